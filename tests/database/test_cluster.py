"""A cluster: the answers of one machine, whatever happens to its workers."""

from __future__ import annotations

import datetime
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import CancelledError
from contextlib import closing, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import duckdb
import numpy as np
import pytest
from distributed import LocalCluster
from distributed.comm import CommClosedError

import motiondb
from motiondb import Cluster, ClusterError, LearnSettings, Question
from motiondb.database import cluster
from motiondb.database import questions as asked_of
from motiondb.files.packed_files import Source
from motiondb.records import Motion
from motiondb.symbols import spread

NOT_THE_SAME = ("run", "meta", "learning")  # Tables with times and random marks
SETTINGS = LearnSettings(n_symbols=3)


@dataclass
class Processes:
    """A scheduler and its workers, each a process, which speak TLS with one another."""

    address: str
    scheduler: subprocess.Popen[bytes]
    workers: list[subprocess.Popen[bytes]]


def certificate(folder: Path) -> dict[str, str]:
    """A key and a certificate that vouches for itself, as dask's configuration."""
    from cryptography import x509
    from cryptography.hazmat.primitives import hashes, serialization
    from cryptography.hazmat.primitives.asymmetric import ec

    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, "motiondb")])
    now = datetime.datetime.now(datetime.UTC)
    signed = (
        x509.CertificateBuilder(name, name, key.public_key(), x509.random_serial_number())
        .not_valid_before(now - datetime.timedelta(days=1))
        .not_valid_after(now + datetime.timedelta(days=1))
        .sign(key, hashes.SHA256())
    )
    pem, form = serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8
    cert, secret = folder / "cert.pem", folder / "key.pem"
    cert.write_bytes(signed.public_bytes(pem))
    secret.write_bytes(key.private_bytes(pem, form, serialization.NoEncryption()))
    prefix, roles = "distributed.comm.tls", ("scheduler", "worker", "client")
    files = {"cert": str(cert), "key": str(secret)}
    return {f"{prefix}.ca-file": str(cert)} | {
        f"{prefix}.{role}.{what}": file for role in roles for what, file in files.items()
    }


@contextmanager
def started(
    folder: Path, protocol: str, host: str, *prefixes: Sequence[str], env: Mapping[str, str] = {}
) -> Iterator[Processes]:
    """A scheduler, and a worker for each prefix of its command."""
    place = folder / "scheduler.json"
    common = ["--scheduler-file", str(place), "--protocol", protocol, "--no-dashboard"]

    def start(prefix: Sequence[str], what: str, *options: str) -> subprocess.Popen[bytes]:
        command = [*prefix, sys.executable, "-m", f"distributed.cli.dask_{what}", *common, *options]
        return subprocess.Popen(
            command, env=os.environ | env, cwd=folder, stderr=subprocess.DEVNULL
        )

    running = [start((), "scheduler", "--host", host, "--port", "0")]
    running += [start(prefix, "worker", "--nthreads", "1", "--no-nanny") for prefix in prefixes]
    try:
        while not (place.exists() and place.read_text().rstrip().endswith("}")):
            assert running[0].poll() is None
            time.sleep(0.1)
        yield Processes(json.loads(place.read_text())["address"], running[0], running[1:])
    finally:
        for process in running:
            process.kill()
            process.wait()


@pytest.fixture
def processes(tmp_path: Path, request: pytest.FixtureRequest) -> Iterator[Processes]:
    """A scheduler and two workers, or as many as a test asks for."""
    import dask.config
    import distributed  # noqa: F401  its defaults, before some are set for a while

    settings, prefixes = certificate(tmp_path), [()] * getattr(request, "param", 2)
    env = {f"DASK_{k.replace('.', '__').replace('-', '_').upper()}": settings[k] for k in settings}
    with (
        dask.config.set(settings),
        started(tmp_path, "tls", "127.0.0.1", *prefixes, env=env) as processes,
    ):
        yield processes


