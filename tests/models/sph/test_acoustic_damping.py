"""The acoustic damper takes the energy of sound, and of nothing else. By default it acts where liquid may hit walls."""

import dataclasses

import numpy as np
import pytest

import ecume
from ecume.errors import SceneError
from ecume.laws.time_step_limits import late_damping_limit
from ecume.models.sph.integration import time_stepping
from ecume.models.sph.rates.right_hand_side import _sum_pressure, evaluate_accelerations, evaluate_density_rate, fill
from ecume.models.sph.record import SPH
from ecume.models.sph.report.energy_budget import power_of_dummies
from ecume.models.sph.setup.building import DAMPING, bulk_viscosity_of, limiter, limits_of, material_of
from ecume.models.sph.setup.choices import acoustic_damping_of
from ecume.scenes.schema import from_plain, to_plain
from ecume_validation import random_tanks
from tests.models.sph.scenes import PERIODIC, free_blob, tank

pytestmark = pytest.mark.sampled(2)

FORCES = ["sum", "monaghan", "corrected"]


def started(scene, seed=0):
    """Parameters, state and workspace, with velocities and densities by chance."""
    parameters = SPH.parameters(scene)
    state, dice = SPH.start(scene, parameters), np.random.default_rng(seed)
    state.velocity[:] = dice.normal(size=state.velocity.shape)
    state.density[:] *= dice.uniform(0.99, 1.01, state.density.shape)
    workspace = SPH.workspace(parameters, state, 1.0)
    fill(parameters, state, workspace)
    return parameters, state, workspace


def damping_of(parameters, state, workspace):
    """(d, N) m/s^2, the acceleration by the damper, and the power (W) of its pressure at dummies: those with it less
    those without.
    """
    found, powers = [], []
    for each in (parameters, parameters._replace(bulk_viscosity=0.0)):
        evaluate_density_rate(each, state, workspace)
        fill(each, state, workspace)
        _sum_pressure(each, workspace)
        found.append(workspace.rates.acceleration[: parameters.dimension].copy())
        powers.append(power_of_dummies(each, state, workspace))
    push = found[0] - found[1]
    return push / state.density if parameters.pressure_force.per_volume else push, powers[0] - powers[1]


def strain_rates(parameters, state, workspace):
    """(N,) 1/s: the divergence by the equation of continuity, and the relative rate of density with diffusion."""
    evaluate_density_rate(parameters, state, workspace)
    rate, diffusion = workspace.rates.continuity.copy(), workspace.rates.diffusion / state.density
    rate /= state.density if parameters.pressure_force.by_mass else 1.0
    return -rate, rate + diffusion


@pytest.mark.compiled
@pytest.mark.parametrize("force", FORCES)
@pytest.mark.parametrize("walls", ["mirror", "dummy"])
@pytest.mark.parametrize("diffusion", ["none", "automatic"])
def test_the_damper_does_the_power_of_its_pressure_and_takes_energy_without_diffusion(force, walls, diffusion):
    """Without diffusion it takes zeta V (div v)^2 from each particle."""
    method = {"acoustic_damping": 0.5, "artificial_viscosity": 0.0, "density_diffusion": diffusion}
    scene = tank(walls=walls, pressure_force=force, **method)
    # Under gravity the volume of an image differs from that of its source, by a ten-thousandth here.
    parameters, state, workspace = started(dataclasses.replace(scene, gravity=(0.0, 0.0)))
    push, at_dummies = damping_of(parameters, state, workspace)
    assert (at_dummies != 0.0) == (walls == "dummy")
    volume = state.mass / state.density
    divergence, rate = strain_rates(parameters, state, workspace)
    damping = parameters.bulk_viscosity * parameters.pressure_force.damping_shares(workspace.fields, len(rate))
    power = np.sum(damping * volume * rate * divergence)
    assert np.sum(state.mass * push * state.velocity) - at_dummies == pytest.approx(power, rel=1e-9)
    if diffusion == "none":
        assert power == pytest.approx(-np.sum(damping * volume * divergence**2), rel=1e-9)
    assert parameters.bulk_viscosity == pytest.approx(0.125 * 10.0)  # alpha rho c h, h of two spacings of 1/8


