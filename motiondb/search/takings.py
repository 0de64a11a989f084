"""Words of a question that no caption holds, and the known words that may replace them.

Clear events, such as "jump", are looked for in the motion alone
(:func:`motiondb.meaning.occurrences.seen_event`): of words hidden from CMU captions they were found
with a mean average precision of .64, by the table below with .31 (``docs/measured/quality.md``).

First, words are tried as another phrase for the same motion, as a compound that the captions write
apart, and as parts of one that they write as one (:func:`write_otherwise`).

Then, with p_i the probability, from the table, that the known word i may replace the word: if the
largest p_i is TAKEN or more, the word is replaced by all known words with p_i of SUGGESTED or more,
with shares p_i / sum p. That a motion shows the known words does not say how probably it shows the
word: on CMU captions, hidden words were replaced with a mean probability of .75, and .15 of the
captures whose captions say the known word say the hidden one too. So such answers carry no
probabilities. If the largest p_i is SUGGESTED or more, the known words are only suggested. Words
that are not English get known words of similar spelling as suggestions.

What is left is heard by its meaning, if it is an English word (:func:`hear_by_meaning`): by the
known words nearest to its vector (:mod:`motiondb.language.word_vectors`), and by its own likeness
to the captions that motion suggests. This ranks answers, and never gives them a probability.

If a head of an action stays unknown, the question is not understood (:func:`not_understood`): its
answers are for the rest alone, and carry no probabilities.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from motiondb.errors import UnknownWordsError
from motiondb.language.lemmas import lemma
from motiondb.language.nearby.table import NearbyTable
from motiondb.language.question.amounts import known_manner
from motiondb.language.question.heads import missing_heads, verbs_in
from motiondb.language.question.parse import parse_tokens
from motiondb.language.question.readings import KnownQuestion, hold_to_known
from motiondb.language.question.tokens import Token, tokenize
from motiondb.language.question.tree import (
    Action,
    NotUsed,
    Question,
    Without,
    actions_of,
    core,
    map_actions,
    walk,
)
from motiondb.language.requests import without_request
from motiondb.language.vocabulary import (
    MODIFIERS,
    STOP_WORDS,
    as_said,
    forms_of,
    motion_word,
    nearest_words,
    nothing_known,
    say_unknown,
    words_of,
    written_otherwise,
)
from motiondb.language.word_vectors.word_vectors import shares_by_meaning, word_vectors
from motiondb.learn.learned import Learned
from motiondb.meaning.amounts import degree_of
from motiondb.meaning.limb_sides import PLAIN
from motiondb.meaning.occurrences import beside_event, seen_event
from motiondb.meaning.postures import OF_POSTURES, beside_posture, is_posture_alone, posture_of
from motiondb.meaning.travelled import directions_to_measure

TAKEN = 0.5
SUGGESTED = 0.3
"""Smallest probability of a replacement, and of a suggestion: docs/measured/nearby-words.md shows
how often each range of probabilities is right."""

OF_POSTURE = "only that the posture is held, or that somebody lands so, is measured"
OF_EVENT = "not in the captions; the rest of its action is seen in the motion alone"
LEAST_NEAR = 0.5
"""Smallest cosine of a word that is heard by its meaning and the nearest known word. Words that
were hidden from the captions of CMU performers were found with an average precision of .39 above it
(chance .18) and .28 below (.13), so the bound itself is a judgement
(``docs/measured/quality.md``, "Words that no caption holds")."""


@dataclass(frozen=True)
class Taking:
    """The replacement or the suggestions for a word that is in no caption.

    Attributes
    ----------
    word : str
        As it was written.
    words : tuple of (str, float)
        Known words, most likely first, each with the probability that it may replace the word; only
        those of SUGGESTED or more.
    spelling : tuple of str
        Known words of similar spelling, if the word is not English and ``words`` is empty.
    is_same : bool
        Whether the known words are the word itself, written otherwise, or another phrase for it.
    """

    word: str
    words: tuple[tuple[str, float], ...]
    spelling: tuple[str, ...] = ()
    is_same: bool = False
    # Known words nearest in meaning, with shares, if the word is heard by its meaning
    nearest: tuple[tuple[str, float], ...] = ()

    @property
    def probability(self) -> float:
        """Probability that the most likely known word is right; 0 if there is none."""
        return self.words[0][1] if self.words else 0.0

    @property
    def is_taken(self) -> bool:
        """Whether the known words replace the word; otherwise they are only suggested."""
        return self.probability >= TAKEN

    @property
    def is_other(self) -> bool:
        """Whether the known words that replace the word are other words: who walks may not limp."""
        return self.is_taken and not self.is_same

    @property
    def chance(self) -> float:
        """Probability that the known words may replace the word, the mean over their shares."""
        return sum(share * p for share, (_, p) in zip(self.shares, self.words))

    @property
    def shares(self) -> tuple[float, ...]:
        """Weights of the known words in the virtual word; their sum is 1."""
        if self.nearest:
            return tuple(share for _, share in self.nearest)
        total = sum(p for _, p in self.words)
        return tuple(p / total for _, p in self.words)

    def sentence(self, where: str = "in the captions") -> str:
        """The sentence for the user.

        Probabilities are rounded down, so that none is printed as 1.

        Parameters
        ----------
        where : str
            Place where the word was searched.

        Examples
        --------
        >>> Taking("stroll", (("walk", 0.995),)).sentence()
        "'stroll' is not in the captions; replaced by walk (0.9), a close match"
        """
        said = [w if self.is_same else f"{w} ({say_chance(p)})" for w, p in self.words]
        if self.is_taken:
            more = ", a close match" if self.is_other else ""
            return f"{self.word!r} is not {where}; replaced by {' or '.join(said)}{more}"
        if self.nearest:
            near = ", ".join(word for word, _ in self.nearest)
            return f"{self.word!r} is not {where}; ranked by meaning; nearest known words: {near}"
        return say_unknown(self.word, said or self.spelling, where)

    @property
    def heard(self) -> tuple[str, ...]:
        """The known words that stand for the word; () if none do."""
        if self.nearest:
            return tuple(word for word, _ in self.nearest)
        return tuple(word for word, _ in self.words) if self.is_taken else ()

    @property
    def notation(self) -> str:
        """The known words in place of a word that is taken.

        >>> Taking("stroll", (("walk", 0.995),)).notation
        'walk (for stroll)'
        """
        if self.nearest:
            return f"{self.word} (by its meaning)"
        return f"{' or '.join(word for word, _ in self.words)} (for {self.word})"


def with_notation(text: str, taken: Mapping[str, Taking]) -> str:
    """A text in known words, in which the words that are taken say so.

    >>> with_notation("moonwalk 0-3 s", {"moonwalk": Taking("moonwalk", (("walk", 0.8),))})
    'walk (for moonwalk) 0-3 s'
    """
    for word, taking in taken.items():
        text = re.sub(rf"\b{re.escape(word)}\b", taking.notation, text)
    return text


def say_chance(probability: float) -> str:
    """A probability with one decimal, rounded down.

    >>> say_chance(0.995), say_chance(0.3), say_chance(0.06)
    ('0.9', '0.3', '0.0')
    """
    return f"{int(probability * 10.0 + 1e-6) / 10.0:.1f}"


_NOT_NEAR = frozenset(("drunk", "drunken"))  # Who is drunk walks so, and does not drink


def take_word(word: str, known: Collection[str], table: NearbyTable) -> Taking:
    """The known words that may replace a word: the table's entry of its lemma, or its own."""
    if word.lower() in known:  # another word of the same form: "lay" is the past of "lie"
        word = lemma(word)
    forms = list(dict.fromkeys((lemma(word), word.lower())))
    entry = next(filter(None, map(table.entry, forms)), ())
    entry = () if word in _NOT_NEAR else entry
    parts = {form.removesuffix(end) for form in forms for end in ("up", "down", "off", "over")}
    chances = [pair for pair in entry if pair[0] in known and pair[0] not in parts]
    ordered = sorted(chances, key=lambda pair: (-pair[1], pair[0]))
    likely = tuple((target, chance) for target, chance in ordered if chance >= SUGGESTED)
    if likely or any(table.is_english(form) for form in forms):
        return Taking(word, likely)
    return Taking(word, (), nearest_words(word, known))


