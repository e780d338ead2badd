"""Passive particles, which the liquid carries without being moved by them: tracers, and grains that settle."""

from __future__ import annotations

from typing import Annotated, Any, Self

from pydantic import Field, model_validator

from ecume.scenes.common import dataclass
from ecume.scenes.faults import Inconsistent, Path
from ecume.scenes.quantities import STRICT, Color, Count, Place, PositiveDensity, Switch
from ecume.units import Length, Number

Radius = Annotated[Length, Field(ge=0.0, le=1e3)]
Schmidt = Annotated[Number, Field(gt=0.0, le=1e3)]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class PassiveTracerSpec:
    """Particles that go with the liquid: at given places, or so many at random in a box."""

    positions: tuple[Place, ...] = ()
    """The initial position of each tracer (m), instead of `count`. Effect: replaces the random positions."""
    count: Count | None = None
    """The number of tracers at random positions between `low` and `high`. Example: `200`. Effect: more tracers
    resolve the flow better."""
    low: Place | None = None
    """The lowest corner of the box of random positions (m). Effect: moves the side of the box."""
    high: Place | None = None
    """The highest corner of the box of random positions (m). Effect: moves the side of the box."""
    radius: Radius = 0.0
    """The radius of each tracer (m); without a radius it follows the liquid exactly. Effect: larger tracers settle
    faster."""
    density: PositiveDensity | None = None
    """The density of tracers with a radius (kg/m^3). Effect: tracers denser than the liquid settle, others rise."""
    turbulent_dispersion: Switch = False
    """Whether the eddies of `method.turbulence` disperse the tracers by a random walk. Effect: spreads the tracers."""
    schmidt_number: Schmidt = 0.7
    """The eddy viscosity, divided by the diffusivity of the tracers. Effect: smaller values disperse more strongly."""
    color: Color | None = None
    """The color in pictures: `#rrggbb`, or an English name. Example: `"orange"`. Effect: none on the motion."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        complaints: list[tuple[Path, str]] = []
        box = self.low is not None and self.high is not None and self.count is not None
        if box == bool(self.positions):
            complaints.append(((), "expected either positions, or count with low and high"))
        if any(b < a for a, b in zip(self.low or (), self.high or (), strict=False)):
            complaints.append((("high",), "expected a corner above low in each direction"))
        if len(self.low or ()) != len(self.high or ()):
            complaints.append((("high",), "expected as many numbers as low has"))
        if (self.radius > 0.0) != (self.density is not None):
            complaints.append((("density",), "expected with a radius, and only then"))
        if complaints:
            raise Inconsistent(complaints)
        return self


def passive_tracer_faults(tracers: tuple[PassiveTracerSpec, ...], tank: Any, turbulence: str) -> list[tuple[Path, str]]:
    """Positions outside of the tank, and eddies in a scene without turbulence."""
    found: list[tuple[Path, str]] = []
    for index, spec in enumerate(tracers):
        for place in (*spec.positions, *(corner for corner in (spec.low, spec.high) if corner is not None)):
            inside = len(place) == len(tank.low) and all(
                a <= x <= b for a, x, b in zip(tank.low, place, tank.high, strict=True)
            )
            if not inside:
                found.append((("passive_tracers", index), f"{tuple(place)} is not in the tank"))
        if spec.turbulent_dispersion and turbulence == "none":
            found.append(
                (("passive_tracers", index, "turbulent_dispersion"), "there are no eddies; set method.turbulence")
            )
    return found
