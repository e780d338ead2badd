"""Work on a liquid is in the energy budget, and energy never rises beyond it."""

import dataclasses

import numpy as np
import pytest

import ecume
from ecume.models.sph.boundaries.rigid_bodies import collide, with_moved_solids
from ecume.models.sph.boundaries.walls import reflect_particles
from ecume.models.sph.rates.right_hand_side import evaluate_accelerations, evaluate_density_rate
from ecume.models.sph.record import SPH
from ecume.models.sph.report.energy_budget import (
    add_diffusion_work,
    energies,
    energy_of_bodies,
    exchanged_energy,
    power_of_base_excitation,
    power_of_dummies,
    power_of_forces,
    power_taken_up,
    reflection_work,
)
from ecume.models.sph.report.observation import invariants
from ecume.models.sph.state import WORK
from ecume.run import RunDirectory
from ecume.run.invariant_monitor import Watch
from ecume.scenes.schema import from_plain, to_plain
from tests.models.sph.scenes import OPEN, PERIODIC, tank
from tests.models.sph.test_open_boundaries import channel
from tests.models.sph.test_prescribed_motion import PUSH, with_side
from tests.models.sph.test_rigid_bodies import tub
from tests.models.sph.test_solids import changed

pytestmark = pytest.mark.sampled(2)


def budget(scene, tmp_path):
    """Energy, work in the budget and energy less work of each frame, once all that must hold has held."""
    watch, rows = Watch(RunDirectory(tmp_path), invariants(scene, SPH.parameters(scene)), "warn"), []
    for number, frame in enumerate(ecume.simulate(scene)):
        watch.take(frame.time, frame.numbers, number)
        rows.append((frame.numbers["total_energy"], frame.numbers.get("injected_work", 0.0)))
    verdicts = {one.name: one for one in watch.verdicts()}
    assert verdicts["energy"].held, verdicts["energy"]
    energy, work = np.array(rows).T
    return energy - energy[0], work, energy - energy[0] - work


def between_plates(walls, **changes):
    """A lid that drags liquid of density 1 over a floor a meter below; round about along x."""
    lid = {"low": [0.0, 0.0], "high": [0.75, 1.0], "walls": walls, "left": PERIODIC, "right": PERIODIC}
    plain = {
        "model": "sph",
        "duration": 1.4,
        "frame_every": 0.2,
        "spacing": 0.125,
        "gravity": [0.0, 0.0],
        "liquid": {"density": 1.0, "viscosity": 0.5, "maximum_speed": 1.0},
        "tank": {**lid, "top": {"velocity": [1.0, 0.0]}},
        "fluid": [{"low": [0.0, 0.0], "high": [0.75, 1.0]}],
    }
    return from_plain({**plain, **changes})


@pytest.mark.compiled
def test_a_slow_piston_does_the_work_of_lifting(tmp_path):
    slow = {"times": [0.0, 4.0], "positions": [0.0, 0.2]}
    scene = changed(with_side(tank(jitter=0.0), "left", motion=slow), duration=4.0, frame_every=1.0)
    energy, work, _ = budget(scene, tmp_path)
    # A square of water becomes as much narrower as it becomes higher: its middle rises by an eighth.
    assert work[-1] == pytest.approx(0.125, rel=0.05)
    assert energy[-1] == pytest.approx(work[-1], rel=0.01)


@pytest.mark.compiled
@pytest.mark.parametrize("walls", ["mirror", "dummy"])
def test_a_lid_brings_what_friction_takes(walls, tmp_path):
    energy, work, own = budget(between_plates(walls), tmp_path)
    # In steady flow its stress, of viscosity and shear rate, times its speed and length; all of it is lost.
    power = 0.5 * 1.0 * 0.75
    assert np.diff(work)[-1] / 0.2 == pytest.approx(power, rel=0.02)
    assert -np.diff(own)[-1] / 0.2 == pytest.approx(power, rel=0.02)
    # A third of the mass goes as fast as the lid, in energy.
    assert energy[-1] == pytest.approx(0.75 / 6.0, rel=0.02)