def hear_by_meaning(
    learned: Learned, takings: Mapping[str, Taking], table: NearbyTable
) -> dict[str, Taking]:
    """The same, and every English word that is not replaced with the known words nearest to it.

    A known word must be as near as LEAST_NEAR. Directions and parts of the body are neither heard
    nor among the known words.
    """
    heard = dict(takings)
    known = [word for word in learned.known_words if word not in MODIFIERS]
    silent = [
        word
        for word, taking in takings.items()
        if not taking.is_taken
        and word not in MODIFIERS
        and (table.is_english(word) or table.is_english(taking.word.lower()))
    ]
    if not known or not silent:
        return heard
    vectors = word_vectors().of(known)
    for word, vector in zip(silent, word_vectors().of(silent)):
        if (vectors @ vector).max() < LEAST_NEAR:
            continue
        shares = shares_by_meaning(vectors, vector)
        nearest = [(known[n], float(shares[n])) for n in np.argsort(-shares, kind="stable")]
        nearest = [pair for pair in nearest if pair[1] > 0.0]
        heard[word] = replace(takings[word], words=(), nearest=tuple(nearest))
    return heard


def hints_of(takings: Mapping[str, Taking]) -> dict[str, tuple[str, ...]]:
    """Unknown words that are not taken -> known words that may be meant, by sense or spelling.

    >>> hints_of({"circle": Taking("circle", ()), "hurl": Taking("hurl", (("shoot", 0.4),))})
    {'circle': (), 'hurl': ('shoot',)}
    """
    return {
        word: tuple(near for near, _ in taking.words) or taking.spelling
        for word, taking in takings.items()
        if not taking.heard
    }


