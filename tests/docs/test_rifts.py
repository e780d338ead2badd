"""The page on rifts in rafts agrees with the recorded numbers."""

import csv
import importlib.util
import re
from pathlib import Path

import numpy as np
import pytest

DOCS = Path(__file__).parents[2] / "docs"
ROW = re.compile(r"^\| ([\d.]+) \| ([\d.]+) \| ([\d.]+) \| ([\d.]+) \| ([\d.]+) \|$", re.MULTILINE)


@pytest.fixture(scope="module")
def study():
    spec = importlib.util.spec_from_file_location("rifts", DOCS / "studies" / "rifts.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_table_of_the_page_is_what_was_recorded(study):
    with study.RECORDED.open(newline="", encoding="utf-8") as table:
        rows = list(csv.DictReader(table))
    assert len(rows) == len(study.INTERACTIONS) * len(study.RATES) * len(study.SEEDS)
    output = ROW.findall((DOCS / "rifts-in-rafts.md").read_text(encoding="utf-8"))
    assert [float(cells[0]) for cells in output] == list(study.RATES)
    for rate, *cells in output:
        found = []
        for name in study.INTERACTIONS:
            some = [row for row in rows if row["interaction"] == name and float(row["rate"]) == float(rate)]
            beads = study.LENGTH * study.WIDTH * len(some) / sum(int(row["clusters"]) for row in some)
            found += [np.mean([float(row["cluster_length"]) for row in some]), beads]
        assert [float(cell) for cell in cells] == pytest.approx(found, rel=0.02)


def test_faster_pulls_separate_more_beads_and_the_flow_keeps_them_together(study):
    recorded = study.recorded()
    alone, together = ([np.mean(recorded[name][rate]) for rate in study.RATES] for name in study.INTERACTIONS)
    assert all(np.diff(together[1:]) < 0.0)
    assert all(np.diff(alone[1:]) < 0.0)
    assert together[2] > 2.0 * alone[2]
    assert together[1] > study.LENGTH
