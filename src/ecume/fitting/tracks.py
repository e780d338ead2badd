"""Measured tracks: positions of objects over time, and their assignment to the particles of a
scene.

Columns are recognized by their headers: plain `x, y, t, id`, trackpy's `x, y, frame, particle`, TrackMate's
`POSITION_X, POSITION_Y, POSITION_T or FRAME, TRACK_ID` with three more header lines, and those of `ecume export --to
csv`. Other columns are ignored. MTrackJ's tables have TID, those of ImageJ's Manual Tracking have "Track n°",
those of MOSAIC "Trajectory". Tables of Tracker (the video program), Logger Pro, Kinovea, idtracker.ai and DeepLabCut
have columns x and y per object, or one object in each file.
"""

from __future__ import annotations

import csv
import io
import math
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment

from ecume.errors import BadInput
from ecume.scenes.faults import echo, suggestion
from ecume.scenes.tables import table_text
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume.units import Array, factor

if TYPE_CHECKING:
    from ecume.scenes.schema import Scene


LEAST = 3
"""The least number of instants for a fit of motion."""
MOST_NAMED = 20
"""The largest number of objects that an error lists."""
MOST_BYTES = 256 * 2**20
MOST_PLACES = 2 * 10**7
"""The largest number of objects times instants."""
SPELLED = {
    "x": ("x", "position_x"),
    "y": ("y", "position_y"),
    "time": ("t", "time", "position_t", "zeit", "temps", "tiempo", "tempo"),
    "frame": ("frame", "slice n°", "slice", "bild", "image", "imagen"),
    "object": (
        "track_id", "tid", "track n°", "trajectory", "trajectory_id", "particle", "particle_id", "track", "object",
        "object_id", "id", "objekt", "objet", "objeto", "teilchen", "particule", "spur",
    ),
}  # fmt: skip
"""The accepted names of columns, in lower case, also in German, French and Spanish; the first one in the table is
used."""


def _plain(name: str) -> str:
    """A name in lower case without blanks and underscores, in which programs differ."""
    return name.lower().replace("_", "").replace(" ", "")


NAMES = {kind: tuple(map(_plain, names)) for kind, names in SPELLED.items()}
"""The same as they are compared."""
HEAD = re.compile(r"\s*([^\[\](),;]*?)\s*(?:[\[(]\s*([^\[\]()]*?)\s*[\])])?\s*")
UNITS = {"micron": "um", "microns": "um", "µm": "um", "sec": "s", "msec": "ms"}
"""Names of units in TrackMate and ImageJ that differ from those of ecume."""
PIXELS = ("pixel", "pixels", "px")
FRAMES = ("frame", "frames")
DECIMAL_COMMA = re.compile(r"([+-]?[0-9]*),([0-9]+(?:[eE][+-]?[0-9]+)?)")
"""A number with a decimal comma, in a table separated by semicolons or tabs, or in quotes."""
THOUSANDS = re.compile(r"[+-]?[1-9][0-9]{0,2}(?:,[0-9]{3})+")
"""A number whose comma divides thousands, or decimals."""
NO_OBJECT = ("", "none", "nan")
"""Entries for the track of a spot that belongs to no track, and for the position of an object that was not seen."""


class Camera(NamedTuple):
    """The scale of pixels and frames in meters and seconds; empty if the table has units."""

    pixel: float | None = None
    """m"""
    rate: float | None = None
    """frames per second"""
    origin: tuple[float, float] = (0.0, 0.0)
    """the origin of the scene, in the units of the table"""


class Tracks(NamedTuple):
    """The positions of objects over time."""

    names: tuple[str, ...]
    """of the objects, as in the table"""
    times: Array
    """(T,) s, from the first instant"""
    position: Array
    """(T, N, 2) m; NaN where an object was not found"""


class Column(NamedTuple):
    """The index of a column, and the factor that converts its numbers to SI."""

    place: int
    scale: float


