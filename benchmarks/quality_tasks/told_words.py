"""How the map from motion to words was chosen, as the report says it."""

from __future__ import annotations

TOLD = (
    "The words of a motion come from a kernel ridge regression to captions, with a weight for "
    "every performer (`motiondb/meaning/description_map.py`). Its form was chosen among about "
    "150 settings within the five training parts, and its four constants among 36 by a rule "
    "that was fixed before the folds were measured: the best mean of F1 and reciprocal rank, "
    "half with each performer left out, half with tenths of the captures left out. *Words told "
    "by the caption map* and *by the word map* use two simpler maps in its place. One logistic "
    "map converts the scores of all words to probabilities. Nearly all words are near 0, so the "
    "probabilities are right on average but less accurate between 0 and 1."
)
