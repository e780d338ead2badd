"""Initial particles from a frame of another run, a file of another program, or a table.

`start_from = "runs/bowl@-1"` is a frame of a run; a table is a file of another program:

    start_from = { file = "packing.gsd", length_unit = "1 mm", time_unit = "1 ms" }

`particles_from = "beads.csv"` is a table with one particle a line.

The particles are matched with the species of the scene, `[[particles]]`, by the names of their types. The values of a
species in the scene, its radius for example, override those of the file.
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path as Folder
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, TypeAdapter, ValidationError

from ecume.errors import BadInput
from ecume.scenes.common import dataclass
from ecume.scenes.faults import Complaints, Inconsistent, Path, echo, faults_of, suggestion
from ecume.scenes.quantities import STRICT, BodyMass, Duration, InPlane, Name, sides_along
from ecume.scenes.tables import COMPRESSED, MOST_BYTES, beside, lines_of, require_there, table_text, text_of
from ecume.trajectories.foreign import series
from ecume.trajectories.foreign.particles import FileFault, Particles
from ecume.trajectories.foreign.series import Series
from ecume.trajectories.frame import Frame, omitted_from
from ecume.units import Length, Unit

RUN, TABLE = "start_from", "particles_from"
PLACES = {"x": "m", "y": "m", "z": "m", "radius": "m", "name": ""}
COLUMNS = {"soft": PLACES, "tracers": {**PLACES, "vx": "m/s", "vy": "m/s", "vz": "m/s"}}
"""The columns of tables of soft spheres and tracers, and their SI units; `name` is a species."""
LAYOUT = ("count", "placement", "positions", "velocities", "spacing", "ring_radius", "center", "low", "high")
"""Keys of a species that state where its particles are."""
FORMATS = {
    ".gsd": "gsd", ".xyz": "xyz", ".extxyz": "xyz", ".data": "lammps", ".lmp": "lammps", ".lammps": "lammps",
    ".dump": "dump", ".lammpstrj": "dump", ".yaml": "dump", ".yml": "dump", ".dcd": "dcd",
}  # fmt: skip
"""The format of a file, by the end of its name."""
BINARY = {"gsd", "dcd"}
"""The formats that are no texts."""
ANOTHER_FRAME = re.compile(r"(.+)@(-?[0-9]{1,9})")
FAR = 1e9
"""The number of sides beyond which positions are no longer moved into a periodic tank: they are faults of a file."""
FARTHEST_UNIT = 1e6
"""The largest unit of length of a file (m): places at sea are in nautical miles or in 100 km."""
ALIKE = 1e-5
"""The relative difference below which sides count as equal, since files hold them in single precision."""
FLAT = 1e-6
"""The range of z over that of x and y in a file with two dimensions."""
NO_MEANING = "has no meaning beside start_from or particles_from, which contain the positions"


@dataclass(frozen=True, kw_only=True, config=STRICT)
class StartSpec:
    """A file of another program from which a scene starts, and the units of its numbers."""

    file: Annotated[str, Field(min_length=1, max_length=1000)]
    """The file, beside the scene's: GSD (`.gsd`), XYZ or extended XYZ (`.xyz`, `.extxyz`), LAMMPS data (`.data`,
    `.lmp`), LAMMPS dumps (`.dump`, `.lammpstrj`, `.yaml`), DCD (`.dcd`); texts also compressed (`.gz`).
    `NAME@FRAME` is a frame, by default the last one. Example: `"packing.gsd@-1"`. Effect: sets the start."""
    length_unit: Annotated[Length, Field(gt=0.0, le=FARTHEST_UNIT)]
    """The unit of length of the file, such as 1 mm where one sigma means a millimeter (m). Effect: scales positions
    and diameters."""
    time_unit: Duration | None = None
    """The unit of time of the file (s); without it velocities are ignored. Effect: velocities are proportional to
    the unit of length divided by it."""
    mass_unit: BodyMass | None = None
    """The unit of mass of the file (kg; also kg/m for a tank in 2D); without it masses and densities are ignored.
    Effect: scales masses and densities."""
    species: dict[Name, Name] = dataclasses.field(default_factory=dict)
    """The species of the scene for each type of the file; by default the one of the same name, or, of types that are
    numbers, the one at this place. Example: `{ A = "small", B = "large" }`. Effect: determines the species of each
    particle."""
    format: Literal["", "gsd", "xyz", "lammps", "dump", "dcd"] = ""
    """The format of the file; by default it follows from the end of its name. Effect: selects the reader."""


class Start(NamedTuple):
    """Particles in SI units, and the species of the scene that correspond to their types."""

    particles: Particles
    name: str
    """The file or run, as the scene names it."""
    species: Mapping[str, str]
    """The species of each type, where it differs."""
    known: Mapping[str, Mapping[str, Any]]
    """The species of the former run with their keys; empty for a file."""
    hint: str = ""
    """What to check where sizes differ."""
    key: str = RUN
    """the key of the scene that names it"""
    without_z: bool = False
    """whether the positions have two coordinates only"""
    in_plane: bool = False
    """whether masses are per depth (kg/m), as in tanks in 2D"""


def is_run(value: object) -> bool:
    """Whether `start_from` names a frame of a run."""
    return isinstance(value, str)


def opened(value: object, folder: Folder) -> tuple[Start | None, Complaints]:
    """The particles of a file of another program, or its faults. `value` is the value of `start_from`."""
    if not isinstance(value, Mapping):
        return None, [((RUN,), f"got {echo(value)}; expected the text RUN@FRAME or a table with file and length_unit")]
    try:
        spec = TypeAdapter(StartSpec).validate_python(dict(value))
    except ValidationError as error:
        return None, [((RUN, *path), message) for path, message in faults_of(error, StartSpec, value)]
    try:
        particles, in_plane = _in_si(_read(spec, folder), spec), isinstance(spec.mass_unit, InPlane)
        return Start(particles, spec.file, spec.species, {}, "; check length_unit", in_plane=in_plane), []
    except FileFault as fault:
        return None, [((RUN, "file"), f"{spec.file}, {fault}")]
    except ValueError as fault:
        return None, [((RUN, "file"), f"{echo(spec.file)} {fault}")]


def of_table(folder: Folder, name: str, model: str) -> Start:
    """The particles of a table, whose radii are those of the species unless there is a column. Raises ValueError."""
    path = beside(folder, name)
    require_there(path, folder)
    lines = [line.values for line in lines_of(table_text(path, MOST_BYTES), COLUMNS[model])]
    types = [line.get("name", "") for line in lines]
    names = tuple(sorted(set(types)))

    def columns(*keys: str) -> NDArray[np.float64]:
        """These columns, zero where one is missing."""
        return np.array([[line.get(key, 0.0) for key in keys] for line in lines])

    velocities = ("vx", "vy", "vz")
    return Start(
        Particles(
            names,
            np.array([names.index(each) for each in types]),
            columns("x", "y", "z"),
            columns(*velocities) if lines[0].keys() & {*velocities} else None,
            2.0 * columns("radius")[:, 0] if "radius" in lines[0] else None,
        ),
        name,
        {},
        {},
        key=TABLE,
        without_z="z" not in lines[0],
    )


def refuse_a_file(name: str) -> None:
    """Raise ValueError if `start_from` is the name of a file of another program as plain text."""
    match = ANOTHER_FRAME.fullmatch(name)
    if _format_of(Folder(match[1] if match else name)):
        table = f'start_from = {{ file = "{name}", length_unit = "1 mm" }}'
        raise ValueError(f"is a file without units; expected a table such as {table}")


def _read(spec: StartSpec, folder: Folder) -> Particles:
    """The particles in the units of the file. Raises ValueError."""
    path, frame = _place_in(spec, folder)
    return _frames_of(path, spec).read(frame)


def _place_in(spec: StartSpec, folder: Folder) -> tuple[Folder, int]:
    """The file and the number of the frame. Raises ValueError."""
    path, frame = beside(folder, spec.file), -1
    match = ANOTHER_FRAME.fullmatch(spec.file)
    if match and not path.is_file():
        path, frame = beside(folder, match[1]), int(match[2])
    require_there(path, folder)
    if not path.is_file():
        raise ValueError('is not a regular file; a run is named by text, as in start_from = "runs/bowl@-1"')
    return path, frame


def _frames_of(path: Folder, spec: StartSpec) -> Series:
    kind = spec.format or _format_of(path)
    if not kind:
        table = "; a table is named by particles_from" if path.suffix.lower() in (".csv", ".tsv", ".txt") else ""
        known = ", ".join(FORMATS)
        raise ValueError(f"has an unknown ending; expected one of {known}, or format in start_from{table}")
    if kind in BINARY and path.suffix.lower() == COMPRESSED:
        raise ValueError(f"is compressed, which only texts may be; decompress it: gunzip {path.name}")
    return series.FORMATS[kind](path, lambda each: text_of(each, MOST_BYTES))


def _format_of(path: Folder) -> str:
    """The format according to the extension of a name, without that of a compressed file; empty if unknown."""
    name = path.with_suffix("") if path.suffix.lower() == COMPRESSED else path
    return FORMATS.get(name.suffix.lower(), "")


class AllFrames(NamedTuple):
    """The frames of a file of another program."""

    name: str
    """The file, without the number of a frame."""
    series: Series
    """in the units of the file"""
    spec: StartSpec

    def in_si(self) -> Series:
        """The frames in SI units."""
        return Series(self.series.frames, lambda frame: _in_si(self.series.read(frame), self.spec))

    @property
    def ignores_velocities(self) -> bool:
        """Whether the frames have velocities, which without a unit of time have no meaning. Raises ValueError."""
        return not self.spec.time_unit and self.series.read(0).velocity is not None


def ignored_velocities(raw: Mapping[str, Any], folder: Folder) -> list[tuple[str, str, str]]:
    """The key, the file and the remark if a scene starts from a file with velocities and states no unit of time. Soft
    spheres have no inertia, and their velocities follow from the positions.
    """
    value = raw.get(RUN)
    if not isinstance(value, Mapping) or value.get("time_unit") is not None or raw.get("model") == "soft":
        return []
    velocity = _read(TypeAdapter(StartSpec).validate_python(dict(value)), folder).velocity
    if velocity is None or not velocity.any():
        return []
    return [(f"{RUN}.file", str(value["file"]), f"its velocities are ignored; {RUN}.time_unit states their unit")]


def all_frames(value: object, folder: Folder) -> AllFrames:
    """The frames of the file in `start_from`. Raises BadInput, and ValueError from `read`."""
    if not isinstance(value, Mapping):
        raise BadInput("the scene has no table [start_from] with the file and its units")
    try:
        spec = TypeAdapter(StartSpec).validate_python(dict(value))
        path, _ = _place_in(spec, folder)
        found = _frames_of(path, spec)
        name = spec.file if beside(folder, spec.file) == path else spec.file.rpartition("@")[0]
    except ValidationError as error:
        (place, message), *_ = faults_of(error, StartSpec, value)
        raise BadInput(f"{RUN}.{'.'.join(map(str, place))}: {message}") from None
    except ValueError as fault:
        raise BadInput(f"{RUN}.file: {value.get('file')} {fault}") from None
    return AllFrames(name, found, spec)


def _in_si(found: Particles, spec: StartSpec) -> Particles:
    """The particles in SI units; quantities without a unit are omitted."""
    length, mass = spec.length_unit, spec.mass_unit
    x, y, z = found.sides or (0.0, 0.0, 0.0)
    return found._replace(
        position=length * found.position,
        velocity=_times(found.velocity, length / spec.time_unit if spec.time_unit else None),
        diameter=_times(found.diameter, length),
        mass=_times(found.mass, mass),
        density=_times(found.density, mass / length ** (2 if isinstance(mass, InPlane) else 3) if mass else None),
        sides=None if found.sides is None else (x * length, y * length, z * length),
        tilt=length * found.tilt,
        instant=None if found.instant is None else found.instant * (spec.time_unit or 1.0),
        timed=found.timed and spec.time_unit is not None,
    )


def _times(values: NDArray[np.float64] | None, unit: float | None) -> NDArray[np.float64] | None:
    return None if values is None or unit is None else unit * values


def of_run(folder: Folder, name: str, model: str) -> Start:
    """The particles of a frame of another run, with its species if it is of the same model. Raises ValueError."""
    from ecume.scenes.runs import frame_of_run

    refuse_a_file(name)
    frame, scene = frame_of_run(folder, name)
    arrays, numbers = _there(frame), frame.numbers
    if "species" not in arrays or not len(frame.arrays["species"]):
        raise ValueError(f"is a run of the model {scene.model!r}, whose frames have no species")
    if not len(arrays["species"]):
        raise ValueError("has no particle in this frame: all have left or are deposited")
    position = np.zeros((len(arrays["position"]), 3))
    position[:, : arrays["position"].shape[1]] = arrays["position"]
    velocity = np.zeros_like(position)
    if "velocity" in arrays:
        velocity[:, : arrays["velocity"].shape[1]] = arrays["velocity"]
    sides = [float(numbers.get(key, 0.0)) for key in ("box_width", "box_height", "box_depth")]
    tilt = float(numbers.get("box_tilt", 0.0))
    particles = Particles(
        tuple(kind.name for kind in scene.kinds),
        arrays["species"],
        position,
        velocity if "velocity" in arrays else None,
        2.0 * arrays["radius"] if "radius" in arrays else None,
        sides=(sides[0], sides[1], sides[2]) if sides[0] > 0.0 else None,
        tilt=abs(tilt - sides[0] * round(tilt / sides[0])) if sides[0] > 0.0 else 0.0,
    )
    return Start(particles, name, {}, _keys_of(scene) if scene.model == model else {})


def _there(frame: Frame) -> Mapping[str, NDArray[Any]]:
    """The arrays of the particles that have not left; particles that left remain in frames at their last position.
    Raises ValueError for frames without this flag.
    """
    if "left" in omitted_from(frame):
        raise ValueError('has frames without "left", which marks the particles that left; see its output.quantities')
    if "left" not in frame.arrays:
        return frame.arrays
    return {name: array[frame.arrays["left"] < 0] for name, array in frame.arrays.items()}


def _keys_of(scene: Any) -> dict[str, dict[str, Any]]:
    """The keys of each species of a run, except those of positions; rows have none."""
    found: dict[str, dict[str, Any]] = {kind.name: {} for kind in scene.kinds}
    for kind, one in zip(scene.kinds, getattr(scene, "particles", ()), strict=False):
        found[kind.name] = {key: value for key, value in table_of(one).items() if key not in LAYOUT}
    return found


def table_of(entry: Any) -> dict[str, Any]:
    """A species as a table: a dictionary, or the values of a dataclass that differ from its defaults."""
    if isinstance(entry, Mapping):
        return dict(entry)
    values = {field.name: (getattr(entry, field.name), field.default) for field in dataclasses.fields(entry)}
    return {name: value for name, (value, default) in values.items() if value != default}


def tables_of(raw: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The species of the plain data of a scene. Raises Inconsistent if they contain positions."""
    given = raw.get("particles", [])
    tables = given if isinstance(given, (list, tuple)) else [given]
    if not all(isinstance(one, Mapping) or dataclasses.is_dataclass(one) for one in tables):
        raise Inconsistent([(("particles",), f"got {echo(given)}; expected [[particles]] tables")])
    found = [table_of(one) for one in tables]
    wrong: Complaints = [
        (("particles", index, key), NO_MEANING) for index, one in enumerate(found) for key in LAYOUT if key in one
    ]
    if wrong:
        raise Inconsistent(wrong)
    return found