def read_tracks(
    path: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    camera: Camera = Camera(),  # noqa: B008  # it cannot change
) -> Tracks:
    """The tracks of a table, or of several tables with different objects. Raises BadInput for faults."""
    files = [Path(path)] if isinstance(path, (str, os.PathLike)) else [Path(one) for one in path]
    spots: list[Spot] = []
    scale = 1.0
    for file in files:
        try:
            rows = in_rows_of_objects(_with_units(_rows(table_text(file, MOST_BYTES))), file.stem)
            columns, body = _columns(rows, camera)
            spots += _apart(_spots(body, columns), {who for who, *_ in spots}, file.stem)
            scale = columns["x"].scale
        except ValueError as fault:
            raise BadInput(f"{file}: {fault}") from None
    try:
        return _gathered(spots, camera.origin, scale)
    except ValueError as fault:
        raise BadInput(f"{', '.join(map(str, files))}: {fault}") from None


def _apart(spots: Sequence[Spot], taken: set[str], name: str) -> list[Spot]:
    """The measurements of another file, with objects renamed if an earlier file has the same names."""
    return [(f"{name}: {who}" if who in taken else who, *rest) for who, *rest in spots]  # type: ignore[misc]


Rows = list[tuple[int, list[str]]]
"""The number and the cells of each line."""
UNIT_ALONE = re.compile(r"\s*[\[(]?\s*([^\s\[\](),;0-9]{1,20})\s*[\])]?\s*")
"""A cell that holds a unit and nothing else."""
NUMERIC = re.compile(r"[+-]?(?:[0-9]+[.,]?[0-9]*|[.,][0-9]+)(?:[eE][+-]?[0-9]+)?")
OF_OBJECT = re.compile(
    r"\s*([xy])(?:[_ .]?([0-9]+)|(?:[_ ]|(?-i:(?<=[xy])(?=[A-Z])))([^\[\](),;]*?))?\s*((?:[\[(][^\[\]()]*[\])])?)\s*",
    re.IGNORECASE,
)
"""A column of one object: x, x1, xA or x_A."""
OBJECT_OF = re.compile(r"\s*([^\[\](),;]*?)[/_ .]([xy])\s*((?:[\[(][^\[\]()]*[\])])?)\s*", re.IGNORECASE)
"""The same with the object before it: A_x, or Trajectory 1/X."""
BEHIND = re.compile(r"[\[(][^\[\]()]*[\])]\s*$")
"""The unit of a column, in brackets or parentheses behind its name."""
NOT_OBJECTS = ("v", "vel", "velocity", "speed", "acc", "acceleration", "component")
"""Words beside x and y that name other quantities."""
WITH_UNIT = re.compile(r"\s*([A-Za-z]+)(?:_|\s*+/\s*+|\s++in\s++)(nm|um|µm|μm|mm|cm|m|px|pixels?|s|ms|sec|min)\s*")
"""A column with its unit behind an underscore, a slash or `in`: x_mm, t/s, Zeit in s."""
BODY_PARTS = "scorer"
"""The first cell of tables of DeepLabCut."""


def in_rows_of_objects(rows: Rows, name: str) -> Rows:
    """The table with one object per line; other tables are returned unchanged.

    The program Tracker writes t, x, y of one object without a header, or with names of objects above the header, or x
    and y of several objects side by side. `name` is used for an object without a name.
    """
    first = [cell.strip() for cell in rows[0][1]]
    if first[0] == BODY_PARTS:
        rows = _one_head(rows)
        first = rows[0][1]
    if len(first) >= 3 and all(NUMERIC.fullmatch(cell) for cell in first[:3]):
        return [(0, ["t", "x", "y", "object"]), *((line, [*row[:3], name]) for line, row in rows)]
    heads, above, body = first, [name] * len(first), rows[1:]
    if not {"x", "t"} & {cell.lower() for cell in first} and len(rows) > 1 and _is_head(rows[1][1]):
        heads, body = [cell.strip() for cell in rows[1][1]], rows[2:]
        above = _named_above(first, len(heads), name)
    words = [_word(cell) for cell in heads]
    time = next((words.index(word) for word in words if word in NAMES["time"]), _place(words, NAMES["frame"]))
    if time is None or any(word in NAMES["object"] for word in words) or words.count("positionx"):
        return rows
    whole = _pairs(heads, above, OF_OBJECT) or _pairs(heads, above, OBJECT_OF)
    if not whole:
        return rows
    units = _units_of_pairs(heads, whole)
    head = [heads[time], *(axis + unit for axis, unit in zip("xy", units, strict=True))]
    lines = [
        (line, [*(row[place] if place < len(row) else "" for place in (time, pair["x"], pair["y"])), who])
        for line, row in body
        for who, pair in whole.items()
    ]
    return [(rows[0][0], [*head, "object"]), *lines]


