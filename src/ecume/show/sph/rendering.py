"""A liquid in space as lit balls, by PyVista: an optional extra, for pictures and not for movies."""

from __future__ import annotations

import importlib
from typing import Any, NamedTuple

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from ecume._extras import install
from ecume.engine.shapes import Ball, Shape
from ecume.errors import BadInput
from ecume.show.curves import Frames
from ecume.show.picture import DPI, USUAL, Pixels, Size
from ecume.show.setting import BODY
from ecume.show.sph.moving import shape_of, turned
from ecume.show.sph.picture import COLORINGS, FULL, usual_color
from ecume.show.style import RIM, figure, scale_for
from ecume.show.tank import RARE, Coloring, time_text
from ecume.trajectories.frame import Frame
from ecume.units import Array

EYE = (0.45, 0.35, 1.0)
"""From where the liquid is seen, in the tank's own directions."""


class Solid(NamedTuple):
    """An obstacle or a body where it is."""

    shape: Shape
    """about its middle"""
    middle: Array
    turn: Array
    """(3, 3) from its own axes to those of the tank"""
    color: str


def rendered(frame: Frame, scene: Any, size: Size = USUAL) -> Pixels:
    """A frame of a liquid in space, (height, width, 3). Raises BadInput without PyVista, and for what is flat."""
    if len(scene.tank.low) != 3:
        raise BadInput("balls are rendered of liquids in space; this one is in the plane, where `snapshot` shows it")
    pyvista, coloring = _pyvista(), coloring_of(scene)
    cloud = pyvista.PolyData(np.ascontiguousarray(frame.arrays["position"]))
    cloud[coloring.label] = coloring.values(frame)
    balls = cloud.glyph(geom=pyvista.Sphere(radius=FULL * scene.spacing), scale=False, orient=False)
    plotter = pyvista.Plotter(off_screen=True, window_size=list(size))
    look = {"cmap": coloring.colors, "clim": list(range_of(frame, coloring)), "show_scalar_bar": False}
    plotter.add_mesh(balls, scalars=coloring.label, smooth_shading=True, **look)
    for solid in solids_of(scene, frame):
        plotter.add_mesh(_mesh(pyvista, solid), color=solid.color, smooth_shading=isinstance(solid.shape, Ball))
    box = pyvista.Box(_bounds(scene.tank.low, scene.tank.high))
    plotter.add_mesh(box, style="wireframe", color=RIM, line_width=2)
    plotter.view_vector(EYE, viewup=(0.0, 1.0, 0.0))
    pixels: Pixels = np.asarray(plotter.screenshot(return_img=True))
    plotter.close()
    return pixels


def solids_of(scene: Any, frame: Frame) -> list[Solid]:
    """Obstacles where they stand, bodies where the frame has them."""
    found = [Solid(shape_of(one), middle_of(one), np.eye(3), color_of(one)) for one in scene.obstacles]
    for number, body in enumerate(scene.bodies):
        at = {part: frame.numbers[f"body{number}_{part}"] for part in ("x", "y", "z", "qw", "qx", "qy", "qz")}
        turn = turned([at[f"q{part}"] for part in "wxyz"])
        found.append(Solid(shape_of(body), np.array([at[axis] for axis in "xyz"]), turn, color_of(body)))
    return found


def middle_of(solid: Any) -> Array:
    """Of what stands still."""
    ends = (solid.low, solid.high) if solid.radius is None else (solid.center, solid.center)
    middle: Array = np.mean(ends, axis=0)
    return middle


def color_of(solid: Any) -> str:
    """Its own, or that of all."""
    return str(solid.color or BODY)


def coloring_of(scene: Any) -> Coloring:
    """What the balls' colors mean."""
    coloring = COLORINGS[usual_color(scene)]
    if coloring is None:
        raise BadInput("a rendered liquid is colored by a quantity")
    return coloring


def range_of(frame: Frame, coloring: Coloring) -> tuple[float, float]:
    """From the least to the largest value, but for what is rare: one peak must not pale all others."""
    values = coloring.values(frame)
    low, high = float(np.quantile(values, RARE)), float(np.quantile(values, 1.0 - RARE))
    return low, high if high > low else low + 1.0


def render(frames: Frames, scene: Any) -> Figure:
    """The last frame of a liquid in space, as lit balls, with a bar that says what their colors mean."""
    frame = frames[-1]
    pixels = rendered(frame, scene)
    drawn = figure(USUAL.width / DPI, USUAL.height / DPI)
    axes = drawn.add_subplot()
    axes.imshow(pixels)
    axes.set_axis_off()
    axes.set_title(time_text(frame.time), loc="left")
    coloring = coloring_of(scene)
    low, high = range_of(frame, coloring)
    scale = scale_for(max(abs(low), abs(high)), coloring.unit)
    shown = ScalarMappable(Normalize(scale.factor * low, scale.factor * high), coloring.colors)
    drawn.colorbar(shown, ax=axes, shrink=0.7, label=f"{coloring.label} ({scale.unit})")
    return drawn


def _mesh(pyvista: Any, solid: Solid) -> Any:
    """Its surface."""
    if isinstance(solid.shape, Ball):
        mesh = pyvista.Sphere(radius=solid.shape.radius, theta_resolution=60, phi_resolution=60)
    else:
        mesh = pyvista.Box(_bounds(*solid.shape.bounds()))
    mesh.points = mesh.points @ solid.turn.T + solid.middle
    return mesh


def _bounds(low: Any, high: Any) -> list[float]:
    """As PyVista has them, axis by axis."""
    return [float(end) for pair in zip(low, high, strict=True) for end in pair]


def _pyvista() -> Any:
    try:
        return importlib.import_module("pyvista")
    except ImportError:
        raise BadInput(f"PyVista is not installed, which renders balls: {install('render')}") from None