class Species(NamedTuple):
    """A species of the scene with its particles."""

    place: int | None
    """The index of its table in the scene; None if only the former run describes it."""
    keys: dict[str, Any]
    which: NDArray[np.int64]
    """The indices of its particles in the file."""
    density: NDArray[np.float64] | None = None
    """Of each of them, from the file, unless the scene states it."""


def matched(start: Start, tables: Sequence[Mapping[str, Any]]) -> list[Species]:
    """The species with their particles; those of the scene come first. Raises Inconsistent."""
    names = [str(one.get("name", "")) for one in tables]
    types = [start.particles.names[kind] for kind in sorted(set(start.particles.kind.tolist()))]
    if start.known:
        unknown = [(index, name) for index, name in enumerate(names) if name not in start.known]
        if unknown:
            raise Inconsistent([_unknown(index, name, start) for index, name in unknown])
    places = {each: _place(each, start, names, len(types)) for each in types}
    lost: Complaints = [
        (
            ("particles", index, "name"),
            f"got {name!r}; {start.name} has no particle of it: its types are {_listed(types)}",
        )
        for index, name in enumerate(names)
        if index not in places.values()
    ]
    if lost:
        raise Inconsistent(lost)
    found: list[Species] = []
    for place in sorted(set(places.values()), key=lambda one: (one is None, one)):
        mine = [each for each in types if places[each] == place]
        groups = [[each] for each in mine] if place is None else [mine]
        for group in groups:
            kinds = [number for number, name in enumerate(start.particles.names) if name in group]
            keys = {**start.known.get(group[0], {}), **(tables[place] if place is not None else {})}
            keys.setdefault("name", group[0])
            found.append(Species(place, keys, np.flatnonzero(np.isin(start.particles.kind, kinds))))
    return found


