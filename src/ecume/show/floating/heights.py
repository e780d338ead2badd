"""The height of the surface as numbers h(x, y) on a grid, for one frame or for all frames of a run.

    field = height_field(scene, frame)
    plt.pcolormesh(field.x, field.y, field.height)

Movies use tables in single precision; here each meniscus is computed separately.
"""

from __future__ import annotations

import os
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.special import k0

from ecume.errors import BadInput
from ecume.models.floating.dishes import field_of
from ecume.models.liquids import liquid_of
from ecume.show.floating.bowl import view_of
from ecume.show.floating.surface import (
    INSIDE,
    charges_in,
    has_menisci,
    multipoles_in,
    near,
    shapes_of,
    solved_heights,
    with_images,
)
from ecume.show.picture import View
from ecume.trajectories.exports import HEAD, data_array, write_series
from ecume.trajectories.frame import Frame
from ecume.trajectories.reader import Trajectory, open_trajectory
from ecume.trajectories.records import replacing, storing
from ecume.units import Array

REACH = 20.0
"""The range of menisci, in capillary lengths; the remaining height is 6e-10."""
CELLS = 200
KINDS = (".npz", ".npy", ".pvd")


class HeightField(NamedTuple):
    """The heights of the surface at the positions (x[i], y[k])."""

    x: Array
    """(X,) m"""
    y: Array
    """(Y,) m"""
    height: Array
    """(Y, X) m, upwards from the undisturbed surface; under a float as at its edge"""


def height_field(scene: Any, frame: Frame, *, cells: int = CELLS, view: View | None = None) -> HeightField:
    """The surface in one frame, on squares, of which the longer side has `cells`; of the whole dish, or of the region
    around the floats.

    Menisci and walls are added up as in the run, or by multipoles if the scene uses them.
    """
    if getattr(scene, "model", "") != "floating":
        raise BadInput("only scenes of the model 'floating' have a surface with heights")
    if cells < 1:
        raise BadInput(f"cells: got {cells}; expected 1 or more")
    shown = view or view_of(scene, [frame])
    cell = max(shown.width, shown.height) / cells
    x, y = (_places(low, side, cell) for low, side in _sides(shown))
    still = field_of(scene.dish, liquid_of(scene), x, y, frame.numbers.get("barrier_position", 0.0))
    return HeightField(x, y, still + _menisci_on_grid(scene, frame, x, y))


def _places(low: float, side: float, cell: float) -> Array:
    return np.asarray(low + cell * (np.arange(max(1, round(side / cell))) + 0.5), np.float64)


def _sides(view: View) -> tuple[tuple[float, float], tuple[float, float]]:
    return (view.left, view.width), (view.bottom, view.height)


def _menisci_on_grid(scene: Any, frame: Frame, x: Array, y: Array) -> Array:
    """The heights (m) of the floats' menisci, shape (y, x)."""
    multipoles = multipoles_in(scene)
    if multipoles is not None:
        return solved_heights(multipoles, frame, x, y)
    if not has_menisci(scene):
        return np.zeros((len(y), len(x)))
    length, shapes = liquid_of(scene).capillary_length, shapes_of(scene)
    arrays = with_images(frame, REACH * length).arrays
    places, closest, charges = arrays["position"], arrays["radius"], arrays["charge"]
    if shapes is not None:
        places, charges = charges_in(frame, shapes, REACH * length)
        closest = np.full(len(charges), INSIDE * float(arrays["radius"].min()))
    height = np.zeros((len(y), len(x)))
    for (px, py), least, charge in zip(places, closest, charges, strict=True):
        rows, columns = near(y, py, REACH * length), near(x, px, REACH * length)
        r = np.hypot(x[columns] - px, (y[rows] - py)[:, None])
        height[rows, columns] -= charge * k0(np.maximum(r, least) / length)
    return height


def export_heights(directory: str | os.PathLike[str], out: str | os.PathLike[str], *, cells: int = CELLS) -> Path:
    """Write the surface in every frame of a run; return the path of the new file.

    `.npz` contains the arrays time, x, y and height (frame, y, x); `.npy` contains only the heights; `.pvd` is a list
    of VTK images in a folder, which ParaView opens as a time series.
    """
    path = Path(out)
    if path.suffix not in KINDS:
        raise BadInput(f"got {path.name} for heights; expected a name that ends in {', '.join(KINDS)}")
    with open_trajectory(directory) as trajectory:
        if not len(trajectory):
            raise BadInput(f"{directory}: the run has no frames yet")
        with storing(path.parent):
            path.parent.mkdir(parents=True, exist_ok=True)
        ends = [trajectory[0], trajectory[len(trajectory) // 2], trajectory[-1]]
        view = view_of(trajectory.scene, ends) if trajectory.scene.model == "floating" else None
        fields = (height_field(trajectory.scene, frame, cells=cells, view=view) for frame in trajectory)
        if path.suffix == ".pvd":
            write_series(path, ".vti", trajectory.times.tolist(), map(image_of, fields))
        else:
            _write_arrays(trajectory, fields, path)
    return path


def _write_arrays(trajectory: Trajectory, fields: Iterator[HeightField], path: Path) -> None:
    found = list(fields)
    heights = np.stack([field.height for field in found])
    with replacing(path) as file:
        if path.suffix == ".npy":
            np.lib.format.write_array(file, heights, allow_pickle=False)
            return
        with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
            parts = {"time": trajectory.times, "x": found[0].x, "y": found[0].y, "height": heights}
            for name, array in parts.items():
                with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                    np.lib.format.write_array(member, np.asarray(array), allow_pickle=False)


def image_of(field: HeightField) -> str:
    """A height field as a VTK image, with one point per node."""
    x, y = field.x.tolist(), field.y.tolist()
    step = x[1] - x[0] if len(x) > 1 else 1.0
    extent = f"0 {len(x) - 1} 0 {len(y) - 1} 0 0"
    place = f'Origin="{x[0]!r} {y[0]!r} 0" Spacing="{step!r} {step!r} 1"'
    return (
        f'{HEAD.format("ImageData")}<ImageData WholeExtent="{extent}" {place}>\n<Piece Extent="{extent}">\n'
        f'<PointData Scalars="height">\n{data_array("height", field.height.ravel())}</PointData>\n'
        "</Piece>\n</ImageData>\n</VTKFile>\n"
    )
