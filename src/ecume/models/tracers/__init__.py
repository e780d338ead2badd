"""Tracers: spheres far below the surface of a liquid that bounce, disperse and settle in a tank
without mutual forces.

Start with `time_stepping`: flights that are exact between walls, and steps without inertia. `energy_budget` is their
work. `parameters` holds the state, drag laws, the choice of the time step and the walls, `openings` the particles that
come in.
"""

from ecume.models.tracers.record import TRACERS

__all__ = ["TRACERS"]
