"""A download ends: after its time, its bytes and its files, whatever a server sends."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import cmu_site
import pytest

from motiondb.errors import QueryError
from motiondb.fetch import FetchLimits, FetchSettings, Patience, fetch_cmu
from motiondb.fetch.captions import caption_row
from motiondb.fetch.checks import check_amc
from motiondb.fetch.cmu_pages import Trial, read_trials
from motiondb.fetch.limits import Budget, UnreachableError
from motiondb.fetch.transfer import read_count, within

WALK = "/subjects/14/14_06.amc"
PAGE = "/search.php?subjectnumber=14"


@pytest.fixture
def site(monkeypatch: pytest.MonkeyPatch) -> Iterator[cmu_site.Site]:
    monkeypatch.setenv("no_proxy", "*")
    files = {
        PAGE: cmu_site.page(14, [(6, "walk", 60)]).encode(),
        "/subjects/14/14.asf": cmu_site.ASF.encode(),
        WALK: cmu_site.amc(5000).encode(),
    }
    with cmu_site.serve(cmu_site.Site(files)) as served:
        yield served


def fetch(url: str, folder: Path, limits: FetchLimits, patience: Patience | None = None):
    settings = FetchSettings(url, patience or Patience(5.0, 2, lambda _: None), limits)
    return fetch_cmu(["14"], folder, settings, accept_terms=True)


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize("has_length", [True, False])
def test_a_file_that_is_too_long_is_refused_and_not_kept(
    site: cmu_site.Site, tmp_path: Path, has_length: bool
) -> None:
    if not has_length:
        site.without_length = {WALK}
    ((file, reason),) = fetch(site.url, tmp_path, FetchLimits(file_bytes=100_000)).refused
    assert file == "14/14_06.amc"
    assert reason.startswith(f"{site.url}{WALK}: expected at most 100000 bytes, found ")
    assert reason.endswith(" or more. Captures are not that large; it was not kept.")
    assert names(tmp_path) == {"14.asf"}


def test_a_page_that_is_too_long_is_refused(site: cmu_site.Site, tmp_path: Path) -> None:
    with pytest.raises(Exception, match=r"expected at most 100 bytes, found \d+ or more"):
        fetch(site.url, tmp_path, FetchLimits(page_bytes=100))
    site.without_length = {PAGE}
    with pytest.raises(Exception, match=r"expected at most 100 bytes, found \d+ or more"):
        fetch(site.url, tmp_path, FetchLimits(page_bytes=100))


def test_all_bytes_together_are_limited_and_what_came_is_kept(
    site: cmu_site.Site, tmp_path: Path
) -> None:
    with pytest.raises(UnreachableError, match="expected at most 50000 bytes in all, found more"):
        fetch(site.url, tmp_path, FetchLimits(total_bytes=50_000))
    assert names(tmp_path) == {"14.asf", "14_06.amc.part"}
    assert fetch(site.url, tmp_path, FetchLimits()).refused == ()
    assert (tmp_path / "14/14_06.amc").read_bytes() == site.files[WALK]


def test_subjects_and_files_are_limited(site: cmu_site.Site, tmp_path: Path) -> None:
    with pytest.raises(QueryError, match="subjects: expected at most 1 at once, found 2"):
        fetch_cmu([1, 2], tmp_path, FetchSettings(site.url, limits=FetchLimits(pages=1)),
                  accept_terms=True)  # fmt: skip
    with pytest.raises(QueryError, match="files: expected at most 1 at once, found 2"):
        fetch(site.url, tmp_path, FetchLimits(files=1))
    assert names(tmp_path) == set()


@pytest.mark.parametrize("field", ["seconds", "pages", "files", "file_bytes"])
@pytest.mark.parametrize("value", [0, -1, float("nan"), float("inf")])
def test_limits_are_numbers_above_0(tmp_path: Path, field: str, value: float) -> None:
    with pytest.raises(QueryError, match=f"{field}: expected a number above 0, found {value!r}"):
        fetch("http://127.0.0.1:9", tmp_path, FetchLimits(**{field: value}))


def test_the_deadline_holds_over_all_attempts(tmp_path: Path) -> None:
    now = [0.0]
    budget = Budget(FetchLimits(seconds=10.0), clock=lambda: now[0])
    budget.spend("u", 5)
    now[0] = 9.9
    budget.spend("u", 5)
    assert budget.seconds_left() == pytest.approx(0.1)
    now[0] = 10.0
    with pytest.raises(UnreachableError, match=r"u: expected to be done within 10 s, found more"):
        budget.spend("u", 0)


DRIPS = {
    "head": (b"", b"HTTP/1.0 200 OK\r\nX-Long: " + b"x" * 10_000),
    "body": (b"HTTP/1.0 200 OK\r\n\r\n", b"<TR>" * 10_000),
}


@pytest.mark.parametrize("where", DRIPS)
def test_a_server_that_drips_meets_the_deadline(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, where: str
) -> None:
    """Each byte comes within the time-out of a socket, and the last one never."""
    monkeypatch.setenv("no_proxy", "*")
    at_once, slowly = DRIPS[where]
    stop = threading.Event()

    def answer(server: socket.socket) -> None:
        while not stop.is_set():
            try:
                client, _ = server.accept()
            except OSError:
                return
            threading.Thread(target=drip, args=(client,), daemon=True).start()

    def drip(client: socket.socket) -> None:
        with client:
            try:
                client.sendall(at_once)
                for byte in slowly:
                    if stop.wait(0.02):
                        return
                    client.sendall(bytes([byte]))
            except OSError:
                return

    with socket.create_server(("127.0.0.1", 0)) as server:
        threading.Thread(target=answer, args=(server,), daemon=True).start()
        url = f"http://127.0.0.1:{server.getsockname()[1]}"
        limits, patience = FetchLimits(seconds=0.5), Patience(0.1, 50, time.sleep)
        with pytest.raises(UnreachableError, match="found"):
            fetch(url, tmp_path, limits, patience)
        stop.set()


def test_work_that_takes_too_long_is_given_up() -> None:
    never = threading.Event()
    with pytest.raises(TimeoutError):
        within(0.05, never.wait)
    never.set()
    assert within(5.0, lambda: 3) == 3
    with pytest.raises(ZeroDivisionError):
        within(5.0, lambda: 1 // 0)


@pytest.mark.parametrize("text", ["", "-1", "1.5", "\u00b2", "\u0663", "9" * 5000, "1_0", None])
def test_lengths_are_plain_numbers(text: str | None) -> None:
    assert read_count(text) is None
    assert read_count(" 120 ") == 120


def test_a_server_with_absurd_numbers_is_read(site: cmu_site.Site, tmp_path: Path) -> None:
    row = (
        "<TR><TD></TD><TD>{0}</TD><TD>walk</TD><TD><A HREF='/subjects/14/14_{0}.amc'>amc</A>"
        "</TD><TD>{1}</TD></TR>"
    )
    odd = ("9" * 5000, "\u00b2", "\u0661", "1" * 30)
    text = "".join(row.format(number, 60) for number in odd) + row.format("06", "9" * 5000)
    assert read_trials(text + row.format("07", "\u00b2"), 14) == (
        Trial(14, 6, "walk", None),
        Trial(14, 7, "walk", None),
    )
    assert check_amc(b":DEGREES\n" + b"9" * 5000 + b"\nroot 1\n") is not None


def test_words_have_no_control_characters() -> None:
    row = caption_row(Trial(1, 2, "walk\x1b[31m \x00and\tturn", None))
    assert row.endswith("walk[31m and turn")
    assert len(row.split("\t")) == 6
