"""Velocities of a liquid from files: NumPy, NetCDF and VTK grids, and recorded runs of tanks.

Arrays may be in either order of their axes where dimensions have names (NetCDF); otherwise they are indexed [x, y, z],
with the time first. Raises BadInput for anything but a grid of equal steps.
"""

from __future__ import annotations

import math
import re
import warnings
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ecume.engine import interpolation
from ecume.errors import BadInput, install
from ecume.models.gridded_flows import Grid
from ecume.scenes.fields import FieldSpec
from ecume.trajectories.reader import open_trajectory
from ecume.units import Array, factor

EVEN = 1e-5
"""The largest deviation of nodes from equal steps, over a step; files hold them in single precision."""
EXTRA = "flows"
MOST_NODES = 10**8
"""The largest number of grid nodes of a run in all frames."""
FINE = 50
"""Cells along a tank, by default."""
FASTEST = 1e3
"""The largest velocity (m/s), that of scenes."""
REACH = 2.0
"""The averaging range over the particles of a run, in spacings of the grid."""
SINCE = re.compile(r"(\S+)\s+since\b.*", re.IGNORECASE | re.DOTALL)
"""The unit of dates: `days since 2000-01-01`."""
LONGEST = 7.0 * 86400.0
"""The longest unit of dates (s): months and years have different lengths."""
SCALED = re.compile(r"([0-9]+\.?[0-9]*(?:[eE][+-]?[0-9]+)?)[\s*]*([^\W\d].*)")
"""A unit behind a number: `0.01 m s-1`."""
JOINED = re.compile(r"(\w*m)s\^?-1")
"""A velocity without a blank: `cms-1`."""
SPELLINGS = str.maketrans({"{": None, "}": None, ".": " ", "\N{MINUS SIGN}": "-"})
NO_UNIT = ("", "1", "-", "none", "dimensionless", "nondimensional", "unitless")


class UnitsWarning(UserWarning):
    """The units that a file states cannot be read."""


class Names(NamedTuple):
    """The names of arrays in a file."""

    coordinates: tuple[str, ...]
    velocities: tuple[str, ...]
    time: str


def grid_of(spec: FieldSpec, dimensions: int) -> Grid:
    """The velocities of a file in SI units. Raises BadInput."""
    path = Path(spec.file)
    names = Names(
        spec.coordinates or ("x", "y", "z")[:dimensions], spec.velocities or ("u", "v", "w")[:dimensions], spec.time
    )
    for key, given in (("coordinates", names.coordinates), ("velocities", names.velocities)):
        if len(given) != dimensions:
            raise BadInput(f"got {len(given)} names; expected {dimensions}", key)
    if path.is_dir():
        return _of_run(path, spec, dimensions)
    if spec.spacing is not None:
        raise BadInput("is of the grid of a run; a file has its own", "spacing")
    readers = {".npz": _of_numpy, ".nc": _of_netcdf, ".nc4": _of_netcdf, ".vti": _of_vtk, ".vtr": _of_vtk,
               ".vtk": _of_vtk}  # fmt: skip
    if path.suffix.lower() in readers and not path.is_file():
        raise BadInput(f"there is no file {str(spec.file)!r}", "file")
    if path.suffix.lower() not in readers:
        raise BadInput(f"got {path.name!r}; expected {', '.join(readers)}, or the directory of a run", "file")
    try:
        places, velocity, times = readers[path.suffix.lower()](path, names, spec)
    except BadInput:
        raise
    except Exception as error:  # libraries may raise any exception for a damaged file
        raise BadInput(_unreadable(path, error), "file") from error
    for name, place in zip(names.coordinates, places, strict=True):
        _require_line(path, name, place.ndim)
    if velocity.shape[1:-1] != tuple(map(len, places)):
        expected = "x".join(str(len(each)) for each in places)
        got = "x".join(map(str, velocity.shape[1:-1]))
        raise BadInput(f"{path.name}: its velocities are {got}; its coordinates make a grid of {expected}", "file")
    if len(times) != len(velocity) or not np.isfinite(times).all() or not (np.diff(times) > 0.0).all():
        raise BadInput(f"{path.name}: its {len(times)} times do not rise with its {len(velocity)} instants", "file")
    places = [(spec.length_unit or 1.0) * each for each in places]
    velocity = (spec.velocity_unit or 1.0) * velocity
    _require_slow(path.name, velocity)
    return _grid(path.name, places, velocity, (spec.time_unit or 1.0) * times)


