"""Damage to the bytes of a file, drawn from a random generator: the same on every machine."""

from __future__ import annotations

import numpy as np

NUMBERS = (
    "nan", "inf", "-inf", "1e999", "-1e999", "1e308", "-1e308", "1e-320", "1_0", "0x10", "²", "١٢",
    "1,5", "--1", "+-1", "1e", ".", "-", "", "9" * 400, "9" * 5000, "1" + "0" * 18, "1000000000",
    "-1", "0", "1e-300", "½", "1.2.3", "True", "None", "1j", "1e5", "\u00a0", "∞", "1e19",
    "2147483648",
)  # fmt: skip
"""Numbers that are none, or that break what is computed from them."""
BYTES = (
    b"\0", b"\r", b"\r\n", b"\n\n", b"\x1c", b"\xff", b"\xff\xfe", b"\xef\xbb\xbf", b"\x85",
    b"\x0b", b"{", b"}", b'"', b"'",
    b"\t", b"\xc2\xa0", b"\xe2\x80\xa8", b"\xed\xb3\xa9", b"#", b":", b"\\",
)  # fmt: skip


def damage(data: bytes, rng: np.random.Generator) -> bytes:
    """Damage a file in one to four places."""
    for _ in range(int(rng.integers(1, 5))):
        how = DAMAGES[int(rng.integers(len(DAMAGES)))]
        data = how(data, rng) or b" "
    return data


def _exchange_token(data: bytes, rng: np.random.Generator) -> bytes:
    """Put an odd number in place of a token."""
    tokens = data.split(b" ")
    place = int(rng.integers(len(tokens)))
    tokens[place] = str(rng.choice(NUMBERS)).encode()
    return b" ".join(tokens)


def _exchange_number(data: bytes, rng: np.random.Generator) -> bytes:
    """Put an odd number in place of a digit."""
    digits = [n for n, character in enumerate(data) if 48 <= character < 58]
    if not digits:
        return data
    place = digits[int(rng.integers(len(digits)))]
    return data[:place] + str(rng.choice(NUMBERS)).encode() + data[place + 1 :]


def _insert(data: bytes, rng: np.random.Generator) -> bytes:
    """Insert bytes that separate or end things in some format."""
    place = int(rng.integers(len(data) + 1))
    return data[:place] + BYTES[int(rng.integers(len(BYTES)))] + data[place:]


def _flip(data: bytes, rng: np.random.Generator) -> bytes:
    """Change one byte."""
    place = int(rng.integers(len(data)))
    return data[:place] + bytes([int(rng.integers(256))]) + data[place + 1 :]


def _cut(data: bytes, rng: np.random.Generator) -> bytes:
    """Cut out a part, or the end."""
    start, end = sorted(int(n) for n in rng.integers(0, len(data) + 1, 2))
    return data[:start] if rng.random() < 0.5 else data[:start] + data[end:]


def _repeat(data: bytes, rng: np.random.Generator) -> bytes:
    """Repeat a line a few or many times."""
    lines = data.split(b"\n")
    place = int(rng.integers(len(lines)))
    lines[place : place + 1] = [lines[place]] * int(10 ** rng.uniform(0, 2.5))
    return b"\n".join(lines)[:200_000]


def _swap_lines(data: bytes, rng: np.random.Generator) -> bytes:
    """Exchange two lines."""
    lines = data.split(b"\n")
    a, b = (int(n) for n in rng.integers(0, len(lines), 2))
    lines[a], lines[b] = lines[b], lines[a]
    return b"\n".join(lines)


def _encode(data: bytes, rng: np.random.Generator) -> bytes:
    """Write the text in another encoding."""
    text = data.decode("latin-1")
    return text.encode(str(rng.choice(["utf-16", "utf-16-le", "utf-8-sig", "utf-7"])))


DAMAGES = (
    _exchange_token, _exchange_number, _exchange_number, _insert, _flip, _cut, _repeat,
    _swap_lines, _encode,
)  # fmt: skip
