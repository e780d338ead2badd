"""How any body floats, in SI."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from ecume.errors import BadInput, FloaterSinks
from ecume.laws.arguments import chosen, require_numbers
from ecume.laws.flotation.balance import BALANCES, CHARGES, Floating
from ecume.laws.flotation.bodies import (
    Bubble,
    Disc,
    Ellipsoid,
    HorizontalCylinder,
    Liquid,
    Sphere,
    VerticalCylinder,
    bond_number,
    density_ratio,
)
from ecume.laws.flotation.nonspherical import (
    bubble_floating,
    cylinder_floating,
    disc_floating,
    ellipsoid_floating,
    lying_floating,
)
from ecume.units import Angle, Length

Upright = Sphere | Disc | Bubble | VerticalCylinder | Ellipsoid
"""Bodies with a far field of K0, which pull at one another."""
Body = Upright | HorizontalCylinder
KEPT = 4096
LEAVES = ("bottom", "leaves the liquid", "denser")


@dataclass(frozen=True)
class Equilibrium:
    """How a body floats. Heights are measured from the undisturbed surface, upwards.

    slope_angle: of the surface at the contact line, positive where it rises outward (a heavy body).
    filling_angle: inclination of the body's own surface there, from the bottom; a sphere's polar angle, 90 degrees at
    rims and upright sides. contact_radius: of the contact line (a lying cylinder: half the distance of the two).
    center_height: of a disc's rim, of a bubble's centroid, of any other body's middle. charge: amplitude A of the far
    field -A K0(r/L), from a lying cylinder -A exp(-|x|/L), with x from its axis.
    floats: always True; a theory that finds no equilibrium raises FloaterSinks.
    """

    slope_angle: Angle
    filling_angle: Angle
    contact_radius: Length
    contact_height: Length
    center_height: Length
    charge: Length
    floats: bool = True


@lru_cache(maxsize=KEPT)
def equilibrium(body: Body, liquid: Liquid, theory: str = "nonlinear") -> Equilibrium:
    """How a body floats, by the theory "nonlinear", "closed-form" or "linear"; raises FloaterSinks when it does not.

    The formulas stand with the bodies: `nonlinear_balance` and its fellows for spheres, `disc_floating`,
    `cylinder_floating`, `lying_floating`, `ellipsoid_floating`, `bubble_floating`. [vella2005, keller1998].

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> heavy = equilibrium(Sphere(1e-3, 1300.0, 1.57), water)
    >>> heavy.slope_angle > 0 and heavy.contact_height < 0
    True
    >>> equilibrium(Bubble(5e-4), water).charge < 0
    True
    """
    chosen(BALANCES, theory, "theory of flotation")
    if type(body) not in FLOATING:
        raise BadInput(f"got {body!r}; expected a floating body: {', '.join(kind.__name__ for kind in FLOATING)}")
    found, length = FLOATING[type(body)](body, liquid, theory), liquid.capillary_length
    if not 0.0 <= found.filling_angle <= math.pi:
        # Only nonlinear slopes know that they end; what the others take for one may lie where there is no body.
        beyond, fate, cure = ("top", "sinks", "lighter") if found.slope_angle > 0.0 else LEAVES
        raise FloaterSinks(
            f"by the {theory} theory the contact line would lie beyond the {beyond} of this {type(body).__name__}: it "
            f"{fate}; take a {cure} one, or theory = 'nonlinear', which limits the load of the surface"
        )
    return Equilibrium(
        slope_angle=found.slope_angle,
        filling_angle=found.filling_angle,
        contact_radius=found.contact_radius * length,
        contact_height=found.contact_height * length,
        center_height=found.center_height * length,
        charge=found.charge * length,
    )


def capillary_charge(body: Body, liquid: Liquid, theory: str = "nonlinear") -> Length:
    """A: the surface far from the body is -A K0(r/L); positive for a heavy one, negative for a light one.

    Like charges attract, unlike repel. Theories: "nonlinear", "closed-form" (spheres: within 0.1 % at B = 0.1),
    "linear" (R B Sigma). Raises FloaterSinks. [vella2005].

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> capillary_charge(Sphere(1e-3, 100.0, 1.57), water) < 0
    True
    """
    if isinstance(body, Sphere):
        charge = chosen(CHARGES, theory, "theory of flotation")
        equilibrium(body, liquid)  # raises FloaterSinks, which linear theories do not know
        return body.radius * charge(*sphere_numbers(body, liquid))
    return equilibrium(body, liquid, theory).charge


def sphere_numbers(sphere: Sphere, liquid: Liquid) -> tuple[float, float, float]:
    """Bond number, density ratio and contact angle; refused where they describe no floater."""
    numbers = bond_number(sphere, liquid), density_ratio(sphere, liquid), sphere.contact_angle
    require_numbers(*numbers)
    return numbers


def _sphere_floating(sphere: Sphere, liquid: Liquid, theory: str) -> Floating:
    found, radius = BALANCES[theory](*sphere_numbers(sphere, liquid)), sphere.radius / liquid.capillary_length
    return Floating(
        slope_angle=found.slope_angle,
        filling_angle=found.filling_angle,
        contact_radius=radius * math.sin(found.filling_angle),
        contact_height=found.contact_height,
        center_height=found.contact_height + radius * math.cos(found.filling_angle),
        charge=found.charge,
    )


FLOATING: dict[type, Callable[[Any, Liquid, str], Floating]] = {
    Sphere: _sphere_floating,
    Disc: disc_floating,
    Bubble: bubble_floating,
    VerticalCylinder: cylinder_floating,
    HorizontalCylinder: lying_floating,
    Ellipsoid: ellipsoid_floating,
}
