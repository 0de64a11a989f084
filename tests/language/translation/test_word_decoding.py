"""Decoding against brute force, against uniform-cost search, and its certificate."""

import heapq
import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.language.translation.decoding import decode_words, log_length_prior
from motiondb.language.translation.decoding_kernels import (
    pose_problem,
    relax,
    said_level,
    sequence_value,
    symbol_pays,
    track,
)
from motiondb.language.translation.explanation import alignment_table, log_probability
from motiondb.language.translation.transition import (
    count_transitions,
    log_bigram,
    log_clustered_bigram,
)
from motiondb.records import Association


def random_model(rng, n_symbols, n_words, longest, peaked):
    """t, a, transitions and lengths drawn at random; some transitions impossible."""
    t = rng.dirichlet(np.full(n_words, 0.1 if peaked else 1.0), n_symbols + 1) + 1e-6
    alignment = {
        (length, width): rng.dirichlet(np.ones(length + 1), width)
        for length in range(1, longest + 1)
        for width in range(1, 5)
    }
    vocabulary = tuple(f"w{k}" for k in range(n_words))
    association = Association(
        vocabulary, np.ones(n_words, int), t / t.sum(1, keepdims=True), alignment, np.zeros(0)
    )
    counts = rng.integers(0, 4, (n_symbols + 1, n_symbols + 1)).astype(float)
    counts[0, 0] = 0.0
    lengths = np.append(-np.inf, np.log(rng.dirichlet(np.ones(longest))))
    return association, log_bigram(counts), lengths


def sequence_log_probability(log_transitions, symbols):
    """log P(symbols), from begin to end, nats."""
    nodes = [0, *(s + 1 for s in symbols), 0]
    return sum(log_transitions[a, b] for a, b in itertools.pairwise(nodes))


def value_of(symbols, words, association, log_transitions, log_lengths):
    """The definition, term by term."""
    return (
        log_lengths[len(symbols)]
        + sequence_log_probability(log_transitions, symbols)
        + log_probability(association, np.array(symbols), words)
    )


def brute_force(words, association, log_transitions, log_lengths):
    """Every sequence of every length."""
    n_symbols = len(association.translation) - 1
    return max(
        value_of(symbols, words, association, log_transitions, log_lengths)
        for length in range(1, len(log_lengths))
        for symbols in itertools.product(range(n_symbols), repeat=length)
        if sequence_log_probability(log_transitions, symbols) > -np.inf
    )


def uniform_cost(words, association, log_transitions, log_lengths):
    """Cheapest transitions first; the words are paid with the last step. (value, expanded)."""
    n_symbols = len(association.translation) - 1
    frontier = [
        (-log_lengths[length], length, ())
        for length in range(1, len(log_lengths))
        if log_lengths[length] > -np.inf
    ]
    heapq.heapify(frontier)
    expanded = 0
    while frontier:
        cost, length, symbols = heapq.heappop(frontier)
        if len(symbols) > length:
            return -cost, expanded
        expanded += 1
        if len(symbols) == length:
            whole = value_of(symbols, words, association, log_transitions, log_lengths)
            if whole > -np.inf:
                heapq.heappush(frontier, (-whole, length, (*symbols, -1)))
            continue
        row = symbols[-1] + 1 if symbols else 0
        for symbol in range(n_symbols):
            step = log_transitions[row, symbol + 1]
            if step > -np.inf:
                heapq.heappush(frontier, (cost - step, length, (*symbols, symbol)))
    return -np.inf, expanded


@pytest.mark.parametrize("seed", range(8))
def test_equals_brute_force_and_expands_less_than_uniform_cost(seed):
    rng = np.random.default_rng(seed)
    model = random_model(rng, 6, 8, 4 + (seed < 3), peaked=seed % 2 == 0)
    words = rng.integers(0, 8, rng.integers(1, 5))
    decoding = decode_words(words, *model)
    blind, expanded = uniform_cost(words, *model)
    assert decoding.certificate == "optimal"
    assert decoding.log_probability == pytest.approx(blind, abs=1e-9)
    assert decoding.nodes_expanded < expanded
    if seed < 4:
        assert decoding.log_probability == pytest.approx(brute_force(words, *model), abs=1e-9)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 4), st.integers(1, 3), st.booleans())
def test_answer_is_worth_what_it_says(seed, n_words, n_symbols, peaked):
    rng = np.random.default_rng(seed)
    model = random_model(rng, n_symbols, 5, 4, peaked)
    words = rng.integers(0, 5, n_words)
    decoding = decode_words(words, *model)
    if decoding is None:
        assert uniform_cost(words, *model)[0] == -np.inf
        return
    assert decoding.log_probability == pytest.approx(value_of(decoding.symbols, words, *model))
    assert decoding.certificate == "optimal"
    assert decoding.bound == decoding.log_probability
    assert decoding.log_probability == pytest.approx(uniform_cost(words, *model)[0], abs=1e-9)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 8), st.booleans())
