"""One ledger of bits for terminals, sentences and rules: how many terminals there should be.

More terminals show the motion more exactly, and make the string harder to describe. Both are
counted in bits: *motion*, to send every frame once its terminal is known; *string*, the sentences
given the rules; *grammar*, the rules. The number of terminals of fewest bits is chosen.

The motion is sent with a stated precision. Poses x_t lie on principal axes, so each axis is coded
for itself: at a mean square error delta^2, a Gaussian axis of variance v takes

    max(0, 1/2 log2(v / delta^2))

bits a sample. The frames of a medoid are sent as poses, v being the variance of poses; all other
frames as what is left when the medoid, uniformly warped, is taken from them, v being the mean
square of that. Motion is smooth, and a frame nearly told by the one before: with correlation rho
from frame to frame there are (1 - rho) / (1 + rho) independent samples a frame. Each segment also
costs log2 of the longest length, for its own.

Sources: J. Rissanen, "Modeling by shortest data description", Automatica 14 (1978), for one ledger
of all parts; T. M. Cover and J. A. Thomas, "Elements of Information Theory" (2006), theorem
10.3.3, for the bits of Gaussian axes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.grammar.cfg import GrammarError
from motiondb.grammar.partition import Sentences, find_sentences
from motiondb.grammar.poses import make_poses
from motiondb.grammar.terminals import Terminals, TerminalSettings, find_terminals, strings_of
from motiondb.records import Float32Array, FloatArray, IntArray, Motion

PRECISION = 0.05
"""delta as a share of the root mean square distance of poses from the mean pose."""

CANDIDATES = (6, 8, 12, 16, 20, 30, 40, 60)
"""Numbers of terminals that are tried."""

Progress = Callable[[int, int, str], None]


@dataclass(frozen=True)
class Ledger:
    """Bits of the motion given the terminals, the sentences given the rules, and the rules."""

    motion: float
    string: float
    grammar: float

    @property
    def total(self) -> float:
        """All bits."""
        return self.motion + self.string + self.grammar


@dataclass(frozen=True, eq=False)
class Choice:
    """What was learned for the number of terminals of fewest bits; the ledger of each number."""

    terminals: Terminals
    sentences: Sentences
    ledgers: dict[int, Ledger]


def motion_bits(
    values: Float32Array | FloatArray,
    starts: IntArray,
    ends: IntArray,
    labels: IntArray,
    medoids: IntArray,
    precision: float = PRECISION,
) -> float:
    """Bits of all frames given the string.

    Parameters
    ----------
    values : array (frames of all takes, axes), poses on axes of their own.
    starts, ends : array (segments,), rows of ``values``, half-open.
    labels : array (segments,), terminals. medoids : array (K,), segments.
    precision : delta, as a share of the spread of poses.

    Raises
    ------
    GrammarError where the precision is not positive.
    """
    if not precision > 0.0:
        raise GrammarError(
            f"precision: expected a share above 0, found {precision}. The default is {PRECISION}."
        )
    poses = np.asarray(values, dtype=np.float64)
    variances = poses.var(axis=0)
    least = precision**2 * variances.sum()
    if least == 0.0:
        return 0.0
    residuals = _residuals(poses, starts, ends, labels, medoids)
    lengths = ends - starts
    shown = int(lengths[medoids].sum())
    rest = int(lengths.sum()) - shown
    bits = shown * _bits_a_sample(variances, least)
    if rest:
        bits += rest * _bits_a_sample((residuals**2).sum(axis=0) / rest, least)
    return bits * samples_a_frame(poses) + len(lengths) * float(np.log2(max(2, lengths.max())))


def samples_a_frame(poses: FloatArray) -> float:
    """(1 - rho) / (1 + rho), rho the correlation of poses one frame apart.

    >>> samples_a_frame(np.array([[0.0], [1.0]] * 8))
    1.0
    """
    spread = float(poses.var(axis=0).sum())
    if spread == 0.0 or len(poses) < 2:
        return 0.0
    steps = float((np.diff(poses, axis=0) ** 2).sum(axis=1).mean())
    rho = max(0.0, 1.0 - steps / (2.0 * spread))
    return (1.0 - rho) / (1.0 + rho)


def _bits_a_sample(variances: FloatArray, least: float) -> float:
    return float(0.5 * np.log2(np.maximum(variances / least, 1.0)).sum())


def _residuals(
    poses: FloatArray, starts: IntArray, ends: IntArray, labels: IntArray, medoids: IntArray
) -> FloatArray:
    """What the warped medoids leave of the frames: 0 in the medoids themselves."""
    found = np.zeros_like(poses)
    for start, end, label in zip(starts, ends, labels, strict=True):
        first, last = starts[medoids[label]], ends[medoids[label]]
        matched = first + np.arange(end - start) * (last - first) // (end - start)
        found[start:end] = poses[start:end] - poses[matched]
    return found


def make_ledger(
    takes: Sequence[Motion],
    terminals: Terminals,
    sentences: Sentences,
    precision: float = PRECISION,
) -> Ledger:
    """The ledger of terminals of takes and of what was learned from their strings."""
    poses = make_poses(takes)
    offsets = poses.bounds[terminals.takes]
    motion = motion_bits(
        poses.values,
        terminals.starts + offsets,
        terminals.ends + offsets,
        terminals.labels,
        terminals.medoids,
        precision,
    )
    return Ledger(motion, sentences.bits.sentences, sentences.bits.grammar)


def choose_terminals(
    takes: Sequence[Motion],
    rng: np.random.Generator,
    *,
    candidates: Sequence[int] = CANDIDATES,
    settings: TerminalSettings | None = None,
    learn: Callable[[Terminals, np.random.Generator], Sentences] | None = None,
    progress: Progress | None = None,
) -> Choice:
    """Terminals, sentences and rules for the number of terminals of fewest bits.

    Candidates for which the takes are too short are left out. ``learn`` makes the sentences of
    terminals; :func:`partition.find_sentences` unless given.

    Raises
    ------
    GrammarError where no candidate is given, or the takes are too short for each.
    """
    learn = learn or _learn
    ledgers: dict[int, Ledger] = {}
    best: tuple[Terminals, Sentences] | None = None
    fault: GrammarError | None = None
    for place, number in enumerate(sorted(set(candidates))):
        if progress is not None:
            progress(place, len(set(candidates)), f"try {number} terminals")
        try:
            terminals = find_terminals(takes, number, rng, settings=settings)
        except GrammarError as error:
            fault = fault or error
            continue
        sentences = learn(terminals, rng)
        ledgers[number] = make_ledger(takes, terminals, sentences)
        if ledgers[number].total == min(ledger.total for ledger in ledgers.values()):
            best = terminals, sentences
    if best is None:
        raise fault or GrammarError(
            "terminals: expected numbers to choose from, found none. Give some, such as 12 20 40."
        )
    return Choice(*best, ledgers)


def _learn(terminals: Terminals, rng: np.random.Generator) -> Sentences:
    return find_sentences(strings_of(terminals), rng)
