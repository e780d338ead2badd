"""Floats with undulated rims: they rotate, and attract rise to rise."""

import math

import numpy as np
import pytest

from ecume.errors import SceneError
from ecume.laws import multipole
from ecume.models.floating import FLOATING
from ecume.models.floating.setup.kinds import float_kinds
from ecume.models.liquids import liquid_of
from ecume.scenes.floating import DiscSpec, FloatingScene, FloatSpec, HydrodynamicsSpec, InteractionSpec, LiquidSpec
from ecume.simulation import simulate
from tests.models import begun

RADIUS, HEIGHT = 0.3e-3, 15e-6


def pair(angles, apart=3.0, *, mode=2, drag=True, viscosity=1e-3, duration=0.02, frame_every=0.01, method="multipole"):
    bodies = tuple(
        FloatSpec(
            name=f"disc {k}",
            radius=RADIUS,
            density=1000.0,
            disc=DiscSpec(thickness=0.3 * RADIUS, rim="top", undulation=HEIGHT, mode=mode, angle=angle),
            positions=((k * apart * RADIUS, 0.0),),
        )
        for k, angle in enumerate(angles)
    )
    return FloatingScene(
        duration=duration,
        frame_every=frame_every,
        liquid=LiquidSpec(density=1000.0, viscosity=viscosity),
        particles=bodies,
        hydrodynamics=HydrodynamicsSpec(drag="stokes" if drag else "none"),
        interaction=InteractionSpec(method=method, order=8),
    )


def test_forces_and_torques_of_the_integration_are_those_of_the_solver():
    scene = pair((0.4, 1.1))
    parameters, state, workspace = begun(scene)
    FLOATING.advance(parameters, state, workspace, 0)
    disc = float_kinds(scene)[0].body
    bodies = [multipole.Undulated(disc, ((2, HEIGHT, angle),)) for angle in (0.4, 1.1)]
    found = multipole.solve(state.position, bodies, liquid_of(scene), 8)
    assert workspace.force == pytest.approx(found.forces, rel=1e-6)
    assert workspace.scratch.interactions[0].torque == pytest.approx(found.torques, rel=1e-6)


@pytest.mark.long
@pytest.mark.uncompiled  # the solver is compiled for the test above
@pytest.mark.parametrize(("mode", "slowest", "shortest_time"), [(2, 0.5, 0.8), (3, 0.8, 2.0)])
def test_the_step_follows_the_stiffest_rotation_of_a_disc_and_its_six_neighbors(mode, slowest, shortest_time):
    scene = pair((0.0, 0.0), mode=mode, drag=False)
    parameters, liquid = FLOATING.parameters(scene), liquid_of(scene)
    corners = np.exp(1j * math.pi / 3.0 * np.arange(6))
    position = 2.0001 * RADIUS * np.array([[0.0, 0.0], *zip(corners.real, corners.imag, strict=True)])
    disc = float_kinds(scene)[0].body

    def torques(angles):
        bodies = [multipole.Undulated(disc, ((mode, HEIGHT, angle),)) for angle in angles]
        return multipole.solve(position, bodies, liquid, 12).torques

    at, turned = np.random.default_rng(0).uniform(0.0, 2.0 * math.pi, 7), 1e-4 * np.eye(7)
    stiffness = np.array([torques(at - by) - torques(at + by) for by in turned]) / 2e-4
    largest = np.linalg.eigvalsh(0.5 * (stiffness + stiffness.T)).max()
    inertia = 0.5 * parameters.floats.mass[0] * RADIUS**2
    assert slowest < math.sqrt(largest / inertia) * parameters.shortest_time < shortest_time


@pytest.mark.long
@pytest.mark.compiled
def test_two_quadrupoles_turn_against_each_other_and_dock_rise_to_rise():
    scene = pair((0.5, 0.4), drag=True, viscosity=0.05, duration=0.6, frame_every=0.02)
    frames = list(simulate(scene))
    first, last = (frame.arrays["angle"] for frame in (frames[0], frames[-1]))
    x, y = np.diff(frames[-1].arrays["position"], axis=0)[0]
    # Only the sum of both angles from the line of centers counts, and it turns to zero.
    both = (last.sum() - 2.0 * np.arctan2(y, x)) % np.pi
    assert min(both, np.pi - both) < 0.02
    assert first[0] - last[0] == pytest.approx(first[1] - last[1], rel=0.05)
    assert frames[-1].numbers["contacts"] == 1
    energies = np.array([frame.numbers["total_energy"] for frame in frames])
    assert np.all(np.diff(energies) <= 1e-6 * np.ptp(energies))


@pytest.mark.long
@pytest.mark.compiled
def test_energy_and_both_momenta_last_while_two_turn_and_nothing_drags():
    frames = list(simulate(pair((0.5, 0.4), 2.8, drag=False, duration=0.008, frame_every=0.002)))
    arrays = frames[-1].arrays
    inertia = 0.5 * arrays["mass"] * arrays["radius"] ** 2
    turning = 0.5 * np.sum(inertia * arrays["spin"] ** 2)
    moving = frames[-1].numbers["kinetic_energy"]
    lost = frames[-1].numbers["pair_energy"] - frames[0].numbers["pair_energy"]
    assert turning > 0.05 * moving
    assert moving == pytest.approx(-lost, rel=5e-3)
    spun = np.sum(inertia * np.abs(arrays["spin"]))
    assert frames[-1].numbers["angular_momentum"] == pytest.approx(0.0, abs=1e-5 * spun)


def test_what_turns_needs_multipoles():
    with pytest.raises(SceneError, match="know contact lines which undulate"):
        FLOATING.parameters(pair((0.0, 0.0), method="pair-corrected"))
