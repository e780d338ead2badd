"""Actions in each model: their work is in the energy budget, and a resumed simulation performs the same ones."""

import dataclasses
from typing import Any

import numpy as np
import pytest

import ecume
from ecume.errors import BadInput
from ecume.models import MODELS
from ecume.scenes.schema import from_plain
from ecume.simulation import moments, simulate
from tests.models.floating.bowls import bowl
from tests.models.soft.clusters import pull_apart
from tests.models.sph.scenes import tank

pytestmark = pytest.mark.compiled


def grains() -> Any:
    """Five grains in a liquid at rest."""
    return from_plain(
        {
            "model": "tracers",
            "duration": 0.2,
            "frame_every": 0.05,
            "liquid": {"viscosity": 1e-2},
            "tank": {"low": [0.0, 0.0], "high": [0.02, 0.02], "restitution": 0.5},
            "particles": [{"radius": 1e-3, "density": 2500.0, "count": 5}],
        }
    )


def without_diffusion(scene: Any) -> Any:
    """The same tank, in which only actions do work."""
    return dataclasses.replace(scene, method=dataclasses.replace(scene.method, density_diffusion="none"))


SCENES = {
    "floating": lambda: bowl(8, duration=0.2, frame_every=0.05),
    "sph": lambda: without_diffusion(dataclasses.replace(tank(6), duration=0.2, frame_every=0.05)),
    "tracers": grains,
}


@ecume.every(steps=9)
def whirl(view: Any) -> None:
    """Turn the particles about their center, and move them a little to it."""
    x, y = (view.position - view.position.mean(axis=0)).T
    view.velocity += 0.1 * np.column_stack([-y, x])
    view.position -= 1e-4 * np.column_stack([x, y])


def copied(state: Any) -> Any:
    """A copy, as a checkpoint makes it."""
    return type(state)(*(array.copy() for array in state))


@pytest.mark.parametrize("name", SCENES)
def test_a_simulation_that_goes_on_from_any_moment_ends_with_the_same_bits(name: str) -> None:
    scene, states = SCENES[name](), []
    for moment in moments(scene, actions=[whirl], patience=0.0):
        states.append(copied(moment.state))
    assert len(states) > 10
    for begun in states[4 :: len(states) // 3]:
        *_, last = (copied(moment.state) for moment in moments(scene, actions=[whirl], state=copied(begun)))
        for field, one, other in zip(states[-1]._fields, states[-1], last, strict=True):
            assert one.tobytes() == other.tobytes(), field


@pytest.mark.parametrize("name", SCENES)
def test_the_work_of_actions_is_injected_work(name: str) -> None:
    scene, gained = SCENES[name](), []

    @ecume.every(steps=9)
    def push(view: Any) -> None:
        mass = view.mass if name != "tracers" else 4.0 / 3.0 * np.pi * view.radius**3 * (view.density + 500.0)
        before = 0.5 * float(np.sum(mass * (view.velocity**2).sum(axis=1)))
        view.velocity[:, 0] += 0.01
        gained.append(0.5 * float(np.sum(mass * (view.velocity**2).sum(axis=1))) - before)

    frames = list(simulate(scene, actions=[push]))
    assert frames[0].numbers["injected_work"] == 0.0
    assert frames[-1].numbers["injected_work"] == pytest.approx(sum(gained), rel=1e-9)
    assert len(gained) > 1


@pytest.mark.parametrize("name", SCENES)
def test_particles_that_an_action_moves_out_are_refused(name: str) -> None:
    @ecume.every(steps=5)
    def throw(view: Any) -> None:
        view.position[3] = 40.0

    who = "float 3" if name == "floating" else "particle 3"
    with pytest.raises(BadInput, match=rf"actions: throw: at t = .* \(step 5\): {who} "):
        list(simulate(SCENES[name](), actions=[throw]))


def test_floats_that_an_action_puts_into_one_another_are_refused() -> None:
    @ecume.every(steps=5)
    def merge(view: Any) -> None:
        view.position[3] = view.position[5] + 1e-3

    with pytest.raises(BadInput, match=r"float 3 overlaps float 5 by 1\.59 mm"):
        list(simulate(SCENES["floating"](), actions=[merge]))


def test_soft_spheres_can_be_read_only() -> None:
    scene, seen = pull_apart(0.1, 0.3, duration=1.0), []
    list(simulate(scene, actions=[ecume.every(steps=2)(lambda view: seen.append(view.step))]))
    assert seen == list(range(2, seen[-1] + 1, 2))
    assert len(seen) > 5

    @ecume.every(time=0.5)
    def move(view: Any) -> None:
        view.position += 0.1

    with pytest.raises(BadInput, match=r"move: .*read-only; .* follow from the balance of forces"):
        list(simulate(scene, actions=[move]))


def test_every_model_states_what_actions_may_change() -> None:
    for model in map(MODELS.__getitem__, ("floating", "soft", "sph", "tracers")):
        state = model.access
        assert bool(state.refusal) == (model.name == "soft")
