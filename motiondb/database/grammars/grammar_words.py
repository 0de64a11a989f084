"""Words and terminals: what the segments of a terminal show, and patterns in words.

The name of a terminal is a letter without a meaning. If the database has learned words, the words
of a terminal are those that are more probable in its segments than in all segments of the same
takes, by the difference

    p(word | segments of the terminal) - p(word | all segments).

The probabilities are those of :mod:`motiondb.search.described`: by the captions
that people wrote, and otherwise by the motion. A word whose place only the alignment of a whole
caption gives has no probability. If the database has learned motion symbols, a terminal also gets
the symbols that cover most of the time of its segments. The database therefore keeps a single table
of motion symbols.

A pattern is a text of terminals, words, ``?`` for any one terminal and ``...`` for any number of
them. A word means one segment, with one of the terminals that show the word. A word that no
caption holds may be replaced by known ones (:mod:`motiondb.search.takings`), and is shown
where these are.
A text without ``?`` and ``...`` that does not consist of terminals is a sentence in words: its
words follow each other in this order, with anything between, before and after. The steps are from
words to motion symbols (the association), to terminals, to a sentence that obeys the grammar, to
motion.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motiondb.database.grammars.grammar_sequences import LONGEST_STRING, Material
from motiondb.database.loading import LearnedGrammar, nearby_table
from motiondb.errors import QueryError, suggestion
from motiondb.grammar.derivation.pattern import ANY, GAP, Pattern, PatternSymbol, read_pattern
from motiondb.language.question.readings import plain_actions
from motiondb.language.vocabulary import motion_word, nearest_words, nothing_known
from motiondb.learn.learned import Learned
from motiondb.records import FloatArray
from motiondb.search.asked_words import AskedWords, learned_words, with_replaced
from motiondb.search.described import segment_words
from motiondb.search.takings import Sentence, Taking, find_takings, sentence_of

N_WORDS = 2  # Most words of a terminal
LEAST_PROBABILITY = 0.25  # Least probability of a word in the segments of a terminal
LEAST_GAIN = 0.05  # Least difference from the probability in all segments


@dataclass(frozen=True)
class Meaning:
    """Words and motion symbols of a terminal."""

    # Words with their probability in the segments of the terminal, the largest difference first;
    # None where no own caption has checked the probability (``motiondb.learn.checking``), and where
    # only the alignment of captions of whole takes says that the segments show the word
    words: tuple[tuple[str, float | None], ...] = ()
    # Motion symbols with their share of the time of the segments, the largest share first
    symbols: tuple[tuple[int, float], ...] = ()

    @property
    def text(self) -> str:
        """The words without their probabilities.

        >>> Meaning((("turn", 0.9), ("left", 0.5))).text
        'turn left'
        """
        return " ".join(word for word, _ in self.words)


def terminal_meanings(
    learned: Learned | None, grammar: LearnedGrammar, numbers: Mapping[int, int]
) -> tuple[Meaning, ...]:
    """Return the meaning of each terminal; `numbers` as :attr:`Material.numbers`."""
    if learned is None:
        return (Meaning(),) * len(grammar.terminals.names)
    shares = terminal_shares(learned_words(learned), grammar, numbers)
    known = learned.association.words if shares.words.size else ()
    return tuple(
        Meaning(_words(row, shares.usual, known, learned.checked & ~aligned), _symbols(symbols))
        for row, aligned, symbols in zip(shares.words, shares.aligned, shares.symbols)
    )


@dataclass(frozen=True, eq=False)
class Shares:
    """The symbols and words of the segments of each terminal."""

    # (terminals, words): probability of each word in the segments of each terminal; no columns
    # without a word map
    words: FloatArray
    # (terminals, words): whether more than half of the probability of a word comes from the
    # alignment of captions
    aligned: NDArray[np.bool_]
    usual: FloatArray  # (words,): probability of each word in all segments
    symbols: FloatArray  # (terminals, symbols): share of the time that each motion symbol covers


def terminal_shares(
    asked: AskedWords, grammar: LearnedGrammar, numbers: Mapping[int, int]
) -> Shares:
    """Return what the segments of each terminal show; `numbers` as :attr:`Material.numbers`."""
    learned, terminals = asked.learned, grammar.terminals
    n = len(terminals.names)
    takes = {take: capture for take, capture in numbers.items() if capture in learned.rows}
    symbols = np.zeros((n, learned.symbols.n_symbols))
    has_words = learned.fitted_word_map is not None
    words = np.zeros((n, len(asked.names) if has_words else 0))
    by_alignment = np.zeros_like(words)
    frames = np.zeros(n)
    for take, capture in takes.items():
        segments = np.flatnonzero(terminals.takes == take)
        rows = learned.rows[capture]
        starts, ends = learned.segments.starts[rows], learned.segments.ends[rows]
        shared = np.minimum(terminals.ends[segments][:, None], ends) - np.maximum(
            terminals.starts[segments][:, None], starts
        )
        shared = np.maximum(shared, 0).astype(float)
        labels = terminals.labels[segments]
        np.add.at(frames, labels, shared.sum(axis=1))
        worn = np.zeros((len(starts), symbols.shape[1]))
        worn[np.arange(len(starts)), learned.segments.symbols[rows]] = 1.0
        np.add.at(symbols, labels, shared @ worn)
        if has_words:
            shown = segment_words(asked, capture)
            np.add.at(words, labels, shared @ shown.probabilities)
            np.add.at(by_alignment, labels, shared @ (shown.probabilities * shown.aligned))
    usual = words.sum(axis=0) / max(frames.sum(), 1.0)
    frames = np.maximum(frames, 1.0)[:, None]
    return Shares(words / frames, by_alignment > words / 2.0, usual, symbols / frames)


def terminals_for(asked: AskedWords, shares: Shares, word: str) -> tuple[int, ...]:
    """Return the numbers of the terminals that show a word; () if none does.

    A terminal shows a word that is more probable in its segments than in all segments of the takes.
    Without a word map, the probability of a word is that of the association, given the motion
    symbols of the terminal.
    """
    number = asked.names.index(word)
    if shares.words.size:
        row, usual = shares.words[:, number], float(shares.usual[number])
    else:
        row = shares.symbols @ asked.learned.association.translation[1:, number]
        usual = float(row.mean())
    shown = (row >= LEAST_PROBABILITY) & (row - usual >= LEAST_GAIN)
    return tuple(np.flatnonzero(shown).tolist())


def _words(
    row: FloatArray, usual: FloatArray, known: tuple[str, ...], checked: NDArray[np.bool_]
) -> tuple[tuple[str, float | None], ...]:
    """Select the words of a terminal; `row`, `usual`, `checked` (words,)."""
    gain = row - usual
    order = np.argsort(-gain, kind="stable")[:N_WORDS]
    return tuple(
        (known[w], float(row[w]) if checked[w] else None)
        for w in order
        if row[w] >= LEAST_PROBABILITY and gain[w] >= LEAST_GAIN
    )


def _symbols(shares: FloatArray) -> tuple[tuple[int, float], ...]:
    """Select at most three motion symbols that each cover at least a tenth of the time."""
    order = np.argsort(-shares, kind="stable")[:3]
    return tuple((int(s), float(shares[s])) for s in order if shares[s] >= 0.1)


def playable(material: Material) -> frozenset[str]:
    """Return the terminals of which some capture is in the database."""
    terminals = material.learned.terminals
    there = np.isin(terminals.takes, list(material.numbers))
    return frozenset(terminals.names[k] for k in set(terminals.labels[there].tolist()))


def tokens_of(text: str) -> list[str]:
    """Return the parts of a pattern."""
    return text.replace("\u2026", f" {GAP} ").split()


def takings(material: Material, learned: Learned, tokens: Sequence[str]) -> dict[str, Taking]:
    """Return what words are taken as that are no terminals and that no caption holds."""
    if learned.fitted_word_map is None:
        return {}
    names = material.learned.grammar.terminals
    words = " ".join(t for t in tokens if t not in names and t not in (GAP, ANY))
    made = find_takings(Sentence(learned, words), nearby_table())
    return {word: taking for word, taking in made.items() if taking.is_taken}


def pattern_of(
    material: Material, learned: Learned | None, text: str, exact: bool = False
) -> Pattern:
    """Read a pattern or a sentence in words; `exact` refuses words that no caption holds."""
    tokens = tokens_of(text)
    if not tokens or len(tokens) > LONGEST_STRING:
        raise QueryError(
            f"pattern: expected 1 to {LONGEST_STRING} terminals or words, found {len(tokens)}."
            f" Write for example 'walk {GAP} {ANY} {GAP} shoot'."
        )
    names = material.learned.grammar.terminals
    asked = None if learned is None else learned_words(learned)
    if asked is not None and not exact:
        asked = with_replaced(asked, takings(material, asked.learned, tokens))
    marked = any(token in (GAP, ANY) for token in tokens)
    if marked or all(token in names for token in tokens):
        return read_pattern([_place(material, asked, token) for token in tokens])
    if asked is None:
        raise _not_a_terminal(material, next(token for token in tokens if token not in names))
    place = _word_places(material, asked)
    parts: list[PatternSymbol | str] = [GAP]
    for word in _words_in_order(asked, text):
        parts += [place(word), GAP]
    return read_pattern(parts)


def _words_in_order(asked: AskedWords, text: str) -> list[str]:
    """Return the words of a sentence; anything but an order of actions is refused."""
    known = sentence_of(asked.learned, text).in_known_words(asked.added)
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


def _place(material: Material, asked: AskedWords | None, token: str) -> PatternSymbol | str:
    """Return a token that is a terminal or a mark, or the place of a word."""
    if token in (GAP, ANY) or token in material.learned.grammar.terminals:
        return token
    if asked is None:
        raise _not_a_terminal(material, token)
    words = asked.names
    word = motion_word(token.lower(), asked.learned.synonyms)
    if word is None or word not in words:
        near = nearest_words(word or token, words)
        raise QueryError(
            f"{token!r}: expected a terminal, {ANY}, {GAP} or a word of the database, found another"
            f" word.{f' Perhaps {near[0]}.' if near else ' Take a word of the captions.'}"
        )
    return _word_places(material, asked)(word)


def _word_places(material: Material, asked: AskedWords) -> Callable[[str], PatternSymbol]:
    """Return a function from a word to its place."""
    shares = terminal_shares(asked, material.learned, material.numbers)

    def place(word: str) -> PatternSymbol:
        names = material.learned.terminals.names
        terminals = [names[k] for k in terminals_for(asked, shares, word)]
        if not terminals:
            raise QueryError(_shown_by_none(material, asked, shares, word))
        return PatternSymbol(word, frozenset(terminals))

    return place


def _shown_by_none(material: Material, asked: AskedWords, shares: Shares, word: str) -> str:
    """Say that no terminal shows a word, and which words are shown."""
    shown = [w for w in asked.names if terminals_for(asked, shares, w)]
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
