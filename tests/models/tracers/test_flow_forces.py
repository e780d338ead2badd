"""Forces of a liquid whose velocity varies, and streams around obstacles."""

import math

import numpy as np
import pytest

from ecume.errors import SceneError
from ecume.laws import drag
from ecume.models import MODELS
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate

RADIUS = 2e-4


def last_of(flow, particles, duration=0.4, **changes):
    """The last frame of particles with inertia in a box of liquid."""
    plain = {
        "model": "tracers", "duration": duration, "frame_every": duration, "gravity": 0.0,
        "tank": {"high": [0.2, 0.1]}, "flow": flow, "hydrodynamics": {"drag": "stokes"},
        "particles": [{"radius": RADIUS, **particles}],
        "integration": {"integrator": "inertial", "time_step": 1e-3},
    }  # fmt: skip
    *_, last = simulate(from_plain({**plain, **changes}))
    return last


def test_a_neutral_particle_moves_with_accelerating_liquid_only_with_its_pressure():
    """In u = (e x, -e z) around the middle, a particle of the liquid's density and velocity is at x exp(e t)."""
    place, rate = [0.11, 0.08], 2.0
    particles = {"density": 1000.0, "positions": [place], "velocity": [rate * 0.01, -rate * 0.03]}
    exact = [0.1 + 0.01 * math.exp(0.8), 0.05 + 0.03 * math.exp(-0.8)]
    off = []
    for given in (True, False):
        forces = {"drag": "stokes", "fluid_acceleration": given}
        last = last_of({"name": "stagnation", "rate": rate}, particles, hydrodynamics=forces)
        off.append(np.abs(last.arrays["position"][0] - exact).max())
    assert off[0] < 1e-6
    assert off[1] > 20.0 * off[0]


def test_faxen_s_correction_is_the_lag_in_a_channel():
    particles = {"density": 1000.0, "positions": [[0.02, 0.05]]}
    slow = [
        last_of({"name": "channel", "speed": 0.01}, particles, hydrodynamics={"drag": "stokes", "faxen": given})
        for given in (False, True)
    ]
    lag = slow[0].arrays["velocity"][0, 0] - slow[1].arrays["velocity"][0, 0]
    assert lag == pytest.approx(RADIUS**2 / 6.0 * 12.0 * 0.01 / 0.1**2, rel=1e-3)


@pytest.mark.parametrize(("integrator", "shown"), [("inertial", ["1.2"]), ("overdamped", [])])
def test_check_states_basset_s_force_of_grains_that_reach_their_terminal_speed(integrator, shown):
    """Of quartz in water, whatever its radius, a sqrt(1/(nu tau)) is sqrt(4.5/(2.65 + 0.5))."""
    scene = from_plain({
        "model": "tracers", "duration": 0.01, "frame_every": 1e-3, "tank": {"high": [0.2, 0.1]},
        "particles": [{"radius": RADIUS, "density": 2650.0, "count": 2}], "integration": {"integrator": integrator},
    })  # fmt: skip
    assert [row[1] for row in MODELS["tracers"].summary(scene) if row[0] == "history force"] == shown


def test_saffman_s_lift_drives_a_settling_grain_across_the_flow():
    shear, gravity = 0.5, 9.81
    speed = drag.stokes_settling_speed(RADIUS, 20.0, 1e-3, gravity)
    friction = drag.stokes_friction(RADIUS, 1e-3, 1.0)
    mass = 4.0 / 3.0 * math.pi * RADIUS**3 * 1520.0
    particles = {"density": 1020.0, "positions": [[0.05, 0.08]]}
    last = last_of({"shear_rate": shear}, particles, gravity=gravity, hydrodynamics={"drag": "stokes", "lift": True})
    relative = last.arrays["velocity"][0, 0] - shear * last.arrays["position"][0, 1]
    lift = 6.46 * RADIUS**2 * speed * math.sqrt(1000.0 * 1e-3 * shear)
    # The grain brings the velocity from where it was higher; the lift is opposite to the shear flow.
    assert relative == pytest.approx((mass * shear * speed - lift) / friction, rel=0.02)


