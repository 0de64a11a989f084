"""Which probabilities own captions have checked."""

from __future__ import annotations

import numpy as np
import pytest

from motiondb.learn import checking, joining
from motiondb.meaning.regression import Certainty

OWN = Certainty(np.array([1.0]), 0.0, 0.5)
FIRST = Certainty(np.array([3.0]), 2.0, 1.5)


def test_a_certainty_is_used_from_enough_own_captions_on() -> None:
    least = checking.LEAST_CHECKING
    assert checking.checked_certainty(OWN, FIRST, least - 1) is None
    joint = checking.checked_certainty(OWN, FIRST, least)
    twin = joining.join_certainty(OWN, FIRST, least)
    assert joint is not None
    assert twin is not None
    assert (joint.weights[0], joint.constant) == (twin.weights[0], twin.constant)


def test_what_own_captions_did_not_teach_is_never_given() -> None:
    assert checking.checked_certainty(None, FIRST, 1_000.0) is None
    assert checking.checked_certainty(OWN, None, 1_000.0) is OWN


@pytest.mark.parametrize(
    ("n_own", "certainty", "reason"),
    [
        (0.0, None, "no probabilities: no caption of this database has checked them"),
        (3.0, None, "they are checked by at least 50 captions of this database, and it has 3"),
        (60.0, None, "had not checked them when it learned; run motiondb learn"),
        (60.0, OWN, "no probabilities: no caption of this database holds 'dash' or 'hop'"),
    ],
)
def test_the_reason_is_told(n_own: float, certainty: Certainty | None, reason: str) -> None:
    assert reason in checking.say_unchecked(n_own, ["dash", "hop"], certainty)
