"""Bodies whose contact line is not a horizontal circle: quadrupoles, ellipsoids, and charges inside an ellipse.

Quadrupoles: a rim of radius a with the height H cos 2 (phi - alpha) deforms the surface as H (a/r)^2 cos 2 (phi -
alpha), for r well below the capillary length. Angles are measured from the line of centers, from i to j, and only their
sum matters: two bodies can rotate in opposite directions like gear wheels without a change of energy. Rises attract
rises, and dips attract dips. The arguments are scalars, as in compiled code.

Charges (`spread_charges`): close to a small body the surface is harmonic, and an ellipse has harmonics exp(-m (u - u0))
cos(m v), with x + iy = c cosh(u + iv) and H at the tips of the line u = u0. A smooth density of charges on a confocal
ellipse inside has exactly that field outside; a few charges, evenly spaced in v, represent this field to many digits. A
body with an undulated contact line is therefore represented by some points, each with a charge as of a sphere, and all
laws for spheres hold: pair forces, walls, Newton's third law, torques. Two such bodies far apart follow the law of
quadrupoles; at small distances the force depends on the shapes of both lines [botto2012]. The interaction of contact
lines (polarization) is ignored, as for spheres.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

import numpy as np

from ecume.errors import BadInput
from ecume.laws.drag import TurningFriction
from ecume.units import (
    Angle,
    Array,
    Energy,
    Force,
    Friction,
    Length,
    Number,
    Rate,
    SurfaceTension,
    Unit,
    Viscosity,
    Volume,
)

Strength = Annotated[float, Unit("J*m^4")]
Torque = Annotated[float, Unit("N*m")]


def quadrupole_strength(surface_tension: SurfaceTension, moment_i: Volume, moment_j: Volume) -> Strength:
    """Strength S = 12 pi gamma (H_i a_i^2) (H_j a_j^2), symmetric in i and j. [stamou2000].

    >>> quadrupole_strength(0.07, 1e-15, 1e-15) > 0
    True
    """
    return 12.0 * math.pi * surface_tension * moment_i * moment_j


def quadrupole_energy(distance: Length, both: Angle, strength: Strength) -> Energy:
    """Energy E = -S cos(2 (alpha_i + alpha_j)) / l^4; `both` is alpha_i + alpha_j. Negative where
    rises face rises.

    Within 0.1 % at l = 32 a, 2 % at 8 a, 4 % at 4 a, for pinned rims much smaller than the capillary length.
    [stamou2000].

    >>> quadrupole_energy(1.0, 0.0, 1.0) < 0 < quadrupole_energy(1.0, math.pi / 2, 1.0)
    True
    """
    return -strength * math.cos(2.0 * both) / distance**4


def quadrupole_force(distance: Length, both: Angle, strength: Strength) -> Force:
    """Force F = -dE/dl = 4 E / l along the line of centers; positive repels. See
    `quadrupole_energy` [stamou2000].

    >>> quadrupole_force(1.0, 0.0, 1.0)
    -4.0
    """
    return -4.0 * strength * math.cos(2.0 * both) / distance**5


def quadrupole_torque(distance: Length, both: Angle, strength: Strength) -> Torque:
    """Torque -dE/d(alpha_i) = -2 S sin(2 (alpha_i + alpha_j)) / l^4: the same on either body,
    counterclockwise.

    A force perpendicular to the line of centers, twice this over l, balances the torques: both bodies rotate in one
    sense, and their pair in the opposite sense. [stamou2000].

    >>> quadrupole_torque(1.0, 0.1, 1.0) < 0
    True
    """
    return -2.0 * strength * math.sin(2.0 * both) / distance**4


PerLength = Annotated[float, Unit("1/m")]
PerVolume = Annotated[float, Unit("1/m^3")]


def ellipsoid_undulation(along: Length, across: Length, contact_angle: Angle) -> Length:
    """Amplitude H of the contact line H cos 2 phi of a free ellipsoid, phi from its first semi-axis: H = -(a - b)/6
    sin^2 cos.

    Exact to first order in a - b for small ellipsoids with any upright semi-axis (which has the same effect on all
    sides). For r = R (1 + f), Young's law at the polar angle theta is H (1 + m) = R (cos f - sin f_theta)_m in mode m.
    A wetted ellipsoid (below 90 degrees) has dips at its tips and rises at its flanks; at 90 degrees the line is flat.
    The second order is ignored: with a = 3 b only the sign is reliable. First order of [vannierop2005]; compare
    [lehle2008].

    >>> ellipsoid_undulation(1.2, 1.0, 1.0) < 0.0 < ellipsoid_undulation(1.2, 1.0, 2.0)
    True
    """
    return -(along - across) / 6.0 * math.sin(contact_angle) ** 2 * math.cos(contact_angle)


def _chi(along: Length, across: Length, upright: Length) -> PerLength:
    """The integral of 1/Delta over all confocal ellipsoids, Delta^2 = (a^2 + s)(b^2 + s)(c^2 + s) [lamb1932]."""
    from scipy.special import elliprf

    return 2.0 * float(elliprf(along**2, across**2, upright**2))


def _alpha(along: Length, across: Length, upright: Length) -> PerVolume:
    """The integral of 1/((a^2 + s) Delta) over all confocal ellipsoids [lamb1932]."""
    from scipy.special import elliprd

    return 2.0 / 3.0 * float(elliprd(across**2, upright**2, along**2))


def ellipsoid_friction(along: Length, across: Length, upright: Length, viscosity: Viscosity) -> Friction:
    """Friction of an ellipsoid that moves along its first semi-axis, deep in a liquid: 16 pi eta /
    (chi + a^2 alpha).

    Half of it applies at a free surface in a plane of symmetry. A sphere has 6 pi eta R, a disc
    edgewise (32/3) eta a. [lamb1932, par. 339].

    >>> round(ellipsoid_friction(1.0, 1.0, 1.0, 1.0) / math.pi, 12)
    6.0
    """
    return 16.0 * math.pi * viscosity / (_chi(along, across, upright) + along**2 * _alpha(along, across, upright))


def ellipsoid_turning_friction(along: Length, across: Length, upright: Length, viscosity: Viscosity) -> TurningFriction:
    """Rotational friction of an ellipsoid about its upright semi-axis, deep in a liquid.

    (16/3) pi eta (a^2 + b^2) / (a^2 alpha + b^2 beta). A sphere has 8 pi eta R^3, a disc (32/3) eta a^3.
    [jeffery1922].

    >>> round(ellipsoid_turning_friction(1.0, 1.0, 1.0, 1.0) / math.pi, 12)
    8.0
    """
    resisting = along**2 * _alpha(along, across, upright) + across**2 * _alpha(across, along, upright)
    return 16.0 / 3.0 * math.pi * viscosity * (along**2 + across**2) / resisting


def elongation(along: Length, across: Length) -> Number:
    """Bretherton's constant (a^2 - b^2)/(a^2 + b^2) of an ellipsoid, whatever its upright semi-axis: 0 for round ones,
    1 for thin needles. [jeffery1922].

    >>> elongation(1.0, 1.0), elongation(3.0, 1.0)
    (0.0, 0.8)
    """
    return (along**2 - across**2) / (along**2 + across**2)


def spin_in_flow(angle: Angle, elongation: Number, rotation: Rate, shear: Rate, extension: Rate) -> Rate:
    """Spin of an ellipsoid that no torque acts on, in a plane flow whose gradient is the same all over it:
    (rotation + elongation (shear cos 2 phi - extension sin 2 phi))/2.

    The angle phi of its long axis is counted from x, counterclockwise; rotation = dv/dx - du/dy, shear = dv/dx + du/dy,
    extension = du/dx - dv/dy. Exact deep in a liquid, and at a flat free surface in a plane of symmetry, without
    inertia. In a shear flow u = g y an ellipsoid turns with the period 2 pi (a/b + b/a)/g. [jeffery1922].

    >>> spin_in_flow(0.0, 1.0, -1.0, 1.0, 0.0)  # a needle along a shear flow
    0.0
    """
    strained = shear * math.cos(2.0 * angle) - extension * math.sin(2.0 * angle)
    return 0.5 * (rotation + elongation * strained)


SLENDER = 0.5
"""The distance of the foci from the center, over the long semi-axis, above which a contact line is represented by
charges between its foci.
"""
DIGITS = 7.0
"""The relative error exp(-DIGITS) of the field of the charges of a touching neighbor."""
MOST = 48


class Line(NamedTuple):
    """A contact line seen from above, flat or with one mode."""

    along: Length
    across: Length
    charge: Length
    """m: the capillary charge, positive for a heavy body"""
    mode: int = 2
    rise: Length = 0.0
    """H: the height at both ends of its long axis"""


def needle_charge(length: Length, slope_angle: Angle) -> Length:
    """Capillary charge A of a lying needle: the force 2 gamma sin(psi) per meter on its two contact lines, over 2 pi
    gamma.

    Short needles have the load of a long cylinder, without end effects [keller1998]. The slope angle psi is that of
    `flotation.HorizontalCylinder`.

    >>> needle_charge(2e-3, 0.1) > 0
    True
    """
    return length * math.sin(slope_angle) / math.pi


def spread_charges(line: Line) -> tuple[Array, Array]:
    """Positions (P, 2) and charges (P,), both in m, of the points that represent a contact line.

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
    """Positions and charges of the points that represent the contact line of a star with as many arms as rises: one
    charge per tip, at the distance `tips` from the center, and one at the center.

    Far away the surface has the height H (R/r)^m cos m phi with R = `along`. Each of the m tips has the charge -m H
    (R/tips)^m / m, whose sum is subtracted at the center; the weight is distributed equally. Derived from the expansion
    of sum A ln r.

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
    """Semi-axes of the confocal ellipse with the charges; for slender lines the charges are between the foci."""
    if not line.along >= line.across > 0.0:
        raise BadInput(
            f"a contact line has the semi-axes {line.along!r} and {line.across!r}; expected the longer first"
        )
    focus = math.sqrt(line.along**2 - line.across**2)
    if focus > SLENDER * line.along:
        return focus, 0.0
    return math.hypot(focus, 0.5 * line.across), 0.5 * line.across


def _count(line: Line) -> int:
    """An even number of points, sufficient for a smooth field at the contact line of a touching equal body."""
    inner = _inner_ellipse(line)
    focus = math.sqrt(line.along**2 - line.across**2)
    if inner[1] > 0.0:
        apart = math.log((line.along + line.across) / (inner[0] + inner[1]))
    else:
        apart = math.asinh((2.0 * line.across) / focus)
    orders = 2 * line.mode + math.ceil(DIGITS / apart)
    return max(min(orders + orders % 2, MOST), 2 * line.mode + 2)
