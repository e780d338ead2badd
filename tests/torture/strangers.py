"""Those who are not trusted: titles that want to be markup, paths or formulas, and whoever asks a server of ours."""

from __future__ import annotations

import dataclasses
import http.client
import json
import re
import socket
import string
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import urlsplit

import psutil

from ecume.run import run

from .trials import ONE_THREAD, Outcome, Trial, scene_of, times, warmed

HARMLESS = "Cereals"
HOSTILE = (
    "</script><img src=x onerror=alert(1)>",
    "$\\input{/etc/passwd}$",
    "'\"><svg/onload=alert(1)><!--",
    "';DROP TABLE runs;--",
    "../../etc",
    "%s%n{0}{{7*7}}",
    "\u202eedoc\u2028\u2029",
)


class Elements(HTMLParser):
    """What a page is made of, but for text: elements, and the names of their attributes."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[tuple[str, ...]] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note it."""
        self.found.append((tag, *sorted(name for name, _ in attrs)))


def elements(page: str) -> list[tuple[str, ...]]:
    """Of a page."""
    parser = Elements()
    parser.feed(page)
    return parser.found


def hostile(scale: float, folder: Path) -> Outcome:
    """Titles that want to be markup or formulas are text: pages have the elements of one with a harmless title, and
    tell the hostile one letter by letter; figures are drawn.
    """
    from ecume.show.figures import plot

    warmed("floating")
    usual = elements(_page(HARMLESS, folder)[0])
    titles, survived = HOSTILE[: times(scale, len(HOSTILE))], 0
    for title in titles:
        page, home = _page(title, folder)
        output = re.search(r'"title":("(?:[^"\\]|\\.)*")', page)
        as_text = output is not None and json.loads(output[1]) == title
        survived += as_text and elements(page) == usual and plot(home, "energies").stat().st_size > 1000
    return Outcome(len(titles), survived, "as text")


def _page(title: str, folder: Path) -> tuple[str, Path]:
    """The page of a short run with that title, and its directory."""
    from ecume.show.view import save_page

    scene = dataclasses.replace(scene_of("floating", "0.1 s"), title=title)
    home = folder / f"{len(list(folder.iterdir()))} {''.join(one for one in title if one in string.ascii_letters)}"
    run(scene, home, options=ONE_THREAD)
    return save_page(home, home / "page.html", 5.0).path.read_text(encoding="utf-8"), home


def strangers(scale: float, folder: Path) -> Outcome:
    """Whoever has not the token, or comes from elsewhere or under another name, gets 403; no other address answers."""
    from ecume.show.view.page import Source, serving

    warmed("floating")
    run(scene_of("floating", "0.1 s"), folder / "run", options=ONE_THREAD)
    stopped: list[bool] = []
    source = Source(folder / "run", lambda: "running", lambda: stopped.append(True))
    source.end_reported = True
    with serving(source) as address:
        port = urlsplit(address).port or 0
        ours = _code(port, "GET", f"/?token={source.token}", {}) == 200
        answers = [_code(port, *request) == 403 for request in requests_of_strangers(source.token, port)]
        answers += [_closed(other, port) for other in other_addresses()]
    return Outcome(len(answers), sum(answers) if ours and not stopped else 0, "403, or no answer")


Request = tuple[str, str, dict[str, str]]


def requests_of_strangers(token: str, port: int) -> Iterator[Request]:
    """What others ask: without the token, with one that was guessed, from elsewhere, for what there is not."""
    page, known = f"/?token={token}", {"X-Token": token}
    yield from (("GET", path, {}) for path in ("/", "/?token=", f"/?token={token[:-1]}", "/frames?from=0"))
    yield "GET", f"/frames?from=0&token={token}", {}
    yield from (("GET", page, {"Host": host}) for host in ("evil.example", f"evil.example:{port}", "localhost", ""))
    yield from (("GET", page, {"Origin": origin}) for origin in ("https://evil.example", "null", "http://127.0.0.1"))
    yield from (("GET", path, known) for path in ("/../../etc/passwd", "/%2e%2e/scene.toml", "//etc/passwd", "/stop"))
    yield from (("POST", path, {}) for path in ("/stop", f"/stop?token={token}"))
    yield "POST", "/stop", {**known, "Origin": "https://evil.example"}
    yield "POST", "/stop", {**known, "Content-Length": "99999999999"}
    yield "POST", "/scene", known


def _code(port: int, method: str, path: str, headers: dict[str, str]) -> int:
    """What the server answers with."""
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=10)
    try:
        connection.putrequest(method, path, skip_host="Host" in headers)
        for name, value in headers.items():
            connection.putheader(name, value)
        connection.endheaders()
        return connection.getresponse().status
    finally:
        connection.close()


def other_addresses() -> list[str]:
    """Those of this machine that a network sees."""
    found = (one.address for some in psutil.net_if_addrs().values() for one in some if one.family == socket.AF_INET)
    return [address for address in found if not address.startswith("127.")]


def _closed(address: str, port: int) -> bool:
    """Whether nobody listens there."""
    with socket.socket() as knocking:
        knocking.settimeout(2.0)
        return knocking.connect_ex((address, port)) != 0


TRIALS = (
    Trial("R19 hostile titles", "on pages and in figures", hostile),
    Trial("R19 strangers", "requests to a live page without token, from another origin, for other files", strangers),
)
