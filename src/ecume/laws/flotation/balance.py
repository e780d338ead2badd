"""The force balance of a floating body, and the equilibrium of a sphere in several theories.

Lengths are in capillary lengths L, weights in gamma L (for a lying cylinder per length: in gamma). A body's weight on a
flat surface is that of the liquid it displaces; any further weight is carried by the slope of the surface at the
contact line. The closure relation of the original project, which computes a contact angle from the weight, serves to
reproduce its figures.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache, partial
from typing import NamedTuple

from ecume.errors import BadInput, FloaterSinks
from ecume.laws.arguments import elementwise
from ecume.laws.flotation.bodies import weight_number
from ecume.laws.flotation.young_laplace import STEEPEST, OuterMeniscus, outer_meniscus
from ecume.laws.special import bessel_k0, bessel_k1
from ecume.units import Angle, Number

TURNS = 80
EXACT = 1e-12
"""Newton's method has converged if the next step is below this fraction of the slope angle."""
STALLED = 1e-9
"""Steps below this size that no longer decrease are rounding errors."""
ROUNDING = 1e-14
"""Rounding error of a weight, over its unit: it limits the accuracy of a nearly neutral body."""
NARROW = 1e-6
"""The accuracy of the slope of greatest load; the load, which is quadratic there, is accurate to the square of it."""
SCAN = 12
"""The number of slopes in the search for the greatest load."""


class Contact(NamedTuple):
    """The contact line of a round, upright body as a function of the slope angle; `..._change` are derivatives by this
    angle.
    """

    radius: float
    radius_change: float
    volume: float
    """volume of the body below the contact line"""
    volume_change: float
    height: float
    """height of the contact line above the body's center"""


class Load(NamedTuple):
    """The load that the surface carries at a slope angle of the contact line, in the unit of weight, and its
    derivative.
    """

    slope_angle: float
    carried: float
    change: float
    meniscus: OuterMeniscus


class Floating(NamedTuple):
    """One floating body in units of L; heights are relative to the undisturbed surface."""

    slope_angle: float
    filling_angle: float
    contact_radius: float
    contact_height: float
    center_height: float
    charge: float


def round_load(contact: Contact, slope_angle: float, unit: float) -> Load:
    """Load of a round contact line: vertical surface tension and generalized buoyancy, 2 pi r sin(psi) + V - pi r^2 z,
    over `unit`.

    V is the body's volume below the contact line, -pi r^2 z that of the dip above it. [keller1998].
    """
    radius, sine, cosine = contact.radius, math.sin(slope_angle), math.cos(slope_angle)
    surface = outer_meniscus(radius, slope_angle, contact.radius_change)
    dip, deepening = -surface.height, -surface.height_change
    carried = 2.0 * math.pi * radius * sine + contact.volume + math.pi * radius**2 * dip
    change = 2.0 * math.pi * (contact.radius_change * sine + radius * cosine) + contact.volume_change
    change += 2.0 * math.pi * radius * contact.radius_change * dip + math.pi * radius**2 * deepening
    return Load(slope_angle, carried / unit, change / unit, surface)


def stable_load(
    load: Callable[[float], Load], target: float, neutral: float, limit: float, guess: float
) -> Load | None:
    """The equilibrium between the flat surface, which carries `neutral`, and the slope of the
    greatest load.

    Newton's method inside a bracket that ends at the slope angle `limit`; None if no slope carries `target`.
    """
    excess = target - neutral
    inner, outer = 0.0, max(-STEEPEST, min(STEEPEST, limit))
    psi, crossed, last = guess, False, math.inf
    for _ in range(TURNS):
        if not crossed and abs(outer - inner) <= NARROW * abs(outer):
            break
        found = load(psi)
        rising = found.change > 0.0
        # Where the load no longer rises, the bracket is halved without a Newton step.
        step = (found.carried - target) / found.change if rising else 0.0
        enough = EXACT * abs(psi) + ROUNDING * (1.0 + abs(target)) / found.change if rising else 0.0
        if rising and (abs(step) <= enough or last <= abs(step) <= STALLED * abs(psi)):
            return found
        last = abs(step)
        above = rising and step * excess >= 0.0
        crossed = crossed or above
        inner, outer = (inner, psi) if above or not rising else (psi, outer)
        ahead = psi - step
        psi = ahead if rising and min(inner, outer) < ahead < max(inner, outer) else 0.5 * (inner + outer)
    return None