def _units_of_pairs(heads: Sequence[str], whole: Mapping[str, Mapping[str, int]]) -> tuple[str, str]:
    """The units of x and y in brackets. Raises ValueError where they differ between objects."""
    found = {who: tuple(_unit_behind(heads[pair[axis]]) for axis in "xy") for who, pair in whole.items()}
    (first, (x, y)), *others = found.items()
    for who, units in others:
        if units != (x, y):
            here, there = (" and ".join(echo(heads[whole[each][axis]]) for axis in "xy") for each in (who, first))
            raise ValueError(f"the columns {here} have other units than {there}; expected one unit of length")
    return x, y


def _unit_behind(head: str) -> str:
    """The unit after the name of a column, in brackets, also if it is in parentheses; empty without a unit."""
    match = BEHIND.search(head[:200])
    return f"[{match[0].strip()[1:-1].strip()}]" if match else ""


def _pairs(heads: Sequence[str], above: Sequence[str], form: re.Pattern[str]) -> dict[str, dict[str, int]]:
    """The columns x and y of each object, whose names are in the headers or above them."""
    pairs: dict[str, dict[str, int]] = {}
    for place, cell in enumerate(heads):
        if match := form.fullmatch(cell[:200]):
            axis, who = (match[1], match[2] or match[3]) if form is OF_OBJECT else (match[2], match[1])
            if not who or who.lower() not in NOT_OBJECTS:
                pair = pairs.setdefault(who or above[place], {})
                if pair.setdefault(axis.lower(), place) != place:
                    raise ValueError(f"has the column {echo(cell)} twice; expected one for each object")
    return {who: pair for who, pair in pairs.items() if len(pair) == 2}


def _with_units(rows: Rows) -> Rows:
    """The table with units in brackets in its header, also if they follow an underscore or are in a line below the
    header.
    """
    (line, head), *body = _without_row_of_units(rows)
    return [(line, [_bracketed(cell[:200]) for cell in head]), *body]


def _without_row_of_units(rows: Rows) -> Rows:
    """The table in which the units of a line below the header are moved to the header; names of objects may be above
    the header.
    """
    for place in range(min(2, len(rows) - 1)):
        (line, heads), (_, below) = rows[place : place + 2]
        units = [_alone(cell) for cell in below]
        lengths = [unit for head, unit in zip(heads, units, strict=False) if _word(head)[:1] in ("x", "y")]
        if len(lengths) > 1 and all(map(_is_length, lengths)) and not any(map(NUMERIC.fullmatch, below)):
            joined = [
                f"{head} [{unit}]" if unit and not _unit_behind(head) else head
                for head, unit in zip(heads, [*units, *[""] * len(heads)], strict=False)
            ]
            return [*rows[:place], (line, joined), *rows[place + 2 :]]
    return rows


def _alone(cell: str) -> str:
    match = UNIT_ALONE.fullmatch(cell[:200])
    return match[1] if match else ""


def _is_length(unit: str) -> bool:
    try:
        return unit.lower() in PIXELS or factor(UNITS.get(unit, unit), "m") > 0.0
    except ValueError:
        return False


def _word(head: str) -> str:
    """The name of a column without its unit, as in NAMES."""
    match = HEAD.fullmatch(head[:200])
    return _plain(match[1]) if match else ""


def _bracketed(cell: str) -> str:
    if (match := WITH_UNIT.fullmatch(cell)) and match[1].lower() in (*NAMES["x"], *NAMES["y"], *NAMES["time"]):
        return f"{match[1]} [{match[2]}]"
    return cell


def _one_head(rows: Rows) -> Rows:
    """A table of DeepLabCut, whose lines of names are above its coordinates, with a single header."""
    heads = {row[0].strip().lower(): row for _, row in rows[:5]}
    if not {"bodyparts", "coords"} <= heads.keys():
        return rows
    count = len(heads["coords"])
    above = [heads[key] for key in ("individuals", "bodyparts") if key in heads and len(heads[key]) == count]
    names = [" ".join(cells) for cells in zip(*above, strict=True)]
    head = [f"{coordinate}_{name}" for coordinate, name in zip(heads["coords"], names, strict=True)]
    return [(rows[0][0], ["frame", *head[1:]]), *rows[len(above) + 2 :]]


