"""The parts that the scenes of all models share, with what a run writes (`[output]`) and the names of user laws.

The dataclasses are validated by pydantic; in Python they have the same messages as in scene files.
"""

from __future__ import annotations

import dataclasses
import functools
import itertools
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from decimal import Decimal
from fractions import Fraction
from typing import (
    Annotated,
    Any,
    ClassVar,
    Literal,
    NamedTuple,
    Protocol,
    Self,
    TypeVar,
    cast,
    dataclass_transform,
    overload,
)

import pydantic.dataclasses
from pydantic import ConfigDict, Field, ValidationError, model_validator

from ecume import _hooks
from ecume.errors import SceneError
from ecume.scenes.faults import Complaints, Inconsistent, as_faults, faults_of
from ecume.scenes.quantities import MOST_FRAMES, STRICT, Duration, Seed, Text
from ecume.units import Array, Quantity

Piece = TypeVar("Piece")
LONGEST_TUPLE = 4
"""The number of items of a tuple that a `repr` shows."""


@dataclass_transform(field_specifiers=(dataclasses.field, Field))
def dataclass(*, frozen: bool, kw_only: bool, config: ConfigDict) -> Callable[[type[Piece]], type[Piece]]:
    """A dataclass of pydantic whose construction raises SceneError with all faults, and whose `repr` is short."""

    def made(kind: type[Piece]) -> type[Piece]:
        decorate = pydantic.dataclasses.dataclass(frozen=frozen, kw_only=kw_only, repr=False, config=config)
        piece = cast(type[Piece], decorate(kind))
        validate = piece.__init__

        @functools.wraps(validate)
        def construct(self: Piece, **values: object) -> None:
            try:
                validate(self, **values)
            except ValidationError as error:
                name = type(self).__name__
                raise SceneError(as_faults(faults_of(error, type(self), values)), name) from None

        setattr(piece, "__init__", construct)  # noqa: B010  # a plain assignment is refused by type checkers
        if piece.__repr__ is object.__repr__:
            setattr(piece, "__repr__", _short)  # noqa: B010
        return piece

    return made


def _short(piece: object) -> str:
    """A text such as `DishSpec(radius=0.05)`: the values that differ from the defaults, long tuples by their length."""
    fields = dataclasses.fields(piece) if dataclasses.is_dataclass(piece) else ()
    given = [
        (field.name, getattr(piece, field.name)) for field in fields if getattr(piece, field.name) != field.default
    ]
    return f"{type(piece).__name__}({', '.join(f'{name}={_shown(value)}' for name, value in given)})"


def _shown(value: object) -> str:
    if isinstance(value, tuple) and len(value) > LONGEST_TUPLE:
        return f"<{len(value)} items>"
    return f"({', '.join(map(_shown, value))},)" if isinstance(value, tuple) else repr(value)


QuantityName = Annotated[str, Field(min_length=1, max_length=100, pattern=r"^[A-Za-z0-9_]+$")]
"""The name of an array or of a number of a frame; the available names depend on the model and the scene."""


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
        """The faults of sampling intervals that are not compatible with the duration of a run (s)."""
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


LawName = Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]*$", max_length=80)]
Constant = Annotated[float, Field(ge=-1e300, le=1e300)]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class UserLawSpec:
    """A user-defined law, by the name of its function."""

    law: LawName
    """The name of the function, which `--laws FILE.py` or `extra_laws` provides. Example: `"yukawa"`. Effect: adds its
    force to the scene; without the file the scene is refused."""
    species: tuple[Text, ...] = ()
    """The species that it acts on: two names for the force of a pair, one for an external force; by default all.
    Example: `["oats", "nuts"]`. Effect: other species do not feel the law."""
    constants: tuple[Constant, ...] = ()
    """The numbers that the function reads as `parameters.constants`, in SI units. Example: `[1e-8, 4e-3]`.
    Effect: they set strength and range, as the function defines."""


class Table(Protocol):
    """A dataclass, such as `DishSpec(radius=0.05)`."""

    __dataclass_fields__: ClassVar[dict[str, dataclasses.Field[Any]]]


Given = float | str | Quantity | Array | Table | Sequence["Given"] | Mapping[str, "Given"] | None
"""A value of a scene in Python: a number, text, a quantity, an array, a table, or lists and dictionaries of them."""


class Kind(NamedTuple):
    """The name of a species of particles, and its color if the scene gives one."""

    name: str
    color: str | None


