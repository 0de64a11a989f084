"""A question in words as a database understands it, before any capture is looked at.

Words that no caption holds are written as known ones, found where they are written, replaced,
measured in the motion, heard by their meaning, or left out
(:mod:`motiondb.search.takings`, :mod:`motiondb.search.asked_words`). If the head of an action stays
unknown, the answers are for the rest alone. Which directions and sides of limbs are measured in the
motion (:mod:`motiondb.search.measured_answers`) is decided here, too.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from itertools import chain, product

from motiondb.errors import UnknownWordsError
from motiondb.language.nearby.table import NearbyTable
from motiondb.language.question.amounts import adverb_of
from motiondb.language.question.readings import (
    Exclusion,
    KnownQuestion,
    Part,
    Reading,
    counted,
    hinted,
    is_order,
    nothing_known,
    plain_actions,
    readings,
    say_count,
    say_duration,
    with_hints,
)
from motiondb.language.question.tree import (
    LIMBS,
    SIDES,
    Action,
    AtOnce,
    Measured,
    Node,
    NotUsed,
    actions_of,
    core,
    is_bare,
    map_actions,
    walk,
)
from motiondb.language.vocabulary import IN_PLACE, MODIFIERS, SINGLE, TRAVELS, as_said
from motiondb.learn.learned import Learned
from motiondb.meaning.aims import aims_of
from motiondb.meaning.amounts import SPEEDS, Degree, degree_of, is_gauged, usual_degree
from motiondb.meaning.direction import vertical_ways
from motiondb.meaning.limb_sides import (
    arm_lowered,
    arm_raised,
    hand_at,
    leg_raised,
    limb_held,
    limbs_to_measure,
)
from motiondb.meaning.occurrences import COUNTED, event_of, seen_event
from motiondb.meaning.postures import (
    OF_POSTURES,
    is_held,
    is_posture_alone,
    posture_of,
    say_posture,
)
from motiondb.meaning.travelled import GOES, LEAST, REST, directions_to_measure
from motiondb.search.asked_times import asked_time
from motiondb.search.asked_words import (
    AskedWords,
    WrittenWord,
    learned_words,
    with_replaced,
    without_words_apart,
    written_words_of,
)
from motiondb.search.measured_amounts import gauged_action
from motiondb.search.said_together import LEAVING, STANDING, searched_together
from motiondb.search.takings import (
    Sentence,
    Taking,
    find_takings,
    hints_of,
    near_sentence,
    not_understood,
    sentence_of,
    unknown_words,
    with_likeliest,
    write_otherwise,
)

_OF_ARMS = frozenset((*SIDES, *LIMBS, "up", "overhead", "down"))  # Words of a moved hand
COUNTED_EVENTS = frozenset((*COUNTED, "spin", "stop", "turn"))
"""Events of which one is told from the next."""


@dataclass(frozen=True, eq=False)
class AskedQuestion:
    """A question in words, as it is understood."""

    text: str  # As it was written
    sentence: Sentence  # With unknown words written as known ones
    asked: AskedWords  # The words that it may use
    known: KnownQuestion  # In known words
    actions: tuple[tuple[str, ...], ...]  # As a plain order of actions; () stands for any action
    not_used: tuple[NotUsed, ...]
    takings: Mapping[str, Taking]  # Of words that no caption holds
    same: Mapping[str, Taking] = field(default_factory=dict)  # Known words, as they were written
    missing: tuple[str, ...] = ()  # Heads of actions that are not understood, as written
    # The rest is empty for a search by symbols
    readings: tuple[Reading, ...] = ()
    only: tuple[str, ...] = ()  # Words, known or not, of the only action; () if there are more
    measured: tuple[str, ...] = ()  # Words that are measured in the motion, not searched
    unmeasured: tuple[str, ...] = ()  # Words that other questions measure and this one does not
    apart: tuple[str, ...] = ()  # What is asked for as one action, and no caption says so
    left: tuple[str, ...] = ()  # Words that are neither searched nor measured
    time: str = ""  # The part of a take in which it asks for its action, as written
    degree: Degree | None = None  # By which measure of the motion the answers are ordered
    is_order: bool = False  # Whether the order is looked for in the frames
    is_measured: bool = False  # Whether something is compared with the motion
    is_seen_alone: bool = False  # Whether it asks for a posture that no caption says

    @property
    def words(self) -> list[str]:
        """The known words that are asked for, each once."""
        actions = actions_of(self.known.tree)
        return list(dict.fromkeys(word for action in actions for word in action.all_words))

    @cached_property
    def compared(self) -> tuple[tuple[tuple[tuple[str, ...], ...], ...], ...]:
        """The actions of every part of every reading, as they are measured."""
        return tuple(
            tuple(actions_of_part(self.asked, part, self.only) for part in reading.parts)
            for reading in self.readings
        )

    @cached_property
    def is_silent(self) -> bool:
        """Whether no answer has a probability, since no own caption has checked the words."""
        unchecked = not self.asked.are_checked(self.readings)
        is_other = self.is_seen_alone or self.names_no_action or self.excludes_limbs
        return is_other or unchecked or bool(self.time)

    @cached_property
    def excludes_limbs(self) -> bool:
        """Whether parts of the body are excluded by themselves: "walk, but not the left hand"."""
        return any(
            is_bare(one) and not LIMBS.isdisjoint(one.words) and not posture_of(one.words)
            for one in self.sentence.excluded
        )

    @cached_property
    def names_no_action(self) -> bool:
        """Whether it names parts of the body and where they are, and nothing that they do.

        What captions say of "hand" and "hip" does not tell whether hands are on the hips.
        """
        asked = actions_of(self.sentence.parsed.tree)
        words = {word for action in asked for word in action.words}
        of_body = MODIFIERS.issuperset(words) and len(words) > 1 and not LIMBS.isdisjoint(words)
        return of_body and not any(action.words in self.sentence.postures for action in asked)

    def is_wordless(self, read: Sequence[Reading]) -> bool:
        """Whether no word of some readings ranks the captures, so that all are looked at."""
        return self.is_seen_alone or not any(part.actions for one in read for part in one.parts)

    @property
    def by_length(self) -> bool:
        """Whether answers are ordered by how long a posture is held, since no word tells more."""
        return self.is_seen_alone and self.readings[0].parts[0].is_seen

    @property
    def sign(self) -> float:
        """1: the more of what was measured, the better; -1: the less; 0: neither."""
        if self.degree is not None:
            return self.degree.sign
        return 1.0 if self.by_length else -1.0 if self.time else 0.0

    @cached_property
    def taken(self) -> dict[str, Taking]:
        """Unknown words for which known ones stand."""
        return {word: taking for word, taking in self.takings.items() if taking.heard}

    def with_near_words(self, table: NearbyTable) -> AskedQuestion | None:
        """The question with near words in place of its own; None if there are none."""
        near = near_sentence(self.sentence, table)
        if near is None:
            return None
        plain = replace(self.asked, heard=None)  # what is said apart depends on the question
        instead = understand(plain, near, self.takings, looks_at_motion=True)
        return replace(instead, text=self.text, same=self.same)


def ask(
    learned: Learned,
    text: str,
    table: NearbyTable,
    find_written: Callable[[], Mapping[str, WrittenWord]],
    exact: bool = False,
    by_symbols: bool = False,
) -> AskedQuestion:
    """Understand a question as ``MotionDB.search`` does."""
    sentence, same = sentence_of(learned, text), dict[str, Taking]()
    if by_symbols:  # captions hold words, not symbols
        takings = unknown_words(sentence, table, is_replaced=not exact)
        question = plain_order(Sentence(with_likeliest(learned, takings), sentence.text), takings)
    else:
        if not exact:
            sentence, same = write_otherwise(sentence, find_written)
        asked = written_words_of(sentence, find_written, None if exact else table)
        sentence = with_found(sentence, table, asked.added)
        takings = unknown_words(sentence, table, asked.added, not exact, by_meaning=not exact)
        takings = without_measured_words(sentence, takings)
        asked = with_replaced(asked, takings)
        question = understand(asked, sentence, takings, looks_at_motion=True)
    shown = question.only if _moves_hands(question.only) else ()  # "put the hands up"
    missing = not_understood(sentence, {*question.asked.added, *question.taken, *shown})
    if missing and MODIFIERS.issuperset(question.words):  # "hand" is no answer to "clap the hands"
        raise UnknownWordsError(nothing_known(text, hints_of(takings)))
    return replace(question, text=text, same=same, missing=missing)


def with_found(sentence: Sentence, table: NearbyTable, added: Collection[str]) -> Sentence:
    """A question that knows which of its words are found as written, or as another name of theirs.

    Who pivots turns, which captions say; a known word for another event replaces none that is seen.
    """
    found = {
        word
        for word, taking in find_takings(sentence, table, added).items()
        if taking.is_taken
        and event_of((word,))
        and event_of((taking.words[0][0],)) == event_of((word,))
    }
    return replace(sentence, found=frozenset((*added, *found)))


def plain_order(sentence: Sentence, takings: Mapping[str, Taking]) -> AskedQuestion:
    """Understand a question as an order of actions, for a search by symbols."""
    hints = hints_of(takings)
    known = with_hints(sentence.in_known_words({}, is_seen=False), hints)
    actions, not_decoded = plain_actions(known.tree)
    unused = hinted((*known.not_used, *not_decoded), hints)
    asked = learned_words(sentence.learned)
    return AskedQuestion(sentence.text, sentence, asked, known, actions, unused, takings)


def understand(
    asked: AskedWords,
    sentence: Sentence,
    takings: Mapping[str, Taking] | None = None,
    looks_at_motion: bool = False,
) -> AskedQuestion:
    """Understand a question in some words.

    `looks_at_motion`: Whether orders and what is measured are looked for in the frames.
    """
    takings = takings or {}
    hints = hints_of(takings)
    known = with_hints(sentence.in_known_words(asked.added, is_seen=looks_at_motion), hints)
    only = _as_measured(asked, only_action(sentence)) if looks_at_motion else ()
    degree = asked_degree(sentence) if looks_at_motion else None
    measured = measured_words(only) & known.unknown.keys()
    if degree is not None:
        known, measured = without_degree(known, degree), measured | degree.words
    leaving = leaving_actions(sentence) if looks_at_motion else frozenset()
    postures = {tuple(w for w in a if not degree or w not in degree.words) for a in sentence.seen}
    known = without_measured(known, measured | (LEAVING if leaving else set()))
    read, not_searched = readings(known.tree)
    is_single = looks_at_motion and len(read) == 1
    unmeasured, apart = tuple[str, ...](), tuple[str, ...]()
    left = tuple(known.unknown)
    if looks_at_motion:
        unmeasured = unmeasured_words(asked, sentence.parsed.tree, read, only)
        searched = searched_together(asked, read, only, leaving, postures, measured_words)
        free = (w for a in postures if not posture_of(a) for w in {*a} - measured_words(a))
        left = (*left, *searched.left, *sorted(MODIFIERS.intersection(free)))
        read, apart = searched.readings, searched.apart
        read = tuple(_with_unseen(counted(one, is_counted), sentence.unseen) for one in read)
        limits = [_measured_limits(asked, part, only) for one in read for part in one.parts]
        met, unmet = (set[str]().union(*of) for of in zip(*limits))
        if any(part.measure and not part.measure.what for one in read for part in one.parts):
            unmet |= {n.measure.say() for n in walk(known.tree) if isinstance(n, Measured)}
        not_searched = tuple(n for n in not_searched if n.text not in met - unmet)
    is_alone = is_single and (is_posture_alone(only) or only in sentence.seen)
    searched_words = {w for action in read[0].parts[0].actions for w in action}
    part = read[0].parts[0]
    is_said = is_alone and searched_words == {*only} and not takings
    is_said = is_said and not (part.seconds or part.longest or is_repeated(part))
    is_said = is_said and (bool(hand_at(only)) or not OF_POSTURES.isdisjoint(only))
    is_seen_alone = is_alone and (only in sentence.seen or not is_said)
    time = asked_time(known, read) if looks_at_motion else ""
    time = "" if degree is not None and degree.measure == "count" else time  # of whole takes
    if is_seen_alone and degree is None and not posture_of(only):
        degree = usual_degree(only)
    seen = (only,) if is_seen_alone else sentence.seen if looks_at_motion else ()
    return AskedQuestion(
        sentence.text,
        sentence,
        without_words_apart(asked, read, sentence.verbs, sentence.phrases),
        known,
        plain_actions(known.tree)[0],
        tuple(
            replace(part, text=as_said(sentence.forms.get(part.text, part.text)))
            for part in hinted((*known.not_used, *not_searched), hints)
            if part.text != time
        ),
        takings,
        readings=read,
        only=only,
        measured=(
            *dict.fromkeys(say_posture(seen_event(a, asked.numbers)) for a in sorted(seen)),
            *sorted(
                "on one leg" if word == SINGLE else as_said(word)
                for word in measured
                if not seen or not posture_of(only)
            ),
            *filter(None, (time,)),
        ),
        unmeasured=unmeasured,
        apart=apart,
        left=left,
        time=time,
        degree=degree,
        is_order=is_single and is_order(read[0]),
        is_measured=looks_at_motion
        and (bool(degree or time) or any(is_measured(asked, one, only) for one in read)),
        is_seen_alone=is_seen_alone,
    )


def understand_learned(learned: Learned, text: str, looks_at_motion: bool = False) -> AskedQuestion:
    """Understand a question in the learned words alone."""
    sentence = sentence_of(learned, text)
    return understand(learned_words(learned), sentence, looks_at_motion=looks_at_motion)


def measured_words(action: Sequence[str]) -> frozenset[str]:
    """The words of an action that are measured.

    >>> sorted(measured_words(("wave", "both", "hand"))), sorted(measured_words(("wave",)))
    (['both', 'hand'], [])
    >>> sorted(measured_words(("sit", "down", "stool")))
    ['down']
    >>> sorted(measured_words(("hop", "left", "foot")))
    ['foot', 'left']
    """
    return _measured_words(tuple(action))


@lru_cache(256)
def _measured_words(action: tuple[str, ...]) -> frozenset[str]:
    limbs = {*chain.from_iterable(limbs_to_measure(action)), *limb_held(action)}
    ends: Collection[str] = {"seat": {"down"}, "rise": {"up"}}.get(event_of(action), set())
    if hand_at(action):
        ends = action
    elif posture_of(action):
        ends = _OF_ARMS.intersection(action) if _moves_hands(action) else {"down", "allfours"}
    return frozenset(
        (*directions_to_measure(action), *aims_of(action), *limbs, *ends, *vertical_ways(action))
    )


def _moves_hands(action: Sequence[str]) -> bool:
    """Whether an action raises or lowers a limb, or holds a hand at a place, which is measured."""
    return any(of(action) is not None for of in (arm_raised, arm_lowered, leg_raised, hand_at))


def asked_degree(sentence: Sentence) -> Degree | None:
    """The degree of the only action of a question, also of one that lasts or is repeated.

    A posture beside it does not count: "the highest jump off the left foot".
    """
    tree = sentence.parsed.tree
    parts = tree.parts if isinstance(tree, AtOnce) else (tree,)
    acting = [a for part in parts if (a := core(part)) is None or not is_posture_alone(a.words)]
    action = acting[0] if len(acting) == 1 else core(tree)
    degree = None if action is None else degree_of(action.all_words)
    if action is not None and degree is not None and degree.measure == "limbs":
        degree = None if sentence.is_said(action.all_words) else degree  # "quick stop"
    measures = [one.measure for one in walk(sentence.parsed.tree) if isinstance(one, Measured)]
    if action is None or degree is None or not any(is_gauged(m, action.words) for m in measures):
        return degree
    return replace(degree, sign=0.0)  # as much as is asked for, not as much as possible


def without_degree(question: KnownQuestion, degree: Degree) -> KnownQuestion:
    """A question without the words that say how fast, high or far."""

    def plain(action: Action) -> Action:
        words = tuple(word for word in action.words if word not in degree.words)
        manner = () if degree.measure in SPEEDS else action.manner
        manner = tuple(one for one in manner if one not in degree.words)
        return Action(words, manner) if words else action

    plain_question = replace(question, tree=map_actions(question.tree, plain))
    return without_measured(plain_question, set(map(adverb_of, degree.words)))


def is_counted(part: Part) -> bool:
    """Whether the repeats of a part are counted in the motion."""
    said = part.said or part.actions
    if len(said) == 1 and posture_of(said[0]):
        return True
    is_one = len(part.actions) < 2 and len(said) == 1
    return is_one and event_of((part.actions or said)[0]) in COUNTED_EVENTS


def _measured_limits(
    asked: AskedWords, part: Part, only: tuple[str, ...]
) -> tuple[set[str], set[str]]:
    """The upper limits and measures of a part that are measured, and that are not, as said."""
    limits: tuple[set[str], set[str]] = (set(), set())
    said = part.said or part.actions
    if part.measure is not None:
        is_measured = bool(gauged_action(part, actions_of_part(asked, part, only)))
        limits[not is_measured].add(part.measure.say())
    if part.most is not None:
        limits[not is_counted(part)].add(say_count(0, part.most))
    if part.longest is not None:
        lasts = bool(said) and lasts_going(part, said[0])
        limits[not lasts].add(say_duration(0.0, part.longest))
    return limits


def _with_unseen(reading: Reading, postures: Collection[tuple[str, ...]]) -> Reading:
    """A reading whose excluded postures are looked for in the motion alone."""
    unseen = tuple(e for e in reading.exclusions if not set(e.actions).isdisjoint(postures))
    kept = tuple(e for e in reading.exclusions if e not in unseen)
    return replace(reading, exclusions=kept, unseen=unseen) if unseen else reading


def only_action(sentence: Sentence) -> tuple[str, ...]:
    """The words, known or not, of a question of one action; () if it asks for more.

    The action may have a count or a duration: "walk in place for 5 seconds".
    """
    action = core(sentence.parsed.tree)
    return action.words if action is not None else ()


def without_measured_words(sentence: Sentence, takings: Mapping[str, Taking]) -> dict[str, Taking]:
    """Replacements of unknown words, but of no direction that is measured as it is written."""
    heard = {word: taking.heard[0] for word, taking in takings.items() if taking.heard}
    words = only_action(sentence)
    measured = measured_words([w if w in LEAST else heard.get(w, w) for w in words])
    degree = asked_degree(sentence)
    measured |= set() if degree is None else degree.words
    measured |= LEAVING if leaving_actions(sentence) else set()
    if not words:
        every = (action.words for action in actions_of(sentence.parsed.tree))
        measured |= set().union(*map(directions_to_measure, every))
    kept = {word: taking for word, taking in takings.items() if word not in measured}
    return kept if kept or not sentence.known.isdisjoint(words) else dict(takings)


def leaving_actions(sentence: Sentence) -> frozenset[tuple[str, ...]]:
    """The actions of a question that leave, without the word that says so ("walk away")."""
    every = [action.words for action in actions_of(sentence.parsed.tree)]
    leave = [a for a in every if LEAVING.intersection(a) and TRAVELS.intersection(a)]
    return frozenset(tuple(word for word in action if word not in LEAVING) for action in leave)


def without_measured(question: KnownQuestion, words: Collection[str]) -> KnownQuestion:
    """A question whose unknown words are used where they are measured."""
    return replace(
        question,
        unknown={word: near for word, near in question.unknown.items() if word not in words},
        not_used=tuple(left for left in question.not_used if left.text not in words),
    )


def actions_of_part(
    asked: AskedWords, part: Part, only: tuple[str, ...]
) -> tuple[tuple[str, ...], ...]:
    """The actions of a part, of which the only one of a question has its unknown words.

    Words that known ones replace are the likeliest of these: "scuttle backward" is measured as
    "walk backward".
    """
    is_one = only and part.actions and len(part.said) < 2  # "sit drink" is two
    actions = (only,) if is_one else part.said or part.actions
    return tuple(_as_measured(asked, action) for action in actions)


def _as_measured(asked: AskedWords, action: Sequence[str]) -> tuple[str, ...]:
    """An action as it is measured: what is not, in the likeliest words that replace its own."""
    if is_posture_alone(action):
        return tuple(action)
    return tuple(w if w in LEAST or event_of((w,)) else asked.likeliest(w) for w in action)


def is_measured(asked: AskedWords, reading: Reading, only: tuple[str, ...]) -> bool:
    """Whether a reading, or the only action of a question, names what is measured."""
    compared = _compared(asked, reading, only)
    if any(measured_words(one) or asked.sure_event(one) for one in compared):
        return True
    return (
        bool(reading.unseen)
        or any(map(excluded_event, reading.exclusions))
        or any(
            is_repeated(part)
            or part.is_seen
            or bool(gauged_action(part, actions_of_part(asked, part, only)))
            or any(lasts_going(part, action) for action in actions_of_part(asked, part, only))
            or any(
                {*action} <= STANDING
                or is_posture_alone(action)
                or seen_event(action, asked.numbers)
                for action in part.said
            )
            for part in reading.parts
        )
    )


def excluded_event(exclusion: Exclusion) -> str:
    """The event that must not be seen; "" where directions say more, or it is not one action."""
    if len(exclusion.actions) != 1 or directions_to_measure(exclusion.actions[0]):
        return ""
    (action,) = exclusion.actions
    return "move" if action == ("move",) else event_of(action)


def is_repeated(part: Part) -> bool:
    """Whether a part asks how often an event occurs, which is counted."""
    return is_counted(part) and (part.least > 1 or part.most is not None)


def lasts_going(part: Part, action: Sequence[str]) -> bool:
    """Whether a part asks how long one action travels, rests or is held: it is measured."""
    travels = not GOES.isdisjoint(action) and IN_PLACE not in action
    asks = part.seconds > 0.0 or part.longest is not None
    rests = bool(REST.intersection(action)) or is_held(event_of(action))
    return asks and len(part.actions or part.said) == 1 and (travels or rests)


def unmeasured_words(
    asked: AskedWords, tree: Node, read: Sequence[Reading], only: tuple[str, ...]
) -> tuple[str, ...]:
    """The words of a question that other questions measure and this one does not.

    Those of several actions if no caption holds them. `tree`: That of the question with its
    unknown words; `read`: Its readings, in known words.
    """
    actions = [_as_measured(asked, action.words) for action in actions_of(tree)]
    compared = [action for reading in read for action in _compared(asked, reading, only)]
    left = set().union(*map(measured_words, actions)).difference(*map(measured_words, compared))
    return tuple(dict.fromkeys(word for action in actions for word in action if word in left))


def _compared(
    asked_words: AskedWords, reading: Reading, only: tuple[str, ...]
) -> list[tuple[str, ...]]:
    """The actions of a reading that are compared with the motion, the excluded ones last."""
    asked = [
        action for part in reading.parts for action in actions_of_part(asked_words, part, only)
    ]
    excluded = [action for each in reading.exclusions for action in each.actions]
    without = [excluded_words(a, e) for a, e in product(asked, excluded) if MODIFIERS.issuperset(e)]
    return [*asked, *without]


def excluded_words(action: Sequence[str], excluded: Sequence[str]) -> tuple[str, ...]:
    """The words of "wave the hand, but not the left" that exclude something, as one action.

    >>> excluded_words(("wave", "right", "hand"), ("left",))
    ('wave', 'left', 'hand')
    >>> excluded_words(("walk", "left"), ("backward",))
    ('walk', 'backward')
    """
    verbs = [word for word in action if word not in MODIFIERS]
    limbs = [word for word in action if word in LIMBS]
    return (*verbs, *excluded, *(limbs[:1] if excluded[-1] in SIDES else ()))
