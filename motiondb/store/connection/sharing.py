"""Let go of the file during a long computation, so that other processes can use it meanwhile."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from motiondb.store.connection.handle import Store

TAKE_BACK = 300.0
"""Seconds to wait for the file when a computation has ended. Chosen by hand: losing what took
minutes to compute is worse than waiting for others, whose commands take seconds."""


@contextmanager
def released(store: Store) -> Iterator[None]:
    """Let go of the file while the block computes, and take it back at its end.

    Other processes may read and write meanwhile. Threads of this process may still read: a question
    opens the file for reading until the end of the block. What the block computes from must be
    loaded before; whether it is still so must be asked afterwards, for example by comparing
    :func:`~motiondb.store.connection.transactions.revision` with the one before. A store that was
    opened for reading keeps the file: it stands in nobody's way but a writer's.

    Parameters
    ----------
    store : Store
        The open database; not within a transaction or a ``reading`` block of this thread.

    Raises
    ------
    StoreError
        Another process held the file for :data:`TAKE_BACK` seconds after the computation.
    """
    if store.read_only or store.in_transaction:
        yield
        return
    store.lend()
    try:
        yield
    except BaseException:
        store.take_back_later()
        raise
    store.take_back(TAKE_BACK)
