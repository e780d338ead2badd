"""Where in a file a path stands."""

from __future__ import annotations

import pytest

from ecume.scenes.faults import place_of, places, read_path, written

TEXT = """\
model = "é" # remark
a.b.c = 3
[liquid]
density = 1030.0
[[particles]]
positions = [
  [1, 2], # one
  [3, "4 mm"],
]
[[particles]]
"ra dius" = 3
energies = {gas = 1, x.y = 2}
[[particles.deep]]
z = 1
[[particles.deep]]
z = 2
[dish.wall]
k = [{q = "é", r = 1}]
"""


@pytest.mark.parametrize(
    ("path", "place"),
    [
        ("model", (1, 1)),
        ("a.b.c", (2, 1)),
        ("liquid", (3, 1)),
        ("liquid.density", (4, 1)),
        ("particles", (5, 1)),
        ("particles[0]", (5, 1)),
        ("particles[0].positions[0][1]", (7, 7)),
        ("particles[0].positions[1][1]", (8, 7)),
        ("particles[1]", (10, 1)),
        ("particles[1].energies.gas", (12, 13)),
        ("particles[1].energies.x.y", (12, 22)),
        ("particles[1].deep[0].z", (14, 1)),
        ("particles[1].deep[1].z", (16, 1)),
        ("dish.wall.k[0].r", (18, 16)),
        ("particles[1].density", (10, 1)),
        ("duration", (1, 1)),
        ("", (None, None)),
    ],
)
def test_a_path_is_found_or_the_piece_around_it(path: str, place: tuple[int, int]) -> None:
    assert place_of(read_path(path), places(TEXT)) == place


def test_a_quoted_key_is_found() -> None:
    assert places(TEXT)["particles", 1, "ra dius"] == (11, 1)


def test_a_very_deep_file_has_places_too() -> None:
    deep = "a = " + "[" * 2000 + "]" * 2000
    assert places(deep)["a",] == (1, 1)


@pytest.mark.parametrize("path", [("particles", 0, "radius"), ("a",), ("a", 3, 4, "b-c")])
def test_a_path_is_written_as_it_is_read(path: tuple[str | int, ...]) -> None:
    assert read_path(written(path)) == path
