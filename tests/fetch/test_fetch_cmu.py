"""Fetching from a site on the loopback interface, with every fault, and within its limits."""

from __future__ import annotations

import errno
import re
import socket
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import cmu_site
import pytest

from motiondb.errors import MotionDBError, QueryError, SheetError
from motiondb.fetch import CMU_TERMS, FetchLimits, FetchSettings, download, fetch_cmu
from motiondb.fetch.cmu import FetchProgress, check_subjects
from motiondb.fetch.download import UnreachableError, read_count

HEADER = "file\tskeleton\tperformer\tfps\tlicence\twords\n"
ROWS = (
    "14/14_01.amc\t14/14.asf\t14\t120\tCMU\tboxing\n",
    "14/14_06.amc\t14/14.asf\t14\t60\tCMU\twalk, squats\n",
)
WALK, BOX = "/subjects/14/14_06.amc", "/subjects/14/14_01.amc"


@pytest.fixture
def site(monkeypatch: pytest.MonkeyPatch) -> Iterator[object]:
    monkeypatch.setenv("no_proxy", "*")
    files = {
        "/search.php?subjectnumber=14": cmu_site.page(
            14, [(1, "boxing", 120), (6, "walk, squats", 60)]
        ).encode(),
        "/subjects/14/14.asf": cmu_site.ASF.encode(),
        BOX: cmu_site.amc(40).encode(),
        WALK: cmu_site.amc(5000).encode(),
    }
    with cmu_site.serve(cmu_site.Site(files)) as served:
        yield served


