"""Soft spheres close together in a viscous liquid: films and surfaces in series, force balance, implicit steps."""

from ecume.models.soft.cluster import T1
from ecume.models.soft.record import SOFT
from ecume.models.soft.t1 import t1_process

__all__ = ["SOFT", "T1", "t1_process"]
