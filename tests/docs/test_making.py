"""The pages that are generated from the code are complete, and have the required links and formulas."""

import dataclasses
import importlib
import re
import sys
import tomllib
from pathlib import Path

import pytest
from tests.contracts.test_laws import MODULES

from ecume.scenes.schema import SCENES
from ecume_validation import CASES

pytestmark = pytest.mark.sampled(2)

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def makers():
    """A function that imports a maker of pages by name, as `python docs/making` does."""
    sys.path.insert(0, str(ROOT / "docs" / "making"))
    yield importlib.import_module
    sys.path.pop(0)


@pytest.mark.parametrize("model", SCENES)
def test_every_key_of_every_table_is_there_and_has_a_meaning(makers, model):
    scenes = makers("scenes")
    text = scenes.page(model)
    for table in scenes.tables(SCENES[model]):
        assert not table.path or f"(`{table.path}`)\n" in text
        fields = scenes.fields_of(table.kind)
        rows = [scenes.row(field, scenes.example_of(model, table, field)) for field in fields]
        assert [row.split("`")[1] for row in rows] == [field.name for field in dataclasses.fields(table.kind)]
        assert all(row in text and row.split(" | ")[-1].strip(" |") for row in rows), table


def test_units_defaults_and_ranges_are_the_schema_s(makers):
    text = makers("scenes").page("floating")
    rows = {line.split("`")[1]: line for line in text.splitlines() if line.startswith("| `")}
    assert rows["surface_tension"].startswith("| `surface_tension` | N/m | – | 1e-9 to 1000 |")
    assert rows["placement"].startswith("| `placement` | – | `random` | `random`, `lattice`, `ring` |")
    assert "| s | *needed* | above 0, to 1e10 |" in rows["frame_every"]
    assert "| rad | 45 deg |" in text  # of the dish


@pytest.mark.long
def test_every_law_and_its_units_are_there(makers):
    pages = makers("functions").pages()
    output = "\n".join(text for name, text in pages.items() if "ecume.laws" in name)
    for module in map(importlib.import_module, MODULES):
        for name in getattr(module, "__all__", ()):
            if callable(getattr(module, name)) and hasattr(getattr(module, name), "__name__"):
                assert f"## {name}\n" in output, name
    drag = pages["reference/python/ecume.laws.drag.md"]
    assert "Units: `radius` m, `viscosity` Pa*s, `factor` 1, *returns* N*s/m." in drag


def test_every_command_is_there(makers):
    (text,) = makers("commands").pages().values()
    assert all(f"## ecume {verb}\n" in text for verb in ("new", "run", "movie", "bench", "validate"))
    assert "`--max-size` `MB` | Largest page; long runs show fewer frames. Default: 50.0. |" in text
    rows = [line for line in text.splitlines() if line.startswith("|")]
    assert r"| `--engine` `local\|lammps` | Integrate" in text
    assert all(len(re.findall(r"(?<!\\)\|", row)) == 3 for row in rows), "a sign of its own makes no cell"


def test_signs_in_docstrings_mean_themselves(makers):
    writing = makers("writing")
    assert writing.plain("a * b_c < `d*e` [keller1998, eq. 3] [1]") == r"a \* b\_c \< `d*e` [keller1998, eq. 3] \[1\]"


def test_links_lead_from_where_a_page_stands_on_the_site_to_where_the_other_does(makers, tmp_path):
    staging = makers("staging")
    pages = dict(staging.written(tmp_path))
    assert "](../extend/pair-law.md)" in pages["how-to/own-laws.md"]
    assert "](benchmarks.md)" in pages["performance.md"]
    assert "index.md" in pages
    assert not any("../../" in text for text in pages.values())


def test_papers_lead_to_the_bibliography_but_not_in_code(makers):
    cited = makers("staging")._cited("Buoyancy [keller1998], not `[keller1998]`, not [one](two).", Path("physics/a.md"))
    assert cited == r"Buoyancy \[[keller1998](../papers.md#keller1998)\], not `[keller1998]`, not [one](two)."


def test_formulas_become_mathml(makers):
    pytest.importorskip("latex2mathml", reason="comes with the extra docs")
    mathml = makers("mathml")
    assert "<mfrac>" in mathml.formula(r"\tfrac{2}{3}", "inline", None)


def test_the_gallery_shows_every_example(makers):
    gallery = makers("gallery")
    cards = gallery.cards()
    for path in [
        *(ROOT / "examples").glob("*.toml"),
        *(gallery.TEMPLATES / f"{name}.toml" for name in gallery.FURTHER),
    ]:
        assert tomllib.loads(path.read_text(encoding="utf-8"))["title"].split("'")[0] in cards
        assert f"_clips/{path.stem}.mp4" in cards


def test_the_start_page_opens_with_a_bowl_that_simulates(makers, tmp_path):
    gallery = makers("gallery")
    index = dict(makers("staging").written(tmp_path))["index.md"]
    assert index.index(f'src="_clips/{gallery.FRONT}.html"') < index.index("| model |")
    gallery.write_front(tmp_path)
    assert 1e5 < (tmp_path / f"{gallery.FRONT}.html").stat().st_size < 1e6


def test_what_is_recorded_belongs_to_cases_and_benchmarks_of_today(makers):
    from ecume.cli.comparisons import BENCHES

    records = makers("records")
    assert set(records.recorded("recorded-validation.json")) <= set(CASES)
    assert set(records.recorded("recorded-benchmarks.json")) <= set(BENCHES)
    assert all(f"`{name}`" in records.validation() for name in CASES)


def test_pages_on_modules_are_titled_by_concepts(makers):
    functions, titles = makers("functions"), makers("titles")
    modules = [
        module
        for chapter in functions.CHAPTERS.values()
        for root in chapter.roots
        for module in functions.modules_of(root)
    ]
    names = {module.__name__.removeprefix("ecume.") for module in modules}
    assert set(titles.TITLES) <= names, "titles of modules that do not exist"
    for module in modules:
        title = titles.title_of(module)
        assert not re.search(r"[_.`]", title), module.__name__
        assert not titles.CLAUSE.match(title), module.__name__
        assert len(title.split()) <= titles.LONGEST, module.__name__


def test_pages_are_completed_for_readers_without_a_mouse(makers):
    """Captions have a level, code and tables that scroll can be focused, landmarks have names; once is enough."""
    completed = makers("accessible").completed
    page = (
        '<p class="caption" role="heading"><span>a</span></p><pre>code</pre><div class="table-wrapper docutils">t</div>'
        '<aside class="toc-drawer no-toc">c</aside><aside class="sidebar-drawer">s</aside>'
    )
    found = completed(page)
    assert 'role="heading" aria-level="2"' in found
    assert '<pre tabindex="0">' in found
    assert 'class="table-wrapper docutils" tabindex="0"' in found
    assert found.count("aria-label=") == 2
    assert completed(found) == found
