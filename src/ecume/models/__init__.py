"""The table of models. Importing it compiles nothing; a model is imported at the first access."""

from __future__ import annotations

import importlib
from collections.abc import Iterator, Mapping, MutableMapping
from typing import Any

from ecume.models.model import Model

HOMES = {
    "floating": "ecume.models.floating:FLOATING",
    "soft": "ecume.models.soft:SOFT",
    "sph": "ecume.models.sph:SPH",
    "tracers": "ecume.models.tracers:TRACERS",
}
"""The package of each model, and the name of its record there."""


class _Models(MutableMapping[str, Model]):
    """A table whose rows are imported at the first access, so that scenes are checked without Numba."""

    def __init__(self) -> None:
        self._known: dict[str, Model | None] = dict.fromkeys(HOMES)

    def __getitem__(self, name: str) -> Model:
        found = self._known[name]
        if found is None:
            home, record = HOMES[name].split(":")
            found = self._known[name] = getattr(importlib.import_module(home), record)
        return found

    def __setitem__(self, name: str, model: Model) -> None:
        self._known[name] = model

    def __delitem__(self, name: str) -> None:
        del self._known[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._known)

    def __len__(self) -> int:
        return len(self._known)


MODELS = _Models()
"""Every model by the name that scenes use."""


class _Scenes(Mapping[str, Any]):
    """The type of the scenes of each model, read from its record."""

    def __getitem__(self, name: str) -> Any:
        return MODELS[name].scene

    def __iter__(self) -> Iterator[str]:
        return iter(MODELS)

    def __len__(self) -> int:
        return len(MODELS)


SCENES_OF_MODELS = _Scenes()
