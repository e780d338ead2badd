"""How loops are compiled: the only file that imports Numba.

Numba's disk cache has three traps, all closed here. It hashes only the file of the function itself, so that an edited
law in another file silently gives the old result: the cache folder is named by a hash of the whole package's text. A
truncated cache file raises from inside the unpickler: it is thrown away and compiled anew. A folder that cannot be
written is an error at import: a temporary folder stands in.
"""

from __future__ import annotations

import hashlib
import logging
import math
import os
import platform
import tempfile
from collections.abc import Callable
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any, TypeVar

import numba
import numba.extending
import platformdirs
from numba.core import types
from numba.core.caching import FunctionCache
from numba.core.imputils import lower_builtin

Function = TypeVar("Function", bound=Callable[..., Any])
log = logging.getLogger(__name__)


def package_digest() -> str:
    """Changes whenever a line of the package, Numba's version or the processor changes."""
    digest = hashlib.sha256(f"{numba.__version__} {platform.python_version()} {platform.processor()}".encode())
    for path in sorted(Path(__file__).parent.rglob("*.py")):
        digest.update(path.as_posix().encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def cache_folder() -> Path:
    """Where compiled code is kept: private to the user, since whoever writes there can make us run anything."""
    asked = os.environ.get("ECUME_CACHE_DIR")
    folder = (Path(asked) if asked else Path(platformdirs.user_cache_dir("ecume"))) / package_digest()
    try:
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except OSError:
        return Path(tempfile.mkdtemp(prefix="ecume-"))


class HealingCache(FunctionCache):  # type: ignore[misc]  # Numba's types are left out: they are half there
    """A disk cache that treats whatever it cannot read as absent."""

    def load_overload(self, *arguments: Any) -> Any:
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


numba.config.CACHE_DIR = str(cache_folder())

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


def compiled_once(function: Function) -> Function:
    """Compile for this process alone: for what a user hands over, which no file of ours can name."""
    return _dispatcher(function, cache=False)


def inlined(function: Function) -> Function:
    """A loop that takes functions: it is written out inside its caller, which names them and can be found in the
    cache.
    """
    made: Function = numba.njit(inline="always", error_model="numpy")(function)
    return made


def admit(*modules: ModuleType) -> None:
    """Let compiled code call the plain functions of these modules. A law itself never knows of Numba."""
    if numba.config.DISABLE_JIT:
        return
    for module in modules:
        for law in vars(module).values():
            if isinstance(law, FunctionType) and law.__module__ == module.__name__:
                numba.extending.register_jitable(error_model="numpy", forceinline=True)(law)


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


def _dispatcher(function: Function, *, cache: bool, **options: bool) -> Function:
    made = numba.njit(error_model="numpy", nogil=True, **options)(function)
    if cache and isinstance(function, FunctionType) and not numba.config.DISABLE_JIT:
        made._cache = HealingCache(function)
    kept: Function = made
    return kept
