"""``add`` on folders with odd files: every one is named, and all others are added."""

from __future__ import annotations

import os
import shutil
import signal
import time
from multiprocessing import resource_tracker
from pathlib import Path

import pytest
from odd_captures import AMC, ASF, BVH, DEEPMIMIC
from pebble.pool.process import PoolManager
from rights import as_others

import motiondb
from motiondb.answers.database import AddReport
from motiondb.database.catalogue import file_reading
from motiondb.database.catalogue.file_reading import AddSettings, FileToRead, read_all
from motiondb.errors import MotionDBError

pytestmark = pytest.mark.usefixtures("read_beside")

FAST = BVH.replace(" 90 0 ", " 90 0 ", 1)
for _frame in range(8):
    FAST = FAST.replace(f"\n{_frame} 90 0 ", f"\n{_frame * 4000} 90 0 ")


def add(folder: Path, base: Path, sheet: str = "", **settings: object) -> AddReport:
    """Add a folder to a new database, with a sheet if there is one."""
    words = None
    if sheet:
        words = base / "words.tsv"
        words.write_text(sheet)
    shutil.rmtree(base / "db", ignore_errors=True)
    (base / "db").mkdir()
    with motiondb.open(base / "db" / "m.duckdb") as db:
        how = AddSettings(**{"jobs": 1, **settings})
        return db.add(folder, words=words, settings=how)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with one good capture."""
    made = tmp_path / "takes"
    made.mkdir()
    (made / "good.bvh").write_text(BVH)
    return made


@pytest.mark.parametrize("jobs", [1, 2])
def test_odd_files_are_problems_and_the_good_one_is_added(
    tmp_path: Path, folder: Path, jobs: int
) -> None:
    (folder / "deep.json").write_text('{"Frames": ' + "[" * 100_000 + "]" * 100_000 + "}")
    (folder / "frames.bvh").write_text(BVH.replace("Frames: 8", "Frames: ²"))
    (folder / "huge.txt").write_text(DEEPMIMIC.replace("0.03", "9" * 5000))
    (folder / "zip.npz").write_bytes(b"PK")
    (folder / "axis.amc").write_text(AMC)
    (folder / "axis.asf").write_text(ASF.replace("axis XYZ", "axis QQQ"))
    report = add(folder, tmp_path, jobs=jobs)
    assert report.added == ("good",)
    named = [problem.split(":")[0] for problem in report.problems]
    files = ("axis.asf", "deep.json", "frames.bvh", "huge.txt", "zip.npz")
    assert sorted(named) == [f"{folder}/{name}" for name in files] or sorted(named) == [
        f"{folder}/axis.amc", *[f"{folder}/{name}" for name in files[1:]]
    ]  # fmt: skip


def test_a_name_that_is_no_text_is_a_problem(tmp_path: Path, folder: Path) -> None:
    odd = os.fsencode(folder) + b"/caf\xe9.bvh"
    try:
        Path(os.fsdecode(odd)).write_text(BVH)
    except OSError:
        pytest.skip("this file system takes no such names")
    report = add(folder, tmp_path)
    assert report.added == ("good",)
    assert report.problems == (
        f"{folder}/caf\\xe9.bvh: expected a file name in UTF-8, found other bytes. "
        "Rename the file.",
    )


@pytest.mark.skipif(os.name != "posix", reason="such names")
def test_a_name_that_commands_terminals_is_a_problem(tmp_path: Path, folder: Path) -> None:
    (folder / "two\nlines.bvh").write_text(BVH)
    (folder / "\x1b[2J.bvh").write_text(BVH)
    report = add(folder, tmp_path)
    assert report.added == ("good",)
    assert report.problems == tuple(
        f"{folder}/{name}.bvh: expected a file name without control characters, found one. "
        "Rename the file."
        for name in ("\\x1b[2J", "two\\nlines")
    )


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="POSIX")
def test_pipes_and_broken_links_are_named_and_not_waited_for(tmp_path: Path, folder: Path) -> None:
    os.mkfifo(folder / "pipe.bvh")
    os.mkfifo(folder / "02.asf")
    (folder / "02_01.amc").write_text(AMC)
    (folder / "gone.bvh").symlink_to(tmp_path / "none.bvh")
    (folder / "round.bvh").symlink_to(folder / "round.bvh")
    report = add(folder, tmp_path)
    assert report.added == ("good",)
    assert report.problems == (
        f"{folder}/02_01.amc: {folder}/02.asf: expected a readable file, found: a pipe; "
        "save what it gives in a file, and name that file.",
    )
    assert report.notes == (
        f"{folder}/gone.bvh: a link that leads to no file is not read",
        f"{folder}/pipe.bvh: a pipe or device is not read",
        f"{folder}/round.bvh: a link that leads to no file is not read",
    )


@pytest.mark.parametrize("mode", [0o000, 0o444])
def test_a_folder_that_may_not_be_read_is_named(tmp_path: Path, folder: Path, mode: int) -> None:
    (folder / "closed").mkdir()
    (folder / "closed" / "own.bvh").write_text(BVH)
    (folder / "closed").chmod(mode)
    with as_others() as can:
        if not can:
            pytest.skip("this user may read everything")
        assert add(folder, tmp_path).notes == (f"{folder}/closed: a folder that may not be read",)
        with pytest.raises(MotionDBError, match="closed: a folder that may not be read"):
            add(folder / "closed", tmp_path)
        with pytest.raises(MotionDBError, match="found a folder on the way to it that this user"):
            add(folder / "closed" / "own.bvh", tmp_path)


def test_files_are_read_here_where_no_process_can_start(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from pebble.pool.process import WorkerManager

    def refuse(*_: object) -> None:
        raise OSError(24, "Too many open files")

    def missing() -> None:  # as on Windows
        raise ModuleNotFoundError("No module named '_posixsubprocess'")

    monkeypatch.setattr(WorkerManager, "create_channels", refuse)
    monkeypatch.setattr(resource_tracker, "ensure_running", missing)
    path = folder / "good.bvh"
    jobs = [FileToRead(f"take{n}", path, None, folder, AddSettings()) for n in range(6)]
    readings = [reading for (reading,) in read_all(jobs, 2)]
    assert [(reading.name, reading.problem) for reading in readings] == [
        (f"take{n}", "") for n in range(6)
    ]


def test_what_is_not_read_is_named(tmp_path: Path, folder: Path) -> None:
    (tmp_path / "elsewhere").mkdir()
    (folder / "link").symlink_to(tmp_path / "elsewhere")
    for name in ("a.mcp", "b.MCP", "c.trb", "d.zip", ".hidden.mcp"):
        (folder / name).touch()
    assert add(folder, tmp_path).notes == (
        f"{folder}/link: a link to a folder is not followed; add that folder by itself",
        f"{folder}/a.mcp and 1 more: .mcp (Vicon Shogun capture) is not read; export as BVH",
        f"{folder}/c.trb: .trb (marker tracks of Motion Analysis) is not read; export as BVH",
        f"{folder}/d.zip: .zip (packed folder) is not read; unpack it",
    )
    (folder / "good.bvh").unlink()
    with pytest.raises(MotionDBError) as caught:
        add(folder, tmp_path)
    assert "found none." in str(caught.value)
    assert "sheet.csv" not in str(caught.value)
    (folder / "sheet.csv").write_text("a;b\n1;2\n")
    with pytest.raises(MotionDBError, match=r"sheet\.csv: no motion by which a capture is known"):
        add(folder, tmp_path)
    assert "a.mcp and 1 more: .mcp (Vicon Shogun capture) is not read; export as BVH." in str(
        caught.value
    )


def test_the_skeleton_of_another_performer_is_not_taken(tmp_path: Path, folder: Path) -> None:
    (folder / "02_01.amc").write_text(AMC)
    (folder / "35.asf").write_text(ASF)
    assert add(folder, tmp_path).problems == (
        f"{folder}/02_01.amc: expected its skeleton 02.asf in the same folder, found 35.asf. "
        "Put the ASF beside the AMC, or name it in the sheet's column 'skeleton'.",
    )
    report = add(folder, tmp_path, "file\tskeleton\n02_01\t35\n")
    assert (report.added, report.problems) == (("02_01", "good"), ())


def test_a_sheet_names_skeletons_inside_the_folder_only(tmp_path: Path, folder: Path) -> None:
    (folder / "02_01.amc").write_text(AMC)
    (tmp_path / "secret.asf").write_text(ASF)
    for name in ("../secret.asf", str(tmp_path / "secret.asf")):
        sheet = f"file\tskeleton\n02_01\t{name}\n"
        assert add(folder, tmp_path, sheet).problems == (
            f"{folder}/02_01.amc: expected a skeleton inside the added folder, found {name!r} "
            "outside. Copy it into the folder, or pass --outside-skeletons.",
        )
        assert add(folder, tmp_path, sheet, outside_skeletons=True).problems == ()
    assert add(folder, tmp_path, "file\tskeleton\n02_01\tnone.asf\n").problems == (
        f"{folder}/02_01.amc: expected the skeleton 'none.asf' of the sheet below {folder} or "
        "beside the capture, found none. Correct the column 'skeleton'.",
    )


def test_motion_faster_than_people_is_a_problem(tmp_path: Path, folder: Path) -> None:
    (folder / "fast.bvh").write_text(FAST)
    report = add(folder, tmp_path)
    assert report.added == ("good",)
    assert report.problems == (
        f"{folder}/fast.bvh: motion: expected the motion of a person, found 88% of the frames "
        f"jumping or without numbers (in the median at 1200 m/s). Check the frame rate (--fps) and "
        "the unit (--unit), or pass --keep-implausible.",
    )
    kept = add(folder, tmp_path, keep_implausible=True)
    assert (kept.added, kept.problems) == (("fast", "good"), ())


class Deadly(type(Path())):
    """A path that ends the process that reads it, but not the one that hands it on."""

    def __reduce__(self) -> tuple[object, ...]:
        ends = "lambda *_, **__: __import__('os')._exit(3)"
        methods = f"dict.fromkeys(('stat', 'is_file', 'open', 'read_bytes'), {ends})"
        base = "type(__import__('pathlib').Path())"
        return eval, (f"type('Deadly', ({base},), {methods})({str(self)!r})",)


def test_a_reader_process_that_dies_costs_only_its_file(folder: Path) -> None:
    jobs = []
    for number in range(7):
        path = folder / f"take{number}.bvh"
        path.write_text(BVH)
        jobs.append(
            FileToRead(
                path.stem, Deadly(path) if number == 3 else path, None, folder, AddSettings()
            )
        )
    readings = [reading for (reading,) in read_all(jobs, 2)]
    assert [reading.name for reading in readings] == [f"take{n}" for n in range(7)]
    assert [bool(reading.problem) for reading in readings] == [n == 3 for n in range(7)]
    assert readings[3].problem == (
        f"{folder}/take3.bvh: expected a file that can be read, found that its process ended with "
        "code 3. Export it again."
    )


class DeadlyOnce(type(Path())):
    """A path that ends the first process that unpacks it."""

    def __reduce__(self) -> tuple[object, ...]:
        path = f"__import__('pathlib').Path({str(self)!r})"
        begun = f"__import__('pathlib').Path({str(self) + '.begun'!r})"
        ends = f"{begun}.touch() or __import__('os')._exit(3)"
        return eval, (f"{path} if {begun}.exists() else {ends}",)


def here(*_: object) -> None:
    raise AssertionError("a file was read in this process, without limits")


def test_a_reader_process_that_is_ended_once_costs_no_file(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = folder / "good.bvh"
    jobs = [
        FileToRead(f"take{n}", DeadlyOnce(path) if n == 3 else path, None, folder, AddSettings())
        for n in range(5)
    ]
    monkeypatch.setattr(file_reading, "_read", here)
    assert [reading.problem for (reading,) in read_all(jobs, 2)] == [""] * 5
    assert (folder / "good.bvh.begun").exists()


def test_after_an_idle_process_has_died_files_are_read_in_others(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    managers: list[PoolManager] = []

    def start(manager: PoolManager) -> None:
        managers.append(manager)
        starts(manager)

    starts = PoolManager.start
    monkeypatch.setattr(PoolManager, "start", start)
    monkeypatch.setattr(file_reading, "_read", here)
    path = folder / "good.bvh"
    jobs = [FileToRead(f"take{n}", path, None, folder, AddSettings()) for n in range(9)]
    readings = read_all(jobs, 2)
    first = next(readings)
    (manager,) = managers
    limit = time.monotonic() + 60
    while manager.task_manager.tasks and time.monotonic() < limit:
        time.sleep(0.02)
    os.kill(next(iter(manager.worker_manager.workers)), signal.SIGKILL)
    while manager.context.alive and time.monotonic() < limit:
        time.sleep(0.02)
    assert [reading.problem for (reading,) in (first, *readings)] == [""] * 9
    assert len(managers) == 2
