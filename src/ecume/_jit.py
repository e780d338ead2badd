"""How loops are compiled: with `_parts` and `_borrowing`, the only files that import Numba."""

from __future__ import annotations

import collections
import functools
import hashlib
import inspect
import math
import os
from collections.abc import Callable, Iterable, Mapping
from types import FunctionType, ModuleType
from typing import Any, TypeVar, cast

import numba
import numba.extending
import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.core.imputils import lower_builtin

from ecume._columns import RECORD, fill_columns
from ecume._dependencies import CHOICES, Choice
from ecume._fused import LANES, fused, lane_sum
from ecume._parts import PART, UNKEPT, AloneCache, Dispatcher, Part, TogetherCache

# Threads that wait for their next loop by spinning slow down other processes on this machine, and are slowed by them
# themselves: on a busy machine loops over a few thousand particles took five times as long. Read when they start.
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")

Function = TypeVar("Function", bound=Callable[..., Any])

ANY_ORDER = {"reassoc", "contract", "nsz", "arcp"}
"""What sums may do to be taken eight terms at a time. NaN and infinity stay what they are."""
prange = numba.prange
"""A loop over threads; only inside a function that is `threaded`."""


def compiled(function: Function) -> Function:
    """Compile at the first call, keep the result on disk. No fastmath: a NaN must be seen, and the bits must be the
    same everywhere.
    """
    return _dispatcher(function, cache=True)


def compiled_inside(function: Function) -> Function:
    """For a few lines called from an inner loop: their machine code is put into the caller's, which saves counting
    references.
    """
    return _dispatcher(function, cache=True, forceinline=True)


def summed_inside(function: Function) -> Function:
    """The same for loops that are `summing`, with their arithmetic, for any caller."""
    return _dispatcher(function, cache=True, forceinline=True, fastmath=ANY_ORDER)


def threaded(function: Function) -> Function:
    """The same, with `prange` over threads."""
    if not isinstance(function, FunctionType) or numba.config.DISABLE_JIT:
        return function
    made: Any = Threaded(function, {"parallel": True}, cache=True)
    kept: Function = made
    return kept


class Threaded(Dispatcher):
    """A loop over threads. Compiled code that calls it is called from Python where `require_threads` was."""

    def __call__(self, *arguments: Any) -> Any:
        """Run it."""
        require_threads()
        return super().__call__(*arguments)


FEW = 4000
"""Loops over fewer particles than this end sooner than a second thread wakes up."""


_FORKED: list[int] = []
"""This process, if it was forked from one whose threads had started."""


def _note_fork() -> None:
    from numba.np.ufunc import parallel

    if getattr(parallel, "_is_initialized", False):
        _FORKED.append(os.getpid())


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_note_fork)


SEVERAL = 2000
"""Particles from which on a step of some model has loops over threads."""


def require_threads(particles: int = SEVERAL) -> None:
    """Raise RuntimeError in a process that was forked after threads had started, for as many particles as need threads:
    they do not exist there, and the library that waits for them ends the process, or waits for ever.
    """
    if _FORKED and particles >= SEVERAL:
        raise RuntimeError(
            "this process was forked from one that had started threads; start workers with "
            'multiprocessing.get_context("spawn"), or fork them before the first simulation'
        )


class Spread:
    """A loop that Python calls, compiled twice: for threads, and for systems too small for them.

    The last axis of the first argument is the size of the system, so that the choice, and with it the order of sums,
    does not depend on how many threads there are.
    """

    def __init__(self, function: FunctionType, **options: Any) -> None:
        self.alone = _dispatcher(function, cache=True, **options)
        if isinstance(self.alone, Dispatcher):
            self.alone._cache = AloneCache(function)
        self.together = _dispatcher(function, cache=True, parallel=True, **options)
        self.__doc__, self.__name__ = function.__doc__, function.__name__

    def __call__(self, array: Any, *arguments: Any) -> Any:
        """Run the one or the other."""
        if array.shape[-1] < FEW:
            return self.alone(array, *arguments)
        require_threads()
        return self.together(array, *arguments)


def spread(function: Function) -> Function:
    """A loop with `prange` over the particles of its first argument, for Python to call."""
    made: Any = Spread(cast(FunctionType, function))
    kept: Function = made
    return kept


