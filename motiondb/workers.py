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
from threading import Thread
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

import numpy as np

from motiondb.errors import ClusterError

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


def trusted(
    workers: Workers,
    fits: Callable[..., bool],
    work: Callable[..., Result],
    pieces: Iterable[Piece],
    *shared: object,
    **how: Any,  # noqa: ANN401
) -> Iterator[tuple[Piece, Result]]:
    """Pieces and results of ``workers.map``; ClusterError for a result that cannot be right.

    Another computer may have a faulty memory, or be no worker of ours.

    `fits`: Whether ``fits(result, piece, *shared)``; an error of it counts as no.
    """
    asked = deque[Piece]()

    def noted() -> Iterator[Piece]:
        for piece in pieces:
            asked.append(piece)
            yield piece

    for result in workers.map(work, noted(), *shared, **how):
        piece = asked.popleft()
        try:
            is_right = workers is HERE or fits(result, piece, *shared)
        except Exception:  # what is of another kind raises anything
            is_right = False
        if not is_right:
            raise ClusterError(
                f"{getattr(workers, 'answered_by', 'a worker')}: expected an answer to "
                f"{work.__name__.strip('_')} of its kind and shape, found {_said(result)}. Nothing "
                "of it was saved: stop that worker, look at its memory and what is installed "
                "there, and start the command again."
            )
        yield piece, result


def is_array(found: object, shape: Sequence[int | None], kind: str = "f") -> bool:
    """Whether something is an array of finite numbers of a kind (``dtype.kind``) and a shape.

    `shape`: Sizes of the axes; None: any.

    >>> is_array(np.ones((2, 3)), (None, 3)), is_array(np.array([np.nan]), (1,))
    (True, False)
    """
    return (
        isinstance(found, np.ndarray)
        and found.dtype.kind == kind
        and found.ndim == len(shape)
        and all(size in (None, own) for size, own in zip(shape, found.shape))
        and bool(np.isfinite(found).all())
    )


def _said(found: object) -> str:
    """What something is, for a message.

    >>> _said(None), _said(np.zeros((2, 3))), _said([1])
    ('NoneType', 'ndarray (2, 3) of float64', 'list of 1')
    """
    kind = type(found).__name__
    if isinstance(found, np.ndarray):
        return f"{kind} {found.shape} of {found.dtype}"
    return f"{kind} of {len(found)}" if isinstance(found, tuple | list | str) else kind


def runs(items: Sequence[Piece], n_runs: int) -> list[Sequence[Piece]]:
    """Divide items into at most so many runs of nearly equal length, none of them empty.

    >>> runs("abcde", 2), runs("ab", 4)
    (['ab', 'cde'], ['a', 'b'])
    """
    edges = [len(items) * n // n_runs for n in range(n_runs + 1)]
    return [items[a:b] for a, b in pairwise(edges) if a < b]


def within(seconds: float, made: Callable[[], Result]) -> Result:
    """What a call gives, or TimeoutError after some seconds; the call is left behind then.

    For libraries without a limit of their own for another program that answers without end.
    """
    from concurrent.futures import Future

    done: Future[Result] = Future()

    def call() -> None:
        try:
            done.set_result(made())
        except BaseException as error:
            done.set_exception(error)

    Thread(target=call, daemon=True).start()
    try:
        return done.result(seconds)
    except TimeoutError as error:
        said = str(error) or f"nothing in {seconds:g} s"
    raise TimeoutError(said)
