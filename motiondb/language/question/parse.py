"""From a question to its tree, by recursive descent.

    order      at_once {("," | "then" | ";" | "after" | "before") at_once} {", not" excluded}
    at_once    any_of {"while" any_of}
    any_of     both {"or" both}
    both       single {"and" single}
    single     "not" excluded | piece {"not" excluded}
    excluded   piece {"or" piece}
    piece      "?" | "(" order ")" | words, manners, counts and durations in any order

So "and" binds tighter than "or", "or" tighter than "while", and all tighter than an order. Beyond
the grammar:

* The last connective of a list determines its meaning: "walk, run or jump" is any of three,
  "walk, turn and sit" is an order of three.
* "and" between two actions leaves open whether they come at once or in order (``Both``); with
  "while" or "at the same time" they are simultaneous.
* A piece of directions, limbs, manners or amounts alone belongs to the action before it ("walk
  forward and backward", "walk, twice"); after "or" and "then" the action is repeated ("turn left
  or right" is turn left or turn right).
* "not", "without" exclude from the piece before them; "but not" and ", not" from everything before
  them, and at the beginning of a question from everything after them; after "then" and "or" an
  exclusion is a separate part. An exclusion ends at "and", "while", "then" and commas, but lists
  that close with "or" or "nor" are excluded as a whole ("not run, jump or hop"), and so are verbs
  in -ing joined by "and" ("without running and jumping"). Two negations cancel.
"""

from __future__ import annotations

from collections.abc import Mapping

from motiondb.errors import QueryError
from motiondb.language.question.bare import attach, drop_empty, is_bare, say_again, share_limb
from motiondb.language.question.chain import Chain, together
from motiondb.language.question.pieces import Pieces
from motiondb.language.question.say import say
from motiondb.language.question.tokens import tokenize
from motiondb.language.question.tree import (
    Action,
    AnyOf,
    Anything,
    AtOnce,
    Both,
    InOrder,
    Node,
    NotUsed,
    Question,
    actions_of,
    at_once,
    join,
    walk,
    without,
)


def parse(
    text: str,
    synonyms: Mapping[str, str] | None = None,
    lemmas: Mapping[str, str] | None = None,
) -> Question:
    """Understand a question.

    >>> from motiondb.language.question.say import say
    >>> say(parse("A person walks, then runs or jumps, but does not sit down.").tree)
    'walk, then (run or jump), not sit down'
    """
    tokens, not_used = tokenize(text, synonyms, lemmas)
    parser = _Parser(tokens)
    tree = parser.order()
    if parser.kind == "close":
        raise QueryError(
            f"question {_short(text)!r}: expected '(' before ')', found none. Leave out ')'."
        )
    if tree is None or not any(isinstance(node, Action) for node in walk(tree)):
        raise QueryError(
            f"query: expected words that describe a motion, found {_short(text)!r}. "
            "Ask for example for 'walk, turn left, sit down'."
        )
    return Question(text, tree, (*not_used, *parser.not_used))


def _short(text: str) -> str:
    return text if len(text) <= 60 else f"{text[:57]}..."


