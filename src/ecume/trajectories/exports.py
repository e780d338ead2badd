"""Export of trajectories to formats of other programs.

    export("runs/bowl", "csv", "bowl.csv")

The file is written under a temporary name and renamed when it is complete, so that no incomplete file remains.

For ParaView a trajectory is one VTKHDF file, or a VTK file for each frame and a list of these files with their times.

VTKHDF: one table contains the points of all frames, and tables of offsets contain the start of each frame; data that
are equal to those of the previous frame are not written again. HDF5 ends the process when a disk is full. To prevent
this, the file object passed to the library accepts all data, and stores the first error of the operating system.

PVD, for ParaView before VTKHDF: `bowl.pvd` is the list, `bowl/0000.vtp` and so on are the frames. They are written
under temporary names, and replace existing files when all are complete, the list last.
"""

from __future__ import annotations

import base64
import contextlib
import io
import json
import math
import os
import shutil
import zipfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, TypeVar
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from ecume.errors import BadInput, StorageError
from ecume.trajectories.frame import Frame
from ecume.trajectories.gsd import SIDES
from ecume.trajectories.reader import ExportedFrames, open_trajectory
from ecume.trajectories.records import replacing, storing
from ecume.trajectories.tables import write_cells, write_rows

if TYPE_CHECKING:
    import h5py

Answer = TypeVar("Answer")
CELLS = ("Vertices", "Lines", "Polygons", "Strips")


def write_vtk(trajectory: ExportedFrames, file: BinaryIO) -> None:
    """Write points with all arrays, and the numbers as field data; positions have three components."""
    import h5py  # slow to import, and only needed here

    sink = _Patient(file)
    try:
        with h5py.File(sink, "w", libver=("earliest", "v110")) as document:
            _write(trajectory, document)
    except Exception:  # any error of HDF5 after a failed write; the stored error is reported instead
        if sink.refusal is None:
            raise
    if sink.refusal is not None:
        raise sink.refusal


def _write(trajectory: ExportedFrames, document: h5py.File) -> None:
    root = document.create_group("VTKHDF")
    root.attrs["Version"] = np.array([2, 0])
    root.attrs.create("Type", np.bytes_("PolyData"))
    steps = root.create_group("Steps")
    steps.attrs["NSteps"] = len(trajectory)
    steps["Values"] = trajectory.times
    steps["NumberOfParts"] = np.ones(len(trajectory), np.int64)
    steps["PartOffsets"] = np.arange(len(trajectory))
    counts = _write_points(trajectory, root, steps)
    root["NumberOfPoints"] = counts
    _write_cells(root, steps, counts)
    _write_numbers(trajectory, root, steps)


def _write_points(trajectory: ExportedFrames, root: h5py.Group, steps: h5py.Group) -> NDArray[np.int64]:
    """Write the points of all frames and their arrays, each as one long table; return the number of points of each
    frame.
    """
    data, starts = root.create_group("PointData"), steps.create_group("PointDataOffsets")
    names = list(trajectory[0].arrays)
    tables = {name: _Table(root if name == "position" else data, name) for name in names}
    counts = []
    for frame in trajectory:
        counts.append(len(frame.arrays["position"]))
        for name, table in tables.items():
            table.add(_in_space(frame.arrays[name]) if name in ("position", "velocity") else frame.arrays[name])
    root.move("position", "Points")
    steps["PointOffsets"] = tables.pop("position").starts
    for name, table in tables.items():
        starts[name] = table.starts
    return np.array(counts, np.int64)


def _write_cells(root: h5py.Group, steps: h5py.Group, counts: NDArray[np.int64]) -> None:
    """Write one vertex per point: a list that is written once, of which each frame uses the first part."""
    for kind in CELLS:
        cells = root.create_group(kind)
        most = int(counts.max()) if kind == "Vertices" else 0
        cells["Offsets"], cells["Connectivity"] = np.arange(most + 1), np.arange(most)
        cells["NumberOfCells"] = counts if kind == "Vertices" else np.zeros_like(counts)
        cells["NumberOfConnectivityIds"] = cells["NumberOfCells"][:]
    steps["CellOffsets"] = steps["ConnectivityIdOffsets"] = np.zeros((len(counts), len(CELLS)), np.int64)


