"""The length of time steps: attempts until the error is small enough, then a PI controller.

These functions are plain Python here; for pages they are compiled. See `web/wasm`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ecume.engine.cells import Integers
from ecume.models.soft.integration.dirk import FAILED as NOT_SOLVED
from ecume.models.soft.integration.dirk_schemes import LOOSE, SCHEMES, Scheme, error_of_run
from ecume.models.soft.parameters import Parameters
from ecume.models.soft.protocol import Drive, Protocol, drive_at, interval_at, next_turn
from ecume.models.soft.report.energy_budget import DRAG, FILMS, INJECTED, SIZE
from ecume.models.soft.state import ACCEPTED, CLOCK, FAILED, LENGTH, PAST_ERROR, REJECTED
from ecume.units import Array

SAFETY = 0.9
MOST_GROWTH, MOST_SHRINK = 5.0, 0.2
AFTER_FAILURE = 0.25
"""The factor of the next time step after the equations of a step could not be solved."""
LEAST_ERROR = 1e-8
MOST_TRIES = 60
"""The number of attempts of a step, each with a shorter time step, before the run ends."""
LEAST_PER_CYCLE, COARSE = 20, 1e-3
"""The least number of time steps per cycle of an oscillation, at tolerances of COARSE or more. A sine is then as
accurate as the gaps.
"""
PER_AGE = 16.0
"""The longest step over the time since a jump is (PER_AGE tolerance)^(1/(p + 1)). After a jump films relax at all
rates. The widest relax first; their gaps change little, so that the error of gaps does not limit the error of the work.
"""
PART_OF_RUN = 0.01
"""The residual of the energy budget of a step is compared with the energy exchanged in the step plus PART_OF_RUN times
that exchanged in the run.
"""
SHRINK_FOR_WORK = 0.01, 0.5
"""The least and the largest factor of the length of a step whose energy budget has too large a residual."""
LEAST_WORK = 1e-14
"""The rounding error of a work, over modulus times radius cubed, summed over the spheres."""
NEARLY = 1e-9
"""A step that would end before a frame or corner by less than this fraction of its length is extended to it."""


IMPOSED = len(Drive._fields)


class Control(NamedTuple):
    """The quantities that determine the length of a step, in addition to the state; fields as in `Parameters`."""

    protocol: Protocol
    time_step: float
    steps_per_frame: int
    end: float
    last_tick: int
    tolerance: float
    scheme: Scheme


class Pace(NamedTuple):
    """The part of a state that the length of a step depends on, by the names of `State`."""

    pace: Array
    tally: Integers
    step: Integers


class Accepted(NamedTuple):
    """A step whose error is small enough."""

    length: float
    """s; zero without one"""
    end: float
    ratio: float
    """its error over the tolerance"""


def control_of(parameters: Parameters) -> Control:
    """The control of a run."""
    return Control(
        parameters.protocol, parameters.time_step, parameters.steps_per_frame, parameters.end, parameters.last_tick,
        parameters.tolerance, SCHEMES[parameters.scheme].tableau,
    )  # fmt: skip


def shortened_until_exact(
    attempt: Callable[[Any, float, float], float],
    shortening: Callable[[Any], float],
    given: Any,
    control: Control,
    now: Pace,
) -> Accepted:
    """Repeat a step with shorter time steps until its error is small enough. `attempt(given, length, end)` returns the
    error; `shortening(given)` returns 1, or the factor of the length if the step must be repeated for another reason.
    """
    pace, tally, order = now.pace, now.tally, control.scheme.order
    for _ in range(MOST_TRIES):
        length, end = next_step(control, now)
        if not end > pace[CLOCK]:
            break
        error = attempt(given, length, end)
        ratio = max(error / control.tolerance, LEAST_ERROR)
        if error == NOT_SOLVED or not math.isfinite(error):
            pace[LENGTH] = AFTER_FAILURE * length
            tally[FAILED] += 1
        elif ratio > 1.0:
            pace[LENGTH] = length * max(MOST_SHRINK, SAFETY * ratio ** (-1.0 / order))
            tally[REJECTED] += 1
        else:
            part = shortening(given)
            if part == 1.0:
                return Accepted(length, end, ratio)
            pace[LENGTH] = part * length
            tally[REJECTED] += 1
    return Accepted(0.0, 0.0, 0.0)


def go_to_end(control: Control, now: Pace, step: Accepted) -> None:
    """Set the clock to the end of a step, and the length of the next one."""
    pace = now.pace
    pace[CLOCK] = step.end
    now.tally[ACCEPTED] += 1
    now.step[0] = _tick(control, int(now.step[0]), step.end)
    # The error of a step that ends early at a frame does not limit the next step.
    kept = pace[LENGTH] if step.length < pace[LENGTH] else 0.0
    pace[LENGTH] = max(_grown(pace, step, control.scheme.order), kept)
    pace[PAST_ERROR] = step.ratio


def drives_of(control: Control, start: float, length: float, end: float) -> Array:
    """The imposed values at each stage of a step; if the protocol jumps at its end, those before the jump."""
    times, interval = control.scheme.times, interval_at(control.protocol, start)
    found = np.empty((len(times), IMPOSED))
    for stage in range(len(times)):
        at = end if stage == len(times) - 1 else start + times[stage] * length
        drive = drive_at(control.protocol, at, interval)
        for k in range(len(drive)):
            found[stage, k] = drive[k]
    return found


def work_scale(parameters: Parameters) -> tuple[float, float]:
    """The accuracy of the energy budget of a run, and the sum of modulus times radius cubed (J)."""
    stiff = float((parameters.modulus * parameters.radius**3).sum())
    return error_of_run(parameters.scheme, parameters.tolerance) / LOOSE, stiff


def missing_work(line: Array, grown: float, spent: float, scale: tuple[float, float]) -> float:
    """The residual of the energy budget of a step over its limit: injected work minus the dissipation by films and
    drag, the work on sizes and the increase of stored energy. `spent` is the energy that the run has dissipated, with
    the stake of the step; `scale` is that of `work_scale`.

    After a film has opened, or a load has started, forces relax much faster than gaps change. Gaps are then exact to
    the tolerance, but the power at the stages does not represent that of the step.
    """
    dissipated = line[FILMS] + line[DRAG]
    missing = abs(line[INJECTED] - dissipated - line[SIZE] - grown)
    if not math.isfinite(missing):
        return math.inf
    moved = abs(dissipated) + abs(grown) + PART_OF_RUN * spent
    return float(missing / (scale[0] * moved + LEAST_WORK * scale[1]))


def for_work(excess: float) -> float:
    """The factor by which a step is shortened if the residual of its energy budget, over its limit, is `excess`."""
    return min(max(SAFETY / excess, SHRINK_FOR_WORK[0]), SHRINK_FOR_WORK[1])


def _grown(pace: Array, step: Accepted, order: int) -> float:
    """The length of the next step, from the errors of this step and the previous one (a PI controller)."""
    past = float(pace[PAST_ERROR]) if pace[PAST_ERROR] != 0.0 else 1.0
    growth = SAFETY * step.ratio ** (-0.7 / order) * past ** (0.4 / order)
    return float(step.length * min(MOST_GROWTH, max(MOST_SHRINK, growth)))


def _due(control: Control, frame: int) -> float:
    """The time of a frame (s); that of the last is the end of the run."""
    return min(frame * control.steps_per_frame * control.time_step, control.end)


def _tick(control: Control, before: int, time: float) -> int:
    """The tick of a time; between two frames it is never equal to that of a frame."""
    frame = before // control.steps_per_frame
    first, last = frame * control.steps_per_frame, (frame + 1) * control.steps_per_frame
    if control.end < math.inf:
        last = min(last, control.last_tick)
    if time == _due(control, frame + 1):
        return last
    return min(max(int(time / control.time_step), before, first + 1), last - 1)


def _longest(control: Control, now: float) -> float:
    """The longest next step (s): a part of a cycle during oscillations, which the error of films does not predict.
    After a jump, or a start under a stress, it is also limited to a part of the time since then.
    """
    protocol, interval = control.protocol, interval_at(control.protocol, now)
    pace, age = float(protocol.waves[interval, 2]), now - float(protocol.times[interval])
    cycle = math.tau / pace / steps_per_cycle(control) if pace > 0.0 else math.inf
    leaps = protocol.jumps[interval] and (interval > 0 or protocol.rules[interval].any())
    return min(cycle, step_per_age(control) * age) if leaps and age > 0.0 else cycle


def step_per_age(control: Control) -> float:
    """The longest step after a jump, over the time since the jump."""
    return float((PER_AGE * control.tolerance) ** (1.0 / (control.scheme.order + 1.0)))


def steps_per_cycle(control: Control) -> float:
    """The minimum number of steps per cycle, proportional to tolerance^(-1/(p + 1)) for a scheme of order p."""
    return float(LEAST_PER_CYCLE * max(COARSE / control.tolerance, 1.0) ** (1.0 / (control.scheme.order + 1.0)))


def next_step(control: Control, now: Pace) -> tuple[float, float]:
    """The length of the next step and the time of its end, at most that of the next frame or corner of the protocol."""
    clock = float(now.pace[CLOCK])
    due = _due(control, int(now.step[0]) // control.steps_per_frame + 1)
    stop = min(due, next_turn(control.protocol, clock))
    length = min(float(now.pace[LENGTH]), _longest(control, clock))
    if clock + length * (1.0 + NEARLY) >= stop:
        return stop - clock, stop
    return length, clock + length
