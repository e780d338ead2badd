"""User laws and actions of a run: reading them from files, and identifying them by name and digest.

A run directory contains no code and no path. It contains names and digests, so that a run continues only with the code
that it was started with: the user gives the file on each command.
"""

from __future__ import annotations

import contextlib
import hashlib
import importlib.util
import inspect
import sys
import traceback
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Any, NamedTuple, NoReturn

import numpy as np

from ecume.errors import BadInput
from ecume.models.actions import Action
from ecume.run.directory import RunDirectory, manifest_of
from ecume.trajectories.records import clean

Law = Callable[..., float]
ARGUMENTS = (2, 4)
"""the numbers of arguments of a pair law (distance, parameters), and of an external law (position, velocity, time,
parameters)
"""


class UserCode(NamedTuple):
    """The user functions that a run calls."""

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
    """The laws in a user's files: all public functions of two or four arguments for `FILE.py`, one function for
    `FILE.py:NAME`.

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
    """The actions in a user's files: all of them for `FILE.py`, one for `FILE.py:NAME`. Raises BadInput as `laws_from`
    does.
    """

    def is_action(module: ModuleType, found: object) -> bool:
        return isinstance(found, Action)

    missing = "action; expected a function decorated with @ecume.every(steps=100)"
    return [action for word in words for action in _found("--actions", word, is_action, missing)]


def _found(option: str, word: str, accepts: Callable[[ModuleType, object], bool], missing: str) -> list[Any]:
    """The public objects of one kind in a user's file, or only the named one."""
    file, _, name = word.partition(".py:")
    path = Path(f"{file}.py" if name else word)
    if path.suffix != ".py":
        raise BadInput(f"{option}: got {word!r}; expected FILE.py or FILE.py:NAME")
    module = _executed(option, path)
    found = {key: one for key, one in vars(module).items() if not key.startswith("_") and accepts(module, one)}
    if not found:
        raise BadInput(f"{option}: {path} defines no {missing}")
    if name and name not in found:
        raise BadInput(f"{option}: {path} has no {KINDS_OF[option]} {name!r}; it has {', '.join(found)}")
    return [found[name]] if name else list(found.values())


KINDS_OF = {"--laws": "function", "--actions": "action"}


class TextLoader(SourceFileLoader):
    """A loader that compiles a file from its text, and writes no bytecode.

    Python trusts bytecode if size and time of the text, in whole seconds, are those of its compilation. An edit may
    change neither, and Python would then run the former law.
    """

    def path_stats(self, path: str) -> NoReturn:
        """Raise OSError, so that bytecode is neither read nor written."""
        raise OSError(path)


def _executed(option: str, path: Path) -> ModuleType:
    """The module that a user file defines."""
    if not path.is_file():
        raise BadInput(f"{option}: {path} does not exist")
    name = f"ecume_user_code_{path.stem}"
    spec = importlib.util.spec_from_file_location(name, path, loader=TextLoader(name, str(path)))
    assert spec is not None and spec.loader is not None  # noqa: S101, PT018  # the suffix is .py
    module = importlib.util.module_from_spec(spec)
    sys.modules[module.__name__] = module
    try:
        spec.loader.exec_module(module)
    except Exception as error:  # a user file may raise any exception
        here = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(path)]
        line = error.lineno if isinstance(error, SyntaxError) else here[-1] if here else None
        where = f"{path}, line {line}" if line else str(path)
        raise BadInput(f"{option}: {where}: {type(error).__name__}: {error}") from error
    return module


def entries(functions: Sequence[Any]) -> list[dict[str, Any]]:
    """The names and digests of functions, and the names of objects that they use and that no digest covers."""
    return [_entry(one) for one in functions]


def _entry(one: Any) -> dict[str, Any]:
    function = _plain_function(one)
    further = sorted(set(_further(function, "", set(), known=True))) if isinstance(function, FunctionType) else []
    texts = _texts(one, set()) + [f"{path} = {content}" for path, content in further if content]
    entry = {"name": named(one), "sha256": hashlib.sha256("\n".join(texts).encode()).hexdigest()}
    uncovered = [clean(path) for path, content in further if not content]
    return entry | ({"uncovered": uncovered} if uncovered else {})


