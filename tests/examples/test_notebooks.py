"""The example notebooks run from top to bottom, and what they show is the player."""

import ast
import json
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[2] / "examples" / "notebooks"


def run(path):
    """What the cells show: of each that ends with a value, that value."""
    names, shown = {"__name__": "notebook"}, []
    for number, cell in enumerate(json.loads(path.read_text(encoding="utf-8"))["cells"]):
        if cell["cell_type"] == "code":
            tree, where = ast.parse("".join(cell["source"])), f"{path.name}, cell {number}"
            last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
            exec(compile(tree, where, "exec"), names)
            if last is not None:
                shown.append(eval(compile(ast.Expression(last.value), where, "eval"), names))
    return shown


@pytest.mark.compiled
@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.ipynb")), ids=lambda path: path.stem)
def test_a_notebook_runs_and_shows_its_run(path, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    played = [value for value in run(path) if hasattr(value, "_repr_html_")]
    assert len(played) >= 2
    for value in played:
        html = value._repr_html_()
        assert html.startswith("<iframe")
        assert len(html) < 4e6


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.ipynb")), ids=lambda path: path.stem)
def test_a_notebook_is_kept_without_what_it_showed(path):
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    assert not any(cell.get("outputs") or cell.get("execution_count") for cell in cells)
    assert len({cell["id"] for cell in cells}) == len(cells)
