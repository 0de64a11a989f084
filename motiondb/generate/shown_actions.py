"""Whether a motion shows what was asked: the judge's answer for every action.

The judge (:mod:`motiondb.meaning.motion_judge`) is not used in making the motion, and
never uses the captures from which it was made. An action of several words is judged as one word
that all captures have whose captions say these words; where no other capture says all of them, by
its least probable word.

Captions describe whole captures. Where no other capture (of the same performer, if there are any)
is described with the action alone, the judge cannot tell it from the actions that are always listed
with it ("wave" from "point" where all captions say "wave, point"). There its probability is
multiplied by the probability that the part comes from the right place of its capture
(:mod:`motiondb.meaning.place_certainty`). Where all these captures list the same other
action, which in turn is mostly listed with this one ("sit, stand up"), neither can tell the two
apart, and nothing is confirmed, unless a word of direction is measured ("up").
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from motiondb.body.features import FEATURE_STEP, recognition_features
from motiondb.generate.direction import gone, say_not_gone
from motiondb.generate.excerpts import REACHED
from motiondb.generate.occurrences import measured_track
from motiondb.generate.sentence_plan import PlannedAction
from motiondb.language.question.tree import NotUsed
from motiondb.learn.learned import Learned
from motiondb.meaning.motion_judge import (
    WithoutSources,
    judge_without,
    judging_table,
    pool_windows,
    said_words,
)
from motiondb.records import Float32Array, FloatArray, Motion

SHOWN_FROM = 0.6
"""Smallest probability of an action that counts as shown. More than one half, because a false claim
is worse than a missing one."""
ENTANGLED = 0.4
"""If all captures of one action list another word, smallest share of that word's captures listing
the action for which the two cannot be told apart."""
FEWEST_OWN = 3
"""Captures of a performer that suffice to find what is always listed together; with fewer, those of
all performers count."""
N_DESCRIBED = 3  # Words by which a part of the motion is described


@dataclass(frozen=True)
class JudgedAction:
    """Whether a motion shows one action.

    Attributes
    ----------
    words : tuple of str
        Words of the action.
    start : int
        First frame of its part of the motion.
    end : int
        Last frame + 1.
    shown : bool or None
        Whether the judge finds the action probable enough and no excluded action; None if it cannot
        decide.
    probability : float or None
        Probability that the part shows the action; None if the judge cannot decide.
    described : tuple of (str, float)
        The words that the part shows most clearly, with their probabilities.
    reason : str
        Why it is not shown, or why the judge cannot decide; "" if it is shown.
    done : tuple of str
        The counts, durations and speeds of the motion.
    """

    words: tuple[str, ...]
    start: int
    end: int
    shown: bool | None
    probability: float | None = None
    described: tuple[tuple[str, float], ...] = ()
    reason: str = ""
    done: tuple[str, ...] = ()


@dataclass(frozen=True)
class Asked:
    """A part of a motion, and the action for which it is judged."""

    action: PlannedAction  # The groups of words that the part is to show, and must not show
    start: int  # First frame of the part
    end: int  # Last frame + 1
    done: tuple[str, ...] = ()  # The counts, durations and speeds of the motion
    directions: tuple[str, ...] = ()  # Words of direction that are measured in the motion
    # Probability that the part comes from the right place of its capture; None where it is not
    # known, and where the capture shows nothing else
    placed: float | None = None
    performer: str = ""  # Performer of that capture
    capture: str = ""  # Name of that capture
    not_done: tuple[NotUsed, ...] = ()  # What of the action the part takes no account of


def judge_motion(
    learned: Learned, motion: Motion, asked: Sequence[Asked], sources: Sequence[int]
) -> tuple[JudgedAction, ...]:
    """Judge every action of a motion."""
    numbers = learned.word_numbers
    known = [
        tuple(numbers[w] for w in group if w in numbers)
        for one in asked
        for group in (*one.action.groups, *one.action.excluded)
    ]
    groups = {group: len(numbers) + n for n, group in enumerate(dict.fromkeys(known))}
    judge = _judge(learned, groups, sources)
    features = learned.feature_space.project(recognition_features(motion))
    path = measured_track(motion)
    return tuple(
        _against_direction(
            _less_than_asked(_judge_part(learned, judge, groups, features, one), one), one, path
        )
        for one in asked
    )


def _less_than_asked(shown: JudgedAction, asked: Asked) -> JudgedAction:
    """The judge's answer, or that it is not sure where the part leaves out what was asked for."""
    if shown.shown is not True or not asked.not_done:
        return shown
    left = "; ".join(f"{one.text!r} is left out: {one.reason}" for one in asked.not_done)
    return replace(shown, shown=None, reason=left)


def _against_direction(shown: JudgedAction, asked: Asked, path: FloatArray) -> JudgedAction:
    """The judge's answer, or "not shown" if the motion does not do what a measured word says."""
    for direction in asked.directions:
        if gone(path[asked.start : asked.end], direction) < REACHED:
            return replace(shown, shown=False, reason=say_not_gone(direction))
    return shown


