"""The scenes that come with the package."""

from __future__ import annotations

from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path

from ecume.errors import BadInput
from ecume.scenes.faults import suggestion


def templates() -> dict[str, str]:
    """Each template's name, and its first line: what it shows."""
    found = {item.name.removesuffix(".toml"): item for item in _folder().iterdir() if item.name.endswith(".toml")}
    return {name: _first_line(found[name]) for name in sorted(found)}


def copy_template(name: str, to: Path) -> list[Path]:
    """Write a template and the table it reads, if any, side by side; nothing is overwritten. The files written."""
    if name not in templates():
        raise BadInput(f"there is no template {name!r}; {suggestion(name, templates())}")
    table = _folder() / f"{name}.csv"
    texts = {to: (_folder() / f"{name}.toml").read_text(encoding="utf-8")}
    if table.is_file():
        texts[to.with_name(table.name)] = table.read_text(encoding="utf-8")
    for path in texts:
        if path.exists():
            raise BadInput(f"{path} exists already; name another file with -o")
    for path, text in texts.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8", newline="\n")
    return list(texts)


def _folder() -> Traversable:
    return files("ecume") / "templates"


def _first_line(item: Traversable) -> str:
    return item.read_text(encoding="utf-8").split("\n", 1)[0].removeprefix("#").strip()
