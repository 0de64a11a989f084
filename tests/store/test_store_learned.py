from __future__ import annotations

from dataclasses import replace
from types import ModuleType

import numpy as np
import pytest

from motiondb import store
from motiondb.errors import NotLearnedError
from motiondb.records import Caption, StoredLearning


def _learn(database: store.Store, samples: ModuleType, **sizes: int) -> StoredLearning:
    infos = store.load_captures(database)
    learning = samples.learning(infos, store.start_run(database, "learn"), **sizes)
    store.save_learning(database, learning)
    return learning


@pytest.fixture
def filled(database: store.Store, samples: ModuleType) -> store.Store:
    for name in ("a", "bb"):
        samples.add(database, name)
    return database


def test_learning_comes_back_to_the_last_bit(filled: store.Store, samples: ModuleType) -> None:
    learning = _learn(filled, samples)
    samples.assert_equal(store.load_learning(filled), learning)
    assert store.check_store(filled) == []
    assert store.load_runs(filled)[-1].finished is not None


def test_a_second_learning_replaces_the_first(filled: store.Store, samples: ModuleType) -> None:
    _learn(filled, samples, n_symbols=9, n_words=11, n_features=5)
    learning = _learn(filled, samples, n_symbols=3, seed=1)
    samples.assert_equal(store.load_learning(filled), learning)
    assert store.check_store(filled) == []


@pytest.mark.parametrize(
    "sizes", [{"n_words": 0}, {"n_symbols": 1}, {"n_symbols": 1, "n_words": 0, "n_features": 1}]
)
def test_small_learnings(filled: store.Store, samples: ModuleType, sizes: dict[str, int]) -> None:
    learning = _learn(filled, samples, **sizes)
    samples.assert_equal(store.load_learning(filled), learning)
    assert store.check_store(filled) == []


def test_extreme_numbers_come_back(filled: store.Store, samples: ModuleType) -> None:
    learning = samples.learning(store.load_captures(filled), store.start_run(filled, "learn"))
    odd = np.array([np.nan, np.inf, -np.inf, -0.0, 5e-324, 1.7e308, 0.1, 1 / 3, -1e300, 1e-300])
    learning.symbols.means[0].flat[: len(odd)] = odd[: learning.symbols.means[0].size]
    learning.segments.scores[0, :4] = odd[:4]
    learning.space.distances.flat[: len(odd)] = odd
    learning.segments.backgrounds[:2] = odd[:2]
    learning = replace(learning, parameters={"odd": odd, "table": odd.reshape(2, 5)})
    store.save_learning(filled, learning)
    loaded = store.load_learning(filled)
    samples.assert_equal(loaded, learning)
    assert np.signbit(loaded.parameters["odd"][3])


def test_long_parameters_are_cut_and_joined(filled: store.Store, samples: ModuleType) -> None:
    learning = samples.learning(store.load_captures(filled), store.start_run(filled, "learn"))
    long = np.random.default_rng(0).normal(size=(2, 35_000))
    given = {"long": long, "x.y": np.ones(1), "x.z": '["\u00e9"]', "xy": "{}"}
    store.save_learning(filled, replace(learning, parameters=given))
    samples.assert_equal(store.load_parameters(filled, "long"), {"long": long})
    samples.assert_equal(store.load_parameters(filled), given)
    assert store.load_parameters(filled, "x").keys() == {"x.y", "x.z"}
    assert store.load_parameters(filled, "none") == {}
    pieces = filled.connection.execute("SELECT count(*) FROM parameter WHERE name = 'long'")
    assert pieces.fetchall() == [(2,)]


def test_parts_can_be_left_out(filled: store.Store, samples: ModuleType) -> None:
    learning = _learn(filled, samples)
    assert store.load_segments(filled, scores=False).scores.shape == (4, 0)
    size = store.load_learning_size(filled)
    assert (size.n_symbols, size.n_words, size.run_id) == (5, 4, learning.run_id)


def test_before_learning(filled: store.Store) -> None:
    assert not store.is_learned(filled)
    for load in (store.load_learning, store.load_symbols, store.load_space, store.load_segments):
        with pytest.raises(NotLearnedError) as error:
            load(filled)
        assert str(error.value) == (
            f"{filled.path}: expected motion symbols, found none. "
            f"Run motiondb learn --db {filled.path} first."
        )


def test_a_change_of_the_catalogue_makes_learning_stale(
    filled: store.Store, samples: ModuleType
) -> None:
    _learn(filled, samples)
    assert store.learning_is_current(filled)
    store.save_tags(filled, 1, {"performer": "3"})
    assert store.learning_is_current(filled)
    store.save_captions(filled, 1, [Caption("run")])
    assert not store.learning_is_current(filled)
    _learn(filled, samples)
    samples.add(filled, "ccc")
    assert not store.learning_is_current(filled)


def test_failing_to_save_keeps_the_earlier_learning(
    filled: store.Store, samples: ModuleType
) -> None:
    learning = _learn(filled, samples)
    bad = replace(learning, parameters={"text": np.array(["no number"])})
    with pytest.raises(ValueError, match="could not convert"):
        store.save_learning(filled, bad)
    samples.assert_equal(store.load_learning(filled), learning)
