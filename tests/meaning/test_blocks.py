"""What is summed some rows at a time does not depend on how many; short ways against long ones."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy import ndimage

from motiondb.meaning import edge_map, regression, score_vectors
from motiondb.records import FloatArray

N, N_COLUMNS, N_WORDS = 90, 6, 2


def regressions() -> dict[str, FloatArray]:
    """Every result that is summed in blocks, of the same rows; one cue is constant, one tiny."""
    rng = np.random.default_rng(3)
    vectors = rng.normal(size=(N, N_COLUMNS)) * [1.0, 1e-6, 1.0, 1.0, 1.0, 0.0] + [0, 0, 0, 0, 5, 7]
    target, weights = rng.uniform(size=(N, N_WORDS)), rng.uniform(0.1, 1.0, N)
    fitted = regression.prepare(vectors, weights, 0.03).fit(target)
    bounds = [0, 1, 4, 20, 24, 25, 60, N]
    parts = [slice(a, b) for a, b in pairwise(bounds)]
    alone = [fitted.of_others(part) for part in parts]
    left_out = fitted.left_out(parts)
    np.testing.assert_allclose(left_out, np.concatenate(alone), atol=1e-9)
    slopes, offsets = regression.fit_ridge(vectors, target, 0.03, weights)
    yes = (vectors[:, 0] + rng.normal(size=N) > 0.0).astype(float)
    space = score_vectors.fit_score_space(
        vectors.astype(np.float32), rng.integers(5, 50, N), target.astype(np.float32)
    )
    return {
        "rows left out": left_out,
        "without few rows": fitted.without(np.arange(2, 6)),
        "without many rows": fitted.without(np.arange(3, 70)),
        "slopes": slopes,
        "offsets": offsets,
        "logistic": regression.fit_logistic(vectors[:, :3], yes, np.zeros(3), np.eye(3), None, 1),
        "mean": space.mean,
        "spread": space.spread,
    }


@pytest.mark.parametrize("size", [1, 7, 24])
def test_sums_do_not_depend_on_the_rows_that_are_looked_at_together(
    size: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = regressions()
    for name in ("AT_ONCE", "ANSWERS_AT_ONCE", "PARTS_AT_ONCE"):
        monkeypatch.setattr(regression, name, size)
    monkeypatch.setattr(score_vectors, "FITTED_AT_ONCE", size)
    for name, values in regressions().items():
        np.testing.assert_allclose(values, whole[name], atol=1e-8, err_msg=name)


def test_all_rows_left_out_leave_nothing() -> None:
    """As of a single performer: what is predicted is the mean."""
    rng = np.random.default_rng(4)
    fitted = regression.prepare(rng.normal(size=(N, N_COLUMNS)), np.ones(N), 0.03).fit(
        rng.uniform(size=(N, N_WORDS))
    )
    np.testing.assert_allclose(fitted.without(np.arange(N)), 0.0, atol=1e-9)
    np.testing.assert_allclose(fitted.left_out([slice(0, N)]), 0.0, atol=1e-9)


@pytest.mark.parametrize("n", [1, 4, 60])
def test_medians_are_those_of_scipy(n: int) -> None:
    values = np.random.default_rng(n).normal(size=n)
    for size in (1, 3, 31):
        expected = ndimage.median_filter(values, size, mode="nearest")
        np.testing.assert_array_equal(score_vectors.running_median(values, size), expected)


@pytest.mark.parametrize("n", [1, 2, 51, 100])
def test_the_high_percentile_is_that_of_numpy(n: int) -> None:
    values = np.random.default_rng(n).normal(size=n)
    assert edge_map._high(values) == pytest.approx(np.quantile(values, 0.98), abs=1e-12)
