"""The user's own pair laws of a run: what they are called, and whether they are still what they were.

A run directory keeps no code and no path. It keeps names and digests, so that a run continues with the laws that it was
started with, or not at all: the user gives the file on each command.
"""

from __future__ import annotations

import hashlib
import importlib.util
import inspect
import sys
import traceback
from collections.abc import Callable, Sequence
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any

from ecume.errors import BadInput
from ecume.run.directory import RunDirectory, manifest_of

Law = Callable[..., float]
ARGUMENTS = 2
"""of a pair law: the distance, and the parameters of the pair"""


def laws_from(words: Sequence[str]) -> list[Law]:
    """The pair laws in a user's files: `FILE.py` gives its public functions of two arguments, `FILE.py:NAME` that one.

    Raises BadInput where a file cannot be read or run, or has no such function.
    """
    return [law for word in words for law in _laws_of(word)]


def _laws_of(word: str) -> list[Law]:
    file, _, name = word.partition(".py:")
    path = Path(f"{file}.py" if name else word)
    if path.suffix != ".py":
        raise BadInput(f"--laws: got {word!r}; expected FILE.py or FILE.py:NAME")
    module = _executed(path)
    found = {
        function: law
        for function, law in vars(module).items()
        if inspect.isfunction(law)
        and law.__module__ == module.__name__
        and not function.startswith("_")
        and len(inspect.signature(law).parameters) == ARGUMENTS
    }
    if not found:
        raise BadInput(f"--laws: {path} defines no function of two arguments; expected (distance, parameters) -> force")
    if name and name not in found:
        raise BadInput(f"--laws: {path} has no function {name!r}; it has {', '.join(found)}")
    return [found[name]] if name else list(found.values())


def _executed(path: Path) -> ModuleType:
    """The module that a file of the user's defines."""
    if not path.is_file():
        raise BadInput(f"--laws: {path}: there is no such file")
    spec = importlib.util.spec_from_file_location(f"ecume_user_laws_{path.stem}", path)
    assert spec is not None and spec.loader is not None  # noqa: S101, PT018  # the suffix is .py
    module = importlib.util.module_from_spec(spec)
    sys.modules[module.__name__] = module
    try:
        spec.loader.exec_module(module)
    except Exception as error:  # a user's file may raise anything
        here = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(path)]
        line = error.lineno if isinstance(error, SyntaxError) else here[-1] if here else None
        where = f"{path}, line {line}" if line else str(path)
        raise BadInput(f"--laws: {where}: {type(error).__name__}: {error}") from error
    return module


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
    former, now = manifest_of(home).get("extra_laws", []), entries(extra_laws)
    before, given = [law["name"] for law in former], [law["name"] for law in now]
    if before and not given:
        raise BadInput(
            f"{home.path}: was started with laws of your own, {', '.join(before)}; give the file that defines them: "
            f"ecume resume {home.path} {' '.join(f'--laws FILE.py:{name}' for name in before)}\n"
            f'or, in Python: ecume.resume("{home.path}", extra_laws=[{", ".join(before)}])'
        )
    if before != given:
        wanted = ", ".join(before) or "no laws of your own"
        raise BadInput(f"{home.path}: got the laws {', '.join(given)}; expected {wanted}, as when the run was started")
    differing = [one["name"] for one, other in zip(former, now, strict=True) if one != other]
    if differing:
        raise BadInput(
            f"{home.path}: {', '.join(differing)}: the text of this law has changed since the run was started; "
            "restore it, or run the scene again"
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