@pytest.fixture
def two_hosts(tmp_path: Path) -> Iterator[Processes]:
    """A scheduler here, and a worker in a network namespace, as on another machine."""
    name, here, there = f"mdb{os.getpid()}", "10.213.77.1", "10.213.77.2"

    def ip(*words: str) -> None:
        subprocess.run(["ip", *words], check=True, capture_output=True)

    try:
        ip("netns", "add", name)
    except (OSError, subprocess.CalledProcessError) as error:
        pytest.skip(f"this machine allows no network namespaces: {error}")
    try:
        ip("link", "add", name, "type", "veth", "peer", "name", "there", "netns", name)
        ip("addr", "add", f"{here}/30", "dev", name)
        ip("link", "set", name, "up")
        ip("-n", name, "addr", "add", f"{there}/30", "dev", "there")
        ip("-n", name, "link", "set", "there", "up")
        with started(tmp_path, "tcp", here, ("ip", "netns", "exec", name)) as processes:
            yield processes
    finally:
        ip("netns", "delete", name)  # with both ends of the connection


def rows(path: Path) -> dict[str, list[str]]:
    """All rows of a database, but times and random marks."""
    with closing(duckdb.connect(str(path), read_only=True)) as opened:
        tables = opened.execute("select table_name from information_schema.tables").fetchall()
        names = sorted(name for (name,) in tables if name not in NOT_THE_SAME)
        return {
            name: sorted(map(repr, opened.execute(f'select * from "{name}"').fetchall()))
            for name in names
        }


def answering(result: Callable[[], object]) -> Any:
    """What dask gives for work that is done."""
    return SimpleNamespace(done=lambda: True, result=result)


def kills(process: subprocess.Popen[bytes], step: str) -> Callable[..., None]:
    """A progress callback that kills a process when a step begins."""

    def tell(what: str, *_: float) -> None:
        if what == step:
            process.send_signal(signal.SIGKILL)

    return tell


@pytest.fixture
def divided(monkeypatch: pytest.MonkeyPatch) -> None:
    """A few captures are divided, and sent, as many hours are."""
    monkeypatch.setattr(cluster, "_LEAST", 1e-4)
    monkeypatch.setattr(cluster, "_SMALL", 1000)
    monkeypatch.setattr(spread, "PART_FRAMES", 50)


def made_by(workers: Cluster | None, some: Path, path: Path) -> dict[str, list[str]]:
    """All rows of a database that workers made."""
    with motiondb.open(path) as db:
        db.add(some, workers=workers)
        db.learn(SETTINGS, workers=workers)
    return rows(path)


@pytest.mark.usefixtures("divided")
def test_one_worker_and_eight_change_no_bit(some: Path, tmp_path: Path) -> None:
    alone = made_by(None, some, tmp_path / "alone.duckdb")
    for n_workers in (1, 8):
        with (
            LocalCluster(
                n_workers=n_workers,
                threads_per_worker=1,
                processes=False,
                dashboard_address="127.0.0.1:0",  # any free port
            ) as started,
            Cluster(started.scheduler_address) as workers,
        ):
            assert workers.n_workers == n_workers
            assert made_by(workers, some, tmp_path / f"{n_workers}.duckdb") == alone


class Liars(Cluster):
    """Workers of another computer that answer something else than they computed."""

    answered_by, n_workers = "tcp://w:1", 2  # type: ignore[assignment]

    def __init__(self, changed: Callable[[Any], Any], of: str = "") -> None:
        self._changed, self._of = changed, of

    def n_pieces(self, _seconds: float = 0.0) -> int:
        return 2

    def map(self, work: Callable[..., Any], pieces: Iterable[Any], *shared: object, **_: object):
        for piece in pieces:
            found = work(piece, *shared)
            yield self._changed(found) if work.__name__.strip("_").startswith(self._of) else found


def moved(motion: Motion) -> Motion:
    return replace(motion, root_positions=motion.root_positions + np.float32(1000.0))


