"""Whether a motion shows what was asked: shown, not shown or not sure, for every action.

Two witnesses are heard, neither of which is used in making the motion.

* *Measurement*: directions, sides of limbs, and some actions are measured in the motion
  (:mod:`motiondb.meaning.direction`), directions and sides as in a search. A motion that does less
  than half of the full amount does not show the action, and one that fully does what is excluded
  does not either. A direction or a side that is done by half or more, but not fully, is not sure.
  What is fully done needs no other confirmation, nor does a turn. Frames that a seam bends towards
  the neighbours of a part may be left out: who sits down has sat down, though the seam lifts him.
* *The judge* (:mod:`motiondb.meaning.motion_judge`), which never uses the captures from which the
  motion was made, looks at the other words of an action together, as one word that all captures
  have whose captions say these words; where no other capture says all of them, at the least
  probable word. So "walk forward" is shown where the motion goes forward and looks like walking.

The words that the judge looks at are shown if their probability is ``SHOWN`` or more; they are not
shown below ``NOT_SHOWN``, unless no other capture says all of them, or all that do list other
actions too. Between these it is not sure. A measured action ("kick", "jump") is shown if it is
fully measured and its probability is ``MEASURED`` or more; it is never called not shown for its
looks. Neither is an action whose direction or side was asked for and is measured: who steps
sideways as asked is not denied for looking little like other steps, but who walks forward without a
jump does not show "jump forward".

Captions describe whole captures. Where no other capture (of the same performer, if there are any)
is described with the action alone, the judge cannot tell it from the actions that are always listed
with it ("wave" from "point" where all captions say "wave, point"). There its probability is
multiplied by the probability that the part comes from the right place of its capture
(:mod:`motiondb.meaning.place_certainty`). Where all these
captures list the same other action, which in turn is mostly listed with this one ("sit, stand up"),
neither can tell the two apart, and the judge is not sure.
"""

from __future__ import annotations

from collections.abc import Container, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motiondb.body.features import FEATURE_STEP, recognition_features
from motiondb.generate.sentence_plan import PlannedAction
from motiondb.language.question.tree import NotUsed
from motiondb.language.vocabulary import MODIFIERS
from motiondb.learn.learned import Learned
from motiondb.meaning.direction import (
    ACTIONS,
    ALOFT,
    FULLY,
    OCCURRING,
    PLAIN_TURNS,
    POSTURES,
    REACHED,
    TURNS,
    VERTICAL,
    directions_of,
    gone,
    is_as_in_search,
    say_hardly_done,
    say_measured,
    say_not_done,
    words_of_measured,
)
from motiondb.meaning.motion_judge import (
    WithoutSources,
    judge_without,
    judging_table,
    pool_windows,
    said_words,
)
from motiondb.meaning.occurrences import event_of, find_occurrences, measured_track, seen_event
from motiondb.meaning.postures import posture_of
from motiondb.records import Float32Array, FloatArray, Motion
from motiondb.search.measured_answers import excluded_words

SHOWN, NOT_SHOWN, MEASURED = 0.58, 0.20, 0.13
"""Smallest probability that is shown, largest that is not, and smallest of a measured action.

By a rule, on the 508 pairs of real CMU captures of the judge's calibration with the performers left
out (``benchmarks/judged_pictures.py --rule``): of the captures without the word at most 1 in 16 is
shown (1 in 12 with the measured action), of those with it at most 1 in 15 is not shown, where
another capture says it alone. Where none does, 1 in 4 would be. No generated motion was used."""
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
        Words of the action, as it was asked for.
    start : int
        First frame of its part of the motion.
    end : int
        Last frame + 1.
    shown : bool or None
        Whether the part shows the action and no excluded one; None if this is not sure.
    probability : float or None
        Probability that the part shows the words that the judge looked at; None if there are none,
        if it cannot tell, or if the verdict rests on what is measured, unwanted or left out.
    described : tuple of (str, float)
        The words that the part shows most clearly, with their probabilities.
    reason : str
        What the verdict rests on.
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
    directions: tuple[str, ...] = ()  # What is measured in the motion (``direction.directions_of``)
    # Probability that the part comes from the right place of its capture; None where it is not
    # known, and where the capture shows nothing else
    placed: float | None = None
    performer: str = ""  # Performer of that capture
    capture: str = ""  # Name of that capture
    not_done: tuple[NotUsed, ...] = ()  # What of the action the part takes no account of
    named: tuple[str, ...] = ()  # Words as they were asked for, where the action has fewer

    @property
    def words(self) -> tuple[str, ...]:
        """Words of the action, as it was asked for."""
        return self.named or self.action.words


