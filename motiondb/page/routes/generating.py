"""Routes that generate motions from sentences."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Any, Literal

from fastapi import APIRouter
from pydantic import Field

from motiondb.page.answers import Answer, PageError
from motiondb.page.facts.made_facts import made_facts, sentence_facts
from motiondb.page.parameters import LARGEST_SEED, Body, Name, Text
from motiondb.page.schemas import generating_schemas, shared_schemas
from motiondb.page.session.state import MadeMotion, Page

MOST_VARIANTS = 8
"""Largest number of variants of one request. Chosen by hand: as many as can be watched side by
side."""


class GenerateBody(Body):
    """A sentence, and the settings for its motion."""

    words: Text
    seed: Annotated[int, Field(ge=0, le=LARGEST_SEED - MOST_VARIANTS)] = 0
    variants: Annotated[int, Field(ge=1, le=MOST_VARIANTS)] = 1
    method: Literal["stitched", "trajectory"] = "stitched"
    exact: bool = False


class SaveBody(Body):
    """The motion to save, and the name of the new capture."""

    id: Text
    name: Annotated[str, Field(min_length=1, max_length=200)]


def router(page: Page) -> APIRouter:
    """Return the routes that generate."""
    routes = APIRouter(tags=["generate"])

    @routes.post("/api/generate", response_model=generating_schemas.GenerateAnswer)
    def generate(body: GenerateBody) -> Answer:
        """Motions that show the actions of a sentence; variant k has the seed ``seed + k``."""
        facts: dict[str, Any] = {}
        variants = []
        for seed in range(body.seed, body.seed + body.variants):
            with page.held.use() as db:  # opened for each variant in turn
                made = db.generate(body.words, seed, body.method, body.exact)
                made_id = page.made.put(MadeMotion(made))
                facts = facts or sentence_facts(made)
                variants.append(made_facts(db, made, made_id, ""))
        return Answer(facts | {"variants": variants})

    @routes.get("/api/made", response_model=generating_schemas.MadeAgain)
    def made(id: Name) -> Answer:
        """A motion that was generated before."""
        kept = page.made.get(id)
        with page.held.use() as db:
            facts = made_facts(db, kept.generated, id, kept.saved)
        return Answer(sentence_facts(kept.generated) | facts)

    @routes.post("/api/made/save", response_model=shared_schemas.Saved)
    def save(body: SaveBody) -> Answer:
        """Save a generated motion as a capture."""
        page.check_writable()
        kept = page.made.get(body.id)
        if kept.saved:
            raise PageError(
                f"{kept.saved}: expected a motion that is not saved, found it saved already.",
                409,
                "ConflictError",
            )
        with page.held.use() as db:
            db.check_name_free(body.name)
            info = db.save_generated(
                body.name, kept.generated.words, kept.generated, kept.generated.seed
            )
        page.made.replace(body.id, replace(kept, saved=info.name))
        return Answer({"capture": info.name, "ref": f"capture:{info.name}"})

    return routes
