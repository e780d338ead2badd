"""Contacts of rigid bodies in 2D: impulses that keep all bodies apart at once (Moreau and Jean's time stepping).

`contacts` finds who touches whom and removes overlaps, `projected_gauss_seidel` solves for the impulses, `active_set`
solves small islands exactly where sweeps creep. `friction` adds Coulomb's law, `torque_contacts` is for bodies that
turn, and `warm_start` keeps impulses from step to step. Start reading with `projected_gauss_seidel`.
"""