def greatest_load(load: Callable[[float], Load], limit: float) -> Load:
    """The load at its first maximum between the flat surface and the slope angle `limit`, or at `limit`."""
    end = min(limit, STEEPEST)
    below = end / SCAN
    for k in range(1, SCAN + 1):
        above = k * end / SCAN
        if load(above).change < 0.0:
            # The load rises at the flat surface, but the first slope of the scan may already be beyond the maximum.
            start = below if below < above else 1e-3 * above
            return load(slope_of_greatest(load, start, above))
        below = above
    return load(end)


def slope_of_greatest(load: Callable[[float], Load], rising: float, falling: float) -> float:
    """The slope angle of the greatest load, between an angle at which the load rises and one at which it falls.

    The zero of the derivative is found by false position, in the Illinois variant, to 1e-7 rad; at a maximum the error
    of the load is of second order. (Importing SciPy's root finders would take longer than the solution.)
    """
    low, high = load(rising).change, load(falling).change
    psi, side = rising, 0
    while abs(falling - rising) > 1e-7 and low * high < 0.0:
        before, psi = psi, (rising * high - falling * low) / (high - low)
        change = load(psi).change
        if change == 0.0 or abs(psi - before) < 1e-8:
            return psi
        if change * low > 0.0:
            rising, low, high, side = psi, change, 0.5 * high if side > 0 else high, 1
        else:
            falling, high, low, side = psi, change, 0.5 * low if side < 0 else low, -1
    return rising if low == 0.0 else falling if high == 0.0 else psi


KEPT = 4096
"""The number of cached solutions; a bowl of equal spheres needs one."""


class Balance(NamedTuple):
    """The equilibrium of one floating sphere: angles, and lengths over the capillary length."""

    slope_angle: float
    filling_angle: float
    contact_height: float
    charge: float


@elementwise
def linear_charge(bond_number: Number, density_ratio: Number, contact_angle: Angle) -> Number:
    """Charge of a small sphere over its radius, A/R = B Sigma.

    Too large by 0.25 % at B = 0.01, 2 % at 0.1, 6 to 9 % at 0.5, 8 to 18 % at 1. [vella2005]; [nicolson1949].

    >>> round(linear_charge(0.1, 1.5, math.pi / 2), 12)
    0.066666666667
    """
    return bond_number * weight_number(density_ratio, contact_angle)


@elementwise
def closed_form_charge(bond_number: Number, density_ratio: Number, contact_angle: Angle) -> Number:
    """Charge over the radius, A/R = B Sigma / [a K1(a) (1 + a^2/2) + a^2 K0(a)/2], a = sqrt(B) sin(theta), with linear
    slopes, but with heave and filling.

    Within 0.1 % of the nonlinear charge at B = 0.1, 1.1 % at 0.5, 6 % at 1, for spheres well above sinking.
    Derived by linearizing the force balance of [vella2005] with the depth of the contact line kept.

    >>> round(closed_form_charge(0.1, 1.5, math.pi / 2), 5)
    0.06525
    """
    a = math.sqrt(bond_number) * math.sin(contact_angle)
    charge = linear_charge(bond_number, density_ratio, contact_angle)
    return charge / (_edge(a) * (1.0 + a * a / 2.0) + a * _depth(a) / 2.0)