def _require_slow(name: str, velocity: Array) -> None:
    """Raise BadInput for velocities beyond the limits of scenes, such as the numbers by which files mark land."""
    largest = float(np.max(np.abs(velocity), where=np.isfinite(velocity), initial=0.0))
    if largest > FASTEST:
        raise BadInput(
            f"{name}: got a velocity of {largest:.4g} m/s; expected at most {FASTEST:g} m/s, and NaN on land: check "
            "velocity_unit, and replace the numbers that mark land",
            "file",
        )


def _require_small(name: str, shapes: Sequence[tuple[int, ...]]) -> None:
    """Raise BadInput, before arrays are read, if a file has more nodes than can be used."""
    largest = max(map(math.prod, shapes), default=0)
    if largest > MOST_NODES:
        raise BadInput(f"{name}: has {largest:.3g} nodes; expected at most {MOST_NODES:.0e} in all frames", "file")


def _unreadable(path: Path, error: Exception) -> str:
    """The message for a file that a library cannot read: the first line of the library's error in printable
    characters.
    """
    cause, _, _ = (str(error) or type(error).__name__).partition("\n")
    if isinstance(error, (LookupError, OverflowError)):
        cause = "it is damaged or cut off"
    return f"{path.name} cannot be read: {_printable(cause)}"


def _printable(text: str) -> str:
    return text if text.isprintable() else ascii(text)


def _real(array: Any) -> Array:
    """The real numbers of an array. Raises ValueError for text, and for complex numbers, whose imaginary parts would be
    lost.
    """
    found = np.asarray(array)
    if found.dtype.kind not in "biuf":
        raise ValueError(f"got {'complex numbers' if found.dtype.kind == 'c' else found.dtype}; expected real numbers")
    return found.astype(float)


def _grid(name: str, places: list[Array], velocity: Array, times: Array) -> Grid:
    """A grid with ascending axes. Raises BadInput for unequal steps, and for infinite velocities."""
    low, step = [], []
    for axis, place in enumerate(places):
        if len(place) < 2:
            raise BadInput(f"{name}: got {len(place)} node along axis {axis}; expected two or more", "file")
        if place[0] > place[-1]:
            place, velocity = place[::-1], np.flip(velocity, axis + 1)
        width = float(place[-1] - place[0]) / (len(place) - 1)
        if width == 0.0:
            raise BadInput(f"{name}: all nodes along axis {axis} are at {place[0]:g} m", "file")
        off = np.abs(place - place[0] - width * np.arange(len(place))).max()
        if not off <= EVEN * width * len(place):
            raise BadInput(f"{name}: its nodes are uneven along axis {axis}; expected steps of {width:g} m", "file")
        low.append(float(place[0]))
        step.append(width)
    if np.isinf(velocity).any():
        raise BadInput(f"{name}: got an infinite velocity; expected numbers, or NaN on land", "file")
    if np.isnan(velocity).all():
        raise BadInput(f"{name}: all velocities are NaN, which is land", "file")
    return Grid(tuple(low), tuple(step), times.astype(float), np.ascontiguousarray(velocity, dtype=float))