@pytest.mark.compiled
@pytest.mark.parametrize("force", FORCES)
@pytest.mark.parametrize("dimension", [2, 3])
def test_the_damper_keeps_the_momentum_and_does_not_act_on_rigid_motion(force, dimension):
    scene = free_blob(dimension, acoustic_damping=0.5, pressure_force=force, density_diffusion="none")
    parameters, state, workspace = started(scene)
    push, _ = damping_of(parameters, state, workspace)
    scale = np.abs(state.mass * push).sum()
    assert np.abs((state.mass * push).sum(axis=1)).max() < 1e-12 * scale
    state.velocity[:] = 0.3
    state.velocity[0] += 2.0 * state.position[1]
    state.velocity[1] -= 2.0 * state.position[0]
    assert np.abs(damping_of(parameters, state, workspace)[0]).max() < 1e-9 * np.abs(push).max()


@pytest.mark.compiled
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("precision", ["double", "single"])
def test_dummies_have_the_mean_damping_of_the_liquid_before_them(dimension, precision):
    parameters, state, workspace = started(walled(dimension, precision=precision), 2)
    evaluate_density_rate(parameters, state, workspace)
    fill(parameters, state, workspace)
    fields, count = workspace.fields, state.position.shape[1]
    damping = fields.damping
    np.testing.assert_allclose(fields.force_term, fields.pressure + damping, rtol=1e-6, atol=1e-6)
    x, given, reach = fields.position[:dimension, :count], damping[:count], parameters.support
    seen = 0
    for dummy in range(count, len(workspace.lists.counts)):
        away = np.sqrt(((x - fields.position[:dimension, dummy][:, None]) ** 2).sum(axis=0))
        weight = np.where(away < reach, (1.0 - away / reach) ** 4 * (1.0 + 4.0 * away / reach), 0.0)  # Wendland's C2
        if weight.sum() > 1e-3:
            seen += 1
            tolerance = 1e-9 if precision == "double" else 1e-3
            expected = weight @ given / weight.sum()
            assert damping[dummy] == pytest.approx(expected, rel=tolerance, abs=tolerance * float(np.abs(given).max()))
    assert seen > 10


def walled(dimension, **method):
    """A little liquid between walls of dummy particles."""
    side = [1.0] * dimension
    return from_plain(
        {
            "model": "sph", "duration": 1.0, "frame_every": 0.1, "spacing": 0.2,
            "liquid": {"density": 1.0, "sound_speed": 10.0, "maximum_speed": 1.0},
            "gravity": [0.0, -1.0, 0.0][:dimension],
            "tank": {"high": [1.0, 2.0, 1.0][:dimension], "walls": "dummy"},
            "fluid": [{"low": [0.0] * dimension, "high": side}],
            "method": {"acoustic_damping": 1.0, "jitter": 0.2, **method},
        }
    )  # fmt: skip


@pytest.mark.compiled
def test_water_in_a_narrow_gap_between_dummies_stays_at_rest():
    """Between a wall and a block, 2.3 spacings apart. Without damping at the dummies it moves at 0.1 sqrt(g H)."""
    scene = random_tanks.random_tank(2, 33)
    assert (scene.tank.walls, acoustic_damping_of(scene)) == ("dummy", 2.0)
    found = random_tanks.rest(scene)
    assert found.speed < 0.005
    assert found.error < 0.01


@pytest.mark.compiled
@pytest.mark.parametrize("walls", ["mirror", "dummy"])
@pytest.mark.parametrize("force", FORCES)
def test_the_recorded_forces_on_walls_are_opposite_to_what_accelerates_the_liquid(walls, force):
    scene = tank(walls=walls, acoustic_damping=0.5, pressure_force=force, artificial_viscosity=0.0)
    parameters, state, workspace = started(scene, 4)
    evaluate_density_rate(parameters, state, workspace)
    evaluate_accelerations(parameters, state, workspace, parameters.time_step)
    felt = (state.mass * state.acceleration).sum(axis=1) - state.mass.sum() * parameters.gravity
    numbers = SPH.observe(parameters, state, workspace).numbers
    for axis, own in zip("xy", felt, strict=True):
        pressed = sum(numbers[f"{side}_force_{axis}"] for side in ("left", "right", "bottom"))
        assert pressed == pytest.approx(-own, rel=1e-9)


