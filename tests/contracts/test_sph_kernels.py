"""Every kernel of the table runs in a tank by the formula of its row, and a new one needs no other file."""

import json
import os
import re
import shutil
import subprocess
import sys
import textwrap
from pathlib import Path

import numpy as np
import pytest
from tests.models.sph.scenes import free_blob, tank

import ecume
from ecume import _jit
from ecume.laws.kernels import KERNEL_CODES, KERNELS, kernel
from ecume.models.sph.integration.passive_particles import surroundings
from ecume.models.sph.rates.kernel_loops import kernel_type, slope_of, value_of
from ecume.models.sph.rates.right_hand_side import evaluate_accelerations, evaluate_density_rate, evaluate_rates
from ecume.models.sph.record import SPH
from ecume.models.sph.report.check_report import lattice_neighbors, neighbor_remark
from ecume.models.sph.setup.choices import smoothing_of
from ecume.scenes.schema import from_plain, to_plain

ROOT = Path(__file__).parents[2]
PACKAGE = Path(ecume.__file__).parent
EACH = pytest.mark.parametrize("name", KERNELS)
# Plain Python takes most of a minute for each kernel in 3D.
DIMENSIONS = pytest.mark.parametrize("dimension", [2, pytest.param(3, marks=pytest.mark.compiled)])
pytestmark = [pytest.mark.filterwarnings("ignore:liu-quartic"), pytest.mark.sampled(2)]


@_jit.compiled
def all_slopes(q, code, found):
    for i in range(len(q)):
        found[i] = slope_of(q[i], code)


@_jit.compiled
def all_values(q, code, found):
    for i in range(len(q)):
        found[i] = value_of(q[i], code)


@EACH
@pytest.mark.parametrize(("compute", "column"), [(all_slopes, "slope"), (all_values, "value")])
def test_compiled_loops_take_the_formula_of_the_row(name, compute, column):
    form = KERNELS[name]
    q = np.linspace(0.0, 1.1 * form.support, 300)
    found = np.zeros_like(q)
    compute(q, KERNEL_CODES[name], found)
    np.testing.assert_allclose(found, getattr(form, column)(q), rtol=1e-13, atol=1e-13 * abs(form.value(0.0)))


def at_start(scene):
    """Parameters, state and workspace of a blob whose density varies."""
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    state.density[...] *= 1.0 + 0.01 * np.sin(7.0 * state.position[0])
    return parameters, state, SPH.workspace(parameters, state, 1.0)


def expected_rates(one, parameters, state):
    """The rates of density and velocity as NumPy sums over all pairs with the formulas of a kernel: continuity, the
    pressure force (p_i + p_j), and the viscous force of Morris et al. with equal viscosities.
    """
    material, h = parameters.material, float(parameters.numbers.smoothing_length)
    apart = state.position[:, :, None] - state.position[:, None, :]
    gradient = one.gradient(np.moveaxis(apart, 0, -1), h)
    volume = state.mass / state.density
    difference = state.velocity[:, None, :] - state.velocity[:, :, None]
    density_rate = -state.density * np.einsum("j,aij,ija->i", volume, difference, gradient)
    ratio = state.density / material.density
    pressure = material.density * material.sound_speed**2 / material.exponent * (ratio**material.exponent - 1.0)
    pairs = pressure[:, None] + pressure[None, :]
    force = -np.einsum("j,ij,ija->ai", volume, pairs, gradient)
    squares = np.sum(apart**2, axis=0) + np.eye(len(volume))
    over_distance = np.einsum("aij,ija->ij", apart, gradient) / squares
    force -= 2.0 * material.viscosity * np.einsum("j,aij,ij->ai", volume, difference, over_distance)
    return density_rate, force / state.density


def close(found, expected):
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())


@pytest.mark.sampled(3)
@EACH
@DIMENSIONS
def test_the_sums_of_a_tank_are_those_of_the_formulas_of_the_row(name, dimension):
    method = {"viscosity_model": "morris", "density_diffusion": "none", "acoustic_damping": 0.0}
    scene = free_blob(dimension, kernel=name, viscosity=1.0, **method)
    parameters, state, workspace = at_start(scene)
    density_rate, acceleration = expected_rates(kernel(name, dimension), parameters, state)
    evaluate_density_rate(parameters, state, workspace)
    close(state.density_rate, density_rate)
    evaluate_accelerations(parameters, state, workspace, parameters.time_step)
    close(state.acceleration, acceleration)
    state.density_rate[...], state.acceleration[...] = 0.0, 0.0
    evaluate_rates(parameters, state, workspace, parameters.time_step)
    close(state.density_rate, density_rate)
    close(state.acceleration, acceleration)


@EACH
@DIMENSIONS
def test_the_mass_density_summed_over_particles_is_that_of_the_row(name, dimension):
    spec = {"count": 20, "low": [-0.3] * dimension, "high": [0.3] * dimension}
    scene = from_plain({**to_plain(free_blob(dimension, kernel=name)), "passive_tracers": [spec]})
    parameters, state, workspace = at_start(scene)
    evaluate_accelerations(parameters, state, workspace, parameters.time_step)
    found = surroundings(parameters, workspace, state.passive_position).fraction
    apart = state.position[:, :, None] - state.passive_position[:, None, :]
    weights = kernel(name, dimension).value(np.sqrt(np.sum(apart**2, axis=0)), smoothing_of(scene))
    np.testing.assert_allclose(found, (state.mass / state.density) @ weights, rtol=1e-12)
    assert found.mean() == pytest.approx(1.0, abs=0.1)


