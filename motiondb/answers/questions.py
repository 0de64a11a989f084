"""Answers to questions: how a question was understood, matches with reasons, descriptions."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import zip_longest
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from motiondb.answers.database import WordProbability
from motiondb.answers.plain import OPTIONAL, extended
from motiondb.language.question import tree
from motiondb.language.question.tree import NotUsed
from motiondb.language.translation.decoding import Decoding
from motiondb.language.vocabulary import as_said
from motiondb.records import Match
from motiondb.search.chances import WordSource
from motiondb.search.reasons import Explanation
from motiondb.tabled import Tabled

if TYPE_CHECKING:
    from motiondb.language.question.readings import KnownQuestion
    from motiondb.search.by_example import ExampleAnswer
    from motiondb.search.by_words import WordAnswer
    from motiondb.search.described import Description
    from motiondb.search.takings import Taking


@dataclass(frozen=True)
class DescribedWord:
    """A word of a motion; without a probability where no own caption has checked it."""

    word: str
    probability: float | None


@dataclass(frozen=True)
class WordsOverTime:
    """The words of an interval, most probable first, and the symbols of its segments."""

    start: float
    end: float
    words: tuple[DescribedWord, ...]
    symbols: tuple[int, ...]


def words_over_time(described: Iterable[Description]) -> tuple[WordsOverTime, ...]:
    """Return the words of a motion over time, as ``describe`` gives them."""
    return tuple(
        WordsOverTime(d.start, d.end, tuple(DescribedWord(w, p) for w, p in d.words), d.symbols)
        for d in described
    )


@dataclass(frozen=True)
class SideOfAction:
    """The side of an action."""

    side: str
    limb: str


@dataclass(frozen=True)
class ActionTree:
    """An action."""

    kind: Literal["action"]
    words: tuple[str, ...]
    sides: tuple[SideOfAction, ...]
    manner: tuple[str, ...]


@dataclass(frozen=True)
class AnythingTree:
    """Any action."""

    kind: Literal["anything"]


@dataclass(frozen=True)
class JoinedTree:
    """Several parts."""

    kind: Literal["in_order", "at_once", "both", "any_of"]
    parts: tuple[QuestionTree, ...]


@dataclass(frozen=True)
class WithoutTree:
    """A part without others."""

    kind: Literal["without"]
    part: QuestionTree
    excluded: tuple[QuestionTree, ...]


@dataclass(frozen=True)
class RepeatedTree:
    """A part that happens several times."""

    kind: Literal["repeated"]
    part: QuestionTree
    at_least: int | None
    at_most: int | None


@dataclass(frozen=True)
class LastingTree:
    """A part of a duration."""

    kind: Literal["lasting"]
    part: QuestionTree
    least_seconds: float | None
    most_seconds: float | None


@dataclass(frozen=True)
class MeasuredTree:
    """A part that turns by an angle (degrees), or goes as far (m), fast (m/s) or many steps."""

    kind: Literal["measured"]
    part: QuestionTree
    what: str  # "angle", "way", "speed" or "steps"
    at_least: float
    at_most: float | None
    said: str


QuestionTree = (
    ActionTree | AnythingTree | JoinedTree | WithoutTree | RepeatedTree | LastingTree | MeasuredTree
)
_JOINED: dict[type, Literal["in_order", "at_once", "both", "any_of"]] = {
    tree.InOrder: "in_order",
    tree.AtOnce: "at_once",
    tree.Both: "both",
    tree.AnyOf: "any_of",
}


def question_tree(node: tree.Node) -> QuestionTree:
    """Return the tree of a question.

    >>> kick = tree.Action(("kick", "left", "leg"))
    >>> question_tree(tree.Repeated(kick, 2, 2)).part.sides
    (SideOfAction(side='left', limb='leg'),)
    """
    match node:
        case tree.Action(words, manner):
            sides = tuple(SideOfAction(side, limb) for side, limb in node.sides)
            return ActionTree("action", tuple(map(as_said, words)), sides, manner)
        case tree.Without(part, excluded):
            left_out = tuple(map(question_tree, excluded))
            return WithoutTree("without", question_tree(part), left_out)
        case tree.Repeated(part, least, most):
            return RepeatedTree("repeated", question_tree(part), least, most)
        case tree.Lasting(part, shortest, longest):
            return LastingTree("lasting", question_tree(part), shortest, longest)
        case tree.Measured(part, measure):
            of = question_tree(part)
            return MeasuredTree(
                "measured", of, measure.what, measure.least, measure.most, measure.say()
            )
        case tree.Anything():
            return AnythingTree("anything")
        case _:
            return JoinedTree(_JOINED[type(node)], tuple(map(question_tree, node.parts)))


@dataclass(frozen=True)
class UnderstoodQuestion:
    """How a question was understood, and its parts that were not used."""

    text: str
    understood: str
    tree: QuestionTree
    not_used: tuple[NotUsed, ...]


@dataclass(frozen=True, kw_only=True)
class WordsOfQuestion:
    """A question, and what its unknown words were replaced by."""

    question: UnderstoodQuestion
    taken: dict[str, tuple[WordProbability, ...]]  # Known words that stand for unknown ones
    suggested: dict[str, tuple[WordProbability, ...]]
    unknown: dict[str, tuple[str, ...]]  # Unknown words, with similar known ones
    missing: tuple[str, ...]  # Unknown words that name an action: the rest alone is answered
    sentences: tuple[str, ...]  # The same for people, with the captions that taught the words


def understood_question(question: KnownQuestion, not_used: Sequence[NotUsed]) -> UnderstoodQuestion:
    """Return how a question was understood."""
    shape = question_tree(question.tree)
    left = tuple(replace(one, text=as_said(one.text)) for one in not_used)
    return UnderstoodQuestion(question.text, question.understood, shape, left)


def known_words(takings: Mapping[str, Taking]) -> dict[str, tuple[WordProbability, ...]]:
    """Return the known words that stand for unknown ones, or are suggested for them."""
    return {
        as_said(word): tuple(WordProbability(known, p) for known, p in taking.words)
        for word, taking in takings.items()
        if not taking.nearest
    }


@dataclass(frozen=True, kw_only=True)
class LikeAnswer:
    """Matches, best first, and whether any is good enough (None: unknown)."""

    matches_anything: bool | None
    strength: float | None
    threshold: float | None
    unchecked: str  # Why there are no probabilities; "" where there are
    matches: tuple[Match, ...]
    read_as: str = ""  # How the words beside a path were read


def like_answer(answer: ExampleAnswer | WordAnswer) -> LikeAnswer:
    """Return the answer to an example, for JSON.

    Parameters
    ----------
    answer : ExampleAnswer
        What :meth:`MotionDB.like` gives.
    """
    return extended(LikeAnswer, answer, matches=tuple(answer.matches))


@dataclass(frozen=True, kw_only=True)
class ExplainedMatch(Match):
    """A match of words, with its reasons where they were asked for."""

    explain: Explanation | None


@dataclass(frozen=True)
class WrittenAnswer:
    """A word that was not learned: its tags, and the number of captures and captions with it."""

    word: str
    tags: tuple[str, ...]
    captures: int
    in_captions: int


@dataclass(frozen=True, kw_only=True)
class SearchAnswer(WordsOfQuestion, LikeAnswer):
    """An answer to words."""

    matches: tuple[ExplainedMatch, ...]
    decoding: Decoding | None  # Of a search by symbols
    sources: tuple[WordSource, ...]  # Which captions taught the words
    written: tuple[WrittenAnswer, ...]
    # Words that are ranked by their meaning, with the nearest known words
    by_meaning: dict[str, tuple[str, ...]]
    measured: tuple[str, ...]  # Words that no caption holds and that are measured in the motion


def search_answer(answer: WordAnswer, explain: bool = True) -> SearchAnswer:
    """Return the answer to words, for JSON.

    Parameters
    ----------
    answer : WordAnswer
        What :meth:`MotionDB.search` gives.
    explain : bool
        Whether every match carries its reasons.
    """
    why = answer.explanations if explain else ()
    written = tuple(
        WrittenAnswer(word.word, word.tags, len(word.captures), word.in_captions)
        for word in answer.written
    )
    matches = tuple(
        extended(ExplainedMatch, match, explain=reason)
        for match, reason in zip_longest(answer.matches, why)
    )
    return extended(
        SearchAnswer,
        answer,
        matches=matches,
        question=understood_question(answer.question, answer.not_used),
        taken=known_words(answer.taken),
        suggested=known_words(answer.suggested),
        unknown={as_said(word): near for word, near in answer.unknown.items()},
        sentences=(
            *filter(None, [answer.not_understood, answer.nothing if answer.doubtful else ""]),
            *answer.remarks,
            *(taking.sentence() for taking in answer.taken.values()),
            *(
                f"{as_said(word)!r} is measured in the motion, not searched in captions"
                for word in answer.measured
            ),
            *(
                f"{as_said(word)!r} is not measured in this question; its answers carry no "
                "probabilities"
                for word in answer.unmeasured
            ),
            *(word.sentence() for word in answer.written),
            *(source.sentence() for source in answer.sources),
        ),
        written=written,
        by_meaning={word: each.heard for word, each in answer.taken.items() if each.nearest},
        measured=tuple(map(as_said, answer.measured)),
    )


@dataclass(frozen=True)
class JointDistance:
    """How far a joint is apart in two aligned motions, metres, relative to pelvis and heading."""

    joint: str
    distance: float


@dataclass(frozen=True, repr=False)
class Comparison(Tabled):
    """Two motions, aligned by dynamic time warping on the standard body."""

    first: str
    second: str
    distance: float  # Mean over the alignment and the joints, metres
    mirrored_distance: float  # The same with the mirror image of the first
    first_seconds: float
    second_seconds: float
    joints: tuple[JointDistance, ...]  # Farthest first
    alignment: tuple[tuple[float, float], ...]  # Times of both that correspond, seconds
    png: Path | None = field(default=None, metadata=OPTIONAL)