def summing(function: Function) -> Function:
    """The same; sums inside may be taken in any order, always the same one."""
    made: Any = Spread(cast(FunctionType, function), fastmath=ANY_ORDER)
    kept: Function = made
    return kept


OTHERS = ("comprehension", "reduction", "inplace_binop", "setitem", "numpy", "stencil", "fusion")
PLAIN_LOOPS = dict.fromkeys(OTHERS, False)
"""Only loops that say so are spread over threads: what array expressions become takes a second each to compile."""


class Shared(Dispatcher):
    """A pass with `prange` that compiled code calls without threads, and Python with threads if the system is large."""

    def __init__(self, function: FunctionType, size: Callable[..., int]) -> None:
        super().__init__(function, {}, cache=True)
        self.size, self.together = size, Dispatcher(function, {"parallel": PLAIN_LOOPS}, cache=True)
        self.together._cache = TogetherCache(function)

    def __call__(self, *arguments: Any) -> Any:
        """Run the one or the other."""
        if self.size(*arguments) < FEW:
            return super().__call__(*arguments)
        require_threads()
        return self.together(*arguments)


def shared(size: Callable[..., int]) -> Callable[[Function], Function]:
    """Compile a pass for compiled code, for Python, and for threads; `size` derives the size from the arguments."""

    def decorate(function: Function) -> Function:
        if not isinstance(function, FunctionType) or numba.config.DISABLE_JIT:
            return function
        made: Any = Shared(function, size)
        kept: Function = made
        return kept

    return decorate


class Composed(Dispatcher):
    """What compiled code calls as a part, and Python runs as it stands: what it consists of is compiled by itself."""

    def __call__(self, *arguments: Any) -> Any:
        """Run the function."""
        return self.py_func(*arguments)


def composed(function: Function) -> Function:
    """A sequence of passes: compiled where few particles make it part of a whole, left to Python where there are many,
    so that each pass may be spread over threads.
    """
    if not isinstance(function, FunctionType) or numba.config.DISABLE_JIT:
        return function
    made: Any = Composed(function, {"inline": "always"}, cache=True)
    kept: Function = made
    return kept


