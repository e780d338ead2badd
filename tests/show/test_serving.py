"""The server of pages: whatever is sent gets an answer, and the token is private."""

import json
import socket
import stat
import time
import urllib.parse
from pathlib import Path

import pytest

from ecume.errors import StorageError
from ecume.show import serving
from ecume.show.play.pages import Game
from ecume.show.serving import Answer, redirect_file, served


class Site:
    token = "secret"
    policy = "default-src 'none'"

    def get(self, path, query):
        if path == "/damaged":
            raise StorageError("0000.gsd: frame 3 is damaged")
        return Answer(b"page", "text/plain") if path == "/" else None

    def post(self, path, body):
        return Answer(body, "text/plain")


@pytest.fixture
def place():
    with served(Site()) as address:
        yield urllib.parse.urlsplit(address)


def sent(place, request, wait=True):
    """The answer to the bytes of a request."""
    with socket.create_connection((place.hostname, place.port), timeout=60) as one:
        one.sendall(request.replace(b"HERE", place.netloc.encode()))
        answer = b""
        while wait and (part := one.recv(65536)):
            answer += part
        return answer


@pytest.mark.parametrize("address", [b"http://[evil/", b"//[", b"http://[::1", b"/%00", b"/\xff"])
def test_addresses_that_are_none_get_an_answer(place, address, capfd):
    for method in (b"GET", b"POST"):
        answer = sent(place, method + b" " + address + b" HTTP/1.0\r\nHost: HERE\r\n\r\n")
        assert answer.split(b" ")[1] in (b"400", b"403")
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("host", [b"evil.example", b"[", b"", b"127.0.0.1", b"HERE.evil"])
def test_another_host_gets_nothing(place, host):
    assert b"403" in sent(place, b"GET /?token=secret HTTP/1.0\r\nHost: " + host + b"\r\n\r\n").split(b"\r\n")[0]
    assert b"200" in sent(place, b"GET /?token=secret HTTP/1.0\r\nHost: HERE\r\n\r\n").split(b"\r\n")[0]


def test_a_run_that_cannot_be_read_is_an_answer(place, capfd):
    answer = sent(place, b"GET /damaged HTTP/1.0\r\nHost: HERE\r\nX-Token: secret\r\n\r\n")
    assert b"503" in answer.split(b"\r\n")[0]
    assert b"frame 3 is damaged" in answer
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    "request_", [b"", b"GET /", b"POST / HTTP/1.0\r\nHost: HERE\r\nX-Token: secret\r\nContent-Length: 9\r\n\r\n1"]
)
def test_a_connection_that_sends_nothing_more_is_closed(monkeypatch, request_):
    monkeypatch.setattr(serving._Requests, "timeout", 0.2)
    with served(Site()) as address:
        began = time.monotonic()
        sent(urllib.parse.urlsplit(address), request_)
        assert time.monotonic() - began < 25.0  # by default 30 s


class Moving:
    time = 0.0


class Toy:
    moving = Moving()

    def __init__(self):
        self.deeds = {"pour": lambda asked: float(asked["amount"])}


@pytest.mark.parametrize(
    "body", [b"[" * 90_000, b'{"what": "pour", "amount": 1' + b"0" * 400 + b"}", b"\xff", b"7", b"1e999"]
)
def test_what_no_page_sends_is_answered(body):
    answer = Game(Toy()).post("/do", body)
    assert "unknown action" in json.loads(answer.content)["said"]


def test_the_token_is_in_a_private_file_and_not_among_the_arguments_of_the_browser():
    address = "http://127.0.0.1:1234/?token=a&b"
    with redirect_file(address) as shown:
        assert "token" not in shown
        file = Path(urllib.parse.unquote(urllib.parse.urlsplit(shown).path))
        assert "url=http://127.0.0.1:1234/?token=a&amp;b" in file.read_text(encoding="utf-8")
        assert stat.S_IMODE(file.stat().st_mode) == 0o600
        assert stat.S_IMODE(file.parent.stat().st_mode) == 0o700
    assert not file.parent.exists()


def test_the_browser_gets_the_file(monkeypatch, capsys):
    from ecume.cli import runs

    opened = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    with runs.offered("http://127.0.0.1:1/?token=secret"):
        assert opened[0].startswith("file:")
        assert "secret" not in opened[0]
    assert "token=secret" in capsys.readouterr().out
