"""Rheology of packings: stress, viscosity, friction and moduli of sheared boxes, and delays before yielding."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ecume.analysis.boxes import Integers
from ecume.analysis.series import Mean, number, series, steady_mean, times
from ecume.errors import BadInput
from ecume.trajectories.frame import Frame
from ecume.units import Array, Number, Pressure, Rate, Time, Viscosity

AXES = "xyz"
FEWEST = 10
"""Instants in a period: with fewer, harmonics are taken for one another."""
PARTS = ("squeeze", "sliding", "remote")
"""What the stress is made of: films squeezed, films sheared, and what acts across them. The surfaces' elastic
deflections carry the sum of the three, being in series with them."""


def stress_tensor(frame: Frame, part: str = "total") -> Array:
    """The stress of a box, (d, d), tension positive; Pa, in a layer N/m. `part` is one of PARTS.

    Its component xy is the force along x across planes of y. Where spheres do not spin it need not be that of yx.
    """
    dimensions = frame.arrays["position"].shape[1]
    tensor = np.zeros((dimensions, dimensions))
    parts = (part,) if part != "total" else tuple(one for one in PARTS if f"stress_{one}_xx" in frame.numbers)
    if not parts or any(f"stress_{one}_xx" not in frame.numbers for one in parts):
        raise BadInput(f"the frames contain no stress {part!r}; expected total, or one of {', '.join(PARTS)}")
    for one in parts:
        for i, j in np.ndindex(dimensions, dimensions):
            tensor[i, j] += frame.numbers[f"stress_{one}_{AXES[i]}{AXES[j]}"]
    return tensor


def normal_stress_differences(frame: Frame, part: str = "total") -> tuple[float, float]:
    """N_1 = s_xx - s_yy and N_2 = s_yy - s_zz, x along the flow and y across, tension positive; N_2 = 0 in a layer."""
    normal = np.diag(stress_tensor(frame, part))
    return float(normal[0] - normal[1]), float(normal[1] - normal[2]) if len(normal) == 3 else 0.0


def shear_rates(frames: Sequence[Frame]) -> Array:
    """The rate of shear between the frames around each, (T,) 1/s."""
    if len(frames) < 2:
        raise BadInput("a rate takes two frames or more")
    (strain,) = series(frames, number("strain"))
    return np.asarray(np.gradient(strain, times(frames)))


class FlowPoint(NamedTuple):
    """A steady flow, each with its standard error."""

    rate: Mean
    """1/s"""
    shear_stress: Mean
    """Pa, in a layer N/m, as the next"""
    normal_stress: Mean
    """in compression positive"""
    fraction: Mean
    viscous_number: Mean
    friction: Mean

    @property
    def viscosity(self) -> Viscosity:
        """Shear stress over shear rate; in a layer N s/m."""
        return self.shear_stress.value / self.rate.value


def viscous_number(viscosity: Viscosity, rate: Rate, normal_stress: Pressure) -> Number:
    """J = eta |rate| / P: how long a film takes to be squeezed, times how fast the flow is. [boyer2011].

    In a layer the normal stress is a force over a length, and J a length: that of P over a radius has none.

    >>> viscous_number(2.0, 3.0, 60.0)
    0.1
    """
    return viscosity * abs(rate) / normal_stress


def flow_point(frames: Sequence[Frame], viscosity: Viscosity, thickness: float = 1.0) -> FlowPoint:
    """The means over frames of a steady flow, evenly spaced in time; cut off how it began before.

    `thickness` makes a stress of a layer's force over length, and J a number: twice the mean radius is usual.
    """
    rate = shear_rates(frames)
    shear, normal, fraction = series(frames, *map(number, ("shear_stress", "normal_stress", "volume_fraction")))
    pressure = steady_mean(normal)
    if not pressure.value > 0.0:
        raise BadInput(f"the mean normal stress is {pressure.value:.3g}, a tension; friction requires compression")
    flow, drag = steady_mean(rate), steady_mean(np.sign(rate.mean()) * shear)
    return FlowPoint(
        flow,
        steady_mean(shear),
        pressure,
        steady_mean(fraction),
        _quotient(flow, pressure, viscosity * thickness),
        _quotient(drag, pressure, 1.0),
    )


def _quotient(above: Mean, below: Mean, factor: float) -> Mean:
    """|a| f / b with the error of independent a and b."""
    value = abs(above.value) * factor / below.value
    error = math.hypot(above.error / above.value if above.value else 0.0, below.error / below.value)
    return Mean(value, value * error if above.value else above.error * factor / below.value)


class Moduli(NamedTuple):
    """The moduli of a small oscillation: the stress in phase with strain, and with the rate of strain."""

    storage: Mean
    """G' (Pa, in a layer N/m)"""
    loss: Mean
    """G'' """
    amplitude: float
    """of the strain"""
    overtone: float
    """the stress's third harmonic over its first: small where the answer is linear"""
    periods: int
    """whole ones, from the end"""