def where_there(default: Any = None) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Compile a function of something that a scene may lack, its first argument: where that is an empty tuple, the
    answer is `default`, and nothing of the function is compiled.
    """

    def decorate(function: Callable[..., Any]) -> Callable[..., Any]:
        made = _dispatcher(function, cache=True)

        @functools.wraps(function)
        def there(subject: Any, *rest: Any) -> Any:
            return made(subject, *rest) if subject != () else default

        if made is not function:

            @numba.extending.overload(there, jit_options={**PART, "pipeline_class": Part}, strict=False)  # type: ignore[untyped-decorator]
            def version(subject: Any, *rest: Any) -> Any:
                missing = isinstance(subject, types.BaseTuple) and len(subject) == 0
                found = (lambda subject, *rest: default) if missing else (lambda subject, *rest: made(subject, *rest))
                # Code of other processes is linked by names.
                found.__qualname__ = (
                    f"{function.__module__}.{function.__qualname__}.{'missing' if missing else 'there'}"
                )
                return found

        return there

    return decorate


def by_type(choice: Callable[[type], Callable[..., Any]], place: int = -1) -> Callable[..., Any]:
    """A function that dispatches on the type of one argument, a NamedTuple: it calls `choice(type)`. Compiled code
    contains only the function that was chosen.
    """

    def chosen(*arguments: Any) -> Any:
        return choice(type(arguments[place]))(*arguments)

    if numba.config.DISABLE_JIT:
        return chosen
    CHOICES[chosen] = Choice(choice, f"argument {place}")

    @numba.extending.overload(chosen, jit_options={**PART, "forceinline": True, "pipeline_class": Part}, strict=False)  # type: ignore[untyped-decorator]
    def version(*arguments: Any) -> Any:
        if not isinstance(arguments[place], types.BaseNamedTuple):
            return None
        made = choice(arguments[place].instance_class)
        if not isinstance(made, FunctionType):
            # Arguments are named one by one: a tuple of large named tuples takes minutes to compile.
            return _written([f"return call_0({_names(len(arguments))})"], len(arguments), {"call_0": made})
        return in_single(made) if types.float32 in arguments and types.float64 not in arguments else made

    return chosen


class Selected(Dispatcher):
    """Stands for one of several compiled functions, by the type of its first argument. Compiled code calls the chosen
    function itself: a function in between would hand on hundreds of arrays, which takes long to compile.
    """

    def __init__(self, choice: Callable[[type], Any]) -> None:
        super().__init__(cast(FunctionType, lambda *arguments: None), {}, cache=False)
        self.choice = choice
        CHOICES[self] = Choice(choice, "argument 0")

    def __call__(self, *arguments: Any) -> Any:
        """Run the chosen function."""
        return self.choice(type(arguments[0]))(*arguments)

    def get_call_template(self, arguments: Any, keywords: Any) -> Any:
        """How compiled code calls the chosen function."""
        return self.choice(arguments[0].instance_class).get_call_template(arguments, keywords)

    def get_overload(self, signature: Any) -> Any:
        """What compiled code calls."""
        return self.choice(signature[0].instance_class).get_overload(signature)


def selected(choice: Callable[[type], Any]) -> Any:
    """The function `choice(type)` of the type of the first argument, a NamedTuple, where all choices are compiled
    functions.
    """
    if numba.config.DISABLE_JIT:
        return lambda *arguments: choice(type(arguments[0]))(*arguments)
    return Selected(choice)


def each_by_type(choice: Callable[[type], Callable[..., Any]]) -> Callable[..., None]:
    """A function of a tuple of parts, a tuple of as many workspaces, and further arguments, which calls
    `choice(type)(part, workspace, *arguments)` for each part in turn. Compiled code contains the chosen functions only.
    """

    def each(parts: Any, workspaces: Any, *arguments: Any) -> None:
        for part, own in zip(parts, workspaces, strict=True):
            choice(type(part))(part, own, *arguments)

    if numba.config.DISABLE_JIT:
        return each
    CHOICES[each] = Choice(choice, "parts")

    @numba.extending.overload(each, jit_options={**PART, "pipeline_class": Part}, strict=False)  # type: ignore[untyped-decorator]
    def version(parts: Any, workspaces: Any, *arguments: Any) -> Any:
        if not isinstance(parts, types.BaseTuple):
            return None
        found: dict[str, Any] = {f"call_{k}": choice(kind.instance_class) for k, kind in enumerate(parts)}
        rest = "".join(f", a{k + 2}" for k in range(len(arguments)))
        calls = [f"call_{k}(a0[{k}], a1[{k}]{rest})" for k in range(len(parts))]
        return _written(calls or ["pass"], len(arguments) + 2, found)

    return each


def _names(count: int) -> str:
    return ", ".join(f"a{k}" for k in range(count))


def _written(lines: list[str], count: int, found: dict[str, Any]) -> Any:
    """A function with these lines and `count` arguments a0, a1, ...; the names that it calls are those of `found`.

    Its own name says what it is: code of other processes is linked by names.
    """
    calls = [f"{one.__module__}.{one.__qualname__}" for one in found.values()]
    name = f"written_{hashlib.sha256(repr((lines, calls)).encode()).hexdigest()[:16]}"
    text = "\n    ".join([f"def {name}({_names(count)}):", *lines])
    exec(compile(text, __file__, "exec"), found)  # noqa: S102  # of the names above, nothing from outside
    return found[name]


def of_this_process(name: str, fields: Iterable[str]) -> Any:
    """A NamedTuple class that exists in this process only: code compiled for it is not written to the disk cache."""
    return collections.namedtuple(f"{UNKEPT}{name}", fields)


def compiled_once(function: Function) -> Function:
    """Compile for this process alone: for functions from the user, which no file of ecume can name."""
    return _dispatcher(function, cache=False)


def inlined(function: Function) -> Function:
    """A loop that takes functions: it is written out inside its caller, which names them and can be found in the
    cache.
    """
    made: Function = numba.njit(inline="always", error_model="numpy")(function)
    return made


def plainly(function: Function) -> Function:
    """A function that is `inlined` elsewhere, as Python runs it: for what it is given that cannot be compiled."""
    kept: Function = getattr(function, "py_func", function)
    return kept


def selection(
    name: str, laws: Mapping[int, Callable[..., Any]], module: str, file: str, takes: tuple[str, ...] = ()
) -> Any:
    """A function `name(x, code)` for loops that are `summing`: the law with this code at x.

    With `takes`, a function `name(*takes, code)` for all other loops: each argument of a law is one of these, by its
    name, or a field of the last of them.

    It is made from a table of laws, as source text with one branch for each row, so that no branch can be forgotten
    (`dataclasses` make `__init__` in the same way). A law that is passed as an argument or caught in a closure would be
    compiled again in each process; a function with the laws as its globals is cached on the disk like any other.
    `module` and `file` are those of the caller. The table must not change while the program runs.

    The last branch has no test of the code, since one more branch makes the compiler arrange each loop in another way,
    which rounds its sums differently: the caller refuses unknown codes before a loop begins.
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
    """The arguments of a law, as text: one of a selection's arguments each, or a field of the last of them."""
    if not takes:
        return "x"
    names = inspect.signature(law).parameters
    return ", ".join(one if one in takes else f"{takes[-1]}.{one}" for one in names)


