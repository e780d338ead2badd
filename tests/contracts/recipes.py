"""A copy of the package, changed according to the recipes in docs/extend."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]


RECIPES = ROOT / "docs" / "extend"


def page_of(name: str) -> str:
    """The text of the page that contains a block."""
    texts = [page.read_text(encoding="utf-8") for page in sorted(RECIPES.glob("*.md"))]
    (found,) = [text for text in texts if re.search(rf"```(?:python|text) {name}\n", text)]
    return found


def block(name: str) -> str:
    """A block of code of a recipe."""
    (found,) = re.findall(rf"```(?:python|text) {name}\n(.*?)```", page_of(name), re.DOTALL)
    return str(found)


def place_of(name: str) -> tuple[str, str]:
    """The position according to the text before a block: above a line, last in a table, or at the end of the file."""
    text = re.split(rf"```(?:python|text) {name}\n", page_of(name))[0].rpartition("```")[2]
    found = re.findall(r"(above|end\s+of)\s+(?:`([^`]+)`|the\s+file)", text, re.IGNORECASE)
    assert found, f"the text before {name} does not say where it goes"
    where, anchor = found[-1]
    if not anchor:
        return "end", ""
    return ("before" if where.lower() == "above" else "last in"), anchor


class Copy:
    """A copy of the package and of the files that its tests need."""

    def __init__(self, folder: Path, parts: tuple[str, ...] = ("src",)) -> None:
        self.folder, self.changed = folder, set[Path]()
        for part in parts:
            left_out = shutil.ignore_patterns("__pycache__", "*.png", "*.mp4")
            shutil.copytree(ROOT / part, folder / part, ignore=left_out)
        shutil.copy(ROOT / "pyproject.toml", folder)

    def edit(self, file: str, where: str, anchor: str, text: str) -> None:
        """Insert text before the only line that begins with the anchor, as the last row of the table there, or at the
        end.
        """
        path = self.folder / "src" / "ecume" / file
        lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
        place = len(lines)
        if where != "end":
            (place,) = [
                number for number, line in enumerate(lines) if re.match(rf"\s*{re.escape(anchor)}(?![\w\[])", line)
            ]
        while where == "before" and place > 0 and lines[place - 1].startswith("@"):  # a class with its decorators
            place -= 1
        if where == "last in":
            place = next(number for number in range(place, len(lines)) if lines[number].startswith(("}", ")")))
        path.write_text("".join([*lines[:place], text, *lines[place:]]), encoding="utf-8")
        self.changed.add(path)

    def follow(self, file: str, name: str) -> None:
        """Insert a block of a recipe at the position according to the text before it."""
        where, anchor = place_of(name)
        self.edit(file, where, anchor, block(name) + "\n\n" * (where == "before"))

    def write(self, file: str, text: str) -> None:
        """Add a file to the package."""
        path = self.folder / "src" / "ecume" / file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")

    def python(self, *arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
        """The result of a separate process that uses the copy."""
        places = {"PYTHONPATH": os.pathsep.join([str(self.folder / "src"), str(self.folder)])}
        asked = {**os.environ, **places, **environment}
        return subprocess.run([sys.executable, *arguments], cwd=self.folder, env=asked, capture_output=True, text=True)

    def printed(self, program: str, **environment: str) -> list[str]:
        """The lines that a program prints."""
        done = self.python("-c", program, **environment)
        assert done.returncode == 0, done.stderr
        return done.stdout.splitlines()
