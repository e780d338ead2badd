"""Floats that overlap slightly at the start, as after soft contacts, are moved apart before the run."""

import numpy as np
import pytest

from ecume.errors import SceneError
from ecume.models.floating.record import FLOATING
from ecume.models.floating.setup.initial_state import separated
from ecume.run import RunOptions, run, verify
from ecume.scenes.schema import from_plain

RADIUS = 1e-3


def scene(positions, **more):
    species = {"radius": RADIUS, "density": 1250.0, "contact_angle": "90 deg", "positions": positions}
    plain = {"model": "floating", "duration": 0.2, "frame_every": 0.1, "particles": [species]}
    return from_plain(plain | {"dish": {"radius": 0.05, "contact_angle": "90 deg"}} | more)


def triangle(overlap):
    side = 2.0 * RADIUS * (1.0 - 0.5 * overlap)
    return [[0.0, 0.0], [side, 0.0], [0.5 * side, 0.5 * np.sqrt(3.0) * side]]


def distances(position):
    return [float(np.linalg.norm(position[i] - position[j])) for i, j in ((0, 1), (0, 2), (1, 2))]


@pytest.mark.parametrize("overlap", [5e-4, 2e-3, 1.9e-2])
def test_slight_overlaps_are_removed_about_the_common_center(overlap):
    asked = scene(triangle(overlap))
    there = FLOATING.start(asked, FLOATING.parameters(asked)).position
    assert distances(there) == pytest.approx([2.0 * RADIUS] * 3, rel=1e-9)
    assert there.mean(axis=0) == pytest.approx(np.mean(triangle(overlap), axis=0), abs=1e-12)


def test_larger_overlaps_are_refused():
    asked = scene(triangle(0.03))
    with pytest.raises(SceneError, match="overlaps"):
        FLOATING.start(asked, FLOATING.parameters(asked))


def test_floats_without_overlaps_stay_to_the_bit():
    touching, none = np.array(triangle(0.0)), np.zeros((1, 2))
    radius = np.full(3, RADIUS)
    assert np.array_equal(separated(touching, radius, none), touching)
    assert np.array_equal(separated(touching * 1.1, radius, none), touching * 1.1)


def test_a_pair_across_a_periodic_border_is_moved_apart():
    box, radius = np.array([[0.02, 0.03]]), np.full(2, RADIUS)
    pair = np.array([[0.0005, 0.01], [0.02 - 0.001495, 0.01]])
    found = separated(pair, radius, box)
    gap = found[0, 0] + box[0, 0] - found[1, 0] - 2.0 * RADIUS
    assert abs(gap) < 1e-12
    assert abs(pair[0, 0] + box[0, 0] - pair[1, 0] - 2.0 * RADIUS) > 4e-6


def test_chains_and_rafts_are_solved_together():
    columns = np.arange(12) * 2.0 * RADIUS * (1.0 - 1e-3)
    row = np.stack([columns, np.zeros(12)], axis=1)
    found = separated(row, np.full(12, RADIUS), np.zeros((1, 2)))
    assert np.diff(found[:, 0]).min() > 2.0 * RADIUS * (1.0 - 1e-6)


@pytest.mark.parametrize(
    ("contacts", "overlap"),
    [({"law": "none"}, 1e-2), ({"law": "spring-dashpot", "stiffness": 10.0}, 1e-2), ({"law": "spring-dashpot"}, 2e-3)],
)
def test_overlaps_that_the_contacts_allow_stay_to_the_bit(contacts, overlap):
    asked = scene(triangle(overlap), contacts=contacts)
    there = FLOATING.start(asked, FLOATING.parameters(asked)).position
    assert np.array_equal(there, triangle(overlap))


@pytest.mark.parametrize("layout", ["chain", "triangle", "pair"])
@pytest.mark.parametrize("overlap", [0.0, 3e-4, 2e-3])
def test_a_raft_at_rest_keeps_its_energy(layout, overlap, tmp_path):
    """Nothing moves but what contacts correct within rounding: no energy is gained by the measure of the raft's own."""
    side = 2.0 * RADIUS * (1.0 - 0.5 * overlap)
    places = {
        "chain": [[k * side, 0.0] for k in range(3)],
        "triangle": triangle(overlap),
        "pair": triangle(overlap)[:2],
    }
    run(scene(places[layout]), tmp_path / "run", options=RunOptions(on_violation="stop"))
    assert verify(tmp_path / "run").sound
