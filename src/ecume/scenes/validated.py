"""The dataclasses of scenes: validated by pydantic, with the messages of scene files when they are made in Python."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable
from typing import TypeVar, cast, dataclass_transform

import pydantic.dataclasses
from pydantic import ConfigDict, Field, ValidationError

from ecume.errors import SceneError
from ecume.scenes.faults import as_faults, faults_of

Piece = TypeVar("Piece")
LONGEST_TUPLE = 4
"""Items of a tuple that a `repr` shows."""


@dataclass_transform(field_specifiers=(dataclasses.field, Field))
def dataclass(*, frozen: bool, kw_only: bool, config: ConfigDict) -> Callable[[type[Piece]], type[Piece]]:
    """A dataclass of pydantic whose construction raises SceneError with all faults, and whose `repr` is short."""

    def made(kind: type[Piece]) -> type[Piece]:
        decorate = pydantic.dataclasses.dataclass(frozen=frozen, kw_only=kw_only, repr=False, config=config)
        piece = cast(type[Piece], decorate(kind))
        validate = piece.__init__

        @functools.wraps(validate)
        def construct(self: Piece, **values: object) -> None:
            try:
                validate(self, **values)
            except ValidationError as error:
                name = type(self).__name__
                raise SceneError(as_faults(faults_of(error, type(self), values)), name) from None

        setattr(piece, "__init__", construct)  # noqa: B010  # a plain assignment is refused by type checkers
        if piece.__repr__ is object.__repr__:
            setattr(piece, "__repr__", _short)  # noqa: B010
        return piece

    return made


def _short(piece: object) -> str:
    """`DishSpec(radius=0.05)`: the values that differ from the defaults, long tuples by their length."""
    fields = dataclasses.fields(piece) if dataclasses.is_dataclass(piece) else ()
    given = [
        (field.name, getattr(piece, field.name)) for field in fields if getattr(piece, field.name) != field.default
    ]
    return f"{type(piece).__name__}({', '.join(f'{name}={_shown(value)}' for name, value in given)})"


def _shown(value: object) -> str:
    if isinstance(value, tuple) and len(value) > LONGEST_TUPLE:
        return f"<{len(value)} items>"
    return f"({', '.join(map(_shown, value))},)" if isinstance(value, tuple) else repr(value)
