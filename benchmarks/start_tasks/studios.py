"""Own captions from none to all, with a start, without, and with a start alone.

The captures of one studio teach the knowledge; those of the other are a user's folder. Its captures
are divided into five folds, by performer (CMU) or by style (Bandai-Namco names no performer). The
captures of a fold have no captions and are searched; some of the others have captions. All motion
of the folder is in the database, as it would be.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motiondb.body.features import FEATURE_STEP
from motiondb.language import vocabulary
from motiondb.language.word_vectors.word_vectors import word_vectors
from motiondb.learn import fitting, knowledge_making
from motiondb.learn.checking import carry, checked_words
from motiondb.learn.joining import is_set_aside, join_moments, strange_share
from motiondb.learn.knowledge import Knowledge, Started, begin
from motiondb.learn.learned import Learned
from motiondb.learn.learned_model import LearnedModel
from motiondb.learn.recognition import FeaturePool, LearnSettings, segment_table
from motiondb.learn.word_fitting import (
    TaughtWords,
    fit_words,
)
from motiondb.meaning import asked_certainty, word_evidence
from motiondb.meaning import regression as certainty
from motiondb.meaning.caption_map import solve_caption_map
from motiondb.meaning.word_map import usual
from motiondb.records import Caption, CaptureInfo, SegmentTable
from motiondb.symbols import acquisition
from quality_protocol.captures import (
    Capture,
    load_bandai,
    load_cmu,
    performer_folds,
    without_copies,
)
from quality_protocol.confidence import weighted_draws
from quality_protocol.whole_vectors import whole_vectors
from start_knowledge import SENTENCE
from start_tasks.judging import (
    Asked,
    brief,
    diagram,
    judge,
    measures,
    oracle_shift,
    pairs_of,
    told_interval,
)
from start_tasks.parts import Parts

CAPTIONED = (0, 10, 25, 50, 100, 1_000)
"""Numbers of own captions; the last means all."""
LEAST_TRAINED, LEAST_SHOWN = 3, 2
"""Captures of a word that must be trained and shown, as in quality_tasks/words.py."""
N_DRAWS = 500
"""Bootstrap samples of an interval. Chosen by hand for the time that it takes."""


@dataclass(frozen=True, eq=False)
class Folder:
    """Captures of a studio: words of every one, groups, and captions of the index alone."""

    captures: tuple[Capture, ...]
    words: tuple[frozenset[str], ...]
    captions: dict[int, tuple[Caption, ...]]
    groups: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class View:
    """A folder's captures cut and scored by some symbols."""

    table: SegmentTable
    n_symbols: int


def folder_of(captures: Sequence[Capture], index_alone: bool = True) -> Folder:
    """Words and captions of captures; sentences about a person are not of the CMU index."""
    said, captions = [], {}
    for number, capture in enumerate(captures):
        texts = [t for t in capture.captions if not (index_alone and SENTENCE.match(t))]
        actions = [a for t in texts for a in vocabulary.split_actions(t)]
        said.append(frozenset(word for action in actions for word in action))
        captions[number] = tuple(Caption(t) for t in texts)
    groups = tuple(c.style if c.performer == "bandai" else c.performer for c in captures)
    return Folder(tuple(captures), tuple(said), captions, groups)


def pool_of(captures: Sequence[Capture]) -> FeaturePool:
    bounds = np.cumsum([0, *(len(c.features) for c in captures)]).astype(np.int64)
    lengths = np.array([min(c.motion.n_frames, len(c.features) * FEATURE_STEP) for c in captures])
    features = np.concatenate([c.features for c in captures])
    return FeaturePool(np.arange(len(captures)), bounds, features, lengths)


def learn(folder: Folder, seed: int) -> LearnedModel:
    """What ``learn`` derives of a folder with all its captions."""
    taught = TaughtWords(folder.captions, {}, dict(enumerate(folder.groups)))
    rng = np.random.default_rng(seed)
    settings = LearnSettings(seed=seed)
    return fitting.fit_model(pool_of(folder.captures), taught, settings, rng, lambda _w, _s: None)


def _teach(folder: Folder, seed: int) -> Knowledge:
    return hand_on(folder, learn(folder, seed))


def hand_on(folder: Folder, model: LearnedModel) -> Knowledge:
    infos = {
        n: CaptureInfo(
            n, c.name, "", "", "captured", 30.0, 0, c.motion.n_frames / 30.0, 0, 1.0, "", 0,
            {"performer": group},
        )
        for n, (c, group) in enumerate(zip(folder.captures, folder.groups))
    }  # fmt: skip
    learned = Learned(**vars(model), captures=infos, captions=folder.captions, source="benchmark")
    return knowledge_making.make_knowledge(learned, "other", [], "", "benchmark")


