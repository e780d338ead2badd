"""Tracks of round objects in a film: read with ffmpeg, located and linked with trackpy.

Objects are located in each picture as maxima of brightness, refined to a fraction of a pixel by the centroid of the
brightness around them, and linked from picture to picture by their displacements, as in [crocker1996].
"""

from __future__ import annotations

import importlib
import itertools
import math
import os
import warnings
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume.engine.ffmpeg import film_of, pictures_of
from ecume.errors import BadInput, install
from ecume.fitting.tracks import LEAST
from ecume.units import Array

Picture = NDArray[np.uint8]
"""Brightness (rows, columns)."""
SEEN = 0.5
"""The least fraction of the pictures in which an object must be found."""
MASK = 1.25
"""The diameter of the mask for the centroid of the brightness, in diameters of the object."""
USUAL = 11
"""Pictures with objects above this diameter (pixels) are reduced to it for the search."""
LEAST_AROUND = 12
"""The least number of pixels around an object for a gradient of the brightness."""
ROUNDS, STILL = 20, 1e-3
"""Centers are refined in up to ROUNDS iterations, until they move by less than STILL (pixels)."""
MOST_PICTURES = 20_000
RESTING = 0.05
"""The longest path, in diameters, of an object that is reported as one at rest."""


class Search(NamedTuple):
    """The properties of the objects to find."""

    diameter: float
    """of an object, pixels"""
    objects: int | None = None
    """the number of objects, the brightest ones; default: all that are found in half of the pictures"""
    dark: bool = False
    """whether objects are darker than their surroundings"""
    box: tuple[int, int, int, int] | None = None
    """left, top, width and height of the searched part of the pictures, pixels"""
    reach: float | None = None
    """the longest displacement from picture to picture, pixels; by default half a diameter"""


class FilmTracks(NamedTuple):
    """The positions of objects in the pictures of a film."""

    times: Array
    """(T,) s"""
    position: Array
    """(T, N, 2) pixels from the lower left corner, y upward; NaN where an object was not found"""
    size: tuple[int, int]
    """width and height of the pictures"""


def film_tracks(path: str | os.PathLike[str], search: Search, rate: float | None = None) -> FilmTracks:
    """The tracks of objects in a film. Raises BadInput if no object is found in half of the pictures. `rate` is the
    frame rate in real time (1/s), by default that of the film.
    """
    if not 2.0 <= search.diameter <= 1000.0:
        raise BadInput(f"diameter: got {search.diameter:g} pixels; expected 2 to 1000")
    facts = film_of(path)
    size = facts.width, facts.height
    left, top, width, height = search.box or (0, 0, *size)
    if left < 0 or top < 0 or width < 1 or height < 1 or left + width > size[0] or top + height > size[1]:
        raise BadInput(f"box: got {left}, {top}, {width}, {height}; the pictures have {size[0]} x {size[1]} pixels")
    found = [
        _objects(picture[top : top + height, left : left + width], search)
        for picture in itertools.islice(pictures_of(path), MOST_PICTURES)
    ]
    if len(found) < LEAST:
        raise BadInput(f"{path}: has {len(found)} pictures; expected {LEAST} or more")
    position = _linked(found, search)
    if not position.shape[1]:
        raise BadInput(
            f"{path}: no object of {search.diameter:g} pixels is in half of the pictures; see --dark and --box"
        )
    # From rows and columns in the box to x and y in the picture.
    position = np.stack([left + position[:, :, 0], size[1] - 1 - top - position[:, :, 1]], axis=2)
    return FilmTracks(np.arange(len(found)) / (rate or facts.rate), position, size)


def _objects(picture: Picture, search: Search) -> Array:
    """Column, row and brightness of each object in a picture, (n, 3).

    Large objects are located in a reduced picture, in which they have no details; `_centered` then refines their
    centers.
    """
    trackpy = _library("trackpy")
    shrink = max(1, int(search.diameter / USUAL))
    light = -picture.astype(np.float64) if search.dark else picture.astype(np.float64)
    small = _shrunk(light - light.min(), shrink)
    diameter = 2 * max(1, round(0.5 * (search.diameter / shrink - 1.0))) + 1
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # warnings on empty pictures and library versions
        found = trackpy.locate(small, diameter, topn=search.objects)
    places = (np.asarray(found[["x", "y"]], np.float64) + 0.5) * shrink - 0.5
    centers = np.array([_centered(light, place, search.diameter) for place in places]).reshape(-1, 2)
    return np.column_stack([centers, np.asarray(found["mass"], np.float64)])


