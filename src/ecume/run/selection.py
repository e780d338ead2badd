"""The quantities that a run records: selected arrays and numbers, and their precision."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume.errors import BadInput, Fault, SceneError, nearest
from ecume.trajectories.frame import Frame, RecordedArrays
from ecume.trajectories.gsd import present_name

if TYPE_CHECKING:
    from ecume.models.model import Model
    from ecume.scenes.common import Common

POSITION = "position"
"""The name of the array that all frames have."""


class Selection(NamedTuple):
    """The arrays that are recorded: all, or those with these names."""

    names: frozenset[str] | None = None
    single: bool = False

    def of(self, frame: Frame) -> Frame:
        """The frame with the arrays and the precision of files."""
        arrays, units = frame.arrays, frame.units
        if self.names is not None:
            omitted = [name for name in arrays if name not in self.names]
            arrays = RecordedArrays({name: arrays[name] for name in arrays if name in self.names}, omitted)
            units = {name: unit for name, unit in units.items() if name not in omitted}
        if self.single:
            rounded = {name: _rounded(array) for name, array in arrays.items()}
            arrays = RecordedArrays(rounded, arrays.omitted) if isinstance(arrays, RecordedArrays) else rounded
        return frame._replace(arrays=arrays, units=units)


def selection_of(scene: Common, model: Model) -> Selection:
    """The selection of a scene: with positions, and with quantities that the model never changes."""
    asked, single = scene.output.quantities, scene.output.precision == "single"
    return Selection(frozenset((*asked, POSITION, *model.constant)) if asked else None, single)


def _rounded(array: NDArray[Any]) -> NDArray[Any]:
    """Floating-point numbers in single precision, as float64."""
    if array.dtype.kind != "f":
        return array
    with np.errstate(over="ignore"):
        return array.astype(np.float32).astype(np.float64)


def names_quantities(scene: Common) -> bool:
    """Whether a scene names quantities that can be checked only in a frame."""
    asked = scene.output
    return bool(asked.quantities or (asked.samples and not scene.numbers.issuperset(asked.samples.numbers)))


def require_known(scene: Common, frame: Frame) -> None:
    """Raise SceneError for names of quantities that the frames of a scene do not have."""
    samples = scene.output.samples
    faults = list(_unknown("output.quantities", scene.output.quantities, frame.arrays))
    faults += _unknown("output.samples.numbers", samples.numbers if samples else (), frame.numbers)
    if faults:
        raise SceneError(faults)


def require_numbers(names: Sequence[str], frame: Frame) -> None:
    """Raise BadInput for names of numbers that a frame does not have."""
    if faults := [fault.message for fault in _unknown("", names, frame.numbers)]:
        raise BadInput(f"numbers of frames: {'; '.join(faults)}")


def _unknown(path: str, names: Sequence[str], known: Iterable[str]) -> Iterator[Fault]:
    """A fault for each name that does not exist."""
    there = list(known)
    for place, name in enumerate(names):
        if name not in there and present_name(name) not in there:
            near = nearest(name, there)
            hint = f"; {near}" if near.startswith("did you mean") else ""
            yield Fault(f"{path}[{place}]", f"got {name!r}; expected one of {', '.join(there)}{hint}")


EVERYTHING = Selection()
"""All quantities of frames, in double precision."""
