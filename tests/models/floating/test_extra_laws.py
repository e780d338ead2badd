import math

import numpy as np
import pytest

from ecume.errors import BadInput
from ecume.models import MODELS
from ecume.models.floating import PairParameters
from ecume.simulation import simulate
from tests.models.floating.bowls import bowl, two_floats

pytestmark = pytest.mark.compiled


def magnetic(distance: float, parameters: PairParameters) -> float:
    """Dipoles that stand upright repel as the fourth power."""
    return 3e-17 / distance**4


def falling(distance: float, parameters: PairParameters) -> float:
    return 1e-3 * parameters.radius_i * parameters.radius_j / distance


def first_kick(laws):
    """The speed that one step gives the second of two floats, and what turns it into a force."""
    scene, model = two_floats(6e-3, duration=0.2), MODELS["floating"]
    parameters = model.parameters(scene)
    state = model.start(scene, parameters)
    used = model.extended(laws) if laws else model
    assert used.advance(parameters, state, used.workspace(parameters, state, 1.0), 1) == 0
    return state.velocity[1, 0] * parameters.floats.mass[0] / parameters.time_step


def test_users_forces_are_added_to_our_own():
    # Compiling a march takes seconds, so both laws go into one.
    wanted = magnetic(6e-3, None) + 1e-9 / 6e-3
    assert first_kick([magnetic, falling]) - first_kick([]) == pytest.approx(wanted, rel=1e-4)


def test_a_law_that_adds_nothing_changes_no_bit():
    def nothing(distance, parameters):
        return 0.0

    scene = bowl(20, duration=0.5)
    plain = list(simulate(scene))[-1].arrays["position"]
    with_nothing = list(simulate(scene, extra_laws=[nothing]))[-1].arrays["position"]
    assert np.array_equal(plain, with_nothing)


@pytest.mark.parametrize(
    ("law", "says"),
    [
        (lambda distance: 1.0, "expected 1, got 2"),
        (lambda distance, parameters: parameters.color, "Unknown attribute 'color'"),
        (lambda distance, parameters: None, "came None at 0.0032 m; wanted a force in N"),
        (lambda distance, parameters: math.nan, "came nan"),
        (lambda distance, parameters: parameters.radius_i / distance, "would create momentum"),
        (lambda distance, parameters: parameters.charge_i - parameters.charge_j, "would create momentum"),
        (3, "extra_laws: 3: cannot be used"),
    ],
)
def test_a_law_that_is_none_is_refused_in_a_line(law, says):
    with pytest.raises(BadInput, match=says) as caught:
        MODELS["floating"].extended([law])
    assert "\n" not in str(caught.value)
