"""Tracers: spheres far below the surface of a liquid that bounce, disperse and settle in a tank
without mutual forces.

Start with `time_stepping`: motion with inertia, which is exact between walls, and motion without inertia.
`energy_budget` contains the work, `parameters` the parameters, the state and the choice of the time step, `tank` the
walls, `drag_laws` the drag, and `openings` the particles that enter.
"""

from ecume.models.tracers.record import TRACERS

__all__ = ["TRACERS"]
