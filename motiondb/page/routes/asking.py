"""Routes of questions: search, like, describe, the symbol space; motions from sentences."""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice, pairwise
from typing import Annotated, Literal

import numpy as np
from fastapi import APIRouter, Query
from pydantic import Field

from motiondb import answers
from motiondb.database import MotionDB
from motiondb.database.curating import CurateSettings, Gathered, gather
from motiondb.database.generating import ActionPlace
from motiondb.errors import QueryError
from motiondb.language.question.heads import verbs_in
from motiondb.page import replies
from motiondb.page.errors import ERRORS, PageError
from motiondb.page.routes import parameters
from motiondb.page.state import Block, MadeMotion, Page, Ref, load_motion, read_ref
from motiondb.records import Match
from motiondb.search.by_example import ExampleAnswer
from motiondb.search.chances import LIKELY

OFFERED, MOST_ASKED = 5, 14  # Questions that are offered, and most that are tried for it
MOST_WORDS = 8  # Words that are offered where no question is proven
MOST_CHOICES = 20  # Shares of which the choice is kept
MOST_CAPTIONS = 40  # Captions whose own order of actions is tried


@dataclass(frozen=True)
class ProvenQuestion:
    """A question, and its first answer with the probability that it is right."""

    question: str
    capture: str
    probability: float


@dataclass(frozen=True)
class ExamplesReply:
    """Questions that find something, and the commonest actions in the captions."""

    examples: tuple[ProvenQuestion, ...]
    words: tuple[str, ...]


@dataclass(frozen=True)
class DescribeReply:
    """The words of a motion over time."""

    ref: str
    duration: float
    words: tuple[answers.WordsOverTime, ...]


@dataclass(frozen=True, kw_only=True)
class PlayableSegment(answers.SymbolSegment):
    """A segment of a symbol that can be played."""

    ref: str


@dataclass(frozen=True, kw_only=True)
class PlacedSymbol(answers.SymbolRow):
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
class ChoiceReply:
    """The part of the library that is worth training on, and where it is in the symbol space."""

    choice: answers.SplitChoice
    symbols: list[int]
    left_out: dict[str, float]  # Seconds for each reason


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
        q: Annotated[
            str, Query(max_length=parameters.LONGEST_TEXT, description="Such as: walk, turn left.")
        ],
        where: parameters.Where = "",
        limit: parameters.Limit = 10,
        exact: bool = False,
        by_symbols: bool = False,
    ) -> replies.SearchReply:
        """Intervals that match a question in words, best first, each with its reasons."""
        began = time.perf_counter()
        with page.reading() as db:
            answer = db.search(q, where, limit, by_symbols, exact=exact)
            return replies.search_reply(db, answer, round(time.perf_counter() - began, 4))

    @routes.get("/api/examples")
    def examples() -> ExamplesReply:
        """Questions that find something in this database, each with its first answer."""
        with page.reading() as db:
            return examples_of(db)

    @routes.get("/api/like")
    def like(
        ref: parameters.RefText,
        start: parameters.Start = None,
        end: parameters.End = None,
        where: parameters.Where = "",
        limit: parameters.Limit = 10,
        meaning: bool | None = None,
    ) -> replies.LikeReply:
        """Intervals that move like a capture, an uploaded file, or a generated motion."""
        began = time.perf_counter()
        with page.reading() as db:
            asked = read_ref(ref)
            example = load_motion(page, db, asked, start, end)
            answer = db.like(example, None, None, where, limit + _OF_ITSELF, meaning)
            others = [each for each in answer.matches if not _is_example(each, asked, start, end)]
            kept = tuple(replace(each, rank=n) for n, each in enumerate(others[:limit], 1))
            found_itself = len(others) < len(answer.matches)  # which is as like as can be
            strength = None if found_itself else answer.strength
            answer = replace(answer, matches=kept, strength=strength)
            took = round(time.perf_counter() - began, 4)
            return replies.like_reply(db, answer, ref, start, end, took)

    def nearest(ask: Callable[[MotionDB], ExampleAnswer]) -> replies.LikeReply:
        """The reply to a path or a rhythm, with the time that it took."""
        began = time.perf_counter()
        with page.reading() as db:
            answer = ask(db)
            took = round(time.perf_counter() - began, 4)
            return replies.like_reply(db, answer, "", None, None, took)

    @routes.get("/api/along")
    def along(
        path: Annotated[
            str, Query(max_length=parameters.LONGEST_TEXT, description="Such as: 0,0 0,3 2,3.")
        ],
        words: Annotated[str, Query(max_length=parameters.LONGEST_TEXT)] = "",
        where: parameters.Where = "",
        limit: parameters.Limit = 10,
    ) -> replies.LikeReply:
        """Intervals that travel along a path on the floor, seen from above, in metres."""
        return nearest(lambda db: db.captures.along(path, words, where, limit))

    @routes.get("/api/rhythm")
    def rhythm(
        taps: Annotated[
            str, Query(max_length=parameters.LONGEST_TEXT, description="Such as: 0 .5 1 1.5.")
        ],
        words: Annotated[str, Query(max_length=parameters.LONGEST_TEXT)] = "",
        where: parameters.Where = "",
        limit: parameters.Limit = 10,
    ) -> replies.LikeReply:
        """Intervals whose steps fall at the times of taps, in seconds."""
        return nearest(lambda db: db.captures.rhythm(taps, words, where, limit))

    @routes.get("/api/describe")
    def describe(
        ref: parameters.RefText, start: parameters.Start = None, end: parameters.End = None
    ) -> DescribeReply:
        """The words of a motion over time, from the beginning of the part."""
        with page.reading() as db:
            asked = read_ref(ref)
            motion = load_motion(page, db, asked, start, end)
            if asked.kind == "capture" and start is None and end is None:
                words = replies.described_words(db, asked.name)
            else:
                words = answers.words_over_time(db.describe(motion))
        return DescribeReply(ref, round(motion.duration, 3), words)

    return routes


