"""Figures say what they show, in units, and show what the frames hold."""

import dataclasses
import re
import types

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from ecume.errors import BadInput, StorageError
from ecume.laws import flotation
from ecume.models.liquids import liquid_of
from ecume.scenes.floating import FloatSpec, InteractionSpec
from ecume.show import curves
from ecume.show.curves import number_over_time
from ecume.show.figure_names import FIGURE_NAMES, require_figure
from ecume.show.figures import FIGURES as ALL_FIGURES
from ecume.show.figures import plot, require_same_names
from ecume.show.floating import figures
from ecume.show.floating.figures import FLOATING_FIGURES as FIGURES
from ecume.show.style import MUTED, save, scale_for
from ecume.units import with_prefix

pytestmark = pytest.mark.sampled(2)

WITH_UNIT = re.compile(r".* \((s|mm|µm|mm²|[pnµm]?J|[pnµm]?N)\)$")
PURE_NUMBERS = {
    "number of clusters",
    "floats in a cluster",
    "floats in a raft",
    r"hexatic order $|\psi_6|$",
    "pair distribution g(r)",
    "elongation (10 and more)",
    "share of the floats",
    "share of the clusters",
    "share of the changes",
    "from",
    "to",
}
MULTIPLES = re.compile(r".*, in (mean radii|capillary lengths)$")
OVER_TIME = ("energies", "kinetic-energy", "clusters", "order", "approach", "distance", "raft-sizes", "transitions")
NOTHING_TO_DRAW = {
    "displacement": "three frames",
    "shapes": "no floats are in contact",
    "topologies": "no clusters",
} | dict.fromkeys(OVER_TIME, "single frame, at 0 s")


def curve(axes, label):
    (line,) = (line for line in axes.lines if line.get_label() == label)
    return line.get_xdata(), line.get_ydata()


@pytest.fixture
def meeting(frames):
    """The frames, and one more in which a light float touches its neighbor."""
    places = frames[-1].arrays["position"].copy()
    places[1] = places[0] + np.array([0.0, 2.0 * frames[-1].arrays["radius"][0]])
    last = frames[-1]._replace(time=1.1, arrays={**frames[-1].arrays, "position": places})
    return [*frames, last]


@pytest.mark.parametrize("what", FIGURES)
def test_every_axis_has_a_name_and_a_unit(what, scene, meeting):
    drawn = FIGURES[what](meeting, scene)
    labels = [label for axes in drawn.axes for label in (axes.get_xlabel(), axes.get_ylabel()) if label]
    assert labels
    for label in labels:
        assert WITH_UNIT.match(label) or MULTIPLES.match(label) or label in PURE_NUMBERS


@pytest.mark.long
@pytest.mark.parametrize(
    ("what", "kind", "start"), [("paths", "png", b"\x89PNG"), ("force-law", "pdf", b"%PDF"), ("bowl", "svg", b"<?xml")]
)
def test_the_name_of_a_file_says_its_format(what, kind, start, scene, frames, tmp_path):
    assert save(FIGURES[what](frames, scene), tmp_path / f"{what}.{kind}").read_bytes().startswith(start)


def test_equal_figures_are_equal_files(scene, frames, tmp_path):
    one, other = (save(curves.energies(frames, scene), tmp_path / f"{n}.svg").read_bytes() for n in range(2))
    assert one == other


@pytest.mark.sampled(3)
@pytest.mark.parametrize("what", FIGURES)
def test_no_word_is_cut_off_or_lies_on_another(what, scene, meeting):
    drawn = FIGURES[what](meeting, scene)
    canvas = FigureCanvasAgg(drawn)
    canvas.draw()
    for axes in drawn.axes:
        box = axes.get_tightbbox(canvas.get_renderer())
        assert box.x0 >= -1
        assert box.y0 >= -1
        assert box.x1 <= drawn.bbox.width + 1
        assert box.y1 <= drawn.bbox.height + 1


