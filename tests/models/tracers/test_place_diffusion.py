"""Drag near walls, and diffusivities that depend on place."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.stats import kstest

from ecume.errors import SceneError
from ecume.laws import drag, wall_drag
from ecume.models import MODELS
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate

RADIUS, KT = 0.5e-6, 1.380649e-23 * 293.15
FAR = KT / (6.0 * math.pi * 1e-3 * RADIUS)


def test_the_factors_are_those_of_faxen_s_and_lorentz_s_series_far_away():
    for height in (20.0, 50.0):
        x = 1.0 / height
        along = 1.0 - 9 / 16 * x + x**3 / 8 - 45 / 256 * x**4 - x**5 / 16
        assert 1.0 / wall_drag.parallel_factor(height - 1.0, 1.0) == pytest.approx(along, abs=x**6)
        toward = 1.0 - 9 / 8 * x + x**3 / 2 - 135 / 256 * x**4 - x**5 / 8
        assert 1.0 / wall_drag.perpendicular_factor(height - 1.0, 1.0) == pytest.approx(toward, abs=2.0 * x**6)


def test_the_factors_near_contact_are_those_of_lubrication():
    """1/e + ln(1/e)/5 toward the wall; along it the friction of a freely turning sphere grows by ln(1/e)/2."""
    gaps = np.array([1e-4, 1e-3])
    toward = [wall_drag.perpendicular_factor(gap, 1.0) - 1.0 / gap for gap in gaps]
    assert toward[0] - toward[1] == pytest.approx(0.2 * math.log(10.0), rel=0.01)
    # Of one that does not turn by 8/15 ln(1/e) [goldman1967].
    fixed = [wall_drag._force(math.acosh(1.0 + gap), "moving") for gap in gaps]
    assert fixed[0] - fixed[1] == pytest.approx(8.0 / 15.0 * math.log(10.0), rel=0.01)


def test_the_flow_of_the_series_is_that_of_a_sphere_that_moves_along_a_wall():
    """It is zero at the wall, that of the sphere at its surface, and free of divergence: at random points."""
    c = 0.9
    k, rng = wall_drag.coefficients(c, "moving"), np.random.default_rng(4)

    def sums(xi, m):
        """W, Q, U0 and U2, without their factors of the angle."""
        big, legendre = np.cosh((k.n + 0.5) * xi), np.polynomial.legendre
        small, root = np.sinh((k.n + 0.5) * xi), math.sqrt(math.cosh(xi) - m)

        def series(weights, order):
            return float(legendre.legval(m, legendre.legder(weights, order) if order else weights))

        s = math.sqrt(1.0 - m * m)
        first = root * s * series(k.a * small, 1), root * s * series(k.b * big + k.c * small, 1)
        return *first, root * series(k.d * big + k.e * small, 0), root * s * s * series(k.f * big + k.g * small, 2)

    def velocity(x):
        """(along r, around, along z) over cos, sin and cos of the angle."""
        r, z = x
        square = r * r + z * z
        xi, m = math.atanh(2.0 * z / (square + 1.0)), 0.0
        m = math.cosh(xi) - (math.sinh(xi) / z if z > 1e-9 else 2.0 / (1.0 + square))
        w, q, zero, two = sums(xi, min(max(m, -1.0), 1.0))
        return 0.5 * (r * q + two + zero), 0.5 * (two - zero), 0.5 * (z * q + 2.0 * w)

    for m in rng.uniform(-0.95, 0.95, 10):
        s = math.sqrt(1.0 - m * m)
        wall = (s / (1.0 - m), 1e-12)
        assert np.abs(velocity(wall)).max() < 1e-5
        scale = math.cosh(c) - m
        assert velocity((s / scale, math.sinh(c) / scale)) == pytest.approx((1.0, -1.0, 0.0), abs=1e-6)
        r, z, h = 0.7 + abs(m), 2.6 + abs(m), 1e-4
        along = (velocity((r + h, z))[0] - velocity((r - h, z))[0]) / (2.0 * h)
        up = (velocity((r, z + h))[2] - velocity((r, z - h))[2]) / (2.0 * h)
        here = velocity((r, z))
        assert abs(along + (here[0] + here[1]) / r + up) < 1e-6


def scene_of(height=4e-6, **changes):
    """Half-micrometer spheres between two plates, or grains of other kinds."""
    plain = {
        "model": "tracers", "duration": 1.0, "frame_every": 1.0, "gravity": 0.0,
        "tank": {"high": [20e-6, height], "periodic": ["x"]},
        "particles": [{"radius": RADIUS, "density": 2000.0, "count": 2000}],
        "hydrodynamics": {"wall_drag": True, "brownian": True, "drag": "stokes"},
        "integration": {"integrator": "overdamped"},
    }  # fmt: skip
    return from_plain({**plain, **changes})


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize("step", [None, 0.05])
def test_a_well_mixed_suspension_stays_so_between_walls(step):
    """Also at a step in which a particle crosses half of its radius: moves are accepted with the ratio of densities."""
    scene = scene_of(integration={"integrator": "overdamped", **({"time_step": step} if step else {})})
    *_, last = simulate(scene)
    height = (last.arrays["position"][:, 1] - RADIUS) / (4e-6 - 2.0 * RADIUS)
    assert kstest(height, "uniform").pvalue > 1e-3
    assert height.min() > 0.0


@pytest.mark.long
@pytest.mark.compiled
def test_the_layer_of_settling_particles_is_barometric_near_the_floor():
    """From the exact profile, which remains while particles change places."""
    length = KT / (4.0 / 3.0 * math.pi * RADIUS**3 * 1000.0 * 9.81)
    share = (np.arange(2000) + 0.5) / 2000
    start = RADIUS - length * np.log1p(share * math.expm1(-5e-6 / length))
    particles = {"radius": RADIUS, "density": 2000.0, "positions": [[1e-5, z] for z in start.tolist()]}
    scene = scene_of(6e-6, gravity=9.81, duration=5.0, frame_every=5.0, particles=[particles])
    *_, last = simulate(scene)
    height = (last.arrays["position"][:, 1] - RADIUS) / length
    span = (6e-6 - 2.0 * RADIUS) / length
    assert np.corrcoef(start, last.arrays["position"][:, 1])[0, 1] < 0.6
    assert kstest(np.expm1(-height) / math.expm1(-span), "uniform").pvalue > 1e-3


@pytest.mark.compiled
def test_diffusion_near_a_wall_has_the_coefficients_of_the_series():
    """Within a time in which a particle moves by a small part of its gap."""
    gap, time = 0.5 * RADIUS, 1e-3
    scene = scene_of(
        1e-3, duration=time, frame_every=time, integration={"integrator": "overdamped", "time_step": time / 10},
        particles=[{"radius": RADIUS, "density": 1000.0, "positions": [[1e-5, RADIUS + gap]] * 4000}],
    )  # fmt: skip
    first, last = simulate(scene)
    way = last.arrays["position"] - first.arrays["position"]
    for axis, factor in enumerate((wall_drag.parallel_factor, wall_drag.perpendicular_factor)):
        expected = 2.0 * FAR * time / factor(gap, RADIUS)
        assert way[:, axis].var() == pytest.approx(expected, rel=4.0 * math.sqrt(2.0 / 4000) + 0.01)
    # The drift is the gradient of the diffusivity.
    slope = (1.0 / wall_drag.perpendicular_factor(gap * 1.01, RADIUS) - 1.0 / wall_drag.perpendicular_factor(
        gap * 0.99, RADIUS)) / (0.02 * gap) * FAR  # fmt: skip
    assert way[:, 1].mean() == pytest.approx(slope * time, abs=4.0 * way[:, 1].std() / math.sqrt(4000))


@pytest.mark.parametrize("regime", ["inertial", "overdamped"])
def test_a_grain_that_settles_to_the_floor_slows_down_as_brenner_says(regime):
    radius, heights = 1e-3, []
    tau = 4.0 / 3.0 * math.pi * radius**3 * 2500.0 / (6.0 * math.pi * 0.1 * radius)
    speed = drag.stokes_settling_speed(radius, 1000.0, 0.1, 9.81)
    start, time = 4.0 * radius, 2.0 * radius / speed * 2.0
    scene = scene_of(
        duration=time, frame_every=time, gravity=9.81, tank={"high": [0.1, 50.0], "periodic": ["x"]},
        liquid={"density": 1000.0, "viscosity": 0.1}, hydrodynamics={"wall_drag": True, "drag": "stokes"},
        particles=[{"radius": radius, "density": 2000.0, "positions": [[0.05, start]]}],
        integration={"integrator": regime, "time_step": time / 200},
    )  # fmt: skip
    *_, last = simulate(scene)

    def rates(_, x):
        friction = wall_drag.perpendicular_factor(x[0] - radius, radius)
        if regime == "overdamped":
            return [-speed / friction]
        return [x[1], -(x[1] * friction + speed) / tau]

    state = [start] if regime == "overdamped" else [start, 0.0]
    exact = solve_ivp(rates, (0.0, time), state, "LSODA", rtol=1e-9, atol=1e-15).y[0, -1]
    heights.append(last.arrays["position"][0, 1])
    assert exact < 1.8 * radius
    assert heights[0] - radius == pytest.approx(exact - radius, rel=5e-3)


def sea(profile, count=4000, **changes):
    """Particles in water of ten meters, mixed by turbulence."""
    heights, spreads = zip(*profile, strict=True)
    plain = {
        "model": "tracers", "duration": 2e4, "frame_every": 2e4, "gravity": 0.0, "tank": {"high": [100.0, 10.0]},
        "particles": [{"radius": 1e-5, "density": 1100.0, "count": count}],
        "flow": {"turbulence": {"heights": heights, "diffusivities": spreads}},
        "integration": {"integrator": "overdamped"},
    }  # fmt: skip
    return from_plain({**plain, **changes})


PROFILES = {
    "smooth": [(h, 2e-2 * h * (10.0 - h) / 25.0 + 1e-5) for h in np.linspace(0.0, 10.0, 21).tolist()],
    "jump": [(4.9, 2e-2), (5.0, 1e-4)],
    "slope": [(0.0, 2e-2), (10.0, 1e-3)],
}


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize("name", list(PROFILES))
def test_a_well_mixed_sea_stays_well_mixed(name):
    """Visser's test: without the drift of the gradient, particles gather where the diffusivity is small."""
    *_, last = simulate(sea(PROFILES[name]))
    assert kstest(last.arrays["position"][:, 1] / 10.0, "uniform").pvalue > 1e-3


