"""The figures of the soft model: gaps, forces, stresses and steps over time, and the last instant.

Figures of flows and rheology come first, the table last.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter, StrMethodFormatter

from ecume.analysis.curves import Curve, Difference, branches, largest_difference
from ecume.analysis.rheology import (
    FEWEST_POINTS,
    CurveFit,
    FlowPoint,
    MeanStress,
    Moduli,
    creep,
    creep_flow,
    flow_point,
    herschel_bulkley,
    mean_stress,
    moduli,
    steady_part,
    viscosity_divergence,
)
from ecume.analysis.series import Mean, number, series, times
from ecume.errors import BadInput
from ecume.models.liquids import material_of
from ecume.scenes.soft import SoftScene, expanded, known_moments, waits
from ecume.show.curves import Frames, evolution, over_time, scaling, span, titled
from ecume.show.soft.measures import MEASURE_FIGURES, require_box
from ecume.show.soft.packing import Packing
from ecume.show.soft.transients import TRANSIENT_FIGURES
from ecume.show.style import INK, MUTED, PALETTE, figure, legend_outside, scale_for, style
from ecume.trajectories.frame import Frame
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.soft import SoftScene

ALIKE = 0.01
"""The difference of volume fractions below which they count as equal."""
SHEARS = ("strain", "shear_rate", "rate_steps", "shear_stress", "oscillation")
"""Keys of a moment of the protocol that end the shear stress before it."""
FEWEST_RATES = 3
"""The smallest number of different shear rates, one after the other, that count as a sweep up or down."""
LEAST = 8
"""The smallest number of frames of a part of the protocol for the detection of a steady state."""


class SteadyFlow(NamedTuple):
    """A part of the protocol with steady shear under a compressive normal stress."""

    frames: Sequence[Frame]
    """of the whole part"""
    steady: Sequence[Frame]
    """from where it is stationary"""
    settled: bool
    point: FlowPoint
    stress: MeanStress | None
    """where frames contain the components"""


def parts_of(frames: Frames, scene: SoftScene) -> list[list[Frame]]:
    """The frames between each two moments of the protocol; steps of the shear rate are moments. Where rates end when
    the stress is stationary, frames say to which rate they belong.
    """
    now = times(frames)
    turns = sorted({0.0, *known_moments(scene.protocol), float(now[-1])})
    inside = [
        np.flatnonzero((now > start * (1.0 + 1e-9)) & (now <= end * (1.0 + 1e-9)))
        for start, end in itertools.pairwise(turns)
    ]
    parts = [[frames[int(index)] for index in part] for part in inside]
    return [list(rate) for part in parts for _, rate in itertools.groupby(part, _rate_step)]


def _rate_step(frame: Frame) -> float:
    """The rate to which a frame belongs, of those that wait for a stationary stress."""
    return frame.numbers.get("rate_step", 0.0)


def steady_flows(frames: Frames, scene: SoftScene) -> list[SteadyFlow]:
    """The stationary flow of each part of the protocol."""
    thickness = 2.0 * float(frames[0].arrays["radius"].mean()) if frames[0].arrays["position"].shape[1] == 2 else 1.0
    viscosity = material_of(scene.liquid).viscosity
    found = []
    for part in parts_of(frames, scene):
        if len(part) < LEAST or part[-1].numbers["strain"] == part[0].numbers["strain"]:
            continue
        if _oscillates(part, scene):
            continue
        steady, settled = steady_part(part)
        if series(steady, number("normal_stress")).mean() > 0.0:
            whole = mean_stress(steady) if "stress_squeeze_xx" in part[0].numbers else None
            found.append(SteadyFlow(part, steady, settled, flow_point(steady, viscosity, thickness), whole))
    return found


def _oscillates(part: Sequence[Frame], scene: SoftScene) -> bool:
    """Whether a part of the protocol is an oscillation, whose mean is not a steady flow."""
    begun = [stage for stage in expanded(scene.protocol) if stage.time < part[0].time * (1.0 - 1e-9)]
    return bool(begun) and begun[-1].oscillation is not None


def _required_flows(frames: Frames, scene: SoftScene) -> list[SteadyFlow]:
    require_box(scene, "flow")
    found = steady_flows(frames, scene)
    if not found:
        raise BadInput("nowhere in this run is the packing sheared while its normal stress is a compression")
    return found


class Look(NamedTuple):
    """The style of a set of points."""

    color: str
    label: str = "_"
    scale: float = 1.0
    """of the values"""
    marker: str = "o"


def _points(axes: Axes, x: Sequence[Mean], y: Sequence[Mean], look: Look) -> None:
    """Draw means with the errors of both axes."""
    axes.errorbar(
        [abs(one.value) for one in x], [look.scale * one.value for one in y], [look.scale * one.error for one in y],
        [one.error for one in x], fmt=look.marker, markersize=4, capsize=2, color=look.color, label=look.label,
    )  # fmt: skip


def _rate_axis(axes: Axes, values: Sequence[float]) -> None:
    """Set the scale of the horizontal axis; for less than two decades, with labels at 1, 2 and 5."""
    axes.set_xscale(scaling(values))
    if axes.get_xscale() == "log" and max(values) < 100.0 * min(values):
        axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axes.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
        axes.xaxis.set_minor_formatter(NullFormatter())


def _mark_unsettled(axes: Axes, flows: Sequence[SteadyFlow], x: Sequence[float], y: Sequence[float]) -> None:
    """Draw rings around the points with non-stationary stress."""
    loose = [n for n, flow in enumerate(flows) if not flow.settled]
    if loose:
        x, y = [x[n] for n in loose], [y[n] for n in loose]
        axes.plot(x, y, "o", markersize=10, markerfacecolor="none", color=MUTED, label="not stationary")


def steady_states(frames: Frames, scene: SoftScene) -> Figure:
    """Shear stress and pressure over strain, with the stationary region of each part of the protocol."""
    frames = list(frames)  # to read all frames only once
    flows = _required_flows(frames, scene)
    shear, pressure = series(frames, number("shear_stress"), number("pressure"))
    scale, strain = scale_for(float(np.abs([shear, pressure]).max()), frames[0].units["shear_stress"]), sheared(frames)
    now = times(frames)
    with style():
        drawn = figure(7.0, 4.8)
        panels = drawn.subplots(2, 1, sharex=True)
        for axes, name, values in zip(panels, ("shear_stress", "pressure"), (shear, pressure), strict=True):
            axes.plot(strain, scale.factor * values, color=MUTED, linewidth=0.8)
            for flow, color in zip(flows, itertools.cycle(PALETTE)):
                (own,) = series(flow.steady, number(name))
                ends = [strain[place_of(now, flow.steady[end])] for end in (0, -1)]
                label = f"{flow.point.rate.value:.3g} /s" + ("" if flow.settled else ", not stationary")
                axes.plot(ends, [scale.factor * own.mean()] * 2, color=color, linewidth=2.5, label=label)
            axes.set_ylabel(f"{name.replace('_', ' ')} ({scale.unit})")
        panels[0].set_title(titled("Steady states", scene))
        panels[1].set_xlabel("total shear strain")
        legend_outside(panels[0])
    return drawn


def sheared(frames: Frames) -> Array:
    """The accumulated strain, in both directions."""
    (strain,) = series(frames, number("strain"))
    return np.concatenate([[0.0], np.cumsum(np.abs(np.diff(strain)))])


def place_of(now: Array, frame: Frame) -> int:
    """The index of the time of a frame among all times."""
    return int(np.argmin(np.abs(now - frame.time)))


def stress_of(flow: SteadyFlow) -> Mean:
    """The shear stress along the flow."""
    return Mean(abs(flow.point.shear_stress.value), flow.point.shear_stress.error)


def rate_of(flow: SteadyFlow) -> float:
    """The magnitude of the shear rate (1/s), rounded so that rates that are meant to be equal agree."""
    return float(f"{abs(flow.point.rate.value):.4g}")


def comparable(flows: Sequence[SteadyFlow]) -> list[int]:
    """The indices of the flows that are stationary and have the volume fraction of the last one, which excludes a
    pre-shear before a compression.
    """
    last = flows[-1].point.fraction.value if flows else 0.0
    alike = (abs(flow.point.fraction.value - last) < ALIKE * last for flow in flows)
    return [place for place, (flow, same) in enumerate(zip(flows, alike, strict=True)) if flow.settled and same]


def fitted_flow(flows: Sequence[SteadyFlow]) -> CurveFit | None:
    """Herschel and Bulkley's law fitted to the comparable flows; None if there are too few, or if they do not determine
    it.
    """
    flows = [flows[place] for place in comparable(flows)]
    if len(flows) < FEWEST_POINTS:
        return None
    try:
        return herschel_bulkley(np.array([abs(flow.point.rate.value) for flow in flows]), list(map(stress_of, flows)))
    except BadInput:
        return None


class Directions(NamedTuple):
    """The indices of the flows at increasing rates, those at decreasing rates, and all others."""

    rising: list[int]
    falling: list[int]
    other: list[int]


def directions(flows: Sequence[SteadyFlow]) -> Directions:
    """The flows of an upward and of a downward sweep of rates; a flow at a turning point belongs to both. Fewer than
    `FEWEST_RATES` in one direction, such as a pre-shear before the slowest rate, are not a sweep.
    """
    rates = list(map(rate_of, flows))
    parts = [one for one in branches(rates) if len({rates[place] for place in one.places}) >= FEWEST_RATES]
    up, down = ({place for one in parts if one.rises is rises for place in one.places} for rises in (True, False))
    if not up or not down:
        up, down = set(), set()
    return Directions(sorted(up), sorted(down), sorted(set(range(len(flows))) - up - down))


def hysteresis(flows: Sequence[SteadyFlow]) -> Difference | None:
    """The largest difference of the stresses of comparable flows between decreasing and increasing rates; None if there
    is only one direction, or no common rate.
    """
    both = directions(flows)
    # At the turning point both are the same flow.
    good = set(comparable(flows)) - (set(both.rising) & set(both.falling))
    up, down = ([flows[place] for place in places if place in good] for places in (both.rising, both.falling))
    if not {rate_of(flow) for flow in up} & {rate_of(flow) for flow in down}:
        return None
    return largest_difference(
        *(Curve(np.array(list(map(rate_of, one))), tuple(map(stress_of, one))) for one in (up, down))
    )


def _sets_of_points(flows: Sequence[SteadyFlow], factor: float) -> list[tuple[list[int], Look]]:
    """The sets of points of a flow curve, with the style of each."""
    found, apart = directions(flows), hysteresis(flows)
    said = (
        ""
        if apart is None
        else f",\n{100.0 * apart.relative:+.2g} % at {apart.at:.3g} /s ({apart.errors:.2g} std. errors)"
    )
    sets = (
        (found.other, Look(PALETTE[1], "steady flows", factor)),
        (found.rising, Look(PALETTE[1], "rates rising", factor, "^")),
        (found.falling, Look(PALETTE[0], f"rates falling{said}", factor, "v")),
    )
    return [one for one in sets if one[0]]


def flow_curve(frames: Frames, scene: SoftScene) -> Figure:
    """Shear stress over shear rate, with a point for each part of the protocol, and Herschel and Bulkley's law. A sweep
    of rates up and down shows both directions.
    """
    flows = _required_flows(frames, scene)
    values, rates = list(map(stress_of, flows)), [flow.point.rate for flow in flows]
    size, fit = [abs(rate.value) for rate in rates], fitted_flow(flows)
    scale = scale_for(max(one.value for one in values), frames[0].units["shear_stress"])
    held = waits(scene.protocol)
    with style():
        drawn = figure(6.4, 5.6 if held else 4.2)
        axes, *below = drawn.subplots(1 + held, 1, sharex=True, squeeze=False, height_ratios=[3.0, 1.0][: 1 + held])[
            :, 0
        ]
        axes.set(xlabel="shear rate (1/s)", ylabel=f"shear stress ({scale.unit})")
        for places, look in _sets_of_points(flows, scale.factor):
            _points(axes, [rates[place] for place in places], [values[place] for place in places], look)
        _mark_unsettled(axes, flows, size, [scale.factor * one.value for one in values])
        if fit is not None:
            rate = np.geomspace(min(size), max(size), 200)
            start, error = scale.factor * fit.offset.value, scale.factor * fit.offset.error
            power = f"n = {fit.exponent.value:.2f} ± {fit.exponent.error:.2f}"
            factor = f"K = {scale.factor * fit.factor.value:.3g}"
            label = f"{start:.3g} ± {error:.3g} {scale.unit} + K rate^n,\n{power}, {factor}"
            axes.plot(rate, scale.factor * fit(rate), color=INK, linewidth=1.0, label=label)
        _rate_axis(axes, size)
        axes.set(yscale=scaling([one.value for one in values]), title=titled("Flow curve", scene))
        axes.legend()
        for panel in below:
            _strains_held(panel, flows)
            panel.set_xlabel("shear rate (1/s)")
            axes.xaxis.label.set_visible(False)
    return drawn


def _strains_held(axes: Axes, flows: Sequence[SteadyFlow]) -> None:
    """Draw the strain for which each rate was held, of those that wait for a stationary stress."""
    waited = [flow for flow in flows if _rate_step(flow.frames[0])]
    parts = [[flow for flow in waited if _became_stationary(flow) is ended] for ended in (True, False)]
    for part, filled, label in zip(parts, (MUTED, "none"), ("until stationary", "largest strain"), strict=True):
        held = [abs(flow.point.rate.value) * _duration(flow.frames) for flow in part]
        rates = [abs(flow.point.rate.value) for flow in part]
        axes.plot(rates, held, "s", markersize=4, markerfacecolor=filled, color=MUTED, label=label if part else "_")
    axes.set(ylabel="strain held", ylim=(0.0, None))
    axes.legend()


def _became_stationary(flow: SteadyFlow) -> bool:
    """Whether a rate ended since its stress was stationary within the error of the scene."""
    first, last = flow.frames[0].numbers, flow.frames[-1].numbers
    return last["rates_stationary"] > first["rates_stationary"]


def _duration(part: Sequence[Frame]) -> float:
    """The duration of evenly spaced frames, with the interval before the first (s)."""
    return (part[-1].time - part[0].time) * len(part) / (len(part) - 1)


def viscous_numbers(frames: Frames, scene: SoftScene) -> Figure:
    """Friction and volume fraction over the viscous number: a point for each part of the protocol."""
    flows = _required_flows(frames, scene)
    with style():
        drawn = figure(6.4, 4.8)
        above, below = drawn.subplots(2, 1, sharex=True)
        numbers = [flow.point.viscous_number for flow in flows]
        for axes, name, label in ((above, "friction", "friction μ"), (below, "fraction", "volume fraction φ")):
            _points(axes, numbers, [getattr(flow.point, name) for flow in flows], Look(PALETTE[1]))
            axes.set_ylabel(label)
        above.set_title(titled("Friction and volume fraction", scene))
        below.set_xlabel("viscous number J = η |rate| / P")
        _rate_axis(below, [one.value for one in numbers])
    return drawn


def normal_stresses(frames: Frames, scene: SoftScene) -> Figure:
    """Pressure and normal stress differences over shear rate: a point for each part of the protocol."""
    flows = [(flow.point.rate, flow.stress) for flow in _required_flows(frames, scene) if flow.stress is not None]
    if not flows:
        raise BadInput("the frames contain no components of the stress; see output.quantities")
    rates, stresses = [rate for rate, _ in flows], [stress for _, stress in flows]
    shown = [("pressure", "pressure P"), ("first_difference", "N₁ = σ_xx − σ_yy")]
    if frames[0].arrays["position"].shape[1] == 3:
        shown.append(("second_difference", "N₂ = σ_yy − σ_zz"))
    scale = scale_for(max(stress.pressure.value for stress in stresses), frames[0].units["shear_stress"])
    with style():
        drawn = figure(6.4, 4.2)
        axes = drawn.add_subplot(xlabel="shear rate (1/s)", ylabel=f"stress ({scale.unit})")
        for (name, label), color in zip(shown, PALETTE, strict=False):
            _points(axes, rates, [getattr(one, name) for one in stresses], Look(color, label, scale.factor))
        axes.axhline(0.0, color=MUTED, linewidth=0.8)
        _rate_axis(axes, [abs(rate.value) for rate in rates])
        axes.set_title(titled("Normal stresses", scene))
        axes.legend()
    return drawn


def viscosity_over_fraction(frames: Frames, scene: SoftScene) -> Figure:
    """Viscosity over volume fraction: a point for each part of the protocol, and the fraction at which it diverges."""
    flows = _required_flows(frames, scene)
    fractions = [flow.point.fraction for flow in flows]
    values = [flow.point.shear_viscosity for flow in flows]
    scale = scale_for(max(one.value for one in values), frames[0].units["viscosity"])
    phi = np.array([one.value for one in fractions])
    with style():
        drawn = figure(6.4, 4.2)
        axes = drawn.add_subplot(xlabel="volume fraction φ", ylabel=f"viscosity ({scale.unit})")
        _points(axes, fractions, values, Look(PALETTE[1], "steady flows", scale.factor))
        try:
            fit = viscosity_divergence(phi, values)
        except BadInput:
            pass
        else:
            line = np.linspace(phi.min(), phi.max(), 100)
            label = f"diverges at {fit.fraction.value:.3f} ± {fit.fraction.error:.3f}"
            height = fit.factor.value * (1.0 - line / fit.fraction.value) ** -fit.exponent.value
            axes.plot(line, scale.factor * height, color=INK, linewidth=1.0, label=label)
        axes.set(yscale=scaling([one.value for one in values]), title=titled("Viscosity over volume fraction", scene))
        axes.legend()
    return drawn


def creep_curves(frames: Frames, scene: SoftScene) -> Figure:
    """The strain since each step of the shear stress, and its rate."""
    require_box(scene, "strain")
    moments = [stage.time for stage in scene.protocol if stage.shear_stress is not None]
    if not moments:
        raise BadInput("the protocol imposes no shear_stress; creep requires one")
    sheared_again = [
        stage.time for stage in expanded(scene.protocol) if any(getattr(stage, key) is not None for key in SHEARS)
    ]
    last = float(times(frames)[-1])
    ends = [min((time for time in sheared_again if time > start), default=last) for start in moments]
    with style():
        drawn = figure(6.4, 4.8)
        strains, rates = drawn.subplots(2, 1, sharex=True)
        for start, end, color in zip(moments, ends, itertools.cycle(PALETTE), strict=False):
            part = [frame for frame in frames if start * (1 - 1e-9) <= frame.time <= end * (1 + 1e-9)]
            if len(part) > FEWEST_POINTS:
                _creep_of(strains, rates, part, color)
        strains.set(ylabel="strain since the step", title=titled("Creep", scene))
        rates.set(xlabel="time since the step (s)", ylabel="rate (1/s)")
        if rates.lines:
            rates.set(xscale="log", yscale="log")
        legend_outside(strains)
    return drawn


def _creep_of(strains: Axes, rates: Axes, part: Sequence[Frame], color: str) -> None:
    """Draw one step of stress."""
    time, crept = creep(part, part[0].time)
    label = f"{part[-1].numbers['shear_stress']:.3g} {part[-1].units['shear_stress']}"
    try:
        flow = creep_flow(part, part[0].time)
        label += f", {flow.rate.value:.2g} /s" if flow.flows else ", no steady flow"
    except BadInput:
        pass
    later = time > 0.0  # the axis is logarithmic
    strains.plot(time[later], crept[later], color=color, label=label)
    rate, middle = np.diff(crept) / np.diff(time), 0.5 * (time[1:] + time[:-1])
    rates.plot(middle[rate > 0.0], rate[rate > 0.0], color=color)


def oscillations(frames: Frames, scene: SoftScene) -> list[tuple[float, Moduli]]:
    """The frequency (1/s) and the moduli of each oscillation of the protocol; if there are several periods, without the
    first one.
    """
    now, strain, stress = times(frames), *series(frames, number("strain"), number("shear_stress"))
    stages = expanded(scene.protocol)
    ends = [*(stage.time for stage in stages[1:]), float(now[-1])]
    found = []
    for stage, end in zip(stages, ends, strict=True):
        if stage.oscillation is None:
            continue
        period = 1.0 / stage.oscillation.frequency
        start = stage.time + (period if end - stage.time >= 2.0 * period * (1.0 - 1e-9) else 0.0)
        inside = (now >= start * (1.0 - 1e-9)) & (now <= end * (1.0 + 1e-9))
        if inside.any() and now[inside][-1] - now[inside][0] >= period * (1.0 - 1e-9):
            found.append((stage.oscillation.frequency, moduli(now[inside], strain[inside], stress[inside], period)))
    return found


def storage_and_loss(frames: Frames, scene: SoftScene) -> Figure:
    """Stress over strain, and the moduli of each oscillation in the protocol: over frequency, or over the strain
    amplitude if all frequencies are equal.
    """
    require_box(scene, "stress")
    found = oscillations(frames, scene)
    if not found:
        raise BadInput("the protocol has no oscillation of a whole period; see protocol.oscillation")
    strain, stress = series(frames, number("strain"), number("shear_stress"))
    unit = frames[0].units["shear_stress"]
    with style():
        drawn = figure(8.4, 3.8)
        loops, spectrum = drawn.subplots(1, 2)
        scale = scale_for(float(np.abs(stress).max()), unit)
        loops.plot(strain, scale.factor * stress, color=PALETTE[1], linewidth=0.9)
        loops.set(xlabel="strain", ylabel=f"shear stress ({scale.unit})", title=titled("Stress over strain", scene))
        loops.xaxis.set_major_locator(MaxNLocator(4))  # labels of small strains are long
        frequency = [one for one, _ in found]
        swept = len(found) > 1 and len(set(frequency)) == 1
        across = [answer.amplitude for _, answer in found] if swept else frequency
        levels = scale_for(max(abs(answer.storage.value) for _, answer in found), unit)
        for name, label, mark, color in (("storage", "G′", "o", PALETTE[0]), ("loss", "G″", "s", PALETTE[2])):
            values = [getattr(answer, name) for _, answer in found]
            spectrum.errorbar(
                across, [levels.factor * one.value for one in values], [levels.factor * one.error for one in values],
                fmt=mark + "-", color=color, label=label, markersize=4,
            )  # fmt: skip
        heights = [abs(getattr(one, name).value) for _, one in found for name in ("storage", "loss")]
        label = "amplitude of the strain" if swept else "frequency (1/s)"
        spectrum.set(xlabel=label, ylabel=f"modulus ({levels.unit})", title="Storage and loss moduli")
        spectrum.set(xscale=scaling(across), yscale=scaling(heights))
        spectrum.legend()
    return drawn


def large_oscillations(frames: Frames, scene: SoftScene) -> Figure:
    """The stress response to each oscillation of the protocol: stress over strain (Lissajous figures), both divided by
    their largest values, and the third harmonic over the strain amplitude.
    """
    require_box(scene, "stress")
    frames = list(frames)  # to read all frames only once
    found = [answer for _, answer in oscillations(frames, scene)]
    if not found:
        raise BadInput("the protocol has no oscillation of a whole period; see protocol.oscillation")
    with style():
        drawn = figure(8.4, 3.8)
        loops, harmonics = drawn.subplots(1, 2)
        parts = [part for part in parts_of(frames, scene) if len(part) > 1 and _oscillates(part, scene)]
        for part, answer, color in zip(parts, found, itertools.cycle(PALETTE)):
            late = part[-1 - max(round(len(part) / (answer.periods + 1)), 1) :]  # with both ends of the last period
            strain, stress = (
                values - values.mean() for values in series(late, number("strain"), number("shear_stress"))
            )
            label = f"amplitude {answer.amplitude:.2g}"
            loops.plot(strain / np.abs(strain).max(), stress / np.abs(stress).max(), color=color, label=label)
        loops.set(xlabel="strain / largest", ylabel="shear stress / largest", title=titled("Stress over strain", scene))
        loops.legend(fontsize="small")
        amplitudes = [one.amplitude for one in found]
        for name, label, mark in (
            ("overtone", "third harmonic / first", "o"), ("elastic_third", "e$_3$/e$_1$, elastic part", "s"),
            ("viscous_third", "v$_3$/v$_1$, viscous part", "^"),
        ):  # fmt: skip
            harmonics.plot(amplitudes, [getattr(one, name) for one in found], mark + "-", markersize=4, label=label)
        harmonics.axhline(0.0, color=MUTED, linewidth=0.8)
        harmonics.set(xlabel="amplitude of the strain", xscale=scaling(amplitudes), title="Third harmonic")
        harmonics.legend(fontsize="small")
    return drawn


FLOW_FIGURES = {
    "steady-state": steady_states,
    "flow-curve": flow_curve,
    "viscous-number": viscous_numbers,
    "normal-stresses": normal_stresses,
    "viscosity-fraction": viscosity_over_fraction,
    "creep": creep_curves,
    "moduli": storage_and_loss,
    "large-oscillation": large_oscillations,
    **TRANSIENT_FIGURES,
}


MOST_CURVES = 12
"""The largest number of contacts drawn as single curves; for more, percentiles are drawn."""
SPREAD = (5, 25, 50, 75, 95)
"""The drawn percentiles."""

Key = tuple[int, int]


def gaps(frames: Frames, scene: SoftScene) -> Figure:
    """The gap of each contact over time, or their distribution for many contacts."""
    return _of_contacts(frames, scene, "gap", "m", "Gaps of contacts")


def forces(frames: Frames, scene: SoftScene) -> Figure:
    """The normal force of every contact over time, or its distribution; tension is positive."""
    return _of_contacts(frames, scene, "tension", "N", "Normal forces of contacts")


def _of_contacts(frames: Frames, scene: SoftScene, name: str, unit: str, title: str) -> Figure:
    shown = evolution(frames)
    values = [_contacts(frame, name) for frame in shown]
    keys = sorted({key for instant in values for key in instant})
    largest = max((abs(value) for instant in values for value in instant.values()), default=0.0)
    scale = scale_for(largest, unit)
    with style():
        drawn = figure(6.8, 4.0)
        axes = over_time(drawn, scene, title)
        if len(keys) <= MOST_CURVES:
            for key, color in zip(keys, itertools.cycle(PALETTE), strict=False):
                curve = [scale.factor * instant.get(key, np.nan) for instant in values]
                axes.plot(times(shown), curve, color=color, label=f"spheres {key[0]} and {key[1]}")
            legend_outside(axes)
        else:
            _spread(axes, times(shown), [scale.factor * np.array(list(instant.values())) for instant in values])
        label = "normal force, tension positive" if name == "tension" else name
        axes.set(ylabel=f"{label} ({scale.unit})", xlim=span(times(shown)))
        if name == "gap":
            axes.set_yscale(scaling([value for instant in values for value in instant.values()]))
    return drawn


def _contacts(frame: Frame, name: str) -> dict[Key, float]:
    """The value of each contact, by the numbers of its spheres."""
    first, slot = np.nonzero(frame.arrays["neighbor"] >= 0)
    second = frame.arrays["neighbor"][first, slot]
    return dict(zip(zip(first.tolist(), second.tolist(), strict=True), frame.arrays[name][first, slot], strict=True))


def _spread(axes: Axes, instants: Array, values: list[Array]) -> None:
    """Percentiles as nested bands around the median."""
    blank = np.full(len(SPREAD), np.nan)  # where no spheres are in contact
    rows = [np.percentile(one, SPREAD) if len(one) else blank for one in values]
    low, lower, median, upper, high = np.array(rows).T
    axes.fill_between(instants, low, high, color=PALETTE[1], alpha=0.2, linewidth=0, label="5 to 95 %")
    axes.fill_between(instants, lower, upper, color=PALETTE[1], alpha=0.4, linewidth=0, label="25 to 75 %")
    axes.plot(instants, median, color=INK, label="median")
    legend_outside(axes)


def elastic_energy(frames: Frames, scene: SoftScene) -> Figure:
    """The elastic energy of the deflections of all surfaces."""
    shown = evolution(frames)
    (energy,) = series(shown, number("elastic_energy"))
    scale = scale_for(float(energy.max()), "J")
    with style():
        drawn = figure()
        axes = over_time(drawn, scene, "Elastic energy")
        axes.plot(times(shown), scale.factor * energy, color=PALETTE[1])
        axes.set(ylabel=f"elastic energy ({scale.unit})", xlim=span(times(shown)))
    return drawn


def stress(frames: Frames, scene: SoftScene) -> Figure:
    """Shear stress and normal stress of a periodic box over time."""
    require_box(scene, "stress")
    shown = evolution(frames)
    shear, normal, pressure = series(shown, *map(number, ("shear_stress", "normal_stress", "pressure")))
    scale = scale_for(float(np.abs([shear, normal, pressure]).max()), shown[0].units["shear_stress"])
    with style():
        drawn = figure()
        axes = over_time(drawn, scene, "Stresses")
        for label, values, color in zip(
            ("shear", "normal", "pressure"), (shear, normal, pressure), PALETTE, strict=False
        ):
            axes.plot(times(shown), scale.factor * values, color=color, label=label)
        axes.set(ylabel=f"stress ({scale.unit})", xlim=span(times(shown)))
        legend_outside(axes)
    return drawn


def picture(frames: Frames, scene: SoftScene) -> Figure:
    """The last frame: spheres, films and forces."""
    shown = Packing(scene, [frames[0], frames[len(frames) // 2], frames[-1]])
    shown.show(frames[-1])
    return shown.figure


SOFT_FIGURES = {
    "gaps": gaps,
    "forces": forces,
    "elastic-energy": elastic_energy,
    "stress": stress,
    **MEASURE_FIGURES,
    **FLOW_FIGURES,
    "packing": picture,
}