def _of_numpy(path: Path, names: Names, spec: FieldSpec) -> tuple[list[Array], Array, Array]:
    if not zipfile.is_zipfile(path):
        raise BadInput(f"{path.name} is no NumPy archive; expected one that numpy.savez wrote", "file")
    with np.load(path, allow_pickle=False) as file:
        _require(path, (*names.coordinates, *names.velocities), list(file))
        lines = [*names.coordinates, *((names.time,) if names.time in file else ())]
        shapes = {name: _announced(file, name) for name in (*lines, *names.velocities)}
        for name in names.coordinates:
            _require_line(path, name, len(shapes[name]))
        _require_small(path.name, list(shapes.values()))
        nodes = math.prod(math.prod(shapes[name]) for name in lines)
        for name in names.velocities:
            if math.prod(shapes[name]) != nodes:
                got = "x".join(map(str, shapes[name]))
                expected = "x".join(str(math.prod(shapes[each])) for each in names.coordinates)
                raise BadInput(
                    f"{path.name}: its velocities are {got}; its coordinates make a grid of {expected}", "file"
                )
        places = [_real(file[name]) for name in names.coordinates]
        velocity = np.stack([_real(file[name]) for name in names.velocities], axis=-1)
        times = np.atleast_1d(_real(file[names.time])) if names.time in file else np.zeros(1)
    return places, velocity if velocity.ndim == len(places) + 2 else velocity[None], times


def _announced(file: Any, name: str) -> tuple[int, ...]:
    """The shape of an array in an archive, from its header."""
    with file.zip.open(f"{name}.npy") as array:
        read = {(1, 0): np.lib.format.read_array_header_1_0}.get(
            np.lib.format.read_magic(array), np.lib.format.read_array_header_2_0
        )
        shape, _, _ = read(array)
    return tuple(map(int, shape))


def _require(path: Path, required: tuple[str, ...], there: list[str]) -> None:
    missing = [name for name in required if name not in there]
    if missing:
        raise BadInput(
            f"{path.name}: has no {missing[0]!r}; it has {', '.join(map(_printable, sorted(map(str, there))))}", "file"
        )


def _require_line(path: Path, name: str, dimensions: int) -> None:
    """Raise BadInput for coordinates that are not a list of nodes along one axis, such as those of a mesh."""
    if dimensions != 1:
        raise BadInput(
            f"{path.name}: {name!r} has {dimensions} dimensions; expected the nodes along one axis of a grid of equal "
            "steps, of a mesh one row",
            "coordinates",
        )


def _of_netcdf(path: Path, names: Names, spec: FieldSpec) -> tuple[list[Array], Array, Array]:
    try:
        import xarray
    except ImportError as error:
        raise BadInput(f"{path.name}: NetCDF needs xarray: {install(EXTRA)}", "file") from error
    with xarray.open_dataset(path, decode_times=False) as file:
        _require(path, (*names.coordinates, *names.velocities), [str(name) for name in file.variables])
        for name in names.coordinates:
            _require_line(path, name, file[name].ndim)
        _require_small(path.name, [file[name].shape for name in (*names.coordinates, *names.velocities)])
        parts, steady = [], names.time not in file.variables
        axes = [file[name].dims[0] for name in names.coordinates]
        for name in names.velocities:
            array = file[name]
            order = [*(() if steady else file[names.time].dims[:1]), *axes]
            spare = [dim for dim in array.dims if dim not in order]
            if lacking := [dim for dim in axes if dim not in array.dims]:
                raise BadInput(f"{path.name}: {name} has no dimension {lacking[0]}; it has {array.dims}", "file")
            if any(array.sizes[dim] > 1 for dim in spare):
                further = f"{path.name}: {name} has a further dimension {_printable(str(spare[0]))}; select one level"
                hint = ", or state it as time" if steady and spare[0] in file.variables else ""
                raise BadInput(further + hint, "file")
            array = array.squeeze(spare)
            if not steady and order[0] not in array.dims:
                array = array.expand_dims({order[0]: 1})
            unit = _stated_unit(path, file[name], ("velocity_unit", "m/s"), spec)
            parts.append(unit * _real(array.transpose(*order).to_numpy()))
        units = [_stated_unit(path, file[name], ("length_unit", "m"), spec) for name in names.coordinates]
        places = [unit * _real(file[name].to_numpy()) for unit, name in zip(units, names.coordinates, strict=True)]
        times = np.zeros(1) if steady else _times(path, file[names.time], spec)
    velocity = np.stack(parts, axis=-1)
    return places, velocity if velocity.ndim == len(places) + 2 else velocity[None], times


