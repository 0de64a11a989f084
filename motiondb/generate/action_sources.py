"""Which captures can show a planned action, and how well each of their segments does.

A capture can show an action if one of its captions says the words of the action together. Notation,
for segment i of such a capture:

    y_i   probability that the words are shown at the segment, by the order of the caption
          (:mod:`motiondb.meaning.place_fitting`); the least over the words,
    e_i   evidence for them in the motion, nats a second: the mean of that by the map of all other
          takes and that by the map of other performers, where these show the words too,
    q_i   how much more the captures that move most like it say the words than others,
    r_i   how much more evidence a map of whole captions has for the words than for others, nats a
          second (both: :mod:`motiondb.generate.competing_words`),
    x_i   the largest evidence for an excluded action,
    u     number of words of the captions besides those of the action and of those beside it,
    d     distance of posture and travel from those of the other sources, in standard deviations,
    a     largest unlikelihood of a segment of the capture among all motion, nats a frame.

The value of a segment is

    v_i = log max(y_i, Y) + E e_i + N q_i + R r_i - X max(x_i, 0),

and the cost of a capture U u + D d^2 + A max(a - a0, 0), where a0 is the least median of a over the
captures of a performer, or RARE where that is more. So a bar, a motorcycle, a dance or a
somersault is used for a plain word only where no plain capture shows it, and the standing before a
jump is not used as the jump.

Words of direction ("sit down") may be said by no caption. They are left out of the words and kept
as what is measured in the motion (:mod:`motiondb.meaning.direction`). The side of a limb or of a
jump ("wave with the left hand", "jump to the left") is measured whatever captions say, because few
say it; those that do cost less. A direction that nearly all captions say with the action belongs to
it: where they say "stand up", "stand" goes up.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, islice, pairwise, product

import numpy as np

from motiondb.generate.competing_words import (
    LEAST_CAPTURES,
    neighbour_gains,
    rival_gain,
)
from motiondb.generate.sentence_plan import PlannedAction
from motiondb.language.question.heads import heads_of
from motiondb.language.question.tree import LIMBS, SIDES, NotUsed
from motiondb.language.vocabulary import IN_A_CIRCLE, MODIFIERS, as_said
from motiondb.learn.learned import Learned
from motiondb.meaning.direction import (
    ALOFT,
    OCCURRING,
    PLAIN_TURNS,
    VERTICAL,
    directions_of,
    words_of_measured,
)
from motiondb.meaning.limb_sides import limb_held, limbs_to_measure
from motiondb.meaning.postures import EVERY_POSTURE, is_posture_alone, posture_of
from motiondb.records import Float32Array, FloatArray, IntArray
from motiondb.search.by_words import SEEN_ALONE
from motiondb.search.said_together import STANDING
from motiondb.symbols.hmm_jobs import one_blas_thread

LEAST_SHOWN = 0.1
"""Y: a place that the caption's order rules out can still be overruled by the motion. With .02 it
could not: in long captures y is mostly 0 or 1, and often wrong."""
EVIDENCE_WEIGHT = 0.25
"""E: one nat a second of evidence, over a segment of about two seconds that is not independent of
its neighbours."""
EXCLUDED_WEIGHT = 0.5  # X: twice E, because an exclusion is meant strictly
LEAST_EVIDENCE = 1.0
"""Evidence in nats a second below which the motion does not determine the place."""
MOST_EVIDENCE = 16.0  # Evidence above which a segment is not valued higher, nats a second
UNASKED_WEIGHT = 0.7  # U; .35 makes no difference to how many excerpts the judge finds right
MOST_UNASKED = 6  # Number of further words above which the cost of a caption no longer rises
APART = 1.0  # Cost of a caption that says the words in different actions ("walk, veer left")
SPEED_SAID = 1.0  # Gain of a capture whose caption says the speed asked for
USUAL = 0.7
"""Share of the captures of an action whose captions say a direction with it, from which on the
direction belongs to it."""
USUAL_DIRECTIONS = (*VERTICAL, "forward", "backward", "sideways", "left", "right")
"""Directions that may belong to an action; "bend back" goes nowhere."""
MOST_WORDS = 8  # Words of an action of which all parts are tried; further ones are left out
DIRECTIONS = SIDES | {
    "up",
    "down",
    "forward",
    "backward",
    "back",
    "around",
    "over",
    "under",
    "sideways",
    "away",
    "off",
    "out",
    "in",
    "on",
    "straight",
    IN_A_CIRCLE,
}
"""Words of direction: if no caption has them, they are left out before other words."""
NEIGHBOUR_WEIGHT = 1.0  # N
RIVAL_WEIGHT = 0.5
"""R. Of 0, .25, .5 and 1, on the best excerpts of 36 actions of CMU: the judge finds the asked
action before all others in .35, .37, .42, .42 (at N = 1; with R = .5 and N = 0 in .37)."""
MOST_COMPARED = 100
"""Number of sources, the best without q and r, for which q and r are computed: more take longer."""
MOST_SOURCES = 300
"""Number of captures that are sources of an action, those whose captions fit it best; by hand. In a
large database more of them take longer."""
UNLIKE_WEIGHT = 0.4  # D
RARE_WEIGHT = 0.12
"""A. Plain kicks and twists win with it against those of an acrobat; .08 to .16 make little
difference to how many excerpts the judge finds right (.61 to .64 of 36 actions of CMU)."""
HELD_WEIGHT = 4.0
"""Value of a segment throughout which a posture is held, nats: one that holds it for less is grown
into only where it holds it for three quarters (``excerpts.DROP``). By hand."""
LONGEST_EVENT = 90  # Frames (3 s) of a squat or another event that no caption says
RARE = 60.0
"""Nats a frame. On CMU the median over the captures of a performer is 30 to 60 in walking,
exercises and karate, 64 in ballet, 132 in acrobatics."""


@dataclass(frozen=True, eq=False)
class Source:
    """A capture that can show an action."""

    capture: int
    rows: slice  # Its rows of the segment table
    starts: IntArray  # (segments,): first frames, at 30 frames a second
    ends: IntArray  # (segments,): last frames + 1
    values: FloatArray  # (segments,): v
    cost: float  # Cost of the module's docstring, and further costs
    is_placed: bool = True  # Whether the motion says where in the capture the action is
    # Words that its captions say in one action with those of the action
    beside: frozenset[int] = frozenset()


@dataclass(frozen=True, eq=False)
class ActionSources:
    """The sources of one action."""

    # The action, without the words that no caption says together with the others
    action: PlannedAction
    sources: tuple[Source, ...]  # At least one, unless nothing shows the action
    not_used: tuple[NotUsed, ...] = ()  # Words that were left out
    # What is measured of the action as it was asked for, or the directions that belong to it
    directions: tuple[str, ...] = ()
    is_usual: bool = False  # Whether these belong to the action, and were not asked for


def find_sources(
    learned: Learned,
    action: PlannedAction,
    verbs: Collection[str],
    held: Callable[[int, str], Sequence[tuple[int, int]]] = lambda *_: (),
) -> ActionSources:
    """Find the captures that can show an action of a sentence with these verbs.

    `held`: The times for which a capture holds a posture; of those that can show what is done in
    it, these come first.
    """
    listed = learned.listed_actions
    groups, left_out, measured = [], [], set[str]()
    searched = [group for group in action.groups if not _is_meanwhile(group)] or action.groups
    directions = tuple(
        d
        for group in action.groups
        for d in (directions_of(group) if group in searched else (_held_by(group),))
    )
    poses = [_held_by(group) for group in action.groups if group not in searched]
    for asked in searched:
        group = _without_measured(asked)
        measured.update(set(asked) - set(group))
        kept = _said_together(listed, group, learned, verbs)
        left_out += [
            NotUsed(word, f"no caption says it together with {' '.join(kept)!r}")
            for word in group
            if word not in kept
        ]
        groups.append(kept)
    action = replace(action, groups=tuple(dict.fromkeys(groups)))
    sides = _free_sides(learned, [word for group in action.groups for word in group])
    words, beside = _numbers(learned, action.words), _numbers(learned, sorted(measured))
    numbers, costs = [_numbers(learned, group) for group in action.groups], dict[int, float]()
    for capture, actions in listed.items():
        apart = _cost_of_saying(actions, numbers, sides)
        if apart is not None and not _says_excluded(learned, actions, action):
            apart += _cost_of_measured(actions, words, beside)
            costs[capture] = apart + _cost_of_further(learned, actions, action)
    posed = {c: cost for c, cost in costs.items() if all(held(c, pose) for pose in poses)}
    joined = _of_saying_joined(learned, posed or costs, action)
    sources_found = [
        _source(learned, capture, listed[capture], action, costs[capture])
        for capture in _least_costly(joined, learned.performers)
    ]
    sources_found = _against_rivals(learned, _with_rarity(learned, sources_found), words)
    sources = tuple(_with_distance(learned, sources_found))
    usual = () if directions else usual_directions(learned.word_numbers, sources)
    return ActionSources(action, sources, tuple(left_out), directions or usual, bool(usual))


def _is_meanwhile(group: Sequence[str]) -> bool:
    """Whether words name a posture that is measured while something else is done."""
    return {*group} <= STANDING or is_posture_alone(group)


def _held_by(group: Sequence[str]) -> str:
    """The posture of :func:`_is_meanwhile`; who stands still and does something moves an arm.

    >>> _held_by(("stand", "still")), _held_by(("sit",)), _held_by(("raise", "both", "arm"))
    ('stand', 'sit', 'raise both')
    """
    if {*group} <= STANDING:
        return "sit" if "sit" in group else "stand"
    return posture_of(group)


def _of_saying_joined(
    learned: Learned, costs: Mapping[int, float], action: PlannedAction
) -> Mapping[int, float]:
    """The sources that also say what "and" joins with a turn beside it; all if there are none.

    "Run and veer left" is not a walk that veers left. `costs`: Of the sources, by capture.
    """
    joined = (*action.words, *action.beside)
    if not action.beside or {*PLAIN_TURNS}.isdisjoint(joined):
        return costs
    every, listed = _numbers(learned, joined), learned.listed_actions
    saying = {c: cost for c, cost in costs.items() if _say_together(listed[c], every)}
    return saying or costs


def _say_together(actions: Sequence[frozenset[int]], words: frozenset[int]) -> bool:
    """Whether an action, or two that follow one another, say all of some words.

    >>> run, left, kick = frozenset({1}), frozenset({2}), frozenset({3})
    >>> _say_together([run, left], run | left), _say_together([run, kick, left], run | left)
    (True, False)
    """
    return any(words <= one | after for one, after in pairwise((*actions, frozenset[int]())))


def usual_directions(word_numbers: Mapping[str, int], sources: Sequence[Source]) -> tuple[str, ...]:
    """Directions that at least ``USUAL`` of the sources say in one action with the asked words."""
    fewest = max(USUAL * len(sources), 1.0)
    numbers = {d: word_numbers.get(d, -1) for d in USUAL_DIRECTIONS}
    said = {d: sum(number in s.beside for s in sources) for d, number in numbers.items()}
    return tuple(d for d, count in said.items() if count >= fewest)


def _numbers(learned: Learned, words: Sequence[str]) -> frozenset[int]:
    return frozenset(learned.word_numbers[w] for w in words if w in learned.word_numbers)


def _without_measured(group: tuple[str, ...]) -> tuple[str, ...]:
    """A group of words without the sides that are measured of its limbs and jumps, if any are left.

    >>> _without_measured(("wave", "left", "hand")), _without_measured(("wave", "hand"))
    (('wave',), ('wave', 'hand'))
    >>> _without_measured(("jump", "left")), _without_measured(("hop", "left", "leg"))
    (('jump',), ('hop',))
    """
    measured = {word for pair in limbs_to_measure(group) for word in pair}
    measured |= {*limb_held(group)} if "hop" in group else set()
    if not {*ALOFT, *OCCURRING}.isdisjoint(group):
        measured |= SIDES.intersection(directions_of(group))
    return tuple(word for word in group if word not in measured) or group


def _cost_of_measured(
    actions: Sequence[frozenset[int]], asked: frozenset[int], measured: frozenset[int]
) -> float:
    """Cost of captions that do not say the measured sides with the action, less for each said.

    >>> _cost_of_measured([frozenset((1, 2)), frozenset((3,))], frozenset((1,)), frozenset((2,)))
    -0.7
    """
    together = any(asked | measured <= one for one in actions)
    said = measured & frozenset().union(*actions)
    return APART * (not together) - UNASKED_WEIGHT * len(said)


def _said_together(
    listed: Mapping[int, Sequence[frozenset[int]]],
    group: tuple[str, ...],
    learned: Learned,
    verbs: Collection[str],
) -> tuple[str, ...]:
    """The largest part of a group of words, with its first head, that some caption says together.

    Of parts of equal size, the one without words of direction is preferred, then the one whose
    words come first. A side may occur in another action of the caption ("walk, veer left"), but the
    side of a limb is not kept without the limb: "kick with the left foot" does not ask for a turn
    left.
    """
    group = group[:MOST_WORDS]
    has_limb = bool(LIMBS.intersection(group))
    heads = heads_of(group, verbs)[:1]
    sides = _free_sides(learned, group)
    for size in range(len(group), 0, -1):
        parts = sorted(
            combinations(range(len(group)), size),
            key=lambda part: sum(group[k] in DIRECTIONS for k in part),
        )
        for part in parts:
            words = tuple(group[k] for k in part)
            if not {*heads} <= {*words}:
                continue
            if has_limb and SIDES.intersection(words) and not LIMBS & {*words}:
                continue
            numbers = [_numbers(learned, words)]
            if any(_cost_of_saying(said, numbers, sides) is not None for said in listed.values()):
                return words
    return heads or group[:1]


def _free_sides(learned: Learned, words: Sequence[str]) -> frozenset[int]:
    """Sides that may occur in another action of a caption; none where words name a limb."""
    return frozenset() if LIMBS.intersection(words) else _numbers(learned, sorted(SIDES))


def _cost_of_saying(
    actions: Sequence[frozenset[int]], groups: Sequence[frozenset[int]], sides: frozenset[int]
) -> float | None:
    """Cost of captions that name every group in one action; None if a group is not named.

    Sides may occur in another action than the rest of their group.
    """
    cost = 0.0
    everything = frozenset().union(*actions)
    for group in groups:
        rest = group - sides
        if any(group <= said for said in actions):
            continue
        if not rest or not group & sides <= everything:
            return None
        if not any(rest <= said for said in actions):
            return None
        cost += APART
    return cost


def _says_excluded(
    learned: Learned, actions: Sequence[frozenset[int]], action: PlannedAction
) -> bool:
    """Whether captions say all words of something that is excluded."""
    excluded = [_numbers(learned, words) for words in action.excluded]
    return any(words and words <= said for words in excluded for said in actions)


def _cost_of_further(
    learned: Learned, actions: Sequence[frozenset[int]], action: PlannedAction
) -> float:
    """Cost of what captions say besides the words of an action."""
    every = frozenset[int]().union(*(_numbers(learned, group) for group in action.groups))
    all_said, beside = frozenset[int]().union(*actions), _numbers(learned, action.beside)
    cost = UNASKED_WEIGHT * min(len(all_said - every - beside), MOST_UNASKED)
    if action.speed and all_said & _speed_words(learned, action.speed):
        cost -= SPEED_SAID
    return cost


def _least_costly(costs: Mapping[int, float], performers: Mapping[int, str]) -> list[int]:
    """The ``MOST_SOURCES`` captures of least cost, as evenly of all performers as ties allow."""
    of: dict[str, int] = {}
    turns = {}
    for capture in costs:
        turns[capture] = of[performers[capture]] = of.get(performers[capture], -1) + 1
    order = sorted(costs, key=lambda capture: (costs[capture], turns[capture], capture))
    return sorted(order[:MOST_SOURCES])


def _source(
    learned: Learned,
    capture: int,
    actions: Sequence[frozenset[int]],
    action: PlannedAction,
    cost: float,
) -> Source:
    """A source with its values; `cost`: of its captions."""
    rows = learned.rows[capture]
    starts, ends = learned.segments.starts[rows], learned.segments.ends[rows]
    asked = [sorted(known) for group in action.groups if (known := _numbers(learned, group))]
    shown = _shown(learned, capture, len(starts), len(actions), asked)
    values = np.log(np.maximum(shown, LEAST_SHOWN))
    evidence = _evidence(learned, capture, {word for words in asked for word in words})
    is_placed = True
    if evidence is not None:
        said = np.min([evidence[:, words].mean(axis=1) for words in asked], axis=0)
        is_placed = bool(np.abs(said).max() >= LEAST_EVIDENCE)
        values = values + EVIDENCE_WEIGHT * np.clip(said, -MOST_EVIDENCE, MOST_EVIDENCE)
        for words in filter(None, (sorted(_numbers(learned, e)) for e in action.excluded)):
            unwanted = np.maximum(evidence[:, words].mean(axis=1), 0.0)
            values = values - EXCLUDED_WEIGHT * unwanted
    every = {word for words in asked for word in words}
    same = frozenset().union(*(said for said in actions if every <= said)) - every
    return Source(capture, rows, starts, ends, values, cost, is_placed, same)


def _speed_words(learned: Learned, speed: str) -> frozenset[int]:
    from motiondb.language.question.amounts import forms_of_manner

    return _numbers(learned, forms_of_manner(speed))


def _shown(
    learned: Learned, capture: int, n_segments: int, n_actions: int, asked: Sequence[Sequence[int]]
) -> FloatArray:
    """y of the module's docstring: array (segments,); equal shares where no place was learned."""
    places = learned.places
    listed = () if places is None else places.words.get(capture, ())
    shown = np.full(n_segments, 1.0)
    for word in {word for words in asked for word in words}:
        if places is not None and word in listed:
            column = places.shown[capture][:, listed.index(word)]
        else:
            column = np.full(n_segments, 1.0 / n_actions)
        shown = np.minimum(shown, column)
    return shown


