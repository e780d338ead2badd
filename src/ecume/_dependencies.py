"""Digests of everything that compiled code depends on, so that outdated code never runs and unchanged code is not
compiled again.

Compiled code contains all functions that it calls, from any file. Its key is therefore a digest of all objects that can
be reached from the function: the bytecode of each function, the values of constants, the options of decorators and the
fields of named tuples that its bytecode names. Comments, docstrings, line numbers and other content of the same file do
not count.

If a function is selected by the type of an argument, the alternatives that count are those for types that can occur:
the named tuples of its signature, and those that a reached function names. A table of laws therefore contributes only
the rows that a scene uses. The digest covers more than is compiled, such as branches for missing parts, but never less.
If an object cannot be described, the digest is that of the text of the whole package.
"""

from __future__ import annotations

import enum
import hashlib
import sys
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from functools import cache
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any, NamedTuple

import numpy as np

PACKAGE = Path(__file__).absolute().parent
LIBRARIES = frozenset({*sys.stdlib_module_names, "llvmlite", "numba", "numpy", "scipy"}) - {"__main__"}
"""Modules that are described by their names only: the key contains the version of the compiler, which determines their
code.
"""


UNKEPT = "OfThisProcess"
"""Prefix of the names of types that exist in one process only: code compiled for them is not cached on disk."""


class Choice(NamedTuple):
    """The way in which a function with several alternatives selects one."""

    by_class: Callable[[type], Any]
    argument: str
    """Whose class decides."""


CHOICES: dict[Any, Choice] = {}
"""The choices of all functions that represent several alternatives."""


class UnknownThingError(TypeError):
    """Compiled code names an object whose changes cannot all be detected."""


class Description(NamedTuple):
    """The description of an object, without the objects that it names, which are described separately."""

    text: str
    named: tuple[Any, ...]


def digest(function: Any, classes: Iterable[type], beginning: str) -> str:
    """The key of a function compiled for arguments that contain named tuples of these classes."""
    whole = hashlib.sha256(beginning.encode())
    try:
        for line in _lines(function, classes):
            whole.update(line.encode("utf-8", "surrogatepass") + b"\0")
    except UnknownThingError:
        whole = hashlib.sha256(f"{beginning} {_full_name(function)} {package_digest()}".encode())
        for file in {function.__code__.co_filename} if Path(function.__code__.co_filename).is_file() else ():
            whole.update(Path(file).read_bytes())
    return whole.hexdigest()[:32]


def text_of(options: Mapping[str, Any]) -> str:
    """The description of the options of a decorator, equal in all processes."""
    return _value(options, [])


def exact_digest(function: Any) -> str | None:
    """The digest of a user function, or of a function around it, for any arguments; None if it names an object that
    cannot be described.
    """
    whole = hashlib.sha256()
    try:
        for line in _lines(function, ()):
            whole.update(line.encode("utf-8", "surrogatepass") + b"\0")
    except UnknownThingError:
        return None
    return whole.hexdigest()[:32]


@cache
def package_digest() -> str:
    """A digest of the source of the whole package."""
    whole = hashlib.sha256()
    for path in sorted(PACKAGE.rglob("*.py")):
        whole.update(path.relative_to(PACKAGE).as_posix().encode() + hashlib.sha256(path.read_bytes()).digest())
    return whole.hexdigest()


def text_digest(files: Iterable[Path]) -> str:
    """A digest of the text of some files."""
    return hashlib.sha256(b"\0".join(file.read_bytes() for file in files)).hexdigest()


def _lines(function: Any, classes: Iterable[type]) -> Iterator[str]:
    """Descriptions of all objects that the search reaches, breadth first, in the order of their names in the code."""
    seen: dict[int, Any] = {}  # by identity, with a reference, since choices may create functions
    ahead: deque[Any] = deque([function, *classes])
    points: list[Any] = []
    kinds: list[type] = []
    while ahead:
        one = ahead.popleft()
        if id(one) in seen:
            continue
        seen[id(one)] = one
        pairs: list[tuple[Any, type]] = []
        if isinstance(one, type):
            kinds.append(one)
            pairs = [(point, one) for point in points]
        elif one in CHOICES:
            points.append(one)
            yield f"{_full_name(CHOICES[one].by_class)} of {CHOICES[one].argument}"
            pairs = [(one, kind) for kind in kinds]
        for point, kind in pairs:
            made = _chosen(point, kind)
            if made is not None:
                ahead.append(made)
                yield f"{_full_name(CHOICES[point].by_class)} {_full_name(kind)}: {_full_name(made)}"
        if one not in CHOICES:
            text, named = _described(one)
            ahead.extend(named)
            yield text


def _chosen(point: Any, kind: type) -> Any:
    """The alternative for a class, or None without one."""
    try:
        return CHOICES[point].by_class(kind)
    except Exception:  # a table without this row, or a class without the attribute that determines the choice
        return None


_descriptions: dict[int, tuple[Any, Description]] = {}


def _described(one: Any) -> Description:
    """The description of an object. Objects of the package are described once per process, since the package must not
    change during a process; those of the user each time, since a session may change them between runs.
    """
    if id(one) in _descriptions:
        return _descriptions[id(one)][1]
    named: list[Any] = []
    describe = _class if isinstance(one, type) else _function if isinstance(one, FunctionType) else _dispatcher
    found = Description(f"{_full_name(one)} = {describe(one, named)}", tuple(named))
    if _module_of(one).partition(".")[0] == PACKAGE.name and "<locals>" not in _full_name(one):
        _descriptions[id(one)] = one, found
    return found


