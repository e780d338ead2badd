"""Dispatchers that represent several compiled functions: versions with and without threads, sequences of passes, and
the rows of a table.
"""

from __future__ import annotations

import _thread
import ctypes
import functools
import math
import os
import threading
from collections.abc import Callable
from itertools import islice
from types import FunctionType
from typing import Any, cast

import llvmlite.binding
import numpy as np
from numba.core import types
from numba.core.imputils import lower_builtin
from numba.core.typing import signature
from numba.core.typing.templates import AbstractTemplate

from ecume._parts import Dispatcher

# Threads that wait for their next loop by spinning slow down other processes on this machine, and themselves: on a busy
# machine, loops over several thousand particles took five times as long. The variable is read when threads start.
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")

_FORKED: list[int] = []
"""This process, if it was forked from one whose threads had started."""


def _note_fork() -> None:
    from numba.np.ufunc import parallel

    if getattr(parallel, "_is_initialized", False):
        _FORKED.append(os.getpid())


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_note_fork)


def require_own_threads() -> None:
    """Raise RuntimeError in a forked process in which the threads of its parent are missing: the library that waits for
    them would end the process or wait forever.
    """
    if _FORKED:
        raise RuntimeError(
            "this process was forked from one that had started threads; start workers with "
            'multiprocessing.get_context("spawn"), or fork them before the first simulation'
        )


class Threaded(Dispatcher):
    """A threaded loop. Compiled code that calls it must be called from Python code that has called
    `require_threads`.
    """

    def __init__(self, function: Any) -> None:
        super().__init__(function, {"parallel": True}, cache=True)

    def __call__(self, *arguments: Any) -> Any:
        """Run the version without threads for small systems, otherwise the one with threads."""
        require_own_threads()
        return super().__call__(*arguments)


class Spread:
    """A loop that Python calls, compiled twice: with threads, and without for small systems.

    The last axis of the first argument is the size of the system, so that the choice, and the order of sums, do not
    depend on the number of threads.
    """

    def __init__(self, function: Any, options: dict[str, Any], few: int) -> None:
        self.few = few
        self.alone = Dispatcher(function, options, cache=True)
        self.together = Dispatcher(function, {"parallel": True, **options}, cache=True)
        self.__doc__, self.__name__ = function.__doc__, function.__name__

    def __call__(self, array: Any, *arguments: Any) -> Any:
        """Run the version without threads for small systems, otherwise the one with threads."""
        if array.shape[-1] < self.few:
            return self.alone(array, *arguments)
        require_own_threads()
        return self.together(array, *arguments)


OTHERS = ("comprehension", "reduction", "inplace_binop", "setitem", "numpy", "stencil", "fusion")
PLAIN_LOOPS = dict.fromkeys(OTHERS, False)
"""The flags by which only explicit loops are threaded; threaded array expressions take a second each to compile."""


class Shared(Dispatcher):
    """A pass with `prange` that compiled code calls without threads, and Python with threads for large systems."""

    def __init__(self, function: Any, size: Callable[..., int], few: int) -> None:
        super().__init__(function, {}, cache=True)
        self.size, self.few = size, few
        self.together = Dispatcher(function, {"parallel": PLAIN_LOOPS}, cache=True)

    def __call__(self, *arguments: Any) -> Any:
        """Run the version that suits the size of the system."""
        if self.size(*arguments) < self.few:
            return super().__call__(*arguments)
        require_own_threads()
        return self.together(*arguments)


class Apart(Dispatcher):
    """A function that is compiled at its first call from compiled code, which calls it through Python. Arrays are
    passed as addresses and shapes. It is linked by its name, which LLVM knows once the module is imported, so that code
    from the disk finds it.
    """

    def __init__(self, function: Any, arrays: tuple[str, ...]) -> None:
        super().__init__(function, {}, cache=True)
        self.kinds = [(kind.partition("[")[0], kind.count(":")) for kind in arrays]
        name = f"{function.__module__}.{function.__qualname__}"
        self.entrance = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_void_p)(self.enter)
        llvmlite.binding.add_symbol(name, ctypes.cast(self.entrance, ctypes.c_void_p).value)
        enter = types.ExternalFunction(name, signature(types.int64, types.intp))
        self.part = Dispatcher(packing(function, self.kinds, enter), {}, cache=True).part

    def enter(self, address: int) -> int:
        """Run the function with the arrays that are described at this address."""
        numbers = iter(as_array(address, "int64", (sum(1 + axes for _, axes in self.kinds),)).tolist())
        arrays = [as_array(next(numbers), kind, tuple(islice(numbers, axes))) for kind, axes in self.kinds]
        try:
            return int(self(*arrays))
        except KeyboardInterrupt:  # an exception that compiled code cannot raise
            threading.Timer(0.05, _thread.interrupt_main).start()
            return 0


