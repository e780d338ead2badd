"""The text of scene files: values that differ from the defaults, in the units of the templates.

>>> from ecume.scenes.schema import from_plain
>>> print(to_toml(from_plain({"model": "tracers", "duration": 2, "frame_every": 0.1, "tank": {"high": [0.01, 0.02]},
...     "particles": [{"radius": 5e-6, "density": 2500}]})))
model = "tracers"
duration = "2 s"
frame_every = "100 ms"
<BLANKLINE>
[[particles]]
radius = "5 um"
density = 2500.0
<BLANKLINE>
[tank]
high = ["1 cm", "2 cm"]
<BLANKLINE>

The file also converts Python objects, such as numbers with units, arrays and tables, to scenes, with the messages of
scene files.

>>> from ecume.units import mm
>>> made = scene("floating", duration="1 s", frame_every="0.1 s",
...     particles=[{"radius": 2 * mm, "count": 3, "density": 600, "contact_angle": (70, "deg")}])
>>> made.particles[0].radius, changed(made, {"particles[0].radius": "3 mm"}).particles[0].radius
(0.002, 0.003)
"""

from __future__ import annotations

import copy
import dataclasses
import json
import math
import os
from collections.abc import Iterator, Mapping, Sequence
from decimal import Decimal
from pathlib import Path as File
from typing import Any, Literal, NamedTuple, overload

import numpy as np

from ecume.errors import BadInput, Fault, SceneError
from ecume.scenes.common import Common, Given
from ecume.scenes.faults import Path, as_faults, read_path, value_at
from ecume.scenes.floating import FloatingScene
from ecume.scenes.load import assembled
from ecume.scenes.overrides import KEY, put
from ecume.scenes.quantities import COLORS
from ecume.scenes.schema import Scene, below, from_plain, item_unit, to_plain
from ecume.scenes.soft import SoftScene
from ecume.scenes.sph import SphScene
from ecume.scenes.tracers import TracersScene
from ecume.units import Quantity, Unit, quantity_of

MOST_BYTES = 2**20
"""The largest size of a scene file."""
MOST_CANDIDATES = 100
"""The largest number of values for which it is tested whether reading fills them in."""
LARGE = 20_000
"""Characters of JSON of a scene from which values that reading would fill in are written nevertheless."""
LONGEST_LINE = 110
MOST_WITH_UNITS = 12
"""The largest number of numbers in a list with units; longer lists hold plain numbers in SI units."""
LONGEST_NUMBER = 20
LARGEST_WITH_UNIT = 1e100
"""The largest number that is written with a unit; larger ones could overflow in another unit."""


class Scale(NamedTuple):
    """A unit, and the power of ten by which it differs from the SI unit."""

    unit: str
    power: int


SCALES = {
    "m": (Scale("m", 0), Scale("cm", -2), Scale("mm", -3), Scale("um", -6), Scale("nm", -9)),
    "s": (Scale("s", 0), Scale("ms", -3), Scale("us", -6)),
    "m/s": (Scale("m/s", 0), Scale("cm/s", -2), Scale("mm/s", -3)),
    "Pa*s": (Scale("Pa*s", 0), Scale("mPa*s", -3)),
    "N/m": (Scale("N/m", 0), Scale("mN/m", -3)),
    "N": (Scale("N", 0), Scale("mN", -3), Scale("uN", -6), Scale("nN", -9)),
    "Pa": (Scale("MPa", 6), Scale("kPa", 3), Scale("Pa", 0)),
    "1/s": (Scale("s^-1", 0),),
}
"""The units in which numbers are written, the largest first."""
COLOR_NAMES = {value: name for name, value in COLORS.items()}
PLAIN = {"1", "kg/m^3"}
"""Units that are omitted."""


def write_scene(scene: Scene, path: str | os.PathLike[str], *, force: bool = False) -> File:
    """Write a scene file, from which `load_scene` reads an equal scene. With `force` an existing file is replaced."""
    from ecume.trajectories.records import write_whole

    file = File(path)
    if file.exists() and not force:
        raise BadInput(f"{file} exists already; name another file, or pass force=True")
    text = to_toml(scene)
    if len(text.encode()) > MOST_BYTES:
        size = f"{len(text.encode()) / 2**20:.3g} MiB, more than the {MOST_BYTES / 2**20:g} MiB of a scene file"
        raise BadInput(f"{file} would have {size}; keep the positions in a table and name it with particles_from")
    file.parent.mkdir(parents=True, exist_ok=True)
    write_whole(file, text)
    return file


def to_toml(scene: Scene, *, defaults: bool = False) -> str:
    """The scene as the text of a scene file, with `defaults` also the values that a file may omit."""
    plain = _without_gaps(to_plain(scene)) if defaults else essential(scene)
    return _document(_with_units(plain, type(scene), ""))


def _without_gaps(value: Any) -> Any:
    """Plain data without None and empty lists, which TOML does not have or need."""
    if isinstance(value, dict):
        return {key: _without_gaps(item) for key, item in value.items() if item is not None and item != []}
    return [_without_gaps(item) for item in value] if isinstance(value, list) else value


