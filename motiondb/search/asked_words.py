"""The words that one question may use: those learned, and for its length others.

A word that was not learned has no model of motion of its own. Two kinds can be added:

* A *written* word stands in captions that came after learning, in tags or names. A capture that
  holds it gets the evidence of a written word, one whose captions or tag have other words that of a
  missing word (:mod:`motiondb.meaning.word_evidence`). Its slope on motion is 0, its prior the
  share of captures that hold it.
* A *replaced* word stands for known words (:mod:`motiondb.search.takings`). Its log-odds are
  the means of theirs, weighted by its shares. A word that is heard by its meaning has its own
  likeness to the captions that motion suggests, in place of theirs by vectors; its probabilities
  are never checked.

An added word is a further column of every array over words, behind the learned ones, so that it may
stand anywhere in a question and reasons add up. It is neither stored nor used for learning.

An action of several words is one that a single action of a caption must hold. "Stand on one leg"
asks for (stand, leg); "stand up, swing legs" holds both words, but of two other actions: to stand
up is not to stand on a leg, and the legs swing. So neither counts as written there
(:func:`without_words_apart`).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Container, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from motiondb.language.nearby.table import NearbyTable
from motiondb.language.question.heads import heads_of
from motiondb.language.question.readings import Reading
from motiondb.language.question.tree import LIMBS
from motiondb.language.vocabulary import MODIFIERS, words_of
from motiondb.language.word_vectors.word_vectors import word_vectors
from motiondb.learn.learned import Learned
from motiondb.meaning.amounts import is_of_degree
from motiondb.meaning.caption_map import likeness_of
from motiondb.meaning.limb_sides import LEGS
from motiondb.meaning.occurrences import SURE, seen_event
from motiondb.meaning.place_fitting import Written, interval_evidence
from motiondb.meaning.regression import probability
from motiondb.meaning.word_evidence import (
    KEPT,
    UNWRITTEN,
    WRITTEN,
    TakeEvidence,
    WhenAsked,
    caption_evidence,
)
from motiondb.meaning.word_map import WordMap, logit, usual, word_spreads
from motiondb.records import CaptureInfo, FloatArray, IntArray
from motiondb.search.takings import Sentence, Taking, take_word

PLAIN_TAGS = frozenset({"licence", "capture", "segments", "fps", "skeleton"})
"""Tags whose values do not describe the motion."""
NAMES = "names"  # Where a word is written, as a tag is
_OF_NAMES = re.compile(r"[^\W\d_](?:[^\W\d_A-Z]+|[A-Z]*(?![^\W\d_A-Z]))")  # "JumpTwist" has two
SHORTEST_OF_NAMES = 3  # Letters of a word of a name: others are mostly codes
MOST_WORDS_OF_TAG = 4  # Largest number of words in a tag's value that counts as a label


@dataclass(frozen=True)
class WrittenWord:
    """A word that was not learned, and where it is written.

    Attributes
    ----------
    word : str
        Its lemma.
    tags : tuple of str
        Tags that hold it, such as "style=exhausted", and "names" if names of captures do.
    captures : frozenset of int
        Numbers of the captures whose captions, tags or names hold it.
    in_captions : int
        Number of captures whose captions hold it.
    """

    word: str
    tags: tuple[str, ...]
    captures: frozenset[int]
    in_captions: int

    def sentence(self) -> str:
        """The sentence for the user.

        >>> WrittenWord("exhaust", ("style=exhausted",), frozenset({1, 2}), 0).sentence()
        "'exhaust' was not learned; found where it is written: style=exhausted (2 captures)"
        >>> WrittenWord("dash", (), frozenset({1}), 1).sentence()
        "'dash' was not learned; found where it is written: captions (1 capture)"
        """
        places = ", ".join([*(["captions"] if self.in_captions else []), *self.tags])
        n = len(self.captures)
        count = "1 capture" if n == 1 else f"{n} captures"
        return f"{self.word!r} was not learned; found where it is written: {places} ({count})"


@dataclass(frozen=True, eq=False)
class AddedColumns:
    """What arrays over words hold for the added words; captures by number."""

    word_map: WordMap  # Of the learned words, then the added ones
    counts: IntArray  # (added,): captures that hold each word, at least 1
    shares: FloatArray  # (learned words, added): weights of the learned words; 0 for written words
    checked: NDArray[np.bool_]  # (added,): whether own captions have checked their probabilities
    evidence: TakeEvidence  # Of the learned words, then the added ones
    likeness: FloatArray  # (captures, added): as ``Learned.likeness``; 0 for written words


@dataclass(frozen=True, eq=False)
class AskedWords:
    """The learned model with the words of one question: the learned ones, then added ones."""

    learned: Learned
    names: tuple[str, ...]  # All words by number
    written_words: tuple[WrittenWord, ...] = ()
    columns: AddedColumns | None = field(default=None, repr=False)  # None where nothing is added
    # Evidence of the words in their actions (:func:`without_words_apart`); None: that of the words
    heard: TakeEvidence | None = field(default=None, repr=False)
    counts_captions: bool = True  # Whether captions are evidence, in addition to the motion

    @cached_property
    def numbers(self) -> dict[str, int]:
        """Word -> its number."""
        return {word: number for number, word in enumerate(self.names)}

    @cached_property
    def own(self) -> Container[str]:
        """The words, but those that a start alone knows."""
        if self.learned.started is None:
            return self.numbers
        said = (described.words for described in self.learned.described)
        return set(self.added).union(*said)

    def sure_event(self, action: Sequence[str]) -> str:
        """The event that an action in words of a start surely needs; "" for others.

        Words that were learned from others' motion say little of who jumps here.
        """
        event = seen_event(action, self.own)
        return event if event in SURE else ""

    @property
    def added(self) -> dict[str, int]:
        """Word that was not learned -> number of captures that hold it, at least 1."""
        if self.columns is None:
            return {}
        names = self.names[len(self.learned.association.words) :]
        return dict(zip(names, self.columns.counts.tolist()))

    def likeliest(self, word: str) -> str:
        """The known word that most likely stands for a word; itself if none does."""
        number = self.numbers.get(word, 0) - len(self.learned.association.words)
        shares = self.columns.shares[:, number] if self.columns and number >= 0 else np.zeros(1)
        return self.names[int(np.argmax(shares))] if shares.max() > 0.0 else word

    @property
    def word_map(self) -> WordMap:
        """Map from score vectors to all words; NotLearnedError if no words were learned."""
        return self.learned.word_map if self.columns is None else self.columns.word_map

    @property
    def checked(self) -> NDArray[np.bool_]:
        """Which words' probabilities own captions have checked: array (words,)."""
        if self.columns is None:
            return self.learned.checked
        return np.concatenate([self.learned.checked, self.columns.checked])

    def are_checked(self, readings: Sequence[Reading]) -> bool:
        """Whether own captions have checked all words of a question."""
        words = set[str]().union(*map(words_of_reading, readings))
        return bool(self.checked[[self.numbers[word] for word in words]].all())

    def is_known(self) -> NDArray[np.bool_]:
        """Which words some caption or tag holds now, or known words replace: array (words,)."""
        return np.append(self.learned.is_known(), np.ones(len(self.added), dtype=bool))

    @property
    def evidence(self) -> TakeEvidence:
        """Evidence of all words in all captures, from the motion, the captions and the tags."""
        if self.heard is not None:
            return self.heard
        return self.learned.evidence if self.columns is None else self.columns.evidence

    @cached_property
    def likeness(self) -> FloatArray:
        """Likeness of all words to what every capture suggests: array (captures, words), nats."""
        own = self.learned.likeness
        if self.columns is None:
            return own
        return np.concatenate([own, self.columns.likeness], axis=1)

    @cached_property
    def said_places(self) -> Mapping[int, FloatArray]:
        """Evidence, in nats, that captions of intervals add: arrays (segments, words)."""
        if not self.counts_captions:
            return {}
        if self.columns is None:
            return self.learned.said_places
        learned = self.learned
        said = Written(learned.captions, learned.synonyms, learned.lemmas, self.numbers)
        return interval_evidence(learned.segments, learned.rows, said)

    def by_motion(self) -> AskedWords:
        """The same words, without captions as evidence."""
        every = self.learned if self.columns is None else self.columns
        return replace(self, heard=every.evidence.by_motion, counts_captions=False)

    def widened(self, values: FloatArray) -> FloatArray:
        """Values of all words from those of the learned ones; 0 for written words: (..., words)."""
        if self.columns is None:
            return values
        return np.concatenate([values, values @ self.columns.shares], axis=-1)


