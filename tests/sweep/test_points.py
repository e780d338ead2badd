"""A sweep's file is read whole or refused with all its faults; its points are those that were asked for."""

import tomllib

import numpy as np
import pytest

from ecume.errors import BadInput, SceneError
from ecume.scenes.templates import sweep_templates
from ecume.sweep.asked import READER
from ecume.sweep.points import load_sweep, named, points_of, varied


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


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('template = "t1"', "axes: is missing; nothing varies"),
        ("repeats = 2", "wanted one of scene, template and process"),
        ('template = "t1"\nscene = "a.toml"\nrepeats = 2', "wanted one of scene, template and process"),
        ('process = "t1"\nrepeats = 2', "repeats: a process has no seed"),
        ('template = "t1"\n[[axes]]\nvalues = [1]', "axes[0]: wanted key, or keys with rows"),
        ('template = "t1"\n[[axes]]\nkey = "a"', "axes[0]: wanted values, or a span"),
        ('template = "t1"\n[[axes]]\nkeys = ["a", "b"]\nrows = [[1]]', "axes[0].rows[0]: came 1 values; wanted 2"),
        ('template = "t1"\n[[axes]]\nkey = "a; import os"\nvalues = [1]', "axes[0].key"),
        ('template = "t1"\n[[axes]]\nkey = "a"\nspan = {start = -1, stop = 1, log = true}', "ratios are of positive"),
        ('template = "t1"\n[[axis]]\nkey = "a"', "axis: no such key; did you mean axes?"),
        ('template = "t1"\nrepeats = 0', "repeats"),
        ('template = "dam-brake"\nrepeats = 2', "did you mean dam-break?"),
        ('template = "t1"\nrepeats = ', "Invalid value"),
    ],
)
def test_what_cannot_be_a_sweep_is_refused_with_its_place(tmp_path, text, says):
    (tmp_path / "sweep.toml").write_text(text)
    with pytest.raises(BadInput) as refused:
        load_sweep(tmp_path / "sweep.toml")
    assert says in str(refused.value)


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
    assert all(named(spec, key) for key in varied(spec))