def moduli(time: Array, strain: Array, stress: Array, period: Time) -> Moduli:
    """G' and G'' from an oscillation of any shape with this period: the ratio of the first harmonics.

    As many whole periods as there are, counted from the end; errors are those of the mean over periods (of one, the
    residual's). Times should be even. A drift is taken off by the means over whole periods, if there are two or more.
    """
    whole = math.floor((time[-1] - time[0]) / period * (1.0 + 1e-9))
    if whole < 1:
        raise BadInput(f"expected a whole period of {period:g} s; these times span {time[-1] - time[0]:g} s")
    turn = np.floor((time[-1] - time) / period + 1e-9).astype(int)
    fewest = int(np.bincount(turn)[:whole].min())
    if fewest < FEWEST:
        raise BadInput(f"expected {FEWEST} instants or more in a period of {period:g} s; got {fewest}")
    steady = [_without_drift(time, values, turn, whole) for values in (strain, stress)]
    found = [[_harmonics(time[turn == n], values[turn == n], period) for values in steady] for n in range(whole)]
    strains, stresses = np.array(found).transpose(1, 0, 2)
    ratio = stresses[:, 0] / strains[:, 0]
    own = float(np.abs(stresses[:, 2] / strains[:, 0]).max())
    overtone = float(np.abs(stresses[:, 1]).mean() / max(np.abs(stresses[:, 0]).mean(), 1e-300))
    amplitude = float(np.abs(strains[:, 0]).mean())
    return Moduli(_over_periods(ratio.real, own), _over_periods(ratio.imag, own), amplitude, overtone, whole)


def _without_drift(time: Array, values: Array, turn: Integers, whole: int) -> Array:
    """Less what the means over periods grow by: harmonics have none."""
    if whole < 2:
        return values
    middle, mean = ([part[turn == n].mean() for n in range(whole)] for part in (time, values))
    return np.asarray(values - np.polyfit(middle, mean, 1)[0] * time)


def _harmonics(time: Array, values: Array, period: Time) -> tuple[complex, complex, complex]:
    """The first and third harmonic, values = Re(c exp(i w t)) + ..., and the first one's error from what is left."""
    phase = 2.0 * math.pi / period * time
    columns = [wave(n * phase) for n in (1.0, 2.0, 3.0) for wave in (np.cos, np.sin)]
    terms = np.column_stack([*columns, np.ones_like(time)])
    answer = np.linalg.lstsq(terms, values, rcond=None)[0]
    left = values - terms @ answer
    error = math.sqrt(2.0 * float((left**2).sum()) / max(len(time) - terms.shape[1], 1) / len(time))
    return complex(answer[0], -answer[1]), complex(answer[4], -answer[5]), complex(error)


def _over_periods(values: Array, own: float) -> Mean:
    if len(values) == 1:
        return Mean(float(values[0]), own)
    return Mean(float(values.mean()), float(values.std(ddof=1) / math.sqrt(len(values))))


YIELDED = 0.1
"""Strain since the step: well beyond the deformation of surfaces, well before steady flow."""


def yield_delay(frames: Sequence[Frame], step: Time, strain: Number = YIELDED) -> Time:
    """The delay from a step of stress to a strain of this size, either way; infinite where it is never reached.

    >>> frames = [Frame(t, {}, {"strain": 0.05 * max(t - 2.0, 0.0)}, {}) for t in (0.0, 1.0, 2.0, 3.0, 6.0)]
    >>> yield_delay(frames, step=1.0)
    3.0
    """
    time, crept = creep(frames, step)
    beyond = np.flatnonzero(crept >= strain)
    if not len(beyond):
        return math.inf
    last = int(beyond[0])
    return float(np.interp(strain, crept[last - 1 : last + 1], time[last - 1 : last + 1]))


def least_rate(frames: Sequence[Frame], step: Time, strain: Number = YIELDED) -> Time:
    """The time after a step of stress at which creep is slowest before this strain is reached: there slowing down ends.

    Half-way between the two frames around it; infinite where the strain is never reached.
    """
    time, crept = creep(frames, step)
    beyond = np.flatnonzero(crept >= strain)
    if not len(beyond):
        return math.inf
    end = int(beyond[0]) + 1
    slowest = int(np.argmin(np.diff(crept[:end]) / np.diff(time[:end])))
    return float(0.5 * (time[slowest] + time[slowest + 1]))


def creep(frames: Sequence[Frame], step: Time) -> tuple[Array, Array]:
    """The time since a step of stress, and the strain since then in the sense in which it ends."""
    now, strain = times(frames), *series(frames, number("strain"))
    after = now >= step * (1.0 - 1e-9)
    if after.sum() < 2:
        raise BadInput(f"expected two frames or more from the step at {step:g} s on; got {int(after.sum())}")
    crept = strain[after] - strain[after][0]
    return now[after] - step, math.copysign(1.0, crept[-1]) * crept
