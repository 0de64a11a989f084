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
* "and" between two actions leaves open whether they come at once or in order (``Both``), unless
  one of them ends a posture ("squat and stand up"); with "while" or "at the same time" they are
  simultaneous.
* A piece of directions, limbs, manners or amounts alone belongs to the action before it ("walk
  forward and backward", "walk, twice"); after "or" and "then" the action is repeated ("turn left
  or right" is turn left or turn right). Ways of travelling share what stands behind the last
  ("walk or run backward", but not "walk, or run backward").
* "not", "without" exclude from the piece before them; "but not" and ", not" from everything before
  them, and at the beginning of a question from everything after them; after "then" and "or" an
  exclusion is a separate part. An exclusion ends at "and", "while", "then" and commas, but lists
  that close with "or" or "nor" are excluded as a whole ("not run, jump or hop"), and so are verbs
  in -ing joined by "and" ("without running and jumping"). Two negations cancel.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TypeGuard

from motiondb.errors import QueryError
from motiondb.language.question.amounts import Measure
from motiondb.language.question.readings import say
from motiondb.language.question.tokens import Token, tokenize
from motiondb.language.question.tree import (
    Action,
    AnyOf,
    Anything,
    AtOnce,
    Both,
    InOrder,
    Joined,
    Lasting,
    Measured,
    Node,
    NotUsed,
    Question,
    Repeated,
    Without,
    actions_of,
    any_of,
    at_once,
    attach,
    drop_empty,
    holds_at,
    is_bare,
    join,
    names_words,
    say_again,
    share_limb,
    walk,
    without,
)


class Chain:
    """Parts read so far, received one after the other, each with the separator before it."""

    def __init__(self) -> None:
        self.parts: list[Node] = []  # in order
        self.front: list[Node] = []  # exclusions that stand before every part
        self.waiting: list[Node] = []  # bare pieces before the first action
        self.list_start = 0  # part with which the present list, separated by commas alone, begins

    def add(self, node: Node, separator: str, closing: str = "") -> None:
        """Put a part at the end."""
        if is_bare(node) and self._add_bare(node, separator):
            return
        for bare in self.waiting if actions_of(node) else ():
            node = attach(node, bare)
            self.waiting = []
        listed = separator == "comma" and self.list_start < len(self.parts)
        if closing == "or" and listed and isinstance(node, AnyOf) and all(map(is_bare, node.parts)):
            last = self.parts[-1]
            again = [say_again(last, part, keeps=True) for part in node.parts]
            self.parts[-1] = join(AnyOf, [last, *again])
            return
        if closing == "or" and listed:
            self.parts[self.list_start :] = [any_of([*self.parts[self.list_start :], node])]
            return
        if not listed:
            self.list_start = len(self.parts)
        self.parts.extend(
            node.parts if closing == "and" and listed and isinstance(node, Both) else [node]
        )
        if isinstance(node, Anything):
            self.list_start = len(self.parts)

    def _add_bare(self, node: Node, separator: str) -> bool:
        """Add a bare node to the action before it; return False if it must be a separate part."""
        if self.parts and actions_of(self.parts[-1]):
            if separator == "comma" and holds_at(self.parts[-1]) and holds_at(node):
                self.parts[-1] = join(Both, [self.parts[-1], node])
            elif separator == "then" and names_words(node):
                self.parts.append(say_again(self.parts[-1], node))
                self.list_start = len(self.parts) - 1
            else:
                self.parts[-1] = attach(self.parts[-1], node)
            return True
        if any(action.words for action in actions_of(node)):
            return False
        self.waiting.append(node)
        return True

    def put_before_last(self, node: Node) -> None:
        """Put a part before the last one."""
        self.parts.insert(max(len(self.parts) - 1, 0), node)

    def join_last(self, kind: Joined, node: Node) -> None:
        """Join a node with the last part, or with the exclusions if there is no part."""
        if not self.parts and kind is AnyOf and self.front:
            self.parts, self.front = [without(Anything(), self.front)], []
        if not self.parts:
            self.parts = [node]
        elif kind is AnyOf:
            self.parts[-1] = join(AnyOf, [self.parts[-1], node])
        else:
            self.parts[-1] = together(self.parts[-1], node)

    def exclude(self, excluded: Sequence[Node]) -> None:
        """Exclude from everything so far, or, at the beginning, from everything that follows."""
        if self.parts:
            self.parts = [without(join(InOrder, self.parts), excluded)]
            self.list_start = 1
        else:
            self.front.extend(excluded)

    def tree(self) -> tuple[Node | None, list[Node]]:
        """The node that was read, None if there is none; and bare pieces without an action."""
        waiting = self.waiting
        if not self.parts:
            self.parts = [bare for bare in waiting if names_words(bare)][:1]
            waiting = [bare for bare in waiting if bare not in self.parts]
        if not self.parts:
            return (without(Anything(), self.front) if self.front else None), waiting
        return without(join(InOrder, self.parts), self.front), waiting


def together(left: Node, right: Node) -> Node:
    """Two simultaneous parts; if one has exclusions only, they apply to the other.

    A bare second part belongs to the first.
    """
    if is_bare(right):
        return attach(left, right)
    for part, other in ((right, left), (left, right)):
        if _only_excludes(part):
            return without(other, part.excluded, part.later)
    return at_once([left, right])


_ENDS = {
    "up": ("stand", "get", "rise"),
    "down": ("sit", "get", "put", "bring"),
    "": ("stop", "fall", "land"),
}
"""Verbs that, with the way beside them, end one posture and begin another."""


_REACHED = ("angle", "way", "steps")  # Measures of what comes to an end with them


def both_of(nodes: Sequence[Node]) -> Node:
    """Parts joined by "and": in order, if one of them ends a posture, or goes as far as is said.

    Else that is left open.

    >>> squat, rise, wave = (Action(words) for words in (("squat",), ("stand", "up"), ("wave",)))
    >>> type(both_of([squat, rise])).__name__, type(both_of([squat, wave])).__name__
    ('InOrder', 'Both')
    """
    ends = any(
        verb in action.words and (not way or way in action.words)
        for node in nodes
        for action in actions_of(node)
        for way, verbs in _ENDS.items()
        for verb in verbs
    )
    goes_so_far = any(
        isinstance(node, Measured) and node.measure.what in _REACHED for node in nodes
    )
    return join(InOrder if ends or goes_so_far else Both, nodes)


MOST_PARENTHESES = 20
"""Largest depth of nested parentheses. Chosen by hand; questions need two or three."""
_PIECE = ("word", "manner", "count", "duration", "measure", "same", "quote", "open", "wild")
"""Kinds of tokens that begin a piece."""


class _Parser:
    """A place in a list of tokens, and the rules of the module's grammar, a method each."""

    def __init__(self, tokens: Sequence[Token]) -> None:
        self.tokens = tokens
        self.place = 0  # number of the next token
        self.depth = 0  # open parentheses
        self.same = False  # whether the current part contains "at the same time"
        self.not_used: list[NotUsed] = []  # parts that are not in the tree

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
        while self.kind in ("count", "duration", "measure"):
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
        while token := self.take("word", "manner", "count", "duration", "measure", "same"):
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
            joined = attach(last, node) if is_bare(node) else both_of([last, node])
            chain.parts[-1] = joined
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
        nodes, together_said = [] if node is None else [node], True
        while token := self.take("or"):
            together_said = together_said and not token.words
            self.take("either")
            other, _ = self.both()
            if other is None:
                continue
            if nodes and is_bare(other) and not is_bare(nodes[-1]):
                nodes[-1] = share_limb(nodes[-1], other)
                other, closing = say_again(nodes[-1], other, keeps=True), ""
            else:
                closing = "or"
            nodes.append(other)
        if len(nodes) < 2:
            return (nodes[0] if nodes else None), closing
        return any_of(nodes) if together_said else join(AnyOf, nodes), closing

    def both(self) -> tuple[Node | None, str]:
        """Parts joined by "and"; and the connective that could close a list."""
        node = self.single()
        nodes = [] if node is None else [node]
        while self.take("and"):
            other = self.single()
            if other is None:
                continue
            held_too = nodes and holds_at(nodes[-1]) and holds_at(other)
            if nodes and is_bare(other) and actions_of(nodes[-1]) and not held_too:
                nodes[-1] = attach(nodes[-1], other)
            else:
                nodes.append(other)
        if self.same and len(nodes) > 1:
            self.same = False
            return at_once(nodes), ""
        return (both_of(nodes) if nodes else None), "and" if len(nodes) > 1 else ""

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


def _without_none(node: Node) -> Node:
    """A tree in which what is asked for no times is excluded: "jump 0 times".

    >>> _without_none(Repeated(Action(("jump",)), 0, 0)) == Without(
    ...     Anything(), (Action(("jump",)),))
    True
    """
    match node:
        case Repeated(part=part, most=0):
            return without(Anything(), [part])
        case Repeated() | Lasting() | Measured() | Without():
            return replace(node, part=_without_none(node.part))
        case InOrder() | AtOnce() | Both() | AnyOf():
            parts = [_without_none(part) for part in node.parts]
            if isinstance(node, (AnyOf, InOrder)):
                return join(type(node), parts)
            shown = [part for part in parts if not _only_excludes(part)]
            excluded = [one for part in parts if _only_excludes(part) for one in part.excluded]
            return without(join(type(node), shown) if shown else Anything(), excluded)
    return node


def _only_excludes(node: Node) -> TypeGuard[Without]:
    """Whether a node asks for nothing but that something is not shown."""
    return isinstance(node, Without) and isinstance(node.part, Anything)


def _amount(node: Node, token: Token) -> Node:
    """A node with the count, duration or measure of a token."""
    if token.kind == "measure":
        return Measured(node, Measure(token.what, token.least, token.most))
    if token.kind == "duration":
        return Lasting(node, token.least, token.most)
    return Repeated(node, round(token.least), None if token.most is None else round(token.most))


def parse(
    text: str,
    synonyms: Mapping[str, str] | None = None,
    lemmas: Mapping[str, str] | None = None,
) -> Question:
    """Understand a question.

    >>> from motiondb.language.question.readings import say
    >>> say(parse("A person walks, then runs or jumps, but does not sit down.").tree)
    'walk, then (run or jump), not sit down'
    """
    return parse_tokens(text, *tokenize(text, synonyms, lemmas))


def parse_tokens(text: str, tokens: Sequence[Token], not_used: Sequence[NotUsed]) -> Question:
    """Understand a question by its tokens and its parts that are not used (``tokenize``)."""
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
    tree = _without_none(tree)
    if tokens[-1].kind == "then" and isinstance(tree, Without):
        tree, tokens = replace(tree, later=True), tokens[:-1]
    return Question(text, tree, (*not_used, *parser.not_used, *_loose(tokens)))


_CONNECTIVES = ("or", "and", "while", "then", "after", "before")


def _loose(tokens: Sequence[Token]) -> list[NotUsed]:
    """Connectives at the ends of a question, which connect nothing: "walk or"."""
    loose = []
    if tokens[0].kind == "or":
        loose.append(NotUsed(tokens[0].text, "no action stands before it"))
    if tokens[-1].kind in _CONNECTIVES:
        loose.append(NotUsed(tokens[-1].text, "no action follows it"))
    return loose


def _short(text: str) -> str:
    return text if len(text) <= 60 else f"{text[:57]}..."
