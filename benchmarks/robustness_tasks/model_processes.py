"""The processes that a chain of steps drives: two that use the class, and the server.

They part from this process, in which motiondb is imported. Requests and answers pass through a
socket, so that a fault that is injected into ``write`` meets files only. Faults are injected into
system calls by ``strace`` where it is installed: the process is killed at one, or the disk is full
from one on. Elsewhere a limit on the size of files does this, which meets writes only: the system
ends a process that exceeds it, or refuses to write, as the process chooses.
"""

from __future__ import annotations

import contextlib
import http.client
import json
import multiprocessing
import os
import pickle
import select
import shutil
import signal
import socket
import stat
import struct
import subprocess
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from datetime import datetime, timedelta, tzinfo
from multiprocessing.process import BaseProcess
from pathlib import Path
from types import MappingProxyType
from typing import Any
from urllib.parse import urlencode

import psutil
from rights import as_others

from motiondb.errors import MotionDBError
from motiondb.files.processes import end_with_parent
from motiondb.store.connection import opening
from robustness_tasks.model_verbs import DB, Hand
from robustness_tasks.plain_model import DONE, REFUSED, UNKNOWN
from robustness_tasks.plain_world import Arguments

STRACE = shutil.which("strace")
PATIENCE = 300.0
"""Seconds after which an answer counts as missing, on a computer that does other work too."""
WRITES = "write,pwrite64,pwritev,fallocate,ftruncate"
CALLS = MappingProxyType(
    {
        "write": 2, "fdatasync": 4, "pwrite64": 12, "ftruncate": 1, "openat": 4, "rename": 1,
        "unlink": 2, "close": 4, "fcntl": 2, "pread64": 4, "futex": 80, "sendto": 1,
    }
)  # fmt: skip
"""System calls at which a process is killed, and how often a change of words makes them."""


CLOSED = (
    ((DB, 0o000),), ((DB, 0o444),), ((DB, 0o444), (".", 0o555)), ((".", 0o555),), ((".", 0o000),),
    ((f"{DB}.cache", 0o000),), ((f"{DB}.cache", 0o555),), (("out", 0o555),), (("given", 0o000),),
)  # fmt: skip
"""Rights that are taken away for a step: places below the folder, and what is left."""


@dataclass(frozen=True)
class Harm:
    """What goes wrong during a step.

    ``kind`` is "", "kill", "late kill", "full disk", "clock" or "rights". ``call`` and ``count``
    say at which system call, ``room`` how many bytes can still be written where ``strace`` is
    missing, ``seconds`` how far the clock jumps, ``closed`` what has which rights, as on the
    computer of somebody else.
    """

    kind: str = ""
    call: str = ""
    count: int = 0
    room: int = 0
    seconds: float = 0.0
    closed: tuple[tuple[str, int], ...] = ()

    @property
    def inject(self) -> str:
        """The option of ``strace``; "" where nothing is injected."""
        if self.kind == "kill":
            return f"{self.call}:signal=KILL:when={self.count}"
        return f"{WRITES}:error=ENOSPC:when={self.count}+" if self.kind == "full disk" else ""


@dataclass(frozen=True)
class Answer:
    """How a verb ended: done with facts, refused with a message, or unknown; and faults."""

    ended: str
    facts: Mapping[str, Any] = field(default_factory=dict)
    message: str = ""
    faults: tuple[str, ...] = ()


class Tracer:
    """``strace`` on a running process, with a fault to inject."""

    def __init__(self, process: int, inject: str) -> None:
        assert STRACE is not None
        calls = inject.partition(":")[0]
        self._strace = subprocess.Popen(
            [STRACE, "-f", "-o", "/dev/null", "-e", f"trace={calls}", "-e", f"inject={inject}",
             "-p", str(process)],
            stderr=subprocess.PIPE, text=True,
        )  # fmt: skip
        assert self._strace.stderr is not None
        self._strace.stderr.readline()  # "Process N attached"

    def end(self, *, is_killed: bool) -> None:
        """Leave the process alone; one that was killed needs no care."""
        if is_killed:
            self._strace.kill()  # it would wait for threads of the process
        else:
            self._strace.terminate()
        self._strace.communicate()


