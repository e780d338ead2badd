"""Curves of the page have the limits of figures: one spike does not compress them."""

import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from ecume.show.curves import ROOM, limits_without_spikes

SOURCE = Path(__file__).parents[3] / "web" / "src" / "spikes.ts"
NODE = shutil.which("node")


def limits_of(curves):
    """The limits that the page gives each curve: the source without its types, run by Node."""
    plain = SOURCE.read_text(encoding="utf-8")
    for types in (": number[]", ": [number, number]", "export ", "!"):
        plain = plain.replace(types, "")
    program = f"{plain}\nconsole.log(JSON.stringify({json.dumps(curves)}.map((curve) => limits(curve))));"
    done = subprocess.run([NODE, "-e", program], capture_output=True, text=True, check=False, timeout=200)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.skipif(NODE is None, reason="Node is not installed")
def test_curves_of_the_page_have_the_limits_of_figures():
    dice = np.random.default_rng(3)
    curves = []
    for count in (5, 19, 20, 60, 300):
        calm = np.sin(np.linspace(0.0, 6.0, count)) + dice.normal(0.0, 0.1, count)
        spiky = calm.copy()
        spiky[count // 2] = 50.0
        curves += [calm.tolist(), spiky.tolist(), (-spiky).tolist()]
    for curve, (low, high) in zip(curves, limits_of(curves), strict=True):
        least, most = limits_without_spikes([np.array(curve)])
        room = ROOM * (most - least)
        assert (low, high) == pytest.approx((least - room, most + room), rel=1e-12)


@pytest.mark.skipif(NODE is None, reason="Node is not installed")
def test_a_constant_curve_has_room_around():
    ((low, high), (none, one)) = limits_of([[2.0] * 30, [0.0] * 30])
    assert low < 2.0 < high
    assert none < 0.0 < one
