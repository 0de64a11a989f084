from __future__ import annotations

import zlib
from dataclasses import replace
from types import ModuleType

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb import store
from motiondb.body import body, rotation
from motiondb.errors import QueryError, StoreError
from motiondb.files import packed_files
from motiondb.records import POSE_STEP, Caption, Relation
from motiondb.store.catalogue.captures import (
    N_JOINTS,
    POSE_SIZE,
    CaptureTotals,
    flatten_motion,
    pack_poses,
    unflatten_motion,
    unpack_poses,
)


def test_what_goes_in_comes_out(database: store.Store, samples: ModuleType) -> None:
    run_id = store.start_run(database, "add", {"folder": "captures"})
    data, skeleton = b"bytes of the file\r\n\x00\xff", b"bytes of the skeleton"
    source = packed_files.pack_source("16_01.amc", data, "amc", "16.asf", skeleton)
    captions = (Caption("walk, turn"), Caption("sit", 0.1, 0.3), Caption("a tail", 0.25))
    saved = store.save_capture(
        database, samples.info("16/16_01", run_id), samples.motion(3), source, captions
    )
    assert (saved.capture_id, saved.motion_frames, saved.leg_length) == (1, 12, 0.75)
    assert saved.sha256 == packed_files.digest(data + skeleton)
    samples.assert_equal(store.load_capture(database, "16/16_01"), saved)
    (listed,) = store.load_captures(database)
    samples.assert_equal(listed, saved)
    samples.assert_equal(store.load_motion(database, 1), samples.motion(3))
    back = store.load_source(database, 1)
    assert (back.data, back.skeleton_data) == (data, skeleton)
    assert (back.file_name, back.skeleton_name, back.format) == ("16_01.amc", "16.asf", "amc")
    assert store.load_captions(database) == {1: captions}
    assert store.load_captions(database, [2]) == {}
    assert store.load_digests(database) == {saved.sha256: "16/16_01"}
    assert store.check_store(database, sources=True) == []


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**31), st.integers(1, 5))
def test_flattening_is_undone_exactly(seed: int, n_frames: int) -> None:
    rng = np.random.default_rng(seed)
    poses = rng.normal(size=(n_frames, 87)).astype(np.float32)
    np.testing.assert_array_equal(flatten_motion(unflatten_motion(poses)), poses)
    assert unflatten_motion(poses).local_rotations[0, 2, 1] == poses[0, 3 + 2 * 4 + 1]
    assert len(body.JOINTS) == N_JOINTS


def test_a_motion_that_is_not_finite_is_refused(database: store.Store, samples: ModuleType) -> None:
    motion = samples.motion()
    motion.root_positions[4, 1] = np.nan
    source = packed_files.pack_source("a.bvh", b"a", "bvh")
    with pytest.raises(StoreError) as error:
        store.save_capture(database, samples.info("a", 1), motion, source)
    assert str(error.value) == (
        "a: expected finite numbers in the motion, found others in frame 4. "
        "Nothing was saved; report the file."
    )


def test_a_name_or_content_that_is_known_is_refused(
    database: store.Store, samples: ModuleType
) -> None:
    samples.add(database, "a/walk")
    source = packed_files.pack_source("new.bvh", b"HIERARCHY a/walk", "bvh")
    info = samples.info("b/walk", 1)
    with pytest.raises(StoreError) as error:
        store.save_capture(database, info, samples.motion(), source)
    assert str(error.value) == (
        f"b/walk: expected a capture that is new to {database.path}, found this content under the "
        "name a/walk. Remove that one first, or give this one another name."
    )
    with pytest.raises(StoreError, match="found another content under a/walk"):
        store.save_capture(
            database,
            samples.info("a/walk", 1),
            samples.motion(),
            packed_files.pack_source("x.bvh", b"other", "bvh"),
        )
    assert [info.name for info in store.load_captures(database)] == ["a/walk"]