def _unknown(index: int, name: str, start: Start) -> tuple[Path, str]:
    if not name:
        return ("particles", index, "name"), f"is missing; expected one of {_listed(start.known)} as in {start.name}"
    return (
        "particles",
        index,
        "name",
    ), f"got {name!r}; {start.name} has no such species; {suggestion(name, start.known)}"


def _place(each: str, start: Start, names: Sequence[str], types: int) -> int | None:
    """The index of the species of a type; None if the former run describes it. Raises Inconsistent."""
    target = start.species.get(each, each)
    if target in names:
        return names.index(target)
    if start.known:
        return None
    if each not in start.species and each.isascii() and each.isdigit() and 1 <= int(each) <= len(names):
        return int(each) - 1
    if each not in start.species and len(names) == types == 1:
        return 0
    listed = f"the species are {_listed(names)}" if all(names) else "there is a species without a name"
    species = listed if names else "the scene has no [[particles]]"
    hint = f"expected a species named {target!r}"
    if start.key == RUN:
        hint += f", or species = {{ {each} = NAME }} in start_from"
    elif not names:
        hint = "expected one [[particles]] table for each of them"
    elif not each:
        hint = "expected one of them in each line of a column name"
    which = f"particles of type {each!r}" if each else "particles without a name"
    raise Inconsistent([((start.key,), f"{start.name} has {which}, and {species}; {hint}")])


