"""Rheology of packings: stress, viscosity, friction and moduli of sheared boxes, and delay times of yielding."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from ecume.analysis.boxes import Integers
from ecume.analysis.series import Mean, number, series, steady_mean, times
from ecume.engine.stationarity import SURE, steady_part_of
from ecume.errors import BadInput
from ecume.trajectories.frame import Frame
from ecume.units import Array, Number, Pressure, Rate, Time, Viscosity

AXES = "xyz"
FEWEST = 10
"""The smallest number of frames in a period; with fewer, harmonics cannot be distinguished."""
PARTS = ("squeeze", "sliding", "remote")
"""The parts of the stress: squeezed films, sheared films, and long-range forces. The elastic deflections of surfaces
transmit the sum of the three, being in series with them.
"""


def stress_tensor(frame: Frame, part: str = "total") -> Array:
    """The stress of a box, (d, d), tension positive; Pa, in a layer N/m. `part` is one of PARTS.

    Its component xy is the force along x across planes of y. If spheres do not rotate, it may differ from the component
    yx.
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
    """The normal stress differences N_1 = s_xx - s_yy and N_2 = s_yy - s_zz, with x along the flow and y across,
    tension positive; N_2 = 0 in a layer.
    """
    normal = np.diag(stress_tensor(frame, part))
    return float(normal[0] - normal[1]), float(normal[1] - normal[2]) if len(normal) == 3 else 0.0


class SteadyState(NamedTuple):
    """The stationary part of a series."""

    first: int
    """the index at which it begins"""
    mean: Mean
    """of the values from there on"""
    settled: bool
    """whether the series is stationary from there on"""


def steady_state(values: Array) -> SteadyState:
    """The stationary part of an evenly spaced series, as `engine.stationarity` detects it [white1997], and its mean.

    >>> steady_state(np.array([9.0, 5.0, 1.0, 3.0, 1.0, 3.0, 1.0, 3.0, 1.0, 3.0, 1.0, 3.0])).first
    4
    """
    found = steady_part_of(values)
    return SteadyState(found.first, steady_mean(values[found.first :]), found.settled)


def steady_part(frames: Sequence[Frame]) -> tuple[Sequence[Frame], bool]:
    """The frames in which shear stress and normal stress are stationary, and whether such frames exist."""
    found = [steady_state(values) for values in series(frames, number("shear_stress"), number("normal_stress"))]
    return frames[max(one.first for one in found) :], all(one.settled for one in found)


class MeanStress(NamedTuple):
    """Means over frames, each with its standard error from block means; Pa, in a layer N/m."""

    shear: Mean
    pressure: Mean
    """in compression positive"""
    first_difference: Mean
    """N_1 = s_xx - s_yy"""
    second_difference: Mean
    """N_2 = s_yy - s_zz; 0 in a layer"""


def mean_stress(frames: Sequence[Frame], part: str = "total") -> MeanStress:
    """The means of the stress over frames of a steady flow, evenly spaced in time."""
    tensors = [stress_tensor(frame, part) for frame in frames]
    differences = [normal_stress_differences(frame, part) for frame in frames]
    shear = steady_mean(np.array([tensor[0, 1] for tensor in tensors]))
    pressure = steady_mean(np.array([-np.trace(tensor) / len(tensor) for tensor in tensors]))
    first, second = (steady_mean(values) for values in np.array(differences).T)
    return MeanStress(shear, pressure, first, second)


def over_seeds(means: Sequence[Mean]) -> Mean:
    """The mean of runs with different seeds. Its standard error follows from their scatter, or from their errors if
    these are larger, since the scatter of two or three runs can be small at random.

    >>> over_seeds([Mean(1.0, 0.1), Mean(3.0, 0.1)]), over_seeds([Mean(2.0, 0.5), Mean(2.0, 0.5)]).error > 0.35
    (Mean(value=2.0, error=1.0), True)
    """
    if not means:
        raise BadInput("expected one run or more; got none")
    own = math.sqrt(sum(one.error**2 for one in means)) / len(means)
    found = _over_periods(np.array([one.value for one in means]), own)
    return Mean(found.value, float(np.fmax(found.error, own)))


def shear_rates(frames: Sequence[Frame]) -> Array:
    """The rate of shear at each frame, from the frames around it, (T,) 1/s."""
    if len(frames) < 2:
        raise BadInput("a rate takes two frames or more")
    (strain,) = series(frames, number("strain"))
    return np.asarray(np.gradient(strain, times(frames)))


class FlowPoint(NamedTuple):
    """The means of a steady flow, each with its standard error."""

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

    @property
    def shear_viscosity(self) -> Mean:
        """The viscosity with its standard error."""
        return _quotient(self.shear_stress, self.rate, 1.0)


EINSTEIN = 2.5
"""The slope of the viscosity of a dilute suspension of spheres over their volume fraction."""