def judge_motion(
    learned: Learned,
    motion: Motion,
    asked: Sequence[Asked],
    sources: Sequence[int],
    bent: NDArray[np.bool_] | None = None,
) -> tuple[JudgedAction, ...]:
    """Judge every action of a motion; `bent` (frames,): which frames a seam bends, if any."""
    numbers = learned.word_numbers
    path = measured_track(motion)
    bent = np.zeros(len(path), dtype=bool) if bent is None else bent
    tracks = [_tracks(path, one, bent) for one in asked]
    amounts = [
        {d: max(_gone(track, d, one.action.words) for track in each) for d in one.directions}
        for one, each in zip(asked, tracks)
    ]
    measured = [[d for d, amount in each.items() if amount >= FULLY] for each in amounts]
    for one, (track, *_), done in zip(asked, tracks, measured):
        occurring = [w for w in one.action.words if w in OCCURRING and w not in one.directions]
        done += [w for w in occurring if gone(track, w) >= FULLY]
    looked_at = [
        tuple(
            words
            for group in one.action.groups
            if (words := _unmeasured(group, done)) and not _is_seen(group, one, done, numbers)
        )
        for one, done in zip(asked, measured)
    ]
    known = [
        tuple(numbers[w] for w in group if w in numbers)
        for one, rest in zip(asked, looked_at)
        for group in (*rest, *one.action.excluded)
    ]
    groups = {group: len(numbers) + n for n, group in enumerate(dict.fromkeys(known))}
    judge = _judge(learned, groups, sources)
    features = learned.feature_space.project(recognition_features(motion))
    judged = []
    for one, done, rest, amount in zip(asked, measured, looked_at, amounts):
        undone = [w for w in one.action.words if w in (*ALOFT, *OCCURRING, *POSTURES)]
        undone = [w for w in undone if gone(path[one.start : one.end], w) < REACHED]
        as_asked = any(map(is_as_in_search, one.directions)) and not undone
        looked = Looked(rest, tuple(done), as_asked)
        answer = _judge_part(learned, judge, groups, features, _excluding(one), looked)
        against = [say_not_done(d, amount[d]) for d in one.directions if amount[d] < REACHED]
        against += _does_though_excluded(one, path[one.start : one.end])
        hardly = [d for d in one.directions if is_as_in_search(d) and amount[d] < FULLY]
        if against:
            answer = replace(answer, shown=False, probability=None, reason=against[0])
        elif hardly and answer.shown:
            why = say_hardly_done(hardly[0])
            answer = replace(answer, shown=None, probability=None, reason=why)
        judged.append(_less_than_asked(answer, one))
    return tuple(judged)


def _gone(track: FloatArray, measured: str, words: Sequence[str]) -> float:
    """How much a motion does of what is measured of an action.

    Who sits down on a high stool hardly goes down: that thighs become level counts as well.
    """
    amount = gone(track, measured)
    event = event_of((*words, measured)) if measured in VERTICAL else ""
    is_done = event in ("seat", "rise") and bool(find_occurrences(track, event))
    return max(amount, 1.0) if is_done else amount


def _tracks(path: FloatArray, asked: Asked, bent: NDArray[np.bool_]) -> list[FloatArray]:
    """The measured track of a part, and that without the frames bent towards its neighbours."""
    still = asked.start + np.flatnonzero(~bent[asked.start : asked.end])
    if not len(still):
        return [path[asked.start : asked.end]]
    first = still[0] if asked.start > 0 else asked.start
    behind = still[-1] + 1 if asked.end < len(path) else asked.end
    return [path[asked.start : asked.end], path[first:behind]]


