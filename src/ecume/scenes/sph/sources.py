"""Liquid and solids from other sources than the scene itself: a table, a drawing, a frame of another run.

Reading a scene's file converts these keys to particles, vertices or triangles, so that the scene is complete without
other files.
"""

from __future__ import annotations

import codecs
import io
import itertools
import math
import tempfile
from collections.abc import Iterable, Mapping
from pathlib import Path as Folder
from typing import Any, Self

import numpy as np
from pydantic import model_validator

from ecume.errors import install
from ecume.scenes.common import dataclass
from ecume.scenes.faults import Complaints, Inconsistent, Path, echo
from ecume.scenes.quantities import BODY_MASS, FARTHEST, STRICT, BodyMass, Motion, Place, PositiveDensity, sides_along
from ecume.scenes.tables import MOST_BYTES, beside, bytes_of, followed, lines_of, names_of, require_there, table_text


@dataclass(frozen=True, kw_only=True, config=STRICT)
class ParticlesSpec:
    """Particles at given positions. Each other quantity is given for all particles or for none."""

    positions: tuple[Place, ...]
    """The position of each particle (m). Effect: determines where there is liquid."""
    velocities: tuple[Motion, ...] = ()
    """The velocity of each particle (m/s); by default zero. Effect: sets the initial flow."""
    densities: tuple[PositiveDensity, ...] = ()
    """The density of each particle (kg/m^3); by default that at rest. Effect: sets the initial pressure."""
    masses: tuple[BodyMass, ...] = ()
    """The mass of each particle (kg; kg/m in 2D); by default that of a lattice cell. Effect: sets the inertia of
    each particle."""

    @model_validator(mode="after")
    def _alike(self) -> Self:
        count = len(self.positions)
        lists = {"velocities": self.velocities, "densities": self.densities, "masses": self.masses}
        wrong = [
            ((key,), f"got {len(values)}, and there are {count} positions")
            for key, values in lists.items()
            if values and len(values) != count
        ]
        if not count:
            wrong.append((("positions",), "got no rows; expected one or more"))
        if wrong:
            raise Inconsistent(wrong)
        return self


def particle_faults(particles: ParticlesSpec, dimension: int) -> Complaints:
    """The faults of the first position and velocity whose dimension is not that of the tank."""
    found: Complaints = []
    for key, rows in (("positions", particles.positions), ("velocities", particles.velocities)):
        wrong = [index for index, row in enumerate(rows) if len(row) != dimension]
        if wrong:
            got = f"got {len(rows[wrong[0]])} numbers; the tank has {dimension} dimensions"
            found.append((("particles", key, wrong[0]), got))
    faults = ((index, BODY_MASS.fault(mass, dimension)) for index, mass in enumerate(particles.masses))
    return found + [(("particles", "masses", index), fault) for index, fault in faults if fault][:1]


TABLE, OUTLINE, UNIT, RUN = "particles_from", "outline_from", "outline_unit", "start_from"
LIQUID_COLUMNS = {
    "x": "m",
    "y": "m",
    "z": "m",
    "vx": "m/s",
    "vy": "m/s",
    "vz": "m/s",
    "density": "kg/m^3",
    "mass": "kg",
}
"""The columns of a table of liquid, and their SI units in 3D."""
MOST_MESH_BYTES = 256 * 2**20
AXES = "xyz"


def follow_sources(raw: dict[str, Any], folder: Folder) -> Complaints:
    """Insert the contents of the files that a scene names into `raw`. Returns their faults."""
    faults: Complaints = []
    if RUN in raw:
        given = raw.pop(RUN)
        follow = _from_file(raw, given, folder) if not isinstance(given, str) else None
        faults += followed((RUN,), _start_from, raw, given, folder) if follow is None else follow
    for name in DRAWN_TABLES:
        pieces = raw.get(name)
        for index, piece in enumerate(pieces if isinstance(pieces, list) else []):
            if not isinstance(piece, dict):
                continue
            if TABLE in piece and name == "fluid":
                faults += followed((name, index, TABLE), _particles_from, piece, piece.pop(TABLE), folder)
            faults += outline_followed(piece, (name, index), folder)
    return faults + _tank_from(raw, folder)


WALL_BEYOND = 4.0
"""The distance, in spacings, of the sides of a tank from a drawn basin, so that the drawing defines
all of its walls.
"""


