"""The T1 process: four spheres that exchange neighbors, pulled by two pairs of forces.

Start with `t1_process` in `process`. `cluster` contains the scene and the results, and solves for the deflections under
very small forces. `paper_scheme` is the explicit method of [rognon2009], for comparison.
"""

from ecume.models.soft.t1.cluster import T1
from ecume.models.soft.t1.process import t1_process

__all__ = ["T1", "t1_process"]
