"""Two liquids in one tank: stacked ones rest, of any densities; sums conserve momentum and energy; what knows one
liquid only is refused.
"""

from types import SimpleNamespace

import numpy as np
import pytest

import ecume
from ecume.errors import SceneError
from ecume.models.sph.boundaries.walls import FASTEST, speed_of
from ecume.models.sph.rates.right_hand_side import evaluate_accelerations, evaluate_density_rate, evaluate_rates
from ecume.models.sph.rates.surface_tension import contour_energy, contour_forces
from ecume.models.sph.record import SPH
from ecume.models.sph.report import observation
from ecume.models.sph.setup.initial_particles import column_head
from ecume.models.sph.state import particle_arrays
from ecume.run import run
from ecume.scenes.schema import from_plain, to_plain
from ecume.simulation import Integration
from tests.models.sph.scenes import OPEN, PERIODIC

CALM = {"shifting": "none", "acoustic_damping": 0.0, "density_diffusion": "none", "artificial_viscosity": 0.0}


def stacked(ratio, *, dense_below=True, deep=12, wide=6, **more):
    """Two layers of equal depth in a tank of height 1, full or open, periodic along x; first is the denser liquid."""
    spacing, height = 1.0 / deep, more.pop("height", 1.0)
    order = ("first", "second") if dense_below else ("second", "first")
    layers = [
        {"low": [0.0, y], "high": [wide * spacing, y + 0.5], "liquid": name}
        for y, name in zip((0.0, 0.5), order, strict=True)
    ]
    tank = {"high": [wide * spacing, height], "left": PERIODIC, "right": PERIODIC}
    if height > 1.0:
        tank["top"] = OPEN
    liquid, second = {"density": 1.0, **more.pop("liquid", {})}, {"density": 1.0 / ratio, **more.pop("second", {})}
    plain = {
        "model": "sph", "duration": 1.0, "frame_every": 0.1, "spacing": spacing, "gravity": [0.0, -1.0],
        "liquid": liquid, "second_liquid": second, "tank": tank, "fluid": layers,
    }  # fmt: skip
    return from_plain({**plain, **more})


def at_start(scene):
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    return parameters, state, SPH.workspace(parameters, state, 1.0)


def disturbed(scene, seed):
    """The same with random displacements, velocities and densities; the repulsion of walls does not act."""
    parameters, state, _ = at_start(scene)
    rng = np.random.default_rng(seed)
    state.position[...] += 0.2 * scene.spacing * rng.uniform(-1.0, 1.0, state.position.shape)
    state.position[1] = np.clip(state.position[1], 0.5 * scene.spacing, 1.0 - 0.5 * scene.spacing)
    state.velocity[...] = rng.uniform(-0.1, 0.1, state.velocity.shape)
    state.density[...] *= 1.0 + 0.01 * rng.uniform(-1.0, 1.0, state.density.shape)
    state.reference[...] = state.position
    return parameters, state, SPH.workspace(parameters, state, 1.0)


@pytest.mark.parametrize("ratio", [1.3, 2.0, 1000.0])
@pytest.mark.parametrize("height", [1.0, 1.5])
def test_stacked_liquids_of_any_densities_start_balanced(ratio, height):
    """With the plain sum p_i + p_j the lighter one starts with 0.26 of the ratio of densities, times g."""
    parameters, state, workspace = at_start(stacked(ratio, height=height, method=CALM))
    evaluate_accelerations(parameters, state, workspace, parameters.time_step)
    far_below_the_surface = state.position[1] < (1.0 if height == 1.0 else 0.75)
    assert np.abs(state.acceleration[:, far_below_the_surface]).max() < 0.2


@pytest.mark.parametrize("dense_below", [True, False])
def test_the_pressure_at_the_start_is_hydrostatic_across_the_interface(dense_below):
    scene = stacked(4.0, dense_below=dense_below, liquid={"sound_speed": 100.0}, second={"sound_speed": 100.0})
    _, state, workspace = at_start(scene)
    frame = Integration(SPH, SPH.parameters(scene), state, 0.0).observe()
    height, pressure = frame.arrays["position"][:, 1], frame.arrays["pressure"]
    lower, upper = (1.0, 0.25) if dense_below else (0.25, 1.0)
    exact = np.where(height > 0.5, upper * (1.0 - height), 0.5 * upper + lower * (0.5 - height))
    np.testing.assert_allclose(pressure, exact, rtol=2e-4)
    assert frame.arrays["liquid"].tolist() == [
        1 + (kind == (0 if not dense_below else 1)) for kind in frame.arrays["species"]
    ]
    assert workspace.fields.kind[: len(pressure)].tolist() == (1.0 + (state.region == int(dense_below))).tolist()


