"""A small picture of every option of a tank: solids, motions, openings and gauges.

Every scene here takes seconds; `docs/figures.py` draws them with all others.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from figures_sph import liquid, scale_to, scene_of, simulated
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch, Polygon, Rectangle
from matplotlib.transforms import Affine2D

from ecume._quick import sized
from ecume.models.sph.setup.initial_particles import cells_of, unaligned_solids
from ecume.models.sph.setup.packing import packed, unevenness
from ecume.models.sph.setup.shapes import obstacle_dummies, shape_of
from ecume.scenes.schema import from_plain
from ecume.scenes.sph import SphScene
from ecume.show.picture import Size
from ecume.show.sph.liquid import surface_of
from ecume.show.sph.picture import liquid_picture
from ecume.show.style import INK, MUTED, PALETTE, figure
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume.units import Array

OPEN, FREE = {"kind": "open"}, {"slip": "free"}
SOLID = {"facecolor": "#e8e4da", "edgecolor": INK, "linewidth": 1.0, "zorder": 2}
WATER = {"density": 1.0, "sound_speed": 10.0, "maximum_speed": 1.4}


def tank(width: float, height: float, **sides: Any) -> dict[str, Any]:
    """An open tank from the origin on."""
    return {"low": [0.0, 0.0], "high": [width, height], "top": OPEN, **sides}


def pool(width: float, depth: float, **changes: Any) -> dict[str, Any]:
    """A scene of liquid that fills an open tank to a depth, in units of 1 for depth and gravity."""
    return {
        "duration": 2.0, "frame_every": 0.5, "spacing": 0.05, "gravity": [0.0, -1.0], "liquid": WATER,
        "tank": tank(width, 2.0 * depth), "fluid": [{"low": [0.0, 0.0], "high": [width, depth]}], **changes,
    }  # fmt: skip


def by_speed(axes: Axes, plain: dict[str, Any], frame: Frame, fastest: float, box: tuple[float, float]) -> None:
    """The liquid of a scene's frame by its speed, in a box from the origin."""
    axes.set(xlim=(-0.03, box[0] + 0.03), ylim=(-0.03, box[1]))
    speed = np.linalg.norm(frame.arrays["velocity"], axis=1)
    liquid(axes, scene_of(plain), frame, speed, scale_to(fastest))
    axes.plot([0, 0, box[0], box[0]], [box[1], 0, 0, box[1]], color=INK, linewidth=1.0)


def sides() -> Figure:
    """What a side can be, and what a wall of the tank does to whom it turns back."""
    drawn = figure(11.0, 4.6)
    panels = drawn.subplots(2, 3).ravel()
    flat = {"low": [0.0, 0.0], "high": [0.8, 0.8]}
    kinds = {
        'kind = "wall"': tank(2.0, 1.2),
        'kind = "open"': tank(2.0, 1.2, right=OPEN),
        'kind = "periodic"': tank(2.0, 1.2, left={"kind": "periodic"}, right={"kind": "periodic"}),
    }
    for axes, (title, one) in zip(panels, kinds.items(), strict=False):
        plain = pool(2.0, 0.6, tank=one, fluid=[flat], duration=1.8, frame_every=1.8)
        by_speed(axes, plain, simulated(plain)[-1], 1.4, (2.0, 1.2))
        axes.set_title(f"{title}, t = 1.8")
    panels[1].plot([2.0, 2.0], [0.02, 1.2], color="white", linewidth=2.0)
    for restitution, color in zip((0.0, 1.0), PALETTE, strict=False):
        one = tank(1.0, 1.2, walls="reflect", restitution=restitution)
        frames = simulated(pool(1.0, 0.6, tank=one, duration=3.0, frame_every=0.05, method={"jitter": 0.2}))
        height = [frame.numbers["center_y"] for frame in frames]
        panels[3].plot([frame.time for frame in frames], height, color=color, label=f"restitution = {restitution:g}")
    panels[3].set(xlabel="time", ylabel="height of the center", title='walls = "reflect"')
    panels[3].legend()
    leaving = {"low": [0.0, 0.2], "high": [0.5, 0.8], "velocity": [0.3, 0.0]}
    for axes, clip in zip(panels[4:], (True, False), strict=True):
        one = tank(1.2, 1.0, walls="dummy")
        changes = {"gravity": [0.0, 0.0], "fluid": [leaving], "duration": 0.8, "frame_every": 0.8}
        plain = pool(1.2, 0.5, tank=one, method={"nonnegative_wall_pressure": clip}, **changes)
        by_speed(axes, plain, simulated(plain)[-1], 0.5, (1.2, 1.0))
        axes.set_title(f"nonnegative_wall_pressure = {str(clip).lower()}")
    return drawn


