"""A tactics diagram with its grammar, and the verbs on such texts, which need no database."""

from __future__ import annotations

import os
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from motiondb import pictures
from motiondb.database.scenes import scene_files
from motiondb.database.scenes.scene_files import GRAMMAR, TACTICS, grammar_file, text_of
from motiondb.scene.language.expressions import expressions
from motiondb.scene.language.grammar_file import read_motion_grammar
from motiondb.scene.language.motion_grammar import MotionGrammar
from motiondb.scene.language.possession import first_holder
from motiondb.scene.language.tactics import Diagram
from motiondb.scene.language.tactics_file import read_diagram
from motiondb.scene.services import casting, services


@dataclass(frozen=True, eq=False)
class SceneText:
    """A diagram and its grammar, with the texts that they were read from.

    Attributes
    ----------
    diagram : Diagram
        The tactics diagram.
    grammar : MotionGrammar
        The motion grammar that it is played by.
    diagram_text : str
        The text of the diagram.
    grammar_text : str
        The text of the grammar.
    """

    diagram: Diagram
    grammar: MotionGrammar
    diagram_text: str
    grammar_text: str

    @property
    def first_holder(self) -> str:
        """The player who has the ball at first, or "" if no element needs a ball."""
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
    """Read a diagram by its file or name, with its grammar, which must allow it."""
    text, where = text_of(str(diagram), TACTICS)
    read = read_diagram(text, where)
    grammar_text, grammar_where = text_of(grammar_file(read, str(diagram)), GRAMMAR)
    grammar = read_motion_grammar(grammar_text, grammar_where)
    casting.cast(read, grammar, where)
    return SceneText(read, grammar, text, grammar_text)


class SceneTextVerbs:
    """Verbs on motion grammars and tactics diagrams; none of them needs an open database.

    ``grammar`` is a file, the name of a shipped grammar, or a MotionGrammar. Actions are given as
    names separated by spaces, or as a sequence of names. A SceneError is raised if a file has a
    fault.
    """

    @staticmethod
    def read_grammar(grammar: str | Path | MotionGrammar) -> MotionGrammar:
        """Read a motion grammar from a file, or the shipped one of this name."""
        return grammar if isinstance(grammar, MotionGrammar) else scene_files.read_grammar(grammar)

    @classmethod
    def check_grammar(cls, grammar: str | Path | MotionGrammar) -> services.GrammarReport:
        """Report conflicts, useless and empty symbols of a grammar.

        Parameters
        ----------
        grammar : str, Path or MotionGrammar
            The grammar.
        """
        return services.check(cls.read_grammar(grammar))

    @classmethod
    def validate(
        cls, grammar: str | Path | MotionGrammar, actions: str | Sequence[str], start: str = ""
    ) -> services.Validation:
        """Parse a string of actions: its tree, or the place and reason of the failure.

        Parameters
        ----------
        grammar : str, Path or MotionGrammar
            The grammar.
        actions : str or sequence of str
            The actions in their order.
        start : str
            The start symbol; by default any that fits.

        Raises
        ------
        SceneError
            There is no such start symbol, or there are too many actions.
        """
        return services.validate(cls.read_grammar(grammar), _names(actions), start)

    @classmethod
    def suggest(
        cls, grammar: str | Path | MotionGrammar, actions: str | Sequence[str], start: str = ""
    ) -> services.Suggestions:
        """Return the actions that may come next, with the probabilities of the grammar's rules.

        Parameters
        ----------
        grammar : str, Path or MotionGrammar
            The grammar.
        actions : str or sequence of str
            The actions so far.
        start : str
            The start symbol; by default any that fits.

        Raises
        ------
        SceneError
            No string of the grammar begins with these actions.
        """
        return services.suggest(cls.read_grammar(grammar), _names(actions), start)

    @classmethod
    def plan(
        cls,
        grammar: str | Path | MotionGrammar,
        actions: str | Sequence[str],
        goals: Sequence[str | Collection[str]],
        start: str = "",
    ) -> tuple[str, ...]:
        """Return the shortest string that continues some actions and reaches goals in order.

        Parameters
        ----------
        grammar : str, Path or MotionGrammar
            The grammar.
        actions : str or sequence of str
            The actions so far.
        goals : sequence of str or collection of str
            Actions to reach, in this order; any member of a collection will do.
        start : str
            The start symbol; by default the first of the grammar.

        Returns
        -------
        tuple of str
            The whole string, which begins with ``actions``.

        Raises
        ------
        SceneError
            The grammar has no such string, or a goal is not one of its actions.
        """
        wanted = [(goal,) if isinstance(goal, str) else tuple(goal) for goal in goals]
        return services.plan(cls.read_grammar(grammar), _names(actions), wanted, start).leaves()

    @staticmethod
    def read_diagram(diagram: str | Path) -> SceneText:
        """Read a tactics diagram from a file, or the shipped one of this name, with its grammar.

        Parameters
        ----------
        diagram : str or Path
            The file or name. A grammar beside the file is preferred to a shipped one.

        Raises
        ------
        SceneError
            Either has a fault, or the grammar does not allow what is drawn.
        """
        return read_scene_text(diagram)

    @classmethod
    def draw_diagram(cls, diagram: str | Path | SceneText, path: str | Path) -> Path:
        """Draw a tactics diagram as PNG.

        Parameters
        ----------
        diagram : str, Path or SceneText
            The diagram.
        path : str or Path
            The picture.

        Raises
        ------
        MotionDBError
            The diagram has a fault, or the picture cannot be written.
        """
        text = diagram if isinstance(diagram, SceneText) else cls.read_diagram(diagram)
        return pictures.draw_tactics(text.diagram, path)


def _names(actions: str | Sequence[str]) -> list[str]:
    return actions.split() if isinstance(actions, str) else list(actions)
