"""What the captures that move like a segment say: by hand, and beside a slow twin."""

import numpy as np

from motiondb.generate.competing_words import (
    MOST_RIVALRY,
    NEIGHBOURS,
    SMALL,
    DescribedSegments,
    neighbour_gain,
    related_words,
    rival_gain,
)

SIT, CLIMB, STOOL = range(3)


def _others() -> DescribedSegments:
    """Capture 1 sits on a stool, capture 2 climbs and sits, capture 3 climbs."""
    vectors = np.array([[1.0, 0.0], [0.8, 0.6], [0.6, 0.8], [0.0, 1.0]])
    says = np.array([[1.0, 0.0, 1.0], [0.5**0.5, 0.5**0.5, 0.0], [0.0, 1.0, 0.0]])
    return DescribedSegments(vectors, np.array([0, 1, 3]), np.array([1, 2, 3]), says)


def test_what_the_nearest_captures_say_is_weighed_by_hand() -> None:
    gain = neighbour_gain(_others(), 9, np.array([[2.0, 0.0]]), [SIT])
    cosines = np.array([1.0, 0.8, 0.0])  # the nearest segment of each capture
    sit = (1.0 + 0.8 * 0.5**0.5) / cosines.sum()
    # climbing stands in one of the two captures of sitting, the stool in one too: none is a rival
    np.testing.assert_allclose(gain, [np.log(sit + SMALL) - np.log(SMALL)])


def test_a_capture_says_nothing_of_itself() -> None:
    gain = neighbour_gain(_others(), 1, np.array([[1.0, 0.0]]), [STOOL])
    assert gain[0] < -3.0


def test_without_other_captures_nothing_is_gained() -> None:
    nobody = DescribedSegments(
        np.zeros((0, 2)), np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64), np.zeros((0, 3))
    )
    assert neighbour_gain(nobody, 1, np.ones((4, 2)), [SIT]).tolist() == [0.0] * 4


def test_the_gain_beside_a_slow_twin() -> None:
    rng = np.random.default_rng(4)
    lengths = rng.integers(1, 5, size=30)
    vectors = rng.normal(size=(int(lengths.sum()), 6))
    vectors /= np.linalg.norm(vectors, axis=1, keepdims=True)
    firsts = np.cumsum([0, *lengths])[:-1]
    says = (rng.random((30, 8)) < 0.2).astype(float)
    others = DescribedSegments(vectors, firsts, np.arange(30), says)
    asked, queries = [2, 5], rng.normal(size=(7, 6))
    gain = neighbour_gain(others, 3, queries, asked)
    rivals = [w for w in range(8) if w not in related_words(says, asked)]
    for query, value in zip(queries, gain):
        alike = []
        for n in range(30):
            if n != 3:
                vectors_of_capture = vectors[firsts[n] : firsts[n] + lengths[n]]
                cosine = max(float(v @ query / np.linalg.norm(query)) for v in vectors_of_capture)
                alike.append((max(cosine, 0.0), n))
        alike.sort(key=lambda pair: -pair[0])
        total = sum(cosine for cosine, _ in alike[:NEIGHBOURS])
        said = [
            sum(cosine * says[n, w] for cosine, n in alike[:NEIGHBOURS]) / total for w in range(8)
        ]
        wanted = np.mean([np.log(said[w] + SMALL) for w in asked])
        best = max((said[w] for w in rivals), default=0.0)
        np.testing.assert_allclose(value, wanted - np.log(best + SMALL), atol=1e-9)


def test_words_of_the_same_action_do_not_compete() -> None:
    evidence = np.array([[3.0, 1.0, 5.0]])
    assert rival_gain(evidence, [SIT], [CLIMB, STOOL]).tolist() == [-2.0]
    assert rival_gain(evidence, [SIT], [CLIMB]).tolist() == [2.0]
    assert rival_gain(evidence, [SIT], []).tolist() == [3.0]


def test_rivalry_is_limited_both_ways() -> None:
    evidence = np.array([[90.0, 0.0, 0.0], [0.0, 90.0, 0.0]])
    assert rival_gain(evidence, [SIT], [CLIMB]).tolist() == [MOST_RIVALRY, -MOST_RIVALRY]
