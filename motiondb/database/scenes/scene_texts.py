"""A tactics diagram with its grammar, and the verbs on such texts, which need no database."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from importlib import resources
from pathlib import Path

from motiondb.errors import Fault, SceneError, suggestion
from motiondb.files.safe_files import is_file, read_bounded_text
from motiondb.scene.language.expressions import expressions
from motiondb.scene.language.grammar_file import read_motion_grammar
from motiondb.scene.language.motion_grammar import MotionGrammar
from motiondb.scene.language.possession import check_diagram, first_holder
from motiondb.scene.language.tactics import Diagram
from motiondb.scene.language.tactics_file import grammar_name, parse_diagram, read_diagram
from motiondb.scene.services import casting

# Motion grammars and tactics diagrams from files, or the shipped ones by name.


GRAMMAR, TACTICS = ".grammar", ".tactics"
_FOLDERS = {GRAMMAR: "grammars", TACTICS: "diagrams"}
_KINDS = {GRAMMAR: "motion grammar", TACTICS: "tactics diagram"}


def shipped(ending: str) -> tuple[str, ...]:
    """Return the names, without ending, of the shipped files with an ending.

    >>> shipped(GRAMMAR)
    ('basketball', 'carrying', 'delivery', 'meeting', 'sparring')
    """
    folder = resources.files("motiondb.scene").joinpath(_FOLDERS[ending])
    names = [entry.name for entry in folder.iterdir()]
    return tuple(sorted(name.removesuffix(ending) for name in names if name.endswith(ending)))


def read_grammar(name: str | Path) -> MotionGrammar:
    """Read a motion grammar from a file, or the shipped one of this name."""
    return read_motion_grammar(*text_of(name, GRAMMAR))


@cache
def shipped_grammar(name: str) -> MotionGrammar:
    """Return the shipped grammar of a name, whatever files the working folder holds."""
    return read_motion_grammar(shipped_text(name, GRAMMAR), name)


def grammar_file(grammar: str, beside: str | Path = "") -> str | Path:
    """Return the file of a grammar beside a diagram's, or the name of a shipped one."""
    path = Path(beside).parent / f"{grammar}{GRAMMAR}"
    return path if beside and is_file(path) else grammar


def shipped_text(name: str, ending: str) -> str:
    """Return the text of a shipped file, and of no other."""
    if name not in shipped(ending):
        near = suggestion(name, shipped(ending)) or f" There are: {', '.join(shipped(ending))}."
        raise SceneError(f"{name}: expected a shipped {_KINDS[ending]}, found no such name.{near}")
    folder = resources.files("motiondb.scene").joinpath(_FOLDERS[ending])
    return folder.joinpath(name + ending).read_text(encoding="utf-8")


def text_of(name: str | Path, ending: str) -> tuple[str, str]:
    """Return the text of a file or of a shipped one, and its name in messages."""
    path = Path(name)
    plain = str(name).removesuffix(ending)
    if not is_file(path) and plain in shipped(ending):
        return shipped_text(plain, ending), plain + ending
    try:
        return read_bounded_text(path), str(name)
    except UnicodeDecodeError:
        raise SceneError(
            f"{name}: expected text in UTF-8, found other bytes. Is it a {_KINDS[ending]}?"
        ) from None
    except OSError as error:
        near = suggestion(plain, shipped(ending)) or (
            f" Name a file, or one of {', '.join(shipped(ending))}."
        )
        raise SceneError(
            f"{name}: expected a {_KINDS[ending]}, found: {error.strerror or error}.{near}"
        ) from None


@dataclass(frozen=True, eq=False)
class SceneText:
    """A diagram and its grammar, with the texts that they were read from."""

    diagram: Diagram
    """The tactics diagram."""
    grammar: MotionGrammar
    """The motion grammar that it is played by."""
    diagram_text: str
    """The text of the diagram."""
    grammar_text: str
    """The text of the grammar."""

    @property
    def first_holder(self) -> str:
        """The player who has the object at first, or "" if no element needs it."""
        return first_holder(self.diagram)

    @cached_property
    def expressions(self) -> Mapping[str, str]:
        """What the diagram requires of each player, such as ``(hold)(pass)(run)*(catch)``."""
        items_of = expressions(self.diagram)
        return {name: "".join(map(str, items)) for name, items in items_of.items()}

    @cached_property
    def shortest(self) -> Mapping[str, tuple[str, ...]]:
        """The shortest string of actions of each player that the grammar and the diagram allow."""
        trees = casting.cast(self.diagram, self.grammar)
        return {name: tree.leaves() for name, tree in trees.items()}

    @property
    def actions(self) -> tuple[str, ...]:
        """The actions that the diagram asks for, each once."""
        rows = expressions(self.diagram).values()
        return tuple(dict.fromkeys(a for row in rows for item in row for a in item.actions))


