"""The page on liquids of particles speaks of every option that a scene may name, and of every key."""

import dataclasses
import re
import typing
from pathlib import Path

import pytest

from ecume.laws.kernels import KERNELS
from ecume.models.sph.choosing import DIFFUSIONS, FRICTIONS, PRECISIONS, STRESSES, TURBULENCES
from ecume.models.sph.parameters import INTEGRATORS, SHIFTINGS, TENSIONS
from ecume.scenes import sph
from ecume.scenes.common import Common
from ecume.scenes.sph.scene import MethodSpec, RegionSpec
from ecume.scenes.sph.tank import SideSpec, TankSpec

PAGE = (Path(__file__).parents[2] / "docs" / "physics" / "sph.md").read_text(encoding="utf-8")
FAMILIES = {
    "kernel": KERNELS,
    "density_diffusion": DIFFUSIONS,
    "friction": FRICTIONS,
    "pressure_force": STRESSES,
    "shifting": SHIFTINGS,
    "surface_tension_model": TENSIONS,
    "turbulence": TURBULENCES,
    "integrator": INTEGRATORS,
    "precision": PRECISIONS,
}


def literals(spec, key):
    """The names that a key of a scene takes by its type."""
    kinds = typing.get_args(typing.get_type_hints(spec)[key])
    return [name for name in kinds if isinstance(name, str) and name]


@pytest.mark.parametrize(
    ("key", "name"),
    [(key, name) for key, names in FAMILIES.items() for name in names]
    + [("start", name) for name in literals(MethodSpec, "start")]
    + [("pressure_split", name) for name in literals(MethodSpec, "pressure_split")]
    + [("flow", name) for name in literals(RegionSpec, "flow")]
    + [("walls", name) for name in literals(TankSpec, "walls")]
    + [("kind", name) for name in literals(SideSpec, "kind")],
)
def test_every_option_stands_on_the_page(key, name):
    assert re.search(rf"`{key}\b|\b{key}`", PAGE) or f"{key} =" in PAGE, f"{key} is not told"
    assert f"`{name}`" in PAGE or f'"{name}"' in PAGE, f"{key} = {name} is not told"


USUAL = {field.name for field in dataclasses.fields(Common)}
"""Of every model's scene."""
SPECS = [kind for kind in vars(sph).values() if isinstance(kind, type) and dataclasses.is_dataclass(kind)]


@pytest.mark.parametrize(
    ("spec", "key"),
    [(spec.__name__, field.name) for spec in SPECS for field in dataclasses.fields(spec) if field.name not in USUAL],
)
def test_every_key_stands_on_the_page(spec, key):
    assert re.search(rf"\b{key}\b", PAGE), f"{key} of {spec} is not told"
