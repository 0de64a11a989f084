"""Workers on a cluster: pieces of work that dask computes in other processes, on any machine.

dask has the scheduler, the queue and the transport; here is what motiondb adds: what several pieces
need is sent to the scheduler once, and from worker to worker; results come in the order of the
pieces; and every way to fail is one sentence. dask is imported when a cluster is used, and not
before.
"""

from __future__ import annotations

import hashlib
import ipaddress
import math
import sys
import time
import warnings
import weakref
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar
from uuid import uuid4

import numpy as np

from motiondb.database.values import check_text
from motiondb.errors import ClusterError
from motiondb.files.safe_files import open_file
from motiondb.symbols.hmm_jobs import one_blas_thread
from motiondb.workers import PIECES_EACH, within

if TYPE_CHECKING:
    from distributed import Client, Future, LocalCluster

Piece = TypeVar("Piece")
Result = TypeVar("Result")

LOCAL = "local"  # Address that means processes of this machine, for as long as the command runs
WAIT = 30.0  # Seconds to wait for the scheduler and for its first worker
_ATTEMPTS = 4  # How often a piece is sent whose data or worker were lost
_LOST = 3.0  # Seconds without an answer after which the scheduler is asked who works on it
_ALONE = 300.0  # Seconds to wait for a worker where the last one has gone
_LEAST = 0.1  # Seconds of work of a piece: handing one out takes about .005 s
_SMALL = 100_000  # Bytes up to which an object is sent with every piece
_NEEDED = (
    "sklearn.cluster",
    "scipy.spatial",
    "scipy.stats",
    "motiondb.database.evaluating",
    "motiondb.database.questions",
    "motiondb.database.searching",
    "motiondb.search.by_example",
    "motiondb.database.loading",
    "motiondb.database.catalogue.file_reading",
    "motiondb.symbols.acquisition",
    "motiondb.symbols.segmentation",
)
"""Modules of the work of workers."""
_ENDED = (OSError, TimeoutError, RuntimeError)  # What dask raises without its scheduler
_SAME = ("motiondb", "numpy", "scipy", "numba")  # Packages whose versions must be the same


@dataclass(frozen=True)
class Bounds(Generic[Piece, Result]):
    """What is done with a piece that ends the process of its worker, or takes too long."""

    seconds: Callable[[Piece], float]  # How long a piece may take
    slow: Callable[[Piece], Result]  # Its result where it takes longer
    ended: Callable[[Piece], Result]  # Its result where it ends several workers


