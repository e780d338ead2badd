"""Smoothed particle hydrodynamics: a weakly compressible liquid in a tank.

Start with `stepping`, one time step in words, and `right_hand_side`, which fills the `fields` and calls the `sums` over
neighbors. `methods` has the forms of the equations, one row each; `defaults` chooses among them for a scene, and
`building` makes its `parameters`. Walls are in `boundaries`, `wall_reflection` and `wall_repulsion`, moving solids in
`bodies` and `forces_on_solids`, sides that liquid passes in `open_boundaries`; `work` and `energies` keep the budget.
"""

from ecume.models.sph.record import SPH

__all__ = ["SPH"]
