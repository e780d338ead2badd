"""Unequal particles: distributions, lists and files of radii, with one key in the models."""

import math

import numpy as np
import pytest

from ecume.errors import SceneError
from ecume.models import MODELS
from ecume.models.soft.report.check_report import jamming_fraction
from ecume.scenes.load import load_scene
from ecume.scenes.schema import from_plain, to_plain
from ecume.scenes.sizes import SizeSpec, quantiles
from ecume.simulation import simulate

FRAME = {"duration": 1e-3, "frame_every": 1e-3, "liquid": {"viscosity": 1.0}}
SPECIES = {
    "soft": {"modulus": 1e4},
    "tracers": {"density": 1100.0},
    "floating": {"density": 1100.0, "contact_angle": 1.5},
}
REGION = {
    "soft": {"cell": {"size": [1.0, 1.0], "volume_fraction": 0.6}, "rotation": True},
    "tracers": {"tank": {"high": [0.1, 0.1]}},
    "floating": {"dish": {"radius": 0.1}},
}


def scene_of(model, radius, count=20, **more):
    species = SPECIES[model] | {"radius": radius, "count": count}
    return from_plain({"model": model, "particles": [species]} | FRAME | REGION[model] | more)


def radii(scene):
    return next(iter(simulate(scene))).arrays["radius"]


@pytest.mark.parametrize("distribution", ["normal", "lognormal", "uniform"])
@pytest.mark.parametrize("spread", [0.05, 0.2])
def test_radii_have_the_mean_and_the_spread_of_their_distribution(distribution, spread):
    found = quantiles(SizeSpec(distribution=distribution, mean=1e-3, spread=spread, truncate=5.0), 4000)
    assert found.mean() == pytest.approx(1e-3, rel=1e-3)
    assert found.std() == pytest.approx(spread * 1e-3, rel=5e-3)
    assert (np.diff(found) >= 0.0).all()
    skewness = (((found - found.mean()) / found.std()) ** 3).mean()
    assert skewness == pytest.approx(3 * spread + spread**3 if distribution == "lognormal" else 0.0, abs=0.02)


def test_no_radius_is_beyond_where_a_distribution_is_truncated():
    for distribution, most in (("normal", 1.4), ("lognormal", math.exp(2 * math.sqrt(math.log1p(0.04))))):
        found = quantiles(SizeSpec(distribution=distribution, mean=1.0, spread=0.2, truncate=2.0), 1000)
        assert found.max() < most
        assert found.max() > 0.95 * most * (1.0 if distribution == "normal" else math.exp(-0.02))


@pytest.mark.parametrize("model", SPECIES)
def test_a_table_a_list_and_a_length_stand_under_one_key_in_each_model(model):
    lognormal = scene_of(model, {"distribution": "lognormal", "mean": "1 mm", "spread": "20 %"})
    assert radii(lognormal).std() == pytest.approx(0.2e-3, rel=0.2)
    assert sorted(radii(lognormal)) == pytest.approx(quantiles(lognormal.particles[0].sizes, 20))
    given = np.linspace(1e-3, 2e-3, 20).tolist()
    assert radii(scene_of(model, given)).tolist() == given
    bins = {"distribution": "histogram", "radii": ["1 mm", "2 mm"], "weights": [3, 1]}
    assert sorted(radii(scene_of(model, bins))) == pytest.approx([1e-3] * 15 + [2e-3] * 5)
    for scene in (lognormal, scene_of(model, given), scene_of(model, bins), scene_of(model, "1 mm")):
        assert from_plain(to_plain(scene)) == scene


@pytest.mark.parametrize("model", SPECIES)
def test_the_seed_decides_on_the_order_of_sizes_and_not_on_the_sizes(model):
    sizes = {"distribution": "uniform", "mean": 1e-3, "spread": 0.3}
    first, again, other = (radii(scene_of(model, sizes, seed=seed)) for seed in (1, 1, 2))
    assert first.tobytes() == again.tobytes()
    assert first.tolist() != other.tolist()
    assert sorted(first) == sorted(other)


