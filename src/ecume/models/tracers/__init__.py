"""Tracers: spheres far below the surface of a liquid that bounce, disperse and settle in a tank
without mutual forces.

Start with `time_stepping`: motion with inertia, which is exact between walls, and motion without inertia.
`energy_budget` holds the work, `parameters` the state, drag laws, the choice of the time step and the walls, and
`openings` the particles that enter.
"""

from ecume.models.tracers.record import TRACERS

__all__ = ["TRACERS"]
