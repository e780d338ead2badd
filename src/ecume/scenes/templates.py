"""The scenes and sweeps that are part of the package."""

from __future__ import annotations

from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path

from ecume.errors import BadInput
from ecume.scenes.faults import suggestion
from ecume.trajectories.records import storing, write_whole


def templates() -> dict[str, str]:
    """The name of each scene, with its first line, which describes it."""
    return _first_lines(folder())


def sweep_templates() -> dict[str, str]:
    """The name of each sweep, with its first line, which describes it."""
    return _first_lines(folder() / "sweeps")


MODELS = {"floating": "Floats", "sph": "Liquids in tanks", "soft": "Soft spheres", "tracers": "Tracers"}
"""The heading of the templates of each model."""


def by_model() -> dict[str, dict[str, str]]:
    """The scenes of each model."""
    scenes = templates()
    models = {name: _model_of((folder() / f"{name}.toml").read_text(encoding="utf-8")) for name in scenes}
    return {
        heading: {name: says for name, says in scenes.items() if models[name] == model}
        for model, heading in MODELS.items()
    }


def _model_of(text: str) -> str:
    return next(line.split('"')[1] for line in text.splitlines() if line.startswith("model"))


def copy_template(name: str, to: Path) -> list[Path]:
    """Write a template, and the table or field that belongs to it, into a folder, without overwriting; return the
    files.
    """
    known = templates() | sweep_templates()
    if name not in known:
        near = suggestion(name, known)
        raise BadInput(f"no template {name!r}; {near if 'mean' in near else '`ecume new` lists them'}")
    home = folder() / "sweeps" if name in sweep_templates() else folder()
    contents = {to: (home / f"{name}.toml").read_bytes()}
    for beside in (home / f"{name}{suffix}" for suffix in BESIDE):
        if beside.is_file():
            contents[to.with_name(beside.name)] = beside.read_bytes()
    for path in contents:
        if path.exists():
            raise BadInput(f"{path} exists already; name another file with -o")
    _write_all(contents)
    return list(contents)


def _write_all(contents: dict[Path, bytes]) -> None:
    """Write all files, or none if one of them fails."""
    done: list[Path] = []
    try:
        for path, content in contents.items():
            with storing(path):
                path.parent.mkdir(parents=True, exist_ok=True)
            write_whole(path, content)
            done.append(path)
    except BaseException:
        for path in done:
            path.unlink(missing_ok=True)
        raise


BESIDE = (".csv", ".nc", ".npz")
"""Files that belong to a template: tables of particles, and fields."""


def folder() -> Traversable:
    """The folder of the templates."""
    return files("ecume") / "templates"


def _first_lines(home: Traversable) -> dict[str, str]:
    found = {item.name.removesuffix(".toml"): item for item in home.iterdir() if item.name.endswith(".toml")}
    return {name: _first_line(found[name]) for name in sorted(found)}


def _first_line(item: Traversable) -> str:
    return item.read_text(encoding="utf-8").split("\n", 1)[0].removeprefix("#").strip()
