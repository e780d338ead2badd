"""Contacts of rigid bodies in 2D: impulses that keep all bodies apart at once (Moreau and Jean's time stepping).

`contacts` finds the discs that touch, removes overlaps and stores impulses from step to step. `impulse_solvers` solves
for the impulses of rows of any type: those of `contacts`, of `friction`, which adds Coulomb's law, of `rolling`, which
adds rolling resistance to it, of `torque_contacts` for bodies that rotate, and of `mobility_contacts` for bodies with
hydrodynamic interaction. It solves `islands` of contacts separately. Islands on which sweeps converge slowly are solved
exactly by `active_set`. `separation` removes overlaps of bodies that rotate. Start reading with `impulse_solvers`.
"""
