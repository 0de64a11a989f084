"""Which probabilities the captions of a database have checked, and how certain the others are.

A certainty that was learned from a handful of captions is a guess: with 25 captions the
probabilities of the first five answers were off by .16 and .32, with 50 by .07 and .19
(docs/measured/start.md). That of a start was learned from the captures of the start, and is wrong
by about .3 on those of another studio. So a probability is given where both hold:

* the certainty of answers of its kind was learned from own captions when the database learned, and
  there were at least LEAST_CHECKING of them (:func:`checked_certainty`);
* own captions hold the word that it stands beside (:func:`checked_words`). Without a start, all
  words come from own captions.

The ranking of answers needs no probability.

**The certainty of a start as the prior of the own one** (:func:`motiondb.learn.joining.
join_certainty`). In other captures its log-odds x have an unknown error e. If e is normal with mean
0 and standard deviation SPREAD, the probability of a right answer is

    P(right) = E sigmoid(x + e) ~ sigmoid(x / sqrt(1 + pi SPREAD^2 / 8)),

so probabilities move towards 0.5; the order of answers and the threshold of "nothing matches" do
not change.

Source: MacKay, The evidence framework applied to classification networks (1992), for the integral.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motiondb.learn.joining import join_certainty
from motiondb.learn.knowledge import Started
from motiondb.meaning.counting import Counted
from motiondb.meaning.regression import Certainties, Certainty, KindCertainty
from motiondb.records import Association

LEAST_CHECKING = 50
"""Own described intervals from which their certainty is used. Among 10, 25, 50 and 100, the
smallest number at which the probabilities across studios are no further off with a start than
without one, in both directions; without a start, they are off by half as much as with 25 in one of
two studios, and by two thirds in the other (docs/measured/start.md)."""
SPREAD = 2.5
"""In nats. Chosen among 0, 0.5, 1, 1.5, 2, 2.5, 3, 4 and 6 on CMU performers never seen: there the
calibration error of the first five answers is smallest at 2.5, and the log-likelihood largest at 2
and nearly as large at 2.5. The errors on captures of another studio were in the same table; they
would have favoured a larger value."""

NO_EXAMPLES_CHECKED = (
    "no probabilities: for examples they are learned from captions that name the same actions for "
    "several performers, and these did not suffice when the database learned; caption more "
    "captures, and run motiondb learn"
)  # The reason where answers to words may have probabilities, but answers to examples have none


def checked_certainty(
    own_certainty: Certainty | None, first: Certainty | None, n_own: float
) -> Certainty | None:
    """The certainty of answers of one kind, from own captions and the start; None if unchecked."""
    if own_certainty is None or n_own < LEAST_CHECKING:
        return None
    return join_certainty(own_certainty, first, n_own)


def given_certainties(learned: Certainties, counted: Counted) -> Certainties:
    """The certainties by which answers are told: none while there are too few own captions."""
    too_few = counted.counts.moments.n < LEAST_CHECKING
    return Certainties() if too_few else learned


def checked_words(
    association: Association,
    started: Started | None,
    counted: Counted,
    certainty: Certainty | None,
) -> NDArray[np.bool_]:
    """Which words have probabilities that own captions have checked.

    Without a start these are all words, or none if there are too few captions.

    Shapes: result (words,).
    """
    if started is None:
        return np.full(len(association.words), certainty is not None)
    if certainty is None:
        return np.zeros(len(association.words), dtype=bool)
    said = dict(zip(counted.reference.association.words, counted.counts.said.tolist()))
    return np.array([said.get(word, 0) > 0 for word in association.words], dtype=bool)


def say_unchecked(n_own: float, words: Sequence[str], certainty: Certainty | None) -> str:
    """The reason why probabilities are not given.

    >>> say_unchecked(0, ["walk"], None)
    'no probabilities: no caption of this database has checked them'
    >>> say_unchecked(9, ["walk"], None)
    'no probabilities: they are checked by at least 50 captions of this database, and it has 9'
    """
    if certainty is not None:
        listed = " or ".join(map(repr, words))
        return f"no probabilities: no caption of this database holds {listed}"
    if n_own < 1:
        return "no probabilities: no caption of this database has checked them"
    if n_own < LEAST_CHECKING:
        return (
            f"no probabilities: they are checked by at least {LEAST_CHECKING} captions of this "
            f"database, and it has {int(n_own)}"
        )
    return (
        "no probabilities: the captions of this database had not checked them when it learned; "
        "run motiondb learn, or caption captures of more performers"
    )


def carry(first: Certainties) -> Certainties:
    """The certainty of a start for captures other than its own.

    Only the certainty of answers to words is widened; the others are unchanged.
    """
    return replace(
        first,
        words=_widen(first.words),
        without=KindCertainty(_widen(first.without.whole), _widen(first.without.part)),
        either=KindCertainty(_widen(first.either.whole), _widen(first.either.part)),
    )


def join_certainties(own_certainties: Certainties, first: Certainties, n_own: float) -> Certainties:
    """The certainty learned from own captions and that of a start, by the weight of the start.

    What own captions have not checked is None. So is the certainty of places, which is learned
    later, from own captions alone.
    """

    def kinds(one: KindCertainty, other: KindCertainty) -> KindCertainty:
        return KindCertainty(
            checked_certainty(one.whole, other.whole, n_own),
            checked_certainty(one.part, other.part, n_own),
        )

    return Certainties(
        checked_certainty(own_certainties.words, first.words, n_own),
        checked_certainty(own_certainties.example, first.example, n_own),
        without=kinds(own_certainties.without, first.without),
        either=kinds(own_certainties.either, first.either),
    )


def _widen(sure: Certainty | None) -> Certainty | None:
    if sure is None:
        return None
    width = np.sqrt(1.0 + np.pi * SPREAD**2 / 8.0)
    return Certainty(sure.weights / width, float(sure.constant / width), sure.threshold)
