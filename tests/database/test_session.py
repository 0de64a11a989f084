"""One session, one cache: every question sees one revision of the store, whoever changes it."""

from __future__ import annotations

import shutil
import threading
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import motiondb
from motiondb import MotionDB, store
from motiondb.database.catalogue.cataloguing import AddSettings
from motiondb.errors import QueryError
from motiondb.language import vocabulary
from motiondb.learn.learned import Learned
from motiondb.learn.learned_model import from_stored, to_stored
from motiondb.learn.recognition import LearnSettings

WORDS = {"ana/bow_1": "bow", "ana/jump_1": "jump", "boris/kick_1": "kick", "boris/punch_1": "punch"}
N_THREADS = 8


@pytest.fixture(scope="module")
def four_learned(tmp_path_factory: pytest.TempPathFactory, samples_folder: Path) -> Path:
    """A database that has learned three symbols from four captures with words."""
    folder = tmp_path_factory.mktemp("few")
    for name in WORDS:
        target = folder / "captures" / f"{name}.bvh"
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(samples_folder / f"{name}.bvh", target)
    with motiondb.open(folder / "few.duckdb") as db:
        db.add(folder / "captures", settings=AddSettings(jobs=1))
        for name, words in WORDS.items():
            db.words.set(name, words)
        db.learn(LearnSettings(n_symbols=3))
    return folder / "few.duckdb"


@pytest.fixture
def few(tmp_path: Path, four_learned: Path) -> Path:
    """A copy that a test may change."""
    return shutil.copy(four_learned, tmp_path / "few.duckdb")


@pytest.fixture
def db(few: Path) -> Iterator[MotionDB]:
    with motiondb.open(few) as opened:
        yield opened


def assert_whole(learned: Learned) -> None:
    """Counts, captions and segments tell of the same captures and the same words."""
    said = Counter(
        word
        for capture, captions in learned.captions.items()
        if learned.captures[capture].kind == "captured"
        for caption in captions
        for word in set(vocabulary.words_of(caption.words, learned.synonyms))
    )
    assert {w: n for w, n in zip(learned.association.words, learned.association.counts) if n} == {
        w: n for w, n in said.items() if w in learned.word_numbers
    }
    assert set(learned.rows) == set(learned.captures)
    assert learned.segments.scores.shape[1] == learned.symbols.n_symbols
    assert len(learned.distances) == learned.symbols.n_symbols


def test_another_opening_of_the_file_learns_anew(few: Path) -> None:
    with motiondb.open(few) as one, motiondb.open(few) as two:
        assert one.like("ana/bow_1")[0].capture == "ana/bow_1"
        two.learn(LearnSettings(n_symbols=2))
        assert one.like("ana/bow_1").matches == two.like("ana/bow_1").matches
        assert one.search("kick").matches == two.search("kick").matches
        assert one.learned.symbols.n_symbols == 2
        assert_whole(one.learned)
        two.learn(LearnSettings(n_symbols=2, seed=9))  # as many symbols, other ones
        assert one.like("ana/bow_1").matches == two.like("ana/bow_1").matches
        assert one.describe("ana/bow_1") == two.describe("ana/bow_1")


def test_lemmas_of_one_database_are_not_those_of_another(few: Path, learned_file: Path) -> None:
    with motiondb.open(few) as db, motiondb.open(learned_file, read_only=True) as other:
        with store.transaction(db.store):
            model = from_stored(store.load_learning(db.store))
            store.save_learning(db.store, to_stored(replace(model, lemmas={"frobs": "kick"})))
        assert db.search("frobs").matches[0].capture == "boris/kick_1"
        with pytest.raises(QueryError, match="found 'frob'\\."):
            other.search("frobs")


def test_what_was_loaded_is_kept_until_something_changes(db: MotionDB) -> None:
    first = db.learned
    db.search("kick")
    db.describe("ana/bow_1")
    assert db.learned is first
    db.words.set("ana/bow_1", "bow, kick")
    assert db.learned is not first
    assert first.association.counts.sum() == 4  # whoever holds it sees what was
    assert db.learned.association.counts.sum() == 5


