"""The example notebooks as pages, with the output of their cells."""

from __future__ import annotations

import ast
import contextlib
import html
import io
import json
import os
import re
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from writing import toctree

INTRODUCTION = """
In `examples/notebooks`, with the outputs of their cells; open them with Jupyter (`pip install jupyter`). Frames,
trajectories and runs show themselves: the last line of a cell is enough.
"""
FOLDER = Path(__file__).parents[2] / "examples" / "notebooks"
PLAYERS = "_players"
"""The folder of the site for what cells show; a page of its own each, which is fetched when it is scrolled to."""
CONTENT = re.compile(r'srcdoc="([^"]*)"')


class Output(NamedTuple):
    """What a cell printed, and the value of its last line; None without one."""

    printed: str
    value: Any


def cells_of(path: Path) -> list[dict[str, Any]]:
    """The cells of a notebook."""
    cells: list[dict[str, Any]] = json.loads(path.read_text(encoding="utf-8"))["cells"]
    return cells


def executed(path: Path) -> Iterator[Output]:
    """The output of each cell of code, executed from top to bottom in the present folder."""
    names = {"__name__": "notebook"}
    for number, cell in enumerate(cells_of(path)):
        if cell["cell_type"] != "code":
            continue
        tree, where = ast.parse("".join(cell["source"])), f"{path.name}, cell {number}"
        last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
        value = None
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            exec(compile(tree, where, "exec"), names)  # noqa: S102  (the notebooks of this repository)
            if last is not None:
                value = eval(compile(ast.Expression(last.value), where, "eval"), names)  # noqa: S307
        yield Output(printed.getvalue(), value)


def pages() -> dict[str, str]:
    """A page for each notebook, one that leads to them, and the players that they show."""
    paths = sorted(FOLDER.glob("*.ipynb"))
    found: dict[str, str] = {}
    for path in paths:
        with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
            outputs = list(executed(path))
            found |= page(path, outputs)
    below = toctree((f"notebook-{path.stem}" for path in paths), hidden=False)
    return {"tutorials/notebooks.md": f"# Notebooks\n{INTRODUCTION}\n{below}", **found}


def page(path: Path, outputs: list[Output]) -> dict[str, str]:
    """Text as it is, code in blocks, outputs below; players are files beside the pages."""
    left, players, parts = iter(outputs), dict[str, str](), []
    for cell in cells_of(path):
        text = "".join(cell["source"])
        if cell["cell_type"] == "markdown":
            parts.append(text)
            continue
        output = next(left)
        parts.append(f"```python\n{text}\n```")
        shown = getattr(output.value, "_repr_html_", lambda: None)()
        if output.printed or (output.value is not None and not shown):
            value = "" if output.value is None or shown else repr(output.value)
            parts.append(f"```text\n{output.printed}{value}".rstrip() + "\n```")
        if shown and (content := CONTENT.search(shown)):
            name = f"{PLAYERS}/{path.stem}-{len(players)}.html"
            players[name] = html.unescape(content[1])
            parts.append(framed(f"{os.path.relpath(name, 'tutorials')}", path.stem))
    parts.append(f"`examples/notebooks/{path.name}`\n")
    return {f"tutorials/notebook-{path.stem}.md": "\n\n".join(parts), **players}


def framed(place: str, name: str) -> str:
    """A player in the page; it may run its own script and nothing else."""
    label = html.escape(f"the run of {name.replace('-', ' ')}, to play and to turn")
    return f'<iframe class="player" title="{label}" sandbox="allow-scripts" loading="lazy" src="{place}"></iframe>'
