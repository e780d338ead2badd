"""Floating bodies, menisci, walls and drag beside an independent computation."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial

from ecume.laws import capillarity, drag, flotation, meniscus
from ecume.laws.special import bessel_k0, bessel_k1
from ecume.validation import multipole as beyond
from ecume.validation.rows import Row, above, below, within
from ecume.validation.runner import read_table

# A liquid whose capillary length is one meter, so that heights come out in capillary lengths.
LIQUID = flotation.Liquid(density=1000.0, surface_tension=1000.0, viscosity=1e-3, gravity=1.0)
WATER = flotation.Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)

Case = dict[str, str]


def equilibrium(case: Case) -> float:
    """A sphere's slope, filling, heights or charge."""
    bond, ratio, angle = _numbers(case)
    if case["quantity"] == "charge_over_R":
        return flotation.CHARGES[case["theory"]](bond, ratio, angle)
    sphere = flotation.Sphere(radius=math.sqrt(bond), density=1000.0 * ratio, contact_angle=angle)
    found = flotation.equilibrium(sphere, LIQUID, case["theory"])
    return {
        "slope_angle_deg": math.degrees(found.slope_angle),
        "filling_angle_deg": math.degrees(found.filling_angle),
        "contact_height_over_L": found.contact_height,
        "center_height_over_L": found.center_height,
        "pull_over_R": found.contact_radius / sphere.radius * math.sin(found.slope_angle),
    }[case["quantity"]]


def sinking(case: Case) -> float:
    """The largest density ratio that floats, or the slope at which it does."""
    bond, angle = float(case["bond_number"]), math.radians(float(case["contact_angle_deg"]))
    if case["quantity"] == "slope_angle_deg":
        load = partial(flotation.balance.load, bond, angle)
        return math.degrees(flotation.balance.greatest_load(load, angle).slope_angle)
    return flotation.sinking_density_ratio(bond_number=bond, contact_angle=angle)


def wall(case: Case) -> float:
    """A plane wall's height or far amplitude."""
    law = {"height_over_L": meniscus.wall_height, "amplitude_over_L": meniscus.wall_amplitude}[case["quantity"]]
    return law(math.radians(float(case["contact_angle_deg"])), LIQUID)


def dish(case: Case) -> float:
    """The height in the middle of a round dish, or at its wall."""
    radius = float(case["dish_radius_over_L"])
    r = {"middle_over_L": 0.0, "wall_over_L": radius}[case["quantity"]]
    angle = math.radians(float(case["contact_angle_deg"]))
    return float(meniscus.dish_height(r, radius, angle, LIQUID, theory=case["theory"]))


SPHERES = {"equilibrium": equilibrium, "sinking": sinking, "wall": wall, "dish": dish}


def spheres(case: Case) -> Row:
    """Spheres, walls and dishes."""
    given = {"B": "bond_number", "D": "density_ratio", "theta": "contact_angle_deg", "a/L": "dish_radius_over_L"}
    where = " ".join(f"{letter}={case[key]}" for letter, key in given.items() if case[key])
    name = f"{case['table']} {case['quantity']} {case['theory']} {where}"
    return _row(name, SPHERES[case["table"]](case), case)


def discs(case: Case) -> Row:
    """A pinned disc with a steep meniscus."""
    disc = flotation.Disc(float(case["radius_over_L"]), 1000.0 * float(case["load_over_gamma_L"]))
    found = flotation.equilibrium(disc, LIQUID)
    computed = {
        "slope_angle_deg": math.degrees(found.slope_angle),
        "contact_height_over_L": found.contact_height,
        "charge_over_L": found.charge,
    }[case["quantity"]]
    return _row(f"disc {case['quantity']} a/L={case['radius_over_L']} W={case['load_over_gamma_L']}", computed, case)


def closures(case: Case) -> Row:
    """The contact angle of the original project's closure."""
    found = flotation.closure_contact_angle(float(case["bond_number"]), float(case["density_ratio"]))
    return within(
        f"original closure's contact angle (deg) B={case['bond_number']} D={case['density_ratio']}",
        math.degrees(found),
        float(case["contact_angle_deg"]),
        float(case["tolerance"]),
    )


def image_forces(case: Case) -> Row:
    """Force of a wall's image, over gamma A^2/L; without a radius the wall is plane."""
    distance, word = float(case["distance_over_L"]), case["wall"]
    if case["dish_radius_over_L"]:
        radius = float(case["dish_radius_over_L"])
        force = meniscus.image_force(1.0, radius - distance, radius, LIQUID, word)
    else:
        force = meniscus.plane_image_force(1.0, distance, LIQUID, word)
    where = f"a/L={case['dish_radius_over_L'] or 'plane'} d/L={case['distance_over_L']}"
    return _row(f"image of a wall, {word} {where}", float(force) / LIQUID.surface_tension, case)


def lubrication(case: Case) -> Row:
    """The drag of two spheres that approach one another."""
    separation, factor = float(case["separation_over_radius"]), float(case["factor"])
    computed = float(drag.pair_factor(separation))
    return within(f"drag of a pair at l/R={separation:g}", computed, factor, float(case["tolerance"]))


