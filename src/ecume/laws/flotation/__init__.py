"""Floating bodies: how they sit in the surface, and how they attract and repel through it."""

from ecume.laws.flotation.balance import (
    BALANCES,
    CHARGES,
    Balance,
    closed_form_balance,
    closed_form_charge,
    linear_balance,
    linear_charge,
    neutral_density_ratio,
    nonlinear_balance,
    nonlinear_charge,
    sinking_density_ratio,
)
from ecume.laws.flotation.bodies import (
    Disc,
    Liquid,
    Sphere,
    bond_number,
    density_ratio,
    dimensionless_weight,
    weight_number,
    young_contact_angle,
)
from ecume.laws.flotation.closeness import superposition_excess, superposition_reach
from ecume.laws.flotation.closure import closure_contact_angle
from ecume.laws.flotation.equilibria import Body, Equilibrium, capillary_charge, equilibrium
from ecume.laws.flotation.interaction import pair_energy, pair_force, surface_height
from ecume.laws.flotation.lying import lying_pair_energy, lying_pair_force
from ecume.laws.flotation.shapes import (
    Bubble,
    Ellipsoid,
    HorizontalCylinder,
    VerticalCylinder,
    disc_of_cylinder,
)

__all__ = [
    "BALANCES",
    "CHARGES",
    "Balance",
    "Body",
    "Bubble",
    "Disc",
    "Ellipsoid",
    "Equilibrium",
    "HorizontalCylinder",
    "Liquid",
    "Sphere",
    "VerticalCylinder",
    "bond_number",
    "capillary_charge",
    "closed_form_balance",
    "closed_form_charge",
    "closure_contact_angle",
    "density_ratio",
    "dimensionless_weight",
    "disc_of_cylinder",
    "equilibrium",
    "linear_balance",
    "linear_charge",
    "lying_pair_energy",
    "lying_pair_force",
    "neutral_density_ratio",
    "nonlinear_balance",
    "nonlinear_charge",
    "pair_energy",
    "pair_force",
    "sinking_density_ratio",
    "superposition_excess",
    "superposition_reach",
    "surface_height",
    "weight_number",
    "young_contact_angle",
]
