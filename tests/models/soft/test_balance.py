"""Forces of many spheres balance at every accepted step, not only at the last."""

import numpy as np
import pytest

from ecume.errors import SceneError
from ecume.models.soft import SOFT
from ecume.models.soft.contacts.contact_list import update_contact_list
from ecume.models.soft.integration.time_stepping import one_step
from ecume.models.soft.state import FORCE_RESIDUAL
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate
from tests.models import begun

from .test_packings import packing


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize("drag", [True, False])
def test_what_is_left_on_a_thousand_sheared_spheres_is_below_1e_8_of_the_typical_force(drag):
    scene = packing(count=500, filled=0.8, strain=0.5, hydrodynamics={"drag": "stokes" if drag else "none"})
    parameters, state, scratch = begun(scene)
    left = []
    for _ in range(20):
        assert one_step(parameters, state, scratch) is not None
        force = np.linalg.norm(scratch.step.responses.force, axis=1)
        left.append(np.abs(scratch.step.bodies.right).max() / np.sqrt((force**2).mean()))
        # What is reported is less than that by what rounding of positions makes of it.
        assert state.pace[FORCE_RESIDUAL] <= left[-1]
        if update_contact_list(parameters, state):
            scratch = SOFT.workspace(parameters, state, 1.0)
    # Also at the first of them, where contacts have only begun to bear anything.
    assert 0.0 < max(left) < 1e-8


def alone_on_a_wall(**changes):
    given = {
        "model": "soft", "duration": 1.0, "frame_every": 0.5, "rotation": True, "gravity": 1.0,
        "liquid": {"viscosity": 1.0, "density": 1.0}, "walls": [{"side": "bottom", "position": 0.0}],
        "particles": [
            {"radius": 1.0, "modulus": 1.0, "density": 1.001, "positions": [[4.0 * n, 1.02] for n in range(2)]}
        ],
        "films": {"cutoff": 0.5},
    }  # fmt: skip
    return from_plain(given | changes)


def test_spheres_that_only_a_wall_holds_bear_their_weight_though_they_may_roll():
    """The matrix was singular: spins were held by the stiffness of pairs, of which there are none."""
    for frame in simulate(alone_on_a_wall()):
        assert frame.numbers["bottom_force_y"] == pytest.approx(-2.0 * 4.0 / 3.0 * np.pi * 1e-3, rel=1e-9)
        assert frame.numbers["imbalance"] < 1e-9


LOAD = ({"time": 0.0, "load": 0.0}, {"time": 0.5, "load": 1.0})


def leaning(**changes):
    """A sphere that leans on one of two others, which rest on a wall, and on which a downward force starts to act."""
    places = ([0.0, 1.02], [2.02, 1.02], [3.05, 2.78])
    spheres = [
        {"radius": 1.0, "modulus": 1.0, "positions": [place], "force": [0.0, -1e-4 * (n == 2)]}
        for n, place in enumerate(places)
    ]
    given = {
        "model": "soft", "duration": 1.0, "frame_every": 0.5, "rotation": True, "liquid": {"viscosity": 1.0},
        "walls": [{"side": "bottom", "position": 0.0}], "particles": spheres, "protocol": LOAD,
        "films": {"cutoff": 0.3},
    }  # fmt: skip
    return from_plain(given | changes)


def test_a_load_that_would_roll_a_sphere_off_at_once_is_refused_with_what_helps():
    """The run ended after some steps, since none was short enough for a fall without resistance."""
    scene = leaning()
    with pytest.raises(SceneError, match=r"no film resists the forces: spheres roll .*hydrodynamics.drag = 'stokes'"):
        SOFT.start(scene, SOFT.parameters(scene))


@pytest.mark.parametrize("changes", [{"rotation": False}, {"hydrodynamics": {"drag": "stokes"}}])
def test_where_films_or_the_liquid_resist_a_load_it_runs(changes):
    assert max(frame.numbers["imbalance"] for frame in simulate(leaning(**changes))) < 1e-7
