import copy

import numpy as np
import pytest

from ecume.errors import SceneError
from ecume.fitting.tracks import _floats_start
from ecume.models import MODELS, costs
from ecume.scenes.schema import from_plain, to_plain
from ecume.show.play.bowl import placed
from ecume.show.play.offered import species_of
from ecume.simulation import simulate
from tests.models.floating.bowls import HEAVY, LIGHT, WATER, bowl, scene_of

FLOATING = MODELS["floating"]


def started(scene):
    parameters = FLOATING.parameters(scene)
    return FLOATING.start(scene, parameters), parameters


def test_random_floats_start_inside_the_dish_without_touching():
    state, _ = started(bowl(60))
    assert np.all(np.hypot(*state.position.T) + 1.5e-3 < 0.03)
    apart = np.hypot(*(state.position[:, None] - state.position[None]).T)
    assert np.min(apart[np.triu_indices(60, 1)]) > 3e-3


def test_lattices_rings_and_rows_stand_where_the_scene_says():
    text = (
        f'[[particles]]\nname = "raft"\ncount = 7\n{HEAVY}'
        'placement = "lattice"\nspacing = 2.1e-3\ncenter = [0.02, 0.0]\n'
        f'[[particles]]\nname = "ring"\ncount = 4\n{LIGHT}placement = "ring"\nring_radius = 8e-3\n'
    )
    state, _ = started(scene_of(WATER + text))
    assert state.position[0] == pytest.approx([0.02, 0.0])
    assert np.hypot(*state.position[7:].T) == pytest.approx(np.full(4, 8e-3))


@pytest.mark.compiled
def test_a_scene_starts_from_a_raft_as_a_run_leaves_it():
    (*_, last) = simulate(bowl(20, radius="12 mm", duration=2.0))
    assert last.numbers["largest_overlap"] > 0.0
    columns = (last.arrays[name].tolist() for name in ("position", "radius", "density", "contact_angle"))
    rows = [
        {"x": x, "y": y, "radius": radius, "density": density, "contact_angle": angle}
        for (x, y), radius, density, angle in zip(*columns, strict=True)
    ]
    plain = {**to_plain(bowl(20, radius="12 mm")), "particles": [], "rows": rows}
    first, *_ = simulate(from_plain(plain))
    assert np.array_equal(first.arrays["position"], last.arrays["position"])


def test_overlapping_floats_are_all_reported_with_their_overlap():
    text = f"[[particles]]\n{HEAVY}positions = [[0.0, 0.0], [0.0015, 0.0], [0.0, 0.0019]]\n"
    with pytest.raises(SceneError) as caught:
        started(scene_of(WATER + text))
    assert [fault.path for fault in caught.value.faults] == ["particles[0].positions[0]", "particles[0].positions[0]"]
    assert "overlaps particles[0].positions[1] by 500 µm" in str(caught.value)


def test_floats_outside_the_dish_are_reported():
    text = f"[[particles]]\n{HEAVY}positions = [[0.0095, 0.0]]\n[dish]\nradius = 0.01\n"
    with pytest.raises(SceneError, match=r"particles\[0\].positions\[0\]: .* not inside the dish"):
        started(scene_of(WATER + text))


def test_floats_that_just_touch_may_start():
    text = f"[[particles]]\n{HEAVY}positions = [[0.0, 0.0], [0.002, 0.0]]\n"
    state, _ = started(scene_of(WATER + text))
    assert len(state.position) == 2


@pytest.mark.compiled
def test_floats_without_room_are_reported():
    with pytest.raises(SceneError, match="placement"):
        started(bowl(600))


def test_a_sphere_that_must_sink_is_refused_with_the_limit():
    text = "[[particles]]\nradius = 2e-3\ndensity = 7800.0\ncontact_angle = 1.57\n"
    with pytest.raises(SceneError, match=r"particles\[0\]: .*7\.8.*"):
        FLOATING.parameters(scene_of(WATER + text))


def test_absurd_counts_are_refused_before_anything_is_laid_out(monkeypatch):
    monkeypatch.setattr(costs, "memory_limit", lambda: 8e9)
    with pytest.raises(SceneError, match=r"50000000 floats need about .* GB, this process may use 8 GB"):
        FLOATING.parameters(scene_of(f"{WATER}[[particles]]\ncount = 50000000\n{HEAVY}"))


@pytest.mark.parametrize(
    ("table", "path"),
    [
        ('[integration]\nintegrator = "velocity-verle"', "integration.integrator"),
        ('[contacts]\nlaw = "impulses"', "contacts.law"),
        ('[interaction]\ncharge = "nonlinaer"', "interaction.charge"),
        ('[dish]\nradius = 0.05\nlaw = "meniskus"', "dish.law"),
    ],
)
def test_a_law_that_does_not_exist_gets_a_suggestion(table, path):
    with pytest.raises(SceneError, match=f"{path}: .*did you mean"):
        FLOATING.parameters(scene_of(f"{WATER}[[particles]]\n{HEAVY}{table}\n"))


def test_contact_angles_come_from_young_and_from_the_closure():
    energies = "[[particles]]\nradius = 1e-3\ndensity = 1100.0\n"
    energies += "surface_energies = { solid_gas = 0.0364, solid_liquid = 0.0 }\n"
    parameters = FLOATING.parameters(scene_of(WATER + energies))
    assert parameters.floats.contact_angle[0] == pytest.approx(np.pi / 3)
    closure = '[[particles]]\nradius = 2e-3\ndensity = 1000.0\ncontact_angle = "original-closure"\n'
    parameters = FLOATING.parameters(scene_of(WATER + closure))
    assert parameters.floats.contact_angle[0] > np.pi / 2


