"""The page on soft spheres names every key of their scenes, and no other."""

import dataclasses
import re
from pathlib import Path

import pytest

from ecume.scenes import soft
from ecume.scenes.common import Common

PAGES = sorted((Path(__file__).parents[2] / "docs" / "physics").glob("soft*.md"))
TABLES = {
    "top level": soft.SoftScene,
    "[liquid]": soft.SoftLiquid,
    "[[particles]]": soft.SphereSpec,
    "[films]": soft.FilmSpec,
    "[long_range_forces]": soft.LongRangeSpec,
    "[cell]": soft.CellSpec,
    "[preparation]": soft.PreparationSpec,
    "[hydrodynamics]": soft.SoftHydrodynamicsSpec,
    "[permeation]": soft.PermeationSpec,
    "[[walls]]": soft.WallSpec,
    "[[protocol]]": soft.StageSpec,
    "[protocol.oscillation]": soft.OscillationSpec,
    "[protocol.rate_steps]": soft.RateStepsSpec,
    "[integration]": soft.IntegrationSpec,
}
"""The tables of a scene, and the part of the schema that each is."""


def keys_told(title):
    """The keys in the row of a table on the page, without explanations in parentheses."""
    lines = [line for page in PAGES for line in page.read_text(encoding="utf-8").splitlines()]
    rows = [line for line in lines if line.startswith("|")]
    (row,) = [line for line in rows if line.split("|")[1].strip(" `") == title]
    output = re.sub(r"\([^()]*\)", "", row.split("|", 2)[2])
    return set(re.findall(r"`(\w+)`", output))


def keys_known(kind):
    common = {field.name for field in dataclasses.fields(Common)} | {"model"}
    nested = {field.name for field in dataclasses.fields(soft.SoftScene)} & {title.strip("[]") for title in TABLES}
    left_out = common | nested if kind is soft.SoftScene else set()
    return {field.name for field in dataclasses.fields(kind)} - left_out


@pytest.mark.parametrize("title", TABLES)
def test_the_row_of_a_table_names_its_keys(title):
    assert keys_told(title) == keys_known(TABLES[title])


def test_no_part_of_a_soft_scene_is_left_out():
    parts = {part for part in vars(soft).values() if dataclasses.is_dataclass(part)}
    assert parts == set(TABLES.values())