def test_energies_add_up_and_what_is_lost_is_dissipated(scene, frames):
    (axes,) = curves.energies(frames, scene).axes
    unit = {"energy (nJ)": 1e9, "energy (µJ)": 1e6}[axes.get_ylabel()]
    time, total = curve(axes, "total")
    parts = [curve(axes, label)[1] for label in ("kinetic", "pair", "wall")]
    assert total == pytest.approx(np.sum(parts, axis=0))
    assert total == pytest.approx([unit * frame.numbers["total_energy"] for frame in frames])
    assert curve(axes, "dissipated")[1] == pytest.approx(total[0] - total)
    assert time == pytest.approx([frame.time for frame in frames])


def test_what_was_injected_is_dissipated_where_energy_does_not_rise_by_it(scene, frames):
    driven = [
        frame._replace(
            numbers={**frame.numbers, "injected_work": n * 1e-6, "numerical_work": 0.0},
            units={**frame.units, "injected_work": "J", "numerical_work": "J"},
        )
        for n, frame in enumerate(frames)
    ]
    (axes,) = curves.energies(driven, scene).axes
    (_, total), (_, injected), (_, lost) = (curve(axes, label) for label in ("total", "injected", "dissipated"))
    lines = {line.get_label(): line for line in axes.get_lines()}
    assert lines["dissipated"].get_color() == MUTED  # the yellow of the palette is hardly visible
    assert not any("_" in label for label in lines)
    assert injected[-1] > 0.0
    assert lost == pytest.approx(total[0] - total + injected)


def test_the_kinetic_energy_of_a_bowl_at_rest_keeps_its_decades_in_bounds(scene, frames):
    asleep = frames[-1]._replace(time=2.0, numbers={**frames[-1].numbers, "kinetic_energy": 1e-200})
    still = frames[-1]._replace(time=3.0, numbers={**frames[-1].numbers, "kinetic_energy": 0.0})
    (axes,) = curves.kinetic_energy([*frames, asleep, still], scene).axes
    low, high = axes.get_ylim()
    assert 0 < low < high < 1e18 * low


@pytest.mark.parametrize("what", FIGURES)
def test_a_run_of_one_frame_in_which_nothing_moves_is_drawn_or_refused_in_a_word(what, scene, frames, tmp_path):
    rest = [frames[0]._replace(numbers=dict.fromkeys(frames[0].numbers, 0.0))]
    if what in NOTHING_TO_DRAW:
        with pytest.raises(BadInput, match=NOTHING_TO_DRAW[what]):
            FIGURES[what](rest, scene)
    else:
        assert save(FIGURES[what](rest, scene), tmp_path / "one.png").exists()


def test_clusters_are_counted_frame_by_frame(scene, frames):
    above, below = curves.clusters(frames, scene).axes
    counts, largest, mean = curve(above, "all")[1], curve(below, "largest")[1], curve(below, "mean")[1]
    assert (counts[0], counts[-1]) == (6, 6)
    together = frames[-1]._replace(
        time=2.0,
        arrays={**frames[-1].arrays, "position": np.array([[0.004 * k, 0.0] for k in range(4)] + [[1, 1], [2, 2]])},
    )
    above, below = curves.clusters([*frames, together], scene).axes
    counts, largest, mean = curve(above, "all")[1], curve(below, "largest")[1], curve(below, "mean")[1]
    assert (counts[-1], largest[-1], mean[-1]) == (3, 4, 2.0)


def test_each_path_runs_from_where_a_float_was_to_where_it_is(scene, frames):
    (axes,) = figures.paths(frames, scene).axes
    discs, lines, starts = axes.collections
    assert axes.get_xlabel() == "x (mm)"
    assert len(lines.get_segments()) == 6
    for float_path, first, last in zip(
        lines.get_segments(), frames[0].arrays["position"], frames[-1].arrays["position"], strict=True
    ):
        assert float_path[0] == pytest.approx(1e3 * first)
        assert float_path[-1] == pytest.approx(1e3 * last)
    assert np.asarray(starts.get_offsets()) == pytest.approx(1e3 * frames[0].arrays["position"])
    assert np.asarray(discs.get_offsets()) == pytest.approx(1e3 * frames[-1].arrays["position"])


