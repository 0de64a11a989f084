"""The key of nearby words as data; see benchmarks/nearby_words/README.md."""

from __future__ import annotations

from pathlib import Path

from motiondb.language.lemmas import lemma

FOLDER = Path(__file__).parent


def read_key(name: str) -> dict[str, frozenset[str]]:
    """From each word, as written, to the lemmas that are right; ``key``, ``blind``, ``tuning``."""
    return {
        word: frozenset() if right == "-" else frozenset(lemma(w) for w in right.split(", "))
        for word, right in _rows(f"{name}.tsv")
    }


def read_vocabulary(name: str) -> frozenset[str]:
    """Lemmas that may be answered: ``captions`` or ``both`` (captions and usual words)."""
    return frozenset(
        lemma(word) for word, source in _rows("vocabulary.tsv") if name in (source, "both")
    )


def read_pairs(name: str) -> list[tuple[str, str]]:
    """Pairs of words: ``opposites`` of the key or ``never``, which the builder reads."""
    return [(one, other) for one, other in _rows(f"{name}.tsv")]


def _rows(name: str) -> list[tuple[str, str]]:
    lines = (FOLDER / name).read_text(encoding="utf-8").splitlines()[1:]
    return [(one, other) for one, other in (line.split("\t") for line in lines if line)]
