"""The symbols of a sentence to be generated: every action is decoded in turn, for its duration.

Captions speak of whole captures, so t(word | symbol) alone cannot tell the jump from the standing
before it. It is therefore replaced by a measure of how clearly a symbol's own segments show the
action and nothing else (``generate.clarity``), combined with t. The number of symbols of an action
follows from its duration in captures and the durations of the symbols that show it.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from motiondb.errors import QueryError
from motiondb.generate import clarity
from motiondb.language.translation import decoding
from motiondb.learn.learned import Learned
from motiondb.learn.recognition import Place, decode
from motiondb.records import MOTION_FPS, Association, FloatArray, IntArray

SHORTEST, LONGEST = 2.0, 5.0  # Bounds on the duration of an action, seconds
MOST_SYMBOLS = 4  # Largest number of symbols of one action
CLEAR_WEIGHT = 3.0  # w: weight of the symbol's own segments relative to t
UNSAID = 1e-4  # Bound on t(word | NULL), because the symbols must explain requested actions


def decode_actions(
    learned: Learned,
    actions: Sequence[Sequence[str]],
    avoided: Sequence[Collection[int]] = (),
) -> tuple[IntArray, list[int], list[decoding.Decoding]]:
    """Symbols of all actions, the action of every symbol, and the decoding of every action.

    Each decoding starts where the one before it ended, and may begin and end within a movement.

    `avoided`: Per action, the symbols that must not show it. An action that avoids some may follow
    any symbol.
    """
    symbols: list[int] = []
    positions: list[int] = []
    decodings = []
    seconds = typical_seconds(learned, actions)
    for number, action in enumerate(actions):
        clear = _clarity(learned, action)
        banned = list(avoided[number]) if avoided else []
        clear[banned] = 0.0
        association = _shown_association(learned, action, clear)
        length = _count_symbols(learned, clear, seconds[number])
        for n_symbols in dict.fromkeys((length, 1)):  # one symbol, where none ever followed
            decoded = decode(
                learned,
                _said_throughout(action, n_symbols),
                place=Place(
                    symbols[-1] if symbols and not banned else None, first=False, last=False
                ),
                length=n_symbols,
                association=association,
            )
            if decoded is not None:
                break
        if decoded is None:
            raise QueryError(
                f"generate: expected symbols for {' '.join(action)!r}, found none that "
                "occur together with these words. Add captures with these words and learn again."
            )
        symbols += decoded.symbols
        positions += [number] * len(decoded.symbols)
        decodings.append(decoded)
    return np.array(symbols), positions, decodings


def typical_seconds(learned: Learned, actions: Sequence[Sequence[str]]) -> list[float]:
    """Return durations of actions: medians over captures described with their words, within bounds.

    A capture of several actions gives each an equal share. If no own caption holds a word of the
    action, the duration is that of the start.
    """
    described = learned.described
    start = {} if learned.started is None else learned.started.seconds
    if not described and not start:
        raise QueryError(
            "generate: expected captures with words, found none. Write some down (motiondb words "
            "set) and learn again."
        )
    seconds = []
    for action in actions:
        said = [d for d in described if set(action) <= set(d.words)]
        said = said or [d for d in described if set(action) & set(d.words)]
        taught = [start[word] for word in action if word in start]
        if not said and not taught:
            said, taught = list(described), list(start.values())
        if said:
            typical = np.median([(d.end - d.start) / d.n_actions for d in said]) / MOTION_FPS
        else:
            typical = np.median(taught)
        seconds.append(float(np.clip(typical, SHORTEST, LONGEST)))
    return seconds


def word_numbers(learned: Learned, action: Sequence[str]) -> IntArray:
    """Numbers of an action's words, each once."""
    numbers = dict.fromkeys(learned.word_numbers[w] for w in action)
    return np.array(list(numbers), dtype=np.int64)


def _clarity(learned: Learned, action: Sequence[str]) -> FloatArray:
    """How clearly every symbol shows an action's words: array (symbols, different words)."""
    return clarity.symbol_clarity(
        learned.segment_probabilities,
        word_numbers(learned, action),
        learned.segments.symbols,
        learned.symbols.n_symbols,
    )


def _count_symbols(learned: Learned, clear: FloatArray, seconds: float) -> int:
    """Number of symbols that fill a duration, by the durations of those that show the action."""
    table = learned.segments
    count = np.maximum(np.bincount(table.symbols, minlength=len(clear)), 1)
    frames = np.bincount(table.symbols, table.ends - table.starts, minlength=len(clear)) / count
    weights = clear.prod(axis=1) ** 2
    if weights.sum() <= 0.0:
        weights = np.ones(len(clear))
    typical = float(np.average(frames, weights=weights)) / MOTION_FPS
    return int(np.clip(round(seconds / max(typical, 1e-6)), 1, MOST_SYMBOLS))


def _said_throughout(action: Sequence[str], n_symbols: int) -> list[str]:
    """Repeat the words of an action once per symbol, because every symbol is to show it.

    >>> _said_throughout(["turn", "left"], 3)
    ['turn', 'left', 'turn', 'left']
    """
    return list(action) * -(-n_symbols // len(action))


def _shown_association(learned: Learned, action: Sequence[str], clear: FloatArray) -> Association:
    """How well a symbol shows a word of an action, in place of t(word | symbol): (t + w c) c.

    Rows need not sum to 1: a symbol that shows nothing clearly has a small sum.
    """
    asked = word_numbers(learned, action)
    t = learned.smoothed_association.translation.copy()
    t[0] = np.minimum(t[0], UNSAID)
    t[1:, asked] = (t[1:, asked] + CLEAR_WEIGHT * clear) * clear
    return replace(learned.smoothed_association, translation=t)
