"""The copy of the checkout in which faults are tried: the user's own files are never touched."""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
from collections.abc import Iterable
from pathlib import Path

ROOT = Path(__file__).parents[2]


class Tree:
    """A copy of the files that git knows and of those that it does not ignore, with its own cache of compiled code."""

    def __init__(self, folder: Path, root: Path = ROOT, package: str = "src/ecume") -> None:
        self.folder, self._root = folder.absolute() / "tree", root
        self.package = self.folder / package
        self.beside = folder.absolute()
        self._cache = self.beside / "cache" / "compiled"
        self._clean: dict[Path, bytes] = {}
        self._kept: set[str] = set()

    def update(self) -> None:
        """Make the copy what the checkout is now."""
        words = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
        listed = subprocess.run(words, cwd=self._root, capture_output=True, check=True).stdout
        wanted = {Path(os.fsdecode(name)) for name in listed.split(b"\0") if name}
        wanted = {path for path in wanted if (self._root / path).is_file()}
        present = [path for path in self.folder.rglob("*") if path.is_file()]
        for path in present:
            if path.relative_to(self.folder) not in wanted:
                path.unlink()
        for path in wanted:
            source, target = self._root / path, self.folder / path
            if not target.is_file() or target.read_bytes() != source.read_bytes():
                target.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(source, target)
        self._cache.mkdir(parents=True, exist_ok=True, mode=0o700)
        self._take_compiled()

    def write(self, path: str, text: str) -> None:
        """Change a file of the package until `restore`."""
        file = self.package / path
        if not self._clean:
            self._kept = {path.name for path in self._cache.iterdir()}
        self._clean.setdefault(file, file.read_bytes())
        file.write_text(text, encoding="utf-8")

    def restore(self) -> None:
        """Undo all changes, and delete the code that was compiled with them."""
        for file, data in self._clean.items():
            file.write_bytes(data)
        self._clean.clear()
        for path in self._cache.iterdir():
            if path.name not in self._kept:
                path.unlink(missing_ok=True)

    def environment(self, **more: str) -> dict[str, str]:
        """Of processes that run the copy."""
        places = [self.package.parent, self.folder, Path(__file__).parent]
        paths = {"PYTHONPATH": os.pathsep.join(map(str, places)), "MUTATION_PACKAGE": str(self.package)}
        quiet = {"ECUME_CACHE_DIR": str(self._cache.parent), "PYTHONDONTWRITEBYTECODE": "1"}
        return {**os.environ, **paths, **quiet, **more}

    def commit(self) -> str:
        """The checkout's last commit."""
        words = ["git", "rev-parse", "--short", "HEAD"]
        return subprocess.run(words, cwd=self._root, capture_output=True, text=True).stdout.strip()

    def digest(self, folders: Iterable[str]) -> str:
        """Changes with every change of the package, or of some folders."""
        found = hashlib.sha256()
        for folder in [self.package, *(self.folder / folder for folder in folders)]:
            for path in sorted(folder.rglob("*.py")):
                found.update(path.relative_to(self.folder).as_posix().encode() + b"\0" + path.read_bytes())
        return found.hexdigest()[:12]

    def _take_compiled(self) -> None:
        """Copy what the tests have compiled already; what is of other text is not found."""
        asked = os.environ.get("ECUME_CACHE_DIR")
        there = (Path(asked) if asked else self._root / ".venv" / "compiled") / "compiled"
        for path in there.glob("*.code"):
            if not (self._cache / path.name).exists():
                shutil.copy(path, self._cache)
