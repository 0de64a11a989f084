"""Left-to-right HMMs as models of hmmlearn, and back.

Notation: a symbol has K states with self-loops a_k, means m_k and variances v_k; from its last
state it is left with probability 1 - a_K. hmmlearn's models are never left: rows of a transition
matrix sum to 1. Two translations of the last state are offered.

- With an *exit state*: state K + 1 is absorbing, and no frame can be in it (its mean is
  ``EXIT_MEAN`` in every dimension). ``model.score(frames)`` is then exactly the log-likelihood of
  :func:`motiondb.symbols.hmm.score`, and the translation back is exact. Such a model is for
  scoring and decoding: hmmlearn's ``fit`` finds no frames for the exit state, and ``sample`` enters
  it.
- Without: the last state has the self-loop 1. The K states can be fitted and sampled by hmmlearn;
  scores are those of a symbol whose last self-loop is 1.

hmmlearn is imported where it is used, so that the command line starts fast.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from motiondb.errors import MotionDBError

if TYPE_CHECKING:
    from hmmlearn.hmm import GaussianHMM

FloatArray = NDArray[np.float64]

EXIT_MEAN = 1e6  # Mean of an exit state in every dimension; features lie within some tens of 0
_NEGLIGIBLE = 1e-9  # probabilities below this are rounding errors of a fit


def to_hmmlearn(
    self_loops: FloatArray, means: FloatArray, covars: FloatArray, *, exit_state: bool = True
) -> GaussianHMM:
    """Translate one symbol to a model of hmmlearn.

    Shapes: `self_loops` (K,); `means`, `covars` (K, dimensions).

    `exit_state`: Whether the model has a state for a symbol that was left (see the module).
    """
    from hmmlearn.hmm import GaussianHMM

    n_states, n_dims = means.shape
    n = n_states + exit_state
    model = GaussianHMM(n, "diag", init_params="")
    model.startprob_ = np.eye(n)[0]
    transitions = np.zeros((n, n))
    for k in range(n_states):
        last = k + 1 == n
        transitions[k, k] = 1.0 if last else self_loops[k]
        if not last:
            transitions[k, k + 1] = 1.0 - self_loops[k]
    if exit_state:
        transitions[-1, -1] = 1.0
        means = np.concatenate([means, np.full((1, n_dims), EXIT_MEAN)])
        covars = np.concatenate([covars, np.ones((1, n_dims))])
    model.transmat_ = transitions
    model.n_features = n_dims
    model.means_ = np.array(means, dtype=np.float64)
    model.covars_ = np.array(covars, dtype=np.float64)
    return model


def check_symbol(symbol: int, n_symbols: int) -> None:
    """Refuse the number of a symbol that does not exist."""
    if not 0 <= symbol < n_symbols:
        raise MotionDBError(
            f"symbol: expected a number from 0 to {n_symbols - 1}, found {symbol}. "
            "`motiondb symbols` lists the symbols."
        )


def from_hmmlearn(
    models: Sequence[GaussianHMM],
) -> tuple[NDArray[np.int64], FloatArray, FloatArray, FloatArray]:
    """Translate models of hmmlearn to symbols, padded as in ``records.MotionSymbols``.

    Shapes: result (symbols,).
    """
    if not models:
        raise MotionDBError("hmmlearn: expected at least 1 model, found 0. Give one a symbol.")
    n_dims = np.asarray(models[0].means_).shape[1]
    for number, model in enumerate(models):
        _check(number, model, n_dims)
    exits = [bool(np.all(np.asarray(model.means_)[-1] == EXIT_MEAN)) for model in models]
    n_states = np.array([model.n_components - e for model, e in zip(models, exits)], dtype=np.int64)
    shape = (len(models), int(n_states.max()), n_dims)
    loops, means, covars = np.zeros(shape[:2]), np.zeros(shape), np.ones(shape)
    for s, (model, n) in enumerate(zip(models, n_states)):
        loops[s, :n] = np.diagonal(model.transmat_)[:n]
        means[s, :n] = model.means_[:n]
        covars[s, :n] = model._covars_[:n]  # ``covars_`` are matrices, and need a fitted model
    return n_states, loops, means, covars


def _check(number: int, model: GaussianHMM, n_dims: int) -> None:
    where = f"hmmlearn model {number}"
    if model.covariance_type != "diag":
        raise MotionDBError(
            f"{where}: expected diagonal covariances, found {model.covariance_type!r}. "
            "Fit a GaussianHMM with covariance_type='diag'."
        )
    n_features = np.asarray(model.means_).shape[1]
    if n_features != n_dims:
        raise MotionDBError(
            f"{where}: expected {n_dims} dimensions as in model 0, found {n_features}. "
            "Fit all models in one feature space."
        )
    moves = np.asarray(model.transmat_)
    faults = {
        "numbers that are not finite": not all(
            np.isfinite(part).all()
            for part in (model.startprob_, moves, model.means_, model._covars_)
        ),
        "rows of transitions that do not sum to 1": (abs(moves.sum(axis=1) - 1.0) > 1e-6).any(),
        "variances that are not above 0": (np.asarray(model._covars_) <= 0.0).any(),
    }
    if found := [fault for fault, is_there in faults.items() if is_there]:
        raise MotionDBError(
            f"{where}: expected a model that was fitted, found {', '.join(found)}. hmmlearn's "
            "`fit` can end so where a state gets no frames: fit fewer states, or to more motion."
        )
    others = moves - np.triu(np.tril(moves, 1))
    if model.startprob_[0] < 1.0 - _NEGLIGIBLE or np.abs(others).max() > _NEGLIGIBLE:
        raise MotionDBError(
            f"{where}: expected a left-to-right model that starts in state 0 and moves on by one "
            "state, found other probabilities above 0. Fix them to 0 before the model is fitted."
        )
