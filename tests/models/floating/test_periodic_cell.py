"""Floats in a periodic cell: nearest images, contacts across borders, invariances, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import k1

from ecume.errors import SceneError
from ecume.models.floating import FLOATING
from ecume.models.floating.time_integration.integration import forces_at
from ecume.models.liquids import liquid_of
from ecume.models.model import DONE
from tests.models import begun
from tests.models.floating.bowls import HEAVY, LIGHT, WATER, scene_of

SIDES = np.array([0.06, 0.08])
PLAIN = pytest.mark.uncompiled
CELL = f"[cell]\nsize = {SIDES.tolist()}\n"
DRY = '[hydrodynamics]\ndrag = "none"\n'


def floats_at(positions, *, velocities=None, kind=HEAVY):
    moving = "" if velocities is None else f"velocities = {np.asarray(velocities).tolist()}\n"
    return f"[[particles]]\n{kind}positions = {np.asarray(positions).tolist()}\n{moving}"


def advanced(scene, steps):
    parameters, state, workspace = begun(scene)
    assert FLOATING.advance(parameters, state, workspace, steps) == DONE
    return FLOATING.observe(parameters, state, workspace)


def spread(count, seed, apart=2.2e-3, sides=SIDES):
    """Positions in the cell whose nearest images keep a distance; the first ones lie at borders and in a corner."""
    chance = np.random.default_rng(seed)
    found = [np.array([1e-4, 1e-4]), sides - [3e-3, 5e-4], np.array([0.5 * sides[0], sides[1] - 1e-5])]
    while len(found) < count:
        point = chance.random(2) * sides
        away = point - np.array(found)
        away -= sides * np.round(away / sides)
        if np.linalg.norm(away, axis=1).min() > apart:
            found.append(point)
    return np.array(found)


def test_forces_are_the_sum_over_all_images():
    position = spread(10, 1)
    scene = scene_of(WATER + floats_at(position[:6]) + floats_at(position[6:], kind=LIGHT) + CELL)
    parameters, state, workspace = begun(scene)
    force, liquid = forces_at(parameters, state.position, workspace), liquid_of(scene)
    charge, length = parameters.floats.charge, liquid.capillary_length
    direct, cut = np.zeros_like(force), np.zeros_like(force)
    for shift in np.ndindex(9, 9):
        apart = position - position[:, None] + SIDES * (np.array(shift) - 4)
        distance = np.linalg.norm(apart, axis=2)
        with np.errstate(divide="ignore", invalid="ignore"):
            pull = 2.0 * np.pi * liquid.surface_tension * charge * charge[:, None] * k1(distance / length) / length
            each = np.where(distance[:, :, None] > 0.0, (pull / distance)[:, :, None] * apart, 0.0)
        direct += each.sum(axis=1)
        cut += np.where(distance[:, :, None] < parameters.cutoff, each, 0.0).sum(axis=1)
    assert force == pytest.approx(cut, rel=1e-9, abs=1e-9 * np.abs(force).max())
    assert force == pytest.approx(direct, abs=scene.interaction.accuracy * np.abs(force).max())


def test_check_compares_the_cell_with_the_cutoff():
    scene = scene_of(WATER + floats_at(spread(10, 1)) + CELL)
    ((_, sides, remark),) = (row for row in FLOATING.summary(scene) if row[0] == "cell")
    parameters = FLOATING.parameters(scene)
    cover = 1000.0 * np.pi * parameters.floats.radius[0] ** 2 / np.prod(SIDES)
    assert sides == "60 mm x 80 mm"
    assert remark == f"periodic, {0.06 / parameters.cutoff:.3g} cutoffs wide; floats cover {cover:.3g} %"
    assert not any(row[0] == "cell" for row in FLOATING.summary(scene_of(WATER + floats_at(spread(10, 1)))))


OVAL = 'shape = { kind = "ellipsoid", width = "1.9 mm", angle = 0.3 }\n'


@pytest.mark.parametrize(
    ("contacts", "shape"),
    [("", ""), ("friction = 0.3\n", ""), ('law = "spring-dashpot"\n', ""), pytest.param("", OVAL, marks=PLAIN)],
)
def test_shifting_all_floats_changes_nothing(contacts, shape):
    position = np.array([[1e-4, 1e-4], [0.0579, 2e-4], [0.0011, 0.0782], [0.03, 0.0795], [0.0305, 0.0018]])
    velocity = np.array([[-0.08, 0.0], [0.08, 0.0], [0.0, 0.04], [0.0, 0.12], [0.0, -0.12]])
    rest = f"{CELL}{DRY}[contacts]\nrestitution = 0.5\n{contacts}"
    frames = []
    for shift in (np.zeros(2), np.array([0.0471, 0.0233])):
        floats = floats_at(position + shift, velocities=velocity, kind=HEAVY + shape)
        scene = scene_of(WATER + floats + rest, frame_every=1e-2)
        parameters, state, workspace = begun(scene)
        assert FLOATING.advance(parameters, state, workspace, int(4e-3 / parameters.time_step)) == DONE
        frames.append(FLOATING.observe(parameters, state, workspace))
    one, other = (frame.arrays for frame in frames)
    moved = other["position"] - one["position"] - [0.0471, 0.0233]
    assert np.abs(moved - SIDES * np.round(moved / SIDES)).max() <= 1e-12 * SIDES.max()
    assert other["velocity"] == pytest.approx(one["velocity"], abs=1e-10)
    bounced = (one["velocity"] - velocity)[[0, 1, 3, 4]]
    assert np.abs(bounced).max(axis=1).min() > 1e-2, "both pairs meet images across a border"
    assert np.all((one["position"] >= 0.0) & (one["position"] < SIDES))


def test_momentum_is_conserved_while_floats_collide_across_borders():
    chance = np.random.default_rng(5)
    position = spread(12, 2, apart=2.05e-3)
    scene = scene_of(WATER + floats_at(position, velocities=0.05 * chance.normal(size=(12, 2))) + CELL + DRY)
    parameters, state, workspace = begun(scene)
    before = parameters.floats.mass @ state.velocity
    assert FLOATING.advance(parameters, state, workspace, 40) == DONE
    largest = np.abs(parameters.floats.mass[:, None] * state.velocity).max()
    assert parameters.floats.mass @ state.velocity == pytest.approx(before, abs=1e-12 * largest)
    assert "momentum" in [row.name for row in FLOATING.invariants(scene, parameters)]


def test_two_floats_collide_across_a_border_as_in_the_middle():
    def after(middle):
        ends = [[middle - 1.1e-3, 0.04], [middle + 1.1e-3, 0.04]]
        floats = floats_at(ends, velocities=[[0.02, 0.0], [-0.02, 0.0]])
        law = '[interaction]\nlaw = "none"\n[contacts]\nrestitution = 0.5\n'
        return advanced(scene_of(WATER + floats + CELL + DRY + law, frame_every=1e-2), 30)

    inside, across = after(0.03), after(0.0)
    assert inside.numbers["collisions"] == across.numbers["collisions"] > 0.0
    assert across.arrays["velocity"] == pytest.approx(inside.arrays["velocity"], abs=1e-12)
    assert across.arrays["velocity"][:, 0] == pytest.approx([-0.01, 0.01], rel=1e-6)


def test_touching_floats_on_both_sides_of_a_border_are_one_cluster():
    scene = scene_of(WATER + floats_at([[0.0590, 0.04], [0.0010, 0.04], [0.03, 0.04]]) + CELL)
    numbers = advanced(scene, 1).numbers
    assert (numbers["contacts"], numbers["clusters"]) == (1.0, 2.0)
    assert (numbers["box_width"], numbers["box_height"]) == tuple(SIDES)
    assert "angular_momentum" not in numbers


def test_given_floats_must_not_overlap_an_image():
    with pytest.raises(SceneError, match=r"overlaps particles\[0\].positions\[1\] by"):
        begun(scene_of(WATER + floats_at([[0.0595, 0.04], [0.0005, 0.04]]) + CELL))


def test_a_run_goes_on_from_its_state_bit_by_bit():
    scene = scene_of(WATER + floats_at(spread(8, 3), velocities=np.full((8, 2), 0.05)) + CELL)
    parameters, state, workspace = begun(scene)
    assert FLOATING.advance(parameters, state, workspace, 12) == DONE
    once = state
    parameters, state, workspace = begun(scene)
    assert FLOATING.advance(parameters, state, workspace, 5) == DONE
    fresh = FLOATING.workspace(parameters, state, 1.0)
    assert FLOATING.advance(parameters, state, fresh, 7) == DONE
    assert all(np.array_equal(a, b) for a, b in zip(once, state, strict=True))


def test_the_area_fraction_sets_the_size_of_the_cell():
    law = '[interaction]\nlaw = "none"\n'
    scene = scene_of(f"{WATER}[[particles]]\n{HEAVY}count = 30\n[cell]\nsize = [3, 1]\narea_fraction = 0.3\n{law}")
    width, height = FLOATING.parameters(scene).periods[0]
    assert width == pytest.approx(3.0 * height)
    assert 30.0 * np.pi * 1e-6 / (width * height) == pytest.approx(0.3)


@pytest.mark.parametrize(("placement", "extra"), [("lattice", "spacing = 3e-3\n"), ("ring", "ring_radius = 0.01\n")])
def test_arrangements_are_around_the_center_of_the_cell(placement, extra):
    floats = f'[[particles]]\n{HEAVY}count = 7\nplacement = "{placement}"\n{extra}'
    state = begun(scene_of(WATER + floats + CELL))[1]
    assert state.position.mean(axis=0) == pytest.approx(0.5 * SIDES)


REFUSED = {
    "an attraction that reaches farther than half a side": (
        "[cell]\nsize = [0.05, 0.06]\n",
        r"cell.size: got 50 mm as the shorter side; expected at least 58.72 mm: the attraction reaches 29.36 mm, .*"
        r"interaction.accuracy = 0.00047 would accept",
    ),
    "a dish": (f"{CELL}[dish]\nradius = 0.1\n", r"cell: is periodic along both axes"),
    "multipoles": (f'{CELL}[interaction]\nmethod = "multipole"\n', r"'multipole' needs a dish or an infinite surface"),
    "a grid": (f'{CELL}[interaction]\nsummation = "grid"\n', r"'grid' needs a dish or an infinite surface"),
    "a flow with a gradient": (f"{CELL}[flow]\nshear_rate = 1.0\n", r"its velocity differs on opposite borders"),
    "films that are longer than half a side": (
        '[cell]\nsize = [0.01, 0.01]\n[interaction]\nlaw = "none"\n[integration]\nintegrator = "overdamped"\n'
        "[hydrodynamics]\nlubrication = { roughness = 1e-6, cutoff = 6 }\n",
        r"expected at least 12 mm: a film reaches 6 mm",
    ),
    "contacts that are longer than half a side": (
        '[cell]\nsize = [0.003, 0.01]\n[interaction]\nlaw = "none"\n',
        r"expected at least 4 mm: a contact of the largest floats reaches 2 mm",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_a_cell_is_refused_with(case):
    rest, expected = REFUSED[case]
    with pytest.raises(SceneError, match=expected):
        FLOATING.parameters(scene_of(f"{WATER}[[particles]]\n{HEAVY}count = 2\n{rest}"))


def test_a_cell_far_wider_than_any_force_is_accepted():
    rest = "[cell]\nsize = [1, 1]\narea_fraction = 3e-9\n"
    parameters = FLOATING.parameters(scene_of(f"{WATER}[[particles]]\ncount = 4\n{HEAVY}{rest}"))
    assert 1000.0 * parameters.cutoff < parameters.periods[0].min()


def test_the_advised_accuracy_accepts_the_cell():
    rest = "[cell]\nsize = [0.05, 0.06]\n[interaction]\naccuracy = 0.00047\n"
    parameters = FLOATING.parameters(scene_of(f"{WATER}[[particles]]\n{HEAVY}count = 2\n{rest}"))
    assert 0.024 < parameters.cutoff <= 0.025


def test_a_uniform_flow_carries_floats_through_the_borders():
    scene = scene_of(WATER + floats_at([[0.059, 0.079]], velocities=[[0.3, 0.2]]) + CELL
                     + "[flow]\nvelocity = [0.3, 0.2]\n", frame_every=1e-2)  # fmt: skip
    parameters, state, workspace = begun(scene)
    steps = int(0.02 / parameters.time_step)
    assert FLOATING.advance(parameters, state, workspace, steps) == DONE
    time = steps * parameters.time_step
    expected = np.mod([0.059 + 0.3 * time, 0.079 + 0.2 * time], SIDES)
    assert FLOATING.observe(parameters, state, workspace).arrays["position"][0] == pytest.approx(expected, abs=1e-9)


def test_a_cell_for_floats_without_attraction_may_be_small():
    small = "[cell]\nsize = [0.01, 0.01]\n"
    with pytest.raises(SceneError, match=r'interaction.law = "none" leaves the attraction out'):
        FLOATING.parameters(scene_of(WATER + floats_at([[2e-3, 2e-3], [6e-3, 6e-3]]) + small))
    scene = scene_of(WATER + floats_at([[2e-3, 2e-3], [6e-3, 6e-3]]) + small + '[interaction]\nlaw = "none"\n')
    rows = {name: (value, remark) for name, value, remark in FLOATING.summary(scene)}
    assert rows["cell"][1].startswith("periodic, floats cover")
    assert "cutoff" not in rows
    parameters = FLOATING.parameters(scene)
    assert parameters.cutoff == pytest.approx(2.0 * parameters.floats.radius.max())
