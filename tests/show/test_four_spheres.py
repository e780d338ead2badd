"""A page that simulates four spheres by itself takes the time that ecume takes, and refuses what it cannot."""

import dataclasses
import json
import math
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from ecume.errors import BadInput
from ecume.models.soft.t1 import t1_process
from ecume.scenes.load import load_scene
from ecume.scenes.templates import folder
from ecume.show.play import four_spheres
from ecume.show.play.alone import alone, refusal, save_alone
from ecume.show.play.four_spheres import Pulled, cluster_arguments, pulled_in
from ecume.show.play.memory import holders_of, leaves, slots, types_of
from ecume.show.view.page import bundled

WORKER = Path(__file__).with_name("worker.mjs")
with_node = pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")


def template(*changes):
    return load_scene((folder() / "t1.toml").read_text(encoding="utf-8"), list(changes))


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    written = tmp_path_factory.mktemp("page") / "t1.html"
    patch = pytest.MonkeyPatch()
    patch.setattr(four_spheres, "GAPS", (1e-3, 1e-2))
    patch.setattr(four_spheres, "FORCES", (1e-3, 1e-2))
    patch.setattr(four_spheres, "RATIOS", (0.0, 0.3, 0.7))
    written.write_text(alone(template()), encoding="utf-8")
    patch.undo()
    return written


def asked(page, *questions):
    done = subprocess.run(
        ["node", str(WORKER), str(page)], input=json.dumps(questions), capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr
    return [one.get("answer") for one in json.loads(done.stdout)]


def test_the_compiled_cluster_takes_what_ecume_has_now():
    assert types_of(cluster_arguments()) == bundled("t1.types"), "the bundle is older than the model: sh scripts/web"


def test_arrays_that_share_memory_do_so_in_the_page():
    """Newton's method solves for `borders.change` and moves the spheres by `bodies.change`, its first row."""
    arguments = cluster_arguments()
    holder = {name: value if isinstance(value, str) else name for name, _, shape, value in slots(arguments) if shape}
    arrays = [(name, one) for name, one in leaves(arguments["cluster"], "cluster") if isinstance(one, np.ndarray)]
    for name, one in arrays:
        for other, another in arrays:
            assert np.shares_memory(one, another) == (one.size > 0 and holder[name] == holder[other]), (name, other)
    assert holder["cluster.step.bodies.change"] == "cluster.step.borders.change"


@pytest.mark.parametrize("first", [1, 2, 5])
def test_an_array_that_begins_within_another_is_refused(first):
    whole = np.arange(6.0)
    with pytest.raises(ValueError, match="part begins within whole"):
        holders_of([("part", whole[first:]), ("whole", whole)])


@pytest.mark.long
@pytest.mark.compiled
@with_node
@pytest.mark.parametrize(
    ("link", "given"),
    [
        ("t1-0-1-0", {"gap": 1e-3, "reduced_force": 1e-3}),
        ("t1-1-2-0", {"gap": 1e-2, "reduced_force": 1e-2}),
        ("t1-1-1-1", {"gap": 1e-2, "reduced_force": 1e-3, "force_ratio": 0.3}),
        ("t1-1-2-2", {"gap": 1e-2, "reduced_force": 1e-2, "force_ratio": 0.7}),
    ],
)
def test_a_process_takes_as_long_as_in_python(page, link, given):
    said, ours = asked(page, ["bring", {"fragment": link}], ["whole", {}])
    theirs = t1_process(**given)
    assert said == ""
    assert ours["outcome"] == theirs.outcome
    assert ours["steps"] == theirs.steps
    if math.isfinite(theirs.duration):
        assert ours["duration"] == pytest.approx(theirs.duration, rel=1e-9)


@pytest.mark.compiled
@with_node
def test_the_clock_moves_the_process_and_links_bring_it_elsewhere(page):
    answers = asked(
        page, ["now", {}], ["link", {}], ["bring", {"fragment": "t1-9-9-9"}], ["bring", {"fragment": "<script>"}],
        ["choose", {"which": 0, "value": 7}], ["choose", {"which": 0, "value": 0}], ["now", {}], ["scene", {}],
    )  # fmt: skip
    first, link, *refused, chosen, then, scene = answers
    assert (first["time"], first["outcome"], link) == (0.0, "", "t1-1-0-0")
    assert first["instant"][2] == pytest.approx(1e-2, rel=1e-12)
    assert refused == ["The link does not describe a cluster of this page."] * 3
    assert chosen == ""
    assert then["instant"][2] == pytest.approx(1e-3, rel=1e-12)
    saved = pulled_in(load_scene(scene))
    assert saved.gap == pytest.approx(1e-3, rel=1e-9)


@pytest.mark.parametrize(
    "given", [Pulled(1e-2, 1e-3, 0.0), Pulled(3e-3, 1e-5, 0.3), Pulled(0.1, 1e-2, -0.5), Pulled(1e-3, 1e-4, 0.7)]
)
def test_a_process_is_known_by_its_scene_in_any_units(given):
    scene = given.scene
    larger = dataclasses.replace(
        scene,
        particles=tuple(
            dataclasses.replace(
                one,
                radius=2e-3,
                modulus=5e3,
                positions=tuple((2e-3 * x, 2e-3 * y) for x, y in one.positions),
                force=tuple(5e3 * 4e-6 * part for part in one.force),
            )
            for one in scene.particles
        ),
        liquid=dataclasses.replace(scene.liquid, viscosity=5e3 * scene.liquid.viscosity),
    )
    assert pulled_in(larger) == pytest.approx(given, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("ratio", [1.0, 1.0 + 1e-15, 1.0 - 1e-15])
def test_a_cluster_whose_forces_balance_is_refused(ratio):
    """F_h = F_v/sqrt(3): there is no force F_N, in whose unit the time of the page is."""
    scene = template()
    pulls = ((1e-5 * ratio / math.sqrt(3.0), 0.0), (-1e-5 * ratio / math.sqrt(3.0), 0.0), (0.0, -1e-5), (0.0, 1e-5))
    places = [(one, place) for one in scene.particles for place in one.positions]
    pulled = [
        dataclasses.replace(one, count=None, positions=(place,), force=pull)
        for (one, place), pull in zip(places, pulls, strict=True)
    ]
    assert "got other ones" in refusal(dataclasses.replace(scene, particles=tuple(pulled)))


@pytest.mark.parametrize(
    "change",
    [
        'films.tangential_law = "potential"', "rotation = true", 'particles[1].positions = [["0 mm", "1.8 mm"]]',
        'particles[0].radius = "1.1 mm"', 'protocol[1].time = "20 ms"',
    ],
)  # fmt: skip
def test_other_scenes_of_soft_spheres_are_refused(change):
    assert "four of a T1 process" in refusal(template(change))


def test_packings_are_refused():
    with pytest.raises(BadInput, match="four of a T1 process"):
        alone(load_scene((folder() / "sheared-packing.toml").read_text(encoding="utf-8")))


@pytest.mark.long
def test_the_page_is_small(tmp_path):
    assert save_alone(template(), tmp_path / "t1.html", 0.5) < 200_000
