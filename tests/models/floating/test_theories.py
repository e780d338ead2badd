"""The laws of a theory of a scene, and walls with tables."""

import dataclasses
import math

import numpy as np
import pytest

from ecume.errors import SceneError
from ecume.laws import capillarity, flotation, meniscus
from ecume.models import MODELS
from ecume.models.floating.dishes import DISH, PLANE, TABLED
from ecume.models.floating.forces.pair_forces import add_wall_forces, sum_of_wall_energies
from ecume.models.floating.frames import observe
from ecume.models.floating.parameters import make_state
from ecume.models.floating.time_integration.integration import forces_at
from ecume.models.floating.time_integration.integrators import INTEGRATORS
from ecume.scenes.floating import IntegrationSpec
from tests.models.floating.bowls import HEAVY, LIGHT, WATER, scene_of

FLOATING = MODELS["floating"]
LIQUID = flotation.Liquid(1000.0, 0.0728, 1e-3)
L = LIQUID.capillary_length
ROUND, RECTANGLE = "radius = 0.03", "size = [0.08, 0.06]"


def in_a_dish(dish, kind=HEAVY, head="", place=(0.0, 0.0)):
    floats = f"[[particles]]\n{kind}positions = [[{place[0]!r}, {place[1]!r}]]\n"
    return scene_of(f'{WATER}{floats}[dish]\ncontact_angle = "35 deg"\n{dish}\n', head=head)


def wall_force(parameters, place):
    force = np.zeros((1, 2))
    add_wall_forces(parameters, np.array([place]), force)
    return force[0]


def test_a_theory_brings_its_laws_and_what_is_named_overrules_it():
    legacy = in_a_dish(ROUND, head='theory = "legacy-2022"')
    assert (legacy.interaction.law, legacy.interaction.charge) == ("one-sided-legacy", "linear")
    assert (legacy.dish.law, legacy.hydrodynamics.drag, legacy.contacts.legacy_coefficient) == (
        "two-point-legacy",
        "none",
        0.3,
    )
    linear = in_a_dish(f'{ROUND}\nlaw = "profile"', head='theory = "linear"')
    assert (linear.interaction.charge, linear.dish.law) == ("linear", "profile")
    assert linear.contacts.legacy_coefficient is None


def test_drag_grows_with_the_reynolds_number_by_default():
    """With the integrators that can, but for Stoermer's scheme, in which scenes of the first program have Stokes's."""
    for name, row in INTEGRATORS.items():
        by_speed = in_a_dish(ROUND, head=f'integration.integrator = "{name}"').drag == "schiller-naumann"
        assert by_speed == ("fast drag" in row.gives and name != "stormer-verlet")
    moving = in_a_dish(f"{ROUND}\n[dish.motion]\nfrequency = 1.0\namplitude = 1e-3")
    needle = in_a_dish(ROUND, kind=f'{HEAVY}shape = {{kind = "needle", width = 5e-4}}\n')
    assert (moving.drag, needle.drag) == ("stokes", "stokes")
    for scene in (moving, needle):
        FLOATING.parameters(scene)
    # The default is no part of the scene: another integrator, or floats of a shape, change it.
    slow = dataclasses.replace(in_a_dish(ROUND), integration=IntegrationSpec(integrator="overdamped"))
    assert slow.drag == "stokes"
    FLOATING.parameters(slow)
    asked = in_a_dish(ROUND, head='hydrodynamics.drag = "stokes"')
    assert FLOATING.parameters(asked).drift.thickness == 0.0
    assert FLOATING.parameters(in_a_dish(ROUND)).drift.thickness == pytest.approx(1e6)


def test_the_default_theory_is_the_one_that_was_there_before():
    named = '[interaction]\nlaw = "capillary"\ncharge = "nonlinear"\n'
    old = in_a_dish(f'{ROUND}\nlaw = "meniscus"\n{named}')
    assert in_a_dish(ROUND) == old
    parameters = FLOATING.parameters(old)
    assert parameters.wall_law == DISH
    bare = flotation.Sphere(1e-3, 1300.0, 1.5707963)
    assert parameters.floats.charge[0] == flotation.capillary_charge(bare, LIQUID, "nonlinear")
    assert wall_force(parameters, (0.02, 0.0))[0] < 0.0


