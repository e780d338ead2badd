"""What compiled code consists of, and where it lies on the disk.

Numba's disk cache has five traps, all closed here. It hashes only the file of the function itself, so that an edited
law in another file silently gives the old result: folders are named by all text that goes into a module's code (see
`_cache`). A truncated cache file raises from inside the unpickler: it is deleted and compiled again. A folder that
cannot be written is an error at import: a temporary folder stands in. A function loaded from it may call threads that
have not been started: they are started before anything is loaded.

Code is compiled for one of two levels of the x86-64 instruction set instead of for the processor at hand: version 4
(with AVX-512) where there is one, else version 3 (AVX2 and fused multiply-adds). All processors of a level then run the
same instructions, so that results do not depend on the model of the processor, at the same speed.
"""

from __future__ import annotations

import contextlib
import io
import logging
import os
import pickle
import platform
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import FunctionType
from typing import Any

import llvmlite
import llvmlite.binding
import numba
from numba.core import config, types
from numba.core.caching import CompileResultCacheImpl, FunctionCache, IndexDataCacheFile
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.compiler_machinery import PassManager
from numba.core.registry import CPUDispatcher

from ecume import _cache
from ecume._borrowing import borrowing

log = logging.getLogger(__name__)

LEVELS = {
    "x86-64-v4": ("avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"),
    "x86-64-v3": ("avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe"),
}
"""Levels of the x86-64 instruction set, the highest first, and what each adds to the one below."""


def instruction_set(features: Mapping[str, bool]) -> str | None:
    """The highest level that a processor with these features supports; None for others, such as Arm, or before 2013.

    >>> instruction_set(dict.fromkeys(LEVELS["x86-64-v3"], True))
    'x86-64-v3'
    """
    usable = [name for name, needed in LEVELS.items() if all(features.get(one) for one in needed + LEVELS["x86-64-v3"])]
    return usable[0] if usable else None


def compile_for_levels() -> None:
    """Have Numba compile for a level of the instruction set, unless NUMBA_CPU_NAME names a processor."""
    if config.CPU_NAME is None and config.CPU_FEATURES is None:
        level = instruction_set(llvmlite.binding.get_host_cpu_features())
        if level is not None:
            config.CPU_NAME, config.CPU_FEATURES = level, ""


compile_for_levels()

COMPILER = f"Numba {numba.__version__}, LLVM {llvmlite.__version__}, Python {platform.python_version()}"

UNKEPT = "OfThisProcess"
"""Prefix of the names of types that exist in one process only: code compiled for them is not cached on disk."""


class Place:
    """Where the code of a function lies on the disk, and the stamp that it must bear: Numba's locator."""

    def __init__(self, function: FunctionType, path: str) -> None:
        self._line = function.__code__.co_firstlineno
        self._py_file = path  # Numba names it where code cannot be cached
        self._folder = _cache.folder(Path(path).absolute(), COMPILER)

    @classmethod
    def from_function(cls, function: FunctionType, path: str) -> Place | None:
        """None where there is no file."""
        return cls(function, path) if Path(path).is_file() else None

    def ensure_cache_path(self) -> None:
        """There is a folder to write into, for its owner alone."""
        _cache.closed_to_others(self._folder)

    def get_cache_path(self) -> str:
        """The folder."""
        return str(self._folder)

    def get_source_stamp(self) -> str:
        """Of the text that the code comes from; part of the folder's name."""
        return self._folder.name

    def get_disambiguator(self) -> str:
        """Functions of one name differ in their lines."""
        return str(self._line)


class WholeFiles(CompileResultCacheImpl):  # type: ignore[misc]  # Numba's types are skipped: they are incomplete
    """Files in our folders."""

    _locator_classes = [Place]  # noqa: RUF012  # Numba's name


class OwnFiles(IndexDataCacheFile):  # type: ignore[misc]
    """The files of a function's code. What is unpickled is run, so that only files are read that no other user could
    have written; others are absent, and replaced.
    """

    def _load_index(self) -> Any:
        try:
            stream = io.BytesIO(_own_content(self._index_path))
        except OSError:
            return {}
        if pickle.load(stream) != self._version:  # noqa: S301  # from a file of this user
            return {}
        stamp, known = pickle.load(stream)  # noqa: S301  # from a file of this user
        return known if stamp == self._source_stamp else {}

    def _load_data(self, name: str) -> Any:
        return pickle.loads(_own_content(self._data_path(name)))  # noqa: S301  # from a file of this user

    @contextlib.contextmanager
    def _open_for_write(self, path: str) -> Iterator[Any]:
        with super()._open_for_write(path) as file:
            if hasattr(os, "fchmod"):
                os.fchmod(file.fileno(), os.fstat(file.fileno()).st_mode & ~0o022)
            yield file


