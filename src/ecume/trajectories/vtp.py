"""A trajectory as one VTK file a frame and a list of them with their times, for ParaView before VTKHDF.

`bowl.pvd` is the list, `bowl/0000.vtp` and so on are what it names. They are written beside what is there, and take its
place when all are whole, the list last.
"""

from __future__ import annotations

import base64
import contextlib
import shutil
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from ecume.errors import StorageError
from ecume.trajectories.durable import replacing, storing
from ecume.trajectories.frame import Frame
from ecume.trajectories.reader import Trajectory

KINDS = {"<f8": "Float64", "<i8": "Int64"}
HEAD = '<?xml version="1.0"?>\n<VTKFile type="{}" version="1.0" byte_order="LittleEndian" header_type="UInt64">\n'


def write_pvd(trajectory: Trajectory, path: Path) -> None:
    """The list at `path`, the frames in the folder beside it that is called as it is, but for the ending."""
    write_series(path, ".vtp", trajectory.times.tolist(), map(vtp_of, trajectory))


def write_series(path: Path, ending: str, times: Sequence[float], files: Iterable[str]) -> None:
    """A list of files at `path`, and they themselves in a folder beside it."""
    folder = path.with_suffix("") if path.suffix else path.with_name(f"{path.name}-frames")
    names = [f"{number:04d}{ending}" for number in range(len(times))]
    with _replacing_folder(folder, ending) as part:
        for name, text in zip(names, files, strict=True):
            with storing(part), (part / name).open("wb") as file:
                file.write(text.encode())
    with replacing(path) as listed:
        listed.write(_listing(times, [f"{folder.name}/{name}" for name in names]).encode())


def vtp_of(frame: Frame) -> str:
    """One frame: a vertex a particle with all arrays, and the numbers as field data."""
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
    """As base64: the number of bytes, then they."""
    plain = np.ascontiguousarray(values)
    text = base64.b64encode(np.uint64(plain.nbytes).tobytes() + plain.tobytes()).decode()
    wide = int(np.prod(plain.shape[1:])) if plain.ndim > 1 else 1
    count = f' NumberOfTuples="{len(plain)}"'
    return (
        f"<DataArray type={quoteattr(KINDS[plain.dtype.str])} Name={quoteattr(name)}"
        f' NumberOfComponents="{wide}"{count} format="binary">{text}</DataArray>\n'
    )


def _in_space(vectors: NDArray[Any]) -> NDArray[Any]:
    """Three components, the missing ones zero."""
    return np.pad(vectors, ((0, 0), (0, 3 - vectors.shape[1])))


@contextlib.contextmanager
def _replacing_folder(folder: Path, ending: str) -> Iterator[Path]:
    """A new content of a folder, as `replacing` of a file. What was made here before goes, and nothing else."""
    part = folder.with_name(f"{folder.name}.part")
    try:
        with storing(folder):
            shutil.rmtree(part, ignore_errors=True)
            part.mkdir(parents=True)
        yield part
        with storing(folder):
            _clear(folder, ending)
            part.rename(folder)
    except BaseException:
        shutil.rmtree(part, ignore_errors=True)
        raise


def _clear(folder: Path, ending: str) -> None:
    """Remove a folder of frames. Raises StorageError, before anything goes, for one that holds anything else."""
    if not folder.exists():
        return
    strange = [path.name for path in folder.iterdir() if path.suffix != ending] if folder.is_dir() else [folder.name]
    if strange:
        raise StorageError(f"{folder}: holds what no export made ({strange[0]}); give another name with -o")
    shutil.rmtree(folder)