class Worker:
    """A process that uses the class; it is started again where it was killed."""

    def __init__(self, name: str, place: Path, material: Path, threads: int) -> None:
        self.name, self.place, self._material, self._threads = name, place, material, threads
        self._process: BaseProcess | None = None
        self._tracer: Tracer | None = None

    def begin(self, request: str, given: Arguments, then: str = "", harm: Harm = Harm()) -> None:
        """Send a request; ``then``: whether to "lend" or "close" the database afterwards."""
        if self._process is None:
            self._start()
        assert self._process is not None
        if harm.inject and STRACE:
            self._tracer = Tracer(self._process.pid or 0, harm.inject)
        _send(self._socket, (request, dict(given), then, harm))

    def end(self, harm: Harm = Harm()) -> Answer:
        """Wait for the answer; a killed process has none."""
        assert self._process is not None
        watched: list[Any] = [self._socket, self._process.sentinel]
        ready, _, _ = select.select(watched, [], [], PATIENCE)
        answer = Answer(UNKNOWN, faults=() if ready else (f"no answer after {PATIENCE:g} s",))
        with contextlib.suppress(EOFError, ConnectionError):
            if self._socket in ready:
                answer = Answer(*_receive(self._socket))
        has_ended = answer.ended == UNKNOWN
        is_killed = has_ended or harm.kind in ("kill", "late kill")
        if self._tracer is not None:
            self._tracer.end(is_killed=is_killed)
            self._tracer = None
        if is_killed:
            code = self.kill()
            died = -code in (signal.SIGKILL, getattr(signal, "SIGXFSZ", 0))
            if has_ended and not (died and harm.kind == "kill"):
                return Answer(UNKNOWN, faults=(*answer.faults, f"the process ended with {code}"))
        return answer

    def do(self, request: str, given: Arguments = MappingProxyType({}), then: str = "") -> Answer:
        """A request that nothing disturbs."""
        self.begin(request, given, then)
        return self.end()

    def kill(self) -> int:
        """Kill the process, if it runs; its exit code."""
        if self._process is None:
            return 0
        self._process.kill()
        self._process.join()
        code = self._process.exitcode or 0
        self._socket.close()
        self._process = None
        return code

    def _start(self) -> None:
        self._socket, theirs = socket.socketpair()
        target = (theirs, self.place, self._material, self._threads)
        self._process = multiprocessing.get_context("fork").Process(target=_work, args=target)
        self._process.start()
        theirs.close()


def _send(to: socket.socket, value: object) -> None:
    data = pickle.dumps(value)
    to.sendall(struct.pack("!I", len(data)) + data)


def _receive(of: socket.socket) -> Any:
    data = b""
    length = 4
    while len(data) < length:
        part = of.recv(65536)
        if not part:
            raise EOFError
        data += part
        if len(data) >= 4:
            length = 4 + struct.unpack("!I", data[:4])[0]
    return pickle.loads(data[4:])


def _part(place: Path, threads: int) -> None:
    """Be another process: own temporary files, nothing printed, an end with the parent."""
    end_with_parent(os.getppid(), True)
    opening._CONFIG["threads"] = threads
    os.environ["TMPDIR"] = str(place / "tmp")
    tempfile.tempdir = None
    null = os.open(os.devnull, os.O_RDWR)
    for number in (0, 1, 2):
        os.dup2(null, number)


def _work(requests: socket.socket, place: Path, material: Path, threads: int) -> None:
    """Do what is asked for, until the other side ends."""
    _part(place, threads)
    hand = Hand(place, material)
    with contextlib.suppress(EOFError, ConnectionError):
        while True:
            request, given, then, harm = _receive(requests)
            try:
                answer = _answer(hand, request, given, then, harm)
            except BaseException:
                answer = (REFUSED, {}, "", (f"a fault outside: {traceback.format_exc()}",))
            _send(requests, answer)
    os._exit(0)