def pulls() -> Figure:
    """Gravity askew; a pull to a point; a tank that is shaken by a sine and by a table; a side that moves."""
    drawn = figure(11.0, 4.8)
    for axes, draw in zip(drawn.subplots(2, 2).ravel(), (askew, to_a_point, shaken, driven), strict=True):
        draw(axes)
    return drawn


def askew(axes: Axes) -> None:
    """A surface that stands across gravity."""
    thick = {"artificial_viscosity": 0.3}
    plain = pool(2.0, 0.6, gravity=[0.25, -0.97], method=thick, duration=8.0, frame_every=8.0)
    by_speed(axes, plain, simulated(plain)[-1], 0.3, (2.0, 1.2))
    axes.plot([0.0, 2.0], [0.6 - 0.25 / 0.97, 0.6 + 0.25 / 0.97], color=PALETTE[1])
    axes.set_title("gravity = [0.25, −0.97], t = 8")


def to_a_point(axes: Axes) -> None:
    """A square that becomes round."""
    square = {"low": [-0.5, -0.5], "high": [0.5, 0.5]}
    around = dict.fromkeys(("left", "right", "bottom", "top"), OPEN)
    free = {"low": [-1.0, -1.0], "high": [1.0, 1.0], **around}
    drop = {"fluid": [square], "gravity": [0.0, 0.0], "central_force": {"angular_frequency": 1.0, "center": [0.0, 0.0]}}
    plain = pool(1.0, 0.5, tank=free, duration=6.0, frame_every=3.0, **drop)
    for frame, shift in zip(simulated(plain), (-1.4, 0.0, 1.4), strict=True):
        outline = surface_of(scene_of(plain), frame, np.zeros((len(frame.arrays["position"]), 0))).outline()
        axes.add_patch(PathPatch(outline.transformed(Affine2D().translate(shift, 0.0)), facecolor=PALETTE[1]))
        axes.text(shift, -0.95, f"t = {frame.time:g}", ha="center")
    axes.set(aspect="equal", xlim=(-2.2, 2.2), ylim=(-1.1, 0.8), title="central_force: a square drop")
    axes.set_axis_off()


def shaken(axes: Axes) -> None:
    """The level in tanks that are shaken in two ways."""
    ways = {
        "amplitude, frequency": {"amplitude": [0.1, 0.0], "frequency": 0.19},
        "times, accelerations": {"times": [0.0, 2.0, 2.01], "accelerations": [[0.2, 0.0], [0.2, 0.0], [0.0, 0.0]]},
    }
    gauge = {"name": "side", "position": [0.0, 0.0], "quantities": ["level"]}
    for (label, shake), color in zip(ways.items(), PALETTE, strict=False):
        frames = simulated(pool(2.0, 0.6, base_excitation=shake, gauges=[gauge], duration=7.0, frame_every=0.1))
        level = [frame.numbers["side_level"] for frame in frames]
        axes.plot([frame.time for frame in frames], level, color=color, label=label)
    axes.set(xlabel="time", ylabel="level at the left side", title="[base_excitation]")
    axes.legend()


