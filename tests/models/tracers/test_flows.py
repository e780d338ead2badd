"""Tracers in flows that vary: exact solutions, grids, functions of the user, periodic sides and deposits."""

import math

import numpy as np
import pytest

from ecume.analysis.series import tracks
from ecume.citing import papers_of
from ecume.errors import BadInput, SceneError
from ecume.laws import carrier_flows
from ecume.models import MODELS, field_files, gridded_flows
from ecume.models.field_files import grid_of
from ecume.models.gridded_flows import Grid
from ecume.models.tracers.check_report import covered
from ecume.models.tracers.liquid_flow import varying_flow
from ecume.models.tracers.named_flows import NAMED_FLOWS
from ecume.models.tracers.record import FlowWarning
from ecume.models.tracers.tank import bounds
from ecume.models.user_laws import bind
from ecume.run import run
from ecume.scenes.fields import FieldSpec
from ecume.scenes.load import load_scene
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate
from ecume.units import factor

NAMED = {
    "channel": {"speed": 0.3}, "couette": {"speed": 0.3}, "tube": {"speed": 0.3}, "duct": {"speed": 0.3},
    "stagnation": {"rate": 0.4}, "rotation": {"rate": 0.5}, "cellular": {"speed": 0.3, "wavelength": 1.0},
    "double-gyre": {"speed": 0.3, "swing": 0.25, "period": 3.0}, "wave": {"speed": 0.1, "wavelength": 1.0},
    "abc": {"speed": 0.2, "wavelength": 1.0},
}  # fmt: skip


def scene_of(flow, dimensions=2, **changes):
    """Fluid particles in a box of liquid."""
    high = [2.0, 1.0] if dimensions == 2 else [2.0, 1.0, 1.0]
    plain = {
        "model": "tracers", "duration": 0.4, "frame_every": 0.2, "gravity": 9.81, "tank": {"high": high},
        "particles": [{"radius": 1e-6, "density": 1000.0, "count": 4}], "flow": flow,
        "integration": {"integrator": "overdamped"},
    }  # fmt: skip
    return from_plain({**plain, **changes})


def named(name, dimensions, **changes):
    return scene_of({"name": name, **NAMED[name]}, dimensions, **changes)


EVERY = [(name, d) for name, row in NAMED_FLOWS.items() for d in row.dimensions]


@pytest.mark.parametrize(("name", "dimensions"), EVERY)
def test_a_named_flow_has_no_divergence_and_crosses_no_wall(name, dimensions):
    scene = named(name, dimensions)
    flow = varying_flow(scene, bounds(scene))
    low, high = (np.array(corner) for corner in bounds(scene))
    points = np.random.default_rng(1).uniform(low + 0.05, high - 0.05, (40, dimensions))
    divergence, size = np.zeros(40), 0.0
    for axis in range(dimensions):
        way = np.eye(dimensions)[axis] * 1e-5
        slope = (flow.velocity(points + way, 0.2) - flow.velocity(points - way, 0.2)) / 2e-5
        divergence += slope[:, axis]
        size = max(size, float(np.abs(slope).max()))
    assert size > 0.01
    assert np.abs(divergence).max() < 1e-8 * size
    for axis in range(dimensions):
        if "xyz"[axis if axis < dimensions - 1 else 2] in NAMED_FLOWS[name].walls:
            for side in (low[axis], high[axis]):
                wall = points.copy()
                wall[:, axis] = side
                assert np.abs(flow.velocity(wall, 0.2)[:, axis]).max() < 1e-12


def test_the_mean_speeds_of_tubes_and_ducts_are_those_of_the_key():
    x = (np.arange(200) + 0.5) / 200
    r = 0.5 * np.sqrt(x)
    assert np.mean([carrier_flows.tube_speed(a, 0.5, 0.3) for a in r]) == pytest.approx(0.3, rel=1e-4)
    slope = 0.3 / carrier_flows.duct_mean(2.0, 1.0)
    duct = [carrier_flows.duct_speed(a, b, 2.0, 1.0, slope) for a in 2 * x[::5] - 1 for b in x[::5] - 0.5]
    assert np.mean(duct) == pytest.approx(0.3, rel=1e-2)


def test_a_duct_is_the_same_lying_and_standing():
    """The series along a short side converges slowly, and cancels where the duct is a thin slot."""
    for y, z in ((0.3, 2e-4), (0.0, 0.0), (0.49, -4e-4)):
        lying = carrier_flows.duct_speed(y, z, 1.0, 1e-3, 0.3)
        assert carrier_flows.duct_speed(z, y, 1e-3, 1.0, 0.3) == lying
        assert 0.0 < lying <= 0.3
    assert carrier_flows.duct_mean(1e-3, 1.0) == carrier_flows.duct_mean(1.0, 1e-3)


def test_the_scales_of_a_flow_far_finer_than_the_tank_are_found():
    """At a wavelength of 1e-4 of the tank differences over such a length would be zero."""
    scene = scene_of({"name": "cellular", "speed": 0.1, "wavelength": 2e-4})
    scales = varying_flow(scene, bounds(scene)).scales
    assert scales.rate == pytest.approx(0.1 * 2.0 * math.pi / 2e-4, rel=0.05)


