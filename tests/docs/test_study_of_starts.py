"""The page on the onset of flow of packings under stress agrees with the recorded numbers."""

import importlib.util
import re
from pathlib import Path

import numpy as np
from scipy.stats import linregress

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


def heights():
    """The recorded starts over the height: pairs of rows with and without permeation."""
    whole = {(row["spheres"], row["seed"], row["permeation"]): row for row in study("permeation_sizes").recorded()}
    return [(row, whole[spheres, seed, 0]) for (spheres, seed, passes), row in sorted(whole.items()) if passes]


def start(row, half):
    """The start of a half of a packing, in the format of the page."""
    return f"{row[half]:g} s" if row[half] < row["until"] + 1e-9 else f"not within {row['until']:g} s"


def test_the_table_of_heights_is_what_was_recorded():
    expected = [
        f"| {held['spheres']:g} | {held['seed']:g} | {held['height']:.1f} | {held['fraction']:.3f} "
        f"| {start(held, 'upper')} | {start(free, 'upper')} | {start(held, 'lower')} | {start(free, 'lower')} "
        f"| {100.0 * held['rise']:.1f} % |"
        for held, free in heights()
    ]
    assert len(expected) >= 5
    assert "\n".join(expected) in PAGE.read_text(encoding="utf-8")


def test_permeation_holds_the_lower_halves_of_prepared_packings_longer_than_films_do():
    assert all(min(held["lower"], held["until"]) > 2.0 * free["lower"] for held, free in heights())


def test_the_power_of_the_height_is_that_of_the_recorded_packings():
    held = [row for row, _ in heights()]
    fit = linregress(np.log([row["height"] for row in held]), np.log([row["lower"] for row in held]))
    said_so = f"power {fit.slope:.1f} ± {fit.stderr:.1f} of the height (standard error; a fit to the seven)"
    assert len(held) == 7
    assert said_so in PAGE.read_text(encoding="utf-8")
