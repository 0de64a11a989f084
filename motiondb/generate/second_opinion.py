"""Whether any motion shows a sentence: where each action would be, and what the judge says of it.

A motion that was made here has a plan; one from elsewhere has none. Its actions are looked for:

* one action in the whole motion, and in the part of it that shows the action most clearly;
* several actions where the evidence of the frames lays them in order
  (:mod:`motiondb.meaning.edge_map`), as a search does; if that order is not seen, in the first
  other one that is.

Each is then judged as generated motion is (:mod:`motiondb.generate.shown_actions`), with what is
counted and measured there. Of alternatives ("walk or run") the best one counts. An order is right
if it is seen, wrong if all actions are shown in another one, and otherwise not sure.

>>> verdict([True, True], in_order=None), verdict([True, None], None), verdict([True, True], False)
(True, None, False)
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import permutations, product

import numpy as np

from motiondb.body.features import FEATURE_STEP, recognition_features
from motiondb.body.retarget import motion_positions
from motiondb.errors import QueryError
from motiondb.generate.excerpt_motion import joint_speeds
from motiondb.generate.excerpt_report import (
    compare_speed,
    gauged_otherwise,
    held_otherwise,
    is_within_count,
)
from motiondb.generate.excerpts import counted_word, occurrences_each
from motiondb.generate.material import Takes
from motiondb.generate.motion_making import read_sentence
from motiondb.generate.sentence_plan import PlannedAction, is_within, plan_sentence, say_times
from motiondb.generate.shown_actions import Asked, JudgedAction, judge_motion
from motiondb.language.question.readings import (
    KnownQuestion,
    readings,
    reason_unknown,
    say,
    say_duration,
)
from motiondb.language.question.tree import (
    Action,
    AnyOf,
    Anything,
    InOrder,
    Lasting,
    Measured,
    Node,
    NotUsed,
    Repeated,
    Without,
    walk,
)
from motiondb.language.vocabulary import IN_PLACE
from motiondb.learn.learned import Learned
from motiondb.meaning.direction import (
    REACHED,
    VERTICAL,
    directions_of,
    gone,
    gone_anywhere,
    progress,
)
from motiondb.meaning.edge_map import averaged, frame_cues, lay_in_order, refine_interval
from motiondb.meaning.motion_judge import WINDOW
from motiondb.meaning.occurrences import COUNTED, find_occurrences, measured_track
from motiondb.records import MOTION_FPS, FloatArray, Motion
from motiondb.search.placing import NARROW
from motiondb.symbols.hmm_jobs import one_blas_thread

MOST_IN_ANY_ORDER = 4  # Actions of which all 24 orders are tried
MOST_COMPARED = 30  # Captures whose speeds say what is slow and fast for an action
Span = tuple[int, int]


@dataclass(frozen=True)
class Opinion:
    """What a motion shows of a sentence."""

    shown: bool | None  # The sentence as a whole; None: not sure
    actions: tuple[JudgedAction, ...]  # In the order of the sentence
    in_order: bool | None  # None: no order is asked for, or it cannot be told
    question: KnownQuestion
    not_used: tuple[NotUsed, ...]
    chosen: str  # Of alternatives the one that the verdict is about; "" without any
    against: str  # What of the order is not as asked, or not sure


def verdict(
    shown: Sequence[bool | None], in_order: bool | None, is_ordered: bool = False
) -> bool | None:
    """The verdict on a sentence, from those on its actions and on their order."""
    if False in shown or in_order is False:
        return False
    return None if None in shown or (is_ordered and in_order is None) else True


def judge_sentence(
    learned: Learned,
    takes: Takes,
    motion: Motion,
    text: str,
    sources: Sequence[int],
    rng: np.random.Generator,
) -> Opinion:
    """Judge any motion by a sentence, without the captures ``sources`` that it comes from.

    Nothing depends on ``rng``: a plan draws alternatives, and here each is judged.
    """
    read = read_sentence(learned, text)
    readings(read.question.tree)  # refuses more alternatives and parts than a search takes
    unread = [
        JudgedAction(words, 0, 0, None, reason=reason_unknown(()))
        for words in (*read.lost, *read.left_over)
    ]
    trees = list(alternatives(read.question.tree))
    with one_blas_thread():
        seen = _Seen.of(learned, takes, motion, sources)
        opinions = [_judge_tree(seen, tree, read.question, unread, rng) for tree in trees]
    best = max(opinions, key=lambda each: _rank(each.shown))
    return best if len(trees) > 1 else replace(best, chosen="")


def alternatives(node: Node) -> Iterator[Node]:
    """The trees of which each asks for one of the alternatives; exclusions keep theirs.

    >>> walks, runs, sits = Action(("walk",)), Action(("run",)), Action(("sit",))
    >>> [say(tree) for tree in alternatives(InOrder((AnyOf((walks, runs)), sits)))]
    ['walk, then sit', 'run, then sit']
    """
    match node:
        case Action() | Anything():
            yield node
        case AnyOf():
            for part in node.parts:
                yield from alternatives(part)
        case Without() | Repeated() | Lasting() | Measured():
            yield from (replace(node, part=part) for part in alternatives(node.part))
        case _:
            for parts in product(*map(alternatives, node.parts)):
                yield replace(node, parts=parts)


def _rank(shown: bool | None) -> int:
    return {False: 0, None: 1, True: 2}[shown]


@dataclass(frozen=True, eq=False)
class _Seen:
    """A motion as it is looked at."""

    learned: Learned
    takes: Takes
    motion: Motion
    sources: Sequence[int]
    track: FloatArray  # (frames, 22): ``measured_track``
    cues: FloatArray  # (feature frames, cues): of the evidence of frames

    @classmethod
    def of(cls, learned: Learned, takes: Takes, motion: Motion, sources: Sequence[int]) -> _Seen:
        frames = learned.feature_space.project(recognition_features(motion))
        return cls(learned, takes, motion, sources, measured_track(motion), frame_cues(frames))

    @cached_property
    def poses(self) -> FloatArray:
        """Joints relative to the pelvis: array (frames, 63), m."""
        positions = motion_positions(self.motion)[0]
        return np.asarray((positions - positions[:, :1]).reshape(len(positions), -1))

    def judge(self, asked: Iterable[Asked]) -> tuple[JudgedAction, ...]:
        return judge_motion(self.learned, self.motion, list(asked), self.sources)


def _judge_tree(
    seen: _Seen,
    tree: Node,
    question: KnownQuestion,
    unread: Sequence[JudgedAction],
    rng: np.random.Generator,
) -> Opinion:
    """The opinion on a tree without alternatives."""
    actions, _, left = plan_sentence(tree, rng)
    if not actions:
        raise QueryError(
            f"judge: expected an action, found only what not to show in {question.text!r}. "
            "Say what the motion should show."
        )
    left = tuple(
        replace(one, reason="it may be anything") if one.text == "?" else one for one in left
    )
    is_ordered = len(actions) > 1 and any(isinstance(node, InOrder) for node in walk(tree))
    order: tuple[int, ...] | None = None
    if len(actions) == 1:
        shown = [_judge_one(seen, actions[0])]
    else:
        order, spans = _lay_out(seen, actions)
        shown = _judge_parts(seen, actions, spans)
    as_asked = order == tuple(range(len(actions)))
    of_actions = [one.shown for one in shown]
    told = order is not None and (all(of_actions) or (as_asked and False not in of_actions))
    in_order = as_asked if is_ordered and told else None
    shown += unread
    whole = verdict([one.shown for one in shown], in_order, is_ordered)
    why = "the order is not seen" if whole is None and is_ordered and in_order is None else ""
    if in_order is False:
        seen_order = (" ".join(actions[k].words) for k in order or ())
        why = f"not in this order: seen are {', then '.join(seen_order)}"
    not_used = (*question.not_used, *left)
    return Opinion(whole, tuple(shown), in_order, question, not_used, say(tree), why)


def _judge_one(seen: _Seen, action: PlannedAction) -> JudgedAction:
    """The better verdict on the whole motion and on the part that shows an action most clearly."""
    n, evidence = len(seen.track), _evidence(seen, action)
    spans = [(0, n)]
    if evidence is not None and not action.excluded:
        first, behind = refine_interval(evidence, (0, len(evidence)), (0, len(evidence)))
        if behind - first <= NARROW * len(evidence):
            spans += _widened([(FEATURE_STEP * first, min(FEATURE_STEP * behind, n))], n)
    judged = seen.judge(_asked(seen, action, span, seen.track) for span in spans)
    return max(judged, key=lambda one: _rank(one.shown))


def _judge_parts(
    seen: _Seen, actions: Sequence[PlannedAction], spans: Sequence[Span] | None
) -> list[JudgedAction]:
    """The verdict on each action in its part; of the whole motion where there are no parts."""
    n = len(seen.track)
    wholes = seen.judge(_asked(seen, action, (0, n)) for action in actions)
    if spans is None:
        return list(wholes)
    parts = seen.judge(_asked(seen, action, span) for action, span in zip(actions, spans))
    why = "the motion shows it, but not where it would be beside the others"
    return [
        replace(part, shown=None, probability=None, reason=why)
        if part.shown is False and whole.shown
        else part
        for part, whole in zip(parts, wholes)
    ]


def _lay_out(
    seen: _Seen, actions: Sequence[PlannedAction]
) -> tuple[tuple[int, ...] | None, list[Span] | None]:
    """The first order in which the actions are seen, as asked if possible, and their parts."""
    found = [_evidence(seen, action) for action in actions]
    known = [each for each in found if each is not None]
    if len(known) < len(found):
        return None, None
    evidence, n = averaged(np.stack(known)), len(seen.track)
    numbers = tuple(range(len(actions)))
    for order in permutations(numbers) if len(numbers) <= MOST_IN_ANY_ORDER else [numbers]:
        laid = lay_in_order(evidence[list(order)], (0, evidence.shape[1]))
        if laid is not None and laid.is_seen:
            spans = [(FEATURE_STEP * a, min(FEATURE_STEP * b, n)) for a, b in laid.spans]
            of_each = dict(zip(order, _widened(spans, n)))
            return order, [of_each[k] for k in numbers]
    return None, None


def _widened(spans: Sequence[Span], n: int) -> list[Span]:
    """Spans that grow to the length of a window of the judge, none into the next one.

    >>> _widened([(10, 20), (60, 200)], 220)
    [(0, 60), (60, 200)]
    """
    wide, ends = [], [0, *(end for _, end in spans)]
    starts = [*(start for start, _ in spans), n]
    for k, (start, end) in enumerate(spans):
        lack = max(WINDOW * FEATURE_STEP - (end - start), 0)
        low = max(start - lack // 2, ends[k])
        high = min(end + lack - (start - low), starts[k + 1])
        low = max(min(low, high - WINDOW * FEATURE_STEP), ends[k]) if lack else low
        wide.append((low, high))
    return wide


def _evidence(seen: _Seen, action: PlannedAction) -> FloatArray | None:
    """Evidence of an action at every feature frame: array (feature frames,); None without any.

    What is counted, else what was learned of the words' places, else what is measured.
    """
    word, n = counted_word(action), len(seen.cues)
    if word and (times := find_occurrences(seen.track, word)):
        counted = np.zeros(n)
        for start, end in times:
            counted[start // FEATURE_STEP : -(-end // FEATURE_STEP)] = 1.0
        return counted
    edges, placed = seen.learned.edges, seen.learned.placed
    numbers = [seen.learned.word_numbers.get(word, -1) for word in action.words]
    words = [number for number in numbers if placed is not None and number in placed.words]
    if edges is not None and words:
        return edges.of_cues(seen.cues, words)
    measured = [d for group in action.groups for d in directions_of(group) if d != IN_PLACE]
    if not measured:
        return None
    way = progress(seen.track, measured[0])
    return np.maximum(np.diff(way[::FEATURE_STEP], prepend=way[0]), 0.0)[:n]


def _asked(
    seen: _Seen, action: PlannedAction, span: Span, counted: FloatArray | None = None
) -> Asked:
    """A part of the motion with what is counted and measured; `counted`: another track to count."""
    part = seen.track[slice(*span)]
    done, left = list[str](), held_otherwise(action, part)
    if action.times is not None and not action.posture:
        word, text = counted_word(action), say_times(action.times)
        found = find_occurrences(part if counted is None else counted, word) if word else []
        poses = seen.poses[slice(*span)] if counted is None else seen.poses
        count = len(found) / occurrences_each(action, poses, found)
        if not word:
            left.append(NotUsed(text, f"only {', '.join(COUNTED)} are counted"))
        elif is_within_count(count, action.times):
            done.append(f"{text}: {count:g} measured in the motion")
        else:
            left.append(NotUsed(text, f"{count:g} measured in the motion"))
    if action.seconds is not None and not action.posture:
        text, seconds = (
            say_duration(action.seconds.least, action.seconds.most),
            len(part) / MOTION_FPS,
        )
        if is_within(seconds, action.seconds):
            done.append(f"{text}: {seconds:.1f} s")
        else:
            left.append(NotUsed(text, f"it lasts {seconds:.1f} s"))
    gauged, not_met = gauged_otherwise(action, part)
    done, left = done + gauged, left + not_met
    if action.speed:
        said, not_said = compare_speed(action.speed, "as it is", _speeds(seen, action, span))
        done, left = done + said, left + not_said
    every = dict.fromkeys(d for group in action.groups for d in directions_of(group))
    directions = tuple(d for d in every if not _is_taken_back(part, d))
    return Asked(action, *span, tuple(done), directions, not_done=tuple(left))


def _is_taken_back(track: FloatArray, measured: str) -> bool:
    """Whether somebody stands up, sits down, stops or starts within a part, but not at its end.

    Parts of a planned motion end with that; elsewhere it says nothing against the action.
    """
    if measured not in (*VERTICAL, "stop", "start") or gone(track, measured) >= REACHED:
        return False
    return gone_anywhere(track, measured) >= REACHED


def _speeds(seen: _Seen, action: PlannedAction, span: Span) -> tuple[float, float, float] | None:
    """Mean speed of the joints in a part, and the least and largest of captures of the action."""
    words = {word for word in action.words if word in seen.learned.word_numbers}
    saying = [d.capture_id for d in seen.learned.described if words <= set(d.words)]
    captures = [c for c in dict.fromkeys(saying) if c not in seen.sources]
    some = captures[:: -(-len(captures) // MOST_COMPARED) or 1]
    if not words or len(some) < 2:
        return None
    speeds = [float(joint_speeds(seen.takes.motion(capture)).mean()) for capture in some]
    return float(joint_speeds(seen.motion)[slice(*span)].mean()), min(speeds), max(speeds)
