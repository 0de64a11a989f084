"""Questions whose answers are measured: degrees, counts, exclusions, postures, leaving, places."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import motiondb
from motiondb.language.question.parse import parse
from motiondb.language.question.readings import Exclusion, readings, say, say_count
from motiondb.language.question.tokens import time_of_take
from motiondb.language.vocabulary import SINGLE
from motiondb.meaning.occurrences import find_occurrences, flown
from motiondb.meaning.postures import sitting
from motiondb.records import FloatArray
from motiondb.search import by_words
from motiondb.search.asking import excluded_event, understand_learned
from motiondb.search.measured_answers import _done_though_excluded, _ways
from motiondb.search.measured_postures import events_of_side
from motiondb.search.placing import PartPlace
from motiondb.search.seen_frames import SeenFrames


def track_of(db: motiondb.MotionDB, name: str) -> FloatArray:
    """What is measured of a capture."""
    numbers = {info.name: number for number, info in db.learned.captures.items()}
    return db.session.frames.track(numbers[name])


def jumps_of(db: motiondb.MotionDB, name: str) -> list[tuple[int, int]]:
    return find_occurrences(track_of(db, name), "jump")


def seconds_of(db: motiondb.MotionDB, name: str) -> float:
    return next(info.duration for info in db.learned.captures.values() if info.name == name)


def amounts(answer: motiondb.WordAnswer) -> list[float]:
    """What was measured, of the answers that the motion does not contradict."""
    free = [match for match in answer.matches if not match.contradicted]
    return [float(match.reason.split("measured: ")[1].split(" m")[0]) for match in free]


@pytest.mark.parametrize(
    ("fast", "slow"), [("fastest run", "slowest run"), ("run quickly", "run in slow motion")]
)
def test_speed_orders_what_fast_and_slow_name(db: motiondb.MotionDB, fast: str, slow: str) -> None:
    quick, calm = db.search(fast, limit=4), db.search(slow, limit=4)
    assert amounts(quick) == sorted(amounts(quick), reverse=True)
    assert amounts(calm) == sorted(amounts(calm))
    assert amounts(quick)[0] > amounts(calm)[0]
    assert {match.probability for match in (*quick.matches, *calm.matches)} == {None}
    assert quick.question.understood == "run"


def test_a_manner_that_is_not_measured_has_no_probability(db: motiondb.MotionDB) -> None:
    answer = db.search("run happily", limit=3)
    assert [left.text for left in answer.not_used] == ["happily"]
    assert {match.probability for match in answer.matches} == {None}


@pytest.mark.parametrize("times", [1, 2, 3])
def test_events_are_counted_in_the_motion(db: motiondb.MotionDB, times: int) -> None:
    """Whatever is not contradicted has as many in its interval, counted again here."""
    answer = db.search(f"jump {times} times", limit=30)
    free = [match for match in answer.matches if not match.contradicted]
    for match in free:
        track = track_of(db, match.capture)
        first, behind = round(30 * match.start), round(30 * match.end)
        inside = [f for f in find_occurrences(track, "jump") if first <= sum(f) / 2 < behind]
        assert len(inside) == times
    others = [match for match in answer.matches if match.contradicted]
    assert others
    assert all("jump" in match.contradicted[0] for match in others)
    assert [match.probability for match in answer.matches] == [None] * len(answer.matches)


def test_what_must_not_come_afterwards_is_read_as_an_exclusion() -> None:
    question = parse("sit down without standing up afterwards")
    assert question.not_used == ()
    assert say(question.tree) == "sit down, not stand up afterwards"
    assert parse(say(question.tree)).tree == question.tree


def test_an_excluded_event_is_looked_for_in_the_interval(db: motiondb.MotionDB) -> None:
    answer = db.search("turn right without jumping", limit=20)
    for match in answer.matches:
        track = track_of(db, match.capture)
        first, behind = 30 * match.start, 30 * match.end
        jumps = [f for f in find_occurrences(track, "jump") if first < sum(f) / 2 < behind]
        told = "jump is seen, which is excluded" in match.contradicted
        assert told == bool(jumps)


def test_a_posture_meanwhile_is_measured(db: motiondb.MotionDB) -> None:
    told = set()
    for match in db.search("wave while sitting", limit=10).matches:
        track = track_of(db, match.capture)[round(30 * match.start) : round(30 * match.end)]
        told.add("does not sit meanwhile" in match.contradicted)
        assert ("does not sit meanwhile" in match.contradicted) == (sitting(track).mean() < 0.7)
    assert True in told


@pytest.mark.parametrize(
    ("asked", "posture"),
    [
        ("jump with the hands in the air", "overhead"),
        ("walk with both arms up", "raise both"),
        ("walk with high knees", "lift"),
        ("walk with a hand on the hip", "at any hip"),
        ("crouched walk", "low"),
        ("walks bent over", "stoop"),
    ],
)
def test_hands_that_are_raised_meanwhile_are_measured_alone(
    db: motiondb.MotionDB, asked: str, posture: str
) -> None:
    """Whatever is not contradicted has them up in its interval; no caption says how probably."""
    answer = db.search(asked, limit=60)
    free = [match for match in answer.matches if not match.contradicted]
    for match in free:
        held = find_occurrences(track_of(db, match.capture), posture)
        first, behind = round(30 * match.start), round(30 * match.end)
        assert any(first >= start and behind <= end for start, end in held)
    others = [match for match in answer.matches if match.contradicted]
    assert free
    assert others
    assert all("meanwhile" in match.contradicted[0] for match in others)
    assert {match.probability for match in answer.matches} == {None}


def test_a_posture_before_another_action_is_measured_alone(db: motiondb.MotionDB) -> None:
    answer = db.search("stand still, then walk", limit=20)
    assert answer.understood == "stand still, then walk; measured: stand still"
    silent = [match for match in answer.matches if "still" not in match.words]  # no caption says so
    free = [match for match in silent if not match.contradicted]
    for match in free:
        still, walk = match.parts
        held = find_occurrences(track_of(db, match.capture), "still")
        first, behind = round(30 * still.start), round(30 * still.end)
        assert any(start <= first < behind <= end for start, end in held)
        assert still.end <= walk.start
    assert len(free) >= 5


def test_captures_that_show_both_actions_are_no_parts(db: motiondb.MotionDB) -> None:
    """Of "and", in either order or at once, no probability is known."""
    answer = db.search("walk and turn", limit=5)
    assert {match.probability for match in answer.matches} == {None}
    assert min(match.score for match in answer.matches) > 0.9
    assert not answer.partial


def test_a_posture_that_no_caption_says_is_measured_alone(db: motiondb.MotionDB) -> None:
    assert not {"kneel", "knee", "lie"} & {*db.learned.known_words}
    for asked, posture in (
        ("kneel", "kneel"),
        ("lie on the floor", "lie"),
        ("kneel twice", "kneel"),
    ):
        answer = db.search(asked, limit=5)
        assert answer.missing == ()
        assert answer.measured == (posture,)
        assert answer.nothing.startswith("probably nothing")
        assert all(posture in match.contradicted[0] for match in answer.matches)


def test_postures_alone_are_looked_for_in_every_capture(db: motiondb.MotionDB) -> None:
    """Also where no word ranks the captures: the later numbers are looked at, too."""
    answer = db.search("raise the right hand, then stand still", limit=200)
    free = {match.capture for match in answer.matches if not match.contradicted}
    for name in [info.name for info in db.captures()]:
        track = track_of(db, name)
        raised, still = (find_occurrences(track, word) for word in ("raise right", "still"))
        # so that the second part begins behind the first, wherever that is
        if raised and still and still[-1][1] - max(max(raised)[1], still[-1][0]) >= 30:
            assert name in free


def test_a_posture_in_unknown_words_is_nothing_for_symbols(db: motiondb.MotionDB) -> None:
    with pytest.raises(motiondb.UnknownWordsError, match="kneel"):
        db.search("kneel", by_symbols=True)
    assert db.search("walk, then kneel", by_symbols=True).understood == "walk"


def test_parts_that_different_captures_show_are_not_called_absent(db: motiondb.MotionDB) -> None:
    for asked in ("wave while dribbling", "dribble, then clap"):
        answer = db.search(asked, limit=3)
        assert answer.partial
        assert not answer.nothing


def test_who_walks_away_is_measured_after_the_other_action(db: motiondb.MotionDB) -> None:
    answer = db.search("wave, then walk away", limit=5)
    assert [part.words for part in answer.matches[0].parts] == ["wave", "walk"]
    assert answer.unknown == {}
    assert {match.probability for match in answer.matches} == {None}
    for match in answer.matches:
        if not match.contradicted:
            assert match.parts[1].end - match.parts[1].start >= 1.0


def test_the_place_of_an_event_is_where_it_is(db: motiondb.MotionDB) -> None:
    (first, *_) = db.search("jump", limit=1).matches
    track = track_of(db, first.capture)
    flights = find_occurrences(track, "jump")
    assert round(30 * first.start) in [start for start, _ in flights]
    assert round(30 * first.end) in [end for _, end in flights]


def test_a_side_is_believed_of_its_own_action_alone(few_copy: Path) -> None:
    with motiondb.open(few_copy) as db:
        name = db.search("punch with the right hand", limit=1).matches[0].capture

        def against(caption: str) -> tuple[str, ...]:
            db.words.set(name, caption)
            found = db.search("punch with the left hand", limit=200).matches
            (match,) = (m for m in found if m.capture == name)
            return match.contradicted

        assert against("punch with the left hand") == ()
        assert against("punch") != ()
        assert against("punch, turn left") == against("punch")


def test_who_must_not_move_is_looked_for_in_the_motion() -> None:
    asked = parse("stand without moving")
    (reading,), _ = readings(asked.tree)
    assert [excluded_event(one) for one in reading.exclusions] == ["move"]
    track = np.zeros((120, 22))
    track[30:60, 9], track[90:120, 2] = 0.5, 0.3  # the right hand moves, then somebody goes ahead
    assert find_occurrences(track, "move") == [(30, 60), (90, 120)]


def test_what_is_named_as_not_used_leaves_no_probability(db: motiondb.MotionDB) -> None:
    assert db.search("turn left", limit=1).matches[0].probability is not None
    answer = db.search("turn left at 30 fps", limit=3)
    assert [left.text for left in answer.not_used] == ["at 30 fps"]
    assert {match.probability for match in answer.matches} == {None}


@pytest.mark.parametrize(
    ("question", "least", "most"),
    [
        ("turn left by 90 degrees", 72.0, 108.0),
        ("walk, then turn right 90 degrees", 72.0, 108.0),
        ("turn at least 120 degrees", 120.0, 720.0),
        ("turn left by 90 degrees while walking", 72.0, 108.0),
    ],
)
def test_angles_of_turns_are_measured(
    db: motiondb.MotionDB, question: str, least: float, most: float
) -> None:
    answer = db.search(question, limit=20)
    assert not answer.not_used
    free = [match for match in answer.matches if not match.contradicted]
    turned = [float(m.reason.split("turns by ")[1].split(" degrees")[0]) for m in free]
    assert turned
    assert all(least <= angle <= most for angle in turned)
    assert {match.probability for match in answer.matches} == {None}


def test_a_measured_turn_is_the_change_of_the_heading(db: motiondb.MotionDB) -> None:
    """Summed up here from the turning of every frame, half as fast as 30 a second."""
    answer = db.search("turn left by 90 degrees", limit=3)
    for match in answer.matches[:1]:
        speeds = track_of(db, match.capture)[:, 3]
        turned = np.degrees(speeds[round(match.start * 30) : round(match.end * 30)].sum() / 30)
        told = float(match.reason.split("turns by ")[1].split(" degrees")[0])
        assert turned == pytest.approx(told, abs=5)


def test_ways_speeds_and_steps_are_measured_where_the_action_goes(db: motiondb.MotionDB) -> None:
    for question, unit in (("walk 3 m", "m"), ("run at least 2 m/s", "m/s"), ("walk 4 steps", "")):
        answer = db.search(question, limit=10)
        assert not answer.not_used
        assert f"{unit or 'steps'}" in answer.matches[0].reason.split("measured: ")[1]
    assert [left.text for left in db.search("kick 90 degrees").not_used] == ["90 degrees"]
    assert [left.text for left in db.search("kick 3 m or walk 3 m").not_used] == ["3 m"]


def test_every_alternative_is_measured_by_itself(db: motiondb.MotionDB) -> None:
    answer = db.search("turn left or turn right", limit=30)
    assert not answer.unmeasured
    captures = [match.capture for match in answer.matches]
    assert len(set(captures)) == len(captures)
    sides = {"left": 1.0, "right": -1.0}
    free = [match for match in answer.matches if not match.contradicted]
    for match in free:
        inside = slice(round(match.start * 30), round(match.end * 30))
        side = match.parts[0].words.split()[1]
        assert sides[side] * track_of(db, match.capture)[inside, 3].sum() > 0.0
    assert {match.parts[0].words for match in free} == {"turn left", "turn right"}
    alone = {m.capture: m.probability for m in db.search("turn left", limit=30).matches}
    for match in free:
        if match.parts[0].words == "turn left":
            assert match.probability == alone[match.capture]


def test_an_excluded_limb_that_is_not_measured_leaves_no_probability(
    db: motiondb.MotionDB,
) -> None:
    answer = db.search("walk without moving the arms", limit=5)
    assert {match.probability for match in answer.matches} == {None}
    assert db.search("walk without waving", limit=5).matches[0].probability is not None


def test_an_excluded_posture_in_unknown_words_is_measured(db: motiondb.MotionDB) -> None:
    answer = db.search("walk without kneeling", limit=20)
    assert not answer.not_used
    kneels = [bool(find_occurrences(track_of(db, m.capture), "kneel")) for m in answer.matches]
    against = [any("kneel" in words for words in m.contradicted) for m in answer.matches]
    assert not any(one and not knelt for one, knelt in zip(against, kneels))
    assert {match.probability for match in answer.matches} == {None}
    assert not db.search("stand, but not on one leg", limit=5).not_used


@pytest.mark.parametrize("question", ["hands on the back", "left foot", "arms forward"])
def test_parts_of_the_body_alone_have_no_verdict(db: motiondb.MotionDB, question: str) -> None:
    answer = db.search(question, limit=5)
    assert {match.probability for match in answer.matches} == {None}
    assert not answer.nothing
    excluded = db.search(f"walk, but not the {question}", limit=5)
    assert {match.probability for match in excluded.matches} == {None}


@pytest.mark.parametrize(
    "question",
    [
        "walk backward",
        "sit down",
        "run for more than 2 seconds",
        "jump twice",
        "turn left, jump",
        "kick with the left leg twice",
        "jump twice in the first 2 s",
    ],
)
def test_a_take_that_surely_contradicts_is_contradicted_at_its_place(
    db: motiondb.MotionDB, question: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    quick = db.search(question, limit=40)
    monkeypatch.setattr(by_words, "is_surely_against", lambda *_: False)
    slow = db.search(question, limit=40)
    assert quick.matches == slow.matches
    assert any(match.contradicted for match in slow.matches)


def test_a_thing_beside_an_event_does_not_take_its_place(db: motiondb.MotionDB) -> None:
    plain = {m.capture: (m.start, m.end) for m in db.search("stand up", limit=30).matches}
    shared = [m for m in db.search("stand up from a chair", limit=5).matches if m.capture in plain]
    assert shared
    assert all((m.start, m.end) == plain[m.capture] for m in shared)


@pytest.mark.parametrize(
    ("question", "time"),
    [
        ("ends with a jump", "at the end"),
        ("jump in the first 1 s", "in the first 1 s"),
        ("does the take end with a jump?", "at the end"),
    ],
)
def test_an_action_is_looked_for_in_the_part_of_a_take(
    db: motiondb.MotionDB, question: str, time: str
) -> None:
    answer = db.search(question, limit=60)
    assert (time in answer.measured, answer.not_used) == (True, ())
    assert {match.probability for match in answer.matches} == {None}
    against = {m.capture for m in answer.matches if f"not {time}" in m.contradicted}
    there = [m for m in answer.matches if m.capture not in against]
    assert against
    assert there
    for match in there:
        low, high = time_of_take(time, seconds_of(db, match.capture)) or (0.0, 0.0)
        assert min(match.end, high) > max(match.start, low)
    for capture in against:
        low, high = time_of_take(time, seconds_of(db, capture)) or (0.0, 0.0)
        assert not any(low < (a + b) / 60.0 < high for a, b in jumps_of(db, capture))


def test_jumps_to_a_side_are_measured_in_their_flights(db: motiondb.MotionDB) -> None:
    answer = db.search("jump to the left", limit=10)  # all jumps of the sample data go up or ahead
    assert {match.contradicted for match in answer.matches} == {("does not jump left",)}
    name = next(m.capture for m in db.search("jump", limit=1).matches)
    (start, end), *_ = jumps_of(db, name)
    track = track_of(db, name).copy()
    track[start:end, 1:4] = -1.0, 0.3, 0.0
    aside, ahead = flown(track, (start, end))
    assert aside < -0.2 < ahead


def test_the_foot_that_a_jump_leaves_is_looked_for_beside_it(db: motiondb.MotionDB) -> None:
    answer = db.search("jump off one foot", limit=101)
    assert answer.measured == ("take off from one foot alone",)
    for match in [m for m in answer.matches if not m.contradicted]:
        takeoffs = find_occurrences(track_of(db, match.capture), "takeoff one")
        assert any(a / 30.0 < match.end + 0.5 and b / 30.0 > match.start - 0.5 for a, b in takeoffs)
    assert any(match.contradicted for match in answer.matches)


def test_takes_are_ordered_by_how_often_something_is_done(db: motiondb.MotionDB) -> None:
    most, least = (db.search(f"the {how} punches", limit=6).matches for how in ("most", "fewest"))
    counts = [len(find_occurrences(track_of(db, m.capture), "punch")) for m in (*most, *least)]
    assert counts[:6] == sorted(counts[:6], reverse=True)
    assert counts[6:] == sorted(counts[6:])
    assert counts[0] > counts[6] >= 1
    assert {m.probability for m in (*most, *least)} == {None}


@pytest.mark.parametrize(
    ("question", "told"),
    [("lunge to the left", "left"), ("deep lunge", "deep"), ("kneel slowly", "slow")],
)
def test_what_is_not_measured_of_a_posture_is_told(
    db: motiondb.MotionDB, question: str, told: str
) -> None:
    answer = db.search(question, limit=1)
    assert answer.measured == (question.split(" to ")[0].split()[0 if told != "deep" else 1],)
    assert told in [part.text for part in answer.not_used]


def test_more_of_what_is_shown_comes_before_as_many_of_what_is_not(db: motiondb.MotionDB) -> None:
    """Of a degree, the speed of what hardly punches is not compared with that of who does."""
    answer = db.search("punch twice quickly", limit=60)
    weak = [match.score < 0.5 for match in answer.matches if not match.contradicted]
    assert weak == sorted(weak)
    assert False in weak


def test_who_stands_while_doing_something_is_measured(db: motiondb.MotionDB) -> None:
    for posed, plain in (
        ("standing wave", "stand while waving"),
        ("seated wave", "wave while sitting"),
    ):
        assert db.search(posed, limit=5).matches == db.search(plain, limit=5).matches
    (wave,) = db.search("wave", limit=1).matches
    seated = {match.capture: match for match in db.search("seated wave", limit=101).matches}
    assert seated[wave.capture].contradicted == ("does not sit meanwhile",)


def test_directions_that_no_caption_holds_are_measured_of_several_actions(
    db: motiondb.MotionDB,
) -> None:
    answer = db.search("walk in place, then turn left", limit=101)
    assert (answer.unknown, answer.not_used) == ({}, ())
    against = {text for match in answer.matches for text in match.contradicted}
    assert "does not stay in place" in against
    assert db.search("does not go backward", limit=1).unknown.keys() == {"backward"}  # left out


def test_who_goes_on_the_whole_time_is_measured(db: motiondb.MotionDB) -> None:
    answer = db.search("walks the whole time", limit=101)
    assert answer.measured == ("the whole time",)
    whole = [match for match in answer.matches if not match.contradicted]
    assert whole
    assert all(match.end - match.start >= 0.7 * seconds_of(db, match.capture) for match in whole)
    assert any("not the whole time" in match.contradicted for match in answer.matches)


@pytest.mark.parametrize(
    ("question", "left"),
    [
        ("waves the whole time", "the whole time"),
        ("ends with a jump or a kick", "at the end"),
        ("walk without kneeling at the end", "at the end"),
        ("jump, but not at the end", "but not at the end"),
    ],
)
def test_a_part_of_a_take_of_which_it_is_open_what_is_there_is_told(
    db: motiondb.MotionDB, question: str, left: str
) -> None:
    answer = db.search(question, limit=3)
    assert left in [part.text for part in answer.not_used]
    assert left not in answer.measured


def test_without_the_motion_a_posture_that_no_caption_says_is_not_used(
    db: motiondb.MotionDB,
) -> None:
    question = understand_learned(db.learned, "defend with arms wide, then crawl")
    assert question.known.understood == "defend"
    answer = by_words.search_words(question, db.learned.rows, 3, written=False)
    assert len(answer.matches) == 3


def test_another_number_comes_before_another_action(db: motiondb.MotionDB) -> None:
    answer = db.search("jump twice", limit=80)
    counted = [n for n, m in enumerate(answer.matches) if any("not 2" in w for w in m.contradicted)]
    shown = {m.capture for m in db.search("jump", limit=80).matches if (m.probability or 0) > 0.5}
    more = [n for n in counted if len(jumps_of(db, answer.matches[n].capture)) > 2]
    weak = [n for n, m in enumerate(answer.matches) if m.capture not in shown]
    assert more
    assert weak
    assert max(n for n in more if answer.matches[n].capture in shown) < min(weak)


def test_fewer_in_a_part_of_a_take_come_after_other_answers(db: motiondb.MotionDB) -> None:
    answers = db.search("punch twice at the start", limit=80).matches
    fewer = [n for n, m in enumerate(answers) if "punch once, not 2 times" in m.contradicted]
    other = [n for n, m in enumerate(answers) if not m.contradicted]
    assert other
    assert fewer
    assert max(other) < min(fewer)


def test_hops_are_counted_on_their_leg() -> None:
    """Of three hops, the first is on the left leg, and both others are on the right one."""
    hops = [(10, 20), (30, 40), (50, 60)]
    seen: Any = SeenFrames(*[None] * 3)  # type: ignore[arg-type]
    seen.__dict__["events"] = {"hop left": hops[:1], "hop right": hops[1:], "hop one": hops}.get
    for leg, counted in (("left", hops[:1]), ("right", hops[1:]), (SINGLE, hops)):
        assert events_of_side(seen, ("hop", leg, "leg"), hops) == counted


def test_a_hop_is_excluded_on_its_leg_alone() -> None:
    """Who hops on the right leg is not told to hop on the left one, which is excluded."""
    hop = [(10, 20)]
    seen: Any = SeenFrames(*[None] * 3)  # type: ignore[arg-type]
    seen.__dict__["events"] = {"hop": hop, "hop left": [], "hop right": hop}.get
    place = PartPlace(0, 60, None)
    asked: Any = SimpleNamespace(numbers={"hop": 0})
    for leg, told in (("left", False), ("right", True)):
        excluded = Exclusion((("hop", leg, "leg"),), 0, 1)
        assert bool(_done_though_excluded(asked, seen, (("hop",),), excluded, place)) is told


def test_who_goes_on_all_fours_backward_is_measured_as_told(db: motiondb.MotionDB) -> None:
    answer = db.search("walk backward on all fours", limit=3)
    assert ({*answer.measured}, answer.not_used) == ({"on all fours", "backward"}, ())


def test_of_a_long_place_the_part_that_goes_in_the_direction_is_told() -> None:
    """Who walks ahead for 4 s and back for 2 s walks backward in the latter."""
    speeds = np.zeros((90, 3))
    speeds[:60, 1], speeds[60:, 1] = 1.2, -0.8
    seen: Any = SeenFrames(*[None] * 3)  # type: ignore[arg-type]
    seen.__dict__["speeds"] = speeds
    place = PartPlace(0, 180, None)
    backward = _ways(seen, "backward", ("walk", "backward"), place, np.ones(90, dtype=bool), 0.0)
    assert backward is not None
    assert (55 <= backward[0] <= 65, backward[1]) == (True, 90)
    assert _ways(seen, "forward", ("walk",), place, np.ones(90, dtype=bool), 0.0) == (0, 90)
    assert _ways(seen, "backward", ("walk",), place, np.ones(90, dtype=bool), 4.0) == (0, 90)


def test_turns_are_counted_by_their_side(db: motiondb.MotionDB) -> None:
    answer = db.search("turn left twice", limit=60)
    for match in answer.matches:
        track = track_of(db, match.capture)
        turned = [track[a:b, 3].sum() for a, b in find_occurrences(track, "turn")]
        n = sum(one > 0.0 for one in turned)
        if match.contradicted:
            assert f"turn {say_count(n, n)}" in match.contradicted[0]
        else:
            assert n >= 2
    assert any(match.contradicted for match in answer.matches)


def test_a_degree_that_is_measured_is_not_called_unused(db: motiondb.MotionDB) -> None:
    kicks = db.search("kick 1 m high", limit=4)  # the number is not measured, but higher is better
    assert (kicks.measured, [left.text for left in kicks.not_used]) == (("high",), ["1 m"])
    assert amounts(kicks) == sorted(amounts(kicks), reverse=True)
    assert len(amounts(kicks)) > 1
    for deep in ("bow deeply", "deep bow"):
        answer = db.search(deep)
        assert (answer.measured, answer.not_used) == (("deep",), ())


def test_light_nouns_behind_one_another_say_no_more_than_the_action(db: motiondb.MotionDB) -> None:
    assert db.search("walking practice session").question.understood == "walk"