def _listed(names: Sequence[str] | Mapping[str, Any]) -> str:
    return ", ".join(map(repr, names))


def dimensions_of(raw: Mapping[str, Any], particles: Particles) -> int:
    """The dimensions of a scene, from its container, or without a container from the file."""
    tank, cell = raw.get("tank"), raw.get("cell")
    lists = [tank.get("high"), tank.get("low"), *(tank.get("vertices") or ())] if isinstance(tank, Mapping) else []
    lists += [cell.get("size")] if isinstance(cell, Mapping) else []
    for one in lists:
        if isinstance(one, (list, tuple)) and len(one) in (2, 3):
            return len(one)
    if isinstance(tank, Mapping):
        return 3 if tank.get("dimensions") == 3 else 2
    return 2 if raw.get("model") == "floating" or _is_flat(particles) else 3


def _is_flat(particles: Particles) -> bool:
    spans = np.ptp(particles.position, axis=0)
    return bool(spans[2] <= FLAT * max(spans[0], spans[1]))


def require_dimensions(start: Start, dimensions: int) -> None:
    """Raise Inconsistent if a file has three dimensions and the scene two, or a table two and the scene three."""
    if dimensions == 3 and start.without_z:
        raise Inconsistent([((TABLE,), f"{start.name} has no column z, and the scene has 3 dimensions")])
    if dimensions == 2 and not _is_flat(start.particles):
        low, high = start.particles.position[:, 2].min(), start.particles.position[:, 2].max()
        message = f"{start.name} is 3D: z is from {low:.4g} m to {high:.4g} m; the scene has 2 dimensions"
        raise Inconsistent([((start.key,), message)])


