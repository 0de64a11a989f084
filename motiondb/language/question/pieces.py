"""Pieces of a question: words, groups, exclusions; the lower rules of ``question.parse``."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

from motiondb.errors import QueryError
from motiondb.language.question.bare import attach, is_bare, names_words
from motiondb.language.question.say import say
from motiondb.language.question.tokens import Token
from motiondb.language.question.tree import (
    Action,
    Anything,
    Lasting,
    Node,
    NotUsed,
    Repeated,
    at_once,
)

MOST_PARENTHESES = 20
"""Largest depth of nested parentheses. Chosen by hand; questions need two or three."""
_PIECE = ("word", "manner", "count", "duration", "same", "quote", "open", "wild")
"""Kinds of tokens that begin a piece."""


class Pieces(ABC):
    """A place in a list of tokens, and the rules that read pieces there."""

    def __init__(self, tokens: Sequence[Token]) -> None:
        self.tokens = tokens
        self.place = 0  # number of the next token
        self.depth = 0  # open parentheses
        self.same = False  # whether the current part contains "at the same time"
        self.not_used: list[NotUsed] = []  # parts that are not in the tree

    @abstractmethod
    def order(self) -> Node | None:
        """Everything up to the end or a closing parenthesis; None if nothing is asked."""

    @property
    def kind(self) -> str:
        """Kind of the next token, "end" at the end."""
        return self.tokens[self.place].kind if self.place < len(self.tokens) else "end"

    def take(self, *kinds: str) -> Token | None:
        """Return the next token and advance, if it is of one of the given kinds."""
        if self.kind not in kinds:
            return None
        self.place += 1
        return self.tokens[self.place - 1]

    def excluded(self) -> tuple[bool, list[Node]]:
        """The exclusion of a negation; and whether it is one of two that cancel."""
        n_negations, text = 0, []
        while token := self.take("not", "nor", "but_not"):
            n_negations += 1
            text.append(token.text)
        self.take("either")
        verb = self._next_text()
        pieces = [self.piece()]
        while self._goes_on(verb):
            self.place += 1
            pieces.append(self.piece())
        excluded = [p for p in pieces if p is not None and (not is_bare(p) or names_words(p))]
        excluded = [p for p in excluded if not isinstance(p, Anything)]
        if not excluded:
            amounts = [say(p).strip() for p in pieces if p is not None]
            self.not_used.append(
                NotUsed(" ".join([*text, *amounts]), "no action follows that could be excluded")
            )
        return n_negations % 2 == 0, excluded

    def _next_text(self) -> str:
        return self.tokens[self.place].text.lower() if self.kind == "word" else ""

    def _goes_on(self, verb: str) -> bool:
        """Whether the next token joins another piece to the excluded ones."""
        following = self.tokens[self.place + 1 : self.place + 2]
        if not following or following[0].kind not in _PIECE:
            return False
        if self.kind in ("or", "nor"):
            return True
        if self.kind == "and":
            return verb.endswith("ing") and following[0].text.lower().endswith("ing")
        return self.kind == "comma" and self._list_closes()

    def _list_closes(self) -> bool:
        """Whether the list that continues with the next comma closes with "or" or "nor"."""
        for token in self.tokens[self.place + 1 :]:
            if token.kind in ("or", "nor"):
                return True
            if token.kind not in ("comma", "word", "manner", "quote"):
                return False
        return False

    def piece(self) -> Node | None:
        """Words with their manners and amounts, a wildcard, or a group in parentheses."""
        if self.take("wild"):
            return self._lasting_anything()
        node: Node | None = None
        grouped = False
        while self.kind in _PIECE and self.kind != "wild":
            start = self.place
            opens = self.kind == "open"
            part = self._group() if opens else self._words()
            if part is None:
                continue
            if node is None:
                node, grouped = part, opens
            elif is_bare(part):
                node = attach(node, part)
            elif is_bare(node):
                node, grouped = attach(part, node), opens
            elif not opens:
                self.place = start
                break
            elif isinstance(part, Action) and isinstance(node, Action) and not grouped:
                node = Action((*node.words, *part.words), (*node.manner, *part.manner))
            else:
                node, grouped = at_once([node, part]), True
        return node

    def _lasting_anything(self) -> Node:
        """Any action, with the amounts that follow."""
        node: Node = Anything()
        while self.kind in ("count", "duration"):
            node = _amount(node, self.tokens[self.place])
            self.place += 1
        return node

    def _group(self) -> Node | None:
        """The part in parentheses."""
        self.take("open")
        self.depth += 1
        if self.depth > MOST_PARENTHESES:
            raise QueryError(
                f"question: expected at most {MOST_PARENTHESES} nested parentheses, "
                "found more. Ask for less at a time."
            )
        same, self.same = self.same, False
        node = self.order()
        self.same = same
        self.depth -= 1
        if not self.take("close"):
            raise QueryError(
                "question: expected ')' for every '(', found the end. Close the parentheses."
            )
        return node

    def _words(self) -> Node | None:
        """A run of words, manners and amounts; None if it holds nothing."""
        if token := self.take("quote"):
            return Action(token.words)
        words: list[str] = []
        manner: list[str] = []
        amounts: list[Token] = []
        while token := self.take("word", "manner", "count", "duration", "same"):
            if token.kind == "word":
                words.extend(token.words)
            elif token.kind == "manner":
                manner.extend(token.words)
            elif token.kind == "same":
                self.same = True
            else:
                amounts.append(token)
        if not (words or manner or amounts):
            return None
        node: Node = Action(tuple(words), tuple(manner))
        for token in amounts:
            node = _amount(node, token)
        return node


def _amount(node: Node, token: Token) -> Node:
    """A node with the count or the duration of a token."""
    if token.kind == "duration":
        return Lasting(node, token.least, token.most)
    return Repeated(node, round(token.least), None if token.most is None else round(token.most))