def test_captures_are_saved_together_or_not_at_all(
    database: store.Store, samples: ModuleType
) -> None:
    run_id = store.start_run(database, "add")

    def given(name: str, content: bytes, *said: Caption) -> store.NewCapture:
        source = packed_files.pack_source(f"{name}.bvh", content, "bvh")
        info, motion = samples.info(name, run_id), samples.motion(len(name))
        return store.NewCapture(info, motion, source, said)

    first, second = given("a", b"1", Caption("walk"), Caption("sit", 0.1, 0.2)), given("bb", b"2")
    with pytest.raises(StoreError, match="found this content under the name a"):
        store.save_captures(database, [first, second, given("ccc", b"1")])
    with pytest.raises(StoreError, match="found another content under bb"):
        store.save_captures(database, [first, second, given("bb", b"3")])
    assert store.load_captures(database) == []
    assert store.save_captures(database, []) == []
    saved = store.save_captures(database, [first, second])
    for info, loaded in zip(saved, store.load_captures(database), strict=True):
        samples.assert_equal(loaded, info)
    assert [info.capture_id for info in saved] == [1, 2]
    assert store.load_captions(database) == {1: first.captions}
    for info, motion in zip(saved, (first.motion, second.motion)):
        kept = store.load_motion(database, info.capture_id, or_markers=True)
        np.testing.assert_array_equal(kept.root_positions, motion.root_positions)
    assert samples.add(database, "dddd").capture_id == 3


def test_removing_takes_everything_and_no_number_comes_back(
    database: store.Store, samples: ModuleType
) -> None:
    infos = [samples.add(database, name) for name in ("a", "bb", "ccc")]
    store.save_relations(database, [Relation("bb", "a", "mirror", 0.0, 0.4, 0.01)])
    store.save_learning(database, samples.learning(infos, store.start_run(database, "learn")))
    before = store.count_rows(database)
    store.remove_captures(database, [infos[1].capture_id])
    assert [info.name for info in store.load_captures(database)] == ["a", "ccc"]
    assert store.load_relations(database) == []
    assert set(store.load_segments(database).capture_ids) == {1, 3}
    assert store.load_segments(database).scores.shape == (4, 5)
    after = store.count_rows(database)
    assert before["motion"] - after["motion"] == 1
    assert before["source"] - after["source"] == 1
    assert store.check_store(database) == []
    store.remove_captures(database, [3])
    assert samples.add(database, "bb").capture_id == 4


def test_names_are_found_by_their_end_or_suggested(
    database: store.Store, samples: ModuleType
) -> None:
    for name in ("14/14_01", "14/14_02", "a/take", "b/take"):
        samples.add(database, name)
    assert store.load_capture(database, "14_02").name == "14/14_02"
    with pytest.raises(QueryError) as error:
        store.load_capture(database, "take")
    assert str(error.value) == (
        "'take': expected one capture, found 2: a/take, b/take. Give the whole name."
    )
    with pytest.raises(QueryError) as error:
        store.load_capture(database, "14/14_01x")
    assert str(error.value) == (
        f"'14/14_01x': expected the name of a capture, found none in {database.path}. "
        "Did you mean 14/14_01 or 14/14_02?"
    )
    with pytest.raises(QueryError, match=r"found none in .* motiondb list shows the names"):
        store.load_capture(database, "zzz")


def test_tags_words_and_synonyms_are_replaced(database: store.Store, samples: ModuleType) -> None:
    samples.add(database, "a")
    store.save_tags(database, 1, {"performer": "9"})
    store.save_captions(database, 1, [Caption("run"), Caption("jump", 1.0, 2.0)])
    store.save_synonyms(database, {"dash": "run"})
    store.save_synonyms(database, {"stroll": "walk"})
    assert store.load_capture(database, "a").tags == {"performer": "9"}
    assert store.load_captions(database, [1])[1] == (Caption("run"), Caption("jump", 1.0, 2.0))
    assert store.load_synonyms(database) == {"stroll": "walk"}
    store.save_tags(database, 1, {})
    store.save_captions(database, 1, [])
    assert store.load_capture(database, "a").tags == {}
    assert store.load_captions(database) == {}
    store.save_tags(database, 1, {"performer": "10"})
    assert store.load_capture(database, "a").tags == {"performer": "10"}


def test_totals_are_those_of_the_rows(database: store.Store, samples: ModuleType) -> None:
    assert store.load_totals(database) == CaptureTotals(0, 0, 0.0, 0, 0)
    for number, name in enumerate(("a", "bb", "ccc", "dddd"), start=1):
        samples.add(database, name)
        store.save_tags(database, number, {"performer": "9" if number < 3 else name})
    store.save_captions(database, 2, [Caption("run"), Caption("jump", 1.0, 2.0)])
    store.save_captions(database, 3, [])
    store.save_captions(database, 4, [Caption("run"), Caption("run", 1.0, 2.0)])
    made = "UPDATE capture SET kind = 'generated', duration = 7.5 WHERE name = 'bb'"
    database.connection.execute(made)
    infos = store.load_captures(database)
    assert store.load_totals(database) == CaptureTotals(
        len(infos),
        sum(info.kind == "generated" for info in infos),
        pytest.approx(sum(info.duration for info in infos)),
        len({info.tags["performer"] for info in infos}),
        len(store.load_captions(database)),
    )
    assert store.load_captured(database) == {1: "a", 3: "ccc", 4: "dddd"}
    assert store.load_texts(database) == {"run": 2, "walk": 1}


