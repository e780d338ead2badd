"""The protocol of a deformation: a table of moments."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Sequence
from typing import Annotated, NamedTuple, Self

from pydantic import Field, PlainValidator, model_validator

from ecume.scenes.common import dataclass
from ecume.scenes.faults import Complaints, Inconsistent, Path
from ecume.scenes.quantities import STRICT, ByDimension
from ecume.units import Number, Rate, Time

Instant = Annotated[Time, Field(ge=0.0, le=1e10)]
Factor = Annotated[Number, Field(ge=-1e9, le=1e9)]
Scale = Annotated[Number, Field(ge=1e-3, le=1e3)]
Frequency = Annotated[Rate, Field(gt=0.0, le=1e9)]
StationaryWithin = Annotated[Number, Field(gt=0.0, le=1.0)]
HeldStrain = Annotated[Number, Field(gt=0.0, le=1e6)]
StrainRate = Annotated[Rate, Field(ge=-1e9, le=1e9)]

MOST_STRESS = 1e15
SAME = 1e-12
"""The relative difference below which times are equal."""
WHOLE = 1e-9
"""The largest deviation of a number of cycles from an integer."""


STRESS = ByDimension("N/m", "Pa")
"""The units of stresses: in a layer, a force per length."""


def stress(value: object) -> float:
    """A stress in Pa, or in N/m for a layer, depending on the dimension of the scene; a plain number has no unit."""
    number = STRESS.number(value)
    if not abs(number) <= MOST_STRESS:
        raise ValueError(f"expected a number between {-MOST_STRESS:g} and {MOST_STRESS:g}")
    return number


Stress = Annotated[float, PlainValidator(stress), STRESS]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class OscillationSpec:
    """A sine added to the shear of a moment until the next moment."""

    frequency: Frequency
    """The frequency in cycles per second (1/s). Effect: faster oscillations meet a more viscous response."""
    amplitude: Factor | None = None
    """The amplitude of the strain, where a strain or a rate is imposed. Effect: larger strains leave the linear
    response."""
    stress: Stress | None = None
    """The amplitude of the shear stress, where a stress is imposed (Pa; N/m in 2D). Example: `"1 Pa"`. Effect:
    larger stresses leave the linear response."""

    @model_validator(mode="after")
    def _one(self) -> Self:
        if (self.amplitude is None) == (self.stress is None):
            raise Inconsistent([((), "expected either amplitude, of the strain, or stress")])
        return self


@dataclass(frozen=True, kw_only=True, config=STRICT)
class RateStepsSpec:
    """Shear rates one after the other, from the moment on, each up to the same strain or until the stress is
    stationary: the steps of a flow curve.
    """

    rates: Annotated[tuple[StrainRate, ...], Field(min_length=1)]
    """The shear rates in their order (1/s), none of them 0. The last one continues; with `stationary_within` the strain
    is held instead. Example: `[10.0, 1.0, 0.1]`. Effect: each is a point of the flow curve."""
    strain: HeldStrain
    """The strain for which each rate is held; with `stationary_within`, the largest one. Example: `10.0`. Effect:
    larger strains leave more of the steady state after the transient."""
    stationary_within: StationaryWithin | None = None
    """The standard error of the mean shear stress, over this mean, at which a stationary rate has been held for long
    enough; the next rate then begins. Omitted, each rate is held for the whole strain. Example: `0.05`. Effect:
    smaller values hold each rate for longer."""

    @model_validator(mode="after")
    def _moving(self) -> Self:
        still = [place for place, rate in enumerate(self.rates) if rate == 0.0]
        if still:
            cause = "got 0, which reaches no strain; expected a rate"
            raise Inconsistent([(("rates", place), cause) for place in still])
        return self

    @property
    def spans(self) -> tuple[float, ...]:
        """The duration of each rate (s)."""
        return tuple(self.strain / abs(rate) for rate in self.rates)

    @property
    def strides(self) -> tuple[int, ...]:
        """Of how many frames at each rate one is tested: see `stride`."""
        fastest = max(map(abs, self.rates))
        return tuple(stride(fastest, abs(rate)) for rate in self.rates)


def stride(fastest: float, speed: float) -> int:
    """Of how many frames at this rate one is tested, so that all rates are tested at about the same strains."""
    return max(round(fastest / speed), 1)


EXCLUSIVE = (
    ("shear_rate", "shear_stress", "rate_steps"),
    ("oscillation", "rate_steps"),
    ("height_rate", "normal_stress", "pressure"),
)
"""Groups of keys of which a moment may contain only one."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class StageSpec:
    """A moment of the protocol. Load, wall shear, strain and scale change linearly from the previous moment to this
    one; rates and stresses apply from it on. Omitted quantities do not change. A repeated time is a jump.
    """

    time: Instant
    """The instant (s); a time given twice is a jump. Effect: shifts the instant at which the values are reached."""
    load: Factor | None = None
    """The factor of the external forces on spheres, reached at this time; initially 1. Effect: scales all forces,
    torques, pressures and stresses."""
    wall_shear: Factor | None = None
    """The additional factor of the shear stresses of walls, reached at this time; initially 1. Effect: scales the
    shear at constant pressure."""
    strain: Factor | None = None
    """The shear strain of the cell along x, reached at this time. Effect: shears the packing."""
    shear_rate: StrainRate | None = None
    """The shear rate from this time on (1/s); 0 holds the strain. Effect: faster shear increases the viscous stress."""
    rate_steps: RateStepsSpec | None = None
    """Shear rates one after the other from this time on. Effect: one run gives several points of a flow curve."""
    shear_stress: Stress | None = None
    """The shear stress from this time on (Pa; N/m in 2D), positive where the top is pulled along x; the strain
    follows. Example: `"10 Pa"`. Effect: above the yield stress the packing flows."""
    oscillation: OscillationSpec | None = None
    """A sine in addition to the shear, up to the next instant. Effect: adds an oscillating strain or stress."""
    scale: Scale | None = None
    """The factor of the sides of the cell, reached at this time. Effect: below 1 the packing is compressed."""
    height_rate: StrainRate | None = None
    """The rate of ln(height of the cell) from this time on (1/s); 0 holds the height. Effect: negative values
    compress the packing along y."""
    normal_stress: Stress | None = None
    """The normal stress at top and bottom from this time on (Pa; N/m in 2D), positive in compression; the height
    follows. Example: `"100 Pa"`. Effect: higher stresses compress the packing along y."""
    pressure: Stress | None = None
    """The mean normal stress from this time on (Pa; N/m in 2D), positive in compression; all sides change in
    proportion.
    Example: `"100 Pa"`. Effect: higher pressures compress the packing."""

    @model_validator(mode="after")
    def _one_each(self) -> Self:
        found = [complaint for names in EXCLUSIVE for complaint in self._too_many(names)]
        if found:
            raise Inconsistent(found)
        return self

    def _too_many(self, names: Sequence[str]) -> Complaints:
        given = [name for name in names if getattr(self, name) is not None]
        if len(given) < 2:
            return []
        cause = f"given together with {given[0]}; expected one of {', '.join(names)}: the others follow"
        return [((name,), cause) for name in given[1:]]


