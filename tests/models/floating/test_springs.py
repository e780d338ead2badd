"""Contacts as springs and dashpots."""

import dataclasses

import numpy as np
import pytest

from ecume.errors import SceneError
from ecume.laws.friction import dashpot_restitution
from ecume.models import MODELS
from ecume.simulation import simulate
from tests.models.floating.bowls import HEAVY, WATER, colliding, scene_of, two_floats

SOFT = 'law = "spring-dashpot"\n'


def relative(frames):
    """The separation speed of two floats, over their approach speed."""
    first, last = (frame.arrays["velocity"][:, 0] for frame in (frames[0], frames[-1]))
    return (last[1] - last[0]) / (first[0] - first[1])


def at_step(scene, time_step):
    """The scene with short steps: some hundred in a collision, where the recommended one takes twenty."""
    return dataclasses.replace(scene, integration=dataclasses.replace(scene.integration, time_step=time_step))


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize("restitution", [0.1, 0.5, 0.9])
def test_a_soft_collision_gives_back_what_was_asked(restitution):
    scene = colliding(
        (0.05, 0.0), densities=(1300.0, 700.0), contacts=f"{SOFT}restitution = {restitution}\nstiffness = 2.0"
    )
    frames = list(simulate(at_step(scene, 1e-5)))
    assert relative(frames) == pytest.approx(restitution, abs=2e-3)
    assert relative(list(simulate(scene))) == pytest.approx(restitution, abs=2e-2)
    moved = frames[-1].numbers["momentum_x"] / frames[0].numbers["momentum_x"]
    assert moved == pytest.approx(1.0, abs=1e-13)
    assert frames[-1].numbers["deepest_overlap"] > 1e-5


@pytest.mark.long
@pytest.mark.compiled
def test_springs_without_dashpots_keep_the_energy_even_where_they_are_pressed():
    floats = "".join(
        f"[[particles]]\nname = '{name}'\n{HEAVY}positions = [[{x}, {y}]]\nvelocity = [{vx}, 0.0]\n"
        for name, x, y, vx in (("a", -2e-3, 2e-4, 0.05), ("b", 2e-3, 0.0, -0.02))
    )
    rest = '[hydrodynamics]\ndrag = "none"\n[interaction]\nlaw = "none"\n'
    dish = '[dish]\nradius = "5 mm"\nlaw = "none"\nrestitution = 1.0\n'
    dish += f"[contacts]\n{SOFT}restitution = 1.0\nstiffness = 2.0\n"
    scene = scene_of(WATER + floats + rest + dish, duration=0.4, frame_every=2e-3)
    frames = list(simulate(at_step(scene, 2e-5)))
    total = np.array([frame.numbers["total_energy"] for frame in frames])
    kinetic = np.array([frame.numbers["kinetic_energy"] for frame in frames])
    assert np.min(kinetic) < 0.9 * total[0]
    assert total == pytest.approx(total[0], rel=2e-4)


@pytest.mark.long
@pytest.mark.compiled
def test_a_pair_rests_where_the_spring_holds_its_pull():
    scene = two_floats(2.05e-3, hydrodynamics="", contacts=f"{SOFT}restitution = 0.2", duration=4.0, frame_every=0.5)
    *_, last = simulate(scene)
    parameters = MODELS["floating"].parameters(scene)
    apart = np.ptp(last.arrays["position"][:, 0])
    strength, length = parameters.pair[0] * parameters.floats.charge[0] ** 2, parameters.pair[1]
    from scipy.special import k1

    pull = strength / length * k1(apart / length)
    assert 2e-3 - apart == pytest.approx(pull / parameters.parts.contacts.stiffness, rel=1e-3)
    assert 0.0 < 2e-3 - apart < 1e-6
    assert last.numbers["largest_speed"] < 1e-8


def test_a_dashpot_takes_more_the_stiffer_it_is():
    assert dashpot_restitution(0.0) == 1.0
    given = [dashpot_restitution(damping) for damping in (0.1, 0.5, 0.999999, 1.000001, 2.0, 5.0)]
    assert all(np.diff(given) < 0.0)
    # Integrated by hand to the moment at which the push is gone.
    assert given[1] == pytest.approx(0.29843606, abs=1e-8)
    assert given[4] == pytest.approx(0.04776873, abs=1e-8)


@pytest.mark.parametrize(
    ("rest", "said"),
    [
        ("[contacts]\nstiffness = 2.0\n", "only with contacts.law"),
        (f"[contacts]\n{SOFT}friction = 0.1\n", "solved as impulses"),
        (f"[contacts]\n{SOFT}restitution = 0.0\n", "0.05 or more"),
        (f'[contacts]\n{SOFT}[interaction]\nlaw = "none"\n', "expected a stiffness in N/m"),
        (f'[contacts]\n{SOFT}[integration]\nintegrator = "rk4"\n', "velocity-verlet"),
    ],
)
def test_what_does_not_go_with_springs_is_reported(rest, said):
    scene = scene_of(f"{WATER}[[particles]]\ncount = 2\n{HEAVY}{rest}")
    with pytest.raises(SceneError, match=said):
        MODELS["floating"].parameters(scene)


def test_springs_of_fast_floats_are_as_stiff_as_collisions_at_the_wall_require():
    """Without a stiffness in the scene: one that holds attraction alone gave an overlap of 2 % of a radius."""
    fast = f"[[particles]]\n{HEAVY}positions = [[-3.9e-3, 0.0]]\nvelocity = [-0.2, 0.0]\n"
    walls = f'[dish]\nradius = "5 mm"\nrestitution = 1.0\n[contacts]\n{SOFT}'
    *_, last = simulate(scene_of(WATER + fast + walls, duration=2e-3, frame_every=1e-3))
    assert last.arrays["velocity"][0, 0] > 0.0
    assert 1e-3 < last.numbers["deepest_overlap"] / 1e-3 < 0.011
