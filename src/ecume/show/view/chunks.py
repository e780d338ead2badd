"""Frames in the format of the page: arrays of small integers with their ranges in sequence, and their descriptions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume.analysis.dispersion import present
from ecume.show.tank import RARE
from ecume.show.view.scenery import Links, Stage
from ecume.trajectories.frame import Frame

STEPS = 65535
"""The number of steps between the smallest and the largest value: 1.5e-5 of the range."""
FEW_STEPS = 255
WIDE = 1e3
"""The ratio of the largest to the smallest value above which equal steps would lose small values."""
NEAR = 1e-6
"""Ways across a border that differ by less are one, over the size of all."""
ALIGNED = 4
"""Bytes that each array's place is a multiple of."""
HIDDEN = ("position", "identity", "neighbor")
"""Arrays of a frame that are no quantity to color by."""

Numbers = NDArray[Any]


class Chunk(NamedTuple):
    """A packed sequence of frames."""

    header: dict[str, Any]
    blob: bytes


class _Packing:
    """A growing block of data, with the offsets of its entries."""

    def __init__(self, rows: int) -> None:
        """Start a block with this number of frames with equal numbers of particles; 1 if their number changes."""
        self.rows = rows
        self.parts: list[bytes] = []
        self.size = 0
        self.places: dict[str, dict[str, Any]] = {}
        self.ranges: dict[str, list[float]] = {}
        self.scales: dict[str, list[float]] = {}

    def add(self, name: str, values: Numbers, kind: str) -> None:
        """Add numbers in a format that the page reads."""
        self._put(name, values.size, kind, np.ascontiguousarray(values, f"<{kind}").tobytes())

    def moved(self, name: str, values: Numbers) -> None:
        """Add 16-bit numbers as differences from the previous frame, if all frames have equally many."""
        if self.rows < 2 or values.size % self.rows:
            self.add(name, values, "u2")
            return
        self._put(name, values.size, "u2", moves(values.reshape(self.rows, -1)))
        self.places[name]["rows"] = self.rows

    def _put(self, name: str, length: int, kind: str, plain: bytes) -> None:
        self.places[name] = {"offset": self.size, "length": int(length), "kind": kind}
        plain += bytes(-len(plain) % ALIGNED)
        self.parts.append(plain)
        self.size += len(plain)

    def quantized(self, name: str, values: Numbers) -> None:
        """Pack numbers as integer steps from the smallest to the largest; unchanged where this would lose or create
        values.
        """
        low, high = (float(values.min()), float(values.max())) if values.size else (0.0, 1.0)
        if not np.isfinite([low, high]).all() or (low > 0.0 and high > WIDE * low):
            finite = values[np.isfinite(values)]
            low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
            self.add(name, values, "f4")
        elif high > low:
            self.moved(name, np.rint((values - low) * (STEPS / (high - low))))
        else:
            self.moved(name, np.zeros(values.shape))
        self.ranges[name] = [low, high]

    def few(self, name: str, values: Numbers) -> None:
        """Add numbers that the page shows as color or width, in a few steps from the smallest to the largest."""
        low, high = (float(values.min()), float(values.max())) if values.size else (0.0, 1.0)
        self.add(name, np.rint((values - low) * (FEW_STEPS / max(high - low, 1e-300))), "u1")
        self.ranges[name] = [low, high]

    def scale(self, name: str, values: Numbers) -> None:
        """Record the range of nearly all values, so that single peaks do not compress the color scale."""
        finite = values[np.isfinite(values)]
        if finite.size:
            self.scales[name] = [float(end) for end in np.quantile(finite, (RARE, 1.0 - RARE))]


def pack(frames: Sequence[Frame], stage: Stage) -> Chunk:
    """A chunk with these frames."""
    frames = [shown(frame, stage) for frame in frames]
    counts = [len(frame.arrays["position"]) for frame in frames]
    packing = _Packing(len(frames) if len(set(counts)) == 1 else 1)
    packing.quantized("position", np.concatenate([frame.arrays["position"].ravel() for frame in frames]))
    steady = _quantities(packing, frames, stage)
    _numbers(packing, frames)
    movers = _movers(packing, frames, stage)
    links = _links(packing, frames, stage)
    if stage.heights is not None:
        packing.add("sheet", np.stack([np.rint(FEW_STEPS * stage.heights(frame)) for frame in frames]), "u1")
        packing.ranges["sheet"] = [0.0, 1.0]
    header = {
        "times": [frame.time for frame in frames],
        "counts": counts,
        "places": packing.places,
        "ranges": packing.ranges,
        "scales": packing.scales,
        "steady": steady,
        "movers": movers,
        "links": links,
    }
    return Chunk(header, b"".join(packing.parts))


def moves(steps: Numbers) -> bytes:
    """The rows of numbers from 0 to 65535 as their differences to the previous row (for the first, to zero), modulo
    65536.

    Differences are encoded so that small magnitudes of either sign are small numbers, and all low bytes precede all
    high bytes. For slow motion the high bytes are zero, which gzip compresses to nearly nothing.
    """
    turned = np.diff(steps.astype(np.uint16), axis=0, prepend=np.zeros((1, steps.shape[1]), np.uint16)).view(np.int16)
    folded = ((turned << 1) ^ (turned >> 15)).astype("<u2")
    return np.ascontiguousarray(folded.ravel().view(np.uint8).reshape(-1, 2).T).tobytes()