# The colors of Okabe and Ito, in an order in which consecutive colors also differ in brightness.
PALETTE = ("#d55e00", "#0072b2", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#f0e442", "#5b6670")


def colors_of(kinds: Iterable[Kind]) -> list[str]:
    """The color of each species; species without a color have the next one of the palette."""
    palette = itertools.cycle(PALETTE)
    return [kind.color or next(palette) for kind in kinds]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Common:
    """The model, the duration and the frames of a scene."""

    model: str
    """The model, which determines all other keys. Effect: selects the equations that are solved."""
    title: Text = ""
    """The title of movies and figures. Effect: none on the results."""
    duration: Duration
    """The simulated time (s). Effect: run time and disk space are proportional to it."""
    frame_every: Duration
    """The simulated time between two frames (s). A duration that is no multiple of it adds a last frame at its end.
    Effect: smaller values record more frames; the time step is never longer."""
    seed: Seed = 0
    """The seed of all random numbers. Effect: another seed gives another sample of random positions and thermal
    noise; equal scenes with equal seeds give equal bits."""
    on_violation: Literal["warn", "stop"] = "warn"
    """The action when an invariant is violated: `warn`, or `stop` with exit code 3. The option `--on-violation`
    takes precedence. Effect: `stop` ends the run at the first violation."""
    output: OutputSpec = OutputSpec()
    """The quantities that are written. Effect: changes files only, never the simulation."""
    user_laws: tuple[UserLawSpec, ...] = ()
    """User-defined laws by name, each for some species. A law that is given but not listed acts on all. Effect: adds
    their forces to those of the scene."""

    @property
    def whole_frames(self) -> int:
        """The number of whole intervals `frame_every` in the duration."""
        frames = self.duration / self.frame_every
        return round(frames) if abs(frames - round(frames)) <= 1e-9 * frames else math.floor(frames)

    @property
    def rest(self) -> Fraction:
        """The time after the last whole frame, over `frame_every`: at least 0 and below 1, exact in decimals."""
        if abs(self.duration / self.frame_every - self.whole_frames) <= 1e-9 * self.whole_frames:
            return Fraction(0)
        return Fraction(repr(self.duration)) / Fraction(repr(self.frame_every)) - self.whole_frames

    @property
    def frames(self) -> int:
        """The number of frames after the first, which is at time 0."""
        return self.whole_frames + (self.rest > 0)

    def frame_time(self, number: int) -> float:
        """The time of a frame (s): `number` times `frame_every`, rounded once; for the last frame, the end of the run.

        >>> Common(model="floating", duration=0.5, frame_every=0.14).frame_time(3)
        0.42
        """
        if number == self.frames:
            return self.duration
        return float(Decimal(repr(self.frame_every)) * number)

    @property
    def numbers(self) -> frozenset[str]:
        """The names of those numbers in frames that follow from the scene alone."""
        return frozenset()

    @property
    def kinds(self) -> tuple[Kind, ...]:
        """The species in the order of their numbers in frames; empty for models without species."""
        return ()

    @overload
    def replace(self, changes: str, value: Given) -> Self: ...

    @overload
    def replace(self, changes: Mapping[str, Given]) -> Self: ...

    def replace(self, changes: str | Mapping[str, Given], value: Given = None) -> Self:
        """A scene with another value at a path, `scene.replace("dish.radius", "6 cm")`, or with several such changes.

        Values that are not given in the scene follow from the new ones. Raises SceneError with all faults at once.
        """
        given = {changes: value} if isinstance(changes, str) else changes
        return cast(Self, _hooks.changed_scene((self, given)))

    def __repr__(self) -> str:
        """A text such as `FloatingScene('A bowl of cereal', 12 s, 151 frames, 40 cereals)`."""
        numbers = [getattr(one, "count", None) or len(one.positions) for one in getattr(self, "particles", ())]
        species = [f"{count} {kind.name}" for count, kind in zip(numbers, self.kinds, strict=False)]
        rows = [f"{count} rows"] if (count := len(getattr(self, "rows", ()))) else []
        title = [repr(self.title)] if self.title else []
        parts = [*title, f"{self.duration:.6g} s", f"{self.frames + 1} frames", *species, *rows]
        return f"{type(self).__name__}({', '.join(parts)})"

    @model_validator(mode="after")
    def _not_too_many_frames(self) -> Self:
        frames = self.duration / self.frame_every
        if frames > MOST_FRAMES * (1 + 1e-9):
            raise Inconsistent([(("frame_every",), f"gives {frames:.3g} frames, more than {MOST_FRAMES:.0e}")])
        if self.output.samples is not None and (found := self.output.samples.faults(self.duration)):
            raise Inconsistent([(("output", "samples", *path), message) for path, message in found])
        if frames < 1 - 1e-9:
            message = f"got {self.frame_every:.9g} s, longer than the duration, {self.duration:.9g} s"
            raise Inconsistent([(("frame_every",), message)])
        return self
