"""The figures of liquids made of particles; `docs/figures.py` draws them."""

from __future__ import annotations

import dataclasses
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from ecume.laws import hydrostatics, states
from ecume.laws.flows import channel_speed
from ecume.laws.kernels import Kernel, kernel
from ecume.scenes.load import load_scene
from ecume.scenes.schema import from_plain, to_plain
from ecume.show.picture import Size
from ecume.show.sph.liquid import Water
from ecume.show.sph.picture import liquid_picture
from ecume.show.sph.solids import movers_of
from ecume.show.style import INK, MUTED, PALETTE, figure
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume.units import Array

TEMPLATES = Path(__file__).parents[1] / "src" / "ecume" / "templates"

DRAWN = {
    "cubic-spline": ("-", PALETTE[0]), "quartic-spline": ("-", PALETTE[4]), "quintic-spline": ("-", PALETTE[3]),
    "liu-quartic": ("--", PALETTE[0]), "wendland-c2": ("-", PALETTE[1]), "wendland-c4": ("--", PALETTE[1]),
    "wendland-c6": (":", PALETTE[1]), "gaussian": ("-", PALETTE[2]),
}  # fmt: skip
"""Lucy's has a support of one h, and would be off the scale."""


def kernels() -> Figure:
    """Kernels in a plane, and their slopes."""
    drawn = figure(9.0, 3.8)
    left, right = drawn.subplots(1, 2)
    q = np.linspace(0.0, 3.0, 601)
    for name, (dashes, color) in DRAWN.items():
        one = quiet(name)
        left.plot(q, one.value(q, 1.0), dashes, color=color, label=name)
        right.plot(q, one.slope(q, 1.0), dashes, color=color)
    left.set(xlabel="distance / h", ylabel="W h²", xlim=(0, 3), ylim=(-0.02, 0.92))
    left.set_title("Kernels in 2D")
    left.legend()
    right.set(xlabel="distance / h", ylabel="dW/dr h³", xlim=(0, 3))
    right.set_title("Derivatives: zero at the center")
    return drawn


def branches() -> Figure:
    """What is left of a spline when its innermost branch is used everywhere; and a quartic that turns negative."""
    drawn = figure(9.4, 3.4)
    axes = drawn.subplots(1, 3)
    q = np.linspace(0.0, 3.0, 601)
    _beside(axes[0], "cubic-spline", q[q <= 2.0], 2.0 / 3.0 - q**2 + 0.5 * q**3)
    axes[0].set_title("Cubic: integral 16/7")
    axes[0].set_ylim(-0.02, 0.6)
    _beside(axes[1], "quintic-spline", q, (3.0 - q) ** 5 - 6.0 * (2.0 - q) ** 5 + 15.0 * (1.0 - q) ** 5)
    axes[1].set_title("Quintic: integral −11.6")
    axes[1].set_ylim(-0.45, 0.45)
    tail = np.linspace(1.5, 2.05, 200)
    for name in ("liu-quartic", "cubic-spline", "wendland-c2"):
        dashes, color = DRAWN[name]
        axes[2].plot(tail, quiet(name).value(tail, 1.0), dashes, color=color, label=name)
    axes[2].axhline(0.0, color=MUTED, linewidth=0.8)
    axes[2].set(xlabel="distance / h", ylim=(-0.0015, 0.012))
    axes[2].set_title("Liu, Liu and Lam: negative tail")
    axes[2].legend()
    return drawn


def _beside(axes: Axes, name: str, q: Array, bracket: Array) -> None:
    one = quiet(name)
    axes.plot(q, one.normalization * bracket[: len(q)], "--", color=PALETTE[0], label="innermost branch only")
    axes.plot(q, one.value(q, 1.0), color=PALETTE[1], label=name)
    axes.axhline(0.0, color=MUTED, linewidth=0.8)
    axes.set(xlabel="distance / h", ylabel="W h²")
    axes.legend()


