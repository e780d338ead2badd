"""Trajectories in the formats of others.

    export("runs/bowl", "csv", "bowl.csv")

The file is written under another name and takes its own when it is complete, so that no half of one is ever left.
"""

from __future__ import annotations

import csv
import json
import os
import zipfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from ecume._plain_files import content_of
from ecume.errors import BadInput
from ecume.trajectories.frame import Frame
from ecume.trajectories.reader import ExportedFrames, open_trajectory
from ecume.trajectories.records import replacing, storing
from ecume.trajectories.samples import LARGEST
from ecume.trajectories.vtk import write_pvd, write_vtk

AXES = "xyz"
SYMBOLS = ("H", "He", "Li", "Be", "B", "C", "N", "O", "F", "Ne", "Na", "Mg", "Al", "Si", "P", "S", "Cl", "Ar")
"""Extended XYZ names each particle by a chemical element, and readers know their colors, and no other names: one
element a species."""


def export(directory: str | os.PathLike[str], kind: str, out: str | os.PathLike[str]) -> Path:
    """Write the trajectory of a run as `csv`, `xyz`, `vtk`, `pvd` or `npz`; the path of the new file comes back.

    csv is one long table, a row a particle and frame, the unit in each heading; xyz is extended XYZ, for OVITO and ASE;
    vtk is VTKHDF, which ParaView opens as a series in time, pvd the same for its older versions, with a folder of
    frames beside it; npz holds one array a quantity, for `numpy.load`. Frames of tanks have all pressures: see
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
    """One long table: frame, time, particle, then each component of each array, with its unit."""
    names, units = list(trajectory[0].arrays), trajectory[0].units
    table = csv.writer(_Text(file), lineterminator="\n")
    table.writerow(["frame", "time [s]", "particle", *_headings(trajectory[0], names, units)])
    for number, frame in enumerate(trajectory):
        columns = [column.tolist() for name in names for column in _components(frame.arrays[name])]
        particles = zip(*columns, strict=True)
        table.writerows([number, frame.time, particle, *row] for particle, row in enumerate(particles))


def write_numbers(trajectory: ExportedFrames, file: BinaryIO) -> None:
    """A table of what is known of each frame as a whole: frame, time, then each of its numbers, with its unit."""
    first = trajectory[0]
    heads = [f"{name} [{first.units[name]}]" if first.units.get(name, "1") != "1" else name for name in first.numbers]
    table = csv.writer(_Text(file), lineterminator="\n")
    table.writerow(["frame", "time [s]", *heads])
    for number, frame in enumerate(trajectory):
        table.writerow([number, frame.time, *(frame.numbers[name] for name in first.numbers)])


def write_xyz(trajectory: ExportedFrames, file: BinaryIO) -> None:
    """Extended XYZ: SI numbers; positions and velocities with three components; the particles' species as elements,
    and in the comment what each element stands for: `Species="H: cereal, He: bead"`.
    """
    legend = _legend(trajectory.species)
    for frame in trajectory:
        properties, columns = _xyz_columns(frame)
        numbers = "".join(f"{name}={value!r} " for name, value in frame.numbers.items())
        comment = f'Properties={properties} Time={frame.time!r} {numbers}{legend}pbc="F F F"'
        head = f"{len(frame.arrays['position'])}\n{comment}\n"
        rows = "".join(" ".join(map(_plain, row)) + "\n" for row in zip(*columns, strict=True))
        file.write((head + rows).encode())


def write_npz(trajectory: ExportedFrames, file: BinaryIO) -> None:
    """NumPy's own: `time`, every array with the frames as its first axis, every number as a curve, `units` as JSON."""
    first = trajectory[0]
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        _put(archive, "units", np.array(json.dumps({"time": "s", **first.units})))
        _put(archive, "time", trajectory.times)
        for name in first.numbers:
            _put(archive, name if name not in first.arrays else f"{name}_number", trajectory.numbers(name))
        for name, array in first.arrays.items():
            _put(archive, name, _stacked(trajectory, name, array.shape))


def write_samples(trajectory: ExportedFrames, file: BinaryIO) -> None:
    """The table of numbers sampled between frames, without a row that is being written."""
    path = trajectory.samples.path
    whole = content_of(path, LARGEST, path.parent)
    file.write(whole[: whole.rfind(b"\n") + 1])


EXPORTS: dict[str, Callable[[ExportedFrames, BinaryIO], None]] = {
    "csv": write_csv,
    "numbers": write_numbers,
    "samples": write_samples,
    "xyz": write_xyz,
    "vtk": write_vtk,
    "npz": write_npz,
}


def _headings(frame: Frame, names: Sequence[str], units: Any) -> Iterator[str]:
    """`x [m]`, `vx [m/s]`, `radius [m]`: the headings that a table of floats is read with, too."""
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
    return list(array.reshape(len(array), -1).T) if array.ndim > 1 else [array]


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


def _legend(species: Sequence[str]) -> str:
    """The chemical element that stands for each species."""
    named = ", ".join(f"{_symbol(kind)}: {name}" for kind, name in enumerate(species)).replace('"', "'")
    return f'Species="{named}" ' if named else ""


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
    """Text into a binary file: what stands between them in the library would close the file."""

    def __init__(self, file: BinaryIO) -> None:
        self._file = file

    def write(self, text: str) -> int:
        return self._file.write(text.encode())
