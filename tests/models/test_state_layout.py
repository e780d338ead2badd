"""A state read from a file fits its scene, or it is refused: compiled loops trust its sizes and indices."""

from pathlib import Path

import numpy as np
import pytest

import ecume
from ecume.errors import BadInput
from ecume.models import MODELS
from ecume.models.layouts import misfit
from ecume.simulation import moments

TEMPLATES = Path(ecume.__file__).parent / "templates"
SCENES = {
    "two-spheres": {"skin": 1.0, "touches": 99, "touching": np.zeros((1, 2), np.int64), "reference": np.zeros((1, 2))},
    "soft-two-spheres": {"contacts": 99, "pair": 2, "order": 1, "log_gap": np.zeros(0)},
    "small-tank": {
        "region": -1,
        "skin": 1.0,
        "zone": 1,
        "density": np.ones(3),
        "velocity": np.zeros((2, 5), np.float32),
    },
    "bouncing-particles": {"left": 3, "hits": np.zeros(1, np.int64)},
}
"""Templates, and values with which their states do not fit."""
CASES = [(template, field) for template, values in SCENES.items() for field in values]


def begun(template):
    scene = ecume.load_scene(TEMPLATES / f"{template}.toml")
    model = MODELS[scene.model]
    parameters = model.parameters(scene)
    return scene, parameters, model.start(scene, parameters)


@pytest.mark.parametrize("template", SCENES)
def test_a_state_at_the_start_fits(template):
    scene, parameters, state = begun(template)
    assert misfit(state, MODELS[scene.model].layout(scene, parameters, state)) == ""


@pytest.mark.parametrize(("template", "field"), CASES)
def test_a_state_that_does_not_fit_is_refused(template, field):
    scene, parameters, state = begun(template)
    value = SCENES[template][field]
    wrong = value if isinstance(value, np.ndarray) else np.full_like(getattr(state, field), value)
    with pytest.raises(BadInput, match=f"does not fit the scene: {field} .*; expected"):
        next(moments(scene, state=state._replace(**{field: wrong}), constants=lambda derived: parameters))
