"""Loops over threads: the same bits as without, for any number of them."""

import sys

import numba
import numpy as np
import pytest

from ecume._variants import Shared
from ecume.models.soft import SOFT
from ecume.models.soft.contacts import tree_search
from ecume.models.soft.contacts.contact_list import update_contact_list
from ecume.models.soft.integration.time_stepping import one_step
from ecume.models.soft.state import LENGTH

from .test_packings import packing

pytestmark = pytest.mark.compiled


def integrated(scene, steps=6, iterations=0):
    parameters = SOFT.parameters(scene)
    state = SOFT.start(scene, parameters)
    state.pace[LENGTH] = 0.05
    state.effort[:] = iterations, 0, 0
    scratch = SOFT.workspace(parameters, state, 1.0)
    for _ in range(steps):
        assert one_step(parameters, state, scratch) is not None
        if update_contact_list(parameters, state):
            scratch = SOFT.workspace(parameters, state, 1.0)
    return state


def threaded_loops():
    """All loops of the model that have a version with threads."""
    modules = [module for name, module in sys.modules.items() if name.startswith("ecume.models.soft")]
    return {id(one): one for module in modules for one in vars(module).values() if isinstance(one, Shared)}.values()


@pytest.mark.long
@pytest.mark.parametrize(
    ("rotation", "iterations"),
    [(True, 0), pytest.param(False, 0, marks=pytest.mark.long), pytest.param(False, 2000, marks=pytest.mark.long)],
)
def test_a_step_has_the_same_bits_with_and_without_threads(monkeypatch, rotation, iterations):
    """By gradients, and where those are said to have taken many iterations, by a factorization."""
    scene = packing(count=300, strain=0.2, hydrodynamics={"drag": "stokes"}, rotation=rotation)
    alone = integrated(scene, iterations=iterations)
    for one in threaded_loops():
        monkeypatch.setattr(one, "few", 1)
    monkeypatch.setattr(tree_search, "CELL_SEARCH_FROM", 1)
    many = numba.get_num_threads()
    try:
        for threads in (1, 2):
            numba.set_num_threads(min(threads, many))
            together = integrated(scene, iterations=iterations)
            assert (together.effort[1] > 0) == (iterations > 0)
            for name, array in alone._asdict().items():
                assert np.asarray(array).tobytes() == getattr(together, name).tobytes(), name
        unused = {one.__name__ for one in threaded_loops() if not one.together.overloads}
        assert unused <= ({"fill_matrix"} if rotation else set())
    finally:
        numba.set_num_threads(many)
