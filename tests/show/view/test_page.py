"""The page: whole, small enough, and closed to whatever a scene's author wrote into it."""

import csv
import hashlib
import json
import re
import shutil
import subprocess
from pathlib import Path

import h5py
import numpy as np
import pytest
from tests.show.view.runs import run_of

from ecume.errors import BadInput
from ecume.run import RunOptions, run
from ecume.scenes.load import load_scene
from ecume.show.view import save_page
from ecume.show.view.page import VIEW, color_map, page, policy_of
from ecume.trajectories.exports import EXPORTS, export

ROOT = Path(__file__).parents[3]
WEB = ROOT / "web"
BUNDLE = ROOT / "src/ecume/show/view/bundle"
HOSTILE = "</script><img src=x onerror=alert(1)><!-- @SCRIPT@ @DATA@ & \\u003c"


def data_of(text, name):
    return json.loads(re.search(rf'<script type="application/json" id="{name}">(.*?)</script>', text)[1])


@pytest.mark.parametrize("model", ["floating", "tracers", "sph", "soft"])
def test_each_model_has_its_page(tmp_path, model):
    made = save_page(run_of(model, tmp_path))
    text = made.path.read_text()
    header = data_of(text, "run")
    assert header["model"] == model
    assert made.size == made.path.stat().st_size
    assert len(data_of(text, "chunk-0")["times"]) == made.frames
    assert {"low", "high", "species", "colorings", "scene", "facts"} <= header.keys()
    assert all(low < high for low, high in zip(header["low"], header["high"], strict=True))


DISCS = """
model = "floating"
duration = "0.02 s"
frame_every = "0.01 s"
[[particles]]
count = 3
radius = "1 mm"
density = 300.0
disc = { thickness = "0.4 mm" }
[dish]
radius = "1 cm"
"""


def test_discs_which_have_no_contact_angle_have_a_page_without_it_and_every_export(tmp_path):
    run(load_scene(DISCS), tmp_path / "run", options=RunOptions(threads=1))
    header = data_of(save_page(tmp_path / "run").path.read_text(), "run")
    names = [one["name"] for one in header["colorings"]]
    assert "density" in names
    assert "contact_angle" not in names
    exported = {
        kind: export(tmp_path / "run", kind, tmp_path / f"discs.{kind}") for kind in EXPORTS if kind != "samples"
    }
    with np.load(exported["npz"]) as archive:
        assert np.isnan(archive["contact_angle"]).all()
        assert np.isfinite(archive["charge"]).all()
    heading, *rows = csv.reader(exported["csv"].read_text().splitlines())
    angle = heading.index("contact_angle [rad]")
    assert {row[angle] for row in rows} == {"nan"}
    with h5py.File(exported["vtk"]) as file:
        assert np.isnan(file["VTKHDF/PointData/contact_angle"]).all()


def test_a_hostile_title_stays_text(tmp_path):
    text = save_page(run_of("tracers", tmp_path, title=HOSTILE)).path.read_text()
    assert data_of(text, "run")["title"] == HOSTILE
    assert "<img" not in text
    assert text.count("</script>") == text.count("<script")


def test_a_page_keeps_to_its_size_by_leaving_frames_out(tmp_path):
    run = run_of("sph", tmp_path)
    whole = save_page(run)
    small = save_page(run, max_size=0.75 * whole.size / 1e6)
    assert whole.every == 1
    assert small.every >= 2
    assert small.size <= 0.75 * whole.size
    assert small.frames == -(-whole.frames // small.every)


def test_a_size_that_holds_nothing_is_refused_with_one_that_does(tmp_path):
    run = run_of("sph", tmp_path)
    with pytest.raises(
        BadInput, match=r"not two frames fit into 0.09 MB; give --max-size (\d+\.\d) or more"
    ) as refused:
        save_page(run, max_size=0.09)
    enough = float(re.search(r"--max-size (\S+)", str(refused.value))[1])
    assert save_page(run, max_size=enough).frames >= 2


def test_the_page_may_run_its_own_script_and_contact_no_server():
    policy = policy_of(VIEW, live=False)
    assert "default-src 'none'" in policy
    assert "connect-src 'none'" in policy
    assert "unsafe" not in policy
    assert "connect-src 'self'" in policy_of(VIEW, live=True)
    assert policy in page({"title": ""}, [])


def test_color_maps_are_256_colors():
    assert len(color_map("viridis")) == len(color_map("height")) == 4 * 256
    assert color_map("height") != color_map("height #fbf8f0")


def test_the_bundle_was_made_of_these_sources():
    digest = hashlib.sha256()
    names = sorted(f"src/{path.name}" for path in (WEB / "src").iterdir())
    for name in [*names, "build.mjs", "package-lock.json", "wasm/LICENSES.txt"]:
        digest.update(f"{name}\n".encode() + (WEB / name).read_bytes())
    assert (BUNDLE / "SOURCES.sha256").read_text().strip() == digest.hexdigest(), "run `npm run build` in web/"


@pytest.mark.long
@pytest.mark.skipif(shutil.which("npm") is None, reason="npm is not installed; the digest of the sources stands in")
def test_building_again_gives_the_same_bytes(tmp_path):
    work = tmp_path / "web"
    shutil.copytree(WEB, work, ignore=shutil.ignore_patterns("node_modules"))
    installed = subprocess.run(["npm", "ci", "--no-audit", "--no-fund"], cwd=work, capture_output=True, text=True)
    if installed.returncode and not (WEB / "node_modules").is_dir():
        pytest.skip("npm reaches no registry")
    if installed.returncode:
        shutil.copytree(WEB / "node_modules", work / "node_modules", symlinks=True)
    subprocess.run(["node", "node_modules/typescript/bin/tsc", "--noEmit"], cwd=work, check=True)
    subprocess.run(["node", "build.mjs", str(tmp_path / "out")], cwd=work, check=True)
    for built in (tmp_path / "out").iterdir():
        assert built.read_bytes() == (BUNDLE / built.name).read_bytes(), built.name


def test_the_lock_names_no_address():
    assert "http" not in json.dumps(
        [
            entry.get("resolved", "")
            for entry in json.loads((WEB / "package-lock.json").read_text())["packages"].values()
        ]
    )


def test_heights_of_the_surface_lie_on_its_scale(tmp_path):
    text = save_page(run_of("floating", tmp_path)).path.read_text()
    surface = data_of(text, "run")["sheet"]
    places = [place for place, _ in surface["ticks"]]
    assert np.all(np.diff(places) > 0)
    assert surface["shown"][0] < surface["shown"][1]
    assert data_of(text, "chunk-0")["places"]["sheet"]["length"] % (surface["columns"] * surface["rows"]) == 0
