"""The style of documentation, templates, help texts, messages and comments: rules and word list of docs/style.md."""

import ast
import io
import re
import tokenize
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

from ecume.errors import BESIDE

pytestmark = pytest.mark.sampled(2)

ROOT = Path(__file__).parents[2]
STYLE = ROOT / "docs" / "style.md"
SOURCES = ROOT / "src" / "ecume"
LONGEST = 45
"""Words in a sentence."""
CLAUSE = re.compile(r"^(what|how|where|who|whom|which|whether|why|when|whose)\b", re.IGNORECASE)

PAGES = sorted(
    page
    for page in [
        *ROOT.glob("*.md"),
        *(ROOT / "docs").rglob("*.md"),
        *(ROOT / "src" / "ecume_validation" / "data").glob("*/README.md"),
    ]
    if page != STYLE
)
SCENES = sorted([*(ROOT / "src" / "ecume").rglob("*.toml"), *(ROOT / "examples").glob("*.toml")])


def name_of(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


@cache
def avoided() -> re.Pattern[str]:
    """All words to avoid in the list on the page, as one pattern."""
    (section,) = re.findall(r"^## Words to avoid\n(.*)", STYLE.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    cells = [line.split("|")[1] for line in section.splitlines() if line.startswith("| `")]
    words = sorted({word for cell in cells for word in re.findall(r"`([^`]+)`", cell)}, key=len, reverse=True)
    return re.compile(rf"(?<![\w-])({'|'.join(map(re.escape, words))})(?![\w-])", re.IGNORECASE)


def words_to_avoid(text: str) -> list[str]:
    return avoided().findall(re.sub(r"\s+", " ", text))


def prose(text: str) -> str:
    """A page without code, formulas, comments and the targets of links."""
    for pattern in (r"^```.*?^```", r"^\$\$.*?\$\$", r"<!--.*?-->"):
        text = re.sub(pattern, "", text, flags=re.MULTILINE | re.DOTALL)
    text = re.sub(r"(?<!`)(`+)(?!`).*?(?<!`)\1(?!`)", "CODE", text, flags=re.DOTALL)
    text = re.sub(r"\$[^$\n]+\$", "FORMULA", text)
    return re.sub(r"\]\([^)\s]+\)", "]", text)


def sentences(text: str) -> Iterator[str]:
    """The sentences in the paragraphs and lists of a page, without tables and headings."""
    lines = [line for line in prose(text).splitlines() if not line.lstrip().startswith(("|", "#"))]
    for block in re.split(r"\n\s*\n|\n\s*(?:[-*]|\d+\.) ", "\n".join(lines)):
        yield from re.split(r"(?<=[.!?;:])\s+(?=\S)", re.sub(r"\s+", " ", block))


def headings(text: str) -> list[str]:
    return re.findall(r"^#+ (.*?)\s*$", prose(text), re.MULTILINE)


def page_faults(path: Path) -> list[str]:
    """All violations on a page."""
    text = path.read_text(encoding="utf-8")
    words = [f"avoid '{word}'" for word in words_to_avoid(prose(text))]
    clauses = [f"heading is a clause: {one}" for one in headings(text) if CLAUSE.match(one) or one.endswith((".", "?"))]
    long = [f"{len(one.split())} words: {one}" for one in sentences(text) if len(one.split()) > LONGEST]
    return [*words, *clauses, *long]


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_a_page_keeps_to_the_style(page):
    faults = page_faults(page)
    assert not faults, "\n".join(faults)


def comments(text: str) -> str:
    """The comments and the title of a TOML file."""
    title = re.findall(r'^title = "(.*)"$', text, re.MULTILINE)
    return "\n".join([*title, *re.findall(r"#(.*)", re.sub(r'"[^"\n]*"', "TEXT", text))])


@pytest.mark.parametrize("scene", SCENES, ids=name_of)
def test_the_comments_of_a_scene_keep_to_the_style(scene):
    assert not words_to_avoid(comments(scene.read_text(encoding="utf-8")))


def texts(path: Path) -> Iterator[str]:
    """The texts in a module that a person reads: docstrings, strings of more than one word, and comments."""
    source = path.read_text(encoding="utf-8")
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and re.search(r"[A-Za-z]\S* \S", node.value):
            yield re.sub(r"`[^`]*`", "CODE", node.value)
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            yield re.sub(r"`[^`]*`", "CODE", token.string)


def parts_of_the_sources() -> list[str]:
    """The modules and packages at the top, and the separate packages of ecume."""
    return [
        *sorted(path.name for path in SOURCES.iterdir() if path.name != "__pycache__"),
        *(f"../{name}" for name in BESIDE),
    ]


@pytest.mark.parametrize("package", parts_of_the_sources())
def test_the_texts_of_a_package_keep_to_the_style(package):
    files = [SOURCES / package] if package.endswith(".py") else sorted((SOURCES / package).resolve().rglob("*.py"))
    faults = [
        f"{name_of(path)}: avoid '{word}'" for path in files for text in texts(path) for word in words_to_avoid(text)
    ]
    assert not faults, "\n".join(faults)


NOT_IN_NAMES = {
    "afloat", "came", "chance", "crowd", "crowded", "crowding", "everybody", "everyone", "felt", "lent", "march",
    "mended", "nobody", "somebody", "tells", "thicken", "thickening", "thrown", "told", "wanted", "whoever",
}  # fmt: skip
"""Words of which no identifier consists: most are words to avoid, the others had private meanings."""
STATUS = {"CROWDED"}
"""The status of a step whose arrays are too small: see `ecume.models.model`."""


def identifiers(path: Path) -> Iterator[str]:
    """The names that a module defines: functions, classes, arguments, variables and fields."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        match node:
            case ast.FunctionDef(name=name) | ast.ClassDef(name=name) | ast.arg(arg=name):
                yield name
            case ast.Name(id=name, ctx=ast.Store()):
                yield name


def words_of(identifier: str) -> set[str]:
    return {word.lower() for word in re.findall(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])", identifier)}


@pytest.mark.parametrize("package", parts_of_the_sources()[:-1])
def test_identifiers_have_no_private_words(package):
    files = [SOURCES / package] if package.endswith(".py") else sorted((SOURCES / package).rglob("*.py"))
    faults = [
        f"{name_of(path)}: {name}"
        for path in files
        for name in set(identifiers(path)) - STATUS
        if words_of(name) & NOT_IN_NAMES
    ]
    assert not faults, "\n".join(sorted(faults))


def test_words_of_identifiers_are_found(tmp_path):
    module = tmp_path / "module.py"
    module.write_text("class TheCrowd:\n    def by_chance(self, wanted):\n        TOLD = marching = 1\n", "utf-8")
    named = {name for name in identifiers(module) if words_of(name) & NOT_IN_NAMES}
    assert named == {"TheCrowd", "by_chance", "wanted", "TOLD"}


def test_comments_count(tmp_path):
    module = tmp_path / "module.py"
    module.write_text('x = 1  # everyone is told\ny = "told"\nz = "it is told"\n', "utf-8")
    assert [words_to_avoid(text) for text in texts(module)] == [["told"], ["everyone", "told"]]


def test_the_rules_find_what_they_forbid(tmp_path):
    page = tmp_path / "page.md"
    page.write_text(
        "# What is computed\n\nEveryone is told. Colour `told` and\n[told](told.md).\n\n" + "word " * 45 + "word.\n",
        "utf-8",
    )
    assert [fault.split(":")[0] for fault in page_faults(page)] == [
        "avoid 'Everyone'",
        "avoid 'told'",
        "avoid 'Colour'",
        "avoid 'told'",
        "heading is a clause",
        "46 words",
    ]
