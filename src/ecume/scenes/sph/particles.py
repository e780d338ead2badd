"""Single particles of liquid, as a table or another run gives them."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field, model_validator
from pydantic.dataclasses import dataclass

from ecume.scenes.faults import Complaints, Inconsistent
from ecume.scenes.quantities import STRICT, Motion, Place, PositiveDensity
from ecume.units import Mass


@dataclass(frozen=True, kw_only=True, config=STRICT)
class ParticlesSpec:
    """Particles by their places; of the rest, all or none."""

    positions: tuple[Place, ...]
    """(m)"""
    velocities: tuple[Motion, ...] = ()
    """m/s; left out, those of the region"""
    densities: tuple[PositiveDensity, ...] = ()
    """kg/m^3; left out, those of the depth"""
    masses: tuple[Annotated[Mass, Field(gt=0.0, le=1e15)], ...] = ()
    """kg; left out, density times a cell of the lattice"""

    @model_validator(mode="after")
    def _alike(self) -> Self:
        count = len(self.positions)
        lists = {"velocities": self.velocities, "densities": self.densities, "masses": self.masses}
        wrong = [
            ((key,), f"came {len(values)}, and there are {count} positions")
            for key, values in lists.items()
            if values and len(values) != count
        ]
        if not count:
            wrong.append((("positions",), "there are none"))
        if wrong:
            raise Inconsistent(wrong)
        return self


def particle_faults(particles: ParticlesSpec, dimension: int) -> Complaints:
    """The first place and velocity that do not have the tank's dimension."""
    found: Complaints = []
    for key, rows in (("positions", particles.positions), ("velocities", particles.velocities)):
        wrong = [index for index, row in enumerate(rows) if len(row) != dimension]
        if wrong:
            came = f"came {len(rows[wrong[0]])} numbers; the tank has {dimension} dimensions"
            found.append((("particles", key, wrong[0]), came))
    return found
