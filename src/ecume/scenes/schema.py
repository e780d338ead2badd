"""The table of scenes, the conversion between scenes and plain data, and the units that the schema knows.

>>> scene = from_plain({"model": "floating", "duration": "1 s", "frame_every": "0.1 s",
...     "particles": [{"radius": "1 mm", "density": 600, "contact_angle": "70 deg"}]})
>>> from_plain(to_plain(scene)) == scene
True
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import typing
from collections.abc import Iterator, Mapping, MutableMapping, Sequence
from functools import cache
from typing import Any, cast

from pydantic import TypeAdapter, ValidationError

from ecume import _hooks
from ecume.errors import SceneError
from ecume.scenes.common import Common
from ecume.scenes.faults import (
    Path,
    as_faults,
    echo,
    faults_of,
    suggestion,
)
from ecume.scenes.floating import FloatingScene
from ecume.scenes.quantities import Measured
from ecume.scenes.soft import SoftScene
from ecume.scenes.sph import SphScene
from ecume.scenes.tracers import TracersScene
from ecume.units import Unit

Scene = FloatingScene | SoftScene | SphScene | TracersScene
"""Any scene."""


class _Scenes(MutableMapping[str, type[Common]]):
    """A table with the rows of this file, for which no model is imported, and those that other models add."""

    def __init__(self, rows: Mapping[str, type[Common]]) -> None:
        self._rows = dict(rows)

    def __getitem__(self, name: str) -> type[Common]:
        return self._rows[name] if name in self._rows else _hooks.scenes_of_models(None)[name]

    def __setitem__(self, name: str, kind: type[Common]) -> None:
        self._rows[name] = kind

    def __delitem__(self, name: str) -> None:
        del self._rows[name]

    def __iter__(self) -> Iterator[str]:
        return iter(dict.fromkeys([*self._rows, *_hooks.scenes_of_models(None)]))

    def __len__(self) -> int:
        return len(list(iter(self)))


SCENES = _Scenes({"floating": FloatingScene, "soft": SoftScene, "sph": SphScene, "tracers": TracersScene})
"""The type of the scenes of each model, by its name."""


def from_plain(plain: Mapping[str, Any]) -> Scene:
    """The scene of plain data (tables, lists, text, numbers). Raises SceneError with all faults at once."""
    scene, found = examined(plain)
    if found:
        raise SceneError(as_faults(found))
    return cast(Scene, scene)


def examined(plain: Mapping[str, Any], also: Sequence[str] = ()) -> tuple[Scene | None, list[tuple[Path, str]]]:
    """The scene, or all its faults; `also` are additional keys that its file may have."""
    model = plain.get("model")
    kind = SCENES.get(model) if isinstance(model, str) else None
    if kind is None:
        return None, [(("model",), _no_model(model))]
    try:
        return cast(Scene, _reader(str(model)).validate_python(dict(plain))), []
    except ValidationError as error:
        return None, faults_of(error, kind, plain, also)


def _no_model(model: object) -> str:
    choices = ", ".join(f'"{name}"' for name in SCENES)
    if model is None:
        return f"is missing; expected one of {choices}"
    return f"got {echo(model)}; expected one of {choices}; {suggestion(str(model), SCENES)}"


@cache
def _reader(model: str) -> TypeAdapter[Common]:
    return TypeAdapter(SCENES[model])


def to_plain(scene: Scene) -> dict[str, Any]:
    """Tables, lists, text and numbers with all defaults filled in: valid JSON, which `from_plain` reads."""
    return cast(dict[str, Any], _listed(dataclasses.asdict(scene)))


def _listed(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _listed(item) for key, item in value.items()}
    return [_listed(item) for item in value] if isinstance(value, (list, tuple)) else value


def scene_hash(scene: Scene) -> str:
    """A hash of 64 hexadecimal digits, which is equal only for equal scenes."""
    return hashlib.sha256(json.dumps(to_plain(scene), sort_keys=True).encode()).hexdigest()


ANGLE = "contact_angle"


def unit_of(plain: Mapping[str, Any], path: Path) -> str:
    """The SI unit of a key by the schema."""
    kind, unit = SCENES[plain["model"]], ""
    for key in path:
        kind = below(kind, key)
        unit = item_unit(kind) or (unit if isinstance(key, int) else "")
    return unit or "1"


def item_unit(kind: Any) -> str:
    """The SI unit in an annotation; empty without one."""
    return next((mark.symbol for mark in _marks(kind) if isinstance(mark, (Unit, Measured))), "")


def below(kind: Any, key: str | int) -> Any:
    """The annotation of a key, or of the items of a list, in an annotated piece."""
    if isinstance(key, int):
        return next((inner for part in _parts(kind) if (inner := _items(part)) is not None), None)
    piece = next((part for part in _parts(kind) if dataclasses.is_dataclass(part)), None)
    return _hints(piece).get(key) if isinstance(piece, type) else None


def _items(kind: Any) -> Any:
    """The annotation of the items of a tuple; None for others."""
    return typing.get_args(kind)[0] if typing.get_origin(kind) is tuple else None


def _parts(kind: Any) -> Iterator[Any]:
    """An annotation and, for a union, its members."""
    yield kind
    if typing.get_origin(kind) is not tuple:
        for part in typing.get_args(kind):
            yield from _parts(part)


@cache
def _hints(piece: type) -> dict[str, Any]:
    return typing.get_type_hints(piece, include_extras=True)


def _marks(kind: Any) -> Iterator[Any]:
    """The metadata of an annotation, including nested ones."""
    for part in typing.get_args(kind):
        yield part
        yield from _marks(part)