def _evidence(learned: Learned, capture: int, asked: set[int]) -> FloatArray | None:
    """Evidence (segments, words) by other takes and other performers; None without any."""
    placed = learned.placed
    take = None if placed is None else placed.take(capture)
    if placed is None or take is None:
        seen = learned.evidence.by_motion.takes
        return seen[capture].windows if capture in seen else None
    evidence = take.windows.copy()
    by_others = placed.by_others(capture)
    if by_others is not None:
        performer = learned.performers[capture]
        others = [words for name, words in placed.listed_by.items() if name != performer]
        columns = sorted(word for word in asked if any(word in words for words in others))
        evidence[:, columns] = (evidence[:, columns] + by_others[:, columns]) / 2.0
    said = learned.said_places.get(capture)
    return evidence if said is None else evidence + said


def all_sources(learned: Learned, of: ActionSources) -> ActionSources:
    """Every recorded capture as a source, by the evidence of its motion: for ``--anyway``."""
    sources = [
        _source(learned, capture, [frozenset()], of.action, 0.0)
        for capture in learned.rows
        if learned.captures[capture].kind == "captured"
    ]
    return replace(of, sources=tuple(sources))


def looked_at(learned: Learned) -> Iterator[int]:
    """The recorded captures in which a posture is looked for."""
    recorded = (c for c in learned.rows if learned.captures[c].kind == "captured")
    return islice(recorded, SEEN_ALONE)


