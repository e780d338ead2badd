"""How loops are compiled: the only file that imports Numba.

Numba's disk cache has four traps, all closed here. It hashes only the file of the function itself, so that an edited
law in another file silently gives the old result: folders are named by all text that goes into a module's code (see
`_cache`). A truncated cache file raises from inside the unpickler: it is thrown away and compiled anew. A folder that
cannot be written is an error at import: a temporary folder stands in. A function loaded from it may call threads that
nobody started: they are started before anything is loaded.
"""

from __future__ import annotations

import functools
import logging
import math
import os
import platform
from collections.abc import Callable
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any, TypeVar, cast

import llvmlite
import numba
import numba.extending
import numpy as np
from numba.core import types
from numba.core.caching import CompileResultCacheImpl, FunctionCache
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.imputils import lower_builtin
from numba.core.registry import CPUDispatcher

from ecume import _cache

# Threads that wait for their next loop by spinning keep whoever else computes here from going on, and are kept from it
# themselves: on a busy machine loops over a few thousand particles took five times as long. Read when they start.
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")

Function = TypeVar("Function", bound=Callable[..., Any])
log = logging.getLogger(__name__)


COMPILER = f"Numba {numba.__version__}, LLVM {llvmlite.__version__}, Python {platform.python_version()}"


class Place:
    """Where the code of a function lies on the disk, and the stamp that it must bear: Numba's locator."""

    def __init__(self, function: FunctionType, path: str) -> None:
        self._line = function.__code__.co_firstlineno
        self._folder = _cache.folder(Path(path).absolute(), COMPILER)

    @classmethod
    def from_function(cls, function: FunctionType, path: str) -> Place | None:
        """None where there is no file."""
        return cls(function, path) if Path(path).is_file() else None

    def ensure_cache_path(self) -> None:
        """There is a folder to write into."""
        self._folder.mkdir(parents=True, exist_ok=True)

    def get_cache_path(self) -> str:
        """The folder."""
        return str(self._folder)

    def get_source_stamp(self) -> str:
        """Of the text that the code comes from; part of the folder's name."""
        return self._folder.name

    def get_disambiguator(self) -> str:
        """Functions of one name differ in their lines."""
        return str(self._line)


class WholeFiles(CompileResultCacheImpl):  # type: ignore[misc]  # Numba's types are left out: they are half there
    """Files in our folders."""

    _locator_classes = [Place]  # noqa: RUF012  # Numba's name


class HealingCache(FunctionCache):  # type: ignore[misc]
    """A disk cache that treats whatever it cannot read as absent."""

    _impl_class = WholeFiles

    def load_overload(self, *arguments: Any) -> Any:
        # Threads must run before code that calls them is linked. Numba sees to that where a function was compiled
        # together with its threaded parts; one made from parts of the disk would jump to nowhere.
        numba.get_num_threads()
        try:
            return super().load_overload(*arguments)
        except Exception as error:  # a damaged pickle raises nearly anything
            log.warning("the compilation cache of %s was damaged (%s) and is made anew", self._name, error)
            self.flush()
            return None

    def save_overload(self, *arguments: Any) -> None:
        try:
            super().save_overload(*arguments)
        except (OSError, EOFError, ValueError) as error:  # full disk, or a damaged index
            log.warning("the compilation cache of %s could not be written: %s", self._name, error)
        except Exception as error:  # the index is a pickle too
            log.warning("the compilation cache of %s was damaged (%s)", self._name, error)
            self.flush()


# Numba optimizes and emits every function, and again inside each of its callers, and theirs: with calls nested eight
# deep most of a compilation was the same work done over. Here what compiled code calls is a part: typed and lowered
# once, and optimized where it ends up, in the whole that Python calls.


class PartLibrary(JITCodeLibrary):  # type: ignore[misc]
    """Code that is never run where it stands, only linked into wholes: it is left as it was lowered."""

    def _optimize_functions(self, module: Any) -> None:
        module.data_layout = self._codegen._data_layout

    def _optimize_final_module(self) -> None:
        pass

    def _finalize_final_module(self) -> None:
        # No search for addresses of this process, which keep code from the disk: most are gone once a whole is
        # optimized, and the whole looks for those that are left.
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """Nowhere: Python does not call a part."""
        self._ensure_finalized()
        return 0

    @property
    def codegen(self) -> Any:
        """Is told where the environment lies, and a part's lies in the wholes."""
        return Nowhere

    def serialize_using_object_code(self) -> Any:
        """There is no object code."""
        return self.serialize_using_bitcode()


class Nowhere:
    """Takes no environment."""

    @staticmethod
    def set_env(name: str, environment: Any) -> None:
        """Do nothing."""


class Part(Compiler):  # type: ignore[misc]
    """Compiles for compiled code."""

    def __init__(self, typing: Any, target: Any, library: Any, *rest: Any) -> None:
        super().__init__(typing, target, library or PartLibrary(target.codegen(), "part"), *rest)


class Whole(Compiler):  # type: ignore[misc]
    """Compiles for Python, all parts included."""

    def compile_extra(self, function: Any) -> Any:
        """As ever; and the parts get their environments."""
        result = super().compile_extra(function)
        for environment in result._find_referenced_environments():
            result.codegen.set_env(environment.env_name, environment)
        return result