@pytest.mark.parametrize(
    "changed",
    [
        lambda _: None,
        lambda _: "a text",
        lambda found: (*found, *found),
        lambda found: tuple(replace(one, name="../../evil") for one in found),
        lambda found: tuple(replace(one, motion=moved(one.motion)) for one in found),
        lambda found: tuple(replace(one, n_frames=3) for one in found),
        lambda found: tuple(replace(one, fps=1j) for one in found),
        lambda found: tuple(replace(one, notes=(1,)) for one in found),
        lambda found: tuple(replace(one, problem=1, motion=None) for one in found),
    ],
)
def test_wrong_answers_of_workers_add_nothing(
    changed: Callable[[Any], Any], some: Path, tmp_path: Path
) -> None:
    with motiondb.open(tmp_path / "m.duckdb") as db:
        liars: Any = Liars(changed)
        with pytest.raises(ClusterError, match=r"^tcp://w:1: expected an answer to read_loaded of"):
            db.add(some, workers=liars)
        assert db.captures() == []


def test_bytes_and_digests_are_those_of_the_process_that_adds(some: Path, tmp_path: Path) -> None:
    lie = Source("0" * 64, "bvh", "evil.bvh", b"other bytes")
    liars: Any = Liars(lambda found: tuple(replace(r, source=lie) for r in found), "read_loaded")
    with motiondb.open(tmp_path / "m.duckdb") as db:
        assert len(db.add(some, workers=liars).added) == 4
        assert db.check() == []
        db.export("ana/bow_1", tmp_path / "back.bvh")
    assert (tmp_path / "back.bvh").read_bytes() == (some / "ana" / "bow_1.bvh").read_bytes()


@pytest.mark.usefixtures("divided")
@pytest.mark.parametrize(
    "of", ["features_of_motions", "first_cuts", "cut_captures", "expect", "score_blocks"]
)
def test_wrong_answers_of_workers_teach_nothing(of: str, some: Path, tmp_path: Path) -> None:
    def spoilt(found: Any) -> Any:
        if isinstance(found, np.ndarray):
            return found[..., :-1] if found.dtype.kind == "i" else found * np.float32(np.nan)
        return type(found)(found[:-1]) if isinstance(found, list) else (found[0], None)

    with motiondb.open(tmp_path / "m.duckdb") as db:
        db.add(some)
        for lie in (spoilt, lambda _: None):
            liars: Any = Liars(lie, of)
            shutil.rmtree(f"{tmp_path / 'm.duckdb'}.cache", ignore_errors=True)
            with pytest.raises(ClusterError, match=f"^tcp://w:1: expected an answer to {of} of"):
                db.learn(SETTINGS, workers=liars)
        assert not db.is_learned()


def test_without_a_worker_it_waits_says_so_and_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "_LOST", 0.1)
    monkeypatch.setattr(cluster, "_ALONE", 0.5)
    said, bounds = list[str](), cluster.Bounds(lambda _: 0.1, str, str)
    with (
        LocalCluster(
            n_workers=1,
            threads_per_worker=1,
            processes=False,
            dashboard_address="127.0.0.1:0",
        ) as started,
        Cluster(started.scheduler_address, said.append) as workers,
    ):
        assert list(workers.map(len, ["abc"])) == [3]
        started.scale(0)
        while workers._client.nthreads():
            time.sleep(0.02)
        for shared in ((), (np.zeros(20_000),)):
            with pytest.raises(ClusterError, match=f"^{workers.address}: expected workers until"):
                list(workers.map(len, ["abc"], *shared, bounds=bounds))  # it blames no piece
    assert said == 2 * [f"{workers.address}: no worker left, waiting for one"]


def test_the_time_of_a_piece_is_that_in_which_a_worker_has_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(cluster, "_LOST", 0.01)
    asked = list[int]()

    def result(timeout: float | None = None) -> int:
        if timeout is None:
            return 7
        time.sleep(timeout)
        raise TimeoutError

    def processing() -> dict[str, list[str]]:
        asked.append(1)
        return {"tcp://w:1": []}  # it works on something else

    future: Any = SimpleNamespace(done=lambda: len(asked) > 9, result=result, key="k")
    workers = object.__new__(Cluster)
    workers.address, workers._kept = "tcp://s:1", {}
    workers._client = SimpleNamespace(status="running", processing=processing)
    bounds = cluster.Bounds(lambda _: 0.01, lambda _: "too slow", str)
    assert workers._result(cluster._Job(int, (), bounds), "piece", future) == 7


