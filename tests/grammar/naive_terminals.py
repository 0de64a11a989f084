"""The slow and obvious twins of the terminals' kernels."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from motiondb.records import Motion


def segment_distance(values: np.ndarray, a: int, b: int, a2: int, b2: int) -> float:
    """Equation 1 as it is printed, frames counted from 0."""
    long, short = (range(a, b), range(a2, b2))
    if len(long) < len(short):
        long, short = short, long
    pairs = [(t, short[m * len(short) // len(long)]) for m, t in enumerate(long)]
    return float(np.mean([np.linalg.norm(values[t] - values[u]) for t, u in pairs]))


def best_medoids(distances: np.ndarray, k: int, weights: np.ndarray, prices: np.ndarray) -> float:
    """The least E over all choices of medoids."""
    return min(
        float((weights * distances[:, chosen].min(axis=1)).sum() + prices[list(chosen)].sum())
        for chosen in combinations(range(len(distances)), k)
    )


def medoids_by_turns(distances: np.ndarray, k: int) -> np.ndarray:
    """Alternating k-medoids from the first k things, as the paper describes it."""
    medoids = np.arange(k)
    while True:
        labels = np.argmin(distances[:, medoids], axis=1)
        labels[medoids] = np.arange(k)
        groups = [np.flatnonzero(labels == g) for g in range(k)]
        after = np.array([g[np.argmin(distances[np.ix_(g, g)].sum(axis=0))] for g in groups])
        if (after == medoids).all():
            return medoids
        medoids = after


def swinging_motion(n_frames: int, seed: int = 0, speed: float = 1.0) -> Motion:
    """Arms and legs swing, the body walks a curve: a motion made of sines."""
    rng = np.random.default_rng(seed)
    t = speed * np.arange(n_frames) / 30.0
    angles = np.zeros((n_frames, 21))
    for joint in (1, 2, 5, 6, 14, 15, 18, 19):
        angles[:, joint] = 0.6 * np.sin(2 * np.pi * t * rng.uniform(0.3, 0.8) + rng.uniform(0, 6))
    rotations = np.zeros((n_frames, 21, 4))
    rotations[..., 0], rotations[..., 1] = np.cos(angles / 2), np.sin(angles / 2)
    root = np.stack([np.sin(t), np.full(n_frames, 0.93), t], axis=1)
    return Motion(rotations.astype(np.float32), root.astype(np.float32))


def actions_motion(order: str, seed: int = 0) -> tuple[Motion, list[int]]:
    """Actions that begin and end at rest, a letter each: which joint swings how; and the cuts."""
    rng = np.random.default_rng(seed)
    kinds = {"a": (14, 1.2, 30), "b": (18, 1.2, 24), "c": (1, 0.9, 36), "d": (9, 0.7, 28)}
    pieces, cuts = [], [0]
    for letter in order:
        joint, height, length = kinds[letter]
        swing = np.zeros((length, 21))
        swing[:, joint] = height * (1 - np.cos(2 * np.pi * np.arange(length) / length)) / 2
        pieces.append(swing * rng.uniform(0.95, 1.05))
        cuts.append(cuts[-1] + length)
    angles = np.concatenate(pieces)
    rotations = np.zeros((*angles.shape, 4))
    rotations[..., 0], rotations[..., 2] = np.cos(angles / 2), 0.0
    rotations[..., 1] = np.sin(angles / 2)
    root = np.tile([0.0, 0.93, 0.0], (len(angles), 1))
    return Motion(rotations.astype(np.float32), root.astype(np.float32)), cuts