def _is_head(cells: Sequence[str]) -> bool:
    words = [cell.strip().lower().partition(" ")[0] for cell in cells]
    return "t" in words and "x" in words and "y" in words


def _named_above(cells: Sequence[str], count: int, name: str) -> list[str]:
    """The name above each column, which is in the last nonempty cell."""
    found = []
    for place in range(count):
        name = cells[place] if place < len(cells) and cells[place] else name
        found.append(name)
    return found


def cut(tracks: Tracks, until: float) -> Tracks:
    """The tracks up to a time (s). Raises BadInput if too few instants remain."""
    early = tracks.times <= until
    if early.sum() < LEAST:
        raise BadInput(f"until: before {until:g} s there are {early.sum()} instants; expected {LEAST} or more")
    return tracks._replace(times=tracks.times[early], position=tracks.position[early])


def picked(tracks: Tracks, names: Sequence[str]) -> Tracks:
    """The tracks of these objects. Raises BadInput for an unknown object."""
    for name in names:
        if name not in tracks.names:
            raise BadInput(f"no object {name!r}; {suggestion(name, tracks.names[:MOST_NAMED])}")
    places = [place for place, name in enumerate(tracks.names) if name in names]
    seen = np.isfinite(tracks.position[:, places, 0]).any(axis=1)
    times = tracks.times[seen]
    if len(times) < LEAST:
        raise BadInput(f"{', '.join(names)}: {len(times)} observations; expected {LEAST} or more")
    chosen = tuple(tracks.names[place] for place in places)
    return Tracks(chosen, times - times[0], tracks.position[seen][:, places])


OF_EXCEL = re.compile(r"sep=([;,\t])")
"""A first line by which Excel knows the character between cells."""
BARE = re.compile(r"[+-]?(?:[0-9]+(?:[.,][0-9]+)?|[.,][0-9]+)(?:[eE][+-]?[0-9]+)?")


def _mark(first: str) -> str:
    """The character between the cells of a table, from its first line; a blank for any number of blanks."""
    for mark in (";", "\t", " "):  # numbers may have decimal commas
        cells = first.split(None if mark == " " else mark)
        divided = mark == " " and any(cell.startswith(",") for cell in cells)  # `0 ,1 ,2`
        if len(cells) > 2 and not divided and all(BARE.fullmatch(cell.strip()) for cell in cells):
            return mark
    mark = max(";\t,", key=first.count)
    return mark if first.count(mark) else " "


def _rows(text: str) -> list[tuple[int, list[str]]]:
    """The number and the cells of each nonempty line."""
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    of_excel = OF_EXCEL.fullmatch(lines[0].strip(" ")) if lines else None
    mark = of_excel[1] if of_excel else _mark(lines[0] if lines else "")
    if of_excel:
        text = text.replace(lines[0], "#", 1)
    if mark == " ":
        text = "\n".join("\t".join(line.split()) for line in text.splitlines())
        mark = "\t"
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=mark, strict=True)
    try:
        found = [(reader.line_num, row) for row in reader if any(map(str.strip, row)) and not row[0].startswith("#")]
    except csv.Error as error:
        raise ValueError(f"line {reader.line_num}: {error}") from None
    if not found:
        raise ValueError("is empty; expected a table with the columns x, y, t and id")
    return found


def _columns(
    rows: list[tuple[int, list[str]]], camera: Camera
) -> tuple[dict[str, Column], list[tuple[int, list[str]]]]:
    """The recognized columns, and the lines below the header."""
    heads = [HEAD.fullmatch(cell[:200]) for cell in rows[0][1]]
    words = [_word(cell) for cell in rows[0][1]]
    places = {kind: _place(words, known) for kind, known in NAMES.items()}
    missing = [kind for kind in ("x", "y", "object") if places[kind] is None]
    missing += ["t or frame"] if places["time"] is None and places["frame"] is None else []
    if missing:
        raise ValueError(
            f"missing column {', '.join(missing)} among {', '.join(map(echo, rows[0][1][:12]))}; expected x, y, t and "
            "id, or a table of trackpy, TrackMate, MTrackJ or Tracker"
        )
    body = rows[1:]
    units = [(match[2] or "") if match else "" for match in heads]
    if "POSITION_X" in rows[0][1]:
        body, units = _trackmate(body, units)
    found = {kind: place for kind, place in places.items() if place is not None}
    _require_single(words, rows, found.values())
    _refuse_thousands(body, places)
    usual = "" if words[found["x"]] == "positionx" else "m"  # for TrackMate, see the last header line
    if "time" in found and not _unit(units, found["time"]) and camera.rate is not None:
        _require_counted(body, found["time"])
    return _scaled(found, units, camera, usual), body