@dataclass(frozen=True, eq=False)
class Sentence:
    """What a person asks for, with the words that a database learned."""

    learned: Learned
    text: str
    # Phrases in it that name one motion ("hand stand"): lemmas that a caption must hold together
    phrases: tuple[tuple[str, ...], ...] = ()
    # Words that no caption holds, and that are found where they are written
    found: frozenset[str] = frozenset()

    @cached_property
    def tokens(self) -> tuple[list[Token], list[NotUsed]]:
        """Its tokens, and its parts that are not used."""
        return tokenize(self.text, self.learned.synonyms, self.learned.lemmas)

    @cached_property
    def parsed(self) -> Question:
        """The question that it is, without what it says of a posture and is not measured."""
        question, told = parse_tokens(self.text, *self.tokens), list[NotUsed]()

        def posture_alone(action: Action) -> Action:
            beside, manner, reason = beside_posture(action.words), action.manner, OF_POSTURE
            heads = {*action.words} - MODIFIERS
            is_open = is_posture_alone(action.words) or bool(beside)
            if self._event(action.words) and not posture_of(action.words):
                degree = degree_of(action.all_words) if core(question.tree) else None
                measured = degree.words if degree else frozenset[str]()
                manner = tuple(one for one in manner if one not in measured)
                beside = tuple(w for w in beside_event(action.words) if w not in measured)
                is_open, reason = True, OF_EVENT
            if not (is_open and (beside or manner)) or not heads.isdisjoint(self.known):
                return action
            told.extend(NotUsed(as_said(w), reason) for w in (*beside, *manner))
            words = tuple(word for word in action.words if word not in beside)
            return Action(words, tuple(one for one in action.manner if one not in manner))

        tree = map_actions(question.tree, posture_alone)
        return replace(question, tree=tree, not_used=(*question.not_used, *told))

    @cached_property
    def forms(self) -> dict[str, str]:
        """Its words: lemma -> word as written; of a manner that captions say, the word they use."""
        lemmas, counts = self.learned.lemmas, dict.fromkeys(self.known, 1)
        forms = [f for f in reversed(forms_of(self.text)) if f not in STOP_WORDS]  # without a lemma
        written = {lemma(form, lemmas): form for form in forms}
        found = dict[str, str]()
        for token in self.tokens[0]:
            manner = known_manner(token.words[0], counts) if token.kind == "manner" else None
            if token.kind == "manner":
                word = manner or motion_word(token.text, self.learned.synonyms, lemmas)
                found |= {} if word is None else {word: token.text}
            elif token.kind in ("word", "quote"):
                found |= {word: written.get(word, word) for word in token.words}
        return found

    @cached_property
    def verbs(self) -> frozenset[str]:
        """Lemmas of the words that name its actions, known or not."""
        return verbs_in(self.text, self.learned.synonyms, self.learned.lemmas)

    @cached_property
    def known(self) -> frozenset[str]:
        """The words that some caption of the database holds."""
        return frozenset(self.learned.known_words)

    @cached_property
    def seen(self) -> frozenset[tuple[str, ...]]:
        """Its postures that are measured alone: those of several actions, or in unknown words."""
        actions = actions_of(self.parsed.tree)
        return self._of_postures(actions, len(actions) > 1)

    @cached_property
    def excluded(self) -> tuple[Action, ...]:
        """Its excluded actions."""
        every = [node for node in walk(self.parsed.tree) if isinstance(node, Without)]
        parts = (part for node in every for one in node.excluded for part in walk(one))
        return tuple(part for part in parts if isinstance(part, Action))

    @cached_property
    def unseen(self) -> frozenset[tuple[str, ...]]:
        """Its excluded postures in unknown words, which are looked for in the motion alone."""
        return self._of_postures(self.excluded, False)

    @property
    def postures(self) -> frozenset[tuple[str, ...]]:
        """Its postures that are looked for in the motion alone, asked for or excluded."""
        return self.seen | self.unseen

    def _of_postures(self, actions: Sequence[Action], is_known: bool) -> frozenset[tuple[str, ...]]:
        """The actions that are postures alone; those of known words only if `is_known`.

        No caption that says "stand" tells on how many legs.
        """
        said = self.known & OF_POSTURES - {"still"}
        return frozenset(
            action.words
            for action in actions
            if (is_posture_alone(action.words) and not action.manner)
            or (self._event(action.words) and not posture_of(action.words))
            if is_known
            or posture_of(action.words).startswith("on ")
            or not posture_of(action.words)
            or not self._is_said(action.words, said)
        )

    def _event(self, words: Sequence[str]) -> str:
        """The posture of an action, or its clear event where captions say none of its words."""
        return seen_event(words, self._named)

    @cached_property
    def _named(self) -> frozenset[str]:
        """The words that captions say, and those that are found where they are written."""
        return self.found.union(self.learned.word_numbers)

    def _is_said(self, words: Sequence[str], of_postures: frozenset[str]) -> bool:
        """Whether captions say the posture of an action: of a hand at a place, all its words."""
        if posture_of(words).split(" ")[0] not in ("at", "lift", "land", "takeoff"):
            return not of_postures.isdisjoint(words)
        return self.is_said([word for word in words if word not in PLAIN])

    def is_said(self, words: Sequence[str]) -> bool:
        """Whether a caption says all of some words of one action."""
        return _say_together(self.learned, {self.learned.word_numbers.get(w, -1) for w in words})

    def in_known_words(self, added: Mapping[str, int], is_seen: bool = True) -> KnownQuestion:
        """The question in the words that the database knows.

        `added`: Further ones -> counts. `is_seen`: Whether postures are measured.
        """
        association = self.learned.association
        counted = zip(association.words, association.counts)
        counts = {word: int(count) for word, count in counted if count > 0} | dict(added)
        is_several = is_seen and core(self.parsed.tree) is None
        measured = directions_to_measure if is_several else None
        return hold_to_known(self.parsed, counts, self.postures if is_seen else (), measured)


