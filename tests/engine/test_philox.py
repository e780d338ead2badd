import numpy as np
import pytest

from ecume.engine.philox import WORD, counter_of, normals, philox, uniforms

PUBLISHED = {
    ((0, 0, 0, 0), (0, 0)): (0x6627E8D5, 0xE169C58D, 0xBC57AC4C, 0x9B00DBD8),
    ((WORD,) * 4, (WORD, WORD)): (0x408F276D, 0x41C83B0E, 0xA20BC7C6, 0x6D5451FD),
    ((0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344), (0xA4093822, 0x299F31D0)): (
        0xD16CFE09,
        0x94FDCCEB,
        0x5001E420,
        0x24126EA1,
    ),
}
"""Known answers of the generator's authors [salmon2011]."""


@pytest.mark.parametrize(("asked", "answer"), PUBLISHED.items())
def test_the_generator_gives_its_authors_answers(asked, answer):
    assert philox(*asked) == answer


def test_normal_numbers_are_normal_and_do_not_know_one_another():
    drawn = np.array([normals(counter_of(who, when, 1), 7) for who in range(60) for when in range(60)])
    assert abs(drawn.mean()) < 4 / np.sqrt(drawn.size)
    assert drawn.var() == pytest.approx(1.0, abs=4 * np.sqrt(2 / drawn.size))
    assert (drawn**4).mean() == pytest.approx(3.0, abs=4 * np.sqrt(96 / drawn.size))
    assert abs((drawn[:, 0] * drawn[:, 1]).mean()) < 4 / np.sqrt(len(drawn))
    assert abs((drawn[1:, 0] * drawn[:-1, 0]).mean()) < 4 / np.sqrt(len(drawn))


def test_uniform_numbers_never_reach_their_ends():
    drawn = np.array([uniforms((k, 0, 0, 0), 2**63 - 1) for k in range(1000)])
    assert drawn.min() > 0.0
    assert drawn.max() < 1.0
