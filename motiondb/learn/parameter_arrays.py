"""Conversion of the typed records of the learned model to the arrays of the store, and back.

The table ``parameter`` of the store holds arrays of float64 by name. This module alone knows the
names. Databases of earlier versions lack some of them; each record describes its default.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from motiondb.language.translation.explanation import ExpectedCounts
from motiondb.learn.checking import LEAST_CHECKING
from motiondb.learn.drift import DriftBaseline
from motiondb.learn.knowledge import Origin, Started
from motiondb.learn.knowledge_arrays import knowledge_arrays, knowledge_from
from motiondb.learn.learned_model import LearnedModel
from motiondb.meaning.calibration import Certainties, certainties_from, certainty_arrays
from motiondb.meaning.counting import Counted, Counts, Reference
from motiondb.meaning.edge_map import EdgeMap
from motiondb.meaning.extents import ContextSpace
from motiondb.meaning.motion_judge import MotionJudge
from motiondb.meaning.place_fitting import Places
from motiondb.meaning.pooled_map import PooledMap
from motiondb.meaning.score_vectors import ScoreSpace
from motiondb.meaning.word_map import CaptionMoments, WordMap, WordMoments
from motiondb.records import Association, FloatArray, StoredLearning
from motiondb.symbols.acquisition import AcquisitionSettings
from motiondb.symbols.feature_space import FeatureSpace

Arrays = Mapping[str, FloatArray]

COUNTED_NAME = "counted_pairs"  # Array that exists if counts were kept
DRIFT_NAMES = ("learned_from", "drift_baseline")
"""Arrays of :class:`~motiondb.learn.drift.DriftBaseline`."""
ORIGIN_NAME = "start_origin"
"""Array that exists if the database learned with a start: the origin as JSON."""
CAPTION_NAMES = ("moment_caption_words", "moment_caption_cross")
"""Arrays of :class:`~motiondb.meaning.word_map.CaptionMoments`."""
LEMMA_NAME = "dictionary_forms"  # Array of the lemmas that the dictionary gave


def to_stored(model: LearnedModel) -> StoredLearning:
    """The stored form of the learned model; :func:`from_stored` is the inverse."""
    return StoredLearning(
        run_id=model.run_id,
        symbols=model.symbols,
        segments=model.segments,
        space=model.space,
        association=model.association,
        transition_counts=model.transition_counts,
        parameters=to_arrays(model),
    )


def from_stored(stored: StoredLearning) -> LearnedModel:
    """The learned model from its stored form."""
    arrays = stored.parameters
    lengths = Counter((int(length), int(m)) for m, length in arrays["length_counts"])
    model = LearnedModel(
        run_id=stored.run_id,
        symbols=stored.symbols,
        segments=stored.segments,
        space=stored.space,
        association=stored.association,
        transition_counts=stored.transition_counts,
        feature_space=FeatureSpace(arrays["feature_mean"], arrays["feature_projection"]),
        score_space=ScoreSpace(arrays["score_mean"], arrays["score_spread"]),
        context_space=_context_space(arrays),
        fitted_word_map=_word_map(arrays),
        certainties=certainties_from(arrays),
        lengths=dict(lengths),
        lemmas=lemmas_from(arrays),
        cutting=_cutting(arrays),
        description_lengths=arrays.get("description_lengths", np.zeros(0)),
        drift_baseline=drift_baseline_from(arrays),
        places=_places(arrays),
        started=started_from(arrays),
        judge=_judge(arrays),
        edges=_edges(arrays),
        pooled=_pooled(arrays),
        description_calibration=arrays.get("description_calibration"),
    )
    if COUNTED_NAME not in arrays:
        return model
    counted = _counted(arrays, model)
    if model.started is not None and counted.counts.moments.n < LEAST_CHECKING:
        model = replace(model, certainties=Certainties())  # older versions stored the start's
    return replace(model, counted=counted)


def to_arrays(model: LearnedModel) -> dict[str, FloatArray]:
    """Arrays by name of everything that has no table of its own."""
    lengths = [(m, n) for n, m in sorted(Counter(dict(model.lengths)).elements())]
    arrays: dict[str, FloatArray] = {
        "feature_mean": model.feature_space.mean,
        "feature_projection": model.feature_space.projection,
        "score_mean": model.score_space.mean,
        "score_spread": model.score_space.spread,
        "length_counts": np.array(lengths, dtype=float).reshape(-1, 2),
        LEMMA_NAME: lemma_array(model.lemmas),
        "recut": np.array([model.cutting.switch_cost, model.cutting.shortest]),
        "description_lengths": model.description_lengths,
    }
    for prefix, record in (("context", model.context_space), ("word", model.fitted_word_map)):
        if record is not None:
            arrays |= {f"{prefix}_{name}": np.asarray(v) for name, v in vars(record).items()}
    arrays |= certainty_arrays(model.certainties)
    if model.drift_baseline is not None:
        arrays |= _drift_arrays(model.drift_baseline)
    if model.places is not None:
        arrays |= _place_arrays(model.places)
    for prefix, part in (("judge", model.judge), ("edge", model.edges), ("pooled", model.pooled)):
        if part is not None:
            arrays |= {f"{prefix}_{name}": np.asarray(v, float) for name, v in vars(part).items()}
    if model.description_calibration is not None:
        arrays["description_calibration"] = model.description_calibration
    if model.counted is not None:
        arrays |= _counted_arrays(model.counted)
    if model.started is not None:
        arrays |= _started_arrays(model.started, model.counted)
    return arrays


def drift_baseline_from(arrays: Arrays) -> DriftBaseline | None:
    """The baseline of drift; None if it was not kept."""
    if any(name not in arrays for name in DRIFT_NAMES):
        return None
    mean, worst, frames = arrays["drift_baseline"]
    return DriftBaseline(
        arrays["learned_from"].astype(np.int64), float(mean), float(worst), float(frames)
    )


def lemmas_from(arrays: Arrays) -> dict[str, str]:
    """Lemmas that the dictionary gave for the words of captions; none if they were not kept."""
    lines = array_text(arrays.get(LEMMA_NAME, np.zeros(0))).splitlines()
    return dict(line.split(" ", 1) for line in lines)


def lemma_array(lemmas: Mapping[str, str]) -> FloatArray:
    """The bytes of lines ``form lemma``, one number a byte: the table holds numbers only."""
    text = "\n".join(f"{form} {lemma}" for form, lemma in lemmas.items())
    return text_array(text)


def _drift_arrays(baseline: DriftBaseline) -> dict[str, FloatArray]:
    return {
        "learned_from": baseline.captures.astype(np.float64),
        "drift_baseline": np.array([baseline.mean, baseline.worst, baseline.frames]),
    }


def _place_arrays(places: Places) -> dict[str, FloatArray]:
    return {
        **_shown_arrays("place", places.words, places.shown),
        **_shown_arrays("inferred", places.inferred, places.inferred_shown),
    }


def _shown_arrays(
    name: str, words: Mapping[int, Sequence[int]], shown: Mapping[int, FloatArray]
) -> dict[str, FloatArray]:
    sizes = [(c, *shown[c].shape) for c in words]
    return {
        f"{name}_takes": np.array(sizes, dtype=float).reshape(-1, 3),
        f"{name}_words": np.array([w for c in words for w in words[c]], dtype=float),
        f"{name}_shown": np.concatenate([np.zeros(0), *(shown[c].ravel() for c in words)]),
    }


def _places(arrays: Arrays) -> Places | None:
    if "place_takes" not in arrays:
        return None
    inferred = _shown(arrays, "inferred") if "inferred_takes" in arrays else ({}, {})
    return Places(*_shown(arrays, "place"), *inferred)


def _shown(arrays: Arrays, name: str) -> tuple[dict[int, tuple[int, ...]], dict[int, FloatArray]]:
    words, shown = {}, {}
    word, number = 0, 0
    for capture, n_segments, n_words in arrays[f"{name}_takes"].astype(np.int64).tolist():
        listed = arrays[f"{name}_words"][word : word + n_words]
        flat = arrays[f"{name}_shown"][number : number + n_segments * n_words]
        words[capture] = tuple(listed.astype(np.int64).tolist())
        shown[capture] = flat.reshape(n_segments, n_words)
        word, number = word + n_words, number + n_segments * n_words
    return words, shown


def _edges(arrays: Arrays) -> EdgeMap | None:
    if "edge_centre" not in arrays:
        return None
    return EdgeMap(*(arrays[f"edge_{name}"] for name in ("centre", "spread", "weights", "floors")))


def _pooled(arrays: Arrays) -> PooledMap | None:
    if "pooled_centre" not in arrays:
        return None
    return PooledMap(
        *(arrays[f"pooled_{name}"] for name in ("centre", "spread", "mean", "weights"))
    )


def _judge(arrays: Arrays) -> MotionJudge | None:
    if "judge_rows" not in arrays:
        return None
    return MotionJudge(
        arrays["judge_mean"],
        arrays["judge_spread"],
        arrays["judge_rows"].reshape(-1, len(arrays["judge_mean"])),
        arrays["judge_captures"].astype(np.int64),
        arrays["judge_calibration"],
    )


def _context_space(arrays: Arrays) -> ContextSpace | None:
    names = ("context_features", "context_mean", "context_projection")
    if any(name not in arrays for name in names):
        return None
    return ContextSpace(*(arrays[name] for name in names))


def _word_map(arrays: Arrays) -> WordMap | None:
    if "word_weights" not in arrays:
        return None
    names = ("weights", "offsets", "priors", "spreads", "calibration")
    ridge = float(arrays["word_ridge"]) if "word_ridge" in arrays else 1.0
    return WordMap(*(arrays[f"word_{name}"] for name in names), ridge=ridge)


def _cutting(arrays: Arrays) -> AcquisitionSettings:
    defaults = AcquisitionSettings()
    if "recut" not in arrays:
        return defaults
    switch_cost, shortest = arrays["recut"]
    return replace(defaults, switch_cost=float(switch_cost), shortest=int(shortest))


def _counted_arrays(counted: Counted) -> dict[str, FloatArray]:
    counts, fixed = counted.counts, counted.reference.association
    return {
        "counted_translation": counts.expected.translation,
        COUNTED_NAME: np.array(float(counts.expected.n_pairs)),
        **_table_arrays("counted", counts.expected.alignment),
        **_moment_arrays(counts.moments),
        "reference_translation": fixed.translation,
        "reference_counts": fixed.counts.astype(np.float64),
        **_table_arrays("reference", fixed.alignment),
    }


def _moment_arrays(moments: WordMoments) -> dict[str, FloatArray]:
    arrays = {
        f"moment_{name}": np.asarray(value)
        for name, value in vars(moments).items()
        if name != "captions"
    }
    if moments.captions is not None:
        arrays |= dict(zip(CAPTION_NAMES, (moments.captions.words, moments.captions.cross)))
    return arrays


def _moments(arrays: Arrays) -> WordMoments:
    captions = None
    if CAPTION_NAMES[0] in arrays:
        captions = CaptionMoments(*(arrays[name] for name in CAPTION_NAMES))
    vectors, words, gram, cross = (
        arrays[f"moment_{name}"] for name in ("vectors", "words", "gram", "cross")
    )
    return WordMoments(float(arrays["moment_n"]), vectors, words, gram, cross, captions)


def _counted(arrays: Arrays, model: LearnedModel) -> Counted:
    published = model.association
    fixed = Association(
        published.words,
        arrays["reference_counts"].astype(np.int64),
        arrays["reference_translation"],
        _tables("reference", arrays),
        published.log_likelihoods,
    )
    moments = _moments(arrays)
    expected = ExpectedCounts(
        arrays["counted_translation"], _tables("counted", arrays), int(arrays[COUNTED_NAME])
    )
    said = np.asarray(arrays.get("own_said", published.counts), dtype=np.int64)
    transitions = arrays.get("own_transitions", model.transition_counts)
    shapes = Counter(dict(model.lengths))
    if "own_lengths" in arrays:
        shapes = Counter({(int(n), int(m)): int(count) for n, m, count in arrays["own_lengths"]})
    counts = Counts(transitions, said, shapes, expected, moments)
    return Counted(counts, Reference(fixed, model.score_space, model.lemmas))


def _started_arrays(started: Started, counted: Counted | None) -> dict[str, FloatArray]:
    """A start, and the own counts, which then differ from the published ones."""
    knowledge = started.knowledge
    arrays = {f"start_{name}": v for name, v in knowledge_arrays(knowledge).items()}
    facts = knowledge.origin.facts() | {"digest": knowledge.origin.digest}
    arrays[ORIGIN_NAME] = text_array(json.dumps(facts))
    arrays["start_words"] = text_array("\n".join(knowledge.taught.words))
    arrays["start_names"] = text_array("\n".join(started.names))
    if counted is not None:
        counts = counted.counts
        lengths = [(*shape, n) for shape, n in sorted(counts.shapes.items())]
        arrays["own_said"] = counts.said.astype(np.float64)
        arrays["own_transitions"] = counts.transitions
        arrays["own_lengths"] = np.array(lengths, dtype=float).reshape(-1, 3)
    return arrays


def started_from(arrays: Arrays) -> Started | None:
    """The start that a database learned with; None if there was none."""
    if ORIGIN_NAME not in arrays:
        return None
    start_keys = ("start_words", "start_names", ORIGIN_NAME)
    rest = {n[6:]: v for n, v in arrays.items() if n.startswith("start_") and n not in start_keys}
    words, names = (tuple(array_text(arrays[n]).split("\n")) for n in start_keys[:2])
    return Started(knowledge_from(origin_from(arrays), words, rest), names)


def origin_from(arrays: Arrays) -> Origin:
    """Origin of the start, from the array ``ORIGIN_NAME``."""
    facts = json.loads(array_text(arrays[ORIGIN_NAME]))
    return Origin(**facts | {"runs": tuple(facts["runs"])})


def text_array(text: str) -> FloatArray:
    """The bytes of a text, one number a byte: the table holds numbers only."""
    return np.array(list(text.encode()), dtype=np.float64)


def array_text(numbers: FloatArray) -> str:
    """Inverse of :func:`text_array`."""
    return bytes(numbers.astype(np.uint8)).decode()


def _table_arrays(
    name: str, alignment: Mapping[tuple[int, int], FloatArray]
) -> dict[str, FloatArray]:
    shapes = sorted(alignment)
    flat = [np.zeros(0), *(alignment[shape].ravel() for shape in shapes)]
    return {
        f"{name}_shapes": np.array(shapes, dtype=float).reshape(-1, 2),
        f"{name}_alignment": np.concatenate(flat),
    }


def _tables(name: str, arrays: Arrays) -> dict[tuple[int, int], FloatArray]:
    shapes = [(int(length), int(m)) for length, m in arrays[f"{name}_shapes"]]
    ends = np.cumsum([m * (length + 1) for length, m in shapes])
    parts = np.split(arrays[f"{name}_alignment"], ends[:-1]) if shapes else []
    return {(n, m): part.reshape(m, n + 1) for (n, m), part in zip(shapes, parts)}
