"""Who performs where nobody said it."""

from __future__ import annotations

from motiondb.learn.learned import family_of, group_performers


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