def suspension_viscosity(
    of_contacts: Viscosity, viscosity: Viscosity, fraction: Number, thickness: float | None = None
) -> Viscosity:
    """The viscosity from the stress of contacts plus that of a dilute suspension, eta (1 + 2.5 phi). [einstein1906],
    with the slope as corrected in 1911.

    The stress in a frame is that of contacts: its viscosity does not include the flow between distant spheres, and
    tends to zero at dilution. The sum is an interpolation between both limits, not a theory. In a layer, of a given
    `thickness` (the mean diameter is usual), viscosities of contacts are in N s/m, and spheres fill two thirds of what
    discs cover.

    >>> suspension_viscosity(0.0, 1.0, 0.1), suspension_viscosity(3.0, 2.0, 0.3, thickness=1.5)
    (1.25, 7.5)
    """
    if thickness is None:
        return of_contacts + viscosity * (1.0 + EINSTEIN * fraction)
    return of_contacts + viscosity * thickness * (1.0 + EINSTEIN * 2.0 / 3.0 * fraction)


def viscous_number(viscosity: Viscosity, rate: Rate, normal_stress: Pressure) -> Number:
    """The viscous number J = eta |rate| / P: the time in which a film is squeezed over that of the flow.
    [boyer2011].

    In a layer the normal stress is a force over a length, and J is a length; with P over a radius it is dimensionless.

    >>> viscous_number(2.0, 3.0, 60.0)
    0.1
    """
    return viscosity * abs(rate) / normal_stress