def _write_numbers(trajectory: ExportedFrames, root: h5py.Group, steps: h5py.Group) -> None:
    data, count = root.create_group("FieldData"), len(trajectory)
    starts, sizes = steps.create_group("FieldDataOffsets"), steps.create_group("FieldDataSizes")
    for name in trajectory[0].numbers:
        data[name] = trajectory.numbers(name)
        starts[name], sizes[name] = np.arange(count), np.ones((count, 2), np.int64)


class _Table:
    """A dataset that grows by frames, with the offset of each frame."""

    def __init__(self, group: h5py.Group, name: str) -> None:
        self._group, self._name, self._last = group, name, np.zeros(0)
        self.starts: list[int] = []

    def add(self, rows: NDArray[Any]) -> None:
        """Add the rows of a frame, unless they are equal to those of the previous frame."""
        if self._name not in self._group:
            self._group.create_dataset(
                self._name, (0, *rows.shape[1:]), rows.dtype, maxshape=(None, *rows.shape[1:]), chunks=self._chunk(rows)
            )
        dataset = self._group[self._name]
        if self.starts and np.array_equal(rows, self._last):
            self.starts.append(self.starts[-1])
            return
        self.starts.append(len(dataset))
        dataset.resize(len(dataset) + len(rows), axis=0)
        dataset[self.starts[-1] :] = rows
        self._last = rows

    @staticmethod
    def _chunk(rows: NDArray[Any]) -> tuple[int, ...]:
        return (max(256, min(len(rows), 2**16)), *rows.shape[1:])


class _Patient(io.RawIOBase):
    """A file that accepts all operations, so that HDF5 completes; `refusal` is the first error of the operating
    system.
    """

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self.refusal: OSError | None = None

    def write(self, data: Any) -> int:
        """Write, or ignore the data after an error."""
        self._tried(lambda: self._file.write(data), 0)
        return len(data)

    def readinto(self, buffer: Any) -> int:
        """Read back; zeros for data that could not be written."""
        found = self._tried(lambda: self._file.read(len(buffer)), b"")
        buffer[:] = found.ljust(len(buffer), b"\0")
        return len(buffer)

    def seek(self, place: int, whence: int = 0) -> int:
        """Set the position."""
        return self._tried(lambda: self._file.seek(place, whence), place)

    def tell(self) -> int:
        """The position in the file."""
        return self._tried(self._file.tell, 0)

    def truncate(self, size: int | None = None) -> int:
        """Set the length, or ignore it after an error."""
        return self._tried(lambda: self._file.truncate(size), size or 0)

    def _tried(self, action: Callable[[], Answer], otherwise: Answer) -> Answer:
        try:
            return action()
        except OSError as error:
            self.refusal = self.refusal or error
            return otherwise


KINDS = {"<f8": "Float64", "<i8": "Int64"}
HEAD = '<?xml version="1.0"?>\n<VTKFile type="{}" version="1.0" byte_order="LittleEndian" header_type="UInt64">\n'


def write_pvd(trajectory: ExportedFrames, path: Path) -> None:
    """Write the list of frames to `path`, and the frames to a folder with the same name."""
    write_series(path, ".vtp", trajectory.times.tolist(), map(vtp_of, trajectory))


def write_series(path: Path, ending: str, times: Sequence[float], files: Iterable[str]) -> None:
    """Write a list of files to `path`, and the files to a folder with the same name."""
    folder = path.with_suffix("") if path.suffix else path.with_name(f"{path.name}-frames")
    names = [f"{number:04d}{ending}" for number in range(len(times))]
    with replacing(path) as listed:  # reserve space for it before the folder is replaced
        listed.write(_listing(times, [f"{folder.name}/{name}" for name in names]).encode())
        listed.flush()
        with _replacing_folder(folder, ending) as part:
            for name, text in zip(names, files, strict=True):
                with storing(part), (part / name).open("wb") as file:
                    file.write(text.encode())