def require_box(raw: dict[str, Any], start: Start, dimensions: int) -> None:
    """Fill in the periodic cell, or raise Inconsistent where that of the scene differs from the box of the file."""
    cell, sides = raw.get("cell"), start.particles.sides
    if not isinstance(cell, dict) or raw.get("walls"):
        return
    if cell.get("volume_fraction") is not None:
        raise Inconsistent([(("cell", "volume_fraction"), NO_MEANING)])
    if sides is None:
        return
    _require_rectangular(start)
    size = cell.setdefault("size", list(sides[:dimensions]))
    own = [_length(side) for side in size] if isinstance(size, (list, tuple)) else []
    if len(own) == dimensions and all(own):
        _compare(own, sides, ("cell", "size"), start)


class Period(NamedTuple):
    """A periodic axis of a tank, and its ends (m)."""

    axis: int
    low: float
    high: float


def periods_of(raw: Mapping[str, Any]) -> list[Period]:
    """The periodic axes of the tank in a scene's plain data, without those that cannot be read."""
    tank = raw.get("tank")
    if not isinstance(tank, Mapping) or not isinstance(tank.get("high"), (list, tuple)):
        return []
    high = [_length(each) for each in tank["high"]]
    low = [_length(each) for each in tank.get("low") or [0.0] * len(high)]
    names = sides_along("z" if raw.get("up") == "z" else "y", len(high))[::2]
    found = []
    for axis, (name, a, b) in enumerate(zip(names, low, high, strict=False)):
        side, axes = tank.get(name), tank.get("periodic")
        periodic = isinstance(axes, (list, tuple)) and "xyz"[axis] in axes
        periodic |= isinstance(side, Mapping) and side.get("kind") == "periodic"
        if periodic and a is not None and b is not None and a < b:
            found.append(Period(axis, a, b))
    return found


