"""The documentation is correct: its code runs, its links are valid, its options and papers exist."""

import contextlib
import dataclasses
import functools
import io
import math
import re
import tomllib
import typing
from pathlib import Path
from urllib.parse import unquote

import pytest

from ecume.cli import app
from ecume.engine.linear_solvers.solvers import SOLVERS
from ecume.laws import flotation, immersion
from ecume.laws.capillarity import truncation_radius
from ecume.laws.friction import FRICTIONS
from ecume.laws.interfaces import INTERFACES
from ecume.laws.long_range import REMOTE
from ecume.laws.soft_pair import PREFACTORS
from ecume.laws.surfaces import SURFACES
from ecume.models import MODELS
from ecume.models.soft.integration.dirk_schemes import SCHEMES
from ecume.scenes import fields, floating
from ecume.scenes.floating.sources import SOURCES
from ecume.scenes.load import load_scene
from ecume.scenes.schema import SCENES
from ecume.units import Unit

pytestmark = pytest.mark.sampled(2)

ROOT = Path(__file__).parents[2]
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])
PHYSICS = ROOT / "docs" / "physics"
SECTIONS = {
    "scene": floating.FloatingScene,
    "[liquid]": floating.LiquidSpec,
    "[flow]": floating.FlowSpec,
    "[flow.nodes]": floating.NodesSpec,
    "[flow.field]": fields.FieldSpec,
    "[[particles]]": floating.FloatSpec,
    "[particles.surface_energies]": floating.SurfaceEnergies,
    "[particles.disc]": floating.DiscSpec,
    "[particles.shape]": floating.ShapeSpec,
    "[[rows]]": floating.FloatRow,
    "[dish]": floating.DishSpec,
    "[dish.motion]": floating.DishMotionSpec,
    "[dish.tilt]": floating.DishTiltSpec,
    "[cell]": floating.CellSpec,
    "[integration]": floating.IntegrationSpec,
    "[hydrodynamics]": floating.HydrodynamicsSpec,
    "[hydrodynamics.lubrication]": floating.LubricationSpec,
    "[activity]": floating.ActivitySpec,
    "[magnetic_field]": floating.MagneticFieldSpec,
    "[waves]": floating.WavesSpec,
    "[[waves.sources]]": floating.WaveSourceSpec,
    "[dish.barrier]": floating.BarrierSpec,
    "[surfactant]": floating.SurfactantSpec,
    "[[surfactant.sources]]": floating.SurfactantSourceSpec,
    "[[surfactant.drops]]": floating.SurfactantDropSpec,
    "[contacts]": floating.ContactSpec,
    "[interaction]": floating.InteractionSpec,
}
"""The tables of options, and the part of the schema that each describes."""
READ = {"contact_angle": "rad", "temperature": "K"}
"""Units of values that the schema reads itself: an angle or a name, kelvin or degrees Celsius."""


def physics(model):
    """The pages about the physics of a model, one after the other."""
    pages = sorted(PHYSICS.glob(f"{model}*.md"))
    return "\n".join(page.read_text(encoding="utf-8") for page in pages)


def name_of(page):
    return page.relative_to(ROOT).as_posix()


each_page = pytest.mark.parametrize("page", PAGES, ids=name_of)


def blocks(page, language):
    """The fenced blocks of a language; blocks marked `no-run` are only shown."""
    return re.findall(rf"^```{language}\n(.*?)^```", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)


def prose(page):
    """A page without its blocks of code."""
    return re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)


@pytest.fixture
def beside_a_run(tmp_path, monkeypatch):
    """A folder with the files that examples name: the cereal bowl and its run, both short."""
    from ecume.run import run
    from ecume.scenes.templates import copy_template

    monkeypatch.chdir(tmp_path)
    (scene,) = copy_template("cereal-bowl", Path("cereal-bowl.toml"))
    text = scene.read_text(encoding="utf-8")
    short = re.sub(r"^(duration|frame_every) = .*$", r'\1 = "50 ms"', text, flags=re.MULTILINE)
    scene.write_text(short, encoding="utf-8")
    run(load_scene(scene), "bowl")


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.usefixtures("beside_a_run")
@pytest.mark.parametrize("page", [page for page in PAGES if blocks(page, "python")], ids=name_of)
def test_the_python_of_a_page_runs(page):
    for name, scene in scenes_of(page).items():
        Path(name).write_text(scene, encoding="utf-8")
    names = {"__name__": "page"}
    for number, (code, shown) in enumerate(zip(blocks(page, "python"), outputs(page), strict=True)):
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile(code, f"{page.name}, block {number}", "exec"), names)
        assert shown in ("", printed.getvalue()), f"output of block {number}"