def test_the_force_law_begins_where_floats_touch_and_is_the_scene_s_own(scene, frames):
    (axes,) = figures.force_law(frames, scene).axes
    drawn = {line.get_label(): line for line in axes.lines if not line.get_label().startswith("_child")}
    assert set(drawn) == {
        "cereal – cereal: attract",
        "cereal – _bead: repel",
        "_bead – _bead: attract".replace("_b", " _b", 1),
    }
    length = liquid_of(scene).capillary_length
    x, force = drawn["cereal – cereal: attract"].get_data()
    unit = {"force (nN)": 1e9, "force (µN)": 1e6}[axes.get_ylabel()]
    assert x[0] == pytest.approx(4.0)
    strength = 2 * np.pi * scene.liquid.surface_tension * 1e-8 / length
    ratio = force / (unit * strength)
    sphere = flotation.Sphere(radius=1e-3, density=1200.0, contact_angle=1.5)
    law = flotation.pair_force(sphere, sphere, 1e-3 * x, liquid_of(scene))
    assert ratio / ratio[0] == pytest.approx(law / law[0], rel=1e-7)


def test_floats_that_leave_the_surface_flat_have_no_force_law(scene, frames, monkeypatch):
    flat = [frame._replace(arrays={**frame.arrays, "charge": np.zeros(6)}) for frame in frames]
    with pytest.raises(BadInput, match="do not deform the surface"):
        figures.force_law(flat, scene)
    powerless = figures.PAIR_LAWS["none"]._replace(has_force=True)
    monkeypatch.setitem(figures.PAIR_LAWS, "none", powerless)
    quiet = dataclasses.replace(scene, interaction=InteractionSpec(law="none"))
    with pytest.raises(BadInput, match="the law 'none' exerts no force on these floats"):
        figures.force_law(frames, quiet)
    monkeypatch.undo()
    with pytest.raises(BadInput, match="'none'"):
        figures.force_law(frames, dataclasses.replace(scene, interaction=InteractionSpec(law="none")))


def test_many_frames_are_thinned_and_the_last_one_stays(scene, frames):
    many = [frames[n % 11]._replace(time=0.01 * n) for n in range(5000)]
    (axes,) = curves.energies(many, scene).axes
    time, _ = curve(axes, "total")
    assert len(time) == curves.MOST_INSTANTS
    assert (time[0], time[-1]) == (0.0, pytest.approx(49.99))


def test_one_species_needs_no_legend_of_its_own(scene, frames):
    single = dataclasses.replace(
        scene, particles=(FloatSpec(name="a", count=6, radius=1e-3, density=600.0, contact_angle=1.2),)
    )
    alike = [frame._replace(arrays={**frame.arrays, "species": np.zeros(6, dtype=int)}) for frame in frames]
    assert figures.paths(alike, single).axes[0].get_legend() is None
    assert figures.paths(frames, scene).axes[0].get_legend() is not None


def test_the_user_s_own_settings_change_no_figure_and_stay(scene, frames, tmp_path):
    usual = save(curves.clusters(frames, scene), tmp_path / "usual.svg").read_bytes()
    with mpl.rc_context({"font.size": 30, "axes.grid": False, "lines.linewidth": 9}):
        assert save(curves.clusters(frames, scene), tmp_path / "mine.svg").read_bytes() == usual
        assert mpl.rcParams["font.size"] == 30


@pytest.mark.parametrize(
    ("largest", "unit", "shown"),
    [(0.0042, "m", "mm"), (1.0, "m", "m"), (0.9999, "m", "m"), (3e-10, "J", "pJ"), (2e-5, "N", "µN"), (0.0, "J", "J")],
)
def test_a_scale_shows_numbers_from_one_to_a_thousand(largest, unit, shown):
    scale = scale_for(largest, unit)
    assert scale.unit == shown
    assert largest == 0 or 0.9 < largest * scale.factor < 1000


