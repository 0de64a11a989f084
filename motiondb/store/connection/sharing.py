"""Release the file during a long computation, so that other processes can use it meanwhile."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from motiondb.store.connection.handle import Store

TAKE_BACK = 300.0
"""Seconds to wait for the file when a computation has ended. Chosen by hand: losing results of
minutes is worse than waiting for other commands, which take seconds."""


@contextmanager
def released(store: Store) -> Iterator[Callable[[], None]]:
    """Release the file while the block computes, and open it again at its end.

    Other processes may read and write meanwhile. A load in the block, by any thread, opens the file
    for reading, so that others can read but not write; the function that the block is given
    releases it again. Whether the loaded data are still current must be checked afterwards, by
    comparing them or :func:`~motiondb.store.connection.transactions.revision`. A store opened for
    reading stays open, because it does not block readers.

    `store`: The open database; not within a transaction or a ``reading`` block of this thread.
    """
    if store.read_only or store.in_transaction:
        yield lambda: None
        return
    store.lend()
    try:
        yield store.lend
    except BaseException:
        store.take_back_later()
        raise
    store.take_back(TAKE_BACK)
