"""The table of drag laws of tracers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from ecume.laws import drag


def unit_factor(reynolds: float) -> float:
    """A drag factor of 1: Stokes drag, or no drag."""
    return 1.0


@dataclass(frozen=True)
class DragLaw:
    """A row of the table: a drag law and everything that depends on it."""

    factor: Callable[..., float]
    """factor(reynolds), or factor(reynolds, sphericity): the drag over Stokes drag, by the
    particle's Reynolds number
    """
    settling_reynolds: Callable[[float, float], float]
    """settling_reynolds(stokes, sphericity): the Reynolds number at the terminal speed, from that with Stokes drag"""
    papers: tuple[Callable[..., Any], ...] = ()
    """functions whose docstrings name the references that `ecume cite` lists"""
    resists: bool = True
    """whether there is any drag"""
    linear: bool = True
    """whether the drag is proportional to the speed"""
    shaped: bool = False
    """whether it depends on the sphericity"""


def same_reynolds(reynolds: float, sphericity: float) -> float:
    """The Reynolds number at the terminal speed with Stokes drag."""
    return reynolds


def settling_reynolds_of_sphere(reynolds: float, sphericity: float) -> float:
    """The Reynolds number at the terminal speed of a sphere with Schiller and Naumann's drag."""
    return drag.settling_reynolds(reynolds)


DRAGS = {
    "none": DragLaw(unit_factor, same_reynolds, resists=False),
    "stokes": DragLaw(unit_factor, same_reynolds, (drag.stokes_friction,)),
    "schiller-naumann": DragLaw(
        drag.schiller_naumann_factor, settling_reynolds_of_sphere,
        (drag.stokes_friction, drag.schiller_naumann_factor), linear=False,
    ),
    "haider-levenspiel": DragLaw(
        drag.haider_levenspiel_factor, drag.settling_reynolds_of_shape,
        (drag.stokes_friction, drag.haider_levenspiel_factor), linear=False, shaped=True,
    ),
}  # fmt: skip
"""Drag laws for `hydrodynamics.drag`."""


class DragChoice(NamedTuple):
    """The drag law of a scene, for compiled code."""

    code: int
    """of the row of `DRAGS`"""
    linear: bool
