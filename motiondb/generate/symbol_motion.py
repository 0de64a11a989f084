"""Motion from the symbols of a sentence: trajectories of the HMMs, and frames drawn from them.

Methods: ``trajectory`` (the most probable smooth trajectory) and ``montecarlo`` (every frame drawn
by itself, as paper A prints it). Neither supports durations, counts or speeds; these are reported
as not used.

A generated motion is recognised like a new capture, from its movement alone. Where the
words of an action are not recognised in its part, the motion is made again without the symbol that
shows the action least (``generate.clarity``).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.body.features import FEATURE_STEP
from motiondb.generate import clarity
from motiondb.generate.action_symbols import decode_actions, word_numbers
from motiondb.generate.segment_material import Takes, gather_material
from motiondb.generate.sequence_motion import SequenceMotion, SymbolPlan, model_motion
from motiondb.language.translation import decoding
from motiondb.learn.learned import Learned
from motiondb.learn.recognition import recognise
from motiondb.records import FloatArray, IntArray, Motion

ATTEMPTS = 4  # Largest number of attempts until every action is recognised
RECOGNISED_FROM = 0.5  # Smallest mean probability of a recognised word: more probable than not
LEAST_PROBABILITY = 1e-6
"""Probabilities are kept away from 0 and 1 by this much, so that logarithms stay finite."""


@dataclass(frozen=True, eq=False)
class SymbolMotion:
    """A motion made from symbols."""

    made: SequenceMotion  # The motion; its lengths are those of the symbols
    plan: SymbolPlan  # Actions and decoded symbols
    decodings: tuple[decoding.Decoding, ...]
    recognised: IntArray  # (segments,): symbols recognised in the motion
    clarities: tuple[float, ...]  # log c per action
    # Number of every action that is not recognised -> the symbol that shows it least
    unclear: Mapping[int, int]
    captures: frozenset[int]  # Captures from whose segments the HMMs were estimated


def symbol_motion(
    learned: Learned,
    takes: Takes,
    actions: tuple[tuple[str, ...], ...],
) -> SymbolMotion:
    """Make a motion from the symbols of actions."""
    avoided: list[set[int]] = [set() for _ in actions]
    best: SymbolMotion | None = None
    for _ in range(ATTEMPTS):
        attempt = _attempt(learned, takes, (actions, avoided))
        if best is None or np.mean(attempt.clarities) > np.mean(best.clarities):
            best = attempt
        if not attempt.unclear:
            break
        for action, symbol in attempt.unclear.items():
            avoided[action].add(symbol)
    assert best is not None
    return best


def _attempt(
    learned: Learned,
    takes: Takes,
    wanted: tuple[tuple[tuple[str, ...], ...], Sequence[set[int]]],
) -> SymbolMotion:
    """One attempt; ``wanted``: the actions, and per action the symbols to avoid."""
    actions, avoided = wanted
    symbols, positions, decodings = decode_actions(learned, actions, avoided)
    plan = SymbolPlan(symbols, tuple(positions), actions)
    material = gather_material(learned, takes, symbols)
    made = model_motion(material, symbols)
    probabilities, recognised = frame_probabilities(learned, made.motion)
    clarities, unclear = _check_actions(learned, plan, made.lengths, probabilities)
    captures = frozenset(material.paths)
    return SymbolMotion(made, plan, tuple(decodings), recognised, clarities, unclear, captures)


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

    Shapes: `probabilities` (frames, words); `asked` (n,).
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