def reference(scene, start, time):
    """The path of a particle of the liquid, by an integrator of order 8."""
    from scipy.integrate import solve_ivp

    flow = varying_flow(scene, bounds(scene))
    found = solve_ivp(lambda t, x: flow.velocity(x[None], t)[0], (0.0, time), start, "DOP853", rtol=1e-12, atol=1e-14)
    return found.y[:, -1]


@pytest.mark.parametrize(("name", "dimensions"), [("double-gyre", 2), ("cellular", 2), ("abc", 3), ("wave", 2)])
def test_paths_are_of_fourth_order(name, dimensions):
    errors = []
    for steps in (4, 8):
        start = [0.7, 0.4] if dimensions == 2 else [0.7, 0.4, 0.5]
        scene = named(
            name, dimensions, gravity=9.81, integration={"integrator": "overdamped", "time_step": 0.4 / steps},
            frame_every=0.4, particles=[{"radius": 1e-6, "density": 1000.0, "positions": [start]}],
        )  # fmt: skip
        *_, last = simulate(scene)
        errors.append(np.abs(last.arrays["position"][0] - reference(scene, start, 0.4)).max())
    assert errors[0] < 1e-3
    assert math.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.6)


def test_flights_in_a_vortex_are_of_second_order():
    found = []
    for steps in (20, 40, 80):
        scene = scene_of(
            {"name": "rotation", "rate": 5.0}, gravity=0.0, duration=0.4, frame_every=0.4,
            integration={"integrator": "inertial", "time_step": 0.4 / steps},
            particles=[{"radius": 5e-4, "density": 2000.0, "positions": [[1.2, 0.6]]}],
        )  # fmt: skip
        *_, last = simulate(scene)
        found.append(last.arrays["position"][0])
    ratio = np.abs(found[0] - found[1]).max() / np.abs(found[1] - found[2]).max()
    assert math.log2(ratio) == pytest.approx(2.0, abs=0.4)


def test_a_pulse_multiplies_the_velocity():
    scene = scene_of({"name": "channel", "speed": 0.3, "pulse": {"amplitude": 2.0, "period": 1.0, "decay_rate": 0.5}})
    flow = varying_flow(scene, bounds(scene))
    place = np.array([[0.5, 0.5]])
    factor = (1.0 + 2.0) * math.exp(-0.125)
    assert flow.velocity(place, 0.25)[0, 0] == pytest.approx(0.45 * factor, rel=1e-12)


@pytest.mark.parametrize(
    ("flow", "words"),
    [
        ({"name": "chanel", "speed": 1.0}, r"flow\.name: got 'chanel'; did you mean channel"),
        ({"name": "channel"}, r"flow\.speed: is missing; the flow channel needs it"),
        ({"name": "tube", "speed": 1.0}, r"flow\.name: got 'tube' in 2D; expected a scene in 3D"),
        ({"name": "channel", "speed": 1.0, "swing": 0.1}, r"flow\.swing: is not used by the flow channel"),
        ({"speed": 1.0}, r"flow\.speed: is not used by a uniform flow"),
        ({"name": "channel", "speed": 1.0, "pulse": {"amplitude": 1.0}}, r"flow\.pulse\.period: is missing"),
        ({"name": "channel", "speed": 1.0, "pulse": {"period": 1.0}}, r"flow\.pulse\.period: is not used without"),
        ({"name": "double-gyre", "speed": 1.0, "period": 1.0}, r"flow\.period: is not used without swing"),
    ],
)
def test_a_flow_that_cannot_be_is_refused_with_its_key(flow, words):
    with pytest.raises(SceneError, match=words):
        MODELS["tracers"].parameters(scene_of(flow))


def rows_of(flow, dimensions=2, **changes):
    """The rows of `ecume check` by name."""
    return {row[0]: row[1:] for row in MODELS["tracers"].summary(scene_of(flow, dimensions, **changes))}


def test_check_names_the_flow_and_what_does_not_act():
    assert rows_of({"name": "rotation", "rate": 1.0})["flow"][1].startswith("rotation: largest speed")
    lifted = rows_of({"shear_rate": 0.5}, hydrodynamics={"lift": True})
    assert lifted["flow"][1].startswith("uniform or sheared")
    assert lifted["forces of the flow"][0] == "none on 4 of 4 particles"
    assert lifted["time step"][1] == "of fourth order in a flow that varies"
    assert rows_of({"velocity": [0.1, 0.0]})["time step"][1] == "exact between walls for linear drag"
    assert rows_of({"name": "tube", "speed": 0.1}, 3)["wall of the tube"][0] == "none"


def test_the_papers_of_a_flow_are_its_own():
    linear = set(papers_of(scene_of({"name": "rotation", "rate": 1.0}))) - {"stokes1851", "schiller1933"}
    assert not linear
    pulse = {"amplitude": 0.5, "period": 1.0}
    assert {"batchelor1967", "womersley1955"} <= set(
        papers_of(scene_of({"name": "channel", "speed": 1.0, "pulse": pulse}))
    )
    assert "pollock1988" not in papers_of(scene_of({"field": {"file": "gyre.npz"}}))


# --- Grids


def nodes(n, formula):
    """A grid of a flow in a box of 2 by 1."""
    x, z = np.linspace(0.0, 2.0, 2 * n + 1), np.linspace(0.0, 1.0, n + 1)
    u, w = formula(*np.meshgrid(x, z, indexing="ij"))
    return Grid((0.0, 0.0), (x[1], z[1]), np.zeros(1), np.stack([u, w], axis=-1)[None])