@pytest.mark.parametrize(
    ("largest", "unit", "shown", "factor"),
    [(0.002, "m^2", "mm^2", 1e6), (0.02, "m^3", "m^3", 1.0), (4.3e-13, "m^2/s", "µm^2/s", 1e12), (5.0, "m²", "m²", 1.0),
     (2e-6, "m^3", "mm^3", 1e9),
     (1000.0, "kg/m^3", "kg/m^3", 1.0), (2e-3, "kg*m/s", "kg*m/s", 1.0), (2000.0, "1/s", "1/s", 1.0),
     (0.02, "N*s/m", "mN*s/m", 1e3)],
)  # fmt: skip
def test_a_prefix_is_raised_to_the_power_of_its_unit_and_kilograms_have_none(largest, unit, shown, factor):
    assert scale_for(largest, unit) == (pytest.approx(factor), shown)
    number, _, name = with_prefix(largest, unit).partition(" ")
    assert float(number) == pytest.approx(largest * factor)
    assert name == shown


def test_an_unknown_figure_is_refused_with_those_there_are(opened, tmp_path, monkeypatch):
    monkeypatch.setattr("ecume.show.figures.open_trajectory", lambda directory: opened)
    with pytest.raises(BadInput, match="'energy'; did you mean energies"):
        plot(tmp_path, "energy")
    with pytest.raises(BadInput, match="'xyz'; known: energies, kinetic-energy, clusters"):
        plot(tmp_path, "xyz")


def test_a_model_without_figures_of_its_own_has_those_of_its_energies(opened, tmp_path, monkeypatch):
    opened.scene = types.SimpleNamespace(model="toy", title="toy")
    monkeypatch.setattr("ecume.show.figures.open_trajectory", lambda directory: opened)
    assert plot(tmp_path, "energies", tmp_path / "energies.png").stat().st_size > 1000
    with pytest.raises(BadInput, match="'clusters'; known: energies, kinetic-energy"):
        plot(tmp_path, "clusters")


def test_an_unknown_format_is_refused_with_those_there_are(scene, frames, tmp_path):
    with pytest.raises(BadInput, match=r"'.docx'; expected one of .*.pdf.*.png.*.svg"):
        save(curves.clusters(frames, scene), tmp_path / "a.docx")


def test_a_folder_that_is_a_file_is_a_storage_error(scene, frames, tmp_path):
    (tmp_path / "taken").write_text("")
    with pytest.raises(StorageError, match="cannot be written"):
        save(curves.clusters(frames, scene), tmp_path / "taken" / "a.png")


def test_any_number_of_the_frames_is_drawn_over_time(opened, tmp_path, monkeypatch):
    monkeypatch.setattr("ecume.show.figures.open_trajectory", lambda directory: opened)
    assert plot(tmp_path, "number:kinetic_energy").name == "kinetic_energy.png"
    with opened as trajectory:
        (axes,) = number_over_time(trajectory, trajectory.scene, "kinetic_energy").axes
        wanted = [frame.numbers["kinetic_energy"] for frame in trajectory]
    drawn = axes.lines[0].get_ydata()
    assert drawn / max(drawn) == pytest.approx(np.array(wanted) / max(wanted))
    assert axes.get_ylabel().startswith("kinetic energy (")
    with pytest.raises(BadInput, match="the frames have no number 'kinetic_enrgy'; did you mean kinetic_energy"):
        plot(tmp_path, "number:kinetic_enrgy")


def test_names_of_figures_are_known_without_what_draws_them():
    assert {model: list(names) for model, names in FIGURE_NAMES.items()} == {
        model: list(figures) for model, figures in ALL_FIGURES.items()
    }
    with pytest.raises(TypeError, match=r"model 'sph': FIGURE_NAMES .*: front; expected .* front, mine"):
        require_same_names({"sph": ("front", "mine")}, {"sph": ("front",)})
    with pytest.raises(TypeError, match=r"model 'mine': .*: none; expected .*: front"):
        require_same_names({"mine": ("front",)}, {})
    with pytest.raises(BadInput, match="no such figure as 'nonsense'"):
        require_figure("sph", "nonsense")
    require_figure("a model of its own", "nonsense")


def test_names_of_other_programs_lead_to_a_figure():
    with pytest.raises(BadInput, match=r"did you mean displacement\?"):
        require_figure("floating", "MSD")
    with pytest.raises(BadInput, match=r"did you mean pair-distribution\?"):
        require_figure("floating", "g(r)")
    with pytest.raises(BadInput, match=r"a figure of the model floating; this run is of .* tracers"):
        require_figure("tracers", "g(r)")