def seen_sources(
    learned: Learned,
    of: ActionSources,
    posture: str,
    held: Callable[[int, str], Sequence[tuple[int, int]]],
) -> ActionSources:
    """The recorded captures that hold a posture, or show an event, whatever captions say.

    `held`: The first frames and last frames + 1 of the times for which a capture holds a posture.
    """
    sources, posed = [], of.action.posed
    rests = [group[0] for group in of.action.groups if group not in posed]
    for capture in looked_at(learned):
        times, rows = held(capture, posture), learned.rows[capture]
        if posture not in EVERY_POSTURE:
            times = [(start, end) for start, end in times if end - start <= LONGEST_EVENT]
        for rest in rests:
            pairs = product(times, held(capture, rest))
            both = ((max(a, c), min(b, d)) for (a, b), (c, d) in pairs)
            times = [(start, end) for start, end in both if start < end]
        starts, ends = learned.segments.starts[rows], learned.segments.ends[rows]
        shares = np.zeros(len(starts))
        for start, end in times:
            inside = np.minimum(ends, end) - np.maximum(starts, start)
            shares += np.maximum(inside, 0) / (ends - starts)
        if times:
            cost = HELD_WEIGHT * all(start == 0 for start, _ in times)  # nobody is seen to take it
            sources.append(Source(capture, rows, starts, ends, HELD_WEIGHT * shares, cost))
    usual = tuple(_with_rarity(learned, sources))
    action = replace(of.action, groups=posed)
    ways = () if of.action.posture else directions_of(of.action.words)
    held_too = (posture, *rests) if posture in EVERY_POSTURE else ()
    directions = (*ways, *held_too)
    told = MODIFIERS.intersection(of.action.words) - words_of_measured(directions) - {"up", "down"}
    told = frozenset() if of.action.posture else told.difference(limb_held(of.action.words))
    left = tuple(NotUsed(as_said(word), "it is not measured") for word in sorted(told))
    return replace(of, action=action, sources=usual, directions=directions, not_used=left)


