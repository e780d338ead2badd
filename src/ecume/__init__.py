"""Particles on, in and between liquids.

    import ecume
    scene = ecume.load_scene("cereal-bowl.toml").replace("dish.radius", "6 cm")
    for frame in ecume.simulate(scene):
        print(frame.time, frame.numbers["kinetic_energy"])

Each name is imported at its first use, so that `import ecume` is fast.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from ecume import _hooks
from ecume._version import __version__

if TYPE_CHECKING:
    from ecume.errors import BadInput, Diverged, EcumeError, FloaterSinks, RunExists, SceneError, Stopped, StorageError
    from ecume.fitting import fit
    from ecume.models.actions import every
    from ecume.run import resume
    from ecume.scenes.floating import (
        ContactSpec,
        DishSpec,
        FloatingScene,
        FloatRow,
        FloatSpec,
        HydrodynamicsSpec,
        IntegrationSpec,
        InteractionSpec,
        LiquidSpec,
        SurfaceEnergies,
    )
    from ecume.scenes.load import load_scene
    from ecume.scenes.schema import Scene, from_plain, scene_hash, to_plain
    from ecume.scenes.writing import scene, to_toml, write_scene
    from ecume.simulation import simulate
    from ecume.sweep import open_sweep
    from ecume.trajectories.frame import Frame
    from ecume.trajectories.reader import open_trajectory

__all__ = [
    "BadInput",
    "ContactSpec",
    "DishSpec",
    "Diverged",
    "EcumeError",
    "FloatRow",
    "FloatSpec",
    "FloaterSinks",
    "FloatingScene",
    "Frame",
    "HydrodynamicsSpec",
    "IntegrationSpec",
    "InteractionSpec",
    "LiquidSpec",
    "RunExists",
    "Scene",
    "SceneError",
    "Stopped",
    "StorageError",
    "SurfaceEnergies",
    "__version__",
    "every",
    "fit",
    "from_plain",
    "load_scene",
    "open_sweep",
    "open_trajectory",
    "resume",
    "scene",
    "scene_hash",
    "simulate",
    "to_plain",
    "to_toml",
    "write_scene",
]

_HOMES = {
    "ecume.errors": "BadInput Diverged EcumeError FloaterSinks RunExists SceneError Stopped StorageError",
    "ecume.fitting": "fit",
    "ecume.models.actions": "every",
    "ecume.run": "resume",
    "ecume.scenes.floating": "ContactSpec DishSpec FloatRow FloatSpec FloatingScene HydrodynamicsSpec"
    " IntegrationSpec InteractionSpec LiquidSpec SurfaceEnergies",
    "ecume.scenes.load": "load_scene",
    "ecume.scenes.schema": "Scene from_plain scene_hash to_plain",
    "ecume.scenes.writing": "scene to_toml write_scene",
    "ecume.simulation": "simulate",
    "ecume.sweep": "open_sweep",
    "ecume.trajectories.frame": "Frame",
    "ecume.trajectories.reader": "open_trajectory",
}
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names.split()}


def __getattr__(name: str) -> Any:
    """Import a public name from its module; `ecume.run` is the module with `run(scene, directory)`."""
    if name == "run":
        return importlib.import_module("ecume.run")
    if name not in _HOME_OF:
        raise AttributeError(f"ecume has no {name}")
    return getattr(importlib.import_module(_HOME_OF[name]), name)


def _html_of(subject: Any) -> str | None:
    """The picture of a frame, trajectory or run directory for a notebook, or None. The code that draws it is imported
    at the first call.
    """
    html: str | None = importlib.import_module("ecume.show.view.page").in_notebook(subject)
    return html


def _scene_of(plain: dict[str, Any]) -> Any:
    """A scene from plain data; the scene modules are imported at the first call."""
    return importlib.import_module("ecume.scenes.schema").from_plain(plain)


def _derived_arrays(scene: Any) -> Any:
    """A function that adds the arrays that follow from the recorded ones: the other pressures of a tank."""
    if scene.model != "sph":
        return lambda frame: frame
    return importlib.import_module("ecume.analysis.pressures").with_pressures(scene)


def _scenes_of_models(_: None) -> Any:
    """The scenes of models that are not in the table `SCENES`."""
    return importlib.import_module("ecume.models").SCENES_OF_MODELS


def _changed(changes: tuple[Any, Any]) -> Any:
    """A scene with other values; the writer of scenes is imported at the first call."""
    return importlib.import_module("ecume.scenes.writing").changed(*changes)


_hooks.changed_scene.register(_changed)
_hooks.derived_arrays.register(_derived_arrays)
_hooks.html_of.register(_html_of)
_hooks.scene_of.register(_scene_of)
_hooks.scenes_of_models.register(_scenes_of_models)


def __dir__() -> list[str]:
    return sorted(__all__)