@pytest.mark.compiled
def test_gravity_along_periodic_sides_brings_what_friction_takes(tmp_path):
    still = {"density_diffusion": "none"}  # its work would be among the whole numbers of lifts
    pulled = to_plain(between_plates("mirror", gravity=[1.0, 0.0], duration=2.4, method=still))
    pulled["tank"]["top"] = {"kind": "wall"}
    scene = from_plain(pulled)
    *_, last = ecume.simulate(scene)
    _, work, own = budget(scene, tmp_path)
    assert -np.diff(own)[-1] / 0.2 == pytest.approx(last.numbers["momentum_x"], rel=0.01)
    # Each particle that comes around is lifted by the length of the tank: whole ones are counted.
    assert work[-1] > 0.0
    assert work[-1] / (0.125**2 * 0.75) == pytest.approx(round(work[-1] / (0.125**2 * 0.75)), abs=1e-9)


@pytest.mark.compiled
def test_a_channel_brings_in_what_friction_takes_and_carries_out_the_rest(tmp_path):
    energy, work, own = budget(channel(), tmp_path)
    # Poiseuille's pressure gradient, twelve times viscosity and mean speed, over two meters.
    assert np.diff(own)[1:] / -0.5 == pytest.approx(1.2, rel=0.06)
    assert work[-1] == pytest.approx(1.2 * 1.5, rel=0.1)
    assert np.abs(energy).max() < 0.1 * work[-1]


@pytest.mark.compiled
def test_a_stream_that_nothing_rubs_gains_and_loses_nothing(tmp_path):
    plain = to_plain(channel())
    sides = {"left": {"kind": "inflow", "speed": 0.5, "level": 0.5}, "right": {"kind": "outflow", "level": 0.5}}
    plain["tank"] |= {**sides, "top": OPEN}
    plain |= {"gravity": [0.0, -1.0], "liquid": {"density": 1.0, "sound_speed": 10.0}, "frame_every": 0.1}
    plain["fluid"] = [{"low": [0.0, 0.0], "high": [2.0, 0.5], "velocity": [0.5, 0.0]}]
    energy, _, own = budget(from_plain(plain), tmp_path)
    # A row that comes in before another goes out is a twentieth of all the motion; the account knows it to 1e-3.
    assert np.abs(energy).max() > 5e-3
    assert np.abs(own).max() < 1e-4


@pytest.mark.long
@pytest.mark.compiled
def test_energy_that_a_body_loses_goes_to_the_liquid_and_none_is_created(tmp_path):
    scene = dataclasses.replace(tub(4.0, density_diffusion="none"), duration=0.4)
    first, *_, last = ecume.simulate(scene)
    energy, work, _ = budget(scene, tmp_path)
    lost = first.numbers["bodies_energy"] - last.numbers["bodies_energy"]
    assert lost > 5e-3
    assert 0.0 < np.abs(work).max() < 0.05 * lost  # of dummies
    # What starts all of a sudden loses a part of it to sound.
    assert 0.5 * lost < energy[-1] + lost < lost


def test_who_comes_in_brings_its_energy_and_who_is_lost_takes_it_along():
    plain = to_plain(tank(jitter=0.0))
    plain["tank"] |= {"bottom": OPEN}
    scene = from_plain(plain)
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    state.velocity[1] = -3.0
    state.position[1, 5] = -9.0
    each = state.mass[5] * (0.5 * 9.0 - 9.0)
    alone = np.arange(64) == 5
    assert exchanged_energy(parameters, state, ~alone & alone, alone) == pytest.approx(-each, rel=0.01)
    after = SPH.exchange(parameters, state)
    assert after.position.shape[1] == 63
    assert after.budget[WORK] == pytest.approx(-each, rel=0.01)


def test_the_guard_of_a_moving_wall_does_work_as_a_bat_does():
    """An elastic wall gives whoever it hits the energy that it gains."""
    plain = to_plain(with_side(tank(jitter=0.0), "left", motion=PUSH))
    scene = from_plain({**plain, "tank": {**plain["tank"], "restitution": 1.0}})
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    state.clock[0] = 0.5
    now = with_moved_solids(parameters, state)
    who = np.argsort(state.position[0])[:3]
    state.position[0, who], state.velocity[0, who] = 0.099, -1.0
    before = state.velocity.copy()
    reflect_particles(now.boundary.guard, state.position, state.velocity, np.zeros_like(before), 0.01)
    np.testing.assert_allclose(state.velocity[0, who], 1.0 + 2.0 * 0.2)
    gained = 0.5 * float(state.mass @ (state.velocity**2 - before**2).sum(axis=0))
    assert reflection_work(now, state, before) == pytest.approx(gained, rel=1e-12)