def _require_counted(body: Rows, place: int) -> None:
    """Raise ValueError if a frame rate is given and the times are not frame numbers."""
    for line, row in body:
        cell = row[place].strip() if place < len(row) else ""
        if NUMERIC.fullmatch(cell) and float(DECIMAL_COMMA.sub(r"\1.\2", cell)) % 1.0:
            raise ValueError(
                f"line {line}: the time {cell} is no number of frames; omit --rate if times are in seconds, or "
                "write their unit into the head, as in 't [ms]'"
            )


def _require_single(words: Sequence[str], rows: Rows, places: Iterable[int]) -> None:
    """Raise ValueError if another column has the same name as a used one, but other cells. Tables of trackpy repeat
    `frame`.
    """
    heads = rows[0][1]
    for place in places:
        alike = [other for other, word in enumerate(words) if word == words[place] and heads[other] == heads[place]]
        if len(alike) < words.count(words[place]) or any(
            row[other] != row[place] for _, row in rows for other in alike if len(row) > max(other, place)
        ):
            raise ValueError(f"has the column {echo(heads[place])} {words.count(words[place])} times; expected one")


def _refuse_thousands(body: Rows, places: Mapping[str, int | None]) -> None:
    """Raise ValueError if commas in a column may be thousands separators: three digits follow each of them, and there
    are numbers without commas, or decimal points. Other commas in times and positions show that all are decimal.
    """
    cells = {
        kind: [(line, row[place].strip()) for line, row in body if place < len(row)]
        for kind in ("x", "y", "time", "frame")
        if (place := places[kind]) is not None
    }
    numbers = [cell for kind in cells if kind != "frame" for _, cell in cells[kind]]
    points = any("." in cell and NUMERIC.fullmatch(cell) for cell in numbers)
    decimal = any(DECIMAL_COMMA.fullmatch(cell) and not THOUSANDS.fullmatch(cell) for cell in numbers)
    for kind, column in cells.items():
        with_comma = [(line, cell) for line, cell in column if "," in cell]
        if not with_comma or not all(THOUSANDS.fullmatch(cell) for _, cell in with_comma):
            continue
        if points or (len(with_comma) < len(column) and (kind == "frame" or not decimal)):
            line, cell = with_comma[0]
            raise ValueError(
                f"line {line}: {echo(cell)} may mean {echo(cell.replace(',', ''))} or "
                f"{echo(cell.replace(',', '.', 1))}; expected numbers without a comma between thousands"
            )


def _place(words: Sequence[str], known: Sequence[str]) -> int | None:
    return next((words.index(name) for name in known if name in words), None)


def _trackmate(body: list[tuple[int, list[str]]], units: list[str]) -> tuple[list[tuple[int, list[str]]], list[str]]:
    """The lines and units of a table, without the three additional header lines of TrackMate: two with names, one with
    units. Each may be missing.
    """
    for _ in range(3):
        if body and not any(re.fullmatch(r"[0-9]+", cell) for cell in body[0][1]):
            given = [HEAD.fullmatch(cell[:200]) for cell in body[0][1]]
            if any(match and match[2] for match in given):
                units = [(match[2] or "") if match else "" for match in given]
            body = body[1:]
    return body, units


def _scaled(places: Mapping[str, int], units: Sequence[str], camera: Camera, usual: str) -> dict[str, Column]:
    """Each column with its factor; lengths without a unit are in the `usual` one. Raises ValueError if a required
    option of the camera is missing.
    """
    counted = "time" not in places
    time = places["frame"] if counted else places["time"]
    seconds = _time_scale("frame" if counted else _unit(units, time), camera)
    found = {"time": Column(time, seconds), "object": Column(places["object"], 0.0)}
    if bool(_unit(units, places["x"])) != bool(_unit(units, places["y"])):
        raise ValueError("one of the columns x and y has a unit and the other has none; expected a unit in both")
    for axis in ("x", "y"):
        unit = _unit(units, places[axis]) or ("pixel" if counted or camera.pixel is not None else usual)
        found[axis] = Column(places[axis], _length_scale(unit, camera))
    return found


