"""Capillary interaction of many floating bodies beyond superposition, on the linearized surface.

`solve` gives forces, heights, tilts and energy of any number of pinned discs and spheres, in SI.
"""

from ecume.laws.multipole.closures import CLOSURES, Closure, Undulated, excess_tilt, righted
from ecume.laws.multipole.many import Basin, Dish, Solution, excess_over_superposition, height, solve

__all__ = [
    "CLOSURES",
    "Basin",
    "Closure",
    "Dish",
    "Solution",
    "Undulated",
    "excess_over_superposition",
    "excess_tilt",
    "height",
    "righted",
    "solve",
]