def words_of_reading(reading: Reading) -> set[str]:
    """All words that a reading asks for or excludes."""
    asked = [action for part in reading.parts for action in part.actions]
    excluded = [action for exclusion in reading.exclusions for action in exclusion.actions]
    return {word for action in (*asked, *excluded) for word in action}


def learned_words(learned: Learned) -> AskedWords:
    """The learned words alone."""
    return AskedWords(learned, learned.association.words)


def find_written(learned: Learned) -> dict[str, WrittenWord]:
    """Words that were not learned and are written in captions, tags or names: lemma -> where."""
    spelling = learned.synonyms, learned.lemmas
    captions: dict[str, set[int]] = {}
    for capture, rows in learned.captions.items():
        for caption in rows if capture in learned.rows else ():
            for word in words_of(caption.words, *spelling):
                captions.setdefault(word, set()).add(capture)
    tags: dict[str, dict[str, set[int]]] = {}
    for capture in learned.rows:
        for word, tag in _tag_words(learned.captures[capture], *spelling):
            tags.setdefault(word, {}).setdefault(tag, set()).add(capture)
    for word, named in _in_names(learned).items():
        tags.setdefault(word, {})[NAMES] = named
    words = {}
    for word in sorted({*captions, *tags} - {*learned.known_words}):
        said, tagged = captions.get(word, set()), tags.get(word, {})
        everywhere = frozenset(said.union(*tagged.values()))
        words[word] = WrittenWord(word, tuple(sorted(tagged)), everywhere, len(said))
    return words