def flow_point(frames: Sequence[Frame], viscosity: Viscosity, thickness: float = 1.0) -> FlowPoint:
    """The means over frames of a steady flow, evenly spaced in time and without the transient.

    With `thickness`, usually twice the mean radius, force over length of a layer is converted to a stress, and J is
    dimensionless.
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
    """The quotient |a| f / b with its error, for independent a and b."""
    value = abs(above.value) * factor / below.value
    error = math.hypot(above.error / above.value if above.value else 0.0, below.error / below.value)
    return Mean(value, value * error if above.value else above.error * factor / below.value)


class CurveFit(NamedTuple):
    """A fit by weighted least squares to points with errors. Where points scatter by more than their errors, the errors
    of the fit are larger by the square root of the misfit.
    """

    offset: Mean
    factor: Mean
    exponent: Mean
    misfit: float
    """chi^2 per degree of freedom: about 1 where the curve and the errors are right"""
    covariance: Array
    """(3, 3) of offset, factor and exponent"""

    def __call__(self, argument: Array) -> Array:
        """The fitted power law, offset + factor x^exponent."""
        return np.asarray(self.offset.value + self.factor.value * np.asarray(argument) ** self.exponent.value)

    def error(self, argument: Array) -> Array:
        """The standard error of the fitted curve, from the covariance of its parameters."""
        x = np.asarray(argument, dtype=float)
        power = x**self.exponent.value
        slopes = np.stack([np.ones_like(x), power, self.factor.value * power * np.log(x)])
        return np.asarray(np.sqrt(np.maximum(np.einsum("a...,ab,b...->...", slopes, self.covariance, slopes), 0.0)))


EXPONENTS = np.geomspace(0.05, 4.0, 80)
"""The exponents among which a fit starts to search."""
FEWEST_POINTS = 4
"""The smallest number of points of a fit: three parameters, and one more for the errors."""


def power_fit(argument: Array, values: Sequence[Mean]) -> CurveFit:
    """Fit offset + factor x^exponent to points: a flow curve, the friction mu(J), or the volume fraction phi(J).

    >>> fit = power_fit(np.array([0.1, 1.0, 4.0, 9.0]), [Mean(2.0 + 3.0 * x**0.5, 0.1) for x in (0.1, 1.0, 4.0, 9.0)])
    >>> [round(one.value, 4) for one in (fit.offset, fit.factor, fit.exponent)]
    [2.0, 3.0, 0.5]
    """
    x = np.asarray(argument, dtype=float)
    if not (x > 0.0).all():
        raise BadInput("a power law is fitted to positive arguments; got others")
    middle = float(np.exp(np.log(x).mean()))
    fit = _separable(lambda power: (x / middle) ** power, values, EXPONENTS)
    # The factor is converted from x/mean to x: f m^-n, including the error of the exponent.
    scale, turn = middle ** -fit.best[2], np.eye(3)
    turn[1] = 0.0, scale, -fit.best[1] * scale * math.log(middle)
    covariance = turn @ fit.covariance @ turn.T
    factor = Mean(float(fit.best[1] * scale), math.sqrt(max(float(covariance[1, 1]), 0.0)))
    return CurveFit(fit.mean(0), factor, fit.mean(2), fit.misfit, covariance)


def herschel_bulkley(rates: Array, stresses: Sequence[Mean]) -> CurveFit:
    """Fit a flow curve s = s_y + K |rate|^n; the offset is the yield stress s_y (Pa; in a layer N/m), the factor the
    consistency K, the exponent n. [herschel1926].

    >>> fit = herschel_bulkley(np.array([1.0, 2.0, 4.0, 8.0]), [Mean(1.0 + r, 0.1) for r in (1.0, 2.0, 4.0, 8.0)])
    >>> round(fit.offset.value, 4), round(fit.exponent.value, 4)
    (1.0, 1.0)
    """
    return power_fit(np.abs(rates), stresses)


class Divergence(NamedTuple):
    """The viscosity eta = A (1 - phi/phi_J)^-b that diverges at a volume fraction."""

    fraction: Mean
    """phi_J"""
    exponent: Mean
    """b"""
    factor: Mean
    """A (Pa s; in a layer N s/m)"""
    misfit: float


FURTHEST = np.geomspace(1e-3, 1.0, 80)
"""The ratios of the distance of the divergence above the largest fraction to that fraction, among
which a fit searches.
"""


def viscosity_divergence(fractions: Array, viscosities: Sequence[Mean]) -> Divergence:
    """Fit a divergence of the viscosity over the volume fraction, by least squares of its logarithm. [krieger1959].

    >>> fit = viscosity_divergence(np.arange(0.5, 0.8, 0.05), [Mean(3.0 * (1 - p / 0.85) ** -2, 0.1)
    ...     for p in np.arange(0.5, 0.8, 0.05)])
    >>> [round(one.value, 4) for one in fit[:3]]
    [0.85, 2.0, 3.0]
    """
    phi = np.asarray(fractions, dtype=float)
    if not all(one.value > 0.0 for one in viscosities):
        raise BadInput("expected positive viscosities")
    logarithms = [Mean(math.log(one.value), one.error / one.value) for one in viscosities]
    fit = _separable(lambda end: -np.log1p(-phi / end), logarithms, phi.max() * (1.0 + FURTHEST))
    size = math.exp(fit.best[0])
    return Divergence(fit.mean(2), fit.mean(1), Mean(size, size * fit.mean(0).error), fit.misfit)


class _Fit(NamedTuple):
    """Offset, factor and the parameter of the column, with their covariance."""

    best: Array
    covariance: Array
    misfit: float

    def mean(self, place: int) -> Mean:
        """One parameter with its error."""
        return Mean(float(self.best[place]), math.sqrt(max(float(self.covariance[place, place]), 0.0)))


def _separable(column: Callable[[float], Array], values: Sequence[Mean], candidates: Array) -> _Fit:
    """The least squares fit of offset + factor column(p): for each p, the other two follow from a linear fit."""
    y, error = np.array([one.value for one in values]), np.array([one.error for one in values])
    if len(y) < FEWEST_POINTS:
        raise BadInput(f"a fit of three parameters takes {FEWEST_POINTS} points or more; got {len(y)}")
    known = bool((np.isfinite(error) & (error > 0.0)).all())
    weight = 1.0 / error if known else np.ones(len(y))

    def linear(p: float) -> tuple[Array, float]:
        terms = np.column_stack([np.ones(len(y)), column(p)])
        answer = np.linalg.lstsq(weight[:, None] * terms, weight * y, rcond=None)[0]
        return answer, float(((weight * (y - terms @ answer)) ** 2).sum())

    costs = [linear(float(p))[1] for p in candidates]
    lowest = int(np.argmin(costs))
    if lowest in (0, len(candidates) - 1):
        raise BadInput("the points do not determine the three parameters of the curve; use more of them, further apart")
    ends = float(candidates[lowest - 1]), float(candidates[lowest + 1])
    p = float(minimize_scalar(lambda one: linear(one)[1], bounds=ends, method="bounded", options={"xatol": 1e-10}).x)
    (offset, factor), cost = linear(p)
    step = 1e-5 * p
    slope = factor * (column(p + step) - column(p - step)) / (2.0 * step)
    terms = weight[:, None] * np.column_stack([np.ones(len(y)), column(p), slope])
    misfit = cost / (len(y) - 3)
    covariance = np.linalg.pinv(terms.T @ terms, rcond=1e-15) * (max(misfit, 1.0) if known else misfit)
    return _Fit(np.array([offset, factor, p]), covariance, misfit)


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
    elastic_third: float
    """e_3/e_1 of the part of the stress that is a function of the strain, e_1 T_1(x) + e_3 T_3(x) + ... with the strain
    over its amplitude x and Chebyshev's polynomials T_n: positive where the packing is stiffest at the largest strain
    """
    viscous_third: float
    """v_3/v_1, the same of the part that is a function of the rate: positive where the viscosity is largest at the
    largest rate
    """


def moduli(time: Array, strain: Array, stress: Array, period: Time) -> Moduli:
    """The moduli G' and G'' from an oscillation of any shape with this period: the ratio of the first harmonics.

    All whole periods are used, counted from the end; errors are those of the mean over periods, or for a single period
    those from the residual. Times should be evenly spaced. With two or more periods, the linear drift of the means over
    periods is subtracted.
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
    # With strain = a sin(u), T_3(sin u) = -sin 3u and T_3(cos u) = cos 3u.
    third = (1j * stresses[:, 1] / (strains[:, 0] / np.abs(strains[:, 0])) ** 3 / np.abs(strains[:, 0])).mean()
    elastic_third, viscous_third = (
        float(part / whole_part) if whole_part else math.nan
        for part, whole_part in ((third.imag, ratio.real.mean()), (third.real, ratio.imag.mean()))
    )
    storage, loss = _over_periods(ratio.real, own), _over_periods(ratio.imag, own)
    return Moduli(storage, loss, amplitude, overtone, whole, elastic_third, viscous_third)