def driven(axes: Axes) -> None:
    """Waves of a side that moves in two ways."""
    motions = {
        "amplitude, frequency, phase": {"amplitude": 0.12, "frequency": 0.45, "phase": "90 deg"},
        "times, positions": {"times": [0.0, 1.5], "positions": [0.0, 0.5]},
    }
    for (label, motion), up in zip(motions.items(), (1.0, 0.0), strict=True):
        moved = tank(5.0, 1.0, left={"motion": motion})
        last = simulated(pool(5.0, 0.4, tank=moved, duration=5.0, frame_every=5.0, spacing=0.05))[-1]
        x, y = last.arrays["position"].T
        axes.scatter(x, y + up, s=3.0, c=np.linalg.norm(last.arrays["velocity"], axis=1), cmap="viridis", linewidths=0)
        axes.text(5.0, up + 0.62, label, ha="right")
    axes.set(aspect="equal", xlim=(-0.2, 5.05), ylim=(-0.05, 1.9), title="tank.left.motion, t = 5; color: speed")
    axes.set_axis_off()


def colors() -> Figure:
    """A film's picture of a tank in space: regions, an obstacle and a body by their own colors."""
    scene = from_plain({"model": "sph", **IN_SPACE})
    frames = list(simulate(scene))
    picture = liquid_picture(scene, frames, Size(820, 520), "region")
    picture.show(frames[-1])
    return picture.figure


IN_SPACE = {
    "duration": 0.25, "frame_every": 0.25, "spacing": 0.025, "title": "Regions, obstacle and body in their colors",
    "tank": {"low": [0.0, 0.0, 0.0], "high": [0.6, 0.4, 0.3], "top": OPEN, "front": FREE, "back": FREE},
    "fluid": [
        {"low": [0.0, 0.0, 0.0], "high": [0.2, 0.2, 0.15], "color": "#4682b4"},
        {"low": [0.0, 0.0, 0.15], "high": [0.2, 0.2, 0.3], "color": "#d9772b"},
    ],
    "obstacles": [{"low": [0.35, 0.0, 0.1], "high": [0.45, 0.15, 0.2], "color": "#8e44ad"}],
    "bodies": [{"center": [0.1, 0.26, 0.15], "radius": 0.05, "density": 300.0, "color": "#c0392b"}],
    "liquid": {"maximum_speed": 2.5},
}  # fmt: skip


def solids() -> Figure:
    """A hollow obstacle that holds a liquid; at the start, cylinders of each kind, and a body of triangles."""
    scenes = [from_plain({"model": "sph", **plain}) for plain in SOLIDS]
    return side_by_side([last_picture(scenes[0]), *(start_picture(scene) for scene in scenes[1:])])


def driven_bodies() -> Figure:
    """A gate that lifts, a stirrer that turns, and a flap that swings about its foot by a table."""
    return side_by_side([last_picture(from_plain({"model": "sph", **plain})) for plain in DRIVEN])


def last_picture(scene: SphScene) -> Array:
    """The liquid by its speed at the end of a scene: rows of pixels."""
    frames = list(simulate(scene))
    return liquid_picture(scene, frames, Size(512, 384), "speed").pixels(frames[-1]).copy()


def start_picture(scene: SphScene) -> Array:
    """The parts of a scene in their colors at its start: rows of pixels."""
    first = next(simulate(scene))
    return liquid_picture(scene, [first], Size(512, 384), "region").pixels(first).copy()


def side_by_side(pictures: list[Array]) -> Figure:
    """Pictures of one height in a row."""
    whole = np.concatenate(pictures, axis=1)
    drawn = Figure(figsize=(whole.shape[1] / 120, whole.shape[0] / 120), layout="none")
    drawn.add_axes((0.0, 0.0, 1.0, 1.0), frameon=False, xticks=[], yticks=[]).imshow(whole)
    return drawn


BASIN = {"duration": 1.0, "frame_every": 0.05, "spacing": 0.02, "liquid": {"maximum_speed": 3.0},
         "tank": {"low": [0.0, 0.0], "high": [1.2, 0.8], "top": OPEN}}  # fmt: skip
