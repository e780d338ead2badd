"""Floating spheres and menisci beside an independent computation."""

from __future__ import annotations

import csv
import math
from pathlib import Path

from ecume.laws import flotation, meniscus
from ecume.validation.rows import Row, within

PUBLISHED = Path(__file__).with_name("published.csv")
# A liquid whose capillary length is one meter, so that heights come out in capillary lengths.
LIQUID = flotation.Liquid(density=1000.0, surface_tension=1000.0, viscosity=1e-3, gravity=1.0)


def equilibrium(case: dict[str, str]) -> float:
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
    }[case["quantity"]]


def sinking(case: dict[str, str]) -> float:
    """The largest density ratio that floats."""
    return flotation.sinking_density_ratio(
        bond_number=float(case["bond_number"]), contact_angle=math.radians(float(case["contact_angle_deg"]))
    )


def wall(case: dict[str, str]) -> float:
    """A plane wall's height or far amplitude."""
    law = {"height_over_L": meniscus.wall_height, "amplitude_over_L": meniscus.wall_amplitude}[case["quantity"]]
    return law(math.radians(float(case["contact_angle_deg"])), LIQUID)


def dish(case: dict[str, str]) -> float:
    """The height in the middle of a round dish, or at its wall."""
    radius = float(case["dish_radius_over_L"])
    r = {"middle_over_L": 0.0, "wall_over_L": radius}[case["quantity"]]
    angle = math.radians(float(case["contact_angle_deg"]))
    return float(meniscus.dish_height(r, radius, angle, LIQUID, theory=case["theory"]))


TABLES = {"equilibrium": equilibrium, "sinking": sinking, "wall": wall, "dish": dish}


def rows() -> list[Row]:
    """Every published number."""
    with PUBLISHED.open(encoding="utf-8") as file:
        return [
            within(_name(case), TABLES[case["table"]](case), float(case["value"]), float(case["tolerance"]))
            for case in csv.DictReader(file)
        ]


def _numbers(case: dict[str, str]) -> tuple[float, float, float]:
    angle = math.radians(float(case["contact_angle_deg"]))
    return float(case["bond_number"]), float(case["density_ratio"]), angle


def _name(case: dict[str, str]) -> str:
    given = {"B": "bond_number", "D": "density_ratio", "theta": "contact_angle_deg", "a/L": "dish_radius_over_L"}
    where = " ".join(f"{letter}={case[key]}" for letter, key in given.items() if case[key])
    return f"{case['table']} {case['quantity']} {case['theory']} {where}"