def test_the_linear_theory_has_its_own_charge_and_wall():
    for dish, law in ((ROUND, DISH), (RECTANGLE, PLANE)):
        exact = FLOATING.parameters(in_a_dish(dish))
        linear = FLOATING.parameters(in_a_dish(dish, head='theory = "linear"'))
        assert linear.wall_law == law
        bare = flotation.Sphere(1e-3, 1300.0, 1.5707963)
        assert linear.floats.charge[0] == pytest.approx(flotation.capillary_charge(bare, LIQUID, "linear"))
        ratio = L / math.tan(math.radians(35.0)) / meniscus.wall_amplitude(math.radians(35.0), LIQUID)
        charges = linear.floats.charge[0] / exact.floats.charge[0]
        assert linear.wall_strength[0, 0] == pytest.approx(exact.wall_strength[0, 0] * ratio * charges)


def at_the_law(law, image, place, dish=ROUND):
    """The force according to a table."""
    parameters = FLOATING.parameters(in_a_dish(f'{dish}\nlaw = "{law}"\nimage = "{image}"'))
    assert parameters.wall_law == TABLED
    return parameters, wall_force(parameters, place)


@pytest.mark.parametrize("r", [1e-3, 0.01, 0.02, 0.0287])
@pytest.mark.parametrize("image", meniscus.WALLS)
def test_a_tabled_dish_is_its_meniscus_and_its_image(r, image):
    parameters, force = at_the_law("meniscus", image, (0.0, r))
    charge, strength = parameters.floats.charge[0], 2 * math.pi * 0.0728
    amplitude = strength * parameters.floats.charge[0] * meniscus.wall_amplitude(math.radians(35.0), LIQUID)
    wanted = meniscus.image_force(charge, r, 0.03, LIQUID, image) - capillarity.dish_force(r, amplitude, L, 0.03)
    assert force[0] == 0.0
    assert force[1] == pytest.approx(wanted, rel=2e-6)


@pytest.mark.parametrize("image", meniscus.WALLS)
@pytest.mark.parametrize("distance", [1.2e-3, 1.9e-3, 1.99e-3, 2.01e-3, 2.1e-3, 4e-3])
def test_beside_the_wall_of_a_wide_dish_its_image_is_that_of_a_plane_wall(image, distance):
    parameters, force = at_the_law("none", image, (0.2 - distance, 0.0), "radius = 0.2")
    assert force[0] == pytest.approx(
        meniscus.image_force(parameters.floats.charge[0], 0.2 - distance, 0.2, LIQUID, image), rel=0.011
    )


@pytest.mark.parametrize("image", meniscus.WALLS)
def test_a_tabled_rectangle_has_an_image_behind_each_wall(image):
    place = 0.037, 0.005
    parameters, force = at_the_law("none", image, place, RECTANGLE)
    wanted = meniscus.rectangle_image_force(parameters.floats.charge[0], place, (0.08, 0.06), LIQUID, image)
    assert force[0] == pytest.approx(wanted[0], rel=1e-6)
    assert abs(force[1] - wanted[1]) < 1e-6 * abs(wanted[0])


def test_a_profile_is_the_slope_of_the_exact_height_and_far_away_the_meniscus():
    r, step = np.array([0.0285, 0.027]), 1e-6
    for place in r:
        parameters, force = at_the_law("profile", "none", (place, 0.0))
        ahead, behind = (
            meniscus.dish_height(place + d, 0.03, math.radians(35.0), LIQUID, "nonlinear") for d in (step, -step)
        )
        slope = (ahead - behind) / (2 * step)
        assert force[0] == pytest.approx(-2 * math.pi * 0.0728 * parameters.floats.charge[0] * slope, rel=1e-5)
    _, far = at_the_law("profile", "none", (0.03 - 4 * L, 0.0))
    plain = wall_force(FLOATING.parameters(in_a_dish(ROUND)), (0.03 - 4 * L, 0.0))
    assert far[0] == pytest.approx(plain[0], rel=0.01)
    parameters, _ = at_the_law("profile", "none", (0.0, 0.0), RECTANGLE)
    near, away = (wall_force(parameters, (0.04 - d, 0.0))[0] for d in (0.1 * L, 4 * L))
    plain = FLOATING.parameters(in_a_dish(RECTANGLE))
    assert near < 1.1 * wall_force(plain, (0.04 - 0.1 * L, 0.0))[0] < 0.0
    assert away == pytest.approx(wall_force(plain, (0.04 - 4 * L, 0.0))[0], rel=0.01)


@pytest.mark.parametrize("dish", [ROUND, RECTANGLE])
def test_the_force_of_a_table_is_minus_the_slope_of_its_energy(dish):
    place, step = np.array([0.0213, 0.0107]), 1e-7
    parameters, force = at_the_law("profile", "fixed-angle", tuple(place), dish)
    for axis in (0, 1):
        moved = step * np.eye(2)[axis]
        ahead, behind = (sum_of_wall_energies(parameters, np.array([place + d])) for d in (moved, -moved))
        assert force[axis] == pytest.approx(-(ahead - behind) / (2 * step), rel=1e-5)