def _own_content(path: str) -> bytes:
    """The content of a file. Raises OSError where another user can write to it, or wrote it."""
    with open(path, "rb") as file:  # noqa: PTH123  # Numba's paths are texts
        if fault := _cache.writable_for_others(os.fstat(file.fileno())):
            raise PermissionError(f"{path}: {fault}")
        return file.read()


class HealingCache(FunctionCache):  # type: ignore[misc]
    """A disk cache that treats whatever it cannot read as absent."""

    _impl_class = WholeFiles

    def __init__(self, function: FunctionType) -> None:
        super().__init__(function)
        stamp = self._impl.locator.get_source_stamp()
        self._cache_file = OwnFiles(self._cache_path, self._impl.filename_base, stamp)

    def load_overload(self, signature: Any, *arguments: Any) -> Any:
        if UNKEPT in str(signature):
            return None
        # Threads must run before code that calls them is linked. Numba sees to that where a function was compiled
        # together with its threaded parts; one made from parts of the disk would jump to nowhere.
        numba.get_num_threads()
        try:
            return super().load_overload(signature, *arguments)
        except Exception as error:  # a damaged pickle raises nearly anything
            log.warning("the compilation cache of %s was damaged (%s) and is built again", self._name, error)
            self.flush()
            return None

    def save_overload(self, signature: Any, *arguments: Any) -> None:
        if UNKEPT in str(signature):
            return
        try:
            super().save_overload(signature, *arguments)
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
        """Receives the address of the environment, and that of a part's in the wholes."""
        return Nowhere

    def serialize_using_object_code(self) -> Any:
        """There is no object code."""
        return self.serialize_using_bitcode()


class Nowhere:
    """Takes no environment."""

    @staticmethod
    def set_env(name: str, environment: Any) -> None:
        """Do nothing."""


class Borrowing(Compiler):  # type: ignore[misc]
    """Compiles without counting references to what arguments keep."""

    def define_pipelines(self) -> list[PassManager]:
        """The steps."""
        return [borrowing(steps) for steps in super().define_pipelines()]


class Part(Borrowing):
    """Compiles for compiled code."""

    def __init__(self, typing: Any, target: Any, library: Any, *rest: Any) -> None:
        super().__init__(typing, target, library or PartLibrary(target.codegen(), "part"), *rest)


@contextlib.contextmanager
def libraries_are_parts(codegen: Any) -> Iterator[None]:
    """Make every code library that is created inside this block a part."""
    kept, codegen._library_class = codegen._library_class, PartLibrary
    try:
        yield
    finally:
        codegen._library_class = kept


class Whole(Borrowing):
    """Compiles for Python, all parts included.

    The bodies of threaded loops are parts too. Numba would optimize and emit each of them by itself, and again inside
    the whole, under one name; the linker then runs the first one in the process that compiles and the second one in
    processes that read the disk. Where sums may be reordered, these two differ in their last bits.
    """

    def __init__(self, typing: Any, target: Any, library: Any, *rest: Any) -> None:
        if library is None:
            library = target.codegen().create_library("whole")
            library.enable_object_caching()
        super().__init__(typing, target, library, *rest)

    def compile_extra(self, function: Any) -> Any:
        """Compile the function with everything it calls; the parts get their environments."""
        with libraries_are_parts(self.state.targetctx.codegen()):
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
        process would find this first: a time step from parts of the disk was fourteen times slower than one read whole.
        """
        with libraries_are_parts(target.codegen()):
            return super().rebuild(target, payload)


class PartCache(HealingCache):
    """The disk cache of parts: a whole made later, such as time steps with a user's laws, finds them there."""

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
EXACT = {"fastmath": False}
"""Said of each part: where nothing is said, Numba takes it from who calls it first, and on the disk that lasts."""


class Dispatcher(CPUDispatcher):  # type: ignore[misc]
    """A compiled function: a whole where Python calls it, a part where compiled code does."""

    def __init__(self, function: FunctionType, options: dict[str, Any], cache: bool) -> None:
        super().__init__(function, targetoptions={**WHOLE, **options}, pipeline_class=Whole)
        self.part = CPUDispatcher(function, targetoptions={**PART, **EXACT, **options}, pipeline_class=Part)
        if cache:
            self._cache, self.part._cache = HealingCache(function), PartCache(function)

    def get_call_template(self, arguments: Any, keywords: Any) -> Any:
        """How compiled code calls it. A literal 0 in the caller is a number like any other, not a separate type
        with a separate compilation.
        """
        plain = tuple(types.unliteral(argument) for argument in arguments)
        return self.part.get_call_template(plain, {name: types.unliteral(kind) for name, kind in keywords.items()})

    def get_overload(self, signature: Any) -> Any:
        """What compiled code calls."""
        return self.part.get_overload(signature)
