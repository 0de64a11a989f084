"""Motions and originals in Parquet files: the same bytes, whole moves, faults that are told."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path
from types import ModuleType

import duckdb
import numpy as np
import pytest

from motiondb import store
from motiondb.errors import QueryError, StoreError
from motiondb.files import packed_files, safe_files
from motiondb.store import moving
from motiondb.store.catalogue import parquet_files, places
from motiondb.store.connection import migrations
from motiondb.store.connection.faults import DamagedMotionError
from motiondb.store.connection.handle import Block
from motiondb.store.connection.transactions import read_meta

N_FRAMES = (12, 30, 7, 12, 25)
Content = dict[str, tuple[bytes, bytes, object]]


@pytest.fixture
def filled(
    database: store.Store, samples: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> store.Store:
    """Five captures for three Parquet files: with skeletons, without, and one without its file."""
    monkeypatch.setitem(moving._AT_MOST, parquet_files.MOTIONS, (42, 1000))
    run_id = store.start_run(database, "add")
    for number, n_frames in enumerate(N_FRAMES):
        name = "abcde"[number]
        skeleton = b"bones" if number in (1, 2) else None
        source = packed_files.pack_source(
            f"{name}.amc", name.encode() * 999, "amc", skeleton and "s.asf", skeleton
        )
        if number == 4:
            source = packed_files.leave_out(source)
        store.save_capture(
            database, samples.info(name, run_id), samples.motion(number, n_frames), source
        )
    return database


def content(database: store.Store) -> Content:
    """The bits of every motion, and every original."""
    found = {}
    for info in store.load_captures(database):
        motion = store.load_motion(database, info.capture_id)
        bits = motion.root_positions.tobytes(), motion.local_rotations.tobytes()
        found[info.name] = (*bits, vars(store.load_packed_source(database, info.capture_id)))
    return found


def test_what_is_moved_comes_out_bit_for_bit(filled: store.Store, moved_to: str) -> None:
    before, mark = content(filled), read_meta(filled, "motion_revision")
    assert store.move_motions(filled, moved_to) == 5
    files = store.load_parquet_files(filled)
    assert [file.place for file in files] == [moved_to] * 3
    assert filled.connection.execute(
        "SELECT (SELECT sum(octet_length(poses)) FROM motion), (SELECT sum(octet_length(data) + "
        "coalesce(octet_length(skeleton_data), 0)) FROM source)"
    ).fetchone() == (0, 0)
    assert content(filled) == before
    assert read_meta(filled, "motion_revision") == mark  # the cache stays valid
    assert store.check_store(filled, sources=True) == []
    assert store.move_motions(filled, moved_to) == 0
    assert parquet_files.untold_files(filled) == []
    assert store.move_motions(filled, moving.IN_DATABASE) == 5
    assert parquet_files.untold_files(filled) == [file.path for file in files]
    assert store.load_parquet_files(filled) == []
    assert content(filled) == before
    assert store.check_store(filled, sources=True) == []
    filled.local.block = Block(1, 0, bytes(files[0].n_bytes))  # of a former file of this number
    store.move_motions(filled, moved_to)
    assert content(filled) == before


def test_any_program_reads_the_files(filled: store.Store, tmp_path: Path) -> None:
    rows = filled.connection.execute(
        "SELECT c.name, poses, data, skeleton_data FROM capture c JOIN motion USING (capture_id) "
        "JOIN source USING (sha256) ORDER BY ALL"
    ).fetchall()
    store.move_motions(filled, str(tmp_path / "out"))
    query = "SELECT name, poses, data, skeleton_data FROM read_parquet(?) ORDER BY ALL"
    assert duckdb.execute(query, [str(tmp_path / "out/*.parquet")]).fetchall() == rows


def test_new_captures_lie_in_the_file_until_they_are_moved(
    filled: store.Store, samples: ModuleType, tmp_path: Path
) -> None:
    place = str(tmp_path / "out")
    store.move_motions(filled, place)
    samples.add(filled, "ffffff", words=())
    samples.add(filled, "ggggggg", words=(), kind="generated")
    before = content(filled)
    assert store.move_motions(filled, place) == 1
    assert content(filled) == before
    left = "SELECT capture_id FROM motion WHERE poses_at IS NULL"
    assert filled.connection.column(left) == [7]  # the generated one, which every question reads


def test_a_write_that_fails_leaves_whole_files_and_is_continued(
    filled: store.Store, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before, place, written = content(filled), str(tmp_path / "out"), []
    write = places._Folder.write

    def fails_at_the_second(self: places._Folder, name: str, file: Path) -> None:
        write(self, name, file)
        written.append(name)
        if len(written) == 2:
            (self._path / name).write_bytes(file.read_bytes()[:99])
            raise OSError("the disk is full")

    with monkeypatch.context() as patch:
        patch.setattr(places._Folder, "write", fails_at_the_second)
        with pytest.raises(StoreError) as error:
            store.move_motions(filled, place)
    assert str(error.value) == (
        f"{place}/{written[1]}: expected a folder that can be used, found: the disk is full. "
        "Nothing of it was moved. Look at the folder or URL, its permissions and its room."
    )
    assert [path.name for path in (tmp_path / "out").iterdir()] == written[:1]
    assert [file.name for file in store.load_parquet_files(filled)] == written[:1]
    assert content(filled) == before
    assert store.check_store(filled, sources=True) == []
    assert store.move_motions(filled, place) == 3
    assert content(filled) == before


def test_other_bytes_than_were_written_are_refused(
    filled: store.Store, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = content(filled)
    monkeypatch.setattr(places, "digest_of", lambda *_: "0")
    with pytest.raises(StoreError, match="expected the bytes that were copied there, found others"):
        store.move_motions(filled, str(tmp_path / "out"))
    assert list((tmp_path / "out").iterdir()) == []
    assert store.load_parquet_files(filled) == []
    assert content(filled) == before


def test_a_missing_file_is_named_and_found_at_another_place(
    filled: store.Store, tmp_path: Path
) -> None:
    old, new = tmp_path / "out", tmp_path / "new"
    store.move_motions(filled, str(old))
    before, file = content(filled), store.load_parquet_files(filled)[0]
    filled.local.block = None  # what was read is not asked for again
    old.rename(new)
    sentence = (
        f"{file.path}: expected a file or folder, found none. It holds motions and originals of "
        f"{filled.path}: put a copy there, or say where it lies now (motiondb compact --db "
        f"{filled.path} --motions-to PLACE)."
    )
    with pytest.raises(StoreError) as error:
        store.load_motion(filled, 1)
    assert str(error.value) == sentence
    assert not isinstance(error.value, DamagedMotionError)  # answers are not given without it
    assert len(store.load_captures(filled)) == 5
    assert store.check_quickly(filled) == []
    faults = store.check_store(filled, sources=True)
    assert (len(faults), faults[0]) == (3, sentence)
    assert store.move_motions(filled, str(new)) == 0  # nothing had to be moved
    assert parquet_files.untold_files(filled) == []
    assert len(list(new.iterdir())) == 3
    assert content(filled) == before


def test_files_are_copied_to_another_place_and_others_are_not_overwritten(
    filled: store.Store, tmp_path: Path
) -> None:
    old, new = tmp_path / "out", tmp_path / "new"
    store.move_motions(filled, str(old))
    before, files = content(filled), store.load_parquet_files(filled)
    new.mkdir()
    (new / files[1].name).write_text("something else")
    with pytest.raises(StoreError, match="expected no such file or a copy of it, found another"):
        store.move_motions(filled, str(new))
    assert (new / files[1].name).read_text() == "something else"
    assert content(filled) == before
    (new / files[1].name).unlink()
    assert parquet_files.untold_files(filled) == [files[0].path]
    assert store.move_motions(filled, str(new)) == 3
    assert parquet_files.untold_files(filled) == [file.path for file in files]  # the first one, too
    shutil.rmtree(old)
    filled.local.block = None
    assert content(filled) == before


def test_a_damaged_motion_is_told_and_the_others_are_read(
    filled: store.Store, tmp_path: Path
) -> None:
    store.move_motions(filled, str(tmp_path / "out"))
    before, file = content(filled), store.load_parquet_files(filled)[0]
    start = filled.connection.value("SELECT poses_at.start FROM motion WHERE capture_id = 2")
    data = bytearray(Path(file.path).read_bytes())
    data[start + 5] ^= 1
    Path(file.path).write_bytes(data)
    filled.local.block = None
    with pytest.raises(
        DamagedMotionError, match="expected the bytes of the capture b as they"
    ) as error:
        store.load_motion(filled, 2)
    assert str(error.value).startswith(f"{file.path}: ")
    assert [number for number, _ in store.readable_motions(filled, range(1, 6))] == [1, 3, 4, 5]
    of_file, of_capture = store.check_store(filled)
    assert of_file.startswith(f"{file.path}: expected the digest {file.sha256[:12]}, found ")
    assert of_capture.startswith(f"b: {file.path}: expected the bytes of the capture b as they")
    data[start + 5] ^= 1
    Path(file.path).write_bytes(data[:-1])  # the end is no value
    assert content(filled) == before
    Path(file.path).write_bytes(data[: start + 5])
    filled.local.block = None
    with pytest.raises(DamagedMotionError):
        store.load_motion(filled, 2)


@pytest.mark.parametrize("column", ["poses_at", "data_at", "skeleton_data_at"])
@pytest.mark.parametrize("is_here", [False, True])
def test_all_but_a_damaged_value_is_moved(
    filled: store.Store, tmp_path: Path, column: str, is_here: bool
) -> None:
    store.move_motions(filled, str(tmp_path / "out"))
    before, files = content(filled), store.load_parquet_files(filled)
    query = f"SELECT {column}.start FROM capture JOIN motion USING (capture_id) JOIN source USING "
    start = filled.connection.value(f"{query} (sha256) WHERE name = 'b'")
    data = bytearray(Path(files[0].path).read_bytes())
    data[start + 5] ^= 1
    Path(files[0].path).write_bytes(data)
    place = moving.IN_DATABASE if is_here else str(tmp_path / "new")
    with pytest.raises(StoreError, match=r"found others of the captures b\. What is damaged"):
        store.move_motions(filled, place)
    left = store.load_parquet_files(filled)
    assert left[0] == files[0]
    assert filled.connection.column("SELECT capture_id FROM motion WHERE poses_at.file_id = 1") == [
        2
    ]
    assert [file.place for file in left[1:]] == ([] if is_here else [place] * 3)
    assert parquet_files.untold_files(filled) == [file.path for file in files[1:]]
    data[start + 5] ^= 1
    Path(files[0].path).write_bytes(data)  # a copy in its place
    for file in files[1:]:
        Path(file.path).unlink()
    assert content(filled) == before
    store.move_motions(filled, place)
    assert parquet_files.untold_files(filled) == [file.path for file in [*files[1:], files[0]]]
    shutil.rmtree(tmp_path / "out")
    filled.local.block = None
    assert content(filled) == before
    assert store.check_store(filled, sources=True) == []


def test_what_another_process_put_there_is_not_deleted(
    filled: store.Store, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    store.move_motions(filled, str(tmp_path / "out"))

    def fails_once_it_is_there(self: places._Folder, name: str, file: Path) -> None:
        self._path.mkdir(exist_ok=True)
        shutil.copyfile(file, self._path / name)
        raise OSError("interrupted")

    monkeypatch.setattr(places._Folder, "write", fails_once_it_is_there)
    with pytest.raises(StoreError, match="interrupted"):
        store.move_motions(filled, str(tmp_path / "new"))
    name = store.load_parquet_files(filled)[0].name
    assert (tmp_path / "new" / name).exists()


def test_a_link_to_the_place_is_the_place(filled: store.Store, tmp_path: Path) -> None:
    out, link = tmp_path / "out", tmp_path / "link"
    store.move_motions(filled, str(out))
    link.symlink_to(out)
    assert store.move_motions(filled, str(link)) == 0
    filled.connection.execute("UPDATE parquet_file SET place = ?", [str(link)])  # an older one
    assert store.move_motions(filled, str(out)) == 0
    assert parquet_files.untold_files(filled) == []


def test_a_link_in_the_place_of_a_moved_file_is_neither_read_nor_written(
    filled: store.Store, tmp_path: Path
) -> None:
    store.move_motions(filled, str(tmp_path / "out"))
    first = parquet_files.load_parquet_files(filled)[0]
    victim, there = tmp_path / "victim", tmp_path / "out" / first.name
    there.rename(victim)
    there.symlink_to(victim)
    before = victim.read_bytes()
    for target in (str(tmp_path / "else"), moving.IN_DATABASE, str(tmp_path / "out")):
        with pytest.raises(StoreError, match="a link in the place of a file that motiondb made"):
            store.move_motions(filled, target) or store.load_motion(filled, 1)
    there.unlink()
    victim.rename(there)
    (tmp_path / "new").mkdir()
    (tmp_path / "new" / first.name).symlink_to(victim)
    with pytest.raises(StoreError, match="a link in the place of a file"):
        store.move_motions(filled, str(tmp_path / "new"))
    assert not victim.exists()
    assert there.read_bytes() == before


def test_a_draft_is_not_written_through_a_link(filled: store.Store, tmp_path: Path) -> None:
    victim, draft = tmp_path / "victim", safe_files.draft_of(filled.path)
    victim.touch()
    draft.symlink_to(victim)
    assert store.move_motions(filled, str(tmp_path / "out")) == len(N_FRAMES)
    assert victim.read_bytes() == b""


def test_no_room_for_a_draft_is_not_blamed_on_the_place(
    filled: store.Store, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    store.move_motions(filled, str(tmp_path / "out"))
    monkeypatch.setattr(safe_files, "draft_of", lambda _path: tmp_path / "none" / "draft")
    with pytest.raises(StoreError, match=r"motions.duckdb: expected room for a draft beside it"):
        store.move_motions(filled, moving.IN_DATABASE)


def test_motions_in_order_are_read_together(
    filled: store.Store, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(moving._AT_MOST, parquet_files.MOTIONS, (1000, 1000))
    store.move_motions(filled, str(tmp_path / "out"))
    sizes, read = list[int](), places._Folder.read

    def counted(self: places._Folder, name: str, start: int, stop: int) -> bytes:
        sizes.append(stop - start)
        return read(self, name, start, stop)

    monkeypatch.setattr(places._Folder, "read", counted)
    for number in (1, 2, 3, 4, 5):
        store.load_motion(filled, number)
    assert len(sizes) == 2  # the first alone, then all that follow
    lengths = dict(
        filled.connection.execute("SELECT capture_id, poses_at.n_bytes FROM motion").fetchall()
    )
    monkeypatch.setattr(parquet_files, "_AHEAD", lengths[3] + 4 + lengths[4])
    for numbers, expected in (((5, 1), [5, 1]), ((2, 3), [2, 3])):
        sizes.clear()
        filled.local.block = None
        for number in numbers:
            store.load_motion(filled, number)
        assert sizes[0] == lengths[expected[0]]
    assert sizes[1] == lengths[3] + 4 + lengths[4]


def test_a_removed_capture_comes_back_and_files_without_captures_are_forgotten(
    filled: store.Store, tmp_path: Path
) -> None:
    store.move_motions(filled, str(tmp_path / "out"))
    before, files = content(filled), store.load_parquet_files(filled)
    for number in (1, 2):
        store.remove_captures(filled, [number])
    store.restore_captures(filled, [2])
    store.restore_captures(filled, [1])
    assert content(filled) == before
    for number in (1, 2):
        store.remove_captures(filled, [number])
    filled.close()
    done = store.compact(filled.path)
    assert (done.moved, done.unused) == (0, (files[0].path,))
    with store.open_store(filled.path) as opened:
        assert store.load_parquet_files(opened) == files[1:]
        assert store.check_store(opened, sources=True) == []
        assert content(opened) == {name: before[name] for name in "cde"}
    assert Path(files[0].path).exists()
    assert store.compact(filled.path).unused == ()  # it was told


def test_compacting_moves_and_gives_the_room_back(
    database: store.Store, samples: ModuleType, tmp_path: Path
) -> None:
    noise = np.random.default_rng(0).bytes(1_500_000)
    source = packed_files.pack_source("a.bvh", noise, "bvh")
    run_id = store.start_run(database, "add")
    store.save_capture(database, samples.info("a", run_id), samples.motion(), source)
    before = content(database)
    database.close()
    done = store.compact(database.path, motions_to=str(tmp_path / "out"))
    assert done.moved == 1
    assert done.after < done.before - 1_000_000
    with store.open_store(database.path) as opened:
        assert content(opened) == before
        assert store.load_runs(opened)[-1].kind == "move"
    assert len(store.compact(database.path, motions_to="here").unused) == 1
    with store.open_store(database.path) as opened:
        assert content(opened) == before


def test_a_database_of_version_5_takes_part(filled: store.Store, tmp_path: Path) -> None:
    before = content(filled)
    store.remove_captures(filled, [1])
    for schema in ("main", "trash"):
        for column in (
            "source DROP data_at",
            "source DROP skeleton_data_at",
            "motion DROP poses_at",
        ):
            filled.connection.execute(f"ALTER TABLE {schema}.{column}")
    filled.connection.execute("ALTER TABLE segment_score DROP scores_at")
    filled.connection.execute("DROP TABLE parquet_file")
    for table in ("known_file", "finding", "capture_quality"):
        filled.connection.execute(f"DROP TABLE {table}")
    filled.connection.execute("UPDATE meta SET value = '5' WHERE key = 'schema'")
    filled.close()
    with store.opened_damaged(filled.path) as (opened, _):  # it stays as it is
        saved = {each.info.name: each for each in store.salvage_captures(opened)}
        assert [saved[name].lost for name in "bcde"] == [()] * 4
    with store.open_store(filled.path) as opened:
        assert migrations.schema_version(opened.connection, "") == migrations.newest_version()
        assert store.check_store(opened, sources=True) == []
        store.restore_captures(opened, [1])
        assert content(opened) == before
        store.move_motions(opened, str(tmp_path / "out"))
        assert content(opened) == before


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("", "'': expected a folder or a URL that fsspec knows, found nothing."),
        ("s3://", "s3://: expected a folder or a URL that fsspec knows, found no name in it."),
        ("http://[x", "http://[x: expected a folder or a URL that fsspec knows, found: Invalid"),
        ("~nobody-of-this-name/x", "~nobody-of-this-name/x: expected a folder or a URL that"),
        ("a\0b", "a\0b: expected a folder or a URL that fsspec knows, found: embedded null"),
        ("memory://a", "memory://a: expected a URL whose files stay, found one of memory or of"),
        ("simplecache::ftp://u:SECRET@h/x", "simplecache::ftp://h/x: expected a URL whose files"),
        ("s3://KEY:SECRET@h/x", "s3://h/x: expected a URL without a user, a password or a query"),
        ("s3://KEY:SEC/RET@h/x", "s3://h/x: expected a URL without a user, a password or a query"),
        ("s3://SECRET:@h/x", "s3://h/x: expected a URL without a user, a password or a query"),
        ("https://h/x?sig=SECRET", "https://h/x: expected a URL without a user, a password or a"),
    ],
)
def test_what_cannot_be_a_place_is_told_without_its_secrets(text: str, found: str) -> None:
    with pytest.raises(QueryError) as error:
        places.place_name(text)
    assert str(error.value).startswith(found)
    assert "SEC" not in str(error.value)


def test_a_place_has_one_name(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to("out")
    for text in ("out", "link", "a/../out", "out//"):
        assert places.place_name(f"{tmp_path}/{text}") == str(tmp_path / "out")
    assert places.place_name(f"file://{tmp_path}/link/") == str(tmp_path / "out")
    assert places.place_name("s3://bucket//a///b/") == "s3://bucket/a/b"


def test_a_place_that_is_refused_leaves_the_trash(filled: store.Store, tmp_path: Path) -> None:
    store.remove_captures(filled, [1])
    filled.close()
    (tmp_path / "file").touch()
    for text, found in (
        ("none/a/b", "expected the folder {0}/none/a, found none. Make the folder first."),
        ("file", "expected a folder, found a file. Name another one."),
    ):
        with pytest.raises(StoreError) as error:
            store.compact(filled.path, motions_to=f"{tmp_path}/{text}")
        assert str(error.value) == f"{tmp_path}/{text}: {found.format(tmp_path)}"
    with store.open_store(filled.path) as opened:
        store.restore_captures(opened, [1])


def test_a_url_needs_its_package(filled: store.Store, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(
        StoreError, match="nonsense://x: expected a folder that can be used, found: "
    ):
        store.move_motions(filled, "nonsense://x")
    monkeypatch.setitem(sys.modules, "fsspec", None)
    with pytest.raises(StoreError, match=r"pip install 'motiondb\[cluster\]'"):
        store.move_motions(filled, "s3://not-opened-before/x")


def test_files_that_were_moved_by_hand_in_part_are_found(
    filled: store.Store, tmp_path: Path
) -> None:
    here, there = tmp_path / "here", tmp_path / "there"
    store.move_motions(filled, str(here))
    before = content(filled)
    first, second, third = [Path(file.path) for file in store.load_parquet_files(filled)]
    there.mkdir()
    first.rename(there / first.name)
    lost = second.rename(tmp_path / second.name)
    with pytest.raises(StoreError) as error:
        store.move_motions(filled, str(there))
    told = f"{second}: expected a file or folder, found none. It holds motions and originals of "
    assert str(error.value).startswith(told)
    assert str(error.value).endswith("\nThe other files (2) are where they should be.")
    lost.rename(second)
    store.move_motions(filled, str(there))
    assert {Path(file.path).parent for file in store.load_parquet_files(filled)} == {there}
    assert content(filled) == before
    assert third.exists()


def test_a_folder_that_was_moved_away_is_not_made_anew(
    filled: store.Store, samples: ModuleType, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    store.move_motions(filled, str(out))
    store.remove_captures(filled, [1])
    samples.add(filled, "new")
    filled.close()
    out.rename(tmp_path / "away")
    with pytest.raises(StoreError, match="expected a file or folder, found none"):
        store.compact(filled.path, motions_to=str(out))
    assert not out.exists()
    with store.open_store(filled.path) as opened:
        assert [number for number, _ in store.load_trash(opened)] == [1]


def test_what_a_kill_left_in_a_place_is_told_by_the_next_move(
    filled: store.Store, moved_to: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Killed(BaseException):
        pass

    def half(file: parquet_files.ParquetFile, draft: Path) -> None:
        place = places.open_place(file.place)
        draft.write_bytes(draft.read_bytes()[:100])
        place.write(file.name, draft)
        raise Killed

    with monkeypatch.context() as patch:
        patch.setattr(moving, "_put", half)
        with pytest.raises(Killed):
            store.move_motions(filled, moved_to)
    (left,) = parquet_files.untold_files(filled)
    filled.close()
    done = store.compact(filled.path, motions_to=moved_to)
    assert done.unused == (left,)
    assert store.compact(filled.path).unused == ()
    with store.open_store(filled.path) as opened:
        assert left not in {file.path for file in store.load_parquet_files(opened)}
        assert store.check_store(opened) == []


def test_what_a_killed_copy_between_places_left_is_written_anew(
    filled: store.Store, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    store.move_motions(filled, str(tmp_path / "out"))
    before, there = content(filled), tmp_path / "there"
    there.mkdir()

    def half(file: parquet_files.ParquetFile, _draft: Path) -> None:
        (there / file.name).write_bytes(b"half")  # as at a URL
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(moving, "_put", half)
        with pytest.raises(KeyboardInterrupt):
            store.move_motions(filled, str(there))
    store.move_motions(filled, str(there))
    assert {file.place for file in store.load_parquet_files(filled)} == {str(there)}
    assert content(filled) == before
    assert store.check_store(filled, sources=True) == []


@pytest.mark.parametrize(
    ("column", "value", "told"),
    [
        ("name", "../../etc/passwd", "expected a name of a Parquet file as motiondb writes it"),
        ("place", "simplecache::ftp://h/x", "expected a URL whose files stay, found one of memory"),
        ("place", "s3://u:SECRET@h/x", "expected a URL without a user, a password or a query"),
        ("place", "some/folder", "as motiondb writes it, found another form"),
    ],
)
def test_a_place_that_another_program_wrote_is_not_opened(
    filled: store.Store, tmp_path: Path, column: str, value: str, told: str
) -> None:
    store.move_motions(filled, str(tmp_path / "out"))
    filled.connection.execute(f"UPDATE parquet_file SET {column} = ? WHERE file_id = 1", [value])
    with pytest.raises(StoreError, match=told) as error:
        store.load_motion(filled, 1)
    assert "SECRET" not in str(error.value)
    assert told in " ".join(store.check_store(filled))