class PartFiles(WholeFiles):
    """Files of their own: the same function's whole has other code."""

    def get_filename_base(self, name: str, flags: str) -> str:
        """The beginning of the files' names."""
        return f"part-{super().get_filename_base(name, flags)}"

    def rebuild(self, target: Any, payload: Any) -> Any:
        """As code to be linked. Numba would make it ready to run as it stands, and what is compiled later in the same
        process would find this first: a march from parts of the disk was fourteen times slower than one read whole.
        """
        codegen = target.codegen()
        kept, codegen._library_class = codegen._library_class, PartLibrary
        try:
            return super().rebuild(target, payload)
        finally:
            codegen._library_class = kept


class PartCache(HealingCache):
    """The disk cache of parts: a whole made later, such as a march with a user's laws, finds them there."""

    _impl_class = PartFiles


class TogetherFiles(WholeFiles):
    """The same function with threads."""

    def get_filename_base(self, name: str, flags: str) -> str:
        """The beginning of the files' names."""
        return f"together-{super().get_filename_base(name, flags)}"


class TogetherCache(HealingCache):
    """The disk cache of what compiled code calls without threads."""

    _impl_class = TogetherFiles


class AloneFiles(WholeFiles):
    """The same function without threads."""

    def get_filename_base(self, name: str, flags: str) -> str:
        """The beginning of the files' names."""
        return f"alone-{super().get_filename_base(name, flags)}"


class AloneCache(HealingCache):
    """The disk cache of loops that are compiled for threads as well."""

    _impl_class = AloneFiles


WHOLE = {"nopython": True, "nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True}
PART = {**WHOLE, "no_cpython_wrapper": True}


class Dispatcher(CPUDispatcher):  # type: ignore[misc]
    """A compiled function: a whole where Python calls it, a part where compiled code does."""

    def __init__(self, function: FunctionType, options: dict[str, Any], cache: bool) -> None:
        super().__init__(function, targetoptions={**WHOLE, **options}, pipeline_class=Whole)
        self.part = CPUDispatcher(function, targetoptions={**PART, **options}, pipeline_class=Part)
        if cache:
            self._cache, self.part._cache = HealingCache(function), PartCache(function)

    def get_call_template(self, arguments: Any, keywords: Any) -> Any:
        """How compiled code calls it. A 0 that stands in the caller is a number like any other, not a type of its own
        with a compilation of its own.
        """
        plain = tuple(types.unliteral(argument) for argument in arguments)
        return self.part.get_call_template(plain, {name: types.unliteral(kind) for name, kind in keywords.items()})

    def get_overload(self, signature: Any) -> Any:
        """What compiled code calls."""
        return self.part.get_overload(signature)


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


def threaded(function: Function) -> Function:
    """The same, with `prange` over threads."""
    return _dispatcher(function, cache=True, parallel=True)


FEW = 4000
"""Loops over fewer particles than this end sooner than a second thread wakes up."""
ANY_ORDER = {"reassoc", "contract", "nsz", "arcp"}
"""What sums may do to be taken eight terms at a time. NaN and infinity stay what they are."""


class Spread:
    """A loop that Python calls, compiled twice: for threads, and for crowds too small for them.

    The last axis of the first argument says how large the crowd is, so that the choice, and with it the order of sums,
    does not depend on how many threads there are.
    """

    def __init__(self, function: FunctionType, **options: Any) -> None:
        self.alone = _dispatcher(function, cache=True, **options)
        if isinstance(self.alone, Dispatcher):
            self.alone._cache = AloneCache(function)
        self.together = _dispatcher(function, cache=True, parallel=True, **options)
        self.__doc__, self.__name__ = function.__doc__, function.__name__

    def __call__(self, crowd: Any, *arguments: Any) -> Any:
        """Run the one or the other."""
        return (self.alone if crowd.shape[-1] < FEW else self.together)(crowd, *arguments)


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
    """A pass with `prange` that compiled code calls without threads, and Python with them where the crowd is large."""

    def __init__(self, function: FunctionType, crowd: Callable[..., int]) -> None:
        super().__init__(function, {}, cache=True)
        self.crowd, self.together = crowd, Dispatcher(function, {"parallel": PLAIN_LOOPS}, cache=True)
        self.together._cache = TogetherCache(function)

    def __call__(self, *arguments: Any) -> Any:
        """Run the one or the other."""
        if self.crowd(*arguments) < FEW:
            return super().__call__(*arguments)
        return self.together(*arguments)


def shared(crowd: Callable[..., int]) -> Callable[[Function], Function]:
    """Compile a pass for compiled code, for Python, and for threads; `crowd` tells its size from its arguments."""

    def decorate(function: Function) -> Function:
        if not isinstance(function, FunctionType) or numba.config.DISABLE_JIT:
            return function
        made: Any = Shared(function, crowd)
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
    made: Any = Composed(function, {}, cache=True)
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
                return (lambda subject, *rest: default) if missing else (lambda subject, *rest: made(subject, *rest))

        return there

    return decorate


def compiled_once(function: Function) -> Function:
    """Compile for this process alone: for what a user hands over, which no file of ours can name."""
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
