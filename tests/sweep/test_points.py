"""A sweep's file is read whole or refused with all its faults; its points are those that were asked for."""

import tomllib

import numpy as np
import pytest

from ecume.errors import BadInput, SceneError
from ecume.scenes.schema import from_plain
from ecume.scenes.soft import first_fraction, sides_of
from ecume.scenes.templates import sweep_templates
from ecume.sweep.directory import json_at, open_or_create, require_laws
from ecume.sweep.executors import write_array
from ecume.sweep.results import Sweep, _unit_in, as_csv
from ecume.sweep.spec import READER, load_sweep, points_of, varied

LAWS = [{"name": "yukawa", "sha256": "1" * 64}]


def test_points_with_laws_of_the_user_are_others_and_keep_to_the_text_of_the_laws(tmp_path):
    text = 'template = "two-spheres"\n[[axes]]\nkey = "seed"\nvalues = [1, 2]\n'
    (tmp_path / "s.toml").write_text(text)
    plain = open_or_create(tmp_path / "s.toml", tmp_path / "plain")
    lawful = open_or_create(tmp_path / "s.toml", tmp_path / "lawful", LAWS)
    assert {job.folder.name for job in plain.jobs}.isdisjoint(job.folder.name for job in lawful.jobs)
    assert "--laws mine.py:yukawa --task" in write_array(lawful, ["mine.py:yukawa"]).read_text()
    require_laws(lawful, LAWS)
    require_laws(plain, [])
    with pytest.raises(BadInput, match=r"expected --laws FILE\.py:yukawa"):
        require_laws(lawful, [])
    with pytest.raises(BadInput, match="text of its laws has changed"):
        require_laws(lawful, [LAWS[0] | {"sha256": "2" * 64}])
    with pytest.raises(BadInput, match="expected no --laws"):
        require_laws(plain, LAWS)


def spec_of(text):
    return READER.validate_python(tomllib.loads(text))


def settings(text):
    return [point.settings for point in points_of(spec_of(text))]


def test_axes_are_combined_and_the_last_varies_first():
    text = """
        template = "t1"
        fixed = {duration = "1 s"}
        [[axes]]
        key = "a"
        values = [1, 2]
        [[axes]]
        key = "b"
        span = {start = 0, stop = 1, count = 3, unit = "mm"}
    """
    found = settings(text)
    assert [(one["a"], one["b"]) for one in found] == [
        (1, "0.0 mm"), (1, "0.5 mm"), (1, "1.0 mm"), (2, "0.0 mm"), (2, "0.5 mm"), (2, "1.0 mm"),
    ]  # fmt: skip
    assert all(one["duration"] == "1 s" for one in found)


def test_a_logarithmic_span_has_equal_ratios_and_its_own_ends():
    found = settings('template = "t1"\n[[axes]]\nkey = "a"\nspan = {start = 1e-5, stop = 1e-1, count = 5, log = true}')
    assert [one["a"] for one in found] == [1e-5, 1e-4, 1e-3, 1e-2, 1e-1]


def test_keys_that_go_together_are_one_axis():
    found = settings('template = "t1"\n[[axes]]\nkeys = ["a", "b[0].c"]\nrows = [[1, "x"], [2, "y"]]')
    assert found == [{"a": 1, "b[0].c": "x"}, {"a": 2, "b[0].c": "y"}]


def test_repeats_are_points_of_their_own():
    found = points_of(spec_of('template = "t1"\nrepeats = 3\n[[axes]]\nkey = "a"\nvalues = [1, 2]'))
    assert [(point.settings["a"], point.repeat) for point in found] == [(1, 0), (1, 1), (1, 2), (2, 0), (2, 1), (2, 2)]


LATIN = """
template = "t1"
[sampling]
count = 50
seed = 7
axes = [{key = "a", span = {start = 0, stop = 1}}, {key = "b", span = {start = 1e-3, stop = 10, log = true}}]
"""


def test_a_latin_hypercube_has_one_point_in_each_slice():
    found = settings(LATIN)
    first = np.array([one["a"] for one in found])
    second = np.log10([one["b"] for one in found])
    assert sorted(np.floor(50 * first)) == list(range(50))
    assert sorted(np.floor(50 * (second + 3.0) / 4.0)) == list(range(50))


def test_the_seed_alone_decides_what_is_drawn():
    assert settings(LATIN) == settings(LATIN)
    assert settings(LATIN) != settings(LATIN.replace("seed = 7", "seed = 8"))
    drawn_freely = settings(LATIN.replace("[sampling]", '[sampling]\nmethod = "random"'))
    assert drawn_freely != settings(LATIN)
    assert all(0 <= one["a"] <= 1 and 1e-3 <= one["b"] <= 10 for one in drawn_freely)