def in_tank(start: Start, periods: Sequence[Period]) -> Start:
    """The particles at the positions of their images inside the tank, since boxes of other programs may begin anywhere.
    Raises Inconsistent if the box of the file has another size.
    """
    sides, position = start.particles.sides, start.particles.position.copy()
    if sides is None:
        return start
    if any(axis for axis, _, _ in periods):  # images across sides along y or z are shifted by the tilt
        where = f" for a tank that is periodic along {' and '.join('xyz'[axis] for axis, _, _ in periods)}"
        _require_rectangular(start, f"{where}; write the file without a tilt, or use walls there")
    for axis, low, high in periods:
        _compare([high - low], sides[axis : axis + 1], ("tank", "high"), start)
        away = np.floor((position[:, axis] - low) / (high - low))
        near = (away != 0.0) & (np.abs(away) < FAR)
        position[:, axis] = np.where(near, position[:, axis] - away * (high - low), position[:, axis])
    return start._replace(particles=start.particles._replace(position=position))


def _require_rectangular(start: Start, purpose: str = "") -> None:
    """Raise Inconsistent where the box of a file is tilted."""
    particles = start.particles
    if particles.sides is not None and particles.tilt > ALIKE * max(particles.sides):
        message = f"{start.name} has a box tilted by {particles.tilt:.4g} m; expected a rectangular one{purpose}"
        raise Inconsistent([((start.key,), message)])


