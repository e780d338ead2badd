"""Floats from other sources than the scene itself: a table, or a frame of another run."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path as Folder
from typing import Any, NamedTuple

from pydantic import TypeAdapter, ValidationError

from ecume.scenes.common import dataclass
from ecume.scenes.faults import Inconsistent, Path, echo, faults_of, written
from ecume.scenes.floating import SurfaceEnergies
from ecume.scenes.floating.scene import PINNED
from ecume.scenes.quantities import STRICT, Color, ContactAngle, Name, PositiveDensity, Radius, Velocity
from ecume.scenes.runs import frame_of_run
from ecume.scenes.tables import MOST_BYTES, TableFaults, beside, lines_of, require_there, table_text
from ecume.trajectories.frame import Frame, omitted_from

TABLE, RUN = "particles_from", "start_from"
SOURCES = (TABLE, RUN)
"""Keys that exist in files only: reading converts them into `rows`."""

OTHERS = {"soft", "sph", "tracers"}
"""Models that read their particles elsewhere."""
MOST_MESSAGES = 20


@dataclass(frozen=True, kw_only=True, config=STRICT)
class RowDefaults:
    """The single [[particles]] entry that goes with `particles_from`; it fills columns that are missing in the
    table.
    """

    name: Name = ""
    radius: Radius | None = None
    density: PositiveDensity | None = None
    contact_angle: ContactAngle | None = None
    surface_energies: SurfaceEnergies | None = None
    velocity: tuple[Velocity, Velocity] = (0.0, 0.0)
    color: Color | None = None


Faults = list[tuple[Path, str]]


class Rows(NamedTuple):
    """Rows as plain data, their origins, and the faults; `key` is the name of the source."""

    key: str
    plain: list[dict[str, Any]]
    origins: list[str]
    faults: Faults

    def with_origins(self, faults: Faults) -> Faults:
        """Faults of rows, with the line of the table or the float of the run that each row comes from."""
        mine, others = [], []
        for path, text in faults:
            if self.origins and len(path) > 1 and path[0] == "rows":
                below = f", {written(path[2:])}" if path[2:] else ""
                mine.append(f"{self.origins[int(path[1])]}{below}: {self._named(text)}")
            else:
                others.append((path, text))
        return others + [((self.key,), text) for text in _few(mine)]

    def _named(self, text: str) -> str:
        """A message in which `rows[3]` is replaced by the origin of the row."""
        return re.sub(r"\brows\[([0-9]+)\]", lambda found: self.origins[int(found[1])], text)


def failed(key: str, messages: Sequence[str], path: Path = ()) -> Rows:
    """Empty rows with these faults."""
    return Rows(key, [], [], [(path or (key,), message) for message in messages])


def rows_from(raw: dict[str, Any], folder: Folder) -> Rows:
    """Remove the sources of a scene of floats from `raw`, and read their rows."""
    if str(raw.get("model")) in OTHERS:
        return failed("rows", [])
    given = {key: raw.pop(key) for key in SOURCES if key in raw}
    if not given:
        return failed("rows", [])
    if len(given) > 1 or "rows" in raw:
        return failed(next(iter(given)), ["of particles_from, start_from and rows only one can stand in a scene"])
    ((key, name),) = given.items()
    if key == RUN and not isinstance(name, str):
        return _from_file(raw, folder, name)
    if not isinstance(name, str):
        return failed(key, [f"got {echo(name)}; expected text"])
    try:
        return (_from_table if key == TABLE else _from_run)(raw, folder, name)
    except TableFaults as faults:
        return failed(key, [f"{name}, {message}" for message in _few(faults.messages)])
    except ValueError as fault:
        return failed(key, [f"{echo(name)} {fault}"])


def _few(messages: Sequence[str]) -> list[str]:
    """The first messages, and the number of the remaining ones."""
    left = len(messages) - MOST_MESSAGES
    return [*messages[:MOST_MESSAGES], *([f"and {left} more like these"] if left > 0 else [])]


def _from_table(raw: dict[str, Any], folder: Folder, name: str) -> Rows:
    table = beside(folder, name)
    require_there(table, folder)
    lines = lines_of(table_text(table, MOST_BYTES))
    defaults, faults = _defaults(raw.pop("particles", []))
    plain = [_row(line.values, defaults) for line in lines]
    missing = [key for key in ("radius", "density", "contact_angle") if not _has(plain[0], key)]
    faults += [
        ((TABLE,), f"{name} has no column {key}, and no [[particles]] gives one") for key in missing if not faults
    ]
    return Rows(TABLE, plain, [f"{name}, line {line.number}" for line in lines], faults)


def _has(row: Mapping[str, Any], key: str) -> bool:
    return key in row or (key == "contact_angle" and "surface_energies" in row)


def _row(values: Mapping[str, Any], defaults: Mapping[str, Any]) -> dict[str, Any]:
    """A line with missing values filled; its contact angle overrides the surface energies of the defaults."""
    row = {**defaults, **values}
    if "contact_angle" in values:
        row.pop("surface_energies", None)
    row["species_name"] = row.pop("name", "") or "float-1"
    return row


def _defaults(floats: object) -> tuple[dict[str, Any], Faults]:
    """The values of the single [[particles]] entry, for every row."""
    if not floats:
        return {}, []
    if not isinstance(floats, list) or len(floats) > 1 or not isinstance(floats[0], dict):
        return {}, [
            (("particles",), "beside particles_from expected one [[particles]] table, with defaults for all rows")
        ]
    layout = [key for key in LAYOUT if key in floats[0]]
    faults: Faults = [(("particles", 0, key), "has no meaning beside particles_from") for key in layout]
    plain = {key: value for key, value in floats[0].items() if key not in layout}
    try:
        TypeAdapter(RowDefaults).validate_python(plain)
    except ValidationError as error:
        faults += [(("particles", 0, *path), message) for path, message in faults_of(error, RowDefaults, plain)]
        return {}, faults
    velocity = plain.pop("velocity", (0.0, 0.0))
    return {"vx": velocity[0], "vy": velocity[1], **plain}, faults


LAYOUT = ("count", "placement", "positions", "spacing", "ring_radius", "center")


def _from_run(raw: dict[str, Any], folder: Folder, name: str) -> Rows:
    """The floats of a run; species of the scene replace keys of those of the run with the same name."""
    from ecume.scenes.starts import matched, of_run, refuse_a_file, require_box, tables_of

    refuse_a_file(name)
    plain = _rows_of_frame(*frame_of_run(folder, name))
    try:
        tables, start = tables_of(raw), of_run(folder, name, "floating")
        require_box(raw, start, 2)
        if tables:
            matched(start, tables)
    except Inconsistent as fault:
        return Rows(RUN, [], [], list(fault.complaints))
    changes = {str(one["name"]): one for one in tables}
    plain = [_changed(row, changes.get(row["species_name"], {})) for row in plain]
    raw.pop("particles", None)
    return Rows(RUN, plain, [f"{name}, float {number}" for number in range(1, len(plain) + 1)], [])


def _changed(row: dict[str, Any], now: Mapping[str, Any]) -> dict[str, Any]:
    """A float with changed properties. A disc or a shape of the scene replaces that of the run, and a contact angle or
    surface energies that of the run. A float that is pinned at an edge has no contact angle.
    """
    body, wetting = {"disc", "shape"}, {"contact_angle", "surface_energies"}
    replaced = {*(body if body & now.keys() else ()), *(wetting if wetting & now.keys() or _is_pinned(now) else ())}
    kept = {key: value for key, value in row.items() if key not in replaced}
    return {**kept, **{key: value for key, value in now.items() if key != "name"}}


def _is_pinned(now: Mapping[str, Any]) -> bool:
    """Whether a species has a body whose edge pins the contact line."""
    shape = now.get("shape")
    kind = shape.get("kind") if isinstance(shape, Mapping) else getattr(shape, "kind", None)
    return "disc" in now or kind in PINNED


def _from_file(raw: dict[str, Any], folder: Folder, value: object) -> Rows:
    """The floats of a file of another program."""
    from ecume.scenes.starts import float_rows, opened

    start, faults = opened(value, folder)
    if start is None:
        return Rows(RUN, [], [], faults)
    try:
        plain, origins = float_rows(raw, start)
    except Inconsistent as fault:
        return Rows(RUN, [], [], list(fault.complaints))
    return Rows(RUN, plain, origins, [])


def _rows_of_frame(frame: Frame, scene: Any) -> list[dict[str, Any]]:
    """The floats of one frame of a run. Raises ValueError."""
    species = scene.kinds
    missing = [name for name in ARRAYS if name not in frame.arrays]
    if missing and missing[0] in omitted_from(frame):
        raise ValueError(f"its frames have no {missing[0]}, which its scene omits from output.quantities")
    if missing:
        raise ValueError(f"is a run of another model: its frames have no {missing[0]}")
    columns = [frame.arrays[name].tolist() for name in ARRAYS]
    rows = [_row_of_float(values, *species[kind]) for *values, kind in zip(*columns, strict=True)]
    for key in (name for name in BESIDE if name in frame.arrays):
        rows = [{**row, key: number} for row, number in zip(rows, frame.arrays[key].tolist(), strict=True)]
    return [{**_wetted(row), **figure} for row, figure in zip(rows, _figures_of(scene), strict=True)]


def _figures_of(scene: Any) -> list[dict[str, Any]]:
    """The disc or the shape of each float of a scene. The angles are those of the frame."""
    found: list[dict[str, Any]] = []
    for given in (*scene.particles, *scene.rows):
        figure: dict[str, Any] = {}
        for key in ("disc", "shape"):
            if getattr(given, key) is not None:
                plain = TypeAdapter(type(getattr(given, key))).dump_python(getattr(given, key))
                figure[key] = {part: value for part, value in plain.items() if value is not None and part != "angle"}
        found += [figure] * given.count
    return found


def _wetted(row: dict[str, Any]) -> dict[str, Any]:
    """The row without the contact angle of a float pinned at an edge, which is NaN."""
    return row if math.isfinite(row["contact_angle"]) else {k: v for k, v in row.items() if k != "contact_angle"}


BESIDE = ("magnetic_moment", "angle", "spin")
"""Quantities that only some floats have."""
ARRAYS = ("position", "velocity", "radius", "density", "contact_angle", "species")


def _row_of_float(values: Sequence[Any], name: str, color: str | None) -> dict[str, Any]:
    """One float of a frame as a row; a computed contact angle is stored as an angle."""
    (x, y), (vx, vy), radius, density, angle = values
    row = {"x": x, "y": y, "vx": vx, "vy": vy, "radius": radius, "density": density, "contact_angle": angle}
    return {**row, "species_name": name, "color": color}
