import dataclasses
import math

import numpy as np
import pytest

import ecume
from ecume.errors import Diverged, SceneError
from ecume.laws import brownian_motion, drag
from ecume.models import MODELS, costs
from ecume.models.tracers.tank import bounds
from ecume.models.tracers.time_stepping import UNBOUNDED, all_finite
from ecume.scenes.tracers import (
    FlowSpec,
    FluidSpec,
    OpeningSpec,
    ParticleSpec,
    TankSpec,
    TracerHydrodynamicsSpec,
    TracerIntegrationSpec,
    TracersScene,
)
from ecume.simulation import moments

QUARTZ = ParticleSpec(radius=1e-4, density=2500.0, positions=((0.5, 0.9),))
STILL = {"duration": 0.2, "frame_every": 0.1}


def last(scene):
    *_, frame = ecume.simulate(scene)
    return frame


@pytest.mark.compiled
@pytest.mark.parametrize(
    ("diameter", "stokes", "schiller_naumann"),
    [
        (20e-6, 3.2700e-4, 3.254636e-4),
        (50e-6, 2.04375e-3, 1.982957e-3),
        (100e-6, 8.175e-3, 7.294103e-3),
        (200e-6, 3.27e-2, 2.291683e-2),
    ],
)
def test_quartz_reaches_its_terminal_speed_in_water_whatever_the_step(diameter, stokes, schiller_naumann):
    for law, expected in (("stokes", stokes), ("schiller-naumann", schiller_naumann)):
        grain = ParticleSpec(radius=diameter / 2, density=2500.0, positions=((0.0, 0.0),))
        scene = TracersScene(particles=(grain,), hydrodynamics=TracerHydrodynamicsSpec(drag=law), **STILL)
        velocity = last(scene).arrays["velocity"][0]
        assert velocity[1] == pytest.approx(-expected, rel=2e-6)
        assert velocity[0] == 0.0


def test_a_ball_in_a_vacuum_falls_and_bounces_as_it_should_however_long_the_steps():
    ball = ParticleSpec(radius=0.1, density=1.0, positions=((0.0, 1.1),))
    scene = TracersScene(
        duration=2.0,
        frame_every=0.5,
        liquid=FluidSpec(density=1e-3, viscosity=0.0),
        particles=(ball,),
        tank=TankSpec(vertices=((-1.0, 0.0), (1.0, 0.0), (1.0, 9.0), (-1.0, 9.0)), restitution=0.8),
        hydrodynamics=TracerHydrodynamicsSpec(drag="none", added_mass=False),
    )
    frames = list(ecume.simulate(scene))
    g = 9.81 * (1.0 - 1e-3)
    first = math.sqrt(2.0 / g)
    for frame in frames:
        height, speed, since = 1.0, 0.0, frame.time
        bounce = 0
        while since > (first if bounce == 0 else 2.0 * first * 0.8**bounce):
            since -= first if bounce == 0 else 2.0 * first * 0.8**bounce
            bounce += 1
        height, speed = (1.0, 0.0) if bounce == 0 else (0.0, g * first * 0.8**bounce)
        expected = height + speed * since - 0.5 * g * since**2 + 0.1
        assert frame.arrays["position"][0, 1] == pytest.approx(expected, abs=1e-12)
    assert frames[-1].numbers["hits_on_wall_0"] == 3.0
    assert frames[-1].numbers["hits"] == 3.0


@pytest.mark.compiled
@pytest.mark.parametrize("regime", ["inertial", "overdamped"])
def test_grains_diffuse_by_twice_d_t_along_each_axis_whatever_the_regime(regime):
    grain = ParticleSpec(radius=1e-6, density=2000.0, positions=((0.0, 0.0, 0.0),) * 1500)
    relaxation = drag.relaxation_time(4 / 3 * math.pi * 1e-18 * 2500.0, drag.stokes_friction(1e-6, 1e-3, 1.0))
    motion = {
        "hydrodynamics": TracerHydrodynamicsSpec(drag="stokes", brownian=True),
        "integration": TracerIntegrationSpec(integrator=regime, time_step=relaxation / 4),
    }
    scene = TracersScene(
        duration=100 * relaxation, frame_every=50 * relaxation, gravity=0.0, particles=(grain,), **motion
    )
    frame = last(scene)
    thermal = brownian_motion.thermal_energy(293.15)
    spread = brownian_motion.diffusivity(thermal, drag.stokes_friction(1e-6, 1e-3, 1.0))
    # From rest it takes three halves of a relaxation time to get going.
    late = 1.5 * relaxation if regime == "inertial" else 0.0
    expected = 2.0 * spread * (frame.time - late)
    assert (frame.arrays["position"] ** 2).mean() == pytest.approx(expected, rel=5.0 * math.sqrt(2.0 / 4500))
    assert abs(frame.arrays["position"].mean()) < 5.0 * math.sqrt(expected / 4500)
    if regime == "inertial":
        kinetic = frame.numbers["kinetic_energy"] / 1500
        assert kinetic == pytest.approx(1.5 * thermal, rel=5.0 * math.sqrt(2.0 / 4500))


