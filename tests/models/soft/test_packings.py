"""Many spheres in a periodic box: random starts, shear, solvers, contacts that open and close."""

import dataclasses
import math

import numpy as np
import pytest

from ecume.errors import SceneError
from ecume.models.model import CROWDED
from ecume.models.soft import SOFT
from ecume.models.soft.cell import Box
from ecume.models.soft.contacts import neighbor_search, tree_search
from ecume.models.soft.contacts.contact_list import new_pairs
from ecume.models.soft.contacts.tree_search import neighbors
from ecume.models.soft.state import ACCEPTED
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate
from tests.models import begun

from .clusters import integrated

pytestmark = [pytest.mark.compiled, pytest.mark.sampled(2)]


def packing(dimensions=2, count=12, filled=0.7, strain=0.05, duration=10.0, **more):
    """A box of unit spheres and of others of 1.3, sheared."""
    volume = count * sum(math.pi * r**2 if dimensions == 2 else 4 / 3 * math.pi * r**3 for r in (1.0, 1.3))
    plain = {
        "model": "soft", "duration": duration, "frame_every": duration, "liquid": {"viscosity": 1e-3},
        "particles": [{"radius": r, "modulus": 1.0, "count": count} for r in (1.0, 1.3)],
        "cell": {"size": [(volume / filled) ** (1 / dimensions)] * dimensions, "minimum_gap": 0.02},
        "protocol": [{"time": 0.0}, {"time": duration, "strain": strain}],
        "integration": {"integrator": "tr-bdf2", "tolerance": 1e-4},
    }  # fmt: skip
    return from_plain(plain | more)


def solved_by(scene, solver):
    return dataclasses.replace(scene, integration=dataclasses.replace(scene.integration, solver=solver))


def test_a_random_start_is_dense_has_its_gaps_and_follows_from_the_seed():
    scene = packing(filled=0.78, count=40)
    parameters = SOFT.parameters(scene)
    first, again = (SOFT.start(scene, parameters) for _ in range(2))
    assert math.exp(first.log_gap[: first.contacts[0]].min()) >= 0.02 * (1 - 1e-9)
    assert first.position.tobytes() == again.position.tobytes()
    other = SOFT.start(dataclasses.replace(scene, seed=5), parameters)
    assert not np.allclose(other.position, first.position)


@pytest.mark.parametrize(("dimensions", "wanted"), [(2, 0.74), (3, 0.5)])
@pytest.mark.parametrize("gap", [0.005, 0.03])
def test_a_start_has_the_volume_fraction_and_the_gap_that_are_wanted(dimensions, wanted, gap):
    box = {"size": [2.0, 1.0, 1.0][:dimensions], "volume_fraction": wanted, "minimum_gap": gap}
    scene = packing(dimensions, count=20, protocol=[], cell=box)
    frame = next(iter(simulate(scene)))
    assert frame.numbers["volume_fraction"] == pytest.approx(wanted, rel=1e-12)
    assert frame.numbers["box_width"] == pytest.approx(2.0 * frame.numbers["box_height"], rel=1e-12)
    assert frame.numbers["smallest_gap"] >= gap * (1 - 1e-9)


def test_a_start_that_does_not_fit_is_refused():
    scene = packing(filled=0.98)
    with pytest.raises(SceneError, match=r"cell\.size: no places were found"):
        SOFT.start(scene, SOFT.parameters(scene))


def test_gaps_that_fill_the_cell_are_refused_without_a_search():
    scene = packing(cell={"size": [12.0, 12.0], "minimum_gap": 20.0}, protocol=[])
    with pytest.raises(SceneError, match=r"cell\.size: spheres with gaps of 20 m would fill [\d.e+]+ times the region"):
        SOFT.start(scene, SOFT.parameters(scene))


@pytest.mark.parametrize(("dimensions", "filled"), [(2, 0.7), (3, 0.5)])
def test_every_solver_finds_the_same_motion(dimensions, filled):
    scene = packing(dimensions, filled=filled, strain=0.01, duration=2.0)
    ends = [integrated(solved_by(scene, solver))[1] for solver in ("dense", "iterative", "direct")]
    for end in ends[1:]:
        assert end.position == pytest.approx(ends[0].position, abs=1e-5)
        assert end.tally[ACCEPTED] == pytest.approx(ends[0].tally[ACCEPTED], abs=2)


def test_shear_to_the_other_side_pulls_to_the_other_side():
    there, back = (list(simulate(packing(strain=sign * 1e-4)))[-1].numbers for sign in (1, -1))
    assert there["shear_stress"] > 0.0
    assert back["shear_stress"] == pytest.approx(-there["shear_stress"], rel=0.01)
    assert abs(there["pressure"]) < 0.5 * there["shear_stress"]


def test_a_box_sheared_by_its_own_width_is_the_box_unsheared():
    scene = packing()
    parameters = SOFT.parameters(scene)
    position, side = SOFT.start(scene, parameters).position, parameters.box[0]
    straight, sheared = (neighbors(parameters, position, Box(parameters.box[:2], tilt)) for tilt in (0.0, side))
    assert straight[0].tolist() == sheared[0].tolist()
    assert straight[2] == pytest.approx(sheared[2], abs=1e-12)


