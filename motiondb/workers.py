"""Who computes independent pieces of work: threads of this process, or processes elsewhere.

A piece's result depends on the piece, and on what all pieces share, alone; results come in the
order of the pieces. So answers do not depend on who computes them, nor on how many there are.
:mod:`motiondb.database.cluster` has workers on other machines.
"""

from __future__ import annotations

import math
import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import chain, islice, pairwise
from typing import TYPE_CHECKING, Protocol, TypeVar

if TYPE_CHECKING:
    from concurrent.futures import Future

Piece = TypeVar("Piece")
Result = TypeVar("Result")

N_THREADS = min(8, os.cpu_count() or 1)
"""Threads at most; more than 8 were never measured. The results do not depend on it."""
PIECES_EACH = 4  # Pieces for each worker: a slow one then delays the others little
_LEAST = 0.008  # Seconds of work for which it is worth to start threads. By hand


class Workers(Protocol):
    """Who computes pieces of work."""

    @property
    def n_workers(self) -> int:
        """Number of pieces that are computed at once."""

    def agree(self, ask: Callable[..., bool], /, *given: object) -> bool:
        """Whether every worker is another process, and answers ``ask(*given)`` with True."""

    def n_pieces(self, seconds: float = math.inf) -> int:
        """Number of pieces into which work of about so many seconds of one processor is divided."""

    def map(
        self, work: Callable[..., Result], pieces: Iterable[Piece], *shared: object
    ) -> Iterator[Result]:
        """Results of ``work(piece, *shared)``, in the order of the pieces.

        `work`: A function of a module, which changes nothing.

        `shared`: What is the same for all pieces. Where it is a large array, or a record of arrays,
        it is sent to other processes only once, and so are those in a piece that is a tuple.
        """


class Threads:
    """Threads of this process."""

    n_workers = N_THREADS

    def agree(self, _ask: Callable[..., bool], /, *_given: object) -> bool:
        """Never: they are no other processes."""
        return False

    def n_pieces(self, seconds: float = math.inf) -> int:
        """Number of pieces into which work of about so many seconds of one processor is divided."""
        return PIECES_EACH * N_THREADS if seconds >= _LEAST else 1

    def map(
        self, work: Callable[..., Result], pieces: Iterable[Piece], *shared: object
    ) -> Iterator[Result]:
        """Results of ``work(piece, *shared)``, in the order of the pieces."""
        left = iter(pieces)
        first = list(islice(left, 2))
        if len(first) <= 1 or N_THREADS == 1:
            yield from (work(piece, *shared) for piece in chain(first, left))
            return
        from concurrent.futures import ThreadPoolExecutor

        running: deque[Future[Result]] = deque()
        pool = ThreadPoolExecutor(N_THREADS)
        try:
            for piece in chain(first, left):
                running.append(pool.submit(work, piece, *shared))
                if len(running) == PIECES_EACH * N_THREADS:
                    yield running.popleft().result()
            yield from (future.result() for future in running)
        finally:  # after an error, or when nobody wants more, what has not begun is left out
            pool.shutdown(cancel_futures=True)


HERE = Threads()  # The workers where nobody names others


def runs(items: Sequence[Piece], n_runs: int) -> list[Sequence[Piece]]:
    """Divide items into at most so many runs of nearly equal length, none of them empty.

    >>> runs("abcde", 2), runs("ab", 4)
    (['ab', 'cde'], ['a', 'b'])
    """
    edges = [len(items) * n // n_runs for n in range(n_runs + 1)]
    return [items[a:b] for a, b in pairwise(edges) if a < b]
