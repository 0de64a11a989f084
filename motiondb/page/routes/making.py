"""Routes that generate motions from sentences."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Literal

from fastapi import APIRouter
from pydantic import Field

from motiondb.page.errors import PageError
from motiondb.page.replies import GenerateReply, generate_reply, made_reply
from motiondb.page.routes.parameters import LARGEST_SEED, Body, Name, SaveBody, Saved, Text
from motiondb.page.state import MadeMotion, Page

MOST_VARIANTS = 8  # Largest number of variants of one request: as many as can be watched at once


class GenerateBody(Body):
    """A sentence, and the settings for its motion."""

    words: Text
    seed: Annotated[int, Field(ge=0, le=LARGEST_SEED - MOST_VARIANTS)] = 0
    variants: Annotated[int, Field(ge=1, le=MOST_VARIANTS)] = 1
    method: Literal["stitched", "trajectory"] = "stitched"
    exact: bool = False


def router(page: Page) -> APIRouter:
    """Return the routes that generate."""
    routes = APIRouter(tags=["generate"])

    @routes.post("/api/generate")
    def generate(body: GenerateBody) -> GenerateReply:
        """Motions that show the actions of a sentence; variant k has the seed ``seed + k``."""
        motions, variants = [], []
        for seed in range(body.seed, body.seed + body.variants):
            with page.held.use() as db:  # opened for each variant in turn
                made = db.generate(body.words, seed, body.method, body.exact)
                motions.append(made)
                variants.append(made_reply(db, made, page.made.put(MadeMotion(made))))
        return generate_reply(motions[0], variants)

    @routes.get("/api/made")
    def made(id: Name) -> GenerateReply:
        """A motion that was generated before."""
        kept = page.made.get(id)
        with page.held.use() as db:
            reply = made_reply(db, kept.generated, id, kept.saved)
        return generate_reply(kept.generated, [reply])

    @routes.post("/api/made/save")
    def save(body: SaveBody) -> Saved:
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
        return Saved(info.name, f"capture:{info.name}")

    return routes
