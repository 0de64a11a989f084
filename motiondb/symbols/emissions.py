"""Gaussian log densities of many frames under all states of all symbols, as matrix products.

With diagonal covariances, for frame x, mean m and variance v of a state, all centred on c,

    log N(x; m, v) = sum_d [ x_d^2 (-1 / 2 v_d) + x_d (m_d / v_d) ]
                     - 1/2 sum_d [ m_d^2 / v_d + log(2 pi v_d) ]

is one row of [x^2, x] times one column of weights. The centre c is the mean of all means: the
squares would cancel badly far from the origin. The product is computed in single precision, unless
a state is so narrow, or so far from the centre, that its terms would still cancel.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from motiondb.errors import MotionDBError
from motiondb.records import Float32Array, FloatArray, MotionSymbols
from motiondb.symbols.hmm_kernels import NEVER, LogSymbols

BLOCK_VALUES = 1_500_000
"""Log densities held at once (6 MB), if one segment under a few symbols does not need more."""
SIMD_WIDTH = 8  # Symbols are taken in multiples of this: floats in a vector register of 256 bits
_SINGLE_PRECISION_LIMIT = 2e4  # sum_d m^2 / v up to which single precision errs by some 1e-3 nats


def log_symbols(symbols: MotionSymbols) -> LogSymbols:
    """Compute the logarithms and reciprocals of the parameters that the kernels use."""
    loops = np.asarray(symbols.self_loops, dtype=np.float64)
    with np.errstate(divide="ignore"):
        log_stay = np.maximum(np.log(loops), NEVER)
        log_leave = np.maximum(np.log1p(-loops), NEVER)
    covars = np.ascontiguousarray(symbols.covars, dtype=np.float64)
    return LogSymbols(
        n_states=np.ascontiguousarray(symbols.n_states, dtype=np.int64),
        log_stay=log_stay,
        log_leave=log_leave,
        means=np.ascontiguousarray(symbols.means, dtype=np.float64),
        precisions=1.0 / covars,
        constants=-0.5 * np.log(2 * np.pi * covars).sum(axis=2),
    )


def check_symbols(symbols: MotionSymbols) -> None:
    """Refuse symbols whose arrays do not fit together or that hold impossible values."""
    n_symbols, n_padded = np.shape(symbols.self_loops)
    expected = (n_symbols, n_padded, np.shape(symbols.means)[-1])
    for name in ("means", "covars"):
        shape = np.shape(getattr(symbols, name))
        if shape != expected:
            raise MotionDBError(
                f"symbols.{name}: expected shape {expected}, found {shape}. "
                "Give every state a mean and a variance in every dimension."
            )
    n_states = symbols.n_states
    if (
        n_symbols == 0
        or len(n_states) != n_symbols
        or n_states.min() < 1
        or n_states.max() > n_padded
    ):
        raise MotionDBError(
            f"symbols.n_states: expected {n_symbols} numbers from 1 to {n_padded}, found "
            f"{np.array2string(n_states, threshold=6)}. Give every symbol at least one state."
        )
    if not (np.all(np.isfinite(symbols.means)) and np.all(symbols.covars > 0)):
        raise MotionDBError(
            "symbols: expected finite means and variances above 0, found others. "
            "Fit the symbols with a positive variance floor."
        )
    if not (np.all(symbols.self_loops >= 0) and np.all(symbols.self_loops <= 1)):
        raise MotionDBError(
            "symbols.self_loops: expected probabilities from 0 to 1, found others. Fit them anew."
        )


def log_density_blocks(
    symbols: MotionSymbols, frames: FloatArray | Float32Array
) -> Iterator[tuple[int, Float32Array]]:
    """Log densities of the frames under every state, some symbols at a time.

    Shapes: `frames` (frames, dimensions).
    """
    n_symbols, n_padded, _ = symbols.means.shape
    width = BLOCK_VALUES // max(1, len(frames) * n_padded)
    width = max(width // SIMD_WIDTH, 1) * SIMD_WIDTH
    weights, constants, centre = _weights(symbols)
    centred = (frames - centre).astype(weights.dtype)
    terms = np.concatenate([np.square(centred), centred], axis=1)
    for first in range(0, n_symbols, width):
        some = slice(first, first + width)
        block = terms @ weights[:, :, some].reshape(len(weights), -1)
        block += constants[:, some].reshape(-1)
        shaped = block.reshape(len(frames), n_padded, -1)
        yield first, np.asarray(shaped, dtype=np.float32)


def _weights(symbols: MotionSymbols) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Weights (2 * dimensions, states, symbols), constants (states, symbols), centre."""
    real = np.arange(symbols.means.shape[1]) < symbols.n_states[:, None]
    centre = symbols.means[real].mean(axis=0)
    means = np.where(real[..., None], symbols.means - centre, 0.0).transpose(2, 1, 0)
    covars = symbols.covars.transpose(2, 1, 0)
    spread = (means**2 / covars).sum(axis=0)
    constants = -0.5 * (spread + np.log(2 * np.pi * covars).sum(axis=0))
    weights = np.concatenate([-0.5 / covars, means / covars])
    dtype = np.float32 if spread.max() < _SINGLE_PRECISION_LIMIT else np.float64
    return np.ascontiguousarray(weights, dtype=dtype), constants.astype(dtype), centre
