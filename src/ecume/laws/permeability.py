"""The permeability of packed spheres, Darcy's law, and consolidation.

A scene chooses a row of the table at the end (`permeation.law`). Layers in which a liquid permeates consolidate: see
`degree_of_consolidation`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any

from ecume.units import Area, Length, Number, Pressure, Speed, Time, Unit, Viscosity

PressureGradient = Annotated[float, Unit("Pa/m")]
Diffusivity = Annotated[float, Unit("m^2/s")]

LEAST_POROSITY = 0.02
"""The least part of a layer that is liquid: undeformed spheres can fill more, deformed ones cannot."""
TERMS = 200
"""Terms of the series of consolidation: at a time factor of 1e-4 the last is below 1e-40."""


def kozeny_carman(solid_fraction: Number, diameter: Length) -> Area:
    """Permeability k = d^2 (1 - phi)^3 / (180 phi^2) of a random packing of spheres.

    d is the Sauter mean diameter, six times the volume of the spheres over their surface. For packings, phi above about
    0.3; the porosity 1 - phi is at least `LEAST_POROSITY`. [carman1937].

    >>> round(kozeny_carman(0.6, 1e-3) * 1e9, 3)
    0.988
    """
    porosity = max(1.0 - solid_fraction, LEAST_POROSITY)
    return diameter**2 * porosity**3 / (180.0 * solid_fraction**2)


def constant_permeability(permeability: Area) -> Area:
    """A permeability that does not depend on the packing.

    >>> constant_permeability(1e-9)
    1e-09
    """
    return permeability


def seepage_gradient(speed: Speed, viscosity: Viscosity, permeability: Area) -> PressureGradient:
    """Pressure gradient dp/dy = (eta/k) (v - Q) that drives the liquid through spheres: Darcy's law.

    The speed is that of the spheres relative to the volume flux Q of liquid and spheres together. [darcy1856].

    >>> round(seepage_gradient(1e-3, 1e-3, 1e-9))
    1000
    """
    return viscosity * speed / permeability


def consolidation_coefficient(permeability: Area, modulus: Pressure, viscosity: Viscosity) -> Diffusivity:
    """The diffusivity c = k M / eta of the pore pressure, with the oedometric modulus M: stress over strain of a layer
    without lateral strain. [terzaghi1943].

    >>> round(consolidation_coefficient(1e-9, 1e6, 1e-3), 12)
    1.0
    """
    return permeability * modulus / viscosity


def excess_pressure(depth: Length, height: Length, time: Time, coefficient: Diffusivity) -> Number:
    """Pore pressure, over the load, at a depth below the drained side of a layer whose other side is undrained.

    u = sum of 2/m sin(m z/H) exp(-m^2 c t/H^2) over m = (n + 1/2) pi, where the liquid alone bears the load at t = 0.
    [terzaghi1943].

    >>> round(excess_pressure(1.0, 1.0, 1e-3, 1.0), 6), round(excess_pressure(1.0, 1.0, 1.0, 1.0), 4)
    (1.0, 0.108)
    """
    total = 0.0
    for n in range(TERMS):
        m = (n + 0.5) * math.pi
        total += 2.0 / m * math.sin(m * depth / height) * math.exp(-(m**2) * coefficient * time / height**2)
    return total


def degree_of_consolidation(height: Length, time: Time, coefficient: Diffusivity) -> Number:
    """Settlement of a layer that is drained on one side, over its final settlement: U = 1 - sum of 2/m^2 exp(-m^2 c
    t/H^2). [terzaghi1943].

    >>> round(degree_of_consolidation(1.0, 0.197, 1.0), 3), degree_of_consolidation(1.0, 100.0, 1.0)
    (0.5, 1.0)
    """
    total = 0.0
    for n in range(TERMS):
        m = (n + 0.5) * math.pi
        total += 2.0 / m**2 * math.exp(-(m**2) * coefficient * time / height**2)
    return 1.0 - total


@dataclass(frozen=True)
class Permeability:
    """A row of the table: a law of permeability and everything that depends on it."""

    law: Callable[..., float]
    """the permeability (m^2); it takes `solid_fraction` and the Sauter mean `diameter` of a layer, and constants of the
    scene, by their names in `ecume.models.soft`'s `Medium`
    """
    papers: tuple[Callable[..., Any], ...] = ()
    """functions whose docstrings name the references that `ecume cite` lists"""
    needs: Mapping[str, str] = field(default_factory=dict)
    """the keys of `[permeation]` that the law uses, and what to say if one is missing"""


PERMEABILITIES = {
    "kozeny-carman": Permeability(kozeny_carman, (kozeny_carman,)),
    "constant": Permeability(
        constant_permeability, (), {"permeability": "is missing; expected that of the packing, such as 1e-9 m^2"}
    ),
}  # fmt: skip
"""Permeabilities: `permeation.law` of a scene."""