def _compare(own: Sequence[float | None], sides: Sequence[float], path: Path, start: Start) -> None:
    if any(one is None or abs(one - side) > ALIKE * side for one, side in zip(own, sides, strict=False)):
        there = ", ".join(f"{side:.6g} m" for side in sides[: len(own)])
        here = ", ".join(f"{one:.6g} m" for one in own)
        raise Inconsistent([(path, f"got {here}; the periodic box of {start.name} is {there}{start.hint}")])


def _length(value: object) -> float | None:
    try:
        return Unit("m").number(value)
    except ValueError:
        return None


def filled(raw: dict[str, Any], start: Start) -> None:
    """Insert positions into the species of a scene of soft spheres or tracers. Raises Inconsistent."""
    dimensions = dimensions_of(raw, start.particles)
    require_dimensions(start, dimensions)
    require_masses_of_spheres(start)
    require_box(raw, start, dimensions)
    start = in_tank(start, periods_of(raw))
    tables, species, faults = tables_of(raw), [], []
    for one in matched(start, tables):
        particles = start.particles
        if raw["model"] == "tracers":
            faults += _take_density(one, _densities(one, particles))
        if "radius" not in one.keys:
            faults += _take_radius(one, start)
        stated = one.place is not None and "velocity" in tables[one.place]
        moving = raw["model"] == "tracers" and particles.velocity is not None and not stated
        velocities = {"velocities": particles.velocity[one.which, :dimensions].tolist()} if moving else {}  # type: ignore[index]
        species.append({**one.keys, "positions": particles.position[one.which, :dimensions].tolist(), **velocities})
    if faults:
        raise Inconsistent(faults)
    raw["particles"] = species


def _densities(one: Species, particles: Particles) -> NDArray[np.float64] | None:
    """The densities of the particles of a species without a density, from the densities or the masses in the file; None
    without either.
    """
    if "density" in one.keys:
        return None
    if particles.density is not None:
        return particles.density[one.which]
    radius = 0.5 * particles.diameter[one.which] if particles.diameter is not None else None
    if "radius" in one.keys:
        radius = np.full(len(one.which), _length(one.keys["radius"]) or math.nan)
    if particles.mass is None or radius is None or not (radius > 0.0).all():
        return None
    return np.asarray(particles.mass[one.which] / (4.0 / 3.0 * math.pi * radius**3))


def _take_density(one: Species, found: NDArray[np.float64] | None) -> Complaints:
    """Set the density of a species from those of the file, which must be equal."""
    if found is None:
        return []
    if np.ptp(found) > ALIKE * found.max():
        path: Path = ("particles", one.place or 0, "density")
        return [(path, f"is missing; those of the file reach from {found.min():.4g} to {found.max():.4g} kg/m^3")]
    one.keys["density"] = float(found[0])
    return []


def _no_radius(start: Start) -> str:
    usual = "; GSD omits diameters that are all 1: write radius as half of length_unit if they are meant"
    match = ANOTHER_FRAME.fullmatch(start.name)
    is_gsd = (match[1] if match else start.name).endswith(".gsd")
    return f"is missing; {start.name} has no diameters{usual if is_gsd else ''}"


