"""The arguments of a compiled function in the memory of a page: see `web/wasm/numba_wasm.py`.

A page calls a function with the address of a block. The block begins with space for the result, followed by the numbers
to which Numba converts the arguments, with eight bytes each: one for a number, and seven or more for an array, one of
which is its address.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ecume.models import MODELS
from ecume.models.floating.parameters import Parameters, State, Workspace
from ecume.scenes.floating import FloatingScene

Named = tuple[str, Any]


def leaves(value: Any, name: str) -> Iterator[Named]:
    """The numbers and arrays in nested tuples, with their names.

    >>> from ecume.engine.walls import no_walls
    >>> [name for name, _ in leaves(no_walls(), "walls")]
    ['walls.disc_radius', 'walls.normal', 'walls.offset']
    """
    if isinstance(value, tuple):
        names = getattr(value, "_fields", range(len(value)))
        for each, item in zip(names, value, strict=True):
            yield from leaves(item, f"{name}.{each}")
    else:
        yield name, value


def kind_of(value: Any) -> str:
    """The type of a number or an array: `float64`, `int64` or `bool`; for an array with its number of axes. Records
    are `record`.

    >>> kind_of(np.zeros((2, 3))), kind_of(1), kind_of(True)
    ('float64 2', 'int64', 'bool')
    """
    if isinstance(value, np.ndarray):
        return f"record {value.ndim}" if value.dtype.names else f"{value.dtype} {value.ndim}"
    return {bool: "bool", int: "int64"}.get(type(value), "float64")


def slots(arguments: dict[str, Any]) -> list[list[Any]]:
    """Name, type, shape and value of each number and array, in the order of the arguments. Numbers have no shape, and
    arrays of zeros no value; the value of an array in the memory of a larger one is the name of the larger one.

    >>> both = np.ones((2, 3))
    >>> [value for *_, value in slots({"row": both[0], "both": both})]
    ['both', [1.0, 1.0, 1.0, 1.0, 1.0, 1.0]]
    """
    found = []
    named = [leaf for key, each in arguments.items() for leaf in leaves(each, key)]
    holders = holders_of([(name, value) for name, value in named if isinstance(value, np.ndarray) and value.size])
    for name, value in named:
        if isinstance(value, np.ndarray):
            found.append([name, kind_of(value), _shape_of(value), holders.get(name, _numbers_in(value))])
        else:
            found.append([name, kind_of(value), None, value.item() if isinstance(value, np.generic) else value])
    return found


def _shape_of(array: Any) -> list[int]:
    """The sizes of an array; a record counts as an axis of words of four bytes."""
    return [*array.shape, array.dtype.itemsize // 4] if array.dtype.names else list(array.shape)


def _numbers_in(array: Any) -> list[Any] | None:
    """The numbers of an array; of records, whole numbers of four bytes with the same bits."""
    if array.dtype.names:
        return list(array.view(np.uint32).ravel().tolist())
    return array.ravel().tolist() if array.any() else None


def holders_of(arrays: list[Named]) -> dict[str, str]:
    """The arrays in the memory of larger ones, with the names of the larger ones, so that both have the same data.
    Raises ValueError for an array that does not begin where the larger one does.
    """
    found: dict[str, str] = {}
    holder, begin, end = "", 0, 0
    for name, array in sorted(arrays, key=lambda one: (one[1].ctypes.data, -one[1].nbytes)):
        at = array.ctypes.data
        if at >= end:
            holder, begin, end = name, at, at + array.nbytes
        elif at == begin:
            found[name] = holder
        else:
            raise ValueError(f"{name} begins within {holder}; a page has room only for arrays that begin with it")
    return found


def arguments_of(parameters: Parameters, state: State, workspace: Workspace) -> dict[str, Any]:
    """The arguments of a bowl's `integrate`, by their names."""
    return {
        "parts": parameters.parts,
        "scratches": workspace.scratch,
        "parameters": parameters._replace(parts=()),
        "state": state,
        "workspace": workspace._replace(scratch=()),
        "steps": 0,
    }


def bowl_arguments(scene: FloatingScene) -> dict[str, Any]:
    """The arguments of a bowl at the start of a scene, by their names."""
    model = MODELS["floating"]
    parameters = model.parameters(scene)
    state = model.start(scene, parameters)
    return arguments_of(parameters, state, model.workspace(parameters, state, 1.0))


def types_of(arguments: dict[str, Any]) -> str:
    """All types, with the parts by their names: code that is compiled for other types cannot be called with these
    arguments.

    >>> types_of({"steps": 0})
    'steps int64'
    """
    parts = [type(value).__name__ for _, value in _tuples(arguments)]
    return "; ".join([*parts, *(f"{name} {kind}" for name, kind, *_ in slots(arguments))])


def _tuples(arguments: dict[str, Any]) -> Iterator[Named]:
    pending = list(arguments.items())
    while pending:
        name, value = pending.pop()
        if isinstance(value, tuple):
            yield name, value
            pending += [(name, each) for each in value]