def test_a_rectangular_dish_pushes_heavy_floats_to_its_middle():
    from ecume.simulation import simulate

    text = f"[[particles]]\n{HEAVY}positions = [[0.006, 0.003]]\n[dish]\nsize = [0.02, 0.012]\n"
    frames = list(simulate(scene_of(WATER + text, duration=0.3)))
    assert np.all(np.abs(frames[-1].arrays["position"][0]) < np.array([0.006, 0.003]))


def test_the_two_point_wall_draws_a_heavy_float_to_the_wall():
    from ecume.simulation import simulate

    text = f'[[particles]]\n{HEAVY}positions = [[0.006, 0.0]]\n[dish]\nradius = 0.01\nlaw = "two-point-legacy"\n'
    frames = list(simulate(scene_of(WATER + text, duration=0.1)))
    assert frames[-1].arrays["position"][0, 0] > 0.006


def test_the_summary_names_every_number_a_user_needs():
    rows = {name: (value, remark) for name, value, remark in FLOATING.summary(bowl(40))}
    for name in ("capillary length", "float-1: Bond number", "time step", "steps", "memory", "time on this machine"):
        assert name in rows
    assert rows["capillary length"][0].endswith("mm")


def test_the_two_point_wall_pulls_with_the_weight_of_the_wall_whatever_the_float():
    strengths = []
    for kind in (HEAVY, LIGHT):
        text = f'[[particles]]\n{kind}positions = [[0.0, 0.0]]\n[dish]\nradius = 0.01\nlaw = "two-point-legacy"\n'
        strengths.append(FLOATING.parameters(scene_of(WATER + text)).wall_strength[0, 0])
    assert strengths[0] == strengths[1] > 0.0


def test_rows_of_discs_and_shapes_float_and_turn_as_tables_of_them_do():
    disc = 'radius = "2 mm"\ndensity = 500.0\n[{0}.disc]\nthickness = "1 mm"\n'
    needle = 'radius = "3 mm"\ndensity = 900.0\ncontact_angle = 1.2\n[{0}.shape]\nkind = "needle"\nwidth = "0.5 mm"\n'
    tables = f"[[particles]]\npositions = [[0.0, 0.0]]\n{disc}"
    tables += f"[[particles]]\npositions = [[0.02, 0.0]]\n{needle}angle = 0.7\n"
    rows = f"[[rows]]\nx = 0.0\ny = 0.0\n{disc}[[rows]]\nx = 0.02\ny = 0.0\nangle = 0.7\nspin = -2.0\n{needle}"
    found = []
    for text, key in ((tables, "particles"), (rows, "rows")):
        scene = scene_of(WATER + text.format(key))
        parameters = FLOATING.parameters(scene)
        found.append((parameters.floats, FLOATING.start(scene, parameters)))
    for name in ("radius", "mass", "charge", "relaxation_time"):
        assert np.array_equal(getattr(found[0][0], name), getattr(found[1][0], name))
    assert found[1][1].turning[1].tolist() == [0.7, -2.0]
    assert found[0][1].turning[1].tolist() == [0.7, 0.0]


def test_the_angle_of_a_row_is_its_own_or_that_of_its_shape():
    needle = {"kind": "needle", "width": 1e-3, "angle": 1.0}
    row = {"y": 0.0, "radius": 3e-3, "density": 600.0, "contact_angle": 1.2, "shape": needle}
    rows = [{"x": 0.0, **row}, {"x": 0.02, **row, "angle": 0.5}, {"x": 0.04, **row, "shape": {**needle, "angle": None}}]
    state, _ = started(from_plain({"model": "floating", "duration": 1.0, "frame_every": 0.1, "rows": rows}))
    assert state.turning[:, 0].tolist() == [1.0, 0.5, 0.0]


@pytest.mark.parametrize(
    "given",
    [
        {"center": [1e-3, 0.0], "count": 2},
        {"center": [1e-3, 0.0], "positions": [[0.0, 0.0]]},
        {"spacing": 1e-2, "positions": [[0.0, 0.0]]},
        {"ring_radius": 1e-2, "positions": [[0.0, 0.0]]},
    ],
)
def test_keys_of_an_arrangement_that_is_not_asked_for_are_refused(given):
    bead = {"radius": 1e-3, "density": 600.0, "contact_angle": 1.2, **given}
    with pytest.raises(SceneError, match="means something only with placement"):
        from_plain({"model": "floating", "duration": 1.0, "frame_every": 0.1, "particles": [bead]})


def test_games_and_fits_replace_arrangements_that_have_a_center():
    """They write positions in place of a ring around a point, or a lattice."""
    for keys in ({"placement": "ring", "ring_radius": 5e-3}, {"placement": "lattice", "spacing": 4e-3}):
        bead = {"radius": 1e-3, "density": 600.0, "contact_angle": 1.2, "count": 4, "center": [4e-3, 0.0], **keys}
        plain = {
            "model": "floating",
            "duration": 1.0,
            "frame_every": 0.1,
            "dish": {"radius": 0.03},
            "particles": [bead],
        }
        scene = from_plain(plain)
        assert len(species_of(scene, shelf=False)) == 1
        again = copy.deepcopy(to_plain(scene))
        _floats_start(again, np.linspace(-0.01, 0.01, 8).reshape(4, 2), None)
        assert len(from_plain(again).particles[0].positions) == 4
        moved = placed(scene, np.linspace(-0.01, 0.01, 8).reshape(4, 2), np.zeros((4, 2)), np.zeros(4, int))
        assert len(moved.particles[0].positions) == 4