def _take_radius(one: Species, start: Start) -> Complaints:
    """Set the radius of a species from the diameters of the file: one radius, or a list if they differ."""
    path: Path = ("particles", one.place or 0, "radius")
    if start.particles.diameter is None:
        return [(path, _no_radius(start))]
    mine = start.particles.diameter[one.which]
    alike = np.ptp(mine) <= ALIKE * mine.max()
    one.keys["radius"] = 0.5 * float(mine[0]) if alike else (0.5 * mine).tolist()
    return []


def require_masses_of_spheres(start: Start) -> None:
    """Raise Inconsistent if the unit of mass is that of 2D. Except for liquid, particles in 2D are spheres, too."""
    if start.in_plane:
        raise Inconsistent([((RUN, "mass_unit"), "got a mass per length; expected a mass as in '1 mg', of spheres")])


def float_rows(raw: dict[str, Any], start: Start) -> tuple[list[dict[str, Any]], list[str]]:
    """The rows of a scene of floats, and the origin of each. Raises Inconsistent."""
    require_dimensions(start, 2)
    require_masses_of_spheres(start)
    require_box(raw, start, 2)
    found = [one._replace(density=_densities(one, start.particles)) for one in matched(start, tables_of(raw))]
    faults: Complaints = []
    for one in found:
        if "radius" not in one.keys and start.particles.diameter is None:
            faults.append((("particles", one.place or 0, "radius"), _no_radius(start)))
        else:
            faults += _faults_of_species(one, start.particles)
    if faults:
        raise Inconsistent(faults)
    rows = {int(index): _row(one, start.particles, int(index)) for one in found for index in one.which}
    origins = [f"{start.name}, particle {index + 1}" for index in sorted(rows)]
    raw.pop("particles", None)
    return [rows[index] for index in sorted(rows)], origins


def _faults_of_species(one: Species, particles: Particles) -> Complaints:
    """The faults of a species of floats, without those of the numbers in the file."""
    from ecume.scenes.floating import FloatRow

    row = _row(one, particles, int(one.which[0]))
    try:
        TypeAdapter(FloatRow).validate_python(row)
    except ValidationError as error:
        found = faults_of(error, FloatRow, row)
        mine = [each for each in found if not each[0] or each[0][0] in one.keys or each[0][0] not in row]
        return [(("particles", one.place or 0, *path), message) for path, message in mine]
    return []


def _row(one: Species, particles: Particles, index: int) -> dict[str, Any]:
    keys = {key: value for key, value in one.keys.items() if key not in ("name", "velocity")}
    if one.density is not None:
        keys["density"] = float(one.density[int(np.searchsorted(one.which, index))])
    if "radius" not in keys and particles.diameter is not None:
        keys["radius"] = 0.5 * float(particles.diameter[index])
    x, y = particles.position[index, :2].tolist()
    vx, vy = one.keys.get("velocity", (0.0, 0.0))
    if "velocity" not in one.keys and particles.velocity is not None:
        vx, vy = particles.velocity[index, :2].tolist()
    return {"x": x, "y": y, "vx": vx, "vy": vy, **keys, "species_name": one.keys["name"]}


def regions(raw: dict[str, Any], start: Start) -> list[dict[str, Any]]:
    """The regions of a tank, one per type of the file. Raises Inconsistent."""
    dimensions = dimensions_of(raw, start.particles)
    require_dimensions(start, dimensions)
    if start.in_plane and dimensions == 3:
        raise Inconsistent([((RUN, "mass_unit"), "has the unit of another dimension; expected kg in 3D")])
    start = in_tank(start, periods_of(raw))
    particles, found = start.particles, []
    for kind in sorted(set(particles.kind.tolist())):
        which = particles.kind == kind
        lists = {"positions": particles.position[which, :dimensions].tolist()}
        if particles.velocity is not None:
            lists["velocities"] = particles.velocity[which, :dimensions].tolist()
        for key, values in (("masses", particles.mass), ("densities", particles.density)):
            if values is not None:
                lists[key] = values[which].tolist()
        found.append({"particles": lists})
    return found
