"""The effect of each choice of an sph scene, in small tanks: the liquid, its start, its sums and steps.

Every scene here takes seconds; `docs/figures.py` draws them with all others.
"""

from __future__ import annotations

import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from figures_sph import liquid, scale_to, scene_of, simulated
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ecume.laws import states
from ecume.laws.liquids import LIQUIDS
from ecume.laws.liquids import liquid as named_liquid
from ecume.models.sph.record import SPH, start
from ecume.models.sph.setup.building import bulk_viscosity_of, limits_of, material_of
from ecume.run import run
from ecume.scenes.load import load_scene
from ecume.scenes.schema import from_plain
from ecume.show.style import INK, PALETTE, figure
from ecume.trajectories.frame import Frame

OPEN = {"kind": "open"}
AROUND = {side: {"kind": "periodic"} for side in ("left", "right", "bottom", "top")}
SHORT = {
    "duration": 10.0, "frame_every": 0.5, "spacing": 1.0 / 12, "gravity": [0.0, -1.0],
    "tank": {"low": [0.0, 0.0], "high": [1.0, 1.6], "top": OPEN},
    "fluid": [{"low": [0.0, 0.0], "high": [1.0, 1.0]}],
    "liquid": {"density": 1.0, "sound_speed": 10.0, "maximum_speed": 1.0},
}  # fmt: skip
"""A tank at rest, twelve deep."""


def substances() -> Figure:
    """Named liquids over their temperature; Tait's law by its exponent; a column by the speed of sound."""
    drawn = figure(11.0, 3.4)
    left, middle, right = drawn.subplots(1, 3)
    for name, color in zip(LIQUIDS, PALETTE, strict=False):
        kelvin = np.linspace(LIQUIDS[name].coldest, LIQUIDS[name].hottest, 40)
        viscosity = [1e3 * named_liquid(name, temperature).viscosity for temperature in kelvin]
        left.semilogy(kelvin - 273.15, viscosity, color=color, label=name)
    left.set(xlabel="temperature (°C)", ylabel="viscosity (mPa s)", title="Viscosity by name and temperature")
    left.legend()
    density = np.linspace(0.97, 1.05, 60)
    for exponent, color in ((1.0, PALETTE[0]), (7.0, PALETTE[1])):
        gauge = states.tait_pressure(density, 1.0, 10.0, exponent)
        middle.plot(density, gauge, color=color, label=f"exponent = {exponent:g}")
        middle.plot(density, gauge + 1.0, ":", color=color)
    middle.set(xlabel="density / ρ₀", ylabel="pressure / ρ₀gH", title="Tait's law (dotted: atmospheric_pressure = 1)")
    middle.legend()
    for speed, color in zip((5.0, 10.0, 20.0), PALETTE, strict=False):
        given = {"density": 1.0, "sound_speed": speed, "maximum_speed": 1.0}
        last = simulated({**SHORT, "duration": 4.0, "frame_every": 4.0, "liquid": given})[-1]
        height = last.arrays["position"][:, 1]
        right.plot(last.arrays["density"], height, ".", color=color, label=f"sound_speed = {speed:g} √(gH)")
    right.set(xlabel="density / ρ₀", ylabel="height / H", title="Column at rest, t = 4")
    right.legend()
    return drawn


def kernel_choice() -> Figure:
    """How well a tank out of order comes to rest, by kernel and by smoothing length."""
    drawn = figure(9.4, 3.4)
    left, right = drawn.subplots(1, 2)
    names = ("wendland-c2", "wendland-c4", "wendland-c6", "gaussian", "quintic-spline", "cubic-spline", "liu-quartic")
    errors = [_error(quietly({"kernel": name})) for name in names]
    left.barh(names, errors, color=PALETTE[1])
    left.invert_yaxis()
    left.set(xlabel="r.m.s. error of the pressure / ρgH", title="Kernels at their default smoothing")
    for name, color in (("wendland-c2", PALETTE[1]), ("cubic-spline", PALETTE[0])):
        widths = np.array([1.1, 1.3, 1.6, 2.0, 2.4])
        found = [_error(quietly({"kernel": name, "smoothing_ratio": float(width)})) for width in widths]
        right.plot(widths, found, "o-", color=color, label=name)
    right.set(xlabel="smoothing (spacings)", ylabel="r.m.s. error / ρgH", ylim=(0.0, None), title="Smoothing length")
    right.legend()
    return drawn