def gyre(x, z):
    pi = math.pi
    return -np.sin(pi * x) * np.cos(pi * z), np.cos(pi * x) * np.sin(pi * z)


def test_a_stream_function_on_a_grid_is_of_third_order_and_has_no_divergence():
    points, errors = np.random.default_rng(2).uniform((0.0, 0.0), (2.0, 1.0), (100, 2)), []
    for n in (8, 16):
        fit = gridded_flows.fitted(nodes(n, gyre), "divergence-free")
        assert fit.removed < 1e-3
        found = np.array([gridded_flows.stream_velocity(fit.shape, x, 0.0, z, 0.0) for x, z in points])
        errors.append(np.abs(found[:, [0, 2]] - np.array(gyre(*points.T)).T).max())
    assert math.log2(errors[0] / errors[1]) > 2.7
    shape, d = fit.shape, 1e-6
    for x, z in points[:20]:
        cell = 2.0 / 32
        x, z = (math.floor(x / cell) + 0.5) * cell, (math.floor(z / cell) + 0.5) * cell
        along = [gridded_flows.stream_velocity(shape, x + s, 0.0, z, 0.0)[0] for s in (d, -d)]
        up = [gridded_flows.stream_velocity(shape, x, 0.0, z + s, 0.0)[2] for s in (d, -d)]
        assert abs(along[0] - along[1] + up[0] - up[1]) / (2 * d) < 1e-8


def test_no_liquid_flows_through_the_edges_of_land():
    grid = nodes(10, gyre)
    grid.velocity[0, 5:9, 3:6] = np.nan
    shape = gridded_flows.fitted(grid, "divergence-free").shape
    for share in np.linspace(0.0, 1.0, 11):
        z, x = 0.3 + 0.2 * share, 0.5 + 0.3 * share
        assert abs(gridded_flows.stream_velocity(shape, 0.5, 0.0, z, 0.0)[0]) < 1e-15
        assert abs(gridded_flows.stream_velocity(shape, x, 0.0, 0.3, 0.0)[2]) < 1e-15


def test_fluxes_in_3d_have_no_divergence_even_beside_land():
    dice = np.random.default_rng(3)
    velocity = dice.normal(size=(1, 6, 5, 4, 3))
    velocity[0, 2:4, 1:3, 1:3] = np.nan
    fit = gridded_flows.fitted(Grid((0.0,) * 3, (0.1, 0.2, 0.3), np.zeros(1), velocity), "divergence-free")
    shape = fit.shape
    rates = [np.diff(part[0], axis=axis) / step for axis, (part, step) in
             enumerate(zip((shape.along, shape.across, shape.upward), shape.step, strict=True))]  # fmt: skip
    assert np.abs(sum(rates)).max() < 1e-9
    assert shape.along[0, 2, 1, 1] == 0.0
    assert 0.1 < fit.removed < 1.0


def test_no_liquid_flows_through_sides_of_a_grid_in_3d_along_which_the_file_s_velocities_are():
    """They have divergence, which the smallest change of fluxes would lead out through these sides."""
    velocity = np.random.default_rng(4).normal(size=(1, 6, 5, 4, 3))
    velocity[0, :, 0, :, 1] = velocity[0, :, :, -1, 2] = 0.0
    velocity[0, 0, :, :, 0] = velocity[0, -1, :, :, 0] = 0.0
    shape = gridded_flows.fitted(Grid((0.0,) * 3, (0.1, 0.2, 0.3), np.zeros(1), velocity), "divergence-free").shape
    for closed in (shape.along[0, 0], shape.along[0, -1], shape.across[0, :, 0], shape.upward[0, ..., -1]):
        assert not closed.any()
    assert np.abs(shape.across[0, :, -1]).min() > 0.0


def test_fluxes_of_a_periodic_grid_in_3d_are_periodic_and_the_same_through_all_sections():
    velocity = np.random.default_rng(5).normal(size=(1, 6, 5, 4, 3))
    velocity[0, :, [0, -1], :, 1] = velocity[0, :, :, [0, -1], 2] = 0.0
    velocity[0, -1] = velocity[0, 0]
    grid = Grid((0.0,) * 3, (0.1, 0.2, 0.3), np.zeros(1), velocity)
    along = gridded_flows.fitted(grid, "divergence-free", (0,)).shape.along[0]
    assert np.array_equal(along[0], along[-1])
    flux = along.sum(axis=(1, 2))
    assert flux == pytest.approx(np.full(6, flux[0]), rel=1e-9)
    assert abs(flux[0]) > 0.1


def saved(folder, name="gyre.npz", instants=1):
    grid = nodes(12, gyre)
    x, z = np.linspace(0.0, 2.0, 25), np.linspace(0.0, 1.0, 13)
    scale = np.arange(1.0, instants + 1.0)[:, None, None]
    arrays = {"x": 100.0 * x, "y": 100.0 * z, "u": scale * grid.velocity[..., 0], "v": scale * grid.velocity[..., 1]}
    np.savez(folder / name, t=np.arange(float(instants)), **arrays)


