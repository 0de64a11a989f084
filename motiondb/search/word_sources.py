"""The captions from which a word was learned, and why it has no checked probability."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from motiondb.learn.checking import say_unchecked
from motiondb.learn.joining import start_weight
from motiondb.learn.learned import Learned


@dataclass(frozen=True)
class WordSource:
    """The captions from which a word was learned, in a database that learned with a start.

    Attributes
    ----------
    word : str
        The word.
    start : str
        Name of the start.
    start_captions : int
        Captions of the start that hold the word.
    own_captions : int
        Own captions that hold it.
    weight : float
        Weight of a caption of the start relative to an own one; 1 if no own caption has the word,
        because it is then learned from the start alone.
    """

    word: str
    start: str
    start_captions: int
    own_captions: int
    weight: float

    def sentence(self) -> str:
        """The sentence for the user.

        >>> WordSource("walk", "cmu", 74, 0, 1.0).sentence()
        'walk: known from the start cmu alone (74 captions there)'
        >>> WordSource("walk", "cmu", 74, 1, 0.5).sentence()
        'walk: known from 1 own caption and 74 of the start cmu, each of which counts 0.5'
        >>> WordSource("dash", "cmu", 0, 3, 0.5).sentence()
        'dash: known from 3 own captions alone'
        """
        captions = f"{self.own_captions} own caption{'' if self.own_captions == 1 else 's'}"
        if not self.own_captions:
            start_captions = (
                "1 caption" if self.start_captions == 1 else f"{self.start_captions} captions"
            )
            return f"{self.word}: known from the start {self.start} alone ({start_captions} there)"
        if not self.start_captions:
            return f"{self.word}: known from {captions} alone"
        return (
            f"{self.word}: known from {captions} and {self.start_captions} of the start "
            f"{self.start}, each of which counts {self.weight:.2g}"
        )


def word_sources(learned: Learned, words: Iterable[str]) -> tuple[WordSource, ...]:
    """The captions from which some words were learned; empty without a start.

    Words that were not learned are left out.
    """
    started = learned.started
    if started is None or learned.counted is None:
        return ()
    counts = learned.counted.counts
    captions_of = dict(zip(learned.counted.reference.association.words, counts.said.tolist()))
    weight = start_weight(counts.moments.n)
    sources = []
    for word in dict.fromkeys(words):
        in_start, in_own = started.said.get(word, 0), captions_of.get(word, 0)
        if in_start or in_own:
            name = started.knowledge.origin.name
            sources.append(WordSource(word, name, in_start, in_own, weight if in_own else 1.0))
    return tuple(sources)


def why_unchecked(learned: Learned, words: Iterable[str]) -> str:
    """The reason why answers about some words carry no probabilities; "" where they do."""
    if learned.counted is None:
        return ""
    if learned.started is None and learned.word_certainty is not None:
        return ""
    number = learned.word_numbers
    asked = [w for w in dict.fromkeys(words) if w in number and not learned.checked[number[w]]]
    if not asked and learned.word_certainty is not None:
        return ""
    return say_unchecked(learned.counted.counts.moments.n, asked, learned.word_certainty)