def _plain_function(one: Any) -> Any:
    """The function of a law, an action or a compiled function."""
    one = one.function if isinstance(one, Action) else one
    return getattr(one, "py_func", one)


PLAIN = (int, float, complex, str, bytes, bool, type(None), np.generic)
"""Values whose `repr` is their content."""
Contents = Iterator[tuple[str, str]]
"""Yields the paths of objects that a function uses (names in a module), each with its content, or empty if that is
unknown.
"""


def _further(function: FunctionType, path: str, seen: set[int], *, known: bool) -> Contents:
    """The objects that a function uses in addition to the numbers and functions of `_texts` (in `known`): arrays,
    lists, tables, and attributes of modules.
    """
    if id(function) in seen:
        return
    seen.add(id(function))
    names = _names(function.__code__)
    cells = zip(function.__code__.co_freevars, function.__closure__ or (), strict=True)
    used = {name: function.__globals__[name] for name in names if name in function.__globals__}
    with contextlib.suppress(ValueError):  # a variable of a closure that has no value yet
        used |= {name: cell.cell_contents for name, cell in cells}
    outside = inspect.getclosurevars(function)
    found = {**outside.globals, **outside.nonlocals} if known else {}
    for name, value in used.items():
        inner = _plain_function(value)
        if isinstance(inner, FunctionType):
            if not (known and name in found):
                yield f"{path}{name}", _text(inner)
            yield from _further(inner, f"{path}{name}.", seen, known=known and name in found)
        elif not (name in found and _is_plain(value)):
            yield from _content(value, f"{path}{name}", names, seen)
    defaults = (*(function.__defaults__ or ()), *(function.__kwdefaults__ or {}).values())
    for place, value in enumerate(defaults):
        yield from _content(value, f"{path}default {place}", names, seen)


def _names(code: CodeType) -> list[str]:
    """The names that code uses, with those of the functions inside of it."""
    inner = [name for each in code.co_consts if isinstance(each, CodeType) for name in _names(each)]
    return sorted({*code.co_names, *inner})


def _is_plain(value: object) -> bool:
    return isinstance(value, PLAIN) or (type(value) is tuple and all(map(_is_plain, value)))


def _content(value: Any, path: str, names: Sequence[str], seen: set[int]) -> Contents:
    """The content of a value, including that of nested values."""
    function = _plain_function(value)
    if isinstance(value, PLAIN):
        yield path, repr(value)
    elif isinstance(value, np.ndarray):
        bits = np.ascontiguousarray(value).tobytes()
        digest = hashlib.sha256(bits).hexdigest()
        yield path, "" if value.dtype.hasobject else f"{value.dtype.str} {value.shape} {digest}"
    elif id(value) in seen or _is_installed(value):
        return
    elif isinstance(function, FunctionType):
        yield path, _text(function)
        yield from _further(function, f"{path}.", seen, known=False)
    elif isinstance(value, ModuleType):
        seen.add(id(value))
        for name in names:
            if hasattr(value, name):
                yield from _content(getattr(value, name), f"{path}.{name}", names, seen)
    else:
        seen.add(id(value))
        yield from _parts(value, path, names, seen)


def _parts(value: Any, path: str, names: Sequence[str], seen: set[int]) -> Contents:
    """The contents of an object that consists of other values."""
    if isinstance(value, (list, tuple)):
        parts = [(str(place), each) for place, each in enumerate(value)]
    elif isinstance(value, dict):
        parts = [(repr(key), each) for key, each in value.items()]
    elif isinstance(value, (set, frozenset)) and all(isinstance(each, PLAIN) for each in value):
        parts = [("items", repr(sorted(map(repr, value))))]
    elif isinstance(value, type):
        parts = [(name, each) for name, each in vars(value).items() if not name.startswith("__") or callable(each)]
    elif hasattr(value, "__dict__") and not _is_installed(type(value)):
        parts = [("class", type(value)), *vars(value).items()]
    else:
        yield path, ""
        return
    yield path, f"{type(value).__qualname__} of {len(parts)}"
    for name, each in parts:
        yield from _content(each, f"{path}.{name}", names, seen)