def _in_names(learned: Learned) -> dict[str, set[int]]:
    """Words that names of captures hold and that may say what these show: word -> captures.

    No directions, sizes and speeds, and nothing that more than half of the names hold.
    """
    pieces: dict[str, set[int]] = {}
    for capture in learned.rows:
        for piece in _OF_NAMES.findall(learned.captures[capture].name):
            pieces.setdefault(piece.lower(), set()).add(capture)
    found: dict[str, set[int]] = {}
    for piece, named in pieces.items():
        for word in words_of(piece, learned.synonyms, learned.lemmas):
            found.setdefault(word, set()).update(named)
    most = len(learned.rows) // 2
    return {
        word: named
        for word, named in found.items()
        if len(named) <= most and len(word) >= SHORTEST_OF_NAMES
        if word not in MODIFIERS and not is_of_degree(word)
    }


def _tag_words(
    info: CaptureInfo, synonyms: Mapping[str, str], lemmas: Mapping[str, str]
) -> Iterable[tuple[str, str]]:
    """Words of the tags of a capture, each with its tag."""
    for key, value in info.tags.items():
        if key in PLAIN_TAGS or len(value.split()) > MOST_WORDS_OF_TAG:
            continue
        for word in words_of(value, synonyms, lemmas):
            if word.isalpha():
                yield word, f"{key}={value}"


def written_words_of(
    sentence: Sentence,
    find: Callable[[], Mapping[str, WrittenWord]],
    table: NearbyTable | None,
) -> AskedWords:
    """The learned words, and the words of a question that are written but were not learned.

    `find` returns the words that are written (:func:`find_written`). It reads all captions,
    tags and names, so it is called only if a word of the question is not known. With a `table` of
    replacements, written words that replace a word of the question are added too.
    """
    learned, known = sentence.learned, sentence.known
    if learned.fitted_word_map is None or known.issuperset(sentence.forms):
        return learned_words(learned)
    written = find()
    wanted = []
    for word, form in sentence.forms.items() if written else ():
        if word in known or word in written:
            wanted.append(word)
        elif table is not None:
            taking = take_word(form, known | written.keys(), table)
            wanted += [w for w, _ in taking.words] if taking.is_taken else []
    return with_written(learned, written, wanted)


def with_written(
    learned: Learned, written: Mapping[str, WrittenWord], wanted: Collection[str]
) -> AskedWords:
    """The learned words, and every wanted lemma that is written somewhere and was not learned."""
    chosen = tuple(
        written[word]
        for word in dict.fromkeys(wanted)
        if word in written and word not in learned.word_numbers
    )
    if not chosen or learned.fitted_word_map is None:
        return learned_words(learned)
    n_learned, n = len(learned.association.words), max(len(learned.rows), 1)
    shares = np.array([len(word.captures) / n for word in chosen])
    priors = np.clip(shares, 0.5 / n, 1.0 - 0.5 / n)
    silent = np.zeros((len(learned.fitted_word_map.weights), len(chosen)))  # whatever the motion
    word_map = learned.fitted_word_map.with_words(
        silent, np.zeros(len(chosen)), priors, word_spreads(priors)
    )
    constant = usual(word_map)[n_learned:]
    # written words are as sure as the captions of the database
    alone = learned.started is None
    sure = bool(learned.checked.all()) if alone else learned.word_certainty is not None
    columns = AddedColumns(
        word_map,
        np.array([len(word.captures) for word in chosen], dtype=np.int64),
        np.zeros((n_learned, len(chosen))),
        np.full(len(chosen), sure),
        learned.evidence.with_columns(
            TakeEvidence(
                learned.segments,
                learned.rows,
                {c: np.tile(constant, (r.stop - r.start + 1, 1)) for c, r in learned.rows.items()},
                _written_columns(learned, chosen),
            )
        ),
        np.zeros((len(learned.rows), len(chosen))),
    )
    names = (*learned.association.words, *(word.word for word in chosen))
    return AskedWords(learned, names, chosen, columns)


