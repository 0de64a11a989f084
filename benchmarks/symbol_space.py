"""Multidimensional scaling here against scikit-learn's SMACOF, on the same distances, in one run.

Both minimise the same stress by the same majorisation; they differ in starts and in when they end.
scikit-learn is run three ways: from our start (the principal coordinates), from its own classical
start, and from four random ones, of which it keeps the best; each with its default number of
iterations and tolerance, and with ours. Stress is normalised as in
``motiondb.symbols.space``. "Same twice" says whether a second run, with another seed,
gives the same distances between points.

    python benchmarks/symbol_space.py --db FILE       (a database that has learned)
"""

from __future__ import annotations

import argparse
import inspect
import time
import warnings
from collections.abc import Callable

import numpy as np

import motiondb
from motiondb.records import FloatArray
from motiondb.symbols.space import classical_scaling, scale, smacof

Scaling = Callable[[FloatArray, int, int], FloatArray]
"""Distances, number of dimensions, seed -> coordinates."""


def stress_of(points: FloatArray, distances: FloatArray) -> float:
    """Normalised stress of coordinates (points, dimensions)."""
    between = np.linalg.norm(points[:, None] - points[None], axis=2)
    return float(np.sqrt(np.sum((between - distances) ** 2) / np.sum(distances**2)))


def ours(distances: FloatArray, n_dimensions: int, _seed: int) -> FloatArray:
    """The coordinates that ``learn`` stores: all numbers of dimensions up to the one asked for."""
    return scale(distances, n_dimensions=n_dimensions)[0]


def ours_once(distances: FloatArray, n_dimensions: int, _seed: int) -> FloatArray:
    """One run of our SMACOF in one number of dimensions."""
    return smacof(distances, classical_scaling(distances, n_dimensions))[0]


def library(start: str, *, long: bool) -> Scaling:
    """scikit-learn's SMACOF; ``long``: with our number of iterations and tolerance."""
    from sklearn import manifold

    limits = {"max_iter": 500, "eps": 1e-9} if long else {}

    def run(distances: FloatArray, n_dimensions: int, seed: int) -> FloatArray:
        if start == "ours":
            first = classical_scaling(distances, n_dimensions)
            return np.asarray(
                manifold.smacof(
                    distances, n_components=n_dimensions, init=first, n_init=1,
                    normalized_stress=False, **limits,
                )[0]
            )  # fmt: skip
        named = {"metric_mds": True, "metric": "precomputed"}  # from scikit-learn 1.8 on
        if "metric_mds" not in inspect.signature(manifold.MDS).parameters:
            named = {"metric": True, "dissimilarity": "precomputed"}
        model = manifold.MDS(
            n_dimensions, init="classical_mds" if start == "classical" else "random",
            n_init=1 if start == "classical" else 4, random_state=seed, **named, **limits,
        )  # fmt: skip
        return np.asarray(model.fit_transform(distances))

    return run


def measure(name: str, run: Scaling, distances: FloatArray, n_dimensions: int) -> str:
    """A row of the table: stress, seconds (best of three), whether two seeds agree."""
    took, results = [], []
    for seed in (0, 1, 2):
        began = time.perf_counter()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # about iterations that ran out, and coming defaults
            results.append(run(distances, n_dimensions, seed))
        took.append(time.perf_counter() - began)
    between = [np.linalg.norm(p[:, None] - p[None], axis=2) for p in results]
    same = all(np.allclose(b, between[0], atol=1e-9 * distances.max()) for b in between)
    worst = max(stress_of(points, distances) for points in results)
    best = min(stress_of(points, distances) for points in results)
    stress = f"{best:.6f}" if best == worst else f"{best:.6f} to {worst:.6f}"
    return f"| {n_dimensions} | {name} | {stress} | {min(took):.3f} | {'yes' if same else 'no'} |"


def main() -> None:
    """Print the table for the symbols of a database."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--db", required=True, help="A database that has learned.")
    with motiondb.open(parser.parse_args().db, read_only=True) as db:
        distances = db.learned.space.distances
    print(f"{len(distances)} symbols\n")
    print("| dimensions | method | stress | s | same twice |\n| --- | --- | --- | --- | --- |")
    methods: dict[str, Scaling] = {
        "motiondb, as learned": ours,
        "motiondb, one run": ours_once,
        "scikit-learn from our start": library("ours", long=False),
        "scikit-learn from our start, longer": library("ours", long=True),
        "scikit-learn, classical start": library("classical", long=False),
        "scikit-learn, 4 random starts": library("random", long=False),
        "scikit-learn, 4 random starts, longer": library("random", long=True),
    }
    for n_dimensions in (1, 2, 3, 4, 6, 8):
        for name, run in methods.items():
            print(measure(name, run, distances, n_dimensions))


if __name__ == "__main__":
    main()