def pressure() -> Figure:
    """A tank at rest: what Tait's law gives, what the sum with the hydrostatic part gives; and how short it is."""
    drawn = figure(9.0, 3.6)
    left, right = drawn.subplots(1, 2)
    height = np.linspace(0.0, 1.0, 101)
    top = hydrostatics.column_height(1.0, 1.0, 1.0, 10.0)
    depth = [max(top - y, 0.0) for y in height]
    density = np.array([hydrostatics.hydrostatic_density(d, 1.0, 1.0, 10.0) for d in depth])
    tait = states.tait_pressure(density, 1.0, 10.0)
    both = hydrostatics.absolute_pressure(density, height, 1.0, reference_density=1.0, sound_speed=10.0, gravity=1.0)
    left.plot(tait, height, color=PALETTE[1], label="Tait's law only")
    left.plot(both, height, "--", color=PALETTE[0], label="with ρ g (H − y) added")
    exact = hydrostatics.hydrostatic_pressure(height, 1.0, 1.0, 1.0)
    left.plot(exact, height, ":", color=INK, linewidth=2.2, label="ρ₀ g (H − y)")
    left.set(xlabel="pressure / ρ₀ g H", ylabel="height / H", xlim=(0, 2.05), ylim=(0, 1))
    left.set_title("Tank at rest")
    left.legend()
    speeds = np.geomspace(5.0, 50.0, 60)
    for exponent, dashes in ((7.0, "-"), (1.0, "--")):
        short = [100.0 * (1.0 - hydrostatics.column_height(1.0, 1.0, 1.0, c, exponent)) for c in speeds]
        right.plot(speeds, short, dashes, color=PALETTE[1], label=f"γ = {exponent:g}")
    right.set(xscale="log", yscale="log", xlabel="c₀ / √(gH)", ylabel="compression (%)")
    right.set_xticks([5, 10, 20, 50], labels=["5", "10", "20", "50"])
    right.minorticks_off()
    right.set_title("Compression of a column")
    right.legend()
    return drawn


def quiet(name: str) -> Kernel:
    """The kernel in a plane, without the warning that `liu-quartic` gives."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return kernel(name, 2)


def simulated(plain: dict[str, Any]) -> list[Frame]:
    """All frames of a scene."""
    return list(simulate(scene_of(plain)))


def scene_of(plain: dict[str, Any]) -> Any:
    """The scene of some keys."""
    return from_plain({"model": "sph", **plain})


def liquid(axes: Axes, scene: Any, frame: Frame, values: Array, scale: ScalarMappable) -> None:
    """The liquid of a frame as a continuous region, colored by values; the axes must have their limits."""
    shades: Any = scale.to_rgba
    Water(axes, scene).put(frame, np.asarray(values, float)[:, None], lambda means: shades(means[..., 0]))
    axes.set_aspect("equal")
    axes.set_axis_off()


def scale_to(high: float) -> ScalarMappable:
    """Colors from 0 to a value."""
    return ScalarMappable(Normalize(0.0, high), "viridis")


def walls() -> Figure:
    """A jittered tank held by mirrors, by dummies, and by nothing but reflection."""
    drawn, scale = figure(9.0, 3.4), scale_to(1.0)
    for axes, kind in zip(drawn.subplots(1, 3), ("mirror", "dummy", "reflect"), strict=True):
        tank = {"low": [0.0, 0.0], "high": [1.0, 1.25], "top": {"kind": "open"}, "walls": kind}
        plain = {
            "duration": 0.8, "frame_every": 0.8, "spacing": 1.0 / 24, "gravity": [0.0, -1.0], "tank": tank,
            "liquid": {"density": 1.0, "sound_speed": 10.0}, "method": {"jitter": 0.2},
            "fluid": [{"low": [0.0, 0.0], "high": [1.0, 1.0]}],
        }  # fmt: skip
        last = simulated(plain)[-1]
        axes.set(xlim=(-0.03, 1.03), ylim=(-0.03, 1.12))
        liquid(axes, scene_of(plain), last, last.arrays["pressure"], scale)
        axes.plot([0, 0, 1, 1], [1.1, 0, 0, 1.1], color=INK, linewidth=1.2)
        axes.set_title(f"{kind}: {last.numbers['guard_hits']:.0f} penetrations")
    drawn.colorbar(scale, ax=drawn.axes, label="pressure / ρ g H", shrink=0.8)
    return drawn


def bodies() -> Figure:
    """The template with bodies, at three instants."""
    drawn, scale = figure(9.4, 2.6), scale_to(3.0)
    plain = to_plain(load_scene(TEMPLATES / "floating-bodies.toml")) | {"duration": 0.9, "frame_every": 0.3}
    frames, scene = simulated(plain), from_plain(plain)
    outlines = movers_of(scene)
    names = (*scene.body_names, *scene.obstacle_names)
    for axes, frame in zip(drawn.subplots(1, 3), [frames[0], frames[1], frames[3]], strict=True):
        axes.set(xlim=(-0.03, 1.23), ylim=(-0.03, 0.72))
        liquid(axes, scene, frame, 1e-3 * frame.arrays["pressure"], scale)
        solids = (*(outlines(frame) if outlines else ()), np.array(scene.obstacles[0].vertices))
        for outline, name in zip(solids, names, strict=True):
            axes.add_patch(Polygon(outline, facecolor="#e8e4da", edgecolor=INK, linewidth=1.0, zorder=2))
            axes.annotate(name, outline.mean(axis=0), ha="center", va="center", fontsize=7, zorder=3)
        axes.plot([0, 0, 1.2, 1.2], [0.7, 0, 0, 0.7], color=INK, linewidth=1.2)
        axes.set_title(f"{frame.time:.1f} s")
    drawn.colorbar(scale, ax=drawn.axes, label="pressure (kPa)", shrink=0.8)
    return drawn


def gates() -> Figure:
    """A channel: what flows in evenly becomes a parabola."""
    drawn = figure(9.4, 3.0)
    left, right = drawn.subplots(1, 2, width_ratios=[1.7, 1.0])
    plain = to_plain(load_scene(TEMPLATES / "channel.toml")) | {"duration": 3.0, "frame_every": 1.0}
    last = simulated(plain)[-1]
    (x, y), speed = last.arrays["position"].T, last.arrays["velocity"][:, 0]
    left.set(xlim=(0.0, 3.0), ylim=(-0.03, 1.03))
    liquid(left, scene_of(plain), last, speed, scale_to(1.5))
    drawn.colorbar(scale_to(1.5), ax=left, label="speed (m/s)", shrink=0.8)
    left.plot([0, 3], [0, 0], color=INK)
    left.plot([0, 3], [1, 1], color=INK)
    for place, color in zip((0.1, 0.5, 2.0), PALETTE, strict=False):
        here = np.abs(x - place) < 0.06
        right.plot(speed[here], y[here], ".", color=color, label=f"at {place:g} m")
    height = np.linspace(0.0, 1.0, 60)
    right.plot([channel_speed(h, 1.0, 1.0) for h in height], height, color=INK, label="parabola")
    right.set(xlabel="speed (m/s)", ylabel="height (m)", xlim=(0, 1.6), ylim=(0, 1))
    right.legend()
    return drawn


def dam_break() -> Figure:
    """The template's dam break when its wave has climbed the wall and falls back, as its movie shows it."""
    scene = load_scene(TEMPLATES / "dam-break.toml")
    frames = list(simulate(dataclasses.replace(scene, duration=1.08)))
    picture = liquid_picture(scene, frames[::12], Size(960, 560))
    picture.show(frames[-1])
    return picture.figure