def test_lift_is_of_second_order_also_for_fast_grains():
    """It takes the slip in the middle of a step, which drag, weight and the lift itself predict."""
    particles = {"density": 2500.0, "positions": [[0.05, 0.08]], "velocity": [0.1, 0.05]}
    found = []
    for steps in (20, 40, 80):
        changes = {"gravity": 9.81, "hydrodynamics": {"lift": True, "fluid_acceleration": True}}
        changes["integration"] = {"integrator": "inertial", "time_step": 0.04 / steps}
        last = last_of({"name": "rotation", "rate": 20.0}, particles, 0.04, **changes)
        found.append(last.arrays["position"][0])
    ratio = np.linalg.norm(found[0] - found[1]) / np.linalg.norm(found[1] - found[2])
    assert math.log2(ratio) == pytest.approx(2.0, abs=0.25)


def test_flat_grains_settle_at_the_speed_of_haider_and_levenspiel_s_drag():
    """C_D is solved for the balance of weight and drag by another library."""
    from scipy.optimize import brentq

    radius, excess, gravity, speeds = 5e-4, 1500.0, 9.81, {}
    for sphericity in (1.0, 0.67):

        def balance(speed, s=sphericity):
            reynolds = 2.0 * radius * speed * 1e6
            a, b = math.exp(2.3288 - 6.4581 * s + 2.4486 * s**2), 0.0964 + 0.5565 * s
            c = math.exp(4.905 - 13.8944 * s + 18.4222 * s**2 - 10.2599 * s**3)
            d = math.exp(1.4681 + 12.2584 * s - 20.7322 * s**2 + 15.8855 * s**3)
            coefficient = 24.0 / reynolds * (1.0 + a * reynolds**b) + c / (1.0 + d / reynolds)
            return coefficient * 0.5 * 1000.0 * speed**2 * radius**2 - 4.0 / 3.0 * radius**3 * excess * gravity

        particles = {"density": 2500.0, "positions": [[0.05, 0.08]], "sphericity": sphericity, "radius": radius}
        changes = {"gravity": gravity, "hydrodynamics": {"drag": "haider-levenspiel"}}
        last = last_of({}, particles, 0.3, tank={"high": [0.2, 0.5]}, **changes)
        speeds[sphericity] = -last.arrays["velocity"][0, 1]
        assert speeds[sphericity] == pytest.approx(brentq(balance, 1e-4, 1.0), rel=1e-5)
    assert 0.6 < speeds[0.67] / speeds[1.0] < 0.8


def test_haider_and_levenspiel_s_drag_of_spheres_is_near_their_fit_to_spheres_alone():
    """C_D = 24/Re (1 + 0.1806 Re^0.6459) + 0.4251/(1 + 6880.95/Re), as the package `fluids` has it."""
    for reynolds in (1.0, 10.0, 200.0, 5000.0):
        alone = 24.0 / reynolds * (1.0 + 0.1806 * reynolds**0.6459) + 0.4251 / (1.0 + 6880.95 / reynolds)
        coefficient = 24.0 / reynolds * drag.haider_levenspiel_factor(reynolds, 1.0)
        assert coefficient == pytest.approx(alone, rel=0.08)


def test_sphericity_without_its_drag_law_is_refused():
    with pytest.raises(SceneError, match=r"particles\[0\]\.sphericity: is not used by the drag law stokes; .* haider"):
        last_of({}, {"density": 2500.0, "positions": [[0.05, 0.08]], "sphericity": 0.5})


