"""The interface to the compiler: decorators for compiled loops, which return the Python functions if compilation is
disabled.

Only this file, `_parts`, `_variants`, `_lowering` and `_borrowing` import Numba, and with NUMBA_DISABLE_JIT=1 none
does.
"""

from __future__ import annotations

import collections
import functools
import hashlib
import inspect
import os
from collections.abc import Callable, Iterable, Mapping
from types import FunctionType, ModuleType
from typing import Any, TypeVar

import numpy as np

from ecume._dependencies import CHOICES, UNKEPT, Choice

COMPILES = os.environ.get("NUMBA_DISABLE_JIT", "").strip() in ("", "0")
"""Whether functions are compiled; otherwise they remain plain Python, and Numba is not imported."""

if COMPILES:
    import numba
    from numba.core import types

    from ecume import _lowering  # noqa: F401  # for what it registers
    from ecume._parts import Dispatcher, overload
    from ecume._variants import Apart, Composed, Selected, Shared, Spread, Threaded, require_own_threads

Function = TypeVar("Function", bound=Callable[..., Any])

SEVERAL = 2000
"""The number of particles from which some model has threaded loops."""
FEW = 4000
"""Loops over fewer particles than this end sooner than a second thread wakes up."""
ANY_ORDER = {"reassoc", "contract", "nsz", "arcp"}
"""The permissions of sums that are computed eight terms at a time. NaN and infinity are preserved."""
prange: Any = numba.prange if COMPILES else range
"""A loop over threads; only inside a function that is `threaded`."""


def compiled(function: Function) -> Function:
    """Compile at the first call, and store the result on disk. Fastmath is disabled, since NaN must be detected, and
    the bits must not depend on the caller.
    """
    return _dispatcher(function, cache=True)


def compiled_inside(function: Function) -> Function:
    """Compile a short function for inner loops: its machine code is inlined, which avoids reference counts."""
    return _dispatcher(function, cache=True, forceinline=True)


def summed_inside(function: Function) -> Function:
    """Compile a short function for loops that are `summing`, with their arithmetic, for any caller."""
    return _dispatcher(function, cache=True, forceinline=True, fastmath=ANY_ORDER)


def compiled_apart(*arrays: str) -> Callable[[Function], Function]:
    """Compile a function of arrays with these types, such as "float64[:,:]", at its first call: for long code that few
    runs reach. The function returns whether it succeeded; false includes any failure.
    """

    def decorate(function: Function) -> Function:
        made: Any = Apart(function, arrays) if COMPILES else function
        kept: Function = made
        return kept

    return decorate


def threaded(function: Function) -> Function:
    """Compile a function whose `prange` loops use threads."""
    made: Any = Threaded(function) if COMPILES else function
    kept: Function = made
    return kept


def require_threads(particles: int = SEVERAL) -> None:
    """Raise RuntimeError in a forked process in which the threads of its parent are missing, if this number of
    particles requires threads: the library would end the process or wait forever.
    """
    if COMPILES and particles >= SEVERAL:
        require_own_threads()


def spread(function: Function) -> Function:
    """A loop with `prange` over the particles of its first argument, for Python to call."""
    return _spread(function, {})


def summing(function: Function) -> Function:
    """Compile a function in which sums may be reordered, always in the same way."""
    return _spread(function, {"fastmath": ANY_ORDER})


def _spread(function: Function, options: dict[str, Any]) -> Function:
    made: Any = Spread(function, options, FEW) if COMPILES else function
    kept: Function = made
    return kept


def shared(size: Callable[..., int]) -> Callable[[Function], Function]:
    """Compile a pass for compiled code, for Python, and for threads; `size` derives the size from the arguments."""

    def decorate(function: Function) -> Function:
        made: Any = Shared(function, size, FEW) if COMPILES else function
        kept: Function = made
        return kept

    return decorate


def composed(function: Function) -> Function:
    """A sequence of passes: compiled as a part of a larger function for few particles; executed by Python for many, so
    that each pass may use threads.
    """
    made: Any = Composed(function) if COMPILES else function
    kept: Function = made
    return kept


