"""Every pair of options of a tank runs and satisfies the invariants of the model, or is refused with a physical
reason.
"""

import itertools
import re
from pathlib import Path

import numpy as np
import pytest
from tests.models.sph.scenes import OPEN, PERIODIC

from ecume.errors import SceneError
from ecume.laws.kernels import KERNELS
from ecume.models.model import DONE, EXCHANGE
from ecume.models.sph.integration.time_stepping import INTEGRATORS
from ecume.models.sph.rates.methods import DIFFUSIONS, FRICTIONS, PRESSURE_FORCES, PRESSURES
from ecume.models.sph.rates.shifting import SHIFTINGS
from ecume.models.sph.rates.surface_tension import TENSIONS
from ecume.models.sph.record import SPH
from ecume.models.sph.report.observation import invariants
from ecume.models.sph.setup.choices import TURBULENCES
from ecume.run import RunDirectory
from ecume.run.invariant_monitor import Watch
from ecume.scenes.schema import from_plain, to_plain

PAGE = Path(__file__).parents[2] / "docs" / "physics" / "sph-options.md"
REGION = {"low": [0.0, 0.0], "high": [1.0, 1.0]}
DRAG = {"liquid": {"viscosity": 0.02}}
FULL = {"tank": {"high": [1.0, 1.0], "top": {}}, "fluid": [{**REGION, "velocity": [0.1, 0.0]}]}
TENSE = {"liquid": {"surface_tension": 0.02}}


def methods(key, names, **more):
    """One option for each value of a key of `[method]`."""
    return {f"{key} = {name}": {"method": {key: name}, **more} for name in names if name != "none"}


FAMILIES = {
    "kernel": methods("kernel", [name for name in KERNELS if name != "wendland-c2"]),
    "density_diffusion": {**methods("density_diffusion", DIFFUSIONS), "density_diffusion = none":
                          {"method": {"density_diffusion": "none"}}},
    "pressure": methods("pressure", ["incompressible"], liquid={"sound_speed": None}),
    "viscosity_model": methods("viscosity_model", FRICTIONS, **DRAG),
    "pressure_force": {**methods("pressure_force", ["monaghan", "corrected"]),
                       **methods("pressure_force", ["transport"], **FULL)},
    "pressure_split": methods("pressure_split", ["modified"], **FULL),
    "shifting": methods("shifting", SHIFTINGS),
    "surface_tension_model": methods("surface_tension_model", TENSIONS, **TENSE),
    "turbulence": methods("turbulence", TURBULENCES),
    "integrator": {
        f"integrator = {name}": {"integration": {"integrator": name}} for name in INTEGRATORS
        if name not in ("symplectic", "projection")
    },
    "precision": methods("precision", ["single"]),
    "dimension": {"3D": {}},
    "tait_exponent": {"tait_exponent = 1": {"liquid": {"tait_exponent": 1.0}}},
    "walls": {"walls = dummy": {"tank": {"walls": "dummy"}}, "walls = reflect": {"tank": {"walls": "reflect"}}},
    "sides": {
        "periodic": {"tank": {"left": PERIODIC, "right": PERIODIC}},
        "inflow and outflow": {"tank": {"left": {"kind": "inflow", "speed": 0.2, "level": 1.0},
                                        "right": {"kind": "outflow", "level": 1.0}}},
        "lid": {"tank": {"bottom": {"velocity": [0.2, 0.0]}}},
        "piston": {"tank": {"left": {"motion": {"amplitude": 0.05, "frequency": 1.0}}}},
        "full tank": FULL,
    },
    "bodies": {"body": {"bodies": [{"low": [0.3, 0.3], "high": [0.7, 0.7], "density": 1.5}]}},
    "obstacles": {"obstacle": {"obstacles": [{"low": [0.3, 0.3], "high": [0.7, 0.7]}]}},
    "passive_tracers": {
        "tracers": {"passive_tracers": [{"positions": [[0.1, 0.2], [0.5, 0.9]]}]},
        "grains": {"passive_tracers": [{"positions": [[0.1, 0.2]], "radius": 0.01, "density": 2.0}]},
    },
    "base_excitation": {"base excitation": {"base_excitation": {"amplitude": [0.05, 0.0], "frequency": 1.0}}},
    "roll": {"roll": {"roll": {"amplitude": 0.05, "frequency": 1.0}}},
    "central_force": {
        "central force": {"central_force": {"angular_frequency": 1.0, "center": [0.5, 0.5]}, "gravity": [0.0, 0.0]},
    },
}  # fmt: skip
OPTIONS = {name: (family, changes) for family, options in FAMILIES.items() for name, changes in options.items()}
"""By name: a pair is one of two families."""
PAIRS = [pair for pair in itertools.combinations(OPTIONS, 2) if OPTIONS[pair[0]][0] != OPTIONS[pair[1]][0]]
TWO_KERNELS = [f"kernel = {name}" for name in ("quintic-spline", "wendland-c4")]


