"""A question reduced to the words that captions have; other words are removed and listed."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from motiondb.errors import UnknownWordsError
from motiondb.language.question.manner import adverb_of, known_manner
from motiondb.language.question.say import say
from motiondb.language.question.tree import (
    Action,
    Anything,
    Lasting,
    Node,
    NotUsed,
    Question,
    Repeated,
    Without,
    join,
    walk,
    without,
)
from motiondb.language.vocabulary import nearest_words, nothing_known


@dataclass(frozen=True)
class KnownQuestion:
    """A question in known words.

    Attributes
    ----------
    text : str
        As it was written.
    tree : Node
        Of known words; an action of which no word is known is left out. A manner is the word that
        captions use for it.
    unknown : mapping of str to tuple of str
        For each unknown word, the nearest known words, best first.
    not_used : tuple of NotUsed
        Parts of the question that are not in the tree, unknown words included.
    """

    text: str
    tree: Node
    unknown: Mapping[str, tuple[str, ...]]
    not_used: tuple[NotUsed, ...]

    @property
    def words(self) -> tuple[str, ...]:
        """Known words that are requested or excluded, from the left, each once."""
        actions = (node for node in walk(self.tree) if isinstance(node, Action))
        return tuple(dict.fromkeys(word for action in actions for word in action.all_words))

    @property
    def understood(self) -> str:
        """How the question is understood, as one line that is itself a question."""
        return say(self.tree)


def hold_to_known(question: Question, counts: Mapping[str, int]) -> KnownQuestion:
    """Remove the words that no caption has from a question, and list them.

    >>> from motiondb.language.question.parse import parse
    >>> known = hold_to_known(parse("wlak slowly, not moonwalk, sit"), {"sit": 3, "walk": 4})
    >>> known.understood, known.unknown
    ('sit', {'wlak': ('walk',), 'moonwalk': ('walk',)})
    """
    unknown: dict[str, tuple[str, ...]] = {}
    not_used = list(question.not_used)

    def known(action: Action) -> Action | None:
        words = tuple(word for word in action.words if word in counts)
        manners = []
        for word in action.words:
            if word not in counts and word not in unknown:
                unknown[word] = nearest_words(word, counts)
        for manner in action.manner:
            said = known_manner(manner, counts)
            if said is not None and (words or not action.words):
                manners.append(said)
            else:
                reason = "no caption says it" if said is None else "its action is not known"
                not_used.append(NotUsed(adverb_of(manner), reason))
        return Action(words, tuple(manners)) if words or manners else None

    tree = _hold(question.tree, known)
    not_used += [NotUsed(word, reason_unknown(near)) for word, near in unknown.items()]
    if tree is None or not any(isinstance(node, Action) for node in walk(tree)):
        raise UnknownWordsError(nothing_known(question.text, unknown))
    return KnownQuestion(question.text, tree, unknown, tuple(not_used))


def reason_unknown(near: tuple[str, ...]) -> str:
    """Why an unknown word is not used, with the known words that may be meant."""
    return "no caption says it" + (f"; the nearest known: {', '.join(near)}" if near else "")


def with_hints(question: KnownQuestion, hints: Mapping[str, tuple[str, ...]]) -> KnownQuestion:
    """A question whose unknown words have other hints than the known words of like spelling."""
    return replace(
        question,
        unknown={word: hints.get(word, near) for word, near in question.unknown.items()},
        not_used=hinted(question.not_used, hints),
    )


def hinted(
    not_used: Sequence[NotUsed], hints: Mapping[str, tuple[str, ...]]
) -> tuple[NotUsed, ...]:
    """Parts that are not used, with other hints for unknown words; see :func:`with_hints`."""
    return tuple(
        NotUsed(left.text, reason_unknown(hints[left.text])) if left.text in hints else left
        for left in not_used
    )


def _hold(node: Node, known: Callable[[Action], Action | None]) -> Node | None:
    """A tree with ``known`` applied to every action; None removes the action."""
    match node:
        case Action():
            return known(node)
        case Anything():
            return node
        case Without():
            part = _hold(node.part, known)
            kept = [e for one in node.excluded if (e := _hold(one, known)) is not None]
            if part is None:
                return without(Anything(), kept) if kept else None
            return without(part, kept)
        case Repeated() | Lasting():
            part = _hold(node.part, known)
            return None if part is None else replace(node, part=part)
        case _:
            kept = [p for part in node.parts if (p := _hold(part, known)) is not None]
            return join(type(node), kept) if kept else None