@pytest.mark.long
@pytest.mark.compiled
def test_settling_against_turbulence_has_the_profile_of_rouse():
    """Where K = K0 + s z the density is (K0 + s z)^(-w/s)."""
    scene = sea([(0.0, 1e-3), (10.0, 2.1e-2)], gravity=9.81, duration=4e4, frame_every=4e4)
    speed = MODELS["tracers"].parameters(scene).bodies.settling[0]
    power = 1.0 - speed / 2e-3
    *_, last = simulate(scene)
    z = last.arrays["position"][:, 1]
    share = ((1e-3 + 2e-3 * z) ** power - 1e-3**power) / (2.1e-2**power - 1e-3**power)
    assert kstest(share, "uniform").pvalue > 1e-3


@pytest.mark.compiled
def test_a_cloud_spreads_by_the_diffusivity_of_its_height():
    scene = sea(
        [(0.0, 0.0), (10.0, 1e-2)], duration=20.0, frame_every=20.0,
        particles=[{"radius": 1e-5, "density": 1000.0, "positions": [[50.0, 5.0]] * 4000}],
        flow={"turbulence": {"heights": [0.0, 10.0], "diffusivities": [0.0, 1e-2], "horizontal": 0.3}},
    )  # fmt: skip
    *_, last = simulate(scene)
    way = last.arrays["position"] - [50.0, 5.0]
    noise = math.sqrt(2.0 / 4000)
    assert way[:, 0].var() == pytest.approx(2.0 * 0.3 * 20.0, rel=4.0 * noise)
    assert way[:, 1].var() == pytest.approx(2.0 * 5e-3 * 20.0, rel=4.0 * noise)
    assert way[:, 1].mean() == pytest.approx(1e-3 * 20.0, abs=4.0 * way[:, 1].std() / math.sqrt(4000))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"tank": {"radius": 1e-5}}, "needs a box"),
        ({"hydrodynamics": {"wall_drag": True, "drag": "none"}, "integration": {}}, "needs drag"),
        ({"tank": {"high": [1e-5, 1e-5], "sticking": True}}, "got openings or sticking"),
        ({"obstacles": [{"center": [5e-6, 2e-6], "radius": 1e-6}]}, "got obstacles"),
        ({"flow": {"turbulence": {"heights": [0.0], "diffusivities": [1e-3]}}}, "beside flow.turbulence"),
    ],
)
def test_drag_near_walls_is_refused_where_its_series_does_not_hold(changes, words):
    with pytest.raises(SceneError, match=words):
        MODELS["tracers"].parameters(scene_of(**changes))


