"""Hooks by which higher layers add functions to objects of lower layers.

A frame has a picture in a notebook, and a trajectory has a scene, but the code for pictures and scenes is in higher
layers, which lower ones do not import. The top of the package registers the functions to call.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Generic, TypeVar

Given = TypeVar("Given")
Found = TypeVar("Found")


class Hook(Generic[Given, Found]):
    """A function that a higher layer registers later.

    >>> double: Hook[int, int] = Hook()
    >>> double.register(lambda number: 2 * number)
    >>> double(21)
    42
    """

    def __init__(self) -> None:
        self._function: Callable[[Given], Found] | None = None

    def register(self, function: Callable[[Given], Found]) -> None:
        """Register the function to call."""
        self._function = function

    def __call__(self, given: Given) -> Found:
        """Call the registered function. Raises LookupError if it is missing."""
        if self._function is None:
            raise LookupError("nothing is registered here")
        return self._function(given)


html_of: Hook[Any, str | None] = Hook()
"""The picture of a frame, trajectory or run directory as HTML, or None without a picture."""
changed_scene: Hook[tuple[Any, Any], Any] = Hook()
"""A scene with other values, from the scene and its changes by path."""
derived_arrays: Hook[Any, Callable[[Any], Any]] = Hook()
"""The function of a scene that adds derived arrays to its frames."""
scene_of: Hook[dict[str, Any], Any] = Hook()
"""The scene that plain data describe."""
scenes_of_models: Hook[None, Mapping[str, Any]] = Hook()
"""The types of scenes that models bring along, by the names of the models."""