def _written_columns(learned: Learned, words: tuple[WrittenWord, ...]) -> dict[int, FloatArray]:
    """Log-odds that captions and tags add to words that were not learned: (segments, words)."""
    number = {word.word: n for n, word in enumerate(words)}
    columns = dict(caption_evidence(learned.described, learned.segments, learned.rows, number))
    for n, word in enumerate(words):
        keys = {tag.partition("=")[0] for tag in word.tags}
        if not keys:
            continue
        for capture, rows in learned.rows.items():
            tagged = not keys.isdisjoint(learned.captures[capture].tags)
            if capture not in word.captures and not tagged:
                continue
            values = columns.setdefault(capture, np.zeros((rows.stop - rows.start, len(words))))
            in_caption = values[:, n] == WRITTEN
            values[:, n] = WRITTEN if capture in word.captures else UNWRITTEN
            values[in_caption, n] = WRITTEN
    return columns


def with_replaced(asked: AskedWords, takings: Mapping[str, Taking]) -> AskedWords:
    """The same words, and every unknown word that known ones replace."""
    taken = {w: taking for w, taking in takings.items() if taking.heard}
    taken = {w: taking for w, taking in taken.items() if w not in asked.numbers}
    learned = asked.learned
    if not taken or learned.fitted_word_map is None:
        return asked
    shares = mixture(list(taken.values()), asked.names)
    n_learned = len(learned.association.words)
    # written words say nothing of the motion: their share adds 0
    alike = _own_likeness(learned, taken, shares[:n_learned])
    # what is written stands for a word that it replaces, not for one that is near in meaning
    standing = np.array([not taking.nearest for taking in taken.values()])
    mixed = asked.evidence.mixed(shares, dict(zip(learned.rows, alike)), standing)
    evidence = asked.evidence.with_columns(mixed)
    likeness = asked.likeness @ shares + alike
    # a replaced word is checked if all words are that replace it
    checked = np.asarray(~(shares[~asked.checked] > 0.0).any(axis=0))
    checked &= [not taking.nearest for taking in taken.values()]
    weights = shares[:n_learned]
    counts = np.append(learned.association.counts, list(asked.added.values()))
    counts = np.maximum(np.rint(counts @ shares), 1).astype(np.int64)
    before = asked.columns
    if before is not None:
        counts = np.concatenate([before.counts, counts])
        weights = np.concatenate([before.shares, weights], axis=1)
        checked = np.concatenate([before.checked, checked])
        likeness = np.concatenate([before.likeness, likeness], axis=1)
    word_map = with_virtual_words(asked.word_map, shares)
    columns = AddedColumns(word_map, counts, weights, checked, evidence, likeness)
    return AskedWords(learned, (*asked.names, *taken), asked.written_words, columns)


def _own_likeness(learned: Learned, taken: Mapping[str, Taking], shares: FloatArray) -> FloatArray:
    """What the likeness of words heard by meaning adds to that of their words: (captures, words).

    0 for words that are replaced. Shapes: `shares` (learned words, words).
    """
    by_meaning = [bool(taking.nearest) for taking in taken.values()]
    if not any(by_meaning):
        return np.zeros((len(learned.rows), len(taken)))
    suggested = learned.heard.meanings
    own = likeness_of(suggested, word_vectors().of(list(taken)))
    added = own - likeness_of(suggested, learned.caption_map.meanings) @ shares
    return np.where(by_meaning, added, 0.0)


def mixture(takings: Collection[Taking], vocabulary: Collection[str]) -> FloatArray:
    """Shares of the known words in replaced words: array (vocabulary, takings), columns sum to 1.

    >>> mixture([Taking("stroll", (("walk", 0.75), ("go", 0.25)))], ["go", "run", "walk"]).tolist()
    [[0.25], [0.0], [0.75]]
    """
    number = {word: n for n, word in enumerate(vocabulary)}
    shares = np.zeros((len(vocabulary), len(takings)))
    for column, taking in enumerate(takings):
        for word, share in zip(taking.heard, taking.shares):
            shares[number[word], column] = share
    return shares


