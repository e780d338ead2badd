"""Contacts of rigid bodies in 2D: impulses that keep all bodies apart at once (Moreau and Jean's time stepping).

`contacts` finds who touches whom, removes overlaps and keeps impulses from step to step. `impulse_solvers` solves for
the impulses, small islands exactly where sweeps creep. `friction` adds Coulomb's law, `torque_contacts` is for bodies
that turn, `mobility_contacts` for bodies that move one another. Start reading with `impulse_solvers`.
"""