@pytest.mark.compiled
def test_in_equilibrium_a_suspension_thins_upwards_by_its_weight_over_kt():
    radius, excess, thermal = 0.5e-6, 100.0, brownian_motion.thermal_energy(293.15)
    layer = brownian_motion.sedimentation_length(thermal, 4 / 3 * math.pi * radius**3 * excess * 9.81)
    tall = 3.0 * layer
    grains = ParticleSpec(radius=radius, density=1000.0 + excess, count=2000)
    settled = tall**2 / brownian_motion.diffusivity(thermal, drag.stokes_friction(radius, 1e-3, 1.0))
    scene = TracersScene(
        duration=3 * settled,
        frame_every=settled,
        particles=(grains,),
        tank=TankSpec(high=(tall, tall + 2 * radius)),
        hydrodynamics=TracerHydrodynamicsSpec(brownian=True),
    )
    height = last(scene).arrays["position"][:, 1] - radius
    x = tall / layer
    mean = layer * (1.0 - x / math.expm1(x))
    assert height.min() >= 0.0
    assert height.max() <= tall
    assert height.mean() == pytest.approx(mean, rel=5.0 / math.sqrt(2000))
    # The lowest tenth of the height holds its share.
    share = math.expm1(-0.1 * x) / math.expm1(-x)
    assert (height < 0.1 * tall).mean() == pytest.approx(share, abs=5.0 * math.sqrt(share / 2000))


@pytest.mark.compiled
def test_what_has_settled_lies_on_the_floor():
    grain = ParticleSpec(radius=1e-5, density=2500.0, positions=((0.5e-3, 0.3e-3),))
    for regime in ("inertial", "overdamped"):
        scene = TracersScene(
            duration=2.0,
            frame_every=1.0,
            particles=(grain,),
            tank=TankSpec(high=(1e-3, 1e-3), restitution=0.5),
            integration=TracerIntegrationSpec(integrator=regime),
        )
        frame = last(scene)
        assert frame.arrays["position"][0] == pytest.approx((0.5e-3, 1e-5), abs=1e-12)


def test_a_long_run_of_fine_grains_does_without_their_inertia_unless_asked():
    silt = ParticleSpec(radius=1e-5, density=2500.0, positions=((0.5e-3, 0.5e-3),))

    def steps_and_regime(**changes):
        scene = TracersScene(**{"duration": 20.0, "frame_every": 0.1, "particles": (silt,), **changes})
        made = MODELS["tracers"].parameters(dataclasses.replace(scene, tank=TankSpec(high=(1e-3, 1e-3))))
        return 20.0 / made.time_step, int(made.bodies.overdamped[0])

    steps, overdamped = steps_and_regime()
    assert overdamped == 1
    assert steps <= 50_000
    steps, overdamped = steps_and_regime(integration=TracerIntegrationSpec(integrator="inertial"))
    assert overdamped == 0
    assert steps > 1_000_000


@pytest.mark.compiled
def test_in_a_shear_flow_a_light_particle_goes_with_the_liquid():
    grain = ParticleSpec(radius=1e-6, density=1000.0, positions=((0.0, 2.0),))
    flow = FlowSpec(velocity=(0.5, 0.0), shear_rate=0.25)
    scene = TracersScene(duration=3.0, frame_every=1.0, particles=(grain,), gravity=0.0, flow=flow)
    assert last(scene).arrays["position"][0] == pytest.approx((3.0, 2.0))


@pytest.mark.compiled
def test_who_leaves_through_an_opening_is_counted_and_stays_out():
    grains = ParticleSpec(radius=1e-5, density=2500.0, count=50, low=(4e-4, 5e-4), high=(6e-4, 9e-4))
    scene = TracersScene(
        duration=4.0,
        frame_every=2.0,
        integration=TracerIntegrationSpec(integrator="overdamped"),
        particles=(grains, dataclasses.replace(grains, low=(1e-4, 5e-4), high=(2e-4, 9e-4))),
        tank=TankSpec(high=(1e-3, 1e-3)),
        openings=(OpeningSpec(wall=1, low=(3e-4, 0.0), high=(7e-4, 0.0)),),
    )
    numbers = last(scene).numbers
    assert numbers["left_through_opening_0"] == 50.0
    assert numbers["particles_inside"] == 50.0


@pytest.mark.parametrize(
    ("field", "value"), [("position", np.nan), ("position", 1e300), ("velocity", np.nan), ("velocity", np.inf)]
)
def test_who_is_nowhere_is_named_and_not_put_back_inside(field, value):
    two = ParticleSpec(radius=1e-3, density=2500.0, positions=((0.5, 0.5), (0.2, 0.2)))
    scene = TracersScene(particles=(two,), tank=TankSpec(high=(1.0, 1.0)), **STILL)
    parameters = MODELS["tracers"].parameters(scene)
    state = MODELS["tracers"].start(scene, parameters)
    getattr(state, field)[1, 0] = value
    with pytest.raises(Diverged, match=rf"at t = 0 s \(step 0\) particle 1 has no finite {field}"):
        list(moments(scene, state=state))


