"""Many floats with hydrodynamic interaction: sums on a grid, compared with the matrix."""

import math
import os

import numba
import numpy as np
import pytest

from ecume.laws.pair_mobility import compact_raft, surface_mobility
from ecume.models import MODELS
from ecume.models.floating.coupled import many_floats
from ecume.models.floating.coupled.many_floats import (
    ERROR,
    MATRIX_UP_TO,
    best_spacing,
    flow_divergence,
    flow_product,
    place_flow_grid,
)
from ecume.models.floating.coupled.mobility import CoupledKicks, GridKicks, add_divergence
from ecume.models.floating.setup import hydrodynamic_interaction
from tests.models.floating.bowls import WATER, scene_of

FLOATING = MODELS["floating"]
PLAIN = os.environ.get("NUMBA_DISABLE_JIT") == "1"
plain = pytest.mark.uncompiled


@pytest.fixture
def few_are_many(monkeypatch):
    """A function that sets the largest number of floats with a matrix."""
    return lambda count: monkeypatch.setattr(hydrodynamic_interaction, "MATRIX_UP_TO", count)


@pytest.fixture
def fine(monkeypatch):
    """Use grids as fine as those of thousands of floats, for which few pairs are summed directly."""
    monkeypatch.setattr(many_floats, "PAIR", 1000.0)


def packing(count, spread, seed=3):
    """Separate and overlapping spheres of unequal radii."""
    dice = np.random.default_rng(seed)
    radius = 1e-4 * np.exp(spread * dice.normal(size=count))
    return dice.uniform(-1.0, 1.0, (count, 2)) * [3e-3, 1e-3], radius, dice.normal(size=(count, 2))


@plain
@pytest.mark.parametrize("spread", [0.0, 0.4])
def test_products_and_drifts_are_those_of_the_matrix(fine, spread):
    position, radius, force = packing(90, spread)
    grid = place_flow_grid(position, radius, 0.02, True)
    assert len(grid.near.partner) < 0.7 * 90**2
    expected = (surface_mobility(position, radius, 0.02) @ force.ravel()).reshape(-1, 2)
    found = flow_product(grid, force)
    assert np.sqrt(np.mean((found - expected) ** 2) / np.mean(expected**2)) < ERROR
    drift = np.zeros(180)
    add_divergence((), CoupledKicks(radius, np.zeros(0), 0.02, 1.0), position, drift)
    assert np.abs(flow_divergence(grid, position).ravel() - drift).max() < 2.0 * ERROR * np.abs(drift).max()
    # Symmetric: the velocity of one float by a force on another is that of the other by a force on the one.
    other = np.random.default_rng(5).normal(size=(90, 2))
    assert np.sum(other * found) == pytest.approx(np.sum(force * flow_product(grid, other)), rel=1e-12)


@plain
def test_a_raft_in_a_wide_sea_has_a_grid_of_its_own_scale():
    raft = 1e-4 * compact_raft(50)
    apart = np.concatenate([raft, np.add(raft, [1.0, 0.0])])
    assert best_spacing(apart, np.full(100, 1e-4)) > 2.0 * best_spacing(raft, np.full(50, 1e-4))
    position, radius = np.concatenate([raft[:5], np.add(raft[:5], [1.0, 0.0])]), np.full(10, 1e-4)
    force = np.random.default_rng(1).normal(size=(10, 2))
    expected = (surface_mobility(position, radius, 1.0) @ force.ravel()).reshape(-1, 2)
    found = flow_product(place_flow_grid(position, radius, 1.0, False), force)
    assert found == pytest.approx(expected, abs=ERROR * np.abs(expected).max())


def raft_scene(more="", *, count=60, radius=3e-4, squeezed=1.02, flow="", **times):
    places = radius * squeezed * compact_raft(count)
    body = f"[[particles]]\nradius = {radius}\ndensity = 1300.0\ncontact_angle = 1.5\npositions = {places.tolist()}\n"
    motion = '[integration]\nintegrator = "overdamped"\n[hydrodynamics]\ninteraction = "rotne-prager"\n'
    return scene_of(f"{WATER.replace('1 mPa', '20 mPa')}{body}{flow}{motion}{more}", **times)