def quietly(method: dict[str, Any]) -> list[Frame]:
    """A tank that starts out of order, from the middle of ten of its times on."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return simulated({**SHORT, "method": {"jitter": 0.2, **method}})[10:]


def _error(frames: list[Frame]) -> float:
    errors = [frame.arrays["pressure"] - (1.0 - frame.arrays["position"][:, 1]) for frame in frames]
    return float(np.sqrt(np.mean(np.concatenate(errors) ** 2)))


def starts() -> Figure:
    """Where liquid comes from, and how it starts to move."""
    drawn = figure(11.0, 4.4)
    panels = drawn.subplots(2, 6)
    with tempfile.TemporaryDirectory() as name:
        for axes, (title, region) in zip(panels[0], sources(Path(name)).items(), strict=True):
            _first(axes, title, region, Path(name))
        _first(panels[1, 5], "start_from a run", _run_before(Path(name)), Path(name))
    for axes, (title, region) in zip(panels[1], MOVED.items(), strict=False):
        _arrows(axes, title, simulated({**CALM, "fluid": [region]})[0])
    return drawn


def _arrows(axes: Axes, title: str, frame: Frame) -> None:
    x, v = frame.arrays["position"], frame.arrays["velocity"]
    axes.quiver(*x[::3].T, *v[::3].T, color=PALETTE[0], width=0.008)
    _room(axes, title)


CALM = {
    "duration": 0.01, "frame_every": 0.01, "spacing": 0.05, "gravity": [0.0, 0.0],
    "tank": {"low": [0.0, 0.0], "high": [1.0, 1.0]},
    "liquid": {"density": 1.0, "sound_speed": 10.0, "maximum_speed": 1.0},
}  # fmt: skip
MOVED: dict[str, dict[str, Any]] = {
    "velocity, in a disc": {"center": [0.5, 0.5], "radius": 0.35, "velocity": [1.0, 0.5]},
    "velocity_gradient": {"center": [0.5, 0.5], "radius": 0.35, "velocity_gradient": [[1.5, -3.0], [3.0, -1.5]]},
    'flow = "taylor-green"': {"low": [0.0, 0.0], "high": [1.0, 1.0], "flow": "taylor-green"},
    'flow = "standing-wave"': {"low": [0.0, 0.0], "high": [1.0, 0.6], "flow": "standing-wave", "flow_speed": 0.4},
    'flow = "poiseuille"': {"low": [0.0, 0.0], "high": [1.0, 1.0], "flow": "poiseuille"},
}


def sources(folder: Path) -> dict[str, str]:
    """Titles, and the [[fluid]] table of each; what it reads is written beside it."""
    import ezdxf
    import trimesh

    turn = np.linspace(0.5, 5.5 * np.pi, 90)
    x, y = 0.5 + 0.025 * turn * np.cos(turn), 0.5 + 0.025 * turn * np.sin(turn)
    rows = zip(x, y, np.gradient(x), np.gradient(y), strict=True)
    lines = ["x,y,vx,vy", *(",".join(f"{number:.4f}" for number in row) for row in rows)]
    (folder / "spiral.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    drawing = ezdxf.new()
    drawing.modelspace().add_ellipse((0.5, 0.5), major_axis=(0.4, 0.15), ratio=0.5)
    drawing.saveas(folder / "pond.dxf")
    trimesh.creation.torus(300.0, 120.0).apply_translation([500.0, 500.0, 500.0]).export(folder / "ring.stl")
    return {
        "low and high": "low = [0.1, 0.0]\nhigh = [0.6, 0.5]",
        "center and radius": "center = [0.5, 0.5]\nradius = 0.35",
        "vertices": "vertices = [[0.1, 0.1], [0.9, 0.1], [0.6, 0.4], [0.6, 0.9]]",
        "particles_from": 'particles_from = "spiral.csv"',
        "outline_from, DXF": 'outline_from = "pond.dxf"',
        "outline_from, STL": 'outline_from = "ring.stl"\noutline_unit = "mm"',
    }


def _run_before(folder: Path) -> str:
    """What goes on from a run of a drop that has fallen onto the floor."""
    drop = {**CALM, "model": "sph", "spacing": 0.04, "duration": 0.5, "frame_every": 0.5, "gravity": [0.0, -3.0]}
    run(from_plain({**drop, "fluid": [{"center": [0.5, 0.3], "radius": 0.25}]}), folder / "drop")
    return 'start_from = "drop@-1"'


def _first(axes: Axes, title: str, source: str, folder: Path) -> None:
    """The particles that a source lays, by their depth in space; with velocities where they have any."""
    scale = [1.0] * (3 if "STL" in title else 2)
    head = (
        f"model = 'sph'\nduration = 0.01\nframe_every = 0.01\nspacing = 0.04\n{source if 'start' in source else ''}\n"
    )
    region = "" if "start" in source else f"[[fluid]]\n{source}\n"
    room = f"[tank]\nlow = {[0.0 for _ in scale]}\nhigh = {scale}\n"
    (folder / "scene.toml").write_text(head + room + region, encoding="utf-8")
    scene = load_scene(folder / "scene.toml")
    state = start(scene, SPH.parameters(scene))
    x, v = state.position, state.velocity
    axes.scatter(x[0], x[1], s=4.0, c=x[2] if len(x) == 3 else np.zeros(len(x[0])), cmap="viridis", linewidths=0.0)
    if v.any():
        axes.quiver(*x[:2, ::4], *v[:2, ::4], color=PALETTE[1], width=0.008)
    _room(axes, title)


def _room(axes: Axes, title: str) -> None:
    axes.set(xlim=(-0.02, 1.02), ylim=(-0.02, 1.02), aspect="equal", xticks=[], yticks=[], title=title)


def first_moments() -> Figure:
    """What a start without pressure, or out of order, does to the pressure on the floor, and acoustic damping."""
    drawn = figure(11.0, 3.2)
    gauge = [{"name": "floor", "position": [0.5, 0.04]}]
    choices = (
        ("initial_pressure", ("hydrostatic", "zero")),
        ("jitter", (0.0, 0.1, 0.2)),
        ("acoustic_damping", (0.0, 2.0)),
    )
    for axes, (key, values) in zip(drawn.subplots(1, 3), choices, strict=True):
        for value, color in zip(values, PALETTE, strict=False):
            method = {"initial_pressure": "zero"} if key == "acoustic_damping" else {"acoustic_damping": 0.0}
            start = {**SHORT, "duration": 6.0, "frame_every": 0.05, "gauges": gauge}
            frames = simulated({**start, "method": {**method, key: value}})
            pressure = [frame.numbers["floor_pressure"] for frame in frames]
            axes.plot([frame.time for frame in frames], pressure, color=color, label=f"{key} = {value}")
        axes.set(xlabel="time · √(g/H)", ylabel="pressure on the floor / ρgH", title=key)
        axes.legend()
    return drawn


def noise() -> Figure:
    """A dam that breaks with less and more diffusion of density, and less and more artificial viscosity."""
    drawn, scale = figure(9.4, 4.4), scale_to(0.6)
    broken = {
        **SHORT, "duration": 2.6, "frame_every": 2.6, "spacing": 1.0 / 24,
        "tank": {"low": [0.0, 0.0], "high": [3.2, 1.6], "top": OPEN},
        "liquid": {"density": 1.0, "sound_speed": 14.0, "maximum_speed": 1.4},
    }  # fmt: skip
    choices = (
        {"diffusion_coefficient": 0.0},
        {"diffusion_coefficient": 0.1},
        {"artificial_viscosity": 0.0},
        {"artificial_viscosity": 0.2},
    )
    for axes, method in zip(drawn.subplots(2, 2).ravel(), choices, strict=True):
        plain = {**broken, "method": method}
        last = simulated(plain)[-1]
        axes.set(xlim=(0, 3.2), ylim=(0, 1.3))
        liquid(axes, scene_of(plain), last, last.arrays["pressure"], scale)
        axes.set_title(", ".join(f"{key} = {value:g}" for key, value in method.items()))
    drawn.colorbar(scale, ax=drawn.axes, label="pressure / ρgH", shrink=0.9)
    return drawn


def spreading() -> Figure:
    """Vortices in which particles follow the flow's lines, are shifted, or drift with a transport velocity."""
    drawn = figure(11.0, 3.2)
    panels = drawn.subplots(1, 4)
    whirl = {
        **CALM, "duration": 0.8, "frame_every": 0.1,
        "tank": {"low": [0.0, 0.0], "high": [1.0, 1.0], **AROUND},
        "fluid": [{"low": [0.0, 0.0], "high": [1.0, 1.0], "flow": "taylor-green"}],
        "liquid": {"density": 1.0, "sound_speed": 10.0, "maximum_speed": 1.0, "viscosity": 0.01},
    }  # fmt: skip
    ways = {
        'shifting = "none"': {"shifting": "none"},
        'shifting = "delta-plus"': {"shifting": "delta-plus"},
        'pressure_force = "transport"': {"pressure_force": "transport"},
    }
    for axes, (title, method), color in zip(panels, ways.items(), PALETTE, strict=False):
        frames = simulated({**whirl, "method": method})
        axes.plot(*frames[-1].arrays["position"].T, ".", color=color, markersize=3)
        _room(axes, title)
        speed = [float(np.linalg.norm(frame.arrays["velocity"], axis=1).max()) for frame in frames]
        panels[3].plot([frame.time for frame in frames], speed, ".-", color=color)
    lines = {"method": {"pressure_force": "monaghan", "shifting": "delta-plus"}}
    frames = simulated({**whirl, **lines})
    speed = [float(np.linalg.norm(frame.arrays["velocity"], axis=1).max()) for frame in frames]
    label = 'pressure_force = "monaghan"'
    panels[3].plot([frame.time for frame in frames], speed, "--", color=PALETTE[1], label=label)
    weaker = simulated({**whirl, "method": {"pressure_force": "transport", "background_pressure": 10.0}})
    speed = [float(np.linalg.norm(frame.arrays["velocity"], axis=1).max()) for frame in weaker]
    panels[3].plot(
        [frame.time for frame in weaker], speed, ":", color=PALETTE[2], label="background_pressure = ρ₀c₀²/10"
    )
    time = np.linspace(0.0, 0.8, 40)
    panels[3].plot(time, np.exp(-8.0 * np.pi**2 * 0.01 * time), color=INK, label="exact")
    panels[3].set(xlabel="time U/L", title="Largest speed / U", ylim=(0.0, 1.1))
    panels[3].legend()
    return drawn


