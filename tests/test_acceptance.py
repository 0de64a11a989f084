"""What must hold of what was learned from the sample data, of answers and of generated motion."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from motiondb import MotionDB, store
from motiondb.database.generating import Generated
from motiondb.language import vocabulary
from motiondb.learn.learned import Learned
from motiondb.learn.recognition import decode
from motiondb.records import MOTION_FPS, CaptureInfo, SymbolSpace

WORDS = ("walk", "jump", "kick", "punch", "bow", "wave", "sit", "run", "dance", "dribble", "guard")


@pytest.fixture(scope="module")
def learned(db: MotionDB) -> Learned:
    return db.learned


@pytest.fixture(scope="module")
def space(db: MotionDB) -> SymbolSpace:
    return store.load_space(db.store)


def test_segments_tile_every_capture(learned: Learned) -> None:
    """A1: no gap, no overlap, first frame to last."""
    table = learned.segments
    assert set(learned.rows) == {i.capture_id for i in learned.captures.values()}
    for capture, rows in learned.rows.items():
        starts, ends = table.starts[rows], table.ends[rows]
        assert starts[0] == 0
        assert ends[-1] == learned.captures[capture].motion_frames
        np.testing.assert_array_equal(starts[1:], ends[:-1])
        assert (ends > starts).all()


def test_every_segment_has_its_likeliest_symbol(learned: Learned) -> None:
    """A2: arg max over symbols, the lowest number among equals, with its log-likelihood."""
    table = learned.segments
    best = table.scores.max(axis=1, keepdims=True)
    near = table.scores >= best - 1e-4 * np.abs(best)  # scores are kept as float32
    assert near[np.arange(len(table.symbols)), table.symbols].all()
    np.testing.assert_allclose(table.log_likelihoods, best[:, 0], rtol=1e-4, atol=1e-4)
    assert np.isfinite(table.backgrounds).all()
    assert np.mean(table.log_likelihoods > table.backgrounds) > 0.9


def test_learning_shortened_the_description_each_time(learned: Learned) -> None:
    """A3: an update is accepted only if the objective does not rise."""
    lengths = learned.description_lengths
    assert len(lengths) > 2
    assert (np.diff(lengths) < 0).all()


def test_segments_and_words_need_not_agree_in_number(learned: Learned) -> None:
    """A6: captions about whole captures, with fewer and with more words than segments."""
    shapes = sorted(Counter(dict(learned.lengths)).elements())
    n_segments, m = np.array(shapes).T
    assert (n_segments > m).any()
    assert (n_segments < m).any()


def test_decoding_carries_its_certificate(learned: Learned) -> None:
    """A10: cost, nodes, and whether it is the best there is."""
    for first, second in pairwise(WORDS):
        decoded = decode(learned, [first, second])
        assert decoded is not None
        assert decoded.certificate == "optimal"
        assert decoded.nodes_expanded >= 0
        assert -np.inf < decoded.log_probability <= decoded.bound + 1e-9


def _is_usable(learned: Learned, words: list[str], clustered: bool) -> bool:
    """Whether each word is spoken by one of the symbols that the words decode to."""
    decoded = decode(learned, words, clustered=clustered)
    if decoded is None:
        return False
    number = [learned.association.words.index(word) for word in words]
    t = learned.association.translation[1:][np.ix_(decoded.symbols, number)]
    return bool((t.max(axis=0) > 0.1).all())


def test_clusters_decode_more_word_pairs_to_usable_symbols(learned: Learned) -> None:
    """A17: pairs of words that are seldom or never seen one after the other."""
    pairs = [[a, b] for a in WORDS for b in WORDS if a != b]
    plain = sum(_is_usable(learned, pair, clustered=False) for pair in pairs)
    mixed = sum(_is_usable(learned, pair, clustered=True) for pair in pairs)
    assert mixed > plain


def test_one_table_of_symbols(db: MotionDB, learned: Learned, space: SymbolSpace) -> None:
    """X1: segments, words, transitions, space and clusters speak of the same symbols."""
    n = learned.symbols.n_symbols
    assert learned.segments.symbols.max() < n
    assert learned.segments.scores.shape[1] == n
    assert learned.association.translation.shape[0] == n + 1
    assert store.load_transition_counts(db.store).shape == (n + 1, n + 1)
    assert space.distances.shape == (n, n)
    assert len(space.coordinates) == n
    assert db.check() == []


SENTENCES = (
    "a person walks then kicks",
    "jump",
    "bow then wave",
    "kick then punch",
    "run then jump",
    "walk, turn left, sit down",
)


def _single(db: MotionDB) -> list[tuple[CaptureInfo, str]]:
    """Captures that show one action, with its name."""
    named = [(info, info.tags["action"]) for info in db.captures()]
    return [(info, action) for info, action in named if ";" not in action]


def _occurs(db: MotionDB, symbols: Sequence[int]) -> bool:
    """Whether a capture shows these symbols one right after the other."""
    learned, n = db.learned, len(symbols)
    sequences = [learned.segments.symbols[rows].tolist() for rows in learned.rows.values()]
    return any(s[i : i + n] == list(symbols) for s in sequences for i in range(len(s)))


def test_a_stored_capture_finds_itself_first(db: MotionDB) -> None:
    """A5: the answer is an interval; that of a whole capture is the whole of it."""
    for info in db.captures()[::6]:
        best = db.like(info.name, limit=1)[0]
        assert (best.rank, best.capture) == (1, info.name)
        assert best.score > 0.9
        assert 0.0 <= best.start < best.end <= info.duration + 0.001  # said in milliseconds


def test_a_part_of_a_stored_capture_finds_itself_first(db: MotionDB) -> None:
    """A5: and where it stands."""
    for name, start, end in (
        ("ana/long_1", 7.2, 10.0),
        ("fatou/kick_1", 0.6, 2.0),
        ("boris/long_2", 4.0, 7.6),
        ("goran/long_fight_2", 11.2, 14.0),
    ):
        best = db.like(name, start, end, limit=1)[0]
        assert best.capture == name
        assert (best.start, best.end) == pytest.approx((start, end), abs=0.2)


def test_words_find_what_shows_them(db: MotionDB) -> None:
    """A5, A11 with words: what people said the word about comes first."""
    for word in ("kick", "bow", "wave", "jump"):
        for match in db.search(word, limit=5).matches:
            said = {
                w for c in db.words.captions(match.capture) for w in vocabulary.words_of(c.words)
            }
            assert word in said, match


def test_words_in_order_are_found_in_order(db: MotionDB) -> None:
    """A11: intervals of the actions follow one another in the answer."""
    for match in db.search("walk, turn left, sit down", limit=5).matches:
        starts = [part.start for part in match.parts]
        assert len(starts) == 3
        assert starts == sorted(starts)
        assert match.start == pytest.approx(starts[0], abs=0.01)


def test_a_sequence_that_never_occurred_is_answered_and_says_so(db: MotionDB) -> None:
    """A11, (a): decoded, aligned with the store; the answer tells whether it was ever seen."""
    seen = []
    for words in ("kick, bow", "wave, jump", "sit down, punch", "walk, turn left, sit down", "bow"):
        answer = db.search(words, by_symbols=True, limit=3)
        assert answer.decoding is not None
        assert answer.decoding.certificate == "optimal"
        assert answer.matches
        occurs = _occurs(db, answer.decoding.symbols)
        says = ["this sequence of symbols does not occur" in m.reason for m in answer.matches]
        assert says == [not occurs] * len(answer.matches)
        seen.append(occurs)
    assert not all(seen)


@pytest.fixture(scope="module")
def made(db: MotionDB) -> dict[str, Generated]:
    return {words: db.generate(words, seed=7) for words in SENTENCES}


def test_a_sequence_that_never_occurred_is_generated(
    db: MotionDB, made: dict[str, Generated]
) -> None:
    """A11, (b)."""
    new = [one for one in made.values() if not _occurs(db, one.symbols)]
    assert new
    for one in new:
        assert one.motion.n_frames > 30
        assert np.isfinite(one.motion.local_rotations).all()
        assert np.isfinite(one.motion.root_positions).all()


def _differences(one: Sequence[int], other: Sequence[int]) -> int:
    """Edit distance."""
    row = list(range(len(other) + 1))
    for i, a in enumerate(one, start=1):
        before, row[0] = row[0], i
        for j, b in enumerate(other, start=1):
            before, row[j] = row[j], min(row[j] + 1, row[j - 1] + 1, before + (a != b))
    return row[-1]


@pytest.mark.parametrize(("method", "share"), [("trajectory", 0.1), ("stitched", 0.2)])
def test_generated_motion_is_recognised_again(
    db: MotionDB, made: dict[str, Generated], method: str, share: float
) -> None:
    """A12: cut and recognised like any motion, it is the sequence that made it, but for a share.

    Trajectories are the symbols' own; stitched segments have seams and another length, and each
    seed takes other places of the captures.
    """
    wrong = total = 0
    for words in SENTENCES:
        if method == "stitched":
            some = [made[words], *(db.generate(words, seed=seed) for seed in range(3))]
        else:
            some = [db.generate(words, seed=7, method=method)]
        wrong += sum(_differences(one.symbols, one.recognised) for one in some)
        total += sum(len(one.symbols) for one in some)
    assert wrong <= share * total


def test_a_trajectory_is_smooth_and_of_the_model_alone(db: MotionDB) -> None:
    """A12: the third differences of rotations stay near those of a stitched motion."""
    jerks = {}
    for method in ("trajectory", "stitched"):
        one = db.generate("a person walks then kicks", seed=7, method=method)
        turns = np.diff(one.motion.local_rotations.astype(float), n=3, axis=0)
        jerks[method] = float(np.median(np.abs(turns)))
        assert (one.provenance.source_numbers == -1).all() == (method == "trajectory")
    assert jerks["trajectory"] < 2 * jerks["stitched"]


def test_a_motion_is_told_in_its_words(db: MotionDB) -> None:
    """A18: the action is among the two likeliest words of a part, for four captures in five."""
    told = []
    for info, action in _single(db)[::3]:
        said = {word for part in db.describe(info.name) for word, _ in part.words[:2]}
        told.append(bool(said & set(action.split("_"))))
    assert np.mean(told) >= 0.8


def test_model_2_tells_symbols_in_words(db: MotionDB) -> None:
    """A18: motion to words by the association alone, the same table that decoding inverts."""
    learned = db.learned
    fitted = learned.association
    for word in ("kick", "bow", "wave", "walk"):
        best = int(np.argmax(fitted.translation[1:, fitted.words.index(word)]))
        shown = fitted.translation[best + 1]
        assert word in [fitted.words[n] for n in np.argsort(-shown)[:3]]


def test_every_generated_frame_knows_its_source_and_licence(
    db: MotionDB, made: dict[str, Generated], tmp_path: Path
) -> None:
    """X2: in memory, and in the file beside the motion, whose runs tile the frames."""
    durations = {info.name: info.duration for info in db.captures()}
    for words, one in made.items():
        actual = one.provenance
        assert len(actual.source_numbers) == one.motion.n_frames == len(actual.edits)
        assert (actual.source_numbers >= 0).all()
        assert set(actual.licences) == {"CC0-1.0"}
        one.write(tmp_path / "made.bvh")
        told = json.loads((tmp_path / "made.bvh.provenance.json").read_text())
        assert (told["words"], told["seed"], told["method"]) == (words, 7, "stitched")
        end = 0
        for run in told["frames"]:
            assert run["start"] == end
            end = run["end"]
            last = run["source_start"] + run["end"] - run["start"] - 1
            assert 0 <= run["source_start"] <= last <= durations[run["capture"]] * MOTION_FPS
        assert end == one.motion.n_frames