def test_contacts_across_borders_are_found_from_wherever_spheres_have_gone():
    scene = packing()
    parameters = SOFT.parameters(scene)
    position = SOFT.start(scene, parameters).position
    side = parameters.box[0]
    moved = position + side * np.random.default_rng(1).integers(-3, 4, position.shape)
    here, there = (neighbors(parameters, places, Box(parameters.box[:2], 0.0)) for places in (position, moved))
    assert here[0].tolist() == there[0].tolist()
    for places, (pair, image, between) in ((position, here), (moved, there)):
        assert places[pair[:, 1]] - places[pair[:, 0]] + side * image == pytest.approx(between, abs=1e-10)


@pytest.mark.parametrize("dimensions", [2, 3])
def test_pairs_near_one_another_are_those_of_a_search_over_all_copies(dimensions):
    scene = packing(dimensions, filled=0.5)
    parameters = SOFT.parameters(scene)
    position, side = SOFT.start(scene, parameters).position, parameters.box[0]
    pair, image, _ = neighbors(parameters, position, Box(parameters.box[:dimensions], 0.4 * side))
    wanted = []
    for move in np.ndindex(*(5,) * dimensions):
        copy = np.array(move) - 2
        there = position + copy * side
        there[:, 0] += 0.4 * side * copy[1]
        gap = np.linalg.norm(there[None] - position[:, None], axis=2) - np.add.outer(*[parameters.radius] * 2)
        for i, j in np.argwhere(gap < parameters.contacts.fade_from):
            if i < j or (i == j and tuple(copy) > (0,) * dimensions):
                wanted.append((int(i), int(j), *copy.tolist()))
    assert [(*p, *i) for p, i in zip(pair.tolist(), image.tolist(), strict=True)] == sorted(wanted)


@pytest.mark.parametrize("dimensions", [pytest.param(2, marks=pytest.mark.long), 3])
def test_cells_find_the_pairs_of_the_tree_in_its_order_with_its_bits(monkeypatch, dimensions):
    """In a box so small that spheres meet several copies of each other, at tilts beyond half a box, and with room for
    too few neighbors at first.
    """
    scene = packing(dimensions, count=6, filled=0.5)
    parameters = SOFT.parameters(scene)
    position = SOFT.start(scene, parameters).position + 3.0 * parameters.box[0]
    parameters = parameters._replace(contacts=parameters.contacts._replace(fade_from=0.9 * parameters.box[0]))
    for tilt in (0.0, 0.4, -1.7):
        box = Box(parameters.box[:dimensions], tilt * parameters.box[0])
        by_tree = neighbors(parameters, position, box)
        monkeypatch.setattr(tree_search, "CELL_SEARCH_FROM", 1)
        monkeypatch.setattr(neighbor_search, "ROOM", 2)
        by_cells = neighbors(parameters, position, box)
        monkeypatch.undo()
        assert len(by_tree[0]) > len(np.unique(by_tree[0], axis=0))
        assert [each.tobytes() for each in by_cells] == [each.tobytes() for each in by_tree]


def test_newcomers_are_near_and_not_in_contact():
    scene = packing()
    parameters = SOFT.parameters(scene)
    state, box = SOFT.start(scene, parameters), Box(parameters.box[:2], 0.0)
    pair, image, between = neighbors(parameters, state.position, box)
    for left_out in ([], [0], [3, 4, len(pair) - 1], range(len(pair))):
        known = np.delete(pair, left_out, axis=0), np.delete(image, left_out, axis=0)
        found = new_pairs(parameters, state.position, box, known)
        assert [each.tolist() for each in found] == [each[list(left_out)].tolist() for each in (pair, image, between)]


def test_interruptions_change_no_bit_while_contacts_come_and_go():
    scene = packing(strain=0.3, duration=30.0)
    whole, pieces = integrated(scene, parts=10**9)[1], integrated(scene, parts=2)[1]
    assert whole.generation[0] > 3
    for name, array in whole._asdict().items():
        assert array.tobytes() == getattr(pieces, name).tobytes(), name


def test_a_film_that_is_drawn_out_fades_without_a_jump_and_is_gone():
    plain = {
        "model": "soft", "duration": 3e3, "frame_every": 30.0, "liquid": {"viscosity": 0.1},
        "hydrodynamics": {"drag": "stokes"},
        "films": {"cutoff": 0.3}, "particles": [
            {"radius": 1.0, "modulus": 1.0, "positions": [[-1.05, 0.0]], "force": [-1e-3, 0.0]},
            {"radius": 1.0, "modulus": 1.0, "positions": [[1.05, 0.0]], "force": [1e-3, 0.0]},
        ],
    }  # fmt: skip
    frames = list(simulate(from_plain(plain)))
    tension = np.array([frame.arrays["tension"][0, 0] for frame in frames])
    assert tension.max() > 5e-4
    assert frames[-1].numbers["contacts"] == 0.0
    last = np.flatnonzero(tension)[-1]
    assert 0.0 < tension[last] < 5e-5
    speed = frames[-1].arrays["velocity"][1, 0]
    assert speed == pytest.approx(1e-3 / (6 * math.pi * 0.1), rel=1e-6)


def test_a_workspace_of_other_contacts_is_not_used():
    scene = packing()
    parameters, state, work = begun(scene)
    state.generation[0] += 1
    assert SOFT.advance(parameters, state, work, 1) == CROWDED