def where_there(default: Any = None) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Compile a function whose first argument is optional: if it is an empty tuple, the result is `default`, and no
    code of the function is compiled.
    """

    def decorate(function: Callable[..., Any]) -> Callable[..., Any]:
        made = _dispatcher(function, cache=True)

        @functools.wraps(function)
        def there(subject: Any, *rest: Any) -> Any:
            return made(subject, *rest) if subject != () else default

        if COMPILES:

            @overload(there)
            def version(subject: Any, *rest: Any) -> Any:
                missing = isinstance(subject, types.BaseTuple) and len(subject) == 0
                found = (lambda subject, *rest: default) if missing else (lambda subject, *rest: made(subject, *rest))
                # Code is linked by names across processes.
                found.__qualname__ = (
                    f"{function.__module__}.{function.__qualname__}.{'missing' if missing else 'there'}"
                )
                return found

        return there

    return decorate


def by_type(choice: Callable[[type], Callable[..., Any]], place: int = -1) -> Callable[..., Any]:
    """A function that dispatches on the type of one argument, a NamedTuple: it calls `choice(type)`. Compiled code
    contains only the selected function.
    """

    def chosen(*arguments: Any) -> Any:
        return choice(type(arguments[place]))(*arguments)

    if not COMPILES:
        return chosen
    CHOICES[chosen] = Choice(choice, f"argument {place}")

    @overload(chosen, forceinline=True)
    def version(*arguments: Any) -> Any:
        if not isinstance(arguments[place], types.BaseNamedTuple):
            return None
        made = choice(arguments[place].instance_class)
        if not isinstance(made, FunctionType):
            # Arguments are named one by one: a tuple of large named tuples takes minutes to compile.
            return _written([f"return call_0({_names(len(arguments))})"], len(arguments), {"call_0": made})
        return in_single(made) if types.float32 in arguments and types.float64 not in arguments else made

    return chosen


def selected(rows: Mapping[type, Any], name: str, missing: int | None = None) -> Any:
    """The function `name` of the row for the type of the first argument, a NamedTuple. If the row has None, the result
    is `missing`, and no code is compiled.
    """
    choice = _field_of(rows, name)
    if COMPILES:
        made = Selected(choice, missing)
        CHOICES[made] = Choice(choice, "argument 0")
        return made

    def chosen(*arguments: Any) -> Any:
        function = choice(type(arguments[0]))
        return missing if function is None else function(*arguments)

    return chosen


def each_selected(rows: Mapping[type, Any], name: str) -> Callable[..., None]:
    """A function of a tuple of parts, a tuple of as many workspaces, and further arguments. For each part it calls the
    function `name` of the row for the type of the part, if there is one: function(part, workspace, *arguments).
    """
    choice = _field_of(rows, name)

    def each(parts: Any, workspaces: Any, *arguments: Any) -> None:
        for part, own in zip(parts, workspaces, strict=True):
            function = choice(type(part))
            if function is not None:
                function(part, own, *arguments)

    if not COMPILES:
        return each
    CHOICES[each] = Choice(choice, "parts")

    @overload(each)
    def version(parts: Any, workspaces: Any, *arguments: Any) -> Any:
        if not isinstance(parts, types.BaseTuple):
            return None
        chosen = [(k, choice(kind.instance_class)) for k, kind in enumerate(parts)]
        found: dict[str, Any] = {f"call_{k}": function for k, function in chosen if function is not None}
        rest = "".join(f", a{k + 2}" for k in range(len(arguments)))
        calls = [f"call_{k}(a0[{k}], a1[{k}]{rest})" for k, function in chosen if function is not None]
        return _written(calls or ["pass"], len(arguments) + 2, found)

    return each


def _field_of(rows: Mapping[type, Any], name: str) -> Callable[[type], Any]:
    def choice(kind: type) -> Any:
        return getattr(rows[kind], name)

    choice.__qualname__ = f"{name} of rows"
    return choice


def _names(count: int) -> str:
    return ", ".join(f"a{k}" for k in range(count))


def _written(lines: list[str], count: int, found: dict[str, Any]) -> Any:
    """A function with these lines and `count` arguments a0, a1, ...; the names that it calls are those in `found`.

    Its name describes its content, since code is linked by names across processes.
    """
    calls = [f"{one.__module__}.{one.__qualname__}" for one in found.values()]
    name = f"written_{hashlib.sha256(repr((lines, calls)).encode()).hexdigest()[:16]}"
    text = "\n    ".join([f"def {name}({_names(count)}):", *lines])
    exec(compile(text, __file__, "exec"), found)  # noqa: S102  # of the names above, nothing from outside
    return found[name]


def of_this_process(name: str, fields: Iterable[str]) -> Any:
    """A NamedTuple class that exists only in this process; code compiled for it is not written to the disk cache."""
    return collections.namedtuple(f"{UNKEPT}{name}", fields)


def compiled_once(function: Function) -> Function:
    """Compile only for this process: for user functions, which no file of ecume can name."""
    return _dispatcher(function, cache=False)


def inlined(function: Function) -> Function:
    """A loop with functions as arguments: it is inlined in its caller, which names these functions and therefore can be
    cached.
    """
    made: Function = numba.njit(inline="always", error_model="numpy")(function) if COMPILES else function
    return made


def plainly(function: Function) -> Function:
    """The Python version of a function that is `inlined` elsewhere, for arguments that cannot be compiled."""
    kept: Function = getattr(function, "py_func", function)
    return kept


def selection(
    name: str, laws: Mapping[int, Callable[..., Any]], module: str, file: str, takes: tuple[str, ...] = ()
) -> Any:
    """A function `name(x, code)` for loops that are `summing`: the law with this code at x.

    With `takes`, a function `name(*takes, code)` for all other loops: each argument of a law is one of these, by its
    name, or a field of the last of them.

    It is generated from a table of laws, as source text with one branch for each row, so that no branch can be missing
    (`dataclasses` generate `__init__` in the same way). A law that is passed as an argument or captured in a closure
    would be compiled again in each process; a function with the laws as its globals is cached on disk like any other.
    `module` and `file` are those of the caller. The table must not change while the program runs.

    The last branch does not test the code, since another branch would change the arrangement of loops by the compiler
    and the rounding of their sums. The caller must refuse unknown codes before a loop starts.
    """
    found: dict[str, Any] = {"__name__": module}
    given = ", ".join(takes or "x")
    lines, distinct = [f"def {name}({given}, code):"], list(dict.fromkeys(laws.values()))
    for number, law in enumerate(distinct):
        found[f"law_{number}"] = law
        if law is not distinct[-1]:
            codes = " or ".join(f"code == {code:d}" for code in laws if laws[code] is law)
            lines += [f"    if {codes}:", f"        return law_{number}({_given_to(law, takes)})"]
    lines += [f"    return law_{len(distinct) - 1}({_given_to(distinct[-1], takes)})"]
    exec(compile("\n".join(lines), file, "exec"), found)  # noqa: S102  # of the names above, nothing from outside
    return compiled_inside(found[name]) if takes else summed_inside(found[name])


def _given_to(law: Callable[..., Any], takes: tuple[str, ...]) -> str:
    """The arguments of a law as text: each is an argument of the selection, or a field of its last argument."""
    if not takes:
        return "x"
    names = inspect.signature(law).parameters
    return ", ".join(one if one in takes else f"{takes[-1]}.{one}" for one in names)


def admit(*modules: ModuleType) -> None:
    """Make the plain functions of these modules callable from compiled code, without making the laws depend on Numba.

    If all arguments are in single precision, the constants of a law are in single precision as well: a single literal
    would make the whole loop double.
    """
    if not COMPILES:
        return
    for module in modules:
        for law in vars(module).values():
            if isinstance(law, FunctionType) and law.__module__ == module.__name__:
                _admit_law(law)


def _admit_law(law: FunctionType) -> None:
    @overload(law, forceinline=True)
    def version(*arguments: Any, **named: Any) -> FunctionType:
        kinds = {*arguments, *named.values()}
        return in_single(law) if types.float32 in kinds and types.float64 not in kinds else law


def in_single(law: FunctionType) -> FunctionType:
    """The law with single-precision constants, including those of its module."""
    code = law.__code__.replace(co_consts=tuple(map(_single, law.__code__.co_consts)))
    names = {name: _single(value) for name, value in law.__globals__.items()}
    defaults = tuple(map(_single, law.__defaults__ or ()))
    return FunctionType(code, names, law.__name__, defaults, law.__closure__)


def _single(value: Any) -> Any:
    return np.float32(value) if type(value) is float else value


def use_threads(count: int | None) -> int:
    """Use this number of threads from now on; None for all of the machine. The result does not depend on it. Plain
    Python uses a single thread.
    """
    if not COMPILES:
        return 1
    if count is not None:
        numba.set_num_threads(min(count, numba.config.NUMBA_NUM_THREADS))
    return int(numba.get_num_threads())


def _dispatcher(function: Function, *, cache: bool, **options: Any) -> Function:
    made: Any = Dispatcher(function, options, cache) if COMPILES and isinstance(function, FunctionType) else function
    kept: Function = made
    return kept