def _excluded_measures(asked: Asked, excluded: Sequence[str]) -> tuple[str, ...]:
    """What is measured of something that an action must not do ("walk, but not backward")."""
    whole = not MODIFIERS.issuperset(excluded)
    return directions_of(excluded if whole else excluded_words(asked.action.words, excluded))


def _does_though_excluded(asked: Asked, track: FloatArray) -> list[str]:
    """What of the excluded actions a part of a motion fully does, as measured."""
    every = [_excluded_measures(asked, words) for words in asked.action.excluded]
    done = [one for one in every if one and all(gone(track, d) >= FULLY for d in one)]
    return [f"{' '.join(map(say_measured, one))} is measured, not wanted" for one in done]


def _excluding(asked: Asked) -> Asked:
    """The same without excluded actions that measurement alone decides on."""
    looked_at = tuple(
        words
        for words in asked.action.excluded
        if not (measures := _excluded_measures(asked, words))
        or not all(is_as_in_search(d) or d in TURNS for d in measures)
    )
    return replace(asked, action=replace(asked.action, excluded=looked_at))


@dataclass(frozen=True)
class Looked:
    """The words of an action that the judge looks at, and those that are measured."""

    groups: tuple[tuple[str, ...], ...]
    measured: tuple[str, ...]  # Directions, sides of limbs and actions that are fully done
    # Whether a direction or a side was asked for, and no jump, hop, kick or punch is found missing
    is_as_asked: bool = False


def _unmeasured(group: Sequence[str], done: Sequence[str]) -> tuple[str, ...]:
    """The words of a group that are no measured direction and no measured turn.

    >>> _unmeasured(("walk", "forward"), ["forward"]), _unmeasured(("turn", "left"), ["turn left"])
    (('walk',), ())
    >>> _unmeasured(("kick",), ["kick"]), _unmeasured(("turn",), ["turn"])
    (('kick',), ())
    """
    if posture_of(group) in done:
        return ()
    measured = words_of_measured([w for w in done if w not in ACTIONS or w in PLAIN_TURNS])
    if not measured.isdisjoint(PLAIN_TURNS):
        measured |= {*PLAIN_TURNS}
    return tuple(word for word in group if word not in measured)


def _is_seen(
    group: Sequence[str], asked: Asked, done: Sequence[str], known: Container[str]
) -> bool:
    """Whether a group whose words no caption says does all that is measured of its event."""
    is_done = bool(asked.directions) and {*asked.directions} <= {*done}
    return is_done and bool(seen_event(group, known))