def _tank_from(raw: dict[str, Any], folder: Folder) -> Complaints:
    """Build a tank of any shape from a drawing: a block with a hole. Open sides cut the drawing."""
    tank = raw.get("tank")
    if not isinstance(tank, dict) or not {OUTLINE, UNIT} & tank.keys():
        return []
    basin: dict[str, Any] = {key: tank.pop(key) for key in (OUTLINE, UNIT) if key in tank}
    if faults := outline_followed(basin, ("tank",), folder):
        return faults
    points = basin.get("vertices") or list(itertools.chain.from_iterable(basin["triangles"]))
    spacing = _length(raw.get("spacing"))
    beyond = WALL_BEYOND * spacing if isinstance(spacing, (int, float)) else 0.0
    for key, first, end in (("low", 0, min), ("high", 1, max)):
        sides = [tank.get(side) for side in sides_along("z" if raw.get("up") == "z" else "y", 3)[first::2]]
        pads = [0.0 if isinstance(side, dict) and side.get("kind", "wall") != "wall" else beyond for side in sides]
        sign = 1.0 if first else -1.0
        ends = [end(values) + sign * pad for values, pad in zip(zip(*points, strict=True), pads, strict=False)]
        tank.setdefault(key, ends)
    # Appended to the others, so that those have the same numbers in the file, in names and in messages.
    faults = _also_called_tank(raw)
    drawn = {"name": "" if faults else "tank", **basin, "hollow": True}
    raw["obstacles"] = [*raw.get("obstacles", []), drawn]
    return faults


def _also_called_tank(raw: Mapping[str, Any]) -> Complaints:
    """The faults of solids that have the name of a drawn tank."""
    solids = [(name, n, one) for name in ("obstacles", "bodies") for n, one in enumerate(raw.get(name, []))]
    message = "got 'tank', the name of the drawn tank; choose another"
    return [
        ((name, n, "name"), message) for name, n, one in solids if isinstance(one, dict) and one.get("name") == "tank"
    ]


DRAWN_TABLES = ("fluid", "obstacles", "bodies")
"""The tables whose shapes may be read from a drawing."""
UNITLESS = {
    ".stl": 'STL files have no unit: read in meters; outline_unit = "mm" changes that',
    ".dxf": 'read in the unit of the drawing, in meters without one; outline_unit = "mm" changes that',
}


def drawn_sizes(raw: Mapping[str, Any], scene: Any) -> list[tuple[str, str, str]]:
    """The sizes of drawings without a unit in the scene or the file: key, size, remark."""
    tank, found = raw.get("tank", {}), list[tuple[str, Mapping[str, Any], Any]]()
    if isinstance(tank, dict) and OUTLINE in tank:
        found.append(("tank", tank, scene.obstacles[-1]))
    for name in DRAWN_TABLES:
        pairs = enumerate(
            zip(raw.get(name, []), getattr(scene, name, ()), strict=False)
        )  # a drawn tank is the last one
        found += [(f"{name}[{n}]", piece, shape) for n, (piece, shape) in pairs if OUTLINE in piece]
    return [
        (f"{name}.{OUTLINE}", _extent(shape), f"{piece[OUTLINE]}: {UNITLESS[Folder(piece[OUTLINE]).suffix.lower()]}")
        for name, piece, shape in found
        if UNIT not in piece
    ]


def _extent(shape: Any) -> str:
    """The sides of the box around a drawn shape, as text."""
    points = shape.vertices or list(itertools.chain.from_iterable(shape.triangles))
    return " × ".join(f"{max(values) - min(values):.4g}" for values in zip(*points, strict=True)) + " m"


def outline_followed(piece: dict[str, Any], path: Path, folder: Folder) -> Complaints:
    """Insert the outline that a piece of a scene names. Returns its faults."""
    if OUTLINE in piece:
        return followed((*path, OUTLINE), _outline_from, piece, piece.pop(OUTLINE), folder)
    if UNIT in piece:
        piece.pop(UNIT)
        return [((*path, UNIT), "says nothing without outline_from")]
    return []


def _there(folder: Folder, name: str) -> Folder:
    path = beside(folder, name)
    require_there(path, folder)
    return path


def _particles_from(region: dict[str, Any], name: str, folder: Folder) -> None:
    """Read one particle per line."""
    text = table_text(_there(folder, name), MOST_BYTES)
    known = LIQUID_COLUMNS if "z" in names_of(text) else {**LIQUID_COLUMNS, "mass": BODY_MASS.plane}
    lines = lines_of(text, known)
    columns = [key for key in LIQUID_COLUMNS if key in lines[0].values]
    region["particles"] = particles_of({key: [line.values[key] for line in lines] for key in columns})