def tension() -> Figure:
    """A square drop draws itself together."""
    drawn, scale = figure(9.4, 2.9), scale_to(120.0)
    plain = to_plain(load_scene(TEMPLATES / "rounding-drop.toml")) | {"frame_every": 0.005}
    frames = simulated(plain)
    panels = drawn.subplots(1, 4)
    for axes, number in zip(panels, (0, 1, 2, -1), strict=True):
        speed = 1e3 * np.linalg.norm(frames[number].arrays["velocity"], axis=1)
        axes.set(xlim=(-2e-3, 2e-3), ylim=(-2e-3, 2e-3))
        liquid(axes, scene_of(plain), frames[number], speed, scale)
        axes.set_title(f"{1e3 * frames[number].time:.0f} ms", y=0.93)
    drawn.colorbar(scale, ax=panels, label="speed (mm/s)", shrink=0.7)
    return drawn


PLATE = {
    "duration": 0.08, "frame_every": 0.08, "spacing": 1e-4, "gravity": [0.0, 0.0],
    "tank": {
        "low": [-3e-3, 0.0], "high": [3e-3, 2.4e-3],
        "left": {"kind": "open"}, "right": {"kind": "open"}, "top": {"kind": "open"},
    },
    "liquid": {"viscosity": 0.02, "surface_tension": 0.0728, "maximum_speed": 0.5},
    "fluid": [{"low": [-1e-3, 0.0], "high": [1e-3, 1e-3]}],
}  # fmt: skip


def wetting() -> Figure:
    """Drops on mirrors and on dummies, from a block, beside segments of circles with the contact angle."""
    drawn, scale = figure(9.4, 3.8), scale_to(200.0)
    cases = (("mirror", 30), ("mirror", 60), ("mirror", 120), ("dummy", 60), ("dummy", 90), ("dummy", 120))
    panels = drawn.subplots(2, 3)
    for axes, (walls, degrees) in zip(panels.flat, cases, strict=True):
        angle = np.deg2rad(degrees)
        plain = PLATE | {"tank": PLATE["tank"] | {"walls": walls}, "liquid": PLATE["liquid"] | {"contact_angle": angle}}
        frame = simulated(plain)[-1]
        liquid(axes, scene_of(plain), frame, frame.arrays["pressure"], scale)
        turns = np.linspace(-angle, angle, 200)
        radius = 1e3 * np.sqrt(2e-6 / (angle - np.sin(angle) * np.cos(angle)))
        axes.plot(radius * np.sin(turns) / 1e3, radius * (np.cos(turns) - np.cos(angle)) / 1e3, color=INK, lw=1.0)
        axes.set(xlim=(-2.6e-3, 2.6e-3), ylim=(0.0, 2.0e-3))
        axes.set_title(f"{walls}, {degrees}°", y=0.93)
    drawn.colorbar(scale, ax=panels, label="pressure (Pa)", shrink=0.7)
    return drawn