def steps() -> Figure:
    """What limits the time step, and how bodies rise however light they are."""
    drawn = figure(9.4, 3.4)
    left, right = drawn.subplots(1, 2)
    spacings = np.geomspace(3e-5, 3e-2, 25)
    table = [_limits(float(spacing)) for spacing in spacings]
    for name, color in zip(table[0], PALETTE, strict=False):
        left.loglog(1e3 * spacings, [1e3 * row[name] for row in table], color=color, label=name)
    left.set(xlabel="spacing (mm)", ylabel="longest step (ms)", title="Syrup (2 Pa s), foam disc of 20 kg/m³")
    left.legend()
    for density, color in zip((0.5, 0.1, 0.01, 0.001), PALETTE, strict=False):
        frames = simulated(tub(density))
        speed = [frame.numbers["body0_velocity_y"] for frame in frames]
        right.plot([frame.time for frame in frames], speed, color=color, label=f"density ratio {density:g}")
    right.set(
        xlabel="time / √(D/g)",
        ylabel="upward speed / √(gD)",
        title="Rising discs, four spacings wide",
    )
    right.legend()
    return drawn


def _limits(spacing: float) -> dict[str, float]:
    plain = {
        "model": "sph", "duration": 1.0, "frame_every": 1.0, "spacing": spacing,
        "tank": {"low": [0.0, 0.0], "high": [0.4, 0.4], "top": OPEN},
        "fluid": [{"low": [0.0, 0.0], "high": [0.4, 0.3]}],
        "liquid": {"density": 1300.0, "viscosity": 2.0, "surface_tension": 0.06},
        "bodies": [{"center": [0.2, 0.2], "radius": 0.03, "density": 20.0}],
    }  # fmt: skip
    scene = from_plain(plain)
    material = material_of(scene)
    return limits_of(scene, material, bulk_viscosity_of(scene, material))


def tub(density: float) -> dict[str, Any]:
    """A disc under a liquid of density 1."""
    return {
        "duration": 0.4, "frame_every": 0.02, "spacing": 1.0 / 12, "gravity": [0.0, -1.0],
        "tank": {"low": [0.0, 0.0], "high": [2.0, 2.5], "top": OPEN},
        "fluid": [{"low": [0.0, 0.0], "high": [2.0, 2.0]}],
        "liquid": {"density": 1.0, "sound_speed": 20.0, "maximum_speed": 2.0},
        "bodies": [{"center": [1.0, 1.0], "radius": 0.17, "density": density}],
    }  # fmt: skip


FIGURES: dict[str, Callable[[], Figure]] = {
    "sph-substances": substances,
    "sph-kernel-choice": kernel_choice,
    "sph-starts": starts,
    "sph-first-moments": first_moments,
    "sph-noise": noise,
    "sph-spreading": spreading,
    "sph-steps": steps,
}
