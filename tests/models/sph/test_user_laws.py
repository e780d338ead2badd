"""Laws of the user in tanks: forces on pairs of particles and external accelerations, with their work."""

import dataclasses
from typing import Any

import numpy as np
import pytest

from ecume.errors import BadInput
from ecume.models import MODELS
from ecume.models.user_laws import bind
from ecume.scenes.common import UserLawSpec
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate
from tests.models.sph.scenes import OPEN, PERIODIC

pytestmark = [pytest.mark.compiled, pytest.mark.sampled(2)]


def spring(distance: float, parameters: Any) -> float:
    """A repulsion that grows with the distance."""
    return parameters.constants[0] * distance


def upward(position: Any, velocity: Any, time: float, parameters: Any) -> Any:
    """Gravity, reversed."""
    return 0.0, 1.0


def swirl(position: Any, velocity: Any, time: float, parameters: Any) -> Any:
    """A force that follows position, velocity and time."""
    return -position[1] - velocity[0], position[0] + 0.1 * time


def blobs(*, away: float = 0.75, sides: Any = OPEN, gravity: float = 0.0, **more: Any) -> Any:
    """Two squares of liquid side by side, in empty space or between periodic sides."""
    names = dict.fromkeys(("left", "right", "bottom", "top"), sides)
    return from_plain(
        {
            "model": "sph",
            "duration": 0.05,
            "frame_every": 0.0125,
            "spacing": 0.125,
            "gravity": [0.0, -gravity],
            "liquid": {"density": 1.0, "sound_speed": 10.0, "maximum_speed": 1.0},
            "tank": {"low": [-2.0, -2.0], "high": [2.0, 2.0], **names},
            "fluid": [
                {"low": [0.0, 0.0], "high": [0.5, 0.5]},
                {"low": [away, 0.0], "high": [away + 0.5, 0.5]},
            ],
            "method": {"jitter": 0.2, "initial_pressure": "zero"},
            **more,
        }
    )


def accelerations(scene: Any, law: Any, **spec: Any) -> tuple[Any, Any]:
    """The state at the start, and the acceleration of a law there."""
    scene = dataclasses.replace(scene, user_laws=(UserLawSpec(law=law.__name__, **spec),))
    model = MODELS["sph"].extended(bind(scene, [law]))
    parameters = model.parameters(scene)
    state = model.start(scene, parameters)
    workspace = model.workspace(parameters, state, 1.0)
    model.observe(parameters, state, workspace)
    assert parameters.user_forces is not None
    return state, parameters.user_forces(parameters, state, workspace)


def test_a_pair_law_acts_between_all_pairs_within_the_support_and_keeps_momentum() -> None:
    state, found = accelerations(blobs(), spring, constants=[3.0])
    parameters = MODELS["sph"].parameters(blobs())
    between = state.position[:, None, :] - state.position[:, :, None]
    distance = np.sqrt((between**2).sum(axis=0))
    near = (distance > 0.0) & (distance < parameters.support)
    wanted = -(3.0 * between * near).sum(axis=2) / state.mass
    np.testing.assert_allclose(found, wanted, rtol=1e-10, atol=1e-10 * np.abs(wanted).max())
    assert np.abs((state.mass * found).sum(axis=1)).max() < 1e-12 * np.abs(state.mass * found).sum()


def test_a_pair_law_acts_between_the_regions_that_the_scene_names() -> None:
    state, found = accelerations(blobs(), spring, constants=[3.0], species=["fluid-1", "fluid-2"])
    own = state.region == 0
    near = np.array([np.abs(state.position[0, i] - state.position[0, own != own[i]]).min() for i in range(len(own))])
    assert found[0, own].min() < 0.0 < found[0, ~own].max()
    assert not found[:, near > 0.5].any()


def test_a_pair_law_acts_across_periodic_sides() -> None:
    moved = blobs(
        sides=PERIODIC, fluid=[{"low": [1.75, 0.0], "high": [2.0, 0.5]}, {"low": [-2.0, 0.0], "high": [-1.75, 0.5]}]
    )
    state, found = accelerations(moved, spring, constants=[3.0], species=["fluid-1", "fluid-2"])
    assert found[0, state.region == 0].min() < 0.0 < found[0, state.region == 1].max()
    assert np.abs((state.mass * found).sum(axis=1)).max() < 1e-12 * np.abs(state.mass * found).sum()


@pytest.mark.long
@pytest.mark.parametrize("integrator", ["symplectic", "verlet"])
def test_an_external_law_against_gravity_leaves_nothing_to_fall(integrator: str) -> None:
    scene = blobs(gravity=1.0, integration={"integrator": integrator})
    held, alone = ([frame.numbers["center_y"] for frame in simulate(scene, extra_laws=laws)] for laws in ([upward], []))
    np.testing.assert_allclose(held, held[0], rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(alone[-1] - alone[0], -0.5 * 0.05**2, rtol=1e-6)


def test_an_external_law_acts_on_the_region_that_the_scene_names() -> None:
    state, found = accelerations(blobs(), upward, species=["fluid-2"])
    np.testing.assert_array_equal(found, [np.zeros(len(state.mass)), state.region == 1])


@pytest.mark.long
@pytest.mark.parametrize("integrator", ["symplectic", "verlet"])
@pytest.mark.parametrize("law", [spring, swirl])
def test_the_work_of_a_law_is_injected_work(integrator: str, law: Any) -> None:
    named = [{"law": law.__name__, "constants": [3.0] if law is spring else []}]
    quiet = {"jitter": 0.2, "initial_pressure": "zero", "acoustic_damping": 0.0}  # little else takes energy
    scene = blobs(integration={"integrator": integrator}, user_laws=named, method=quiet, duration=0.2, frame_every=0.05)
    frames = list(simulate(scene, extra_laws=[law]))
    work = np.array([frame.numbers["injected_work"] for frame in frames])
    energy = np.array([frame.numbers["total_energy"] for frame in frames])
    assert abs(work[-1]) > 1e-4
    assert (energy - work).max() < energy[0] + 0.02 * np.ptp(work)
    assert (energy - work).min() > energy[0] - 0.1 * np.ptp(work)


@pytest.mark.parametrize(
    ("law", "says"),
    [
        (lambda x, v, t, p: (0.0, 0.0, 0.0), "a tuple of 2 numbers"),
        (lambda r, p: p.mass_i, "would create momentum"),
        (lambda r: 1.0, "got 1 arguments; the model sph expects pair laws .* or external laws"),
    ],
)
def test_a_law_that_is_none_is_refused(law: Any, says: str) -> None:
    with pytest.raises(BadInput, match=says):
        next(simulate(blobs(), extra_laws=[law]))