def _judge(
    learned: Learned, groups: dict[tuple[int, ...], int], sources: Sequence[int]
) -> WithoutSources | None:
    """The judge without the sources, with an additional word for every group of words."""
    if learned.judge is None or not learned.described:
        return None
    inside = set(learned.judge.captures.tolist())
    said = {}
    for capture, (words, n) in said_words(learned.described, learned.word_numbers).items():
        if capture in inside:
            whole = {number for group, number in groups.items() if set(group) <= words}
            said[capture] = (words | whole, n)
    if not said:
        return None
    n_words = len(learned.word_numbers) + len(groups)
    return judge_without(judging_table(learned.judge, said, n_words), sources)


def _judge_part(
    learned: Learned,
    judge: WithoutSources | None,
    groups: dict[tuple[int, ...], int],
    features: Float32Array,
    asked: Asked,
) -> JudgedAction:
    action = asked.action
    answer = JudgedAction(action.words, asked.start, asked.end, None, done=asked.done)
    if judge is None or judge.table.judge.calibration is None:
        why = "the database has no judge of motion: learn again, with more captions"
        if not learned.described:
            why = "no caption of this database can confirm it"
        return replace(answer, reason=why)
    last = max(asked.end // FEATURE_STEP, asked.start // FEATURE_STEP + 1)
    part = features[min(asked.start // FEATURE_STEP, len(features) - 1) : last]
    scores = judge.scores(pool_windows(part))
    named = learned.association.words
    described = tuple(
        (named[word], p)
        for word, p in judge.likeliest(scores, N_DESCRIBED + len(groups))
        if word < len(named)
    )[:N_DESCRIBED]
    each = [_probability(learned, judge, groups, scores, group) for group in action.groups]
    known = [p for p in each if p is not None]
    unsure = ""
    shown: bool | None = None
    probability = min(known) if len(known) == len(each) else None
    if probability is not None and asked.placed is not None and _is_mixed(learned, judge, asked):
        if probability >= SHOWN_FROM:
            unsure = (
                "its captions list other actions too, and the probability that this is the right "
                f"part of {asked.capture} is {asked.placed:.2f}"
            )
        probability *= asked.placed
    companion = None if asked.directions else find_companion(learned, judge, asked)
    if companion is not None:
        probability = None
        reason = f"all captions that could confirm it list {companion!r} too"
    elif probability is None:
        reason = "no other capture shows it, so that nothing can confirm it"
    else:
        shown = probability >= SHOWN_FROM
        unlike = "it does not look like other captures of it"
        reason = "" if shown else unsure or unlike
    for words in action.excluded:
        unwanted = _probability(learned, judge, groups, scores, words)
        if unwanted is not None and unwanted >= SHOWN_FROM:
            shown, reason = False, f"it shows {' '.join(words)!r} ({unwanted:.2f}), not wanted"
    return replace(answer, shown=shown, probability=probability, described=described, reason=reason)


def _probability(
    learned: Learned,
    judge: WithoutSources,
    groups: dict[tuple[int, ...], int],
    scores: FloatArray,
    words: Sequence[str],
) -> float | None:
    """Probability that a part shows a group of words; None where the judge cannot tell."""
    numbers = tuple(learned.word_numbers[w] for w in words if w in learned.word_numbers)
    if not numbers:
        return None
    whole = judge.probability(scores, groups[numbers])
    if whole is not None:
        return whole
    each = [judge.probability(scores, number) for number in numbers]
    known = [p for p in each if p is not None]
    return min(known) if len(known) == len(each) else None


def _saying(
    learned: Learned, judge: WithoutSources, words: Sequence[str], performer: str, fewest: int = 1
) -> list[int]:
    """Captures that say an action; those of the performer alone, where there are enough of them.

    The performer's captures are the most similar ones, so they determine the judge's answer.
    """
    numbers = {learned.word_numbers[w] for w in words if w in learned.word_numbers}
    saying = [c for c in sorted(judge.captures) if numbers <= judge.table.said[c][0]]
    of_performer = [c for c in saying if learned.performers[c] == performer]
    return of_performer if len(of_performer) >= fewest else saying


def _is_mixed(learned: Learned, judge: WithoutSources, asked: Asked) -> bool:
    """Whether the judge knows an action of a part only together with other actions."""
    said = judge.table.said
    return any(
        all(said[c][1] > 1 for c in _saying(learned, judge, words, asked.performer))
        for words in asked.action.groups
    )


def find_companion(learned: Learned, judge: WithoutSources, asked: Asked) -> str | None:
    """A word that all captions which could confirm an action also list; None if there is none.

    It counts if all of these captions list several actions, and if at least ``ENTANGLED`` of its
    own captures list the action.
    """
    said, together = judge.table.said, judge.table.together
    for words in asked.action.groups:
        numbers = [learned.word_numbers[w] for w in words if w in learned.word_numbers]
        saying = _saying(learned, judge, words, asked.performer, FEWEST_OWN)
        if not saying or not numbers or any(said[c][1] == 1 for c in saying):
            continue
        common = frozenset.intersection(*(said[c][0] for c in saying)) - set(numbers)
        for other in sorted(number for number in common if number < len(learned.word_numbers)):
            if together[other, numbers].min() >= ENTANGLED * together[other, other]:
                return learned.association.words[other]
    return None
