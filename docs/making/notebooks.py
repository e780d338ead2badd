"""The example notebooks as pages."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from writing import toctree

INTRODUCTION = """
In `examples/notebooks`; a test runs their cells. Frames, trajectories and runs show themselves: the last line of a cell
is enough.
"""
FOLDER = Path(__file__).parents[2] / "examples" / "notebooks"


def pages() -> dict[str, str]:
    """A page for each notebook, and one that leads to them."""
    paths = sorted(FOLDER.glob("*.ipynb"))
    found = {f"tutorials/notebook-{path.stem}.md": page(path) for path in paths}
    below = toctree((f"notebook-{path.stem}" for path in paths), hidden=False)
    return {"tutorials/notebooks.md": f"# Notebooks\n{INTRODUCTION}\n{below}", **found}


def page(path: Path) -> str:
    """Text as it is, code in blocks."""
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    return "\n\n".join(map(_cell, cells)) + f"\n\n`examples/notebooks/{path.name}`\n"


def _cell(cell: dict[str, Any]) -> str:
    text = "".join(cell["source"])
    return text if cell["cell_type"] == "markdown" else f"```python\n{text}\n```"