def test_both_ends_of_a_span_may_carry_the_unit():
    found = settings(SPAN.format('start = "1 mPa*s", stop = "1e2 mPa*s", count = 3, log = true'))
    assert [one["a"] for one in found] == ["1.0 mPa*s", "10.0 mPa*s", "100.0 mPa*s"]


def test_whole_numbers_are_rounded_where_that_is_asked_for():
    found = settings(SPAN.format("start = 20, stop = 61, count = 4, whole = true"))
    assert [one["a"] for one in found] == [20, 34, 47, 61]
    assert all(isinstance(one["a"], int) for one in found)


def test_what_is_fixed_may_stand_in_tables():
    spec = spec_of('template = "t1"\nrepeats = 2\n[fixed]\nliquid.viscosity = 1\n"particles[0].count" = 3')
    assert spec.fixed == {"liquid.viscosity": 1, "particles[0].count": 3}


TWICE = 'template = "t1"\n[[axes]]\nkey = "{}"\nvalues = [1]\n{}\n[[axes]]\nkey = "{}"\nvalues = [1]\n{}\n'
SPAN = 'template = "t1"\n[[axes]]\nkey = "a"\nspan = {{{}}}'


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('template = "t1"', "axes: is missing; nothing varies"),
        ("repeats = 2", "expected one of scene, template and process"),
        ('template = "t1"\nscene = "a.toml"\nrepeats = 2', "expected one of scene, template and process"),
        ('process = "t1"\nrepeats = 2', "repeats: a process has no seed"),
        ('template = "t1"\n[[axes]]\nvalues = [1]', "axes[0]: expected key, or keys with rows"),
        ('template = "t1"\n[[axes]]\nkey = "a"', "axes[0]: expected values, or a span"),
        ('template = "t1"\n[[axes]]\nkeys = ["a", "b"]\nrows = [[1]]', "axes[0].rows[0]: got 1 values; expected 2"),
        ('template = "t1"\n[[axes]]\nkey = "a; import os"\nvalues = [1]', "axes[0].key"),
        ('template = "t1"\n[[axes]]\nkey = "a"\nspan = {start = -1, stop = 1, log = true}', "ratios are of positive"),
        ('template = "t1"\n[[axis]]\nkey = "a"', "axis: no such key; did you mean axes?"),
        ('template = "t1"\nrepeats = 0', "repeats"),
        ('template = "dam-brake"\nrepeats = 2', "did you mean dam-break?"),
        ('template = "t1"\nrepeats = ', "line 2, column 11: is not TOML: Invalid value"),
        ("a = " + "[" * 3000, "nested too deeply"),
        ('process = "t1"\nmeasures = ["final x"]\n[[axes]]\nkey = "gap"\nvalues = [1]', "fixed list of numbers"),
        ('template = "t1"\nrepeats = 2\nmeasures = ["finl top"]', "line 3, column 13: measures[0]: got 'finl top'"),
        ('template = "t1"\nrepeats = 2\nmeasures = ["first top > 1.2.3"]', "or 'first top > 0.3'"),
        (TWICE.format("a", "", "a", ""), "axes[1].key: a is given twice"),
        (TWICE.format("a", 'name = "x"', "b", 'name = "x"'), "axes[0].name: another column of the table is called x"),
        (TWICE.format("a", 'name = "state"', "b", ""), "axes[0].name: another column of the table is called state"),
        (TWICE.format("a", "", "b", "") + "[fixed]\nb = 1", "axes[1].key: b is given twice"),
        (
            'template = "t1"\nrepeats = 2\n[[axes]]\nkey = "seed"\nvalues = [1]',
            "repeats: repeats have consecutive seeds",
        ),
        (SPAN.format('start = "1 mm", stop = "2 m"'), "or two with one unit"),
        (SPAN.format('start = "1 mm", stop = 2'), "or two with one unit"),
        (SPAN.format('start = "1 mm", stop = "2 mm", unit = "mm"'), "or two with one unit"),
        (SPAN.format("start = 1, stop = 2, count = 1"), "axes[0].span.count: got 1; expected 2 or more"),
        ('template = "t1"\n[[axes]]\nkey = "a"\nvalues = [nan]', "values[0]: got nan; expected a finite number, text"),
        ('template = "t1"\n[[axes]]\nrows = [[1]]', "axes[0]: expected key, or keys with rows"),
        ('template = "t1"\nrepeats = 2\n[cluster]\nwalltime = "1 h"', 'hours:minutes:seconds, such as "01:30:00"'),
    ],
)
def test_what_cannot_be_a_sweep_is_refused_with_its_place(tmp_path, text, says):
    (tmp_path / "sweep.toml").write_text(text)
    with pytest.raises(BadInput) as refused:
        load_sweep(tmp_path / "sweep.toml")
    assert says in str(refused.value)
    assert "sweep.toml: " in str(refused.value)