def symbols_router(page: Page) -> APIRouter:
    """Return the routes of motion symbols."""
    routes = APIRouter(tags=["ask"], responses=ERRORS)

    @routes.get("/api/symbols")
    def symbols() -> SpaceReply:
        """The symbol space: coordinates, clusters, and the words of every symbol."""
        with page.held.use() as db:
            rows, space = db.symbols.rows(), db.learned.space
            typical = [_playable(db.symbols.segments(row.symbol)[:1]) for row in rows]
        clusters = [
            SymbolCluster(number, float(weight), mean.tolist(), covariance.tolist())
            for number, (weight, mean, covariance) in enumerate(
                zip(space.weights, space.means, space.covars)
            )
        ]
        placed = [
            answers.extended(PlacedSymbol, row, at=at.tolist(), typical=next(iter(first), None))
            for row, at, first in zip(rows, space.coordinates, typical)
        ]
        stress = [float(value) for value in space.stress]
        return SpaceReply(space.coordinates.shape[1], stress, placed, clusters)

    @routes.get("/api/choice")
    def choice(share: Annotated[float, Query(gt=0.0, le=1.0)]) -> ChoiceReply:
        """The choice of `curate`, in a library of which all captures were measured."""
        return _kept_choice(page, share)

    @routes.get("/api/symbol")
    def symbol(
        symbol: Annotated[int, Query(ge=0, le=10**6)],
        offset: Annotated[int, Query(ge=0, le=10**9)] = 0,
        limit: Annotated[int, Query(ge=1, le=1000)] = 50,
    ) -> SegmentsReply:
        """The segments of a symbol, most typical first."""
        with page.held.use() as db:
            rows = db.symbols.segments(symbol)
        return SegmentsReply(symbol, len(rows), _playable(rows[offset : offset + limit]))

    return routes


_OF_ITSELF = 3  # Matches of an example that may be parts of itself


def _is_example(match: Match, ref: Ref, start: float | None, end: float | None) -> bool:
    """Whether a match is the example that was asked with: more than half of it is in its part."""
    if ref.kind != "capture" or match.capture != ref.name:
        return False
    low, high = start or 0.0, np.inf if end is None else end
    return min(match.end, high) - max(match.start, low) > 0.5 * (match.end - match.start)


