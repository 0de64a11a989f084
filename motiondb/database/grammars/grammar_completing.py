"""Complete a pattern of words and terminals by sentences of a grammar that its captures can show.

A pattern is a text of terminals, words, ``?`` for any one terminal and ``...`` for any number of
them. A word means one segment, with one of the terminals in whose segments the word is probable
(:mod:`.grammar_words`). A word that no caption holds may be taken as known ones
(:mod:`motiondb.search.taken_words`), and is probable where these are. A text without ``?`` and
``...`` that does not consist of terminals is a sentence in words: its words follow each other in
this order, with anything between, before and after. The steps are from words to motion symbols (the
association), to terminals, to a sentence that obeys the grammar, to motion.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from motiondb import store
from motiondb.database.grammars.grammar_sequences import (
    LONGEST_STRING,
    GrammarSequence,
    Material,
    play,
)
from motiondb.database.grammars.grammar_words import Shares, terminal_shares, terminals_for
from motiondb.database.session import nearby_table
from motiondb.errors import QueryError, suggestion
from motiondb.grammar.derivation.complete import Completions, complete, sample_completion
from motiondb.grammar.derivation.pattern import ANY, GAP, Pattern, Place, read_pattern
from motiondb.language.question.plain import plain_actions
from motiondb.language.vocabulary import motion_word, nearest_words, nothing_known
from motiondb.learn.learned import Learned
from motiondb.learn.recognition import understand
from motiondb.search.taken_words import made_of_unknown, with_taken
from motiondb.search.taking import Taking

if TYPE_CHECKING:
    from motiondb.database.session import Session


def playable(material: Material) -> frozenset[str]:
    """Return the terminals of which some capture is in the database."""
    terminals = material.learned.terminals
    there = np.isin(terminals.takes, list(material.numbers))
    return frozenset(terminals.names[k] for k in set(terminals.labels[there].tolist()))


def best(
    session: Session, material: Material, like: str, n: int, exact: bool = False
) -> Completions:
    """Return the most probable sentences that match a pattern.

    `exact`: Whether words that no caption holds are refused rather than taken as known ones.
    """
    if n < 1:
        raise QueryError(f"number: expected 1 sentence or more, found {n}. Ask for more.")
    pattern = pattern_of(material, _learned(session), like, exact)
    return complete(material.learned.grammar, pattern, n, allowed=playable(material))


def generate(
    session: Session,
    material: Material,
    like: str,
    length: int | None,
    seed: int,
    exact: bool = False,
) -> GrammarSequence:
    """Draw a sentence from those that match a pattern, by their probabilities, and assemble it.

    `exact`: Whether words that no caption holds are refused rather than taken as known ones.
    """
    if length is not None:
        raise QueryError(
            f"length: expected none with a pattern, found {length}. Write the number of terminals "
            f"as places: '? ? ?'."
        )
    pattern = pattern_of(material, _learned(session), like, exact)
    rng = np.random.default_rng(seed)
    grammar, allowed = material.learned.grammar, playable(material)
    return play(material, sample_completion(grammar, pattern, rng, allowed=allowed), rng)


def _learned(session: Session) -> Learned | None:
    with session.reading():
        return session.learned if store.is_learned(session.store) else None


def taken_words(session: Session, material: Material, like: str) -> dict[str, Taking]:
    """Return what is made of the words of a pattern that no caption holds."""
    learned = _learned(session)
    return {} if learned is None else _takings(material, learned, _tokens(like))


def _tokens(text: str) -> list[str]:
    return text.replace("\u2026", f" {GAP} ").split()


def _takings(material: Material, learned: Learned, tokens: Sequence[str]) -> dict[str, Taking]:
    """Return what words are taken as that are no terminals and that no caption holds."""
    if learned.fitted_word_map is None:
        return {}
    names = material.learned.grammar.terminals
    words = " ".join(t for t in tokens if t not in names and t not in (GAP, ANY))
    made = made_of_unknown(learned, words, nearby_table())
    return {word: taking for word, taking in made.items() if taking.is_taken}


def pattern_of(
    material: Material, learned: Learned | None, text: str, exact: bool = False
) -> Pattern:
    """Read a pattern, or a sentence in words.

    `exact`: Whether words that no caption holds are refused rather than taken as known ones.
    """
    tokens = _tokens(text)
    if not tokens or len(tokens) > LONGEST_STRING:
        raise QueryError(
            f"pattern: expected 1 to {LONGEST_STRING} terminals or words, found {len(tokens)}."
            f" Write for example 'walk {GAP} {ANY} {GAP} shoot'."
        )
    names = material.learned.grammar.terminals
    if learned is not None and not exact:
        learned = with_taken(learned, _takings(material, learned, tokens))
    marked = any(token in (GAP, ANY) for token in tokens)
    if marked or all(token in names for token in tokens):
        return read_pattern([_place(material, learned, token) for token in tokens])
    if learned is None:
        raise _not_a_terminal(material, next(token for token in tokens if token not in names))
    place = _word_places(material, learned)
    parts: list[Place | str] = [GAP]
    for word in _words_in_order(learned, text):
        parts += [place(word), GAP]
    return read_pattern(parts)


def _words_in_order(learned: Learned, text: str) -> list[str]:
    """Return the words of a sentence; anything but an order of actions is refused."""
    known = understand(learned, text)
    if known.unknown:
        raise QueryError(nothing_known(text, known.unknown))
    actions, not_used = plain_actions(known.tree)
    if not_used:
        told = "; ".join(f"{left.text!r}: {left.reason}" for left in not_used)
        raise QueryError(
            f"pattern: expected actions one after the other, found {told}. Leave it out, or write"
            f" a pattern with {GAP} and {ANY}."
        )
    return [word for action in actions for word in action]


def _place(material: Material, learned: Learned | None, token: str) -> Place | str:
    """Return a token that is a terminal or a mark, or the place of a word."""
    if token in (GAP, ANY) or token in material.learned.grammar.terminals:
        return token
    if learned is None:
        raise _not_a_terminal(material, token)
    words = learned.association.words
    word = motion_word(token.lower(), learned.synonyms)
    if word is None or word not in words:
        near = nearest_words(word or token, words)
        raise QueryError(
            f"{token!r}: expected a terminal, {ANY}, {GAP} or a word of the database, found another"
            f" word.{f' Did you mean {near[0]}?' if near else ' Take a word of the captions.'}"
        )
    return _word_places(material, learned)(word)


def _word_places(material: Material, learned: Learned) -> Callable[[str], Place]:
    """Return a function from a word to its place."""
    shares = terminal_shares(learned, material.learned, material.numbers)

    def place(word: str) -> Place:
        names = material.learned.terminals.names
        terminals = [names[k] for k in terminals_for(learned, shares, word)]
        if not terminals:
            raise QueryError(_shown_by_none(material, learned, shares, word))
        return Place(word, frozenset(terminals))

    return place


def _shown_by_none(material: Material, learned: Learned, shares: Shares, word: str) -> str:
    """Say that no terminal shows a word, and which words are shown."""
    shown = [w for w in learned.association.words if terminals_for(learned, shares, w)]
    options = ", ".join(shown[:20]) or "none"
    return (
        f"{word!r}: expected a word that a terminal of {material.learned.name} shows, found one "
        f"that none shows. They show: {options}."
    )


def _not_a_terminal(material: Material, token: str) -> QueryError:
    names = material.learned.grammar.terminals
    return QueryError(
        f"{token!r}: expected a terminal ({', '.join(names[:30])}), {ANY} or {GAP}, found another"
        f" name, and the database has learned no words.{suggestion(token, names)}"
        " Use terminals, or run motiondb learn."
    )
