"""The published numbers of floating spheres and menisci."""

import runpy
from pathlib import Path

import pytest

COMPARE = runpy.run_path(str(Path(__file__).parents[2] / "validation" / "flotation" / "compare.py"))


@pytest.fixture(scope="module")
def rows():
    return COMPARE["rows"]()


def test_every_published_number_is_met_within_its_digits(rows):
    assert len(rows) == 188
    off = [row for row in rows if not abs(row[1] - row[2]) <= row[3]]
    assert not off


def test_a_wrong_number_makes_the_comparison_fail(monkeypatch, capsys, rows):
    bad = [(rows[0][0], rows[0][1] + 1.0, *rows[0][2:]), *rows[1:]]
    monkeypatch.setitem(COMPARE["main"].__globals__, "rows", lambda: bad)
    assert COMPARE["main"]() == 1
    assert "OFF" in capsys.readouterr().out