def as_array(address: int, kind: str, shape: tuple[int, ...]) -> Any:
    """The array of this type and shape at an address."""
    if 0 in shape:
        return np.empty(shape, kind)
    return np.ctypeslib.as_array((np.ctypeslib.as_ctypes_type(kind) * math.prod(shape)).from_address(address)).reshape(
        shape
    )


def packing(function: Any, kinds: list[tuple[str, int]], enter: Any) -> Any:
    """A function with the same arguments, which writes their addresses and shapes into one array and calls `enter` with
    it.
    """
    numbers = [f"a{k}.{what}" for k, (_, axes) in enumerate(kinds) for what in ("ctypes.data", *_sizes(axes))]
    text = [f"def packed({', '.join(f'a{k}' for k in range(len(kinds)))}):"]
    text += [f"given = empty({len(numbers)}, int64)", *(f"given[{k}] = {one}" for k, one in enumerate(numbers))]
    # The later use keeps the array alive until the call returns.
    text += ["done = enter(given.ctypes.data)", "return done != 0 and given[0] == a0.ctypes.data"]
    names = {"__name__": function.__module__, "empty": np.empty, "int64": np.int64, "enter": enter}
    exec(compile("\n    ".join(text), __file__, "exec"), names)  # noqa: S102  # of numbers and the names above
    packed: Any = names["packed"]
    packed.__qualname__ = f"{function.__qualname__}.packed"
    return packed


def _sizes(axes: int) -> list[str]:
    return [f"shape[{axis}]" for axis in range(axes)]


class Composed(Dispatcher):
    """A function that compiled code calls as a part, while Python executes its text with each called function compiled
    separately.
    """

    def __init__(self, function: Any) -> None:
        super().__init__(function, {"inline": "always"}, cache=True)

    def __call__(self, *arguments: Any) -> Any:
        """Run the function."""
        return self.py_func(*arguments)


class Selected(Dispatcher):
    """A function that represents several compiled functions, selected by the type of the first argument. Compiled code
    calls the selected function directly: a function in between would pass hundreds of arrays, which takes long to
    compile. If None is selected, the call is the constant `missing`.
    """

    def __init__(self, choice: Callable[[type], Any], missing: int | None) -> None:
        super().__init__(cast(FunctionType, lambda *arguments: None), {}, cache=False)
        self.choice, self.missing = choice, missing

    def __call__(self, *arguments: Any) -> Any:
        """Run the chosen function."""
        function = self.choice(type(arguments[0]))
        return self.missing if function is None else function(*arguments)

    def get_call_template(self, arguments: Any, keywords: Any) -> Any:
        """The template by which compiled code calls the selected function."""
        function = self.choice(arguments[0].instance_class)
        if function is None:
            return _constant(self.missing)[0], None, arguments, keywords
        return function.get_call_template(arguments, keywords)

    def get_overload(self, signature: Any) -> Any:
        """The implementation that compiled code calls."""
        function = self.choice(signature[0].instance_class)
        return _constant(self.missing)[1] if function is None else function.get_overload(signature)


@functools.cache
def _constant(value: int | None) -> tuple[Any, Any]:
    """The type and the code of a call with a constant value."""
    kind = types.none if value is None else types.int64

    def constant(*arguments: Any) -> int | None:
        return value

    class Template(AbstractTemplate):  # type: ignore[misc]  # Numba's types are skipped: they are incomplete
        key = constant

        def generic(self, arguments: Any, keywords: Any) -> Any:
            return signature(kind, *arguments)

    @lower_builtin(constant, types.VarArg(types.Any))  # type: ignore[untyped-decorator]
    def lower(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return context.get_dummy_value() if value is None else context.get_constant(kind, value)

    return Template, constant


_constant(None)
_constant(0)
