"""Schemas of answers to questions, and of the symbol space."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from motiondb.page.schemas.shared_schemas import (
    CaptionFacts,
    Facts,
    SegmentFacts,
    WordProbability,
    WordsOverTime,
)


class SideFacts(Facts):
    """The side of an action."""

    side: str
    limb: str


class QuestionTree(Facts):
    """A node of a question; the other fields depend on its kind."""

    kind: Literal[
        "action",
        "anything",
        "in_order",
        "at_once",
        "both",
        "any_of",
        "without",
        "repeated",
        "lasting",
    ]
    words: list[str] | None = Field(default=None, description="Of an action.")
    sides: list[SideFacts] | None = None
    manner: list[str] | None = None
    parts: list[QuestionTree] | None = Field(default=None, description="In order, at once...")
    part: QuestionTree | None = Field(default=None, description="Without, repeated, lasting.")
    excluded: list[QuestionTree] | None = None
    at_least: int | None = None
    at_most: int | None = None
    least_seconds: float | None = None
    most_seconds: float | None = None


class NotUsed(Facts):
    """A part of a question that was not used, with the reason."""

    text: str
    reason: str


class QuestionFacts(Facts):
    """How a question was understood."""

    text: str
    understood: str
    tree: QuestionTree
    not_used: list[NotUsed]


class Understood(Facts):
    """How a question was understood, word by word."""

    question: QuestionFacts
    taken: dict[str, list[WordProbability]] = Field(
        description="Known words that stand for unknown ones."
    )
    suggested: dict[str, list[WordProbability]]
    unknown: dict[str, list[str]] = Field(description="Unknown words, with similar known ones.")
    sentences: list[str]


class SymbolShareFacts(Facts):
    """What one symbol in one interval adds to the log-odds of an answer."""

    symbol: int
    start: float = Field(alias="from", description="Seconds.")
    end: float = Field(alias="to")
    share: float = Field(description="Nats.")


class ExplainedWordFacts(Facts):
    """What one word adds: prior, written, as_caption and all symbols, or strongest and others."""

    word: str
    log_odds: float
    log_probability: float
    contribution: float
    prior: float
    written: float
    as_caption: float
    symbols: list[SymbolShareFacts]
    strongest: list[SymbolShareFacts]
    others: float


class ExcludedFacts(Facts):
    """What an exclusion adds."""

    amount: float
    log_odds: float
    words: list[ExplainedWordFacts]


class ExplanationFacts(Facts):
    """Contributions of words, together and amounts of exclusions, which sum to the log-odds."""

    log_odds: float
    together: float
    words: list[ExplainedWordFacts]
    excluded: list[ExcludedFacts]


class MatchPartFacts(Facts):
    """A part of a question in an answer."""

    words: str
    start: float
    end: float
    probability: float | None
    interval_probability: float | None
    place: Literal["known", "unknown"]


class TimelineFacts(Facts):
    """The take of an answer."""

    segments: list[SegmentFacts]
    words: list[CaptionFacts]


class MatchFacts(Facts):
    """An answer."""

    rank: int
    capture: str
    ref: str
    start: float
    end: float
    score: float
    probability: float | None
    interval_probability: float | None = None
    place: Literal["known", "unknown"] | None = None
    parts: list[MatchPartFacts] | None = None
    words: list[str]
    reason: str
    duration: float
    performer: str | None
    licence: str | None
    kind: str
    timeline: TimelineFacts
    explain: ExplanationFacts | None = None


class AnswerFacts(Facts):
    """Answers, and whether any of them matches."""

    matches_anything: bool | None
    strength: float | None
    threshold: float | None
    unchecked: str = Field(description="Why there are no probabilities; empty where there are.")
    not_yet_learned: int
    matches: list[MatchFacts]
    took: float = Field(description="Seconds.")


class DecodingFacts(Facts):
    """Symbols that words were decoded to."""

    symbols: list[int]
    log_probability: float
    nodes_expanded: int
    certificate: str
    bound: float | None = None


class SearchAnswer(AnswerFacts, Understood):
    """An answer to words."""

    decoding: DecodingFacts | None
    sources: list[str] = Field(description="Which captions taught the words.")


class LikeAnswer(AnswerFacts):
    """An answer to an example."""

    ref: str
    start: float | None
    end: float | None


class Description(Facts):
    """The words of a motion over time."""

    ref: str
    duration: float
    words: list[WordsOverTime]


class SymbolFacts(Facts):
    """A motion symbol."""

    symbol: int
    at: list[float]
    cluster: int
    count: int
    captures: int
    seconds: float
    words: list[WordProbability]


class ClusterFacts(Facts):
    """A cluster of symbols, a Gaussian."""

    cluster: int
    weight: float
    mean: list[float]
    covariance: list[list[float]]


class SymbolSpaceFacts(Facts):
    """The symbol space."""

    dimensions: int
    stress: list[float]
    symbols: list[SymbolFacts]
    clusters: list[ClusterFacts]


class SymbolSegment(SegmentFacts):
    """A segment of a symbol."""

    capture: str
    ref: str


class SymbolSegments(Facts):
    """Segments of a symbol, most typical first."""

    symbol: int
    total: int
    segments: list[SymbolSegment]