@elementwise
def nonlinear_charge(bond_number: Number, density_ratio: Number, contact_angle: Angle) -> Number:
    """Charge over the radius, A/R: the far amplitude of the full Young–Laplace meniscus. See
    `nonlinear_balance`.

    >>> round(nonlinear_charge(0.1, 1.5, math.pi / 2), 8)
    0.0652334
    """
    return nonlinear_balance(bond_number, density_ratio, contact_angle).charge / math.sqrt(bond_number)


@elementwise
def linear_balance(bond_number: Number, density_ratio: Number, contact_angle: Angle) -> Balance:
    """Balance of a small sphere with small slopes: z' = B Sigma / sin(theta) at the contact line.

    The slope is 10 to 12 % too large at B = 0.1, 1.7 % at 0.01 (theta = 90 degrees). [vella2005]; [canbraun2022, eq.
    4].

    >>> round(math.degrees(linear_balance(0.01, 1.5, math.pi / 2).slope_angle), 3)
    0.382
    """
    sine = math.sin(contact_angle)
    if sine < 1e-12:
        raise BadInput(
            "the linear theory has no slope at a contact angle of 0 or 180 degrees; use the nonlinear theory"
        )
    charge = linear_charge(bond_number, density_ratio, contact_angle)
    slope, a = charge / sine, math.sqrt(bond_number) * sine
    psi = math.atan(slope)
    height = -slope * bessel_k0(a) / bessel_k1(a)
    return Balance(psi, math.pi - contact_angle + psi, height, charge * math.sqrt(bond_number))


@elementwise
def closed_form_balance(bond_number: Number, density_ratio: Number, contact_angle: Angle) -> Balance:
    """Balance with a linear meniscus, but with heave and filling: r_c sin(psi)/R = B Sigma / [1 + (a^2/2)(1 + K0(a)/(a
    K1(a)))].

    The angles follow exactly from sin(phi_c) sin(psi) equal to this, phi_c = pi - theta + psi. There is no root if the
    sphere is too heavy for its size. Derived as `closed_form_charge` is, from [vella2005].

    >>> round(math.degrees(closed_form_balance(0.1, 1.5, math.pi / 2).slope_angle), 2)
    3.41
    """
    pull = _closed_form_pull(bond_number, density_ratio, contact_angle)
    psi = _closed_form_slope(pull, contact_angle)
    if math.isnan(psi):
        if neutral_density_ratio(contact_angle) < density_ratio < sinking_density_ratio(bond_number, contact_angle):
            raise BadInput("this sphere floats, but too deep for the closed form; use the nonlinear theory")
        raise _sinks(bond_number, density_ratio, contact_angle)
    filling = math.pi - contact_angle + psi
    radius = math.sqrt(bond_number) * math.sin(filling)
    height = (
        -pull * math.sqrt(bond_number) * (bessel_k0(radius) / (radius * bessel_k1(radius)) if radius > 0.0 else 0.0)
    )
    charge = closed_form_charge(bond_number, density_ratio, contact_angle)
    return Balance(psi, filling, height, charge * math.sqrt(bond_number))


@elementwise
@lru_cache(maxsize=KEPT)
def nonlinear_balance(bond_number: Number, density_ratio: Number, contact_angle: Angle) -> Balance:
    """Balance with the full Young–Laplace meniscus; raises FloaterSinks above the sinking limit.

    (2/3) D B = sin(phi_c) sin(psi) + (B/2) [-(z_c/R) sin(phi_c)^2 + 2/3 - cos(phi_c) + cos(phi_c)^3/3], phi_c = pi -
    theta + psi: weight = surface tension's vertical part + Archimedes' generalized buoyancy [keller1998, vella2005].
    Of several roots the one on the branch of the undisturbed surface, which is stable. Ten digits.
    Erratum: [canbraun2022, eq. 2 and 3] print +z_c/R, right only if z_c is a depth, which contradicts their z' > 0.

    >>> round(math.degrees(nonlinear_balance(0.1, 1.5, math.pi / 2).slope_angle), 8)
    3.41051514
    """
    if density_ratio == neutral_density_ratio(contact_angle):
        return Balance(0.0, math.pi - contact_angle, 0.0, 0.0)
    found = _stable_load(bond_number, density_ratio, contact_angle)
    filling = math.pi - contact_angle + found.slope_angle
    return Balance(found.slope_angle, filling, found.meniscus.height, found.meniscus.amplitude)


