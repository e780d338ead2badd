"""The table `[output]` of all models: what a run writes."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from ecume.scenes.faults import Complaints, Inconsistent
from ecume.scenes.quantities import STRICT, Duration
from ecume.scenes.validated import dataclass

QuantityName = Annotated[str, Field(min_length=1, max_length=100, pattern=r"^[A-Za-z0-9_]+$")]
"""The name of an array or of a number of a frame. Which names exist depends on the model and the scene."""


Interval = Annotated[int, Field(strict=True, ge=1, le=1_000_000_000)]
MOST_ROWS = 100_000_000


@dataclass(frozen=True, kw_only=True, config=STRICT)
class SamplesSpec:
    """Numbers of the whole system, such as energies and gauges, sampled between frames and averaged in blocks. A row of
    `samples.csv` in the run's directory is a block. Exactly one of `every` and `every_steps`.
    """

    every: Duration | None = None
    """The time between two samples (s). A sample is taken at the first time step at or after each multiple of it.
    Effect: shorter times resolve faster changes; each sample costs about as much as the numbers of a frame."""
    every_steps: Interval | None = None
    """The number of time steps between two samples, for models with a constant time step. Example: `10`. Effect: as
    that of `every`."""
    block: Interval = 1
    """The number of samples that are averaged in a row: mean, minimum, maximum and standard error of the mean. Example:
    `100`. Effect: larger blocks give shorter tables and smoother curves; 1 writes each sample."""
    numbers: tuple[QuantityName, ...] = ()
    """The names of the sampled numbers; by default all numbers of a frame. Example: `["kinetic_energy"]`. Effect: fewer
    numbers take less disk space."""

    @model_validator(mode="after")
    def _one_interval(self) -> Self:
        if (self.every is None) == (self.every_steps is None):
            raise Inconsistent([((), "expected exactly one of every and every_steps")])
        return self

    def faults(self, duration: float) -> Complaints:
        """Intervals that do not fit the duration of a run (s)."""
        if self.every is None:
            return []
        if self.every > duration * (1.0 + 1e-9):
            return [(("every",), f"got {self.every:.9g} s, longer than the duration, {duration:.9g} s")]
        rows = duration / self.every / self.block
        if rows > MOST_ROWS:
            return [(("every",), f"gives {rows:.3g} rows, more than {MOST_ROWS:.0e}; increase every or block")]
        return []


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
    samples: SamplesSpec | None = None
    """Numbers that are sampled between frames. Example: `{ every = "1 ms" }`. Effect: adds the file `samples.csv` to
    the run."""
