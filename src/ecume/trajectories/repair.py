"""Repair of a damaged trajectory: its whole frames are kept."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import NamedTuple

from ecume._plain_files import place_of
from ecume.errors import StorageError
from ecume.trajectories import segments
from ecume.trajectories.durable_files import storing
from ecume.trajectories.recorder import segment_files
from ecume.trajectories.segments import Segment
from ecume.trajectories.verification import damages


class Repaired(NamedTuple):
    """The number of good frames, the faults of the others (a line each), and the files without any."""

    good: int
    faults: tuple[str, ...]
    unusable: tuple[Path, ...]


def repair(folder: Path) -> Repaired:
    """Make the segments of a folder readable again: whole frames stay, what was half written goes.

    Each damaged frame is named. A file without any whole frame is set aside, under a name that ends in `.damaged`.
    """
    good, faults, unusable = 0, [], []
    for path in segment_files(folder):
        try:
            segment = Segment(path)
        except StorageError as error:
            faults.append(str(error))
            unusable.append(_set_aside(path))
            continue
        with contextlib.closing(segment):
            found = [fault for _, fault in damages(segment)]
        segments.cut(path, segment.frames)
        good += segment.frames - len(found)
        faults += found
    return Repaired(good, tuple(faults), tuple(unusable))


def _set_aside(path: Path) -> Path:
    aside = path.with_suffix(".gsd.damaged")
    with storing(path), place_of(path, segments.root_of(path)) as place:
        place.beside(aside.name).take(place)
    return aside