def sphere_contact(radius: Number, contact_angle: Angle, slope_angle: Angle) -> Contact:
    """Contact line of a sphere at phi_c = pi - theta + psi; lengths in L."""
    # sin and cos of phi_c, without the rounding error of pi.
    sine, cosine = math.sin(contact_angle - slope_angle), -math.cos(contact_angle - slope_angle)
    cap = math.pi * radius**3
    volume = cap * (2.0 / 3.0 - cosine + cosine**3 / 3.0)
    return Contact(radius * sine, radius * cosine, volume, cap * sine**3, -radius * cosine)


def load(bond_number: Number, contact_angle: Angle, slope_angle: Angle) -> Load:
    """Density ratio of a sphere that floats with this slope angle (not zero) at its contact line: the inverse of the
    balance.
    """
    radius = math.sqrt(bond_number)
    contact = sphere_contact(radius, contact_angle, slope_angle)
    return round_load(contact, slope_angle, 4.0 / 3.0 * math.pi * radius**3)


@elementwise
def neutral_density_ratio(contact_angle: Angle) -> Number:
    """Density ratio for which the surface is flat, Sigma = 0.

    >>> round(neutral_density_ratio(math.pi / 2), 12)
    0.5
    """
    cosine = math.cos(contact_angle)
    return 0.5 + 0.75 * cosine - 0.25 * cosine**3


@elementwise
@lru_cache(maxsize=KEPT)
def sinking_density_ratio(bond_number: Number, contact_angle: Angle) -> Number:
    """Largest density ratio D_max that floats: the maximum of the carried load over the filling
    angle.

    For small B about (3/2B) sin(theta/2)^2; 1 for a wetted sphere. [vella2015].

    >>> round(sinking_density_ratio(bond_number=0.1, contact_angle=math.pi / 2), 4)
    8.7917
    """
    if contact_angle < 1e-9:
        return 1.0

    def change(psi: float) -> float:
        return load(bond_number, contact_angle, psi).change

    # Small spheres sink at theta/2, large ones later.
    steepest = 0.7 * contact_angle
    while change(steepest) > 0.0:
        steepest = 0.5 * (steepest + min(contact_angle, STEEPEST))
    top = slope_of_greatest(partial(load, bond_number, contact_angle), 0.3 * contact_angle, steepest)
    return load(bond_number, contact_angle, top).carried


def _stable_load(bond_number: float, density_ratio: float, contact_angle: float) -> Load:
    """The load, and the slope angle of equilibrium between the flat surface and the slope of the greatest load."""
    neutral = neutral_density_ratio(contact_angle)
    limit = contact_angle if density_ratio > neutral else contact_angle - math.pi
    guess = _guess(bond_number, density_ratio, contact_angle, max(-STEEPEST, min(STEEPEST, limit)))
    found = stable_load(partial(load, bond_number, contact_angle), density_ratio, neutral, limit, guess)
    if found is None:
        raise _sinks(bond_number, density_ratio, contact_angle)
    return found


def _closed_form_pull(bond_number: float, density_ratio: float, contact_angle: float) -> float:
    """The ratio r_c sin(psi) / R of the closed form."""
    a = math.sqrt(bond_number) * math.sin(contact_angle)
    filling = a * a / 2.0 + a * _depth(a) / (2.0 * _edge(a))
    return linear_charge(bond_number, density_ratio, contact_angle) / (1.0 + filling)