def particles_of(columns: Mapping[str, list[float]]) -> dict[str, Any]:
    """The lists of a `ParticlesSpec` from columns by name."""
    axes = [axis for axis in AXES if axis in columns]
    plain: dict[str, Any] = {"positions": [list(row) for row in zip(*(columns[axis] for axis in axes), strict=True)]}
    if any(f"v{axis}" in columns for axis in AXES):
        still = [0.0] * len(columns["x"])
        speeds = [columns.get(f"v{axis}", still) for axis in axes]
        plain["velocities"] = [list(row) for row in zip(*speeds, strict=True)]
    names = {"density": "densities", "mass": "masses"}
    return {**plain, **{names[key]: columns[key] for key in names if key in columns}}


def _start_from(raw: dict[str, Any], name: str, folder: Folder) -> None:
    """Create a region for each region of the run."""
    from ecume.scenes.runs import frame_of_run
    from ecume.scenes.starts import refuse_a_file

    refuse_a_file(name)
    if raw.get("fluid"):
        raise ValueError("brings all the liquid; leave [[fluid]] out")
    frame, scene = frame_of_run(folder, name)
    if scene.model != "sph":
        raise ValueError(f"is a run of the model {scene.model!r}; expected one of sph")
    if _length(raw.setdefault("spacing", scene.spacing)) != scene.spacing:
        raise ValueError(f"has a spacing of {scene.spacing!r} m; leave spacing out, or write the same number")
    species = frame.arrays["species"]
    regions = [(species == number, region) for number, region in enumerate(scene.fluid) if (species == number).any()]
    raw["fluid"] = [_region(frame.arrays, mine, region) for mine, region in regions]


def _from_file(raw: dict[str, Any], given: object, folder: Folder) -> Complaints:
    """Create a region for each type in a file of another program."""
    from ecume.scenes.starts import opened, regions

    if raw.get("fluid"):
        return [(("fluid",), "has no meaning beside start_from, which contains all the liquid")]
    start, faults = opened(given, folder)
    if start is None:
        return faults
    try:
        raw["fluid"] = regions(raw, start)
    except Inconsistent as fault:
        return list(fault.complaints)
    return []


def _length(said: object) -> object:
    """A given value in meters, if it is a length."""
    from ecume.units import parse

    try:
        return parse(said, "m") if isinstance(said, str) else said
    except ValueError:
        return said


def _region(arrays: Mapping[str, Any], mine: Any, region: Any) -> dict[str, Any]:
    keys = {"positions": "position", "velocities": "velocity", "densities": "density", "masses": "mass"}
    particles = {key: arrays[name][mine].tolist() for key, name in keys.items()}
    others = {"color": region.color, "liquid": region.liquid if region.liquid != "first" else ""}
    return {"particles": particles, **{key: value for key, value in others.items() if value}}


def _outline_from(region: dict[str, Any], name: str, folder: Folder) -> None:
    """Read a drawn outline, in the unit of the file or the scene."""
    unit = region.pop(UNIT, None)  # also where the file is missing: otherwise the unit is a second fault
    path = _there(folder, name)
    kinds = {".stl": ("triangles", _triangles), ".dxf": ("vertices", _vertices)}
    if path.suffix.lower() not in kinds:
        raise ValueError("expected a .stl or .dxf file")
    key, read = kinds[path.suffix.lower()]
    found = read(bytes_of(path, MOST_MESH_BYTES), unit)
    farthest = max(map(abs, _coordinates(found)))
    if not farthest <= FARTHEST:
        raise ValueError(f"reaches to {farthest:.4g} m, beyond {FARTHEST:g} m; is outline_unit missing?")
    region[key] = found


def _coordinates(points: Any) -> Iterable[float]:
    """The coordinates in nested lists of points."""
    return itertools.chain.from_iterable(map(_coordinates, points)) if isinstance(points, list) else (points,)


def _meters(unit: object) -> float:
    from ecume.units import factor, parse

    if not isinstance(unit, str):
        raise ValueError(f"has the unit {echo(unit)}; expected text such as outline_unit = 'mm'")
    return parse(unit, "m") if unit[:1].isdigit() else factor(unit, "m")


