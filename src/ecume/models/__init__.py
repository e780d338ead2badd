"""The models there are. Reading this table compiles nothing; a model is imported when it is first looked up."""

from __future__ import annotations

from collections.abc import Iterator, MutableMapping

from ecume.models.model import Model


class _Models(MutableMapping[str, Model]):
    """A table whose own rows are imported late: a scene is checked without Numba."""

    def __init__(self) -> None:
        self._known: dict[str, Model | None] = {"floating": None, "soft": None, "sph": None, "tracers": None}

    def __getitem__(self, name: str) -> Model:
        found = self._known[name]
        if found is None:
            found = self._known[name] = _imported(name)
        return found

    def __setitem__(self, name: str, model: Model) -> None:
        self._known[name] = model

    def __delitem__(self, name: str) -> None:
        del self._known[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._known)

    def __len__(self) -> int:
        return len(self._known)


def _imported(name: str) -> Model:
    if name == "floating":
        from ecume.models.floating import FLOATING

        return FLOATING
    if name == "soft":
        from ecume.models.soft import SOFT

        return SOFT
    if name == "sph":
        from ecume.models.sph import SPH

        return SPH
    if name == "tracers":
        from ecume.models.tracers import TRACERS

        return TRACERS
    raise KeyError(name)


MODELS = _Models()
"""Every model by the name that scenes use."""
