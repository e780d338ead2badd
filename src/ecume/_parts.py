"""The units of compiled code and their storage on disk.

Numba's disk cache has five defects, which this cache avoids. (1) It hashes only the file of the function itself, so
that after a change of a law in another file the old result is used; here the names of files depend on all code that
they contain (see `_dependencies`). (2) A truncated cache file raises an exception in the unpickler; here the function
is compiled again. (3) A folder without write permission is an error at import; here it is replaced by a temporary
folder. (4) A function that is loaded from the cache may call threads that have not been started; here they are started
before loading. (5) Two processes that write to one index may lose an entry; here there is no index.

Code is compiled for one of two levels of the x86-64 instruction set instead of the present processor: version 4 (with
AVX-512) if supported, otherwise version 3 (AVX2 and fused multiply-adds). All processors of a level then run the same
instructions, so that results do not depend on the model of the processor, at the same speed.
"""

from __future__ import annotations

import contextlib
import logging
import pickle
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from types import FunctionType
from typing import Any

import llvmlite
import llvmlite.binding
import numba
import numba.extending
from numba.core import config, types
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, CompileResult
from numba.core.compiler_machinery import PassManager
from numba.core.registry import CPUDispatcher
from numba.core.serialize import dumps
from numba.core.targetconfig import TargetConfig

from ecume import _cache
from ecume._borrowing import borrowing
from ecume._dependencies import PACKAGE, UNKEPT, digest, text_digest, text_of

log = logging.getLogger(__name__)

LEVELS = {
    "x86-64-v4": ("avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"),
    "x86-64-v3": ("avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe"),
}
"""The levels of the x86-64 instruction set, the highest first, with the instructions that each adds."""


def instruction_set(features: Mapping[str, bool]) -> str | None:
    """The highest level that a processor with these features supports; None for others, such as Arm, or before 2013.

    >>> instruction_set(dict.fromkeys(LEVELS["x86-64-v3"], True))
    'x86-64-v3'
    """
    usable = [name for name, needed in LEVELS.items() if all(features.get(one) for one in needed + LEVELS["x86-64-v3"])]
    return usable[0] if usable else None


def compile_for_levels() -> None:
    """Make Numba compile for a level of the instruction set, unless NUMBA_CPU_NAME names a processor."""
    if config.CPU_NAME is None and config.CPU_FEATURES is None:
        level = instruction_set(llvmlite.binding.get_host_cpu_features())
        if level is not None:
            config.CPU_NAME, config.CPU_FEATURES = level, ""


compile_for_levels()

COMPILER = f"Numba {numba.__version__}, LLVM {llvmlite.__version__}, {sys.implementation.cache_tag}{sys.abiflags}, " + (
    text_digest(
        PACKAGE / f"_{name}.py" for name in ("borrowing", "columns", "fused", "jit", "lowering", "parts", "variants")
    )
)
"""The versions that determine the machine code. All Pythons of one minor version have the same bytecode."""


def named_tuples(kinds: Iterable[Any]) -> Iterator[type]:
    """The classes of all named tuples in types, and in their items."""
    for kind in kinds:
        if isinstance(kind, types.BaseNamedTuple):
            yield kind.instance_class
        if isinstance(kind, types.BaseTuple):
            yield from named_tuples(kind)


