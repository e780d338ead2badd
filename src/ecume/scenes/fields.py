"""Velocities of a liquid from files, for models whose particles follow a liquid."""

from __future__ import annotations

from pathlib import Path as Folder
from typing import Annotated, Any, Literal

from pydantic import Field

from ecume.scenes.common import dataclass
from ecume.scenes.faults import Complaints, echo
from ecume.scenes.quantities import STRICT, Duration, Name, Size
from ecume.scenes.tables import beside, require_there
from ecume.units import Length, Speed


@dataclass(frozen=True, kw_only=True, config=STRICT)
class FieldSpec:
    """Velocities of the liquid on a grid of equal steps, from a file, or from a run of the model `sph`."""

    file: Annotated[str, Field(min_length=1, max_length=1000)]
    """The file, beside the scene's: NumPy (`.npz`), NetCDF (`.nc`), VTK (`.vti`, `.vtr`, `.vtk`), or the directory of a
    run of a tank. Example: `"gyre.npz"`. Effect: particles follow its velocities; NaN is land."""
    length_unit: Annotated[Length, Field(gt=0.0, le=1e6)] | None = None
    """The unit of the coordinates of the file (m); by default meters, or what a NetCDF file states. Effect: scales the
    grid."""
    velocity_unit: Annotated[Speed, Field(gt=0.0, le=1e3)] | None = None
    """The unit of the velocities of the file (m/s); by default m/s, or what a NetCDF file states. Effect: scales the
    velocities."""
    time_unit: Duration | None = None
    """The unit of the times of the file (s); by default seconds, or what a NetCDF file states; dates need none. Effect:
    scales the times."""
    coordinates: tuple[Name, ...] = ()
    """The names of the coordinates in the file, the upward one last; by default x, y in 2D and x, y, z in 3D. Example:
    `["lon", "lat"]`. Effect: selects other arrays."""
    velocities: tuple[Name, ...] = ()
    """The names of the velocities in the file, in the order of the coordinates; by default u, v in 2D and u, v, w in
    3D. Example: `["uo", "vo"]`. Effect: selects other arrays."""
    time: Name = "t"
    """The name of the times in the file; without them the flow is steady. Example: `"time"`. Effect: selects another
    array."""
    interpolation: Literal["divergence-free", "linear"] = "divergence-free"
    """How velocities are interpolated: `divergence-free` by a stream function in 2D and by fluxes through the faces of
    cells in 3D, so that particles do not cluster; or `linear`. Effect: `linear` keeps the divergence of the file."""
    spacing: Size | None = None
    """The spacing of the grid onto which the velocities of a run are averaged (m); by default a fiftieth of the tank.
    Effect: smaller spacings resolve smaller eddies and take more memory."""


def follow_field(raw: dict[str, Any], folder: Folder) -> Complaints:
    """Replace the path of the file of a flow in `raw` by an absolute one, if the file exists. Returns its faults."""
    flow = raw.get("flow")
    field = flow.get("field") if isinstance(flow, dict) else None
    if not isinstance(field, dict) or not isinstance(field.get("file"), str):
        return []
    try:
        path = beside(folder, field["file"])
        require_there(path, folder)
    except ValueError as fault:
        return [(("flow", "field", "file"), f"{echo(field['file'])} {fault}")]
    field["file"] = str(path.resolve())
    return []