def test_bounds_never_lie_below_the_truth(seed, n_words, peaked):
    """At every prefix of random sequences, whatever q the bounds are linearised at."""
    rng = np.random.default_rng(seed)
    association, transitions, lengths = random_model(rng, 5, 8, 4, peaked)
    words = rng.integers(0, 8, n_words)
    alignments = np.zeros((5, n_words, 5))
    for length in range(1, 5):
        alignments[length, :, : length + 1] = alignment_table(association, length, n_words)
    problem = pose_problem(association.translation[:, words], alignments, transitions, lengths)
    for length in range(1, 5):
        q = 10.0 ** rng.uniform(-6, 0, n_words)
        upper, _ = relax(problem, length, q.copy(), np.zeros(5, dtype=np.int64), -np.inf)
        level = said_level(problem, length, q)
        pays = np.empty((length + 1, 5))
        symbol_pays(problem, length, level, pays)
        ahead = np.empty((length + 1, len(problem.end), 1 << len(problem.tracked)), np.float32)
        track(problem, length, level, pays, ahead)
        for path in rng.integers(0, 5, (10, length)):
            value = sequence_value(problem, path)
            if value == -np.inf:
                continue
            assert value == pytest.approx(value_of(path, words, association, transitions, lengths))
            assert value <= upper + 1e-9
            row, spent, mask = problem.row_of[0], lengths[length], ahead.shape[2] - 1
            for k, symbol in enumerate(path, start=1):
                spent += transitions[0 if k == 1 else path[k - 2] + 1, symbol + 1] + pays[k, symbol]
                mask &= ~problem.says[symbol]
                row = problem.row_of[symbol + 1]
                assert value <= spent + ahead[k, row, mask]


@pytest.mark.parametrize("n_words", [9])
def test_more_words_than_are_tracked(n_words):
    rng = np.random.default_rng(5)
    association, transitions, lengths = random_model(rng, 5, 12, 4, peaked=True)
    words = rng.permutation(12)[:n_words]
    model = (association, transitions, lengths)
    decoding = decode_words(words, *model)
    assert decoding.log_probability == pytest.approx(uniform_cost(words, *model)[0], abs=1e-9)


def test_clusters_share_their_rows():
    rng = np.random.default_rng(6)
    association, _, lengths = random_model(rng, 6, 8, 4, peaked=True)
    counts = count_transitions([rng.integers(0, 6, 9) for _ in range(3)], 6)
    model = (association, log_clustered_bigram(counts, np.array([0, 0, 0, 1, 1, 2])), lengths)
    words = np.array([1, 5, 2])
    decoding = decode_words(words, *model)
    assert decoding.log_probability == pytest.approx(uniform_cost(words, *model)[0], abs=1e-9)


def test_words_bring_their_symbols_in_order():
    translation = np.array([[0.5, 0.5], [0.98, 0.02], [0.02, 0.98]])
    association = Association(("sit", "walk"), np.ones(2, int), translation, {}, np.zeros(0))
    counts = count_transitions([np.array([1, 0]), np.array([0, 1])], 2)
    lengths = log_length_prior({(2, 2): 10}, 2, 4)
    assert decode_words([1, 0], association, log_bigram(counts), lengths).symbols == (1, 0)
    assert decode_words([0, 1], association, log_bigram(counts), lengths).symbols == (0, 1)


def test_limit_of_nodes_is_admitted():
    rng = np.random.default_rng(0)
    model = random_model(rng, 30, 8, 6, peaked=False)
    words = rng.integers(0, 8, 4)
    limited = decode_words(words, *model, node_limit=0)
    full = decode_words(words, *model, node_limit=100_000)
    assert limited.certificate == "beam-limited"
    assert limited.nodes_expanded == 0
    assert full.certificate == "optimal"
    assert limited.log_probability <= full.log_probability <= limited.bound
    assert full.nodes_expanded > 0


def test_impossible_words_have_no_answer():
    translation = np.array([[1.0, 0.0], [1.0, 0.0]])
    association = Association(("sit", "walk"), np.ones(2, int), translation, {}, np.zeros(0))
    counts = count_transitions([np.array([0])], 1)
    lengths = log_length_prior({}, 1, 2)
    assert decode_words([1], association, log_bigram(counts), lengths) is None
    assert decode_words([0], association, log_bigram(counts), lengths).symbols == (0,)


def test_errors_say_what_is_wrong():
    association = Association(("a",), np.ones(1, int), np.ones((3, 1)), {}, np.zeros(0))
    lengths = log_length_prior({}, 1, 2)
    with pytest.raises(ValueError, match=r"^words: expected at least one word, found none\.$"):
        decode_words([], association, np.zeros((3, 3)), lengths)
    with pytest.raises(
        ValueError,
        match=r"^log_transitions: expected shape \(3, 3\) for 2 symbols, found \(2, 2\)\.$",
    ):
        decode_words([0], association, np.zeros((2, 2)), lengths)
    with pytest.raises(ValueError, match=r"^longest: expected a length of at least 1, found 0\.$"):
        log_length_prior({}, 1, 0)


def test_length_prior_learns_and_keeps_to_its_limit():
    shapes = {(3, 2): 2, (9, 2): 1}
    prior = np.exp(log_length_prior(shapes, 2))
    assert prior.shape == (5,)
    assert log_length_prior(shapes, 6).shape == (13,)
    assert prior[0] == 0.0
    assert prior.sum() == pytest.approx(1.0)
    assert prior[3] == pytest.approx((2 + 1 / 4) / 3)
    assert prior[1] == pytest.approx((1 / 4) / 3)
    other = np.exp(log_length_prior(shapes, 3, 6))
    assert other[3] == pytest.approx((2 * np.exp(-1) + 1 / 6) / (2 * np.exp(-1) + 1))