def test_a_profile_of_turbulence_needs_a_floor_and_a_lid():
    tank = {"high": [100.0, 10.0], "periodic": ["y"]}
    with pytest.raises(SceneError, match=r"tank\.periodic: got the vertical axis"):
        MODELS["tracers"].parameters(sea(PROFILES["slope"], 4, tank=tank))
    MODELS["tracers"].parameters(sea([(0.0, 1e-3)], 4, tank=tank))


def test_mixing_without_drag_is_refused():
    for changes in ({"hydrodynamics": {"drag": "none"}}, {"liquid": {"viscosity": 0.0}}):
        with pytest.raises(SceneError, match=r"flow\.turbulence: needs drag"):
            MODELS["tracers"].parameters(sea(PROFILES["slope"], 4, **changes))


def test_turbulence_does_not_move_particles_with_inertia():
    with pytest.raises(SceneError, match=r"flow\.turbulence: acts on particles without inertia"):
        MODELS["tracers"].parameters(
            sea(PROFILES["slope"], 4, duration=1e-4, frame_every=1e-4, integration={"integrator": "inertial"})
        )


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({"heights": [0.0, 1.0], "diffusivities": [1.0]}, "got 1 for 2 heights"),
        ({"heights": [1.0, 0.0], "diffusivities": [1.0, 1.0]}, "expected rising numbers"),
    ],
)
def test_a_profile_that_is_none_is_refused(table, words):
    with pytest.raises(SceneError, match=words):
        sea(PROFILES["slope"], flow={"turbulence": table})


def test_recorded_settling_speeds_are_those_near_the_wall():
    """Without noise a particle near the floor sinks as slowly as Brenner's series says, and its frame says so."""
    heights = (1.2, 2.0, 5.0)
    scene = from_plain({
        "model": "tracers", "duration": 1e-4, "frame_every": 1e-4, "tank": {"high": [1e-2, 1e-2]},
        "particles": [{"radius": RADIUS, "density": 2000.0, "positions": [[5e-3, h * RADIUS] for h in heights]}],
        "hydrodynamics": {"wall_drag": True}, "integration": {"integrator": "overdamped"},
    })  # fmt: skip
    *_, last = simulate(scene)
    far = drag.stokes_settling_speed(RADIUS, 1000.0, 1e-3, 9.81)
    for i in range(3):
        gap = last.arrays["position"][i, 1] / RADIUS - 1.0
        expected = -far / wall_drag.perpendicular_factor(gap, 1.0)
        assert last.arrays["velocity"][i, 1] == pytest.approx(expected, rel=1e-3)
