"""Facts of a tactics diagram before a scene is made: faults, first holder, strings, clips.

A program with a board asks after every change. No exception is raised for a diagram that cannot be
played: every fault is returned with its line.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from motiondb.database.scenes.scene_clips import ShownAction
from motiondb.database.scenes.scene_files import GRAMMAR, shipped_text
from motiondb.errors import SceneError
from motiondb.scene.language import expressions, possession
from motiondb.scene.language.grammar_file import read_motion_grammar
from motiondb.scene.language.motion_grammar import MotionGrammar
from motiondb.scene.language.tactics import Diagram
from motiondb.scene.language.tactics_file import parse_diagram
from motiondb.scene.services import casting

WHERE = "board"  # Name of the diagram in messages
_LINE = re.compile(rf"{WHERE}:(\d+)(?::\d+)?: ?")
LONGEST_TEXT = 100_000
"""Most characters of a diagram. Chosen by hand: the longest shipped one has 1,500."""


@dataclass(frozen=True)
class BoardFault:
    """Why a diagram cannot be played."""

    line: int  # Line of the text, from 1; 0 if it is about the whole diagram
    message: str  # The sentence, without the place
    player: str = ""  # The player who cannot do what the diagram requires, or ""


@dataclass(frozen=True, eq=False)
class Board:
    """A diagram with its facts."""

    text: str
    diagram: Diagram | None = None  # The diagram; None if the text cannot be read
    grammar: MotionGrammar | None = None  # Its grammar; None if there is none of this name
    faults: tuple[BoardFault, ...] = ()  # Why it cannot be played; none for one that can
    holder: str = ""  # Name of the player who has the ball at first, or ""
    # Shortest string of actions of each player who can do what the diagram requires
    strings: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    # The requirements of each player, in the notation of the paper
    expressions: Mapping[str, str] = field(default_factory=dict)

    @property
    def actions(self) -> tuple[str, ...]:
        """Every action that a player needs, once."""
        return tuple(dict.fromkeys(a for string in self.strings.values() for a in string))


def read_board(text: str) -> Board:
    """Return the facts of the text of a diagram with a shipped grammar."""
    if len(text) > LONGEST_TEXT:
        raise SceneError(
            f"{WHERE}: expected at most {LONGEST_TEXT} characters, found {len(text)}. Shorten it."
        )
    try:
        diagram = parse_diagram(text, WHERE)
    except SceneError as error:
        return Board(text, faults=_faults(str(error)))
    try:
        text_of_grammar = shipped_text(diagram.grammar, GRAMMAR)
        grammar = read_motion_grammar(text_of_grammar, diagram.grammar)
    except SceneError as error:
        return Board(text, diagram, faults=(BoardFault(0, str(error)),))
    try:
        possession.check_diagram(diagram, WHERE)
        trees, unable = casting.try_cast(diagram, grammar, WHERE)
    except SceneError as error:
        return Board(text, diagram, grammar, _faults(str(error)))
    faults = tuple(f for name, told in unable.items() for f in _faults(told, name))
    asked = expressions.expressions(diagram)
    return Board(
        text,
        diagram,
        grammar,
        faults,
        possession.first_holder(diagram),
        {name: tree.leaves() for name, tree in trees.items()},
        {name: "".join(map(str, items)) for name, items in asked.items()},
    )


def _faults(message: str, player: str = "") -> tuple[BoardFault, ...]:
    """Return the faults of an error: each begins with the place."""
    faults: list[BoardFault] = []
    for line in message.split("\n"):
        place = _LINE.match(line)
        if place:
            faults.append(BoardFault(int(place[1]), line[place.end() :], player))
        elif faults and not line.startswith(f"{WHERE}: "):
            last = faults.pop()
            faults.append(BoardFault(last.line, f"{last.message}\n{line}", player))
        else:
            faults.append(BoardFault(0, line.removeprefix(f"{WHERE}: "), player))
    return tuple(faults)


def element_faults(board: Board) -> tuple[str, ...]:
    """Return for each element of the diagram why it cannot be played, or ""."""
    if board.diagram is None:
        return ()
    told: dict[int, str] = {}
    for fault in board.faults:
        told.setdefault(fault.line, fault.message)
    return tuple(told.get(element.line, "") for element in board.diagram.elements)


def count_clips(clips: Mapping[str, Sequence[ShownAction]], names: Sequence[str]) -> dict[str, int]:
    """Return the number of clips for each of some actions."""
    return {name: len(clips.get(name, ())) for name in names}