def read_scene_text(diagram: str | os.PathLike[str]) -> SceneText:
    """Read a tactics diagram with its grammar, which must allow what is drawn.

    A grammar beside the file is preferred to a shipped one.
    """
    text, where = text_of(str(diagram), TACTICS)
    file = grammar_file(grammar_name(text), str(diagram))
    grammar_text, grammar_where = text_of(file, GRAMMAR)
    grammar = read_motion_grammar(grammar_text, grammar_where)
    read = read_diagram(text, where, grammar.activity)
    casting.cast(read, grammar, where)
    return SceneText(read, grammar, text, grammar_text)


def stored_text(diagram: str, grammar: str, name: str) -> SceneText:
    """Read the texts of a scene that was made earlier.

    Grammars of earlier versions did not say what a diagram draws. For one that is shipped with the
    same actions, the shipped one says it.
    """
    known = read_motion_grammar(grammar, f"{name}: grammar", is_kept=True)
    if known.name in shipped(GRAMMAR) and not known.activity.declared:
        newer = shipped_grammar(known.name)
        if newer.terminal.keys() == known.terminal.keys():
            asked = newer.only_asked
            terminals = [replace(one, asked=one.name in asked) for one in known.terminals]
            known = replace(known, activity=newer.activity, terminals=tuple(terminals))
    read = read_diagram(diagram, f"{name}: diagram", known.activity, is_kept=True)
    return SceneText(read, known, diagram, grammar)


# Facts of a tactics diagram before a scene is made: faults, first holder, strings, clips.

WHERE = "board"  # Name of the diagram in messages
LONGEST_TEXT = 100_000
"""Most characters of a diagram. Chosen by hand: the longest shipped one has 1,500."""


@dataclass(frozen=True)
class BoardFault:
    """Why a diagram cannot be played."""

    line: int  # Line of the text, from 1; 0 if it is about the whole diagram
    message: str  # The sentence, without the place
    player: str = ""  # The player who cannot do what the diagram requires, or ""
    # What kind of fault it is, "" if only its sentence tells, and what it is about: what was
    # expected and found, what to do, and what belongs to the kind
    code: str = ""
    fields: Mapping[str, str] = field(default_factory=dict)


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
    """Return the facts of the text of a diagram with a shipped grammar.

    A program with a board asks after every change. No exception is raised for a diagram that cannot
    be played: every fault is returned with its line.
    """
    if len(text) > LONGEST_TEXT:
        raise SceneError(
            f"{WHERE}: expected at most {LONGEST_TEXT} characters, found {len(text)}. Shorten it."
        )
    grammar, unknown = None, ""
    try:
        name = grammar_name(text)
        try:
            grammar = shipped_grammar(name)
        except SceneError as error:
            unknown = str(error)
        diagram = parse_diagram(text, WHERE, grammar.activity if grammar else None)
    except SceneError as error:
        return Board(text, faults=_faults(error))
    if grammar is None:
        return Board(text, diagram, faults=(BoardFault(0, unknown),))
    try:
        check_diagram(diagram, WHERE)
        trees, unable = casting.try_cast(diagram, grammar, WHERE)
    except SceneError as error:
        return Board(text, diagram, grammar, _faults(error))
    faults = tuple(_fault(fault, name) for name, fault in unable.items())
    asked = expressions(diagram)
    return Board(
        text,
        diagram,
        grammar,
        faults,
        first_holder(diagram),
        {name: tree.leaves() for name, tree in trees.items()},
        {name: "".join(map(str, items)) for name, items in asked.items()},
    )


def _faults(error: SceneError) -> tuple[BoardFault, ...]:
    """Return the faults of an error."""
    told = tuple(_fault(fault) for fault in error.faults)
    return told or (BoardFault(0, str(error).removeprefix(f"{WHERE}: ")),)


def _fault(fault: Fault, player: str = "") -> BoardFault:
    said = {"expected": fault.expected, "found": fault.found, "advice": fault.advice}
    return BoardFault(fault.line, str(fault), player, fault.code, {**said, **fault.fields})


def element_faults(board: Board) -> tuple[str, ...]:
    """Return for each element of the diagram why it cannot be played, or ""."""
    if board.diagram is None:
        return ()
    told: dict[int, str] = {}
    for fault in board.faults:
        told.setdefault(fault.line, fault.message)
    return tuple(told.get(element.line, "") for element in board.diagram.elements)