def test_a_wall_that_strikes_a_body_brings_what_the_body_gains():
    plain = to_plain(with_side(tank(jitter=0.0), "left", motion=PUSH))
    body = {"center": [0.3, 1.5], "radius": 0.2, "density": 0.5, "velocity": [-1.0, 0.0]}
    scene = from_plain({**plain, "bodies": [{**body, "restitution": 1.0, "friction": 0.0}]})
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    state.clock[0], state.pose[0] = 0.5, 0.29
    before = energy_of_bodies(parameters, state.pose, state.motion)
    now = with_moved_solids(parameters, state)
    hits, work = collide(now.bodies, now.boundary.guard.sheet, (state.pose, state.motion), 0.0)
    assert hits == 1
    # Struck centrally, without friction and loss: the reflected velocity in the frame of the wall, and no spin.
    assert state.motion[0, 0] == pytest.approx(1.0 + 2.0 * 0.2, rel=1e-12)
    assert state.motion[3:, 0] == pytest.approx(0.0, abs=1e-12)
    assert work == pytest.approx(energy_of_bodies(parameters, state.pose, state.motion) - before, rel=1e-9)


def test_a_base_excitation_pulls_at_bodies_too():
    scene = changed(tub(0.5), base_excitation={"amplitude": [2.0, 0.0], "frequency": 0.25})
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    state.velocity[0], state.motion[0], state.clock[0] = 0.1, -3.0, 1.0
    momentum = 0.1 * float(state.mass.sum()) - 3.0 * float(parameters.bodies.mass[0])
    assert power_of_base_excitation(parameters, state) == pytest.approx(2.0 * momentum, rel=1e-12)


def test_what_is_pulled_by_a_surface_and_moves_has_no_line_of_energy():
    plain = to_plain(with_side(tank(jitter=0.0), "left", motion=PUSH))
    plain["liquid"] |= {"surface_tension": 0.01}
    for scene, judged in ((from_plain(plain), False), (with_side(from_plain(plain), "left", motion=None), True)):
        names = [one.name for one in invariants(scene, SPH.parameters(scene))]
        assert ("energy" in names) == judged


def random_tank(seed, **integration):
    """Still water of 6 to 9 layers in a tank of any shape, and its weight times its depth."""
    dice = np.random.default_rng(seed)
    width, depth = dice.uniform(0.3, 1.5), dice.uniform(0.3, 2.0)
    spacing = depth / dice.integers(6, 10) * dice.uniform(0.95, 1.05)
    width = min(width, 10 * spacing)
    time = 4.0 * np.sqrt(depth / 9.81)
    plain = {
        "model": "sph", "duration": time, "frame_every": 0.25 * time, "spacing": spacing, "integration": integration,
        "tank": {"high": [width, 1.5 * depth], "top": {"kind": str(dice.choice(["wall", "open"]))}},
        "fluid": [{"low": [0.0, 0.0], "high": [width, depth]}],
    }  # fmt: skip
    return from_plain(plain), 1000.0 * 9.81 * depth * width * depth


@pytest.mark.compiled
@pytest.mark.parametrize("seed", range(3))
def test_the_energy_that_density_diffusion_brings_is_its_work(seed, tmp_path):
    """Still water is lifted a little by diffusion, which raises its energy by up to 1e-3 of rho g H times its volume:
    less the work of diffusion it never rises by 1e-4 of that.
    """
    scene, weight = random_tank(seed)
    energy, work, rest = budget(scene, tmp_path)
    rises = [float((each - np.minimum.accumulate(each)).max()) / weight for each in (energy, rest)]
    assert rises[1] < 1e-4
    assert rises[0] > 5.0 * rises[1]
    assert abs(work[-1]) > 1e-5 * weight


@pytest.mark.compiled
def test_the_sound_of_a_start_without_pressure_is_damped_and_brings_no_energy(tmp_path):
    method = {"initial_pressure": "zero", "artificial_viscosity": 0.0, "acoustic_damping": 2.0, "walls": "dummy"}
    rest = budget(tank(**method), tmp_path)[2]
    assert rest[-1] < -1e-3  # of rho g H times the volume
    assert np.diff(rest).max() < 1e-3 * -rest[-1]


