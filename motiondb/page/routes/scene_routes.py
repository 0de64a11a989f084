"""Routes of scenes: make, update, keep, and their reports."""

from __future__ import annotations

import secrets
from pathlib import Path
from typing import Annotated, Any

from fastapi import APIRouter
from pydantic import Field

from motiondb.database.scenes.scene_folder import report_facts
from motiondb.database.scenes.scene_texts import TACTICS, read_board
from motiondb.page.answers import Answer, PageError
from motiondb.page.delivery.refs import Ref, read_ref
from motiondb.page.facts.scene_facts import find_kept, kept_scene_facts, read_scene_facts
from motiondb.page.files.boards import read_board_text
from motiondb.page.parameters import Body, RefText, Seed, Text
from motiondb.page.routes.board_routes import BoardBody
from motiondb.page.schemas import scene_schemas, shared_schemas
from motiondb.page.session.state import Page

Minutes = Annotated[float, Field(gt=0.0, le=10_000.0, allow_inf_nan=False)]
_LISTED = ("characters", "clips", "frames", "seconds", "error", "rules", "broken")


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


def router(page: Page) -> APIRouter:
    """Return the routes of scenes."""
    routes = APIRouter(tags=["scenes"])

    @routes.post("/api/scenes", response_model=shared_schemas.JobFacts, status_code=202)
    def make(body: SceneBody) -> Answer:
        """Make a scene of a diagram, as a job."""
        if body.board is not None and (body.text is not None or body.diagram is not None):
            raise PageError("scene: expected a board or a text, found both.")
        if body.board is not None:
            text = read_board_text(page.settings.boards_folder, body.board)[0]
        else:
            text = body.to_text()
        settings = {
            key: getattr(body, key) for key in ("seed", "rounds", "minutes", "chains", "gaze")
        }
        parameters = _new_scene(page, text) | {"settings": settings}
        job = page.jobs.start("scene", f"scene of {_title(text)}", parameters)
        return Answer(job.facts(), 202)

    @routes.post("/api/scenes/update", response_model=shared_schemas.JobFacts, status_code=202)
    def update(body: UpdateBody) -> Answer:
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
        known = {"seed": body.seed, "minutes": body.minutes}
        settings = {key: value for key, value in known.items() if value is not None}
        parameters = _new_scene(page, text) | {"earlier": earlier, "settings": settings}
        page.jobs.drop_waiting("scene-update")
        job = page.jobs.start("scene-update", f"update of {_title(text)}", parameters)
        return Answer(job.facts(), 202)

    _scene_routes(routes, page)
    return routes


def _scene_routes(routes: APIRouter, page: Page) -> None:
    """Add the routes of existing scenes."""

    @routes.get("/api/scenes", response_model=scene_schemas.SceneRows)
    def scenes() -> Answer:
        """The scenes that this server made, and the scenes kept in the database."""
        rows = [
            {"ref": f"scene:{name}", "name": (facts := _read(page, name))["name"]}
            | {key: facts["report"][key] for key in _LISTED}
            for name in page.scene_ids()
        ]
        with page.held.use() as db:
            for name in db.scenes.names():
                facts = report_facts(db.scenes.load(name))
                rows.append(
                    {"ref": f"kept:{name}", "name": name} | {key: facts[key] for key in _LISTED}
                )
        return Answer({"scenes": rows})

    @routes.get("/api/scene", response_model=scene_schemas.SceneFacts)
    def scene(ref: RefText) -> Answer:
        """A scene: its diagram, its report with every rule, and the times of its actions."""
        kept_ref = read_ref(ref)
        if kept_ref.kind == "scene":
            return Answer({"ref": ref} | _read(page, kept_ref.name))
        if kept_ref.kind != "kept":
            raise _no_scene(kept_ref)
        with page.held.use() as db, db.session.reading():
            record = find_kept(db, kept_ref.name)
            return Answer({"ref": ref} | kept_scene_facts(db, record))

    @routes.post("/api/scenes/keep", response_model=scene_schemas.SceneKept)
    def keep(body: KeepBody) -> Answer:
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
        return Answer(page.jobs.ask_scene_worker("scene-keep", "keep the scene", parameters))

    @routes.delete("/api/scene", response_model=scene_schemas.SceneRemoved)
    def remove(ref: RefText) -> Answer:
        """Remove a kept scene with its players' captures."""
        page.check_writable()
        kept_ref = read_ref(ref)
        if kept_ref.kind != "kept":
            raise _no_scene(kept_ref)
        with page.held.use() as db:
            find_kept(db, kept_ref.name)
            return Answer({"removed": kept_ref.name, "captures": db.scenes.remove(kept_ref.name)})


def _no_scene(ref: Ref) -> PageError:
    return PageError(f"ref: expected a scene, found {str(ref)[:100]!r}.")


def _read(page: Page, name: str) -> dict[str, Any]:
    return read_scene_facts(page.scene_folder(name))


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
