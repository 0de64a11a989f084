"""Motion from a sentence: its actions, captures that show them, the motion, and its evaluation.

Methods: ``stitched`` (excerpts of captures that show the actions, seams blended, feet held) and
``trajectory`` (the most probable smooth trajectory of the symbols' HMMs). The result is evaluated
by a judge that is not used in making it (:mod:`motiondb.generate.shown_actions`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from motiondb.errors import QueryError, UnknownWordsError
from motiondb.generate.action_sources import (
    ActionSources,
    all_sources,
    find_sources,
    looked_at,
    picked_source,
    seen_sources,
)
from motiondb.generate.excerpt_motion import (
    ANY_PLACE,
    Choices,
    ExcerptMotion,
    PlaceWish,
    excerpt_motion,
)
from motiondb.generate.excerpt_report import (
    miscounted,
    place_probability,
    report_excerpt,
    segments_of,
)
from motiondb.generate.material import SequenceMotion, Takes
from motiondb.generate.sentence_plan import (
    MOST_SECONDS,
    Amount,
    PlannedAction,
    plan_sentence,
)
from motiondb.generate.shown_actions import Asked, JudgedAction, judge_motion
from motiondb.generate.smoothness import Smoothness, measure_smoothness
from motiondb.generate.symbol_motion import symbol_motion
from motiondb.language.question.heads import missing_heads, verbs_in
from motiondb.language.question.parse import parse
from motiondb.language.question.readings import KnownQuestion, hold_to_known, reason_unknown
from motiondb.language.question.tree import (
    Action,
    AnyOf,
    Node,
    NotUsed,
    Question,
    Without,
    actions_of,
    core,
    map_actions,
    parts_of,
)
from motiondb.language.translation import decoding
from motiondb.language.vocabulary import MODIFIERS, TRAVELS, as_said, nearest_words
from motiondb.learn.learned import Learned
from motiondb.learn.recognition import recognise
from motiondb.meaning.amounts import amounts_of, off, outside
from motiondb.meaning.direction import (
    HOPS_ON,
    directions_of,
    is_as_in_search,
    words_of_measured,
)
from motiondb.meaning.limb_sides import hand_at, limb_held
from motiondb.meaning.occurrences import FLIGHTS, beside_event, measured_track, seen_event
from motiondb.meaning.postures import EVERY_POSTURE, is_posture_alone
from motiondb.records import MOTION_FPS, IntArray
from motiondb.symbols.hmm_jobs import one_blas_thread

METHODS = ("stitched", "trajectory")
INSIDE = 0.1  # Share of a limit by which a motion is made to be inside of it
MOST_FITS = 3  # Times that a motion is made again, so that it goes as far as is asked for
LEAST_SECONDS = 0.6  # Of an action that is made again so
SPEED_NAMES = ("slow", "fast")  # Manners that generation can show although no caption says them


@dataclass(frozen=True, eq=False)
class MadeMotion:
    """A motion that was made from a sentence, and is not judged yet (:func:`judge`)."""

    made: SequenceMotion  # The motion with the origin of its frames
    symbols: IntArray  # (symbols,): symbols of the excerpts, or those that were decoded
    positions: tuple[int, ...]  # Per symbol the number of its action
    actions: tuple[tuple[str, ...], ...]  # Words of every action that was made
    decodings: tuple[decoding.Decoding, ...]  # Per action; none for stitched motion
    question: KnownQuestion
    asked: tuple[Asked, ...]  # What is to be judged
    missing: tuple[JudgedAction, ...]  # What was asked for and not made
    sources: tuple[int, ...]  # Captures that the judge leaves out
    decided: tuple[str, ...] = ()  # Decisions on what the sentence leaves open
    not_used: tuple[NotUsed, ...] = ()  # Parts of the sentence that the motion does not show
    # Number of every action's place among those that show it about as clearly as the best one (-1
    # if it is none of them), and their number; none for other methods
    places: tuple[tuple[int, int], ...] = ()


@dataclass(frozen=True, eq=False)
class JudgedMotion:
    """A motion with what it shows."""

    made: SequenceMotion
    shown: tuple[JudgedAction, ...]  # Per action that was asked for, whether the motion shows it
    recognised: IntArray  # (segments,): symbols recognised in the motion
    smoothness: Smoothness

    @property
    def spans(self) -> tuple[tuple[int, int], ...]:
        """First frame and last frame + 1 of every action that was made."""
        return tuple((one.start, one.end) for one in self.shown if one.end > one.start)


@dataclass(frozen=True, eq=False)
class _Wanted:
    """The planned actions of a sentence, with notes."""

    question: KnownQuestion
    actions: tuple[PlannedAction, ...]
    verbs: frozenset[str]  # Of the sentence
    missing: tuple[JudgedAction, ...]  # What is asked for and not made
    decided: tuple[str, ...]
    not_used: tuple[NotUsed, ...]


def make_motion(
    learned: Learned,
    takes: Takes,
    text: str,
    rng: np.random.Generator,
    method: str = "stitched",
    anyway: bool = False,
    instead: Mapping[str, str] | None = None,
    choice: Choices = ANY_PLACE,
) -> MadeMotion:
    """Generate a motion from a sentence.

    `anyway`: whether to make the rest of the motion if nothing in the database shows an action.
    `instead`: word that no caption says -> the nearest known word, which is made in its place and
    does not count as showing it. `choice` (stitched motion only): which of the places that show
    each action about as clearly as the best one are preferred, from the first again after the last.
    """
    if method not in METHODS:
        raise QueryError(f"method: expected one of {', '.join(METHODS)}, found {method!r}.")
    held = partial(_is_held, learned, takes) if method == "stitched" else lambda _: False
    wanted = _understand(learned, text, rng, anyway, instead or {}, choice.wishes, held)
    if choice.wishes and (method != "stitched" or len(choice.wishes) != len(wanted.actions)):
        said = ", ".join(" ".join(action.words) for action in wanted.actions)
        raise QueryError(
            f"places: expected one for each of {len(wanted.actions)} stitched actions ({said}),"
            f" found {len(choice.wishes)} with the method {method}. Say every action by itself,"
            " divided by 'then'."
        )
    with one_blas_thread():  # the same sums on any machine
        if method == "trajectory":
            return _from_symbols(learned, takes, wanted)
        sources = _sources(learned, takes, wanted, anyway, choice.wishes)
        drawn = deepcopy(rng)
        made_of_excerpts = excerpt_motion(learned, takes, sources, rng, choice)

        def again(of: Sequence[ActionSources]) -> ExcerptMotion:
            return excerpt_motion(learned, takes, of, deepcopy(drawn), choice)

        made_of_excerpts = _as_far_as_asked(sources, made_of_excerpts, again)
        return _from_excerpts(learned, wanted, sources, made_of_excerpts)


def _as_far_as_asked(
    sources: Sequence[ActionSources],
    made: ExcerptMotion,
    again: Callable[[Sequence[ActionSources]], ExcerptMotion],
) -> ExcerptMotion:
    """A motion whose excerpts go on for as long as the ways and steps that are asked for take.

    It is the motion that was made, unless another comes nearer. `again`: Makes it of other sources.
    """
    if not any(_goes_so_far(of.action) for of in sources):
        return made
    apart = _apart(sources, made)
    best, least = made, _distance(apart)
    seconds: list[float | None] = [None] * len(sources)
    for _ in range(MOST_FITS):
        before = seconds
        seconds = [  # what is met lasts as long as before
            s if one is None or one[0] <= 0.0 else one[1] for one, s in zip(apart, before)
        ]
        if seconds == before:
            break
        timed = [
            of if s is None else replace(of, action=replace(of.action, seconds=Amount(s, s)))
            for of, s in zip(sources, seconds)
        ]
        tried = again(timed)
        shown = (replace(one, action=of.action) for one, of in zip(tried.shown, sources))
        tried = replace(tried, shown=tuple(shown))
        apart = _apart(sources, tried)  # at first of another excerpt, which may be faster
        if _distance(apart) < least:
            best, least = tried, _distance(apart)
    return best


def _distance(apart: Sequence[tuple[float, float] | None]) -> tuple[int, float]:
    """Of how many actions a way or steps were not measured, and how far the others are outside."""
    return sum(one is None for one in apart), sum(one[0] for one in apart if one is not None)


def _apart(
    sources: Sequence[ActionSources], made: ExcerptMotion
) -> list[tuple[float, float] | None]:
    """How far the way or the steps of each action are outside, and the seconds that would do.

    None for an action without, and for one that also lasts or is repeated as often as is said.
    """
    track, ends = measured_track(made.made.motion), np.cumsum([0, *made.made.lengths])
    found: list[tuple[float, float] | None] = []
    for of, start, end in zip(sources, ends[:-1], ends[1:]):
        action, measure = of.action, of.action.measure
        found.append(None)
        if measure is None or not _goes_so_far(action):
            continue
        gone = amounts_of(measure, action.words, track[start:end])
        amount, first, behind = min(
            gone, key=lambda one: off(measure, action.words, one[0]), default=(0.0, 0, 0)
        )
        if amount > 0.0:  # of no steps, nothing follows
            low, high = measure.least, np.inf if measure.most is None else measure.most
            if low < high:  # limits are met exactly, so clearly inside
                low, high = min(low * (1.0 + INSIDE), high), max(high * (1.0 - INSIDE), low)
            share = float(np.clip(amount, low, max(low, high))) / amount
            frames = end - start - (behind - first) * (1.0 - share)
            beyond = max(outside(measure, action.words, amount), 0.0)
            seconds = float(np.clip(frames / MOTION_FPS, LEAST_SECONDS, MOST_SECONDS))
            found[-1] = beyond, seconds
    return found


def _goes_so_far(action: PlannedAction) -> bool:
    """Whether an action travels a way or steps, and is neither as long nor as often as is said."""
    goes = action.measure is not None and action.measure.what in ("way", "steps")
    is_free = action.seconds is None and action.times is None
    flies = not set(FLIGHTS).isdisjoint(action.words)
    return goes and is_free and not flies and not TRAVELS.isdisjoint(action.words)


def _understand(
    learned: Learned,
    text: str,
    rng: np.random.Generator,
    anyway: bool,
    instead: Mapping[str, str],
    wishes: Sequence[PlaceWish],
    held: Callable[[str], bool],
) -> _Wanted:
    """Read a sentence; words of speed, of what is measured and of picked excerpts are known."""
    read = read_sentence(learned, text, lambda tree: _picked_words(tree, rng, wishes), held)
    question, missing = read.question, read.missing
    actions, decided, left = plan_sentence(question.tree, rng)
    if not actions:
        raise QueryError(
            f"generate: expected an action to show, found only what not to show in {text!r}. "
            "Say what the motion is to show."
        )
    if missing and not anyway:
        raise UnknownWordsError(_nothing_shows(missing, learned))
    judged = [
        JudgedAction(words, 0, 0, False, 0.0, reason=f"it was not made: {reason_unknown(())}")
        for words in read.lost
    ]
    for words in read.left_over:
        judged.append(JudgedAction(words, 0, 0, None, reason=reason_unknown(())))
    for word, near in instead.items():
        why = f"{reason_unknown(())}; {near!r}, the nearest known word, was made instead"
        judged.append(JudgedAction((word,), 0, 0, False, 0.0, reason=why))
    not_used = (*question.not_used, *left)
    return _Wanted(question, actions, read.verbs, tuple(judged), decided, not_used)


@dataclass(frozen=True, eq=False)
class ReadSentence:
    """A sentence in the words of the captions and of what is measured, and what that loses."""

    question: KnownQuestion
    verbs: frozenset[str]  # Of the sentence
    missing: tuple[tuple[str, ...], ...]  # Words of the actions without any known word
    lost: tuple[tuple[str, ...], ...]  # These, and unknown heads of the other actions
    left_over: tuple[tuple[str, ...], ...]  # Other unknown words of an action


def read_sentence(
    learned: Learned,
    text: str,
    also_known: Callable[[Node], set[str]] = lambda _tree: set(),
    held: Callable[[str], bool] = lambda _posture: True,
) -> ReadSentence:
    """Read a sentence; words of speed, of what is measured and of ``also_known`` are known.

    `held`: Whether a posture can be shown whatever captions say.
    """
    counts = dict.fromkeys(SPEED_NAMES, 1)
    for word, count in zip(learned.association.words, learned.association.counts):
        if count > 0:
            counts[word] = int(count)
    read = _each_word_once(parse(text, learned.synonyms, learned.lemmas))
    for word in (*also_known(read.tree), *_measured_words(read.tree, counts, held)):
        counts.setdefault(word, 1)
    question = hold_to_known(read, counts)
    missing = tuple(_missing(read, counts))
    verbs = verbs_in(text, learned.synonyms, learned.lemmas)
    heads = missing_heads(read.tree, verbs, counts)
    lost = dict.fromkeys((*missing, *(h for h in heads if not any({*h} <= {*m} for m in missing))))
    unknown = _in_actions(read.tree, lambda one: tuple(w for w in one.words if w not in counts))
    left = (tuple(w for w in words if not any(w in of for of in lost)) for words in unknown)
    return ReadSentence(question, verbs, missing, tuple(lost), tuple(filter(None, left)))


def _picked_words(tree: Node, rng: np.random.Generator, wishes: Sequence[PlaceWish]) -> set[str]:
    """The words of the actions of which an excerpt was picked: no caption needs to say them."""
    if not any(wish.excerpt for wish in wishes):
        return set()
    actions, *_ = plan_sentence(tree, deepcopy(rng))  # the same draws come again
    if len(actions) != len(wishes):
        return set()
    picked = [action for action, wish in zip(actions, wishes) if wish.excerpt]
    return {word for action in picked for word in action.words}


def _as_in_search(groups: Sequence[Sequence[str]]) -> tuple[str, ...]:
    """The directions and sides of limbs of an action, which are measured whatever captions say."""
    return tuple(d for words in groups for d in directions_of(words) if is_as_in_search(d))


def _is_asked(measured: str) -> bool:
    """Whether what is measured is judged although no excerpt does it."""
    return is_as_in_search(measured) or measured in (*EVERY_POSTURE, *HOPS_ON)


def _measured_words(tree: Node, counts: Mapping[str, int], held: Callable[[str], bool]) -> set[str]:
    """Words of the actions that no caption says and that are measured beside known words."""
    measured = set[str]()
    for action in actions_of(tree):
        seen = seen_event(action.words, counts)
        is_alone = is_posture_alone(action.words) or not beside_event(action.words)
        if seen and is_alone and held(seen):
            measured.update(action.words)
            continue
        words = words_of_measured(_as_in_search([action.words])) & MODIFIERS
        words |= {*limb_held(action.words)} if "hop" in action.words else set()
        if any(word in counts for word in action.words if word not in words):
            measured |= words
    return measured - counts.keys()


def _each_word_once(question: Question) -> Question:
    """Drop words of an action that mean the same as another one ("walk on tiptoes")."""

    def once(action: Action) -> Action:
        if hand_at(action.words):  # "the left hand at the left hip"
            return action
        return replace(action, words=tuple(dict.fromkeys(action.words)))

    return replace(question, tree=map_actions(question.tree, once))


def _missing(read: Question, counts: dict[str, int]) -> list[tuple[str, ...]]:
    """Words of the actions without any word of a caption; one known alternative suffices.

    Of a sentence of one action, a known direction or limb makes none of an unknown one: "lie down".
    """

    def missing(action: Action) -> tuple[str, ...]:
        heads = [word for word in action.words if word not in MODIFIERS]
        named = heads if heads and action is core(read.tree) else action.words
        return () if any(word in counts for word in named) else action.words

    return _in_actions(read.tree, missing)


def _in_actions(node: Node, words_of: Callable[[Action], tuple[str, ...]]) -> list[tuple[str, ...]]:
    """The words of every asked action for which there are any, none if an alternative has none."""
    if isinstance(node, Action):
        words = words_of(node)
        return [words] if words else []
    parts = (node.part,) if isinstance(node, Without) else parts_of(node)
    below = [_in_actions(part, words_of) for part in parts]
    if isinstance(node, AnyOf) and not all(below):
        return []
    return [words for part in below for words in part]


def _nothing_shows(missing: Sequence[tuple[str, ...]], learned: Learned) -> str:
    said = ", ".join(repr(" ".join(words)) for words in missing)
    near = [
        near
        for words in missing
        for word in words
        if word not in learned.known_words
        for near in nearest_words(word, learned.known_words)
    ]
    hint = f"Perhaps {' or '.join(dict.fromkeys(near))}. " if near else ""
    return (
        f"generate: expected actions that are in the captions, found {said}, which nothing in the "
        f"database shows. {hint}Say it in other words (`motiondb words` lists them), or pass "
        "--anyway to make the rest."
    )


def _sources(
    learned: Learned, takes: Takes, wanted: _Wanted, anyway: bool, wishes: Sequence[PlaceWish]
) -> list[ActionSources]:
    """The captures that can show each action; a picked one shows it, whatever is written."""
    if not learned.has_words:
        raise QueryError(
            "generate: expected captures with words, found none. Write some down (motiondb words "
            "set) and learn again."
        )
    found: dict[PlannedAction, ActionSources] = {}
    for action in dict.fromkeys(wanted.actions):
        known = any(word in learned.word_numbers for word in action.words)
        of = ActionSources(action, ())
        seen = action.looked_for(learned.word_numbers)
        if seen:
            of = seen_sources(learned, of, seen, takes.held)
        if not of.sources and known:
            of = find_sources(learned, action, wanted.verbs, takes.held)
        found[action] = of
    chosen = []
    for action, wish in zip(wanted.actions, wishes or [PlaceWish()] * len(wanted.actions)):
        of = found[action]
        if not of.sources and wish.excerpt is not None:
            of = picked_source(learned, of, wish.excerpt[0])
        elif not of.sources:
            if not anyway and not _is_from_start(learned, action):
                raise QueryError(_no_source(action))
            of = all_sources(learned, of)
        chosen.append(of)
    return chosen


def _is_held(learned: Learned, takes: Takes, posture: str) -> bool:
    """Whether a recorded capture holds a posture."""
    return any(takes.held(capture, posture) for capture in looked_at(learned))


def _is_from_start(learned: Learned, action: PlannedAction) -> bool:
    """Whether an action is known from a start alone, so that no own caption can hold it."""
    words = {word for group in action.groups for word in group}
    return learned.started is not None and not any(
        words & set(described.words) for described in learned.described
    )


def _no_source(action: PlannedAction) -> str:
    said = " while ".join(" ".join(map(as_said, group)) for group in action.groups)
    without = "".join(f", not {' '.join(words)}" for words in action.excluded)
    parts = [*map(" ".join, action.groups)] if len(action.groups) > 1 else []
    near = f"Each by itself is known: {', '.join(parts)}. " if parts else ""
    seen = " and no capture is seen to do it" * bool(action.posture)
    return (
        f"generate: no caption mentions {said + without!r}{seen}. {near}"
        "Ask for it otherwise, or pass --anyway for the closest motion."
    )


def _from_excerpts(
    learned: Learned,
    wanted: _Wanted,
    sources: Sequence[ActionSources],
    made_of_excerpts: ExcerptMotion,
) -> MadeMotion:
    """A stitched motion with what is to be judged."""
    ends = np.cumsum([0, *made_of_excerpts.made.lengths])
    track = measured_track(made_of_excerpts.made.motion)
    asked, left, symbols, positions = [], [], list[int](), list[int]()
    for n, (of, shown) in enumerate(zip(sources, made_of_excerpts.shown)):
        of_part = track[ends[n] : ends[n + 1]]
        done, unmade = report_excerpt(learned, shown, of_part)
        part = of.action, int(ends[n]), int(ends[n + 1])
        placed = place_probability(learned, shown)
        performer = learned.performers[shown.excerpt.capture]
        name = learned.captures[shown.excerpt.capture].name
        not_done = [*unmade, *miscounted(shown, of_part)]
        as_asked = () if of.is_usual else filter(_is_asked, of.directions)
        measured = tuple(dict.fromkeys((*shown.directions, *as_asked)))
        not_done += [one for one in of.not_used if one.text not in words_of_measured(measured)]
        left += not_done
        named = wanted.actions[n].words
        asked.append(Asked(*part, done, measured, placed, performer, name, tuple(not_done), named))
        inside = segments_of(learned, shown)
        symbols += inside
        positions += [n] * len(inside)
    captures = sorted(set(made_of_excerpts.made.captures.tolist()))
    return MadeMotion(
        made_of_excerpts.made,
        np.array(symbols, dtype=np.int64),
        tuple(positions),
        tuple(of.action.words for of in sources),
        (),
        wanted.question,
        tuple(asked),
        wanted.missing,
        tuple(captures),
        wanted.decided,
        tuple(dict.fromkeys((*wanted.not_used, *left))),
        tuple((shown.place, shown.n_places) for shown in made_of_excerpts.shown),
    )


def _from_symbols(learned: Learned, takes: Takes, wanted: _Wanted) -> MadeMotion:
    """A motion of the HMMs with what is to be judged, and what they cannot do."""
    known = [
        tuple(word for word in action.words if word in learned.word_numbers)
        for action in wanted.actions
    ]
    actions = tuple(words for words in known if words)
    made_of_symbols = symbol_motion(learned, takes, actions)
    lengths = made_of_symbols.made.lengths
    frames = np.bincount(made_of_symbols.positions, weights=lengths).astype(int)
    ends = np.cumsum([0, *frames])
    asked = [
        Asked(action, int(a), int(b), directions=_as_in_search(action.groups))
        for action, a, b in zip(wanted.actions, ends[:-1], ends[1:])
    ]
    left = [one for action in wanted.actions for one in _not_by_symbols(action)]
    return MadeMotion(
        made_of_symbols.made,
        made_of_symbols.symbols,
        made_of_symbols.positions,
        actions,
        made_of_symbols.decodings,
        wanted.question,
        tuple(asked),
        wanted.missing,
        tuple(sorted(made_of_symbols.captures)),
        wanted.decided,
        tuple(dict.fromkeys((*wanted.not_used, *left))),
    )


def judge(
    learned: Learned, takes: Takes, asked_for: MadeMotion, made: SequenceMotion, first: int = 0
) -> JudgedMotion:
    """Say what a motion shows; what it became by a change begins at the frame ``first`` of it."""
    count = made.motion.n_frames
    asked = [
        replace(
            one,
            start=min(max(one.start - first, 0), count),
            end=min(max(one.end - first, 0), count),
        )
        for one in asked_for.asked
    ]
    left = [one for one in asked if one.end > one.start]
    with one_blas_thread():
        bent = np.array([edit.startswith("blend") for edit in made.edits])
        judged = iter(judge_motion(learned, made.motion, left, asked_for.sources, bent))
        recognised = recognise(learned, made.motion).symbols
        smoothness = measure_smoothness(made, takes.motion)
    why = "the cycle that was cut out does not hold it"
    shown = [
        next(judged)
        if one.end > one.start
        else JudgedAction(one.words, 0, 0, False, 0.0, reason=why)
        for one in asked
    ]
    return JudgedMotion(made, (*shown, *asked_for.missing), recognised, smoothness)


def _not_by_symbols(action: PlannedAction) -> list[NotUsed]:
    """What the HMMs cannot do."""
    from motiondb.generate.excerpt_report import say_amounts

    left = [NotUsed(text, "trajectory does not support it") for text in say_amounts(action)]
    why = "trajectory excludes nothing; the result is judged for it"
    return left + [NotUsed(f"not {' '.join(words)}", why) for words in action.excluded]
