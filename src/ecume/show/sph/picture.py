"""A liquid of particles in its tank: a side view in 2D, a perspective view in 3D."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba_array

from ecume.analysis.pressures import with_pressures
from ecume.engine.shapes import Flags
from ecume.errors import BadInput
from ecume.scenes.faults import suggestion
from ecume.show.picture import STANDING, UPRIGHT, USUAL, Eye, Size, Species, Wires, wires_of
from ecume.show.sph.liquid import Water
from ecume.show.sph.solids import (
    ball_outline,
    drawn_shape,
    edges,
    is_ball,
    mover_colors,
    movers_of,
    outline,
    rectangle,
)
from ecume.show.sph.water import WaterImage
from ecume.show.style import INK, PALETTE, RIM
from ecume.show.tank import BODY, Coloring, Setting, Tank, colored, seen, stand_apart
from ecume.trajectories.frame import Frame
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.sph import SphScene

FULL = 0.5
"""The radius of drawn particles, in spacings: neighbors on a lattice touch."""
AIR = "white"
BRIGHT = (PALETTE[0], PALETTE[3], INK)
"""The colors of passive tracers."""


def speed(frame: Frame) -> Array:
    """The speed of each particle (m/s)."""
    fast: Array = np.linalg.norm(frame.arrays["velocity"], axis=1)
    return fast


def array(name: str) -> Callable[[Frame], Array]:
    """A function that returns an array of the frame unchanged."""
    return lambda frame: frame.arrays[name]


COLORINGS: Mapping[str, Coloring | None] = {
    "pressure": Coloring(array("pressure"), "gauge pressure", "Pa"),
    "speed": Coloring(speed, "speed", "m/s", "cividis"),
    "density": Coloring(array("density"), "density", "kg/m³", "cividis"),
    "region": None,
}
"""The colorings by the names of `ecume movie --color`; `region` colors by the [[fluid]] table of a particle."""
DERIVED = ("hydrostatic_pressure", "dynamic_pressure", "absolute_pressure")
"""Pressures that follow from the gauge pressure, see `ecume.analysis.pressures`; the last one also for two liquids."""


def colorings_of(scene: SphScene) -> dict[str, Coloring | None]:
    """All colorings of a tank, with those of derived pressures (`dynamic-pressure` and so on)."""
    completed = with_pressures(scene)

    def derived(name: str) -> Callable[[Frame], Array]:
        return lambda frame: completed(frame).arrays[name]

    names = DERIVED if scene.second_liquid is None else DERIVED[-1:]
    more = {name.replace("_", "-"): Coloring(derived(name), name.replace("_", " "), "Pa") for name in names}
    return {**COLORINGS, **more}


def liquid_picture(
    scene: SphScene,
    sample: Sequence[Frame],
    size: Size = USUAL,
    color: str | None = None,
    eye: Eye | None = None,
    particles: bool = False,
) -> Tank:
    """The tank with its liquid colored by pressure under gravity, otherwise by speed, or as `color`
    specifies.

    In 2D the liquid is a continuous region, in 3D translucent water unless a `color` is given; with `particles` each
    particle is a disc or a ball with the diameter of the spacing.
    """
    name, colorings = color or usual_color(scene), colorings_of(scene)
    if name not in colorings:
        raise BadInput(f"no color {name!r}; {suggestion(name, colorings)}")
    if len(scene.tank.low) == 2 and eye is not None:
        raise BadInput("azimuth and elevation are for liquids in 3D; this one is in 2D")
    if len(scene.tank.low) == 3:
        setting = setting_in_space(scene, eye or Eye())
        if particles:
            return Tank(setting, sample, size, colorings[name])
        return WaterTank(scene, setting, sample, size, None if color is None else colorings[name], color == "region")
    if particles:
        return Tank(setting_of(scene), sample, size, colorings[name])
    return LiquidTank(scene, sample, size, colorings[name])


class WaterTank(Tank):
    """A tank in 3D with a continuous, translucent liquid, or one whose surface is colored by a quantity."""

    def __init__(
        self,
        scene: SphScene,
        setting: Setting,
        sample: Sequence[Frame],
        size: Size,
        coloring: Coloring | None,
        regions: bool,
    ) -> None:
        self.scene, self.by_region = scene, regions
        super().__init__(setting, sample, size, coloring)

    def _contents(self, axes: Axes, frame: Frame) -> list[Artist]:
        camera = self.setting.camera
        self.water = WaterImage(axes, self.scene, np.eye(3) if camera is None else camera, self.view)
        self.particles = self._particles(axes, frame)
        return [self.water.image, self.particles]

    def _fill(self, frame: Frame) -> None:
        liquid = colored(self.setting, frame)
        if self.by_region:
            own = np.array(to_rgba_array([kind.color for kind in self.setting.kinds]))
            self.water.put(liquid, own[liquid.arrays["species"]], lambda means: means)
        elif self.coloring is None or self.mapping is None:
            self.water.put(liquid, np.zeros((len(liquid.arrays["position"]), 0)), None)
        else:
            shades: Any = self.mapping.to_rgba
            values = np.asarray(self.coloring.values(liquid), float)[:, None]
            self.water.put(liquid, values, lambda means: shades(means[..., 0]))
        kept = passive_in(self.setting, frame)
        position, camera = frame.arrays["position"][kept], self.setting.camera
        depth = None if camera is None else position @ camera[2]
        self.particles.put(seen(position, camera), depth, shades_of(self.setting, frame, kept))


def shades_of(setting: Setting, frame: Frame, kept: Flags) -> Array:
    """The colors (M, 4) of passive tracers."""
    if not kept.any():
        return np.zeros((0, 4))
    own = np.array(to_rgba_array([kind.color for kind in setting.kinds]))
    shades: Array = own[frame.arrays["species"][kept]]
    return shades


def passive_in(setting: Setting, frame: Frame) -> Flags:
    """Flags (N,) of the particles that are passive tracers."""
    if not stand_apart(setting):
        return np.zeros(len(frame.arrays["position"]), bool)
    return np.asarray(frame.arrays["species"] >= setting.apart)


class LiquidTank(Tank):
    """A tank in 2D whose liquid is a continuous region, with the passive tracers in it as discs."""

    def __init__(self, scene: SphScene, sample: Sequence[Frame], size: Size, coloring: Coloring | None) -> None:
        self.scene = scene
        super().__init__(setting_of(scene)._replace(before=True), sample, size, coloring)

    def _contents(self, axes: Axes, frame: Frame) -> list[Artist]:
        self.water = Water(axes, self.scene)
        self.particles = self._particles(axes, frame)
        return [*self.water.artists, self.particles]

    def _fill(self, frame: Frame) -> None:
        liquid = colored(self.setting, frame)
        if self.coloring is None or self.mapping is None:
            own = np.array(to_rgba_array([kind.color for kind in self.setting.kinds]))
            self.water.put(liquid, own[liquid.arrays["species"]], lambda means: means)
        else:
            shades: Any = self.mapping.to_rgba
            values = np.asarray(self.coloring.values(liquid), float)[:, None]
            self.water.put(liquid, values, lambda means: shades(means[..., 0]))
        kept = passive_in(self.setting, frame)
        self.particles.put(seen(frame.arrays["position"][kept]), None, shades_of(self.setting, frame, kept))


def usual_color(scene: SphScene) -> str:
    """The default quantity for colors: the two liquids, if there are two; otherwise the pressure under gravity, or the
    speed without gravity.
    """
    if scene.second_liquid is not None:
        return "region"
    return "pressure" if any(scene.gravity or ()) else "speed"


def setting_of(scene: SphScene) -> Setting:
    """The setting of a tank in 2D: open sides are not drawn, periodic sides are dotted, moving sides are movers."""
    corners = rectangle(scene.tank.low, scene.tank.high)
    sides = [(getattr(scene.tank, side), corners[[first, last]]) for side, first, last in EDGES]
    walls = [ends for side, ends in sides if side.kind == "wall" and side.motion is None]
    nothing_around = all(side.kind in OPENINGS for side, _ in sides)
    return Setting(
        scene.title,
        None if nothing_around else corners,
        walls=walls,
        bodies=[outline(solid, scene.tank) for solid in scene.obstacles],
        body_colors=[solid.color or BODY for solid in scene.obstacles],
        kinds=regions(scene),
        inside=AIR,
        dotted=[ends for side, ends in sides if side.kind == "periodic"],
        radius=FULL * scene.spacing,
        movers=movers_of(scene),
        mover_colors=mover_colors(scene, BODY, flat=True),
        apart=len(scene.fluid),
        room=walled(scene),
    )


def walled(scene: SphScene) -> tuple[Array, Array]:
    """The corners of a 2D tank (m); infinite at sides that move or are not walls."""
    corners = np.array([scene.tank.low, scene.tank.high], dtype=float)
    for number, name in enumerate(scene.sides):
        side = getattr(scene.tank, name)
        if side.kind != "wall" or side.motion is not None:
            corners[number % 2, number // 2] = np.inf if number % 2 else -np.inf
    return corners[0], corners[1]


EDGES = (("bottom", 0, 1), ("right", 1, 2), ("top", 2, 3), ("left", 3, 0))
OPENINGS = ("open", "inflow", "outflow")


def setting_in_space(scene: SphScene, eye: Eye) -> Setting:
    """The edges of a tank in perspective; empty if all sides are open."""
    camera = eye.camera(STANDING if scene.up == "z" else UPRIGHT)
    around = any(getattr(scene.tank, side).kind != "open" for side in scene.sides)
    tank = wires_of(scene.tank.low, scene.tank.high, camera) if around else Wires([], [])
    solids = [(line, solid.color or RIM) for solid in scene.obstacles for line in solid_lines(solid, camera)]
    return Setting(
        scene.title,
        None,
        kinds=regions(scene),
        inside=AIR,
        wires=[*tank.front, *(line for line, _ in solids)],
        wire_colors=[RIM] * len(tank.front) + [color for _, color in solids],
        behind=tank.behind,
        camera=camera,
        radius=FULL * scene.spacing,
        movers=movers_of(scene, camera),
        mover_colors=mover_colors(scene, RIM, flat=False),
        apart=len(scene.fluid),
    )


def solid_lines(solid: Any, camera: Array) -> list[Array]:
    """An obstacle in 3D as projected: the edges of a box, the outline of a ball."""
    if is_ball(solid):
        return [ball_outline(np.array(solid.center), solid.radius, camera)]
    if solid.low is None:
        return [seen(edge, camera) for edge in edges(drawn_shape(solid))]
    return [edge for part in wires_of(solid.low, solid.high, camera) for edge in part]


def regions(scene: SphScene) -> list[Species]:
    """The [[fluid]] tables, each with its color, and the [[passive_tracers]], in colors that the liquid seldom has."""
    palette, bright = itertools.cycle(PALETTE[1:]), itertools.cycle(BRIGHT)
    liquid = [Species(f"region {n}", part.color or next(palette)) for n, part in enumerate(scene.fluid, 1)]
    if scene.second_liquid is not None:
        colors = dict(zip(("first", "second"), PALETTE[1:], strict=False))
        liquid = [
            each._replace(color=part.color or colors[part.liquid])
            for each, part in zip(liquid, scene.fluid, strict=True)
        ]
    return liquid + [
        Species(f"tracers {n}", part.color or next(bright)) for n, part in enumerate(scene.passive_tracers, 1)
    ]