def sentence_of(learned: Learned, text: str) -> Sentence:
    """What a person asks for in a text, without the frame of a request."""
    return Sentence(learned, without_request(text))


def find_takings(
    sentence: Sentence, table: NearbyTable, added: Collection[str] = ()
) -> dict[str, Taking]:
    """Lemma of every word that is in no caption -> its replacement or suggestions.

    `added`: words that are known to the question although they were not learned.
    """
    learned = sentence.learned
    if learned.fitted_word_map is None:
        _ = learned.word_map  # raises NotLearnedError if no words were learned
    known = sentence.known.union(added)
    return {
        word: take_word(form, known, table)
        for word, form in sentence.forms.items()
        if word not in known and word not in learned.word_numbers
    }


def unknown_words(
    sentence: Sentence,
    table: NearbyTable,
    added: Collection[str] = (),
    is_replaced: bool = True,
    by_meaning: bool = False,
) -> dict[str, Taking]:
    """As :func:`find_takings`; a question without any known or replaced word is refused.

    `is_replaced`: Whether unknown words are replaced or suggestions made for them; otherwise, known
    words of similar spelling are suggested for those that are not English. `by_meaning`: Whether
    words that are not replaced are heard by their meaning.
    """
    seen = set[str]().union(*sentence.postures)
    found = find_takings(sentence, table, added)
    takings = {word: taking for word, taking in found.items() if word not in seen}
    if not is_replaced:
        takings = {word: replace(taking, words=()) for word, taking in takings.items()}
    if by_meaning:
        takings = hear_by_meaning(sentence.learned, takings, table)
    is_known = not sentence.known.union(added, seen).isdisjoint(sentence.forms)
    if takings and not is_known and not any(taking.heard for taking in takings.values()):
        raise UnknownWordsError(nothing_known(sentence.text, hints_of(takings)))
    return takings