def view_by(knowledge: Knowledge, captures: Sequence[Capture]) -> View:
    pool = pool_of(captures)
    frames = knowledge.feature_space.project(pool.features)
    cutting = acquisition.recut(frames, pool.bounds, knowledge.symbols, knowledge.cutting)
    table = segment_table(frames, pool, knowledge.symbols, cutting)
    return View(table, knowledge.symbols.n_symbols)


def across_studios(data: Path, source: str, seed: int, parts: Parts) -> dict[str, Any]:
    """Knowledge of one studio for the captures of the other."""
    studios = {
        "cmu": folder_of(without_copies(load_cmu(data))),
        "bandai": folder_of(without_copies(load_bandai(data))),
    }
    theirs = studios.pop(source)
    ((target, ours),) = studios.items()
    knowledge = parts.learned(f"{source}-{seed}-knowledge", lambda: _teach(theirs, seed))
    bare = Folder(ours.captures, ours.words, {}, ours.groups)
    alone = parts.learned(f"{target}-{seed}-bare", lambda: _view(learn(bare, seed)))
    views = {"with start": view_by(knowledge, ours.captures), "without start": alone}
    curves = _curves(ours, views, begin(knowledge, {}), seed, parts.of(source))
    return {
        "source": source,
        "target": target,
        "seed": seed,
        "captures": len(ours.captures),
        "symbols": {name: v.n_symbols for name, v in views.items()},
        "strange": round(strange_share(views["with start"].table), 4),
        **curves,
    }


def _view(model: LearnedModel) -> View:
    return View(model.segments, model.symbols.n_symbols)


def _curves(
    ours: Folder, views: dict[str, View], started: Started, seed: int, parts: Parts
) -> dict[str, Any]:
    has = np.array([bool(w) for w in ours.words])
    folds = performer_folds(ours.groups)
    draws = weighted_draws(len(ours.captures), seed, N_DRAWS)
    gathered: dict[tuple[str, int], list[dict[str, Any]]] = {}
    queries: list[int] = []

    def ask(
        used: str, chosen: NDArray[np.int64], gallery: NDArray[np.int64], asked: Sequence[str]
    ) -> dict[str, Any]:
        start = started if used == "with start" else None
        answers = answer(ours, views[used], chosen, gallery, start)
        return judge(ours.words, answers, gallery, asked, seed)

    for fold in np.unique(folds):
        gallery = np.flatnonzero((folds == fold) & has)
        others = np.flatnonzero((folds != fold) & has)
        asked = queries_of(ours.words, others, gallery)
        queries.append(len(asked))
        order = np.random.default_rng(seed).permutation(others)

        for n in CAPTIONED:
            chosen = np.sort(order[:n])
            aside = is_set_aside(views["with start"].table, len(chosen))
            for name in views:
                used = "without start" if aside else name
                judged = parts.judged(
                    f"{seed}-{fold}-{used}-{n}", partial(ask, used, chosen, gallery, asked)
                )
                gathered.setdefault((name, n), []).append(judged)
                print(fold, name, len(chosen), brief(judged), flush=True)
    rows = []
    for n in CAPTIONED:
        each = {name: measures(gathered[name, n], draws) for name in views}
        names = list(next(iter(each.values())))
        rows.append(
            {
                "captions": int(
                    min(n, np.mean([((folds != f) & has).sum() for f in np.unique(folds)]))
                ),
                **{name: {m: told_interval(each[name][m]) for m in names} for name in views},
                "answers with a probability": {
                    name: len(pairs_of(gathered[name, n], "calibration")) for name in views
                },
                "diagram of the start": diagram(pairs_of(gathered["with start", n], "withheld")),
                "oracle shift": oracle_shift(pairs_of(gathered["with start", n], "withheld")),
                "difference": {
                    m: told_interval(each["with start"][m] - each["without start"][m])
                    for m in names
                },
            }
        )
    return {"queries": int(sum(queries)), "rows": rows}


def queries_of(
    words: Sequence[frozenset[str]], others: NDArray[np.int64], gallery: NDArray[np.int64]
) -> list[str]:
    """Words that captions of enough others hold, and that some of the gallery show, not all."""
    every = sorted(set().union(*(words[i] for i in others)))
    trained = {w: sum(w in words[i] for i in others) for w in every}
    shown = {w: sum(w in words[i] for i in gallery) for w in every}
    return [w for w in every
            if trained[w] >= LEAST_TRAINED and LEAST_SHOWN <= shown[w] < len(gallery)]  # fmt: skip


