"""Capillary forces between floats, and between a float and walls, as scalar laws for compiled code.

Each law is an energy E and a force, F = -dE/d(distance); positive repels. Far from a float the deformations of the
surface by floats and walls add up, so every law is a strength (an energy, computed once for a pair) times a function of
distance. Arguments are positional, as compiled code requires; the order is always distance, strength, lengths.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from ecume.errors import BadInput
from ecume.laws.special import bessel_k0, bessel_k1, scaled_bessel_i0, scaled_bessel_i1
from ecume.units import Energy, Force, Length, Number, SurfaceTension


def pair_strength(surface_tension: SurfaceTension, charge_i: Length, charge_j: Length) -> Energy:
    """Strength 2 pi gamma A_i A_j of a pair; positive (attractive) for charges of equal sign.

    gamma: surface_tension; A: the charge, the amplitude of the far field -A K0(r/L) of one floater, positive when it
    is heavy. Symmetric in i and j, which is Newton's third law for unlike floaters [nicolson1949, chan1981].

    >>> pair_strength(0.07, 1e-5, -1e-5) < 0
    True
    """
    return 2.0 * math.pi * surface_tension * charge_i * charge_j


def pair_energy(distance: Length, strength: Energy, capillary_length: Length) -> Energy:
    """Energy of two floaters, zero when far apart, negative for like charges.

    E = -S K0(l/L), with l the distance of the centers, S the `pair_strength`, L the capillary_length. Exact far away,
    also for steep menisci when the charges are the nonlinear ones. Spheres in contact are attracted more than that: by
    0.4 % at contact angles of 30 or 150 degrees, 5 % at 60 or 120, 15 to 19 % at 90 (B <= 0.1). [nicolson1949];
    [canbraun2022, eq. 20], which prints a lower-case b, and does not treat unlike floaters.

    >>> round(pair_energy(2.0, 1.0, 2.0), 9)
    -0.421024438
    """
    return -strength * bessel_k0(distance / capillary_length)


def pair_force(distance: Length, strength: Energy, capillary_length: Length) -> Force:
    """Force between two floaters along the line of centers; positive repels, so that like charges give a negative one.

    F = -(S/L) K1(l/L), with the symbols and the validity of `pair_energy`. [nicolson1949]; [canbraun2022, eq. 21].

    >>> round(pair_force(2.0, 1.0, 2.0), 9)
    -0.300953615
    """
    return -strength / capillary_length * bessel_k1(distance / capillary_length)


def wall_strength(surface_tension: SurfaceTension, charge: Length, wall_amplitude: Length) -> Energy:
    """Strength 2 pi gamma A A_w of a wall; positive (repulsive) for a heavy floater at a wetting wall.

    A_w: `meniscus.wall_amplitude`, positive where the liquid rises at the wall. A point charge in an outer field h
    has the energy 2 pi gamma A h: heavy floaters slide down, buoyant ones climb [vella2005].

    >>> wall_strength(0.07, 1e-5, 2e-3) > 0
    True
    """
    return 2.0 * math.pi * surface_tension * charge * wall_amplitude


def dish_energy(center_distance: Length, strength: Energy, capillary_length: Length, dish_radius: Length) -> Energy:
    """Energy of a floater in the meniscus of a round dish. For a heavy one at a wetting wall the energy decreases
    towards the middle.

    E = S I0(r/L) / I1(a/L), with r the distance from the dish's axis, a the dish_radius, S the `wall_strength`. The
    height at the middle is right to 1 % for a >= 2 L, 5 % at L; within about 2 L of the wall a steep meniscus is higher
    than its far field. Derived from [vella2005], with the amplitude of the exact plane meniscus.

    >>> round(dish_energy(0.0, 1.0, 1.0, 2.0), 9)
    0.628679008
    """
    r = center_distance / capillary_length
    a = dish_radius / capillary_length
    return strength * scaled_bessel_i0(r) / scaled_bessel_i1(a) * math.exp(r - a)


def dish_force(center_distance: Length, strength: Energy, capillary_length: Length, dish_radius: Length) -> Force:
    """Force of a round dish's meniscus on a floater; positive repels: it points from the wall to the middle.

    F = (S/L) I1(r/L) / I1(a/L), with the symbols and the validity of `dish_energy`. [vella2005].

    >>> round(dish_force(2.0, 1.0, 1.0, 2.0), 9)
    1.0
    """
    r = center_distance / capillary_length
    a = dish_radius / capillary_length
    return strength / capillary_length * scaled_bessel_i1(r) / scaled_bessel_i1(a) * math.exp(r - a)


def plane_wall_energy(distance: Length, strength: Energy, capillary_length: Length) -> Energy:
    """Energy of a floater in the meniscus of a plane wall; positive for a heavy one at a wetting wall.

    E = S exp(-x/L), with x the distance from the wall, S the `wall_strength` (between two walls with
    `meniscus.facing_amplitude`). The far field of the exact profile; within about 2 L of the wall a steep meniscus is
    higher. [landau1987, par. 61].

    >>> round(plane_wall_energy(1.0, 1.0, 1.0), 9)
    0.367879441
    """
    return strength * math.exp(-distance / capillary_length)


def plane_wall_force(distance: Length, strength: Energy, capillary_length: Length) -> Force:
    """Force of a plane wall's meniscus on a floater; positive repels: it points away from the wall.

    F = (S/L) exp(-x/L), with the symbols and the validity of `plane_wall_energy`. [landau1987, par. 61].

    >>> round(plane_wall_force(1.0, 1.0, 2.0), 9)
    0.30326533
    """
    return strength / capillary_length * math.exp(-distance / capillary_length)


def legacy_wall_strength(
    surface_tension: SurfaceTension, radius: Length, bond_number: Number, wall_weight: Number
) -> Energy:
    """Wall strength of the original project, 2 pi gamma (R B Sigma_w)^2, never negative; it
    replaces `wall_strength`.

    R, B: the floater's radius and Bond number; Sigma_w: wall_weight, the dimensionless weight of a sphere of the
    wall's density and contact angle. Erratum: a wall is no sphere, and the floater's own weight does not enter.
    [canbraun2022, par. 1.2].

    >>> legacy_wall_strength(0.07, 1e-3, 0.1, -1.0) == legacy_wall_strength(0.07, 1e-3, 0.1, 1.0)
    True
    """
    charge = radius * bond_number * wall_weight
    return 2.0 * math.pi * surface_tension * charge * charge


def one_sided_legacy_force(
    distance: Length, strength: Energy, capillary_length: Length, touching_distance: Length
) -> Force:
    """The original program's force of one float on another; positive would repel, but it is never
    positive.

    F = -(S/L) K1(l/L) with S the `pair_strength` of the *other* with itself, 2 pi gamma A_j^2, and zero once the two
    touch. For comparison only: it violates Newton's third law for unlike floats, attracts heavy floats to light ones,
    and makes stable rafts break up. Erratum of [canbraun2022, eq. 21].

    >>> one_sided_legacy_force(2.0, 1.0, 2.0, 1.0) < 0.0 == one_sided_legacy_force(1.0, 1.0, 2.0, 1.0)
    True
    """
    if distance <= touching_distance:
        return 0.0 * strength / capillary_length
    return -strength / capillary_length * bessel_k1(distance / capillary_length)


def two_point_legacy_energy(
    center_distance: Length, strength: Energy, capillary_length: Length, dish_radius: Length
) -> Energy:
    """Energy of a float at the original project's wall, which acts as two particles on the rim, on the diameter through
    the float.

    E = -S [K0((a - r)/L) + K0((a + r)/L)], with S the `legacy_wall_strength`. For comparison only: the law should
    decay as I0, it is about ten times too strong, and it attracts every floater to every wall. Erratum of
    [canbraun2022, par. 1.2 and eq. 20].

    >>> round(two_point_legacy_energy(0.0, 1.0, 1.0, 1.0), 9)
    -0.842048876
    """
    near = (dish_radius - center_distance) / capillary_length
    far = (dish_radius + center_distance) / capillary_length
    return -strength * (bessel_k0(near) + bessel_k0(far))


def two_point_legacy_force(
    center_distance: Length, strength: Energy, capillary_length: Length, dish_radius: Length
) -> Force:
    """Force of the original project's wall; positive would repel, but it always points to the
    nearer point.

    F = -(S/L) [K1((a - r)/L) - K1((a + r)/L)], with the symbols and the erratum of `two_point_legacy_energy`.
    [canbraun2022, par. 1.2 and eq. 21].

    >>> two_point_legacy_force(0.0, 1.0, 1.0, 1.0)
    -0.0
    """
    near = (dish_radius - center_distance) / capillary_length
    far = (dish_radius + center_distance) / capillary_length
    return -strength / capillary_length * (bessel_k1(near) - bessel_k1(far))


def no_wall_energy(center_distance: Length, strength: Energy, capillary_length: Length, dish_radius: Length) -> Energy:
    """Zero energy: the wall has no meniscus (a contact angle of 90 degrees).

    >>> no_wall_energy(0.0, 1.0, 1.0, 1.0)
    0.0
    """
    return 0.0 * strength


def no_wall_force(center_distance: Length, strength: Energy, capillary_length: Length, dish_radius: Length) -> Force:
    """Zero force: the wall has no meniscus (a contact angle of 90 degrees).

    >>> no_wall_force(0.0, 1.0, 1.0, 1.0)
    0.0
    """
    return 0.0 * strength / capillary_length


STEP = 0.05
"""Step of the trapezoidal rule below, which converges exponentially: beyond 15 digits."""


def neglected_fraction(cutoff: Number, contact: Number = 0.0) -> Number:
    """The fraction of the force on a float at the edge of a raft that pairs beyond the cutoff
    contribute.

    int_c^inf r K1(r) dr / int_d^inf r K1(r) dr: the raft is a half-plane, c is the cutoff and d the distance of centers
    at contact, both in capillary lengths. Floats cannot be nearer than d; for floats of several capillary lengths, most
    of the attraction acts within a capillary length of contact.

    >>> round(neglected_fraction(0.0), 12)
    1.0
    >>> round(neglected_fraction(8.0, 6.0), 2)
    0.15
    """
    return math.exp(contact - cutoff) * _edge_force(cutoff) / _edge_force(contact)


def _edge_force(nearest: Number) -> Number:
    """The integral exp(c) int_c^inf r K1(r) dr = int_0^inf exp(-c (cosh t - 1)) (c + 1/cosh t) dt, c in capillary
    lengths.
    """
    total = 0.5 * (nearest + 1.0)
    for k in range(1, 1000):
        cosh = math.cosh(k * STEP)
        term = math.exp(-nearest * (cosh - 1.0)) * (nearest + 1.0 / cosh)
        total += term
        if term < 1e-17 * total:
            break
    return STEP * total


def truncation_radius(accuracy: Number, contact: Number = 0.0) -> Number:
    """The cutoff, in capillary lengths, beyond which pairs contribute less than `accuracy` of the force; see
    `neglected_fraction`. `contact` is the largest distance of centers at contact, in capillary lengths.

    >>> round(truncation_radius(1e-6))
    15
    >>> round(truncation_radius(1e-6, 20.0))
    34
    """
    if not 1e-15 <= accuracy < 1.0:
        raise BadInput(f"accuracy of the cutoff is {accuracy!r}; expected between 1e-15 and 1, such as 1e-6")
    near, far = contact, contact + 50.0
    while far - near > 1e-9:
        middle = 0.5 * (near + far)
        near, far = (middle, far) if neglected_fraction(middle, contact) > accuracy else (near, middle)
    return far


class WallLaw(NamedTuple):
    """A round wall's energy and force, both of (center_distance, strength, capillary_length, dish_radius)."""

    energy: Callable[[float, float, float, float], float]
    force: Callable[[float, float, float, float], float]


WALLS = {
    "meniscus": WallLaw(dish_energy, dish_force),
    "linear": WallLaw(dish_energy, dish_force),
    "two-point-legacy": WallLaw(two_point_legacy_energy, two_point_legacy_force),
    "none": WallLaw(no_wall_energy, no_wall_force),
}
