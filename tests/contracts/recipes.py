"""A copy of the package that is changed as CONTRIBUTING says."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]


def block(name: str) -> str:
    """A block of code of the page."""
    page = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    (found,) = re.findall(rf"```python {name}\n(.*?)```", page, re.DOTALL)
    return str(found)


class Copy:
    """A copy of the package and of what its tests need."""

    def __init__(self, folder: Path, parts: tuple[str, ...] = ("src",)) -> None:
        self.folder, self.changed = folder, set[Path]()
        for part in parts:
            left_out = shutil.ignore_patterns("__pycache__", "*.png", "*.mp4")
            shutil.copytree(ROOT / part, folder / part, ignore=left_out)
        shutil.copy(ROOT / "pyproject.toml", folder)

    def edit(self, file: str, where: str, anchor: str, text: str) -> None:
        """Put text before or after the only line of a file that begins with the anchor, or at the end."""
        path = self.folder / "src" / "ecume" / file
        lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
        place = len(lines)
        if where != "end":
            (found,) = [number for number, line in enumerate(lines) if line.startswith(anchor)]
            place = found + (where == "after")
        path.write_text("".join([*lines[:place], text, *lines[place:]]), encoding="utf-8")
        self.changed.add(path)

    def write(self, file: str, text: str) -> None:
        """Add a file to the package."""
        path = self.folder / "src" / "ecume" / file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")

    def python(self, *arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
        """What a process of its own makes of the copy."""
        places = {"PYTHONPATH": os.pathsep.join([str(self.folder / "src"), str(self.folder)])}
        asked = {**os.environ, **places, **environment}
        return subprocess.run([sys.executable, *arguments], cwd=self.folder, env=asked, capture_output=True, text=True)

    def printed(self, program: str, **environment: str) -> list[str]:
        """The lines that a program prints."""
        done = self.python("-c", program, **environment)
        assert done.returncode == 0, done.stderr
        return done.stdout.splitlines()
