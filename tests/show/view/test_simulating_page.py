"""A page that simulates in a real browser: from a disk, without requests, by keys too, and safe from hostile links."""

from urllib.parse import quote

import pytest
from tests.show.view.test_browser import CHROMIUM, browser, tab  # noqa: F401  # fixtures

from ecume.scenes.load import load_scene
from ecume.scenes.templates import folder
from ecume.show.play import alone as pages

pytestmark = [pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed"), pytest.mark.compiled]


@pytest.fixture(scope="module")
def address(tmp_path_factory):
    patch = pytest.MonkeyPatch()
    for name, value in (("SIZES", (1.0,)), ("DENSITIES", (1.0,)), ("ANGLES", (0.0,)), ("LIQUIDS", ("water",))):
        patch.setattr(pages, name, value)
    patch.setattr(pages, "USUAL", (0, 0, 0))
    written = tmp_path_factory.mktemp("page") / "bowl.html"
    scene = load_scene((folder() / "cereal-bowl.toml").read_text(encoding="utf-8"), ["particles[0].count=12"])
    written.write_text(pages.alone(scene), encoding="utf-8")
    patch.undo()
    return written.as_uri()


def opened(tab, address):  # noqa: F811
    tab.goto(address)
    tab.wait_for_selector("body[data-drawn]", timeout=30_000)


def count_of(tab):  # noqa: F811
    return int(tab.inner_text("#clock").split("·")[1].split()[0])


def wait_for_count(tab, count):  # noqa: F811
    while count_of(tab) != count:
        tab.wait_for_timeout(50)


def test_it_runs_from_a_disk_and_asks_nobody(tab, address):  # noqa: F811
    opened(tab, address)
    assert count_of(tab) == 12
    first = tab.inner_text("#clock")
    while tab.inner_text("#clock") == first:
        tab.wait_for_timeout(50)
    assert tab.complaints == []
    assert [one for one in tab.requests if not one.startswith("blob:")] == [address]


def test_everything_goes_by_keys(tab, address):  # noqa: F811
    opened(tab, address)
    tab.focus("#canvas")
    tab.keyboard.press("Enter")
    wait_for_count(tab, 13)
    tab.keyboard.press("n")
    tab.keyboard.down("d")
    tab.wait_for_timeout(300)
    tab.keyboard.up("d")
    tab.keyboard.press("x")
    wait_for_count(tab, 12)
    assert tab.complaints == []


def test_hands_drop_and_take_out(tab, address):  # noqa: F811
    opened(tab, address)
    tab.click("#speeds button")  # pause
    box = tab.locator("#canvas").bounding_box()
    middle = box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"]
    tab.mouse.click(*middle)
    wait_for_count(tab, 13)
    tab.mouse.dblclick(*middle)
    wait_for_count(tab, 12)
    assert tab.complaints == []


@pytest.mark.parametrize("fragment", ["%", "x", "{}", '{"liquid":"water","choices":[],"floats":[]}', "<script>"])
def test_hostile_links_end_in_a_sentence(tab, address, fragment):  # noqa: F811
    opened(tab, f"{address}#{quote(fragment) if fragment != '%' else fragment}")
    tab.wait_for_selector("#said:not([hidden])")
    assert tab.inner_text("#said") == "The link does not describe a bowl of this page."
    assert count_of(tab) == 12


def test_other_liquids_forces_and_the_ruler(tab, address):  # noqa: F811
    opened(tab, address)
    tab.check("#arrows")
    tab.check("#ruler")
    tab.select_option("#liquid", "water")
    while "surface tension 72.7" not in tab.inner_text("#liquid-numbers"):
        tab.wait_for_timeout(50)
    assert "mm" in tab.inner_text("#length")
    assert not tab.is_visible("#said")


def test_it_can_be_saved(tab, address):  # noqa: F811
    opened(tab, address)
    with tab.expect_download() as saved:
        tab.click("#save")
    scene = load_scene(saved.value.path().read_text(encoding="utf-8"))
    assert scene.particles[0].count == 12