def test_a_column_has_one_pressure_on_both_sides_of_each_interface():
    parameters = SPH.parameters(stacked(10.0))
    heavy, light = parameters.materials
    alone = column_head([(heavy, 0.3), (heavy, 0.2)], 1.0)
    assert alone == pytest.approx(0.5)
    head = column_head([(heavy, 0.0), (light, 0.5)], 1.0)
    assert head * heavy.density == pytest.approx(0.5 * light.density, rel=1e-3)


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("integrator", ["symplectic", "verlet"])
def test_sums_of_two_liquids_conserve_momentum_and_energy(seed, integrator):
    """What the pressure does to kinetic energy, continuity takes from elastic energy; mirrors take momentum along y."""
    ratio = float(10.0 ** np.random.default_rng(seed).uniform(0.0, 3.0))
    scene = stacked(
        ratio, method=CALM, gravity=[0.0, 0.0], liquid={"maximum_speed": 1.0}, integration={"integrator": integrator}
    )
    parameters, state, workspace = disturbed(scene, seed)
    parameters = parameters._replace(fixed_volume=False)
    if integrator == "symplectic":
        evaluate_density_rate(parameters, state, workspace)
        evaluate_accelerations(parameters, state, workspace, parameters.time_step)
    else:
        evaluate_rates(parameters, state, workspace, parameters.time_step)
    force = state.mass * state.acceleration
    assert abs(force[0].sum()) < 1e-12 * np.abs(force[0]).sum()
    pressed = workspace.fields.pressure[: len(state.mass)]
    power = np.sum(force * state.velocity), np.sum(state.mass * pressed / state.density**2 * state.density_rate)
    assert np.abs(power).max() > 1e-3
    assert sum(power) == pytest.approx(0.0, abs=1e-10 * np.abs(force * state.velocity).sum())


def test_one_sum_of_both_rates_equals_two():
    scene = stacked(7.0, method={"shifting": "none"})
    parameters, state, workspace = disturbed(scene, 1)
    evaluate_density_rate(parameters, state, workspace)
    rate = state.density_rate.copy()
    evaluate_accelerations(parameters, state, workspace, parameters.time_step)
    acceleration = state.acceleration.copy()
    state.density_rate[...] = rate
    evaluate_rates(parameters, state, workspace, parameters.time_step)
    np.testing.assert_allclose(state.density_rate, rate, rtol=1e-9, atol=1e-12 * np.abs(rate).max())
    np.testing.assert_allclose(state.acceleration, acceleration, rtol=1e-9, atol=1e-9 * np.abs(acceleration).max())


def test_two_equal_liquids_do_as_one():
    quiet = {"density_diffusion": "none", "artificial_viscosity": 0.0, "acoustic_damping": 2.0}
    found = []
    for scene in (two := stacked(1.0, method=quiet), from_plain_of_one(two)):
        parameters, state, workspace = disturbed(scene, 3)
        evaluate_density_rate(parameters, state, workspace)
        evaluate_accelerations(parameters, state, workspace, parameters.time_step)
        found.append(state.acceleration.copy())
    np.testing.assert_allclose(*found, rtol=1e-9, atol=1e-9)


def from_plain_of_one(scene):
    """The scene with liquid 1 everywhere."""
    regions = [{"low": list(each.low), "high": list(each.high)} for each in scene.fluid]
    return from_plain(
        {
            "model": "sph", "duration": 1.0, "frame_every": 0.1, "spacing": scene.spacing, "gravity": [0.0, -1.0],
            "liquid": {"density": 1.0}, "fluid": regions,
            "tank": {"high": list(scene.tank.high), "left": PERIODIC, "right": PERIODIC},
            "method": {"density_diffusion": "none", "artificial_viscosity": 0.0, "acoustic_damping": 2.0},
        }
    )  # fmt: skip


