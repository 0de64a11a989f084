"""Words of a text with their values, by compiled code: one pass over the bytes.

A number of at most 19 digits is m 10^e with a whole m. Where m <= 2^53 and |e| <= 22, both m and
10^|e| are exact in float64, so that one product or quotient is the nearest float64 (Clinger, "How
to Read Floating Point Numbers Accurately", 1990). Python reads the others.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from motiondb.files.text import MAX_DIGITS
from motiondb.records import FloatArray, IntArray

_TENS: FloatArray = np.power(10.0, np.arange(23))  # All are exact
_NONE = -(10**6)  # No exponent
_DIGITS = 19  # That fit in 64 bits


def read_words(text: bytes) -> tuple[IntArray, IntArray, FloatArray]:
    """Begin, end and value of each word between white space: arrays (words,).

    The value is NaN where a word is no finite number in plain decimal notation.

    >>> read_words(b" 1.5  abc -2e1")
    (array([ 1,  6, 10]), array([ 4,  9, 14]), array([  1.5,   nan, -20. ]))
    """
    characters = np.frombuffer(text, np.uint8)
    starts, ends, values = _read(characters, _count(characters), _TENS)
    for n in np.flatnonzero(np.isinf(values)).tolist():
        value = float(text[starts[n] : ends[n]])
        values[n] = value if math.isfinite(value) else math.nan
    return starts, ends, values


def count_values(block: bytes) -> tuple[IntArray, IntArray]:
    """Count the values on each line that has any; result (rows,)."""
    counts = _count_lines(np.frombuffer(block, np.uint8), block.count(b"\n") + 1)
    lines = np.flatnonzero(counts)
    return lines, counts[lines]


@njit(cache=True, nogil=True)
def _count_lines(text: NDArray[np.uint8], n_lines: int) -> IntArray:
    """The number of values on each line; those without a character above a space are empty."""
    counts, line, before = np.zeros(n_lines, np.int64), 0, True
    for c in text:
        counts[line] += before and c > 32
        before = c <= 32
        line += c == 10
    return counts


@njit(cache=True, nogil=True)
def _is_space(c: int) -> bool:
    """Whether ``bytes.split`` separates words here."""
    return c == 32 or 9 <= c <= 13


@njit(cache=True, nogil=True)
def _count(text: NDArray[np.uint8]) -> int:
    """The number of words of a text (characters,)."""
    n, before = 0, True
    for c in text:
        is_space = _is_space(c)
        n += before and not is_space
        before = is_space
    return n


@njit(cache=True, nogil=True)
def _read(
    text: NDArray[np.uint8], n_words: int, tens: FloatArray
) -> tuple[IntArray, IntArray, FloatArray]:
    """Begin, end and value of the words; infinity for numbers that are left to Python."""
    starts, ends = np.empty(n_words, np.int64), np.empty(n_words, np.int64)
    values, i = np.empty(n_words), 0
    for n in range(n_words):
        while _is_space(text[i]):
            i += 1
        starts[n] = i
        values[n], i = _value(text, i, tens)
        while i < len(text) and not _is_space(text[i]):
            values[n] = np.nan
            i += 1
        ends[n] = i
        if i - starts[n] > MAX_DIGITS:
            values[n] = np.nan
    return starts, ends, values


@njit(cache=True, nogil=True)
def _value(text: NDArray[np.uint8], i: int, tens: FloatArray) -> tuple[float, int]:
    """The number that begins at a character, and the character behind it."""
    n, is_negative = len(text), text[i] == 45
    if is_negative or text[i] == 43:
        i += 1
    mantissa, exponent, n_kept, n_digits, point = np.uint64(0), 0, 0, 0, False
    while i < n:
        digit = int(text[i]) - 48
        if 0 <= digit <= 9:
            n_digits += 1
            n_kept += n_kept > 0 or digit > 0  # zeros that lead do not count
            mantissa = mantissa * np.uint64(10) + np.uint64(digit)
            exponent -= int(point)
        elif text[i] == 46 and not point:
            point = True
        else:
            break
        i += 1
    if n_digits == 0:
        return np.nan, i
    if i < n and (text[i] == 101 or text[i] == 69):
        shift, i = _exponent(text, i + 1)
        if shift == _NONE:
            return np.nan, i
        exponent += shift
    if n_kept > _DIGITS or mantissa > np.uint64(2**53) or abs(exponent) > 22:
        return np.inf, i
    value = float(mantissa) * tens[exponent] if exponent > 0 else float(mantissa) / tens[-exponent]
    return (-value if is_negative else value), i


@njit(cache=True, nogil=True)
def _exponent(text: NDArray[np.uint8], i: int) -> tuple[int, int]:
    """The exponent that begins at a character, ``_NONE`` if it has no digit, and what follows."""
    n, sign, exponent = len(text), 1, _NONE
    if i < n and (text[i] == 45 or text[i] == 43):
        sign = 44 - int(text[i])
        i += 1
    while i < n and 48 <= text[i] <= 57:
        exponent = min(max(exponent, 0) * 10 + int(text[i]) - 48, 10_000)
        i += 1
    return (exponent if exponent == _NONE else sign * exponent), i