@pytest.mark.compiled
@pytest.mark.parametrize("integrator", ["symplectic", "verlet"])
def test_a_column_that_starts_without_pressure_is_soon_quiet(integrator):
    """A quarter of a wave, k = pi/2H, decays at the rate alpha c h k^2/2 = 4.6, its energy by exp(-9). Mirrors under
    gravity keep energy within 1e-4; what they bring falls with the motion.
    """
    start = {"initial_pressure": "zero", "jitter": 0.0, "density_diffusion": "none", "integrator": integrator}
    moving, quiet = (list(ecume.simulate(tank(**start, acoustic_damping=alpha))) for alpha in (0.0, 1.5))
    assert quiet[-1].numbers["kinetic_energy"] < 1e-3 * max(f.numbers["kinetic_energy"] for f in moving[-5:])
    energies = [np.array([frame.numbers["total_energy"] for frame in frames]) for frames in (moving, quiet)]
    gains = [float(np.diff(energy).max()) for energy in energies]
    assert gains[1] < 0.1 * gains[0]
    assert energies[1][-1] < energies[0].min()


def wave(alpha, integrator="symplectic"):
    """A standing wave of sound over the length of a periodic box: its kinetic energy (J/m) over time."""
    positions = [((i + 0.5) / 32, (j + 0.5) / 32) for i in range(32) for j in range(8)]
    scene = from_plain(
        {
            "model": "sph", "duration": 0.5, "frame_every": 0.001, "spacing": 1.0 / 32, "gravity": [0.0, 0.0],
            "liquid": {"density": 1.0, "sound_speed": 10.0, "maximum_speed": 1.0, "tait_exponent": 1.0},
            "tank": {"high": [1.0, 0.25], "left": PERIODIC, "right": PERIODIC, "bottom": PERIODIC, "top": PERIODIC},
            "fluid": [
                {
                    "particles": {
                        "positions": positions,
                        "velocities": [(0.001 * np.sin(2.0 * np.pi * x), 0.0) for x, _ in positions],
                    }
                }
            ],
            "method": {
                "acoustic_damping": alpha, "artificial_viscosity": 0.0, "density_diffusion": "none", "shifting": "none"
            },
            "integration": {"integrator": integrator},
        }
    )  # fmt: skip
    frames = list(ecume.simulate(scene))
    return np.array([frame.time for frame in frames]), np.array([frame.numbers["kinetic_energy"] for frame in frames])


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize(("integrator", "lag"), [("symplectic", 0.0), ("verlet", 1.0)])
def test_sound_decays_at_half_the_bulk_viscosity_times_the_squared_wavenumber(integrator, lag):
    """The wavenumber is that of the smoothed gradients, w/c: a frequency of the undamped wave gives it. Damping by the
    rate of density a step ago is stronger by its factor 1/(1 - alpha h w^2 dt/c).
    """
    time, energy = wave(0.0)
    peaks = np.flatnonzero((energy[1:-1] > energy[:-2]) & (energy[1:-1] >= energy[2:])) + 1
    frequency = np.pi / np.diff(time[peaks]).mean()  # the energy has twice that of the wave
    assert frequency == pytest.approx(10.0 * 2.0 * np.pi, rel=0.03)
    damped = wave(0.5, integrator)[1]
    peaks = np.flatnonzero((damped[1:-1] > damped[:-2]) & (damped[1:-1] >= damped[2:])) + 1
    rate = -0.5 * np.polyfit(time[peaks], np.log(damped[peaks]), 1)[0]
    twice = 0.5 * (2.0 / 32) / 10.0 * frequency**2  # alpha c h k^2
    step = 0.25 * (2.0 / 32) / 11.0
    assert rate == pytest.approx(0.5 * twice / (1.0 - lag * twice * step), rel=0.01)


@pytest.mark.compiled
def test_a_coefficient_of_zero_damps_nothing():
    parameters, state, workspace = started(tank(acoustic_damping=0.0))
    evaluate_density_rate(parameters, state, workspace)
    fill(parameters, state, workspace)
    assert (workspace.fields.force_term == workspace.fields.pressure).all()


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"pressure": "incompressible"}, "no sound waves"),
        ({"pressure_force": "transport"}, "which 'transport' does not take"),
    ],
)
def test_what_has_no_such_sound_is_refused(change, says):
    scene = tank(**change)
    scene = dataclasses.replace(scene, liquid=dataclasses.replace(scene.liquid, sound_speed=None))
    scene = dataclasses.replace(
        scene, method=dataclasses.replace(scene.method, acoustic_damping=1.0),
        tank=dataclasses.replace(scene.tank, top=scene.tank.bottom), fluid=scene.fluid,
    )  # fmt: skip
    with pytest.raises(SceneError, match=says):
        SPH.parameters(scene)


