"""Tracers: spheres deep in a liquid that bounce, disperse and settle in a tank, and do not feel one another.

Start with `time_stepping`: flights that are exact between walls, and steps without inertia. `energy_budget` is their
work. `parameters` holds the state, drag laws, the choice of the time step and the walls, `openings` the particles that
come in.
"""

from ecume.models.tracers.record import TRACERS

__all__ = ["TRACERS"]