def vtp_of(frame: Frame) -> str:
    """The text of a frame: one vertex per particle with all arrays, and the numbers as field data."""
    position = frame.arrays["position"]
    rest = {name: array for name, array in frame.arrays.items() if name != "position"}
    numbers = "".join(data_array(name, np.array([value])) for name, value in frame.numbers.items())
    points = data_array("position", _in_space(position))
    values = "".join(
        data_array(name, _in_space(array) if name == "velocity" else array) for name, array in rest.items()
    )
    vertices = data_array("connectivity", np.arange(len(position))) + data_array(
        "offsets", np.arange(1, len(position) + 1)
    )
    piece = f'<Piece NumberOfPoints="{len(position)}" NumberOfVerts="{len(position)}">\n'
    return (
        f"{HEAD.format('PolyData')}<PolyData>\n<FieldData>\n{numbers}</FieldData>\n{piece}"
        f"<PointData>\n{values}</PointData>\n<Points>\n{points}</Points>\n<Verts>\n{vertices}</Verts>\n"
        "</Piece>\n</PolyData>\n</VTKFile>\n"
    )


def _listing(times: Sequence[float], names: Sequence[str]) -> str:
    rows = "".join(
        f'<DataSet timestep="{time!r}" part="0" file={quoteattr(name)}/>\n'
        for time, name in zip(times, names, strict=True)
    )
    return f"{HEAD.format('Collection')}<Collection>\n{rows}</Collection>\n</VTKFile>\n"


def data_array(name: str, values: NDArray[Any]) -> str:
    """The data as base64: the number of bytes, then the bytes."""
    plain = np.ascontiguousarray(values)
    text = base64.b64encode(np.uint64(plain.nbytes).tobytes() + plain.tobytes()).decode()
    wide = int(np.prod(plain.shape[1:])) if plain.ndim > 1 else 1
    count = f' NumberOfTuples="{len(plain)}"'
    return (
        f"<DataArray type={quoteattr(KINDS[plain.dtype.str])} Name={quoteattr(name)}"
        f' NumberOfComponents="{wide}"{count} format="binary">{text}</DataArray>\n'
    )


def _in_space(vectors: NDArray[Any]) -> NDArray[Any]:
    """The vectors with three components; missing ones are zero."""
    return np.pad(vectors, ((0, 0), (0, 3 - vectors.shape[1])))


@contextlib.contextmanager
def _replacing_folder(folder: Path, ending: str) -> Iterator[Path]:
    """A folder that replaces an earlier one when it is complete, as `replacing` does for files. Only folders of frames
    are removed.
    """
    part = folder.with_name(f"{folder.name}.part")
    with storing(folder):
        _clear(part, ending)  # the folder of an export that was killed
    try:
        with storing(folder):
            part.mkdir(parents=True)
        yield part
        with storing(folder):
            _clear(folder, ending)
            part.rename(folder)
    except BaseException:
        shutil.rmtree(part, ignore_errors=True)
        raise


def _clear(folder: Path, ending: str) -> None:
    """Remove a folder of frames. Raises StorageError, before anything is removed, for a folder with other content."""
    if not folder.exists():
        return
    strange = [path.name for path in folder.iterdir() if path.suffix != ending] if folder.is_dir() else [folder.name]
    if strange:
        raise StorageError(f"{folder}: holds what no export made ({strange[0]}); give another name with -o")
    shutil.rmtree(folder)


AXES = "xyz"
SYMBOLS = ("H", "He", "Li", "Be", "B", "C", "N", "O", "F", "Ne", "Na", "Mg", "Al", "Si", "P", "S", "Cl", "Ar")
"""Chemical elements, one per species: extended XYZ names each particle by an element, for which readers know colors."""


def export(directory: str | os.PathLike[str], kind: str, out: str | os.PathLike[str]) -> Path:
    """Write the trajectory of a run as `csv`, `xyz`, `vtk`, `pvd` or `npz`; return the path of the
    new file.

    csv is one long table with a row per particle and frame, and the unit in each heading; xyz is extended XYZ, for
    OVITO and ASE; vtk is VTKHDF, which ParaView opens as a time series; pvd is for older versions of ParaView, with a
    folder of frames; npz contains one array per quantity, for `numpy.load`. Frames of tanks have all pressures: see
    `ecume.analysis.pressures`.
    """
    if kind not in (*EXPORTS, "pvd"):
        raise BadInput(f"a trajectory cannot be written as {kind}; expected one of {', '.join((*EXPORTS, 'pvd'))}")
    path = Path(out)
    with open_trajectory(directory) as trajectory:
        if not len(trajectory):
            raise BadInput(f"{directory}: the run has no frames yet")
        with storing(path.parent):
            path.parent.mkdir(parents=True, exist_ok=True)
        frames = ExportedFrames(trajectory)
        if kind == "pvd":
            write_pvd(frames, path)
            return path
        with replacing(path) as file:
            EXPORTS[kind](frames, file)
    return path


