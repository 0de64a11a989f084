"""Routes of questions: search by words, search by example, describe; the symbol space."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

from fastapi import APIRouter, Query

from motiondb.answers.catalogue import SymbolRow, SymbolSegment
from motiondb.answers.plain import fields_of
from motiondb.answers.questions import WordsOverTime, words_over_time
from motiondb.page.errors import ERRORS
from motiondb.page.examples import ExamplesReply, examples_of
from motiondb.page.refs import load_motion, read_ref
from motiondb.page.replies import (
    LikeReply,
    SearchReply,
    described_words,
    like_reply,
    search_reply,
)
from motiondb.page.routes.parameters import LONGEST_TEXT, End, Limit, RefText, Start, Where
from motiondb.page.state import Page


@dataclass(frozen=True)
class DescribeReply:
    """The words of a motion over time."""

    ref: str
    duration: float
    words: tuple[WordsOverTime, ...]


@dataclass(frozen=True, kw_only=True)
class PlayableSegment(SymbolSegment):
    """A segment of a symbol that can be played."""

    ref: str


@dataclass(frozen=True, kw_only=True)
class PlacedSymbol(SymbolRow):
    """A motion symbol with its coordinates and its most typical segment."""

    at: list[float]
    typical: PlayableSegment | None


@dataclass(frozen=True)
class SymbolCluster:
    """A cluster of symbols, a Gaussian."""

    cluster: int
    weight: float
    mean: list[float]
    covariance: list[list[float]]


@dataclass(frozen=True)
class SpaceReply:
    """The symbol space."""

    dimensions: int
    stress: list[float]
    symbols: list[PlacedSymbol]
    clusters: list[SymbolCluster]


@dataclass(frozen=True)
class SegmentsReply:
    """Segments of a symbol, most typical first."""

    symbol: int
    total: int
    segments: list[PlayableSegment]


def router(page: Page) -> APIRouter:
    """Return the routes of questions."""
    routes = APIRouter(tags=["ask"], responses=ERRORS)

    @routes.get("/api/search")
    def search(
        q: Annotated[str, Query(max_length=LONGEST_TEXT, description="Such as: walk, turn left.")],
        where: Where = "",
        limit: Limit = 10,
        exact: bool = False,
        by_symbols: bool = False,
    ) -> SearchReply:
        """Intervals that match a question in words, best first, each with its reasons."""
        began = time.perf_counter()
        with page.held.use() as db, db.session.reading():
            answer = db.search(q, where, limit, by_symbols, exact=exact)
            return search_reply(db, answer, round(time.perf_counter() - began, 4))

    @routes.get("/api/examples")
    def examples() -> ExamplesReply:
        """Questions that find something in this database, each with its first answer."""
        with page.held.use() as db, db.session.reading():
            return examples_of(db)

    @routes.get("/api/like")
    def like(
        ref: RefText,
        start: Start = None,
        end: End = None,
        where: Where = "",
        limit: Limit = 10,
        meaning: bool | None = None,
    ) -> LikeReply:
        """Intervals that move like a capture, an uploaded file, or a generated motion."""
        began = time.perf_counter()
        with page.held.use() as db, db.session.reading():
            example = load_motion(page, db, read_ref(ref), start, end)
            answer = db.like(example, None, None, where, limit, meaning)
            took = round(time.perf_counter() - began, 4)
            return like_reply(db, answer, ref, start, end, took)

    @routes.get("/api/describe")
    def describe(ref: RefText, start: Start = None, end: End = None) -> DescribeReply:
        """The words of a motion over time, from the beginning of the part."""
        with page.held.use() as db, db.session.reading():
            asked = read_ref(ref)
            motion = load_motion(page, db, asked, start, end)
            if asked.kind == "capture" and start is None and end is None:
                words = described_words(db, asked.name)
            else:
                words = words_over_time(db.describe(motion))
        return DescribeReply(ref, round(motion.duration, 3), words)

    @routes.get("/api/symbols")
    def symbols() -> SpaceReply:
        """The symbol space: coordinates, clusters, and the words of every symbol."""
        with page.held.use() as db:
            rows, space = db.symbol_rows(), db.learned.space
            typical = [_playable(db.symbol_segments(row.symbol)[:1]) for row in rows]
        clusters = [
            SymbolCluster(number, float(weight), mean.tolist(), covariance.tolist())
            for number, (weight, mean, covariance) in enumerate(
                zip(space.weights, space.means, space.covars)
            )
        ]
        placed = [
            PlacedSymbol(**fields_of(row), at=at.tolist(), typical=next(iter(first), None))
            for row, at, first in zip(rows, space.coordinates, typical)
        ]
        stress = [float(value) for value in space.stress]
        return SpaceReply(space.coordinates.shape[1], stress, placed, clusters)

    @routes.get("/api/symbol")
    def symbol(
        symbol: Annotated[int, Query(ge=0, le=10**6)],
        offset: Annotated[int, Query(ge=0, le=10**9)] = 0,
        limit: Annotated[int, Query(ge=1, le=1000)] = 50,
    ) -> SegmentsReply:
        """The segments of a symbol, most typical first."""
        with page.held.use() as db:
            rows = db.symbol_segments(symbol)
        return SegmentsReply(symbol, len(rows), _playable(rows[offset : offset + limit]))

    return routes


def _playable(segments: Sequence[SymbolSegment]) -> list[PlayableSegment]:
    return [PlayableSegment(**fields_of(one), ref=f"capture:{one.capture}") for one in segments]