def test_what_is_large_is_sent_once_and_forgotten_when_it_is_here() -> None:
    sent = list[object]()

    def submit(*_: object, **options: object) -> object:
        sent.append(options.get("workers"))
        return answering(lambda: len(sent))

    workers = object.__new__(Cluster)
    workers.address, workers._kept, workers._n_sent = "tcp://w:1", {}, 0
    workers._client = SimpleNamespace(
        status="running", submit=submit, cancel=lambda _: None, nthreads=lambda: {"a": 1, "b": 1}
    )
    workers.n_pieces = lambda *_: 9  # type: ignore[method-assign]
    large = [np.zeros(20_000), np.zeros(20_000)]
    pieces = [(large[0], 1), (large[1], 2), (large[0], 3)]
    shared = np.zeros(20_000)
    assert len(list(workers.map(len, pieces, np.zeros(3), shared))) == 3
    assert len(workers._kept) == 3
    # of pieces to each in its turn, whatever they share, and work to where its data are
    assert sent == ["a", "a", "a", "b", "b", "a"]
    del large, pieces, shared
    assert workers._kept == {}


@pytest.mark.usefixtures("divided")
def test_workers_and_their_deaths_change_no_bit(
    some: Path, tmp_path: Path, processes: Processes
) -> None:
    alone = made_by(None, some, tmp_path / "alone.duckdb")
    with (
        Cluster(processes.address) as workers,
        motiondb.open(tmp_path / "two.duckdb") as db,
    ):
        assert processes.address.startswith("tls://")
        assert (workers.n_workers, workers.warning) == (2, "")
        db.add(some, workers=workers)
        db.learn(SETTINGS, kills(processes.workers[0], "symbols compete"), workers=workers)
        assert workers.n_workers == 1
        questions = [Question("walk"), Question(like="ana/walk_1", limit=2), Question("walk then")]
        here = list(map(repr, db.ask_many(questions)))
    with (
        Cluster(processes.address) as workers,
        motiondb.open(tmp_path / "two.duckdb", read_only=True) as db,
    ):
        assert list(map(repr, db.ask_many(questions, workers))) == here
        assert workers._n_sent == 0  # they map what they need
        kept = workers._client.run(lambda: len(asked_of._lent))
        assert list(kept.values()) == [0]  # and forget it at the end
    motiondb.open(tmp_path / "two.duckdb").close()
    assert rows(tmp_path / "two.duckdb") == alone


@pytest.mark.parametrize("processes", [1], indirect=True)
@pytest.mark.parametrize("step", ["reading captures", "symbols compete"])
def test_without_the_scheduler_nothing_is_changed(
    step: str, some: Path, tmp_path: Path, processes: Processes
) -> None:
    path, tell = tmp_path / "m.duckdb", kills(processes.scheduler, step)
    with motiondb.open(path) as db:
        if step == "symbols compete":
            db.add(some)
    before = rows(path)
    with Cluster(processes.address) as workers, motiondb.open(path) as db:
        work = {
            "reading captures": lambda: db.add(some, progress=tell, workers=workers),
            "symbols compete": lambda: db.learn(SETTINGS, tell, workers=workers),
        }
        with pytest.raises(ClusterError, match="expected the scheduler to stay until the work is"):
            work[step]()
    assert rows(path) == before


def test_a_worker_on_another_machine_reads_captures_and_is_warned_of(
    some: Path, tmp_path: Path, two_hosts: Processes
) -> None:
    with Cluster(two_hosts.address) as workers, motiondb.open(tmp_path / "m.duckdb") as db:
        assert ["10.213.77.2:" in address for address in workers._client.nthreads()] == [True]
        assert workers.warning.startswith(f"{two_hosts.address}: captures travel unencrypted")
        assert len(db.add(some, workers=workers).added) == 4