def write_csv(trajectory: ExportedFrames, file: BinaryIO) -> None:
    """Write one long table: frame, time, particle, then each component of each array with its unit."""
    names, units = list(trajectory[0].arrays), trajectory[0].units
    text = _Text(file)
    write_rows(text, [["frame", "time [s]", "particle", *_headings(trajectory[0], names, units)]])
    for number, frame in enumerate(trajectory):
        columns = [column.tolist() for name in names for column in _components(frame.arrays[name])]
        particles = zip(*columns, strict=True)
        write_cells(text, ([number, frame.time, particle, *row] for particle, row in enumerate(particles)))


def write_numbers(trajectory: ExportedFrames, file: BinaryIO) -> None:
    """Write a table with one row per frame: frame, time, then each of its numbers with its unit."""
    first = trajectory[0]
    heads = [f"{name} [{first.units[name]}]" if first.units.get(name, "1") != "1" else name for name in first.numbers]
    write_rows(text := _Text(file), [["frame", "time [s]", *heads]])
    rows = enumerate(trajectory)
    write_cells(
        text, ([number, frame.time, *(frame.numbers[name] for name in first.numbers)] for number, frame in rows)
    )


def write_xyz(trajectory: ExportedFrames, file: BinaryIO) -> None:
    """Write extended XYZ in SI units: positions and velocities with three components, species as chemical elements,
    with a comment that assigns them: `Species="H: cereal, He: bead"`.
    """
    legend = _legend(trajectory.species)
    for frame in trajectory:
        properties, columns = _xyz_columns(frame)
        numbers = "".join(f"{name}={value!r} " for name, value in frame.numbers.items())
        box, periodic = _xyz_box(frame, trajectory.corner), _xyz_periodic(frame)
        comment = f"{box}Properties={properties} Time={frame.time!r} {numbers}{legend}{periodic}"
        head = f"{len(frame.arrays['position'])}\n{comment}\n"
        rows = "".join(" ".join(map(_plain, row)) + "\n" for row in zip(*columns, strict=True))
        file.write((head + rows).encode())


def write_npz(trajectory: ExportedFrames, file: BinaryIO) -> None:
    """Write NumPy's format: `time`, every array with the frames as its first axis, every number as an array over
    frames, and `units` as JSON.
    """
    first = trajectory[0]
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        _put(archive, "units", np.array(json.dumps({"time": "s", **first.units})))
        _put(archive, "time", trajectory.times)
        for name in first.numbers:
            _put(archive, name if name not in first.arrays else f"{name}_number", trajectory.numbers(name))
        for name, array in first.arrays.items():
            _put(archive, name, _stacked(trajectory, name, array.shape))


def write_samples(trajectory: ExportedFrames, file: BinaryIO) -> None:
    """Write the table of numbers sampled between frames, without a row that is incomplete."""
    file.write(trajectory.samples.content)


EXPORTS: dict[str, Callable[[ExportedFrames, BinaryIO], None]] = {
    "csv": write_csv,
    "numbers": write_numbers,
    "samples": write_samples,
    "xyz": write_xyz,
    "vtk": write_vtk,
    "npz": write_npz,
}


def _headings(frame: Frame, names: Sequence[str], units: Any) -> Iterator[str]:
    """Yield `x [m]`, `vx [m/s]`, `radius [m]`: the headings of tables of floats in scenes."""
    short = {"position": "", "velocity": "v"}
    for name in names:
        unit = f" [{units[name]}]" if units.get(name, "1") != "1" else ""
        shape = frame.arrays[name].shape[1:]
        if not shape:
            yield f"{name}{unit}"
        elif len(shape) == 1 and shape[0] <= len(AXES):
            yield from (f"{short.get(name, name + '_')}{axis}{unit}" for axis in AXES[: shape[0]])
        else:
            yield from (f"{name}_{'_'.join(map(str, place))}{unit}" for place in np.ndindex(shape))


