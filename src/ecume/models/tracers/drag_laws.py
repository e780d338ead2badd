"""The table of drag laws of tracers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from ecume.laws import drag


def unit_factor(reynolds: float) -> float:
    """1: Stokes drag, or no drag."""
    return 1.0


@dataclass(frozen=True)
class DragLaw:
    """A row of the table: a drag law and everything that depends on it."""

    factor: Callable[[float], float]
    """factor(reynolds): the drag over Stokes's, by the particle's Reynolds number"""
    settling_reynolds: Callable[[float], float]
    """settling_reynolds(stokes): the Reynolds number at the terminal speed, from that with Stokes's drag"""
    papers: tuple[Callable[..., Any], ...] = ()
    """functions whose docstrings name the references that `ecume cite` lists"""
    resists: bool = True
    """whether there is any drag"""
    linear: bool = True
    """whether the drag is in proportion to the speed"""


def same_reynolds(reynolds: float) -> float:
    """The terminal speed is that with Stokes's drag."""
    return reynolds


DRAGS = {
    "none": DragLaw(unit_factor, same_reynolds, resists=False),
    "stokes": DragLaw(unit_factor, same_reynolds, (drag.stokes_friction,)),
    "schiller-naumann": DragLaw(
        drag.schiller_naumann_factor, drag.settling_reynolds,
        (drag.stokes_friction, drag.schiller_naumann_factor), linear=False,
    ),
}  # fmt: skip
"""Drag laws for `hydrodynamics.drag`."""


class DragChoice(NamedTuple):
    """The drag law of a scene, for compiled code."""

    code: int
    """of the row of `DRAGS`"""
    linear: bool
