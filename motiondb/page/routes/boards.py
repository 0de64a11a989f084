"""Routes of tactics diagrams (list, check, save) and of the scenes that are made from them.

The user's diagrams are text files in one folder, the same that the command line reads.
"""

from __future__ import annotations

import re
import secrets
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from fastapi import APIRouter
from pydantic import Field, TypeAdapter, ValidationError

from motiondb import answers
from motiondb.answers.database import Removed
from motiondb.database import MotionDB
from motiondb.database.scenes.scene_folder import report_facts
from motiondb.database.scenes.scene_texts import (
    GRAMMAR,
    LONGEST_TEXT,
    TACTICS,
    BoardFault,
    element_faults,
    read_board,
    shipped,
    shipped_grammar,
    shipped_text,
)
from motiondb.files.safe_files import read_bounded, write_bytes
from motiondb.page.diagrams import (
    DiagramShape,
    GroundShape,
    RequestedDiagram,
    diagram_shape,
    ground_shape,
    text_of,
)
from motiondb.page.errors import ERRORS, PageError, unknown
from motiondb.page.jobs import FACTS_FILE, JobReply
from motiondb.page.replies import SceneReply, kept_scene_reply
from motiondb.page.routes.parameters import Body, Name, RefText, Seed, Text
from motiondb.page.state import Page, Ref, find_kept, read_ref
from motiondb.scene.language.activity import Activity

NAME = r"[A-Za-z0-9][A-Za-z0-9_-]{0,59}"
"""Names of diagrams: file names that are valid on every system."""
_TITLE = re.compile(r'^\s*diagram\s+"([^"]*)"', re.MULTILINE)
_RESERVED = re.compile(r"(?i)(con|prn|aux|nul|com[0-9]|lpt[0-9])")


@dataclass(frozen=True)
class BoardFile:
    """A diagram that can be opened."""

    name: str
    title: str
    shipped: bool  # Whether it comes with motiondb


@dataclass(frozen=True)
class ElementVerdict:
    """Whether an element can be played."""

    element: int
    feasible: bool
    reason: str | None


@dataclass(frozen=True)
class PlayerVerdict:
    """What the diagram requires of a player."""

    name: str
    shortest: tuple[str, ...]
    expression: str
    reason: str | None


@dataclass(frozen=True, kw_only=True)
class BoardReply:
    """A diagram, with its faults and clips; `diagram` is None where the text is not a diagram."""

    name: str
    shipped: bool
    text: str
    diagram: DiagramShape | None
    feasible: bool
    fault: str | None
    line: int | None
    faults: tuple[BoardFault, ...]
    holder: str | None
    elements: list[ElementVerdict]
    players: list[PlayerVerdict]
    clips: dict[str, int]
    without_clips: list[str]


@dataclass(frozen=True)
class BoardsReply:
    """The shipped diagrams and the user's."""

    boards: list[BoardFile]


@dataclass(frozen=True)
class BoardVerb:
    """What a diagram of a grammar may draw."""

    name: str
    link: str  # The word before the other player or place; "" if none is needed
    role: str  # Who is meant: a role or a place
    goes: bool  # Whether it ends at a point of the ground
    look: str  # How it is drawn: way, give, send, link or act
    holding: str  # How it is drawn for who has the object
    bar: bool  # Whether a bar is drawn at its end, where something is done
    declared: bool  # Whether the grammar declares it beside its actions


@dataclass(frozen=True)
class Ground:
    """What a diagram of a grammar may hold."""

    grammar: str
    verbs: list[BoardVerb]
    teams: tuple[str, ...]  # Roles of players
    places: tuple[str, ...]  # Places that a diagram must give
    object: str  # What the object is called, or ""
    ground: GroundShape


@dataclass(frozen=True)
class BoardKinds:
    """The grammars of diagrams, and what a diagram of each may hold."""

    grammars: tuple[str, ...]
    grounds: list[Ground]