def _unit(units: Sequence[str], place: int) -> str:
    word = units[place] if place < len(units) else ""
    return UNITS.get(word, word)


def _time_scale(unit: str, camera: Camera) -> float:
    if unit.lower() in FRAMES or (not unit and camera.rate is not None):
        if camera.rate is None:
            raise ValueError("times are counted in frames; give the frame rate: --rate 25")
        return 1.0 / camera.rate
    return factor(unit, "s") if unit else 1.0


def _length_scale(unit: str, camera: Camera) -> float:
    if not unit and camera.pixel is None:
        raise ValueError("positions have no unit; give it: --pixel '1 um'")
    if unit.lower() in PIXELS:
        if camera.pixel is None:
            raise ValueError("positions are in pixels; give the size of a pixel: --pixel '20 um'")
        return camera.pixel
    return factor(unit, "m")


Spot = tuple[str, float, float, float]
"""The object, time (s) and position (m) of one measurement."""


def _spots(body: Sequence[tuple[int, list[str]]], columns: Mapping[str, Column]) -> list[Spot]:
    """The measurements of all lines that contain an object and a position."""
    found = []
    for number, row in body:
        if len(row) <= max(column.place for column in columns.values()):
            raise ValueError(f"line {number}: {len(row)} cells are fewer than in the head")
        who = row[columns["object"].place].strip()
        cells = {kind: row[columns[kind].place].strip().lower() for kind in ("time", "x", "y")}
        lost = cells["x"] in NO_OBJECT or cells["y"] in NO_OBJECT
        # Text instead of a number is also an error in spots that are lost or without a track: it may be a unit.
        read = [kind for kind, cell in cells.items() if not (lost and cell in NO_OBJECT)]
        values = [_number(number, kind, row, columns[kind]) for kind in read]
        if not lost and who.lower() not in NO_OBJECT:
            when, x, y = values
            found.append((_named(who), when, x, y))
    if not found:
        raise ValueError("has no rows below the header")
    return found


def _named(who: str) -> str:
    """The name of an object; Pandas writes integers as `3.0`."""
    return who[:-2] if re.fullmatch(r"[0-9]+\.0", who) else who


def _number(line: int, kind: str, row: Sequence[str], column: Column) -> float:
    cell = row[column.place].strip()
    try:
        value = float(DECIMAL_COMMA.sub(r"\1.\2", cell)) * column.scale
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ValueError(f"line {line}, {kind}: got {echo(cell)}; expected a number")
    return value


def _gathered(spots: Sequence[Spot], origin: tuple[float, float], scale: float) -> Tracks:
    """The tracks from single measurements."""
    names = sorted({who for who, *_ in spots}, key=lambda name: (len(name), name))
    times, rows = np.unique([when for _, when, _, _ in spots], return_inverse=True)
    if len(times) * len(names) > MOST_PLACES:
        raise ValueError(
            f"{len(names)} objects at {len(times)} instants are more than {MOST_PLACES} places; expected the tracks of "
            "the objects that are fitted"
        )
    position = np.full((len(times), len(names), 2), np.nan)
    column = {name: place for place, name in enumerate(names)}
    for row, (who, when, x, y) in zip(rows, spots, strict=True):
        if not math.isnan(position[row, column[who], 0]):
            raise ValueError(f"object {who} is in two places at t = {when:g} s")
        position[row, column[who]] = x - origin[0] * scale, y - origin[1] * scale
    if len(times) < LEAST:
        raise ValueError(f"there are only {len(times)} instants; motion shows in {LEAST} or more")
    return Tracks(tuple(names), times - times[0], position)


FIRST = 5
"""The number of instants for the estimate of the initial velocity."""


def first_frame(scene: Scene) -> Frame:
    """The frame of the scene at time 0."""
    frame = next(simulate(scene))
    if frame.arrays["position"].shape[1] != 2:
        raise BadInput("tracks are 2D; the particles of the scene move in 3D")
    return frame