OF_BOX = (
    "strain", "shear_rate", "rate_steps", "shear_stress", "oscillation", "scale", "height_rate", "normal_stress",
    "pressure",
)  # fmt: skip
STRESSES = ("shear_stress", "normal_stress", "pressure")


def steps_of(stage: StageSpec) -> tuple[StageSpec, ...]:
    """The moments that replace a moment with several shear rates, one for each rate."""
    steps = stage.rate_steps
    if steps is None:
        return (stage,)
    begins = itertools.accumulate(steps.spans, initial=stage.time)
    rates = steps.rates if steps.stationary_within is None else (*steps.rates, 0.0)
    first, *others = (StageSpec(time=time, shear_rate=rate) for time, rate in zip(begins, rates, strict=False))
    return (dataclasses.replace(stage, rate_steps=None, shear_rate=first.shear_rate), *others)


def expanded(stages: Sequence[StageSpec]) -> tuple[StageSpec, ...]:
    """A protocol with each rate of `rate_steps` as a moment. Rates that end when the stress is stationary count with
    the largest strain.
    """
    return tuple(step for stage in stages for step in steps_of(stage))


class Wait(NamedTuple):
    """What ends a moment of the expanded protocol before the next one."""

    group: int
    """the index of the moment whose rates these are; -1 where nothing does"""
    within: float
    """see `RateStepsSpec.stationary_within`"""


NO_WAIT = Wait(-1, 0.0)


def waits_of(stages: Sequence[StageSpec]) -> tuple[Wait, ...]:
    """What ends each moment of the expanded protocol."""
    found = []
    for index, stage in enumerate(stages):
        steps = stage.rate_steps
        if steps is None or steps.stationary_within is None:
            found += [NO_WAIT] * len(steps_of(stage))
        else:
            found += [Wait(index, steps.stationary_within)] * len(steps.rates) + [NO_WAIT]
    return tuple(found)


def known_moments(stages: Sequence[StageSpec]) -> tuple[float, ...]:
    """The times (s) of the expanded protocol that do not depend on the run."""
    steps = zip(expanded(stages), (NO_WAIT, *waits_of(stages)), waits_of(stages), strict=False)
    return tuple(step.time for step, before, wait in steps if wait.group < 0 or wait.group != before.group)