def _shrunk(light: Array, shrink: int) -> Array:
    """The picture reduced by averaging squares of pixels."""
    rows, columns = (side // shrink * shrink for side in light.shape)
    means = light[:rows, :columns].reshape(rows // shrink, shrink, columns // shrink, shrink).mean(axis=(1, 3))
    return np.asarray(means)


def _centered(light: Array, place: Array, diameter: float) -> Array:
    """The centroid of the brightness above a threshold halfway between the surroundings of an object and its center.

    The threshold follows the gradient of the surrounding brightness: a constant one would shift the center to the side
    whose brightness is closer to that of the object.
    """
    reach = MASK * 0.5 * diameter
    for _ in range(ROUNDS):
        low = np.maximum(np.ceil(place - reach).astype(np.int64), 0)
        high = np.minimum(np.floor(place + reach).astype(np.int64) + 1, light.shape[::-1])
        part = light[low[1] : high[1], low[0] : high[0]]
        x, y = np.arange(low[0], high[0]) - place[0], np.arange(low[1], high[1])[:, None] - place[1]
        away = np.sqrt(x**2 + y**2)
        rim, core = (away > 0.55 * diameter) & (away < reach), away < 0.25 * diameter
        if not rim.any() or not core.any():
            return place
        inside = float(np.median(part[core]))
        around = _around(part, rim, inside, (x, y))
        height = (part - around) / np.maximum(inside - around, 1e-9)
        weight = np.clip(2.0 * height - 0.5, 0.0, 1.0) * (away < reach)
        total = float(weight.sum())
        if total <= 0.0:
            return place
        shift = np.array([float((weight * x).sum()), float((weight * y).sum())]) / total
        place = place + shift
        if float(np.abs(shift).max()) < STILL:
            break
    return place


def _around(part: Array, rim: Any, inside: float, away: tuple[Array, Array]) -> Array:
    """The brightness around an object, as a plane fitted to the rim; pixels of other objects are omitted."""
    level = float(np.median(part[rim]))
    free = rim & (np.abs(part - level) < 0.5 * abs(inside - level))
    if np.count_nonzero(free) < LEAST_AROUND:
        return np.full(part.shape, level)
    terms = np.stack(np.broadcast_arrays(1.0, *away))
    slopes = np.linalg.lstsq(terms[:, free].T, part[free], rcond=None)[0]
    return np.asarray(np.tensordot(slopes, terms, 1))


def _linked(found: list[Array], search: Search) -> Array:
    """Columns and rows (T, N, 2) of the objects that are found in half of the pictures, the brightest first."""
    import pandas

    trackpy = _library("trackpy")
    trackpy.quiet()
    frame = np.repeat(np.arange(len(found)), [len(one) for one in found])
    table = pandas.DataFrame(np.concatenate(found), columns=["x", "y", "mass"]).assign(frame=frame)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        linked = trackpy.link(table, search.reach or 0.5 * search.diameter, memory=3)
    particle = np.asarray(linked["particle"], np.int64)
    who, count = np.unique(particle, return_counts=True)
    whole = who[count >= SEEN * len(found)]
    mass, place = np.asarray(linked["mass"]), np.asarray(linked[["x", "y"]])
    whole = np.array(sorted(whole, key=lambda one: -float(mass[particle == one].mean())), np.int64)[: search.objects]
    position = np.full((len(found), len(whole), 2), math.nan)
    for number, one in enumerate(whole):
        mine = particle == one
        position[np.asarray(linked["frame"])[mine], number] = place[mine]
    return position


def at_rest(tracks: FilmTracks, diameter: float) -> list[tuple[float, float]]:
    """The places (pixels) of objects whose whole path is shorter than a small part of a diameter: often a mark of the
    picture, such as a scale, and not a particle.
    """
    low, high = np.nanmin(tracks.position, axis=0), np.nanmax(tracks.position, axis=0)
    still = (high - low).max(axis=1) < RESTING * diameter
    return [(x, y) for x, y in (0.5 * (low + high))[still].tolist()]


def table_of_tracks(tracks: FilmTracks) -> str:
    """The tracks as a table that `ecume fit` reads."""
    lines = ["t [s],x [px],y [px],id"]
    for time, row in zip(tracks.times.tolist(), tracks.position.tolist(), strict=True):
        lines += [f"{time!r},{x:.4f},{y:.4f},{number}" for number, (x, y) in enumerate(row) if math.isfinite(x)]
    return "\n".join(lines) + "\n"


def _library(name: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError:
        raise BadInput(f"films need {name}, which is not installed: {install('track')}") from None