@pytest.mark.long
@pytest.mark.parametrize("seed", range(3))
def test_it_does_not_matter_which_liquid_is_the_first(seed):
    """Forces, rates, time steps and the scales of invariants, with viscosities and the usual damping and diffusion."""
    ratio, found = float(10.0 ** np.random.default_rng(seed).uniform(0.0, 3.0)), []
    dense, light = {"density": 1.0, "viscosity": 0.02}, {"density": 1.0 / ratio, "viscosity": 0.01}
    for liquid, second, dense_below in ((dense, light, True), (light, dense, False)):
        scene = stacked(ratio, liquid=liquid, second=second, dense_below=dense_below)
        parameters, state, workspace = disturbed(scene, seed)
        evaluate_rates(parameters, state, workspace, parameters.time_step)
        evaluate_rates(parameters, state, workspace, parameters.time_step)  # damping has the rate of the one before
        scales = [row.name for row in SPH.invariants(scene, parameters)], observation._faint(parameters)(ONE)
        found.append((state.acceleration, state.density_rate, parameters.time_step, *scales))
    (acceleration, rate, step, names, faint), other = found
    np.testing.assert_allclose(other[0], acceleration, rtol=1e-9, atol=1e-9 * np.abs(acceleration).max())
    np.testing.assert_allclose(other[1], rate, rtol=1e-9, atol=1e-9 * np.abs(rate).max())
    assert other[2] == pytest.approx(step)
    assert (other[3], other[4]) == (names, pytest.approx(faint))


ONE = SimpleNamespace(first={"volume": 1.0})
"""A run of one cubic meter."""


def test_density_diffuses_within_each_liquid_only():
    """Compressed as a whole, a layer does not lose density to the other one."""
    parameters, state, workspace = at_start(stacked(3.0, gravity=[0.0, 0.0], liquid={"maximum_speed": 1.0}))
    state.density[state.region == 0] *= 1.02
    evaluate_density_rate(parameters, state, workspace)
    assert np.abs(workspace.rates.diffusion).max() < 1e-9 * np.abs(state.density).max()
    state.density[:5] *= 1.02
    evaluate_density_rate(parameters, state, workspace)
    assert np.abs(workspace.rates.diffusion).max() > 1e-3


def test_forces_on_mirrors_bear_the_weight_of_both_liquids():
    scene = stacked(2.0, method=CALM)
    parameters, state, _ = at_start(scene)
    frame = Integration(SPH, parameters, state, 0.0).observe()
    weight = float(state.mass.sum())
    assert -frame.numbers["bottom_force_y"] - frame.numbers["top_force_y"] == pytest.approx(weight, rel=0.01)
    assert frame.numbers["first_center_y"] == pytest.approx(0.25, abs=0.005)
    assert frame.numbers["second_center_y"] == pytest.approx(0.75, abs=0.005)


@pytest.mark.compiled
@pytest.mark.parametrize("dense_below", [True, False])
def test_the_interface_pulls_by_the_derivative_of_its_energy(dense_below):
    """At a right angle to the walls its energy is the tension times its length, and only its liquid is pulled."""
    scene = stacked(2.0, dense_below=dense_below, deep=10, second={"interface_tension": 0.3})
    parameters, state, workspace = disturbed(scene, 2)
    evaluate_accelerations(parameters, state, workspace, parameters.time_step)
    force = contour_forces(parameters, workspace, state.mass)
    assert not force[:, state.region == int(dense_below)].any()
    for particle in np.flatnonzero(state.region == int(not dense_below))[::7]:
        before = state.position[1, particle]
        energy = []
        for step in (-1e-6, 1e-6):
            state.position[1, particle] = before + step
            state.reference[...] = state.position
            workspace = SPH.workspace(parameters, state, 1.0)
            evaluate_accelerations(parameters, state, workspace, parameters.time_step)
            energy.append(contour_energy(parameters, workspace))
        state.position[1, particle] = before
        assert force[1, particle] == pytest.approx(-(energy[1] - energy[0]) / 2e-6, rel=1e-4, abs=1e-6)