def waits(stages: Sequence[StageSpec]) -> bool:
    """Whether any rate of a protocol is held until the stress is stationary."""
    return any(wait.group >= 0 for wait in waits_of(stages))


def end_of(stage: StageSpec) -> float:
    """The time (s) at which the last of the rates of a moment ends; without `rate_steps` its own time."""
    return stage.time + (0.0 if stage.rate_steps is None else sum(stage.rate_steps.spans))


def protocol_faults(stages: Sequence[StageSpec], dimensions: int, boxed: bool) -> Complaints:
    """The faults of a protocol, moment by moment."""
    found: Complaints = [
        ((index, "time"), f"got {later.time:g} s, before {earlier.time:g} s; expected times that ascend")
        for index, (earlier, later) in enumerate(itertools.pairwise(stages), 1)
        if later.time < earlier.time * (1.0 - SAME)
    ]
    for index, stage in enumerate(stages):
        given = [name for name in OF_BOX if getattr(stage, name) is not None]
        if given and not boxed:
            cause = "is that of a [cell] without walls; walls have a pressure, a shear_stress and a velocity"
            found += [((index, name), cause) for name in given]
        found += [((index, *path), cause) for path, cause in _wrong_units(stage, dimensions)]
    found = found or [*_short_steps(stages), *_unknown_strains(stages)]
    if found:
        return found
    origin = [index for index, stage in enumerate(stages) for _ in steps_of(stage)]
    steps = expanded(stages)
    beside = [*_unreachable(steps), *_broken_waves(steps)]
    return [((origin[int(place)], *path), cause) for (place, *path), cause in beside]


def _short_steps(stages: Sequence[StageSpec]) -> Complaints:
    """The faults of moments that begin before the rates of the previous moment end."""
    return [
        ((index, "time"), f"got {later.time:g} s; the rate_steps of the moment before end at {end_of(earlier):g} s")
        for index, (earlier, later) in enumerate(itertools.pairwise(stages), 1)
        if later.time < end_of(earlier) * (1.0 - WHOLE)
    ]


def _unknown_strains(stages: Sequence[StageSpec]) -> Complaints:
    """The faults of strains to be reached after rates that end at a strain which only the run knows."""
    return [
        (
            (index, "strain"),
            "is unknown after rates with stationary_within, which end early; expected shear_rate, or no strain",
        )
        for index, stage in enumerate(stages)
        if stage.strain is not None and waits(stages[:index])
    ]


def _wrong_units(stage: StageSpec, dimensions: int) -> Complaints:
    given: list[tuple[Path, float | None]] = [((name,), getattr(stage, name)) for name in STRESSES]
    if stage.oscillation is not None:
        given.append((("oscillation", "stress"), stage.oscillation.stress))
    return [(path, fault) for path, value in given if (fault := STRESS.fault(value, dimensions))]


def _unreachable(stages: Sequence[StageSpec]) -> Complaints:
    """The faults of strains and scales in moments after one in which another quantity is controlled."""
    found: Complaints = []
    sheared, sized = "", ""
    for index, stage in enumerate(stages):
        if stage.strain is not None and sheared:
            cause = (
                f"cannot be reached while {sheared}; expected shear_rate, 0 to hold, and strain only where it is known"
            )
            found.append(((index, "strain"), cause))
        if stage.scale is not None and sized:
            found.append(((index, "scale"), f"cannot be reached while {sized}; expected height_rate, 0 to hold"))
        if stage.shear_stress is not None:
            sheared = "the strain has answered to a shear_stress"
        elif stage.shear_rate is not None and not sheared.endswith("stress"):
            sheared = "a shear_rate rules" if stage.shear_rate != 0.0 else ""
        if stage.normal_stress is not None or stage.pressure is not None:
            sized = "the box has answered to a stress"
        elif stage.height_rate and not sized:
            sized = "a height_rate rules"
    return found


def _broken_waves(stages: Sequence[StageSpec]) -> Complaints:
    found: Complaints = []
    stressed = False
    for index, stage in enumerate(stages):
        if stage.shear_stress is not None or stage.shear_rate is not None:
            stressed = stage.shear_stress is not None
        wave = stage.oscillation
        if wave is None:
            continue
        if stressed and wave.stress is None:
            found.append(((index, "oscillation", "amplitude"), "shear_stress is imposed; expected oscillation.stress"))
        if not stressed and wave.amplitude is None:
            found.append(((index, "oscillation", "stress"), "no shear_stress is imposed; expected it, or amplitude"))
        if index + 1 < len(stages):
            cycles = wave.frequency * (stages[index + 1].time - stage.time)
            if abs(cycles - round(cycles)) > WHOLE * max(cycles, 1.0):
                cause = (
                    f"makes {cycles:g} cycles until the next moment; expected a whole number, or the strain would jump"
                )
                found.append(((index, "oscillation", "frequency"), cause))
    return found
