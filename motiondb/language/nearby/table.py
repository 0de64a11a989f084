"""The table of nearby words: English words, and the known words that may replace each.

The file is made by ``benchmarks/nearby_table.py`` from WordNet 3.0 (its licence and notice are in
the same folder). It holds a line of text,

    motiondb nearby words 1 W P S

the W words, sorted, a line each, and then, little-endian: u4 (W + 1), the index of the first pair
of each word; u2 (P), the number of the replacement; u1 (P), the probability in units of 1/200; u4
(S), sorted CRC-32 sums of further English words, which are only known to be English. A word is
wrongly called English with probability S / 2^32, some 1 in 100,000.
"""

from __future__ import annotations

import zlib
from bisect import bisect_left
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motiondb.errors import SheetError
from motiondb.records import FloatArray

HEADING = "motiondb nearby words 1"
UNIT = 1.0 / 200.0  # Step of the stored probabilities: one byte holds 0 to 1.275


@dataclass(frozen=True, eq=False)
class NearbyTable:
    """The table of replacements of words."""

    words: tuple[str, ...]  # Words with an entry, sorted
    starts: NDArray[np.uint32]  # (words + 1,): index of the first pair of each word
    targets: NDArray[np.uint16]  # (pairs,): numbers of words; the likeliest of a word first
    chances: FloatArray  # (pairs,): probability of each replacement
    # (silent words,): sorted CRC-32 sums of English words without an entry
    silent: NDArray[np.uint32]

    def entry(self, word: str) -> tuple[tuple[str, float], ...]:
        """The replacements of a word, most probable first; () if there are none.

        >>> read_table(write_table({"amble": [("walk", 180)], "walk": []}, [])).entry("amble")
        (('walk', 0.9),)
        """
        place = self._place(word)
        if place is None:
            return ()
        pairs = range(int(self.starts[place]), int(self.starts[place + 1]))
        return tuple((self.words[self.targets[p]], float(self.chances[p])) for p in pairs)

    def is_english(self, word: str) -> bool:
        """Whether the word is in WordNet as one word that is not a name."""
        if self._place(word) is not None:
            return True
        total = zlib.crc32(word.encode())
        place = int(np.searchsorted(self.silent, total))
        return place < len(self.silent) and int(self.silent[place]) == total

    def _place(self, word: str) -> int | None:
        place = bisect_left(self.words, word)
        return place if place < len(self.words) and self.words[place] == word else None


def write_table(pairs: Mapping[str, Sequence[tuple[str, int]]], silent: Sequence[int]) -> bytes:
    """The bytes of a table.

    `pairs`: Word -> replacements, with probabilities in units of 1/200. Words that only occur as
    replacements have an empty entry.
    """
    words = sorted(pairs)
    number = {word: n for n, word in enumerate(words)}
    lengths = [len(pairs[word]) for word in words]
    flat = [pair for word in words for pair in pairs[word]]
    heading = f"{HEADING} {len(words)} {len(flat)} {len(silent)}"
    return b"".join(
        [
            "\n".join([heading, *words, ""]).encode("ascii"),
            np.cumsum([0, *lengths]).astype("<u4").tobytes(),
            np.array([number[target] for target, _ in flat], dtype="<u2").tobytes(),
            np.array([share for _, share in flat], dtype="u1").tobytes(),
            np.array(silent, dtype="<u4").tobytes(),
        ]
    )


def read_table(data: bytes, source: str = "words.table") -> NearbyTable:
    """Read a table from bytes."""
    heading, _, rest = data.partition(b"\n")
    parts = heading.decode("ascii", "replace").rsplit(" ", 3)
    if parts[0] != HEADING or len(parts) != 4 or not all(p.isdigit() for p in parts[1:]):
        raise SheetError(
            f"{source}: expected a table of nearby words ({HEADING!r}), found "
            f"{heading[:40]!r}. Install motiondb again."
        )
    n_words, n_pairs, n_silent = map(int, parts[1:])
    size = 4 * (n_words + 1) + 3 * n_pairs + 4 * n_silent
    text = rest[: len(rest) - size] if len(rest) >= size else b""
    words = tuple(text.decode("ascii", "replace").split("\n")[:-1])
    if len(words) != n_words:
        raise SheetError(
            f"{source}: expected {n_words} words, found {len(words)}. The file is damaged: "
            "install motiondb again."
        )
    at = len(rest) - size
    starts = np.frombuffer(rest, "<u4", n_words + 1, at)
    at += 4 * (n_words + 1)
    targets = np.frombuffer(rest, "<u2", n_pairs, at)
    at += 2 * n_pairs
    chances = np.frombuffer(rest, "u1", n_pairs, at) * UNIT
    silent = np.frombuffer(rest, "<u4", n_silent, at + n_pairs)
    return NearbyTable(words, starts, targets, np.round(chances, 3), silent)