def _answer(hand: Hand, request: str, given: Arguments, then: str, harm: Harm) -> tuple[Any, ...]:
    """How a request ended, as the fields of an :class:`Answer`."""
    facts: Mapping[str, Any] = {}
    ended, message, faults = DONE, "", []
    if harm.kind == "clock":
        jump(harm.seconds)
    with _limited(harm, hand.place), _closed(harm, hand.place):
        try:
            if request == "begin":
                facts = hand.begun()
            elif request == "look":
                facts = hand.look(thorough=given["thorough"])
            elif request != "rest":
                facts = hand.do(request, given)
        except MotionDBError as error:
            ended, message = REFUSED, f"{type(error).__name__}: {error}"
        except Exception:
            ended, message = REFUSED, traceback.format_exc(limit=-4)
            faults.append(f"an error that is not the project's: {message}")
        try:
            if then == "close":
                hand.close()
            elif then == "lend":
                hand.lend()
        except MotionDBError as error:
            faults += [] if harm.kind in ("full disk", "rights") else [f"closing: {error}"]
        except Exception:
            faults.append(f"closing: {traceback.format_exc(limit=-4)}")
    return ended, facts, message, tuple(faults)


@contextlib.contextmanager
def _limited(harm: Harm, place: Path) -> Any:
    """A limit on the size of files, in place of ``strace``."""
    if not harm.inject or STRACE:
        yield
        return
    import resource

    sizes = [path.stat().st_size for path in place.glob(f"{DB}*") if path.is_file()]
    sizes = sizes if harm.count % 2 else [0]  # the log begins anew, the file goes on
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    usual = signal.getsignal(signal.SIGXFSZ)
    signal.signal(signal.SIGXFSZ, signal.SIG_DFL if harm.kind == "kill" else signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_FSIZE, (max([0, *sizes]) + harm.room, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, usual)


@contextlib.contextmanager
def _closed(harm: Harm, place: Path) -> Any:
    """Take rights away."""
    paths = [(place / name, mode) for name, mode in harm.closed if (place / name).exists()]
    if not paths:
        yield
        return
    before = [(path, stat.S_IMODE(path.stat().st_mode)) for path, _ in paths]
    for path, mode in paths:
        path.chmod(mode)
    try:
        with as_others():
            yield
    finally:
        for path, mode in before:
            if path.exists():
                path.chmod(mode)


_TIME = time.time


def jump(seconds: float) -> None:
    """Let the clock of this process be wrong by some seconds."""
    from motiondb.store.catalogue import runs

    class Wrong(datetime):
        """The time with the jump."""

        @classmethod
        def now(cls, tz: tzinfo | None = None) -> datetime:  # type: ignore[override]
            """The wrong time."""
            return datetime.now(tz) + timedelta(seconds=seconds)

    time.time = lambda: _TIME() + seconds
    runs.datetime = Wrong  # type: ignore[misc]


class Server:
    """``motiondb serve`` in a process of its own, asked over the loopback address."""

    name = "server"

    def __init__(self, place: Path, threads: int) -> None:
        self.place, self._threads = place, threads
        self._process: BaseProcess | None = None
        self._port = 0

    @property
    def runs(self) -> bool:
        """Whether it was started and not killed."""
        return self._process is not None

    def do(self, verb: str, given: Arguments, harm: Harm = Harm()) -> Answer:
        """Do a verb by requests, disturbed or not; where the server dies, it is unknown."""
        if self._process is None:
            self._start()
        assert self._process is not None
        process = psutil.Process(self._process.pid)
        inject = harm.inject if STRACE else ""
        tracer = Tracer(process.pid, inject) if inject else None
        children: list[psutil.Process] = []
        try:
            answer = self._requested(verb, given, process, children)
        except (OSError, http.client.HTTPException) as error:
            answer = Answer(UNKNOWN, message=repr(error))
        if tracer is not None:
            tracer.end(is_killed=harm.kind == "kill" or answer.ended == UNKNOWN)
        if harm.kind in ("kill", "late kill"):
            answer = Answer(answer.ended, answer.facts, answer.message,
                            (*answer.faults, *self.kill(children)))  # fmt: skip
        elif answer.ended == UNKNOWN:
            faults = (f"the server gave no answer: {answer.message}", *self.kill(children))
            return Answer(UNKNOWN, faults=faults)
        return answer

    def _requested(
        self, verb: str, given: Arguments, process: psutil.Process, children: list[psutil.Process]
    ) -> Answer:
        if verb in EDITS:
            status, shown = self.request(
                "GET", f"/api/grammar?{urlencode({'name': given['name']})}", None
            )
            if status >= 400:
                return Answer(REFUSED, message=str(shown))
            given = {
                **given,
                "run": shown["run"],
                "terminals": [t["terminal"] for t in shown["terminals"]],
            }
        method, path, body = REQUESTS[verb](given)
        status, facts = self.request(method, path, body)
        while status in (200, 202) and (job := facts.get("id")) and "state" in facts:
            children[:] = process.children(recursive=True)
            if facts["state"] not in ("waiting", "running"):
                break
            time.sleep(0.05)
            status, facts = self.request("GET", f"/api/jobs/{job}", None)
        if facts.get("error_kind") == "WorkerError":  # the fault met the process of the work
            return Answer(UNKNOWN, message=str(facts["message"]))
        if "state" in facts and facts["state"] != "done":
            raw = facts["error_kind"] == "ProgramError"
            return Answer(REFUSED, message=str(facts["message"]),
                          faults=(f"job: {facts['message']}",) if raw else ())  # fmt: skip
        if status == 200 and verb in SECOND:
            ref = str(facts.get("id") or facts["variants"][0]["id"])
            status, facts = self.request("POST", SECOND[verb], {"id": ref, "name": given["name"]})
        if status >= 400:
            message = str(facts.get("error", facts))
            if "WorkerError" in message:
                return Answer(UNKNOWN, message=message)
            faults = (f"status {status}: {message}",) if status >= 500 else ()
            return Answer(REFUSED, message=message, faults=faults)
        return Answer(DONE, _told(verb, facts))

    def request(self, method: str, path: str, body: object) -> tuple[int, dict[str, Any]]:
        """Status and JSON of an answer."""
        connection = http.client.HTTPConnection("127.0.0.1", self._port, timeout=PATIENCE)
        data = None if body is None else json.dumps(body)
        headers = {} if body is None else {"Content-Type": "application/json"}
        connection.request(method, path, data, headers)
        reply = connection.getresponse()
        text = reply.read()
        connection.close()
        return reply.status, json.loads(text)

    def kill(self, children: list[psutil.Process] | None = None) -> list[str]:
        """Kill the server; its processes must then end by themselves."""
        if self._process is None:
            return []
        with contextlib.suppress(psutil.Error):
            children = [*(children or []), *psutil.Process(self._process.pid).children(True)]
        self._process.kill()
        self._process.join()
        self._process = None
        _, alive = psutil.wait_procs(children or [], timeout=60.0)
        for each in alive:
            each.kill()
        return [f"a process of the server goes on: {each.pid}" for each in alive]

    def _start(self) -> None:
        here, there = multiprocessing.get_context("fork").Pipe()
        self._process = multiprocessing.get_context("fork").Process(
            target=_serve, args=(self.place, there, self._threads)
        )
        self._process.start()
        there.close()
        self._port = int(here.recv().rstrip("/").rpartition(":")[2])
        here.close()


def _serve(place: Path, told: Any, threads: int) -> None:
    from motiondb.page.serve import serve
    from motiondb.page.settings import PageSettings

    _part(place, threads)
    sys.stdout = sys.stderr = open(os.devnull, "w")  # noqa: SIM115, PTH123
    settings = PageSettings(place / DB, port=0, folders=(place / "given",), wait=60.0, warm=False)
    serve(settings, told.send, lambda _warning: None, open_browser=False)


def _rename_terminal(given: Arguments) -> tuple[str, str, object]:
    terminal = given["terminals"][given["which"] % len(given["terminals"])]
    told = {"grammar": given["name"], "run": given["run"], "terminal": terminal, "to": given["to"]}
    return "PUT", "/api/grammar/terminal", told


def _captions(given: Arguments) -> list[dict[str, Any]]:
    return [dict(zip(("words", "start", "end"), words)) for words in given["captions"]]


def _below(path: str | None) -> str | None:
    """A path below the folder that the server may add from."""
    return None if path is None else path.removeprefix("given/")


def _add(given: Arguments) -> tuple[str, str, object]:
    folder = {"root": 0, "path": _below(given["folder"])}
    return "POST", "/api/add", {"folder": folder, "words": _below(given["words"])}


REQUESTS: Mapping[str, Callable[[Arguments], tuple[str, str, object]]] = MappingProxyType(
    {
        "add": _add,
        "remove": lambda g: ("DELETE", f"/api/capture?{urlencode({'name': g['names'][0]})}", None),
        "set words": lambda g: (
            "POST", "/api/words",
            {"capture": g["name"], **{k: g[k] for k in ("words", "start", "end", "keep")}},
        ),
        "set captions": lambda g: (
            "PUT", "/api/captions", {"capture": g["name"], "words": _captions(g)}
        ),
        "add words": lambda g: (
            "POST", "/api/captures/words", {"captures": g["names"], "words": g["words"]}
        ),
        "set tags": lambda g: (
            "POST", "/api/captures/tags", {"captures": g["names"], "tags": g["tags"]}
        ),
        "rename": lambda g: (
            "POST", "/api/captures/rename", {"old": g["old"], "new": g["new"]}
        ),
        "rename terminal": _rename_terminal,
        "undo edit": lambda g: (
            "POST", "/api/grammar/undo", {"grammar": g["name"], "run": g["run"]}
        ),
        "undo": lambda _g: ("POST", "/api/undo", None),
        "learn": lambda g: ("POST", "/api/learn", {"symbols": g["symbols"], "seed": g["seed"]}),
        "save generated": lambda g: (
            "POST", "/api/generate", {"words": g["words"], "seed": g["seed"]}
        ),
        "remove grammar": lambda g: (
            "DELETE", f"/api/grammar?{urlencode({'name': g['name']})}", None
        ),
        "save sequence": lambda g: (
            "POST", "/api/sequences", {"grammar": g["grammar"], "seed": g["seed"]}
        ),
        "list": lambda _g: ("GET", "/api/captures?limit=1000&sort=-name", None),
        "show": lambda g: ("GET", f"/api/capture?{urlencode({'name': g['name']})}", None),
        "ask": lambda g: ("GET", f"/api/search?{urlencode({'q': g['words']})}", None),
    }
)  # fmt: skip
"""Verb -> method, path and body of its first request."""
EDITS = frozenset({"rename terminal", "undo edit"})
"""Verbs that need to know the version of a grammar."""
SECOND = MappingProxyType({"save generated": "/api/made/save",
                           "save sequence": "/api/sequences/save"})  # fmt: skip
"""Verb -> where what the first request made is saved."""


def _told(verb: str, facts: Mapping[str, Any]) -> dict[str, Any]:
    """What the model looks at in an answer."""
    if verb == "list":
        names = [row["name"] for row in facts["captures"]]
        return {"names": sorted(names), "browsed": names}
    return {"removed": facts["removed"]} if verb == "remove" else {}