def test_relations_go_by_names(database: store.Store, samples: ModuleType) -> None:
    for name in ("a", "bb", "ccc"):
        samples.add(database, name)
    relations = [
        Relation("bb", "a", "same", 0.0, 0.4, 0.0),
        Relation("ccc", "bb", "cut", 0.1, 0.2, 0.3),
    ]
    store.save_relations(database, relations)
    store.save_relations(database, [replace(relations[1], distance=0.1)])
    assert store.load_relations(database) == [relations[0], replace(relations[1], distance=0.1)]
    assert store.load_relations(database, "a") == relations[:1]
    with pytest.raises(QueryError, match="'x': expected the name of a capture"):
        store.save_relations(database, [Relation("x", "a", "same", 0.0, 0.4, 0.0)])


def test_a_damaged_source_is_told(database: store.Store, samples: ModuleType) -> None:
    digest = samples.add(database, "a").sha256
    database.connection.execute("UPDATE source SET data = ?", [zlib.compress(b"other")])
    expected = (
        f"{database.path}: expected the bytes of a.bvh with digest {digest[:12]}, found others. "
        "The file is damaged: restore a copy, or add the capture again."
    )
    with pytest.raises(StoreError) as error:
        store.load_source(database, 1)
    assert str(error.value) == expected
    assert store.check_store(database, sources=True) == [expected]


@pytest.mark.parametrize("load", [store.load_motion, store.load_source])
def test_an_unknown_number_is_told(database: store.Store, load: object) -> None:
    with pytest.raises(QueryError) as error:
        load(database, 5)
    assert str(error.value) == (f"capture 5: expected a capture in {database.path}, found none.")


def test_runs_tell_what_made_a_row(database: store.Store) -> None:
    first = store.start_run(database, "add", {"jobs": 2, "folder": database.path.parent})
    second = store.start_run(database, "learn", seed=7)
    store.finish_run(database, first)
    runs = store.load_runs(database)
    assert [(run.run_id, run.kind, run.seed) for run in runs] == [(1, "add", None), (2, "learn", 7)]
    assert runs[0].parameters == {"jobs": 2, "folder": str(database.path.parent)}
    assert runs[0].finished is not None
    assert runs[1].finished is None
    assert runs[0].started <= runs[0].finished
    assert second == 2


@pytest.mark.parametrize("n_frames", [0, 1, 2, 300])
@pytest.mark.parametrize("kind", ["floats", "multiples", "large multiples", "turns"])
def test_packed_poses_are_the_same_bit_by_bit(n_frames: int, kind: str) -> None:
    poses = np.random.default_rng(0).normal(size=(n_frames, POSE_SIZE)).astype(np.float32)
    if kind == "turns":
        poses[:, 3:] = rotation.normalize(poses[:, 3:].reshape(-1, 21, 4)).reshape(-1, 84)
    if kind == "floats":
        poses[:, 3] *= 1e38
        poses[:, 5] *= 1e-42
        poses[n_frames // 2 :, 4] = -0.0
    else:
        poses = (np.rint(poses / POSE_STEP) * POSE_STEP).astype(np.float32)
        poses[:, 0] += 17_000.0 if kind == "large multiples" else 16_000.0
    assert pack_poses(poses).startswith(b"\2") == (n_frames == 0 or kind in ("multiples", "turns"))
    unpacked = unpack_poses(pack_poses(poses))
    assert (unpacked.shape, unpacked.tobytes()) == (poses.shape, poses.tobytes())


def test_poses_that_were_packed_with_w_are_read() -> None:
    whole = np.array([[3, -2], [131072, 131000]])
    numbers = np.zeros((POSE_SIZE, 2), np.int32)
    numbers[[0, 3]] = whole
    second = np.zeros_like(numbers)
    second[[0, 3]] = [[3, -8], [131072, -131144]]
    turned = (second << 1) ^ (second >> 31)
    planes = turned.reshape(-1).view(np.uint8).reshape(-1, 4).T
    poses = unpack_poses(b"\1" + zlib.compress(np.ascontiguousarray(planes).tobytes()))
    assert (numbers * POSE_STEP == poses.T).all()