@pytest.mark.parametrize(
    ("more", "path"),
    [
        ({"method": {"pressure": "incompressible"}}, "method.pressure"),
        ({"method": {"pressure_force": "monaghan"}}, "method.pressure_force"),
        ({"method": {"pressure_split": "modified"}}, "method.pressure_split"),
        ({"method": {"density_diffusion": "antuono"}}, "method.density_diffusion"),
        ({"method": {"artificial_viscosity": 0.1}}, "method.artificial_viscosity"),
        ({"method": {"turbulence": "smagorinsky"}}, "method.turbulence"),
        ({"method": {"surface_tension_model": "cohesion"}}, "method.surface_tension_model"),
        ({"liquid": {"surface_tension": 0.1}}, "liquid.surface_tension"),
        ({"liquid": {"viscosity": 0.1}}, "second_liquid.viscosity"),
        ({"second": {"density": 1e-4}}, "second_liquid.density"),
        ({"obstacles": [{"center": [0.2, 0.2], "radius": 0.1}]}, "obstacles"),
        ({"gauges": [{"name": "P", "position": [0.1, 0.1], "quantities": ["dynamic_pressure"]}]}, "gauges"),
    ],
)  # fmt: skip
def test_what_knows_one_liquid_only_is_refused(more, path):
    with pytest.raises(SceneError, match=path.replace(".", r"\.")):
        SPH.parameters(stacked(2.0, **more))


def test_regions_and_the_second_liquid_need_each_other():
    with pytest.raises(SceneError, match="no region has"):
        stacked(2.0, fluid=[{"low": [0.0, 0.0], "high": [0.5, 1.0]}])
    with pytest.raises(SceneError, match="all regions have it"):
        stacked(2.0, fluid=[{"low": [0.0, 0.0], "high": [0.5, 1.0], "liquid": "second"}])
    plain = {"model": "sph", "duration": 1.0, "frame_every": 0.1, "spacing": 0.1, "tank": {"high": [1.0, 1.0]}}
    with pytest.raises(SceneError, match=r"write the table"):
        from_plain({**plain, "fluid": [{"low": [0.0, 0.0], "high": [0.5, 1.0], "liquid": "second"}]})


def test_a_run_of_two_liquids_is_the_start_of_another(tmp_path):
    run(stacked(2.0, deep=6, duration=0.02, frame_every=0.02), tmp_path / "one")
    table = "[second_liquid]\ndensity = 0.5\n"
    text = (
        'model = "sph"\nduration = 1.0\nframe_every = 0.1\nstart_from = "one@-1"\ngravity = [0.0, -1.0]\n'
        f"[liquid]\ndensity = 1.0\n{table}[tank]\nhigh = [1.0, 1.0]\n"
        'left = { kind = "periodic" }\nright = { kind = "periodic" }\n'
    )
    (tmp_path / "two.toml").write_text(text)
    _, state, _ = at_start(ecume.load_scene(tmp_path / "two.toml"))
    assert 0.45 < state.density[state.region == 1].min() <= state.density[state.region == 1].max() < 0.55
    (tmp_path / "two.toml").write_text(text.replace(table, ""))
    with pytest.raises(SceneError, match=r"there is no \[second_liquid\]"):
        ecume.load_scene(tmp_path / "two.toml")


def test_a_liquid_that_has_left_has_no_center():
    parameters, state, _ = at_start(stacked(2.0, height=1.5))
    kept = {name: array[..., state.region == 0] for name, array in particle_arrays(state).items()}
    found = observation.of_liquids(parameters, state._replace(**kept))
    assert found["first_center_y"] == pytest.approx(0.25, abs=0.01)
    assert np.isnan(found["second_center_y"])


def test_check_reports_the_tension_of_the_interface_only():
    named = {"density": None, "name": "water"}, {"density": None, "name": "ethanol"}
    still, acting = ({"interface_tension": 0.0}, {"interface_tension": 0.02})
    rows = [
        {row[0]: row[1:] for row in SPH.summary(stacked(2.0, deep=8, liquid=named[0], second={**named[1], **each}))}
        for each in (still, acting)
    ]
    assert not {"surface tension", "Bond number", "wave damping"} & rows[0].keys()
    assert rows[1]["second liquid: interface tension"][0] == "0.02 N/m"
    assert float(rows[1]["Bond number"][0]) == pytest.approx((998.2 - 789.5) * 0.5**2 / 0.02, rel=0.01)


