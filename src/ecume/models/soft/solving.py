"""Which way a step's linear systems are solved: by elimination for a few spheres."""

from __future__ import annotations

from ecume.models.soft.parameters import Drive, Parameters
from ecume.models.soft.schemes import Scheme
from ecume.models.soft.stages import During, Step, attempt_dense, first_stage, newton_dense

FINE = 1e-13
"""The last change of a position, over its distance, with which spheres are said to be balanced."""


def attempt(parameters: Parameters, step: Step, scheme: Scheme, during: During) -> float:
    """Try a step: the estimated error, or `stages.FAILED`."""
    return attempt_dense(parameters.contacts, step, scheme, during)


def balance(parameters: Parameters, step: Step, drive: Drive) -> bool:
    """Move the spheres to where their forces balance while the gaps stay as they are; whether there is such a place."""
    first_stage(parameters.contacts, step, drive)
    return bool(newton_dense(parameters.contacts, step, (drive, 0.0), FINE))