class Cluster:
    """Workers of a dask cluster; use it in a ``with`` statement.

    The answers are those of one machine, whatever the number of workers. A worker that ends costs
    time: others compute its pieces again.

    Parameters
    ----------
    address : str
        Address of dask's scheduler, such as "tcp://10.0.0.5:8786" or "tls://10.0.0.5:8786" (keys
        and certificates by dask's own configuration, ``distributed.comm.tls``); "local": one
        process for each core of this machine, which end with the block.
    tell : callable, optional
        Called with a sentence where there is no worker left, and the work waits for one.

    Raises
    ------
    ClusterError
        When dask is not installed, no scheduler or worker answers, or a worker has other versions.
    """

    _answered: Future | None = None

    def __init__(self, address: str, tell: Callable[[str], None] | None = None) -> None:
        check_text("address", address)  # dask starts a cluster of its own for None
        self.address, self._tell = address, tell
        self._started: LocalCluster | None = None
        self._kept: dict[int, _Kept] = {}
        self._n_sent = 0  # Objects that were sent to be kept
        self._client = self._connect()
        try:
            self._check_workers()
        except BaseException:
            self.close()
            raise

    def _connect(self) -> Client:
        """Connect with the scheduler, or start one."""
        try:
            from distributed import Client, LocalCluster
        except ImportError:
            raise ClusterError(
                "cluster: expected dask.distributed, found that it is not installed. Install it: "
                "pip install 'motiondb[cluster]'."
            ) from None
        try:
            if self.address == LOCAL:
                self._started = LocalCluster(
                    threads_per_worker=1, host="127.0.0.1", dashboard_address="127.0.0.1:0"
                )
            place = self._started or self.address
            return within(2 * WAIT, lambda: Client(place, timeout=WAIT, set_as_default=False))
        except Exception as error:  # another program's answers make dask raise many kinds
            raise ClusterError(
                f"{self.address}: expected the address of dask's scheduler, such as "
                f"tcp://10.0.0.5:8786, found none that answers ({_first_line(error)}). Start one: "
                "dask scheduler."
            ) from None

    def _check_workers(self) -> None:
        """Refuse a cluster without workers, and workers that would answer otherwise."""
        try:
            self._client.wait_for_workers(1, timeout=WAIT)
        except TimeoutError:
            raise ClusterError(
                f"{self.address}: expected at least one worker, found none in {WAIT:g} s. Start "
                f"some: dask worker {self.address}."
            ) from None
        found = self._client.run(ready, on_error="return")
        for worker, theirs in found.items():
            if isinstance(theirs, Exception):
                raise ClusterError(
                    f"{worker}: expected a worker with motiondb, found one that cannot import it "
                    f"({_first_line(theirs)}). Install motiondb {version('motiondb')} there."
                )
            check_versions(worker, versions(), theirs)

    @property
    def dashboard(self) -> str:
        """Address of dask's page on the cluster; "" if it has none."""
        return self._client.dashboard_link or ""

    @property
    def warning(self) -> str:
        """A sentence if captures travel unencrypted over a network; else ""."""
        return _exposed(self._client.scheduler_info()["address"])

    @property
    def n_workers(self) -> int:
        """Number of threads of all workers: so many pieces are computed at once."""
        try:
            return max(1, sum(self._client.nthreads().values()))
        except _ENDED as error:
            raise self._gone(_first_line(error)) from None

    @property
    def answered_by(self) -> str:
        """Address of the worker that gave the last result of :meth:`map`; the cluster's if lost."""
        with suppress(Exception):
            ((worker, *_),) = self._client.who_has([self._answered]).values()
            return str(worker)
        return self.address

    def n_pieces(self, seconds: float = math.inf) -> int:
        """Number of pieces into which work of about so many seconds of one processor is divided.

        Parameters
        ----------
        seconds : float
            Seconds that one processor would need; pieces are not made so small that sending them
            takes longer than their work.
        """
        return int(np.clip(seconds / _LEAST, 1, PIECES_EACH * self.n_workers))

    def each(self, ask: Callable[..., Result], /, *given: object) -> dict[str, Result | Exception]:
        """What every worker answers to ``ask(*given)``, or its error, by the worker's address.

        Parameters
        ----------
        ask : callable
            A function of a module.
        *given : object
            Its arguments.

        Raises
        ------
        ClusterError
            When the scheduler goes away.
        """
        try:
            found: dict[str, Result | Exception] = self._client.run(ask, *given, on_error="return")
        except _ENDED as error:
            raise self._gone(_first_line(error)) from None
        return found

    def map(
        self,
        work: Callable[..., Result],
        pieces: Iterable[Piece],
        *shared: object,
        bounds: Bounds[Piece, Result] | None = None,
    ) -> Iterator[Result]:
        """Results of ``work(piece, *shared)``, in the order of the pieces.

        What is large among the shared, and in a piece that is a tuple, is sent once, and kept by
        the workers that needed it as long as it is kept here. Large is an array, or a record of
        arrays; a list, a tuple or a dictionary of them is sent with every piece.

        Parameters
        ----------
        work : callable
            A function of a module, which changes nothing.
        pieces : iterable
            Pieces, which are taken as results come: few wait in memory.
        *shared : object
            What is the same for all pieces.
        bounds : Bounds, optional
            What a piece may take. None: it may take any time, and must not end its worker.

        Raises
        ------
        ClusterError
            When the scheduler goes away, workers end again and again, or the last one has gone and
            none comes.
        """
        job = _Job(work, shared, bounds)
        running, ahead = deque[tuple[Piece, Any]](), self.n_pieces()
        try:
            for piece in pieces:
                running.append((piece, self._submit(job, piece)))
                if len(running) >= ahead:
                    yield self._result(job, *running.popleft())
            while running:
                yield self._result(job, *running.popleft())
        finally:
            with suppress(Exception):  # an error, or nobody wants them
                self._client.cancel([future for _, future in running])

    def _submit(self, job: _Job[Result], piece: object) -> Future:
        """Hand out a piece, to the worker that keeps its data if it is there."""
        try:
            place, held = None, piece
            if isinstance(piece, tuple):
                parts = [self._keep(each, is_part=True) for each in piece]
                place = next((part.worker for part in parts if isinstance(part, _Kept)), None)
                held = tuple(map(_sent, parts))
            shared = [_sent(self._keep(each)) for each in job.shared]
            name = f"{job.work.__name__.strip('_')}-{uuid4()}"  # shown on dask's page
            return self._client.submit(
                _checked,
                versions(),
                job.work,
                held,
                *shared,
                key=name,
                workers=place,
                allow_other_workers=place is not None,
            )
        except _ENDED as error:
            raise self._gone(_first_line(error)) from None

    def _keep(self, what: object, is_part: bool = False) -> object:
        """An object itself if it is small; otherwise how a worker keeps it: each in its turn.

        `is_part`: Whether it is of a piece, on which the worker works that keeps it.
        """
        if _n_bytes(what) < _SMALL:
            return what
        place = id(what)
        if place not in self._kept:
            worker = self._next_worker(is_part)
            self._n_sent += 1
            with warnings.catch_warnings():  # of its size: the scheduler keeps it, so that it can
                warnings.simplefilter("ignore")  # be sent again where it was lost with a worker
                future = self._client.submit(
                    _itself,
                    what,
                    pure=False,
                    workers=worker,
                    allow_other_workers=worker is not None,
                )
            self._kept[place] = _Kept(future, worker, is_part)
            weakref.finalize(what, self._kept.pop, place, None).atexit = False
        return self._kept[place]

    def _next_worker(self, is_part: bool) -> str | None:
        """Address of the worker that keeps the fewest objects of a kind for each of its threads.

        None where no worker is left.
        """
        n_threads = self._client.nthreads()
        kept = Counter(each.worker for each in self._kept.values() if each.is_part == is_part)
        return min(
            sorted(n_threads),
            key=lambda worker: kept[worker] / max(n_threads[worker], 1),
            default=None,
        )

    def _result(self, job: _Job[Result], piece: object, future: Future) -> Result:
        """The result of a piece, which is handed out again where its data were lost."""
        from concurrent.futures import CancelledError

        from distributed import KilledWorker
        from distributed.comm import CommClosedError

        for _ in range(_ATTEMPTS):
            try:
                if not self._finished(future, job.bounds, piece):
                    assert job.bounds is not None
                    return job.bounds.slow(piece)
                result: Result = future.result()
                self._answered = future
                return result
            except KilledWorker as error:
                if job.bounds is not None:
                    return job.bounds.ended(piece)
                raise ClusterError(
                    f"{self.address}: expected workers that stay, found that several ended with "
                    f"the same piece of work ({_first_line(error)}). Look at their logs; give them "
                    "more memory."
                ) from None
            except (CancelledError, CommClosedError) as error:  # lost with worker or scheduler
                self._check_there(error)
                self._forget_lost()
                future = self._submit(job, piece)
        raise self._gone("results were lost again and again")

    def _forget_lost(self) -> None:
        """Forget what workers keep no more, so that it is sent again."""
        for place, kept in list(self._kept.items()):
            if kept.future.cancelled():
                self._kept.pop(place, None)

    def _finished(self, future: Future, bounds: Bounds[Any, Any] | None, piece: object) -> bool:
        """Wait for a piece; False if it took too long, and its worker is started anew.

        Only the time counts in which a worker had it.
        """
        left = float("inf") if bounds is None else 2 * bounds.seconds(piece)  # it may have to queue
        alone = 0.0
        while not future.done():
            began = time.monotonic()
            try:
                future.result(timeout=min(_LOST, left))
            except TimeoutError:
                if future.done():  # an error of the work itself
                    break
            except Exception:
                break  # it will be raised again
            self._check_there()
            at_work = self._at_work()
            taken = time.monotonic() - began
            alone = 0.0 if at_work else self._left_alone(alone, taken)
            left -= taken * any(future.key in keys for keys in at_work.values())
            if left <= 0 and not future.done():
                self._end(future)
                return False
        return True

    def _at_work(self) -> Mapping[str, Iterable[object]]:
        """The workers, with the pieces that each has."""
        try:
            return within(WAIT, self._client.processing)
        except _ENDED as error:
            raise self._gone(_first_line(error)) from None

    def _left_alone(self, before: float, seconds: float) -> float:
        """Seconds without a worker so far; at first this is said, after :data:`_ALONE` an error."""
        if not before and self._tell is not None:
            self._tell(f"{self.address}: no worker left, waiting for one")
        if before + seconds < _ALONE:
            return before + seconds
        raise ClusterError(
            f"{self.address}: expected workers until the work is done, found none left, and none "
            f"that came in {_ALONE:g} s. What was not saved is as before; start some (dask worker "
            f"{self.address}) and the command again."
        )

    def _end(self, future: Future) -> None:
        """Give up a piece, and start its worker anew, which cannot interrupt it."""
        with suppress(Exception):  # a worker without a nanny is not started again
            stuck = [w for w, keys in self._client.processing().items() if future.key in keys]
            future.cancel()
            self._client.restart_workers(stuck, timeout=WAIT, raise_for_error=False)

    def _check_there(self, error: BaseException | None = None) -> None:
        """Refuse to wait for a scheduler that went away."""
        if self._client.status != "running":
            raise self._gone(_first_line(error) if error else "the connection is closed")

    def _gone(self, reason: str) -> ClusterError:
        """The error that says that the cluster does not answer any more."""
        return ClusterError(
            f"{self.address}: expected the scheduler to stay until the work is done, found that it "
            f"went away ({reason}). What was not saved is as before; start the scheduler and the "
            "command again."
        )

    def close(self) -> None:
        """Leave the cluster; end the processes that were started here."""
        self._kept.clear()
        self._client.close(timeout=2)
        if self._started is not None:
            self._started.close()

    def __enter__(self) -> Cluster:
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()