TEXT = """
model = "tracers"
duration = "1 s"
frame_every = "0.5 s"
[tank]
high = ["2 m", "1 m"]
[flow.field]
file = "{file}"
length_unit = "1 cm"
[[particles]]
radius = "1 um"
density = 1000.0
positions = [["0.7 m", "0.4 m"]]
"""


def test_a_flow_from_a_file_carries_particles_as_the_formula_does(tmp_path):
    saved(tmp_path)
    (tmp_path / "scene.toml").write_text(TEXT.format(file="gyre.npz"))
    scene = load_scene(tmp_path / "scene.toml")
    *_, last = simulate(scene)
    formula = scene_of({"name": "double-gyre", "speed": 1.0}, duration=1.0)
    expected = reference(formula, [0.7, 0.4], 1.0)
    assert last.arrays["position"][0] == pytest.approx(expected, abs=5e-4)
    shown = next(row for row in MODELS["tracers"].summary(scene) if row[0] == "divergence")
    assert 0.0 < float(shown[1].removesuffix(" %")) < 0.002


@pytest.mark.long
def test_velocities_change_linearly_between_instants(tmp_path):
    saved(tmp_path, instants=2)
    (tmp_path / "scene.toml").write_text(TEXT.format(file="gyre.npz"))
    scene = load_scene(tmp_path / "scene.toml")
    flow, place = varying_flow(scene, bounds(scene)), np.array([[0.3, 0.2]])
    assert flow.velocity(place, 0.25) == pytest.approx(1.25 * flow.velocity(place, 0.0), rel=1e-12)
    assert flow.velocity(place, 9.0) == pytest.approx(2.0 * flow.velocity(place, 0.0), rel=1e-12)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda a: a.pop("v"), "has no 'v'; it has"),
        (lambda a: a.update(x=a["x"] ** 2), "uneven along axis 0"),
        (lambda a: a.update(u=a["u"][:, :5]), "its velocities|dimension|shape"),
        (lambda a: a.update(u=a["u"] + np.inf), "infinite velocity"),
        (lambda a: a.update(y=np.ones(13)), "all nodes along axis 1 are at 0.01 m"),
        (lambda a: a.update(x=np.outer(a["x"], np.ones(13))), "'x' has 2 dimensions; expected the nodes along one"),
        (lambda a: a.update(x=a["x"][0]), "'x' has 0 dimensions"),
        (lambda a: a.update(u=a["u"] + 1j), "complex numbers; expected real"),
        (lambda a: a.update(u=a["u"].astype(str)), "<U.*; expected real"),
    ],
)
def test_a_file_that_is_no_grid_is_refused(tmp_path, change, words):
    saved(tmp_path)
    arrays = dict(np.load(tmp_path / "gyre.npz"))
    change(arrays)
    with np.errstate(invalid="ignore"):
        np.savez(tmp_path / "gyre.npz", **arrays)
    (tmp_path / "scene.toml").write_text(TEXT.format(file="gyre.npz"))
    with pytest.raises(SceneError, match=words):
        MODELS["tracers"].parameters(load_scene(tmp_path / "scene.toml"))


def test_a_file_beside_the_tank_is_refused_and_none_is_no_archive(tmp_path):
    (tmp_path / "scene.toml").write_text(TEXT.format(file="gyre.npz").replace("1 cm", "1 m"))
    saved(tmp_path)
    arrays = dict(np.load(tmp_path / "gyre.npz"))
    np.savez(tmp_path / "gyre.npz", **{**arrays, "y": arrays["y"] + 10.0})
    with pytest.raises(SceneError, match=r"from 10 m to 110 m along y, the tank from 0 m to 1 m; .* set length_unit"):
        MODELS["tracers"].parameters(load_scene(tmp_path / "scene.toml"))
    with pytest.raises(SceneError, match=r"there is no file 'lost\.npz'"):
        MODELS["tracers"].parameters(scene_of({"field": {"file": "lost.npz"}}))


@pytest.mark.parametrize("interpolation", ["divergence-free", "linear"])
def test_a_part_of_the_tank_or_of_the_run_without_velocities_is_stated(interpolation, tmp_path):
    """The file reaches to (2, 1) m and, with two instants, to 1 s."""
    saved(tmp_path, instants=2)
    field = {"file": str(tmp_path / "gyre.npz"), "length_unit": 0.01, "interpolation": interpolation}
    whole = {"flow": {"field": field}, "duration": 1.0}
    larger = {"tank": {"high": [2.5, 1.25]}, "duration": 3.0, "frame_every": 1.0}
    assert not {"beyond the grid", "times of the flow"} & set(rows_of(**whole))
    with pytest.warns(FlowWarning) as said:
        rows = rows_of(**whole | larger)
    assert rows["beyond the grid"][0] == "36 %"
    assert rows["times of the flow"][0] == "0 s to 1 s"
    assert [str(one.message).split(" of the ")[0] for one in said] == ["flow.field: 36 %", "flow.field: 0 s to 1 s"]


def test_particles_that_start_on_land_are_counted(tmp_path):
    saved(tmp_path)
    arrays = dict(np.load(tmp_path / "gyre.npz"))
    np.savez(tmp_path / "gyre.npz", **{**arrays, "u": np.where(arrays["x"][:, None] < 100.0, np.nan, arrays["u"])})
    field = {"file": str(tmp_path / "gyre.npz"), "length_unit": 0.01}
    particles = [{"radius": 1e-6, "density": 1000.0, "positions": [[0.5, 0.5], [1.5, 0.2], [0.7, 0.3]]}]
    assert rows_of({"field": field}, particles=particles)["start on land"][0] == "2"


