"""Each option of tracers with each other one: a few steps in a small tank, or a physical reason against it.

The matrix in `docs/physics/tracers.md` is written by `python -m tests.contracts.test_tracer_option_pairs`.
"""

import copy

import pytest
from tests.contracts.option_pairs import Pairs, matrix, merged, section, write_section

OPENING = {"openings": [{"wall": 0, "low": [0.0, 0.004], "high": [0.0, 0.012]}]}
OPTIONS = {
    "drag none": {"hydrodynamics": {"drag": "none"}},
    "drag stokes": {"hydrodynamics": {"drag": "stokes"}},
    "integrator inertial": {"integration": {"integrator": "inertial"}},
    "integrator overdamped": {"integration": {"integrator": "overdamped"}},
    "brownian": {"hydrodynamics": {"brownian": True}},
    "no added mass": {"hydrodynamics": {"added_mass": False}},
    "time_step": {"integration": {"time_step": 2e-5}},
    "named liquid": {"liquid": {"name": "glycerol", "temperature": 300.0}},
    "flow": {"flow": {"velocity": [0.02, 0.0]}},
    "shear_rate": {"flow": {"shear_rate": 2.0}},
    "no gravity": {"gravity": 0.0},
    "no viscosity": {"liquid": {"viscosity": 0.0}},
    "3D": {"dimensions": 3},
    "round tank": {"tank": {"radius": 0.01}},
    "polygon": {"tank": {"vertices": [[0.0, 0.016], [0.0, 0.0], [0.02, 0.0], [0.018, 0.016]]}},
    "no tank": {"tank": None},
    "restitution": {"rebound": {"restitution": 0.5, "tangential_restitution": 0.8}},
    "obstacle": {"obstacles": [{"low": [0.009, 0.006], "high": [0.011, 0.008]}]},
    "opening": OPENING,
    "opening with a rate": merged(OPENING, {"openings": [{"rate": 2000.0, "velocity": [0.05, 0.0]}]}),
    "opening with a concentration": merged(OPENING, {"openings": [{"concentration": 1e6, "velocity": [0.05, 0.0]}]}),
    "given positions": {"places": [[0.005, 0.004], [0.006, 0.007]]},
    "dust": {"dust": 1e-6},
    "moving start": {"start": [0.2, 0.1]},
}
TANK = {"high": [0.02, 0.016]}


def plain_of(one, other):
    """The scene of two options: grains of sand and dust."""
    asked = copy.deepcopy(merged(OPTIONS[one], OPTIONS[other]))
    deep, tank = asked.pop("dimensions", 2) - 2, asked.pop("tank", TANK)
    places, start, rebound = asked.pop("places", []), asked.pop("start", None), asked.pop("rebound", {})

    def vector(flat, depth=0.004):
        return [flat[0], *[depth] * deep, flat[1]]

    def speed(flat):
        return vector(flat, 0.0)

    if tank is not None:
        sized = {"high": vector(TANK["high"], 0.008)} if "high" in tank else dict(tank)
        if "radius" in sized:
            sized["dimensions"] = 2 + deep
        if "vertices" in sized and deep:
            sized["vertices"] = [[x, y, z] for x, z in sized["vertices"] for y in (0.0, 0.008)]
        asked["tank"] = sized | rebound
    for table in (*asked.get("obstacles", []), *asked.get("openings", [])):
        for corner, depth in (("low", 0.002), ("high", 0.006)):
            table[corner] = [table[corner][0], *[depth] * deep, table[corner][1]]
        if "velocity" in table:
            table["velocity"] = speed(table["velocity"])
    if "velocity" in asked.get("flow", {}):
        asked["flow"]["velocity"] = speed(asked["flow"]["velocity"])
    particles = [
        {"radius": 2e-4, "density": 2500.0, "count": 3},
        {"radius": asked.pop("dust", 2e-5), "density": 1100.0, "count": 3},
    ]
    for species in particles:
        if places or tank is None:
            species |= {"positions": [vector(place) for place in places or OPTIONS["given positions"]["places"]]}
            species["count"] = len(species["positions"])
        if start:
            species["velocity"] = speed(start)
    base = {"model": "tracers", "duration": 0.004, "frame_every": 0.002, "seed": 5, "particles": particles}
    return merged(base, asked)


pytestmark = pytest.mark.filterwarnings("ignore::ecume.models.tracers.record.FlowWarning")

PAIRS = Pairs("tracers.md", OPTIONS, plain_of)


@pytest.mark.sampled(4)
@pytest.mark.compiled
@pytest.mark.parametrize(("one", "other"), PAIRS.names, ids=lambda name: name)
def test_a_pair_of_options_works_or_is_refused_for_a_reason(one, other):
    PAIRS.require_works_or_reason(one, other)


def test_the_page_has_a_row_and_a_column_for_each_option():
    """What it says of each pair is compared above with what becomes of that."""
    assert section(PAIRS.page) == matrix(OPTIONS, PAIRS.stated)


if __name__ == "__main__":
    write_section(PAIRS.page, PAIRS.matrix())
