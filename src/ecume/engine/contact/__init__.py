"""Contacts of rigid bodies in 2D: impulses that keep all bodies apart at once (Moreau and Jean's time stepping).

`contacts` finds which discs touch, removes overlaps and keeps impulses from step to step. `impulse_solvers` solves for
the impulses of rows of any type: those of `contacts`, of `friction`, which adds Coulomb's law, of `rolling`, which adds
rolling resistance to it, of `torque_contacts` for bodies that turn, and of `mobility_contacts` for bodies that move one
another. It solves `islands` of contacts alone, and those on which sweeps creep exactly, by `active_set`. `separation`
removes overlaps of bodies that turn. Start reading with `impulse_solvers`.
"""