def _triangles(content: bytes, unit: object) -> list[Any]:
    """The surface of an STL file; such files have no units."""
    trimesh = _library("trimesh")
    if fault := _fault_of_stl(content):
        raise ValueError(f"cannot be read as STL: {fault}")
    try:
        mesh = trimesh.load_mesh(io.BytesIO(content), file_type="stl")
        mesh.update_faces(_single(mesh.faces))
        if not _is_closed(mesh.faces):
            mesh.faces = _turned(mesh)
        triangles, closed = mesh.triangles, _is_closed(mesh.faces)
    except Exception as fault:  # any exception of the library means that the file is not a surface
        raise ValueError(f"cannot be read as STL: {fault}") from None
    if not len(triangles) or not closed:
        raise ValueError("has holes: a surface that is not closed has no inside; close it where it was drawn")
    scaled: list[Any] = (triangles * _meters("m" if unit is None else unit)).tolist()
    return scaled


def _single(faces: Any) -> Any:
    """Flags of the faces (T, 3) of the surface. Of equal faces only the first remains; opposite faces, as where bodies
    touch, and degenerate ones are removed.
    """
    turns = np.argmin(faces, axis=1)[:, None] + np.arange(3)
    first, one, other = np.take_along_axis(faces, turns % 3, axis=1).T
    keys = np.column_stack([first, np.minimum(one, other), np.maximum(one, other)])
    _, place, group = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    group, ways = group.ravel(), np.where(one < other, 1, -1)
    faced = np.bincount(group, ways > 0) * np.bincount(group, ways < 0) > 0
    kept = np.zeros(len(faces), bool)
    kept[place[~faced]] = True
    return kept & (first != one) & (one != other) & (other != first)


def _is_closed(faces: Any) -> bool:
    """Whether a surface is closed: each edge of a face also belongs to another face, in the opposite direction."""
    ends = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    ways = np.where(ends[:, 0] < ends[:, 1], 1, -1)
    edge = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True)[1].ravel()
    return not np.bincount(edge, ways).any()


STL_HEAD, STL_TRIANGLE = 84, 50
"""The bytes of the head of a binary STL file, which ends with the number of triangles, and of each triangle."""


def _fault_of_stl(content: bytes) -> str:
    """The reason why the bytes are not a complete STL file; empty for a file of the correct size, or a text with an
    end.
    """
    count = int.from_bytes(content[STL_HEAD - 4 : STL_HEAD], "little")
    if len(content) >= STL_HEAD and len(content) == STL_HEAD + STL_TRIANGLE * count:
        return "" if count else "it has no triangles"
    text = content.lower()
    if text.lstrip().startswith(b"solid") and b"facet" in text:
        return "" if b"endsolid" in text else "it ends before endsolid; was it cut off?"
    if len(content) < STL_HEAD or not content[:STL_HEAD].strip(b"\0"):
        return f"got {len(content)} bytes; expected a surface of triangles, binary or as text"
    room = (len(content) - STL_HEAD) / STL_TRIANGLE
    return f"its head announces {count} triangles, and its bytes are those of {room:.4g}; was it cut off?"


def _turned(mesh: Any) -> Any:
    """The faces (T, 3); those whose orientation differs from that of most of their piece are reversed."""
    faces, neighbors = mesh.faces.tolist(), dict[int, list[tuple[int, bool]]]()
    for (one, other), (a, b) in zip(mesh.face_adjacency.tolist(), mesh.face_adjacency_edges.tolist(), strict=True):
        agrees = _runs(faces[one], a, b) != _runs(faces[other], a, b)
        neighbors.setdefault(one, []).append((other, agrees))
        neighbors.setdefault(other, []).append((one, agrees))
    turned: dict[int, bool] = {}
    found: list[int] = []
    for first in range(len(faces)):
        if first in turned:
            continue
        turned[first], piece = False, [first]
        for here in piece:
            for there, agrees in neighbors.get(here, []):
                if there not in turned:
                    turned[there] = turned[here] == agrees
                    piece.append(there)
        most = 2 * sum(turned[face] for face in piece) > len(piece)
        found += [face for face in piece if turned[face] != most]
    alike = mesh.faces.copy()
    alike[found] = alike[found][:, ::-1]
    return alike


def _runs(face: list[int], a: int, b: int) -> bool:
    """Whether a triangle runs along an edge from a to b."""
    return face[face.index(a) - 2] == b


