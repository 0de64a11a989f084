"""The learned model with other counts: used when captures and words change."""

from __future__ import annotations

from dataclasses import replace

from motiondb.learn.learned_model import LearnedModel
from motiondb.learn.start.joining import publish
from motiondb.meaning.counting import Counted, publish_association, publish_word_map
from motiondb.records import SegmentTable


def with_counts(
    model: LearnedModel, run_id: int, table: SegmentTable, counted: Counted
) -> LearnedModel:
    """The learned model with other counts and everything that depends on them."""
    fit, counts = model.fitted_word_map, counted.counts
    present = set(table.capture_ids.tolist())
    model = replace(
        model,
        run_id=run_id,
        segments=table,
        counted=counted,
        places=None if model.places is None else model.places.only(present),
        judge=None if model.judge is None else model.judge.only(present),
    )
    if model.started is not None and fit is not None:
        joint = publish(counts, counted.reference, model.started, fit.ridge, fit.calibration)
        return replace(
            model,
            association=joint.association,
            transition_counts=joint.transitions,
            fitted_word_map=joint.word_map,
            lengths=joint.lengths,
        )
    word_map = None if fit is None else publish_word_map(counts, fit.ridge, fit.calibration)
    return replace(
        model,
        association=publish_association(counts, counted.reference),
        transition_counts=counts.transitions,
        fitted_word_map=word_map,
        lengths=dict(counts.shapes),
    )
