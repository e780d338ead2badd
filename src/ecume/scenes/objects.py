"""Scenes from Python objects: numbers with units, arrays and tables become a scene, with the messages of scene files.

>>> from ecume.units import mm
>>> made = scene("floating", duration="1 s", frame_every="0.1 s",
...     particles=[{"radius": 2 * mm, "count": 3, "density": 600, "contact_angle": (70, "deg")}])
>>> made.particles[0].radius, changed(made, {"particles[0].radius": "3 mm"}).particles[0].radius
(0.002, 0.003)
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path as File
from typing import Any, Literal, overload

import numpy as np

from ecume.errors import Fault, SceneError
from ecume.scenes.common import Common, Given
from ecume.scenes.faults import as_faults, read_path
from ecume.scenes.floating import FloatingScene
from ecume.scenes.load import KEY, assembled, put
from ecume.scenes.schema import Scene, from_plain
from ecume.scenes.soft import SoftScene
from ecume.scenes.sph import SphScene
from ecume.scenes.tracers import TracersScene
from ecume.scenes.writing import essential
from ecume.units import Quantity, quantity_of


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
    """The scene of these keys, which are those of a scene file; tables are dictionaries or dataclasses.

    A number with a unit is text (`"2 mm"`), a pair (`(2, "mm")`), a quantity (`2 * mm` with `ecume.units.mm`) or a
    quantity of Pint; a plain number is in SI units. Arrays of NumPy may stand for lists. Files that the scene names are
    looked for in `folder`. Raises SceneError with all faults at once.
    """
    made, faults = assembled({"model": model, **{key: plain_of(value) for key, value in keys.items()}}, File(folder))
    if made is None or faults:
        raise SceneError(as_faults(faults))
    return made


def changed(of: Common, changes: Mapping[str, Given]) -> Scene:
    """A scene with other values at some paths, such as `dish.radius`. Raises SceneError with all faults at once.

    Values that the scene did not state, such as the laws of its `theory`, follow from the new ones.
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
    """A Python object as the plain data that a scene is read from; quantities and dataclasses stay what they are."""
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