def full(**method):
    """A tank with a lid on the liquid."""
    plain = to_plain(tank(**method))
    return from_plain({**plain, "tank": {"low": [0.0, 0.0], "high": [1.0, 1.0]}})


def incompressible():
    """A tank of a liquid without sound."""
    plain = to_plain(tank(pressure="incompressible"))
    return from_plain({**plain, "liquid": {"density": 1.0, "maximum_speed": 1.0}})


def floating(density, **method):
    """A disc of two spacings radius in a liquid of density 1."""
    plain = to_plain(tank(deep=12, **method))
    return from_plain({**plain, "bodies": [{"center": [0.5, 0.5], "radius": 0.17, "density": density}]})


@pytest.mark.parametrize("density", [0.001, 0.01, 0.1, 1.0])
def test_by_default_damping_does_not_shorten_the_step_of_a_light_body(density):
    given = {"acoustic_damping": 0.0}, {}, {"acoustic_damping": 2.0}
    free, damped, forced = (SPH.parameters(floating(density, **method)) for method in given)
    assert damped.time_step == free.time_step
    assert 0.0 < damped.bulk_viscosity <= forced.bulk_viscosity
    assert (forced.time_step < 0.5 * free.time_step) == (density < 0.5)


@pytest.mark.compiled
@pytest.mark.long
@pytest.mark.parametrize("damping", [{}, {"acoustic_damping": 2.0}])
@pytest.mark.parametrize("density", [0.003, 0.03])
def test_a_light_body_is_stable_with_damping(density, damping):
    # A thousand steps are enough, and damping that is asked for makes them the shorter, the lighter the body is.
    every = 0.05 * density / 0.03 if damping else 0.1
    scene = dataclasses.replace(floating(density, jitter=0.0, **damping), duration=2.0 * every, frame_every=every)
    frames = list(ecume.simulate(scene))
    speeds = [frame.numbers["body0_velocity_y"] for frame in frames]
    assert 0.0 < speeds[1] < speeds[-1] < 1.0


@pytest.mark.parametrize(
    ("scene", "expected"),
    [
        (tank(), 2.0),
        (tank(walls="dummy"), 2.0),
        (tank(viscosity=0.01), 2.0),
        (tank(acoustic_damping=0.5), 0.5),
        (tank(acoustic_damping=0.0), 0.0),
        (tank(artificial_viscosity=0.0), 0.0),
        (tank(walls="reflect"), 0.0),
        (full(), 0.0),
        (full(pressure_force="transport"), 0.0),
        (incompressible(), 0.0),
    ],
)
def test_by_default_sound_is_damped_where_liquid_may_hit_walls(scene, expected):
    assert acoustic_damping_of(scene) == expected
    parameters = SPH.parameters(scene)
    assert parameters.bulk_viscosity == pytest.approx(expected * 0.25 * 10.0)  # alpha rho c h, h of two spacings of 1/8


@pytest.mark.compiled
@pytest.mark.parametrize("integrator", ["symplectic", "verlet"])
def test_the_damping_of_a_particle_goes_with_it_when_the_lists_are_renewed(integrator, monkeypatch):
    """Renewed lists may have another order of particles: the damping is still by each one's own rate of density."""
    seen, renew = [], time_stepping.renew

    def watched(parameters, state, workspace):
        before = dict(zip(state.identity.tolist(), state.density_rate.tolist(), strict=True))
        former = state.identity.copy()
        renew(parameters, state, workspace)
        fill(parameters, state, workspace)
        rates = np.array([before[i] for i in state.identity.tolist()])
        expected = parameters.bulk_viscosity * rates / state.density
        np.testing.assert_allclose(workspace.fields.damping[: len(rates)], expected, rtol=1e-12)
        seen.append(bool((state.identity != former).any() and np.abs(rates).max() > 0.0))

    monkeypatch.setattr(time_stepping, "renew", watched)
    monkeypatch.setattr(time_stepping, "SORT_EVERY", 1)
    parameters, state, workspace = started(tank(jitter=0.3, integrator=integrator))
    state.velocity[...] *= 0.3
    SPH.advance(parameters, state, workspace, 300)
    assert any(seen)


