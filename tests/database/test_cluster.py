"""A cluster: the answers of one machine, whatever happens to its workers."""

from __future__ import annotations

import datetime
import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import duckdb
import pytest
from distributed.comm import CommClosedError

import motiondb
from motiondb import Cluster, ClusterError, LearnSettings, Question
from motiondb.database import cluster

NOT_THE_SAME = ("run", "meta", "learning")  # Tables with times and random marks


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


@pytest.fixture
def processes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Processes]:
    import dask.config
    import distributed  # noqa: F401  its defaults, before some are set for a while

    settings = certificate(tmp_path)
    place = tmp_path / "scheduler.json"
    in_env = {
        f"DASK_{k.replace('.', '__').replace('-', '_').upper()}": settings[k] for k in settings
    }
    env, common = os.environ | in_env, ["--scheduler-file", str(place), "--protocol", "tls"]

    def start(what: str, *options: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", f"distributed.cli.dask_{what}", *common, *options]
        return subprocess.Popen(
            [*command, "--no-dashboard"], env=env, cwd=tmp_path, stderr=subprocess.DEVNULL
        )

    running = [start("scheduler", "--host", "127.0.0.1", "--port", "0")]
    running += [start("worker", "--nthreads", "1", "--no-nanny") for _ in range(2)]
    with dask.config.set(settings):
        while not place.exists():
            assert running[0].poll() is None
            time.sleep(0.1)
        yield Processes(json.loads(place.read_text())["address"], running[0], running[1:])
    for process in running:
        process.kill()
        process.wait()


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


def test_workers_and_their_deaths_change_no_bit(
    some: Path, tmp_path: Path, processes: Processes, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster, "_LEAST", 1e-4)  # all is divided, and sent
    monkeypatch.setattr(cluster, "_SMALL", 1000)
    settings = LearnSettings(n_symbols=3)
    with motiondb.open(tmp_path / "alone.duckdb") as db:
        db.add(some)
        db.learn(settings)
    with (
        Cluster(processes.address) as workers,
        motiondb.open(tmp_path / "two.duckdb") as db,
    ):
        assert processes.address.startswith("tls://")
        assert (workers.n_workers, workers.warning) == (2, "")
        db.add(some, workers=workers)
        db.learn(settings, kills(processes.workers[0], "symbols compete"), workers=workers)
        assert workers.n_workers == 1
        questions = [Question("walk"), Question(like="ana/walk_1", limit=2), Question("walk then")]
        here, there = db.ask_many(questions), db.ask_many(questions, workers)
        assert list(map(repr, here)) == list(map(repr, there))
    assert rows(tmp_path / "two.duckdb") == rows(tmp_path / "alone.duckdb")
    with (
        Cluster(processes.address) as workers,
        motiondb.open(tmp_path / "none.duckdb") as db,
        pytest.raises(ClusterError, match="expected the scheduler to stay until the work is done"),
    ):
        db.add(some, progress=kills(processes.scheduler, "reading captures"), workers=workers)
    with motiondb.open(tmp_path / "none.duckdb") as db:
        assert db.captures() == []


@pytest.mark.parametrize("lost", [CancelledError, CommClosedError])
def test_a_result_whose_connection_ends_is_asked_for_again_while_there_is_a_scheduler(
    lost: type[Exception],
) -> None:
    client = SimpleNamespace(status="running", submit=lambda *_, **__: answering(lambda: 7))
    workers = object.__new__(Cluster)
    workers.address, workers._client = "tcp://w:1", client

    def fails() -> None:
        raise lost("Stream is closed")

    job: cluster._Job[int] = cluster._Job(int, (), None)
    assert workers._result(job, "7", answering(fails)) == 7
    client.status = "closed"
    with pytest.raises(ClusterError, match=r"^tcp://w:1: .* went away \(Stream is closed\)\."):
        workers._result(job, "7", answering(fails))


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
