"""A question's tree as flat readings, for a search along the time of a capture.

A reading is an order of parts; a part is the actions of one interval; an exclusion lists actions
that must not occur from one part to another. A tree has several readings where it leaves a choice:

* ``AnyOf``: those of every alternative.
* ``Both``: all parts at once, or in the order in which they are written.

The manner of an action is treated as a simultaneous action: a capture must show both. A part at
once with an order holds for every part of the order. A part that is requested three times becomes
three parts in order, which together make one statement. Parts that a search cannot use are removed
and listed: durations of whole orders, and the order, count and duration of exclusions. Upper limits
of counts and durations are listed, too: a search that measures them says so.

A question is also reduced to the words that captions have (:func:`hold_to_known`), and said in one
line, which is itself a question with the same tree (:func:`say`).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, product
from math import prod
from typing import NoReturn

from motiondb.errors import QueryError, UnknownWordsError
from motiondb.language.question.amounts import (
    Measure,
    adverb_of,
    known_manner,
    manner_of,
    match_number,
)
from motiondb.language.question.tokens import match_connective
from motiondb.language.question.tree import (
    Action,
    AmountNode,
    AnyOf,
    Anything,
    AtOnce,
    Both,
    InOrder,
    Lasting,
    Measured,
    Node,
    NotUsed,
    Question,
    Repeated,
    Without,
    any_of,
    join,
    walk,
    without,
)
from motiondb.language.vocabulary import (
    LEAST_OFTEN,
    MODIFIERS,
    MOST_OFTEN,
    as_said,
    nearest_words,
    nothing_known,
    say_perhaps,
)

_PLACES = MODIFIERS | {"floor", "ground", "wall", "air", "room"}
MOST_READINGS = 64  # Largest number of readings of a question: each is searched in every capture
MOST_PARTS = 128  # Largest number of parts of a reading, counting repeats


@dataclass(frozen=True)
class Part:
    """The actions of one interval."""

    actions: tuple[tuple[str, ...], ...]  # Words of every action, all at once; none for anything
    seconds: float = 0.0  # Least length of the interval
    repeat_of: int = 0  # Number of the first equal part, for repeats; its own number otherwise
    longest: float | None = None  # Most seconds of the interval; None: no upper limit
    least: int = 1  # Repeats that are counted within the part (:func:`counted`)
    most: int | None = None  # Most repeats; None: no upper limit
    # The actions with the words that are measured in place of searched; () where there are none
    said: tuple[tuple[str, ...], ...] = ()
    measure: Measure | None = None  # How far, how fast or by which angle

    @property
    def is_seen(self) -> bool:
        """Whether it is measured alone, as it is that somebody leaves ("walk away") or kneels."""
        return bool(self.said) and not self.actions


@dataclass(frozen=True)
class Exclusion:
    """Actions that must not all be seen in the parts [first, last)."""

    actions: tuple[tuple[str, ...], ...]
    first: int
    last: int
    later: bool = False  # Whether they must not be seen afterwards, either


@dataclass(frozen=True)
class Reading:
    """Parts in order, with exclusions."""

    parts: tuple[Part, ...]
    exclusions: tuple[Exclusion, ...] = ()
    unseen: tuple[Exclusion, ...] = ()  # Postures that must not be seen, which are not searched


def readings(tree: Node) -> tuple[tuple[Reading, ...], tuple[NotUsed, ...]]:
    """The readings of a tree, and its unused parts.

    >>> walk, run, sit = (Action((word,)) for word in ("walk", "run", "sit"))
    >>> found, _ = readings(Without(InOrder((walk, AnyOf((run, sit)))), (Action(("jump",)),)))
    >>> [[part.actions for part in reading.parts] for reading in found]
    [[(('walk',),), (('run',),)], [(('walk',),), (('sit',),)]]
    >>> found[0].exclusions
    (Exclusion(actions=(('jump',),), first=0, last=2, later=False),)
    """
    not_used: list[NotUsed] = []
    read = _read(tree, not_used)
    unique = tuple(dict.fromkeys(read))
    return unique, tuple(dict.fromkeys(not_used))


def _read(node: Node, not_used: list[NotUsed]) -> list[Reading]:
    """The readings of a node; unused parts are added to the list."""
    match node:
        case Action():
            manners = [(manner,) for manner in node.manner]
            return [Reading((Part(tuple(a for a in (node.words, *manners) if a)),))]
        case Anything():
            return [Reading((Part(()),))]
        case Without():
            excluded = [e for one in node.excluded for e in _excluded(one, not_used)]
            read = _read(node.part, not_used)
            parts = [_without(reading, excluded, node.later) for reading in read]
        case Repeated():
            if node.most is not None:
                reason = f"{_UNCHECKED}; captures with at least {max(node.least, 1)} are shown"
                not_used.append(NotUsed(say_count(0, node.most), reason))
            parts = [_repeat(r, max(node.least, 1), node.most) for r in _read(node.part, not_used)]
        case Lasting():
            parts = [_lasting(r, node, not_used) for r in _read(node.part, not_used)]
        case Measured():
            not_used.append(NotUsed(node.measure.say(), _UNMEASURED))
            parts = [_measured(r, node.measure) for r in _read(node.part, not_used)]
        case _:
            parts = _read_joined(node, not_used)
    return _limited(parts)


def _read_joined(node: InOrder | AtOnce | Both | AnyOf, not_used: list[NotUsed]) -> list[Reading]:
    """The readings of a node that joins parts."""
    each = [_read(part, not_used) for part in node.parts]
    if isinstance(node, AnyOf):
        return [reading for read in each for reading in read]
    if isinstance(node, InOrder):
        return _products(each, _in_order)
    if isinstance(node, Both):
        return [*_products(each, _at_once), *_products(each, _in_order)]
    if len({len(reading.parts) for read in each for reading in read} - {1}) > 1:
        reason = "orders of different lengths are searched one after the other"
        not_used.append(NotUsed(say(node), reason))
    return _products(each, _at_once)


def _limited(alternatives: list[Reading]) -> list[Reading]:
    if len(alternatives) > MOST_READINGS:
        _refuse("alternatives", len(alternatives), MOST_READINGS)
    longest = max(len(reading.parts) for reading in alternatives)
    if longest > MOST_PARTS:
        _refuse("actions in order", longest, MOST_PARTS)
    return alternatives


def _products(
    each: Sequence[list[Reading]], combine: Callable[[Sequence[Reading]], Reading]
) -> list[Reading]:
    """Every choice of one reading a part, combined."""
    number = prod(len(read) for read in each)
    if number > MOST_READINGS:
        _refuse("alternatives", number, MOST_READINGS)
    return [combine(choice) for choice in product(*each)]


def _in_order(choice: Sequence[Reading]) -> Reading:
    """Readings one after the other."""
    parts: list[Part] = []
    exclusions: list[Exclusion] = []
    for reading in choice:
        n = len(parts)
        parts += [replace(part, repeat_of=part.repeat_of + n) for part in reading.parts]
        exclusions += [replace(e, first=e.first + n, last=e.last + n) for e in reading.exclusions]
    return Reading(tuple(parts), tuple(exclusions))


def _at_once(choice: Sequence[Reading]) -> Reading:
    """Readings in the same intervals; single parts hold for every part of an order.

    Orders of different lengths cannot be overlaid: the shorter ones follow.
    """
    longest = max(choice, key=lambda reading: len(reading.parts))
    n = len(longest.parts)
    over = [reading for reading in choice if len(reading.parts) in (1, n)]
    parts = []
    for k, part in enumerate(longest.parts):
        same = [reading.parts[k if len(reading.parts) == n else 0] for reading in over]
        actions = dict.fromkeys(action for each in same for action in each.actions)
        seconds = max(each.seconds for each in same)
        measures = [each.measure for each in same if each.measure]
        measure = replace(measures[0], what="") if measures[1:] else next(iter(measures), None)
        parts.append(replace(part, actions=tuple(actions), seconds=seconds, measure=measure))
    exclusions = [
        e if len(reading.parts) == n else replace(e, first=0, last=n)
        for reading in over
        for e in reading.exclusions
    ]
    behind = [reading for reading in choice if len(reading.parts) not in (1, n)]
    return _in_order([Reading(tuple(parts), tuple(exclusions)), *behind])


def _without(
    reading: Reading, excluded: Sequence[tuple[tuple[str, ...], ...]], later: bool
) -> Reading:
    """A reading whose parts exclude these actions."""
    added = tuple(Exclusion(actions, 0, len(reading.parts), later) for actions in excluded)
    return replace(reading, exclusions=(*reading.exclusions, *added))


def _excluded(node: Node, not_used: list[NotUsed]) -> list[tuple[tuple[str, ...], ...]]:
    """Sets of actions that must not all be seen."""
    inside = list(walk(node))
    for part in inside:
        if isinstance(part, InOrder):
            not_used.append(NotUsed(f"the order of {say(part)}", _NOT_EXCLUDED))
        elif isinstance(part, (Repeated, Lasting, Measured)):
            not_used.append(NotUsed(_say_amount(part), _NOT_EXCLUDED))
        elif isinstance(part, Without):
            not_used.append(NotUsed(f"not {say(part.excluded[0])}", _NOT_EXCLUDED))
    sets = []
    for reading in _read(node, []):
        actions = dict.fromkeys(action for part in reading.parts for action in part.actions)
        if actions:
            sets.append(tuple(actions))
    return list(dict.fromkeys(sets))


_NOT_EXCLUDED = "exclusions apply in any order, number and duration"
_UNCHECKED = "it cannot be checked"
_UNMEASURED = "measured are angles of turns, and ways, speeds and steps of who goes or jumps"


def counted(reading: Reading, is_counted: Callable[[Part], bool]) -> Reading:
    """A reading in which repeats that are counted in the motion are one part.

    >>> jump, walk = (("jump",),), (("walk",),)
    >>> found = counted(Reading((Part(walk), Part(jump, 0.0, 1), Part(jump, 0.0, 1))), bool)
    >>> [(part.actions, part.repeat_of, part.least) for part in found.parts]
    [((('walk',),), 0, 1), ((('jump',),), 1, 2)]
    >>> twice = Reading((Part(jump), Part(walk, 0.0, 1), Part(jump), Part(walk, 0.0, 1)))
    >>> counted(twice, bool) == twice  # what is repeated is the order
    True
    """
    dropped = {
        k
        for k, part in enumerate(reading.parts)
        if k and part.repeat_of == reading.parts[k - 1].repeat_of and is_counted(part)
    }
    kept = [k for k in range(len(reading.parts)) if k not in dropped]
    number = {k: sum(one <= k for one in kept) - 1 for k in range(len(reading.parts))}
    parts = tuple(
        replace(
            reading.parts[k],
            repeat_of=number[reading.parts[k].repeat_of],
            least=after - k,
        )
        for k, after in zip(kept, [*kept[1:], len(reading.parts)])
    )

    def moved(exclusions: Sequence[Exclusion]) -> tuple[Exclusion, ...]:
        now = (replace(e, first=number[e.first], last=number[e.last - 1] + 1) for e in exclusions)
        return tuple(dict.fromkeys(now))

    return Reading(parts, moved(reading.exclusions), moved(reading.unseen))


def _repeat(reading: Reading, times: int, most: int | None) -> Reading:
    """A reading several times, its parts one statement each."""
    n = len(reading.parts)
    if n == 1:
        reading = replace(reading, parts=(replace(reading.parts[0], most=most),))
    if n * times > MOST_PARTS:
        _refuse("actions in order", n * times, MOST_PARTS)
    exclusions = [
        replace(e, first=e.first + k * n, last=e.last + k * n)
        for k in range(times)
        for e in reading.exclusions
    ]
    return Reading(reading.parts * times, tuple(exclusions))


def _lasting(reading: Reading, node: Lasting, not_used: list[NotUsed]) -> Reading:
    """A reading whose single part lasts."""
    if len(reading.parts) > 1:
        reason = "durations are searched for single actions only"
        not_used.append(NotUsed(say_duration(node.least, node.most), reason))
        return reading
    if node.most is not None:
        is_exact = node.least == node.most  # part of a longer one lasts as long
        reason = ("" if is_exact else f"{_UNCHECKED}; ") + "longer ones are shown, too"
        not_used.append(NotUsed(say_duration(0.0, node.most), reason))
    part, longest = reading.parts[0], None if node.least == node.most else node.most
    lasting = replace(part, seconds=max(part.seconds, node.least), longest=longest)
    return replace(reading, parts=(lasting,))


def _measured(reading: Reading, measure: Measure) -> Reading:
    """A reading whose single part is as far or as fast as measured."""
    first = replace(reading.parts[0], measure=measure)
    return reading if reading.parts[1:] else replace(reading, parts=(first,))


def _refuse(what: str, number: int, most: int) -> NoReturn:
    raise QueryError(
        f"question: expected at most {most} {what}, found {number:,}. Ask for fewer at a time."
    )


@dataclass(frozen=True)
class KnownQuestion:
    """A question in known words.

    Attributes
    ----------
    text : str
        As it was written.
    tree : Node
        Of known words; an action of which no word is known is left out. A manner is the word that
        captions use for it.
    unknown : mapping of str to tuple of str
        For each unknown word, the nearest known words, best first.
    not_used : tuple of NotUsed
        Parts of the question that are not in the tree, unknown words included.
    """

    text: str
    tree: Node
    unknown: Mapping[str, tuple[str, ...]]
    not_used: tuple[NotUsed, ...]

    @property
    def words(self) -> tuple[str, ...]:
        """Known words that are requested or excluded, from the left, each once."""
        actions = (node for node in walk(self.tree) if isinstance(node, Action))
        return tuple(dict.fromkeys(word for action in actions for word in action.all_words))

    @property
    def understood(self) -> str:
        """How the question is understood, as one line that is itself a question."""
        return say(self.tree)


def is_order(reading: Reading) -> bool:
    """Whether a reading asks for several actions, each different from the one before."""
    of_parts = [part.actions for part in reading.parts]
    return len(of_parts) > 1 and all(a != b for a, b in pairwise(of_parts))


def hold_to_known(
    question: Question,
    counts: Mapping[str, int],
    seen: Collection[tuple[str, ...]] = (),
    measured: Callable[[Sequence[str]], Collection[str]] | None = None,
) -> KnownQuestion:
    """Remove the words that no caption has from a question, and list them.

    Of one action among others, a direction or place alone is not left: "back" of "puts it back".
    `seen`: Actions that stay as they are, since they are measured. `measured`: The words of an
    action that are, and stay where another word of it is known.

    >>> from motiondb.language.question.parse import parse
    >>> known = hold_to_known(parse("wlak slowly, not moonwalk, sit"), {"sit": 3, "walk": 4})
    >>> known.understood, known.unknown
    ('sit', {'wlak': ('walk',), 'slowly': (), 'moonwalk': ('walk',)})
    """
    unknown, not_used = dict[str, tuple[str, ...]](), list(question.not_used)

    def known(action: Action, is_asked: bool = True) -> Action | None:
        if action.words in seen:
            return action
        is_heard = is_asked and not counts.keys().isdisjoint(action.words)
        kept = measured(action.words) if is_heard and measured is not None else ()
        words, manners = tuple(word for word in action.words if word in counts or word in kept), []
        for word in action.words:
            if word not in words and word not in unknown:
                unknown[word] = nearest_words(word, counts)
        is_lost = not MODIFIERS.issuperset(action.words) and _PLACES.issuperset(words)
        if is_lost and action is not question.tree:
            not_used.extend(NotUsed(word, "its action is not known") for word in words)
            words = ()
        for manner in action.manner:
            said = known_manner(manner, counts)
            if said is None:
                unknown.setdefault(adverb_of(manner), ())
            elif words or not action.words:
                manners.append(said)
            else:
                not_used.append(NotUsed(adverb_of(manner), "its action is not known"))
        return Action(words, tuple(manners)) if words or manners else None

    tree = _hold(question.tree, known)
    not_used += [NotUsed(word, reason_unknown(near, word)) for word, near in unknown.items()]
    if tree is None or not any(isinstance(node, Action) for node in walk(tree)):
        raise UnknownWordsError(nothing_known(question.text, unknown))
    return KnownQuestion(question.text, tree, unknown, tuple(not_used))


def reason_unknown(near: tuple[str, ...], word: str = "") -> str:
    """Why an unknown word is not used, with the known words that may be meant."""
    if word in (MOST_OFTEN, LEAST_OFTEN):
        return "takes are ordered by number only for one action that is counted, of any side"
    return f"not in the captions{say_perhaps(near)}"


def with_hints(question: KnownQuestion, hints: Mapping[str, tuple[str, ...]]) -> KnownQuestion:
    """A question whose unknown words have other hints than the known words of like spelling."""
    return replace(
        question,
        unknown={word: hints.get(word, near) for word, near in question.unknown.items()},
        not_used=hinted(question.not_used, hints),
    )


def hinted(
    not_used: Sequence[NotUsed], hints: Mapping[str, tuple[str, ...]]
) -> tuple[NotUsed, ...]:
    """Parts that are not used, with other hints for unknown words; see :func:`with_hints`."""
    return tuple(
        NotUsed(left.text, reason_unknown(hints[left.text], left.text))
        if left.text in hints
        else left
        for left in not_used
    )


def _hold(
    node: Node, known: Callable[[Action, bool], Action | None], is_asked: bool = True
) -> Node | None:
    """A tree with ``known`` applied to every action, asked for or not; None removes the action."""
    match node:
        case Action():
            return known(node, is_asked)
        case Anything():
            return node
        case Without():
            part = _hold(node.part, known, is_asked)
            kept = [e for one in node.excluded if (e := _hold(one, known, False)) is not None]
            if not kept:
                return part
            return without(Anything() if part is None else part, kept, node.later)
        case Repeated() | Lasting() | Measured():
            part = _hold(node.part, known, is_asked)
            return None if part is None else replace(node, part=part)
        case _:
            kept = [p for part in node.parts if (p := _hold(part, known, is_asked)) is not None]
            return join(type(node), kept) if kept else None


def say(node: Node) -> str:
    """One line for a tree.

    >>> walk, run, sit = (Action((word,)) for word in ("walk", "run", "sit"))
    >>> say(Without(InOrder((walk, AnyOf((run, Repeated(sit, 2, None))))), (Action(("wave",)),)))
    'walk, then (run or (sit at least 2 times)), not wave'
    """
    match node:
        case Action(words, manner):
            return " ".join((*map(as_said, _quoted(words)), *map(adverb_of, manner)))
        case Anything():
            return "?"
        case InOrder(parts):
            return ", then ".join(_inside(part) for part in parts)
        case AtOnce(parts):
            return " while ".join(map(_inside, parts))
        case Both(parts):
            return " and ".join(_inside(part) for part in parts)
        case AnyOf(parts):
            return (" or " if any_of(parts) == node else ", or ").join(map(_inside, parts))
        case Without(part, excluded, later):
            kept = [] if isinstance(part, Anything) else [_before_exclusion(part)]
            said = ", ".join([*kept, *(f"not {_inside(one)}" for one in excluded)])
            return f"{said} afterwards" if later else said
        case _:
            return f"{_inside(node.part)} {_say_amount(node)}"


def _say_amount(node: AmountNode) -> str:
    """How often, how long or how far."""
    match node:
        case Repeated():
            return say_count(node.least, node.most)
        case Lasting():
            return say_duration(node.least, node.most)
        case Measured():
            return node.measure.say()


def _quoted(words: Sequence[str]) -> Sequence[str]:
    """Words, in quotation marks where one of them would be read as something else."""
    if any(match_connective(w, 0) or match_number(w) or manner_of(w) for w in words):
        return [f'"{" ".join(words)}"']
    return words


def say_count(least: int, most: int | None) -> str:
    """A number of repeats.

    >>> say_count(3, 3), say_count(1, 1), say_count(0, 2), say_count(2, 4)
    ('3 times', 'once', 'at most 2 times', '2 to 4 times')
    """
    if most is None:
        return f"at least {least} times"
    if least == most:
        return "once" if least == 1 else f"{least} times"
    return f"{least} to {most} times" if least > 0 else f"at most {most} times"


def say_duration(least: float, most: float | None) -> str:
    """A length of time.

    >>> say_duration(10.0, 10.0), say_duration(5.0, None), say_duration(0.0, 2.5)
    ('for 10 s', 'for at least 5 s', 'for at most 2.5 s')
    """
    if most is None:
        return f"for at least {least:.10g} s"
    if least == most:
        return f"for {least:.10g} s"
    return f"for {least:.10g} to {most:.10g} s" if least > 0 else f"for at most {most:.10g} s"


def _inside(node: Node) -> str:
    """A node as a part of another one."""
    text = say(node)
    return text if isinstance(node, (Action, Anything)) else f"({text})"


def _before_exclusion(node: Node) -> str:
    """The base of an exclusion: an order needs no parentheses there."""
    return say(node) if isinstance(node, InOrder) else _inside(node)


def plain_actions(tree: Node) -> tuple[tuple[tuple[str, ...], ...], tuple[NotUsed, ...]]:
    """The actions of a tree in order, () for anything; and the unused parts of the tree.

    Generation and the search by symbols decode words in order. Of alternatives they use the first;
    simultaneous actions become one.

    >>> walk, run, sit = (Action((word,)) for word in ("walk", "run", "sit"))
    >>> plain_actions(Without(AnyOf((walk, run)), (sit,)))[1]
    (NotUsed(text='not sit', reason='nothing can be excluded'), NotUsed(text='or run', \
reason='only the first alternative is used'))
    """
    left: list[NotUsed] = []
    return tuple(_plain(tree, left)), tuple(dict.fromkeys(left))


_NOT_SET: dict[type, str] = {
    Repeated: "it is used once",
    Lasting: "no duration can be set",
    Measured: "no angle, way or speed can be set",
}


def _plain(node: Node, left: list[NotUsed]) -> list[tuple[str, ...]]:
    match node:
        case Action():
            return [node.all_words]
        case Anything():
            return [()]
        case AnyOf():
            left += [
                NotUsed(f"or {say(p)}", "only the first alternative is used")
                for p in node.parts[1:]
            ]
            return _plain(node.parts[0], left)
        case Without():
            left += [NotUsed(f"not {say(one)}", "nothing can be excluded") for one in node.excluded]
            return _plain(node.part, left)
        case Repeated() | Lasting() | Measured():
            left.append(NotUsed(_say_amount(node), _NOT_SET[type(node)]))
            return _plain(node.part, left)
        case AtOnce():
            words = [
                word for part in node.parts for action in _plain(part, left) for word in action
            ]
            return [tuple(words)]
        case _:
            return [action for part in node.parts for action in _plain(part, left)]
