"""The user's own pair laws of a run: what they are called, and whether they are still what they were.

A run directory keeps no code. It keeps names and digests, so that a run goes on with the laws that it was begun with,
or not at all.
"""

from __future__ import annotations

import hashlib
import inspect
from collections.abc import Callable, Sequence
from types import FunctionType
from typing import Any

from ecume.errors import BadInput
from ecume.run.directory import RunDirectory, json_of

Law = Callable[..., float]


def entries(extra_laws: Sequence[Law]) -> list[dict[str, str]]:
    """The entries of these laws in the manifest."""
    return [
        {"name": named(law), "sha256": hashlib.sha256("\n".join(_texts(law, set())).encode()).hexdigest()}
        for law in extra_laws
    ]


def named(law: Law) -> str:
    """The name of a law."""
    return getattr(law, "__name__", None) or repr(law)


def require_same(home: RunDirectory, extra_laws: Sequence[Law]) -> None:
    """Raise BadInput unless these are the laws that the run was begun with, in their order."""
    former, now = json_of(home.manifest).get("extra_laws", []), entries(extra_laws)
    before, given = [law["name"] for law in former], [law["name"] for law in now]
    if before and not given:
        raise BadInput(
            f"{home.path}: was begun with laws of your own, {', '.join(before)}; go on from Python: "
            f'ecume.resume("{home.path}", extra_laws=[{", ".join(before)}])'
        )
    if before != given:
        wanted = ", ".join(before) or "no laws of your own"
        raise BadInput(f"{home.path}: extra_laws: got {', '.join(given)}; the run was begun with {wanted}")
    differing = [one["name"] for one, other in zip(former, now, strict=True) if one != other]
    if differing:
        raise BadInput(
            f"{home.path}: extra_laws: {', '.join(differing)}: not what it was when the run began; bring back the "
            "former text, or run the scene again"
        )


def _texts(law: Any, seen: set[int]) -> list[str]:
    """The text of a law, of the numbers from outside that it uses, and of the functions that it calls."""
    function = getattr(law, "py_func", law)
    if not isinstance(function, FunctionType) or id(function) in seen:
        return []
    seen.add(id(function))
    outside = inspect.getclosurevars(function)
    used = sorted({**outside.globals, **outside.nonlocals}.items())
    numbers = [f"{name} = {value!r}" for name, value in used if isinstance(value, (int, float, str, tuple))]
    calls = [text for _, value in used for text in _texts(value, seen)]
    return [_text(function), *numbers, *calls]


def _text(function: FunctionType) -> str:
    """The source of a law; for one that was typed into a prompt, its bytecode."""
    try:
        return inspect.getsource(function)
    except OSError:
        return f"{function.__code__.co_code.hex()} {function.__code__.co_consts!r}"