def ground_of(name: str) -> Ground:
    """Return what a diagram of a shipped grammar may hold."""
    grammar = shipped_grammar(name)
    activity = grammar.activity
    asked = {start.team for start in grammar.starts}
    teams = activity.teams if "" in asked else activity.teams[:-1]
    places = tuple(place.name for place in activity.places if place.at is None)
    verbs = [_board_verb(activity, verb) for verb in activity.verbs]
    thing = activity.thing.name if activity.thing else ""
    return Ground(name, verbs, teams, places, thing, ground_shape(activity.ground))


def _board_verb(activity: Activity, name: str) -> BoardVerb:
    verb = activity.verb(name)
    look, holding = activity.look(name, False), activity.look(name, True)
    rest = len(verb.steps) > 1, verb.declared
    return BoardVerb(name, verb.link, verb.role, verb.goes, look, holding, *rest)


def list_boards(folder: Path) -> list[BoardFile]:
    """Return the shipped diagrams and the user's, each by name."""
    known = [
        BoardFile(name, _title(shipped_text(name, TACTICS), name), True)
        for name in shipped(TACTICS)
    ]
    for path in sorted(folder.glob(f"*{TACTICS}")) if folder.is_dir() else ():
        name = path.name.removesuffix(TACTICS)
        if re.fullmatch(NAME, name) and name not in shipped(TACTICS) and _is_own(path):
            known.append(BoardFile(name, _title(_read(path), name), False))
    return known


def read_board_text(folder: Path, name: str) -> tuple[str, bool]:
    """Return the text of a diagram, and whether it is a shipped one."""
    if name in shipped(TACTICS):
        return shipped_text(name, TACTICS), True
    path = board_path(folder, name)
    if not _is_own(path):
        raise unknown("board", name)
    return _read(path), False


def save_board(folder: Path, name: str, text: str) -> None:
    """Write a diagram into the folder, which is created if it is missing."""
    path = board_path(folder, name)
    if name in shipped(TACTICS):
        raise PageError(
            f"{name}: expected another name than those of the shipped diagrams. Choose one.",
            "ConflictError",
        )
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise PageError(
            f"{folder.name}: expected a folder for boards, found: {error.strerror}."
        ) from None
    if path.is_symlink() or (path.exists() and not path.is_file()):
        raise PageError(f"{name}: expected a file, found something else. Choose another name.")
    write_bytes(path, text.encode())


def remove_board(folder: Path, name: str) -> None:
    """Delete a diagram of the user."""
    path = board_path(folder, name)
    if not _is_own(path):
        raise unknown("board", name, "Shipped ones stay.")
    path.unlink()


def board_path(folder: Path, name: str) -> Path:
    """Return the path of a diagram; a name that contains a path is refused."""
    if not re.fullmatch(NAME, name) or _RESERVED.fullmatch(name):
        raise PageError(
            f"board: expected a name of letters, digits, - and _, found {name[:100]!r}."
        )
    return folder / f"{name}{TACTICS}"


def _is_own(path: Path) -> bool:
    return path.is_file() and not path.is_symlink()


def _read(path: Path) -> str:
    return read_bounded(path).decode("utf-8-sig", "replace")


def _title(text: str, name: str) -> str:
    matched = _TITLE.search(text)
    return matched[1] if matched and matched[1] else name


class BoardBody(Body):
    """A diagram as text or as JSON; exactly one of them is given."""

    text: Annotated[str, Field(max_length=LONGEST_TEXT)] | None = None
    diagram: RequestedDiagram | None = None

    def to_text(self) -> str:
        """Return the text of the diagram."""
        if (self.text is None) == (self.diagram is None):
            raise PageError("board: expected either text or diagram, found neither or both.")
        if self.diagram is not None:
            name = self.diagram.grammar
            known = shipped_grammar(name).activity if name in shipped(GRAMMAR) else None
            return text_of(self.diagram, known)
        return self.text or ""


