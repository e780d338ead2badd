"""The user's laws and actions of a run: reading them from files, and identifying them by name and digest.

A run directory contains no code and no path. It contains names and digests, so that a run continues only with the code
that it was started with: the user gives the file on each command.
"""

from __future__ import annotations

import hashlib
import importlib.util
import inspect
import sys
import traceback
from collections.abc import Callable, Mapping, Sequence
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any, NamedTuple, NoReturn

from ecume.errors import BadInput
from ecume.models.actions import Action
from ecume.run.directory import RunDirectory, manifest_of

Law = Callable[..., float]
ARGUMENTS = (2, 4)
"""of a pair law (distance, parameters), and of an external law (position, velocity, time, parameters)"""


class UserCode(NamedTuple):
    """The user's functions that a run calls."""

    laws: Sequence[Law] = ()
    actions: Sequence[Action] = ()

    def entries(self) -> dict[str, list[dict[str, Any]]]:
        """The entries of the manifest."""
        periods = [{"every": action.period} for action in self.actions]
        actions = [one | period for one, period in zip(entries(self.actions), periods, strict=True)]
        return {"extra_laws": entries(self.laws), "actions": actions}


NO_CODE = UserCode()
OPTIONS = {"extra_laws": "--laws", "actions": "--actions"}
"""The option that gives the code of each entry of the manifest."""
KINDS = {"extra_laws": "laws", "actions": "actions"}


def laws_from(words: Sequence[str]) -> list[Law]:
    """The laws in a user's files: `FILE.py` gives its public functions of two or four arguments, `FILE.py:NAME` one.

    Raises BadInput where a file cannot be read or run, or has no such function.
    """

    def is_law(module: ModuleType, found: object) -> bool:
        own = inspect.isfunction(found) and found.__module__ == module.__name__
        return own and len(inspect.signature(found).parameters) in ARGUMENTS  # type: ignore[arg-type]

    missing = (
        "function of two or four arguments; expected (distance, parameters) -> force, or "
        "(position, velocity, time, parameters) -> acceleration"
    )
    return [law for word in words for law in _found("--laws", word, is_law, missing)]


def actions_from(words: Sequence[str]) -> list[Action]:
    """The actions in a user's files: `FILE.py` gives all of them, `FILE.py:NAME` that one. Raises BadInput likewise."""

    def is_action(module: ModuleType, found: object) -> bool:
        return isinstance(found, Action)

    missing = "action; expected a function decorated with @ecume.every(steps=100)"
    return [action for word in words for action in _found("--actions", word, is_action, missing)]


def _found(option: str, word: str, wanted: Callable[[ModuleType, object], bool], missing: str) -> list[Any]:
    """The public objects of one kind in a user's file, or the one that is named."""
    file, _, name = word.partition(".py:")
    path = Path(f"{file}.py" if name else word)
    if path.suffix != ".py":
        raise BadInput(f"{option}: got {word!r}; expected FILE.py or FILE.py:NAME")
    module = _executed(option, path)
    found = {key: one for key, one in vars(module).items() if not key.startswith("_") and wanted(module, one)}
    if not found:
        raise BadInput(f"{option}: {path} defines no {missing}")
    if name and name not in found:
        raise BadInput(f"{option}: {path} has no {KINDS_OF[option]} {name!r}; it has {', '.join(found)}")
    return [found[name]] if name else list(found.values())


KINDS_OF = {"--laws": "function", "--actions": "action"}


class TextLoader(SourceFileLoader):
    """Loads a file from its text, and leaves no bytecode beside it.

    Python trusts bytecode if size and time of the text, in whole seconds, are those of its compilation. An edit may
    change neither, and then a former law would run.
    """

    def path_stats(self, path: str) -> NoReturn:
        """No size and no time: bytecode is neither read nor written."""
        raise OSError(path)


def _executed(option: str, path: Path) -> ModuleType:
    """The module that a file of the user's defines."""
    if not path.is_file():
        raise BadInput(f"{option}: {path} does not exist")
    name = f"ecume_user_code_{path.stem}"
    spec = importlib.util.spec_from_file_location(name, path, loader=TextLoader(name, str(path)))
    assert spec is not None and spec.loader is not None  # noqa: S101, PT018  # the suffix is .py
    module = importlib.util.module_from_spec(spec)
    sys.modules[module.__name__] = module
    try:
        spec.loader.exec_module(module)
    except Exception as error:  # a user's file may raise anything
        here = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(path)]
        line = error.lineno if isinstance(error, SyntaxError) else here[-1] if here else None
        where = f"{path}, line {line}" if line else str(path)
        raise BadInput(f"{option}: {where}: {type(error).__name__}: {error}") from error
    return module


def entries(functions: Sequence[Any]) -> list[dict[str, Any]]:
    """The names and digests of functions."""
    return [
        {"name": named(one), "sha256": hashlib.sha256("\n".join(_texts(one, set())).encode()).hexdigest()}
        for one in functions
    ]


def named(function: object) -> str:
    """The name of a law or an action."""
    name = function.name if isinstance(function, Action) else getattr(function, "__name__", None)
    return name or repr(function)


def require_same(home: RunDirectory, code: UserCode) -> None:
    """Raise BadInput unless this is the code that the run was begun with, in its order."""
    manifest, given = manifest_of(home), code.entries()
    former = {key: manifest.get(key, []) for key in given}
    if any(former[key] and not given[key] for key in given):
        raise BadInput(_command(home, {key: [one["name"] for one in former[key]] for key in given}))
    for key, kind in KINDS.items():
        before, now = ([one["name"] for one in each[key]] for each in (former, given))
        if before != now:
            wanted = ", ".join(before) or f"no user-defined {kind}"
            got = ", ".join(now)
            raise BadInput(f"{home.path}: got the {kind} {got}; expected {wanted}, as when the run was started")
        differing = [one["name"] for one, other in zip(former[key], given[key], strict=True) if one != other]
        if differing:
            raise BadInput(
                f"{home.path}: {', '.join(differing)}: the text of this {kind.removesuffix('s')} has changed since the "
                "run was started; restore it, or run the scene again"
            )


def _command(home: RunDirectory, names: Mapping[str, Sequence[str]]) -> str:
    """The message to someone who resumes a run without its code."""
    kinds = " and ".join(f"{KINDS[key]} {', '.join(each)}" for key, each in names.items() if each)
    options = [f"{OPTIONS[key]} FILE.py:{name}" for key, each in names.items() for name in each]
    python = ", ".join(f"{key}=[{', '.join(each)}]" for key, each in names.items() if each)
    return (
        f"{home.path}: was started with the user-defined {kinds}; give the file that defines them: "
        f"ecume resume {home.path} {' '.join(options)}\n"
        f'or, in Python: ecume.resume("{home.path}", {python})'
    )


def _texts(law: Any, seen: set[int]) -> list[str]:
    """The text of a function, of the numbers from outside that it uses, and of the functions that it calls."""
    law = law.function if isinstance(law, Action) else law
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
    """The source of a function; for one that was typed into a prompt, its bytecode."""
    try:
        return inspect.getsource(function)
    except OSError:
        return f"{function.__code__.co_code.hex()} {function.__code__.co_consts!r}"