def with_virtual_words(word_map: WordMap, shares: FloatArray) -> WordMap:
    """A word map with a column for every replaced word; `shares` (words, replaced words).

    The log-odds of a replaced word are exactly the means, weighted by its shares, of those of its
    words: slopes over spreads, and the logits of the priors, are averaged, and its spread is 1.
    """
    scaled = (word_map.weights / word_map.spreads) @ shares
    offsets = (word_map.offsets / word_map.spreads) @ shares
    priors = probability(logit(word_map.priors) @ shares)
    return word_map.with_words(scaled, offsets, priors, np.ones(shares.shape[1]))


def without_words_apart(
    asked: AskedWords,
    read: Sequence[Reading],
    verbs: Collection[str],
    phrases: Iterable[Collection[str]] = (),
) -> AskedWords:
    """The words of a question, less what captions say of them in other actions.

    Such a word counts as one that captions do not hold. Words that the question also excludes keep
    all of their evidence. `phrases`: words that a caption must hold together ("hand stand").
    """
    excluded = {w for reading in read for e in reading.exclusions for a in e.actions for w in a}
    actions = {
        action
        for reading in read
        for part in reading.parts
        for action in part.actions
        if not excluded.intersection(action)
    }
    if all(len(action) < 2 for action in actions):
        return asked
    evidence, learned = asked.evidence, asked.learned
    heads = {action: heads_of(action, verbs) for action in actions}

    def make(capture: int) -> FloatArray:
        said = evidence.written[capture]
        captions = learned.said_actions(capture)
        elsewhere, here = set[str](), set[str]()
        for action in actions:
            apart = words_apart(action, heads[action], captions, phrases)
            elsewhere |= apart
            here |= set(action) - apart
        columns = [asked.numbers[word] for word in sorted(elsewhere - here)]
        if columns:
            said = said.copy()
            said[:, columns] = np.minimum(said[:, columns], UNWRITTEN)
        return said

    heard = TakeEvidence(
        evidence.table,
        evidence.rows,
        evidence.odds,
        WhenAsked(evidence.written, make, KEPT),
        evidence.extremes,  # still bounds, as nothing that is asked for grows
    )
    return replace(asked, heard=heard)


def words_apart(
    action: Sequence[str],
    heads: Collection[str],
    captions: Iterable[Collection[str]],
    phrases: Iterable[Collection[str]] = (),
) -> set[str]:
    """The words of an action that captions hold, but not in the action that says most of it.

    Of actions that say as many of its words, those with its heads count. A direction or a part of
    the body is said of the verb beside it; with another one it may be another action.
    `phrases`: words that count only together.

    >>> sorted(words_apart(("stand", "leg"), ("stand",), [("stand", "up"), ("swing", "leg")]))
    ['leg', 'stand']
    >>> words_apart(("walk", "forward"), ("walk",), [("walk", "around"), ("walk", "arm")])
    set()
    >>> words_apart(("swing", "leg"), ("swing",), [("stand", "up"), ("swing", "leg")])
    set()
    """
    if len(action) < 2:
        return set()
    asked, heading = set(action), set(heads)
    written, shared = set[str](), [set[str]()]
    for words in map(set, captions):
        same = asked & words
        written |= same
        if same.isdisjoint(heading):
            same -= MODIFIERS
        elif _is_another(asked, words):
            same = set()
        shared.append(same.difference(*(set(p) for p in phrases if not words.issuperset(p))))
    return written - max(shared, key=lambda same: (len(same), len(same & heading)))


_PAIRS = (("up", "down"), ("forward", "backward"), ("left", "right"), ("in", "out"))
_OPPOSITE = dict(_PAIRS) | {b: a for a, b in _PAIRS}
_PARTICLES = frozenset(("up", "down", "off"))
"""Directions that make another action of a verb: "stand up", "push off"."""


def _is_another(asked: set[str], words: set[str]) -> bool:
    """Whether a caption's verb is another action than that of the question.

    It is if the other limbs move, if it goes the opposite way, or if it has another particle where
    the question names a particle or a limb: "stand up" is not to stand on one leg.
    """
    missing, further = asked - words, words - asked
    limbs = _limbs(words)
    if _limbs(missing) and limbs and limbs.isdisjoint(_limbs(asked)):
        return True
    if any(_OPPOSITE.get(word) in further for word in missing):
        return True
    return bool(further & _PARTICLES) and bool(_limbs(missing) or missing & _PARTICLES)


def _limbs(words: Collection[str]) -> set[str]:
    return {"leg" if word in LEGS else "arm" for word in words if word in LIMBS}