def test_what_is_nowhere_begins_at_its_bound():
    inside, beyond = np.array([[0.0, np.nextafter(UNBOUNDED, 0.0)]]), np.array([[0.0, -UNBOUNDED]])
    assert all_finite(inside, inside)
    assert not all_finite(beyond, inside)
    assert not all_finite(inside, beyond)


def test_a_run_that_would_never_end_is_refused():
    slow = {"integration": TracerIntegrationSpec(time_step=1e-9)}
    scene = TracersScene(particles=(QUARTZ,), **slow, duration=1e10, frame_every=1e3)
    with pytest.raises(SceneError, match=r"duration: is 1e\+19 steps"):
        MODELS["tracers"].parameters(scene)


def test_more_tracers_than_the_memory_holds_are_refused_before_they_are_laid_out(monkeypatch):
    monkeypatch.setattr(costs, "memory_limit", lambda: 16e9)
    many = ParticleSpec(radius=1e-6, density=2500.0, count=50_000_000)
    scene = TracersScene(particles=(many,), tank=TankSpec(high=(1.0, 1.0)), **STILL)
    with pytest.raises(SceneError, match="50000000 particles need about 34 GB"):
        MODELS["tracers"].parameters(scene)


def test_what_makes_no_sense_is_refused_with_its_place():
    def output(**changes):
        scene = TracersScene(**{"duration": 1.0, "frame_every": 0.1, "particles": (QUARTZ,), **changes})
        with pytest.raises(SceneError) as error:
            MODELS["tracers"].summary(scene)
        return str(error.value)

    assert "did you mean stokes?" in output(hydrodynamics=TracerHydrodynamicsSpec(drag="stoke"))
    assert "particles[0].positions[0]: (0.5, 0.9) is" in output(tank=TankSpec(high=(0.6, 0.5)))
    assert "needs drag" in output(hydrodynamics=TracerHydrodynamicsSpec(drag="none", brownian=True))
    assert "longer than half a relaxation time" in output(
        integration=TracerIntegrationSpec(integrator="inertial", time_step=0.1)
    )
    assert "would fit" in output(integration=TracerIntegrationSpec(time_step=0.03))
    assert "tank: polygon: not convex" in output(tank=TankSpec(vertices=((0, 0), (2, 0), (1, 0.2), (1, 2))))
    assert "openings[0]: opening: got surface 7" in output(
        tank=TankSpec(high=(1.0, 1.0)), openings=(OpeningSpec(wall=7, low=(0.0, 0.0), high=(1.0, 0.0)),)
    )


@pytest.mark.parametrize(("text", "kelvin"), [("20 degC", 293.15), ("300 K", 300.0), (280.0, 280.0), ("-5 °C", 268.15)])
def test_a_temperature_may_be_in_degrees(text, kelvin):
    assert FluidSpec(temperature=text).temperature == pytest.approx(kelvin)


@pytest.mark.parametrize("dimensions", [2, 3])
def test_a_round_tank_is_filled_to_its_radius_along_each_axis(dimensions):
    scene = TracersScene(
        tank=TankSpec(radius=0.3, dimensions=dimensions),
        particles=(ParticleSpec(radius=1e-3, density=2500.0, count=200),),
        **STILL,
    )
    assert bounds(scene) == ((-0.3,) * dimensions, (0.3,) * dimensions)
    position = MODELS["tracers"].start(scene, MODELS["tracers"].parameters(scene)).position
    assert position.shape == (200, dimensions)
    assert np.linalg.norm(position, axis=1).max() <= 0.299
    assert (np.ptp(position, axis=0) > 0.5).all()


def test_each_tracer_may_start_with_a_velocity_of_its_own():
    places = ((0.0, 0.0), (0.5, 0.0))
    grains = ParticleSpec(radius=1e-3, density=2500.0, positions=places, velocities=((0.1, 0.0), (0.0, -0.2)))
    slow = ParticleSpec(radius=1e-3, density=2500.0, positions=((1.0, 0.0),), velocity=(0.0, 0.3))
    first = next(ecume.simulate(TracersScene(particles=(grains, slow), **STILL)))
    assert first.arrays["velocity"].tolist() == [[0.1, 0.0], [0.0, -0.2], [0.0, 0.3]]
    with pytest.raises(SceneError, match="velocities: got 1; there are 2 positions"):
        ParticleSpec(radius=1e-3, density=2500.0, positions=places, velocities=((0.1, 0.0),))
    wide = ParticleSpec(radius=1e-3, density=2500.0, positions=places, velocities=((0.1, 0.0, 0.0),) * 2)
    with pytest.raises(SceneError, match=r"particles\[0\]\.velocities\[0\]: got 3 coordinates; expected 2"):
        TracersScene(particles=(wide,), **STILL)