def _no_examples(written: asked_certainty.Written) -> certainty.Certainty | None:
    """Nothing, in place of the certainty of examples, which takes most of the time."""
    del written
    return None


def answer(
    ours: Folder,
    view: View,
    captioned: NDArray[np.int64],
    gallery: NDArray[np.int64],
    started: Started | None,
) -> Asked | None:
    """Learn the words of some captions and ask the gallery; None if nothing was learned."""
    captions = {int(i): ours.captions[int(i)] for i in captioned}
    taught = TaughtWords(captions, {}, dict(enumerate(ours.groups)))
    asked_certainty.example_certainty = _no_examples  # only words are asked here
    if started is None and not len(captioned):
        return None
    fitted = fit_words(view.table, taught, started)
    published = fitted.published
    fit = published.fitted_word_map
    assert fit is not None
    rows = fitted.score_space.standardise(view.table.scores, view.table.movement)
    parts = {}
    for capture in map(int, gallery):
        first, last = np.searchsorted(view.table.capture_ids, [capture, capture + 1])
        parts[capture] = slice(int(first), int(last))
    moments, known = fitted.counted.counts.moments, published.association.words
    if started is not None:
        moments = join_moments(moments, known, started)
    whole = whole_vectors(rows, view.table, parts)
    of_captions = solve_caption_map(moments, word_vectors().of(known))
    odds = word_evidence.hear_takes(fit, of_captions, rows, view.table, parts).by_capture(parts)
    ranked = [0.5 * each[:-1].max(axis=0) + 0.5 * each[-1] for each in odds.values()]
    described = fit.log_odds(whole)
    scores = np.array(ranked)
    sure, names = fitted.certainties.words, published.association.words
    chances = None if sure is None else certainty.probability(sure.log_odds(scores[..., None]))
    withheld = None
    if started is not None:
        unchecked = ~checked_words(published.association, started, fitted.counted, sure)
        if chances is not None:
            chances[:, unchecked] = np.nan
        if not len(captioned):
            first = carry(started.taught.certainties).words
            assert first is not None
            withheld = certainty.probability(first.log_odds(scores[..., None]))
    return Asked(
        names, scores, described, scores - usual(fit),
        None if sure is None or np.isnan(sure.threshold) else sure.threshold, chances, withheld,
    )  # fmt: skip


def unseen_performers(data: Path, seed: int, parts: Parts) -> dict[str, Any]:
    """Knowledge of four folds of CMU performers for the captures of the fifth, without captions."""
    results = {}
    for name, index_alone in (("words of the CMU index", True), ("all captions", False)):
        every = folder_of(without_copies(load_cmu(data)), index_alone)
        folds = performer_folds(every.groups)
        draws = weighted_draws(len(every.captures), seed, N_DRAWS)
        judged = []
        for fold in np.unique(folds):
            theirs = folder_of(
                [every.captures[i] for i in np.flatnonzero(folds != fold)], index_alone
            )
            knowledge = parts.learned(
                f"unseen-{index_alone}-{seed}-{fold}", partial(_teach, theirs, seed)
            )
            one = parts.of("unseen").judged(
                f"{index_alone}-{seed}-{fold}",
                partial(_ask_unseen, every, folds == fold, knowledge, seed),
            )
            judged.append(one)
            print(name, fold, brief(one), flush=True)
        every_measure = measures(judged, draws)
        results[name] = {
            "queries": sum(len(j["rankings"]) for j in judged),
            **{m: told_interval(v) for m, v in every_measure.items()},
            "diagram of the start": diagram(pairs_of(judged, "withheld")),
            "oracle shift": oracle_shift(pairs_of(judged, "withheld")),
        }
    return {"seed": seed, "rows": results}


def _ask_unseen(
    every: Folder, held: NDArray[np.bool_], knowledge: Knowledge, seed: int
) -> dict[str, Any]:
    """Ask a database of the held captures alone, which starts and has no captions."""
    has = np.array([bool(w) for w in every.words])
    rows, gallery = np.flatnonzero(held), np.flatnonzero(held & has)
    asked = queries_of(every.words, np.flatnonzero(~held & has), gallery)
    chosen = [every.captures[i] for i in rows]
    ours = Folder(
        tuple(chosen), tuple(every.words[i] for i in rows), {}, tuple(every.groups[i] for i in rows)
    )
    answers = answer(
        ours, view_by(knowledge, chosen), np.zeros(0, dtype=np.int64),
        np.searchsorted(rows, gallery), begin(knowledge, {}),
    )  # fmt: skip
    return judge(every.words, answers, gallery, asked, seed)