class NamedBoardBody(BoardBody):
    """A diagram, and the name under which it is saved."""

    name: Annotated[str, Field(min_length=1, max_length=60)]


def router(page: Page) -> APIRouter:
    """Return the routes of tactics diagrams."""
    routes = APIRouter(tags=["boards"], responses=ERRORS)
    folder = page.settings.boards_folder

    @routes.get("/api/boards")
    def boards() -> BoardsReply:
        """The shipped diagrams and the user's."""
        return BoardsReply(list_boards(folder))

    @routes.get("/api/board/kinds")
    def kinds() -> BoardKinds:
        """The grammars, and what a diagram of each may hold: verbs, roles, places and ground."""
        names = shipped(GRAMMAR)
        return BoardKinds(names, [ground_of(name) for name in names])

    @routes.get("/api/board")
    def board(name: Name) -> BoardReply:
        """A diagram, with its faults and clips."""
        text, is_shipped = read_board_text(folder, name)
        with page.held.use() as db:
            return _reply(db, text, name, is_shipped)

    @routes.post("/api/board/check")
    def check(body: BoardBody) -> BoardReply:
        """The faults of a diagram, with each element that cannot be played, and its clips."""
        text = body.to_text()
        with page.held.use() as db:
            return _reply(db, text)

    @routes.put("/api/board")
    def save(body: NamedBoardBody) -> BoardReply:
        """Save a diagram as the text file that the command line reads."""
        page.check_writable()
        text = body.to_text()
        save_board(folder, body.name, text)
        with page.held.use() as db:
            return _reply(db, text, body.name)

    @routes.delete("/api/board", response_model_exclude_none=True)
    def remove(name: Name) -> Removed:
        """Delete a diagram of the user."""
        page.check_writable()
        remove_board(folder, name)
        return Removed(name)

    return routes


def _reply(db: MotionDB, text: str, name: str = "", is_shipped: bool = False) -> BoardReply:
    """Return a diagram with its faults, shortest strings of actions, and number of clips."""
    board = read_board(text)
    clips: dict[str, int] = {}
    if board.grammar is not None and board.actions:
        found = db.scenes.find_actions(board.grammar)
        clips = {action: len(found.get(action, ())) for action in board.actions}
    about = {fault.player: fault.message for fault in board.faults if fault.player}
    by_line = {fault.line: fault.message for fault in board.faults}
    return answers.extended(
        BoardReply,
        board,
        name=name,
        shipped=is_shipped,
        diagram=diagram_shape(board.diagram) if board.diagram else None,
        feasible=not board.faults,
        fault="\n".join(fault.message for fault in board.faults) or None,
        line=next((fault.line for fault in board.faults if fault.line), None),
        elements=[
            ElementVerdict(number, not reason, reason or None)
            for number, reason in enumerate(element_faults(board))
        ],
        players=[
            PlayerVerdict(
                player.name,
                board.strings.get(player.name, ()),
                board.expressions.get(player.name, ""),
                about.get(player.name) or by_line.get(player.line),
            )
            for player in (board.diagram.players if board.diagram else ())
        ],
        clips=clips,
        without_clips=[action for action, count in clips.items() if not count],
    )


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


def scene_router(page: Page) -> APIRouter:
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
        return page.jobs.start("scene", f"scene of {_title_in(text)}", parameters).reply()

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
        return page.jobs.start("scene-update", f"update of {_title_in(text)}", parameters).reply()

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
                rows.append(_listed(f"scene:{name}", _read_made(page, name).report))
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
            return _read_made(page, kept_ref.name)
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


def _read_made(page: Page, name: str) -> SceneReply:
    """Return the facts that a worker wrote."""
    return _REPLY.validate_json((page.scene_folder(name) / FACTS_FILE).read_bytes())


def _listed(ref: str, report: answers.SceneAnswer) -> ListedScene:
    return answers.extended(ListedScene, report, ref=ref)


def _title_in(text: str) -> str:
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
