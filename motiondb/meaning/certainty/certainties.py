"""Certainties of answers of every kind, as one record."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from motiondb.meaning.calibration import Certainty, unpack
from motiondb.meaning.certainty.asked_certainty import (
    Written,
    example_certainty,
    words_certainty,
)
from motiondb.meaning.certainty.question_certainty import KindCertainty, without_and_either
from motiondb.records import FloatArray
from motiondb.symbols.hmm_jobs import one_blas_thread

PLACE_NAME = "certainty_interval"
"""Array of the certainty of places. Earlier versions stored a certainty of other cues as
"certainty_place", which is not used."""


@dataclass(frozen=True)
class Certainties:
    """Certainty of answers; None if there are too few captions."""

    words: Certainty | None = None  # Of an answer to words
    example: Certainty | None = None  # Of an answer to an example
    # Certainty of the interval of an action, given that the capture shows the action, and several
    # actions (:mod:`motiondb.meaning.certainty.place_certainty`)
    place: Certainty | None = None
    # That a capture shows an action throughout, where ``place`` was learned; None in databases of
    # versions in which ``place`` covered this case
    single: Certainty | None = None
    # Of an answer to one action but not another
    without: KindCertainty = field(default_factory=KindCertainty)
    # Of an answer to one of several actions
    either: KindCertainty = field(default_factory=KindCertainty)


def fit_certainties(written: Written) -> Certainties:
    """Certainties of answers, if there are captions of two or more performers."""
    if len(np.unique(written.groups)) < 2:
        return Certainties()
    with one_blas_thread():  # many small systems
        without, either = without_and_either(written)
        return Certainties(
            words_certainty(written), example_certainty(written), without=without, either=either
        )


def certainty_arrays(sure: Certainties) -> dict[str, FloatArray]:
    """Certainties of answers as arrays by name; :func:`certainties_from` is the inverse."""
    each = {
        "certainty_words": sure.words,
        "certainty_example": sure.example,
        PLACE_NAME: sure.place,
        "certainty_single": sure.single,
        "certainty_without": sure.without.whole,
        "certainty_without_part": sure.without.part,
        "certainty_either": sure.either.whole,
        "certainty_either_part": sure.either.part,
    }
    return {name: one.pack() for name, one in each.items() if one is not None}


def certainties_from(arrays: Mapping[str, FloatArray]) -> Certainties:
    """Certainties of answers from arrays by name; a certainty without arrays is None."""

    def one(name: str) -> Certainty | None:
        return unpack(arrays[name]) if name in arrays else None

    return Certainties(
        one("certainty_words"),
        one("certainty_example"),
        one(PLACE_NAME),
        one("certainty_single"),
        *(
            KindCertainty(one(name), one(f"{name}_part"))
            for name in ("certainty_without", "certainty_either")
        ),
    )
