"""Schemas of generated motion."""

from __future__ import annotations

from pydantic import Field

from motiondb.page.schemas.asking_schemas import DecodingFacts, NotUsed, Understood
from motiondb.page.schemas.shared_schemas import Facts, SourceFacts, StretchFacts, WordsOverTime


class SpanFacts(Facts):
    """When an action is shown."""

    words: str
    start: float
    end: float


class ShownFacts(Facts):
    """Whether a generated motion shows an action."""

    text: str
    start: float
    end: float
    probability: float | None
    shown: bool | None = Field(description="null: this cannot be decided.")
    reason: str | None


class MadeFacts(Facts):
    """A generated motion."""

    id: str
    ref: str
    words: str
    seed: int
    method: str
    seconds: float
    actions: list[list[str]]
    symbols: list[int]
    recognised: list[int]
    decodings: list[DecodingFacts]
    spans: list[SpanFacts]
    recognised_words: list[WordsOverTime]
    shown: list[ShownFacts]
    not_shown: list[NotUsed]
    sources: list[SourceFacts]
    stretches: list[StretchFacts]
    saved: str | None


class MadeAgain(Understood, MadeFacts):
    """A generated motion with its sentence."""


class GenerateAnswer(Understood):
    """Motions of one sentence."""

    variants: list[MadeFacts]
