"""Tracers: spheres deep in a liquid that bounce, disperse and settle in a tank, and do not feel one another.

Start with `time_stepping`: flights that are exact between walls, and steps without inertia. `parameters` holds drag
laws, the choice of the time step and the walls, `openings` the particles that come in, `energy_budget` their
work.
"""

from ecume.models.tracers.record import TRACERS

__all__ = ["TRACERS"]