def test_check_warns_of_a_lattice_that_resists_shear():
    for jitter, warns in ((0.0, True), (0.2, False)):
        rows = [row[0] for row in SPH.summary(stacked(2.0, deep=8, method={"jitter": jitter}))]
        assert ("particles at the start" in rows) == warns


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize("seed", range(4))
def test_random_stacked_liquids_stay_at_rest(seed):
    """Full or open tanks, with random displacements: they come to rest, unmixed, and gain no energy. Full ones, with
    larger displacements, gained up to 24 % of their potential energy; particles that settle raise it once.
    """
    rng = np.random.default_rng([45, seed])
    ratio, height = float(10.0 ** rng.uniform(0.1, 1.5)), float(rng.choice([1.0, 1.4]))
    jitter, most = (0.2, 5e-4) if height == 1.0 else (0.05, 1e-4)
    scene = stacked(ratio, deep=16, wide=8, height=height, method={"jitter": jitter}, duration=3.0, frame_every=0.3)
    frames = list(ecume.simulate(scene))
    energy = np.array([each.numbers["total_energy"] - each.numbers["injected_work"] for each in frames])
    assert (energy - np.minimum.accumulate(energy)).max() < most * frames[0].numbers["potential_energy"]
    last = frames[-1]
    height_of, liquid = last.arrays["position"][:, 1], last.arrays["liquid"]
    assert height_of[liquid == 1].max() < height_of[liquid == 2].min()
    assert last.numbers["largest_speed"] < 0.03


@pytest.mark.parametrize("height", [1.0, 1.4])
def test_rotation_as_a_whole_is_free_of_friction_where_two_viscosities_meet(height):
    """The stress is eta (grad v + its transpose): div(eta grad v) turns the interface."""
    wide = {"liquid": {"viscosity": 0.5, "maximum_speed": 1.0}, "second": {"viscosity": 0.01}, "height": height}
    scene = stacked(2.0, deep=10, wide=12, gravity=[0.0, 0.0], method=CALM, **wide)
    parameters, state, workspace = disturbed(scene, 4)
    evaluate_accelerations(parameters, state, workspace, parameters.time_step)
    still = state.acceleration.copy()
    x, y = state.position - np.array([[0.6], [0.5]])
    state.velocity[...] += 5.0 * np.stack([-y, x])
    found = {}
    for name in ("automatic", "morris"):
        chosen = SPH.parameters(from_plain({**to_plain(scene), "method": {**CALM, "viscosity_model": name}}))
        evaluate_accelerations(chosen, state, workspace, parameters.time_step)
        found[name] = state.acceleration - still
    inner = (np.abs(x) < 0.18) & (np.abs(y) < 0.08)  # all their neighbors rotate
    assert inner.sum() > 4
    assert np.abs(found["automatic"][:, inner]).max() < 1e-9 * np.abs(found["morris"][:, inner]).max()


@pytest.mark.parametrize("dense_first", [True, False])
def test_walls_repel_what_the_faster_sound_allows(dense_first):
    """Whichever liquid is the first one."""
    dense, light = {"density": 1.0}, {"density": 0.01}
    liquid, second = (dense, light) if dense_first else (light, dense)
    scene = stacked(2.0, liquid=liquid, second=second, dense_below=dense_first, gravity=[0.0, -1.0])
    parameters = SPH.parameters(scene)
    fastest = max(each.sound_speed for each in parameters.materials)
    assert speed_of(parameters) == FASTEST * fastest == pytest.approx(FASTEST * 10.0 * np.sqrt(2.0 * 100.0))


@pytest.mark.long
@pytest.mark.parametrize("ratio", [2.0, 1000.0])
def test_stacked_liquids_start_balanced_in_3d(ratio):
    spacing, wide = 1.0 / 8.0, 5.0 / 8.0
    tank = {"high": [wide, 1.0, wide], "left": PERIODIC, "right": PERIODIC, "front": PERIODIC, "back": PERIODIC}
    layers = [
        {"low": [0.0, y, 0.0], "high": [wide, y + 0.5, wide], "liquid": name}
        for y, name in ((0.0, "first"), (0.5, "second"))
    ]
    scene = from_plain(
        {
            "model": "sph", "duration": 1.0, "frame_every": 0.1, "spacing": spacing, "gravity": [0.0, -1.0, 0.0],
            "liquid": {"density": 1.0}, "second_liquid": {"density": 1.0 / ratio}, "tank": tank, "fluid": layers,
            "method": CALM,
        }
    )  # fmt: skip
    parameters, state, workspace = at_start(scene)
    evaluate_accelerations(parameters, state, workspace, parameters.time_step)
    assert np.abs(state.acceleration).max() < 0.2
    evaluate_density_rate(parameters, state, workspace)
    assert not state.density_rate.any()