@pytest.mark.parametrize("name", ["hydrostatic", "antuono", "linear", "molteni"])
@pytest.mark.parametrize("damping", [0.0, 2.0])
def test_the_work_of_diffusion_is_the_change_of_elastic_energy(name, damping):
    """In a step in which nothing else happens: to second order in the step. It works against acoustic damping, too."""
    scene = tank(density_diffusion=name, acoustic_damping=damping)
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    workspace = SPH.workspace(parameters, state, 1.0)
    evaluate_density_rate(parameters, state, workspace)
    count = len(state.density)
    errors = []
    for time in (2e-4, 1e-4):
        state.density_rate[:] = workspace.rates.diffusion[:count]
        state.budget[WORK] = 0.0
        add_diffusion_work(parameters, state, workspace, time)
        after = state._replace(density=state.density + time * state.density_rate)
        damped = parameters.bulk_viscosity * state.density_rate / state.density
        against = time * float(np.sum(state.mass / state.density**2 * damped * state.density_rate))
        change = elastic(parameters, after) - elastic(parameters, state)
        errors.append(abs(float(state.budget[WORK]) - change - against) / abs(change))
    assert errors[0] < 1e-4
    assert errors[1] < 0.6 * errors[0] + 1e-9


HIGH = {"center": [0.55, 0.6], "radius": 0.2, "density": 0.5, "velocity": [0.3, 0.2]}
LOW = {"center": [0.5, 0.25], "radius": 0.2, "density": 2.0, "velocity": [0.3, -0.5]}


@pytest.mark.parametrize("force", ["sum", "monaghan"])
@pytest.mark.parametrize(
    ("walls", "gravity", "bodies"),
    [("dummy", 1.0, []), ("dummy", 1.0, [HIGH]), ("mirror", 0.0, [LOW])],
    ids=["dummy walls", "a body between them", "a body between a floor and a piston of mirrors"],
)
def test_the_work_of_dummies_is_what_the_energies_gain(force, walls, gravity, bodies):
    """In a liquid that dissipates nothing, to rounding. A mirror adds the weight of what is between images. The liquid
    stores what compresses dummies at and near bodies: all but the weight between, which is zero without gravity.
    """
    exact = {"density_diffusion": "none", "artificial_viscosity": 0.0, "jitter": 0.1}
    scene = tank(walls=walls, pressure_force=force, **exact)
    plain = to_plain(with_side(scene, "left", motion=PUSH) if walls == "mirror" else scene)
    scene = from_plain({**plain, "bodies": bodies, "gravity": [0.0, -gravity]})
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    dice = np.random.default_rng(2)
    state.velocity[:] = dice.normal(size=state.velocity.shape)
    state.density[:] *= dice.uniform(1.005, 1.01, len(state.density))
    workspace = SPH.workspace(parameters, state, 1.0)
    evaluate_density_rate(parameters, state, workspace)
    evaluate_accelerations(parameters, state, workspace, 1e-3)
    push = state.acceleration - parameters.gravity[:, None]
    kinetic = float(np.sum(state.mass * (push * state.velocity).sum(axis=0)))
    pressure = workspace.fields.pressure[: len(state.mass)]
    elastic_power = float(np.sum(state.mass * pressure / state.density**2 * state.density_rate))
    pull = np.array([*parameters.gravity, 0.0, 0.0, 0.0, 0.0])[:, None]
    moved = float(np.sum(parameters.bodies.mass * ((state.body_acceleration - pull) * state.motion)[:3]))
    now = with_moved_solids(parameters, state)
    power = power_of_forces(now, state, workspace)
    stored, rest = power_taken_up(now, state, workspace), power_of_dummies(now, state, workspace)
    assert abs(stored if bodies else rest) > 0.005 * abs(elastic_power)
    assert gravity or abs(rest) < 1e-3 * abs(stored)
    assert kinetic + elastic_power + moved == pytest.approx(power, rel=1e-9)


def elastic(parameters, state):
    """The elastic energy of the liquid."""
    return energies(parameters, state, 0.0, 0.0)["elastic_energy"]


@pytest.mark.compiled
@pytest.mark.parametrize("walls", ["mirror", "dummy"])
def test_all_work_in_an_undriven_tank_is_that_of_the_numerical_method(walls):
    last = list(ecume.simulate(tank(walls=walls)))[-1].numbers
    assert last["injected_work"] != 0.0
    assert last["numerical_work"] == pytest.approx(last["injected_work"], rel=1e-9)


@pytest.mark.compiled
def test_the_work_of_a_moving_side_is_not_numerical():
    last = list(ecume.simulate(with_side(tank(jitter=0.0), "left", motion=PUSH)))[-1].numbers
    assert last["injected_work"] - last["numerical_work"] > 10.0 * abs(last["numerical_work"])
