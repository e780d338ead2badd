"""The page on liquids of particles describes every option that a scene may name, and every key."""

import dataclasses
import re
import typing
from pathlib import Path

import pytest

from ecume.laws.kernels import KERNELS
from ecume.models.sph.integration.time_stepping import INTEGRATORS
from ecume.models.sph.rates.methods import DIFFUSIONS, FRICTIONS, PRESSURE_FORCES
from ecume.models.sph.rates.shifting import SHIFTINGS
from ecume.models.sph.rates.surface_tension import TENSIONS
from ecume.models.sph.setup.choices import PRECISIONS, TURBULENCES
from ecume.scenes import sph
from ecume.scenes.common import Common
from ecume.scenes.sph.scene import MethodSpec, RegionSpec
from ecume.scenes.sph.tank import SideSpec, TankSpec

PAGES = sorted((Path(__file__).parents[2] / "docs" / "physics").glob("sph*.md"))
PAGE = "\n".join(page.read_text(encoding="utf-8") for page in PAGES)
FAMILIES = {
    "kernel": KERNELS,
    "density_diffusion": DIFFUSIONS,
    "viscosity_model": FRICTIONS,
    "pressure_force": PRESSURE_FORCES,
    "shifting": SHIFTINGS,
    "surface_tension_model": TENSIONS,
    "turbulence": TURBULENCES,
    "integrator": INTEGRATORS,
    "precision": PRECISIONS,
}


def literals(spec, key):
    """The names that the type of a key permits."""
    kinds = typing.get_args(typing.get_type_hints(spec)[key])
    return [name for name in kinds if isinstance(name, str) and name]


@pytest.mark.parametrize(
    ("key", "name"),
    [(key, name) for key, names in FAMILIES.items() for name in names]
    + [("initial_pressure", name) for name in literals(MethodSpec, "initial_pressure")]
    + [("pressure_split", name) for name in literals(MethodSpec, "pressure_split")]
    + [("flow", name) for name in literals(RegionSpec, "flow")]
    + [("walls", name) for name in literals(TankSpec, "walls")]
    + [("kind", name) for name in literals(SideSpec, "kind")],
)
def test_every_option_stands_on_the_page(key, name):
    assert re.search(rf"`{key}\b|\b{key}`", PAGE) or f"{key} =" in PAGE, f"{key} is not documented"
    assert f"`{name}`" in PAGE or f'"{name}"' in PAGE, f"{key} = {name} is not documented"


FOLDER = Path(__file__).parents[2] / "docs"
ROWS = [
    [cell.strip() for cell in line.strip("|").split("|")]
    for line in PAGE.splitlines()
    if line.startswith("|") and "](../figures/" in line
]
"""Of the table of pictures: whose, keys and names, picture."""
CALLED = {
    "SphScene": "the scene", "FluidSpec": "`[liquid]`", "RegionSpec": "`[[fluid]]`", "ParticlesSpec": "particles",
    "TankSpec": "`[tank]`", "SideSpec": "a side", "MotionSpec": "motion", "BaseExcitationSpec": "`[base_excitation]`",
    "CentralForceSpec": "`[central_force]`", "ObstacleSpec": "`[[obstacles]]`", "BodySpec": "`[[bodies]]`",
    "PassiveTracerSpec": "`[[passive_tracers]]`", "GaugeSpec": "`[[gauges]]`", "MethodSpec": "`[method]`",
    "IntegrationSpec": "`[integration]`", "SecondLiquidSpec": "`[second_liquid]`", "BodyMotionSpec": "motion of a body",
    "RollSpec": "`[roll]`",
}  # fmt: skip
"""What the table calls each part of a scene; shapes are a part of regions, obstacles and bodies."""
NAMED = {
    **{
        ("IntegrationSpec" if key == "integrator" else "MethodSpec", key): tuple(names)
        for key, names in FAMILIES.items()
        if key != "kernel"
    },
    ("MethodSpec", "initial_pressure"): literals(MethodSpec, "initial_pressure"),
    ("MethodSpec", "pressure_split"): literals(MethodSpec, "pressure_split"),
    ("RegionSpec", "flow"): literals(RegionSpec, "flow"),
    ("TankSpec", "walls"): literals(TankSpec, "walls"),
    ("SideSpec", "kind"): literals(SideSpec, "kind"),
}
"""Kernels have a figure of their own."""


def pictures(spec, key, name=None):
    """The files that show a key, or one of its names, according to the table."""
    mine = [row for row in ROWS if row[0] == CALLED[spec] and f"`{key}`" in row[1]]
    return [FOLDER / "physics" / re.search(r"\((.*)\)", row[2])[1] for row in mine if not name or f"`{name}`" in row[1]]


USUAL = {field.name for field in dataclasses.fields(Common)}
"""Of every model's scene."""
SPECS = [kind for kind in vars(sph).values() if isinstance(kind, type) and dataclasses.is_dataclass(kind)]


@pytest.mark.parametrize(
    ("spec", "key"),
    [(spec.__name__, field.name) for spec in SPECS for field in dataclasses.fields(spec) if field.name not in USUAL],
)
def test_every_key_stands_on_the_page(spec, key):
    assert re.search(rf"\b{key}\b", PAGE), f"{key} of {spec} is not documented"


@pytest.mark.parametrize(
    ("spec", "key"),
    [(spec.__name__, field.name) for spec in SPECS if spec.__name__ in CALLED for field in dataclasses.fields(spec)
     if field.name not in USUAL],
)  # fmt: skip
def test_every_key_names_its_picture(spec, key):
    assert pictures(spec, key), f"no picture of {key} of {CALLED[spec]}"


@pytest.mark.parametrize(
    ("spec", "key", "name"), [(*place, name) for place, names in NAMED.items() for name in names if name != "automatic"]
)
def test_every_choice_names_its_picture(spec, key, name):
    assert pictures(spec, key, name), f"no picture of {key} = {name}"


def test_every_part_of_a_scene_is_in_the_table_of_pictures():
    assert {spec.__name__ for spec in SPECS} == {*CALLED, "ShapeSpec"}


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row[1][:40])
def test_a_picture_that_the_table_names_is_drawn_and_stands_on_the_page(row):
    name = re.search(r"\(\.\./figures/(.*)\.png\)", row[2])[1]
    assert (FOLDER / "figures" / f"{name}.png").exists()
    assert re.search(rf"!\[.*\]\(\.\./figures/{name}\.png\)", PAGE), f"{name} is not shown"
    assert any(f'"{name}": ' in code.read_text(encoding="utf-8") for code in FOLDER.glob("figures_*.py"))
