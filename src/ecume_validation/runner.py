"""The scenes, tables, runs and rows of validation cases; scenes and tables are in `data/CASE`.

Long cases store the result of each finished run, a piece, in a folder of the working directory. The name of a piece
contains the digests of its scene and of the code behind its numbers: an interrupted case continues with missing pieces,
and after a change of the model all are computed again.

Each row compares one number, with a tolerance or a bound.
"""

from __future__ import annotations

import csv
import hashlib
import json
import math
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from ecume.made_from import digest_of
from ecume.scenes.floating import FloatingScene
from ecume.scenes.load import load_scene
from ecume.scenes.schema import Scene, to_plain
from ecume.scenes.sph import SphScene
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame

DATA = Path(__file__).parent / "data"


def read_table(case: str, name: str = "published") -> list[dict[str, str]]:
    """The rows of a CSV file of a case, each as a dictionary of its columns."""
    with (DATA / case / f"{name}.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def case_scene(case: str, changes: Sequence[str] = (), name: str = "scene") -> Scene:
    """The scene of a case, with some of its values changed as by `--set`."""
    return load_scene(DATA / case / f"{name}.toml", changes)


def floating_scene(case: str, changes: Sequence[str] = (), name: str = "scene") -> FloatingScene:
    """The scene of a case of the floating model."""
    scene = case_scene(case, changes, name)
    assert isinstance(scene, FloatingScene)  # noqa: S101  # the scenes of these cases are
    return scene


def sph_scene(case: str, changes: Sequence[str] = ()) -> SphScene:
    """The scene of a case of the SPH model."""
    scene = case_scene(case, changes)
    assert isinstance(scene, SphScene)  # noqa: S101  # the scenes of these cases are
    return scene


def frames_of(case: str, changes: Sequence[str] = ()) -> Iterator[Frame]:
    """The frames of the scene of a case, with some of its values changed."""
    return simulate(case_scene(case, changes))


def kept_values(scene: Scene, folder: Path, compute: Callable[[], Sequence[Any]]) -> list[Any]:
    """The stored values for a scene, in JSON, or newly computed ones."""
    made_from = digest_of(compute.__module__)
    path = folder / f"{digest(scene)}-{made_from[:16]}.json"
    if not path.is_file():
        text = json.dumps(compute())
        folder.mkdir(parents=True, exist_ok=True)
        # The file is renamed after it is complete, so that an interruption leaves no partial file.
        partial = path.with_suffix(".part")
        partial.write_text(text, encoding="utf-8")
        partial.replace(path)
    found: list[Any] = json.loads(path.read_text(encoding="utf-8"))
    return found


def digest(scene: Scene) -> str:
    """A digest of a complete scene."""
    return hashlib.sha256(json.dumps(to_plain(scene), sort_keys=True).encode()).hexdigest()[:16]


class Row(NamedTuple):
    """A computed number with the expected one."""

    name: str
    computed: float
    expected: float
    """for a bound: the bound"""
    tolerance: float
    """absolute; for a bound: zero"""
    kind: str
    """a key of `KINDS`"""

    @property
    def met(self) -> bool:
        """Whether the computed number agrees with the expected one; never for NaN."""
        return bool(KINDS[self.kind](self))


KINDS: dict[str, Callable[[Row], bool]] = {
    "within": lambda row: abs(row.computed - row.expected) <= row.tolerance,
    "below": lambda row: row.computed < row.expected,
    "above": lambda row: row.computed > row.expected,
}


def within(name: str, computed: float, expected: float, tolerance: float) -> Row:
    """A row with an expected number and an absolute tolerance."""
    return Row(name, computed, expected, tolerance, "within")


def below(name: str, computed: float, bound: float) -> Row:
    """A row with an upper bound."""
    return Row(name, computed, bound, 0.0, "below")


def above(name: str, computed: float, bound: float) -> Row:
    """A row with a lower bound."""
    return Row(name, computed, bound, 0.0, "above")


def as_text(row: Row) -> tuple[str, str, str, str]:
    """Name, computed number, expected number and tolerance, with as many digits as the tolerance requires."""
    if row.kind == "within":
        digits = _digits(row)
        return row.name, f"{row.computed:.{digits}g}", f"{row.expected:.{digits}g}", f"{row.tolerance:.2g}"
    sign = {"below": "<", "above": ">"}[row.kind]
    return row.name, f"{row.computed:.4g}", f"{sign} {row.expected:g}", "bound"


def _digits(row: Row) -> int:
    if not row.tolerance or not row.expected:
        return 6
    return min(max(math.ceil(math.log10(abs(row.expected) / row.tolerance)) + 2, 4), 15)
