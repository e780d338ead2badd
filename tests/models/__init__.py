"""Tests of the models, and how each of them is set up."""

from __future__ import annotations

from typing import Any

from ecume.models import MODELS


def begun(scene: Any) -> tuple[Any, Any, Any]:
    """Parameters, state and workspace of a scene at its start."""
    model = MODELS[scene.model]
    parameters = model.parameters(scene)
    state = model.start(scene, parameters)
    return parameters, state, model.workspace(parameters, state, 1.0)
