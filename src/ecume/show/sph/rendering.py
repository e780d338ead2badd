"""A liquid in space as lit balls, by PyVista: an optional extra, for pictures and not for movies."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ecume.errors import BadInput
from ecume.show.curves import Frames
from ecume.show.picture import DPI, USUAL, Pixels, Size
from ecume.show.sph.picture import COLORINGS, FULL, usual_color
from ecume.show.style import RIM, figure
from ecume.trajectories.frame import Frame

EYE = (0.45, 0.35, 1.0)
"""From where the liquid is seen, in the tank's own directions."""


def rendered(frame: Frame, scene: Any, size: Size = USUAL) -> Pixels:
    """A frame of a liquid in space, (height, width, 3). Raises BadInput without PyVista, and for what is flat."""
    if len(scene.tank.low) != 3:
        raise BadInput("balls are rendered of liquids in space; this one is in the plane, where `snapshot` shows it")
    pyvista = _pyvista()
    coloring = COLORINGS[usual_color(scene)]
    if coloring is None:
        raise BadInput("a rendered liquid is colored by a quantity")
    cloud = pyvista.PolyData(np.ascontiguousarray(frame.arrays["position"]))
    cloud[coloring.label] = coloring.values(frame)
    balls = cloud.glyph(geom=pyvista.Sphere(radius=FULL * scene.spacing), scale=False, orient=False)
    plotter = pyvista.Plotter(off_screen=True, window_size=list(size))
    plotter.add_mesh(balls, scalars=coloring.label, cmap=coloring.colors, smooth_shading=True, show_scalar_bar=False)
    low, high = scene.tank.low, scene.tank.high
    box = pyvista.Box([end for pair in zip(low, high, strict=True) for end in pair])
    plotter.add_mesh(box, style="wireframe", color=RIM, line_width=2)
    plotter.view_vector(EYE, viewup=(0.0, 1.0, 0.0))
    pixels: Pixels = np.asarray(plotter.screenshot(return_img=True))
    plotter.close()
    return pixels


def render(frames: Frames, scene: Any) -> Figure:
    """The last frame of a liquid in space, as lit balls."""
    pixels = rendered(frames[-1], scene)
    drawn = figure(USUAL.width / DPI, USUAL.height / DPI)
    axes = drawn.add_subplot()
    axes.imshow(pixels)
    axes.set_axis_off()
    return drawn


def _pyvista() -> Any:
    try:
        return importlib.import_module("pyvista")
    except ImportError:
        raise BadInput("PyVista is not installed, which renders balls: pip install 'ecume[render]'") from None
