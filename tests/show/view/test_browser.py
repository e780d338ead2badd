"""The page in a real browser: it plays, colors, inspects, survives a hostile scene, and asks nobody anything."""

import contextlib
import html
import io
import os
import shutil
import threading
import time
from pathlib import Path
from urllib.parse import unquote, urlsplit

import numpy as np
import pytest
from PIL import Image, ImageColor
from tests.show.sph.conftest import carrying, frame_of, scene_of
from tests.show.view.runs import run_of
from tests.show.view.test_page import HOSTILE

from ecume.scenes.load import load_scene
from ecume.scenes.templates import folder
from ecume.show.play.alone import save_alone, save_text, templates, together
from ecume.show.play.pages import Written, game_of
from ecume.show.serving import served
from ecume.show.style import DARK_CANVAS, contrast
from ecume.show.view import save_page
from ecume.show.view.chunks import pack
from ecume.show.view.page import ALONE, Source, hexadecimal, looks, page, serving
from ecume.show.view.scenery import STAGES

playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
CHROMIUM = os.environ.get("ECUME_CHROMIUM") or shutil.which("chromium") or shutil.which("chromium-browser")
pytestmark = [pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed"), pytest.mark.sampled(2)]
AXE = Path(__file__).parents[3] / "web" / "node_modules" / "axe-core" / "axe.min.js"
READY = 1000.0
"""ms from the request of a page to its first picture, on a machine that has no other work just then"""
FLAGS = [
    "--headless", "--no-sandbox", "--no-first-run", "--disable-background-networking", "--disable-component-update",
    "--disable-sync", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
]  # fmt: skip


COARSE = [
    "spacing=8 cm", 'obstacles=[{low = ["72 cm", "0 m"], high = ["104 cm", "1 m"]}]', 'fluid[1].low=["104 cm", "0 m"]',
]  # fmt: skip


@pytest.fixture(scope="module")
def browser():
    with playwright.sync_playwright() as driver:
        opened = driver.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield opened
        opened.close()


@pytest.fixture
def tab(browser):
    """An empty tab that remembers what it was asked for, and what went wrong in it."""
    made = browser.new_page(viewport={"width": 1100, "height": 700})
    made.complaints, made.requests = [], []
    made.on("console", lambda message: made.complaints.append(message.text))
    made.on("pageerror", lambda error: made.complaints.append(str(error)))
    made.on("request", lambda request: made.requests.append(request.url))
    yield made
    made.close()


def opened(tab, run):
    address = save_page(run).path.resolve().as_uri()
    tab.goto(address)
    tab.wait_for_selector("body[data-drawn]", timeout=30_000)
    return address


def pictures(tab):
    return int(tab.get_attribute("body", "data-drawn"))


@pytest.mark.long
@pytest.mark.parametrize("model", ["floating", "tracers", "sph", "soft"])
def test_a_run_is_drawn_without_a_word_to_anybody(tab, tmp_path, model):
    address = opened(tab, run_of(model, tmp_path))
    tab.locator("#canvas").screenshot(path=tmp_path / "canvas.png")
    with Image.open(tmp_path / "canvas.png") as picture:
        colors = np.unique(np.asarray(picture.convert("RGB")).reshape(-1, 3), axis=0)
    assert len(colors) > 20
    assert tab.complaints == []
    assert tab.requests == [address]


def test_it_plays_and_is_played(tab, tmp_path):
    opened(tab, run_of("floating", tmp_path))
    before = tab.inner_text("#clock")
    tab.keyboard.press("Space")
    while int(tab.input_value("#time")) <= 2:
        tab.wait_for_timeout(50)
    assert tab.get_attribute("#play", "aria-label") == "pause"
    tab.keyboard.press("Space")
    assert tab.inner_text("#clock") != before
    tab.keyboard.press("End")
    assert tab.input_value("#time") == "10"
    assert tab.inner_text("#clock") == "200 ms"
    tab.keyboard.press("ArrowLeft")
    assert tab.input_value("#time") == "9"
    tab.fill("#time", "4")
    assert tab.inner_text("#clock") == "80 ms"


@pytest.mark.long
def test_colors_follow_the_choice_and_say_what_they_mean(tab, tmp_path):
    opened(tab, run_of("sph", tmp_path))
    assert tab.input_value("#coloring") == "pressure"
    first = tab.locator("#canvas").screenshot()
    tab.select_option("#coloring", "density")
    assert "density (kg/m^3)" in tab.inner_text("#bar")
    tab.wait_for_timeout(200)
    assert tab.locator("#canvas").screenshot() != first


def test_a_particle_shows_its_numbers(tab, tmp_path):
    opened(tab, run_of("soft", tmp_path))
    box = tab.locator("#canvas").bounding_box()
    assert not tab.is_visible("#inspector")
    tab.mouse.click(box["x"] + 0.62 * box["width"], box["y"] + 0.5 * box["height"])
    output = tab.inner_text("#inspector")
    assert "particle 1" in output
    assert "1 mm" in output
    tab.mouse.click(box["x"] + 3, box["y"] + box["height"] - 3)
    assert not tab.is_visible("#inspector")


@pytest.mark.long
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_liquid_is_one_region_without_gaps_inside_its_walls_and_seen_on_a_dark_page(tab, tmp_path, scheme):
    scene, frame = scene_of(), frame_of()
    stage = STAGES["sph"](scene, [frame])
    header = {"title": "", "model": "sph", "facts": [], "papers": [], "scene": "", "live": False}
    (tmp_path / "page.html").write_text(page({**header, **looks(frame, frame, stage)}, [pack([frame], stage)]))
    tab.emulate_media(color_scheme=scheme)
    tab.goto((tmp_path / "page.html").as_uri())
    tab.wait_for_selector("body[data-drawn]", timeout=30_000)
    tab.wait_for_timeout(200)
    tab.evaluate(
        "document.querySelectorAll('#clock, #scale, #kinds').forEach((one) => (one.style.visibility = 'hidden'))"
    )
    tab.locator("#canvas").screenshot(path=tmp_path / "canvas.png")
    with Image.open(tmp_path / "canvas.png") as picture:
        colors = np.asarray(picture.convert("RGB")).astype(int)
    ground = np.array(ImageColor.getrgb(DARK_CANVAS if scheme == "dark" else "#ffffff"))
    rows, columns = np.nonzero((np.abs(colors - ground) > 8).any(axis=-1))
    wide, floor = np.ptp(columns), rows.max()
    wet = colors[floor - wide // 4 + 6 : floor - 6, columns.min() + 6 : columns.max() - 6]
    seen = [contrast(color / 255.0, ground / 255.0) for color in np.unique(wet.reshape(-1, 3), axis=0)]
    assert min(seen) > (1.9 if scheme == "dark" else 1.1)
    tab.check("#particles")
    tab.wait_for_timeout(200)
    tab.locator("#canvas").screenshot(path=tmp_path / "canvas.png")
    with Image.open(tmp_path / "canvas.png") as picture:
        discs = np.asarray(picture.convert("RGB")).astype(int)[floor - wide // 4 + 6 : floor - 6]
    assert (np.abs(discs - ground).max(axis=-1) < 8).sum() > 1000
    assert tab.complaints == []


@pytest.mark.long
def test_a_liquid_in_3d_is_translucent_water_in_one_piece(tab, tmp_path):
    scene, frame = scene_of(3), frame_of(dimension=3)
    stage = STAGES["sph"](scene, [frame])
    header = {"title": "", "model": "sph", "facts": [], "papers": [], "scene": "", "live": False}
    (tmp_path / "page.html").write_text(page({**header, **looks(frame, frame, stage)}, [pack([frame], stage)]))
    tab.emulate_media(color_scheme="dark")
    tab.set_viewport_size({"width": 1000, "height": 420})
    tab.goto((tmp_path / "page.html").as_uri())
    tab.wait_for_selector("body[data-drawn]", timeout=30_000)
    tab.evaluate("document.querySelectorAll('#clock, #scale').forEach((one) => (one.style.visibility = 'hidden'))")

    def seen():
        tab.wait_for_timeout(200)
        tab.locator("#canvas").screenshot(path=tmp_path / "canvas.png")
        with Image.open(tmp_path / "canvas.png") as picture:
            return np.asarray(picture.convert("RGB")).astype(int)

    water = seen()
    blue = water[..., 2] - water[..., 0] > 30
    assert blue.sum() > 0.05 * blue.size
    rows = np.flatnonzero(blue.any(axis=1))
    for row in blue[rows[len(rows) // 4] : rows[3 * len(rows) // 4]]:
        (columns,) = np.nonzero(row)
        assert row[columns[0] : columns[-1] + 1].mean() > 0.95, "without gaps, but for the edges of the tank"
    assert len(np.unique(water[blue], axis=0)) > 200, "deeper water is darker or more opaque"
    tab.select_option("#coloring", "pressure")
    colored = seen()
    assert ((colored[..., 1] - colored[..., 0] > 60) & (colored[..., 1] - colored[..., 2] > 10)).sum() > 1000
    tab.check("#particles")
    balls = seen()
    assert (np.abs(balls - colored).max(axis=-1) > 30).sum() > 2000
    assert all("GPU stall" in one for one in tab.complaints)


@pytest.mark.long
def test_a_passive_tracer_keeps_its_color_and_says_what_it_is(tab, tmp_path):
    scene = scene_of(passive_tracers=[{"positions": [[1.0, 0.25]], "color": "#ff0000"}])
    frame = carrying(frame_of())
    stage = STAGES["sph"](scene, [frame])
    header = {"title": "", "model": "sph", "facts": [], "papers": [], "scene": "", "live": False}
    (tmp_path / "page.html").write_text(page({**header, **looks(frame, frame, stage)}, [pack([frame], stage)]))
    tab.goto((tmp_path / "page.html").as_uri())
    tab.wait_for_selector("body[data-drawn]", timeout=30_000)
    tab.locator("#canvas").screenshot(path=tmp_path / "canvas.png")
    with Image.open(tmp_path / "canvas.png") as picture:
        region = np.asarray(picture.convert("RGB")).astype(int)
    assert (region[len(region) // 2 :] == (255, 0, 0)).all(axis=-1).sum() > 50, "above the region of the liquid"
    tab.check("#particles")
    for coloring, others in (("pressure", "#fde725"), ("species", hexadecimal(stage.kinds[0].color))):
        tab.select_option("#coloring", coloring)
        tab.wait_for_timeout(200)
        assert tab.inner_text("#kinds").split("\n") == (["region 1"] if coloring == "species" else []) + ["tracers 1"]
        tab.locator("#canvas").screenshot(path=tmp_path / "canvas.png")
        with Image.open(tmp_path / "canvas.png") as picture:
            colors = np.asarray(picture.convert("RGB")).astype(int)
        colors[: len(colors) // 2] = 255  # there is the legend
        y, x = np.nonzero((colors == (255, 0, 0)).all(axis=-1))
        assert len(x) > 50, coloring
        assert (np.abs(colors - ImageColor.getrgb(others)).max(axis=-1) <= 3).sum() > 500, coloring
    box = tab.locator("#canvas").bounding_box()
    x, y = box["x"] + x.mean(), box["y"] + y.mean()
    tab.mouse.click(x, y)
    assert "particle 400, carried by the liquid" in tab.inner_text("#inspector")
    tab.mouse.click(x - 60, y)
    assert "particle" in tab.inner_text("#inspector")
    assert "carried" not in tab.inner_text("#inspector")
    assert tab.complaints == []


@pytest.mark.long
def test_dragging_moves_and_the_wheel_enlarges(tab, tmp_path):
    opened(tab, run_of("tracers", tmp_path))
    box = tab.locator("#canvas").bounding_box()
    middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    length = tab.inner_text("#scale-text"), tab.locator("#scale-bar").bounding_box()["width"]
    tab.mouse.move(*middle)
    tab.mouse.wheel(0, -400)
    tab.wait_for_timeout(200)
    assert (tab.inner_text("#scale-text"), tab.locator("#scale-bar").bounding_box()["width"]) != length
    before = tab.locator("#canvas").screenshot()
    tab.mouse.down()
    tab.mouse.move(middle[0] + 120, middle[1] + 60, steps=4)
    tab.mouse.up()
    tab.wait_for_timeout(200)
    assert tab.locator("#canvas").screenshot() != before
    tab.keyboard.press("r")
    tab.wait_for_timeout(200)
    assert (tab.inner_text("#scale-text"), tab.locator("#scale-bar").bounding_box()["width"]) == length


def test_a_hostile_scene_does_nothing(tab, tmp_path):
    address = opened(tab, run_of("tracers", tmp_path, title=HOSTILE))
    assert tab.inner_text("#title") == HOSTILE
    assert tab.locator("img").count() == 0
    assert tab.complaints == []
    assert tab.requests == [address]


def test_it_is_readable_on_a_phone_and_in_the_dark(browser, tmp_path):
    phone = browser.new_page(viewport={"width": 380, "height": 780}, color_scheme="dark", has_touch=True)
    opened(phone, run_of("soft", tmp_path))
    assert phone.get_attribute("html", "data-light") == "dark"
    assert phone.evaluate("document.documentElement.scrollWidth") <= 380
    assert phone.locator("#canvas").bounding_box()["height"] > 300
    phone.close()


@pytest.mark.long
def test_everything_that_is_pressed_has_a_name(tab, tmp_path):
    opened(tab, run_of("floating", tmp_path))
    for one in tab.locator("button, select, input").all():
        if one.is_visible():
            named = one.evaluate("node => node.ariaLabel || node.labels?.[0]?.innerText || node.innerText")
            assert named.strip()


@pytest.mark.long
def test_a_run_in_progress_is_followed_and_stopped(tab, tmp_path):
    state, stopped = ["running"], []
    source = Source(run_of("tracers", tmp_path), lambda: state[0], lambda: stopped.append(True))
    with serving(source) as address:
        tab.goto(address)
        tab.wait_for_selector("body[data-drawn]")
        assert tab.get_attribute("#time", "max") == "10"
        tab.click("#stop")
        tab.wait_for_timeout(200)
        assert stopped == [True]
        state[0] = "stopped"
        tab.wait_for_selector("body[data-state=stopped]")
    assert tab.inner_text("#stop") == "stopped"
    assert tab.complaints == []


@pytest.fixture(scope="module")
def simulating(tmp_path_factory):
    """A page that simulates a bowl, opened from the disk."""
    written = tmp_path_factory.mktemp("alone") / "bowl.html"
    save_alone(load_scene((folder() / "cereal-bowl.toml").read_text()), written, 1.0)
    return written.as_uri()


SITE = "https://bowl.example/bowl.html"
AROUND = "https://around.example/"


def on_site(tab, simulating, around=""):
    """The page as a site gives it out, and another one around it."""
    tab.route(SITE, lambda route: route.fulfill(path=unquote(urlsplit(simulating).path), content_type="text/html"))
    tab.route(AROUND, lambda route: route.fulfill(body=around, content_type="text/html"))
    tab.goto(AROUND if around else SITE)


def floats_of(tab):
    return int(tab.inner_text("#clock").split(" · ")[1].split(" ")[0])


def test_a_page_simulates_within_a_second_and_asks_nobody(tab, simulating):
    ready = []
    while not ready or (len(ready) < 20 and min(ready) > READY):
        tab.goto(simulating)
        tab.wait_for_selector("body[data-drawn]", timeout=30_000)
        ready.append(tab.evaluate("performance.getEntriesByName('ready')[0].startTime"))
    assert min(ready) < READY
    assert floats_of(tab) == 60
    before = tab.inner_text("#clock")
    while tab.inner_text("#clock") == before:
        tab.wait_for_timeout(50)
    assert tab.complaints == []
    assert [request for request in tab.requests if not request.startswith("blob:")] == len(ready) * [simulating]


@pytest.mark.long
def test_a_bowl_is_played_by_keys_alone(tab, simulating):
    tab.goto(simulating)
    tab.wait_for_selector("body[data-drawn]", timeout=30_000)
    tab.get_by_role("button", name="pause").press("Enter")
    tab.get_by_role("button", name="empty the dish").press("Enter")
    tab.wait_for_selector("#clock:has-text(' 0 floats')")
    tab.get_by_role("radio", name="cereal").press("ArrowRight")
    canvas = tab.locator("#canvas")
    for number in (1, 2):
        canvas.press("Enter")
        tab.wait_for_selector(f"#clock:has-text(' {number} floats')")
    canvas.press("n")
    assert tab.inner_text("#heard").startswith("bead, 1 of 2, 0.00 mm right")
    for key in "rnr":
        canvas.press(key)
    assert tab.is_checked("#ruler")
    tab.wait_for_selector("#plot[aria-label*=' mm']")
    tab.get_by_role("button", name="1×", exact=True).press("Enter")
    canvas.focus()
    tab.keyboard.down("d")
    tab.wait_for_timeout(400)
    tab.keyboard.up("d")
    tab.get_by_role("button", name="pause").press("Enter")
    canvas.press("n")
    canvas.press("n")
    assert not tab.inner_text("#heard").startswith("bead, 2 of 2, 0.00 mm")
    canvas.press("x")
    tab.wait_for_selector("#clock:has-text(' 1 floats')")
    with tab.expect_download() as saved:
        tab.get_by_role("button", name="save as scene").press("Enter")
    assert [(one.name, one.count) for one in load_scene(saved.value.path()).particles] == [("bead", 1)]
    assert tab.complaints == []


@pytest.mark.long
def test_a_bowl_is_played_by_hands(tab, simulating):
    tab.goto(simulating)
    tab.wait_for_selector("body[data-drawn]", timeout=30_000)
    tab.get_by_role("button", name="pause").click()
    tab.get_by_role("button", name="empty the dish").click()
    tab.wait_for_selector("#clock:has-text(' 0 floats')")
    box = tab.locator("#canvas").bounding_box()
    middle = box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"]
    tab.mouse.click(*middle)
    tab.wait_for_selector("#clock:has-text(' 1 floats')")
    assert tab.locator("#liquid select").count() == 1
    tab.locator("#liquid select").select_option("water")
    tab.wait_for_timeout(200)
    assert tab.locator("#liquid select").input_value() == "water"
    assert floats_of(tab) == 1
    assert tab.complaints == []


@pytest.mark.long
def test_a_link_brings_a_bowl_back_and_hostile_ones_end_in_a_sentence(browser, tab, simulating):
    tab.goto(simulating)
    tab.wait_for_selector("body[data-drawn]", timeout=30_000)
    tab.select_option("#dish-name", "square")
    tab.select_option("#liquid-name", "water")
    tab.get_by_role("button", name="empty the dish").click()
    tab.locator("#canvas").press("Enter")
    tab.get_by_role("button", name="link").click()
    tab.wait_for_selector("#said:has-text('opens on this machine only')")
    assert not tab.locator("#code").is_visible()
    link = tab.evaluate("location.href")
    assert tab.input_value("#address") == link
    other = browser.new_page()
    other.goto(link)
    other.wait_for_selector("#clock:has-text(' 1 floats')", timeout=30_000)
    assert other.input_value("#dish-name") == "square"
    assert other.input_value("#liquid-name") == "water"
    for fragment in ("x", "<img src=x onerror=alert(1)>", "A" * 5000, "%00", "AQ"):
        other.evaluate("fragment => { location.hash = fragment }", fragment)
        other.wait_for_selector("#said:has-text('The link does not describe a bowl of this page.')")
        other.get_by_role("button", name="pause").click()
        other.wait_for_selector("#said", state="hidden")
    other.close()
    assert tab.complaints == []


@pytest.mark.long
def test_a_link_to_a_site_has_a_code(tab, simulating):
    on_site(tab, simulating)
    tab.wait_for_selector("body[data-drawn]", timeout=30_000)
    tab.get_by_role("button", name="link").click()
    tab.wait_for_selector("#code", state="visible")
    assert tab.input_value("#address") == tab.evaluate("location.href")
    assert tab.input_value("#address").startswith(f"{SITE}#")
    assert "holds the bowl" in tab.inner_text("#said")
    assert "this machine" not in tab.inner_text("#said")


def test_a_page_of_a_program_hands_over_neither_its_token_nor_a_code(tab, simulating):
    site = Written(Path(unquote(urlsplit(simulating).path)).read_text(encoding="utf-8"), ALONE)
    with served(site) as address:
        tab.goto(address)
        tab.wait_for_selector("body[data-drawn]", timeout=30_000)
        tab.get_by_role("button", name="empty the dish").click()
        tab.get_by_role("button", name="link").click()
        tab.wait_for_selector("#said:has-text('this page opens on this machine only')")
        assert not tab.locator("#code").is_visible()
        fragment = tab.input_value("#address")
        assert tab.evaluate("location.hash") == fragment
    assert site.token not in fragment
    tab.goto(simulating + fragment)
    tab.wait_for_selector("#clock:has-text(' 0 floats')", timeout=30_000)


def test_a_page_in_a_frame_shows_its_link(tab, simulating):
    on_site(tab, simulating, f'<iframe sandbox="allow-scripts" width="1000" height="650" src="{SITE}"></iframe>')
    inner = tab.frame_locator("iframe")
    inner.locator("body[data-drawn]").wait_for(timeout=30_000)
    inner.get_by_role("button", name="link").click()
    inner.locator("#said:has-text('The link beside the bowl holds the bowl as it is now.')").wait_for()
    inner.locator("#address").focus()
    link = inner.locator("#address").input_value()
    assert link.startswith(f"{SITE}#")
    assert inner.locator("#address").evaluate("shown => shown.selectionEnd - shown.selectionStart") == len(link)


def test_a_page_without_an_address_offers_no_link(tab, simulating):
    text = Path(unquote(urlsplit(simulating).path)).read_text(encoding="utf-8")
    tab.set_content(f'<iframe sandbox="allow-scripts" srcdoc="{html.escape(text)}"></iframe>')
    inner = tab.frame_locator("iframe")
    inner.locator("body[data-drawn]").wait_for(timeout=30_000)
    assert inner.locator("#save").is_visible()
    assert not inner.locator("#link").is_visible()


@pytest.mark.skipif(not AXE.exists(), reason="axe-core is not installed: `npm ci` in web/")
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_no_violation_in_a_page_that_simulates(browser, simulating, scheme):
    for size in ({"width": 1280, "height": 800}, {"width": 390, "height": 844}):
        shown = browser.new_page(viewport=size, color_scheme=scheme)
        on_site(shown, simulating)
        shown.wait_for_selector("body[data-drawn]", timeout=30_000)
        shown.check("#ruler")
        shown.get_by_role("button", name="link").click()
        shown.wait_for_selector("#code", state="visible")
        shown.evaluate(AXE.read_text(encoding="utf-8"))
        found = shown.evaluate("axe.run()")
        assert [(one["id"], one["nodes"][0]["html"]) for one in found["violations"]] == []
        assert len(found["passes"]) > 20
        shown.close()


@pytest.fixture(scope="module")
def four_spheres(tmp_path_factory):
    """A page that simulates a T1 process, opened from the disk."""
    written = tmp_path_factory.mktemp("spheres") / "t1.html"
    save_alone(load_scene((folder() / "t1.toml").read_text()), written, 0.5)
    return written.as_uri()


@pytest.mark.long
def test_four_spheres_move_within_a_second_and_ask_nobody(tab, four_spheres):
    ready = []
    while not ready or (len(ready) < 20 and min(ready) > READY):
        tab.goto(four_spheres)
        tab.wait_for_selector("body[data-drawn]", timeout=30_000)
        ready.append(tab.evaluate("performance.getEntriesByName('ready')[0].startTime"))
    assert min(ready) < READY
    label = tab.get_attribute("#canvas", "aria-label")
    tab.get_by_role("button", name="4×", exact=True).press("Enter")
    tab.wait_for_selector("#clock:has-text('neighbors exchanged after 48.')", timeout=60_000)
    assert tab.get_attribute("#canvas", "aria-label") != label
    assert "neighbors exchanged after 48." in tab.text_content("#heard")
    assert tab.complaints == []
    assert [request for request in tab.requests if not request.startswith("blob:")] == len(ready) * [four_spheres]


@pytest.mark.long
def test_a_cluster_is_chosen_by_keys_and_links(tab, four_spheres):
    tab.goto(four_spheres)
    tab.wait_for_selector("body[data-drawn]", timeout=30_000)
    gap = tab.get_by_role("slider", name="first gap of the cluster")
    gap.press("ArrowRight")
    tab.wait_for_selector("#sliders:has-text('0.1 R')")
    tab.get_by_role("slider", name="inward pull of the sides of the cluster").press("End")
    tab.get_by_role("button", name="4×", exact=True).press("Enter")
    tab.wait_for_selector("#clock:has-text('blocked')", timeout=60_000)
    tab.get_by_role("button", name="link").press("Enter")
    tab.wait_for_selector("#address", state="visible")
    link = tab.input_value("#address")
    tab.goto("about:blank")
    tab.goto(link)
    tab.wait_for_selector("#sliders:has-text('0.1 R')", timeout=30_000)
    tab.goto("about:blank")
    tab.goto(f"{four_spheres}#<script>alert(1)</script>")
    tab.wait_for_selector("#said:has-text('The link does not describe a cluster of this page.')", timeout=30_000)
    assert tab.complaints == []


@pytest.mark.skipif(not AXE.exists(), reason="axe-core is not installed: `npm ci` in web/")
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_no_violation_in_the_page_of_four_spheres(browser, four_spheres, scheme):
    for size in ({"width": 1280, "height": 800}, {"width": 390, "height": 844}):
        shown = browser.new_page(viewport=size, color_scheme=scheme)
        on_site(shown, four_spheres)
        shown.wait_for_selector("body[data-drawn]", timeout=30_000)
        shown.get_by_role("button", name="link").click()
        shown.wait_for_selector("#code", state="visible")
        shown.evaluate(AXE.read_text(encoding="utf-8"))
        found = shown.evaluate("axe.run()")
        assert [(one["id"], one["nodes"][0]["html"]) for one in found["violations"]] == []
        assert len(found["passes"]) > 15
        shown.close()


@pytest.fixture(scope="module")
def several(tmp_path_factory):
    """A page of a bowl, a tank and a T1 process, opened from the disk."""
    written = tmp_path_factory.mktemp("several") / "all.html"
    assert save_text(together(templates("particles[0].count=12")), written, 1.0) < 1e6
    return written.as_uri()


@pytest.mark.long
def test_a_page_of_several_shows_each_and_its_links_open_the_same_one(browser, tab, several):
    tab.goto(several)
    inner = tab.frame_locator("#frame")
    inner.locator("#clock:has-text('12 floats')").wait_for(timeout=30_000)
    tab.get_by_role("radio", name="bowl", exact=True).press("ArrowRight")
    inner.locator("#clock:has-text('1064 particles')").wait_for(timeout=30_000)
    inner.get_by_role("button", name="open the gate").press("Enter")
    inner.get_by_role("button", name="link").press("Enter")
    inner.locator("#said:has-text('holds the tank as it is now')").wait_for()
    link = tab.evaluate("location.href")
    assert link.startswith(f"{several}#sph.")
    other = browser.new_page()
    other.goto(link)
    other.frame_locator("#frame").locator("#close").wait_for(timeout=30_000)
    for name, what in (("floating", "bowl"), ("sph", "tank"), ("soft", "cluster")):
        other.evaluate("name => { location.hash = `${name}.<img src=x onerror=alert(1)>` }", name)
        said = f"The link does not describe a {what} of this page."
        other.frame_locator("#frame").locator(f"#said:has-text('{said}')").wait_for(timeout=30_000)
    other.get_by_role("radio", name="bowl", exact=True).click()
    assert other.evaluate("location.href") == f"{several}#floating", "a reload would show what is no longer chosen"
    other.close()
    assert tab.complaints == []
    assert [request for request in tab.requests if not request.startswith("blob:")] == [several]


@pytest.mark.skipif(not AXE.exists(), reason="axe-core is not installed: `npm ci` in web/")
@pytest.mark.parametrize(("scheme", "width", "height"), [("light", 1280, 800), ("dark", 390, 844)])
def test_axe_finds_no_violation_in_a_page_of_several(browser, several, scheme, width, height):
    shown = browser.new_page(viewport={"width": width, "height": height}, color_scheme=scheme)
    on_site(shown, several)
    shown.frame_locator("#frame").locator("body[data-drawn]").wait_for(timeout=30_000)
    for frame in shown.frames:
        frame.evaluate(AXE.read_text(encoding="utf-8"))
    found = shown.evaluate("axe.run()")
    assert [(one["id"], one["nodes"][0]["html"]) for one in found["violations"]] == []
    assert len(found["passes"]) > 20
    shown.close()


@contextlib.contextmanager
def played(name, changes):
    """A template that somebody plays with, and the address of its page."""
    game = game_of(load_scene((folder() / f"{name}.toml").read_text(), changes))
    game.toy.moving.play(0.0)
    loop = threading.Thread(target=game.run, daemon=True)
    loop.start()
    with served(game) as address:
        yield game.toy.moving, address
    game.over.set()
    loop.join()


@pytest.mark.long
def test_a_bowl_is_played_with(tab):
    away = "particles[0].positions=[[-0.02, 0.02], [-0.01, 0.025], [0.01, 0.025], [0.02, 0.02]]"
    with played("cereal-bowl", ["particles[0].count=4", away]) as (bowl, address):
        tab.goto(address)
        tab.wait_for_selector("body[data-drawn]", timeout=30_000)
        tab.get_by_role("button", name="pause").click()
        tab.get_by_role("radio", name="bead").click()
        box = tab.locator("#canvas").bounding_box()
        middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        for number in range(10):
            tab.mouse.click(middle[0] + 30 * (number % 4) - 45, middle[1] + 30 * (number // 4) - 30)
            tab.wait_for_selector(f"#clock:has-text('{5 + number} floats')", timeout=60_000)
        first, end = bowl.frame.numbers["clusters"], bowl.time + 1.5
        tab.get_by_role("button", name="4×", exact=True).click()
        while bowl.time < end:
            tab.wait_for_timeout(100)
        assert bowl.frame.numbers["clusters"] < first, "equal beads attract one another"
        with tab.expect_download() as saved:
            tab.get_by_role("button", name="save as scene").click()
        assert len(load_scene(saved.value.path()).particles[1].positions) == 10
        assert not tab.complaints
        assert all(request.startswith((address.split("/?")[0], "blob:")) for request in tab.requests)


@pytest.mark.long
def test_sliders_follow_a_bowl_that_begins_again(tab):
    with played("cereal-bowl", ["particles[0].count=1", "particles[0].positions=[[0, 0]]"]) as (bowl, address):
        tab.goto(address)
        sliders = [
            tab.get_by_label(name)
            for name in ("surface tension of liquid", "contact angle of dish", "radius of cereal")
        ]
        for slider in sliders:
            slider.wait_for(timeout=30_000)
        first = [slider.input_value() for slider in sliders]
        for slider in sliders:
            slider.focus()
            slider.press("PageDown")
            assert slider.evaluate("one => one === document.activeElement")
        patience = time.monotonic() + 30.0
        while bowl.scene.particles[0].radius == bowl.first.particles[0].radius:
            assert time.monotonic() < patience
            tab.wait_for_timeout(50)
        changed = [slider.input_value() for slider in sliders]
        assert all(one != other for one, other in zip(first, changed, strict=True))
        tab.get_by_role("button", name="begin again").click()
        for _ in range(200):
            if sliders[2].input_value() == first[2]:
                break
            tab.wait_for_timeout(50)
        assert [slider.input_value() for slider in sliders] == first
        assert tab.complaints == []


@pytest.fixture(scope="module")
def pool(tmp_path_factory):
    """A page that simulates a tank, opened from the disk."""
    written = tmp_path_factory.mktemp("pool") / "tank.html"
    save_alone(load_scene((folder() / "small-tank.toml").read_text(), COARSE), written, 1.0)
    return written.as_uri()


@pytest.mark.long
def test_a_tank_in_a_page_is_poured_waved_pushed_and_tilted_and_asks_nobody(tab, pool):
    tab.goto(pool)
    tab.wait_for_selector("body[data-drawn]", timeout=30_000)
    box, few = tab.locator("#canvas").bounding_box(), floats_of(tab)
    tab.mouse.click(box["x"] + 0.6 * box["width"], box["y"] + 0.3 * box["height"])
    while floats_of(tab) <= few:
        tab.wait_for_timeout(50)
    canvas = tab.locator("#canvas")
    tab.get_by_role("button", name="make a wave").press("Enter")
    tab.wait_for_timeout(300)
    canvas.press("e")
    tab.get_by_role("button", name="open the gate").press("Enter")
    tab.wait_for_selector("#close", state="visible")
    canvas.focus()
    tab.keyboard.down("ArrowRight")
    tab.wait_for_selector("#tilt output:has-text('10.0°')")
    tab.keyboard.up("ArrowRight")
    tab.locator("#tilt input").fill("-5")
    canvas.press("i")
    assert "Gates: 1 open." in tab.inner_text("#heard")
    with tab.expect_download() as saved:
        tab.get_by_role("button", name="save as scene").press("Enter")
    assert load_scene(saved.value.path()).tank.low[0] > 0.0
    tab.get_by_role("button", name="restart").press("Enter")
    tab.wait_for_selector("#tilt output:has-text('0.0°')")
    assert tab.input_value("#tilt input") == "0"
    assert floats_of(tab) == few
    assert tab.complaints == []
    assert [request for request in tab.requests if not request.startswith("blob:")] == [pool]


@pytest.mark.skipif(not AXE.exists(), reason="axe-core is not installed: `npm ci` in web/")
@pytest.mark.parametrize(("scheme", "width", "height"), [("light", 1280, 800), ("dark", 390, 844)])
def test_axe_finds_no_violation_in_the_page_of_a_tank(browser, pool, scheme, width, height):
    shown = browser.new_page(viewport={"width": width, "height": height}, color_scheme=scheme)
    shown.goto(pool)
    shown.wait_for_selector("body[data-drawn]", timeout=30_000)
    shown.evaluate(AXE.read_text(encoding="utf-8"))
    found = shown.evaluate("axe.run()")
    assert [(one["id"], one["nodes"][0]["html"]) for one in found["violations"]] == []
    assert len(found["passes"]) > 15
    shown.close()


@pytest.mark.long
def test_a_tank_is_played_with(tab):
    with played("small-tank", COARSE) as (tank, address):
        tab.goto(address)
        tab.wait_for_selector("body[data-drawn]", timeout=30_000)
        box = tab.locator("#canvas").bounding_box()
        few = tank.count
        tab.mouse.move(box["x"] + 0.7 * box["width"], box["y"] + 0.4 * box["height"])
        tab.mouse.down()
        while tank.count < few + 30:
            tab.wait_for_timeout(50)
        tab.mouse.up()
        tab.get_by_role("radio", name="scoop").click()
        many = tank.count
        tab.mouse.click(box["x"] + 0.25 * box["width"], box["y"] + 0.75 * box["height"])
        while tank.count >= many:
            tab.wait_for_timeout(50)
        tab.get_by_role("radio", name="pressure").click()
        tab.wait_for_selector("#most:has-text('Pa')")
        tab.get_by_role("button", name="open the gate").click()
        tab.wait_for_selector("#open", state="hidden")
        until = tank.time + 0.5
        while tank.time < until:
            tab.wait_for_timeout(50)
        tab.get_by_role("button", name="close the gate").click()
        tab.wait_for_selector("#close", state="hidden")
        assert tab.locator("#open").is_visible()
        assert not tank.opened
        tab.get_by_role("button", name="make a wave").click()
        while not tank.pushed:
            tab.wait_for_timeout(50)
        tab.locator("#canvas").focus()
        tab.keyboard.down("ArrowRight")
        while tank.leaning < 0.05:
            tab.wait_for_timeout(50)
        tank.lean(9.0)
        while tank.leaning < 0.3:
            tab.wait_for_timeout(50)
        seen = Image.open(io.BytesIO(tab.locator("#canvas").screenshot())).convert("RGB")
        around = np.asarray(seen)[90:-6, 6:-6]
        edges = np.concatenate([around[-1], around[:, 0], around[:, -1]])
        assert (edges == edges[0]).all(), "a tank that leans is seen whole"
        tab.keyboard.up("ArrowRight")
        tab.screenshot(path=os.environ.get("ECUME_SCREENSHOT") or os.devnull, type="png")
        with tab.expect_download() as saved:
            tab.get_by_role("button", name="save as scene").click()
        assert sum(len(part.particles.masses) for part in load_scene(saved.value.path()).fluid) == tank.count
        tab.get_by_role("button", name="restart").click()
        tab.wait_for_selector("#open", state="visible")
        assert not tab.complaints
        assert all(request.startswith((address.split("/?")[0], "blob:")) for request in tab.requests)