def matched(tracks: Tracks, frame: Frame, *, centered: bool) -> Tracks:
    """The tracks in the order of the particles of the scene; the track that starts nearest is assigned to each
    particle.

    With `centered`, a common displacement of all tracks is ignored. Raises BadInput if the numbers differ.
    """
    there = frame.arrays["position"]
    if len(there) != len(tracks.names):
        hint = "; name those that count (--only), and join what an object left that was lost and found again"
        raise BadInput(
            f"there are {len(tracks.names)} tracks and {len(there)} particles in the scene; expected the same number"
            + hint * (len(tracks.names) > len(there))
        )
    seen = first_seen(tracks)
    if centered:
        there, seen = there - there.mean(axis=0), seen - seen.mean(axis=0)
    apart = np.linalg.norm(there[:, None] - seen[None], axis=2)
    order = linear_sum_assignment(apart**2)[1]
    return Tracks(tuple(tracks.names[place] for place in order), tracks.times, tracks.position[:, order])


def first_seen(tracks: Tracks) -> Array:
    """The first measured position of each object (N, 2) (m)."""
    seen = np.isfinite(tracks.position[:, :, 0])
    return np.array([tracks.position[np.argmax(seen[:, n]), n] for n in range(len(tracks.names))])


def first_speeds(tracks: Tracks) -> Array:
    """The initial velocity of each object (N, 2) (m/s): the slopes of straight lines through its first positions."""
    return np.array([_slope(tracks.times, tracks.position[:, n]) for n in range(len(tracks.names))])


def _slope(times: Array, position: Array) -> Array:
    seen = np.flatnonzero(np.isfinite(position[:, 0]))[:FIRST]
    if len(seen) < 2:
        return np.zeros(2)
    return np.asarray(np.polyfit(times[seen], position[seen], 1)[0])


def start_at(plain: dict[str, Any], position: Array, velocity: Array | None) -> dict[str, Any]:
    """Set initial positions and velocities in a scene's plain data. Changes and returns the data."""
    require_starts(plain, moving=velocity is not None)
    STARTED[plain["model"]](plain, position, velocity)
    return plain


def require_starts(plain: Mapping[str, Any], *, moving: bool) -> None:
    """Raise BadInput if the initial state of the scene's model cannot be fitted."""
    model = plain["model"]
    if model not in STARTED:
        raise BadInput(f"where particles of the model {model} start is the scene's to say: --start scene")
    if moving and model == "soft":
        raise BadInput("soft spheres have no inertia, and so no velocity to start with: --start positions")
    if moving and any(species["count"] > 1 for species in plain.get("particles", ())):
        raise BadInput("particles of a kind start with one velocity; write [[particles]] for each or --start positions")


def _floats_start(plain: dict[str, Any], position: Array, velocity: Array | None) -> None:
    places = iter(range(len(position)))
    for species in plain["particles"]:
        mine = [next(places) for _ in range(species["count"])]
        species |= {"placement": "random", "spacing": None, "ring_radius": None, "center": None}
        species["positions"] = position[mine].tolist()
        if velocity is not None:
            species["velocities"] = velocity[mine].tolist()
    for row in plain["rows"]:
        place = next(places)
        row |= dict(zip("xy", position[place].tolist(), strict=True))
        if velocity is not None:
            row |= dict(zip(("vx", "vy"), velocity[place].tolist(), strict=True))


def _tracers_start(plain: dict[str, Any], position: Array, velocity: Array | None) -> None:
    places = iter(range(len(position)))
    for species in plain["particles"]:
        mine = [next(places) for _ in range(species["count"])]
        species |= {"positions": position[mine].tolist(), "low": None, "high": None}
        if velocity is not None:
            species["velocity"] = velocity[mine[0]].tolist()


def _spheres_start(plain: dict[str, Any], position: Array, velocity: Array | None) -> None:
    places = iter(range(len(position)))
    for species in plain["particles"]:
        mine = [next(places) for _ in range(species["count"] or len(species["positions"]))]
        species |= {"positions": position[mine].tolist(), "count": None}


STARTED = {"floating": _floats_start, "tracers": _tracers_start, "soft": _spheres_start}
"""Functions that set the initial positions, by model."""
KINDS = ("particles", "rows")
"""The keys of tables of particles in scenes."""


def keeps_kinds(plain: Mapping[str, Any]) -> bool:
    """Whether all particles of the scene are equal."""
    return sum(len(plain.get(kinds, ())) for kinds in KINDS) == 1


def require_deterministic(plain: Mapping[str, Any]) -> None:
    """Raise BadInput if the motion is stochastic, so that a simulation cannot reproduce the tracks."""
    if plain.get("hydrodynamics", {}).get("brownian"):
        raise BadInput("the scene has Brownian motion, which is random; a fit needs a scene without it")
