"""Every pair of options of floating scenes: it works, with forces that are minus the slope of the energy, or it is
refused for a physical reason. The page in the documentation says which.
"""

from __future__ import annotations

import numpy as np
import pytest
from tests.contracts import float_options
from tests.contracts.float_options import NEW, PAGE, page, pairs, refusal, scene_with
from tests.models import begun

from ecume.models.floating import FLOATING
from ecume.models.floating.options import CAPABILITIES
from ecume.models.floating.time_integration.integration import forces_at
from ecume.models.model import DONE

# Each combination is compiled by itself: as plain Python all of them take a minute.
plain_only = pytest.mark.uncompiled
WITHOUT_ENERGY = {"one-sided law", "flow", "active forces", "waves", "surfactant in a dish"}
"""Options whose forces have no potential."""
DISHES = {"round dish", "square dish", "wall profile", "dish in motion", "surfactant in a dish"}
OUTSIDE = {"one-sided law", "flow", "active forces", *DISHES}
"""Options with which momentum is not kept."""
STEP = 1e-9
"""m, of differences"""


@pytest.fixture(autouse=True)
def _short_tables(monkeypatch):
    float_options.shorten_tables(monkeypatch.setattr)


def potential(parameters, state, workspace):
    """The potential energy of frames (J)."""
    numbers = FLOATING.observe(parameters, state, workspace).numbers
    return numbers["pair_energy"] + numbers["wall_energy"]


def minus_slope(parameters, state, workspace):
    """Minus the slope of the potential energy, by differences."""
    found = np.zeros_like(state.position)
    for i, axis in np.ndindex(found.shape):
        energies = []
        for way in (-STEP, STEP):
            position = state.position.copy()
            position[i, axis] += way
            energies.append(potential(parameters, state._replace(position=position), workspace))
        found[i, axis] = (energies[0] - energies[1]) / (2.0 * STEP)
    return found


@pytest.mark.sampled(6)
@plain_only
@pytest.mark.parametrize("pair", pairs(), ids=" and ".join)
def test_a_pair_of_options_works_or_is_refused_for_a_reason(pair):
    if refused := refusal(*pair):
        assert any(f"needs {phrase}" in refused for _, phrase in CAPABILITIES.values())
        return
    scene = scene_with(*pair)
    parameters, state, workspace = begun(scene)
    force = forces_at(parameters, state.position, workspace).copy()
    largest = np.abs(force).max()
    if not WITHOUT_ENERGY & set(pair):
        assert force == pytest.approx(minus_slope(parameters, state, workspace), abs=2e-3 * largest + 1e-18)
    if not OUTSIDE & set(pair):
        assert np.abs(force.sum(axis=0)).max() <= 1e-5 * largest + 1e-24
    assert FLOATING.advance(parameters, state, workspace, 3) == DONE
    assert all(np.all(np.isfinite(array)) for array in state)
    assert int(state.step[0]) == 3


@pytest.mark.long
@plain_only
def test_the_page_says_what_can_be_combined():
    assert page() == PAGE.read_text(encoding="utf-8"), "write it again: python -m tests.contracts.float_options"


def test_pairs_that_became_possible_are_not_refused():
    assert set(pairs()) >= NEW
    assert not [pair for pair in NEW if refusal(*pair)]


@pytest.mark.long
@pytest.mark.compiled
def test_a_grid_goes_with_friction_in_compiled_parts():
    scene = scene_with("grid", "friction")
    parameters = FLOATING.parameters(scene)
    state = FLOATING.start(scene, parameters)
    assert FLOATING.advance(parameters, state, FLOATING.workspace(parameters, state, 1.0), 2) == DONE
    assert state.turning.shape == (3, 2)