def _components(array: NDArray[Any]) -> list[NDArray[Any]]:
    return list(array.reshape(len(array), math.prod(array.shape[1:])).T) if array.ndim > 1 else [array]


def _xyz_columns(frame: Frame) -> tuple[str, list[list[Any]]]:
    """The description of the columns, and the columns."""
    count = len(frame.arrays["position"])
    species = frame.arrays.get("species", np.zeros(count, np.int64)).tolist()
    properties, columns = ["species:S:1"], [[_symbol(kind) for kind in species]]
    for name, array in frame.arrays.items():
        vector = name in ("position", "velocity")
        parts = _components(array)
        if vector:
            parts = [*parts, *[np.zeros(count)] * (3 - len(parts))]
        shown = {"position": "pos", "velocity": "velo", "species": "kind"}.get(name, name)
        properties.append(f"{shown}:{'I' if array.dtype.kind == 'i' else 'R'}:{len(parts)}")
        columns += [part.tolist() for part in parts]
    return ":".join(properties), columns


def _xyz_sides(frame: Frame) -> list[float]:
    """The three sides of the periodic box (m); zero along axes that are not periodic."""
    return [frame.numbers.get(name, 0.0) for name in SIDES]


def _xyz_periodic(frame: Frame) -> str:
    """The axes along which the box is periodic, as text."""
    return f'pbc="{" ".join("T" if side > 0.0 else "F" for side in _xyz_sides(frame))}"'


def _xyz_box(frame: Frame, corner: Sequence[float]) -> str:
    """The lattice vectors of a periodic box, which begins at `corner`, and its origin unless that is zero; empty if no
    axis is periodic. Along other axes the box contains all particles.
    """
    sides = _xyz_sides(frame)
    if not any(sides):
        return ""
    position = frame.arrays["position"]
    radius = float(frame.arrays["radius"].max(initial=0.0)) if "radius" in frame.arrays else 0.0
    low, span = np.zeros(3), np.zeros(3)
    low[: len(corner)] = corner
    if len(position):
        own = [axis for axis in range(position.shape[1]) if not sides[axis]]
        low[own] = position[:, own].min(axis=0) - radius
        span[own] = np.ptp(position[:, own], axis=0) + 2.0 * radius
    lengths = [side or float(far) or max(sides) for side, far in zip(sides, span, strict=True)]
    tilt = frame.numbers.get("box_tilt", 0.0)
    lattice = f'Lattice="{lengths[0]!r} 0 0 {tilt or 0!r} {lengths[1]!r} 0 0 0 {lengths[2]!r}" '
    return lattice + (f'Origin="{" ".join(map(repr, low.tolist()))}" ' if low.any() else "")


def _legend(species: Sequence[str]) -> str:
    """The chemical element that represents each species."""
    named = ", ".join(f"{_symbol(kind)}: {' '.join(name.split())}" for kind, name in enumerate(species))
    plain = named.replace('"', "'")
    return f'Species="{plain}" ' if named else ""


def _symbol(kind: int) -> str:
    return SYMBOLS[kind] if kind < len(SYMBOLS) else "X"


def _plain(value: Any) -> str:
    return value if isinstance(value, str) else repr(value)


def _stacked(trajectory: ExportedFrames, name: str, shape: tuple[int, ...]) -> NDArray[Any]:
    stacked = np.empty((len(trajectory), *shape), trajectory[0].arrays[name].dtype)
    for number, frame in enumerate(trajectory):
        if frame.arrays[name].shape != shape:
            raise BadInput(f"the number of particles changes at frame {number}, which npz cannot store; use csv")
        stacked[number] = frame.arrays[name]
    return stacked


def _put(archive: zipfile.ZipFile, name: str, array: NDArray[Any]) -> None:
    with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
        np.lib.format.write_array(member, array, allow_pickle=False)


class _Text:
    """A text layer over a binary file; that of the standard library would close the file."""

    def __init__(self, file: BinaryIO) -> None:
        self._file = file

    def write(self, text: str) -> int:
        return self._file.write(text.encode())
