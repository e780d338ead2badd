"""Smoothed particle hydrodynamics (SPH): a weakly compressible liquid in a tank.

Start with `integration.time_stepping`, one time step, then `rates.right_hand_side`, which fills the `fields` and calls
the sums over neighbors. `rates.methods` has the forms of the equations, one row each. `setup` makes `parameters` and
the initial `state` from a scene; `boundaries` contains walls, bodies and open sides; `report` has frames, the energy
budget and the lines of `ecume check`. `record` is the interface to the package.
"""

from ecume.models.sph.record import SPH

__all__ = ["SPH"]