def _times(path: Path, array: Any, spec: FieldSpec) -> Array:
    """The times of a NetCDF file in units of the scene. If the times are dates, of any calendar, the result is in
    seconds since the first date, independent of the key `time_unit`. Raises BadInput for months and years.
    """
    times = np.atleast_1d(_real(array.to_numpy()))
    dated = SINCE.fullmatch(str(array.attrs.get("units", "")).strip())
    if dated is None:
        return _stated_unit(path, array, ("time_unit", "s"), spec) * times
    unit = _in_si(dated[1], "s")
    if unit is None or unit > LONGEST:
        got = _printable(str(array.attrs["units"]))
        raise BadInput(f"{path.name}: its times are in {got}; expected days, hours, minutes or seconds", "file")
    passed: Array = times - times[0]
    return unit / (spec.time_unit or 1.0) * passed


def _stated_unit(path: Path, array: Any, sought: tuple[str, str], spec: FieldSpec) -> float:
    """The unit, in SI, of an array of a NetCDF file. It is 1 if the key of the scene gives a unit, if the file gives
    none, and, with a warning, if it cannot be read; sought = (key, SI unit). Raises BadInput for degrees.
    """
    (key, symbol), stated = sought, str(array.attrs.get("units", "")).strip()
    if getattr(spec, key) is not None or stated.lower() in NO_UNIT:
        return 1.0
    if symbol == "m" and stated.lower().startswith(("deg", "\N{DEGREE SIGN}")):
        raise BadInput(
            f"{path.name}: {_printable(str(array.name))!r} is in {_printable(stated)}; expected lengths on a plane: "
            "write a file with coordinates in meters, 111.2 km for each degree of latitude",
            "file",
        )
    unit = _in_si(stated, symbol)
    if unit is None:
        got = f"{_printable(stated)!r} of {_printable(str(array.name))!r}"
        warnings.warn(
            f"{path.name}: the units {got} cannot be read, and count as {symbol}; state {key} if they are others",
            UnitsWarning,
            stacklevel=2,
        )
    return 1.0 if unit is None else unit


def _in_si(stated: str, symbol: str) -> float | None:
    """The size in SI of a unit in the notation of NetCDF files; None if it is not a unit of this dimension.

    >>> [_in_si(one, "m/s") for one in ("cm.s-1", "cm s^{-1}", "0.01 m s-1", "CM/S", "cms-1", "furlong")]
    [0.01, 0.01, 0.01, 0.01, 0.01, None]
    """
    scaled = SCALED.fullmatch(stated)
    number, unit = (float(scaled[1]), scaled[2]) if scaled else (1.0, stated)
    unit = unit.translate(SPELLINGS)
    if symbol == "m/s":
        unit = JOINED.sub(r"\1 s-1", unit)
    for one in (unit, {"NM": "nautical_mile"}.get(unit, unit.lower())):
        try:
            return number * factor(one, symbol)
        except ValueError:
            continue
    return None