def test_the_grid_of_a_flow_in_3d_is_compared_along_its_own_axes():
    shape = gridded_flows.fitted(Grid((0.0, 1.0, 2.0), (0.5, 0.25, 0.2), np.zeros(1), np.zeros((1, 3, 5, 6, 3))),
                                 "divergence-free").shape  # fmt: skip
    low, high = covered(shape, 3)
    assert [*low, *high] == pytest.approx([0.0, 1.0, 2.0, 1.0, 2.0, 3.0])


def test_a_step_that_does_not_resolve_the_flow_is_told():
    """The flow turns at 2 pi/(1 us), and a run has at most 50,000 steps."""
    pulse = {"amplitude": 1.0, "period": 1e-6}
    assert "set integration.time_step to 16 ns" in rows_of({**NAMED["channel"], "name": "channel", "pulse": pulse})[
        "time step"][1]  # fmt: skip


def test_what_numpy_saved_alone_is_refused_as_no_archive(tmp_path):
    with (tmp_path / "gyre.npz").open("wb") as file:
        np.save(file, np.zeros((3, 3)))
    (tmp_path / "scene.toml").write_text(TEXT.format(file="gyre.npz"))
    with pytest.raises(SceneError, match=r"gyre\.npz is no NumPy archive"):
        MODELS["tracers"].parameters(load_scene(tmp_path / "scene.toml"))