def test_the_energy_with_these_forces_never_rises():
    forces = {"drag": "stokes", "lift": True, "faxen": True, "fluid_acceleration": True}
    plain = {
        "model": "tracers", "duration": 0.2, "frame_every": 0.02, "gravity": 9.81, "tank": {"high": [0.2, 0.1]},
        "flow": {"name": "cellular", "speed": 0.1, "wavelength": 0.1}, "hydrodynamics": forces,
        "particles": [{"radius": RADIUS, "density": 1500.0, "count": 5}],
        "integration": {"integrator": "inertial", "time_step": 1e-3},
    }  # fmt: skip
    numbers = [frame.numbers for frame in simulate(from_plain(plain))]
    own = [each["total_energy"] - each["injected_work"] for each in numbers]
    assert max(np.diff(own)) < 1e-6 * abs(own[0])


def around(kind, position, dimensions=3, **changes):
    center = [0.0, 0.0, 0.0][:dimensions]
    return from_plain({
        "model": "tracers", "duration": 16.0, "frame_every": 16.0, "gravity": 0.0,
        "flow": {"velocity": [0.5, 0.0, 0.0][:dimensions], "around_obstacles": kind},
        "obstacles": [{"center": center, "radius": 1.0, "sticking": True}],
        "particles": [{"radius": 1e-6, "density": 1000.0, "positions": [position]}],
        "integration": {"integrator": "overdamped", "time_step": 0.05}, **changes,
    })  # fmt: skip


def stokes_stream(x):
    square, r = x[1] ** 2 + x[2] ** 2, float(np.linalg.norm(x))
    return square * (1.0 - 1.5 / r + 0.5 / r**3)


def cylinder_stream(x):
    return x[1] * (1.0 - 1.0 / float(x @ x))


@pytest.mark.parametrize(
    ("kind", "start", "stream"),
    [
        ("creeping", [-3.0, 0.5, 0.2], stokes_stream),
        ("ideal", [-3.0, 0.1], cylinder_stream),
        ("ideal", [-3.0, 0.3, 0.2], lambda x: (x[1] ** 2 + x[2] ** 2) * (1.0 - 1.0 / float(np.linalg.norm(x)) ** 3)),
    ],
)
def test_a_particle_of_the_liquid_keeps_its_stream_line_around_an_obstacle(kind, start, stream):
    *_, last = simulate(around(kind, start, len(start)))
    end = last.arrays["position"][0]
    assert end[0] > -1.0
    assert last.numbers["particles_inside"] == 1.0
    assert stream(end) == pytest.approx(stream(np.array(start)), rel=2e-4)


def test_no_warning_where_the_liquid_goes_around(recwarn):
    scene = around("creeping", [-3.0, 0.5, 0.2])
    MODELS["tracers"].parameters(scene)
    assert not recwarn.list
    rows = {row[0]: row[1:] for row in MODELS["tracers"].summary(scene)}
    assert rows["flow"][1].startswith("creeping, around the obstacle")
    assert float(rows["obstacle: Reynolds number"][0]) == pytest.approx(1e6)


def test_particles_start_at_random_in_3d_without_a_tank():
    low, high = [-3.0, -1.0, -1.0], [-2.0, 1.0, 1.0]
    particles = [{"radius": 1e-6, "density": 1000.0, "count": 20, "low": low, "high": high}]
    first, *_ = simulate(around("creeping", [0.0], 3, particles=particles))
    assert first.arrays["position"].shape == (20, 3)
    assert (first.arrays["position"] >= low).all()
    assert (first.arrays["position"] <= high).all()


@pytest.mark.parametrize(
    ("kind", "dimensions", "changes", "words"),
    [
        ("creeping", 2, {}, "Stokes's paradox"),
        ("ideal", 2, {"tank": {"low": [-4.0, -4.0], "high": [4.0, 4.0]}}, "one disc or sphere without a tank"),
        ("ideal", 2, {"flow": {"shear_rate": 1.0, "around_obstacles": "ideal"}}, "needs a uniform flow"),
    ],
)
def test_streams_without_an_exact_solution_are_refused(kind, dimensions, changes, words):
    with pytest.raises(SceneError, match=words):
        MODELS["tracers"].parameters(around(kind, [-3.0, 0.5, 0.2][:dimensions], dimensions, **changes))
