"""Engines: programs that integrate in place of the loops of a model."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ecume.models.model import Model

LOCAL = "local"
"""The loops of the model itself."""
LAMMPS = "lammps"


def _no_facts() -> Mapping[str, str | int]:
    """Nothing beside the versions that each session states."""
    return {}


@dataclass(frozen=True)
class Engine:
    """Integrates the states of a scene; frames and checkpoints are those of its model."""

    model: Callable[[Model], Model]
    """makes of the scene's model one that integrates in another way"""
    name: str = LOCAL
    """as in `--engine`; the manifest of a run states it, since states of one engine fit no other"""
    repeats: bool = True
    """whether frames that are computed again have the same bits"""
    facts: Callable[[], Mapping[str, str | int]] = _no_facts
    """version and number of ranks, for the manifest; called after the first step"""
