"""Spheres on a liquid surface: the Cheerios effect."""

from ecume.models.floating.parameters import PairParameters
from ecume.models.floating.record import FLOATING

__all__ = ["FLOATING", "PairParameters"]