@pytest.mark.compiled
@pytest.mark.parametrize("walls", ["mirror", "dummy"])
def test_liquid_in_free_fall_has_no_pressure(walls):
    """Density diffusion pulls it toward a hydrostatic one, and flow balances that: which is no sound."""
    plain = to_plain(tank(deep=12, jitter=0.0, initial_pressure="zero", walls=walls))
    plain["tank"] |= {"low": [-2.0, -6.0], "high": [3.0, 6.0]}
    last = list(ecume.simulate(from_plain({**plain, "duration": 2.0})))[-1]
    assert np.abs(last.arrays["pressure"]).max() < 0.02


def growth_of_sound(swing, decay):
    """The largest growth per step of a damped wave in the Verlet scheme, for omega dt and zeta k^2 dt / rho."""

    def step(wave):
        density, velocity, force, rate = wave
        ahead = velocity + force
        now, push = swing * ahead, -swing * (density + rate) - decay * rate / swing
        return density + 0.5 * (rate + now), velocity + 0.5 * (force + push), push, now

    return np.abs(np.linalg.eigvals(np.array([step(row) for row in np.eye(4)]).T)).max()


@pytest.mark.parametrize("swing", [0.05, 0.1, 0.2, 0.3])
def test_the_limit_of_late_damping_is_within_that_of_the_eigenvalues_of_a_step(swing):
    """By the factor 2: gradients are larger than those of a lattice near surfaces and where impacts press liquid."""
    wavenumber, dense = 10.0, 1000.0
    most = late_damping_limit(dense, 1.0, wavenumber) * wavenumber**2 / dense
    assert all(growth_of_sound(swing, part * most) <= 1.0 for part in (0.1, 0.5, 0.9, 1.0))
    assert growth_of_sound(swing, 2.0 * most) <= 1.0
    assert growth_of_sound(swing, 2.4 * most) > 1.0


@pytest.mark.compiled
@pytest.mark.parametrize("kernel", ["wendland-c2", "wendland-c4", "wendland-c6", "cubic-spline"])
def test_a_shallow_pool_stays_at_rest_with_the_longest_steps_of_late_damping(kernel):
    """Two rows over the mirrored floor, in which gradients are largest; with 0.7 for 0.35 they burst, at 1 and more."""
    plain = to_plain(tank(jitter=0.1, integrator="verlet", courant_number=0.5, kernel=kernel))
    plain["fluid"][0]["high"] = [1.0, 0.25]
    pool = from_plain(plain)
    material = material_of(pool)
    assert limiter(limits_of(pool, material, bulk_viscosity_of(pool, material))) == DAMPING
    assert max(frame.numbers["largest_speed"] for frame in ecume.simulate(pool)) < 0.1


@pytest.mark.parametrize(
    ("method", "ratio"),
    [({}, 0.60), ({"kernel": "wendland-c4"}, 0.45), ({"kernel": "wendland-c4", "acoustic_damping": 1.0}, 0.90)],
)
def test_late_damping_shortens_steps_where_lattices_have_faster_sound(method, ratio):
    """Expected: 0.35 h/(alpha c (kh)^2) over the step by sound, 0.25 h/(c + u), with kh = 1.14 and 1.30."""
    usual, late = (SPH.parameters(tank(integrator=name, **method)).time_step for name in ("symplectic", "verlet"))
    assert late / usual == pytest.approx(ratio, abs=0.02)


def test_a_step_beyond_the_limit_of_late_damping_is_refused():
    """It is divided by the speed of sound alone, and four times the limit was allowed."""
    scenes = [tank(integrator=name, kernel="wendland-c4") for name in ("verlet", "symplectic")]
    long = 1.5 * SPH.parameters(scenes[0]).time_step
    late, prompt = (
        dataclasses.replace(each, integration=dataclasses.replace(each.integration, time_step=long)) for each in scenes
    )
    with pytest.raises(SceneError, match="acoustic damping requires"):
        SPH.parameters(late)
    assert SPH.parameters(prompt).time_step > 1.4 * SPH.parameters(scenes[0]).time_step
