"""The server of a run in progress: frames for the page that it gave out, nothing for anybody else."""

import json
import struct
import urllib.error
import urllib.request

import pytest
from tests.show.view.runs import run_of

from ecume.show.serving import HOST
from ecume.show.view.page import Source, serving


@pytest.fixture
def asked(tmp_path, monkeypatch):
    """A server with a run in progress, how it stands, and who asked to stop it."""
    monkeypatch.setattr("ecume.show.view.page.FAREWELL", 0.1)  # no page waits for the end
    state, stopped = ["running"], []
    source = Source(run_of("tracers", tmp_path), lambda: state[0], lambda: stopped.append(True))
    with serving(source) as address:
        yield address.split("/?")[0], source, state, stopped


def answer(url, method="GET", **headers):
    named = {name.replace("_", "-"): value for name, value in headers.items()}
    with urllib.request.urlopen(urllib.request.Request(url, method=method, headers=named)) as got:
        return got.read(), got.headers


def refused(url, method="GET", **headers):
    with pytest.raises(urllib.error.HTTPError) as error:
        answer(url, method, **headers)
    error.value.close()
    return error.value.code == 403


def frames_from(asked, begin):
    content, _ = answer(f"{asked[0]}/frames?from={begin}", X_Token=asked[1].token)
    (length,) = struct.unpack_from("<I", content)
    return json.loads(content[4 : 4 + length]), content[4 + length :]


def test_the_page_and_its_frames(asked):
    text, headers = answer(f"{asked[0]}/?token={asked[1].token}")
    assert b'"live":true' in text
    assert "connect-src 'self'" in headers["Content-Security-Policy"]
    output, blob = frames_from(asked, 0)
    assert output["state"] == "running"
    assert len(output["chunk"]["times"]) == 11
    assert len(blob) >= max(place["offset"] for place in output["chunk"]["places"].values())


def test_only_what_is_new_comes(asked):
    output, blob = frames_from(asked, 9)
    assert len(output["chunk"]["times"]) == 2
    output, blob = frames_from(asked, 11)
    assert (output, blob) == ({"state": "running", "chunk": None}, b"")


def test_the_end_is_sent_with_the_last_frames(asked, monkeypatch):
    monkeypatch.setattr("ecume.show.view.page.MOST_FRAMES", 6)
    asked[2][0] = "done"
    assert [frames_from(asked, begin)[0]["state"] for begin in (0, 6)] == ["running", "done"]
    assert asked[1].end_reported


def test_stopping_wants_the_token(asked):
    base, source, _, stopped = asked
    assert refused(f"{base}/stop", "POST")
    assert refused(f"{base}/stop?token={source.token}", "POST")
    assert refused(f"{base}/stop", "POST", X_Token="guess")
    assert not stopped
    answer(f"{base}/stop", "POST", X_Token=source.token)
    assert stopped == [True]


def test_strangers_get_nothing(asked):
    base, source, _, _ = asked
    page = f"{base}/?token={source.token}"
    assert refused(base)
    assert refused(f"{base}/?token=guess")
    assert refused(f"{base}/frames?from=0&token={source.token}")
    assert refused(page, Host="evil.example")
    assert refused(page, Host="localhost:1")
    assert refused(page, Origin="https://evil.example")
    assert refused(f"{base}/../../etc/passwd", X_Token=source.token)
    assert answer(page, Origin=base)[0]


def test_it_listens_on_this_machine_alone(asked):
    assert asked[0].startswith(f"http://{HOST}:")
    assert HOST == "127.0.0.1"