def essential(scene: Scene) -> dict[str, Any]:
    """The plain data of a scene without defaults and without values that reading fills in."""
    plain: dict[str, Any] = {"model": scene.model, **_given(scene)}
    whole = _bits(to_plain(scene))
    if len(whole) > LARGE:
        return plain
    for path in list(_removable(plain, scene))[:MOST_CANDIDATES]:
        fewer = copy.deepcopy(plain)
        table = value_at(fewer, path[:-1], None)
        if not isinstance(table, dict) or path[-1] not in table:
            continue  # removed together with its table
        del table[path[-1]]
        try:
            same = _bits(to_plain(from_plain(fewer))) == whole
        except SceneError:
            continue
        if same:
            plain = fewer
    return plain


def _bits(plain: object) -> str:
    """A text that is equal only for equal bits: minus zero differs from zero."""
    return json.dumps(plain)


def _given(piece: Any) -> dict[str, Any]:
    """The values of a piece that differ from its defaults."""
    found: dict[str, Any] = {}
    for field in dataclasses.fields(piece):
        value = _plain(getattr(piece, field.name))
        default = None if field.default is dataclasses.MISSING else _plain(field.default)
        if value is not None and (field.default is dataclasses.MISSING or _bits(value) != _bits(default)):
            found[field.name] = value
    return found


def _plain(value: Any) -> Any:
    if dataclasses.is_dataclass(value):
        return _given(value)
    return [_plain(item) for item in value] if isinstance(value, tuple) else value


def _removable(plain: Any, piece: Any, path: Path = ()) -> Iterator[Path]:
    """The paths of values that a file may omit."""
    if isinstance(plain, list):
        for index, item in enumerate(plain):
            yield from _removable(item, piece[index], (*path, index))
    if not isinstance(plain, dict):
        return
    optional = {field.name for field in dataclasses.fields(piece) if field.default is not dataclasses.MISSING}
    for key, value in plain.items():
        if key in optional and (*path, key) != ("model",):
            yield (*path, key)
        yield from _removable(value, getattr(piece, key), (*path, key))


def _with_units(value: Any, kind: Any, unit: str) -> Any:
    """Plain data in which numbers are text with units; `kind` is their annotation, `unit` that of the surrounding
    list.
    """
    if isinstance(value, Mapping):
        kinds = {key: below(kind, key) for key in value}
        spelled_out = {key: _with_units(item, kinds[key], item_unit(kinds[key])) for key, item in value.items()}
        return {key: COLOR_NAMES.get(item, item) if key == "color" else item for key, item in spelled_out.items()}
    if isinstance(value, list):
        if value and _count(value) > MOST_WITH_UNITS and not isinstance(value[0], Mapping):
            return value
        inner = below(kind, 0)
        return [_with_units(item, inner, item_unit(inner) or unit) for item in value]
    return spelled(value, unit) if isinstance(value, float) else value


def _count(value: Any) -> int:
    """The number of numbers in nested lists."""
    return sum(map(_count, value)) if isinstance(value, list) else 1


def spelled(value: float, unit: str) -> float | str:
    """A number in SI as text with a unit of suitable size, if that text gives the same bits; otherwise the number.

    >>> spelled(0.0018, "m"), spelled(1.2217304763960306, "rad"), spelled(293.15, "K"), spelled(1030.0, "kg/m^3")
    ('1.8 mm', '70 deg', '20 degC', 1030.0)
    """
    if unit in PLAIN or not unit or abs(value) > LARGEST_WITH_UNIT:
        return value
    if unit == "rad":
        degrees = math.degrees(value)
        texts = [f"{degrees:.12g} deg"] if math.isfinite(degrees) else []
        texts.append(f"{value!r} rad")
    elif unit == "K":
        texts = [f"{_digits(Decimal(repr(value)) - Decimal('273.15'))} degC", f"{value!r} K"]
    else:
        texts = [_scaled(value, unit)]
    return next((text for text in texts if _same(text, value, unit)), value)


def _same(text: str, value: float, unit: str) -> bool:
    """Whether a text is short and gives the same bits."""
    return len(text.partition(" ")[0]) <= LONGEST_NUMBER and repr(Unit(unit).number(text)) == repr(value)


def _scaled(value: float, unit: str) -> str:
    """A number in the largest unit in which it is at least one."""
    decimal = Decimal(repr(value))
    scales = SCALES.get(unit, (Scale(unit, 0),))
    fitting = [scale for scale in scales if abs(decimal).scaleb(-scale.power) >= 1] if value else scales[:1]
    scale = fitting[0] if fitting else scales[-1]
    return f"{_digits(decimal.scaleb(-scale.power))} {scale.unit}"


def _digits(decimal: Decimal) -> str:
    """A decimal number without an exponent and without zeros at its end."""
    text = f"{decimal:f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def _document(table: dict[str, Any]) -> str:
    """The text of the tables of a scene, each below its heading."""
    lines = list(_lines(table, ""))
    return "\n".join(lines).strip("\n") + "\n"