def _kept_choice(page: Page, share: float) -> ChoiceReply:
    """The choice of a share, computed once a revision while the file is free."""
    with page.held.use() as db:
        kept = db.session.kept("choices", dict[float, ChoiceReply])
        if share in kept:
            return kept[share]
        revision = db.revision()  # before what is gathered, so that no older choice is kept
        db.captures("quality >= 0")  # says so where they were not measured
        bodies, settings = [i for i in db.captures() if i.has_body], CurateSettings(share=share)
        gathered = gather(db.session, bodies, settings, lambda _what, _done, _all: None)
    reply = _choice(gathered)
    with page.held.use() as db:
        kept = db.session.kept("choices", dict[float, ChoiceReply])
        if db.revision() == revision:
            kept[share] = reply
            for oldest in list(kept)[:-MOST_CHOICES]:
                kept.pop(oldest, None)
    return reply


def _choice(gathered: Gathered) -> ChoiceReply:
    made = gathered.answer()
    symbols = sorted({symbol for each in made.intervals for symbol in each.symbols})
    return ChoiceReply(made.splits[0], symbols, made.reasons)


def _playable(segments: Sequence[answers.SymbolSegment]) -> list[PlayableSegment]:
    return [
        answers.extended(PlayableSegment, one, ref=f"capture:{one.capture}") for one in segments
    ]


def examples_of(db: MotionDB) -> ExamplesReply:
    """Return questions that find something in a database; computed once a revision.

    Each was asked: its first answer is more likely right than wrong. Where the captions have not
    checked the words, no answer has a probability; then only words are offered.
    """
    return db.session.kept("page examples", lambda: _find(db))


def _find(db: MotionDB) -> ExamplesReply:
    counted = [row.word for row in db.words.rows() if row.count > 0]  # those in most captions first
    words = [word for word in counted if verbs_in(word) == {word}]
    proven: list[ProvenQuestion] = []
    shown: set[str] = set()
    for question in islice(_candidates(db, words), MOST_ASKED):
        if len(proven) == OFFERED:
            break
        found = _prove(db, question)
        if found is not None and found.capture not in shown:
            proven.append(found)
            shown.add(found.capture)
    return ExamplesReply(tuple(proven), tuple(words[:MOST_WORDS]))


def _candidates(db: MotionDB, words: list[str]) -> Iterator[str]:
    """Yield questions: orders of actions that captions tell and single actions, by turns."""
    singles, orders = iter(words), _told_orders(db, set(words))
    for _ in range(MOST_ASKED):
        yield from islice(singles, 1)
        yield from islice(orders, 1)
    yield from (f"{a} or {b}" for a, b in pairwise(words))


def _told_orders(db: MotionDB, words: set[str]) -> Iterator[str]:
    """Yield two actions that a caption of a whole capture tells one after the other."""
    told: dict[str, None] = {}
    for row in db.captures.browse(limit=10**6).rows:
        for caption in row.captions:
            pieces = [piece.strip() for piece in caption.words.lower().split(",")]
            named = [min(verbs_in(p) & words, default="") for p in pieces]
            told.update((f"{a}, {b}", None) for a, b in pairwise(named) if a and b and a != b)
        if len(told) > MOST_CAPTIONS:
            break
    yield from told


def _prove(db: MotionDB, question: str) -> ProvenQuestion | None:
    """Return a question whose first answer is more likely right than wrong, else None."""
    try:
        answer = db.search(question, limit=1)
    except QueryError:
        return None
    if not answer.matches or not answer.matches_anything:
        return None
    first = answer.matches[0]
    if first.probability is None or first.probability < LIKELY:
        return None
    return ProvenQuestion(question, first.capture, first.probability)


MOST_VARIANTS = 8  # Largest number of variants of one request: as many as can be watched at once
MOST_BLOCKS = 30  # Largest number of actions on a timeline
_FOR = re.compile(r"\s+for\s+(about\s+)?[\d.]+\s*s(ec(ond)?s?)?\b", re.IGNORECASE)


