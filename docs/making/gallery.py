"""The page of the gallery, from the scenes in `examples`, some templates, and their clips."""

from __future__ import annotations

import html
import tomllib
from pathlib import Path

from writing import toctree

ROOT = Path(__file__).parents[2]
CLIPS = ROOT / "docs" / "clips"
"""A picture (.webp) and a film (.mp4) of each, drawn by `python docs/clips.py`."""
TEMPLATES = ROOT / "src" / "ecume" / "templates"
FURTHER = ("active-raft", "rifts", "spinners", "surfers")
"""Templates with a clip."""
HEADINGS = {
    "floating": "Floating bodies",
    "tracers": "Tracers",
    "sph": "Liquids (SPH)",
    "soft": "Soft spheres",
}


def cards() -> str:
    """All scenes, model by model."""
    scenes = texts()
    models = {name: str(tomllib.loads(text)["model"]) for name, text in scenes.items()}
    parts = []
    for model, heading in HEADINGS.items():
        inside = "\n".join(card(name, scenes[name]) for name in scenes if models[name] == model)
        parts.append(f'## {heading}\n\n<div class="gallery">\n{inside}\n</div>\n')
    return "\n".join([*parts, toctree(f"gallery/{name}" for name in scenes)])


FRONT = "play"
"""The page that simulates, which the start page shows."""


def front() -> str:
    """The page that simulates in the reader's browser, on the start page."""
    return (
        f'<iframe class="simulated" src="_clips/{FRONT}.html" title="a bowl, a tank and a T1 process, simulated here" '
        'sandbox="allow-scripts allow-downloads"></iframe>'
    )


def write_front(folder: Path) -> None:
    """Write that page."""
    from ecume.show.play.alone import save_text, templates, together

    save_text(together(templates()), folder / f"{FRONT}.html", 1.0)


def pages() -> dict[str, str]:
    """A page for each scene with its text."""
    return {f"gallery/{name}.md": alone(name, text) for name, text in texts().items()}


def texts() -> dict[str, str]:
    """The scenes' files, by name."""
    paths = [*(ROOT / "examples").glob("*.toml"), *(TEMPLATES / f"{name}.toml" for name in FURTHER)]
    return {path.stem: path.read_text(encoding="utf-8") for path in sorted(paths, key=lambda path: path.stem)}


def card(name: str, text: str) -> str:
    """A clip with its title; without a blank line, which would end the HTML block of Markdown."""
    return (
        f'<figure>{clip(name)}<figcaption><strong><a href="gallery/{name}.html">{html.escape(title(text))}</a></strong>'
        f"{html.escape(says(text))}</figcaption></figure>"
    )


def clip(name: str, above: str = "") -> str:
    """The picture is shown before it plays; see `static/films.js`."""
    label = html.escape(f"a film of {name.replace('-', ' ')}")
    file = f"{above}_clips/{name}"
    return (
        f'<video controls loop muted playsinline preload="none" poster="{file}.webp" src="{file}.mp4" '
        f'aria-label="{label}"></video>'
    )


def alone(name: str, text: str) -> str:
    """A scene's own page: clip, what it shows, its file."""
    film = f'<div class="gallery"><figure>{clip(name, "../")}</figure></div>'
    source = f"`ecume new {name}`" if name in FURTHER else f"`examples/{name}.toml`"
    return f"# {title(text)}\n\n{says(text)}\n\n{film}\n\n{source}:\n\n```toml\n{text}```\n"


def title(text: str) -> str:
    """What the scene calls itself."""
    return str(tomllib.loads(text)["title"])


def says(text: str) -> str:
    """What it shows: the comment it begins with."""
    lines = text.split("\n\n", 1)[0].splitlines()
    return " ".join(line.removeprefix("#").strip() for line in lines if line.startswith("#"))
