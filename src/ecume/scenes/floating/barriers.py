"""A barrier: a side of a rectangular dish that moves, or a wall that closes from all sides."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from ecume.scenes.common import dataclass
from ecume.scenes.faults import Complaints, Inconsistent
from ecume.scenes.quantities import STRICT, Amplitude, PositiveTension, Switch, Velocity
from ecume.units import Time

Instant = Annotated[Time, Field(ge=0.0, le=1e10)]
Instants = Annotated[tuple[Instant, ...], Field(max_length=100_000)]
Advances = Annotated[tuple[Amplitude, ...], Field(max_length=100_000)]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class BarrierSpec:
    """A side of a rectangular dish that moves along its normal, as the barrier of a Langmuir trough, or the whole wall
    of a dish of any shape, as an iris.
    """

    side: Literal["left", "right", "bottom", "top", "all"] = "right"
    """The side of the dish that is the barrier: one of a rectangle, or `all`, the whole wall of a dish of any shape,
    which closes toward the middle. Effect: determines the direction in which floats are compressed."""
    both: Switch = False
    """Whether the opposite side moves alike, toward the barrier. Effect: compresses the floats from two sides."""
    velocity: Velocity | None = None
    """The velocity of the barrier (m/s), positive into the dish; either this, or `times` and `positions`. Example:
    `"1 mm/s"`. Effect: floats in front of the barrier move with it, and their drag presses on it."""
    start: Amplitude = 0.0
    """The distance of the barrier from its side of the dish at the start (m). Example: `"1 cm"`. Effect: floats start
    in the part of the dish that is left."""
    stop: Amplitude | None = None
    """The distance from its side at which the barrier stops (m); by default it does not. Example: `"4 cm"`. Effect:
    floats then relax at a constant area."""
    times: Instants = ()
    """Instants (s) in ascending order, for a barrier that follows a table; it is at rest before the first and after
    the last. Example: `["0 s", "20 s", "40 s"]`. Effect: sets when the barrier moves."""
    positions: Advances = ()
    """The distance of the barrier from its side at each of the `times` (m), with a constant velocity between them.
    Example: `["0 cm", "3 cm", "0 cm"]`. Effect: the barrier compresses and expands the floats."""
    largest_pressure: PositiveTension | None = None
    """The surface pressure at which the barrier stops for good (N/m); by default that at which a raft buckles.
    Example: `"20 mN/m"`. Effect: a raft of hard floats that is packed is not compressed further."""

    @model_validator(mode="after")
    def _one_motion(self) -> Self:
        both = [(("both",), "got true with side = 'all', which moves every side")] if self.closes and self.both else []
        if complaints := [*both, *_of_table(self), *_of_velocity(self)]:
            raise Inconsistent(complaints)
        return self

    @property
    def closes(self) -> bool:
        """Whether the whole wall moves toward the middle."""
        return self.side == "all"


def _of_table(barrier: BarrierSpec) -> Complaints:
    times, positions = barrier.times, barrier.positions
    if len(times) != len(positions):
        return [(("positions",), f"got {len(positions)} of them and {len(times)} times; expected as many")]
    if len(times) == 1:
        return [(("times",), "got one instant; expected two or more")]
    falls = next((k for k, (one, after) in enumerate(pairwise(times), 1) if not one < after), None)
    if falls is not None:
        got = f"got {times[falls]:g} s after {times[falls - 1]:g} s; expected times that ascend"
        return [(("times", falls), got)]
    return []


def _of_velocity(barrier: BarrierSpec) -> Complaints:
    if (barrier.velocity is None) == (not barrier.times):
        got = "got none of them" if barrier.velocity is None else "got both"
        return [(("velocity",), f"{got}; expected either velocity, or times and positions")]
    if barrier.velocity is None:
        own = [("start", barrier.start != 0.0), ("stop", barrier.stop is not None)]
        return [((key,), "belongs to velocity; the table says where the barrier is") for key, given in own if given]
    way = 0.0 if barrier.stop is None else barrier.stop - barrier.start
    if way * barrier.velocity < 0.0 or (way != 0.0 and barrier.velocity == 0.0):
        got = f"got {barrier.stop:g} m, which the barrier never reaches; it starts at {barrier.start:g} m"
        return [(("stop",), got)]
    if barrier.velocity < 0.0 and barrier.start == 0.0:
        got = f"got {barrier.velocity:g} m/s, out of the dish, from the side itself; expected a positive velocity"
        return [(("velocity",), f"{got}, or a start inside the dish")]
    return []
