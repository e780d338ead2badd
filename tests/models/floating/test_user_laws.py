import dataclasses
import math

import numpy as np
import pytest

from ecume.errors import BadInput
from ecume.models import MODELS
from ecume.models.floating import PairParameters
from ecume.simulation import simulate
from tests.models.floating.bowls import bowl, two_floats

pytestmark = pytest.mark.compiled


SMALL = 1.1e-6
"""m^2: the laws below act among floats of 1 mm, and add nothing among cereals of 1.5 mm."""


def small_magnets(distance: float, parameters: PairParameters) -> float:
    """Dipoles that stand upright repel as the fourth power."""
    return 3e-17 / distance**4 if parameters.radius_i * parameters.radius_j < SMALL else 0.0


def small_falling(distance: float, parameters: PairParameters) -> float:
    squared = parameters.radius_i * parameters.radius_j
    return 1e-3 * squared / distance if squared < SMALL else 0.0


@pytest.fixture(scope="module")
def extended():
    """Compiling a march takes seconds: one for all tests, with both laws."""
    return MODELS["floating"].extended([small_magnets, small_falling])


def first_kick(model):
    """The force that one step of a model lets the second of two floats feel, taken from its speed."""
    scene = two_floats(6e-3, duration=0.2)
    parameters = model.parameters(scene)
    state = model.start(scene, parameters)
    assert model.advance(parameters, state, model.workspace(parameters, state, 1.0), 1) == 0
    return state.velocity[1, 0] * parameters.floats.mass[0] / parameters.time_step


def test_users_forces_are_added_to_our_own(extended):
    wanted = 3e-17 / 6e-3**4 + 1e-9 / 6e-3
    assert first_kick(extended) - first_kick(MODELS["floating"]) == pytest.approx(wanted, rel=1e-4)


def test_multipoles_refuse_laws_that_they_would_leave_out(extended):
    model, scene = MODELS["floating"], two_floats(6e-3, duration=0.2)
    asked = dataclasses.replace(scene, interaction=dataclasses.replace(scene.interaction, method="multipole", order=2))
    parameters = model.parameters(asked)
    state = model.start(asked, parameters)
    with pytest.raises(BadInput, match=r"extra_laws: .* got 'multipole' \(interaction.method\)"):
        extended.advance(parameters, state, model.workspace(parameters, state, 1.0), 1)


def test_laws_that_add_nothing_change_no_bit(extended, monkeypatch):
    laws, scene = [small_magnets, small_falling], bowl(20, duration=0.5)
    plain = list(simulate(scene))[-1].arrays["position"]
    asked = []
    monkeypatch.setitem(
        MODELS, "floating", dataclasses.replace(extended, extended=lambda given: asked.append(given) or extended)
    )
    with_nothing = list(simulate(scene, extra_laws=laws))[-1].arrays["position"]
    assert asked == [laws]
    assert np.array_equal(plain, with_nothing)


@pytest.mark.parametrize(
    ("law", "says"),
    [
        (lambda distance: 1.0, "expected 1, got 2"),
        (lambda distance, parameters: parameters.color, "Unknown attribute 'color'"),
        (lambda distance, parameters: None, "got None at 0.0032 m; expected a force in N"),
        (lambda distance, parameters: math.nan, "got nan"),
        (lambda distance, parameters: parameters.radius_i / distance, "would create momentum"),
        (lambda distance, parameters: parameters.charge_i - parameters.charge_j, "would create momentum"),
        (3, "extra_laws: 3: cannot be used"),
    ],
)
def test_a_law_that_is_none_is_refused_in_a_line(law, says):
    with pytest.raises(BadInput, match=says) as caught:
        MODELS["floating"].extended([law])
    assert "\n" not in str(caught.value)
