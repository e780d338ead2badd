import numpy as np
import pytest

from ecume import _jit
from ecume.engine.contact.contacts import make_contacts
from ecume.engine.neighbors import THREADS_FROM
from ecume.laws import flotation
from ecume.laws.pair_laws import PAIR_LAWS, Setting
from ecume.models import MODELS
from ecume.models.floating import dishes
from ecume.models.floating.contacts.collisions import require_rest
from ecume.models.floating.forces.pair_forces import law_of, summed_law, two_floats
from ecume.models.floating.frames import observe
from ecume.models.floating.parameters import make_state
from ecume.models.floating.time_integration.integration import forces_at
from ecume.models.floating.time_integration.step_size import raft_pull
from ecume.scenes.floating import DishSpec
from tests.models.floating.bowls import HEAVY, LIGHT, WATER, bowl, scene_of

FLOATING = MODELS["floating"]


def found_at(parameters, position):
    state = make_state(position, np.zeros_like(position))
    workspace = FLOATING.workspace(parameters, state, 1.0)
    forces_at(parameters, state.position, workspace)
    return workspace.force


def a_mixed_crowd(count=40, rest=""):
    floats = f'[[particles]]\nname = "heavy"\ncount = {count // 2}\n{HEAVY}'
    floats += f'[[particles]]\nname = "light"\ncount = {count // 2}\n{LIGHT}'
    return scene_of(WATER + floats + rest)


def test_compiled_pair_forces_are_the_exact_law_to_1e_7():
    scene = a_mixed_crowd(2)
    parameters = FLOATING.parameters(scene)
    liquid = flotation.Liquid(1000.0, 0.0728, 1e-3)
    heavy, light = (flotation.Sphere(1e-3, density, 1.5707963) for density in (1300.0, 200.0))
    for distance in np.geomspace(2e-3, 0.99 * parameters.cutoff, 25):
        found = found_at(parameters, np.array([[0.0, 0.0], [distance, 0.0]]))
        wanted = flotation.pair_force(heavy, light, distance, liquid, theory="nonlinear")
        assert found[1, 0] == pytest.approx(wanted, rel=1e-7)
        assert found[0, 0] == -found[1, 0]


def test_force_is_minus_the_slope_of_the_energy_that_frames_record():
    scene = a_mixed_crowd(10)
    parameters = FLOATING.parameters(scene)
    position = FLOATING.start(scene, parameters).position
    found, step = found_at(parameters, position), 1e-7
    for i in (0, 7):
        energies = []
        for moved in (-step, step):
            shifted = position.copy()
            shifted[i, 1] += moved
            state = make_state(shifted, np.zeros_like(shifted))
            frame = observe(parameters, state, FLOATING.workspace(parameters, state, 1.0))
            energies.append(frame.numbers["total_energy"])
        assert found[i, 1] == pytest.approx((energies[0] - energies[1]) / (2 * step), rel=1e-5)


def test_pair_forces_of_many_floats_cancel_to_rounding():
    scene = a_mixed_crowd(60)
    parameters = FLOATING.parameters(scene)
    found = found_at(parameters, FLOATING.start(scene, parameters).position)
    assert np.abs(found.sum(axis=0)) == pytest.approx(np.zeros(2), abs=1e-14 * np.abs(found).sum())


def test_a_dish_pushes_along_the_slope_of_its_energy():
    scene = bowl(8)
    parameters = FLOATING.parameters(scene)
    position = FLOATING.start(scene, parameters).position
    found, step = found_at(parameters, position), 1e-7
    energies = []
    for moved in (-step, step):
        shifted = position + np.array([[moved, 0.0]] + 7 * [[0.0, 0.0]])
        state = make_state(shifted, np.zeros_like(shifted))
        energies.append(observe(parameters, state, FLOATING.workspace(parameters, state, 1.0)).numbers["total_energy"])
    assert found[0, 0] == pytest.approx((energies[0] - energies[1]) / (2 * step), rel=1e-5)


