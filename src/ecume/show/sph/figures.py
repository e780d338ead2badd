"""Figures of a run of liquid: pressure over depth, front, velocity, free surface."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ecume.analysis.grids import Profile, velocity_profile
from ecume.analysis.pressures import with_pressures
from ecume.analysis.series import number, series, times
from ecume.errors import BadInput
from ecume.laws.hydrostatics import column_height, column_pressure
from ecume.models.sph.setup.choices import free_surface, pressure_of
from ecume.show.curves import (
    Frames,
    cut_spikes,
    energies,
    evolution,
    kinetic_energy,
    limits_without_spikes,
    over_time,
    samples_of,
    titled,
)
from ecume.show.sph.liquid import free_lines, walls_at
from ecume.show.sph.picture import DERIVED, liquid_picture
from ecume.show.sph.solids import rectangle, solid_cells
from ecume.show.style import INK, MUTED, PALETTE, RIM, Scale, figure, legend_outside, plain, scale_for, style
from ecume.trajectories.frame import Frame
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.sph import SphScene

REACH = 4.0
"""The range of the kernel in profiles, in spacings."""
POINTS = 61
INSTANTS = 5
AXES = "xyz"


def pressure(frames: Frames, scene: SphScene) -> Figure:
    """The pressure of each particle against its height at the end, and the exact pressure of this liquid at rest."""
    last = frames[-1]
    height, weight = _heights(last, scene)
    depth, exact = _column(last, scene, weight)
    lengths, pressures = scale_for(float(np.abs(height).max()), "m"), scale_for(float(exact.max()), "Pa")
    with style():
        drawn = figure()
        axes = drawn.add_subplot(title=titled(f"Pressure at {last.time:.4g} s", scene))
        dots: dict[str, Any] = {"color": PALETTE[5], "markersize": 2.0, "markeredgewidth": 0.0, "label": "particles"}
        axes.plot(pressures.factor * last.arrays["pressure"], lengths.factor * height, "o", **dots)
        bottom = walls_at(scene, last)[0][scene.up_axis]
        column = lengths.factor * (bottom + depth[-1] - depth)
        axes.plot(pressures.factor * exact, column, color=INK, label="exact column at rest")
        axes.set(xlabel=f"gauge pressure ({pressures.unit})", ylabel=f"height ({lengths.unit})")
        _absolute_axis(axes, scene, pressures.factor)
        legend_outside(axes)
    return drawn


def _absolute_axis(axes: Axes, scene: SphScene, factor: float) -> None:
    """Add a second axis with absolute pressures if the scene gives an atmospheric pressure; `factor` is that of the
    first axis.
    """
    atmospheric = scene.liquid.atmospheric_pressure
    if not atmospheric:
        return
    scale = scale_for(atmospheric, "Pa")
    ratio, shift = scale.factor / factor, scale.factor * atmospheric

    def absolute(gauge: Any) -> Any:
        return ratio * gauge + shift

    def gauge(absolute: Any) -> Any:
        return (absolute - shift) / ratio

    above: Any = axes.secondary_xaxis("top", functions=(absolute, gauge))
    above.set_xlabel(f"absolute pressure ({scale.unit})")
    above.ticklabel_format(useOffset=False)


def dynamic_pressure(frames: Frames, scene: SphScene) -> Figure:
    """The dynamic pressure of each particle against its height at the end: the gauge pressure minus the hydrostatic
    one, which is zero at rest.
    """
    height, _ = _heights(frames[-1], scene)
    if scene.second_liquid is not None:
        raise BadInput("the dynamic pressure is of one liquid; this tank has a [second_liquid]")
    values = with_pressures(scene)(frames[-1]).arrays["dynamic_pressure"]
    lengths, pressures = scale_for(float(np.abs(height).max()), "m"), scale_for(float(np.abs(values).max()), "Pa")
    with style():
        drawn = figure()
        axes = drawn.add_subplot(title=titled(f"Dynamic pressure at {frames[-1].time:.4g} s", scene))
        axes.plot(pressures.factor * values, lengths.factor * height, "o", color=PALETTE[5], markersize=2.0, mew=0.0)
        axes.axvline(0.0, color=INK, linewidth=0.8)
        axes.set(xlabel=f"dynamic pressure ({pressures.unit})", ylabel=f"height ({lengths.unit})")
    return drawn


def _heights(frame: Frame, scene: SphScene) -> tuple[Array, float]:
    """The heights of the particles, and the magnitude of gravity. Raises BadInput where neither has a meaning."""
    pull, up = np.array(scene.gravity), scene.up_axis
    if not pull[up] < 0.0 or np.delete(pull, up).any():
        raise BadInput(f"gravity does not point down along {scene.up}; the hydrostatic pressure is not defined")
    if not len(frame.arrays["position"]):
        raise BadInput(f"all liquid has left the tank at {frame.time:.4g} s, the time of this figure")
    return frame.arrays["position"][:, up], -float(pull[up])


def _column(frame: Frame, scene: SphScene, weight: float) -> tuple[Array, Array]:
    """Depths and pressures of the same amount of liquid at rest on the whole floor, around the
    solids there.

    Solid parts below the level displace liquid and raise the level, and a higher level may submerge more of a solid.
    The level is therefore found as a fixed point.
    """
    from ecume.models.sph.setup.building import material_of

    if scene.second_liquid is not None:
        raise BadInput("the exact column is of one liquid; this tank has a [second_liquid]")
    material = material_of(scene)
    low, high = walls_at(scene, frame)
    floor = float(np.prod(np.delete(high - low, scene.up_axis)))
    height, volume = solid_cells(scene, frame, (low, high))
    mass, laws = float(frame.arrays["mass"].sum()), (weight, material.density, material.sound_speed, material.exponent)
    level = column_height(mass / floor, *laws)
    for _ in range(LEVELS):
        wet = float(volume[height < low[scene.up_axis] + level].sum())
        before, level = level, column_height((mass + material.density * wet) / floor, *laws)
        if level <= before * (1.0 + CLOSE):
            break
    depth = np.linspace(0.0, level, POINTS)
    return depth, np.array([column_pressure(down, *laws) for down in depth])


LEVELS, CLOSE = 1000, 1e-9
"""The largest number of steps in the search for a level, and the relative change at its end."""


FRONTS = (("right", "front", "front, largest x"), ("top", "top", "top, the largest height"))


def _flowing(scene: SphScene) -> list[str]:
    """The sides with inflow or outflow."""
    return [side for side in scene.sides if getattr(scene.tank, side).kind in FLOWS]


FLOWS = ("inflow", "outflow")


def front(frames: Frames, scene: SphScene) -> Figure:
    """The largest x and the largest height of all particles."""
    closed = {side for side in ("right", "top") if getattr(scene.tank, side).kind not in ("wall", "open")}
    names = {name: label for side, name, label in FRONTS if side not in closed}
    if not names or "left" in _flowing(scene):
        raise BadInput("the liquid flows through the tank; it has no front")
    return _lengths_over_time(frames, scene, names, "position", "Front and top of the liquid")


def center(frames: Frames, scene: SphScene) -> Figure:
    """The center of mass."""
    axes = AXES[: len(scene.tank.low)]
    names = {f"center_{axis}": axis for axis in axes}
    if scene.second_liquid is not None:
        names = {f"{one}_center_{axis}": f"{one} liquid, {axis}" for one in ("first", "second") for axis in axes}
    return _lengths_over_time(frames, scene, names, "center of mass", "Center of mass")


def _lengths_over_time(frames: Frames, scene: SphScene, names: Mapping[str, str], label: str, title: str) -> Figure:
    shown = evolution(frames)
    curves = series(shown, *map(number, names))
    scale = scale_for(float(np.abs(curves).max()), "m")
    with style():
        drawn = figure()
        axes = over_time(drawn, scene, title)
        for values, name, color in zip(curves, names.values(), PALETTE, strict=False):
            axes.plot(times(shown), scale.factor * values, color=color, label=name)
        axes.set_ylabel(f"{label} ({scale.unit})")
        legend_outside(axes)
    return drawn


def snapshot(frames: Frames, scene: SphScene) -> Figure:
    """The last frame, as movies show it."""
    return liquid_picture(scene, [frames[-1]]).figure


def velocity(frames: Frames, scene: SphScene) -> Figure:
    """Velocities along two lines through the middle of the tank: u along the vertical one, v (or w in tanks in which z
    points up) along the horizontal one.
    """
    chosen = [frame for frame in _instants(frames, 3) if len(frame.arrays["position"])]
    if not chosen:
        raise BadInput("all liquid has left the tank at the times of this figure")
    level = [_along(frame, scene, axis=0) for frame in chosen]
    axis = scene.up_axis
    upright = [_along(frame, scene, axis) for frame in chosen]
    lengths = scale_for(float(np.abs(scene.tank.high).max()), "m")
    fast_u = max(np.nanmax(np.abs(profile.values[:, 0]), initial=0.0) for profile in upright)
    fast_v = max(np.nanmax(np.abs(profile.values[:, axis]), initial=0.0) for profile in level)
    u_scale, v_scale = scale_for(float(fast_u), "m/s"), scale_for(float(fast_v), "m/s")
    with style():
        drawn = figure(7.6, 3.8)
        left, right = drawn.subplots(1, 2)
        for frame, up, flat, color in zip(chosen, upright, level, PALETTE, strict=False):
            label = f"{frame.time:.4g} s"
            left.plot(u_scale.factor * up.values[:, 0], lengths.factor * up.points[:, axis], color=color, label=label)
            right.plot(
                lengths.factor * flat.points[:, 0], v_scale.factor * flat.values[:, axis], color=color, label=label
            )
        middle, level_at = 0.5 * (scene.tank.low[0] + scene.tank.high[0]), level[-1].points[0, axis]
        left.set(xlabel=f"u ({u_scale.unit})", ylabel=f"{scene.up} ({lengths.unit})")
        left.set_title(f"u along the line x = {lengths.factor * middle:.3g} {lengths.unit}")
        rise = "v" if scene.up == "y" else "w"
        right.set(xlabel=f"x ({lengths.unit})", ylabel=f"{rise} ({v_scale.unit})")
        right.set_title(f"{rise} along the line {scene.up} = {lengths.factor * level_at:.3g} {lengths.unit}")
        drawn.suptitle(titled("Velocity", scene), x=0.01, ha="left", fontsize=10)
        legend_outside(right)
    return drawn


def _along(frame: Frame, scene: SphScene, axis: int) -> Profile:
    """The velocity through the middle of the tank along an axis."""
    low, high = np.array(scene.tank.low), np.array(scene.tank.high)
    ends = np.tile(0.5 * (low + high), (2, 1))
    if axis == 0:
        # At half the height of the liquid, since the tank may contain air.
        ends[:, scene.up_axis] = np.median(frame.arrays["position"][:, scene.up_axis])
    ends[:, axis] = low[axis], high[axis]
    return velocity_profile(frame, (ends[0], ends[1]), POINTS, REACH * scene.spacing)


def surface(frames: Frames, scene: SphScene) -> Figure:
    """The outline of the liquid at several instants."""
    if len(scene.tank.low) != 2:
        raise BadInput("outlines are drawn of liquids in 2D; this one is in 3D")
    chosen = _instants(frames, INSTANTS)
    outlines = [free_lines(scene, frame) for frame in chosen]
    if not any(outlines):
        raise BadInput("the liquid fills the tank: it has no free surface")
    corners = rectangle(scene.tank.low, scene.tank.high)
    scale = scale_for(float(np.abs(corners).max()), "m")
    with style():
        drawn = figure()
        axes = drawn.add_subplot(title=titled("Free surface", scene), aspect="equal")
        for frame, lines, color in zip(chosen, outlines, PALETTE, strict=False):
            _lines(axes, lines, scale, color, f"{frame.time:.4g} s")
        closed = scale.factor * corners[[0, 1, 2, 3, 0]]
        if any(getattr(scene.tank, side).kind != "open" for side in scene.sides):
            axes.plot(*closed.T, color=RIM, linewidth=0.8, linestyle=":")
        axes.set(xlabel=f"x ({scale.unit})", ylabel=f"y ({scale.unit})")
        legend_outside(axes)
    return drawn


def _lines(axes: Axes, lines: Sequence[Array], scale: Scale, color: str, label: str) -> None:
    """Draw lines of one color with one entry in the legend."""
    for index, line in enumerate(lines):
        axes.plot(*(scale.factor * line).T, color=color, label=label if index == 0 else None)


def gauges(frames: Frames, scene: SphScene) -> Figure:
    """The readings of the gauges over time: pressures, levels and velocities, with one panel each; from the samples
    between frames if the run has them.
    """
    shown = evolution(frames)
    panels = {kind: [name for name in shown[0].numbers if name in _readings(scene, kind)] for kind in GAUGE_UNITS}
    panels = {kind: names for kind, names in panels.items() if names}
    if not panels:
        raise BadInput("the scene has no gauges; write a [[gauges]] table with name and place")
    with style():
        drawn = figure(6.4, 1.4 + 2.2 * len(panels))
        for axes, (kind, names) in zip(
            drawn.subplots(len(panels), 1, squeeze=False)[:, 0], panels.items(), strict=True
        ):
            instants, curves = _over_time(frames, shown, names)
            low, high = limits_without_spikes(curves)
            scale = scale_for(max(abs(low), abs(high)), GAUGE_UNITS[kind])
            for values, name, color in zip(curves, names, itertools.cycle(PALETTE), strict=False):
                axes.plot(instants, scale.factor * values, color=color, label=plain(name.replace("_" + kind, "")))
            axes.margins(x=0)
            cut_spikes(axes, instants, scale.factor * np.array(curves), scale.unit)
            axes.set_ylabel(f"{kind.replace('_', ' ')} ({scale.unit})")
            if single_readings(frames, scene, kind, names):
                axes.text(0.99, 0.96, SINGLE, transform=axes.transAxes, ha="right", va="top", color=MUTED, fontsize=8)
            legend_outside(axes)
        drawn.axes[0].set_title(titled("Gauges", scene))
        drawn.axes[-1].set_xlabel("time (s)")
    return drawn


MOST_SOLIDS = 6
"""Panels of a figure of forces, of the solids with the largest ones."""


def forces(frames: Frames, scene: SphScene) -> Figure:
    """The forces of the liquid on obstacles and bodies over time, with one panel each, for at most the six with the
    largest forces; in a tank without solids, on its sides; from the samples between frames if the run has them.
    """
    shown = evolution(frames)
    known = [name.removesuffix("_force_x") for name in shown[0].numbers if name.endswith("_force_x")]
    solids = [name for name in known if name not in scene.sides] or known
    if not solids:
        raise BadInput("all sides are open or periodic, and nothing stands in the tank; no force to draw")
    of_solids = {}
    for solid in solids:
        names = [name for axis in AXES if (name := f"{solid}_force_{axis}") in shown[0].numbers]
        of_solids[solid] = (names, *_over_time(frames, shown, names))
    largest = {solid: float(np.abs(curves).max()) for solid, (_, _, curves) in of_solids.items()}
    drawn_ones = sorted(sorted(solids, key=lambda one: -largest[one])[:MOST_SOLIDS], key=solids.index)
    left_out = f"the largest, on {len(drawn_ones)} of {len(solids)} solids" if len(solids) > MOST_SOLIDS else ""
    with style():
        drawn = figure(6.4, 1.4 + 2.2 * len(drawn_ones))
        panels = drawn.subplots(len(drawn_ones), 1, squeeze=False)[:, 0]
        for axes, solid in zip(panels, drawn_ones, strict=True):
            names, instants, curves = of_solids[solid]
            scale = scale_for(float(np.abs(curves).max()), shown[0].units[names[0]])
            for values, axis, color in zip(curves, AXES, PALETTE, strict=False):
                axes.plot(instants, scale.factor * values, color=color, label=f"{solid}, {axis}")
            axes.margins(x=0)
            axes.set_ylabel(f"force ({scale.unit})")
            legend_outside(axes)
        panels[0].set_title(titled(f"Forces: {left_out}" if left_out else "Forces", scene))
        panels[-1].set_xlabel("time (s)")
    return drawn


SINGLE = "single readings: at impacts only averages are meaningful"
"""The remark on pressures of an incompressible liquid with a free surface, which grow at impacts as steps shorten."""


def single_readings(frames: Frames, scene: SphScene, kind: str, names: Sequence[str]) -> bool:
    """Whether a kind of gauge reads pressures to which this remark applies."""
    if GAUGE_UNITS[kind] != "Pa" or pressure_of(scene).compressible or not free_surface(scene):
        return False
    sampled, spec = samples_of(frames), scene.output.samples
    return sampled is None or not set(names) <= set(sampled.names) or spec is None or spec.block == 1


def _over_time(frames: Frames, shown: Sequence[Frame], names: Sequence[str]) -> tuple[Array, list[Array]]:
    """Times and numbers: those sampled between frames if all numbers were sampled, otherwise those of frames."""
    sampled = samples_of(frames)
    if sampled is not None and set(names) <= set(sampled.names):
        return sampled.times, [sampled.mean(name) for name in names]
    return times(shown), list(series(shown, *map(number, names)))


GAUGE_UNITS = {"pressure": "Pa", **dict.fromkeys(DERIVED, "Pa"), "level": "m", "velocity": "m/s"}


def _readings(scene: SphScene, kind: str) -> set[str]:
    """The names of the numbers from gauges of a kind."""
    components = [f"_{axis}" for axis in AXES] if kind == "velocity" else [""]
    rows = [(gauge, range(1, (gauge.count or 0) + 1)) for gauge in scene.gauges if kind in gauge.quantities]
    names = [gauge.name if gauge.end is None else f"{gauge.name}_{n}" for gauge, row in rows for n in row or (0,)]
    return {f"{name}_{kind}{component}" for name in names for component in components}


def _instants(frames: Frames, count: int) -> list[Frame]:
    """Frames from the first to the last at equal distances."""
    return [frames[int(index)] for index in np.unique(np.linspace(0, len(frames) - 1, count).round())]


SPH_FIGURES: Mapping[str, Any] = {
    "energies": energies,
    "kinetic-energy": kinetic_energy,
    "pressure": pressure,
    "dynamic-pressure": dynamic_pressure,
    "front": front,
    "center": center,
    "snapshot": snapshot,
    "velocity": velocity,
    "surface": surface,
    "gauges": gauges,
    "forces": forces,
}
