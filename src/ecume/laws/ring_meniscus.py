"""The meniscus between two concentric round walls, as in a ring-shaped dish.

The linear field is a sum of two menisci, one of each wall: S_o I0(r/L)/I1(a/L) of the outer wall and
S_i K0(r/L)/K1(b/L) of the inner one. Their amplitudes follow from the slopes at both walls. Both angles are those of
the walls, through the liquid: below 90 degrees the liquid rises at the wall.
"""

from __future__ import annotations

import math

import numpy as np

from ecume.errors import BadInput
from ecume.laws.flotation.bodies import Liquid
from ecume.laws.flotation.young_laplace import outer_meniscus
from ecume.laws.meniscus import AMPLITUDES, linear_wall_amplitude, wall_amplitude
from ecume.laws.special import (
    scaled_bessel_i0,
    scaled_bessel_i1,
    scaled_bessel_k0,
    scaled_bessel_k1,
)
from ecume.units import Angle, Energy, Force, Length, Lengths

__all__ = ["inner_wall_amplitude", "inner_wall_energy", "inner_wall_force", "ring_amplitudes", "ring_height"]

UPRIGHT = 1e-9
"""Slopes at a wall (rad) below this leave the surface flat."""
WIDE = 300.0
"""The radius, in L, above which an inner wall has the meniscus of a plane wall, within 1e-4."""


def inner_wall_energy(center_distance: Length, strength: Energy, capillary_length: Length, radius: Length) -> Energy:
    """Energy of a floater in the meniscus of a round wall that it is outside of; positive for a heavy one at a wetting
    wall.

    E = S K0(r/L) / K1(b/L), with r the distance from the axis of the wall, b its radius, S the `wall_strength` with the
    amplitude of `ring_amplitudes`. The far field of the exact profile. [vella2005].

    >>> round(inner_wall_energy(2.0, 1.0, 1.0, 1.0), 9)
    0.189221639
    """
    r = center_distance / capillary_length
    b = radius / capillary_length
    return strength * scaled_bessel_k0(r) / scaled_bessel_k1(b) * math.exp(b - r)


def inner_wall_force(center_distance: Length, strength: Energy, capillary_length: Length, radius: Length) -> Force:
    """Force of the meniscus of a round wall on a floater outside of it; positive repels: it points away from the wall.

    F = (S/L) K1(r/L) / K1(b/L), with the symbols and the validity of `inner_wall_energy`. [vella2005].

    >>> inner_wall_force(1.0, 1.0, 1.0, 1.0)
    1.0
    """
    r = center_distance / capillary_length
    b = radius / capillary_length
    return strength / capillary_length * scaled_bessel_k1(r) / scaled_bessel_k1(b) * math.exp(b - r)


def inner_wall_amplitude(radius: Length, contact_angle: Angle, liquid: Liquid, theory: str = "amplitude") -> Length:
    """Amplitude A of the meniscus A K0(r/L)/K1(b/L) far outside of a vertical cylinder of radius b.

    "amplitude": that of the exact axisymmetric profile. For wide cylinders it is that of a plane wall,
    `wall_amplitude`; for thin ones A = L cos(theta), since there r sin(psi) is constant. "linear": L cot(theta).
    Derived from [vella2005].

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> round(inner_wall_amplitude(1e-6, 0.8, water) / water.capillary_length / math.cos(0.8), 3)
    1.0
    """
    if theory not in AMPLITUDES:
        raise BadInput(f"theory: got {theory!r}; expected one of {', '.join(map(repr, AMPLITUDES))}")
    if theory == "linear":
        return linear_wall_amplitude(contact_angle, liquid)
    slope, b = contact_angle - 0.5 * math.pi, radius / liquid.capillary_length
    if abs(slope) < UPRIGHT:
        return -slope * liquid.capillary_length
    if b > WIDE:
        return wall_amplitude(contact_angle, liquid)
    amplitude = -outer_meniscus(b, slope).amplitude
    return liquid.capillary_length * amplitude * scaled_bessel_k1(b) * math.exp(-b)


def ring_amplitudes(
    radii: tuple[Length, Length], contact_angles: tuple[Angle, Angle], liquid: Liquid, theory: str = "amplitude"
) -> tuple[Length, Length]:
    """Amplitudes S_o and S_i of the menisci of the outer and the inner wall of a ring; `radii` and `contact_angles` are
    those of the outer wall, then of the inner one.

    S_o - S_i K1(a)/K1(b) = A_o and S_i - S_o I1(b)/I1(a) = A_i, with the radii in L, and the amplitudes A of each wall
    alone: the sum has the slope A_o/L at the outer wall and -A_i/L at the inner one. Exact in linear theory. A thin
    inner wall leaves the meniscus of a round dish. Derived from [vella2005].

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> outer, inner = ring_amplitudes((0.02, 0.005), (0.8, 0.8), water)
    >>> inner > outer > 0.0
    True
    """
    a, b = (radius / liquid.capillary_length for radius in radii)
    if not 0.0 < b < a:
        raise BadInput(f"radii: got {radii[0]:g} and {radii[1]:g} m; expected the outer one first, both above 0")
    outer = AMPLITUDES[theory](contact_angles[0], liquid)
    inner = inner_wall_amplitude(radii[1], contact_angles[1], liquid, theory)
    outward = scaled_bessel_k1(a) / scaled_bessel_k1(b) * math.exp(b - a)
    inward = scaled_bessel_i1(b) / scaled_bessel_i1(a) * math.exp(b - a)
    shared = 1.0 - outward * inward
    return (outer + inner * outward) / shared, (inner + outer * inward) / shared


def ring_height(
    r: Lengths, radii: tuple[Length, Length], contact_angles: tuple[Angle, Angle], liquid: Liquid
) -> Lengths:
    """Height of the surface between two round walls at a distance r from their axis: S_o I0(r/L)/I1(a/L) + S_i
    K0(r/L)/K1(b/L) with `ring_amplitudes`. Within about 2 L of a wall a steep meniscus is higher. [vella2005].

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> low, middle, high = (ring_height(r, (0.02, 0.005), (0.8, 0.8), water) for r in (0.005, 0.012, 0.02))
    >>> low > middle < high
    True
    """
    outer, inner = ring_amplitudes(radii, contact_angles, liquid)
    length, (a, b), places = liquid.capillary_length, radii, np.asarray(r, dtype=np.float64)
    if not bool(np.all((places >= b * (1.0 - 1e-9)) & (places <= a * (1.0 + 1e-9)))):
        raise BadInput(f"r: got {np.min(places):g} to {np.max(places):g} m; expected {b:g} to {a:g} m, inside the ring")
    each = [
        scaled_bessel_i0(x) / scaled_bessel_i1(a / length) * math.exp(x - a / length) * outer
        + inner_wall_energy(x * length, inner, length, b)
        for x in (places.ravel() / length).tolist()
    ]
    found = np.reshape(each, places.shape)
    return float(found) if np.ndim(r) == 0 else found
