"""A flow from a table."""

from __future__ import annotations

from pathlib import Path

import pytest

from ecume.errors import SceneError
from ecume.scenes.floating import FloatingScene
from ecume.scenes.load import load_scene

SCENE = """\
model = "floating"
duration = 1
frame_every = 0.1
[flow]
velocity_from = "flow.csv"
[[particles]]
radius = "1 mm"
density = 900
contact_angle = "60 deg"
"""


def read(folder: Path, table: str, scene: str = SCENE) -> FloatingScene:
    (folder / "flow.csv").write_text(table)
    (folder / "scene.toml").write_text(scene)
    return load_scene(folder / "scene.toml")


def test_nodes_may_stand_in_any_order_and_unit(tmp_path: Path) -> None:
    table = "x [mm],y [mm],vx [mm/s],vy\n2,1,5,0\n0,1,3,0\n1,3,8,0.5\n0,3,6,0\n1,1,4,0\n2,3,7,0\n"
    flow = read(tmp_path, table).flow
    assert flow is not None
    assert flow.nodes is not None
    assert (flow.nodes.low, flow.nodes.high) == ((0.0, 0.001), (0.002, 0.003))
    assert flow.nodes.vx == ((0.003, 0.006), (0.004, 0.008), (0.005, 0.007))
    assert flow.nodes.vy == ((0.0, 0.0), (0.0, 0.5), (0.0, 0.0))


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ("x,y,vx,vy\n0,0,1,1\n1,0,1,1\n0,1,1,1\n", "is not a grid: 3 nodes, with 2 different x and 2 different y"),
        ("x,y,vx,vy\n0,0,1,1\n0,0,1,1\n", "has a node twice"),
        ("x,y,vx\n0,0,1\n", "has no column vy"),
        ("x,y,vx,vy\n" + "".join(f"{x},{y},1,1\n" for x in (0, 1, 3) for y in (0, 1)), "uneven along x"),
        ("x,y,vx,vz\n0,0,1,1\n", "column 'vz': no such column"),
        ("x,y,vx,vy\n0,0,1,fast\n", "line 2, column vy"),
    ],
)
def test_what_is_wrong_with_a_table_is_reported_once(tmp_path: Path, table: str, said: str) -> None:
    with pytest.raises(SceneError) as caught:
        read(tmp_path, table)
    (fault,) = caught.value.faults
    assert said in str(fault)
    assert "flow.velocity_from" in str(fault)


def test_a_table_that_is_not_there_and_one_that_is_no_name_are_reported(tmp_path: Path) -> None:
    for name in ('"flaw.csv"', "3"):
        with pytest.raises(SceneError, match=r"flow\.velocity_from"):
            read(tmp_path, "", SCENE.replace('"flow.csv"', name))


def test_nodes_that_do_not_fit_together_are_refused(tmp_path: Path) -> None:
    nodes = "nodes = { low = [0, 0], high = [1, 1], vx = [[0, 0], [0, 0]], vy = [[0, 0], [0]] }"
    with pytest.raises(SceneError, match="as many numbers in each row"):
        read(tmp_path, "", SCENE.replace('velocity_from = "flow.csv"', nodes))
    backward = nodes.replace("high = [1, 1]", "high = [-1, 1]").replace("[0]]", "[0, 0]]")
    with pytest.raises(SceneError, match="larger coordinates"):
        read(tmp_path, "", SCENE.replace('velocity_from = "flow.csv"', backward))
