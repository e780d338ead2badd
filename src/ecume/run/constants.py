"""The constants of a run: the numbers that its model derived from the scene when the run began.

Charges, tables, fits and the time step come from solvers and special functions of libraries, whose last digits depend
on the processor and on their versions. They are stored in `constants.npz` and restored when the run is resumed, so that
no constant changes in the middle of a run.

Only numbers are restored, into parameters that were derived again from the scene: floating-point numbers and arrays of
the same shape and type, and the number of steps per frame. All other values (counts, indices, choices) must be equal to
those from the scene; otherwise nothing is restored, and the run warns. Therefore this file cannot change anything but
numbers.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume._plain_files import opened
from ecume.errors import StorageError
from ecume.run.archives import Stored, arrays_of, with_present_names
from ecume.run.directory import RunDirectory, manifest_of
from ecume.trajectories.records import replacing, storing

STEPS = "steps_per_frame"
"""The only integer that may differ: it follows from the time step."""


class Restored(NamedTuple):
    """Parameters with the constants of a run, and a remark for its log."""

    parameters: Any
    remark: str
    kept: bool
    """Whether these are the stored constants of the run, and not derived again."""


def save_constants(home: RunDirectory, parameters: Any) -> str:
    """Write the constants of a run; return their digest."""
    with replacing(home.constants, home.path) as file:
        np.savez(file, allow_pickle=False, **_numbers(parameters))
    return digest(home)


def digest(home: RunDirectory) -> str:
    """The SHA-256 of the file of constants."""
    with storing(home.constants), opened(home.constants, "r", home.path) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def is_sound(home: RunDirectory) -> bool:
    """Whether the file of constants is unchanged; true for runs of former versions, which have no such file."""
    expected = manifest_of(home).get("constants_sha256")
    if expected is None:
        return True
    return home.constants.is_file() and digest(home) == expected


def require_sound_constants(home: RunDirectory) -> None:
    """Raise StorageError where the file is damaged or missing."""
    if not is_sound(home):
        raise StorageError(
            f"{home.constants}: damaged: it is not what the run began with; `ecume repair {home.path}` sets it aside, "
            "and the run then derives its constants again"
        )


def restored(home: RunDirectory, parameters: Any) -> Restored:
    """The parameters of a resumed run with the stored constants, given those derived from its scene. Raises
    StorageError if the file is damaged.
    """
    if manifest_of(home).get("constants_sha256") is None:
        return Restored(parameters, "derived again, since none are stored with the run", False)
    require_sound_constants(home)
    derived = _numbers(parameters)
    stored = with_present_names(_load(home), derived)
    if misfit := _misfit(stored, derived):
        return Restored(parameters, f"derived again: {misfit}", False)
    return Restored(_with(parameters, stored, ""), _drift(stored, derived), True)


def _load(home: RunDirectory) -> Stored:
    try:
        with opened(home.constants, "r", home.path) as file:
            return arrays_of(file, home.constants)
    except (OSError, ValueError) as error:
        raise StorageError(f"{home.constants}: damaged: {error}") from error


def _leaves(tree: Any, path: str) -> Iterator[tuple[str, Any]]:
    """The leaves of a tree of (named) tuples, each with its path: `floats.charge`, `gauges.0.reach`."""
    if not isinstance(tree, tuple):
        yield path, tree
        return
    for name, part in _parts(tree):
        yield from _leaves(part, f"{path}.{name}" if path else name)


def _parts(tree: tuple[Any, ...]) -> Iterator[tuple[str, Any]]:
    return zip(getattr(tree, "_fields", map(str, range(len(tree)))), tree, strict=True)


def _numbers(parameters: Any) -> Stored:
    """The numbers among the parameters, by their paths. Names and choices follow from the scene."""
    kinds = (np.ndarray, np.generic, bool, int, float, complex)
    return {path: np.asarray(leaf) for path, leaf in _leaves(parameters, "") if isinstance(leaf, kinds)}


def _misfit(stored: Mapping[str, NDArray[Any]], derived: Mapping[str, NDArray[Any]]) -> str:
    """The reason why stored constants do not fit this scene in this version; empty if they do."""
    for path in sorted({*stored, *derived}):
        if path not in stored or path not in derived:
            return f"{path} is {'not stored' if path not in stored else 'no constant of this version'}"
        one, other = stored[path], derived[path]
        if one.shape != other.shape or one.dtype != other.dtype:
            return f"{path} was stored as {one.dtype}{list(one.shape)} and is now {other.dtype}{list(other.shape)}"
        if not (_is_near(one, other) if _may_differ(path, one) else np.array_equal(one, other)):
            return f"{path} was stored with other values"
    positive = stored["time_step"] > 0.0 and stored[STEPS] >= 1
    return "" if positive else "the stored time step is not a positive number"


FARTHEST, ROUNDING = 0.5, 1e-3
"""The largest difference between a stored and a derived constant, relative to its value and to the largest of its
array. Other processors change last digits, and fits of them up to 3e-5; larger differences mean another scene.
"""


def _is_near(stored: NDArray[Any], derived: NDArray[Any]) -> bool:
    """Whether constants may be those of another processor: finite in the same elements, and of similar size."""
    finite = np.isfinite(derived)
    if not np.array_equal(np.isfinite(stored), finite) or not np.array_equal(stored[~finite], derived[~finite], True):
        return False
    with np.errstate(over="ignore"):
        own = np.abs(derived[finite])
        far = np.abs(stored[finite] - derived[finite]) > FARTHEST * own + ROUNDING * own.max(initial=0.0)
    return not far.any()


def _may_differ(path: str, stored: NDArray[Any]) -> bool:
    return stored.dtype.kind in "fc" or path == STEPS


def _with(tree: Any, stored: Stored, path: str) -> Any:
    """The tree with its numbers replaced by the stored ones."""
    if isinstance(tree, tuple):
        parts = [_with(part, stored, f"{path}.{name}" if path else name) for name, part in _parts(tree)]
        return type(tree)(*parts) if hasattr(tree, "_fields") else tuple(parts)
    if path not in stored or not _may_differ(path, stored[path]):
        return tree
    return _in_layout_of(tree, stored[path]) if isinstance(tree, np.ndarray) else type(tree)(stored[path][()])


def _in_layout_of(model: NDArray[Any], values: NDArray[Any]) -> NDArray[Any]:
    """The values as an array in the memory layout of the model's array, since compiled code distinguishes layouts like
    types.
    """
    if model.flags.c_contiguous or model.flags.f_contiguous:
        made = np.array(values, order="C" if model.flags.c_contiguous else "F")
    else:
        made = np.empty((*model.shape, 2), model.dtype)[..., 0]
        made[...] = values
    made.flags.writeable = model.flags.writeable
    return made


def _drift(stored: Stored, derived: Stored) -> str:
    """A phrase on the difference between constants derived here and those of the run; empty without a difference."""
    differing = [path for path in stored if stored[path].tobytes() != derived[path].tobytes()]
    if not differing:
        return ""
    size, path = max((_relative(stored[path], derived[path]), path) for path in differing)
    share = f"{len(differing)} of {len(stored)}"
    return f"kept; derived here, {share} would differ, {path} most: by {size:.1e} of its largest value"


def _relative(one: NDArray[Any], other: NDArray[Any]) -> float:
    """The largest difference of two arrays over their largest value; values that are not finite in both are ignored."""
    finite = np.isfinite(one) & np.isfinite(other)
    scale = float(np.abs(one[finite]).max(initial=0.0))
    with np.errstate(over="ignore"):
        largest = float(np.abs(one[finite] - other[finite]).max(initial=0.0))
    return largest / scale if scale > 0.0 else largest
