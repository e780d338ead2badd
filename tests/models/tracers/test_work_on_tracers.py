"""The work of liquid and openings on tracers: energy minus work never rises, particle by particle."""

import numpy as np
import pytest

import ecume
from ecume.models import MODELS
from ecume.models.invariants import ENERGY
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


def budget(scene):
    """Energy and work in the budget of each frame."""
    numbers = [frame.numbers for frame in ecume.simulate(scene)]
    return np.array([[one["total_energy"], one["injected_work"]] for one in numbers]).T


def grain(velocity=None, place=(0.01, 0.01)):
    return ParticleSpec(radius=1e-3, density=2500.0, positions=(place,), velocity=velocity)


def alone(particle, **changes):
    liquid = FluidSpec(viscosity=1e-2, **changes.pop("liquid", {}))
    return TracersScene(**{"duration": 0.2, "frame_every": 0.01, "particles": (particle,), "liquid": liquid, **changes})


@pytest.mark.parametrize("regime", ["inertial", "overdamped"])
def test_a_grain_that_the_liquid_keeps_up_costs_its_weight_times_the_speed(regime):
    motion = {
        "hydrodynamics": TracerHydrodynamicsSpec(drag="stokes"),
        "integration": TracerIntegrationSpec(integrator=regime, time_step=1e-3),
    }
    parameters = MODELS["tracers"].parameters(alone(grain(), **motion))
    bodies = parameters.bodies
    weight, speed = float(bodies.mass[0] * bodies.apparent_gravity[0]), float(bodies.settling[0])
    energy, work = budget(alone(grain((0.0, 0.0)), **motion, flow=FlowSpec(velocity=(0.0, speed))))
    np.testing.assert_allclose(work, weight * speed * 0.01 * np.arange(21), rtol=1e-9, atol=1e-20)
    np.testing.assert_allclose(energy, energy[0], rtol=1e-9)


@pytest.mark.long
@pytest.mark.parametrize("drag", ["stokes", "schiller-naumann"])
@pytest.mark.parametrize("regime", ["inertial", "overdamped"])
def test_no_grain_that_bounces_in_a_stream_has_energy_from_nowhere(drag, regime):
    dice = np.random.default_rng(3)
    # What inertia meets in a liquid at rest is judged as it is: see below.
    for flow in ((0.3, 0.1),) if regime == "inertial" else (None, (0.3, 0.1)):
        for _ in range(12):
            particle = grain(tuple(dice.uniform(-1.0, 1.0, 2)), tuple(dice.uniform(0.002, 0.018, 2)))
            scene = alone(
                particle,
                flow=FlowSpec(velocity=flow, shear_rate=0.0 if flow is None else 5.0),
                tank=TankSpec(high=(0.02, 0.02)),
                hydrodynamics=TracerHydrodynamicsSpec(drag=drag),
                integration=TracerIntegrationSpec(integrator=regime),
            )
            energy, work = budget(scene)
            own = energy - work
            assert np.diff(own).max() <= 1e-12 * np.abs(own).max()
            assert own[-1] < own[0]


def test_a_liquid_at_rest_brings_nothing_so_that_no_bounce_is_excused():
    scene = alone(
        grain((0.0, -0.5)), tank=TankSpec(high=(0.02, 0.02)), hydrodynamics=TracerHydrodynamicsSpec(drag="stokes")
    )
    assert all("injected_work" not in frame.numbers for frame in ecume.simulate(scene))


@pytest.mark.compiled
def test_noise_brings_as_much_heat_as_drag_takes():
    """In equilibrium half of kT an axis and relaxation time, twice; steps take what they have of it."""
    dust = ParticleSpec(radius=1e-6, density=2000.0, positions=((0.0, 0.0),) * 400)
    motion = {
        "hydrodynamics": TracerHydrodynamicsSpec(drag="stokes", brownian=True),
        "integration": TracerIntegrationSpec(integrator="inertial"),
    }
    probe = {"particles": (dust,), "gravity": 0.0, **motion}
    parameters = MODELS["tracers"].parameters(TracersScene(duration=1e-5, frame_every=1e-6, **probe))
    late = float(parameters.bodies.mass[0] / parameters.bodies.friction[0])
    scene = TracersScene(duration=100.0 * late, frame_every=25.0 * late, **probe)
    parameters = MODELS["tracers"].parameters(scene)
    steps = 4 * parameters.steps_per_frame
    each = 2 * 400 * 0.5 * parameters.fluid.thermal * -np.expm1(-2.0 * parameters.time_step / late)
    energy, work = budget(scene)
    assert work[-1] / (steps * each) == pytest.approx(1.0, abs=5.0 * np.sqrt(4.0 / (800 * steps)))
    assert energy[-1] / (400 * parameters.fluid.thermal) == pytest.approx(1.0, abs=5.0 * np.sqrt(1.0 / 400))
    assert np.all(np.diff(energy - work) < 0.0)


@pytest.mark.compiled
def test_without_inertia_noise_does_not_change_the_work_of_settling():
    silt = ParticleSpec(radius=1e-6, density=2000.0, positions=((0.0, 0.0),) * 50)
    motion = {
        "hydrodynamics": TracerHydrodynamicsSpec(drag="stokes", brownian=True),
        "integration": TracerIntegrationSpec(integrator="overdamped", time_step=0.01),
    }
    scene = TracersScene(duration=0.5, frame_every=0.1, particles=(silt,), **motion)
    bodies = MODELS["tracers"].parameters(scene).bodies
    energy, work = budget(scene)
    lost = float(np.sum(bodies.mass * bodies.apparent_gravity * bodies.settling)) * 0.1 * np.arange(6)
    assert np.abs(np.diff(work)).max() > 0.01 * lost[1]
    np.testing.assert_allclose(work - energy + energy[0], lost, rtol=1e-9, atol=1e-9 * lost[1])


def test_who_comes_and_goes_takes_its_energy_along():
    """In a vacuum nothing else changes it."""
    ball = ParticleSpec(name="ball", radius=1e-3, density=1000.0, positions=((0.5, 0.3), (0.2, 0.6)))
    scene = TracersScene(
        duration=1.5,
        frame_every=0.1,
        liquid=FluidSpec(viscosity=0.0, density=1e-3),
        particles=(ball,),
        tank=TankSpec(high=(1.0, 0.8)),
        openings=(
            OpeningSpec(wall=0, low=(0.0, 0.3), high=(0.0, 0.6), rate=10.0, velocity=(2.0, 0.5)),
            OpeningSpec(wall=2, low=(1.0, 0.0), high=(1.0, 0.8)),
        ),
        hydrodynamics=TracerHydrodynamicsSpec(drag="none"),
    )
    *_, last = ecume.simulate(scene)
    assert last.numbers["entered_through_opening_0"] == 15
    assert last.numbers["left_through_opening_1"] > 3
    energy, work = budget(scene)
    assert np.ptp(energy) > 0.5 * energy[0]
    np.testing.assert_allclose(energy - work, energy[0], rtol=1e-10)


def test_every_scene_has_a_line_of_energy():
    model = MODELS["tracers"]
    for flow in (FlowSpec(), FlowSpec(shear_rate=3.0)):
        scene = alone(grain(), flow=flow)
        assert ENERGY in [one.name for one in model.invariants(scene, model.parameters(scene))]
