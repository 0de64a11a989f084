"""Jobs: the limit of matrix products to one thread."""

from __future__ import annotations

from threading import Event, Thread

import numpy as np  # noqa: F401  loads the library of matrix products
from threadpoolctl import threadpool_info

from motiondb.symbols.hmm_jobs import one_blas_thread


def n_blas_threads() -> set[int]:
    return {pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"}


def test_overlapping_blocks_of_two_threads_have_one_thread_and_leave_all() -> None:
    """The block that began first ends first."""
    before, begun, overlapped = n_blas_threads(), Event(), Event()

    def first() -> None:
        with one_blas_thread():
            begun.set()
            overlapped.wait()

    thread = Thread(target=first)
    thread.start()
    begun.wait()
    with one_blas_thread():
        overlapped.set()
        thread.join()
        with one_blas_thread():
            pass
        assert n_blas_threads() == {1}
    assert n_blas_threads() == before
