"""What the page is given is what the frames hold, to the steps of its numbers."""

import gzip
from typing import NamedTuple

import numpy as np
import pytest

from ecume.show.view.chunks import FEW_STEPS, STEPS, moves, pack, quantities
from ecume.show.view.scenery import Stage
from ecume.trajectories.frame import Frame

KINDS = {"u1": np.uint8, "u2": np.uint16, "f4": np.float32}
PLAIN = Stage(np.zeros(2), np.ones(2), [])


def frames(count=4, particles=7, seed=3):
    rng = np.random.default_rng(seed)
    still = {"radius": rng.uniform(1.0, 2.0, particles), "species": np.arange(particles) % 3}
    return [
        Frame(
            0.5 * step,
            {
                "position": rng.normal(size=(particles, 2)),
                "velocity": rng.normal(size=(particles, 2)),
                "charge": rng.normal(size=particles),
                **still,
            },
            {"kinetic_energy": float(step) ** 2},
            {},
        )
        for step in range(count)
    ]


def summed(coded, rows):
    """As the page adds up how far numbers went from frame to frame."""
    low, high = np.frombuffer(coded, np.uint8).reshape(2, rows, -1).astype(np.int64)
    folded = low + 256 * high
    turned = np.where(folded % 2, -(folded // 2) - 1, folded // 2)
    return np.cumsum(turned, axis=0).ravel() % (STEPS + 1)


def unpacked(chunk, name, top=None):
    """As the page reads an array: steps from the least to the largest."""
    place = chunk.header["places"][name]
    kind = KINDS[place["kind"]]
    raw = np.frombuffer(chunk.blob, kind, place["length"], place["offset"])
    if "rows" in place:
        raw = summed(chunk.blob[place["offset"] :][: 2 * place["length"]], place["rows"])
    if place["kind"] == "f4" or name not in chunk.header["ranges"]:
        return raw
    low, high = chunk.header["ranges"][name]
    return low + (high - low) / (STEPS if place["kind"] == "u2" else FEW_STEPS) * raw


def test_positions_come_back_to_half_a_step():
    given = frames()
    chunk = pack(given, PLAIN)
    low, high = chunk.header["ranges"]["position"]
    wanted = np.concatenate([frame.arrays["position"].ravel() for frame in given])
    assert (low, high) == (wanted.min(), wanted.max())
    np.testing.assert_allclose(unpacked(chunk, "position"), wanted, rtol=0, atol=0.501 * (high - low) / STEPS)


@pytest.mark.parametrize(
    "steps", [[[0, 65535, 7], [65535, 0, 7]], [[1, 2, 3]], [[9, 9, 9], [8, 40000, 9], [0, 1, 65535]]]
)
def test_moves_add_up_to_the_numbers(steps):
    assert summed(moves(np.array(steps, float)), len(steps)).tolist() == np.ravel(steps).tolist()


def test_what_moves_little_takes_little():
    rng = np.random.default_rng(1)
    steps = rng.uniform(5000.0, 60000.0, 2000) + np.cumsum(rng.integers(-40, 41, (50, 2000)), axis=0)
    assert len(gzip.compress(moves(steps), 6)) < 0.52 * steps.size * 2
    assert len(gzip.compress(steps.astype("<u2").tobytes(), 6)) > 0.8 * steps.size * 2


class Links(NamedTuple):
    pairs: np.ndarray
    along: np.ndarray
    gap: np.ndarray
    tension: np.ndarray


def linked(count, box=10.0):
    """Particles in a row across a border of a periodic box, each in contact with the next, fewer in each frame."""
    rng, frames = np.random.default_rng(2), {}
    for step in range(count):
        place = np.column_stack([(0.5 + np.arange(10) + 3.3 * step) % box, rng.uniform(0.0, 1.0, 10)])
        pairs = np.array([(i, (i + 1) % 10) for i in range(10 - step)])
        along = place[pairs[:, 1]] - place[pairs[:, 0]]
        along[:, 0] -= box * np.rint(along[:, 0] / box)
        frames[float(step)] = (
            place,
            Links(pairs, along, rng.uniform(1e-6, 1e-2, len(pairs)), rng.normal(size=len(pairs))),
        )
    return frames


def test_contacts_come_back_from_their_particles_and_the_way_across_a_border():
    output = linked(3)
    given = [Frame(time, {"position": place}, {}, {}) for time, (place, _) in output.items()]
    chunk = pack(given, PLAIN._replace(links=lambda frame: output[frame.time][1]))
    pairs, ways = unpacked(chunk, "links/pairs").reshape(-1, 2), unpacked(chunk, "links/ways")
    across = unpacked(chunk, "links/across").reshape(3, -1, 2)
    assert chunk.header["links"] == [10, 9, 8]
    assert across.shape[1] == 2
    begin = 0
    for step, (place, links) in enumerate(output.values()):
        here = slice(begin, begin + len(links.gap))
        first, second = pairs[here].T
        assert place[second] - place[first] + across[step][ways[here]] == pytest.approx(links.along, abs=1e-5)
        assert np.log(links.gap) == pytest.approx(unpacked(chunk, "links/gap")[here], abs=0.02)
        assert links.tension == pytest.approx(unpacked(chunk, "links/tension")[here], abs=0.02)
        begin = here.stop


def test_two_thousand_spheres_in_contact_fit_into_the_page_that_is_wanted():
    """Two hundred frames of them, with all their contacts, in 8 MB: judged by thirty of a crowd that jostles."""
    rng, output = np.random.default_rng(1), {}
    lattice = np.stack(np.meshgrid(np.arange(45), np.arange(45)), -1).reshape(-1, 2)[:2000].astype(float)
    pairs = np.array([(i, j) for i in range(2000) for j in (i + 1, i + 45, i + 46) if j < 2000])
    place, spin, tension = lattice, np.zeros(2000), np.zeros(len(pairs))
    for step in range(30):
        place, spin = place + rng.normal(size=place.shape) * 0.004, spin + rng.normal(size=2000)
        tension = tension + 0.05 * rng.normal(size=len(pairs))
        gone = rng.random(len(pairs)) > 0.02
        along = place[pairs[:, 1]] - place[pairs[:, 0]]
        gap = 0.01 + 0.001 * rng.random(len(pairs))
        output[float(step)] = place, spin, Links(*(column[gone] for column in (pairs, along, gap, tension)))
    given = [Frame(time, {"position": each[0], "spin": each[1]}, {}, {}) for time, each in output.items()]
    chunk = pack(given, PLAIN._replace(links=lambda frame: output[frame.time][2]))
    assert len(gzip.compress(chunk.blob, 6)) * 4 / 3 * 200 / 30 < 8e6


def test_what_never_changes_stands_once():
    chunk = pack(frames(), PLAIN)
    assert set(chunk.header["steady"]) == {"array/radius", "array/species"}
    assert chunk.header["places"]["array/radius"]["length"] == 7
    assert unpacked(chunk, "array/species").tolist() == [0, 1, 2, 0, 1, 2, 0]
    assert chunk.header["places"]["array/charge"]["length"] == 28


def test_of_velocities_the_speed_is_shown():
    frame = frames(1)[0]
    assert "velocity" not in quantities(frame)
    np.testing.assert_allclose(quantities(frame)["speed"], np.hypot(*frame.arrays["velocity"].T), rtol=1e-14)


def test_numbers_of_the_whole_stand_beside_them():
    assert unpacked(pack(frames(), PLAIN), "number/kinetic_energy").tolist() == [0.0, 1.0, 4.0, 9.0]


def test_a_growing_number_of_particles_is_in_each_chunk():
    given = [frames(1, particles)[0] for particles in (3, 5)]
    chunk = pack(given, PLAIN)
    assert chunk.header["counts"] == [3, 5]
    assert "array/radius" not in chunk.header["steady"]
    assert chunk.header["places"]["array/radius"]["length"] == 8


@pytest.mark.parametrize("values", [[1.0, np.nan, 3.0], [1e-9, 1e-3, 1.0], [1.0, np.inf, 2.0]])
def test_what_steps_would_spoil_is_kept_as_it_is(values):
    frame = Frame(0.0, {"position": np.zeros((3, 2)), "gap": np.array(values)}, {}, {})
    np.testing.assert_array_equal(unpacked(pack([frame], PLAIN), "array/gap"), np.float32(values))


def test_one_peak_does_not_pale_all_others():
    pressure = np.append(np.linspace(0.0, 1.0, 1000), 1e6)
    frame = Frame(0.0, {"position": np.zeros((1001, 2)), "pressure": pressure}, {}, {})
    low, high = pack([frame], PLAIN).header["scales"]["array/pressure"]
    assert 0.0 <= low < 0.01
    assert 0.99 < high < 1.01


def test_places_are_where_arrays_of_the_browser_may_begin():
    places = pack(frames(particles=5), PLAIN).header["places"].values()
    assert all(place["offset"] % 4 == 0 for place in places)


def test_tracers_that_left_are_not_drawn_nor_set_the_range_of_colors_and_those_on_walls_remain():
    """Opening 0 and, after it in `left`, a wall that holds particles."""
    numbers = {"left_through_opening_0": 0.0, "deposited_on_wall_1": 0.0}
    given = [
        frame.with_arrays({**frame.arrays, "speed": np.array([9.0, *np.linspace(1.0, 2.0, 6)]),
                           "left": np.array([0, 1, *[-1] * 5]) if number else np.full(7, -1)})._replace(numbers=numbers)
        for number, frame in enumerate(frames(2))
    ]  # fmt: skip
    chunk = pack(given, PLAIN)
    radius = unpacked(chunk, "array/radius").reshape(2, 7)
    whole = given[0].arrays["radius"]
    step = (whole.max() - 0.0) / STEPS
    assert radius[0] == pytest.approx(whole, abs=step)
    assert radius[1] == pytest.approx([0.0, *whole[1:]], abs=step)
    assert chunk.header["counts"] == [7, 7], "each particle keeps its number"
    assert pack(given[1:], PLAIN).header["scales"]["array/speed"][1] < 2.1