def after(scene, steps, *, pauses=1):
    parameters = FLOATING.parameters(scene)
    state = FLOATING.start(scene, parameters)
    for _ in range(pauses):
        workspace = FLOATING.workspace(parameters, state, 1.0)
        assert FLOATING.advance(parameters, state, workspace, steps // pauses) == 0
    return parameters, state, workspace


@pytest.mark.long
@plain
def test_a_raft_that_is_pressed_together_moves_as_with_the_matrix(fine, few_are_many):
    flow = "[flow]\nextension_rate = 0.05\nrotation_rate = 0.02\n"
    scene = raft_scene(flow=flow, count=19, squeezed=1.004, duration=4.0, frame_every=4.0)
    parameters, expected, _ = after(scene, 4)
    few_are_many(10)
    on_grid, found, workspace = after(scene, 4)
    assert isinstance(on_grid.parts.integrator, GridKicks)
    far = expected.position - parameters.floats.radius[0] * 1.004 * compact_raft(19)
    assert found.position - expected.position == pytest.approx(0.0 * far, abs=1e-3 * np.abs(far).max())
    numbers = FLOATING.observe(on_grid, found, workspace).numbers
    assert numbers["unconverged_steps"] == 0
    assert numbers["contacts"] >= 20
    assert numbers["deepest_overlap"] < on_grid.slop
    # The forces of contacts are equal and opposite.
    load = workspace.scratch.integrator.load.reshape(-1, 2)
    assert np.abs(load.sum(axis=0)).max() < 1e-9 * np.abs(load).max()
    assert np.abs(load - workspace.force).max() > 0.1 * np.abs(workspace.force).max()


@pytest.mark.long
@plain
def test_noise_is_that_of_the_matrix_and_half_a_run_and_half_a_run_are_a_run(fine, few_are_many):
    scene = raft_scene("brownian = true\n", radius=1e-6, squeezed=1.3, duration=1.0, frame_every=1.0)
    _, expected, _ = after(scene, 1)
    few_are_many(10)
    _, whole, _ = after(scene, 2)
    _, halves, _ = after(scene, 2, pauses=2)
    _, found, _ = after(scene, 1)
    assert np.abs(found.velocity - expected.velocity).max() < 1e-3 * np.abs(expected.velocity).max()
    assert all(np.array_equal(one, other) for one, other in zip(whole, halves, strict=True))


@plain
@pytest.mark.parametrize(
    ("more", "many"),
    [("", True), ("lubrication = { roughness = 1e-8 }\n", False), ("[contacts]\nfriction = 0.3\n", False)],
)
def test_many_floats_have_no_matrix_unless_films_or_friction_need_one(few_are_many, more, many):
    few_are_many(20)
    assert isinstance(FLOATING.parameters(raft_scene(more, count=21)).parts.integrator, GridKicks) is many
    assert not isinstance(FLOATING.parameters(raft_scene(more, count=20)).parts.integrator, GridKicks)
    assert MATRIX_UP_TO == 1000


@plain
def test_check_names_the_accuracy_of_the_grid(few_are_many):
    few_are_many(20)
    scene = raft_scene(count=21)
    remarks = [remark for *_, remark in FLOATING.summary(scene)]
    assert any("summed on a grid, velocities within 0.0001" in remark for remark in remarks)


@pytest.mark.long
@pytest.mark.skipif(PLAIN, reason="plain Python has one thread")
def test_the_bits_do_not_depend_on_the_number_of_threads():
    position, radius, force = packing(5000, 0.2)
    found = []
    for threads in (1, numba.config.NUMBA_NUM_THREADS):
        numba.set_num_threads(threads)
        grid = place_flow_grid(position, radius, 0.02, True)
        found.append((flow_product(grid, force), flow_divergence(grid, position)))
    assert all(np.array_equal(one, other) for one, other in zip(*found, strict=True))


def test_the_extent_is_rounded_up_so_that_the_flow_is_transformed_once():
    shapes = {many_floats.shape_around(np.array([1.0, 1.0]) * (1.0 + 0.001 * k), 0.01) for k in range(20)}
    assert len(shapes) <= 2
    assert min(min(shape) for shape in shapes) >= 2.0 * math.ceil(1.0 / 0.01)
