"""A trajectory as one VTK file a frame and a list of them with their times, for ParaView before VTKHDF.

`bowl.pvd` is the list, `bowl/0000.vtp` and so on are what it names. They are written beside what is there, and take its
place when all are whole, the list last.
"""

from __future__ import annotations

import base64
import contextlib
import shutil
from collections.abc import Iterator
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
    folder = path.with_suffix("") if path.suffix else path.with_name(f"{path.name}-frames")
    with _replacing_folder(folder) as part:
        for number, frame in enumerate(trajectory):
            with storing(part), (part / _name(number)).open("wb") as file:
                file.write(vtp_of(frame).encode())
    with replacing(path) as listed:
        listed.write(_listing(trajectory, folder.name).encode())


def vtp_of(frame: Frame) -> str:
    """One frame: a vertex a particle with all arrays, and the numbers as field data."""
    position = frame.arrays["position"]
    rest = {name: array for name, array in frame.arrays.items() if name != "position"}
    numbers = "".join(_array(name, np.array([value])) for name, value in frame.numbers.items())
    points = _array("position", _in_space(position))
    values = "".join(_array(name, _in_space(array) if name == "velocity" else array) for name, array in rest.items())
    vertices = _array("connectivity", np.arange(len(position))) + _array("offsets", np.arange(1, len(position) + 1))
    piece = f'<Piece NumberOfPoints="{len(position)}" NumberOfVerts="{len(position)}">\n'
    return (
        f"{HEAD.format('PolyData')}<PolyData>\n<FieldData>\n{numbers}</FieldData>\n{piece}"
        f"<PointData>\n{values}</PointData>\n<Points>\n{points}</Points>\n<Verts>\n{vertices}</Verts>\n"
        "</Piece>\n</PolyData>\n</VTKFile>\n"
    )


def _listing(trajectory: Trajectory, folder: str) -> str:
    rows = "".join(
        f'<DataSet timestep="{time!r}" part="0" file={quoteattr(f"{folder}/{_name(number)}")}/>\n'
        for number, time in enumerate(trajectory.times.tolist())
    )
    return f"{HEAD.format('Collection')}<Collection>\n{rows}</Collection>\n</VTKFile>\n"


def _name(number: int) -> str:
    return f"{number:04d}.vtp"


def _array(name: str, values: NDArray[Any]) -> str:
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
def _replacing_folder(folder: Path) -> Iterator[Path]:
    """A new content of a folder, as `replacing` of a file. What was made here before goes, and nothing else."""
    part = folder.with_name(f"{folder.name}.part")
    try:
        with storing(folder):
            shutil.rmtree(part, ignore_errors=True)
            part.mkdir(parents=True)
        yield part
        with storing(folder):
            _clear(folder)
            part.rename(folder)
    except BaseException:
        shutil.rmtree(part, ignore_errors=True)
        raise


def _clear(folder: Path) -> None:
    """Remove a folder of frames. Raises StorageError, before anything goes, for one that holds anything else."""
    if not folder.exists():
        return
    strange = [path.name for path in folder.iterdir() if path.suffix != ".vtp"] if folder.is_dir() else [folder.name]
    if strange:
        raise StorageError(f"{folder}: holds what no export made ({strange[0]}); give another name with -o")
    shutil.rmtree(folder)
