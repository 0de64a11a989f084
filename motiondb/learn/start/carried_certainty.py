"""Certainty of answers that depend on the captions of a start.

The calibration of a start holds for the captures from which it was learned. In other captures,
words have other frequencies and the evidence of motion is shifted, so its log-odds x have an error
that is unknown before there are own captions. If this error e is normal with mean 0 and standard
deviation SPREAD, the probability of a right answer is

    P(right) = E sigmoid(x + e) ~ sigmoid(x / sqrt(1 + pi SPREAD^2 / 8)),

so probabilities move towards 0.5 and the order of answers does not change. The threshold of
"nothing matches" does not change either. No such probability is given before own captions have
checked it (:mod:`motiondb.learn.start.checking`); then it is the prior of the certainty that is
learned from them (:func:`motiondb.learn.start.joining.join_certainty`).

Source: MacKay, The evidence framework applied to classification networks (1992), for the integral.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from motiondb.learn.start.checking import checked_certainty
from motiondb.meaning.calibration import Certainty
from motiondb.meaning.certainty.certainties import Certainties
from motiondb.meaning.certainty.question_certainty import KindCertainty

SPREAD = 2.5
"""In nats. Chosen among 0, 0.5, 1, 1.5, 2, 2.5, 3, 4 and 6 on CMU performers never seen: there the
calibration error of the first five answers is smallest at 2.5, and the log-likelihood largest at 2
and nearly as large at 2.5. The errors on captures of another studio were in the same table; they
would have favoured a larger value."""


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
