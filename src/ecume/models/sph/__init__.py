"""Smoothed particle hydrodynamics: a weakly compressible liquid in a tank."""

from ecume.models.sph.record import SPH

__all__ = ["SPH"]
