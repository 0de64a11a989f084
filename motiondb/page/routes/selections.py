"""Routes of selections: captures, and parts of them, that are kept under a name."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from fastapi import APIRouter
from pydantic import Field
from starlette.responses import Response

from motiondb import answers
from motiondb.answers.plain import extended
from motiondb.page.errors import ERRORS, PageError
from motiondb.page.routes.catalogue import MOST_CHANGED, CapturesChanged, noted
from motiondb.page.routes.files import described, plain_name, zipped
from motiondb.page.routes.parameters import Body, Name, Part, Text
from motiondb.page.state import Page, read_ref

_PACK = described("A zip of the motions of a selection, with its manifest.", "application/zip")


class SelectionBody(Body):
    """A selection, and captures or parts of them, by their refs."""

    name: Text
    items: Annotated[list[Part], Field(min_length=1, max_length=MOST_CHANGED)]


@dataclass(frozen=True)
class SelectionsReply:
    """The selections of the database."""

    selections: list[answers.SelectionRow]


@dataclass(frozen=True, kw_only=True)
class PlayablePart(answers.SelectedPart):
    """A part of a selection that can be played."""

    ref: str


@dataclass(frozen=True)
class SelectionReply:
    """What a selection holds."""

    selection: str
    parts: list[PlayablePart]


def router(page: Page) -> APIRouter:
    """Return the routes of selections."""
    routes = APIRouter(tags=["catalogue"], responses=ERRORS)

    @routes.get("/api/selections")
    def selections() -> SelectionsReply:
        """The selections, with their numbers of captures, parts and seconds."""
        with page.held.use() as db:
            return SelectionsReply(db.selections())

    @routes.get("/api/selection")
    def selection(name: Name) -> SelectionReply:
        """What a selection holds, by capture and time."""
        with page.held.use() as db:
            parts = [
                extended(PlayablePart, each, ref=f"capture:{each.capture}")
                for each in db.selections.show(name)
            ]
            return SelectionReply(name, parts)

    @routes.post("/api/selection/add")
    def add(body: SelectionBody) -> CapturesChanged:
        """Put captures, or parts of them, into a selection, which is made if need be."""
        with page.changing() as db:
            parts = _parts(body.items)
            return noted(page, db, "selection", lambda: db.selections.add(body.name, parts))

    @routes.post("/api/selection/take")
    def take(body: SelectionBody) -> CapturesChanged:
        """Take captures, or parts of them, out of a selection."""
        with page.changing() as db:
            parts = _parts(body.items)
            return noted(page, db, "selection", lambda: db.selections.take(body.name, parts))

    @routes.delete("/api/selection")
    def remove(name: Name) -> CapturesChanged:
        """Forget a selection; its captures stay."""
        with page.changing() as db:
            return noted(page, db, "selection", lambda: db.selections.remove(name))

    @routes.get("/api/selection/pack", response_class=Response, responses=_PACK)
    def pack(
        name: Name, format: Literal["bvh", "glb", "fbx", "usd", "npz", "csv", "parquet"] = "bvh"
    ) -> Response:
        """A selection as a zip: a file for each part, and the manifest."""
        with tempfile.TemporaryDirectory(dir=page.folder) as place:
            folder = Path(place) / "pack"
            with page.reading() as db:
                db.selections.export(name, folder, format)
            data = zipped(sorted(path for path in folder.rglob("*") if path.is_file()))
        disposition = f'attachment; filename="{plain_name(name)}.zip"'
        return Response(
            data, media_type="application/zip", headers={"Content-Disposition": disposition}
        )

    return routes


def _parts(items: Sequence[Part]) -> list[tuple[str, float | None, float | None]]:
    """The parts of captures that refs name."""
    refs = [read_ref(item.ref) for item in items]
    for ref in refs:
        if ref.kind != "capture":
            raise PageError(f"{ref}: expected a stored capture, found another motion. Save it.")
    return [(ref.name, item.start, item.end) for ref, item in zip(refs, items)]