def _dispatcher(one: Any, named: list[Any]) -> str:
    """The description of a decorated function: its options, and the function."""
    named.append(one.py_func)
    return f"{type(one).__name__} {_value(one.targetoptions, named)}"


def _class(one: Any, named: list[Any]) -> str:
    """The description of a named tuple: its fields in order, and their defaults."""
    defaults = [_value(one._field_defaults[name], named) for name in one._field_defaults]
    return f"class {one._fields} {tuple(one._field_defaults)} {defaults}"


def _function(one: FunctionType, named: list[Any]) -> str:
    """The description of a function: its code and the objects that it names."""
    code = one.__code__
    words = frozenset(_words(code))
    found = [f"{name} {_value(one.__globals__[name], named, words)}" for name in sorted(words & one.__globals__.keys())]
    cells = [_value(cell.cell_contents, named, words) for cell in one.__closure__ or ()]
    defaults = _value(one.__defaults__, named), _value(one.__kwdefaults__, named)
    return f"{_code(code, named, one.__doc__)} {found} {cells} {defaults}"


def _words(code: CodeType) -> Iterator[str]:
    """All names that code may use: globals, attributes, and attributes whose names are strings, including those of
    inner functions.
    """
    yield from code.co_names
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _words(constant)
        elif isinstance(constant, str) and constant.isidentifier():
            yield constant


def _code(code: CodeType, named: list[Any], documentation: str | None = None) -> str:
    """The bytecode without line numbers."""
    constants = list(code.co_consts)
    if constants and documentation is not None and constants[0] == documentation:
        constants[0] = None
    shape = code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount, code.co_flags
    names = code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars
    inside = [_value(constant, named) for constant in constants]
    return f"{code.co_code.hex()} {code.co_exceptiontable.hex()} {shape} {names} {inside}"


def _value(value: Any, named: list[Any], words: frozenset[str] = frozenset()) -> str:
    """The description of a value as text. Objects with separate descriptions are added to `named`; for a module, only
    the attributes in `words` count.
    """
    if value is None or value is Ellipsis or type(value) in (bool, int, str, bytes):
        return f"{type(value).__name__} {value!r}"
    if isinstance(value, (float, complex)) and not isinstance(value, np.generic):
        return f"{type(value).__name__} {np.complex128(value).tobytes().hex()}"
    if isinstance(value, CodeType):
        return _code(value, named)
    if isinstance(value, (tuple, list, set, frozenset, Mapping)):
        return _collection(value, named)
    if isinstance(value, (np.generic, np.ndarray)) and not value.dtype.hasobject:
        return f"{type(value).__name__} {value.dtype.descr} {value.shape} {value.tobytes('A').hex()} {value.flags}"
    if isinstance(value, np.dtype):
        return f"dtype {value.descr}"
    if isinstance(value, enum.Enum):
        return f"{_full_name(type(value))}.{value.name} {_value(value.value, named)}"
    if isinstance(value, ModuleType):
        return _module(value, named, words)
    return _thing(value, named)


def _collection(value: Any, named: list[Any]) -> str:
    if isinstance(value, Mapping):
        return f"dict {[(_value(name, named), _value(one, named)) for name, one in value.items()]}"
    inside = [_value(one, named) for one in value]
    if hasattr(value, "_fields"):
        named.append(type(value))
        return f"{_full_name(type(value))} {inside}"
    return f"{type(value).__name__} {sorted(inside) if isinstance(value, (set, frozenset)) else inside}"


def _module(module: ModuleType, named: list[Any], words: frozenset[str]) -> str:
    """The description of the attributes of a module that the code may read."""
    if _of_library(module.__name__):
        return f"module {module.__name__}"
    inside = vars(module)
    # For a module in a module, the words without the name of the former, so that the recursion ends.
    rest = words - {module.__name__.rpartition(".")[2]}
    found = [f"{name} {_value(inside[name], named, rest - {name})}" for name in sorted(words & inside.keys())]
    return f"module {module.__name__} {found}"


def _thing(value: Any, named: list[Any]) -> str:
    """The description of a function, class or object that the compiler knows by name."""
    name = _full_name(value)
    if hasattr(value, "py_func") or (isinstance(value, FunctionType) and value in CHOICES):
        named.append(value)
        return f"-> {name}"
    if hasattr(value, "__name__") and _of_library(_module_of(value)):
        if isinstance(getattr(value, "__self__", None), (ModuleType, type, None.__class__)):
            return name
    elif _module_of(type(value)).partition(".")[0] in ("numba", "numpy"):
        return f"{name} {value!r}"
    if isinstance(value, FunctionType) or (isinstance(value, type) and hasattr(value, "_fields")):
        named.append(value)
        return f"-> {name}"
    if isinstance(value, type) and issubclass(value, enum.Enum):
        return f"{name} {[_value(member, named) for member in value]}"
    if isinstance(value, type) and (issubclass(value, BaseException) or is_dataclass(value)):
        return name  # it is an exception, or compiled code cannot use it
    if is_dataclass(value) and not isinstance(value, type) and value.__dataclass_params__.frozen:  # type: ignore[attr-defined]
        return f"{name} {[_value(getattr(value, field.name), named) for field in fields(value)]}"
    raise UnknownThingError(name)


def _of_library(module: str) -> bool:
    return module.partition(".")[0] in LIBRARIES


def _full_name(thing: Any) -> str:
    name = getattr(thing, "__qualname__", None) or getattr(thing, "__name__", type(thing).__qualname__)
    return f"{_module_of(thing)}.{name}"


def _module_of(thing: Any) -> str:
    return str(getattr(thing, "__module__", None) or getattr(type(thing), "__module__", ""))