@pytest.mark.parametrize("lost", [CancelledError, CommClosedError])
def test_a_result_whose_connection_ends_is_asked_for_again_while_there_is_a_scheduler(
    lost: type[Exception],
) -> None:
    client = SimpleNamespace(status="running", submit=lambda *_, **__: answering(lambda: 7))
    workers = object.__new__(Cluster)
    workers.address, workers._client, workers._kept = "tcp://w:1", client, {}

    def fails() -> None:
        raise lost("Stream is closed")

    job: cluster._Job[int] = cluster._Job(int, (), None)
    assert workers._result(job, "7", answering(fails)) == 7
    client.status = "closed"
    with pytest.raises(ClusterError, match=r"^tcp://w:1: .* went away \(Stream is closed\)\."):
        workers._result(job, "7", answering(fails))


def test_what_workers_lost_is_sent_again() -> None:
    kept = list[Any]()

    def lost() -> None:
        raise CancelledError("lost")

    def submit(work: object, *given: object, **_: object) -> object:
        if work is not cluster._itself:
            return answering(lost if given[-1] is kept[0] else lambda: 7)
        cancelled = not kept
        kept.append(SimpleNamespace(cancelled=lambda: cancelled))
        return kept[-1]

    workers = object.__new__(Cluster)
    workers.address, workers._kept, workers._n_sent = "tcp://w:1", {}, 0
    workers._client = SimpleNamespace(
        status="running", submit=submit, cancel=lambda _: None, nthreads=lambda: {"a": 1}
    )
    large = np.zeros(20_000)
    assert list(workers.map(len, [1], large)) == [7]
    assert len(kept) == 2


def test_nobody_answers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "WAIT", 0.3)
    with pytest.raises(ClusterError) as error:
        Cluster("tcp://127.0.0.1:9")
    assert str(error.value).startswith(
        "tcp://127.0.0.1:9: expected the address of dask's scheduler, such as "
        "tcp://10.0.0.5:8786, found none that answers ("
    )


def test_another_program_that_answers_is_no_scheduler(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "WAIT", 5)
    with socket.create_server(("127.0.0.1", 0)) as server:

        def answer() -> None:
            asked, _ = server.accept()
            with asked:  # one message without a frame, which dask unpacks with struct
                asked.sendall((1).to_bytes(8, "little") + (2**40).to_bytes(8, "little"))
                asked.sendall(b"x" * 100)

        threading.Thread(target=answer, daemon=True).start()
        with pytest.raises(ClusterError, match="expected the address of dask's scheduler, such as"):
            Cluster(f"tcp://127.0.0.1:{server.getsockname()[1]}")


def test_a_program_that_says_nothing_is_no_scheduler(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "WAIT", 0.3)
    with (
        socket.create_server(("127.0.0.1", 0)) as server,
        pytest.raises(ClusterError, match=r"found none that answers \(nothing in 0.6 s\)"),
    ):
        Cluster(f"tcp://127.0.0.1:{server.getsockname()[1]}")


def test_another_version_is_refused() -> None:
    here = cluster.versions()
    other = here | {"code of motiondb": "0" * 12}
    with pytest.raises(ClusterError, match=r"^tcp://w:1: expected code of motiondb .{12} as here"):
        cluster.check_versions("tcp://w:1", here, other)
    with pytest.raises(ClusterError, match=r"^tcp://w:1: expected numpy .* as here, found 1.0\."):
        cluster.check_versions("tcp://w:1", here, here | {"numpy": "1.0"})


def test_open_networks_are_warned_of() -> None:
    text = cluster._exposed("tcp://10.0.0.5:8786")
    assert "unencrypted" in text
    assert cluster._exposed("tcp://node7:8786").startswith("tcp://node7:8786: ")
    assert [cluster._exposed(a) for a in ("tcp://[::1]:1", "tls://node7:1")] == ["", ""]


def test_without_a_cluster_nothing_of_dask_is_imported() -> None:
    names = "motiondb.cli.main, motiondb.database.motion_db, motiondb.database.cluster"
    lazily = "motiondb.database.catalogue.cataloguing, motiondb.database.learn.learn_run"
    code = f"import sys, {names}, {lazily}; print({{'dask', 'distributed'}} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"