def _less_than_asked(shown: JudgedAction, asked: Asked) -> JudgedAction:
    """The judge's answer, or that it is not sure where the part leaves out what was asked for."""
    if shown.shown is not True or not asked.not_done:
        return shown
    left = "; ".join(f"{one.text!r} is not met: {one.reason}" for one in asked.not_done)
    return replace(shown, shown=None, probability=None, reason=left)


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
    looked: Looked,
) -> JudgedAction:
    """The verdict on a part, before what it does less than is asked for is taken into account."""
    measured = ", ".join(f"{say_measured(word)} is measured" for word in looked.measured)
    answer = JudgedAction(asked.words, asked.start, asked.end, None, done=asked.done)
    if judge is None or judge.table.judge.certainty is None:
        why = "nothing that was learned here judges motion: learn again, with more captions"
        if not learned.described:
            why = "no caption of this database can confirm it"
        shown = None if looked.groups else True
        return replace(answer, shown=shown, reason=why if shown is None else measured)
    last = max(asked.end // FEATURE_STEP, asked.start // FEATURE_STEP + 1)
    part = features[min(asked.start // FEATURE_STEP, len(features) - 1) : last]
    scores = judge.scores(pool_windows(part))
    named = learned.association.words
    described = tuple(
        (named[word], p)
        for word, p in judge.likeliest(scores, N_DESCRIBED + len(groups))
        if word < len(named)
    )[:N_DESCRIBED]
    seen = _Seen(learned, judge, groups, scores, looked)
    each = [_judge_words(seen, asked, words) for words in looked.groups]
    worst = min(each, key=lambda one: _RANK[one[0]], default=(True, None, ""))
    known = [p for _, p, _ in each if p is not None]
    shown, reason = worst[0], ", ".join(filter(None, [worst[2], measured]))
    probability = min(known) if len(known) == len(each) and known else None
    for words in asked.action.excluded:
        unwanted, _ = _probability(seen, words)
        if unwanted is not None and unwanted >= SHOWN:
            shown, probability = False, None
            reason = f"it shows {' '.join(words)!r} ({unwanted:.2f}), not wanted"
    return replace(answer, shown=shown, probability=probability, described=described, reason=reason)


_RANK = {False: 0, None: 1, True: 2}  # Verdicts, the worst first


@dataclass(frozen=True, eq=False)
class _Seen:
    """What is seen in a part of a motion."""

    learned: Learned
    judge: WithoutSources
    groups: dict[tuple[int, ...], int]  # Groups of words -> their numbers for the judge
    scores: FloatArray  # (words and groups,): z of the part
    looked: Looked


def _judge_words(
    seen: _Seen, asked: Asked, words: tuple[str, ...]
) -> tuple[bool | None, float | None, str]:
    """The judge's verdict on a group of words, its probability, and what the verdict rests on."""
    learned, judge, unsure = seen.learned, seen.judge, ""
    probability, is_whole = _probability(seen, words)
    if probability is None:
        return (
            None,
            None,
            "only one capture is described this way, so there is nothing to check against",
        )
    companion = None
    if not asked.directions:
        companion = find_companion(learned, judge, words, asked.performer)
    if companion is not None:
        return None, None, f"cannot be confirmed, since every caption of it also says {companion!r}"
    mixed = is_mixed(learned, judge, words, asked.performer)
    if asked.placed is not None and mixed:
        if probability >= SHOWN:
            unsure = (
                "its captions list other actions too, and the probability that this is the right "
                f"part of {asked.capture} is {asked.placed:.2f}"
            )
        probability *= asked.placed
    is_measured = set(words) <= set(seen.looked.measured)
    said = " ".join(words)
    if probability >= SHOWN:
        return True, probability, f"{said} by its looks"
    if is_measured and probability >= MEASURED:
        return True, None, ""  # the verdict rests on the measurement
    may_deny = is_whole and not (is_measured or mixed or seen.looked.is_as_asked)
    if probability < NOT_SHOWN and may_deny:
        return False, probability, unsure or "it does not look like other captures of it"
    return (
        None,
        probability,
        unsure or f"it resembles the captures that are described as {said} only a little",
    )


def _probability(seen: _Seen, words: Sequence[str]) -> tuple[float | None, bool]:
    """Probability that a part shows a group of words, and whether another capture says them all.

    None where the judge cannot tell; the least one of the words where no other capture says all.
    """
    names, judge, scores = seen.learned.word_numbers, seen.judge, seen.scores
    numbers = tuple(names[w] for w in words if w in names)
    if not numbers:
        return None, False
    whole = judge.probability(scores, seen.groups[numbers])
    if whole is not None:
        return whole, True
    each = [judge.probability(scores, number) for number in numbers]
    known = [p for p in each if p is not None]
    return (min(known) if len(known) == len(each) else None), False


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


def is_mixed(learned: Learned, judge: WithoutSources, words: Sequence[str], performer: str) -> bool:
    """Whether all captures that could confirm an action list others too, without saying where."""
    said_by = _saying(learned, judge, words, performer)
    return all(judge.table.said[capture][1] > 1 for capture in said_by)


def find_companion(
    learned: Learned, judge: WithoutSources, words: Sequence[str], performer: str
) -> str | None:
    """A word that all captions which could confirm an action also list; None if there is none.

    It counts if all of these captions list several actions, and if at least ``ENTANGLED`` of its
    own captures list the action.
    """
    said, together = judge.table.said, judge.table.together
    numbers = [learned.word_numbers[w] for w in words if w in learned.word_numbers]
    saying = _saying(learned, judge, words, performer, FEWEST_OWN)
    if not saying or not numbers or any(said[c][1] == 1 for c in saying):
        return None
    common = frozenset.intersection(*(said[c][0] for c in saying)) - set(numbers)
    for other in sorted(number for number in common if number < len(learned.word_numbers)):
        if together[other, numbers].min() >= ENTANGLED * together[other, other]:
            return learned.association.words[other]
    return None
