"""Shear rates that are held until the stress is stationary: which of them have ended, and the protocol that follows.

The criterion is that of `ecume.engine.stationarity`, on the shear stress and the normal stress at frames: at all frames
of the fastest rate of a moment, and at as many per strain of the slower ones. The state contains these stresses and the
times at which rates ended, so that a resumed run ends rates at the same frames.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ecume.engine.cells import Integers
from ecume.engine.stationarity import is_stationary, is_tested
from ecume.models.soft.protocol import STRAIN, Protocol, at_frames
from ecume.scenes.soft.protocol import SAME, stride
from ecume.units import Array

RUNNING, UNSETTLED, STATIONARY = range(3)
"""What `Waiting.reached` says of a rate: it has not ended, or has reached its largest strain, or has become stationary.
"""


class Waiting(NamedTuple):
    """The rates that are held until the stress is stationary, in a state."""

    ends: Array
    """(W,) s: the time at which each of them ended"""
    reached: Integers
    """(W,) one of `RUNNING`, `UNSETTLED`, `STATIONARY`"""
    stresses: Array
    """(F, 2) the shear stress and the normal stress at the frames at which the current rate is tested; the rest is zero
    """
    frames: Integers
    """(1,) the number of frames of the current rate"""


def rates_of(protocol: Protocol) -> Integers:
    """(W,) the intervals that end when the stress is stationary."""
    return np.flatnonzero(protocol.groups >= 0)


def strides_of(protocol: Protocol) -> Integers:
    """(W,) of how many frames one is tested: all rates of a moment are tested at about the same strains."""
    rates = rates_of(protocol)
    speed, group = np.abs(protocol.courses[rates, STRAIN, 1]), protocol.groups[rates]
    fastest = [float(speed[group == own].max()) for own in group]
    return np.array([stride(most, own) for most, own in zip(fastest, speed.tolist(), strict=True)], np.int64)


def make_waiting(protocol: Protocol, frame_every: float) -> Waiting:
    """The state at time 0."""
    rates = rates_of(protocol)
    spans = (protocol.times[rates + 1] - protocol.times[rates]) / strides_of(protocol)
    most = math.ceil(float(spans.max(initial=0.0)) / frame_every) + 1 if len(rates) else 0
    return Waiting(
        np.zeros(len(rates)),
        np.zeros(len(rates), np.int64),
        np.zeros((most, 2)),
        np.zeros(min(len(rates), 1), np.int64),
    )


def shortened(protocol: Protocol, waiting: Waiting) -> Protocol:
    """The protocol after some of its rates have ended early: the next one begins there, and after the last one of a
    moment the strain is held until the next moment.
    """
    order = {int(place): rate for rate, place in enumerate(rates_of(protocol))}
    early, lost = 0.0, 0.0
    times, courses, places = list[float](), list[Array](), list[int]()

    def reached(now: float) -> Array:
        return np.asarray(courses[-1][:, 0] + courses[-1][:, 1] * (now - times[-1]))

    for place, start in enumerate(map(float, protocol.times)):
        course, before = protocol.courses[place].copy(), int(protocol.groups[place - 1]) if place else -1
        if early > 0.0 and int(protocol.groups[place]) != before:
            held = courses[-1].copy()
            held[:, 0], held[STRAIN, 1] = reached(start - early), 0.0
            times, courses, places = [*times, start - early], [*courses, held], [*places, -1]
            early = 0.0
        course[STRAIN, 0] -= lost
        if early > 0.0:
            course[:, 0] = reached(start - early)
        times, courses, places = [*times, start - early], [*courses, course], [*places, place]
        rate = order.get(place)
        if rate is not None and waiting.reached[rate] == STATIONARY:
            planned, end = float(protocol.times[place + 1]) - early, float(waiting.ends[rate])
            if end < planned * (1.0 - 2.0 * SAME):
                early += planned - end
                lost += float(course[STRAIN, 1]) * (planned - end)
    return _rows(protocol, np.array(places))._replace(times=np.array(times), courses=np.array(courses))


def _rows(protocol: Protocol, places: Integers) -> Protocol:
    """The intervals with these indices; -1 is one without waves and jumps, with the rules of the one before."""
    held = places < 0
    rules = np.where(held, np.roll(places, 1), places)
    return protocol._replace(
        waves=np.where(held[:, None], 0.0, protocol.waves[places]),
        rules=protocol.rules[rules],
        jumps=np.where(held, 0, protocol.jumps[places]),
        groups=np.where(held, -1, protocol.groups[places]),
        within=np.where(held, 0.0, protocol.within[places]),
    )


def interval_before(protocol: Protocol, time: float) -> int:
    """The interval that contains a time; at a corner, to rounding, the earlier one."""
    return max(int(np.searchsorted(protocol.times, time * (1.0 - SAME), side="left")) - 1, 0)


def rate_at(protocol: Protocol, time: float) -> int:
    """The rate, of those that wait, to which a frame at this time belongs, counted from 1; 0 for none."""
    place = interval_before(protocol, time)
    return int((protocol.groups[: place + 1] >= 0).sum()) if protocol.groups[place] >= 0 else 0


def take(waiting: Waiting, protocol: Protocol, time: float, stresses: tuple[float, float]) -> None:
    """Add the stresses of a frame to those of its rate, and end the rate if they are stationary, or at the largest
    strain. `protocol` is the present one.
    """
    rates = rates_of(protocol)
    _end_until(waiting, protocol, int((protocol.times[rates + 1] <= time * (1.0 - SAME)).sum()))
    rate = rate_at(protocol, time) - 1
    if rate < 0:
        return
    waiting.frames[0] += 1
    count, past = divmod(int(waiting.frames[0]), int(strides_of(protocol)[rate]))
    if past == 0:
        waiting.stresses[count - 1] = stresses
    end = float(protocol.times[rates[rate] + 1])
    at_end = end <= time * (1.0 + SAME)
    if at_end or (past == 0 and is_tested(count)):
        shear, normal = waiting.stresses[:count].T
        if is_stationary(shear, float(protocol.within[rates[rate]])) and is_stationary(normal):
            waiting.reached[rate], waiting.ends[rate] = STATIONARY, end if at_end else time
            _forget(waiting)
            return
    if at_end:
        _end_until(waiting, protocol, rate + 1)


def _end_until(waiting: Waiting, protocol: Protocol, count: int) -> None:
    """End all of the first rates that have not, at their largest strain."""
    for rate, place in enumerate(rates_of(protocol)[:count]):
        if waiting.reached[rate] == RUNNING:
            waiting.reached[rate], waiting.ends[rate] = UNSETTLED, protocol.times[place + 1]
            _forget(waiting)


def _forget(waiting: Waiting) -> None:
    """Remove the stresses of a rate that has ended."""
    waiting.stresses[:], waiting.frames[:] = 0.0, 0


def present(protocol: Protocol, waiting: Waiting, frames: tuple[int, float, float]) -> Protocol:
    """The protocol with the rates that have ended early; `frames` are the last arguments of `at_frames`."""
    if not (waiting.reached == STATIONARY).any():
        return protocol
    return at_frames(shortened(protocol, waiting), *frames)