class DiskCache:
    """The cache of the compiled code of one function on disk, as used by Numba's dispatchers. Unreadable files count as
    missing.
    """

    kind = "whole"
    """The parts of the same function have other code."""

    def __init__(self, function: FunctionType, options: Mapping[str, Any]) -> None:
        self._function = function
        self._options = text_of(options)
        self._name = f"{self.kind}-{function.__module__}.{function.__qualname__}".translate({60: None, 62: None})

    @property
    def cache_path(self) -> str:
        """The cache folder of the user."""
        return str(_cache.root())

    def flush(self) -> None:
        """Do nothing, since outdated files are never found."""

    def file_name(self, signature: Any, target: Any) -> str | None:
        """The name of the file with the code for arguments of these types, or None if no other process can use this
        code.
        """
        kinds = getattr(signature, "args", signature)
        text = str(kinds)
        if UNKEPT in text or " at 0x" in text:  # Numba describes functions among the arguments by their addresses
            return None
        classes = list(named_tuples(kinds))
        names = [f"{one.__module__}.{one.__qualname__}" for one in classes]
        beginning = f"{COMPILER} {target.magic_tuple()} {self._name} {self._options} {text} {names}"
        key = digest(self._function, classes, beginning)
        return f"{self._name}-{key}{_cache.SUFFIX}"

    def load_overload(self, signature: Any, target: Any) -> Any:
        """The result of an earlier compilation; None if missing."""
        target.refresh()
        name = self.file_name(signature, target.codegen())
        if name is None:
            return None
        # Threads must run before code that calls them is linked. Numba starts them if a function was compiled together
        # with its threaded parts; one linked from parts on disk would jump to an invalid address.
        numba.get_num_threads()
        try:
            data = _cache.read(name)
            return None if data is None else self.rebuilt(target, pickle.loads(data))  # noqa: S301  # see SECURITY.md
        except Exception as error:  # a damaged pickle raises nearly anything
            log.warning("the compilation cache of %s was damaged (%s) and is built again", self._name, error)
            return None

    def save_overload(self, signature: Any, result: Any) -> None:
        """Store the result of a compilation."""
        name = self.file_name(signature, result.codegen)
        if name is None or result.lifted or result.library.has_dynamic_globals:
            return
        try:
            _cache.write(name, dumps(self.reduced(result)))
        except OSError as error:  # full disk
            log.warning("the compilation cache of %s could not be written: %s", self._name, error)

    def reduced(self, result: Any) -> Any:
        """The data to store: the machine code of a whole, and the names in the library that Numba keeps for later
        linking, which is never done.
        """
        (name, form, (code, bitcode)), *rest = result._reduce()
        return (name, form, (code, names_alone(llvmlite.binding.parse_bitcode(bitcode)))), *rest

    def rebuilt(self, target: Any, stored: Any) -> Any:
        """The result of a compilation, from stored data."""
        return CompileResult._rebuild(target, *stored)


def names_alone(module: Any) -> bytes:
    """The bitcode of a module that defines the same names, without their contents."""
    functions = [one.name for one in module.functions if not one.is_declaration]
    values = [one.name for one in module.global_variables if not one.is_declaration]
    lines = [f'define void @"{name}"() {{ ret void }}' for name in functions]
    lines += [f'@"{name}" = global i8 0' for name in values]
    bitcode: bytes = llvmlite.binding.parse_assembly("\n".join(lines)).as_bitcode()
    return bitcode


def _hash_of_type(options: Any) -> int:
    return hash(type(options))


# Numba hashes options by their names, which are those of the class, and looks up all of them each time, which took one
# twentieth of the compilation time.
TargetConfig.__hash__ = _hash_of_type


# Numba optimizes and emits every function again in each of its direct and indirect callers: for calls nested eight
# deep, most of a compilation was repeated work. Here a called function is a part: it is typed and lowered once, and
# optimized only in the function that Python calls.


class WholeLibrary(JITCodeLibrary):  # type: ignore[misc]  # Numba's types are skipped: they are incomplete
    """A library of code that Python runs."""

    def _optimize_functions(self, module: Any) -> None:
        """Optimize each function that is defined here; Numba would spend the same time on functions that are only
        declared.
        """
        module.data_layout = self._codegen._data_layout
        for function in module.functions:
            if not function.is_declaration:
                passes, builder = self._codegen._function_pass_manager()
                passes.run(function, builder)


class PartLibrary(JITCodeLibrary):  # type: ignore[misc]
    """A library of compiled code that is linked into larger libraries and never executed itself; it is not optimized
    before it is linked.
    """

    def _optimize_functions(self, module: Any) -> None:
        module.data_layout = self._codegen._data_layout

    def _optimize_final_module(self) -> None:
        pass

    def _finalize_final_module(self) -> None:
        # Parts are not searched for addresses of this process, which prevent storing code: most of them vanish by
        # optimization, and the optimized function is searched for the others.
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """The null address, since Python never calls a part."""
        self._ensure_finalized()
        return 0

    @property
    def codegen(self) -> Any:
        """An object that accepts and ignores the address of the environment, and in wholes those of parts."""
        return Nowhere

    def serialize_using_object_code(self) -> Any:
        """Return nothing, since a part has no object code."""
        return self.serialize_using_bitcode()