def picked_source(learned: Learned, of: ActionSources, capture: int) -> ActionSources:
    """A capture as the only source, whatever its captions say: one that somebody picked."""
    if _numbers(learned, of.action.words):
        source = _source(learned, capture, [frozenset()], of.action, 0.0)
    else:
        rows = learned.rows[capture]
        segments = learned.segments.starts[rows], learned.segments.ends[rows]
        source = Source(capture, rows, *segments, np.zeros(len(segments[0])), 0.0, False)
    return replace(of, sources=(source,))


def _with_rarity(learned: Learned, sources: Sequence[Source]) -> list[Source]:
    """Add the cost of motion that is rarer than another performer's motion for the action."""
    rare = {s.capture: float(-learned.segments.backgrounds[s.rows].min()) for s in sources}
    of: dict[str, list[float]] = {}
    for capture, value in rare.items():
        of.setdefault(learned.performers[capture], []).append(value)
    usual = max(RARE, min((float(np.median(v)) for v in of.values()), default=RARE))
    return [
        replace(s, cost=s.cost + RARE_WEIGHT * max(rare[s.capture] - usual, 0.0)) for s in sources
    ]


def _against_rivals(
    learned: Learned, sources: Sequence[Source], words: frozenset[int]
) -> list[Source]:
    """Add N q + R r; sources that are not compared get the least that another one got."""
    order = sorted(range(len(sources)), key=lambda n: sources[n].cost - _peak(sources[n]))
    if not order:
        return []
    others = learned.described_segments
    known = {int(w) for w in np.flatnonzero((others.says > 0.0).sum(axis=0) >= LEAST_CAPTURES)}
    compared = order[:MOST_COMPARED]
    takes = {sources[n].capture: learned.segment_rows[sources[n].rows] for n in compared}
    with one_blas_thread():  # the matrices are too small to gain from two
        alike = neighbour_gains(others, takes, words)
    gains = {}
    for n in compared:
        capture = sources[n].capture
        gains[n] = NEIGHBOUR_WEIGHT * alike[capture]
        evidence = None if learned.unplaced is None else learned.unplaced.get(capture)
        if evidence is not None and words:
            rivals = known - words - sources[n].beside
            gains[n] = gains[n] + RIVAL_WEIGHT * rival_gain(evidence, words, rivals)
    least = np.float64(min(float(gain.min()) for gain in gains.values()))
    return [replace(s, values=s.values + gains.get(n, least)) for n, s in enumerate(sources)]


def _with_distance(learned: Learned, sources: Sequence[Source]) -> list[Source]:
    """Add the cost of posture and travel that are unlike those of the other sources."""
    if learned.n_posture_and_travel == 0 or len(sources) < 3:
        return list(sources)
    peaks = np.stack(
        [_weighted(learned.bearing[s.rows], s.values, s.ends - s.starts) for s in sources]
    )
    gain = np.array([_peak(s) - s.cost for s in sources])
    weight = np.exp(np.maximum(gain - gain.max(), -20.0))
    total = weight.sum() - weight  # of the others
    centre = (weight @ peaks - weight[:, None] * peaks) / np.maximum(total, 1e-9)[:, None]
    centre[total < 1e-6] = peaks[total < 1e-6]
    distance = np.mean((peaks - centre) ** 2, axis=1)
    return [replace(s, cost=s.cost + UNLIKE_WEIGHT * float(d)) for s, d in zip(sources, distance)]


def _weighted(columns: Float32Array, values: FloatArray, frames: IntArray) -> FloatArray:
    """Mean of columns over the segments of largest value: array (columns,)."""
    weight = frames * np.exp(values - values.max())
    return np.asarray(weight @ columns / weight.sum())


def _peak(source: Source) -> float:
    return float(source.values.max())
