"""The recorded delays under stress are at equal volume fractions, and the page describes them correctly."""

import importlib.util
import math
import re
from pathlib import Path

import numpy as np
import pytest

from ecume.laws.soft_pair import SoftPair, passage_time

DOCS = Path(__file__).parents[2] / "docs"


@pytest.fixture(scope="module")
def study():
    spec = importlib.util.spec_from_file_location("study", DOCS / "studies" / "delay_under_stress.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def rows(study):
    return study.recorded()


def test_each_seed_was_stressed_at_each_age(study, rows):
    assert [(row["seed"], row["age"]) for row in rows] == [(seed, age) for seed in study.SEEDS for age in study.AGES]


def test_volume_fractions_are_equal_and_gaps_are_not(rows):
    assert max(row["volume_fraction"] for row in rows) - min(row["volume_fraction"] for row in rows) < 2e-4
    gaps = [row["mean_gap"] for row in rows]
    assert max(gaps) > 8.0 * min(gaps)


def test_recorded_separation_times_are_those_of_the_closed_form(rows):
    pair = SoftPair(1.2e-3, 1e4, 1.0)
    for row in rows:
        time = passage_time(pair, 2.4e-3 * row["shear_stress"], row["mean_gap"], 1.2e-3)
        assert row["separation_time"] == pytest.approx(time, rel=1e-4)


ROW = re.compile(r"^\| (\d+) s \| ([\d.]+) µm \| ([\d.]+) s \|((?: [\d.]+ ± [\d.]+ s \|){3})$", re.MULTILINE)


def test_the_table_of_the_page_is_what_was_recorded(study, rows):
    output = ROW.findall((DOCS / "delay-under-stress.md").read_text(encoding="utf-8"))
    assert len(output) == len(study.AGES)
    for age, gap, part, cells in output:
        some = [row for row in rows if row["age"] == float(age)]
        assert float(gap) == pytest.approx(1e6 * study.geometric_mean(some, "mean_gap").value, rel=0.02)
        assert float(part) == pytest.approx(study.geometric_mean(some, "separation_time").value, rel=0.02)
        for strain, cell in zip(study.STRAINS, re.findall(r"([\d.]+) ± ([\d.]+) s", cells), strict=True):
            mean = study.geometric_mean(some, f"delay_{strain:.2f}")
            assert float(cell[0]) == pytest.approx(mean.value, rel=0.02)
            assert float(cell[1]) == pytest.approx(mean.value * math.expm1(mean.error), rel=0.1)


def test_delays_grow_as_the_time_to_part_two_spheres_does(study, rows):
    for strain in study.STRAINS:
        ratio = np.log([row[f"delay_{strain:.2f}"] / row["separation_time"] for row in rows])
        part = np.log([row["separation_time"] for row in rows])
        assert np.polyfit(part, ratio + part, 1)[0] == pytest.approx(1.0, abs=0.2)
        assert ratio.std() < 0.15 * np.ptp(part)