def approach(case: Case) -> Row:
    """How long two equal spheres creep from 2 L to 2.02 R, drag against pull, or how they pull at contact."""
    sphere = flotation.Sphere(1e-3 * float(case["radius_mm"]), 1050.0, math.radians(75.0))
    name = f"two spheres of R={case['radius_mm']} mm, {case['quantity']}"
    return _row(name, APPROACHES[case["quantity"]](sphere), case)


def pull_of(sphere: flotation.Sphere, distance: float) -> float:
    """The attraction of two bodies (N), by linear charges."""
    charge = flotation.capillary_charge(sphere, WATER, "linear")
    strength = capillarity.pair_strength(WATER.surface_tension, charge, charge)
    return -capillarity.pair_force(distance, strength, WATER.capillary_length)


def approach_time(sphere: flotation.Sphere, film: Callable[[float], float]) -> float:
    """The time that the slow approach takes (s): the integral of friction over twice the pull."""
    from scipy.integrate import quad

    friction = drag.stokes_friction(sphere.radius, WATER.viscosity, 0.565)
    length = WATER.capillary_length

    def slowness(distance: float) -> float:
        return friction * film(distance / sphere.radius) / (2.0 * pull_of(sphere, distance))

    ends = 2.02 * sphere.radius, 2.0 * length
    return float(quad(slowness, *ends, epsabs=0.0, epsrel=1e-10, limit=200)[0])


APPROACHES: dict[str, Callable[[flotation.Sphere], float]] = {
    "time_alone_s": lambda sphere: approach_time(sphere, lambda _: 1.0),
    "time_with_film_s": lambda sphere: approach_time(sphere, lambda separation: float(drag.pair_factor(separation))),
    "contact_force_N": lambda sphere: pull_of(sphere, 2.0 * sphere.radius),
}


def bessel(case: Case) -> Iterator[Row]:
    """K0 and K1, of which all sums are made."""
    x = float(case["x"])
    for name, law in (("k0", bessel_k0), ("k1", bessel_k1)):
        value = float(case[name])
        yield within(f"{name.upper()}({x:g})", law(x), value, 1e-14 * value)


def truncation(case: Case) -> Row:
    """The part of the pull at a raft's straight edge that a cutoff omits."""
    computed = capillarity.neglected_fraction(float(case["cutoff_over_L"]))
    name = f"share of a raft's pull beyond {case['cutoff_over_L']} L"
    return within(name, computed, float(case["neglected"]), float(case["tolerance"]))


def lines_of_charges() -> list[Row]:
    """Charges that stand for contact lines that rise and fall, on the law of quadrupoles."""
    from ecume.validation.shapes import law_rows

    return [row._replace(name=f"lines of charges: {row.name}") for row in law_rows()]


def signs() -> list[Row]:
    """Compare the signs of forces, and action with reaction."""
    heavy = flotation.Sphere(1e-3, 1300.0, math.radians(90.0))
    disc, bubble = flotation.Disc(1.3e-3, 2e-5), flotation.Bubble(5e-4)
    wetting = meniscus.wall_amplitude(math.radians(45.0), WATER)

    def from_wall(body: flotation.Body) -> float:
        charge = flotation.equilibrium(body, WATER).charge
        strength = capillarity.wall_strength(WATER.surface_tension, charge, wetting)
        return capillarity.dish_force(0.018, strength, WATER.capillary_length, 0.02)

    def force(a: flotation.Sphere | flotation.Disc | flotation.Bubble, b: flotation.Disc | flotation.Bubble) -> float:
        return float(flotation.pair_force(a, b, 4e-3, WATER, "nonlinear"))

    return [
        above("force of a wetting wall on a heavy sphere (N)", from_wall(heavy), 0.0),
        below("force of a wetting wall on a bubble (N)", from_wall(bubble), 0.0),
        above("force between a bubble and a loaded disc (N)", force(bubble, disc), 0.0),
        below("force between a heavy sphere and a loaded disc (N)", force(heavy, disc), 0.0),
        below("action and reaction, over the force", abs(force(bubble, disc) / force(disc, bubble) - 1.0), 1e-12),
    ]


def rows() -> list[Row]:
    """Every published number, those of many bodies beyond superposition as well."""
    found = [spheres(case) for case in read_table("floating", "published")]
    found += [discs(case) for case in read_table("floating", "published_discs")]
    found += [closures(case) for case in read_table("floating", "published_closure")]
    found += [image_forces(case) for case in read_table("floating", "published_images")]
    found += [lubrication(case) for case in read_table("floating", "published_lubrication")]
    found += [approach(case) for case in read_table("floating", "published_approach")]
    found += [row for case in read_table("floating", "published_bessel") for row in bessel(case)]
    found += [truncation(case) for case in read_table("floating", "published_truncation")]
    return found + signs() + beyond.rows() + lines_of_charges()


def _row(name: str, computed: float, case: Case) -> Row:
    return within(name, computed, float(case["value"]), float(case["tolerance"]))


def _numbers(case: Case) -> tuple[float, float, float]:
    angle = math.radians(float(case["contact_angle_deg"]))
    return float(case["bond_number"]), float(case["density_ratio"]), angle
