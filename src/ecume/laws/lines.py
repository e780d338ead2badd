"""Capillary charges spread inside an elliptic contact line, whose far fields add up to that of the whole line.

Close to a small body the surface is harmonic, and an ellipse has its own harmonics: with x + iy = c cosh(u + iv) they
are exp(-m (u - u0)) cos(m v), H at the tips of the line u = u0. A smooth density of charges on a confocal ellipse
inside has exactly that field outside; evenly spaced in v, few of them have it to many digits. So a body with a
contact line that rises and falls becomes some points, each with the charge of a sphere, and all laws of spheres hold:
pair forces, walls, Newton's third law, torques. Two such bodies far apart follow the law of quadrupoles; close
together they feel the shape of each other's line [botto2012]. The interaction of contact lines (polarization) is
ignored, as for spheres.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ecume.errors import BadInput
from ecume.units import Angle, Array, Length

SLENDER = 0.5
"""Lines whose foci lie farther out than this, over the long semi-axis, have their charges between the foci."""
DIGITS = 7.0
"""exp(-7) is what the field of a touching neighbor's charges may err by."""
MOST = 48


class Line(NamedTuple):
    """A contact line as seen from above, flat or with one mode."""

    along: Length
    across: Length
    charge: Length
    """as of a heavy sphere: positive"""
    mode: int = 2
    rise: Length = 0.0
    """H: how high it is at both ends of its long axis"""


def needle_charge(length: Length, slope_angle: Angle) -> Length:
    """A of a lying needle: what its two contact lines carry, 2 gamma sin(psi) for each meter, over 2 pi gamma.

    Where it is short beside the capillary length, its load is that of a long cylinder, without end effects
    [keller1998]. The slope angle psi is that of `flotation.HorizontalCylinder`.

    >>> needle_charge(2e-3, 0.1) > 0
    True
    """
    return length * math.sin(slope_angle) / math.pi


def spread_charges(line: Line) -> tuple[Array, Array]:
    """Places (P, 2) and charges (P,), both in m, of the points that stand for a contact line.

    Density on the inner ellipse u1: A/(2 pi) of the charge, that of a flat line, and -(m H/pi) q^m/(1 + p^m) cos(m v)
    of mode m, with q = exp(u0 - u1) and p = exp(-2 u1). [botto2012].

    >>> places, charges = spread_charges(Line(2e-3, 1e-3, 1e-5, 2, 1e-6))
    >>> bool(abs(charges.sum() - 1e-5) < 1e-18), bool(charges[0] < charges[len(charges) // 2])  # rises at the tips
    (True, True)
    """
    if line.rise == 0.0 and line.along == line.across:
        return np.zeros((1, 2)), np.array([line.charge])
    inner, count = _inner_ellipse(line), _count(line)
    between_foci = inner[1] == 0.0
    turn = (np.arange(count // 2 if between_foci else count) + 0.5) * 2.0 * math.pi / count
    shrunk = (line.along + line.across) / (inner[0] + inner[1])
    narrow = (inner[0] - inner[1]) / (inner[0] + inner[1])
    of_mode = -line.mode * line.rise / math.pi * shrunk**line.mode / (1.0 + narrow**line.mode)
    density = line.charge / (2.0 * math.pi) + of_mode * np.cos(line.mode * turn)
    places = np.stack([inner[0] * np.cos(turn), inner[1] * np.sin(turn)], axis=1)
    return places, density * (2.0 * math.pi / len(turn))


def star_charges(line: Line, tips: Length) -> tuple[Array, Array]:
    """The same for a star, whose arms are as many as its line rises: one charge a tip, `tips` from the middle, and one
    in it, so that all lie under the body.

    Far away the line rises as H (R/r)^m cos m phi, with R its `along`: -m H (R/tips)^m / m of a charge at each of the m
    tips, their sum taken from the middle; the weight is shared alike. Derived from the expansion of sum A ln r.

    >>> places, charges = star_charges(Line(1e-3, 1e-3, 0.0, 5, 1e-5), 0.8e-3)
    >>> len(charges), bool(abs(charges.sum()) < 1e-18)
    (6, True)
    """
    turn = 2.0 * math.pi * np.arange(line.mode) / line.mode
    places = np.zeros((line.mode + 1, 2))
    places[1:] = tips * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    charges = np.full(line.mode + 1, line.charge / (line.mode + 1.0))
    of_tip = -line.rise * (line.along / tips) ** line.mode
    charges[1:] += of_tip
    charges[0] -= line.mode * of_tip
    return places, charges


def _inner_ellipse(line: Line) -> tuple[float, float]:
    """Semi-axes of the confocal ellipse that the charges are on; slender lines have them between their foci."""
    if not line.along >= line.across > 0.0:
        raise BadInput(
            f"a contact line has the semi-axes {line.along!r} and {line.across!r}; expected the longer first"
        )
    focus = math.sqrt(line.along**2 - line.across**2)
    if focus > SLENDER * line.along:
        return focus, 0.0
    return math.hypot(focus, 0.5 * line.across), 0.5 * line.across


def _count(line: Line) -> int:
    """An even number of points, so many that a line of the same kind which touches the flank feels a smooth one."""
    inner = _inner_ellipse(line)
    focus = math.sqrt(line.along**2 - line.across**2)
    if inner[1] > 0.0:
        apart = math.log((line.along + line.across) / (inner[0] + inner[1]))
    else:
        apart = math.asinh((2.0 * line.across) / focus)
    wanted = 2 * line.mode + math.ceil(DIGITS / apart)
    return max(min(wanted + wanted % 2, MOST), 2 * line.mode + 2)
