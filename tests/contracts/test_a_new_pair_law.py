"""The recipe docs/extend/pair-law.md, followed to the letter in a copy of the package."""

import re

import pytest
from tests.contracts.recipes import Copy

REPELLING = '''
import ecume
scene = ecume.load_scene("""
model = "floating"
duration = 0.1
frame_every = 0.02
[liquid]
density = 1000.0
viscosity = "1 mPa*s"
surface_tension = "72.8 mN/m"
[[particles]]
radius = 1e-3
density = 1300.0
contact_angle = "90 deg"
positions = [[-1.1e-3, 0.0], [1.1e-3, 0.0]]
[interaction]
law = "yukawa"
[contacts]
friction = FRICTION
""")
frames = list(ecume.simulate(scene))
apart = [abs(frame.arrays["position"][1, 0] - frame.arrays["position"][0, 0]) for frame in frames]
energy = [frame.numbers["total_energy"] for frame in frames]
assert all(later > earlier for earlier, later in zip(apart, apart[1:])), apart
assert all(later < earlier for earlier, later in zip(energy, energy[1:])), energy
print(f"{1e3 * apart[-1]:.6f} mm")
'''

SETTING = """
import warnings
import ecume
from ecume.models import MODELS
from ecume.models.floating.forces.pair_forces import law_of
from ecume.scenes.writing import to_toml
def made(constants):
    return ecume.from_plain({"model": "floating", "duration": 0.1, "frame_every": 0.1,
        "particles": [{"radius": 1e-3, "density": 1300.0, "contact_angle": 1.5, "positions": [[0.0, 0.0], [0.01, 0]]}],
        "interaction": {"law": "yukawa", "constants": constants}})
for constants in ([], [3e-12], [3e-12, 2e-3]):
    print(tuple(law_of(MODELS["floating"].parameters(ecume.load_scene(to_toml(made(constants)))))))
for constants in ([1.0, 2.0, 3.0], [1e-10, 0.0], [1e-10, -1e-3]):
    try:
        MODELS["floating"].parameters(made(constants))
    except ecume.SceneError as error:
        print(error)
with warnings.catch_warnings(record=True) as noted:
    warnings.simplefilter("always")
    for constants in ([3e-12], [3e-12, 0.05]):
        print(len(noted), next(row for row in MODELS["floating"].summary(made(constants)) if row[0] == "pair law"))
print(*[each.message for each in noted])
"""


WRITTEN = """
from ecume import _cache
written, write = [], _cache.write
_cache.write = lambda name, data: (written.append(name), write(name, data))
"""
"""Counts what a process compiles: what it writes."""


@pytest.fixture(scope="module")
def copy(tmp_path_factory):
    """The package with the new law: one file is changed."""
    made, file = Copy(tmp_path_factory.mktemp("copy"), ("src", "tests", "docs")), "laws/pair_laws.py"
    for name in ("yukawa-imports", "yukawa", "yukawa-row"):
        made.follow(file, name)
    return made


@pytest.mark.long
@pytest.mark.compiled
def test_two_floats_repel_by_a_new_law_with_friction_and_without(copy):
    """Compiled with friction, as plain Python without: the two cases find the law in different ways."""
    rough = REPELLING.replace("FRICTION", "0.3")
    (apart,) = copy.printed(rough)
    assert copy.printed(REPELLING.replace("FRICTION", "0.0"), NUMBA_DISABLE_JIT="1") == [apart]
    assert float(apart.removesuffix(" mm")) > 2.5
    assert copy.printed(f"{WRITTEN}{rough}\nprint(len(written), len(_cache.used) > 0)")[-1] == "0 True"


@pytest.mark.long
@pytest.mark.compiled  # as plain Python in a process of its own, whatever this one does: once is enough
def test_a_new_law_holds_what_all_others_hold(copy):
    chosen = "yukawa and not documentation"
    page = "tests/contracts/test_pair_laws.py"
    done = copy.python(
        "-m", "pytest", "-v", "-p", "no:cacheprovider", "-k", chosen, "-m", "not compiled", page,
        NUMBA_DISABLE_JIT="1",
    )  # fmt: skip
    assert done.returncode == 0, done.stdout
    assert re.search(r"[2-9]\d passed", done.stdout), done.stdout


@pytest.mark.long
@pytest.mark.compiled
def test_a_scene_sets_the_constants_of_a_new_law(copy):
    *found, refused, zero, negative, short, long, warned = copy.printed(SETTING, NUMBA_DISABLE_JIT="1")
    assert found == ["(2e-12, 0.0014)", "(3e-12, 0.0014)", "(3e-12, 0.002)"]
    assert "interaction.constants: got 3 numbers for the law 'yukawa'; expected strength (J*m), length (m)" in refused
    assert "interaction.constants: got a length of 0 m; expected one above 0" in zero
    assert "interaction.constants: got a length of -0.001 m; expected one above 0" in negative
    assert short == "0 ('pair law', 'yukawa', 'strength = 3e-12 J*m, length = 0.0014 m')"
    assert long == "0 ('pair law', 'yukawa', 'strength = 3e-12 J*m, length = 0.05 m')"
    assert warned.startswith("interaction.accuracy: at the cutoff, ")
    assert "which is above 0.0001; beyond, it is ignored" in warned


KNOWING = '''
import ecume
from ecume.citing import papers_of
from ecume.models.floating import FLOATING
from ecume.show.floating.figures import force_law
scene = ecume.load_scene("""
model = "floating"
duration = 1.0
frame_every = 0.1
[[particles]]
count = 2
radius = 1e-4
density = 1100.0
contact_angle = "90 deg"
[integration]
integrator = "overdamped"

[liquid]
temperature = "300 K"
[hydrodynamics]
brownian = true
[interaction]
law = "yukawa"
""")
print(papers_of(scene))
print([name for name, _, _ in FLOATING.summary(scene)])
print(force_law([next(ecume.simulate(scene))], scene).axes[0].get_legend_handles_labels()[1])
'''


@pytest.mark.long
@pytest.mark.compiled
def test_check_cite_and_the_figure_know_a_new_law(copy):
    papers, summary, drawn = copy.printed(KNOWING, NUMBA_DISABLE_JIT="1")
    assert "israelachvili2011" in papers
    assert "nicolson1949" not in papers
    assert "pair bond" in summary
    assert "repel" in drawn
