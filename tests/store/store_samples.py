"""Small records to fill a store with; random, but the same for the same seed."""

from __future__ import annotations

import numpy as np

from motiondb import store
from motiondb.files import packed_files
from motiondb.records import (
    Association,
    Caption,
    CaptureInfo,
    Motion,
    MotionSymbols,
    SegmentTable,
    StoredLearning,
    SymbolSpace,
)


def motion(seed: int = 0, n_frames: int = 12) -> Motion:
    rng = np.random.default_rng(seed)
    q = rng.normal(size=(n_frames, 21, 4)).astype(np.float32)
    q /= np.linalg.norm(q, axis=-1, keepdims=True)
    roots = rng.normal(size=(n_frames, 3)).astype(np.float32)
    return Motion(q, roots, 0.75, ("mended",))


def info(name: str, run_id: int, **changes: object) -> CaptureInfo:
    values: dict = {
        "capture_id": 0,
        "name": name,
        "sha256": "",
        "format": "bvh",
        "kind": "captured",
        "fps": 120.0,
        "n_frames": 48,
        "duration": 0.4,
        "motion_frames": 0,
        "leg_length": 0.0,
        "path": f"/captures/{name}.bvh",
        "run_id": run_id,
        "tags": {"performer": name.partition("/")[0], "licence": "CC0"},
        "notes": ("odd",),
    }
    return CaptureInfo(**{**values, **changes})


def add(
    database: store.Store,
    name: str,
    run_id: int | None = None,
    n_frames: int = 12,
    words: tuple[str, ...] = ("walk",),
    **changes: object,
) -> CaptureInfo:
    if run_id is None:
        run_id = store.start_run(database, "add", {"folder": "captures"})
    return store.save_capture(
        database,
        info(name, run_id, **changes),
        motion(len(name), n_frames),
        packed_files.pack_source(f"{name}.bvh", f"HIERARCHY {name}".encode(), "bvh"),
        [Caption(text) for text in words],
    )


def learning(
    infos: list[CaptureInfo],
    run_id: int,
    n_symbols: int = 5,
    n_words: int = 4,
    n_features: int = 3,
    seed: int = 0,
) -> StoredLearning:
    """Random arrays of the right shapes; every capture is cut into two segments."""
    rng = np.random.default_rng(seed)
    lengths = np.array([i.motion_frames for i in infos], dtype=np.int64)
    middles = lengths // 2
    starts = np.stack([0 * middles, middles], axis=1).ravel()
    ends = np.stack([middles, lengths], axis=1).ravel()
    ids = np.repeat(np.array([i.capture_id for i in infos], dtype=np.int64), 2)
    scores = rng.normal(size=(len(ids), n_symbols)).astype(np.float32)
    segments = SegmentTable(
        ids,
        starts,
        ends,
        scores.argmax(axis=1) if n_symbols else ids * 0,
        rng.normal(size=len(ids)),
        rng.normal(size=len(ids)),
        scores,
    )
    translation = rng.random((n_symbols + 1, n_words))
    translation[:, 1:][translation[:, 1:] < 0.4] = 0
    translation /= np.maximum(translation.sum(axis=1, keepdims=True), 1e-300)
    translation[-1] = 0
    alignment = {
        (length, m): rng.dirichlet(np.ones(length + 1), size=m)
        for length in (1, 2)
        for m in (1, 3)
        if n_words
    }
    association = Association(
        tuple(f"word{n}" for n in range(n_words)),
        rng.integers(1, 9, n_words),
        translation,
        alignment,
        rng.normal(size=3),
    )
    counts = rng.integers(0, 2, (n_symbols + 1, n_symbols + 1)).astype(float)
    parameters = {"mean": rng.normal(size=3), "scalar": np.array(2.5), "none": np.zeros((0, 4))}
    symbols, space = _symbols(rng, n_symbols, n_features), _space(rng, n_symbols)
    return StoredLearning(run_id, symbols, segments, space, association, counts, parameters)


def _symbols(rng: np.random.Generator, n: int, n_features: int) -> MotionSymbols:
    n_states = rng.integers(1, 4, n)
    n_states[:1] = 3
    real = np.arange(3) < n_states[:, None]
    return MotionSymbols(
        n_states,
        np.where(real, rng.random((n, 3)), 0.0),
        np.where(real[..., None], rng.normal(size=(n, 3, n_features)), 0.0),
        np.where(real[..., None], rng.random((n, 3, n_features)), 1.0),
    )


def _space(rng: np.random.Generator, n: int) -> SymbolSpace:
    distances = rng.random((n, n))
    return SymbolSpace(
        distances + distances.T,
        rng.random((n, n)),
        rng.normal(size=(n, 2)),
        rng.random(4),
        rng.integers(0, 2, n),
        np.array([0.25, 0.75]),
        rng.normal(size=(2, 2)),
        rng.normal(size=(2, 2, 2)),
    )


def assert_equal(actual: object, expected: object, where: str = "record") -> None:
    """Records, dicts and arrays equal to the last bit, dtype and shape included."""
    if isinstance(expected, np.ndarray):
        assert isinstance(actual, np.ndarray), where
        assert (actual.dtype, actual.shape) == (expected.dtype, expected.shape), where
        np.testing.assert_array_equal(actual, expected, err_msg=where)
    elif hasattr(expected, "__dataclass_fields__"):
        for name in expected.__dataclass_fields__:
            assert_equal(getattr(actual, name), getattr(expected, name), f"{where}.{name}")
    elif isinstance(expected, dict):
        assert isinstance(actual, dict)
        assert actual.keys() == expected.keys(), where
        for key, value in expected.items():
            assert_equal(actual[key], value, f"{where}[{key!r}]")
    else:
        assert actual == expected, where


def grammar(
    name: str,
    infos: list[CaptureInfo],
    run_id: int = 0,
    grammar_id: int = 0,
    objective: float = 2.5,
    probability: float = 0.25,
) -> store.StoredGrammar:
    """Two takes of three segments each: x y x and x z x; S -> x A x, A -> y | z."""
    ends = np.array([(n * i.motion_frames) // 3 for i in infos for n in (1, 2, 3)], dtype=np.int64)
    return store.StoredGrammar(
        name,
        sources=tuple(store.GrammarSource(i.name, i.sha256, i.motion_frames) for i in infos),
        terminals=("x", "y", "z"),
        symbols=np.array([-1, 4, 2]),
        takes=np.repeat(np.arange(2), 3),
        starts=np.where(np.arange(6) % 3 == 0, 0, np.roll(ends, 1)),
        ends=ends,
        labels=np.array([0, 1, 0, 0, 2, 0]),
        medoids=np.array([3, 1, 4]),
        objective=objective,
        start="S",
        rules=(("S", ("x", "A", "x"), 1.0), ("A", ("y",), probability), ("A", ("z",), 0.75)),
        sentences=np.array([[0, 3], [3, 6]]),
        parses=((0, 1), (0, 2)),
        bits={"motion": 512.25, "grammar": 17.5},
        run_id=run_id,
        grammar_id=grammar_id,
    )
