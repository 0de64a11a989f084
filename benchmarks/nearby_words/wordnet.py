"""WordNet's files as records: synsets, senses with their probability, words of glosses, opposites.

A *synset* is a set of words with one meaning; a word's *senses* are the synsets that contain it.
How likely a sense is meant is estimated by how often it was counted in texts (``cntlist.rev``),
each count raised by a half that shrinks with the rank of the sense, and weighted by the field
(``lexnames``) of the synset: in questions about motion, ``run`` is seldom to manage a company. The
texts are not about motion, so that the estimate is raised to the power ``FLATTENING``, which makes
rare senses likelier.

Files: wndb(5WN), lexnames(5WN). Source: Miller (1995), WordNet: a lexical database for English;
WordNet 3.0, Princeton University.
"""

from __future__ import annotations

import re
from collections import defaultdict
from dataclasses import dataclass, field
from pathlib import Path

PARTS = ("noun", "verb", "adj", "adv")
LETTERS = {"n": "noun", "v": "verb", "a": "adj", "s": "adj", "r": "adv"}
FIELD_WEIGHTS = {
    4: 1.5, 5: 1.0, 6: 1.0, 8: 2.0, 9: 0.4, 10: 0.4, 12: 0.5, 14: 0.4, 15: 0.7, 16: 0.4, 18: 0.7,
    19: 0.4, 20: 0.5, 21: 0.3, 22: 0.4, 23: 0.4, 24: 0.4, 26: 0.5, 27: 0.5, 28: 0.4,
    29: 2.0, 30: 0.7, 31: 0.3, 32: 0.5, 33: 1.5, 34: 1.5, 35: 2.0, 36: 0.7, 37: 0.5, 38: 4.0,
    39: 0.5, 40: 0.4, 41: 0.5, 42: 0.6, 43: 0.5,
}  # fmt: skip
"""How many times as likely a field is in questions about motion (verb.motion is 38, verb.contact
35, verb.body 29, noun.body 8, noun.act 4); 1 where not named. Chosen by hand; not tuned."""
RANK_SHARE = 0.6
"""What the half count of an uncounted sense is multiplied by at every rank. Chosen by hand."""
FLATTENING = 0.5
"""Power of the estimate of a sense. Of 1, 0.75 and 0.5, cross-validated on the tuning list: first
answers right .717, .722 and .746 among the words of the CMU captions, .769, .778 and .777 with
usual words."""

_TOKEN = re.compile(r"[a-z]+(?:'[a-z]+)?|[(),;:]")
_ENDS_PHRASE = """
of in on at by for from to with without that which who whom whose as used when where while
into through during after before over than or and ( ) , ; :
"""
_PHRASE_END = frozenset(_ENDS_PHRASE.split())
_ARTICLES = frozenset(["a", "an", "the", "any", "some", "one's", "his", "her", "its", "be"])


@dataclass(frozen=True)
class Synset:
    """One meaning.

    Attributes
    ----------
    part : noun, verb, adj or adv.
    field : number of its lexicographer's file, as in lexnames(5WN).
    words : its words in lower case, with _ between the parts of a phrase.
    pointers : (symbol, key of the other synset, number of the word here, number there); numbers
        count from 1, 0 if the relation holds between the synsets.
    definition : the gloss without examples.
    gloss : the definition and the examples.
    """

    part: str
    field: int
    words: tuple[str, ...]
    pointers: tuple[tuple[str, str, int, int], ...]
    definition: str
    gloss: str


@dataclass(frozen=True)
class WordNet:
    """synsets: by key, part and offset. senses: from a word to its (key, probability), likeliest
    first. counts: how often a word was counted in texts, in any sense. names: words that are only
    ever written with a capital letter."""

    synsets: dict[str, Synset]
    senses: dict[str, tuple[tuple[str, float], ...]]
    counts: dict[str, int] = field(default_factory=dict)
    names: frozenset[str] = frozenset()


