"""Scenes at the limits of solvability: one sphere at a wall, rattlers, absurd forces, boxes too full or too small."""

import math

import numpy as np
import pytest

from ecume.errors import Diverged, SceneError
from ecume.laws.soft_pair import SoftPair, passage_time
from ecume.models.soft import SOFT
from ecume.scenes.load import load_scene
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate

SPHERE = {"radius": 1.0, "modulus": 1.0}
RING = SPHERE | {"positions": [[1.02 + 2.05 * k, 1.0] for k in range(6)]}
"""Neighbors across a periodic cell 12.3 wide."""
BASE = {"model": "soft", "duration": 1.0, "frame_every": 1.0, "liquid": {"viscosity": 1.0}}


def scene_of(**more):
    return from_plain(BASE | more)


def honeycomb(*loose, **more):
    """Six spheres in a ring of neighbors across a periodic cell, and others far from any film."""
    particles = [RING]
    if loose:
        particles.append(SPHERE | {"positions": [list(place) for place in loose]})
    given = {"particles": particles, "cell": {"size": [12.3, 14.0]}, "protocol": [{"time": 0.0, "shear_rate": 0.1}]}
    return scene_of(**(given | more))


def test_a_single_sphere_approaches_a_wall_as_brenners_does():
    sphere = SPHERE | {"modulus": 1e3, "positions": [[0.0, 1.1]], "force": [0.0, -1e-2]}
    pair = SoftPair(2.0, 2e3, 1.0)
    time = passage_time(pair, 1e-2, 0.1, 0.05)
    # Rigid, with 6 pi eta R^2/h: the surfaces are deflected little.
    assert time == pytest.approx(6.0 * math.pi / 1e-2 * math.log(2.0), rel=2e-3)
    walled = scene_of(
        duration=time, frame_every=time, particles=[sphere], walls=[{"side": "bottom", "position": 0.0}],
        integration={"tolerance": 1e-8},
    )  # fmt: skip
    last = list(simulate(walled))[-1]
    assert last.numbers["smallest_gap"] == pytest.approx(0.05, rel=1e-6)
    assert last.arrays["position"].shape == (1, 2)


def test_the_smallest_gap_is_that_at_a_wall_where_it_is_narrower():
    places = [[0.0, 1.01], [0.0, 3.06]]
    walled = scene_of(particles=[SPHERE | {"positions": places}], walls=[{"side": "bottom", "position": 0.0}])
    assert next(iter(simulate(walled))).numbers["smallest_gap"] == pytest.approx(0.01)
    assert {name: value for name, value, _ in SOFT.summary(walled)}["narrowest gap"] == "10 mm"


@pytest.mark.parametrize("more", [{}, {"rotation": True}, {"integration": {"solver": "iterative"}}])
def test_rattlers_go_with_the_box_and_change_nothing_else(more):
    alone, rattling = (list(simulate(honeycomb(*loose, **more)))[-1] for loose in ((), [(3.0, 8.0), (7.0, 9.0)]))
    assert rattling.arrays["velocity"][6:] == pytest.approx(np.array([[0.8, 0.0], [0.9, 0.0]]), abs=1e-9)
    for name in ("shear_stress", "smallest_gap", "dissipated_work"):
        assert rattling.numbers[name] == pytest.approx(alone.numbers[name], rel=1e-7, abs=1e-12), name


def test_a_pair_apart_from_the_rest_is_held_if_its_forces_balance():
    pulled = [SPHERE | {"positions": [[x, 8.0]], "force": [f, 0.0]} for x, f in ((3.0, -1e-3), (5.05, 1e-3))]
    apart = list(simulate(scene_of(particles=[RING, *pulled], cell={"size": [12.3, 14.0]})))[-1]
    assert apart.numbers["imbalance"] < 1e-7
    assert apart.numbers["largest_tension"] == pytest.approx(1e-3, rel=1e-6)


def test_a_rattler_that_something_pulls_at_is_refused():
    pulled = [SPHERE | {"positions": [[x, y]], "force": [f, 0.0]} for x, y, f in ((3.0, 8.0, 1e-3), (7.0, 5.0, -1e-3))]
    with pytest.raises(SceneError, match="sphere 6 has no film to sphere 0"):
        next(
            iter(
                simulate(
                    honeycomb(particles=[SPHERE | {"positions": [[1.02 + 2.05 * k, 1.0] for k in range(6)]}, *pulled])
                )
            )
        )


def test_a_sphere_that_loses_its_last_film_under_a_force_ends_the_run():
    spheres = [SPHERE | {"positions": [[x, 0.0]], "force": [f, 0.0]} for x, f in ((0.0, -1e-2), (2.1, 1e-2))]
    parting = scene_of(duration=1e4, frame_every=1e4, particles=spheres, films={"cutoff": 0.2})
    with pytest.raises(Diverged, match="has lost its last film"):
        list(simulate(parting))


@pytest.mark.parametrize(
    ("more", "path", "says"),
    [
        ({"particles": [SPHERE | {"positions": [[0.0, 0.0]]}]}, "particles", "expected two or more, or a wall"),
        (
            {"particles": [SPHERE | {"positions": [[x, 0.0]], "force": [f, 0.0]} for x, f in ((0, 1e3), (2.1, -1e3))]},
            "particles",
            "a force of 1 kN on sphere 0 would deflect its surface by more than a radius; expected at most 2 N",
        ),
        (
            {"particles": [SPHERE | {"count": 9}], "cell": {"size": [3.0, 3.0]}},
            "cell.size",
            "spheres would fill 3.14 times the cell; expected at most 1.5 times",
        ),
        (
            {
                "particles": [SPHERE | {"count": 9}],
                "cell": {"size": [1.0, 1.0], "volume_fraction": 0.75},
                "protocol": [{"time": 0.0}, {"time": 1.0, "scale": 0.5}],
            },
            "protocol",
            "spheres would fill 3 times the cell",
        ),
    ],
)
def test_absurd_scenes_are_refused(more, path, says):
    with pytest.raises(SceneError) as caught:
        SOFT.parameters(scene_of(**more))
    (fault,) = caught.value.faults
    assert fault.path == path
    assert says in fault.message


TEXT = """model = "soft"
duration = 1.0
frame_every = 1.0
[liquid]
viscosity = 1.0
[[particles]]
radius = 1.0
modulus = 1.0
count = 9
[cell]
size = [10.0, 8.0]
[films]
cutoff = 4.5
"""


def test_films_longer_than_half_the_box_are_a_fault_with_its_line():
    with pytest.raises(SceneError, match="expected at most half of the shortest periodic side, 4 m") as caught:
        load_scene(TEXT)
    (fault,) = caught.value.faults
    assert (fault.path, fault.line) == ("films.cutoff", 13)
    assert load_scene(TEXT + '[[walls]]\nside = "bottom"\n[[walls]]\nside = "top"\n').films.cutoff == 4.5