def admit(*modules: ModuleType) -> None:
    """Let compiled code call the plain functions of these modules. A law itself never knows of Numba.

    Called with numbers in single precision only, a law has its constants in single precision, too: one literal would
    make the whole loop double.
    """
    if numba.config.DISABLE_JIT:
        return
    for module in modules:
        for law in vars(module).values():
            if isinstance(law, FunctionType) and law.__module__ == module.__name__:
                _admit_law(law)


def _admit_law(law: FunctionType) -> None:
    options = {**PART, "forceinline": True, "pipeline_class": Part}

    @numba.extending.overload(law, jit_options=options, strict=False)  # type: ignore[untyped-decorator]
    def version(*arguments: Any, **named: Any) -> FunctionType:
        kinds = {*arguments, *named.values()}
        return in_single(law) if types.float32 in kinds and types.float64 not in kinds else law


def in_single(law: FunctionType) -> FunctionType:
    """The law with single-precision constants, its own and those of its module."""
    code = law.__code__.replace(co_consts=tuple(map(_single, law.__code__.co_consts)))
    names = {name: _single(value) for name, value in law.__globals__.items()}
    defaults = tuple(map(_single, law.__defaults__ or ()))
    return FunctionType(code, names, law.__name__, defaults, law.__closure__)


def _single(value: Any) -> Any:
    return np.float32(value) if type(value) is float else value


