"""Floaters that feel one another's menisci beyond superposition: many bodies on the linearized surface.

`solve` gives forces, heights, tilts and energy of any number of pinned discs and spheres, in SI.
"""

from ecume.laws.multipole.closures import CLOSURES, Closure, Undulated
from ecume.laws.multipole.many import Solution, excess_over_superposition, height, solve
from ecume.laws.multipole.walls import Basin, Dish

__all__ = [
    "CLOSURES",
    "Basin",
    "Closure",
    "Dish",
    "Solution",
    "Undulated",
    "excess_over_superposition",
    "height",
    "solve",
]
