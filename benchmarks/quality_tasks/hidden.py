"""Words that no caption holds: each word is hidden from all captions, then asked for.

Five folds by performer. A hidden word is heard by its meaning, whether or not the table of nearby
words would replace it: by the known words nearest to its vector, and by its own likeness to the
captions that motion suggests.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from motiondb.database.loading import nearby_table
from motiondb.language.vocabulary import MODIFIERS, words_of
from motiondb.language.word_vectors.word_vectors import shares_by_meaning, word_vectors
from motiondb.meaning import word_map
from motiondb.meaning.amounts import usual_degree
from motiondb.meaning.caption_map import likeness_of
from motiondb.meaning.occurrences import find_occurrences, measured_track, seen_event
from motiondb.records import FloatArray
from motiondb.search.asked_words import mixture
from motiondb.search.takings import LEAST_NEAR, take_word
from nearby_words.retrieval import precision
from quality_protocol.captures import load_cmu, performer_folds, without_copies
from quality_protocol.confidence import mean_of
from quality_protocol.recognition import Recognised, recognise
from quality_protocol.report import Measure, TaskReport

LEAST_TRAINED, LEAST_SHOWN = 3, 2


@dataclass(frozen=True)
class Asked:
    """Average precision of one hidden word in one fold; NaN where a method is silent."""

    near: float  # Cosine of the nearest known word
    meaning: float
    nearby: float
    motion: float
    chance: float


def run(data: Path, seed: int) -> TaskReport:
    """Hide every word, and ask for it."""
    captures = without_copies(load_cmu(data))
    said = [{w for text in c.captions for w in words_of(text)} for c in captures]
    names = sorted(set().union(*said))
    words = np.array([[name in each for name in names] for each in said])
    folds, has = performer_folds([c.performer for c in captures]), words.any(axis=1)
    groups = np.unique([c.performer for c in captures], return_inverse=True)[1]
    seen = recognise(captures, np.ones(len(captures), dtype=bool), seed)
    tracks = [measured_track(c.motion) for c in captures]
    asked = []
    for k in range(5):
        train, gallery = np.flatnonzero((folds != k) & has), np.flatnonzero((folds == k) & has)
        shown = words[gallery]
        usable = words[train].sum(axis=0) >= LEAST_TRAINED
        usable &= (shown.sum(axis=0) >= LEAST_SHOWN) & ~shown.all(axis=0)
        for word in np.flatnonzero(usable):
            if names[word] not in MODIFIERS:
                one = _ask(seen, words, (train, gallery), groups, names, int(word))
                shown_by_motion = _by_motion([tracks[c] for c in gallery], names[word])
                by_motion = float("nan")
                if shown_by_motion is not None:
                    by_motion = precision(shown_by_motion, words[gallery, word])
                asked.append(replace(one, motion=by_motion))
    return _report(asked, len(captures), _both_said(said), seed)


def _both_said(said: Sequence[set[str]]) -> str:
    """How probable the table calls its replacements, and how often captions say both words."""
    names = set().union(*said)
    stated, shared = [], []
    for word in sorted(names - MODIFIERS):
        taking = take_word(word, names - {word}, nearby_table())
        if taking.is_taken:
            broader = [words for words in said if taking.words[0][0] in words]
            stated.append(taking.probability)
            shared.append(np.mean([word in words for words in broader]))
    return (
        f"The table replaces {len(stated)} of all words, each hidden alone, with a mean "
        f"probability of {np.mean(stated):.2f}; of the captures whose captions say the likeliest "
        f"known word, {np.mean(shared):.2f} also say the hidden one (mean over words), so answers "
        "for a replaced word carry no probabilities."
    )


def _by_motion(tracks: Sequence[FloatArray], word: str) -> FloatArray | None:
    """How clearly captures show the event of a word, as a search alone orders them; None: no event.

    By the degree of its clearest one, or the length of the longest; -1 without any.
    """
    event, degree = seen_event((word,), ()), usual_degree((word,))
    if not event:
        return None
    found = []
    for track in tracks:
        times = find_occurrences(track, event)
        amounts = (degree.amount(track, *t) if degree else float(t[1] - t[0]) for t in times)
        found.append(max(amounts, default=-1.0))
    return np.array(found)


def _ask(
    seen: Recognised,
    words: NDArray[np.bool_],
    parts: tuple[NDArray[np.int64], NDArray[np.int64]],
    groups: NDArray[np.int64],
    names: Sequence[str],
    word: int,
) -> Asked:
    """Hide a word from the training captures, and ask for it in the gallery."""
    train, gallery = parts
    said = words[train].copy()
    said[:, word] = False
    train, said = train[said.any(axis=1)], said[said.any(axis=1)]
    fit = word_map.fit_word_map(seen.vectors[train], said, groups[train])
    captions = seen.captions(train, said, names)
    suggested = captions.suggest(seen.vectors[gallery])
    acts = np.array([name not in MODIFIERS for name in names])
    held = np.asarray(said.any(axis=0), dtype=bool) & acts
    vectors = np.where(held[:, None], captions.meanings, 0.0)
    own = word_vectors().of([names[word]])
    shares = shares_by_meaning(vectors, own[0])
    takes = seen.hear(fit, captions, gallery)
    odds = np.stack([0.5 * (t.windows @ shares).max() + 0.5 * (t.whole @ shares) for t in takes])
    meanings = suggested.meanings
    odds += likeness_of(meanings, own)[:, 0] - likeness_of(meanings, captions.meanings) @ shares
    right = words[gallery, word]
    known = {name for n, name in enumerate(names) if said[:, n].any()}
    taking = take_word(names[word], known, nearby_table())
    nearby = float("nan")
    if taking.is_taken:
        taken = mixture([taking], names)[:, 0]
        both = [replace(t, windows=t.windows @ taken, whole=t.whole @ taken) for t in takes]
        nearby = precision(np.array([0.5 * t.windows.max() + 0.5 * t.whole for t in both]), right)
    near = float((vectors @ own[0]).max())
    return Asked(near, precision(odds, right), nearby, float("nan"), float(right.mean()))


def _report(asked: Sequence[Asked], n_captures: int, both: str, seed: int) -> TaskReport:
    """One row for each group of words, and for those that the table replaces."""
    groups = {
        "all words": list(asked),
        f"nearest known word at {LEAST_NEAR:g} or more": [a for a in asked if a.near >= LEAST_NEAR],
        f"nearest known word below {LEAST_NEAR:g}": [a for a in asked if a.near < LEAST_NEAR],
        "replaced by the table": [a for a in asked if not np.isnan(a.nearby)],
        "seen in the motion": [a for a in asked if not np.isnan(a.motion)],
        "seen, and replaced": [a for a in asked if not np.isnan(a.motion + a.nearby)],
    }
    rows: list[tuple[str | float | Measure, ...]] = []
    for name, some in groups.items():
        means = {
            what: mean_of(values, seed)
            for what in ("meaning", "nearby", "motion", "chance")
            if not np.isnan(values := [getattr(a, what) for a in some]).any()
        }
        cells = (means.get(what, "") for what in ("meaning", "nearby", "motion", "chance"))
        rows.append((name, str(len(some)), *cells))
    return TaskReport(
        "Words that no caption holds",
        f"{n_captures} CMU captures, five folds by performer. Every word with at least "
        f"{LEAST_TRAINED} training captures and {LEAST_SHOWN} in the gallery, other than "
        "directions, manners and parts of the body, is hidden from all captions and then asked "
        "for. Mean average precision; intervals over words. `search` ranks by meaning only words "
        "that the table does not replace and whose nearest known word is at the bound or above. "
        "Clear events are looked for in the motion alone, before the table is asked. "
        f"{both}",
        (
            "words",
            "number",
            "by meaning",
            "by the table of nearby words",
            "in the motion",
            "chance",
        ),
        tuple(rows),
    )