@lower_builtin(math.sqrt, types.float32)  # type: ignore[untyped-decorator]
@lower_builtin(math.sqrt, types.float64)  # type: ignore[untyped-decorator]
def _square_root(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    """Numba calls the C library for `math.sqrt`, which keeps a loop from vectorizing; the processor's own gives the
    same bits.
    """
    intrinsic = builder.module.declare_intrinsic("llvm.sqrt", [arguments[0].type])
    return builder.call(intrinsic, arguments)


@numba.extending.type_callable(fused)  # type: ignore[untyped-decorator]
def _type_fused(context: Any) -> Callable[..., Any]:
    return lambda a, b, c: types.float32 if {a, b, c} == {types.float32} else types.float64


@lower_builtin(fused, types.float32, types.float32, types.float32)  # type: ignore[untyped-decorator]
@lower_builtin(fused, types.float64, types.float64, types.float64)  # type: ignore[untyped-decorator]
def _fused(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    """The processor's own; Numba would leave it to LLVM whether a product and a sum are rounded once or twice."""
    return builder.fma(*arguments)


@numba.extending.type_callable(lane_sum)  # type: ignore[untyped-decorator]
def _type_lane_sum(context: Any) -> Callable[..., Any]:
    return lambda values, count: types.float64 if isinstance(values, types.Array) else None


@lower_builtin(lane_sum, types.Array, types.Integer)  # type: ignore[untyped-decorator]
def _lane_sum(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    """Lanes are a vector, whatever the processor makes of one: the bits are the same."""
    kind = signature.args[0]
    data = context.make_array(kind)(context, builder, arguments[0]).data
    wide = ir.VectorType(ir.DoubleType(), LANES)
    total = cgutils.alloca_once_value(builder, ir.Constant(wide, [0.0] * LANES))
    blocks = builder.udiv(arguments[1], ir.Constant(arguments[1].type, LANES))
    with cgutils.for_range(builder, blocks) as loop:
        place = builder.gep(data, [builder.mul(loop.index, ir.Constant(loop.index.type, LANES))])
        narrow = ir.VectorType(context.get_data_type(kind.dtype), LANES)
        found = builder.load(place, typ=narrow, align=kind.dtype.bitwidth // 8)
        found = found if narrow == wide else builder.fpext(found, wide)
        builder.store(builder.fadd(builder.load(total, typ=wide), found), total)
    lanes = builder.load(total, typ=wide)
    each = [builder.extract_element(lanes, ir.Constant(ir.IntType(32), k)) for k in range(LANES)]
    while len(each) > 1:
        half = len(each) // 2
        each = [builder.fadd(each[k], each[k + half]) for k in range(half)]
    return each[0]


@numba.extending.type_callable(fill_columns)  # type: ignore[untyped-decorator]
def _type_fill_columns(context: Any) -> Callable[..., Any]:
    def typer(columns: Any, records: Any, neighbor: Any, place: Any, count: Any) -> Any:
        return types.none if isinstance(columns, types.Array) and columns.dtype == records.dtype else None

    return typer


@lower_builtin(fill_columns, types.Array, types.Array, types.Array, types.Integer, types.Integer)  # type: ignore[untyped-decorator]
def _fill_columns(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    """Blocks of neighbors, as many as numbers fit into a vector of this processor: whole records are loaded, and
    transposed in log2(block) rounds of exchanges between pairs of vectors.
    """
    kind = context.get_data_type(signature.args[0].dtype)
    columns, records, neighbor = (
        context.make_array(signature.args[k])(context, builder, arguments[k]) for k in range(3)
    )
    block = max(2, min(RECORD, _vector_bytes(context) * 8 // signature.args[0].dtype.bitwidth))
    wide, alignment, index = ir.VectorType(kind, block), signature.args[0].dtype.bitwidth // 8, ir.IntType(64)

    def number(value: int) -> Any:
        return ir.Constant(index, value)

    room = cgutils.unpack_tuple(builder, columns.shape)[1]
    length = cgutils.unpack_tuple(builder, neighbor.shape)[1]
    row = builder.gep(neighbor.data, [builder.mul(arguments[3], length)])
    with cgutils.for_range(builder, builder.udiv(arguments[4], number(block))) as loop:
        first = builder.mul(loop.index, number(block))
        slots = [builder.load(builder.gep(row, [builder.add(first, number(k))])) for k in range(block)]
        starts = [builder.mul(builder.zext(slot, index), number(RECORD)) for slot in slots]
        for part in range(0, RECORD, block):
            places = [builder.gep(records.data, [builder.add(start, number(part))]) for start in starts]
            vectors = [builder.load(place, typ=wide, align=alignment) for place in places]
            for column, vector in enumerate(_transposed(builder, vectors)):
                place = builder.gep(columns.data, [builder.add(builder.mul(number(part + column), room), first)])
                store = builder.store(vector, builder.bitcast(place, wide.as_pointer()))
                store.align = alignment
    return context.get_dummy_value()


def _transposed(builder: Any, vectors: list[Any]) -> list[Any]:
    """The transpose of so many vectors of as many elements, by exchanges at distances 1, 2, 4."""
    count, distance = len(vectors), 1
    while distance < count:
        upper = [k if not k & distance else count + k - distance for k in range(count)]
        lower = [k + distance if not k & distance else count + k for k in range(count)]
        masks = [ir.Constant(ir.VectorType(ir.IntType(32), count), mask) for mask in (upper, lower)]
        found = list(vectors)
        for k in range(count):
            if not k & distance:
                pair = vectors[k], vectors[k + distance]
                found[k], found[k + distance] = (builder.shuffle_vector(*pair, mask) for mask in masks)
        vectors, distance = found, 2 * distance
    return vectors


def _vector_bytes(context: Any) -> int:
    """The width of the vectors that are transposed: with AVX-512, too, blocks of 32 bytes are a little faster."""
    return 32 if context.codegen().magic_tuple()[1] in {"x86-64-v3", "x86-64-v4"} else 16


def use_threads(count: int | None) -> int:
    """Use that many threads from now on; all of the machine's when None. The result does not depend on it."""
    if count is not None:
        numba.set_num_threads(min(count, numba.config.NUMBA_NUM_THREADS))
    return int(numba.get_num_threads())


def _dispatcher(function: Function, *, cache: bool, **options: Any) -> Function:
    if not isinstance(function, FunctionType) or numba.config.DISABLE_JIT:
        return function
    made: Any = Dispatcher(function, options, cache)
    kept: Function = made
    return kept
