"""Routes of tactics diagrams: list, check, save."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from fastapi import APIRouter
from pydantic import Field

from motiondb.database import MotionDB
from motiondb.database.scenes.scene_texts import GRAMMAR, LONGEST_TEXT, read_board, shipped
from motiondb.page.answers import Answer, PageError
from motiondb.page.facts.board_facts import board_facts
from motiondb.page.files.boards import list_boards, read_board_text, remove_board, save_board
from motiondb.page.parameters import Body, Name
from motiondb.page.schemas import scene_schemas
from motiondb.page.session.state import Page
from motiondb.scene.language.semantic_rules import Spot
from motiondb.scene.language.tactics import KINDS, TEAMS, Court, Diagram, Element, Player
from motiondb.scene.language.tactics_file import format_diagram

Metres = Annotated[float, Field(ge=-1000.0, le=1000.0, allow_inf_nan=False)]
Point = tuple[Metres, Metres]
PlayerName = Annotated[str, Field(pattern=r"^[^\W\d]\w*$", max_length=60)]
OtherName = Annotated[str, Field(pattern=r"^([^\W\d]\w*)?$", max_length=60)]
MOST = 200  # Largest number of players, elements or places. Chosen by hand: a team has five players


class PlayerBody(Body):
    """A player at the beginning of the play."""

    name: PlayerName
    team: Literal["attack", "defence", "player"]
    at: Point
    guards: OtherName = ""


class ElementBody(Body):
    """An action of a player; ``line`` is ignored."""

    kind: Literal[KINDS]  # type: ignore[valid-type]  # a tuple of literals
    step: Annotated[int, Field(ge=1, le=10_000)]
    player: PlayerName
    other: OtherName = ""
    caught: Annotated[int, Field(ge=0, le=10_000)] = 0
    via: Annotated[list[Point], Field(max_length=MOST, default_factory=list)]
    to: Point | None = None
    line: int | None = None


class CourtBody(Body):
    """The court; ``behind_rim`` is derived from the other values and is ignored."""

    width: Annotated[float, Field(ge=0.0, le=1000.0, allow_inf_nan=False)] = 15.0
    length: Annotated[float, Field(ge=0.0, le=1000.0, allow_inf_nan=False)] = 14.0
    behind_rim: float | None = None
    lines: bool = True


class PlaceBody(Body):
    """A place that rules may refer to."""

    name: PlayerName
    at: Point


class DiagramBody(Body):
    """A tactics diagram; places are [x, z] in metres."""

    title: Annotated[str, Field(pattern=r'^[^"\n\r]*$', max_length=200)]
    grammar: Annotated[str, Field(pattern=r"^[^\W\d]\w*(-\w+)*$", max_length=60)] = "basketball"
    ball: OtherName = ""
    court: CourtBody = CourtBody()
    places: Annotated[list[PlaceBody], Field(max_length=MOST, default_factory=list)]
    players: Annotated[list[PlayerBody], Field(max_length=MOST)]
    elements: Annotated[list[ElementBody], Field(max_length=MOST, default_factory=list)]

    def to_diagram(self) -> Diagram:
        """Return the diagram."""
        rim = () if any(p.name == "rim" for p in self.places) else (("rim", Spot(0.0, 0.0)),)
        court = Court()
        if not self.court.lines:
            sizes = self.court.width, self.court.length
            court = Court(*sizes, behind_rim=sizes[1] / 2, lines=False)
        return Diagram(
            self.title,
            tuple(Player(p.name, p.team, Spot(*p.at), p.guards) for p in self.players),
            tuple(
                Element(
                    e.kind,
                    e.step,
                    e.player,
                    e.other,
                    tuple(Spot(*at) for at in e.via),
                    Spot(*e.to) if e.to else None,
                    e.caught,
                )
                for e in self.elements
            ),
            self.grammar,
            court,
            (*rim, *((p.name, Spot(*p.at)) for p in self.places)),
            self.ball,
        )


class BoardBody(Body):
    """A diagram as text or as JSON; exactly one of them is given."""

    text: Annotated[str, Field(max_length=LONGEST_TEXT)] | None = None
    diagram: DiagramBody | None = None

    def to_text(self) -> str:
        """Return the text of the diagram."""
        if (self.text is None) == (self.diagram is None):
            raise PageError("board: expected either text or diagram, found neither or both.")
        if self.diagram is not None:
            return format_diagram(self.diagram.to_diagram())
        return self.text or ""


class NamedBoardBody(BoardBody):
    """A diagram, and the name under which it is saved."""

    name: Annotated[str, Field(min_length=1, max_length=60)]


def router(page: Page) -> APIRouter:
    """Return the routes of tactics diagrams."""
    routes = APIRouter(tags=["boards"])
    folder = page.settings.boards_folder

    @routes.get("/api/boards", response_model=scene_schemas.BoardRows)
    def boards() -> Answer:
        """The shipped diagrams and the user's."""
        return Answer({"boards": list_boards(folder)})

    @routes.get("/api/board/kinds", response_model=scene_schemas.BoardKinds)
    def kinds() -> Answer:
        """The kinds of elements, the teams, and the grammars."""
        return Answer({"kinds": KINDS, "teams": TEAMS, "grammars": shipped(GRAMMAR)})

    @routes.get("/api/board", response_model=scene_schemas.BoardFacts)
    def board(name: Name) -> Answer:
        """A diagram, with its faults and clips."""
        text, is_shipped = read_board_text(folder, name)
        with page.held.use() as db:
            return Answer(_facts(db, text, name, is_shipped))

    @routes.post("/api/board/check", response_model=scene_schemas.BoardFacts)
    def check(body: BoardBody) -> Answer:
        """The faults of a diagram, with each element that cannot be played, and its clips."""
        text = body.to_text()
        with page.held.use() as db:
            return Answer(_facts(db, text))

    @routes.put("/api/board", response_model=scene_schemas.BoardFacts)
    def save(body: NamedBoardBody) -> Answer:
        """Save a diagram as the text file that the command line reads."""
        page.check_writable()
        text = body.to_text()
        save_board(folder, body.name, text)
        with page.held.use() as db:
            return Answer(_facts(db, text, body.name))

    @routes.delete("/api/board", response_model=scene_schemas.BoardRemoved)
    def remove(name: Name) -> Answer:
        """Delete a diagram of the user."""
        page.check_writable()
        remove_board(folder, name)
        return Answer({"removed": name})

    return routes


def _facts(db: MotionDB, text: str, name: str = "", is_shipped: bool = False) -> dict[str, Any]:
    return board_facts(db, read_board(text), name, is_shipped)
