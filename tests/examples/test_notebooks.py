"""The example notebooks run from top to bottom and show the player."""

import importlib
import json
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[2] / "examples" / "notebooks"


@pytest.fixture
def notebooks(monkeypatch):
    """The maker of their pages, which executes them."""
    monkeypatch.syspath_prepend(FOLDER.parents[1] / "docs" / "making")
    return importlib.import_module("notebooks")


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.ipynb")), ids=lambda path: path.stem)
def test_a_notebook_runs_and_shows_its_run(path, tmp_path, monkeypatch, notebooks):
    """The page has a player for each value with a notebook view, and the output of the cells."""
    monkeypatch.chdir(tmp_path)
    outputs = list(notebooks.executed(path))
    played = [value for _, value in outputs if hasattr(value, "_repr_html_")]
    assert len(played) >= 2
    text, *players = notebooks.page(path, outputs).items()
    assert len(players) == len(played) == text[1].count("<iframe")
    for name, player in players:
        assert f'src="../{name}"' in text[1]
        assert player.lstrip().startswith("<!doctype html>")
        assert len(player) < 4e6
    written = [one for one in outputs if one.printed or not (one.value is None or hasattr(one.value, "_repr_html_"))]
    assert text[1].count("```text") == len(written) > 0


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.ipynb")), ids=lambda path: path.stem)
def test_a_notebook_is_kept_without_what_it_showed(path):
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    assert not any(cell.get("outputs") or cell.get("execution_count") for cell in cells)
    assert len({cell["id"] for cell in cells}) == len(cells)
