"""A tank on many ranks, which threads stand in for: the same bits as on one."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ecume.engine.mpi_exchange import Share
from ecume.errors import BadInput
from ecume.models.model import DONE
from ecume.models.sph import SPH
from ecume.models.sph.mpi import complete, integrate_shared, require_spreadable, workspace_shared
from ecume.scenes.load import load_scene
from tests.models.floating.test_mpi import copied, on_ranks

TANK = """
model = "sph"
duration = "1 s"
frame_every = "10 ms"
spacing = "5 cm"
[liquid]
density = 1000.0
viscosity = "10 Pa*s"
[tank]
low = ["0 m", "0 m"]
high = ["1 m", "80 cm"]
[[fluid]]
low = ["0 m", "0 m"]
high = ["30 cm", "40 cm"]
"""
STEPS = 25


def begun(*changes: str) -> tuple[Any, Any]:
    """Parameters and state of the tank."""
    scene = load_scene(TANK, list(changes))
    parameters = SPH.parameters(scene)
    return parameters, SPH.start(scene, parameters)


@pytest.mark.parametrize(("ranks", "changes"), [(2, ()), (3, ("integration.integrator=verlet", "liquid.viscosity=0"))])
def test_a_tank_on_ranks_is_that_of_one(ranks: int, changes: tuple[str, ...]) -> None:
    parameters, state = begun(*changes)
    require_spreadable(parameters)
    start = copied(state)
    alone = SPH.workspace(parameters, state, 1.0)
    assert SPH.advance(parameters, state, alone, STEPS) == DONE
    assert (state.reference != start.reference).any(), "the lists were never made anew"
    seen = SPH.observe(parameters, state, alone)

    def integrate_here(share: Share) -> Any:
        own = copied(start)
        scratch = workspace_shared(share, parameters, own, 1.0)
        assert integrate_shared(share, parameters, own, scratch, STEPS) == DONE
        return own, scratch, SPH.observe(parameters, own, complete(share, parameters, own, scratch))

    for own, scratch, frame in on_ranks(ranks, integrate_here):
        assert 0 < (scratch.lists.counts > 0).sum() < len(scratch.lists.counts), "a rank has all lists, or none"
        for name in state._fields:
            assert np.array_equal(getattr(own, name), getattr(state, name), equal_nan=True), name
        assert frame.numbers == seen.numbers


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("tank.walls=dummy", "mirrors or periodic"),
        ("tank.bottom.velocity=[0.1, 0.0]", "stand still"),
        ("method.density_diffusion=antuono", "does not support transport velocity"),
        ("method.turbulence=smagorinsky", "does not support surface tension"),
    ],
)
def test_tanks_that_are_not_spread_are_refused(change: str, message: str) -> None:
    parameters, _ = begun(change)
    with pytest.raises(BadInput, match=message):
        require_spreadable(parameters)