def _of_vtk(path: Path, names: Names, spec: FieldSpec) -> tuple[list[Array], Array, Array]:
    try:
        from vtkmodules.util import numpy_support
        from vtkmodules.vtkIOLegacy import vtkDataSetReader
        from vtkmodules.vtkIOXML import vtkXMLImageDataReader, vtkXMLRectilinearGridReader
    except ImportError as error:
        raise BadInput(f"{path.name}: VTK needs vtk: {install(EXTRA)}", "file") from error
    kinds = {".vti": vtkXMLImageDataReader, ".vtr": vtkXMLRectilinearGridReader, ".vtk": vtkDataSetReader}
    reader: Any = kinds[path.suffix.lower()]()
    to_numpy: Any = numpy_support.vtk_to_numpy
    reader.SetFileName(str(path))
    reader.Update()
    data = reader.GetOutput()
    counts = getattr(data, "GetDimensions", lambda: (0, 0, 0))()
    if min(counts) < 1 or max(counts) < 2:
        raise BadInput(f"{path.name}: got no structured or rectilinear grid", "file")
    if hasattr(data, "GetXCoordinates"):
        every = [to_numpy(each) for each in (data.GetXCoordinates(), data.GetYCoordinates(), data.GetZCoordinates())]
    elif not hasattr(data, "GetSpacing"):
        raise BadInput(f"{path.name}: its grid is curvilinear; expected one of equal steps", "file")
    else:
        # The bounds give the first node, since the origin need not be a node.
        spans = zip(data.GetBounds()[::2], data.GetSpacing(), counts, strict=True)
        every = [origin + step * np.arange(count) for origin, step, count in spans]
    points = data.GetPointData()
    found = [points.GetArray(k) for k in range(points.GetNumberOfArrays())]
    vectors = [each for each in found if each.GetNumberOfComponents() == 3]
    named = [each for each in vectors if each.GetName() in names.velocities] or vectors
    if not named:
        raise BadInput(f"{path.name}: has no vectors at its points; expected the velocity", "file")
    values = to_numpy(named[0]).reshape(*reversed(counts), 3).transpose(2, 1, 0, 3)
    used = [axis for axis in range(3) if counts[axis] > 1]
    if len(used) != len(names.coordinates):
        raise BadInput(f"{path.name}: its grid has {len(used)} dimensions; the scene {len(names.coordinates)}", "file")
    flat = values.reshape(*(counts[axis] for axis in used), 3)[..., used]
    return [np.asarray(every[axis], float) for axis in used], np.asarray(flat, float)[None], np.zeros(1)


def _of_run(path: Path, spec: FieldSpec, dimensions: int) -> Grid:
    """The velocities of the particles of a tank, averaged onto a grid in each frame; zero where there is no liquid."""
    run = open_trajectory(path)
    if not len(run) or {"position", "velocity"} - set(run[0].arrays):
        raise BadInput(f"{path.name}: has no frames with positions and velocities of a liquid", "file")
    first = run[0].arrays["position"]
    if first.shape[1] != dimensions:
        raise BadInput(f"{path.name}: is a run in {first.shape[1]}D; the scene is in {dimensions}D", "file")
    low, high = first.min(axis=0), first.max(axis=0)
    for frame in run:
        low, high = np.minimum(low, frame.arrays["position"].min(axis=0)), np.maximum(
            high, frame.arrays["position"].max(axis=0))  # fmt: skip
    spacing = spec.spacing or float((high - low).max()) / FINE
    counts = [max(2, math.ceil(side / spacing) + 1) for side in high - low]
    nodes = len(run) * math.prod(counts)
    if nodes > MOST_NODES:
        raise BadInput(f"got {spacing:g} m: {nodes:.2g} nodes; expected at most {MOST_NODES:.0e}", "spacing")
    places = [start + spacing * np.arange(count) for start, count in zip(low, counts, strict=True)]
    points = np.stack(np.meshgrid(*places, indexing="ij"), axis=-1).reshape(-1, dimensions)
    instants = [_averaged(frame.arrays, points, REACH * spacing).reshape(*counts, dimensions) for frame in run]
    return _grid(path.name, places, np.stack(instants), np.asarray(run.times, float))


def _averaged(arrays: Any, points: Array, reach: float) -> Array:
    """The linear fit to the velocities around each point; 0 where no particle is near."""
    pairs = interpolation.near(points, arrays["position"], reach)
    weight = np.maximum(1.0 - (pairs.distance / reach) ** 2, 0.0) ** 2
    return np.nan_to_num(interpolation.planes(pairs, weight, arrays["velocity"]))
