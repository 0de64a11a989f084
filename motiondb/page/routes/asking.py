"""Routes of questions: search by words, search by example, describe; the symbol space."""

from __future__ import annotations

import time
from typing import Annotated

from fastapi import APIRouter, Query

from motiondb.page.answers import Answer
from motiondb.page.delivery.refs import load_motion, read_ref
from motiondb.page.facts.asked_facts import like_facts, search_facts
from motiondb.page.facts.capture_facts import description_facts
from motiondb.page.parameters import LONGEST_TEXT, End, Limit, RefText, Start, Where
from motiondb.page.schemas import asking_schemas
from motiondb.page.session.state import Page


def router(page: Page) -> APIRouter:
    """Return the routes of questions."""
    routes = APIRouter(tags=["ask"])

    @routes.get("/api/search", response_model=asking_schemas.SearchAnswer)
    def search(
        q: Annotated[str, Query(max_length=LONGEST_TEXT, description="Such as: walk, turn left.")],
        where: Where = "",
        limit: Limit = 10,
        exact: bool = False,
        by_symbols: bool = False,
    ) -> Answer:
        """Intervals that match a question in words, best first, each with its reasons."""
        began = time.perf_counter()
        with page.held.use() as db, db.session.reading():
            answer = db.search(q, where, limit, by_symbols, exact=exact)
            facts = search_facts(db, answer)
        return Answer(facts | {"took": round(time.perf_counter() - began, 4)})

    @routes.get("/api/like", response_model=asking_schemas.LikeAnswer)
    def like(
        ref: RefText,
        start: Start = None,
        end: End = None,
        where: Where = "",
        limit: Limit = 10,
        meaning: bool | None = None,
    ) -> Answer:
        """Intervals that move like a capture, an uploaded file, or a generated motion."""
        began = time.perf_counter()
        with page.held.use() as db, db.session.reading():
            example = load_motion(page, db, read_ref(ref), start, end)
            facts = like_facts(db, db.like(example, None, None, where, limit, meaning))
        took = round(time.perf_counter() - began, 4)
        return Answer({"ref": ref, "start": start, "end": end} | facts | {"took": took})

    @routes.get("/api/describe", response_model=asking_schemas.Description)
    def describe(ref: RefText, start: Start = None, end: End = None) -> Answer:
        """The words of a motion over time, from the beginning of the part."""
        with page.held.use() as db, db.session.reading():
            motion = load_motion(page, db, read_ref(ref), start, end)
            words = description_facts(db.describe(motion))
        return Answer({"ref": ref, "duration": round(motion.duration, 3), "words": words})

    @routes.get("/api/symbols", response_model=asking_schemas.SymbolSpaceFacts)
    def symbols() -> Answer:
        """The symbol space: coordinates, clusters, and the words of every symbol."""
        with page.held.use() as db:
            rows, space = db.symbol_rows(), db.learned.space
        for row, at in zip(rows, space.coordinates):
            row["at"] = at
        clusters = [
            {"cluster": number, "weight": weight, "mean": mean, "covariance": covariance}
            for number, (weight, mean, covariance) in enumerate(
                zip(space.weights, space.means, space.covars)
            )
        ]
        return Answer(
            {
                "dimensions": space.coordinates.shape[1],
                "stress": space.stress,
                "symbols": rows,
                "clusters": clusters,
            }
        )

    @routes.get("/api/symbol", response_model=asking_schemas.SymbolSegments)
    def symbol(
        symbol: Annotated[int, Query(ge=0, le=10**6)],
        offset: Annotated[int, Query(ge=0, le=10**9)] = 0,
        limit: Annotated[int, Query(ge=1, le=1000)] = 50,
    ) -> Answer:
        """The segments of a symbol, most typical first."""
        with page.held.use() as db:
            rows = db.symbol_segments(symbol)
        shown = [
            row | {"ref": f"capture:{row['capture']}"} for row in rows[offset : offset + limit]
        ]
        return Answer({"symbol": symbol, "total": len(rows), "segments": shown})

    return routes