@pytest.fixture(autouse=True)
def pauses(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Seconds that a download waited, which no test waits for."""
    seconds: list[float] = []
    clock = SimpleNamespace(sleep=seconds.append, monotonic=time.monotonic)
    monkeypatch.setattr(download, "time", clock)
    return seconds


def fetch(site, folder, *, limits=None, timeout=5.0, attempts=3, **options):
    settings = FetchSettings(site.url, timeout, attempts, limits or FetchLimits())
    return fetch_cmu(["14"], folder, settings, **{"accept_terms": True, **options})


def files_in(folder: Path) -> dict[str, bytes]:
    actual = (path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): path.read_bytes() for path in actual}


def names_in(folder: Path) -> set[str]:
    return {Path(file).name for file in files_in(folder)}


def whole(site) -> dict[str, bytes]:
    captures = {
        path.removeprefix("/subjects/"): data
        for path, data in site.files.items()
        if path.startswith("/subjects/")
    }
    return {**captures, "cmu-captions.tsv": (HEADER + "".join(ROWS)).encode()}


def test_a_subject_with_its_words(site, tmp_path) -> None:
    heard: list[FetchProgress] = []
    report = fetch(site, tmp_path / "new" / "cmu", on_progress=heard.append)
    assert files_in(tmp_path / "new" / "cmu") == whole(site)
    assert report.fetched == ("14/14.asf", "14/14_01.amc", "14/14_06.amc")
    assert (report.skipped, report.refused) == ((), ())
    assert report.n_bytes == sum(
        len(data) for path, data in site.files.items() if "sub" in path[:4]
    )
    assert report.sheet == tmp_path / "new" / "cmu" / "cmu-captions.tsv"
    size = len(site.files[WALK])
    assert heard[-1] == FetchProgress("14/14_06.amc", 3, 3, size, size)


def test_again_asks_for_nothing_and_keeps_the_users_words(site, tmp_path) -> None:
    fetch(site, tmp_path)
    sheet = tmp_path / "cmu-captions.tsv"
    mine = sheet.read_text().replace("boxing", "shadow boxing") + "07/x.amc\t\t07\t\tme\thop\n"
    sheet.write_text(mine)
    site.log.clear()
    report = fetch(site, tmp_path)
    assert [path for path, _ in site.log] == ["/search.php?subjectnumber=14"]
    assert report.skipped == ("14/14.asf", "14/14_01.amc", "14/14_06.amc")
    assert sorted(sheet.read_text().splitlines()[1:]) == sorted(mine.splitlines()[1:])


@pytest.mark.parametrize("has_range", [True, False])
def test_a_transfer_cut_half_way_goes_on(site, tmp_path, pauses, has_range) -> None:
    site.has_range = has_range
    site.cuts[WALK] = [70_000]
    report = fetch(site, tmp_path)
    assert files_in(tmp_path) == whole(site)
    assert report.refused == ()
    assert site.asked(WALK) == [None, "bytes=70000-"]
    assert pauses == [1.0]


@pytest.mark.parametrize(
    ("part", "starts_again"),
    [
        (lambda data: data[:1000], False),
        (lambda data: data, False),
        (lambda _: b"of another file, longer " * 9000, True),
        (lambda _: b"of another file", True),
    ],
)
def test_a_part_of_an_earlier_session_goes_on_or_starts_again(
    site, tmp_path, part, starts_again
) -> None:
    (tmp_path / "14").mkdir()
    begun = part(site.files[WALK])
    (tmp_path / "14" / "14_06.amc.part").write_bytes(begun)
    fetch(site, tmp_path)
    assert files_in(tmp_path) == whole(site)
    assert site.asked(WALK) == [f"bytes={len(begun)}-", *([None] if starts_again else [])]


def test_a_cut_capture_under_its_final_name_is_fetched_again(site, tmp_path) -> None:
    (tmp_path / "14").mkdir()
    (tmp_path / "14" / "14_06.amc").write_bytes(site.files[WALK][:1003])
    assert "14/14_06.amc" in fetch(site, tmp_path).fetched
    assert files_in(tmp_path) == whole(site)


def test_a_capture_that_is_not_there_is_listed_and_the_others_come(site, tmp_path) -> None:
    del site.files[BOX]
    report = fetch(site, tmp_path)
    reason = f"{site.url}{BOX}: expected a file, found none there (HTTP 404)."
    assert report.refused == (("14/14_01.amc", reason),)
    assert (tmp_path / "cmu-captions.tsv").read_text() == HEADER + ROWS[1]


@pytest.mark.parametrize(
    ("data", "fault"),
    [
        (b"<html>Sorry</html>", "expected an AMC file, found a web page"),
        (
            cmu_site.amc(3).encode()[:-16],
            "expected 2 bones with 9 values in the last frame (number 3), "
            "found 1 bones with 6 values",
        ),
    ],
)
def test_a_damaged_answer_is_refused(site, tmp_path, data, fault) -> None:
    site.files[BOX] = data
    report = fetch(site, tmp_path)
    assert report.refused == (
        (
            "14/14_01.amc",
            f"{site.url}{BOX}: {fault}. "
            "The server's copy is damaged or is not a capture; it was not kept.",
        ),
    )
    assert [path.name for path in (tmp_path / "14").glob("14_01*")] == []


def test_too_long_a_length_is_refused_after_patience(site, tmp_path, pauses) -> None:
    size = len(site.files[BOX])
    site.has_range = False
    site.lengths[BOX] = size + 10
    report = fetch(site, tmp_path)
    assert report.refused == (
        (
            "14/14_01.amc",
            f"{site.url}{BOX}: expected {size + 10} bytes, found {size}. "
            "The transfer was cut: try again later.",
        ),
    )
    assert pauses == [1.0, 1.0, 2.0]


def test_without_a_length_the_contents_decide(site, tmp_path) -> None:
    site.without_length = {BOX, WALK}
    site.cuts[BOX] = [501]
    report = fetch(site, tmp_path)
    assert [file for file, _ in report.refused] == ["14/14_01.amc"]
    assert fetch(site, tmp_path).refused == ()
    assert files_in(tmp_path) == whole(site)


def test_a_busy_server_is_asked_again(site, tmp_path, pauses) -> None:
    site.statuses[WALK] = [503, 500]
    assert fetch(site, tmp_path).refused == ()
    assert pauses == [1.0, 2.0]


def test_a_server_that_forbids_is_not_asked_again(site, tmp_path, pauses) -> None:
    site.statuses[WALK] = [403]
    (refused,) = fetch(site, tmp_path).refused
    assert refused[1] == (
        f"{site.url}{WALK}: expected a file, found that the server refuses (HTTP 403 Forbidden). "
        "Try again later."
    )
    assert pauses == []


def test_a_subject_that_is_not_there(site, tmp_path) -> None:
    site.files["/search.php?subjectnumber=4"] = cmu_site.page(4, []).encode()
    with pytest.raises(QueryError) as caught:
        fetch_cmu([14, 4], tmp_path, FetchSettings(site.url), accept_terms=True)
    assert str(caught.value) == (
        f"{site.url}/search.php?subjectnumber=4: expected captures of subject 4, "
        f"found none listed. Existing subjects are listed at {site.url}/search.php."
    )
    assert files_in(tmp_path) == {}


def test_no_network(tmp_path, monkeypatch, pauses) -> None:
    monkeypatch.setenv("no_proxy", "*")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        url = f"http://127.0.0.1:{free.getsockname()[1]}"
    with pytest.raises(UnreachableError) as caught:
        fetch_cmu([14], tmp_path, FetchSettings(url, 1.0, 3), accept_terms=True)
    assert str(caught.value) == (
        f"{url}/search.php?subjectnumber=14: expected an answer, found none "
        "([Errno 111] Connection refused). Check the network, or name another server with "
        "--base-url; downloaded files are kept."
    )
    assert pauses == [1.0, 2.0]


def test_a_full_disk_stops_and_keeps_what_is_whole(site, tmp_path, monkeypatch) -> None:
    class FullDisk:
        def __init__(self, file) -> None:
            self.file = file

        def __enter__(self):
            return self

        def __exit__(self, *_) -> None:
            self.file.close()

        def write(self, chunk) -> None:
            self.file.write(chunk[:50])
            raise OSError(errno.ENOSPC, "No space left on device")

    def opened(part, mode="r", *rest, **named):
        file = real(part, mode, *rest, **named)
        return FullDisk(file) if "_06" in part.name and mode != "rb" else file

    real = Path.open
    monkeypatch.setattr(Path, "open", opened)
    with pytest.raises(UnreachableError) as caught:
        fetch(site, tmp_path)
    part = tmp_path / "14" / "14_06.amc.part"
    assert str(caught.value) == (
        f"{part}: expected room on the disk, found it full. "
        "Make room and run the same command again; downloaded files are kept."
    )
    assert (tmp_path / "cmu-captions.tsv").read_text() == HEADER + ROWS[0]
    monkeypatch.setattr(Path, "open", real)
    fetch(site, tmp_path)
    assert site.asked(WALK) == [None, "bytes=50-"]
    assert files_in(tmp_path) == whole(site)


def test_an_interruption_leaves_nothing_half_written_under_a_final_name(site, tmp_path) -> None:
    def stop(progress: FetchProgress) -> None:
        if progress.file == "14/14_06.amc":
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fetch(site, tmp_path, on_progress=stop)
    assert names_in(tmp_path) == {"14.asf", "14_01.amc", "14_06.amc.part", "cmu-captions.tsv"}
    assert (tmp_path / "cmu-captions.tsv").read_text() == HEADER + ROWS[0]
    fetch(site, tmp_path)
    assert files_in(tmp_path) == whole(site)


def test_the_terms_come_first(site, tmp_path) -> None:
    with pytest.raises(MotionDBError) as caught:
        fetch(site, tmp_path, accept_terms=False)
    assert str(caught.value) == (
        "fetch cmu: expected the terms to be accepted, found that they are not. "
        f"Read them, then pass --yes.\n{CMU_TERMS}"
    )
    assert "mocap.cs.cmu.edu" in CMU_TERMS
    assert "NSF EIA-0196217" in CMU_TERMS
    assert site.log == []


def test_a_foreign_sheet_is_not_overwritten(site, tmp_path) -> None:
    sheet = tmp_path / "cmu-captions.tsv"
    sheet.write_text("file\twords\nmine.bvh\thop\n")
    with pytest.raises(SheetError) as caught:
        fetch(site, tmp_path)
    assert str(caught.value) == (
        f"{sheet}:1: expected the columns file, skeleton, performer, fps, licence, words, "
        "found file, words. Move this file away, or fetch to another folder."
    )
    assert sheet.read_text() == "file\twords\nmine.bvh\thop\n"


def test_a_server_that_falls_silent(site, tmp_path, pauses) -> None:
    site.silent.add(WALK)
    with pytest.raises(UnreachableError) as caught:
        fetch(site, tmp_path, timeout=0.1, attempts=2)
    assert re.match(
        f"{site.url}{WALK}: expected an answer, found none .(timed out|nothing in 0.1 s).. Check",
        str(caught.value),
    )
    assert (tmp_path / "14" / "14_06.amc.part").stat().st_size == 100
    site.silent.clear()
    fetch(site, tmp_path)
    assert files_in(tmp_path) == whole(site)


def test_a_server_that_sends_byte_by_byte_is_given_up(site, tmp_path) -> None:
    site.slow.add(WALK)
    with pytest.raises(UnreachableError, match="expected 500 bytes a second or more, found"):
        fetch(site, tmp_path, timeout=0.2)
    assert len(site.asked(WALK)) == 1


def test_a_folder_that_cannot_be_made(site, tmp_path) -> None:
    (tmp_path / "14").write_text("a file in the way")
    with pytest.raises(UnreachableError) as caught:
        fetch(site, tmp_path)
    assert str(caught.value) == (
        f"{tmp_path / '14'}: expected a file that can be written, found: File exists. "
        "Choose another folder with --dir."
    )


@pytest.mark.parametrize("subject", ["x", "", 0, -3, 1000, "14_06"])
def test_subjects_are_numbers(subject) -> None:
    with pytest.raises(QueryError) as caught:
        check_subjects([subject])
    assert str(caught.value) == (
        f"subjects: expected numbers such as 14, found {str(subject)!r}. "
        "The list is at http://mocap.cs.cmu.edu/search.php."
    )


def test_no_subjects_and_no_address(tmp_path) -> None:
    with pytest.raises(QueryError, match="expected at least one number such as 14, found none"):
        check_subjects([])
    with pytest.raises(QueryError, match=r"found 'file:///etc'\. Begin with http:// or "):
        fetch_cmu([14], tmp_path, FetchSettings("file:///etc"), accept_terms=True)


@pytest.mark.parametrize("has_length", [True, False])
def test_a_file_that_is_too_long_is_refused_and_not_kept(site, tmp_path, has_length) -> None:
    if not has_length:
        site.without_length = {WALK}
    ((file, reason),) = fetch(site, tmp_path, limits=FetchLimits(file_bytes=100_000)).refused
    assert file == "14/14_06.amc"
    assert reason.startswith(f"{site.url}{WALK}: expected at most 100000 bytes, found ")
    assert reason.endswith(" or more. Captures are not that large; it was not kept.")
    assert names_in(tmp_path) == {"14.asf", "14_01.amc", "cmu-captions.tsv"}


@pytest.mark.parametrize("has_length", [True, False])
def test_a_page_that_is_too_long_is_refused(site, tmp_path, has_length) -> None:
    site.without_length = set() if has_length else {"/search.php?subjectnumber=14"}
    with pytest.raises(Exception, match=r"expected at most 100 bytes, found \d+ or more"):
        fetch(site, tmp_path, limits=FetchLimits(page_bytes=100))


def test_all_bytes_together_are_limited_and_what_came_is_kept(site, tmp_path) -> None:
    with pytest.raises(UnreachableError, match="expected at most 50000 bytes in all, found more"):
        fetch(site, tmp_path, limits=FetchLimits(total_bytes=50_000))
    assert names_in(tmp_path) == {"14.asf", "14_01.amc", "14_06.amc.part", "cmu-captions.tsv"}
    assert fetch(site, tmp_path, limits=FetchLimits()).refused == ()
    assert (tmp_path / "14/14_06.amc").read_bytes() == site.files[WALK]


def test_subjects_and_files_are_limited(site, tmp_path) -> None:
    settings = FetchSettings(site.url, limits=FetchLimits(pages=1))
    with pytest.raises(QueryError, match="subjects: expected at most 1 at once, found 2"):
        fetch_cmu([1, 2], tmp_path, settings, accept_terms=True)
    with pytest.raises(QueryError, match="files: expected at most 1 at once, found 3"):
        fetch(site, tmp_path, limits=FetchLimits(files=1))
    assert names_in(tmp_path) == set()


@pytest.mark.parametrize("value", [0, -1, float("nan"), float("inf")])
def test_limits_are_numbers_above_0(site, tmp_path, value) -> None:
    with pytest.raises(QueryError, match=f"seconds: expected a number above 0, found {value!r}"):
        fetch(site, tmp_path, limits=FetchLimits(seconds=value))
    assert site.log == []


@pytest.mark.parametrize("begun", ["HTTP/1.0 200 OK\r\n\r\n", "HTTP/1.0 200 OK\r\nX-A: "])
def test_a_server_that_drips_meets_the_deadline(begun: str, tmp_path, monkeypatch) -> None:
    """Each byte of body or head comes within the time-out of a socket, and the last one never."""
    monkeypatch.setenv("no_proxy", "*")
    stop = threading.Event()

    def drip(server: socket.socket) -> None:
        with server.accept()[0] as client:
            client.sendall(begun.encode())
            while not stop.wait(0.02):
                client.sendall(b"<TR>" * 50)

    with socket.create_server(("127.0.0.1", 0)) as server:
        thread = threading.Thread(target=drip, args=(server,), daemon=True)
        thread.start()
        settings = FetchSettings(
            f"http://127.0.0.1:{server.getsockname()[1]}", 0.2, 2, FetchLimits(seconds=0.3)
        )
        with pytest.raises(UnreachableError, match=r"to be done within 0\.3 s, found more"):
            fetch_cmu([14], tmp_path, settings, accept_terms=True)
        stop.set()
        thread.join()


@pytest.mark.parametrize("text", ["", "-1", "1.5", "\u00b2", "\u0663", "9" * 5000, "1_0", None])
def test_lengths_are_plain_numbers(text: str | None) -> None:
    assert read_count(text) is None
    assert read_count(" 120 ") == 120