def near_sentence(sentence: Sentence, table: NearbyTable) -> Sentence | None:
    """A question with near words in place of known ones; None if there are none.

    A word is near by the table, and if at least half of the actions of captions that say the known
    word ("run/jog") say it too. So who says "jog" may also mean what others call "run" alone.
    """
    learned, text = sentence.learned, sentence.text
    for word, form in sentence.forms.items():
        if word not in sentence.known or word in MODIFIERS:
            continue
        taking = take_word(word, sentence.known - {word}, table)
        if not taking.is_taken:
            continue
        number, other = (learned.word_numbers.get(w, -1) for w in (word, taking.words[0][0]))
        actions = (action for listed in learned.listed_actions.values() for action in listed)
        said = [action for action in actions if number in action]
        if said and 2 * sum(other in action for action in said) >= len(said):
            text = re.sub(rf"\b{re.escape(form)}\b", taking.words[0][0], text, flags=re.IGNORECASE)
    return None if text == sentence.text else replace(sentence, text=text)


def with_likeliest(learned: Learned, takings: Mapping[str, Taking]) -> Learned:
    """The learned model, with the likeliest known words as synonyms of the words they replace.

    For requests of one sequence of symbols, which a mean of several words does not have.
    """
    likeliest = {word: taking.words[0][0] for word, taking in takings.items() if taking.is_taken}
    return replace(learned, synonyms={**learned.synonyms, **likeliest}) if likeliest else learned


def nearest_suggested(sentence: Sentence, table: NearbyTable) -> dict[str, str]:
    """The likeliest suggestion for every word that no caption holds, where there is one.

    Known words of like spelling are suggested only where the table has none.
    """
    suggested = {}
    for word, taking in find_takings(sentence, table).items():
        known = [*(near for near, _ in taking.words), *taking.spelling]
        if known:
            suggested[word] = known[0]
    return suggested


def write_otherwise(
    sentence: Sentence, find: Callable[[], Collection[str]] = tuple
) -> tuple[Sentence, dict[str, Taking]]:
    """A question with unknown words written as known ones; and these, as they were written.

    `find` returns further known words. It is called only if a word of the question is not known.
    """
    written, same = _written_otherwise(sentence, find)
    plain, light = _without_light_heads(written)
    return plain, {**same, **light}