@dataclass(frozen=True)
class _Kept:
    """An object that a worker keeps."""

    future: Future
    worker: str | None  # Its address; None: any
    is_part: bool  # Whether it is of a piece, not of what pieces share


@dataclass(frozen=True)
class _Job(Generic[Result]):
    """What is done with every piece."""

    work: Callable[..., Result]
    shared: tuple[object, ...]  # What all pieces share
    bounds: Bounds[Any, Result] | None


@cache
def versions() -> dict[str, str]:
    """Versions on which answers depend, of this process."""
    python = ".".join(map(str, sys.version_info[:2]))
    found = {"Python": python, **{name: version(name) for name in _SAME}}
    return found | {"code of motiondb": _code_digest()}


def _code_digest() -> str:
    """Digest of the installed modules, but those of the page: versions do not tell checkouts."""
    package, digest = Path(__file__).parents[1], hashlib.sha256()
    rooms = [room for room in package.iterdir() if room.is_dir() and room.name != "page"]
    modules = [*package.glob("*.py"), *(path for room in rooms for path in room.rglob("*.py"))]
    for path in sorted(modules):
        with open_file(path) as file:
            code = file.read().replace(b"\r\n", b"\n")  # as a checkout on Windows has it
        digest.update(f"{path.relative_to(package).as_posix()} {len(code)} ".encode() + code)
    return digest.hexdigest()[:12]