@pytest.mark.parametrize(
    ("radius", "says"),
    [
        ({"distribution": "normal", "mean": "1 mm"}, "spread: is missing; normal needs a mean and a spread"),
        ({"distribution": "gamma", "mean": "1 mm"}, "expected one of normal, lognormal, uniform, histogram"),
        ({"distribution": "histogram"}, "radii: is missing; a histogram needs the radii"),
        (["1 mm", "2 mm"], "radius: got 2 radii; expected one for each of 20 particles"),
    ],
)
@pytest.mark.parametrize("model", SPECIES)
def test_sizes_that_say_too_little_are_refused(model, radius, says):
    with pytest.raises(SceneError, match=says):
        scene_of(model, radius)


def test_unequal_spheres_fill_the_fraction_that_is_wanted_and_check_tells_their_moments():
    scene = scene_of("soft", {"distribution": "lognormal", "mean": "1 mm", "spread": "30 %"}, count=30)
    assert next(iter(simulate(scene))).numbers["volume_fraction"] == pytest.approx(0.6, rel=1e-12)
    rows = {name: value for name, value, _ in MODELS["soft"].summary(scene)}
    assert float(rows["mean by volume"].split()[0]) > float(rows["mean by surface"].split()[0]) > 1.0


def test_spheres_of_more_sizes_jam_at_a_higher_fraction():
    equal, unequal = np.ones(50), quantiles(SizeSpec(distribution="lognormal", mean=1.0, spread=0.4), 500)
    assert jamming_fraction(equal, 3) == pytest.approx(0.634)
    assert 0.66 < jamming_fraction(unequal, 3) < 0.70


def test_unequal_tracers_settle_by_their_own_sizes():
    scene = scene_of(
        "tracers", {"distribution": "uniform", "mean": 1e-5, "spread": 0.3}, integration={"integrator": "overdamped"}
    )
    first, last = simulate(scene)
    speed = (first.arrays["position"] - last.arrays["position"])[:, 1]
    assert speed / first.arrays["radius"] ** 2 == pytest.approx(
        np.full(20, speed[0] / first.arrays["radius"][0] ** 2), rel=1e-4
    )


@pytest.mark.parametrize("model", SPECIES)
def test_a_file_with_a_diameter_of_each_particle_gives_each_its_own(model, tmp_path):
    rows = [f"{n + 1} 1 {0.002 + 1e-4 * n:g} 1000 {0.004 * n + 0.002:g} 0.004 0" for n in range(4)]
    head = (
        "sizes\n\n4 atoms\n1 atom types\n\n0 0.016 xlo xhi\n0 0.016 ylo yhi\n-0.001 0.001 zlo zhi\n\nAtoms # sphere\n\n"
    )
    (tmp_path / "sizes.data").write_text(head + "\n".join(rows) + "\n")
    region = {
        "soft": 'cell.size = ["16 mm", "16 mm"]',
        "tracers": 'tank.high = ["16 mm", "16 mm"]',
        "floating": 'dish.radius = "3 cm"',
    }[model]
    own = "\n".join(f"{key} = {value}" for key, value in SPECIES[model].items())
    (tmp_path / "scene.toml").write_text(
        f'model = "{model}"\nduration = 1e-3\nframe_every = 1e-3\nliquid.viscosity = 1.0\n{region}\n'
        f'start_from = {{ file = "sizes.data", length_unit = "1 m" }}\n[[particles]]\n{own}\n'
    )
    assert radii(load_scene(tmp_path / "scene.toml")) == pytest.approx(0.001 + 5e-5 * np.arange(4))


