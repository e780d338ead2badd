"""Long-range forces between surfaces: steric repulsion, and DLVO. A positive force repels.

Each law has an energy, a force, and the slope of the force over the gap, which an implicit step requires.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any

from ecume.units import Energy, Force, Length, Unit

ForceSlope = Annotated[float, Unit("N/m")]


def no_remote_energy(gap: Length) -> Energy:
    """Energy without a long-range force: zero.

    >>> no_remote_energy(1e-9)
    0.0
    """
    return 0.0 * gap


def no_remote_force(gap: Length) -> Force:
    """Force without a long-range force: zero.

    >>> no_remote_force(1e-9)
    0.0
    """
    return 0.0 * gap


def no_remote_slope(gap: Length) -> ForceSlope:
    """Slope without a long-range force: zero.

    >>> no_remote_slope(1e-9)
    0.0
    """
    return 0.0 * gap


def steric_energy(gap: Length, strength: Force, steric_length: Length) -> Energy:
    """Energy U = K (s^2/h - h - 2 s ln(s/h)) below the steric length s, zero beyond: the integral
    of `steric_force`.

    K is the strength, h the gap. It replaces the sharp repulsion of [rognon2010], for which the paper has no formula.

    >>> steric_energy(2.0, 1.0, 1.0)
    0.0
    """
    if gap >= steric_length:
        return 0.0 * strength * gap
    return strength * (steric_length**2 / gap - gap - 2.0 * steric_length * math.log(steric_length / gap))


def steric_force(gap: Length, strength: Force, steric_length: Length) -> Force:
    """Force F = K (s/h - 1)^2 below the steric length s, zero beyond; smooth at s, unbounded at
    contact; repels.

    K is the strength, h the gap. It replaces the sharp repulsion of [rognon2010], for which the paper has no formula.

    >>> steric_force(0.5, 3.0, 1.0)
    3.0
    """
    return strength * max(steric_length / gap - 1.0, 0.0) ** 2


def steric_slope(gap: Length, strength: Force, steric_length: Length) -> ForceSlope:
    """Slope dF/dh of `steric_force`; negative. [rognon2010].

    >>> steric_slope(0.5, 3.0, 1.0)
    -24.0
    """
    return -2.0 * strength * max(steric_length / gap - 1.0, 0.0) * steric_length / gap**2


def dlvo_energy(
    gap: Length,
    reduced_radius: Length,
    hamaker: Energy,
    layer_strength: Force,
    debye_length: Length,
    smallest_separation: Length,
) -> Energy:
    """Energy U = R* Z exp(-h/l) - A R* / (6 h) (1 - (D/h)^6 / 7): the electric double layer repels, van der Waals
    forces attract.

    h is the gap, much smaller than the reduced radius R*; A Hamaker's constant, Z the strength of the double layer
    (energy over length), l the Debye length, D the smallest separation, at which the short repulsion of atoms, that of
    Lennard and Jones between bodies, balances the attraction. [israelachvili2011, eq. 13.11a and 14.52].

    >>> dlvo_energy(1.0, 1.0, 6.0, 0.0, 1.0, 0.0)
    -1.0
    """
    core = (smallest_separation / gap) ** 6 / 7.0
    return reduced_radius * (layer_strength * math.exp(-gap / debye_length) - hamaker / (6.0 * gap) * (1.0 - core))


def dlvo_force(
    gap: Length,
    reduced_radius: Length,
    hamaker: Energy,
    layer_strength: Force,
    debye_length: Length,
    smallest_separation: Length,
) -> Force:
    """Force F = R* Z exp(-h/l) / l - A R* / (6 h^2) (1 - (D/h)^6); positive repels. [israelachvili2011, eq. 13.11a and
    14.52].

    >>> dlvo_force(1.0, 1.0, 6.0, 0.0, 1.0, 0.0)
    -1.0
    >>> dlvo_force(1.0, 1.0, 6.0, 0.0, 1.0, 1.0)
    0.0
    """
    layer = layer_strength * math.exp(-gap / debye_length) / debye_length
    return reduced_radius * (layer - hamaker / (6.0 * gap**2) * (1.0 - (smallest_separation / gap) ** 6))


def dlvo_slope(
    gap: Length,
    reduced_radius: Length,
    hamaker: Energy,
    layer_strength: Force,
    debye_length: Length,
    smallest_separation: Length,
) -> ForceSlope:
    """Slope dF/dh of `dlvo_force`. [israelachvili2011, eq. 13.11a and 14.52].

    >>> dlvo_slope(1.0, 1.0, 6.0, 0.0, 1.0, 0.0)
    2.0
    """
    layer = layer_strength * math.exp(-gap / debye_length) / debye_length**2
    return reduced_radius * (hamaker / (3.0 * gap**3) * (1.0 - 4.0 * (smallest_separation / gap) ** 6) - layer)


def _steric_doubts(constants: Any, smallest_radius: Length) -> list[str]:
    """Warnings on steric layers that are not thin compared with the spheres."""
    said = "the steric length is a tenth of a radius or more: spheres bear each other at a distance"
    return [said] if constants.steric_length > 0.1 * smallest_radius else []


SAMPLES = 200
"""The number of gaps at which a barrier is searched for."""


def _dlvo_doubts(constants: Any, smallest_radius: Length) -> list[str]:
    """Warnings on an attraction that no double layer balances."""
    least, most = constants.smallest_separation, min(10.0 * constants.debye_length, smallest_radius)
    if not (constants.hamaker > 0.0 and 0.0 < least < most):
        return []
    gaps = [1.5 * least * (most / (1.5 * least)) ** (place / SAMPLES) for place in range(SAMPLES + 1)]
    names = (constants.hamaker, constants.layer_strength, constants.debye_length, least)
    if max(dlvo_force(gap, smallest_radius, *names) for gap in gaps) > 0.0:
        return []
    return ["attraction beats the double layer at every gap: surfaces close to the smallest separation and stick"]


@dataclass(frozen=True)
class Remote:
    """A row of the table: a law and everything that depends on it.

    Arguments of its formulas other than the gap and the reduced radius are constants of the scene, by their names in
    the `Contacts` of `ecume.models.soft`.
    """

    energy: Callable[..., Any]
    force: Callable[..., Any]
    """positive if it repels"""
    slope: Callable[..., Any]
    """dF/dh"""
    acts: bool = True
    """whether the force can differ from zero"""
    doubts: Callable[..., list[str]] | None = None
    """warnings of `ecume check`, from `Contacts` and the smallest radius"""


REMOTE = {
    "none": Remote(no_remote_energy, no_remote_force, no_remote_slope, acts=False),
    "steric": Remote(steric_energy, steric_force, steric_slope, doubts=_steric_doubts),
    "dlvo": Remote(dlvo_energy, dlvo_force, dlvo_slope, doubts=_dlvo_doubts),
}
"""Long-range forces: `long_range_forces.law` of a scene."""
