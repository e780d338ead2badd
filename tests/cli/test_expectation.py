"""The first line of a run: how many steps, and how long they are expected to take."""

from ecume.cli.output import WithExpectation
from ecume.run import Progress


def test_the_expected_time_is_the_first_line_and_is_said_once(capsys):
    heard = []
    reporter = WithExpectation(heard.append)
    first = Progress(10, 30000, 0.1, 10.0, 1, 0.0, 0.0, None)
    for progress in (first, first._replace(remaining=240.0), first._replace(remaining=200.0)):
        reporter(progress)
    assert capsys.readouterr().err == "30000 steps, about 4 min\n"
    assert len(heard) == 3
    WithExpectation(heard.append)(first._replace(steps=None, remaining=3.0))
    assert capsys.readouterr().err == "adaptive steps, about 3 s\n"