def _lines(table: dict[str, Any], path: str) -> Iterator[str]:
    """The lines of a table: keys first, then the tables in it."""
    sections = []
    for key, value in table.items():
        if _is_section(value, path):
            sections.append((key, value))
        else:
            yield _line(key, value)
    for key, value in sections:
        name = f"{path}.{key}" if path else key
        for one in value if isinstance(value, list) else [value]:
            yield from ("", f"[[{name}]]" if isinstance(value, list) else f"[{name}]")
            yield from _lines(one, name)


def _is_section(value: Any, path: str) -> bool:
    """Whether a value gets a heading: tables at the top of a scene, and long ones elsewhere."""
    if not (isinstance(value, dict) or (isinstance(value, list) and value and isinstance(value[0], dict))):
        return False
    return not path or len(_inline(value)) > LONGEST_LINE


def _line(key: str, value: Any) -> str:
    """The text `key = value`; a long list has several lines."""
    line = f"{key} = {_inline(value)}"
    if len(line) <= LONGEST_LINE or not isinstance(value, list):
        return line
    lines = [""]
    for item in map(_inline, value):
        if len(lines[-1]) + len(item) > LONGEST_LINE - 6:
            lines.append("")
        lines[-1] += f" {item}," if lines[-1] else f"{item},"
    return "\n".join([f"{key} = [", *(f"    {each}" for each in lines), "]"])


def _inline(value: Any) -> str:
    """A value on one line."""
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{key} = {_inline(item)}' for key, item in value.items())} }}"
    if isinstance(value, list):
        return f"[{', '.join(map(_inline, value))}]"
    if isinstance(value, str):
        import tomli_w

        return tomli_w.dumps({"key": value}).removeprefix("key = ").rstrip("\n")
    return str(value).lower() if isinstance(value, bool) else repr(value)


@overload
def scene(model: Literal["floating"], *, folder: str | os.PathLike[str] = ..., **keys: Given) -> FloatingScene: ...


@overload
def scene(model: Literal["sph"], *, folder: str | os.PathLike[str] = ..., **keys: Given) -> SphScene: ...


@overload
def scene(model: Literal["soft"], *, folder: str | os.PathLike[str] = ..., **keys: Given) -> SoftScene: ...


@overload
def scene(model: Literal["tracers"], *, folder: str | os.PathLike[str] = ..., **keys: Given) -> TracersScene: ...


@overload
def scene(model: str, *, folder: str | os.PathLike[str] = ..., **keys: Given) -> Scene: ...


def scene(model: str, *, folder: str | os.PathLike[str] = ".", **keys: Given) -> Scene:
    """The scene with these keys, which are those of a scene file; tables are dictionaries or dataclasses.

    A number with a unit is text (`"2 mm"`), a pair (`(2, "mm")`), a quantity (`2 * mm` with `ecume.units.mm`) or a
    quantity of Pint; a plain number is in SI units. NumPy arrays may replace lists. Paths of files in the scene are
    relative to `folder`. Raises SceneError with all faults at once.
    """
    made, faults = assembled({"model": model, **{key: plain_of(value) for key, value in keys.items()}}, File(folder))
    if made is None or faults:
        raise SceneError(as_faults(faults))
    return made


def changed(of: Common, changes: Mapping[str, Given]) -> Scene:
    """A scene with other values at some paths, such as `dish.radius`. Raises SceneError with all faults at once.

    Values that are not given in the scene, such as the laws of its `theory`, follow from the new ones.
    """
    plain, faults = essential(of), []  # type: ignore[arg-type]  # every scene is one of `Scene`
    for name, value in changes.items():
        try:
            if KEY.fullmatch(name) is None:
                raise ValueError("expected the path of a key, such as dish.radius or particles[0].count")
            put(plain, read_path(name), plain_of(value))
        except ValueError as fault:
            faults.append(Fault(name, str(fault)))
    if faults:
        raise SceneError(faults)
    return from_plain(plain)


def plain_of(value: Any) -> Any:
    """A Python object as plain data of scenes; quantities and dataclasses are unchanged."""
    if quantity_of(value) is not None:
        return quantity_of(value)
    if isinstance(value, Mapping):
        return {str(key): plain_of(item) for key, item in value.items()}
    if isinstance(value, (np.ndarray, np.generic)):
        return plain_of(value.tolist())
    if isinstance(value, tuple) and len(value) == 2 and isinstance(value[1], str) and _is_list(value[0]):
        return plain_of(value[0]) * Quantity(1.0, value[1])
    if _is_list(number := getattr(value, "magnitude", None)):
        return plain_of(number) * Quantity(1.0, str(value.units).replace(" ", ""))
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    return [plain_of(item) for item in value] if _is_list(value) else value


def _is_list(value: object) -> bool:
    return isinstance(value, np.ndarray) or (isinstance(value, Sequence) and not isinstance(value, (str, bytes)))
