"""How sure answers of every kind are, as one record."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from motiondb.learning.certainty.asked_certainty import (
    Written,
    example_certainty,
    words_certainty,
)
from motiondb.learning.certainty.question_certainty import KindCertainty, without_and_either
from motiondb.search.certainty import Certainty
from motiondb.symbols.models.hmm_jobs import one_blas_thread


@dataclass(frozen=True)
class Certainties:
    """How sure answers are; None where too little was written to tell.

    Attributes
    ----------
    words : Certainty or None
        Of an answer to words.
    example : Certainty or None
        Of an answer to an example.
    place : Certainty or None
        Of the interval told for an action, where the capture shows the action
        (:mod:`motiondb.learning.certainty.place_certainty`).
    without : KindCertainty
        Of an answer to one action but not another.
    either : KindCertainty
        Of an answer to one of several actions.
    """

    words: Certainty | None = None
    example: Certainty | None = None
    place: Certainty | None = None
    without: KindCertainty = field(default_factory=KindCertainty)
    either: KindCertainty = field(default_factory=KindCertainty)


def fit_certainties(written: Written) -> Certainties:
    """How sure answers are, where captions of two performers or more tell."""
    if len(np.unique(written.groups)) < 2:
        return Certainties()
    with one_blas_thread():  # many small systems
        without, either = without_and_either(written)
        return Certainties(
            words_certainty(written), example_certainty(written), without=without, either=either
        )
