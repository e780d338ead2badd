"""What the schema knows of a place in a scene: the unit of the number there."""

from __future__ import annotations

import typing
from collections.abc import Iterator, Mapping
from typing import Any

from ecume.scenes.faults import Path
from ecume.scenes.schema import SCENES
from ecume.units import Unit

ANGLE = "contact_angle"


def unit_of(plain: Mapping[str, Any], path: Path) -> str:
    """The SI unit that the schema knows for a place in a scene."""
    if path[-1] == ANGLE:
        return "rad"
    kind: Any = SCENES[plain["model"]]
    for key in path:
        kind = _below(kind, key)
    return next((mark.symbol for mark in _marks(kind) if isinstance(mark, Unit)), "1")


def _below(kind: Any, key: str | int) -> Any:
    """The annotation one key further down."""
    if isinstance(key, int):
        return next(part for part in typing.get_args(kind) if part is not ...)
    piece = next((part for part in (kind, *typing.get_args(kind)) if hasattr(part, "__dataclass_fields__")), None)
    return typing.get_type_hints(piece, include_extras=True).get(key) if piece is not None else None


def _marks(kind: Any) -> Iterator[Any]:
    """All that annotations say, however deep."""
    for part in typing.get_args(kind):
        yield part
        yield from _marks(part)