@cache
def ready() -> dict[str, str]:
    """Import what workers need, and give the versions of this process.

    Libraries that one thread loads while another looks at them (threadpoolctl) can lock each other
    out for ever, so all are loaded before the first piece.
    """
    for module in _NEEDED:
        import_module(module)
    with one_blas_thread():
        return versions()


def check_versions(worker: str, here: dict[str, str], there: dict[str, str]) -> None:
    """Refuse a worker whose versions are not those of the process that asks."""
    for name, own in here.items():
        if there.get(name) != own:
            raise ClusterError(
                f"{worker}: expected {name} {own} as here, found {there.get(name)}. Install the "
                "same version there: answers must not depend on who computes them."
            )


def _checked(
    here: dict[str, str], work: Callable[..., Result], piece: object, *shared: object
) -> Result:
    """Work on a piece, by a worker that may have come later."""
    if (there := ready()) != here:
        from distributed import get_worker

        check_versions(get_worker().address, here, there)
    return work(piece, *shared)


def _exposed(address: str) -> str:
    """A sentence if a scheduler's address is unencrypted and not of this machine; else "".

    >>> _exposed("tcp://127.0.0.1:8786"), _exposed("tls://10.0.0.5:8786")
    ('', '')
    """
    scheme, _, place = address.partition("://")
    host = place.rpartition(":")[0].strip("[]")
    if scheme in ("tls", "wss", "inproc") or host == "localhost":
        return ""
    try:
        if ipaddress.ip_address(host).is_loopback:
            return ""
    except ValueError:
        pass  # the name of another machine
    return (
        f"{address}: captures travel unencrypted, and whoever reaches the scheduler can run code "
        f"on its workers. Use it in a network of your own only, or TLS (docs/guide/cluster.md)."
    )


def _sent(what: object) -> object:
    """What a task names for an object, or for one that is kept."""
    return what.future if isinstance(what, _Kept) else what


def _itself(what: Result) -> Result:
    """The object, which dask then copies to every worker that needs it."""
    return what


def _n_bytes(what: object) -> int:
    """Bytes of the arrays of an object."""
    if isinstance(what, np.ndarray):
        return what.nbytes
    return sum(map(_n_bytes, vars(what).values())) if hasattr(what, "__dict__") else 0


def _first_line(error: BaseException) -> str:
    """The first line of an error, or its kind."""
    lines = str(error).strip().splitlines()
    return lines[0][:200] if lines else type(error).__name__
