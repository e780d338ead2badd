"""The permeation in frames and in `ecume check`: pore pressures, permeability, and the time of consolidation."""

from __future__ import annotations

import math

import numpy as np

from ecume.laws.permeability import PERMEABILITIES, consolidation_coefficient
from ecume.laws.surfaces import Expected
from ecume.models.model import Row
from ecume.models.soft.medium import OPEN, Medium
from ecume.models.soft.parameters import Parameters
from ecume.models.soft.permeation import Permeation, ends_of, pore_pressures
from ecume.models.soft.state import Step
from ecume.scenes.soft import SoftScene
from ecume.units import Array, duration_text, with_prefix

PORE = "pore_pressure"


def pressure_arrays(step: Step) -> dict[str, Array]:
    """The pore pressure at the center of each sphere (Pa, in 2D N/m)."""
    if not (layers := step.permeation) or not step.walls:
        return {}
    begin, end = ends_of(layers.medium, step.walls.places)
    height = step.bodies.position[:, layers.medium.axis]
    return {PORE: np.interp(height, np.linspace(begin, end, layers.medium.layers + 1), pore_pressures(layers))}


def pressure_numbers(layers: Permeation | tuple[()], names: list[str]) -> dict[str, float]:
    """The pore pressures at the walls with these names, which bound the layers, and the pore pressure with the largest
    magnitude.
    """
    if not layers:
        return {}
    pressures = pore_pressures(layers)
    ends = zip((layers.medium.lower, layers.medium.upper), pressures[[0, -1]], strict=True)
    found = {f"{PORE}_{names[wall]}": float(value) for wall, value in ends if wall != OPEN}
    return found | {f"largest_{PORE}": float(pressures[np.abs(pressures).argmax()])}


def permeation_rows(scene: SoftScene, parameters: Parameters, typical: Expected) -> list[Row]:
    """The layers, their mean permeability, and the time of consolidation under the expected forces."""
    medium = parameters.permeation
    if not medium or scene.permeation is None:
        return []
    fraction, passes = mean_permeability(medium)
    layer = with_prefix(medium.height / medium.layers, "m", 3)
    remark = f"{scene.permeation.law}, at a mean solid fraction of {fraction:.3g}"
    rows = [
        ("layers of pore pressure", str(medium.layers), f"{layer} each"),
        ("permeability", f"{passes:.3g} m^2", remark),
    ]
    if not typical.force > 0.0:
        return rows
    radius, prefactors = typical.pair.radius, typical.pair.prefactors
    unit = prefactors.normal * math.sqrt(prefactors.deflection_weight) * typical.pair.modulus * radius**2
    deflection = radius * (typical.force / unit) ** (2.0 / 3.0)
    modulus = 1.5 * typical.force / deflection / (2.0 * radius)
    path = medium.height if medium.closed != OPEN else 0.5 * medium.height
    time = path**2 / consolidation_coefficient(passes, modulus, medium.viscosity)
    remark = f"height^2 eta/(k M), with M = {with_prefix(modulus, 'Pa', 2)} of contacts under the {typical.source}"
    return [*rows, ("time of consolidation", duration_text(time), remark)]


def mean_permeability(medium: Medium) -> tuple[float, float]:
    """The solid fraction between the ends at the start, and the corresponding permeability (m^2)."""
    volume, surface = float(medium.volume.sum()), float(medium.surface.sum())
    fraction = volume / (medium.area * medium.height)
    given = {"solid_fraction": fraction, "diameter": 6.0 * volume / surface, "permeability": medium.permeability}
    law = list(PERMEABILITIES.values())[medium.law].law
    names = law.__code__.co_varnames[: law.__code__.co_argcount]
    return fraction, float(law(**{name: given[name] for name in names}))