def _vertices(content: bytes, unit: object) -> list[list[float]]:
    """The single closed outline of a DXF drawing, with arcs as lines."""
    ezdxf = _library("ezdxf")
    try:
        drawing = _drawing(ezdxf, content)
        entities = _library("ezdxf.disassemble").recursive_decompose(drawing.modelspace().query(f"{DRAWN} INSERT"))
        paths = [_library("ezdxf.path").make_path(each) for each in entities if each.dxftype() in DRAWN.split()]
        lines = _joined([[(point.x, point.y) for point in each.flattening(_fine(each))] for each in paths if len(each)])
        meters = _library("ezdxf.units").conversion_factor(drawing.units, METERS) if drawing.units else 1.0
    except Exception as fault:  # any exception of the library means that the file is not a drawing
        raise ValueError(f"cannot be read as DXF: {_fault_of_dxf(fault)}") from None
    if len(lines) != 1:
        ends = "; lines count as one outline where their ends meet" if not lines and paths else ""
        raise ValueError(f"has {len(lines)} closed outlines; expected one per file{ends}")
    scale = meters if unit is None else _meters(unit)
    if len(lines[0]) < CORNERS:
        raise ValueError(f"has an outline of {len(lines[0])} points; expected at least {CORNERS}")
    corners = lines[0][:-1] if math.dist(lines[0][0], lines[0][-1]) <= MEETING * _size(lines[0]) else lines[0]
    return [[scale * x, scale * y] for x, y in corners]


Line = list[tuple[float, float]]


def _joined(lines: list[Line]) -> list[Line]:
    """The closed outlines among lines: closed lines, and chains of other lines whose ends meet in pairs."""
    if not lines:
        return []
    reach = MEETING * _size(list(itertools.chain.from_iterable(lines)))
    closed = [line for line in lines if math.dist(line[0], line[-1]) <= reach]
    parts = [line for line in lines if math.dist(line[0], line[-1]) > reach]
    if not parts:
        return closed
    node = _nodes([place for line in parts for place in (line[0], line[-1])], reach)
    met: dict[int, list[int]] = {}
    for end, mine in enumerate(node):
        met.setdefault(mine, []).append(end)
    left = set(range(len(parts)))
    for first in range(len(parts)):
        chain, end = Line(), 2 * first
        while end // 2 in left:
            left.remove(end // 2)
            line = parts[end // 2]
            chain += (line if end % 2 == 0 else line[::-1])[1 if chain else 0 :]
            others = [each for each in met[node[end ^ 1]] if each != end ^ 1]
            if len(others) != 1:  # the line ends, or branches
                break
            if others[0] == 2 * first:
                closed.append(chain)
            end = others[0]
    return closed


def _nodes(places: Line, reach: float) -> list[int]:
    """The index of the point at which each end lies; ends within reach of each other have the same point."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    pairs = cKDTree(places).query_pairs(reach, output_type="ndarray")
    links = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), (len(places), len(places)))
    found: list[int] = connected_components(links, directed=False)[1].tolist()
    return found


def _drawing(ezdxf: Any, content: bytes) -> Any:
    """The drawing in the bytes of a DXF file, text or binary."""
    with tempfile.TemporaryDirectory() as folder:  # the library detects the encoding only of files
        copy = Folder(folder) / "outline.dxf"
        copy.write_bytes(content.removeprefix(codecs.BOM_UTF8))
        return ezdxf.readfile(str(copy))


def _fault_of_dxf(fault: Exception) -> str:
    """What the library says, without the name of our copy."""
    if isinstance(fault, OSError):
        return "it does not begin as a drawing, with a section"
    name = type(fault).__name__
    return f"{name}: {str(fault).removeprefix(f'{name}: ')}"


CORNERS = 3
"""The smallest number of corners of an outline."""
DRAWN = "LINE ARC LWPOLYLINE POLYLINE CIRCLE ELLIPSE SPLINE"
MEETING = 1e-6
"""The distance below which ends of lines meet, over the size of the drawing."""
METERS = 6
"""The number of the unit meter in DXF."""
FINENESS = 1e-3
"""The largest distance of lines from an arc, over the size of the outline."""


def _fine(path: Any) -> float:
    return FINENESS * _size([(point.x, point.y) for point in path.control_vertices()])


def _size(points: list[tuple[float, float]]) -> float:
    """The larger side of the box around points."""
    return max(float(max(values) - min(values)) for values in zip(*points, strict=True))


def _library(name: str) -> Any:
    import importlib

    try:
        return importlib.import_module(name)
    except ImportError:
        package = name.partition(".")[0]
        raise ValueError(f"needs {package}, which is not installed: {install('shapes')}") from None
