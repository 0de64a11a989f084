"""The verbs on sequences that are there: open saved ones, show one as a strip."""

from __future__ import annotations

from typing import TYPE_CHECKING

from motiondb import store
from motiondb.database.grammars import (
    grammar_completing,
    grammar_editing,
    grammar_sequences,
    grammar_strips,
)
from motiondb.database.grammars.grammar_sequences import GrammarSequence, Material
from motiondb.search.unknown_words import Taking

if TYPE_CHECKING:
    from motiondb.database.session import Session


class SequenceVerbs:
    """Verbs on sequences, for :class:`~motiondb.database.grammars.grammar_verbs.Grammars`.

    Parameters
    ----------
    session : Session
        The open database.
    """

    def __init__(self, session: Session) -> None:
        self._session = session

    def material(self, name: str) -> Material:
        """Return a grammar with its takes, as far as their captures are in the database."""
        return self._session.kept(
            ("grammar", name), lambda: grammar_sequences.load_material(self._session.store, name)
        )

    def taken_in_pattern(self, name: str, like: str) -> dict[str, Taking]:
        """Return what the words of a pattern are taken as that no caption holds.

        Parameters
        ----------
        name : str
            Name of the grammar.
        like : str
            The pattern, see ``complete``.
        """
        return grammar_completing.taken_words(self._session, self.material(name), like)

    def strip(self, sequence: GrammarSequence) -> tuple[grammar_strips.StripTerminal, ...]:
        """Return the terminals of a sequence with their times and the segments that play them."""
        return grammar_strips.strip(self.material(sequence.grammar), sequence)

    def saved(self, name: str) -> list[str]:
        """Return the names of the saved sequences that a grammar derived."""
        opened = self._session.store
        with self._session.reading():
            infos = [i for i in store.load_captures(opened) if i.kind == "generated"]
            derived = [(i.name, store.load_derivation(opened, i.capture_id)) for i in infos]
        return [
            capture for capture, derivation in derived if derivation and derivation.grammar == name
        ]

    def chain(self, name: str, seconds: float, seed: int = 0) -> GrammarSequence:
        """Return sentences that follow one another, as motion of about a wanted duration.

        A take is a chain of sentences, and so is the result. Sentences are drawn one by one by
        their probabilities, whatever the sentence before. The segments are chosen for the whole
        chain, so that the cost of its joins is least.

        Parameters
        ----------
        name : str
            Name of the grammar.
        seconds : float
            Wanted duration. The number of sentences is the one whose mean duration is nearest.
        seed : int
            Seed of the derivations; the same seed gives the same motion.

        Raises
        ------
        QueryError
            When there is no such grammar, the duration is not above 0 or too long, or all captures
            that show one of the terminals were removed.
        """
        return grammar_sequences.chain(self.material(name), seconds, seed)

    def open(self, name: str, seed: int = 0) -> GrammarSequence:
        """Return a saved sequence, assembled again from its segments.

        Parameters
        ----------
        name : str
            Name of the capture.
        seed : int
            Seed of the greedy choice with which the choice of segments is compared.

        Raises
        ------
        QueryError
            When there is no such capture, it has no derivation by a grammar of the database, or a
            capture that plays one of its terminals was removed.
        """
        with self._session.reading():
            _, derivation = grammar_sequences.load_sequence(self._session.store, name)
            material = self.material(derivation.grammar)
            return grammar_editing.play_saved(material, name, seed)
