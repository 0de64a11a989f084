"""Which probabilities own captions have checked."""

from __future__ import annotations

import numpy as np
import pytest

from motiondb.learn import checking, joining
from motiondb.learn.learned import family_of, group_performers
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


def test_captures_of_one_folder_are_one_performer() -> None:
    names = {1: "gym/walk_1", 2: "gym/run_1", 3: "park/walk_1"}
    groups = group_performers(names, {})
    assert groups[1] == groups[2] != groups[3]


def test_in_a_single_folder_the_name_up_to_the_last_number_counts() -> None:
    names = {1: "cmu/14_06", 2: "cmu/14_20", 3: "cmu/16_06", 4: "cmu/walk"}
    groups = group_performers(names, {})
    assert groups[1] == groups[2]
    assert len(set(groups.values())) == 3


def test_what_people_said_counts_and_is_no_folder() -> None:
    names = {1: "ana/walk_1", 2: "b/walk_1", 3: "c/walk_1"}
    groups = group_performers(names, {1: "ana", 3: "ana"})
    assert groups[1] == groups[3] == "ana"
    assert groups[2] not in ("ana", "")


def test_a_name_that_is_a_number_stays() -> None:
    assert family_of("cmu/12") == "cmu/12"
    assert family_of("take 3") == "take"
