"""What can be computed about answers on real captures: right or wrong, overlap, slip, jerk."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from motiondb.body import retarget
from motiondb.body.contacts import foot_slip
from motiondb.language import vocabulary
from motiondb.language.question.readings import readings
from motiondb.learn.learned import Learned
from motiondb.meaning import by_question, score_vectors, word_evidence, word_map
from motiondb.records import MOTION_FPS, CaptureInfo, Match, Motion
from motiondb.search.takings import Sentence

Part = tuple[float, float, str]
"""start, end (seconds), label of a known part of a long take."""


def load_parts(sheet: Path, names: Iterable[str]) -> dict[str, list[Part]]:
    """capture -> its known parts, from a sheet with columns clip, start_s, end_s, label."""
    full = {name.rsplit("/", 1)[-1]: name for name in names}
    parts: dict[str, list[Part]] = {}
    if sheet.is_file():
        with sheet.open(encoding="utf-8", newline="") as file:
            for row in csv.DictReader(file, delimiter="\t"):
                if row["clip"] in full:
                    part = (float(row["start_s"]), float(row["end_s"]), row["label"])
                    parts.setdefault(full[row["clip"]], []).append(part)
    return parts


def overlap(start: float, end: float, parts: Sequence[Part], labels: Sequence[str]) -> float:
    """Share of an interval that lies in parts with one of the labels."""
    inside = [
        max(0.0, min(end, high) - max(start, low)) for low, high, label in parts if label in labels
    ]
    return sum(inside) / max(end - start, 1e-9)


def union_overlap(
    start: float, end: float, parts: Sequence[Part], labels: Sequence[str]
) -> tuple[float, Part | None]:
    """Largest intersection over union of an interval with a part of the labels, and that part."""
    best: tuple[float, Part | None] = (0.0, None)
    for part in parts:
        if part[2] in labels:
            shared = max(0.0, min(end, part[1]) - max(start, part[0]))
            value = shared / (max(end, part[1]) - min(start, part[0]))
            best = max(best, (value, part), key=lambda pair: pair[0])
    return best


def said_words(learned: Learned) -> dict[str, frozenset[str]]:
    """capture -> the motion words that people wrote about it."""
    captions = learned.captions
    return {
        info.name: frozenset(
            word
            for caption in captions.get(number, ())
            for word in vocabulary.words_of(caption.words, learned.synonyms)
        )
        for number, info in learned.captures.items()
    }


def hears_unseen_performers(learned: Learned) -> dict[int, word_evidence.TakeScores]:
    """Log-odds of words in every capture by word maps that saw none of its performer's words.

    Symbols and the standardisation of scores come from all motion, which needs no words.
    """
    said = said_words(learned)
    number = {word: n for n, word in enumerate(learned.association.words)}
    described = [c for c in learned.rows if said[learned.captures[c].name]]
    vectors = np.stack([_whole_vector(learned, c) for c in described])
    presence = np.zeros((len(described), len(number)), dtype=bool)
    for row, capture in enumerate(described):
        presence[row, [number[w] for w in said[learned.captures[capture].name]]] = True
    performers = {c: learned.captures[c].tags.get("performer", f"#{c}") for c in learned.rows}
    who = np.unique([performers[c] for c in described], return_inverse=True)[1]
    takes: dict[int, word_evidence.TakeScores] = {}
    for performer in sorted(set(performers.values())):
        seen = np.array([performers[c] != performer for c in described])
        fit = word_map.fit_word_map(vectors[seen], presence[seen], who[seen])
        blind = _with_word_map(learned, fit)
        takes |= {
            c: blind.evidence.by_motion.takes[c] for c in learned.rows if performers[c] == performer
        }
    return takes


def _whole_vector(learned: Learned, capture: int) -> np.ndarray:
    rows = learned.rows[capture]
    starts, ends = learned.segments.starts[rows], learned.segments.ends[rows]
    return score_vectors.interval_vectors(
        learned.segment_rows[rows], starts, ends, np.array([0]), ends[-1:]
    )[0]


def _with_word_map(learned: Learned, fit: word_map.WordMap) -> Learned:
    return replace(learned, fitted_word_map=fit)


def search_takes(
    learned: Learned, takes: Mapping[int, word_evidence.TakeScores], words: str, limit: int
) -> list[Match]:
    """As ``search_words``, on log-odds of one's own."""
    question = Sentence(learned, words).in_known_words({})
    number = {word: n for n, word in enumerate(learned.association.words)}
    read, _ = readings(question.tree)
    hits = []
    for capture, take in takes.items():
        hit = by_question.search_take(take, read, number)
        if hit is not None:
            hits.append((-hit.log_odds, capture, hit))
    hits.sort(key=lambda entry: entry[:2])
    return [
        Match(
            rank,
            learned.captures[capture].name,
            hit.start / MOTION_FPS,
            hit.end / MOTION_FPS,
            float(1.0 / (1.0 + np.exp(-hit.log_odds))),
        )
        for rank, (_, capture, hit) in enumerate(hits[:limit], start=1)
    ]


def average_precision(ranked: Sequence[bool]) -> float:
    """Mean over the right ones of the share of right ones down to there.

    >>> average_precision([True, False, True])
    0.8333333333333333
    """
    right = np.flatnonzero(ranked)
    return float(np.mean((np.arange(len(right)) + 1) / (right + 1))) if len(right) else 0.0


@dataclass(frozen=True)
class WordPrecision:
    """Over words that at least two performers were described with, weighing words equally.

    words : how many. precision : mean average precision. chance : of a random order, about.
    """

    words: int
    precision: float
    chance: float


def word_precision(
    learned: Learned, takes: Mapping[int, word_evidence.TakeScores]
) -> WordPrecision:
    """How well captures are ranked for single words by the whole capture's log-odds."""
    said = said_words(learned)
    infos: dict[int, CaptureInfo] = {
        c: learned.captures[c] for c in takes if said[learned.captures[c].name]
    }
    values, priors = [], []
    for number, word in enumerate(learned.association.words):
        right = {c: word in said[info.name] for c, info in infos.items()}
        performers = {infos[c].tags.get("performer") for c, words in right.items() if words}
        if len(performers) < 2:
            continue
        order = sorted(infos, key=lambda c: -takes[c].whole[number])
        values.append(average_precision([right[c] for c in order]))
        priors.append(sum(right.values()) / len(right))
    return WordPrecision(len(values), float(np.mean(values)), float(np.mean(priors)))


@dataclass(frozen=True)
class Smoothness:
    """slip: cm/s of feet in contact; jerk: m/s3, mean over joints and frames; seconds."""

    slip: float
    jerk: float
    seconds: float


def smoothness(motion: Motion) -> Smoothness:
    """Foot slip and jerk of a motion on the standard body at 30 frames a second."""
    positions, _ = retarget.motion_positions(motion)
    third = np.diff(positions, n=3, axis=0) * MOTION_FPS**3
    jerk = float(np.linalg.norm(third, axis=-1).mean()) if len(third) else 0.0
    return Smoothness(100.0 * foot_slip(motion), jerk, motion.n_frames / MOTION_FPS)