def test_a_light_float_climbs_a_wetting_wall_and_its_pinned_image_holds_it_off():
    scene = in_a_dish(f'{ROUND}\nlaw = "profile"\nimage = "pinned"', LIGHT)
    parameters = FLOATING.parameters(scene)
    assert wall_force(parameters, (0.025, 0.0))[0] > 0.0
    alone = FLOATING.parameters(in_a_dish(f'{ROUND}\nlaw = "none"\nimage = "pinned"', LIGHT))
    assert wall_force(alone, (0.028, 0.0))[0] < 0.0


def one_sided(densities, apart):
    floats = "".join(
        f"[[particles]]\nradius = 1e-3\ndensity = {density}\ncontact_angle = 1.5707963\npositions = [[{x!r}, 0.0]]\n"
        for density, x in zip(densities, (0.0, apart), strict=True)
    )
    scene = scene_of(WATER + floats, head='theory = "legacy-2022"')
    parameters = FLOATING.parameters(scene)
    state = make_state(np.array([[0.0, 0.0], [apart, 0.0]]), np.zeros((2, 2)))
    workspace = FLOATING.workspace(parameters, state, 1.0)
    forces_at(parameters, state.position, workspace)
    return parameters, state, workspace


def test_the_originals_force_is_the_others_alone_and_breaks_newtons_third_law():
    parameters, state, workspace = one_sided((1300.0, 200.0), 4e-3)
    charge, force = parameters.floats.charge, workspace.force
    for i, j in ((0, 1), (1, 0)):
        strength = capillarity.pair_strength(0.0728, charge[j], charge[j])
        toward = (-1) ** i
        assert force[i, 0] == pytest.approx(-toward * capillarity.pair_force(4e-3, strength, L), rel=1e-12)
    assert force[0, 0] > 0.0 > force[1, 0]  # unlike ones attract, too
    assert abs(force[0, 0] + force[1, 0]) > 0.1 * abs(force[0, 0])
    assert observe(parameters, state, workspace).numbers["pair_energy"] == 0.0


def test_the_originals_force_is_right_for_equal_floats_until_they_touch():
    parameters, _, workspace = one_sided((1300.0, 1300.0), 4e-3)
    strength = capillarity.pair_strength(0.0728, *parameters.floats.charge)
    assert workspace.force[0, 0] == pytest.approx(-capillarity.pair_force(4e-3, strength, L), rel=1e-12)
    assert not np.any(one_sided((1300.0, 1300.0), 2e-3)[2].force)


@pytest.mark.uncompiled  # the template of this theory is compiled anyway: see tests/compiling.py
def test_the_originals_scene_runs_and_its_unlike_pair_moves_off_by_itself():
    from ecume.simulation import simulate

    floats = f"[[particles]]\n{HEAVY}positions = [[0.0, 0.0]]\n[[particles]]\n{LIGHT}positions = [[0.004, 0.0]]\n"
    frames = list(simulate(scene_of(WATER + floats, head='theory = "legacy-2022"', duration=0.2)))
    numbers, arrays = frames[-1].numbers, frames[-1].arrays
    carried = float(np.sum(arrays["mass"] * np.abs(arrays["velocity"][:, 0])))
    assert abs(numbers["momentum_x"]) > 0.05 * carried


@pytest.mark.parametrize(
    ("dish", "head", "path", "said"),
    [
        (RECTANGLE, 'theory = "legacy-2022"', "dish.law", "not known for this shape of the dish"),
        (f'{ROUND}\nimage = "pinned"', 'theory = "legacy-2022"', "dish.image", "no images"),
        (f'{ROUND}\nimage = "sticky"', "", "dish.image", "no such law"),
        (f'{ROUND}\nlaw = "profil"', "", "dish.law", "did you mean 'profile'"),
    ],
)
def test_what_does_not_go_together_is_reported(dish, head, path, said):
    with pytest.raises(SceneError) as caught:
        FLOATING.parameters(in_a_dish(dish, head=head))
    assert path in str(caught.value)
    assert said in str(caught.value)


def test_a_wetted_wall_has_no_linear_height():
    scene = scene_of(
        f'{WATER}[[particles]]\n{HEAVY}[dish]\ncontact_angle = "0 deg"\n{ROUND}\n', head='theory = "linear"'
    )
    with pytest.raises(SceneError, match="amplitude"):
        FLOATING.parameters(scene)
