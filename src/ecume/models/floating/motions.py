"""Which floats turn, and how easily."""

from __future__ import annotations

from ecume.models.floating.contact_models import contacts_of
from ecume.models.floating.interactions import interactions_of
from ecume.models.floating.parameters import Parameters
from ecume.units import Array


def inertia_of(parameters: Parameters) -> Array | None:
    """The moments of inertia of floats that turn (kg m^2), (N,); None where none does."""
    by_contacts = contacts_of(parameters).inertia(parameters.parts.contacts)
    found = [by_contacts, *(row.inertia(part) for part, row in interactions_of(parameters))]
    return next((each for each in found if each is not None), None)