@pytest.mark.long
def test_a_damaged_netcdf_file_is_a_sentence_in_one_line(tmp_path):
    pytest.importorskip("xarray")
    from scipy.io import netcdf_file

    with netcdf_file(tmp_path / "gyre.nc", "w") as file:
        for name, axes in {"x": ("x",), "y": ("y",), "u": ("y", "x"), "v": ("y", "x")}.items():
            if name in axes:
                file.createDimension(name, 5)
            file.createVariable(name, "d", axes)[:] = np.linspace(0.0, 1.0, 5) if name in axes else 0.1
    whole = (tmp_path / "gyre.nc").read_bytes()
    (tmp_path / "scene.toml").write_text(TEXT.format(file="gyre.nc"))
    damaged = [whole[:size] for size in (0, 3, 20, 60, 150, len(whole) // 2)]
    damaged += [whole[:k] + bytes([whole[k] ^ 0xFF]) + whole[k + 1 :] for k in range(0, 200, 14)]
    says = list[str]()
    for content in damaged:
        (tmp_path / "gyre.nc").write_bytes(content)
        try:
            MODELS["tracers"].parameters(load_scene(tmp_path / "scene.toml"))
        except SceneError as error:
            says.append(str(error))
    assert len(says) > 12
    assert all("gyre.nc" in said and said.isprintable() for said in says)


@pytest.mark.parametrize(
    ("axes", "v", "words"),
    [(("x",), ("y",), "v has no dimension x"), (("x", "y"), ("x", "y"), "'a' has 2 dimensions")],
)
def test_a_netcdf_file_of_another_grid_is_refused(tmp_path, axes, v, words):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf")
    sizes = {"x": 5, "y": 3}
    given = {"a": axes, "b": ("y",), "u": ("x", "y"), "v": v}
    data = {name: (dims, np.ones([sizes[dim] for dim in dims])) for name, dims in given.items()}
    xarray.Dataset(data).to_netcdf(tmp_path / "gyre.nc", engine="h5netcdf")
    text = TEXT.format(file="gyre.nc").replace("length_unit", 'coordinates = ["a", "b"]\nlength_unit')
    (tmp_path / "scene.toml").write_text(text)
    with pytest.raises(SceneError, match=words):
        MODELS["tracers"].parameters(load_scene(tmp_path / "scene.toml"))


def changed_file(folder, **changes):
    """A file of a flow with other arrays."""
    saved(folder)
    arrays = dict(np.load(folder / "gyre.npz"))
    np.savez_compressed(folder / "gyre.npz", **{**arrays, **{name: new(arrays) for name, new in changes.items()}})
    return FieldSpec(file=str(folder / "gyre.npz"))


@pytest.mark.parametrize(("value", "words"), [(-9999.0, "velocity of 9999 m/s"), (1e20, "velocity of 1e.20 m/s")])
def test_numbers_that_mark_land_are_no_velocities(value, words, tmp_path):
    with pytest.raises(BadInput, match=words):
        grid_of(changed_file(tmp_path, u=lambda arrays: np.where(arrays["u"] > 0.0, value, arrays["u"])), 2)


def test_an_archive_that_would_fill_the_memory_is_refused_by_its_heads(tmp_path, monkeypatch):
    spec = changed_file(tmp_path, u=lambda arrays: np.zeros((1000, 1000)))
    monkeypatch.setattr(np, "stack", lambda *_, **__: pytest.fail("the velocities were read"))
    with pytest.raises(BadInput, match="its velocities are 1000x1000; its coordinates make a grid of 25x13"):
        grid_of(spec, 2)


@pytest.mark.long
def test_netcdf_and_vtk_give_the_grid_of_numpy(tmp_path):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf")
    vtk = pytest.importorskip("vtk")
    from vtk.util.numpy_support import numpy_to_vtk

    saved(tmp_path)
    arrays = dict(np.load(tmp_path / "gyre.npz"))
    data = {name: (("y", "x"), arrays[name][0].T) for name in "uv"}
    xarray.Dataset(data, {"x": arrays["x"], "y": arrays["y"]}).to_netcdf(tmp_path / "gyre.nc", engine="h5netcdf")
    image = vtk.vtkImageData()
    image.SetDimensions(25, 13, 1)
    image.SetSpacing(100.0 / 12, 100.0 / 12, 1.0)
    vectors = np.stack([arrays["u"][0].T, arrays["v"][0].T, np.zeros((13, 25))], axis=-1).reshape(-1, 3)
    values = numpy_to_vtk(np.ascontiguousarray(vectors))
    values.SetName("velocity")
    image.GetPointData().AddArray(values)
    writer = vtk.vtkXMLImageDataWriter()
    writer.SetFileName(str(tmp_path / "gyre.vti"))
    writer.SetInputData(image)
    writer.Write()
    ends = []
    for name in ("gyre.npz", "gyre.nc", "gyre.vti"):
        (tmp_path / "scene.toml").write_text(TEXT.format(file=name))
        *_, last = simulate(load_scene(tmp_path / "scene.toml"))
        ends.append(last.arrays["position"][0])
    assert ends[1] == pytest.approx(ends[0], abs=1e-12)
    assert ends[2] == pytest.approx(ends[0], abs=1e-12)


@pytest.mark.parametrize(
    ("length", "speed", "time"),
    [
        ("", "", ""),
        ("m", "m/s", "s"),
        ("km", "cm s-1", "hours"),
        ("nautical_mile", "knot", "days"),
        ("km", "m.s-1", "h"),
    ],
)
def test_the_units_that_a_netcdf_file_states_are_used(tmp_path, length, speed, time):
    xarray, rng, path = pytest.importorskip("xarray"), np.random.default_rng(1), tmp_path / "flow.nc"
    pytest.importorskip("h5netcdf")
    sought = ((length, "m"), (speed.replace(".", " "), "m/s"), (time, "s"))
    one = [factor(unit, symbol) if unit else 1.0 for unit, symbol in sought]
    x, y, t, velocity = 100.0 * np.arange(5), 100.0 * np.arange(4), 3600.0 * np.arange(3), rng.normal(size=(2, 3, 4, 5))
    parts = {
        name: (("t", "y", "x"), part / one[1], {"units": speed}) for name, part in zip("uv", velocity, strict=True)
    }
    axes = {name: (name, values / one[0], {"units": length}) for name, values in (("x", x), ("y", y))}
    data = xarray.Dataset(parts, {**axes, "t": ("t", t / one[2], {"units": time})})
    data.to_netcdf(path, engine="h5netcdf")
    found = field_files.grid_of(FieldSpec(file=str(path)), 2)
    assert found.step == pytest.approx((100.0, 100.0), rel=1e-12)
    assert found.times == pytest.approx(t, rel=1e-12)
    assert found.velocity == pytest.approx(np.transpose(velocity, (1, 3, 2, 0)), rel=1e-12)
    given = field_files.grid_of(FieldSpec(file=str(path), length_unit=10.0, velocity_unit=2.0, time_unit=60.0), 2)
    assert given.step[0] == pytest.approx(1000.0 / one[0], rel=1e-12), "the key comes first"
    assert given.times == pytest.approx(60.0 * t / one[2], rel=1e-12)
    assert given.velocity == pytest.approx(2.0 / one[1] * np.transpose(velocity, (1, 3, 2, 0)), rel=1e-12)
    meters = field_files.grid_of(FieldSpec(file=str(path), velocity_unit=1.0), 2)
    assert meters.velocity == pytest.approx(1.0 / one[1] * np.transpose(velocity, (1, 3, 2, 0)), rel=1e-12)


def test_a_netcdf_file_in_degrees_is_refused(tmp_path):
    xarray, path = pytest.importorskip("xarray"), str(tmp_path / "globe.nc")
    pytest.importorskip("h5netcdf")
    axes = {
        name: (name, np.arange(4.0), {"units": unit}) for name, unit in (("x", "degrees_east"), ("y", "degrees_north"))
    }
    data = {name: (("y", "x"), np.ones((4, 4))) for name in "uv"}
    xarray.Dataset(data, axes).to_netcdf(path, engine="h5netcdf")
    with pytest.raises(BadInput, match=r"'x' is in degrees_east; expected lengths on a plane"):
        field_files.grid_of(FieldSpec(file=path), 2)


def of_units(folder, x="m", u="m s-1", **time):
    """The grid of a NetCDF file that states these units."""
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf")
    axes = {name: (name, np.arange(4.0), {"units": x}) for name in ("x", "y")} | {"t": ("t", np.arange(3.0), time)}
    parts = {name: (("t", "y", "x"), np.ones((3, 4, 4)), {"units": u}) for name in "uv"}
    xarray.Dataset(parts, axes).to_netcdf(folder / "flow.nc", engine="h5netcdf")
    return field_files.grid_of(FieldSpec(file=str(folder / "flow.nc")), 2)


@pytest.mark.parametrize(
    "u", ["cm s^{-1}", "0.01 m s-1", "CM/S", "cms-1", "cm s\N{SUPERSCRIPT MINUS}\N{SUPERSCRIPT ONE}"]
)
def test_units_of_netcdf_files_are_read_as_programs_write_them(tmp_path, u):
    found = of_units(tmp_path, "Km", u, units="Hours")
    assert found.step == (1000.0, 1000.0)
    assert found.times[1] == 3600.0
    assert found.velocity == pytest.approx(0.01, rel=1e-14)


def test_units_that_cannot_be_read_are_told(tmp_path):
    with pytest.warns(field_files.UnitsWarning, match="the units 'pixel' of '.' cannot be read, and count as m; state"):
        assert of_units(tmp_path, "pixel").step == (1.0, 1.0)


@pytest.mark.parametrize("calendar", ["standard", "noleap", "360_day"])
def test_dates_of_any_calendar_are_seconds_from_the_first(tmp_path, calendar):
    found = of_units(tmp_path, units="days since 2000-02-28", calendar=calendar)
    assert found.times == pytest.approx([0.0, 86400.0, 172800.0], rel=1e-15)


def test_dates_in_months_are_refused(tmp_path):
    with pytest.raises(BadInput, match="its times are in months since 2000-01-01; expected days"):
        of_units(tmp_path, units="months since 2000-01-01")


# --- Functions of the user


def swirl(position, time, constants):
    """A flow that grows in time."""
    return -constants[0] * (position[1] - 0.5) * time, constants[0] * (position[0] - 1.0) * time


def test_a_function_of_place_and_time_is_a_flow():
    particles = [{"radius": 1e-6, "density": 1000.0, "positions": [[1.3, 0.5]]}]
    scene = scene_of({}, duration=1.0, particles=particles, user_laws=[{"law": "swirl", "constants": [2.0]}])
    *_, last = simulate(scene, extra_laws=[swirl])
    angle = 2.0 * 1.0**2 / 2.0
    expected = [1.0 + 0.3 * math.cos(angle), 0.5 + 0.3 * math.sin(angle)]
    assert last.arrays["position"][0] == pytest.approx(expected, abs=2e-4)


def test_check_states_the_speed_of_a_flow_by_a_function():
    scene = scene_of({}, duration=1.0, user_laws=[{"law": "swirl", "constants": [2.0]}])
    model = MODELS["tracers"].extended(bind(scene, [swirl]))
    rows = {row[0]: row[1:] for row in model.summary(scene)}
    assert rows["flow"][1].startswith("by a function of the user: largest speed")
    assert float(rows["flow"][0].split()[0]) == pytest.approx(2.0 * math.hypot(1.0, 0.5) * 7.0 / 8.0, rel=0.05)
    assert float(rows["history force"][0]) > 0.0


def shaken(position, time, constants):
    """A uniform flow that swings fast."""
    return constants[0] * math.sin(300.0 * time), 0.0 * position[0]


def test_the_step_follows_a_function_that_changes_fast_in_time():
    particles = [{"radius": 1e-6, "density": 1000.0, "positions": [[1.0, 0.5]]}]
    laws = [{"law": "shaken", "constants": [2.0]}]
    scene = scene_of({}, duration=0.1, frame_every=0.1, particles=particles, user_laws=laws)
    *_, last = simulate(scene, extra_laws=[shaken])
    assert last.arrays["position"][0, 0] == pytest.approx(1.0 + 2.0 / 300.0 * (1.0 - math.cos(30.0)), abs=1e-6)


# --- Periodic sides and deposits


def test_periodic_sides_count_images_and_paths_do_not_jump():
    scene = scene_of(
        {"velocity": [1.5, 0.0]}, tank={"high": [2.0, 1.0], "periodic": ["x"]}, duration=4.0, frame_every=1.0,
        particles=[{"radius": 1e-6, "density": 1000.0, "positions": [[1.9, 0.5]]}],
    )  # fmt: skip
    frames = list(simulate(scene))
    assert frames[-1].arrays["image"][0].tolist() == [3, 0]
    assert tracks(frames)[-1, 0] == pytest.approx([1.9 + 6.0, 0.5], rel=1e-12)
    assert all(0.0 <= frame.arrays["position"][0, 0] < 2.0 for frame in frames)


def test_an_obstacle_beside_a_periodic_side_is_met_from_the_other():
    scene = scene_of(
        {}, tank={"high": [2.0, 1.0], "periodic": ["x"]}, gravity=0.0, hydrodynamics={"drag": "none"}, duration=1.0,
        frame_every=1.0, integration={"time_step": 0.25}, obstacles=[{"low": [0.1, 0.2], "high": [0.2, 0.8]}],
        particles=[{"radius": 0.01, "density": 1000.0, "positions": [[1.9, 0.5]], "velocity": [1.0, 0.0]}],
    )  # fmt: skip
    *_, last = simulate(scene)
    # It flies 0.19 m to the front at x = 2.1, and the rest of 1 m back.
    assert last.arrays["position"][0, 0] == pytest.approx(2.09 - 0.81, abs=1e-9)


PASSING = {
    "tank": {"high": [1.0, 1.0], "periodic": ["x"]}, "gravity": 0.0, "hydrodynamics": {"drag": "none"}, "duration": 9.0,
    "frame_every": 9.0, "obstacles": [{"low": [0.5, 0.8], "high": [0.6, 1.0]}],
    "particles": [{"radius": 1e-3, "density": 1000.0, "positions": [[0.1, 0.05]], "velocity": [1.0, 0.1]}],
}  # fmt: skip


def test_a_step_does_not_pass_an_obstacle_in_a_periodic_box_farther_away():
    """The path meets it in the ninth box; copies are in the boxes beside the first only."""
    *_, last = simulate(scene_of({}, **PASSING, integration={}))
    assert last.numbers["hits"] == 1.0
    assert last.arrays["position"][0, 0] == pytest.approx(0.1, abs=1e-9)
    with pytest.raises(SceneError, match=r"integration\.time_step: got 9 s; expected at most 0\.995 s"):
        MODELS["tracers"].parameters(scene_of({}, **PASSING, integration={"time_step": 9.0}))


def test_a_flow_that_differs_on_periodic_sides_is_refused():
    scene = scene_of({"name": "rotation", "rate": 1.0}, tank={"high": [2.0, 1.0], "periodic": ["x"]})
    with pytest.raises(SceneError, match=r"tank\.periodic: got x; the velocities of the liquid .* differ by 2 m/s"):
        MODELS["tracers"].parameters(scene)


def test_a_flow_that_differs_on_periodic_sides_only_later_is_refused():
    flow = {"name": "double-gyre", "speed": 1.0, "swing": 0.2, "period": 2.0}
    scene = scene_of(flow, tank={"high": [2.0, 1.0], "periodic": ["x"]})
    with pytest.raises(SceneError, match=r"tank\.periodic: got x; the velocities of the liquid .* differ"):
        MODELS["tracers"].parameters(scene)


def test_sticking_walls_hold_what_touches_them_and_count_it():
    scene = scene_of(
        {}, tank={"high": [2.0, 1.0], "walls": [{"wall": 1, "sticking": True}]}, duration=2.0, frame_every=1.0,
        particles=[{"radius": 1e-4, "density": 8000.0, "positions": [[0.5, 0.01], [0.7, 0.9]], }],
    )  # fmt: skip
    frames = list(simulate(scene))
    last = frames[-1]
    assert last.numbers["deposited_on_wall_1"] == 1.0
    assert last.numbers["particles_inside"] == 1.0
    assert last.arrays["position"][0] == pytest.approx([0.5, 1e-4], abs=1e-9)
    assert MODELS["tracers"].invariants(scene, None)


@pytest.mark.compiled
def test_diffusing_particles_are_absorbed_as_often_as_the_exact_solution_says():
    """Between two absorbing plates a uniform suspension decays as sum of 8/(n pi)^2 exp(-n^2 pi^2 D t/h^2), n odd."""
    radius, width = 1e-7, 1e-5
    scene = scene_of(
        {}, tank={"high": [1e-4, width + 2 * radius], "periodic": ["x"], "sticking": True}, gravity=0.0, duration=8.0,
        frame_every=8.0, particles=[{"radius": radius, "density": 1000.0, "count": 20000}],
        hydrodynamics={"brownian": True, "drag": "stokes"}, integration={"integrator": "overdamped", "time_step": 0.8},
    )  # fmt: skip
    *_, last = simulate(scene)
    spread = 1.380649e-23 * 293.15 / (6 * math.pi * 1e-3 * radius)
    n = np.arange(1, 100, 2) * math.pi
    expected = float((8.0 / n**2 * np.exp(-(n**2) * spread * 8.0 / width**2)).sum())
    share = last.numbers["particles_inside"] / 20000
    assert share == pytest.approx(expected, abs=4.0 * math.sqrt(expected * (1 - expected) / 20000) + 0.004)


@pytest.mark.compiled
def test_a_recorded_tank_carries_tracers_at_its_speed(tmp_path):
    """Along both axes: y of the tank is up, as z of the tracers is."""
    box, speed = {"low": [0.0, 0.0], "high": [0.4, 0.2]}, np.array([0.1, 0.04])
    periodic = {side: {"kind": "periodic"} for side in ("left", "right", "bottom", "top")}
    tank = {
        "model": "sph", "duration": 0.2, "frame_every": 0.1, "spacing": 0.02, "gravity": [0.0, 0.0],
        "tank": {**box, **periodic}, "fluid": [{**box, "velocity": speed.tolist()}], "liquid": {"maximum_speed": 0.2},
    }  # fmt: skip
    run(from_plain(tank), tmp_path / "tank")
    places = [[0.1, 0.05], [0.2, 0.1]]
    tracers = {
        "model": "tracers", "duration": 0.2, "frame_every": 0.1, "gravity": 0.0, "liquid": {"viscosity": 1e-3},
        "particles": [{"positions": places, "radius": 1e-6, "density": 1000.0}], "tank": {"high": box["high"]},
        "flow": {"field": {"file": str(tmp_path / "tank"), "spacing": 0.02}},
        "integration": {"integrator": "overdamped"},
    }  # fmt: skip
    *_, last = simulate(from_plain(tracers))
    assert last.arrays["position"] == pytest.approx(np.array(places) + 0.2 * speed, rel=1e-6)