INSTALLED = ("site-packages", "dist-packages")


def _is_installed(value: Any) -> bool:
    """Whether an object belongs to Python, to ecume or to an installed package, whose versions a run records."""
    if isinstance(value, ModuleType):
        name = value.__name__
    elif isinstance(value, (type, FunctionType, BuiltinFunctionType, np.ufunc)):
        name = getattr(value, "__module__", None) or "numpy"
    else:
        return False
    top = name.partition(".")[0]
    file = getattr(sys.modules.get(name), "__file__", None) or ""
    standard = top in sys.stdlib_module_names and top != "__main__"
    return standard or top == "ecume" or any(part in INSTALLED for part in Path(file).parts)


def named(function: object) -> str:
    """The name of a law or an action."""
    name = function.name if isinstance(function, Action) else getattr(function, "__name__", None)
    return name or repr(function)


def require_same(home: RunDirectory, code: UserCode) -> None:
    """Raise BadInput unless this is the code with which the run was started, in the same order."""
    manifest, given = manifest_of(home), code.entries()
    former = {key: manifest.get(key, []) for key in given}
    if any(former[key] and not given[key] for key in given):
        raise BadInput(_command(home, {key: [one["name"] for one in former[key]] for key in given}))
    for key, kind in KINDS.items():
        before, now = ([one["name"] for one in each[key]] for each in (former, given))
        if before != now:
            accepts = ", ".join(before) or f"no user-defined {kind}"
            got = ", ".join(now)
            raise BadInput(f"{home.path}: got the {kind} {got}; expected {accepts}, as when the run was started")
        differing = [one["name"] for one, other in zip(former[key], given[key], strict=True) if one != other]
        if differing:
            raise BadInput(
                f"{home.path}: {', '.join(differing)}: the text of this {kind.removesuffix('s')}, or what it uses, has "
                "changed since the run was started; restore it, or run the scene again"
            )
    warn_of_uncovered(given)


def warn_of_uncovered(given: Mapping[str, Sequence[Mapping[str, Any]]]) -> None:
    """Warn of objects without a digest that functions use, whose changes are not detected when the run is resumed."""
    for one in (one for each in given.values() for one in each if "uncovered" in one):
        names = ", ".join(one["uncovered"])
        warnings.warn(f"{one['name']} uses {names}, whose changes are not noticed when a run is resumed", stacklevel=2)


def _command(home: RunDirectory, names: Mapping[str, Sequence[str]]) -> str:
    """The message to a user who resumes a run without its code."""
    kinds = " and ".join(f"{KINDS[key]} {', '.join(each)}" for key, each in names.items() if each)
    options = [f"{OPTIONS[key]} FILE.py:{name}" for key, each in names.items() for name in each]
    python = ", ".join(f"{key}=[{', '.join(each)}]" for key, each in names.items() if each)
    return (
        f"{home.path}: was started with the user-defined {kinds}; give the file that defines them: "
        f"ecume resume {home.path} {' '.join(options)}\n"
        f'or, in Python: ecume.resume("{home.path}", {python})'
    )


def _texts(law: Any, seen: set[int]) -> list[str]:
    """The text of a function, of the global numbers that it uses, and of the functions that it calls."""
    function = _plain_function(law)
    if not isinstance(function, FunctionType) or id(function) in seen:
        return []
    seen.add(id(function))
    outside = inspect.getclosurevars(function)
    used = sorted({**outside.globals, **outside.nonlocals}.items())
    numbers = [f"{name} = {value!r}" for name, value in used if isinstance(value, (int, float, str, tuple))]
    calls = [text for _, value in used for text in _texts(value, seen)]
    return [_text(function), *numbers, *calls]


def _text(function: FunctionType) -> str:
    """The source of a function; for a function typed at a prompt, its bytecode."""
    try:
        return inspect.getsource(function)
    except OSError:
        return f"{function.__code__.co_code.hex()} {function.__code__.co_consts!r}"