def _closed_form_slope(pull: float, contact_angle: float) -> float:
    """The slope angle for which sin(theta - psi) sin(psi) has this value; NaN if it is too large."""
    cosine = -math.cos(contact_angle) - 2.0 * pull
    return 0.5 * (math.acos(cosine) - (math.pi - contact_angle)) if abs(cosine) <= 1.0 else math.nan


def _guess(bond_number: float, density_ratio: float, contact_angle: float, limit: float) -> float:
    """A first slope angle, from the closed form if it has one."""
    psi = _closed_form_slope(_closed_form_pull(bond_number, density_ratio, contact_angle), contact_angle)
    if math.isnan(psi):
        return 0.5 * limit
    return psi if abs(psi) < 0.9 * abs(limit) else 0.9 * limit


def _sinks(bond_number: float, density_ratio: float, contact_angle: float) -> FloaterSinks:
    if density_ratio < neutral_density_ratio(contact_angle):
        return FloaterSinks(f"a sphere of density ratio D = {density_ratio:.4g} leaves the liquid; take a denser one")
    most = sinking_density_ratio(bond_number, contact_angle)
    return FloaterSinks(
        f"a sphere of density ratio D = {density_ratio:.5g} sinks: at a Bond number of {bond_number:.4g} "
        f"and a contact angle of {math.degrees(contact_angle):.4g} degrees the surface carries D_max = {most:.5g} "
        "at most; take a smaller or lighter sphere, or a larger contact angle"
    )


def _edge(a: float) -> float:
    """The product a K1(a), which is 1 at a = 0."""
    return a * bessel_k1(a) if a > 1e-100 else 1.0


def _depth(a: float) -> float:
    """The product a K0(a), which is 0 at a = 0."""
    return a * bessel_k0(a) if a > 1e-100 else 0.0


CHARGES: dict[str, Callable[[float, float, float], float]] = {
    "nonlinear": nonlinear_charge,
    "closed-form": closed_form_charge,
    "linear": linear_charge,
}
BALANCES: dict[str, Callable[[float, float, float], Balance]] = {
    "nonlinear": nonlinear_balance,
    "closed-form": closed_form_balance,
    "linear": linear_balance,
}


@elementwise
def closure_contact_angle(bond_number: Number, density_ratio: Number) -> Angle:
    """Contact angle that the original project derives from B and D. Raises BadInput without a
    solution.

    phi_c = arcsin(pi B/2) = pi - theta + arctan(z'_c) put into its (13): (pi/2) tan(theta + phi_c) = Sigma(D, theta),
    solved on the branch of slopes below 90 degrees. A root needs B <= 2/pi and tan(arcsin(pi B/2)) >= 4 D/(3 pi).
    Erratum of [canbraun2022, eq. 6 to 17]: a contact angle is a property of the materials, independent of the weight.
    Its phi_c is the slope relation of a horizontal cylinder without the density; small spheres would be dry, whereas
    phi_c actually tends to pi - theta. Its (15) and (16) drop the factor pi/2, and its expansion (17) lacks
    sin(theta)/3; here (13) itself is solved.

    >>> round(math.degrees(closure_contact_angle(bond_number=0.6, density_ratio=0.5)), 4)
    117.2475
    """
    from scipy.optimize import brentq

    filling = math.asin(min(1.0, 0.5 * math.pi * bond_number))

    def excess(angle: float) -> float:
        return 0.5 * math.pi * math.tan(angle + filling - math.pi) - weight_number(density_ratio, angle)

    lowest = 0.5 * math.pi - filling
    if 0.5 * math.pi * bond_number > 1.0 or not excess(math.pi) >= 0.0 or not excess(lowest + 1e-9) < 0.0:
        raise BadInput(
            f"the original closure has no contact angle for B = {bond_number:g} and D = {density_ratio:g}: "
            "it needs B <= 2/pi and tan(arcsin(pi B/2)) >= 4 D/(3 pi); give the contact angle of the material instead"
        )
    return float(brentq(excess, lowest + 1e-9, math.pi, xtol=1e-14))
