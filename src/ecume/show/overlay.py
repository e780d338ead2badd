"""A fitted simulation drawn over the film of the measured tracks."""

from __future__ import annotations

import itertools
import math
import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume.engine.ffmpeg import film_of, pictures_of
from ecume.show.movies import encode
from ecume.show.style import PALETTE

if TYPE_CHECKING:
    from ecume.fitting import Fit

THICK = 1.2
"""The width of the line around an object, in pixels, half of it on either side."""
LOOP = 400
"""The number of points of a drawn circle."""


class Scale(NamedTuple):
    """The transformation from positions in the scene to pixels of the film."""

    pixel: float
    """m"""
    origin: tuple[float, float]
    """of the scene, in pixels from the lower left corner"""
    rate: float | None = None
    """pictures a second of real time; by default those of the film"""


def overlay(path: str | os.PathLike[str], found: Fit, scale: Scale, out: Path) -> Path:
    """Write the film with a circle around each simulated object; return the written file."""
    radius = _radii(found) / scale.pixel
    facts = film_of(path)
    rate = scale.rate or facts.rate
    # Tracks start at the first picture in which an object was found.
    last = math.floor(float(found.tracks.times[-1]) * rate + 0.5) + 1

    def drawn() -> Iterator[NDArray[np.uint8]]:
        for number, picture in enumerate(itertools.islice(pictures_of(path, "rgb24"), last)):
            yield _circled(picture, _places(found, number / rate, scale), radius, facts.height)

    return encode(drawn(), out, max(1, round(facts.rate)))


def _radii(found: Fit) -> NDArray[np.float64]:
    """The radii (N,) in m of the particles of the scene."""
    kinds: Any = getattr(found.scene, "particles", ())
    return np.concatenate([np.full(max(kind.count, 1), float(kind.radius)) for kind in kinds])


def _places(found: Fit, time: float, scale: Scale) -> NDArray[np.float64]:
    """The positions (N, 2) of the simulated objects in pixels from the lower left corner."""
    paths = found.simulated.reshape(len(found.tracks.times), -1)
    now = np.array([np.interp(time, found.tracks.times, path) for path in paths.T]).reshape(-1, 2)
    return np.asarray(now / scale.pixel + np.array(scale.origin))


def _circled(
    picture: NDArray[np.uint8], places: NDArray[np.float64], radius: NDArray[np.float64], height: int
) -> NDArray[np.uint8]:
    """The picture with circles."""
    shown = picture.copy()
    angle = np.linspace(0.0, 2.0 * np.pi, LOOP, endpoint=False)
    for (x, y), size, color in zip(places, radius, itertools.cycle(PALETTE[1:]), strict=False):
        red, green, blue = (int(color[k : k + 2], 16) for k in (1, 3, 5))
        for far in np.arange(size - THICK, size + THICK, 0.5):
            columns = np.round(x + far * np.cos(angle)).astype(np.int64)
            rows = np.round(height - 1 - y - far * np.sin(angle)).astype(np.int64)
            within = (columns >= 0) & (columns < shown.shape[1]) & (rows >= 0) & (rows < shown.shape[0])
            shown[rows[within], columns[within]] = red, green, blue
    return shown
