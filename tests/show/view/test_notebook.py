"""The player in notebooks: frames, trajectories and runs show themselves, bounded in size and shut in."""

import html
import json
import re

import numpy as np
import pytest
from tests.show.view.runs import run_of

from ecume.errors import BadInput
from ecume.run import RunResult, info
from ecume.show.view.page import player, still
from ecume.trajectories.frame import Frame
from ecume.trajectories.reader import open_trajectory


def document(shown):
    """The page inside the frame that a notebook gets."""
    assert re.fullmatch(
        r'<iframe title="ecume" sandbox="allow-scripts" srcdoc="[^"<>]*" style="[^"<>]*"></iframe>', shown
    )
    return html.unescape(re.search(r'srcdoc="([^"]*)"', shown)[1])


def output(shown):
    return json.loads(re.search(r'<script type="application/json" id="run">(.*?)</script>', document(shown))[1])


@pytest.mark.parametrize("model", ["floating", "tracers", "sph", "soft"])
def test_a_run_shows_itself_whichever_way_one_holds_it(model, tmp_path):
    folder = run_of(model, tmp_path)
    with open_trajectory(folder) as trajectory:
        shown = trajectory._repr_html_()
    assert output(shown)["model"] == model
    assert RunResult(folder, 11, 1, 0.2, 0.1)._repr_html_() == shown == info(folder)._repr_html_()


@pytest.mark.parametrize("model", ["floating", "tracers", "sph", "soft"])
def test_a_frame_shows_its_particles_alone(model, tmp_path):
    with open_trajectory(run_of(model, tmp_path)) as trajectory:
        frame = trajectory[-1]
        header = output(frame._repr_html_())
    position = frame.arrays["position"]
    assert np.all(np.array(header["low"]) < position.min(axis=0))
    assert np.all(np.array(header["high"]) > position.max(axis=0))
    assert {one["name"] for one in header["numbers"]} == set(frame.numbers)
    assert header["shown"] == []


def test_a_player_keeps_within_its_size_by_leaving_frames_out(tmp_path):
    with open_trajectory(run_of("floating", tmp_path)) as trajectory:
        whole = player(trajectory)
        bound = len(whole.encode()) - 2000
        less = player(trajectory, bound / 1e6)
        with pytest.raises(BadInput, match="not two frames fit"):
            player(trajectory, 0.05)
    assert len(less.encode()) <= bound
    frames = [json.loads(re.search(r'id="chunk-0">(.*?)</script>', document(one))[1])["times"] for one in (whole, less)]
    assert len(frames[0]) == 11
    assert 2 <= len(frames[1]) < 11


def test_what_a_scene_is_called_cannot_leave_the_frame(tmp_path):
    hostile = '"></iframe><script>alert(1)</script>'
    with open_trajectory(run_of("floating", tmp_path, hostile)) as trajectory:
        assert output(player(trajectory))["title"] == hostile


def test_where_nothing_can_be_seen_the_notebook_prints_the_object(tmp_path):
    empty = Frame(0.0, {"position": np.zeros((0, 2))}, {}, {})
    with pytest.raises(BadInput, match="no particles"):
        still(empty)
    assert empty._repr_html_() is None
    assert RunResult(tmp_path / "nothing", 0, 0, 0.0, 0.0)._repr_html_() is None
