"""Routes of scenes: make, update, keep, and their reports."""

from __future__ import annotations

import secrets
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from fastapi import APIRouter
from pydantic import Field, TypeAdapter, ValidationError

from motiondb import answers
from motiondb.database.scenes.scene_folder import report_facts
from motiondb.database.scenes.scene_texts import TACTICS, read_board
from motiondb.page.errors import ERRORS, PageError
from motiondb.page.jobs import FACTS_FILE, JobReply
from motiondb.page.refs import Ref, find_kept, read_ref
from motiondb.page.replies import SceneReply, kept_scene_reply
from motiondb.page.routes.boards import BoardBody, read_board_text
from motiondb.page.routes.parameters import Body, RefText, Seed, Text
from motiondb.page.state import Page

Minutes = Annotated[float, Field(gt=0.0, le=10_000.0, allow_inf_nan=False)]
_REPLY = TypeAdapter(SceneReply)


class SceneBody(BoardBody):
    """A diagram as text, as JSON or by name, and the settings for its scene."""

    board: Annotated[str, Field(min_length=1, max_length=60)] | None = None
    seed: Seed = 0
    rounds: Annotated[int, Field(ge=1, le=10_000)] = 70
    minutes: Minutes | None = None
    chains: Annotated[int, Field(ge=1, le=64)] = 4
    gaze: bool = True


class UpdateBody(BoardBody):
    """A changed diagram, and the scene to start from."""

    scene: Text
    seed: Seed | None = None
    minutes: Minutes | None = None


class KeepBody(Body):
    """A scene, and the name under which it is kept."""

    ref: Text
    name: Annotated[str, Field(min_length=1, max_length=100)]


@dataclass(frozen=True, kw_only=True)
class ListedScene(answers.SceneRow):
    """A scene in a list, with its ref."""

    ref: str


@dataclass(frozen=True)
class ScenesReply:
    """The scenes of this server and of the database."""

    scenes: list[ListedScene]


@dataclass(frozen=True)
class SceneKept:
    """The ref of a scene that is kept."""

    ref: str


def router(page: Page) -> APIRouter:
    """Return the routes of scenes."""
    routes = APIRouter(tags=["scenes"], responses=ERRORS)

    @routes.post("/api/scenes", status_code=202)
    def make(body: SceneBody) -> JobReply:
        """Make a scene of a diagram, as a job."""
        if body.board is not None and (body.text is not None or body.diagram is not None):
            raise PageError("scene: expected a board or a text, found both.")
        if body.board is not None:
            text = read_board_text(page.settings.boards_folder, body.board)[0]
        else:
            text = body.to_text()
        settings = body.model_dump(include={"seed", "rounds", "minutes", "chains", "gaze"})
        parameters = _new_scene(page, text) | {"settings": settings}
        return page.jobs.start("scene", f"scene of {_title(text)}", parameters).reply()

    @routes.post("/api/scenes/update", status_code=202)
    def update(body: UpdateBody) -> JobReply:
        """Make the scene of a changed diagram from an earlier scene; a newer one cancels it."""
        text = body.to_text()
        ref = read_ref(body.scene)
        earlier: dict[str, Any] = {"name": ref.name, "folder": None}
        if ref.kind == "scene":
            earlier["folder"] = str(page.scene_folder(ref.name))
        elif ref.kind == "kept":
            with page.held.use() as db:
                find_kept(db, ref.name)
        else:
            raise _no_scene(ref)
        settings = body.model_dump(include={"seed", "minutes"}, exclude_none=True)
        parameters = _new_scene(page, text) | {"earlier": earlier, "settings": settings}
        page.jobs.drop_waiting("scene-update")
        return page.jobs.start("scene-update", f"update of {_title(text)}", parameters).reply()

    _scene_routes(routes, page)
    return routes


def _scene_routes(routes: APIRouter, page: Page) -> None:
    """Add the routes of existing scenes."""

    @routes.get("/api/scenes")
    def scenes() -> ScenesReply:
        """The scenes that this server made, and the scenes kept in the database."""
        rows = []
        for name in page.scene_ids():
            with suppress(OSError, ValidationError):  # one unreadable scene must not hide the rest
                rows.append(_listed(f"scene:{name}", _read(page, name).report))
        with page.held.use() as db:
            rows += [
                _listed(f"kept:{name}", report_facts(db.scenes.load(name)))
                for name in db.scenes.names()
            ]
        return ScenesReply(rows)

    @routes.get("/api/scene")
    def scene(ref: RefText) -> SceneReply:
        """A scene: its diagram, its report with every rule, and the times of its actions."""
        kept_ref = read_ref(ref)
        if kept_ref.kind == "scene":
            return _read(page, kept_ref.name)
        if kept_ref.kind != "kept":
            raise _no_scene(kept_ref)
        with page.reading() as db:
            return kept_scene_reply(db, find_kept(db, kept_ref.name))

    @routes.post("/api/scenes/keep")
    def keep(body: KeepBody) -> SceneKept:
        """Keep a scene in the database, with its players' motions as captures."""
        page.check_writable()
        ref = read_ref(body.ref)
        if ref.kind != "scene":
            raise _no_scene(ref)
        parameters = {
            "scene": ref.name,
            "folder": str(page.scene_folder(ref.name)),
            "name": body.name,
        }
        return SceneKept(**page.jobs.ask_scene_worker("scene-keep", "keep the scene", parameters))

    @routes.delete("/api/scene", response_model_exclude_none=True)
    def remove(ref: RefText) -> answers.Removed:
        """Remove a kept scene with its players' captures."""
        page.check_writable()
        kept_ref = read_ref(ref)
        if kept_ref.kind != "kept":
            raise _no_scene(kept_ref)
        with page.held.use() as db:
            find_kept(db, kept_ref.name)
            return answers.Removed(kept_ref.name, db.scenes.remove(kept_ref.name))


def _no_scene(ref: Ref) -> PageError:
    return PageError(f"ref: expected a scene, found {str(ref)[:100]!r}.")


def _read(page: Page, name: str) -> SceneReply:
    """Return the facts that a worker wrote."""
    return _REPLY.validate_json((page.scene_folder(name) / FACTS_FILE).read_bytes())


def _listed(ref: str, report: answers.SceneAnswer) -> ListedScene:
    return answers.extended(ListedScene, report, ref=ref)


def _title(text: str) -> str:
    diagram = read_board(text).diagram
    return diagram.name if diagram else "a diagram"


def _new_scene(page: Page, text: str) -> dict[str, Any]:
    """Return the id and the folder of a new scene; the diagram gets a separate folder."""
    name = f"s{secrets.token_hex(5)}"
    folder: Path = page.folder / "scenes" / name
    folder.mkdir(mode=0o700)
    diagram = folder / f"board{TACTICS}"
    diagram.write_text(text, encoding="utf-8")
    return {"scene": name, "folder": str(folder), "diagram": str(diagram)}