def shown(frame: Frame, stage: Stage) -> Frame:
    """A frame with derived arrays. Floats with a shape are drawn as outlines around discs; their radius is that of the
    circumscribed circle. Tracers that have left keep their numbers, and have the radius 0, so that they are not drawn.
    """
    frame = frame if stage.derived is None else stage.derived(frame)
    if stage.inner is not None:
        return frame.with_arrays({**frame.arrays, "radius": stage.inner})
    if "left" in frame.arrays and not (there := present(frame)).all():
        radius = np.where(there, frame.arrays.get("radius", stage.radius), 0.0)
        return frame.with_arrays({**frame.arrays, "radius": radius})
    return frame


def quantities(frame: Frame) -> dict[str, Numbers]:
    """The quantities by which particles can be colored: the arrays of a frame, and for vectors the magnitude."""
    found: dict[str, Numbers] = {}
    dimension = frame.arrays["position"].shape[1]
    for name, values in frame.arrays.items():
        if name in HIDDEN:
            continue
        if values.ndim == 1:
            found[name] = values
        elif values.ndim == 2 and values.shape[1] == dimension:
            found["speed" if name == "velocity" else name] = np.linalg.norm(values, axis=1)
    return found


def _quantities(packing: _Packing, frames: Sequence[Frame], stage: Stage) -> list[str]:
    """Add the quantities of the particles. Returns the names of the constant ones, which are stored once."""
    steady = []
    columns = [quantities(frame) for frame in frames]
    colored = [_colored(frame, stage) for frame in frames]
    for name, first in columns[0].items():
        each = [column[name] for column in columns]
        whole = f"array/{name}"
        if all(np.array_equal(first, one) for one in each):
            steady.append(whole)
            each = [first]
        values = np.concatenate(each)
        if values.dtype.kind == "i" and values.size and values.min() >= 0 and values.max() <= FEW_STEPS:
            packing.add(whole, values, "u1")
        elif values.dtype.kind == "i":
            packing.add(whole, values, "f4")
            packing.ranges[whole] = [float(values.min(initial=0)), float(values.max(initial=1))]
        else:
            packing.quantized(whole, values)
        packing.scale(whole, np.concatenate([one[which] for one, which in zip(each, colored, strict=False)]))
    return steady


def _colored(frame: Frame, stage: Stage) -> Numbers:
    """The values that determine the range of colors: all except those of particles that have left or have separate
    colors.
    """
    there = present(frame)
    return there if stage.apart is None else there & (frame.arrays["species"] < stage.apart)


def _numbers(packing: _Packing, frames: Sequence[Frame]) -> None:
    for name in frames[0].numbers:
        packing.add(f"number/{name}", np.array([frame.numbers.get(name, np.nan) for frame in frames]), "f4")


def _movers(packing: _Packing, frames: Sequence[Frame], stage: Stage) -> list[int]:
    """Add the outlines of moving parts. Returns the number of points of each."""
    if stage.movers is None:
        return []
    outlines = [stage.movers(frame) for frame in frames]
    packing.add("movers", np.concatenate([line.ravel() for each in outlines for line in each]), "f4")
    return [len(line) for line in outlines[0]]


def _links(packing: _Packing, frames: Sequence[Frame], stage: Stage) -> list[int]:
    """Add the contacts. Returns the number in each frame.

    Contacts are stored as pairs of particle numbers, whose positions are known. The pairs change little from frame to
    frame, so that gzip compresses them well. The shift from a particle to its copy across a border is one of few.
    """
    if stage.links is None:
        return []
    links = [stage.links(frame) for frame in frames]
    pairs = np.concatenate([one.pairs.ravel() for one in links])
    packing.add("links/pairs", pairs, "u2" if pairs.max(initial=0) <= STEPS else "u4")
    ways = [_ways(frame, one) for frame, one in zip(frames, links, strict=True)]
    most = max(len(across) for _, across in ways)
    padded = [np.pad(across, ((0, most - len(across)), (0, 0))) for _, across in ways]
    packing.add("links/ways", np.concatenate([number for number, _ in ways]), "u1")
    packing.add("links/across", np.stack(padded), "f4")
    # Gaps span many powers of ten.
    packing.few("links/gap", np.log(np.concatenate([np.maximum(one.gap, 1e-300) for one in links])))
    packing.few("links/tension", np.concatenate([one.tension for one in links]))
    return [len(one.gap) for one in links]


def _ways(frame: Frame, links: Links) -> tuple[Numbers, Numbers]:
    """The periodic shift of the second particle of each contact, as an index into the list of shifts (W, d) in m."""
    first, second = links.pairs.T
    place = frame.arrays["position"][:, : links.along.shape[1]]
    shift = links.along - (place[second] - place[first])
    size = NEAR * max(float(np.ptp(place)), 1e-300)
    found, number = np.unique(np.rint(shift / size), axis=0, return_inverse=True)
    return number.ravel(), size * found