DRIVEN: tuple[dict[str, Any], ...] = (
    {
        **BASIN, "title": "motion: velocity, start, until", "duration": 0.45,
        "fluid": [{"low": [0.0, 0.0], "high": [0.4, 0.4]}],
        "bodies": [{"low": [0.4, 0.0], "high": [0.46, 0.7],
                    "motion": {"velocity": [0.0, 1.0], "start": 0.1, "until": 0.3}}],
    },
    {
        **BASIN, "title": "motion: spin", "fluid": [{"low": [0.0, 0.0], "high": [1.2, 0.5]}],
        "bodies": [{"low": [0.4, 0.24], "high": [0.8, 0.3], "motion": {"spin": 3.0}}],
    },
    {
        **BASIN, "title": "motion: times, angles, pivot", "fluid": [{"low": [0.3, 0.0], "high": [1.2, 0.4]}],
        "bodies": [{"low": [0.24, 0.04], "high": [0.3, 0.6], "motion": {
            "times": [0.0, 0.5, 1.0], "angles": [0.0, -0.4, 0.2], "pivot": [0.27, 0.04]}}],
    },
)  # fmt: skip

OCTAHEDRON = [
    [[0.3 + 0.1 * x, 0.2, 0.15], [0.3, 0.2 + 0.1 * y, 0.15], [0.3, 0.2, 0.15 + 0.1 * z]][:: x * y * z]
    for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)
]  # fmt: skip
"""Its faces, with their corners counterclockwise from outside."""
IN_A_BOX = {
    "duration": 0.2, "frame_every": 0.2, "spacing": 0.025, "liquid": {"maximum_speed": 2.5},
    "tank": {"low": [0.0, 0.0, 0.0], "high": [0.6, 0.4, 0.3], "top": OPEN, "front": FREE, "back": FREE},
}  # fmt: skip
SOLIDS: tuple[dict[str, Any], ...] = (
    {
        "title": "obstacles: hollow = true", "duration": 0.25, "frame_every": 0.25, "spacing": 0.02,
        "tank": {"low": [0.0, 0.0], "high": [1.2, 0.8], "top": OPEN},
        "fluid": [{"low": [0.2, 0.2], "high": [0.5, 0.6]}],
        "obstacles": [{"vertices": [[0.3, 0.1], [0.9, 0.1], [1.1, 0.8], [0.1, 0.8]], "hollow": True}],
        "liquid": {"maximum_speed": 3.0},
    },
    {
        **IN_A_BOX, "title": "axis: of liquid, an obstacle and a body",
        "fluid": [{"center": [0.12, 0.2, 0.125], "radius": 0.1, "axis": [0.0, 0.0, 0.25], "color": "#4682b4"}],
        "obstacles": [{"center": [0.4, 0.125, 0.15], "radius": 0.05, "axis": [0.0, 0.25, 0.0], "color": "#8e44ad"}],
        "bodies": [{"center": [0.27, 0.05, 0.15], "radius": 0.04, "axis": [0.0, 0.0, 0.16],
             "density": 500, "color": "#c0392b"}],
    },
    {
        **IN_A_BOX, "title": 'triangles: of a body; up = "z"', "up": "z",
        "fluid": [{"low": [0.0, 0.0, 0.0], "high": [0.6, 0.4, 0.15], "color": "#4682b4"}],
        "bodies": [{"triangles": OCTAHEDRON, "density": 300.0, "color": "#c0392b"}],
    },
)  # fmt: skip