def _written_otherwise(
    sentence: Sentence, find: Callable[[], Collection[str]]
) -> tuple[Sentence, dict[str, Taking]]:
    """A question in the spelling of the database, see :func:`write_otherwise`."""
    if sentence.known.issuperset(sentence.forms):
        return _joined(sentence)
    learned, known = sentence.learned, sentence.known.union(find())

    def together(words: Sequence[str | None]) -> bool:
        numbers = {learned.word_numbers.get(word or "", -1) for word in words}
        return not learned.listed_actions or -1 in numbers or _say_together(learned, numbers)

    changed, phrases = written_otherwise(
        sentence.text, known, learned.synonyms, learned.lemmas, together
    )
    if not phrases:
        return sentence, {}
    same = {word: Taking(word, ((phrase, 1.0),), is_same=True) for word, phrase in phrases.items()}
    lemmas = [words_of(phrase, learned.synonyms, learned.lemmas) for phrase in phrases.values()]
    return Sentence(learned, changed, tuple(map(tuple, lemmas))), same


def _without_light_heads(sentence: Sentence) -> tuple[Sentence, dict[str, Taking]]:
    """A question without nouns that say no more than the action before them ("salsa steps")."""
    learned, text, same = sentence.learned, sentence.text, dict[str, Taking]()
    forms = forms_of(text)
    for n, second in enumerate(forms[1:]):
        head = _light_head(second, learned.lemmas)
        if head is None:
            continue
        first = next((form for form in forms[n::-1] if _light_head(form) is None), forms[n])
        word = lemma(first, learned.lemmas)
        is_light = word in sentence.known - MODIFIERS - _LIGHT_HEADS - _SIZES
        if not is_light or (word, head) == ("box", "step") or sentence.is_said((word, head)):
            continue
        changed = re.sub(rf"\b({first})[ -]{second}\b", r"\1", text, flags=re.IGNORECASE)
        if changed != text:
            same[f"{first} {second}"] = Taking(f"{first} {second}", ((word, 1.0),), is_same=True)
        text = changed
    return (replace(sentence, text=text), same) if same else (sentence, same)


_LIGHT_TEXT = "step move position pose routine technique exercise session practice style activity"
_LIGHT_HEADS = frozenset(_LIGHT_TEXT.split())
_LIGHT_STARTS = tuple({head[:3] for head in _LIGHT_HEADS})
_SIZES = frozenset(("long", "short", "tiny", "broad", "deep", "brisk", "rapid", "heavy", "light"))


def _light_head(form: str, known: Mapping[str, str] | None = None) -> str | None:
    """The light head of which a word is a form; other words are not looked up (0.2 s)."""
    if not form.lower().startswith(_LIGHT_STARTS):
        return None
    head = lemma(form, known)
    return head if head in _LIGHT_HEADS else None


def _say_together(learned: Learned, numbers: set[int]) -> bool:
    """Whether a caption says all of some words of one action."""
    listed = learned.listed_actions.values()
    return any(numbers <= action for actions in listed for action in actions)


def _joined(sentence: Sentence) -> tuple[Sentence, dict[str, Taking]]:
    """A question with a compound of known words ("back flip") that captions write as one word."""
    learned, text, same = sentence.learned, sentence.text, dict[str, Taking]()
    for pair in pairwise(forms_of(text)):
        whole = "".join(pair)
        if whole not in sentence.known or not sentence.known.issuperset(pair):
            continue
        if sentence.is_said(pair):
            continue  # captions say both of one action: "side step"
        text = re.sub(rf"\b{pair[0]}[ -]{pair[1]}\b", whole, text, flags=re.IGNORECASE)
        same[" ".join(pair)] = Taking(" ".join(pair), ((whole, 1.0),), is_same=True)
    return (Sentence(learned, text), same) if same else (sentence, same)


def not_understood(sentence: Sentence, added: Collection[str] = ()) -> tuple[str, ...]:
    """The heads of a question's actions that are not known, as they were written.

    `added`: words that are known to the question although they were not learned: those that are
    written somewhere, and those that known words replace.
    """
    known, written = sentence.known.union(added, *sentence.postures), sentence.forms
    if known.issuperset(written):
        return ()
    missing = missing_heads(sentence.parsed.tree, sentence.verbs, known)
    return tuple(dict.fromkeys(written.get(word, word) for heads in missing for word in heads))
