"""Painted discs cover the right pixels in their order, for any number of threads."""

import numpy as np
import pytest

from ecume.engine.rendering import DIMMEST, Dots, Look, splat

INK = np.array([0.0, 0.0, 0.0])
FLAT = Look(False, 0.0, INK)
RED, GREEN = (255.0, 0.0, 0.0), (0.0, 255.0, 0.0)


def painted(places, radius, colors, look=FLAT, shape=(40, 50)):
    pixels = np.zeros((*shape, 4), np.uint8)
    across, down = np.array(places, dtype=float).T
    splat(
        pixels,
        Dots(across, down, np.broadcast_to(np.array(radius, float), across.shape).copy(), np.array(colors)),
        look,
    )
    return pixels


@pytest.mark.parametrize("radius", [1.0, 2.5, 7.3, 15.0])
@pytest.mark.parametrize("middle", [(25.0, 20.0), (24.3, 19.9)])
def test_a_disc_covers_its_area_about_its_middle(middle, radius):
    # An edge covers a pixel by how far it is from the pixel's middle, which is right to a twentieth of a pixel.
    cover = painted([middle], radius, [RED])[..., 3] / 255.0
    rows, columns = np.mgrid[: cover.shape[0], : cover.shape[1]] + 0.5
    assert cover.sum() == pytest.approx(np.pi * radius**2, rel=0.03 if radius > 2 else 0.1)
    assert (cover * columns).sum() / cover.sum() == pytest.approx(middle[0], abs=0.05)
    assert (cover * rows).sum() / cover.sum() == pytest.approx(middle[1], abs=0.05)


def test_later_ones_lie_on_earlier_ones_and_edges_mix():
    pixels = painted([(20.0, 20.0), (26.0, 20.0)], 5.0, [RED, GREEN])
    assert pixels[20, 17].tolist() == [255, 0, 0, 255]
    assert pixels[20, 26].tolist() == [0, 255, 0, 255]
    assert pixels[20, 23].tolist() == [0, 255, 0, 255]
    assert pixels[0, 0].tolist() == [0, 0, 0, 0]
    mixed = (pixels[..., 0] > 0) & (pixels[..., 1] > 0)
    assert mixed.any()
    assert (pixels[mixed][:, :2].astype(int).sum(axis=1) <= 256).all()


def test_one_at_the_border_is_cut_and_one_beyond_it_is_not_seen():
    whole, cut = painted([(25.0, 20.0)], 6.0, [RED]), painted([(25.0, 0.0)], 6.0, [RED])
    assert (cut[:6] == whole[20:26]).all()
    assert not painted([(25.0, -8.0), (60.0, 20.0), (25.0, 49.0)], 6.0, [RED] * 3).any()


def test_a_ball_is_brightest_in_its_middle_and_a_rim_is_dark():
    ball = painted([(25.0, 20.0)], 10.0, [RED], Look(True, 0.0, INK))
    assert ball[19:21, 24:26, 0].min() >= 253
    assert ball[20, 34, 0] == pytest.approx(255 * DIMMEST, abs=60)
    assert (np.diff(ball[20, 25:34, 0].astype(int)) < 0).all()
    rimmed = painted([(25.0, 20.0)], 10.0, [RED], Look(False, 2.0, INK))
    assert rimmed[20, 25].tolist() == [255, 0, 0, 255]
    assert rimmed[20, 33].tolist() == [0, 0, 0, 255]


def test_a_dot_smaller_than_a_pixel_is_still_seen():
    assert painted([(25.5, 20.5)], 0.01, [RED])[20, 25].tolist() == [255, 0, 0, 255]


def test_the_order_of_bands_and_their_number_changes_no_pixel(monkeypatch):
    rng = np.random.default_rng(3)
    places, colors = rng.uniform(0, 40, (60, 2)), rng.uniform(0, 255, (60, 3))
    look = Look(True, 0.7, INK)
    plainly = getattr(splat, "py_func", splat)
    from ecume.engine import rendering as module

    monkeypatch.setattr(module, "BANDS", 1)
    one = np.zeros((40, 50, 4), np.uint8)
    across, down = places.T.copy()
    plainly(one, Dots(across, down, rng.uniform(1, 6, 60), colors), look)
    rng = np.random.default_rng(3)
    places, colors = rng.uniform(0, 40, (60, 2)), rng.uniform(0, 255, (60, 3))
    monkeypatch.setattr(module, "BANDS", 16)
    assert (painted(places, rng.uniform(1, 6, 60), colors, look) == one).all()