def inlets() -> Figure:
    """Profiles of an inflow, a stream with a surface over a step, and the pressure at which liquid leaves."""
    drawn = figure(11.0, 4.8)
    panels = drawn.subplots(2, 2).ravel()
    for profile, color in zip(("uniform", "parabolic"), PALETTE, strict=False):
        left = {"kind": "inflow", "speed": 1.0, "profile": profile}
        last = simulated(channel(left, {"kind": "outflow"}))[-1]
        (x, y), speed = last.arrays["position"].T, last.arrays["velocity"][:, 0]
        panels[0].plot(speed[x < 0.15], y[x < 0.15], ".", color=color, label=f'profile = "{profile}"')
    panels[0].set(xlabel="speed near the inflow", ylabel="height", title="left.profile, speed = 1")
    panels[0].legend()
    for pressure, color in zip((0.0, 5.0), PALETTE, strict=False):
        last = simulated(channel({"kind": "inflow", "speed": 1.0}, {"kind": "outflow", "pressure": pressure}))[-1]
        panels[1].plot(last.arrays["position"][:, 0], last.arrays["pressure"], ".", color=color, markersize=3,
                       label=f"pressure = {pressure:g}")  # fmt: skip
    panels[1].set(xlabel="x", ylabel="pressure", title="right.pressure")
    panels[1].legend()
    gate = {"left": {"kind": "inflow", "speed": 0.5, "level": 0.6}, "right": {"kind": "outflow", "level": 0.6}}
    step = {"vertices": [[1.4, 0.0], [2.2, 0.0], [2.0, 0.25], [1.6, 0.25]], "slip": "free"}
    region = [{"low": [0.0, 0.0], "high": [4.0, 0.6], "velocity": [0.5, 0.0]}]
    stream = pool(4.0, 0.6, tank=tank(4.0, 1.0, **gate), obstacles=[step], fluid=region, duration=5.0)
    by_speed(panels[2], stream, simulated({**stream, "frame_every": 5.0})[-1], 1.2, (4.0, 0.9))
    panels[2].add_patch(Polygon(np.array(step["vertices"]), **SOLID))
    panels[2].set_title("Inflow and outflow with a level, over a step")
    drawn.colorbar(scale_to(1.2), ax=panels[2], label="speed", shrink=0.7)
    lid = {"low": [0.0, 0.0], "high": [1.0, 1.0], "top": {"velocity": [1.0, 0.0]}}
    viscous = {"density": 1.0, "viscosity": 0.02, "sound_speed": 10.0, "maximum_speed": 1.0}
    full = {"low": [0.0, 0.0], "high": [1.0, 1.0]}
    turned = pool(1.0, 1.0, tank=lid, fluid=[full], liquid=viscous, gravity=[0.0, 0.0], duration=4.0)
    last = simulated({**turned, "frame_every": 4.0})[-1]
    panels[3].quiver(*last.arrays["position"].T, *last.arrays["velocity"].T, color=PALETTE[0], scale=6.0, width=0.004)
    panels[3].set(aspect="equal", title="top.velocity: moving lid")
    panels[3].set_axis_off()
    return drawn


def channel(left: dict[str, Any], right: dict[str, Any]) -> dict[str, Any]:
    """A viscous liquid between plates."""
    room = {"low": [0.0, 0.0], "high": [2.0, 1.0], "left": left, "right": right}
    return {
        "duration": 3.0, "frame_every": 3.0, "spacing": 0.0625, "gravity": [0.0, 0.0], "tank": room,
        "fluid": [{"low": [0.0, 0.0], "high": [2.0, 1.0], "velocity": [1.0, 0.0]}],
        "liquid": {"density": 1.0, "viscosity": 0.1, "sound_speed": 15.0, "maximum_speed": 1.5},
        "method": {"shifting": "delta-plus"},
    }  # fmt: skip


def gauges() -> Figure:
    """Gauges in a dam that breaks: where they are, and what they read."""
    drawn = figure(11.0, 3.2)
    left, middle, right = drawn.subplots(1, 3, width_ratios=[1.6, 1.0, 1.0])
    probes = [
        {"name": "sensor", "position": [3.2, 0.05]},
        {"name": "post", "position": [2.0, 0.0], "quantities": ["level"]},
        {"name": "line", "position": [1.2, 0.0], "end": [1.2, 0.6], "count": 7, "quantities": ["velocity"]},
    ]
    dam = [{"low": [0.0, 0.0], "high": [1.0, 1.0]}]
    plain = pool(3.2, 1.0, fluid=dam, gauges=probes, spacing=0.04, duration=4.0, frame_every=0.05)
    frames = simulated(plain)
    by_speed(left, plain, frames[32], 1.8, (3.2, 1.2))
    left.plot(3.2, 0.05, "s", color=PALETTE[1], markersize=8, clip_on=False)
    left.plot([2.0, 2.0], [0.0, 0.8], color=PALETTE[0])
    left.plot([1.2] * 7, np.linspace(0.0, 0.6, 7), "o", color=PALETTE[2], markersize=4)
    left.set_title(f"Gauges at t = {frames[32].time:g}")
    time = [frame.time for frame in frames]
    pressure = [frame.numbers["sensor_pressure"] for frame in frames]
    middle.plot(time, pressure, color=PALETTE[1], label="sensor_pressure / ρgH")
    middle.plot(
        time, [10.0 * frame.numbers["post_level"] for frame in frames], color=PALETTE[0], label="10 · post_level / H"
    )
    middle.set(xlabel="time / √(H/g)", title=f"Time series (first peak: {max(pressure):.0f})", ylim=(-0.1, 5.0))
    middle.legend(loc="upper right", handlelength=0.6, fontsize=7.5)
    for number, color in zip((10, 20, 40), PALETTE, strict=False):
        speed = [frames[number].numbers[f"line_{k}_velocity_x"] for k in range(1, 8)]
        right.plot(speed, np.linspace(0.0, 0.6, 7), "o-", color=color, label=f"t = {frames[number].time:g}")
    right.set(xlabel="line_…_velocity_x / √(gH)", ylabel="height / H", title="Profile along the line (0 where dry)")
    right.legend()
    return drawn


