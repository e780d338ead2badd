import numpy as np
import pytest

from ecume.laws.friction import impulse
from ecume.models import MODELS
from ecume.simulation import simulate
from tests.models import begun
from tests.models.floating.bowls import HEAVY, WATER, colliding, scene_of

FLOATING = MODELS["floating"]


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
        f"[[particles]]\n{HEAVY}positions = [[-0.0015, 0.0]]\nvelocity = [0.04, 0.003]\n"
        f'[[particles]]\nname = "b"\n{HEAVY}positions = [[0.0015, 0.0]]\nvelocity = [-0.04, 0.003]\n'
    )
    rest = '[hydrodynamics]\ndrag = "none"\n[interaction]\nlaw = "none"\n[contacts]\nrestitution = 0.5\n'
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
    floats = f"[[particles]]\n{HEAVY}positions = [[0.0, 0.0]]\nvelocity = [0.05, 0.01]\n"
    rest = '[hydrodynamics]\ndrag = "none"\n[interaction]\nlaw = "none"\n'
    after, _ = last_and_first(scene_of(WATER + floats + dish + rest, duration=0.3, frame_every=0.1))
    assert after.arrays["velocity"][0] == pytest.approx([-0.03, 0.01], rel=1e-12)


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_simultaneous_collisions_have_the_least_restitution_among_them(order):
    """A float hits another one in the moment in which that one hits a softer wall: both collisions are as soft as the
    wall, whichever float has the lower number.
    """
    middle, thrown = (
        f"positions = [[{8.999e-3!r}, 0.0]]\nvelocity = [0.02, 0.0]",
        f"positions = [[{6.998e-3!r}, 0.0]]\nvelocity = [0.05, 0.0]",
    )
    floats = "".join(f"[[particles]]\n{HEAVY}{(middle, thrown)[which]}\n" for which in order)
    dish = '[dish]\nsize = [0.02, 0.02]\nlaw = "none"\nrestitution = 0.1\n'
    rest = '[integration]\ntime_step = 1e-4\n[hydrodynamics]\ndrag = "none"\n[interaction]\nlaw = "none"\n'
    rest += "[contacts]\nrestitution = 0.9\n"
    after, before = last_and_first(scene_of(WATER + floats + dish + rest, duration=1e-2, frame_every=1e-2))
    expected = [(-0.1 * 0.02, -0.1 * 0.05)[which] for which in order]
    assert after.arrays["velocity"][:, 0] == pytest.approx(expected, rel=1e-6)
    assert after.numbers["kinetic_energy"] == pytest.approx(0.01 * before.numbers["kinetic_energy"], rel=1e-6)
    assert after.numbers["collisions"] == 2


@pytest.mark.parametrize("kicks", [6.0, 12.0, 35.0])
def test_floats_that_attract_each_other_bounce_if_they_meet_faster_than_a_few_kicks(kicks):
    """A kick is the change of the approach speed by the attraction in half a step. Floats that meet much faster than
    that bounce; only those that the attraction presses together come to rest. The attraction in the few steps before
    and after the collision changes the speeds by some kicks.
    """
    still = pair_about_to_meet(0.0, 1e-9)
    parameters, state, workspace = begun(still)
    FLOATING.advance(parameters, state, workspace, 0)
    speed = float(kicks * 2.0 * parameters.kick.gain[0] * abs(workspace.force[0, 0]))
    for steps_to_contact in np.linspace(0.3, 3.6, 9).tolist():
        frames = simulate(pair_about_to_meet(0.5 * speed, steps_to_contact * speed * parameters.time_step))
        parting = max(float(np.diff(frame.arrays["velocity"][:, 0])[0]) for frame in frames)
        assert parting / speed > 0.8 - 2.4 / kicks, steps_to_contact


def pair_about_to_meet(speed, gap):
    """Two heavy floats that attract each other, each with this speed, in steps of 1 ms."""
    half = 1e-3 + 0.5 * gap
    floats = "".join(
        f"[[particles]]\n{HEAVY}positions = [[{way * half!r}, 0.0]]\nvelocity = [{-way * speed!r}, 0.0]\n"
        for way in (-1, 1)
    )
    rest = "[integration]\ntime_step = 1e-3\n[hydrodynamics]\ndrag = 'none'\n[contacts]\nrestitution = 0.8\n"
    return scene_of(WATER + floats + rest, duration=6e-3, frame_every=1e-3)


def test_without_contacts_floats_pass_through_each_other():
    after, _ = last_and_first(colliding((0.05, -0.05), contacts='law = "none"'))
    assert after.arrays["velocity"][:, 0] == pytest.approx([0.05, -0.05])
    assert after.arrays["position"][0, 0] > after.arrays["position"][1, 0]


@pytest.mark.long
@pytest.mark.compiled
def test_momentum_is_conserved_to_1e_12_over_a_run_with_many_collisions():
    floats = (
        f'[[particles]]\nname = "a"\ncount = 30\n{HEAVY}'
        '[[particles]]\nname = "b"\ncount = 30\nradius = 0.7e-3\ndensity = 1100.0\ncontact_angle = 1.5707963\n'
        "velocity = [0.01, 0.0]\n"
    )
    scene = scene_of(f"{WATER}{floats}[hydrodynamics]\ndrag = 'none'\n[contacts]\nrestitution = 0.7\n", duration=3.0)
    frames = list(simulate(scene))
    scale = np.sum(frames[-1].arrays["mass"] * np.hypot(*frames[-1].arrays["velocity"].T))
    assert frames[-1].numbers["collisions"] > 30
    for name in ("momentum_x", "momentum_y"):
        assert frames[-1].numbers[name] == pytest.approx(frames[0].numbers[name], abs=1e-12 * scale)


PASSING = {
    "a dish": ('[dish]\nradius = "1 cm"\ncontact_angle = "45 deg"\n', ""),
    "a dish without inertia": ('[dish]\nradius = "1 cm"\n', 'integrator = "overdamped"'),
    "a rectangle": ('[dish]\nsize = ["2 cm", "2 cm"]\n', ""),
    "a dish and the flow of others": (
        '[dish]\nradius = "1 cm"\n[hydrodynamics]\ninteraction = "rotne-prager"\n',
        'integrator = "overdamped"',
    ),
}


@pytest.mark.filterwarnings("ignore::ecume.models.floating.setup.hydrodynamic_interaction.ReynoldsWarning")
@pytest.mark.uncompiled  # where floats are put, and that walls hold them: others compile shapes, dishes and rectangles
@pytest.mark.parametrize("name", PASSING)
@pytest.mark.parametrize("shape", ["", 'shape = { kind = "needle", width = "0.3 mm", angle = 0.0 }\n'])
def test_floats_that_pass_through_one_another_may_overlap_at_the_start_and_stay_in_the_dish(name, shape):
    around, integration = PASSING[name]
    if shape and "rotne" in around:
        pytest.skip("the flow of needles is not known")
    floats = (
        f'[[particles]]\nradius = "0.5 mm"\ndensity = 300.0\ncontact_angle = "60 deg"\n{shape}'
        f"positions = [[0.009, 0.0], [{-0.005 if shape else 0.0089}, 0.0]]\n"
    )
    laws = f'[contacts]\nlaw = "none"\n[integration]\n{integration}\n'
    frames = list(simulate(scene_of(WATER + floats + around + laws, duration=0.2, frame_every=0.1)))
    for frame in frames:
        assert np.abs(frame.arrays["position"]).max() < 9.55e-3