class _Parser(Pieces):
    """The upper rules of the module's grammar, a method each."""

    def order(self) -> Node | None:
        """Everything up to the end or a closing parenthesis; None if nothing is asked."""
        chain = Chain()
        separator = ""
        while self.kind not in ("end", "close"):
            before = self.place
            if token := self.take("comma", "then", "stop", "and"):
                separator = token.kind
            elif self.kind in ("not", "nor", "but_not") and separator != "then":
                self._exclude(chain)
                separator = ""
            elif self.kind in ("while", "or", "after", "before"):
                self._late_connective(chain)
                separator = ""
            else:
                self._element(chain, separator)
                separator = ""
            self.place = max(self.place, before + 1)
        tree, left_over = chain.tree()
        if tree is not None:
            tree, dropped = drop_empty(tree)
            left_over += dropped
        self.not_used += [
            NotUsed(say(bare).strip(), "there is no action that it belongs to")
            for bare in left_over
        ]
        return tree

    def _element(self, chain: Chain, separator: str) -> None:
        """A part of an order, with the parts before and after it by "after" and "before"."""
        if self.take("either"):
            chain.list_start = len(chain.parts)
        self.same = False
        node, closing = self.at_once()
        while self.kind in ("after", "before") and not self.tokens[self.place].words:
            connective = self.take("after", "before")
            other, _ = self.at_once()
            pair = [part for part in (node, other) if part is not None]
            if connective is not None and connective.kind == "after":
                pair.reverse()
            if len(pair) == 2 and is_bare(pair[1]):
                pair[1] = say_again(pair[0], pair[1])
            node = join(InOrder, pair) if pair else None
            closing = ""
        if node is None:
            return
        if separator == "and" and chain.parts:
            last = chain.parts[-1]
            chain.parts[-1] = attach(last, node) if is_bare(node) else join(Both, [last, node])
        elif self.same and chain.parts and separator in ("comma", "stop"):
            chain.join_last(AtOnce, node)
        else:
            chain.add(node, separator, closing)

    def _exclude(self, chain: Chain) -> None:
        """An exclusion from everything before it, or from everything after it."""
        cancelled, excluded = self.excluded()
        if cancelled:
            for node in excluded:
                chain.join_last(AtOnce, node)
        elif excluded:
            chain.exclude(excluded)

    def _late_connective(self, chain: Chain) -> None:
        """A connective at the beginning, after a comma, or after an exclusion."""
        token = self.take("while", "or", "after", "before")
        assert token is not None
        if token.kind == "or":
            node, _ = self.at_once()
        else:
            node, _ = self.any_of() if token.kind == "while" else self.at_once()
        if node is None:
            return
        first = not chain.parts
        more = self.kind in ("comma", "then", "stop")
        if token.kind in ("while", "before") and first and more:
            self.place += 1
            following, closing = self.at_once()
            if following is None:
                chain.add(node, "")
            elif token.kind == "while":
                chain.add(together(node, following), "")
            else:
                chain.add(following, "", closing)
                chain.add(node, "then")
        elif token.kind in ("while", "or"):
            chain.join_last(AnyOf if token.kind == "or" else AtOnce, node)
        elif token.kind == "after" and not first and not more:
            chain.put_before_last(node)
        else:
            chain.add(node, "then")

    def at_once(self) -> tuple[Node | None, str]:
        """Parts joined by "while"; and the connective that could close a list."""
        node, closing = self.any_of()
        while self.take("while"):
            other, _ = self.any_of()
            closing = ""
            if node is None or other is None:
                node = other if node is None else node
            else:
                node = together(node, other)
        return node, closing

    def any_of(self) -> tuple[Node | None, str]:
        """Parts joined by "or"; and the connective that could close a list."""
        self.take("either")
        node, closing = self.both()
        nodes = [] if node is None else [node]
        while self.take("or"):
            self.take("either")
            other, _ = self.both()
            if other is None:
                continue
            if nodes and is_bare(other) and not is_bare(nodes[-1]):
                nodes[-1] = share_limb(nodes[-1], other)
                other, closing = say_again(nodes[-1], other), ""
            else:
                closing = "or"
            nodes.append(other)
        return (join(AnyOf, nodes) if nodes else None), closing

    def both(self) -> tuple[Node | None, str]:
        """Parts joined by "and"; and the connective that could close a list."""
        node = self.single()
        nodes = [] if node is None else [node]
        while self.take("and"):
            other = self.single()
            if other is None:
                continue
            if nodes and is_bare(other) and actions_of(nodes[-1]):
                nodes[-1] = attach(nodes[-1], other)
            else:
                nodes.append(other)
        if self.same and len(nodes) > 1:
            self.same = False
            return at_once(nodes), ""
        return (join(Both, nodes) if nodes else None), "and" if len(nodes) > 1 else ""

    def single(self) -> Node | None:
        """A piece without its exclusions."""
        node = self.piece() if self.kind not in ("not", "nor") else None
        while self.kind in ("not", "nor"):
            cancelled, excluded = self.excluded()
            if cancelled:
                for part in excluded:
                    node = part if node is None else together(node, part)
            elif excluded:
                node = without(Anything() if node is None else node, excluded)
        return node
