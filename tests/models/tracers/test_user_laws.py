"""External laws of the user move tracers as they should, and their work is injected work."""

from typing import Any

import numpy as np
import pytest

from ecume.errors import BadInput, SceneError
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate

MASS = 4.0 / 3.0 * np.pi * 1e-9 * 2000.0


def trap(position: Any, velocity: Any, time: float, parameters: Any) -> Any:
    """A harmonic trap about the origin."""
    pull = -(parameters.constants[0] ** 2)
    x, y = position
    return pull * x, pull * y


def wind(position: Any, velocity: Any, time: float, parameters: Any) -> Any:
    """A constant force (N) along x."""
    return 1e-6 / parameters.mass, 0.0


def magnetic(position: Any, velocity: Any, time: float, parameters: Any) -> Any:
    """A Lorentz force, which does no work."""
    return 5.0 * velocity[1], -5.0 * velocity[0]


def growing(position: Any, velocity: Any, time: float, parameters: Any) -> Any:
    """An acceleration that grows with time."""
    return 6.0 * time, 0.0


def grains(step: float = 0.01, **changes: Any) -> Any:
    """Two grains of different species, without weight."""
    particles = [
        {"name": name, "radius": 1e-3, "density": 2000.0, "positions": [place], "velocity": [0.0, 0.01]}
        for name, place in (("a", [0.01, 0.0]), ("b", [0.02, 0.0]))
    ]
    plain = {
        "model": "tracers",
        "duration": 1.0,
        "frame_every": 0.1,
        "gravity": 0.0,
        "particles": particles,
        "hydrodynamics": {"drag": "none", "added_mass": False},
        "integration": {"time_step": step},
    }
    return from_plain(plain | changes)


def test_a_trap_is_an_oscillator_of_second_order_and_its_work_is_exact() -> None:
    law, errors = {"law": "trap", "constants": [3.0]}, []
    for step in (0.02, 0.01):
        frames = list(simulate(grains(step, user_laws=[law]), extra_laws=[trap]))
        time = np.array([frame.time for frame in frames])
        x, y = np.array([frame.arrays["position"][0] for frame in frames]).T
        errors.append(
            float(np.abs(x - 0.01 * np.cos(3.0 * time)).max() + np.abs(y - 0.01 / 3 * np.sin(3.0 * time)).max())
        )
        own = [frame.numbers["total_energy"] - frame.numbers["injected_work"] for frame in frames]
        work = [frame.numbers["injected_work"] for frame in frames]
        np.testing.assert_allclose(own, own[0], rtol=1e-12)
        assert np.ptp(work) > 0.1 * own[0]
    assert errors[0] < 1e-4
    assert 3.5 < errors[0] / errors[1] < 4.5


@pytest.mark.parametrize("regime", ["inertial", "overdamped"])
def test_a_force_against_drag_gives_the_terminal_velocity(regime: str) -> None:
    still = [{"radius": 1e-3, "density": 2000.0, "positions": [[0.0, 0.0]], "velocity": [0.0, 0.0]}]
    changes = {
        "particles": still,
        "hydrodynamics": {"drag": "stokes", "added_mass": False},
        "liquid": {"viscosity": 0.1},
        "integration": {"integrator": regime, "time_step": 1e-3},
    }
    last = list(simulate(grains(**changes), extra_laws=[wind]))[-1]
    speed = 1e-6 / (6.0 * np.pi * 0.1 * 1e-3)
    np.testing.assert_allclose(last.arrays["velocity"], [[speed, 0.0]], rtol=1e-6, atol=1e-12)
    # The velocity of what has no inertia is that of the flow, and its energy of motion is counted as work.
    moving = last.numbers["kinetic_energy"] if regime == "overdamped" else 0.0
    work = 1e-6 * last.arrays["position"][0, 0]
    assert last.numbers["injected_work"] == pytest.approx(work + moving, rel=1e-9)


def test_a_force_that_follows_the_velocity_is_of_second_order() -> None:
    errors = []
    for step in (0.02, 0.01):
        last = list(simulate(grains(step), extra_laws=[magnetic]))[-1]
        wanted = 0.01 * np.array([np.sin(5.0), np.cos(5.0)])
        errors.append(float(np.abs(last.arrays["velocity"][0] - wanted).max()))
    assert 3.4 < errors[0] / errors[1] < 4.6


def test_a_force_that_grows_with_time_is_that_of_the_middle_of_each_step() -> None:
    """A midpoint rule has the exact velocity 3 t^2 then, however long the step."""
    *_, last = simulate(grains(0.1, user_laws=[{"law": "growing"}]), extra_laws=[growing])
    assert last.arrays["velocity"][0] == pytest.approx([3.0, 0.01], rel=1e-12)


def test_a_law_acts_on_the_species_that_the_scene_names() -> None:
    law = {"law": "wind", "species": ["b"]}
    last = list(simulate(grains(user_laws=[law]), extra_laws=[wind]))[-1]
    np.testing.assert_allclose(last.arrays["velocity"], [[0.0, 0.01], [1e-6 / MASS, 0.01]], rtol=1e-9)


def test_a_step_that_is_too_long_for_a_law_is_refused() -> None:
    law = {"law": "trap", "constants": [100.0]}
    with pytest.raises(SceneError, match=r"integration.time_step: got 0.01 s; expected at most 0.005 s"):
        next(simulate(grains(user_laws=[law]), extra_laws=[trap]))


@pytest.mark.parametrize(
    ("law", "says"),
    [
        (lambda distance, parameters: 1.0, "got 2 arguments; the model tracers expects external laws"),
        (lambda x, v, t, p: 1.0, "got 1.0; expected an acceleration"),
        (lambda x, v, t, p: (0.0, 0.0, 0.0), "a tuple of 2 numbers"),
        (lambda x, v, t, p: (p.color, 0.0), "cannot be used"),
    ],
)
def test_a_law_that_is_none_is_refused(law: Any, says: str) -> None:
    with pytest.raises(BadInput, match=says):
        next(simulate(grains(), extra_laws=[law]))