class BlockBody(parameters.Body):
    """An action on the timeline: its phrase, its duration, and where it is taken from."""

    phrase: Annotated[str, Field(min_length=1, max_length=500)]
    seconds: Annotated[float, Field(ge=0.5, le=60.0, allow_inf_nan=False)] | None = None
    place: Annotated[int, Field(ge=0, le=1000)] | None = None
    capture: parameters.Text | None = None
    start: parameters.Seconds | None = None
    end: parameters.Seconds | None = None

    def to_block(self) -> Block:
        """Return the block; an excerpt that was picked has both ends."""
        if self.capture is not None and (self.start is None or self.end is None):
            raise PageError("block: expected the start and the end of an excerpt, found one.")
        return Block(**self.model_dump())


def sentence_of(blocks: Sequence[Block]) -> str:
    """Return the sentence that asks for blocks.

    >>> sentence_of([Block("walk for 2 s", seconds=5.0), Block("kick twice")])
    'walk for 5 seconds, then kick twice'
    """
    said = [
        one.phrase
        if one.seconds is None
        else f"{_FOR.sub('', one.phrase)} for {one.seconds:g} seconds"
        for one in blocks
    ]
    return ", then ".join(said)


class GenerateBody(parameters.Body):
    """A sentence, and the settings for its motion."""

    words: parameters.Text = ""
    blocks: Annotated[tuple[BlockBody, ...], Field(max_length=MOST_BLOCKS)] = ()
    seed: Annotated[int, Field(ge=0, le=parameters.LARGEST_SEED - MOST_VARIANTS)] = 0
    variants: Annotated[int, Field(ge=1, le=MOST_VARIANTS)] = 1
    method: Literal["stitched", "trajectory"] = "stitched"
    exact: bool = False


def making_router(page: Page) -> APIRouter:
    """Return the routes that generate."""
    routes = APIRouter(tags=["generate"], responses=ERRORS)

    @routes.post("/api/generate")
    def generate(body: GenerateBody) -> replies.GenerateReply:
        """Motions that show the actions of a sentence; variant k has the seed ``seed + k``.

        With blocks, one motion that takes each action from where its block says.
        """
        if bool(body.words.strip()) == bool(body.blocks):
            raise PageError("generate: expected either words or blocks, found neither or both.")
        if body.blocks:
            return _from_blocks(page, body)
        motions, variants = [], []
        for seed in range(body.seed, body.seed + body.variants):
            with page.held.use() as db:  # opened for each variant in turn
                made = db.generate(body.words, seed, body.method, body.exact)
                motions.append(made)
                variants.append(replies.made_reply(db, made, page.made.put(MadeMotion(made))))
        return replies.generate_reply(motions[0], variants)

    @routes.get("/api/made")
    def made(id: parameters.Name) -> replies.GenerateReply:
        """A motion that was generated before."""
        kept = page.made.get(id)
        with page.held.use() as db:
            reply = replies.made_reply(db, kept.generated, id, kept.saved, kept.blocks)
        return replies.generate_reply(kept.generated, [reply])

    @routes.post("/api/made/save")
    def save(body: parameters.SaveBody) -> parameters.Saved:
        """Save a generated motion as a capture."""
        page.check_writable()
        kept = page.made.get(body.id)
        if kept.saved:
            raise PageError(
                f"{kept.saved}: expected a motion that is not saved, found it saved already.",
                "ConflictError",
            )
        with page.held.use() as db:
            db.captures.check_name_free(body.name)
            info = db.captures.save_generated(
                body.name, kept.generated.words, kept.generated, kept.generated.seed
            )
        page.made.replace(body.id, replace(kept, saved=info.name))
        return parameters.Saved(info.name, f"capture:{info.name}")

    return routes


def _from_blocks(page: Page, body: GenerateBody) -> replies.GenerateReply:
    """Return the motion of a timeline."""
    blocks = tuple(block.to_block() for block in body.blocks)
    places = [
        ActionPlace(one.place, one.capture, one.start or 0.0, one.end or 0.0) for one in blocks
    ]
    words = sentence_of(blocks)
    with page.held.use() as db:
        made = db.generate(words, body.seed, body.method, body.exact, places=places)
        name = page.made.put(MadeMotion(made, blocks=blocks))
        return replies.generate_reply(made, [replies.made_reply(db, made, name, blocks=blocks)])
