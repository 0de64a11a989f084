"""Counting: exact sums, whatever is added and removed in whatever order; equal to the last bit."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import motiondb
from motiondb import store
from motiondb.database.catalogue.cataloguing import AddSettings
from motiondb.database.loading import segments_of
from motiondb.language import vocabulary
from motiondb.language.translation import association
from motiondb.learn.drift import DriftBaseline
from motiondb.learn.joining import with_counts
from motiondb.learn.learned_model import LearnedModel, from_stored, to_stored
from motiondb.meaning import counting, word_map
from motiondb.meaning.counting import Counted
from motiondb.meaning.extents import ContextSpace
from motiondb.meaning.score_vectors import fit_score_space
from motiondb.records import (
    Association,
    Caption,
    MotionSymbols,
    SegmentTable,
    StoredLearning,
    SymbolSpace,
)
from motiondb.symbols.feature_space import FeatureSpace
from motiondb.symbols.settings import RecutSettings

SAMPLE = Path(__file__).parents[2] / "sample_data"
ONE = AddSettings(jobs=1)
TEXTS = ("walk, sit down", "run", "walk fast", "jump and run", "the person", "sit, walk, sit")
Captions = dict[int, tuple[Caption, ...]]


def recount(database: store.Store) -> StoredLearning:
    """What was learned with everything counted from nothing, as it is stored."""
    model = from_stored(store.load_learning(database))
    reference = model.counted.reference
    there = set(model.segments.capture_ids.tolist())
    captions = {c: rows for c, rows in store.load_captions(database).items() if c in there}
    table = segments_of(database, model, there)
    counts = counting.count(table, captions, store.load_synonyms(database), reference)
    return to_stored(with_counts(model, model.run_id, there, Counted(counts, reference)))


def made_up(seed: int, n_captures: int = 7, n_symbols: int = 4) -> tuple[SegmentTable, Captions]:
    """Captures of one to five segments, most of them with words for the whole or a part."""
    rng = np.random.default_rng(seed)
    sizes = rng.integers(1, 6, n_captures)
    ids = np.repeat(np.arange(10, 10 + n_captures), sizes)
    scores = rng.normal(size=(len(ids), n_symbols)).astype(np.float32)
    starts = np.concatenate([np.arange(n) * 20 for n in sizes])
    best = scores.argmax(axis=1)
    table = SegmentTable(ids, starts, starts + 20, best, scores.max(axis=1), best * 0.0, scores)
    captions: Captions = {}
    for number in range(10, 10 + n_captures):
        texts = rng.choice(TEXTS, size=rng.integers(0, 3))
        captions[number] = tuple(
            Caption(str(text), *((0.0, 0.5) if rng.random() < 0.5 else (None, None)))
            for text in texts
        )
    return table, captions


def reference_of(table: SegmentTable, captions: Captions) -> counting.Reference:
    described = counting.described_intervals(table, captions, {})
    words, _ = vocabulary.count_words([d.words for d in described])
    number = {word: n for n, word in enumerate(words)}
    pairs = [
        (table.symbols[d.low : d.high], np.array([number[w] for w in d.words])) for d in described
    ]
    fitted = association.fit_association(pairs, table.scores.shape[1], words)
    scores = fit_score_space(table.scores, table.ends - table.starts)
    return counting.make_reference(fitted, {}, scores)


def arrays_of(counts: counting.Counts, reference: counting.Reference) -> dict[str, Any]:
    """Everything that counts amount to, by name."""
    published = counting.publish_association(counts, reference)
    return {
        "transitions": counts.transitions,
        "said": published.counts,
        "translation": published.translation,
        **{f"alignment {shape}": table for shape, table in published.alignment.items()},
        **to_stored(model_of(counts, reference, published)).parameters,
    }


def model_of(
    counts: counting.Counts, reference: counting.Reference, published: Association
) -> LearnedModel:
    """A model with these counts; what is not counted is empty."""
    n = len(counts.transitions) - 1
    none = np.zeros((0, 0))
    table, _ = made_up(0)
    return LearnedModel(
        run_id=1,
        symbols=MotionSymbols(np.ones(n, dtype=np.int64), none, none, none),
        segments=table,
        space=SymbolSpace(none, none, none, none, np.zeros(0, dtype=np.int64), none, none, none),
        association=published,
        transition_counts=counts.transitions,
        feature_space=FeatureSpace(np.zeros(3), np.zeros((3, 2))),
        score_space=reference.scores,
        context_space=ContextSpace(np.zeros(3), np.zeros(6), np.zeros((6, 2))),
        cutting=RecutSettings(),
        drift_baseline=DriftBaseline(np.arange(2), -1.0, -2.0, 3.0),
        fitted_word_map=word_map.solve_word_map(counts.moments, 1.0, np.array([1.0, 1.0, 0.0])),
        lengths=dict(counts.shapes),
        counted=Counted(counts, reference),
        lemmas={"frobs": "frob"},
    )


def assert_same(actual: dict[str, Any], expected: dict[str, Any]) -> None:
    assert actual.keys() == expected.keys()
    for name, value in expected.items():
        np.testing.assert_array_equal(actual[name], value, name)


def only(table: SegmentTable, captures: list[int]) -> SegmentTable:
    return counting.take_rows(table, np.isin(table.capture_ids, captures))


@settings(deadline=None, max_examples=25)
@given(st.integers(0, 10**6), st.permutations(list(range(10, 17))), st.integers(0, 6))
def test_sums_are_exact_in_any_order(seed: int, order: list[int], n_removed: int) -> None:
    """One by one in any order, or all at once, or all less some: the same numbers, all bits."""
    table, captions = made_up(seed)
    reference = reference_of(table, captions)

    def count(captures: list[int]) -> counting.Counts:
        some = {c: captions[c] for c in captures}
        return counting.count(only(table, captures), some, {}, reference)

    kept, gone = order[n_removed:], order[:n_removed]
    total = count(order[:1])
    for capture in order[1:]:
        total = total + count([capture])
    assert_same(arrays_of(total, reference), arrays_of(count(order), reference))
    left = total
    for capture in gone:
        left = left - count([capture])
    assert_same(arrays_of(left, reference), arrays_of(count(kept), reference))


@settings(deadline=None, max_examples=10)
@given(st.integers(0, 10**6))
def test_what_is_packed_comes_back(seed: int) -> None:
    table, captions = made_up(seed)
    reference = reference_of(table, captions)
    counts = counting.count(table, captions, {}, reference)
    published = counting.publish_association(counts, reference)
    model = model_of(counts, reference, published)
    again = from_stored(to_stored(model)).counted
    assert_same(arrays_of(again.counts, again.reference), arrays_of(counts, reference))
    assert_same(to_stored(from_stored(to_stored(model))).parameters, to_stored(model).parameters)


def test_words_by_hand() -> None:
    """Two captions: one word twice in the first; a word outside the vocabulary is left out."""
    table, _ = made_up(0, 2)
    taught = {10: (Caption("walk, sit, walk"),), 11: (Caption("walk"),)}
    reference = reference_of(table, taught)
    said = {10: (Caption("walk, sit, walk"), Caption("moonwalk")), 11: (Caption("walk, hop"),)}
    counts = counting.count(table, said, {}, reference)
    assert reference.association.words == ("sit", "walk")
    assert counts.said.tolist() == [1, 2]
    first, second = (int((table.capture_ids == c).sum()) for c in (10, 11))
    assert counts.shapes == {(first, 3): 1, (second, 1): 1}
    assert counts.expected.translation.sum() == pytest.approx(4.0, abs=1e-8)  # shared out in full
    assert counts.moments.n == 2


def test_a_word_is_counted_with_a_symbol_it_never_stood_beside() -> None:
    table, _ = made_up(1, 2)
    reference = reference_of(table, {10: (Caption("walk"),), 11: (Caption("sit"),)})
    counts = counting.count(table, {10: (Caption("sit"),)}, {}, reference)
    assert counts.expected.translation.sum() == pytest.approx(1.0, abs=1e-8)
    t = counting.publish_association(counts, reference).translation
    assert set(t.sum(axis=1).round(12).tolist()) <= {0.0, 1.0}  # unseen symbols have no row


def test_the_word_map_of_moments_is_the_fitted_one() -> None:
    rng = np.random.default_rng(3)
    vectors = rng.normal(size=(40, 5))
    vectors /= np.linalg.norm(vectors, axis=1, keepdims=True)
    presence = rng.random((40, 3)) < 0.3
    fitted = word_map.fit_word_map(vectors, presence, np.arange(40) % 4)
    moments = word_map.word_moments(vectors, presence)
    solved = word_map.solve_word_map(moments, fitted.ridge, fitted.calibration)
    for name, value in vars(fitted).items():
        np.testing.assert_allclose(getattr(solved, name), value, atol=1e-3, err_msg=name)


def learned_arrays(learning: StoredLearning) -> dict[str, Any]:
    """All that was learned, by name, but the run."""
    known = learning.association
    arrays: dict[str, Any] = {"words": known.words, "counts": known.counts, "t": known.translation}
    arrays |= {f"a{shape}": table for shape, table in known.alignment.items()}
    for record in (learning.symbols, learning.segments, learning.space):
        arrays |= {f"{type(record).__name__}.{k}": v for k, v in vars(record).items()}
    return arrays | {"transitions": learning.transition_counts} | learning.parameters


@pytest.fixture
def spare(tmp_path: Path) -> Path:
    """Two captures that the sample database does not hold: other bytes, other names."""
    folder = tmp_path / "spare"
    folder.mkdir()
    for name, source in (("hop", "ana/jump_1"), ("stroll", "ana/walk_1")):
        text = (SAMPLE / f"captures/{source}.bvh").read_text()
        (folder / f"{name}.bvh").write_text(text + "\n")
    (folder / "words.tsv").write_text("file\twords\nhop.bvh\tjumps up\nstroll.bvh\twalks slowly\n")
    return folder


def test_added_and_removed_leaves_no_trace(few_copy: Path, spare: Path) -> None:
    with motiondb.open(few_copy) as db:
        before = store.load_learning(db.store)
        assert_same(learned_arrays(recount(db.store)), learned_arrays(before))
        report = db.add(spare, spare / "words.tsv", ONE)
        assert (report.added, report.counted) == (("hop", "stroll"), 2)
        between = store.load_learning(db.store)
        assert between.association.counts.sum() > before.association.counts.sum()
        assert "hop" in {match.capture for match in db.search("jump", limit=200).matches}
        assert db.like("hop", limit=3)[0].score >= 0.99
        assert db.check() == []
        db.captures.remove(["hop", "stroll"])
        after = store.load_learning(db.store)
        assert_same(learned_arrays(after), learned_arrays(before))
        assert db.check() == []
        assert [run.kind for run in store.load_runs(db.store)][-2:] == ["add", "remove"]


def test_removed_is_as_if_never_counted(learned_copy: Path) -> None:
    """All learned, some removed: equal to counting all others from nothing."""
    with motiondb.open(learned_copy) as db:
        names = [info.name for info in db.captures("performer=ana")]
        assert len(names) > 5
        db.captures.remove(names)
        left = store.load_learning(db.store)
        assert_same(learned_arrays(left), learned_arrays(recount(db.store)))
        assert len(db.search("walk").matches) > 0


def test_words_are_counted_when_they_change(few_copy: Path, tmp_path: Path) -> None:
    with motiondb.open(few_copy) as db:
        before = learned_arrays(store.load_learning(db.store))
        old = db.words.captions("ana/walk_1")
        change = db.words.set("ana/walk_1", "jump, zigzag")
        assert change.new_words == ("zigzag",)
        now = store.load_learning(db.store)
        words = now.association.words
        assert now.association.counts[words.index("jump")] == 1 + int(
            before["counts"][words.index("jump")]
        )
        assert_same(learned_arrays(now), learned_arrays(recount(db.store)))
        (tmp_path / "synonyms.txt").write_text("jump = walk\n")
        db.words.set_synonyms(tmp_path / "synonyms.txt")
        now = store.load_learning(db.store)
        assert now.association.counts[words.index("jump")] == 0
        assert_same(learned_arrays(now), learned_arrays(recount(db.store)))
        (tmp_path / "synonyms.txt").write_text("")
        db.words.set_synonyms(tmp_path / "synonyms.txt")
        db.words.set("ana/walk_1", old[0].words, old[0].start, old[0].end)
        for caption in old[1:]:
            db.words.set("ana/walk_1", caption.words, caption.start, caption.end, keep=True)
        assert_same(learned_arrays(store.load_learning(db.store)), before)


def test_a_failure_in_between_changes_nothing(
    few_copy: Path, spare: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with motiondb.open(few_copy) as db:
        before = learned_arrays(store.load_learning(db.store))

        def fail(*_: object) -> None:
            raise RuntimeError("stopped")

        monkeypatch.setattr(store, "save_learning", fail)
        with pytest.raises(RuntimeError, match="stopped"):
            db.add(spare, spare / "words.tsv", ONE)
        assert_same(learned_arrays(store.load_learning(db.store)), before)
        assert "hop" not in {info.name for info in db.captures()}


def test_before_learning_nothing_is_counted(tmp_path: Path, spare: Path) -> None:
    with motiondb.open(tmp_path / "new.duckdb") as db:
        report = db.add(spare, spare / "words.tsv", ONE)
        assert (len(report.added), report.counted) == (2, 0)
        assert db.words.set("hop", "hop").counted == ()
        assert db.captures.remove(["hop"]) == ["hop"]


@pytest.mark.parametrize("gaps", [False, True])
def test_described_segments_are_those_that_a_caption_overlaps(gaps: bool) -> None:
    rng = np.random.default_rng(0)
    for _ in range(200):
        lengths = rng.integers(1, 30, int(rng.integers(1, 8)))
        ends = np.cumsum(lengths)
        starts = ends - lengths + (rng.integers(0, lengths) if gaps else 0)
        n, scores = len(ends), np.zeros((len(ends), 2), dtype=np.float32)
        table = SegmentTable(
            np.ones(n, int), starts, ends, 0 * ends, 0.0 * ends, 0.0 * ends, scores
        )
        edges = rng.choice(np.concatenate([starts, ends]) / 30.0, 2)
        low, high = edges if rng.random() < 0.5 else rng.uniform(-0.5, ends[-1] / 30.0 + 1.0, 2)
        captions = {1: (Caption("walk", low, high), Caption("walk", None, high))}
        expected = []
        for start in (low, 0.0):
            inside = np.flatnonzero((starts < high * 30.0) & (ends > start * 30.0))
            if len(inside):
                expected.append((inside[0], inside[-1] + 1))
        described = counting.described_intervals(table, captions, {})
        assert [(d.low, d.high) for d in described] == expected