def turbulence() -> Figure:
    """Eddies smaller than particles: what they do to a jump of velocity, and to tracers."""
    drawn = figure(11.0, 3.4)
    left, *rest = drawn.subplots(1, 4)
    for name, color in zip(("none", "smagorinsky"), PALETTE, strict=False):
        frames = simulated(sheared({"turbulence": name, "viscosity_model": "morris", "jitter": 0.1}))
        y, speed = frames[-1].arrays["position"][:, 1], frames[-1].arrays["velocity"][:, 0]
        left.plot(speed, y, ".", color=color, markersize=3, label=f'"{name}"')
    left.set(xlabel="speed / U", ylabel="height / H", title=f"Shear layer, t = {frames[-1].time:g} H/U")
    left.legend(title="turbulence", loc="upper left", markerscale=3.0)
    cloud = {"count": 150, "low": [0.9, 0.48], "high": [1.1, 0.52]}
    ways = (
        {},
        {"turbulent_dispersion": True},
        {"turbulent_dispersion": True, "schmidt_number": 0.05},
    )
    for axes, way in zip(rest, ways, strict=True):
        scene = sheared(
            {"turbulence": "smagorinsky", "viscosity_model": "morris", "jitter": 0.1},
            passive_tracers=[{**cloud, **way}],
        )
        frames = simulated(scene)
        for frame, color in ((frames[0], MUTED), (frames[-1], PALETTE[1])):
            mine = frame.arrays["species"] == 2
            axes.plot(*frame.arrays["position"][mine].T, ".", color=color, markersize=3)
        axes.add_patch(Rectangle((0.0, 0.0), 2.0, 1.0, facecolor="none", edgecolor=INK))
        axes.set(xlim=(-0.02, 2.02), ylim=(-0.02, 1.02), aspect="equal")
        axes.set_axis_off()
        names = [f"{key} = {value}".replace("True", "true") for key, value in way.items()]
        axes.set_title(names[-1] if names else "tracers")
    return drawn


def sheared(method: dict[str, Any], **changes: Any) -> dict[str, Any]:
    """A full tank whose upper half flows to the right and whose lower half to the left."""
    around = {
        "left": {"kind": "periodic"},
        "right": {"kind": "periodic"},
        "top": {"slip": "free"},
        "bottom": {"slip": "free"},
    }
    halves = [
        {"low": [0.0, 0.5], "high": [2.0, 1.0], "velocity": [1.0, 0.0]},
        {"low": [0.0, 0.0], "high": [2.0, 0.5], "velocity": [-1.0, 0.0]},
    ]
    return {
        "duration": 1.5, "frame_every": 1.5, "spacing": 0.05, "gravity": [0.0, 0.0],
        "tank": {"low": [0.0, 0.0], "high": [2.0, 1.0], **around}, "fluid": halves,
        "liquid": {"density": 1.0, "viscosity": 1e-4, "sound_speed": 10.0, "maximum_speed": 1.0},
        "method": method, **changes,
    }  # fmt: skip