def _without_drift(time: Array, values: Array, turn: Integers, whole: int) -> Array:
    """The values minus the linear drift of their means over periods, which contributes nothing to harmonics."""
    if whole < 2:
        return values
    middle, mean = ([part[turn == n].mean() for n in range(whole)] for part in (time, values))
    return np.asarray(values - np.polyfit(middle, mean, 1)[0] * time)


def _harmonics(time: Array, values: Array, period: Time) -> tuple[complex, complex, complex]:
    """The first and third harmonic, values = Re(c exp(i w t)) + ..., and the error of the first one
    from the residual.
    """
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
    """The delay from a step of stress to a strain of this magnitude; infinite if it is never reached.

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
    """The time after a step of stress at which the creep rate is smallest before this strain is reached.

    It is halfway between two frames; infinite if the strain is never reached.
    """
    time, crept = creep(frames, step)
    beyond = np.flatnonzero(crept >= strain)
    if not len(beyond):
        return math.inf
    end = int(beyond[0]) + 1
    slowest = int(np.argmin(np.diff(crept[:end]) / np.diff(time[:end])))
    return float(0.5 * (time[slowest] + time[slowest + 1]))


def creep(frames: Sequence[Frame], step: Time) -> tuple[Array, Array]:
    """The time since a step of stress, and the strain since then, positive in its final direction."""
    now, strain = times(frames), *series(frames, number("strain"))
    after = now >= step * (1.0 - 1e-9)
    if after.sum() < 2:
        raise BadInput(f"expected two frames or more from the step at {step:g} s on; got {int(after.sum())}")
    crept = strain[after] - strain[after][0]
    return now[after] - step, math.copysign(1.0, crept[-1]) * crept


class CreepFlow(NamedTuple):
    """The end of a creep test."""

    strain: float
    """since the step of stress, at the end"""
    rate: Mean
    """of the strain in the second half of the time since the step (1/s)"""
    slowing: float
    """the exponent n of a rate that falls as t^-n in the second half: 0 for a steady flow, near 1 for a packing that
    stops"""

    @property
    def flows(self) -> bool:
        """Whether the packing flows steadily: the rate exceeds three times its error, and decreases more slowly than
        t^-1/2.
        """
        return self.rate.value > SURE * self.rate.error and self.slowing < STOPPING


STOPPING = 0.5
"""The exponent of the strain rate below which creep counts as stopping: the strain then grows more slowly than the
square root of time.
"""


def creep_flow(frames: Sequence[Frame], step: Time) -> CreepFlow:
    """The creep under a constant shear stress since its step: strain, rate, and whether it slows down.

    >>> frames = [Frame(t, {}, {"strain": 0.05 * t + 0.1}, {}) for t in np.arange(0.0, 8.1, 0.1)]
    >>> flow = creep_flow(frames, step=0.0)
    >>> round(flow.rate.value, 6), flow.flows
    (0.05, True)
    """
    time, crept = creep(frames, step)
    rates, middle = np.diff(crept) / np.diff(time), 0.5 * (time[1:] + time[:-1])
    late = middle >= 0.5 * time[-1]
    if late.sum() < FEWEST_POINTS:
        raise BadInput(
            f"expected {FEWEST_POINTS} frames or more in the second half of the creep; got {int(late.sum())}"
        )
    half = len(rates[late]) // 2
    early_rate, late_rate = rates[late][:half].mean(), rates[late][-half:].mean()
    early_time, late_time = middle[late][:half].mean(), middle[late][-half:].mean()
    positive = early_rate > 0.0 and late_rate > 0.0
    slowing = -math.log(late_rate / early_rate) / math.log(late_time / early_time) if positive else math.inf
    return CreepFlow(float(crept[-1]), steady_mean(rates[late]), slowing)
