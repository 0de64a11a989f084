"""Build the table of nearby words that motiondb ships.

    python benchmarks/nearby_table.py --wordnet /usr/share/wordnet --vectors vectors.npz [--check]

``--check`` builds it again and compares it with the shipped table, byte by byte (exit 1 where it
differs).

WordNet 3.0: Debian's package wordnet-base (``apt-get install wordnet-base``, or its data.*,
index.* and cntlist.rev from anywhere else). vectors.npz: ``benchmarks/nearby_vectors.py``. The same
inputs give the same bytes; vectors computed by another version of torch or on another processor
may move a probability by a hundredth.
"""

from __future__ import annotations

import argparse
import hashlib
import sys
import zlib
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from motiondb.language.nearby.table import UNIT, read_table, write_table
from nearby_words.choice import N_WORDS, answers, by_use
from nearby_words.key import read_key, read_pairs, read_vocabulary
from nearby_words.model import (
    Model,
    Similarity,
    fit,
    pair_features,
    target_facts,
    training_pairs,
)
from nearby_words.opposites import vetoes
from nearby_words.pairs import Lexicon, base, evidence, make_lexicon
from nearby_words.wordnet import FLATTENING, read_wordnet

OUTPUT = Path(__file__).parents[1] / "motiondb" / "language" / "nearby" / "words.table"
N_TAKEN = 12
"""Known words kept for one word. Chosen by hand; not tuned."""
LEAST_KEPT = 0.03
"""Less likely words are not kept; below 0.3 no suggestion is made, but shares of a mixture are
used."""
LEAST_HELD = 0.3
"""A word is in the table if its most probable answer reaches this; others are never answered."""
GENERAL = frozenset({"go", "move"})
"""Words that fit nearly every motion and do not distinguish motions."""
GENERAL_SHARE = 0.5
"""What their probability is multiplied by. Of 49 wrong answers that were taken on the tuning list,
both vocabularies together, 16 were one of these words."""


def read_similarity(path: Path | None) -> Similarity:
    """Vectors of a file of nearby_vectors.py; none without a file."""
    if path is None:
        return Similarity({}, None)
    with np.load(path) as file:
        rows = {str(word): n for n, word in enumerate(file["words"])}
        return Similarity(rows, file["vectors"].astype(np.float32))


def taken(
    words: list[str],
    allowed: frozenset[str],
    lexicon: Lexicon,
    similarity: Similarity,
    model: Model,
    never: frozenset[tuple[str, str]],
) -> Iterator[tuple[str, list[tuple[str, float]]]]:
    """Every word with what it may be taken as, likeliest first."""
    known = target_facts(allowed, lexicon)
    for word in words:
        base_form = base(word)
        evidence_of = {
            t: e for t, e in evidence(word, lexicon).items()
            if t in allowed and (base_form, t) not in never and (word, t) not in never
        }  # fmt: skip
        targets, features = pair_features(word, evidence_of, lexicon, similarity, known)
        chances = model.probabilities(features)
        chances *= [GENERAL_SHARE if target in GENERAL else 1.0 for target in targets]
        kept = sorted(
            ((t, float(p)) for t, p in zip(targets, chances) if p >= LEAST_KEPT),
            key=lambda tp: (-tp[1], tp[0]),
        )
        yield word, kept


def shortened(
    kept: list[tuple[str, float]], places: Mapping[str, int], never: frozenset[tuple[str, str]]
) -> list[tuple[str, float]]:
    """The words of the table: probable, and common enough to occur in captions.

    A probability counts 0.3 less for every tenfold place of the target among all words by use, so
    that usual words come before rare ones of the same meaning (chosen on the tuning list). Of two
    words that are opposites the likelier is kept: a word is never taken as both.
    """

    def worth(pair: tuple[str, float]) -> float:
        return pair[1] - 0.3 * float(np.log10(1 + places.get(pair[0], 60_000)))

    best: list[tuple[str, float]] = []
    for target, chance in sorted(kept, key=lambda pair: (-worth(pair), pair[0])):
        against = {t for t, p in kept if (t, target) in never and p > chance}
        if len(best) < N_TAKEN and not against:
            best.append((target, chance))
    return sorted(best, key=lambda pair: (-pair[1], pair[0]))


def main() -> None:
    """Read, fit, choose, write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--wordnet", type=Path, required=True)
    parser.add_argument("--vectors", type=Path)
    parser.add_argument("--output", type=Path, default=OUTPUT)
    parser.add_argument("--check", action="store_true", help="Compare with the shipped table.")
    asked = parser.parse_args()
    wordnet = read_wordnet(asked.wordnet, FLATTENING)
    lexicon, similarity = make_lexicon(wordnet), read_similarity(asked.vectors)
    ordered = by_use(wordnet)
    features, right, _ = training_pairs(
        read_key("tuning"), read_vocabulary("both"), lexicon, similarity
    )
    model = fit(features, right)
    allowed = frozenset(answers(ordered))
    if similarity.vectors is not None:
        allowed &= similarity.rows.keys()
    never = vetoes(wordnet, read_pairs("never"))
    places = {word: n for n, word in enumerate(ordered)}
    held: dict[str, list[tuple[str, float]]] = {}
    for word, kept in taken(ordered, allowed, lexicon, similarity, model, never):
        if kept and kept[0][1] >= LEAST_HELD:
            held[word] = shortened(kept, places, never)
        if len(held) == N_WORDS:
            break
    named = sorted({*held, *(t for kept in held.values() for t, _ in kept)})
    silent = sorted(zlib.crc32(w.encode()) for w in ordered if w not in set(named))
    pairs = {w: [(t, max(1, round(p / UNIT))) for t, p in held.get(w, [])] for w in named}
    made = write_table(pairs, silent)
    print(f"{len(held)} words, {sum(map(len, pairs.values()))} pairs, {len(silent)} silent words, "
          f"{len(made)} bytes, sha256 {hashlib.sha256(made).hexdigest()}")  # fmt: skip
    if not asked.check:
        asked.output.write_bytes(made)
    elif made != OUTPUT.read_bytes():
        sys.exit(f"differs from {OUTPUT}: {_differences(made, OUTPUT.read_bytes())}")
    else:
        print("the same as the shipped table, to the last byte")


def _differences(made: bytes, shipped: bytes) -> str:
    """In how many words two tables differ, and by how much their probabilities do."""
    one, other = (read_table(content) for content in (made, shipped))
    words = {*one.words, *other.words}
    pairs = [(dict(one.entry(w)), dict(other.entry(w))) for w in words]
    gaps = [abs(a.get(t, 0.0) - b.get(t, 0.0)) for a, b in pairs for t in {*a, *b}]
    return f"{sum(a != b for a, b in pairs)} words, probabilities by at most {max(gaps, default=0)}"


if __name__ == "__main__":
    main()
