"""Motion from a sentence: words to symbols, symbols to a trajectory, real segments along it.

Methods: ``stitched`` (real segments that follow the trajectory, seams blended, feet held),
``trajectory`` (the most probable smooth trajectory itself) and ``montecarlo`` (every frame drawn by
itself, as paper A prints it).

A motion that was made is recognised as a new capture would be, from its movement alone. Where the
words of an action are not recognised in its part, the motion is made again without the symbol that
shows the action least (``generate.clarity``).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass

import numpy as np

from motiondb.errors import QueryError
from motiondb.generate import clarity
from motiondb.learning.learned import Learned
from motiondb.learning.making.action_symbols import decode_actions, word_numbers
from motiondb.learning.making.segment_material import Takes, gather_material
from motiondb.learning.making.stitched_motion import (
    SequenceMotion,
    SymbolPlan,
    model_motion,
    stitched_motion,
)
from motiondb.learning.recognition import recognise, understand
from motiondb.pose.features import FEATURE_STEP
from motiondb.records import FloatArray, IntArray, Motion
from motiondb.words.question.known import KnownQuestion
from motiondb.words.question.plain import plain_actions
from motiondb.words.question.tree import NotUsed
from motiondb.words.translation import decoding

METHODS = ("stitched", "trajectory", "montecarlo")
ATTEMPTS = 4
"""Largest number of attempts until every action is recognised. Chosen by hand; not tuned."""
RECOGNISED_FROM = 0.5
"""Mean probability from which on a word counts as recognised: more probable than not."""
LEAST_PROBABILITY = 1e-6
"""Probabilities are kept away from 0 and 1 by this much, so that logarithms stay finite."""


@dataclass(frozen=True, eq=False)
class MadeMotion:
    """A motion that was made from a sentence.

    Attributes
    ----------
    made : SequenceMotion
        The motion with the origin of its frames.
    plan : SymbolPlan
        Actions and decoded symbols.
    decodings : tuple of Decoding
        Per action.
    recognised : array (segments,)
        Symbols recognised in the motion.
    question : KnownQuestion
        The sentence as it was understood.
    spans : tuple of (int, int)
        First frame and last frame + 1 of every action.
    not_used : tuple of NotUsed
        What of the sentence the motion takes no account of.
    """

    made: SequenceMotion
    plan: SymbolPlan
    decodings: tuple[decoding.Decoding, ...]
    recognised: IntArray
    question: KnownQuestion
    spans: tuple[tuple[int, int], ...]
    not_used: tuple[NotUsed, ...] = ()


@dataclass(frozen=True, eq=False)
class _Attempt:
    """One attempt.

    ``clarities`` has log c per action, ``unclear`` the symbol that shows an action least, for every
    action that is not recognised.
    """

    made: SequenceMotion
    plan: SymbolPlan
    decodings: tuple[decoding.Decoding, ...]
    recognised: IntArray
    clarities: tuple[float, ...]
    unclear: Mapping[int, int]


def make_motion(
    learned: Learned,
    takes: Takes,
    text: str,
    rng: np.random.Generator,
    method: str = "stitched",
) -> MadeMotion:
    """Make a motion that shows what a sentence says.

    Parameters
    ----------
    learned : Learned
        What was learned.
    takes : Takes
        Motions of the captures.
    text : str
        The sentence.
    rng : numpy.random.Generator
        Every attempt begins from its state; it is not advanced.
    method : str
        One of ``METHODS``.

    Raises
    ------
    QueryError
        For an unknown method, no known word, or words that no symbols can show.
    NotLearnedError
        When no words were learned.
    """
    if method not in METHODS:
        raise QueryError(f"method: expected one of {', '.join(METHODS)}, found {method!r}.")
    question = understand(learned, text)
    said, left_out = plain_actions(question.tree)
    actions = tuple(action for action in said if action)
    if not actions:
        raise QueryError(
            f"generate: expected an action to show, found only what not to show in {text!r}. "
            "Say what the motion is to show."
        )
    avoided: list[set[int]] = [set() for _ in actions]
    best: _Attempt | None = None
    for _ in range(ATTEMPTS):
        attempt = _attempt(learned, takes, (actions, avoided), deepcopy(rng), method)
        if best is None or np.mean(attempt.clarities) > np.mean(best.clarities):
            best = attempt
        if not attempt.unclear:
            break
        for action, symbol in attempt.unclear.items():
            avoided[action].add(symbol)
    assert best is not None
    spans = _spans(best.plan.positions, best.made.lengths)
    return MadeMotion(
        best.made, best.plan, best.decodings, best.recognised, question, spans,
        (*question.not_used, *left_out),
    )  # fmt: skip


def _attempt(
    learned: Learned,
    takes: Takes,
    wanted: tuple[tuple[tuple[str, ...], ...], Sequence[set[int]]],
    rng: np.random.Generator,
    method: str,
) -> _Attempt:
    """One attempt; ``wanted``: the actions, and per action the symbols to avoid."""
    actions, avoided = wanted
    symbols, positions, decodings = decode_actions(learned, actions, avoided)
    plan = SymbolPlan(symbols, tuple(positions), actions)
    material = gather_material(learned, takes, symbols)
    if method == "stitched":
        made = stitched_motion(learned, material, plan, rng)
    else:
        made = model_motion(material, symbols, rng, method)
    probabilities, recognised = frame_probabilities(learned, made.motion)
    clarities, unclear = _check_actions(learned, plan, made.lengths, probabilities)
    return _Attempt(made, plan, tuple(decodings), recognised, clarities, unclear)


def frame_probabilities(learned: Learned, motion: Motion) -> tuple[FloatArray, IntArray]:
    """Probability of every word at every frame: array (frames, words); and the symbols recognised.

    Frames run at 30 a second.
    """
    seen = recognise(learned, motion)
    probabilities = learned.word_map.probabilities(seen.window_vectors())
    frames = np.repeat(
        np.repeat(probabilities, seen.ends - seen.starts, axis=0), FEATURE_STEP, axis=0
    )
    which = np.minimum(np.arange(motion.n_frames), len(frames) - 1)
    return np.clip(frames[which], LEAST_PROBABILITY, 1.0 - LEAST_PROBABILITY), seen.symbols


def log_clarity(probabilities: FloatArray, asked: IntArray) -> float:
    """log c of a part of a motion, mean over its frames and the words asked for.

    Parameters
    ----------
    probabilities : array (frames, words)
        Strictly between 0 and 1.
    asked : array (n,)
        Numbers of the words asked for.
    """
    said = np.log(probabilities[:, asked]).mean(axis=1)
    unasked = clarity.log_unasked(probabilities, asked)
    return float(np.mean(said + clarity.UNASKED_SHARE * unasked))


def shows_all(probabilities: FloatArray, asked: Sequence[int] | IntArray, least: float) -> bool:
    """Whether every word asked for has at least this mean probability over a part of a motion."""
    return bool((probabilities[:, asked].mean(axis=0) >= least).all())


def _check_actions(
    learned: Learned, plan: SymbolPlan, lengths: Sequence[int], probabilities: FloatArray
) -> tuple[tuple[float, ...], dict[int, int]]:
    """log c of every action, and the least clear symbol of those that are not recognised."""
    bounds = np.minimum(np.cumsum([0, *lengths]), len(probabilities) - 1)
    clarities, unclear = [], {}
    for number, action in enumerate(plan.actions):
        asked = word_numbers(learned, action)
        places = [k for k, position in enumerate(plan.positions) if position == number]
        part = probabilities[bounds[places[0]] : bounds[places[-1] + 1] + 1]
        clarities.append(log_clarity(part, asked))
        if not shows_all(part, asked, RECOGNISED_FROM):
            parts = [probabilities[bounds[k] : bounds[k + 1] + 1] for k in places]
            least = int(np.argmin([log_clarity(one, asked) for one in parts]))
            unclear[number] = int(plan.symbols[places[least]])
    return tuple(clarities), unclear


def _spans(positions: Sequence[int], lengths: Sequence[int]) -> tuple[tuple[int, int], ...]:
    """Frames of every action, from the frames of every symbol.

    >>> _spans([0, 0, 1], [10, 5, 20])
    ((0, 15), (15, 35))
    """
    totals = np.bincount(positions, weights=lengths).astype(int)
    ends = np.cumsum(totals)
    return tuple((int(end - total), int(end)) for end, total in zip(ends, totals))
