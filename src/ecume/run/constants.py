"""The constants of a run: what its model derived from the scene when the run began.

Charges, tables, fits and the time step come from solvers and special functions of libraries, whose last digits depend
on the processor and on their versions. They are kept in `constants.npz` and read back when the run is resumed, so that
no constant changes in the middle of a run.

Only numbers are read back, into parameters that were derived again from the scene: floating-point numbers and arrays
of the same shape and type, and the number of steps per frame. Everything else (counts, indices, choices) must be what
the scene gives, or nothing is read back at all, and the run warns. So this file can change numbers, and nothing else.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume._plain_files import opened
from ecume.errors import StorageError
from ecume.run.checkpoints import arrays_of
from ecume.run.directory import RunDirectory, manifest_of
from ecume.trajectories.records import replacing, storing

STEPS = "steps_per_frame"
"""The one whole number that follows from rounded ones: it belongs to the time step."""

Stored = dict[str, NDArray[Any]]


class Restored(NamedTuple):
    """Parameters with the constants of a run, and what is worth recording about it."""

    parameters: Any
    remark: str
    kept: bool
    """Whether they are the run's own constants, and not derived again."""


def save(home: RunDirectory, parameters: Any) -> str:
    """Write the constants of a run; their digest."""
    with replacing(home.constants, home.path) as file:
        np.savez(file, allow_pickle=False, **_numbers(parameters))
    return digest(home)


def digest(home: RunDirectory) -> str:
    """The SHA-256 of the file."""
    with storing(home.constants), opened(home.constants, "r", home.path) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def is_sound(home: RunDirectory) -> bool:
    """Whether the file is as it was written. A run of a former version has none, and that is sound, too."""
    expected = manifest_of(home).get("constants_sha256")
    if expected is None:
        return True
    return home.constants.is_file() and digest(home) == expected


def require_sound(home: RunDirectory) -> None:
    """Raise StorageError where the file is damaged or missing."""
    if not is_sound(home):
        raise StorageError(
            f"{home.constants}: damaged: it is not what the run began with; `ecume repair {home.path}` sets it aside, "
            "and the run then derives its constants again"
        )


def restored(home: RunDirectory, parameters: Any) -> Restored:
    """The parameters of a run that is resumed, given those derived from its scene just now. Raises StorageError where
    the file is damaged.
    """
    if manifest_of(home).get("constants_sha256") is None:
        return Restored(parameters, "derived again, since none are stored with the run", False)
    require_sound(home)
    stored = _load(home)
    if misfit := _misfit(stored, _numbers(parameters)):
        return Restored(parameters, f"derived again: {misfit}", False)
    return Restored(_with(parameters, stored, ""), _drift(stored, _numbers(parameters)), True)


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
    """The numbers among the parameters. Names, choices and nothing at all are not: they follow from the scene."""
    kinds = (np.ndarray, np.generic, bool, int, float, complex)
    return {path: np.asarray(leaf) for path, leaf in _leaves(parameters, "") if isinstance(leaf, kinds)}


def _misfit(stored: Mapping[str, NDArray[Any]], derived: Mapping[str, NDArray[Any]]) -> str:
    """Why stored constants are not those of this scene in this version, or an empty string."""
    for path in sorted({*stored, *derived}):
        if path not in stored or path not in derived:
            return f"{path} is {'not stored' if path not in stored else 'no constant of this version'}"
        one, other = stored[path], derived[path]
        if one.shape != other.shape or one.dtype != other.dtype:
            return f"{path} was stored as {one.dtype}{list(one.shape)} and is now {other.dtype}{list(other.shape)}"
        if not _may_differ(path, one) and not np.array_equal(one, other):
            return f"{path} was stored with other values"
    positive = stored["time_step"] > 0.0 and np.isfinite(stored["time_step"]) and stored[STEPS] >= 1
    return "" if positive else "the stored time step is not a positive number"


def _may_differ(path: str, stored: NDArray[Any]) -> bool:
    return stored.dtype.kind in "fc" or path == STEPS


def _with(tree: Any, stored: Stored, path: str) -> Any:
    """The tree with its numbers replaced by the stored ones."""
    if isinstance(tree, tuple):
        parts = [_with(part, stored, f"{path}.{name}" if path else name) for name, part in _parts(tree)]
        return type(tree)(*parts) if hasattr(tree, "_fields") else tuple(parts)
    if path not in stored or not _may_differ(path, stored[path]):
        return tree
    return _laid_out_as(tree, stored[path]) if isinstance(tree, np.ndarray) else type(tree)(stored[path][()])


def _laid_out_as(model: NDArray[Any], values: NDArray[Any]) -> NDArray[Any]:
    """The values in an array of the model's memory layout: compiled code distinguishes layouts as it does types."""
    if model.flags.c_contiguous or model.flags.f_contiguous:
        made = np.array(values, order="C" if model.flags.c_contiguous else "F")
    else:
        made = np.empty((*model.shape, 2), model.dtype)[..., 0]
        made[...] = values
    made.flags.writeable = model.flags.writeable
    return made


def _drift(stored: Stored, derived: Stored) -> str:
    """The difference between constants derived here and those of the run, in words; empty without a difference."""
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