class Nowhere:
    """An object that ignores environments."""

    @staticmethod
    def set_env(name: str, environment: Any) -> None:
        """Do nothing."""


class Borrowing(Compiler):  # type: ignore[misc]
    """A compiler that does not count references to values that the arguments keep alive."""

    def define_pipelines(self) -> list[PassManager]:
        """The passes of the compilation."""
        return [borrowing(steps) for steps in super().define_pipelines()]


class Part(Borrowing):
    """A compiler of functions that only compiled code calls."""

    def __init__(self, typing: Any, target: Any, library: Any, *rest: Any) -> None:
        super().__init__(typing, target, library or PartLibrary(target.codegen(), "part"), *rest)


@contextlib.contextmanager
def libraries_are_parts(codegen: Any) -> Iterator[None]:
    """A context in which every new code library is a part."""
    kept, codegen._library_class = codegen._library_class, PartLibrary
    try:
        yield
    finally:
        codegen._library_class = kept


class Whole(Borrowing):
    """A compiler of functions that Python calls, including all parts.

    The bodies of threaded loops are parts as well. Numba would optimize and emit each of them separately, and again
    inside the whole, with the same name. The linker would then use the first version in the compiling process and the
    second one in processes that load the code from disk. If sums may be reordered, the two versions differ in the last
    bits.
    """

    def __init__(self, typing: Any, target: Any, library: Any, *rest: Any) -> None:
        if library is None:
            library = WholeLibrary(target.codegen(), "whole")
            library.enable_object_caching()
        super().__init__(typing, target, library, *rest)

    def compile_extra(self, function: Any) -> Any:
        """Compile the function with all functions that it calls, and pass environments to the parts."""
        with libraries_are_parts(self.state.targetctx.codegen()):
            result = super().compile_extra(function)
        for environment in result._find_referenced_environments():
            result.codegen.set_env(environment.env_name, environment)
        return result


class PartCache(DiskCache):
    """The disk cache of parts, in which wholes that are made later, such as time steps with user laws, find them."""

    kind = "part"

    def reduced(self, result: Any) -> Any:
        """The data to store: code for linking."""
        return result._reduce()

    def rebuilt(self, target: Any, stored: Any) -> Any:
        """The stored code as a part to be linked. If it were prepared for execution, as Numba does, code that is
        compiled later in the same process would call it without inlining, which was fourteen times slower.
        """
        with libraries_are_parts(target.codegen()):
            return super().rebuilt(target, stored)


WHOLE = {"nopython": True, "nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True}
PART = {**WHOLE, "no_cpython_wrapper": True}
EXACT = {"fastmath": False}
"""The flags of each part. Without them, Numba would apply those of the first caller, also to the code on disk."""


def overload(function: Any, **options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Register a function that selects, by the types of the arguments, the implementation of `function` in compiled
    code.
    """
    jit_options = {**PART, "pipeline_class": Part, **options}
    register: Callable[[Callable[..., Any]], Any] = numba.extending.overload(
        function, jit_options=jit_options, strict=False
    )
    return register


class Dispatcher(CPUDispatcher):  # type: ignore[misc]
    """A compiled function: a whole if Python calls it, a part if compiled code does."""

    def __init__(self, function: FunctionType, options: dict[str, Any], cache: bool) -> None:
        own, inside = {**WHOLE, **options}, {**PART, **EXACT, **options}
        super().__init__(function, targetoptions=own, pipeline_class=Whole)
        self.part = CPUDispatcher(function, targetoptions=inside, pipeline_class=Part)
        if cache:
            self._cache, self.part._cache = DiskCache(function, own), PartCache(function, inside)

    def get_call_template(self, arguments: Any, keywords: Any) -> Any:
        """The template by which compiled code calls the function. A literal 0 as an argument is typed as a number, so
        that it causes no second compilation.
        """
        plain = tuple(types.unliteral(argument) for argument in arguments)
        return self.part.get_call_template(plain, {name: types.unliteral(kind) for name, kind in keywords.items()})

    def get_overload(self, signature: Any) -> Any:
        """The implementation that compiled code calls."""
        return self.part.get_overload(signature)
