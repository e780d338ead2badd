"""The page on the onset of flow of packings under stress agrees with the recorded numbers."""

import importlib.util
import re
from pathlib import Path

DOCS = Path(__file__).parents[2] / "docs"
PAGE = DOCS / "physics" / "soft-permeation.md"
ROW = re.compile(r"^\| (0\.\d+) \| (\d) \| ([\d.]+ s|none) \| ([\d.]+ s|none) \|$", re.MULTILINE)


def study(name="permeation"):
    spec = importlib.util.spec_from_file_location("permeation_study", DOCS / "studies" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def said(time, longest):
    """A time in the format of the page."""
    return "none" if time >= longest else f"{time:g} s"


def test_the_table_of_the_page_is_what_was_recorded():
    module = study()
    expected = [
        (f"{row['volume_fraction']:g}", f"{row['seed']:g}",
         said(row["permeating"], module.LONGEST), said(row["free"], module.LONGEST))
        for row in module.recorded()
    ]  # fmt: skip
    assert ROW.findall(PAGE.read_text(encoding="utf-8")) == expected


def test_loose_packings_start_earlier_with_permeation_and_the_densest_later():
    rows = study().recorded()
    assert all(row["permeating"] <= row["free"] for row in rows if row["volume_fraction"] <= 0.76)
    dense = [row for row in rows if row["volume_fraction"] == 0.79]
    assert len(dense) == 3
    assert all(row["permeating"] > 2.0 * row["free"] for row in dense)


def test_the_table_of_heights_is_what_was_recorded():
    rows = study("permeation_sizes").recorded()
    whole = {(row["spheres"], row["seed"], row["permeation"]): row for row in rows}
    expected = [
        f"| {spheres:g} | {row['height']:.1f} | {seed:g} | {max(row['upper'], row['lower']):g} s "
        f"| {max(free['upper'], free['lower']):g} s | {row['suction']:.1f} |"
        for spheres in (30, 60)
        for seed in (1, 2, 3)
        if (row := whole.get((spheres, seed, 1))) and (free := whole.get((spheres, seed, 0)))
    ]
    assert len(expected) == 5
    assert "\n".join(expected) in PAGE.read_text(encoding="utf-8")
