"""The scene of the floating model as a whole."""

from __future__ import annotations

import dataclasses
import math
from typing import Any, Literal, Self

from pydantic import model_validator

from ecume.scenes.common import Common, Kind, dataclass
from ecume.scenes.faults import Complaints, Inconsistent
from ecume.scenes.floating.floats import FloatRow, FloatSpec
from ecume.scenes.floating.surroundings import (
    ActivitySpec,
    CellSpec,
    ContactSpec,
    DishSpec,
    FlowSpec,
    HydrodynamicsSpec,
    IntegrationSpec,
    InteractionSpec,
    LiquidSpec,
    MagneticFieldSpec,
    WavesSpec,
)
from ecume.scenes.quantities import MOST_PARTICLES, MOST_STEPS, STRICT, Gravity

THEORIES: dict[str, dict[str, dict[str, Any]]] = {
    "nonlinear": {
        "interaction": {"law": "capillary", "charge": "nonlinear"},
        "dish": {"law": "meniscus"},
        "hydrodynamics": {"drag": "stokes"},
    },
    "linear": {
        "interaction": {"law": "capillary", "charge": "linear"},
        "dish": {"law": "linear"},
        "hydrodynamics": {"drag": "stokes"},
    },
    "legacy-2022": {
        "interaction": {"law": "one-sided-legacy", "charge": "linear"},
        "dish": {"law": "two-point-legacy"},
        "hydrodynamics": {"drag": "none"},
        "contacts": {"legacy_coefficient": 0.3},
    },
}
"""What each theory says where a scene leaves a law out."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class FloatingScene(Common):
    """Spheres on a liquid surface, with or without a dish around them.

    A file may also contain `particles_from = "table.csv"` or `start_from = "RUN@-1"`; reading it converts either into
    `rows`, so that the scene does not depend on other files.
    """

    model: Literal["floating"] = "floating"
    """The model: particles at a liquid surface. Effect: selects the equations that are solved."""
    theory: Literal["nonlinear", "linear", "legacy-2022"] = "nonlinear"
    """The set of default laws: the exact far field, small slopes everywhere, or those of the original program.
    Effect: sets each law that the scene does not name."""
    liquid: LiquidSpec = LiquidSpec()
    """The properties of the liquid and of the gas above it. Effect: they set the capillary length, the drag and the
    attraction."""
    gravity: Gravity = 9.81
    """The gravitational acceleration (m/s^2), downward. Effect: a larger value shortens the capillary length, the
    range of the attraction, and increases the capillary charges."""
    flow: FlowSpec | None = None
    """A flow of the surface, imposed on the liquid. Effect: drags the floats along; requires drag."""
    particles: tuple[FloatSpec, ...] = ()
    """The species of floats, one table each. Effect: each species adds floats with common properties."""
    rows: tuple[FloatRow, ...] = ()
    """Individual floats, in addition to those of `particles`; tables and restarts are read into them. Effect: each
    row adds one float."""
    dish: DishSpec | None = None
    """The wall around the floats; without it and without a `cell` the surface is infinite. Effect: its meniscus
    attracts or repels floats, and they bounce off it."""
    cell: CellSpec | None = None
    """The periodic cell, instead of a dish. Effect: the floats are a part of an infinite layer, without walls and
    their menisci."""
    integration: IntegrationSpec = IntegrationSpec()
    """The time stepping. Effect: determines the error per step and the cost."""
    hydrodynamics: HydrodynamicsSpec = HydrodynamicsSpec()
    """The forces of the liquid on moving floats. Effect: they damp the motion or make it overdamped."""
    activity: ActivitySpec | None = None
    """Active forces and torques on floats. Effect: floats move without attraction or noise; requires drag."""
    magnetic_field: MagneticFieldSpec | None = None
    """A magnetic field, constant or oscillating, that induces moments. Effect: floats attract and repel one another by
    induced and permanent moments."""
    waves: WavesSpec | None = None
    """Waves radiated by floats that oscillate up and down. Effect: floats push and turn one another across many
    wavelengths; requires drag."""
    contacts: ContactSpec = ContactSpec()
    """The contacts between floats. Effect: they determine collisions and the structure of rafts."""
    interaction: InteractionSpec = InteractionSpec()
    """The capillary interaction of floats. Effect: it determines attraction, accuracy and cost."""

    @property
    def kinds(self) -> tuple[Kind, ...]:
        """The species, those of `particles` first."""
        return tuple(Kind(*named) for named in species_of(self))

    @property
    def rubs(self) -> bool:
        """Whether surfaces rub anywhere."""
        return self.contacts.friction > 0.0 or (self.dish is not None and self.dish.friction > 0.0)

    @property
    def sides(self) -> tuple[float, float]:
        """The sides of the periodic cell (m), as large as its area fraction requires; zero without a cell."""
        if self.cell is None:
            return 0.0, 0.0
        (width, height), asked = self.cell.size, self.cell.area_fraction
        if asked is None:
            return width, height
        covered = math.pi * sum(one.radius**2 * getattr(one, "count", 1) for one in self.given)
        factor = math.sqrt(covered / asked / (width * height))
        return factor * width, factor * height

    @property
    def given(self) -> tuple[FloatSpec | FloatRow, ...]:
        """The entries that give floats: tables of species, then rows."""
        return (*self.particles, *self.rows)

    @property
    def shaped(self) -> bool:
        """Whether any float is longer than wide, or has corners."""
        return any(one.shape is not None for one in self.given)

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        named = tuple(
            dataclasses.replace(species, name=species.name or f"float-{index}")
            for index, species in enumerate(self.particles, 1)
        )
        object.__setattr__(self, "particles", named)
        for part, laws in THEORIES[self.theory].items():
            given = getattr(self, part)
            left_out = {key: law for key, law in laws.items() if given is not None and getattr(given, key) is None}
            if left_out:
                object.__setattr__(self, part, dataclasses.replace(given, **left_out))
        complaints = [*_population(self), *_boundary(self), *_steps(self), *_doubles(self)]
        if complaints:
            raise Inconsistent(complaints)
        return self


def species_of(scene: FloatingScene) -> list[tuple[str, str | None]]:
    """The name and color of each species; its place in the list is its number in frames."""
    found: dict[str, str | None] = {species.name: species.color for species in scene.particles}
    for row in scene.rows:
        found[row.species_name] = found.get(row.species_name) or row.color
    return list(found.items())


def _population(scene: FloatingScene) -> Complaints:
    total = len(scene.rows) + sum(species.count for species in scene.particles)
    if total == 0:
        return [
            (
                ("particles",),
                "there is nothing afloat; write a [[particles]] table with radius, density and contact_angle",
            )
        ]
    if total > MOST_PARTICLES:
        return [(("particles",), f"{total} floats are more than {MOST_PARTICLES:.0e}")]
    return []


def _boundary(scene: FloatingScene) -> Complaints:
    if scene.cell is None or scene.dish is None:
        return []
    return [(("cell",), "is periodic along both axes, and there is a [dish] with walls; expected one of the two")]


def _steps(scene: FloatingScene) -> Complaints:
    step = scene.integration.time_step
    if step is None:
        return []
    if step > scene.frame_every * (1 + 1e-9):
        return [(("integration", "time_step"), f"got {step:g} s, longer than frame_every, {scene.frame_every:g} s")]
    steps = scene.duration / step
    return (
        [(("integration", "time_step"), f"gives {steps:.3g} steps, more than {MOST_STEPS:.0e}")]
        if steps > MOST_STEPS
        else []
    )


def _doubles(scene: FloatingScene) -> Complaints:
    names = [species.name for species in scene.particles]
    return [
        (("particles", index, "name"), f"got {name!r} for the second time; each species has its own name")
        for index, name in enumerate(names)
        if name in names[:index]
    ]
