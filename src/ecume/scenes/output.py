"""The table `[output]` of all models: what a run writes."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from ecume.scenes.quantities import STRICT
from ecume.scenes.validated import dataclass

QuantityName = Annotated[str, Field(min_length=1, max_length=100, pattern=r"^[A-Za-z0-9_]+$")]
"""The name of an array or of a number of a frame. Which names exist depends on the model and the scene."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class OutputSpec:
    """The quantities that a run writes. `frame_every` at the top of the scene sets how often frames are written. None
    of these keys changes the simulation or its checkpoints, which are in double precision.
    """

    quantities: tuple[QuantityName, ...] = ()
    """The quantities per particle that frames contain; by default all. Positions and constant quantities, such as
    radius and species, are always included: a constant quantity is stored once. Example: `["velocity"]`. Effect: fewer
    quantities take less disk space; movies, figures and restarts that need an omitted one refuse."""
    precision: Literal["double", "single"] = "double"
    """The floating-point precision of quantities per particle in frames: `double`, or `single` with a relative
    rounding error of 6e-8. Numbers of the whole system are always double. Effect: `single` takes less than half of the
    disk space; continuations of a run with `start_from` begin from rounded positions."""
