"""Schemas that several routes share."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, ConfigDict, Field


class Facts(BaseModel):
    """A JSON object with exactly the listed fields; fields with a default may be absent."""

    model_config = ConfigDict(extra="forbid")


class CaptionFacts(Facts):
    """Words about a capture, or about a part of it."""

    words: str
    start: float | None = Field(description="Seconds; null: the whole capture.")
    end: float | None


class SegmentFacts(Facts):
    """An interval with its motion symbol."""

    symbol: int
    start: float = Field(description="Seconds.")
    end: float
    log_likelihood: float | None = Field(description="Nats per frame.")
    known: bool = Field(description="False: unlike all learned motion.")


class SourceFacts(Facts):
    """A capture that frames of a generated motion come from."""

    capture: str
    licence: str
    sha256: str
    frames: int


class StretchFacts(Facts):
    """A stretch of a generated motion."""

    start: float = Field(description="Seconds.")
    end: float
    capture: str | None = Field(description="null: drawn from the model.")
    source_start: float
    licence: str | None
    edit: str


class WordProbability(Facts):
    """A word with its probability."""

    word: str
    probability: float


class DescribedWord(Facts):
    """A word of a motion with its probability; null where no own caption has checked it."""

    word: str
    probability: float | None


class WordsOverTime(Facts):
    """The words of an interval."""

    start: float = Field(description="Seconds.")
    end: float
    words: list[DescribedWord]
    symbols: list[int]


class Saved(Facts):
    """The capture under which a motion was saved."""

    capture: str
    ref: str


class JobFacts(Facts):
    """A job: long work in a separate process."""

    id: str
    kind: str = Field(description="add, learn, grammar, scene or scene-update.")
    title: str
    state: str = Field(description="waiting, running, done, failed or cancelled.")
    what: str = Field(description="The current step.")
    share: float = Field(ge=0.0, le=1.0, description="Share of the step that is done.")
    error: float | None = Field(description="-log P of the scene that is being sampled.")
    started: float = Field(description="Seconds since 1970.")
    seconds: float = Field(description="Duration so far, seconds.")
    message: str | None = Field(description="Why it failed.")
    error_kind: str | None
    result: dict[str, Any] | None = Field(description="The result; its keys depend on the kind.")
    preview: str | None = Field(description="Ref of a first motion of a scene, before its report.")
    curve: list[tuple[float, float]] = Field(description="Share and error of a scene so far.")


class JobList(Facts):
    """All jobs, newest first."""

    jobs: list[JobFacts]


class FolderFacts(Facts):
    """What is in a folder that captures may be added from."""

    root: int
    path: str
    folders: list[str]
    captures: int
    sheets: list[str]


class UploadedFile(Facts):
    """A file that was accepted."""

    name: str
    ref: str
    bytes: int
    kind: str = Field(description="capture, skeleton or sheet.")


class RefusedFile(Facts):
    """A file that was refused."""

    name: str
    message: str


class UploadFacts(Facts):
    """Files that were uploaded together."""

    upload: str
    files: list[UploadedFile]
    refused: list[RefusedFile]
