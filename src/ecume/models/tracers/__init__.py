"""Spheres deep in a liquid that bounce, disperse and settle in a tank."""

from ecume.models.tracers.record import TRACERS

__all__ = ["TRACERS"]
