"""Routes that generate motions from sentences."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Annotated, Literal

from fastapi import APIRouter
from pydantic import Field

from motiondb.database.generating import ActionPlace
from motiondb.page.errors import ERRORS, PageError
from motiondb.page.replies import GenerateReply, generate_reply, made_reply
from motiondb.page.routes.parameters import LARGEST_SEED, Body, Name, SaveBody, Saved, Seconds, Text
from motiondb.page.state import Block, MadeMotion, Page

MOST_VARIANTS = 8  # Largest number of variants of one request: as many as can be watched at once


MOST_BLOCKS = 30  # Largest number of actions on a timeline
_FOR = re.compile(r"\s+for\s+(about\s+)?[\d.]+\s*s(ec(ond)?s?)?\b", re.IGNORECASE)


class BlockBody(Body):
    """An action on the timeline: its phrase, its duration, and where it is taken from."""

    phrase: Annotated[str, Field(min_length=1, max_length=500)]
    seconds: Annotated[float, Field(ge=0.5, le=60.0, allow_inf_nan=False)] | None = None
    place: Annotated[int, Field(ge=0, le=1000)] | None = None
    capture: Text | None = None
    start: Seconds | None = None
    end: Seconds | None = None

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


class GenerateBody(Body):
    """A sentence, and the settings for its motion."""

    words: Text = ""
    blocks: Annotated[tuple[BlockBody, ...], Field(max_length=MOST_BLOCKS)] = ()
    seed: Annotated[int, Field(ge=0, le=LARGEST_SEED - MOST_VARIANTS)] = 0
    variants: Annotated[int, Field(ge=1, le=MOST_VARIANTS)] = 1
    method: Literal["stitched", "trajectory"] = "stitched"
    exact: bool = False


def router(page: Page) -> APIRouter:
    """Return the routes that generate."""
    routes = APIRouter(tags=["generate"], responses=ERRORS)

    @routes.post("/api/generate")
    def generate(body: GenerateBody) -> GenerateReply:
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
                variants.append(made_reply(db, made, page.made.put(MadeMotion(made))))
        return generate_reply(motions[0], variants)

    @routes.get("/api/made")
    def made(id: Name) -> GenerateReply:
        """A motion that was generated before."""
        kept = page.made.get(id)
        with page.held.use() as db:
            reply = made_reply(db, kept.generated, id, kept.saved, kept.blocks)
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
            db.captures.check_name_free(body.name)
            info = db.captures.save_generated(
                body.name, kept.generated.words, kept.generated, kept.generated.seed
            )
        page.made.replace(body.id, replace(kept, saved=info.name))
        return Saved(info.name, f"capture:{info.name}")

    return routes


def _from_blocks(page: Page, body: GenerateBody) -> GenerateReply:
    """Return the motion of a timeline."""
    blocks = tuple(block.to_block() for block in body.blocks)
    places = [
        ActionPlace(one.place, one.capture, one.start or 0.0, one.end or 0.0) for one in blocks
    ]
    words = sentence_of(blocks)
    with page.held.use() as db:
        made = db.generate(words, body.seed, body.method, body.exact, places=places)
        name = page.made.put(MadeMotion(made, blocks=blocks))
        return generate_reply(made, [made_reply(db, made, name, blocks=blocks)])