def outputs(page):
    """The output below each block of Python on a page; empty if the page shows none."""
    text = page.read_text(encoding="utf-8")
    return re.findall(r"^```python\n.*?^```(?:\n\n```text\n(.*?)^```)?", text, re.MULTILINE | re.DOTALL)


def scenes_of(page):
    """The scenes that a page assigns to file names, in a comment at their top."""
    named = ((re.match(r"# ([\w-]+\.toml)\n", text), text) for text in blocks(page, "toml"))
    return {match[1]: text for match, text in named if match}


def test_the_start_page_shows_the_table_of_check():
    page = ROOT / "docs" / "start.md"
    scene = load_scene(next(text for text in blocks(page, "toml") if text.splitlines()[0].endswith("# mine.toml")))
    rows = {" ".join(" ".join(row).split()) for row in MODELS[scene.model].summary(scene)}
    (shown,) = (text for text in blocks(page, "text") if text.startswith("quantity"))
    assert {" ".join(line.split()) for line in shown.splitlines()[1:]} <= rows


@each_page
def test_the_scenes_of_a_page_are_scenes(page):
    for text in blocks(page, "toml"):
        if "model" in tomllib.loads(text):
            assert load_scene(text)


@each_page
def test_the_links_of_a_page_lead_somewhere(page):
    for target in re.findall(r"\]\(([^)\s]+)\)", prose(page)):
        if re.match(r"[a-z]+:", target):
            continue
        path, _, anchor = target.partition("#")
        file = (page.parent / unquote(path)).resolve() if path else page
        assert file.exists(), target
        assert not anchor or anchor in anchors(file), target


