"""T1 events with known numbers: four discs, a sheared honeycomb, fluctuating particles."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.spatial import Delaunay

from ecume.analysis.boxes import Box, copies, nearest, wrapped
from ecume.analysis.rearrangements import contact_swaps, neighbor_swaps, neighbors_of, radical_neighbors
from ecume.errors import BadInput
from ecume.models.soft import t1_process
from ecume.models.soft.t1.cluster import t1_scene
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame

ROW = math.sqrt(3.0) / 2.0


def frame_of(position, time=0.0, radius=0.5, box=None):
    position = np.asarray(position, dtype=float)
    numbers = {}
    if box is not None:
        numbers = {"box_width": box.sides[0], "box_height": box.sides[1], "strain": box.strain}
    return Frame(
        time, {"position": position, "radius": np.broadcast_to(radius, len(position)).astype(float)}, numbers, {}
    )


def rhombus(ratio, turn=0.0):
    """Four discs whose horizontal distance is `ratio` times the vertical one."""
    half = np.array([[ratio, 0.0], [-ratio, 0.0], [0.0, 1.0], [0.0, -1.0]]) / 2.0
    cos, sin = math.cos(turn), math.sin(turn)
    return half @ np.array([[cos, sin], [-sin, cos]])


def courses(ratios, **more):
    return [frame_of(rhombus(ratio, **more), time) for time, ratio in enumerate(ratios)]


def honeycomb(columns=6, rows=6):
    i, j = np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij")
    return np.stack([(i + 0.5 * (j % 2)).ravel() + 0.1, ROW * j.ravel() + 0.1], axis=1).astype(float)


def sheared_honeycomb(strains, columns=6, rows=6):
    """Rows that slide over each other, one frame per strain; positions are wrapped into the box."""
    start, frames = honeycomb(columns, rows), []
    for time, strain in enumerate(strains):
        box = Box(np.array([columns, rows * ROW]), strain)
        moved = start + np.column_stack([strain * start[:, 1], np.zeros(len(start))])
        frames.append(frame_of(wrapped(moved, box), float(time), box=box))
    return frames


def test_neighbors_of_equal_discs_are_delaunays():
    random = np.random.default_rng(3)
    place = random.uniform(size=(200, 2))
    found = radical_neighbors(place, np.full(200, 0.01))
    simplices = Delaunay(place).simplices
    wanted = {tuple(sorted(pair)) for a, b, c in simplices.tolist() for pair in ((a, b), (b, c), (c, a))}
    assert set(map(tuple, found.pairs.tolist())) == wanted


def test_touching_discs_are_neighbors_however_unequal():
    # Two large ones that touch, and a small one in each pocket: Delaunay's circles would part the large ones.
    small = 0.03
    position = [
        (-1.0, 0.0),
        (1.0, 0.0),
        (0.0, math.sqrt((1 + small) ** 2 - 1)),
        (0.0, -math.sqrt((1 + small) ** 2 - 1)),
    ]
    frame = frame_of(position, radius=[1.0, 1.0, small, small])
    assert [0, 1] in neighbors_of(frame).pairs.tolist()
    assert [0, 1] not in neighbors_of(frame_of(position)).pairs.tolist()


@pytest.mark.parametrize("strain", [0.0, 0.3, 0.5, 1.7, -2.2])
def test_periodic_particles_have_three_neighbor_pairs_each(strain):
    box = Box(np.array([8.0, 6.0]), strain)
    random = np.random.default_rng(5)
    found = radical_neighbors(random.uniform(size=(80, 2)) * box.sides, np.full(80, 0.2), box)
    assert len(found.pairs) == 3 * 80
    assert np.isfinite(found.border).all()


def test_borders_in_a_honeycomb_are_as_long_as_its_sides():
    box = Box(np.array([6.0, 6 * ROW]))
    found = radical_neighbors(honeycomb(), np.full(36, 0.5), box)
    assert found.border == pytest.approx(1.0 / math.sqrt(3.0))


def test_copies_do_not_depend_on_which_copy_of_the_box_is_meant():
    box, slid = Box(np.array([3.0, 2.0]), 0.2), Box(np.array([3.0, 2.0]), 0.2 + 3 * 1.5)
    place = np.random.default_rng(1).uniform(size=(10, 2)) * box.sides
    one, other = (copies(place, each, 1.0).position for each in (box, slid))
    assert np.sort(one.round(9), axis=0) == pytest.approx(np.sort(other.round(9), axis=0))
    between = place[1:] - place[:-1] + box.tilt @ [2, -1]
    assert nearest(between, box) == pytest.approx(nearest(place[1:] - place[:-1], box))


@pytest.mark.parametrize("turn", [0.0, 0.4, 1.9])
def test_a_rhombus_that_is_squeezed_swaps_once_at_the_square(turn):
    ratios = np.linspace(0.7, 1.4, 8)  # a square at 3.0
    found = neighbor_swaps(courses(ratios, turn=turn))
    assert [(swap.lost, swap.gained) for swap in found.events] == [((0, 1), (2, 3))]
    assert found.times == pytest.approx([3.0], abs=0.05)
    (swap,) = found.events
    assert (swap.loss, swap.gain) == (2.0, 4.0)
    assert swap.duration == swap.gain - swap.loss
    assert swap.place == pytest.approx((0.0, 0.0), abs=1e-12)
    assert found.unpaired == 0


def test_a_square_that_trembles_swaps_no_neighbors():
    random = np.random.default_rng(2)
    ratios = [0.7, 0.9, *(1.0 + 0.03 * random.standard_normal(40)), 0.9, 0.7]
    assert not neighbor_swaps(courses(ratios)).events
    assert len(neighbor_swaps(courses(ratios), firm=0.0).events) > 5


def test_who_swaps_and_swaps_back_makes_two_events():
    found = neighbor_swaps(courses([0.7, 0.9, 1.3, 1.3, 0.9, 0.7]))
    assert [swap.gained for swap in found.events] == [(2, 3), (0, 1)]


def test_a_start_in_the_middle_is_no_event():
    assert not neighbor_swaps(courses([1.0, 1.2, 1.4])).events
    assert not neighbor_swaps(courses([1.0, 0.8, 0.6])).events


def test_a_sheared_honeycomb_swaps_each_of_its_particles_once_as_rows_slide_by_one():
    # Rows slide by one spacing in a strain of 1/ROW; half-way, all squares at once.
    strains = np.arange(0.0, 2.02 / ROW, 0.05)
    found = neighbor_swaps(sheared_honeycomb(strains))
    assert len(found.events) == 2 * 36
    assert found.unpaired == 0
    at = np.interp(found.times, np.arange(len(strains)), strains) * ROW
    assert np.sort(at) == pytest.approx(np.repeat([0.5, 1.5], 36), abs=0.01)
    for particles in found.particles:
        assert len(set(particles.tolist())) == 4


def test_the_same_events_are_found_in_turned_and_renumbered_copies():
    random = np.random.default_rng(7)
    steps = random.standard_normal((30, 40, 2)).cumsum(axis=0) * 0.05
    start = 6.0 * random.uniform(size=(40, 2))
    order = random.permutation(40)
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    frames = [frame_of(start + step, float(time)) for time, step in enumerate(steps)]
    others = [frame_of((start + step)[order] @ turn.T, float(time)) for time, step in enumerate(steps)]
    one, other = neighbor_swaps(frames), neighbor_swaps(others)
    assert len(one.events) > 10
    keys = sorted((round(swap.time, 6), swap.lost, swap.gained) for swap in one.events)
    back = [
        (round(swap.time, 6), *(tuple(sorted(order[list(pair)].tolist())) for pair in (swap.lost, swap.gained)))
        for swap in other.events
    ]
    assert keys == sorted(back)


def test_crossing_a_sheared_border_is_no_event():
    box = Box(np.array([6.0, 6 * ROW]), 0.37)
    start = honeycomb() + np.random.default_rng(4).normal(scale=0.05, size=(36, 2))
    drift = [
        frame_of(wrapped(start + 0.31 * step * np.array([1.0, 0.7]), box), float(step), box=box) for step in range(40)
    ]
    found = neighbor_swaps(drift)
    assert (found.events, found.unpaired) == ((), 0)


def test_contacts_give_the_times_of_separation_and_of_meeting():
    # The sides keep the length 1.1; horizontal 1.05 -> 1.6, vertical the rest.
    across = np.linspace(1.02, 1.62, 61)
    along = 2.0 * np.sqrt(1.0**2 - (across / 2.0) ** 2)
    frames = [
        frame_of([(x / 2, 0), (-x / 2, 0), (0, y / 2), (0, -y / 2)], 0.1 * number)
        for number, (x, y) in enumerate(zip(across, along, strict=True))
    ]
    found = contact_swaps(frames, touch=0.2, apart=0.3)
    (swap,) = found.events
    assert (swap.lost, swap.gained) == ((0, 1), (2, 3))
    assert swap.loss == pytest.approx(0.1 * 28.0)
    wanted = 2.0 * math.sqrt(1.0 - 0.6**2)  # vertical 1.2 where horizontal is 1.6
    assert swap.gain == pytest.approx(0.1 * (wanted - 1.02) / 0.01, abs=1e-3)
    assert found.unpaired == 0


def test_contacts_that_flicker_between_both_gaps_are_no_events():
    random = np.random.default_rng(2)
    frames = courses(1.3 + 0.08 * random.standard_normal(50))
    assert not contact_swaps(frames, touch=0.2, apart=0.5).events


def test_thresholds_the_wrong_way_round_are_refused():
    with pytest.raises(BadInput, match="expected touch <= apart"):
        contact_swaps([], touch=0.2, apart=0.1)


def test_swaps_of_borders_are_a_matter_of_the_plane():
    with pytest.raises(BadInput, match="3 dimensions"):
        neighbor_swaps([frame_of(np.zeros((4, 3)))])
    with pytest.raises(BadInput, match="three particles"):
        neighbor_swaps([frame_of([(0, 0), (1, 0)])])


@pytest.mark.long
@pytest.mark.compiled
def test_the_t1_process_is_found_when_it_happens():
    gap, kappa = 0.03, 1e-3
    known = t1_process(gap=gap, reduced_force=kappa, rtol=1e-7, threshold=0.99)
    interval = known.duration / 200
    scene = t1_scene(gap, (0.0, math.sqrt(3.0) * kappa), "paper", 0.01, 1e-6)
    frames = list(simulate(dataclasses.replace(scene, duration=known.duration, frame_every=interval)))
    (swap,) = neighbor_swaps(frames).events
    across, along = known.curve("gap_horizontal"), known.curve("gap_vertical")
    assert swap.time == pytest.approx(np.interp(0.0, across - along, known.time), abs=0.1 * interval)
    (slow,) = contact_swaps(frames, touch=0.2, apart=0.2).events
    assert slow.loss == pytest.approx(np.interp(0.2, across, known.time), abs=interval)
    assert slow.gain == pytest.approx(np.interp(-0.2, -along, known.time), abs=interval)
    assert 10 * interval < slow.duration < 0.5 * known.duration
