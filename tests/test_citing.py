"""A scene's papers are those that its laws name, and follow its options."""

import inspect
from dataclasses import fields

import pytest
from typer.testing import CliRunner

from ecume.citing import bibliography, bibtex, cited, in_words, papers_of
from ecume.cli import app
from ecume.errors import SceneError
from ecume.models import MODELS
from ecume.models.model import Model
from ecume.scenes.load import load_scene
from ecume.scenes.templates import copy_template, folder, templates


def papers(name, *changes):
    return papers_of(load_scene(str(folder() / f"{name}.toml"), changes))


@pytest.mark.parametrize("name", templates())
def test_every_template_has_papers(name):
    assert papers(name)
    assert set(papers(name)) <= bibliography().keys()


def test_every_law_behind_a_template_names_its_paper():
    for name in templates():
        scene = load_scene(str(folder() / f"{name}.toml"))
        laws = [law for law in MODELS[scene.model].laws(scene) if not law.__name__.startswith("no_")]
        silent = {law.__name__ for law in laws if not cited(inspect.getdoc(law) or "")}
        assert silent <= {"nonlinear_charge"}, name


def test_papers_follow_the_options():
    assert "monaghan1985" in papers("tank-at-rest", "method.kernel=cubic-spline")
    assert "monaghan1985" not in papers("tank-at-rest")
    assert "wendland1995" in papers("tank-at-rest")
    assert "schiller1933" not in papers("bouncing-particles", "hydrodynamics.drag=stokes")
    assert "dalrymple2006" in papers("dam-break", "method.turbulence=smagorinsky")
    assert "fourtakas2019" in papers("tank-at-rest")
    assert "fourtakas2019" not in papers("tank-at-rest", "method.density_diffusion=molteni")
    assert "molteni2009" in papers("tank-at-rest", "method.density_diffusion=molteni")
    assert "brackbill1992" in papers("rounding-drop")
    assert "akinci2013" not in papers("rounding-drop")
    assert "akinci2013" in papers("rounding-drop", "method.surface_tension_model=cohesion")
    assert "hosea1996" in papers("t1", "integration.integrator=tr-bdf2")
    assert "kennedy2003" in papers("t1")
    assert "vassileva2005" in papers("cereal-discs")
    assert "vassileva2005" not in papers("cereal-bowl")
    assert "moreau1988" in papers("cereal-bowl")
    soft = papers("cereal-bowl", "contacts.law=spring-dashpot")
    assert {"cundall1979", "schwager2007"} <= set(soft)
    assert "moreau1988" not in soft


def test_a_model_that_names_no_laws_rests_on_no_paper(monkeypatch):
    without = {part.name: getattr(MODELS["tracers"], part.name) for part in fields(Model) if part.name != "laws"}
    monkeypatch.setitem(MODELS, "tracers", Model(**without))
    assert papers("settling") == []


def test_liquids_by_name_bring_friction_and_its_paper():
    assert {"morris1997", "monaghan2005"} & set(papers("channel"))


def test_entries_are_whole():
    assert len(bibliography()) > 80
    for key, entry in bibliography().items():
        assert entry.startswith("@")
        assert entry.count("{") == entry.count("}"), key
        assert entry.endswith("}")
        assert len(in_words(key)) > 20


def test_the_verb_prints_bibtex(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    copy_template("t1", tmp_path / "t1.toml")
    output = CliRunner().invoke(app, ["cite", "t1.toml"])
    assert output.exit_code == 0
    assert output.stdout == bibtex(papers("t1"))
    assert "@article{rognon2009," in output.stdout


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("t1", "films.surface=jelly"),
        ("t1", "films.interface=jelly"),
        ("t1", "films.friction=jelly"),
        ("t1", "long_range_forces.law=jelly"),
        ("t1", "integration.integrator=jelly"),
        ("settling", "hydrodynamics.drag=jelly"),
        ("dam-break", "method.kernel=jelly"),
    ],
)
def test_a_scene_whose_law_does_not_exist_is_refused_by_name(name, change):
    with pytest.raises(SceneError, match=change.split("=")[0].replace(".", r"\.")):
        papers(name, change)