def read_wordnet(folder: Path) -> WordNet:
    """Read data.*, index.* and cntlist.rev of a folder such as /usr/share/wordnet."""
    synsets: dict[str, Synset] = {}
    small: set[str] = set()
    for part in PARTS:
        for line in (folder / f"data.{part}").read_text(encoding="ascii").splitlines():
            if not line.startswith("  "):
                key, synset, written = _synset(line, part)
                synsets[key] = synset
                small.update(w for w in written if w.islower())
    counted = _counts(folder / "cntlist.rev")
    weights: dict[str, list[tuple[str, float]]] = defaultdict(list)
    counts: dict[str, int] = defaultdict(int)
    for part in PARTS:
        for line in (folder / f"index.{part}").read_text(encoding="ascii").splitlines():
            if line.startswith("  "):
                continue
            parts = line.split()
            word, n_senses = parts[0], int(parts[2])
            for rank, offset in enumerate(parts[-n_senses:]):
                key, count = f"{part}{offset}", counted.get((word, part, rank + 1), 0)
                chance = (count + 0.5 * RANK_SHARE**rank) * FIELD_WEIGHTS.get(
                    synsets[key].field, 1.0
                )
                weights[word].append((key, chance**FLATTENING))
                counts[word] += count
    return WordNet(
        synsets, {w: _normalised(s) for w, s in weights.items()}, dict(counts),
        frozenset(w for w in weights if w not in small),
    )  # fmt: skip


def is_plain(word: str) -> bool:
    """Whether a word is one word of letters."""
    return word.isascii() and word.isalpha() and len(word) > 1


def gloss_words(definition: str, part: str) -> tuple[list[str], list[str]]:
    """The words that head a definition, and all others, as they are written.

    The head of a verb's gloss is its first word, that of a noun's the last of its first phrase;
    where "or" joins words right there, all of them. Of adjectives and adverbs every word counts.

    >>> gloss_words("a leisurely walk (usually in some public place)", "noun")
    (['walk'], ['leisurely', 'usually', 'in', 'some', 'public', 'place'])
    >>> gloss_words("walk or tramp about", "verb")
    (['walk', 'tramp'], ['or', 'about'])
    """
    tokens = _TOKEN.findall(re.sub(r"\([^)]*\)", _inner, definition.lower(), count=0))
    tokens = tokens[: tokens.index(";")] if ";" in tokens else tokens
    while tokens and (tokens[0] in _ARTICLES or not tokens[0][0].isalpha()):
        tokens = tokens[1:]
    if part == "verb":
        places = [0]
        while len(tokens) > places[-1] + 2 and tokens[places[-1] + 1] in ("or", "and"):
            places.append(places[-1] + 2)
    elif part == "noun":
        end = next((i for i, t in enumerate(tokens) if t in _PHRASE_END), len(tokens))
        places = [end - 1] if end else []
    else:
        places = []
    heads = [tokens[i] for i in places if i < len(tokens)]
    others = [t for i, t in enumerate(tokens) if i not in places and t[0].isalpha()]
    return heads, others


def _inner(parenthesis: re.Match[str]) -> str:
    """A parenthesis in the middle keeps its words, one that opens a definition is left out."""
    return "" if parenthesis.start() == 0 else parenthesis.group()


def _synset(line: str, part: str) -> tuple[str, Synset, tuple[str, ...]]:
    head, _, gloss = line.partition(" | ")
    fields = head.split()
    n_words = int(fields[3], 16)
    written = tuple(re.sub(r"\(.*\)$", "", w) for w in fields[4 : 4 + 2 * n_words : 2])
    words = tuple(w.lower() for w in written)
    start = 4 + 2 * n_words
    n_pointers = int(fields[start])
    pointers = []
    for p in range(n_pointers):
        symbol, offset, letter, ends = fields[start + 1 + 4 * p : start + 5 + 4 * p]
        pointers.append((symbol, LETTERS[letter] + offset, int(ends[:2], 16), int(ends[2:], 16)))
    definition = re.split(r';\s*"|^"', gloss.strip())[0].strip()
    synset = Synset(part, int(fields[1]), words, tuple(pointers), definition, gloss)
    return part + fields[0], synset, written


def _counts(path: Path) -> dict[tuple[str, str, int], int]:
    parts = {"1": "noun", "2": "verb", "3": "adj", "4": "adv", "5": "adj"}
    counted = {}
    for line in path.read_text(encoding="ascii").splitlines():
        key, number, count = line.split()
        word, _, rest = key.partition("%")
        counted[word.lower(), parts[rest[0]], int(number)] = int(count)
    return counted


def _normalised(weighted: list[tuple[str, float]]) -> tuple[tuple[str, float], ...]:
    total = sum(chance for _, chance in weighted)
    return tuple(sorted(((k, c / total) for k, c in weighted), key=lambda kc: (-kc[1], kc[0])))
