"""Sizes of the particles of a species: equal radii, one radius per particle, or a distribution.

`radius` of a species is a length, a list with one radius per particle, or a table: a distribution with its mean and
spread. A species keeps the mean in `radius`, the list in `radii` and the table in `sizes`.

The number of particles of a species may follow from its share of the total volume.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from pathlib import Path as Folder
from statistics import NormalDist
from typing import Annotated, Any, Literal, Protocol, Self, TypeVar

import numpy as np
from pydantic import Field, model_validator
from pydantic_core import ArgsKwargs

from ecume.scenes.common import dataclass
from ecume.scenes.faults import Complaints, Inconsistent, Path
from ecume.scenes.quantities import MOST_PARTICLES, STRICT, Radius
from ecume.scenes.tables import MOST_BYTES, TableFaults, beside, followed, lines_of, require_there, table_text
from ecume.units import Array, Number, Unit

Spread = Annotated[Number, Field(gt=0.0, le=1.0)]
Cut = Annotated[Number, Field(ge=0.5, le=6.0)]
Weight = Annotated[Number, Field(ge=0.0, le=1e15)]
Share = Annotated[Number, Field(gt=0.0, lt=1.0)]
LEAST = 0.01
"""The smallest radius of a distribution, over its mean."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class SizeSpec:
    """A distribution of radii, by number. The radii of a species are its quantiles at equal distances, in random order,
    so that even a few particles represent it.
    """

    distribution: Literal["normal", "lognormal", "uniform", "histogram"]
    """The distribution: `normal`, `lognormal`, `uniform`, or a `histogram` of given radii. Effect: changes the shape of
    the tails."""
    mean: Radius | None = None
    """The mean radius (m); of a histogram it follows from the radii. Effect: all radii are proportional to it."""
    spread: Spread | None = None
    """The standard deviation divided by the mean, the polydispersity; text such as `"20 %"` is allowed. Effect: unequal
    particles crystallize less and jam at a higher volume fraction."""
    truncate: Cut = 3.0
    """The number of standard deviations from the mean beyond which there are no radii; of the logarithm for
    `lognormal`. Effect: small values cut the tails."""
    radii: tuple[Radius, ...] = ()
    """The radii of a histogram (m), given here or in a table, `file = "sizes.csv"`, with a column `radius` or
    `diameter` and perhaps `weight`, units in its head as in `diameter [um]`. Effect: these are the only radii."""
    weights: tuple[Weight, ...] = ()
    """The number of particles of each radius of a histogram, in proportion; by default equal. Effect: larger weights
    give more particles of that radius."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        listed, found = self.distribution == "histogram", []
        if listed and not self.radii:
            found.append((("radii",), "is missing; a histogram needs the radii, and weights"))
        if not listed:
            missing = [key for key in ("mean", "spread") if getattr(self, key) is None]
            found += [((key,), f"is missing; {self.distribution} needs a mean and a spread") for key in missing]
            given = [key for key in ("radii", "weights") if getattr(self, key)]
            found += [((key,), f'belongs to distribution = "histogram"; got {self.distribution}') for key in given]
        if listed and self.weights and (len(self.weights) != len(self.radii) or not sum(self.weights) > 0.0):
            found.append((("weights",), f"got {len(self.weights)}; expected one for each of {len(self.radii)} radii"))
        complaints: Complaints = [*found]
        if complaints:
            raise Inconsistent(complaints)
        return self


class Sized(Protocol):
    """A species of any model with radii."""

    @property
    def radius(self) -> float:
        """The mean radius (m)."""

    @property
    def radii(self) -> tuple[float, ...]:
        """One radius per particle, or empty."""

    @property
    def sizes(self) -> SizeSpec | None:
        """The distribution of radii, if any."""


def quantiles(sizes: SizeSpec, count: int) -> Array:
    """The radii of `count` particles, ascending (m): the quantiles (k + 1/2)/count.

    >>> quantiles(SizeSpec(distribution="uniform", mean=1.0, spread=0.1), 2).round(4).tolist()
    [0.9134, 1.0866]
    """
    part = (np.arange(count) + 0.5) / count
    if sizes.distribution == "histogram":
        order = np.argsort(sizes.radii)
        weights = np.array(sizes.weights or [1.0] * len(sizes.radii))[order]
        place = np.searchsorted(np.cumsum(weights) / weights.sum(), part)
        return np.asarray(np.array(sizes.radii)[order][np.minimum(place, len(order) - 1)])
    mean, spread = sizes.mean or 0.0, sizes.spread or 0.0
    if sizes.distribution == "uniform":
        found = mean * (1.0 + math.sqrt(3.0) * spread * (2.0 * part - 1.0))
    else:
        normal = NormalDist()
        low, high = normal.cdf(-sizes.truncate), normal.cdf(sizes.truncate)
        score = np.array([normal.inv_cdf(low + (high - low) * float(each)) for each in part])
        found = mean * (1.0 + spread * score)
        if sizes.distribution == "lognormal":
            variance = math.log1p(spread**2)
            found = mean * np.exp(math.sqrt(variance) * score - 0.5 * variance)
    return np.asarray(np.maximum(found, LEAST * mean))


def radii_of(species: Sized, count: int, seed: tuple[int, int]) -> Array:
    """The radius of each particle of a species (m). For a distribution, the order follows from the seed of the scene
    and the index of the species.
    """
    if species.sizes is not None:
        return np.random.default_rng([*seed, count]).permutation(quantiles(species.sizes, count))
    return np.array(species.radii) if species.radii else np.full(count, float(species.radius))


def largest_radius(species: Sized) -> float:
    """The largest radius that particles of a species can have (m)."""
    sizes = species.sizes
    if sizes is None:
        return float(max(species.radii, default=species.radius))
    return float(max(sizes.radii) if sizes.radii else _upper(sizes))


def _upper(sizes: SizeSpec) -> float:
    mean, spread = sizes.mean or 0.0, sizes.spread or 0.0
    if sizes.distribution == "lognormal":
        variance = math.log1p(spread**2)
        return mean * math.exp(math.sqrt(variance) * sizes.truncate - 0.5 * variance)
    return mean * (1.0 + spread * (math.sqrt(3.0) if sizes.distribution == "uniform" else sizes.truncate))


def mean_power(species: Sized, power: int, count: int) -> float:
    """The mean of a power of the radii (m^power)."""
    if species.sizes is None and not species.radii:
        return float(species.radius**power)
    return float((radii_of(species, count, (0, 0)) ** power).mean())


def sized(raw: Any) -> Any:
    """The keys of a species; a `radius` that is a table or a list is moved to another key."""
    keys = raw.kwargs if isinstance(raw, ArgsKwargs) else raw
    if not isinstance(keys, Mapping):
        return raw
    radius, more = keys.get("radius"), {}
    if isinstance(radius, Mapping):
        listed = radius.get("radii") if radius.get("distribution") == "histogram" else None
        more = {"sizes": dict(radius), "radius": _mean(listed, radius.get("weights")) or radius.get("mean")}
    elif isinstance(radius, SizeSpec):
        more = {"sizes": radius, "radius": _mean(radius.radii, radius.weights) or radius.mean}
    elif isinstance(radius, (list, tuple)):
        more = {"radii": tuple(radius), "radius": _mean(radius, None)}
    if not more:
        return raw
    if more["radius"] is None:
        more.pop("radius")
    kept = {key: value for key, value in keys.items() if key != "radius"} | more
    return ArgsKwargs(raw.args, kept) if isinstance(raw, ArgsKwargs) else kept


def _mean(radii: Any, weights: Any) -> float | None:
    """The mean of listed radii; None if they are not lengths, which is reported as a fault of their key."""
    if not isinstance(radii, (list, tuple)) or not radii:
        return None
    try:
        given = np.array([Unit("m").number(one) for one in radii])
        return float(np.average(given, weights=weights or None))
    except (ValueError, TypeError, ZeroDivisionError):
        return None


def list_faults(species: Sized, count: int) -> Complaints:
    """The fault of a list of radii whose length is not the number of particles."""
    if species.radii and len(species.radii) != count:
        return [(("radius",), f"got {len(species.radii)} radii; expected one for each of {count} particles")]
    return []


class Shared(Sized, Protocol):
    """A species whose number may follow from its share of the volume."""

    @property
    def count(self) -> int | None:
        """The number of particles, if it is known."""

    @property
    def positions(self) -> Sequence[Any]:
        """The position of each particle, if specified."""

    @property
    def volume_share(self) -> float | None:
        """The fraction of the volume of all particles, if the number follows from it."""


Species = TypeVar("Species", bound=Shared)


def shared_out(particles: Sequence[Species], power: int) -> tuple[Species, ...]:
    """The species with the number of particles that follows from each share of the volume. Raises Inconsistent. The
    volume of a particle is that of a sphere, proportional to the third `power` of the radius, or in a layer an area, to
    the second.
    """
    shares = [one.volume_share or 0.0 for one in particles]
    if not any(shares):
        return tuple(particles)
    volume = sum(
        _number(one) * mean_power(one, power, _number(one))
        for one, share in zip(particles, shares, strict=True)
        if not share
    )
    last = max(index for index, share in enumerate(shares) if share)
    if not volume > 0.0:
        cause = "is a part of the volume of all; expected a count, or positions, of at least one species"
        raise Inconsistent([(("particles", last, "volume_share"), cause)])
    if sum(shares) >= 1.0:
        cause = f"the shares sum to {sum(shares):g}; expected less than 1, the rest being counted species"
        raise Inconsistent([(("particles", last, "volume_share"), cause)])
    whole = volume / (1.0 - sum(shares))
    numbers = [
        round(share * whole / mean_power(one, power, MANY)) for one, share in zip(particles, shares, strict=True)
    ]
    wrong = [
        fault
        for index, (one, share) in enumerate(zip(particles, shares, strict=True))
        for fault in (_faults_of_share(index, one.count, numbers[index]) if share else [])
    ]
    if wrong:
        raise Inconsistent(wrong)
    return tuple(
        dataclasses.replace(one, count=number) if share else one  # type: ignore[type-var]
        for one, share, number in zip(particles, shares, numbers, strict=True)
    )


def _number(species: Shared) -> int:
    """The number of particles of a species: its count, or the number of its positions."""
    return species.count or len(species.positions)


MANY = 1000
"""The number of particles for the mean volume of a distribution if their number is to follow from it."""


def _faults_of_share(index: int, count: int | None, number: int) -> Complaints:
    if not 1 <= number <= MOST_PARTICLES:
        cause = f"makes {number} particles; expected 1 to {MOST_PARTICLES:.0e}"
        return [(("particles", index, "volume_share"), cause)]
    if count not in (None, 0, number):
        cause = f"got {count}, and volume_share makes {number} particles; expected one of the two"
        return [(("particles", index, "count"), cause)]
    return []


SIZE_COLUMNS = {"radius": "m", "weight": "1"}
"""The columns of a table of sizes, and their SI units."""


def follow_sizes(raw: Mapping[str, Any], folder: Folder) -> list[tuple[Path, str]]:
    """Replace the `file` of a histogram by the radii and weights of its table; return the faults of the files."""
    species = raw.get("particles")
    found: list[tuple[Path, str]] = []
    for index, one in enumerate(species if isinstance(species, list) else []):
        radius = one.get("radius") if isinstance(one, dict) else None
        if isinstance(radius, dict) and "file" in radius:
            found += followed(("particles", index, "radius", "file"), _histogram, radius, radius.pop("file"), folder)
    return found


def _histogram(radius: dict[str, Any], name: str, folder: Folder) -> None:
    """The radii and weights of a table. Raises ValueError."""
    path = beside(folder, name)
    require_there(path, folder)
    lines = [line.values for line in lines_of(table_text(path, MOST_BYTES), SIZE_COLUMNS, required=())]
    if "radius" not in lines[0]:
        raise TableFaults(["line 1: expected either a column radius or a column diameter"])
    radius["radii"] = [values["radius"] for values in lines]
    if "weight" in lines[0]:
        radius["weights"] = [values["weight"] for values in lines]