def anchors(page):
    """The anchors of the headings of a page."""
    headings = re.findall(r"^#+ (.*)$", prose(page), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@each_page
def test_the_papers_of_a_page_are_in_the_bibliography(page):
    known = re.findall(r"^@\w+\{(\w+),", (ROOT / "src/ecume/references.bib").read_text(encoding="utf-8"), re.MULTILINE)
    cited = {key for group in re.findall(r"\[([^\]]*)\]", prose(page)) for key in re.findall(r"\b[a-z]+\d{4}\b", group)}
    assert cited <= set(known)


def part_of(kind, name):
    """The table of a scene with this name at its top, if there is one."""
    hint = typing.get_type_hints(kind).get(name)
    return next((each for each in (hint, *typing.get_args(hint)) if dataclasses.is_dataclass(each)), None)


@each_page
def test_every_option_that_a_page_names_exists(page):
    parts = [{title.strip("[]"): kind for title, kind in SECTIONS.items() if title != "scene"}]
    parts += [{name: part_of(kind, name) for name in parts[0]} for kind in SCENES.values()]
    named = re.findall(r"`(\w+)(?:\[\d+\])?\.(\w+)(?: = [^`]*)?`", prose(page))
    for part, key in named:
        kinds = [found[part] for found in parts if found.get(part) is not None]
        known = {field.name for kind in kinds for field in dataclasses.fields(kind)}
        assert not kinds or key in known, f"{part}.{key}"


def test_the_scene_of_the_readme_is_the_template():
    (text,) = blocks(ROOT / "README.md", "toml")
    shown, template = load_scene(text), load_scene(ROOT / "src" / "ecume" / "templates" / "cereal-bowl.toml")
    looks = {"name": shown.particles[0].name, "color": None}
    bare = [dataclasses.replace(species, **looks) for species in template.particles]
    assert dataclasses.replace(template, title="", particles=tuple(bare)) == shown


@functools.cache
def files_of_ours():
    """All Python files, each as "/path". The root itself is not searched, since other tests create and remove files
    there.
    """
    folders = ("benchmarks", "docs", "examples", "src", "tests")
    return [f"/{path.relative_to(ROOT).as_posix()}" for name in folders for path in (ROOT / name).rglob("*.py")]


@each_page
def test_every_file_of_ours_that_a_page_names_exists(page):
    for path in re.findall(r"`([\w/]+\.py)`", prose(page)):
        if "mine" not in path:
            assert [found for found in files_of_ours() if found.endswith(f"/{path}")], path


@each_page
def test_every_command_that_a_page_names_exists(page):
    verbs = {command.name or command.callback.__name__ for command in app.registered_commands}
    text = "\n".join([*blocks(page, "sh"), *re.findall(r"`(ecume [^`]*)`", prose(page))])
    assert set(re.findall(r"^(?:\$ )?ecume (\w+)", text, re.MULTILINE)) <= verbs


def unit_of(hint):
    """The unit contained in an annotation."""
    units = [extra.symbol for extra in getattr(hint, "__metadata__", ()) if isinstance(extra, Unit)]
    return next((found for found in [*units, *map(unit_of, typing.get_args(hint))] if found), "")


def facts(kind):
    """The required facts on each key in a table of options: its name, unit and default."""
    hints = typing.get_type_hints(kind, include_extras=True)
    for field in dataclasses.fields(kind):
        unit = unit_of(hints[field.name]) or READ.get(field.name, "")
        yield field.name, "–" if unit in ("", "1") else unit, written(field.default)


def written(default):
    if default is dataclasses.MISSING:
        return "needed"
    if default is None or default in ("", ()) or dataclasses.is_dataclass(default):
        return "–"
    if isinstance(default, bool):
        return str(default).lower()
    if isinstance(default, tuple):
        return str(list(default))
    return f"`{default}`" if isinstance(default, str) else f"{default:.5g}"


def rows_below(title):
    """The first three cells of a table's rows below a heading of the pages on floating."""
    heading = "## Top level" if title == "scene" else f"## `{title}`"
    section = re.split(r"^#", physics("floating").split(f"{heading}\n")[1], flags=re.MULTILINE)[0]
    rows = [line.strip("|").split("|") for line in section.splitlines() if line.startswith("| `")]
    return [(row[0].strip(" `"), row[1].strip(), row[2].strip()) for row in rows]


@pytest.mark.parametrize("title", SECTIONS)
def test_the_table_of_options_is_the_schema(title):
    assert rows_below(title) == list(facts(SECTIONS[title]))


@pytest.mark.parametrize(
    "table",
    [PREFACTORS, SURFACES, INTERFACES, FRICTIONS, REMOTE, SCHEMES, SOLVERS],
    ids=lambda table: ", ".join(table),
)
def test_the_pages_on_soft_spheres_name_every_law_and_scheme(table):
    named = set(re.findall(r"`([\w-]+)`", physics("soft")))
    assert set(table) <= named


def test_the_tables_of_options_leave_no_part_of_a_scene_out():
    parts = {part for part in vars(floating).values() if dataclasses.is_dataclass(part)}
    assert {part for part in parts if part.__module__.startswith(floating.__name__)} == {*SECTIONS.values()} - {
        fields.FieldSpec
    }  # of tracers, too
    text = physics("floating")
    assert all(f"`{source} = " in text for source in SOURCES)


def numbers_below(title):
    """The first table below a heading whose first row begins with `title`: its first row over its second."""
    lines = physics("floating").splitlines()
    head = next(number for number, line in enumerate(lines) if line.startswith(f"| {title} |"))
    return [
        [float(re.sub(r"[^\d.e-]", "", cell.split("(")[0])) for cell in lines[row].strip("|").split("|")[1:]]
        for row in (head, head + 2)
    ]


def test_the_cutoffs_in_the_table_are_the_laws():
    for accuracy, cutoff in zip(*numbers_below("accuracy"), strict=True):
        assert cutoff == pytest.approx(truncation_radius(accuracy), abs=0.05)


def test_the_drag_factors_in_the_table_are_the_laws():
    for degrees, factor in zip(*numbers_below("θ"), strict=True):
        assert factor == pytest.approx(immersion.immersion_factor(math.radians(degrees)), abs=5e-5)


def test_the_errors_of_the_simpler_theories_are_those_of_the_table():
    text = physics("floating").replace("−", "-")
    rows = re.findall(r"^\| ([\d.]+) \|((?: *-?[\d.]+ % *\|){6})$", text, re.MULTILINE)
    assert len(rows) == 4
    for bond, cells in rows:
        reported = [float(cell) for cell in re.findall(r"(-?[\d.]+) %", cells)]
        assert reported == pytest.approx(errors_of_theories(float(bond)), rel=0.04, abs=0.06)


def errors_of_theories(bond):
    """The errors in percent: of the linear slope of two spheres, of their linear charge, and of their charge in closed
    form.
    """
    spheres = [(bond, 0.2, math.radians(60.0)), (bond, 1.5, math.radians(90.0))]
    exact = [flotation.nonlinear_balance(*sphere) for sphere in spheres]
    linear = [flotation.linear_balance(*sphere) for sphere in spheres]
    closed = [flotation.closed_form_balance(*sphere) for sphere in spheres]
    slopes = [math.tan(a.slope_angle) / math.tan(b.slope_angle) for a, b in zip(linear, exact, strict=True)]
    charges = [a.charge / b.charge for a, b in zip([*linear, *closed], exact * 2, strict=True)]
    return [100.0 * (ratio - 1.0) for ratio in (*slopes, *charges)]


def test_pictures_are_small():
    pictures = [path for path in (ROOT / "docs").rglob("*") if path.suffix in (".png", ".svg")]
    assert pictures
    assert all(picture.stat().st_size < 150_000 for picture in pictures)
