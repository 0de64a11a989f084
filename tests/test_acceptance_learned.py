"""What must hold of everything that was learned from the sample data (requirements A1 to A16)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import motiondb
from motiondb import MotionDB, store
from motiondb.learn.learned import Learned
from motiondb.learn.recognition import decode
from motiondb.records import SymbolSpace

WORDS = ("walk", "jump", "kick", "punch", "bow", "wave", "sit", "run", "dance", "dribble", "guard")


@pytest.fixture(scope="module")
def db(learned_file: Path) -> Iterator[MotionDB]:
    with motiondb.open(learned_file, read_only=True) as opened:
        yield opened


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