CARRYING = {
    "model": "sph", "duration": 0.5, "frame_every": 0.25, "spacing": 0.015,
    "tank": {"low": [0.0, 0.0], "high": [1.0, 0.6], "top": {"kind": "open"}},
    "fluid": [{"low": [0.0, 0.0], "high": [0.4, 0.3]}],
    "liquid": {"viscosity": 1e-3, "maximum_speed": 3.0},
    "method": {"turbulence": "smagorinsky"},
    "passive_tracers": [
        {"count": 60, "low": [0.05, 0.05], "high": [0.35, 0.25], "turbulent_dispersion": True},
        {"count": 60, "low": [0.05, 0.05], "high": [0.35, 0.25], "radius": 1e-3, "density": 2500.0},
    ],
}  # fmt: skip


def carried() -> Figure:
    """Tracers and grains in a dam that breaks."""
    drawn = figure(9.4, 3.0)
    frames = simulated(CARRYING)
    water = ScalarMappable(Normalize(0.0, 1.0), ListedColormap(["#c9d6e2"]))
    for axes, frame in zip(drawn.subplots(1, 3), frames, strict=True):
        kind, (x, y) = frame.arrays["species"], frame.arrays["position"].T
        axes.set(xlim=(0, 1), ylim=(0, 0.6))
        alone = frame._replace(arrays={name: array[kind == 0] for name, array in frame.arrays.items()})
        liquid(axes, scene_of(CARRYING), alone, np.zeros(len(alone.arrays["mass"])), water)
        for number, color, label in ((1, PALETTE[0], "tracers"), (2, PALETTE[1], "sand")):
            axes.scatter(x[kind == number], y[kind == number], s=9, color=color, label=label, linewidths=0, zorder=2)
        axes.plot([0, 0, 1, 1], [0.6, 0, 0, 0.6], color=INK, linewidth=1.2)
        axes.set_title(f"{frame.time:.2f} s")
    axes.legend(loc="upper left")
    return drawn


UNQUIET = {
    "model": "sph", "duration": 40.0, "frame_every": 2.0, "spacing": 1.0 / 16, "gravity": [0.0, -1.0],
    "tank": {"low": [0.0, 0.0], "high": [1.0, 1.6], "top": {"kind": "open"}},
    "fluid": [{"low": [0.0, 0.0], "high": [1.0, 1.0]}],
    "liquid": {"density": 1.0, "sound_speed": 10.0, "maximum_speed": 1.0},
}  # fmt: skip


def schemes() -> Figure:
    """Pressures by diffusion; speeds by integrator and precision."""
    drawn = figure(9.4, 3.6)
    left, right = drawn.subplots(1, 2)
    for name, color in zip(("none", "molteni", "antuono", "linear", "hydrostatic"), PALETTE, strict=False):
        last = simulated({**UNQUIET, "method": {"jitter": 0.2, "density_diffusion": name}})[-1]
        height = last.arrays["position"][:, 1]
        left.scatter(last.arrays["pressure"] - (1.0 - height), height, s=5, color=color, label=name, linewidths=0)
    left.set(xlabel="(pressure − hydrostatic) / ρgH", ylabel="height / H", xlim=(-0.35, 0.35))
    left.set_title("Density diffusion")
    left.legend(loc="upper left")
    looks = (("symplectic", "double", "-"), ("verlet", "double", "--"), ("symplectic", "single", ":"))
    for color, (integrator, precision, dashes) in zip(PALETTE, looks, strict=False):
        steps = {"integration": {"integrator": integrator}}
        frames = simulated({**UNQUIET, "method": {"jitter": 0.2, "precision": precision}, **steps})[1:]
        speeds = [float(np.sqrt((frame.arrays["velocity"] ** 2).sum(axis=1).mean())) for frame in frames]
        label = f"{integrator}, {precision}"
        right.semilogy([frame.time for frame in frames], speeds, dashes, color=color, label=label)
    right.set(xlabel="time · √(g/H)", ylabel="r.m.s. speed / √(gH)")
    right.set_title("Integrators and precision")
    right.legend()
    return drawn


FIGURES: dict[str, Callable[[], Figure]] = {
    "dam-break": dam_break,
    "sph-kernels": kernels,
    "sph-branches": branches,
    "sph-pressure": pressure,
    "sph-walls": walls,
    "sph-bodies": bodies,
    "sph-channel": gates,
    "sph-tension": tension,
    "sph-wetting": wetting,
    "sph-carried": carried,
    "sph-schemes": schemes,
}
