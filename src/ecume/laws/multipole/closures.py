"""The response of a body to a deformed surface: the induced amplitude of each multipole, and the
permanent ones.

On the linearized surface every contact line is a circle as seen from above. Around it the height is the sum over m of
the outgoing field of the body, A_m K_m(r) exp(i m phi), and the incoming field of all other bodies, C_m I_m(r) exp(i m
phi). In terms of the values at the contact line, alpha_m = A_m K_m(a) and c_m = C_m I_m(a), a round body responds mode
by mode, alpha_m = S_m + T_m c_m: S is its source, the amplitude at a flat surface, and T its response. Lengths are in
capillary lengths, forces in gamma L, energies in gamma L^2. Derived for this package from the balance of each body, as
in [vassileva2005].

Bessel functions of all orders are scaled so that none overflows at any order. K_m(x) grows like (m-1)!/2 (2/x)^m and
I_m(x) decays like (x/2)^m/m!. With a reference length s the arrays (ladders) contain k_m = exp(x) K_m(x) (s/2)^m / m!
and i_m = exp(-x) I_m(x) (2/s)^m m!, which are of order one for x near s. [watson1944].
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume.errors import BadInput
from ecume.laws.flotation.bodies import Disc, Liquid, Sphere, VerticalCylinder, bond_number, dimensionless_weight
from ecume.laws.flotation.equilibria import equilibrium
from ecume.laws.special import scaled_bessel_k0, scaled_bessel_k1
from ecume.units import Angle, Array, Length, Number

MOST_TERMS = 4000
TINY = 1e-280


def outgoing_ladder(x: Number, reference: Number, values: Array) -> None:
    """Fill `values` with k_0, k_1, ... at x: K_{m+1} = K_{m-1} + (2 m/x) K_m, which is stable upwards.

    >>> values = np.zeros(3)
    >>> outgoing_ladder(1.0, 2.0, values)
    >>> np.round(values * math.exp(-1.0) * (1.0, 1.0, 2.0), 9).tolist()       # K_0(1), K_1(1), K_2(1)
    [0.421024438, 0.60190723, 1.624838899]
    """
    values[0] = scaled_bessel_k0(x)
    if len(values) > 1:
        values[1] = scaled_bessel_k1(x) * 0.5 * reference
    near, far = reference / x, 0.25 * reference * reference
    for m in range(1, len(values) - 1):
        values[m + 1] = far / (m * (m + 1.0)) * values[m - 1] + near * m / (m + 1.0) * values[m]


def regular_ladder(x: Number, reference: Number, values: Array) -> None:
    """Fill `values` with i_0, i_1, ... at x: the last two by their power series, whose terms are all positive, the
    others by I_{m-1} = I_{m+1} + (2 m/x) I_m, which is stable downwards.

    >>> values = np.zeros(3)
    >>> regular_ladder(1.0, 2.0, values)
    >>> np.round(values * math.exp(1.0) / (1.0, 1.0, 2.0), 9).tolist()        # I_0(1), I_1(1), I_2(1)
    [1.266065878, 0.565159104, 0.13574767]
    """
    last = len(values) - 1
    highest = math.exp(-x) * (x / reference) ** last
    # The highest value must not be subnormal, since the recurrence is downward.
    from_top = highest > TINY and last > 1
    for m in range(last - 1 if from_top else 0, last + 1):
        term, total = 1.0, 1.0
        for k in range(1, MOST_TERMS):
            term *= 0.25 * x * x / (k * (m + k))
            total += term
            if term < 1e-17 * total:
                break
        values[m] = math.exp(-x) * (x / reference) ** m * total
    if from_top:
        near, far = reference / x, 0.25 * reference * reference
        for m in range(last - 1, 0, -1):
            values[m - 1] = far / (m * (m + 1.0)) * values[m + 1] + near * values[m]


def log_slopes(x: Number, order: int) -> tuple[Array, Array]:
    """K_m'(x)/K_m(x) and I_m'(x)/I_m(x) for m = 0 ... order.

    >>> outgoing, regular = log_slopes(1e-3, 2)
    >>> np.round(outgoing * 1e-3, 3).tolist()[1:], np.round(regular * 1e-3, 3).tolist()
    ([-1.0, -2.0], [0.0, 1.0, 2.0])
    """
    k, i = np.zeros(order + 2), np.zeros(order + 2)
    outgoing_ladder(x, x, k)
    regular_ladder(x, x, i)
    m = np.arange(order + 1.0)
    outgoing, regular = np.zeros(order + 1), np.zeros(order + 1)
    # K_m' = -K_{m-1} - (m/x) K_m and I_m' = I_{m+1} + (m/x) I_m; K_0' = -K_1.
    outgoing[0] = -k[1] / (0.5 * x * k[0])
    outgoing[1:] = -k[:-2] * 0.5 * x / (m[1:] * k[1:-1]) - m[1:] / x
    regular[:] = i[1:] * 0.5 * x / ((m + 1.0) * i[:-1]) + m / x
    return outgoing, regular


class Closure(NamedTuple):
    """The response of a body to the fields of others."""

    radius: float
    """of the contact line, in L"""
    response: Array
    """(order + 1,) T"""
    source: NDArray[np.complex128]
    """(order + 1,) S"""
    energy: float
    """of the body alone, in gamma L^2"""


def disc_closure(disc: Disc, liquid: Liquid, order: int) -> Closure:
    """Closure of a disc with a pinned rim: the contact line stays plane; it rises, and tilts, until forces and torques
    balance.

    2 pi a s_0 - pi a^2 z = W;   2 pi a^2 s_1 - pi a^3 t_1/2 + 2 kappa t_1/a = 0 (t_1 = 0 when it stays level); alpha_m
    + c_m = 0 for m > 1. s: slope modes of the ring, z and t_1: its height and tilt, W: load, kappa: stability. The
    moment of the horizontal tension is missing: see `righted`.

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> disc_closure(Disc(1e-3, 1e-5), water, 3).response[2:].tolist()
    [-1.0, -1.0]
    """
    length = liquid.capillary_length
    a, load = disc.radius / length, disc.load / (liquid.surface_tension * length)
    outgoing, regular = log_slopes(a, order)
    response, source = -np.ones(order + 1), np.zeros(order + 1, np.complex128)
    stiff = 2.0 * math.pi * a * outgoing[0] - math.pi * a * a
    response[0] = -(2.0 * math.pi * a * regular[0] - math.pi * a * a) / stiff
    source[0] = load / stiff
    if disc.tilting and order >= 1:
        lean = -0.5 * math.pi * a**3 + 2.0 * disc.stability / a
        turning = 2.0 * math.pi * a * a * outgoing[1] + lean
        if turning >= 0.0:
            most = 0.5 * a * (0.5 * math.pi * a**3 - 2.0 * math.pi * a * a * outgoing[1])
            raise BadInput(
                f"a disc of stability {disc.stability:g} topples; its surface holds it upright below {most:.4g}"
            )
        response[1] = -(2.0 * math.pi * a * a * regular[1] + lean) / turning
    return Closure(a, response, source, 0.5 * load * float(source[0].real))


def righted(disc: Disc, liquid: Liquid) -> Disc:
    """The disc with the moment of the horizontal tension, which rights it, in its stability: kappa - pi a^2.

    At a rim with the tilt t, the tension gamma pulls outwards at the height t a cos(phi), where rotation by dt moves
    the rim inwards by t a cos(phi) dt. The work is -gamma pi a^2 t dt: the moment -gamma pi a^2 t, the energy gamma pi
    a^2 t^2/2, by which the surface outside grows because a tilted disc covers less of it. A small disc without mass
    then lies in the surface, t = s at a slope s, instead of t = 2 s. Derived for this package.

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> small = Disc(1e-6, 0.0)
    >>> [round(1.0 + float(disc_closure(one, water, 1).response[1]), 4) for one in (small, righted(small, water))]
    [2.0, 1.0]
    """
    return replace(disc, stability=disc.stability - math.pi * (disc.radius / liquid.capillary_length) ** 2)


def excess_tilt(disc: Disc, liquid: Liquid) -> float:
    """The tilt of a disc in the surface of others, over that with the moment of the horizontal tension, minus 1.

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> [round(excess_tilt(Disc(radius, 0.0), water), 2) for radius in (1e-5, 3e-3, 3e-2)]
    [1.0, 0.48, 0.02]
    """
    tilts = [1.0 + float(disc_closure(one, liquid, 1).response[1]) for one in (disc, righted(disc, liquid))]
    return tilts[0] / tilts[1] - 1.0


def sphere_closure(sphere: Sphere, liquid: Liquid, order: int) -> Closure:
    """Closure of a sphere, whose contact line slides at a constant contact angle: s_m = (alpha + c)_m / a, without
    torque.

    a s_0 (1 + a^2/2) - (a^2/2) (alpha_0 + c_0) = R B Sigma, with a = R sin(theta), with heave and filling. Slopes are
    linear, so that the charge is that of the closed form.

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> bool(abs(sphere_closure(Sphere(1e-4, 1500.0, math.pi / 2), water, 1).response[1]) < 1e-2)
    True
    """
    equilibrium(sphere, liquid)  # raises FloaterSinks
    bond = bond_number(sphere, liquid)
    a = math.sqrt(bond) * math.sin(sphere.contact_angle)
    if a < 1e-6:
        raise BadInput(
            f"the contact line of a sphere of radius {sphere.radius:g} m and contact angle {sphere.contact_angle:g} is "
            "a point: nothing pins or slides on it; use the pair law"
        )
    weight = math.sqrt(bond) * bond * dimensionless_weight(sphere, liquid)
    outgoing, regular = log_slopes(a, order)
    response = -(regular - 1.0 / a) / (outgoing - 1.0 / a)
    source = np.zeros(order + 1, np.complex128)
    steep = a * (1.0 + 0.5 * a * a)
    stiff = steep * outgoing[0] - 0.5 * a * a
    response[0] = -(steep * regular[0] - 0.5 * a * a) / stiff
    source[0] = weight / stiff
    return Closure(a, response, source, math.pi * weight * float(source[0].real))


def cylinder_closure(cylinder: VerticalCylinder, liquid: Liquid, order: int) -> Closure:
    """Closure of an upright cylinder with a contact line that slides on its side: s_0 = sin(theta - 90 degrees), s_m =
    0.

    The cylinder is held upright. It responds to every mode as a wall does.

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> rod = VerticalCylinder(radius=1e-3, height=9e-3, density=500.0, contact_angle=1.2)
    >>> bool(cylinder_closure(rod, water, 2).source[0].real > 0)  # wetted: the surface climbs it
    True
    """
    # The contact line carries 2 pi gamma R sin(psi), psi = theta - 90 degrees, however steep it is.
    a, slope = cylinder.radius / liquid.capillary_length, -math.cos(cylinder.contact_angle)
    outgoing, regular = log_slopes(a, order)
    source = np.zeros(order + 1, np.complex128)
    source[0] = slope / outgoing[0]
    return Closure(a, -regular / outgoing, source, math.pi * a * slope * float(source[0].real))


@dataclass(frozen=True)
class Undulated:
    """A disc with an undulated rim: the height of mode m >= 2 is H cos m (phi - alpha).

    modes: (m, H, alpha) of each; a quadrupole is m = 2, a hexapole m = 3.

    >>> Undulated(Disc(1e-6, 0.0), ((2, 1e-8, 0.0),)).modes[0][0]
    2
    """

    disc: Disc
    modes: tuple[tuple[int, Length, Angle], ...]

    def __post_init__(self) -> None:
        for mode in self.modes:
            if mode[0] < 2 or not all(map(math.isfinite, mode)):
                raise BadInput(
                    f"a mode of an undulated rim is {mode!r}; expected (m, height, angle) with m of 2 or more"
                )


def undulated_closure(body: Undulated, liquid: Liquid, order: int) -> Closure:
    """Closure of a pinned, undulated rim: alpha_m + c_m = (H/2) exp(-i m angle). Far away, two quadrupoles follow
    `contact_lines.quadrupole_energy`. Derived as in [stamou2000].

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> bool(abs(undulated_closure(Undulated(Disc(1e-6, 0.0), ((2, 1e-8, 0.0),)), water, 3).source[2]) > 0)
    True
    """
    flat, energy = disc_closure(body.disc, liquid, order), 0.0
    outgoing, _ = log_slopes(flat.radius, order)
    source = flat.source.copy()
    for mode, height, angle in body.modes:
        if mode > order:
            raise BadInput(f"the rim has a mode {mode}, beyond the order {order}; expected a higher order")
        source[mode] += 0.5 * height / liquid.capillary_length * cmath.exp(-1j * mode * angle)
    for mode in range(2, order + 1):
        energy -= 2.0 * math.pi * flat.radius * float(outgoing[mode]) * abs(source[mode]) ** 2
    return flat._replace(source=source, energy=flat.energy + energy)


CLOSURES: dict[type, Callable[[Any, Liquid, int], Closure]] = {
    Disc: disc_closure,
    Sphere: sphere_closure,
    VerticalCylinder: cylinder_closure,
    Undulated: undulated_closure,
}
"""The closures by type of body."""


def closure_of(body: Any, liquid: Liquid, order: int) -> Closure:
    """The closure of a body. Raises BadInput for bodies without one."""
    for kind, closure in CLOSURES.items():
        if isinstance(body, kind):
            return closure(body, liquid, order)
    known = ", ".join(kind.__name__ for kind in CLOSURES)
    raise BadInput(f"multipoles: got {body!r}; expected one of {known}")