@pytest.mark.long
@pytest.mark.compiled
def test_single_precision_keeps_six_digits_wherever_the_floats_are():
    found = []
    for precision in ("double", "single"):
        parameters = FLOATING.parameters(a_mixed_crowd(60, f'[interaction]\nprecision = "{precision}"\n'))
        position = FLOATING.start(a_mixed_crowd(60), parameters).position + 900.0
        found.append(found_at(parameters, position))
    error = np.sqrt(np.sum((found[1] - found[0]) ** 2) / np.sum(found[0] ** 2))
    assert 1e-9 < error < 1e-6
    assert np.abs(found[1].sum(axis=0)).max() < 1e-14 * np.abs(found[1]).sum()


@pytest.mark.compiled
def test_forces_have_the_same_bits_for_any_number_of_threads():
    count = THREADS_FROM + 96
    scene = scene_of(f"{WATER}[[particles]]\n{HEAVY}count = {count}\n")
    parameters = FLOATING.parameters(scene)
    position = FLOATING.start(scene, parameters).position
    found = []
    for threads in (1, 2):
        _jit.use_threads(threads)
        found.append(found_at(parameters, position).copy())
    assert np.array_equal(found[0], found[1])


def test_packed_constants_come_out_as_they_went_in():
    parameters = FLOATING.parameters(a_mixed_crowd())
    liquid, smallest = flotation.Liquid(1000.0, 0.0728, 1e-3), 1e-3
    setting = Setting(liquid.capillary_length, 0.0728, 1.8 * smallest, parameters.cutoff + smallest)
    assert law_of(parameters) == PAIR_LAWS["capillary"].make_constants(setting)
    single = summed_law(parameters._replace(single=True))
    assert {type(each) for each in single} == {np.float32}


def test_a_law_without_its_own_pull_of_a_raft_has_that_of_a_half_plane():
    """Floats on one side of a float at the edge, by a sum over small squares of their surface."""
    scene = scene_of(f'{WATER}[[particles]]\ncount = 2\n{HEAVY}[interaction]\nlaw = "one-sided-legacy"\n')
    parameters, area = FLOATING.parameters(scene), 1e-3
    law, charge, far = law_of(parameters), parameters.floats.charge, parameters.cutoff
    own = two_floats(parameters, (1e-3, 1e-3), (charge[0], charge[1]))
    nodes = (np.arange(400) + 0.5) * far / 400
    x, y = np.meshgrid(nodes, nodes)
    apart = np.hypot(x, y)
    inside = (apart > 2e-3) & (apart < far)
    pull = np.interp(apart[inside], grid := np.linspace(2e-3, far, 2000), [
        abs(PAIR_LAWS["one-sided-legacy"].force(each, own, law)) for each in grid.tolist()
    ])  # fmt: skip
    expected = 2.0 * (far / 400) ** 2 * float(np.sum(pull * x[inside] / apart[inside])) * 2 / area
    assert raft_pull(parameters, np.abs(charge), area) == pytest.approx([expected] * 2, rel=0.01)


def test_only_approaches_by_the_kick_alone_are_brought_to_rest():
    """Approaches of 1.9 and 2.1 kicks, one of 3 with a gap, and a pair that parts; then with a tolerance."""
    parameters = FLOATING.parameters(a_mixed_crowd(2))
    contacts, kick = make_contacts(8), 1e-3
    contacts.total[0] = 4
    contacts.change[:4] = [-1.9 * kick, -2.1 * kick, -3.0 * kick, kick]
    contacts.scratch[:4] = contacts.change[:4] - kick
    contacts.gap[:4] = [0.0, 0.0, 1e-6, 1e-6]
    parting = -1e-6 / parameters.time_step
    require_rest(parameters, contacts, 0.0)
    assert contacts.bound[:4].tolist() == [0.0, -np.inf, -np.inf, parting]
    require_rest(parameters, contacts, 0.5 * kick)
    assert contacts.bound[:4].tolist() == [0.0, 0.0, -np.inf, parting]


@pytest.mark.parametrize("image", ["pinned", "fixed-angle"])
def test_the_energy_of_images_in_a_dish_is_continuous_near_the_wall(image):
    dish, liquid = DishSpec(radius=0.02, contact_angle=1.0, image=image), flotation.Liquid(1000.0, 0.0728, 1e-3)
    switch = dishes.HUGGING * 0.02
    before, at, after, far = dishes._round_images(dish, liquid, switch * np.array([0.999, 1.0, 1.001, 10.0]))
    assert at - before == pytest.approx(after - at, rel=0.05)
    assert abs(at - before) < 0.01 * abs(at - far)