def test_values_are_kept_for_one_revision(db: MotionDB) -> None:
    loads: list[str] = []

    def load() -> int:
        loads.append("loaded")
        return len(loads)

    assert [db.session.kept("x", load) for _ in range(2)] == [1, 1]
    assert db.session.kept("y", load) == 2
    with store.transaction(db.store):
        assert db.session.kept("x", load) == 3  # it may yet be undone, so it is not kept
    assert [db.session.kept("x", load) for _ in range(2)] == [4, 4]
    with pytest.raises(ZeroDivisionError):
        db.session.kept("z", lambda: 1 // 0)  # nothing is kept of a load that raised
    assert db.session.kept("z", load) == 5


def test_a_long_load_keeps_nobody_from_other_values(db: MotionDB) -> None:
    assert db.session.kept("short", lambda: 1) == 1
    loading, seen = threading.Event(), threading.Event()

    def load() -> int:
        loading.set()
        assert seen.wait(60)  # ends only after the others were answered
        return 2

    with ThreadPoolExecutor(2) as pool:
        long = [pool.submit(db.session.kept, "long", load) for _ in range(2)]
        assert loading.wait(60)
        assert db.session.kept("short", lambda: 3) == 1
        assert db.session.kept("new", lambda: 4) == 4
        assert db.learned.has_words
        seen.set()
        assert [asked.result() for asked in long] == [2, 2]


def test_a_value_is_loaded_once_for_all_threads(db: MotionDB) -> None:
    loads: list[int] = []

    def load() -> int:
        loads.append(1)
        return len(loads)

    with ThreadPoolExecutor(N_THREADS) as pool:
        values = list(pool.map(lambda _: db.session.kept("x", load), range(N_THREADS)))
    assert values == [1] * N_THREADS


def test_a_value_of_a_revision_that_ended_while_it_was_loaded_is_not_kept(few: Path) -> None:
    with motiondb.open(few) as one, motiondb.open(few) as two:

        def load() -> str:
            two.set_words("ana/bow_1", "bow, kick")
            with ThreadPoolExecutor(1) as other:  # reads the new revision while this one loads
                assert other.submit(one.session.kept, "y", lambda: "new").result() == "new"
            return "old"

        assert one.session.kept("x", load) == "old"
        assert one.session.kept("x", lambda: "new") == "new"


def test_what_an_undone_change_showed_is_forgotten(db: MotionDB) -> None:
    def change() -> None:
        with store.transaction(db.store):
            db.captures.remove(["ana/bow_1"])
            assert "ana/bow_1" not in {info.name for info in db.learned.captures.values()}
            raise RuntimeError("stopped")

    with pytest.raises(RuntimeError, match="stopped"):
        change()
    assert_whole(db.learned)
    assert db.like("ana/bow_1")[0].capture == "ana/bow_1"
    db.words.set("ana/bow_1", "bow")  # a change of the same number as the one undone
    assert db.like("ana/bow_1")[0].capture == "ana/bow_1"


def test_a_reader_of_an_earlier_revision_keeps_to_it(few: Path) -> None:
    with motiondb.open(few) as one, motiondb.open(few) as two:
        with one.session.reading():
            before = one.learned.association.counts.sum()
            with ThreadPoolExecutor(1) as other:
                other.submit(two.set_words, "ana/bow_1", "bow, kick").result()
                assert other.submit(lambda: one.learned.association.counts.sum()).result() == 5
            assert one.learned.association.counts.sum() == before == 4
        assert one.learned.association.counts.sum() == 5


def test_threads_ask_while_another_changes(db: MotionDB, samples_folder: Path) -> None:
    """Threads ask; meanwhile words change, and a capture comes and goes."""
    ended = threading.Event()
    walk = samples_folder / "ana/walk_1.bvh"

    def search() -> None:
        assert {m.capture for m in db.search("kick", limit=9).matches} >= {"boris/kick_1"}

    def like() -> None:
        assert db.like("ana/jump_1", limit=1)[0].capture == "ana/jump_1"

    def describe() -> None:
        assert db.describe("boris/punch_1")[0].words

    def look() -> None:
        assert_whole(db.learned)
        assert db.captures.unlearned() == []

    asked = (search, like, describe, look)

    def ask(number: int) -> int:
        rounds = 0
        while rounds < 2 or not ended.is_set():
            asked[(number + rounds) % len(asked)]()
            rounds += 1
        return rounds

    def change() -> None:
        try:
            db.words.set("ana/bow_1", "bow, kick")
            db.add(walk, settings=AddSettings(jobs=1))
            db.captures.remove(["walk_1"])
        finally:
            ended.set()

    with ThreadPoolExecutor(len(asked) + 1) as pool:
        changing = pool.submit(change)
        rounds = list(pool.map(ask, range(len(asked))))
        changing.result()
    assert min(rounds) >= 2
    assert db.check() == []


@pytest.mark.parametrize("ask", [MotionDB.like, MotionDB.describe])
def test_every_thread_gets_the_same_answer(
    four_learned: Path, ask: Callable[[MotionDB, str], object]
) -> None:
    """All threads ask an open database for the first time at once."""
    with motiondb.open(four_learned, read_only=True) as db, ThreadPoolExecutor(N_THREADS) as pool:
        answers = list(pool.map(lambda _: ask(db, "ana/jump_1"), range(N_THREADS)))
        assert len({str(getattr(answer, "matches", answer)) for answer in answers}) == 1


def is_mapped(array: np.ndarray | None) -> bool:
    """Whether the memory of an array is that of a file."""
    while array is not None and not isinstance(array, np.memmap):
        array = array.base if isinstance(array.base, np.ndarray) else None
    return array is not None


def test_what_is_kept_of_all_captures_is_what_would_be_computed(learned_file: Path) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        learned = db.searchable
    plain = replace(learned, prepared=None)
    assert is_mapped(learned.heard.odds)
    assert learned.placed is not None
    assert plain.placed is not None
    assert learned.unplaced is not None
    assert plain.unplaced is not None
    np.testing.assert_array_equal(learned.likeness, plain.likeness)
    for capture in list(learned.rows)[::9]:
        np.testing.assert_array_equal(learned.evidence.odds[capture], plain.evidence.odds[capture])
        kept, made = learned.placed.take(capture), plain.placed.take(capture)
        assert kept is not None
        assert made is not None
        np.testing.assert_allclose(kept.windows, made.windows, atol=1e-9)
        np.testing.assert_allclose(learned.unplaced[capture], plain.unplaced[capture], atol=1e-9)
    for name, values in vars(plain.evidence.extremes).items():
        kept = getattr(learned.evidence.extremes, name)
        np.testing.assert_array_equal(values.astype(kept.dtype), kept)


def test_nothing_kept_is_used_for_other_words(learned_file: Path) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        learned = db.searchable
    other = replace(learned, captions={})
    assert other.evidence.written == {}
    assert not is_mapped(other.heard.odds)


def fitted_places(path: Path) -> dict[str, bytes]:
    """The files of the fitted maps of places in the cache of a database."""
    folder = path.with_name(f"{path.name}.cache")
    return {file.name: file.read_bytes() for file in folder.glob("places-*")}


def assert_as_computed(learned: Learned) -> None:
    """The fitted maps of places are those of the captures, words and model that are there."""
    computed = replace(learned, prepared=None).place_arrays
    assert learned.place_arrays.keys() == computed.keys()
    assert "unplaced_slopes" in computed
    for name, array in computed.items():
        np.testing.assert_array_equal(learned.place_arrays[name], array)


def assert_maps_as_computed(db: MotionDB) -> None:
    """The maps to captions and words are those of the captions and performers that are there."""
    mapped, computed = db.searchable.map_arrays, replace(db.searchable, prepared=None).map_arrays
    assert mapped.keys() == computed.keys()
    assert {"caption weights", "description centres"} < mapped.keys()
    for name, array in computed.items():
        assert is_mapped(mapped[name])
        np.testing.assert_array_equal(mapped[name], array)


def test_maps_with_generated_captures_do_not_replace_those_without(few: Path) -> None:
    with motiondb.open(few) as db:
        db.captures.save_generated("made/kick_1", "kick", db.generate("kick", anyway=True), 0)
        db.search("kick")
    folder = few.with_name(f"{few.name}.cache")
    before = {file: file.stat().st_mtime_ns for file in folder.glob("*maps-*")}
    assert len(before) == 2
    with motiondb.open(few) as db:
        db.search("kick")
    assert before == {file: file.stat().st_mtime_ns for file in folder.glob("*maps-*")}


@pytest.mark.parametrize(
    "change",
    [
        lambda db: db.words.set("ana/bow_1", "jump"),
        lambda db: db.captures.remove(["ana/bow_1"]),
        lambda db: db.captures.set_tags({"performer": "boris"}, ["ana/bow_1"]),
        lambda db: store.save_synonyms(db.store, {"kick": "punch"}),
        lambda db: db.learn(LearnSettings(n_symbols=2)),
    ],
    ids=["words", "captures", "performer", "synonyms", "model"],
)
def test_maps_to_words_are_those_of_what_is_there(
    few: Path, change: Callable[[MotionDB], object]
) -> None:
    with motiondb.open(few) as db:
        assert_maps_as_computed(db)
        change(db)
        assert_maps_as_computed(db)


def test_maps_of_places_stay_while_other_captures_come(few: Path, samples_folder: Path) -> None:
    with motiondb.open(few) as db:
        db.learn(LearnSettings(n_symbols=3))  # makes them
        before, revision = fitted_places(few), db.learned.places_digest
        db.add([samples_folder / "ana/wave_1.bvh"], settings=AddSettings(jobs=1))
        db.words.set("wave_1", "kick")
        assert len(db.learned.rows) == len(WORDS) + 1
        assert db.learned.places_digest == revision
        assert fitted_places(few) == before
        assert_as_computed(db.learned)


@pytest.mark.parametrize(
    "change",
    [
        lambda db: db.words.set("ana/bow_1", "jump"),
        lambda db: db.captures.remove(["ana/bow_1"]),
        lambda db: store.save_synonyms(db.store, {"kick": "punch"}),
        lambda db: db.learn(LearnSettings(n_symbols=2)),
    ],
    ids=["words", "captures", "synonyms", "model"],
)
def test_maps_of_places_are_those_of_what_is_there(
    few: Path, change: Callable[[MotionDB], object]
) -> None:
    with motiondb.open(few) as db:
        db.search("kick")
        before = fitted_places(few)
        change(db)
        assert_as_computed(db.learned)
        after = fitted_places(few)
        assert after.keys().isdisjoint(before)
    shutil.rmtree(few.with_name(f"{few.name}.cache"))
    with motiondb.open(few) as db:
        db.search("punch")
    assert fitted_places(few) == after


def _asked(path: Path) -> tuple[object, ...]:
    """Answers for which everything in the cache is needed, and the notes on files."""
    with motiondb.open(path, read_only=True) as db:
        found = db.search("jump").matches, db.like("ana/bow_1").matches, db.describe("ana/jump_1")
        return str(motiondb.to_json(found)), tuple(db.store.notes)


def test_the_cache_is_neither_read_nor_written_through_links(few: Path, tmp_path: Path) -> None:
    expected, _ = _asked(few)
    folder = few.with_name(f"{few.name}.cache")
    victims = {file: tmp_path / f"victim-{file.name}" for file in folder.iterdir()}
    for file, victim in victims.items():
        file.rename(victim)  # what stands there would do, if it were read
        file.symlink_to(victim)
    before = {victim: (victim.stat().st_ino, victim.read_bytes()) for victim in victims.values()}
    found, notes = _asked(few)
    assert found == expected
    removed = "expected a file that motiondb made, found a link. It was removed"
    assert all(f"{file}: {removed}" in "".join(notes) for file in victims)
    assert {v: (v.stat().st_ino, v.read_bytes()) for v in before} == before
    assert {file.name for file in folder.iterdir() if not file.is_symlink()} == {
        file.name for file in victims
    }
    assert _asked(few) == (expected, ())


def test_a_cache_that_is_a_link_is_not_followed(few: Path, tmp_path: Path) -> None:
    folder = few.with_name(f"{few.name}.cache")
    expected, _ = _asked(few)
    shutil.rmtree(folder)
    (tmp_path / "elsewhere").mkdir()
    folder.symlink_to(tmp_path / "elsewhere")
    found, (note,) = _asked(few)
    assert found == expected
    assert "found a link, which is not followed" in note
    assert not any((tmp_path / "elsewhere").iterdir())