@EACH
@pytest.mark.compiled
def test_a_tank_keeps_at_rest_under_every_kernel(name):
    scene = tank(kernel=name, walls="dummy", jitter=0.0)
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    before = state.density.copy()
    SPH.advance(parameters, state, SPH.workspace(parameters, state, 1.0), 20)
    # A kernel whose value and slope do not belong together would press the liquid out of its dummies.
    assert np.abs(state.density / before - 1.0).max() < 0.01
    assert np.abs(state.velocity).max() < 0.2


@pytest.mark.parametrize("code", [-1, len(KERNELS)])
def test_a_number_that_no_kernel_has_is_refused(code):
    parameters, state, workspace = at_start(free_blob())
    parameters.numbers.kernel = code
    with pytest.raises(ValueError, match=rf"got {code}; expected a number of KERNEL_CODES"):
        evaluate_accelerations(parameters, state, workspace, parameters.time_step)
    with pytest.raises(KeyError):
        kernel_type(parameters.constants)


def test_the_table_cannot_change_while_the_program_runs():
    with pytest.raises(TypeError):
        KERNELS["mine"] = KERNELS["lucy"]
    with pytest.raises(TypeError):
        KERNEL_CODES["mine"] = 5


@EACH
def test_the_default_smoothing_length_of_a_kernel_gives_neither_few_nor_many_neighbors(name):
    for dimension in (2, 3):
        reach = KERNELS[name].support * KERNELS[name].smoothing[dimension]
        remark = neighbor_remark(lattice_neighbors(dimension, reach), dimension, name)
        assert not remark.startswith(("few", "many"))


RECIPE = (ROOT / "docs" / "extend" / "kernel.md").read_text(encoding="utf-8")
FORMULAS, ROW = (
    textwrap.indent(textwrap.dedent(block), "    " * inside)
    for inside, block in enumerate(re.findall(r"```python\n(.*?) *```", RECIPE, re.DOTALL))
)
USE = """
import json, sys
import numpy as np
from ecume.laws.kernels import KERNELS, kernel
from ecume.models.sph.fields import FIELD
from ecume.models.sph.rates.right_hand_side import evaluate_accelerations, evaluate_density_rate
from ecume.models.sph.rates.sums import CONTINUITY, PRESSURE
from tests.contracts.test_sph_kernels import at_start, close, expected_rates
from tests.models.sph.scenes import free_blob

def off(found, expected):
    return float(np.abs(found - expected).max() / np.abs(expected).max())

name = list(KERNELS)[-1]
parameters, state, workspace = at_start(free_blob(kernel=name, density_diffusion="none", artificial_viscosity=0.0))
density_rate, acceleration = expected_rates(kernel(name, 2), parameters, state)
evaluate_density_rate(parameters, state, workspace)
evaluate_accelerations(parameters, state, workspace, parameters.time_step)
loops = [taken.loop.alone for taken in (CONTINUITY[FIELD.density], PRESSURE)]
print(json.dumps({
    "name": name,
    "off": max(off(state.density_rate, density_rate), off(state.acceleration, acceleration)),
    "acceleration": float(np.abs(state.acceleration).max()),
    "compiled": sum(sum(loop.stats.cache_misses.values()) for loop in loops),
}))
"""


@pytest.fixture(scope="module")
def recipe(tmp_path_factory):
    """The only file of a copy of the package that the recipe edits, the folder of the copy, and the first use of a
    tank.
    """
    folder = tmp_path_factory.mktemp("kernel")
    copy = folder / "src" / "ecume"
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    file = re.search(r"`src/ecume/([\w/]+\.py)`", RECIPE)[1]
    table = (copy / file).read_text(encoding="utf-8")
    assert table.count("\n\nclass Form(") == 1
    table = table.replace("\n\nclass Form(", f"\n\n{FORMULAS}\n\nclass Form(")
    head, tail = table.split("})  # fmt: skip\n")
    (copy / file).write_text(f"{head}{ROW}}})  # fmt: skip\n{tail}", encoding="utf-8")
    return copy / file, folder, used(folder)


@pytest.mark.long
@pytest.mark.compiled
def test_the_recipe_for_a_kernel_works_as_it_is_written_and_edits_one_file(recipe):
    _, _, first = recipe
    assert first["name"] not in KERNELS
    assert first["compiled"] == 2
    assert first["off"] < 1e-9
    assert first["acceleration"] > 1.0


@pytest.mark.long
@pytest.mark.compiled
def test_a_new_kernel_is_compiled_once_and_again_when_it_is_edited(recipe):
    file, folder, first = recipe
    assert used(folder)["compiled"] == 0
    text, law = file.read_text(encoding="utf-8"), "return -6.0 * (left * left)"
    assert text.count(law) == 1
    file.write_text(text.replace(law, "return -3.0 * (left * left)"), encoding="utf-8")
    edited = used(folder)
    assert edited["compiled"] == 2
    assert edited["off"] < 1e-9
    assert edited["acceleration"] == pytest.approx(0.5 * first["acceleration"], rel=1e-9)


def used(folder):
    """The result of a tank with the last kernel of the package in a folder, in a new process."""
    places = {"ECUME_CACHE_DIR": str(folder / "cache"), "PYTHONPATH": f"{folder / 'src'}{os.pathsep}{ROOT}"}
    words = [sys.executable, "-c", USE]
    done = subprocess.run(words, env={**os.environ, **places}, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])
