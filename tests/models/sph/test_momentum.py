"""The forces recorded on walls and solids are the reaction to all forces on the liquid."""

import numpy as np
import pytest

from ecume.models.sph import SPH
from ecume.models.sph.boundaries.forces_on_solids import reversed_lists
from ecume.models.sph.boundaries.rigid_bodies import with_moved_solids
from ecume.models.sph.integration.time_stepping import resolve_collisions
from ecume.models.sph.rates.right_hand_side import evaluate_accelerations, evaluate_density_rate
from ecume.scenes.schema import from_plain
from ecume.simulation import Integration
from tests.models.sph.random_closed_tanks import at_this_step
from tests.models.sph.scenes import OPEN


def scattered(seed, walls, **method):
    """A pool with a body and an obstacle close to walls of random places, and its run at rest."""
    rng = np.random.default_rng([38, seed])
    x, y = rng.uniform(0.15, 0.3, 2)
    shapes = [{"center": [x, y], "radius": 0.15}, {"low": [0.6, 0.0], "high": [0.8 + 0.2 * (seed % 2), 0.3]}]
    body, obstacle = shapes if rng.uniform() < 0.6 else shapes[::-1]
    scene = from_plain(
        {
            "model": "sph", "duration": 1.0, "frame_every": 0.1, "spacing": 0.1, "gravity": [0.3, -1.0],
            "liquid": {"density": 1.0, "viscosity": method.pop("viscosity", 0.0)},
            "tank": {"high": [1.0, 1.5], "top": OPEN, "walls": walls},
            "fluid": [{"low": [0.0, 0.0], "high": [1.0, 0.7]}],
            "bodies": [{**body, "density": 1.5}], "obstacles": [obstacle], "method": {"jitter": 0.15, **method},
        }
    )  # fmt: skip
    parameters = SPH.parameters(scene)
    run = Integration(SPH, parameters, SPH.start(scene, parameters), 1.0)
    run.state.velocity[...] = rng.normal(0.0, 0.1, run.state.velocity.shape)
    return run


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize(
    ("walls", "method"),
    [
        ("mirror", {}), ("dummy", {}), ("mirror", {"viscosity": 0.01}), ("mirror", {"pressure_force": "corrected"}),
    ],
)  # fmt: skip
def test_solids_have_the_reaction_to_the_force_on_the_liquid(walls, method, seed):
    """Behind a mirror the pressure grows by the weight of the liquid, for liquid and dummies. A dummy once had the
    force of the liquid's image, the liquid that of the dummy's image: with a body on the floor these differed by 2 % of
    all weight.
    """
    run = scattered(seed, walls, **method)
    parameters, state, workspace = run.parameters, run.state, run.workspace
    for _ in range(2):
        delayed = state.delayed_body_acceleration.copy()
        evaluate_density_rate(parameters, state, workspace)
        evaluate_accelerations(parameters, state, workspace, parameters.time_step)
    state.delayed_body_acceleration[...] = delayed
    on_liquid = (state.mass * (state.acceleration - parameters.gravity[:, None])).sum(axis=1)
    np.testing.assert_allclose(at_this_step(run), -on_liquid, atol=1e-6 * state.mass.sum())


def test_reversed_lists_contain_the_same_pairs():
    run = scattered(0, "mirror")
    there = run.workspace.lists
    rows, columns = np.arange(len(run.state.mass)), np.arange(run.workspace.fields.shape[1])
    back = reversed_lists(there, rows, columns, len(columns))
    pairs = {(int(j), int(i)) for i in rows for j in there.neighbor[there.start[i] :][: there.counts[i]]}
    assert pairs == {(int(j), int(i)) for j in columns for i in back.neighbor[back.start[j] :][: back.counts[j]]}


@pytest.mark.parametrize("solid", ["bodies", "obstacles"])
def test_what_is_moved_out_of_a_solid_leaves_its_impulse_there(solid):
    """A polygon that is not convex expels liquid like a body. The impulse was in the body's motion, and in no force."""
    corner = [[0.3, 0.1], [0.7, 0.1], [0.7, 0.2], [0.45, 0.2], [0.45, 0.5], [0.3, 0.5]]
    scene = from_plain(
        {
            "model": "sph", "duration": 1.0, "frame_every": 0.1, "spacing": 0.1, "gravity": 0.0,
            "liquid": {"density": 1.0, "maximum_speed": 3.0}, "tank": {"high": [1.0, 1.0]},
            "fluid": [{"low": [0.0, 0.6], "high": [1.0, 0.8]}],
            solid: [{"vertices": corner, **({"density": 2.0} if solid == "bodies" else {})}],
        }
    )  # fmt: skip
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    state.position[:, :3] = np.array([[0.35, 0.68, 0.4], [0.48, 0.15, 0.12]])
    state.velocity[:, :3] = np.array([[0.5, -1.0, 0.2], [-1.0, -0.5, 1.0]])
    before = (state.mass * state.velocity).sum(axis=1)
    start = state.motion.copy()
    now = with_moved_solids(parameters, state)
    resolve_collisions(now, state, 0.0)
    given = before - (state.mass * state.velocity).sum(axis=1)
    recorded = state.struck * parameters.time_step
    assert np.abs(given).max() > 1e-3
    np.testing.assert_allclose(recorded[:, :2].sum(axis=0), given, atol=1e-12)
    assert np.flatnonzero(recorded.any(axis=1)).tolist() == [4]
    if solid == "bodies":
        motion, bodies = state.motion - start, parameters.bodies
        np.testing.assert_allclose(recorded[4, :2], bodies.mass[0] * motion[:2, 0], atol=1e-12)
        assert recorded[4, 5] == pytest.approx(bodies.inertia[2, 0] * motion[5, 0])