@pytest.mark.parametrize("model", SPECIES)
def test_a_histogram_is_read_from_a_table_with_units(model, tmp_path):
    (tmp_path / "sieve.csv").write_text("diameter [mm],weight\n2,3\n4,1\n")
    own = "\n".join(f"{key} = {value}" for key, value in SPECIES[model].items())
    region = {
        "soft": "cell = { size = [1, 1], volume_fraction = 0.6 }", "tracers": "tank.high = [0.1, 0.1]",
        "floating": "dish.radius = 0.1",
    }[model]  # fmt: skip
    text = (
        f'model = "{model}"\nduration = 1e-3\nframe_every = 1e-3\nliquid.viscosity = 1.0\n{region}\n'
        f'[[particles]]\ncount = 20\n{own}\nradius = {{ distribution = "histogram", file = "FILE" }}\n'
    )
    (tmp_path / "scene.toml").write_text(text.replace("FILE", "sieve.csv"))
    scene = load_scene(tmp_path / "scene.toml")
    assert sorted(radii(scene)) == pytest.approx([1e-3] * 15 + [2e-3] * 5)
    assert from_plain(to_plain(scene)) == scene
    for content, says in (("size\n1\n", "no such column"), ("radius,diameter\n1,2\n", "radius appears twice"),
                          ("weight\n1\n", "either a column radius or")):  # fmt: skip
        (tmp_path / "bad.csv").write_text(content)
        (tmp_path / "bad.toml").write_text(text.replace("FILE", "bad.csv"))
        with pytest.raises(SceneError, match=says):
            load_scene(tmp_path / "bad.toml")
    (tmp_path / "bad.toml").write_text(text.replace("FILE", "none.csv"))
    with pytest.raises(SceneError, match=r"radius\.file: 'none.csv' does not exist"):
        load_scene(tmp_path / "bad.toml")


def mixed(model, *species, **more):
    return from_plain(
        {"model": model, "particles": [SPECIES[model] | one for one in species]} | FRAME | REGION[model] | more
    )


@pytest.mark.parametrize("model", SPECIES)
@pytest.mark.parametrize("share", [0.2, 0.5])
def test_a_share_of_the_volume_says_how_many_particles_there_are(model, share):
    small = {"radius": {"distribution": "lognormal", "mean": 5e-4, "spread": 0.3}, "volume_share": share}
    scene = mixed(model, {"radius": 1e-3, "count": 30}, small)
    frame, power = next(iter(simulate(scene))), 2 if model == "soft" else 3
    volume = frame.arrays["radius"] ** power
    part = volume[frame.arrays["species"] == 1].sum() / volume.sum()
    assert part == pytest.approx(share, rel=0.03)
    assert from_plain(to_plain(scene)) == scene


@pytest.mark.parametrize("model", SPECIES)
def test_shares_that_say_too_little_or_too_much_are_refused(model):
    ball = {"radius": 1e-3}
    with pytest.raises(SceneError, match=r"volume_share: .* expected a count, or positions, of at least one"):
        mixed(model, ball | {"volume_share": 0.5})
    with pytest.raises(SceneError, match=r"the shares sum to 1\.1"):
        mixed(model, ball | {"count": 3}, ball | {"volume_share": 0.6}, ball | {"volume_share": 0.5})
    with pytest.raises(SceneError, match="got 7, and volume_share makes 3 particles"):
        mixed(model, ball | {"count": 3}, ball | {"volume_share": 0.5, "count": 7})
    with pytest.raises(SceneError, match="volume_share: makes 0 particles"):
        mixed(model, ball | {"count": 1}, ball | {"volume_share": 0.1})


def test_floats_of_one_species_have_each_their_own_weight_and_charge():
    sizes = {"distribution": "uniform", "mean": 1e-3, "spread": 0.3}
    scene = scene_of("floating", sizes, count=6, seed=4)
    parameters = MODELS["floating"].parameters(scene)
    alone = [
        MODELS["floating"].parameters(scene_of("floating", float(radius), count=1))
        for radius in parameters.floats.radius
    ]
    for name in ("mass", "charge", "relaxation_time"):
        wanted = [getattr(one.floats, name)[0] for one in alone]
        assert getattr(parameters.floats, name) == pytest.approx(wanted, rel=1e-12), name
    rows = {name: value for name, value, _ in MODELS["floating"].summary(scene)}
    assert rows["mean radius"] == "1 mm"


def test_a_shape_has_one_size():
    with pytest.raises(SceneError, match="shape: has one size"):
        scene_of("floating", [1e-3, 2e-3], count=2, particles=[
            {"radius": [1e-3, 2e-3], "density": 1100.0, "contact_angle": 1.5, "count": 2,
             "shape": {"kind": "ellipsoid", "width": 5e-4}}
        ])  # fmt: skip
