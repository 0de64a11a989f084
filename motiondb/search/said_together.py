"""Captions as evidence for an action of several words, which one action of theirs must hold.

Example: "stand on one leg" asks for the action (stand, leg). The caption "stand up, swing legs"
holds both words, but of two actions. So only "stand", the head, counts as written there; "leg" adds
nothing.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace

import numpy as np

from motiondb.language.question.heads import heads_of
from motiondb.language.question.readings import Reading
from motiondb.language.vocabulary import split_actions
from motiondb.meaning.word_evidence import TakeEvidence, WhenAsked
from motiondb.records import FloatArray
from motiondb.search.asked_words import AskedWords


def without_words_apart(
    asked: AskedWords, read: Sequence[Reading], verbs: Collection[str]
) -> AskedWords:
    """The words of a question, less what captions say of them in different actions.

    Words that the question also excludes keep all of their evidence.
    """
    excluded = {w for reading in read for e in reading.exclusions for a in e.actions for w in a}
    actions = {
        action
        for reading in read
        for part in reading.parts
        for action in part.actions
        if len(action) > 1 and not excluded.intersection(action)
    }
    if not actions:
        return asked
    evidence, learned = asked.evidence, asked.learned

    def make(capture: int) -> FloatArray:
        said = evidence.written[capture]
        captions = [
            set(words)
            for caption in learned.captions.get(capture, ())
            for words in split_actions(caption.words, learned.synonyms, learned.lemmas)
        ]
        apart = {
            asked.numbers[word]
            for action in actions
            for word in words_apart(action, heads_of(action, verbs), captions)
        }
        if apart:
            said, columns = said.copy(), sorted(apart)
            said[:, columns] = np.minimum(said[:, columns], 0.0)
        return said

    heard = TakeEvidence(
        evidence.table,
        evidence.rows,
        evidence.odds,
        WhenAsked(evidence.written, make),
        evidence.extremes,  # still bounds, as nothing that is asked for grows
    )
    return replace(asked, heard=heard)


def words_apart(
    action: Sequence[str], heads: Collection[str], captions: Iterable[Collection[str]]
) -> set[str]:
    """The words of an action that captions hold, but not in the action that says most of it.

    Of actions that say as many of its words, those with its heads count.

    >>> words_apart(("stand", "leg"), ("stand",), [("stand", "up"), ("swing", "leg")])
    {'leg'}
    >>> words_apart(("swing", "leg"), ("swing",), [("stand", "up"), ("swing", "leg")])
    set()
    """
    shared = [frozenset(action).intersection(words) for words in captions]
    most = max(shared, key=lambda words: (len(words), len(words & set(heads))), default=frozenset())
    return set().union(*shared) - most