def packing() -> Figure:
    """Particles and dummies around a disc and on a slope: the lattice, and the packed particles."""
    drawn, (width, depth) = figure(9.0, 6.6), (1.2, 0.8)
    solids: tuple[dict[str, Any], ...] = (
        {"center": [0.63, 0.37], "radius": 0.21},
        {"vertices": [[0.3, 0.0], [width, 0.0], [width, 0.5]]},
    )
    for row, solid in zip(drawn.subplots(2, 2), solids, strict=True):
        scene = from_plain({"model": "sph", **pool(width, depth, spacing=0.0606), "obstacles": [solid]})
        assert isinstance(scene, SphScene)  # noqa: S101  # the model says so
        cells = [each for each, _ in cells_of(scene)]
        dummies = np.concatenate([points for points, _ in obstacle_dummies(scene, 0.24)])
        for axes, title, found in zip(
            row, ("Lattice", "Packed"), (cells, packed(scene, cells, unaligned_solids(scene))), strict=True
        ):
            far = unevenness(scene, found, unaligned_solids(scene)) or 0.0
            outline = shape_of(scene.obstacles[0]).rim(0.01)
            axes.add_patch(Polygon(outline.tolist(), **SOLID))
            axes.plot(*dummies.T, ".", color=MUTED, markersize=4)
            axes.plot(*found[0].centers.T, ".", color=PALETTE[0], markersize=6)
            axes.set(xlim=(0.0, width), ylim=(0.0, depth), aspect="equal", xticks=[], yticks=[])
            axes.set_title(f"{title}: density within {100.0 * far:.2g} %")
    return drawn


def roll() -> Figure:
    """A channel that starts from rest, and a tank that rolls, in its own frame."""
    drawn = figure(11.0, 2.9)
    flux, rolls, sensor = drawn.subplots(1, 3, width_ratios=(1.0, 1.5, 1.0))
    channel = {
        **pool(4.0, 1.0), "duration": sized(16.0, 2.0), "frame_every": 0.25, "spacing": 0.2,
        "liquid": {**WATER, "sound_speed": 14.0},
        "tank": {"high": [4.0, 1.0], "left": {"kind": "inflow", "speed": 0.2}, "right": {"kind": "outflow"}},
    }  # fmt: skip
    frames = simulated(channel)
    times = [frame.time for frame in frames]
    flux.plot(times, [frame.arrays["velocity"][:, 0].mean() / 0.2 for frame in frames], label="mean velocity / inflow")
    flux.plot(times, [len(frame.arrays["mass"]) / len(frames[0].arrays["mass"]) for frame in frames], label="particles")
    flux.axhline(1.0, color=MUTED, linewidth=0.8)
    flux.set(xlabel="time", title="A channel from rest")
    flux.legend()
    width, turn = 9.7, {"amplitude": 0.07, "frequency": sized(0.0597, 0.2)}
    gauge = {"name": "sensor", "position": [0.0, 1.0]}
    rolling = {
        **pool(width, 1.0), "duration": sized(25.0, 2.0), "frame_every": 0.25, "spacing": sized(0.125, 0.25),
        "roll": turn, "gauges": [gauge],
    }  # fmt: skip
    frames = simulated(rolling)
    pressures = [frame.numbers["sensor_pressure"] for frame in frames]
    by_speed(rolls, rolling, frames[int(np.argmax(pressures))], 1.0, (width, 2.0))
    rolls.set_title("A tank that rolls, in its frame: speed at the impact")
    sensor.plot([frame.time for frame in frames], pressures)
    sensor.set(xlabel="time", title="Pressure at the left wall / ρgH")
    return drawn


FIGURES: dict[str, Callable[[], Figure]] = {
    "sph-roll": roll,
    "sph-packing": packing,
    "sph-sides": sides,
    "sph-pulls": pulls,
    "sph-colors": colors,
    "sph-solids": solids,
    "sph-driven-bodies": driven_bodies,
    "sph-inlets": inlets,
    "sph-gauges": gauges,
    "sph-turbulence": turbulence,
}