def tells_something_new(pair):
    """Whether a pair is tested. No sum hangs on which kernel it is; `test_sph_kernels` compares the sums of each kernel
    with its formulas.
    """
    kernels = [name for name in pair if OPTIONS[name][0] == "kernel"]
    return not kernels or kernels[0] in TWO_KERNELS


TRIED = [pair for pair in PAIRS if tells_something_new(pair)]
BASE = {
    "model": "sph", "duration": 0.1, "frame_every": 0.1, "spacing": 0.125, "gravity": [0.0, -1.0],
    "liquid": {"density": 1.0, "sound_speed": 10.0, "maximum_speed": 1.0},
    "tank": {"low": [0.0, 0.0], "high": [1.0, 1.5], "top": OPEN},
    "fluid": [REGION], "method": {"jitter": 0.05},
}  # fmt: skip
pytestmark = pytest.mark.filterwarnings("ignore:liu-quartic")
VECTORS = ("low", "high", "gravity", "center", "amplitude", "velocity")


def deepened(value, key=""):
    """A part of a scene, extended to 3D."""
    if isinstance(value, dict):
        return {name: deepened(part, name) for name, part in value.items()}
    if key in ("positions",):
        return [[*place, 0.5] for place in value]
    if isinstance(value, list) and value and isinstance(value[0], dict):
        return [deepened(part) for part in value]
    if key in VECTORS and isinstance(value, list):
        third = {"high": 0.7 if value[0] == 0.7 else 1.0, "low": 0.3 if value[0] == 0.3 else 0.0, "center": 0.5}
        return [*value, third.get(key, 0.0)]
    return value


def scene_with(names):
    """The small tank with these options."""
    plain = {**BASE}
    for name in names:
        for table, change in OPTIONS[name][1].items():
            plain[table] = {**plain.get(table, {}), **change} if isinstance(change, dict) else change
    if "3D" in names:
        plain = {**deepened(plain), "spacing": 0.2}
    return from_plain(plain)


def frames_of(scene, steps=3):
    """Frames at the start and after each of a few steps."""
    parameters = SPH.parameters(scene)
    state = SPH.start(scene, parameters)
    workspace = SPH.workspace(parameters, state, 1.0)
    yield SPH.observe(parameters, state, workspace)
    while int(state.step[0]) < steps:
        status = SPH.advance(parameters, state, workspace, 1)
        assert status in (DONE, EXCHANGE)
        if status == EXCHANGE:
            state = SPH.exchange(parameters, state)
            workspace = SPH.workspace(parameters, state, 1.0)
        yield SPH.observe(parameters, state, workspace)


def reason_of(names):
    """The reason why a pair is refused; None if it is not."""
    try:
        SPH.parameters(scene_with(names))
    except SceneError as error:
        return "; ".join(f"{fault.path}: {fault.message}" for fault in error.faults)
    return None


