"""Contacts of rigid bodies in 2D: impulses that keep all bodies apart at once (Moreau and Jean's time stepping).

`contacts` finds which bodies touch, removes overlaps and keeps impulses from step to step. `impulse_solvers` solves for
the impulses of discs, small islands exactly where sweeps creep. `sweeps` does so for other rows: those of `friction`,
which adds Coulomb's law, of `rolling`, which adds rolling resistance to it, of `torque_contacts` for bodies that turn,
and of `mobility_contacts` for bodies that move one another. `separation` removes overlaps of bodies that turn. Start
reading with `impulse_solvers`.
"""
