import numpy as np
import pytest

from ecume.laws.contact import impulse
from ecume.simulation import simulate
from tests.models.floating.bowls import HEAVY, WATER, colliding, scene_of


def last_and_first(scene):
    frames = list(simulate(scene))
    return frames[-1], frames[0]


@pytest.mark.parametrize("restitution", [0.0, 0.3, 1.0])
def test_a_collision_exchanges_the_impulse_of_the_law(restitution):
    scene = colliding(
        (0.05, -0.02), densities=(1300.0, 1100.0), radii=(1e-3, 0.7e-3), contacts=f"restitution = {restitution}"
    )
    after, before = last_and_first(scene)
    mass = before.arrays["mass"]
    exchanged = impulse(0.07, mass[0], mass[1], restitution)
    assert after.arrays["velocity"][0, 0] == pytest.approx(0.05 - exchanged / mass[0], rel=1e-12)
    assert after.arrays["velocity"][1, 0] == pytest.approx(-0.02 + exchanged / mass[1], rel=1e-12)
    assert after.numbers["momentum_x"] == pytest.approx(before.numbers["momentum_x"], rel=1e-13)
    assert after.numbers["collisions"] == 1


def test_an_oblique_collision_leaves_the_velocity_across_as_it_is():
    floats = (
        f"[[floats]]\n{HEAVY}positions = [[-0.0015, 0.0]]\nvelocity = [0.04, 0.003]\n"
        f'[[floats]]\nname = "b"\n{HEAVY}positions = [[0.0015, 0.0]]\nvelocity = [-0.04, 0.003]\n'
    )
    rest = '[motion]\ndrag = false\n[interaction]\nlaw = "none"\n[contacts]\nrestitution = 0.5\n'
    after, _ = last_and_first(scene_of(WATER + floats + rest, duration=0.1, frame_every=0.1))
    assert after.arrays["velocity"][:, 1] == pytest.approx([0.003, 0.003], rel=1e-12)
    assert after.arrays["velocity"][:, 0] == pytest.approx([-0.02, 0.02], rel=1e-12)


def test_the_legacy_coefficient_below_one_half_leaves_the_pair_approaching():
    scene = colliding((0.05, -0.05), contacts="legacy_coefficient = 0.3")
    frames = list(simulate(scene))
    overlaps = [frame.numbers["largest_overlap"] for frame in frames]
    # e = 2 C - 1 = -0.4: each step of overlap leaves 0.4 of the approach, never a separation.
    assert max(overlaps) > 1e-5
    assert frames[-1].arrays["velocity"][0, 0] >= 0.0


def test_the_legacy_coefficient_of_one_is_elastic():
    after, _ = last_and_first(colliding((0.05, -0.05), contacts="legacy_coefficient = 1.0"))
    assert after.arrays["velocity"][:, 0] == pytest.approx([-0.05, 0.05], rel=1e-9)


def test_a_wall_turns_the_normal_velocity_back_by_its_restitution():
    dish = '[dish]\nsize = [0.02, 0.02]\nlaw = "none"\nrestitution = 0.6\n'
    floats = f"[[floats]]\n{HEAVY}positions = [[0.0, 0.0]]\nvelocity = [0.05, 0.01]\n"
    rest = '[motion]\ndrag = false\n[interaction]\nlaw = "none"\n'
    after, _ = last_and_first(scene_of(WATER + floats + dish + rest, duration=0.3, frame_every=0.1))
    assert after.arrays["velocity"][0] == pytest.approx([-0.03, 0.01], rel=1e-12)


def test_without_contacts_floats_pass_through_each_other():
    after, _ = last_and_first(colliding((0.05, -0.05), contacts='law = "none"'))
    assert after.arrays["velocity"][:, 0] == pytest.approx([0.05, -0.05])
    assert after.arrays["position"][0, 0] > after.arrays["position"][1, 0]


@pytest.mark.compiled
def test_momentum_is_conserved_to_1e_12_over_a_run_with_many_collisions():
    floats = (
        f'[[floats]]\nname = "a"\ncount = 30\n{HEAVY}'
        '[[floats]]\nname = "b"\ncount = 30\nradius = 0.7e-3\ndensity = 1100.0\ncontact_angle = 1.5707963\n'
        "velocity = [0.01, 0.0]\n"
    )
    scene = scene_of(f"{WATER}{floats}[motion]\ndrag = false\n[contacts]\nrestitution = 0.7\n", duration=3.0)
    frames = list(simulate(scene))
    scale = np.sum(frames[-1].arrays["mass"] * np.hypot(*frames[-1].arrays["velocity"].T))
    assert frames[-1].numbers["collisions"] > 30
    for name in ("momentum_x", "momentum_y"):
        assert frames[-1].numbers[name] == pytest.approx(frames[0].numbers[name], abs=1e-12 * scale)