def marks(pair):
    """The marks of slow tests: so many take too long as plain Python, and each in 3D compiles separate time steps."""
    return [pytest.mark.compiled, *[pytest.mark.long] * ("3D" in pair)]


@pytest.mark.sampled(6)
@pytest.mark.parametrize(
    "pair",
    [pytest.param(pair, id=" + ".join(pair), marks=marks(pair)) for pair in TRIED],
)
def test_a_pair_of_options_keeps_mass_and_energy_or_is_refused(pair, tmp_path):
    if reason_of(pair) is not None:
        return
    scene = scene_with(pair)
    watch = Watch(RunDirectory(tmp_path), invariants(scene, SPH.parameters(scene)), "warn")
    for number, frame in enumerate(frames_of(scene)):
        assert all(np.isfinite(array).all() for array in frame.arrays.values())
        assert all(np.isfinite(value) for value in frame.numbers.values())
        watch.take(frame.time, frame.numbers, number)
    assert frame.arrays["velocity"].any()
    for verdict in watch.verdicts():
        assert verdict.held, verdict


HEAVIER = 1000.0
MASSES = ("density", "viscosity", "surface_tension")
"""Keys that carry a unit of mass, once."""


def heavier(value):
    """The scene with liquids, solids and tracers heavier by a factor, including viscosity and tension."""
    if isinstance(value, dict):
        return {
            key: HEAVIER * part if key in MASSES and isinstance(part, float) else heavier(part)
            for key, part in value.items()
        }
    return [heavier(part) for part in value] if isinstance(value, list | tuple) else value


SCALED = [*((name,) for name in OPTIONS), *(pair for pair in PAIRS if "pressure_force = monaghan" in pair)]


@pytest.mark.sampled(6)
@pytest.mark.parametrize(
    "names",
    [pytest.param(each, id=" + ".join(each), marks=marks(each)) for each in SCALED],
)
def test_a_motion_does_not_depend_on_the_unit_of_mass(names):
    """In units of a gram the numbers of the scene are a thousand times larger, and the motion is the same."""
    if reason_of(names) is not None:
        return
    scene = scene_with(names)
    one = list(frames_of(scene))[-1]
    other = list(frames_of(from_plain(heavier(to_plain(scene)))))[-1]
    single = scene.method.precision == "single"
    for name in ("position", "velocity"):
        size = np.abs(one.arrays[name]).max()
        np.testing.assert_allclose(other.arrays[name], one.arrays[name], rtol=0, atol=(1e-3 if single else 1e-9) * size)
    change = np.abs(one.arrays["density"] - 1.0).max()
    scaled, atol = other.arrays["density"] / HEAVIER, (1e-3 if single else 1e-9) * max(change, 1e-6)
    np.testing.assert_allclose(scaled, one.arrays["density"], rtol=0, atol=atol)


def test_every_row_of_the_tables_is_among_the_options():
    for table in (
        KERNELS,
        DIFFUSIONS,
        FRICTIONS,
        PRESSURES,
        PRESSURE_FORCES,
        SHIFTINGS,
        TENSIONS,
        TURBULENCES,
        INTEGRATORS,
    ):
        defaults = {"wendland-c2", "sum", "none", "symplectic", "projection", "tait"}
        assert all(any(name.endswith(f"= {row}") for name in OPTIONS) for row in table if row not in defaults)


def refusals():
    """The rows of the table in the documentation, one for each refused pair."""
    found = {pair: reason_of(pair) for pair in PAIRS}
    return [f"| {one} | {other} | {reason} |" for (one, other), reason in found.items() if reason is not None]


@pytest.mark.long
@pytest.mark.uncompiled
def test_the_documentation_lists_the_pairs_that_are_refused():
    listed = re.search(r"<!-- refused pairs -->\n\n(.*?)\n\n<!-- end -->", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert listed is not None
    assert listed[1].splitlines()[2:] == refusals()


if __name__ == "__main__":
    print("\n".join(["| option | with | reason |", "|---|---|---|", *refusals()]))