def test_all_faults_come_at_once(tmp_path):
    (tmp_path / "sweep.toml").write_text('template = "t1"\nrepeats = 0\n[[axes]]\nkey = "a"\nvalues = 3\n')
    with pytest.raises(SceneError) as refused:
        load_sweep(tmp_path / "sweep.toml")
    assert {fault.path for fault in refused.value.faults} >= {"repeats", "axes[0].values"}


def test_too_many_points_are_counted_before_they_are_made():
    axes = '[[axes]]\nkey = "{}"\nspan = {{start = 0, stop = 1, count = 100000}}\n'
    with pytest.raises(BadInput, match="10000000000 points are more than 1000000"):
        points_of(spec_of('template = "t1"\n' + axes.format("a") + axes.format("b")))


@pytest.mark.parametrize("name", sweep_templates())
def test_templates_are_sweeps(tmp_path, name):
    from ecume.scenes.templates import copy_template

    (path,) = copy_template(name, tmp_path / "sweep.toml")
    spec = load_sweep(path).spec
    assert len(points_of(spec)) >= 3
    assert all(spec.named(key) for key in varied(spec))


@pytest.mark.parametrize(
    ("value", "unit"),
    [("2 mm", "mm"), ("1e-3 mN/m", "mN/m"), ("0.5 1/s", "1/s"), ("3", ""), (2.0, ""), ("cells", ""),
     ("0.07*sin(3*t)", ""), ("1 - cos(t)", "")],
)  # fmt: skip
def test_the_unit_of_a_value_is_what_follows_the_number(value, unit):
    assert _unit_in(value) == unit


LISTED = "x = 0.1, y = 0.1, radius = 1e-3, density = 1200.0, contact_angle = 1.0"
SIZED = """
template = "sheared-packing"
sizes = [1, 4]
[fixed]
"particles[0].count" = 8
"particles[1].count" = 4
[[axes]]
key = "liquid.viscosity"
values = [1.0, 2.0]
"""


def test_sizes_repeat_each_point_with_as_many_times_the_particles_at_the_same_volume_fraction(tmp_path):
    (tmp_path / "s.toml").write_text(SIZED)
    sweeping = open_or_create(tmp_path / "s.toml", tmp_path / "sweep")
    scenes = [from_plain(json_at(job.asked, dict)["scene"]) for job in sweeping.jobs]
    assert [[one.count for one in scene.particles] for scene in scenes] == [[8, 4], [32, 16]] * 2
    assert [job.values["size_factor"] for job in sweeping.jobs] == [1, 4, 1, 4]
    assert len({first_fraction(scene) for scene in scenes}) == 1
    assert np.prod(sides_of(scenes[1])) == pytest.approx(4.0 * np.prod(sides_of(scenes[0])))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('template = "dam-break"\nsizes = [1, 2]', "those of a periodic cell"),
        ('template = "soft-two-spheres"\nsizes = [2]', "those of a periodic cell"),
        (f'template = "periodic-raft"\nsizes = [1, 2]\n[fixed]\nrows = [{{{LISTED}}}]', "whose floats are listed"),
        ('process = "t1"\nsizes = [1, 2]', "sizes: are of the cell of a scene"),
        ('template = "sheared-packing"\nsizes = [2, 2]', "sizes: contain a factor twice"),
    ],
)
def test_sizes_of_what_has_none_are_refused(tmp_path, text, says):
    (tmp_path / "s.toml").write_text(text)
    with pytest.raises((BadInput, SceneError), match=says):
        open_or_create(tmp_path / "s.toml", tmp_path / "sweep")


def test_the_file_of_a_table_has_the_units_of_the_sweep(tmp_path):
    """Values as they were written, with their unit in the header, also degrees Celsius; plain numbers in SI units."""
    text = (
        'template = "cereal-bowl"\n[[axes]]\nkey = "dish.contact_angle"\nvalues = ["45 deg", "62.5 deg"]\n'
        '[[axes]]\nkey = "liquid.temperature"\nspan = {start = "20 degC", stop = "30 degC"}\n'
        '[[axes]]\nkey = "dish.radius"\nvalues = [0.03, "40 mm"]\n'
    )
    (tmp_path / "s.toml").write_text(text)
    sweep = Sweep(open_or_create(tmp_path / "s.toml", tmp_path / "out"))
    columns = sweep.columns()
    assert columns["dish.contact_angle (deg)"] == [45.0] * 4 + [62.5] * 4
    assert columns["liquid.temperature (degC)"][:4] == [20.0, 20.0, 30.0, 30.0]
    assert columns["dish.radius (m)"][:2] == [0.03, 0.04]
    assert [row["dish.radius"] for row in sweep.table()][:2] == [0.03, 0.04]
    assert as_csv(columns).splitlines()[1] == "45.0,20.0,0.03,missing"
