"""Long work: each job runs in a separate process, which can be cancelled.

A worker (:mod:`motiondb.page.worker`) reads commands, one JSON object a line, and writes
events in the same form. Adding, learning and grammars get a new worker each, one after the other:
each changes what the next one reads. Scenes share one worker that stays alive, so that its clips
and compiled code are already loaded when the user drags a player. A job that waits for another says
so, and none holds the file while it computes. Ending a worker is always safe: the database saves a
change completely or not at all.
"""

from __future__ import annotations

import json
import re
import secrets
import subprocess
import sys
import threading
import time
from collections import OrderedDict
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any, Literal

from motiondb import answers
from motiondb.page.errors import PageError, unknown

MOST_JOBS = 100  # Largest number of jobs that are remembered
MOST_POINTS = 2000  # Largest number of points of an error curve that are remembered
# What the worker of scenes writes into the folder of a scene: the facts last
FACTS_FILE, MOTION_FILE, FIRST_FILE = "facts.json", "motion.bin", "first.bin"
SCENE_KINDS = ("scene", "scene-update")
State = Literal["waiting", "running", "done", "failed", "cancelled"]
_ENDED = ("done", "failed", "cancelled")
_RESULTS: dict[str, Callable[..., Any]] = {
    "add": answers.AddResult,
    "learn": answers.LearnResult,
    "sample": answers.LearnResult,
    "grammar": answers.GrammarLearned,
    "scene": answers.SceneMade,
    "scene-update": answers.SceneMade,
}
# Step of a kind of job -> its share of the time, measured on the sample data and on real captures
_ADD = {"reading captures": 0.6, "saving captures": 0.4}
_LEARN = {
    "features": 0.14,
    "symbols compete": 0.14,
    "cutting anew": 0.04,
    "cutting": 0.1,
    "scoring": 0.02,
    "symbol space": 0.04,
    "words": 0.5,
    "saving": 0.02,
}
_STEPS: dict[str, dict[str, float]] = {
    "add": _ADD,
    "learn": _LEARN,
    "sample": {**_ADD, **{step: 1.6 * share for step, share in _LEARN.items()}},
    "grammar": {
        "describe poses": 0.03,
        "search terminals": 0.55,
        "tune cuts": 0.12,
        "find sentences": 0.25,
        "parses": 0.05,
    },
}
_BY_TURNS = ("add",)  # Kinds whose steps go on by turns, batch after batch
LEAST_SECONDS, LEAST_SHARE = 3.0, 0.08  # Before this, the time that is left is not told
_PAUSE = 0.1  # Seconds between two looks at the job that one waits for
_PATIENCE = 5.0  # Seconds after which a worker that was asked to end is killed


@dataclass(frozen=True, kw_only=True)
class JobStep:
    """The current step of a job."""

    what: str
    share: float  # Share of the step that is done, 0 to 1
    whole: float | None  # Share of the whole job that is done; it never falls. None: not known
    left: float | None  # Seconds that are left if it goes on as fast; None: not known
    error: float | None  # -log P of the scene that is being sampled
    preview: str | None  # Ref of a first motion of a scene, before its report


@dataclass(frozen=True, kw_only=True)
class JobReply(JobStep):
    """A job: long work in a separate process."""

    id: str
    kind: str  # "add", "learn", "sample", "grammar", "scene" or "scene-update"
    title: str
    state: State
    started: float  # Seconds since 1970
    seconds: float  # Duration so far
    message: str | None  # Why it failed
    error_kind: str | None
    result: (
        answers.AddResult | answers.LearnResult | answers.GrammarLearned | answers.SceneMade | None
    )
    curve: list[tuple[float, float]]  # Share and error of a scene so far


class WholeProgress:
    """The share of a whole job that is done; it never falls."""

    def __init__(self, kind: str) -> None:
        self._steps, self._by_turns = _STEPS.get(kind, {}), kind in _BY_TURNS
        self._done: dict[str, float] = {}
        self.share: float | None = 0.0 if self._steps else None

    def tell(self, step: str, share: float) -> None:
        """Record the share of a step that is done."""
        if self.share is None or step not in self._steps:
            return
        self._done[step] = max(self._done.get(step, 0.0), share)
        if not self._by_turns:  # what stands before it is over, also what this job left out
            for earlier in list(self._steps)[: list(self._steps).index(step)]:
                self._done[earlier] = 1.0
        done = sum(self._steps[name] * part for name, part in self._done.items())
        self.share = max(self.share, min(done / sum(self._steps.values()), 1.0))

    def left(self, seconds: float) -> float | None:
        """Return the seconds that are left if it goes on as fast; None where it is too early.

        `seconds`: What it has taken so far.

        >>> progress = WholeProgress("add")
        >>> progress.tell("reading captures", 0.5)
        >>> progress.share, progress.left(6.0), progress.left(1.0)
        (0.3, 14.0, None)
        """
        if self.share is None or seconds < LEAST_SECONDS or self.share < LEAST_SHARE:
            return None
        return round(seconds * (1.0 - self.share) / self.share, 1)


class Job:
    """A piece of long work. Only :class:`Jobs` changes it."""

    def __init__(self, kind: str, title: str) -> None:
        self.job_id = f"j{secrets.token_hex(5)}"
        self.kind, self.title = kind, title
        self.state: State = "waiting"
        self.what, self.share = "", 0.0
        self.progress = WholeProgress(kind)
        self.error: float | None = None
        self.message: str | None = None
        self.error_kind: str | None = None
        self.result: Any = None
        self.preview: str | None = None
        self.curve: list[tuple[float, float]] = []
        self.started, self.ended = time.time(), 0.0
        self.version = 0
        self._lock = threading.Lock()  # several threads may end it

    @property
    def is_over(self) -> bool:
        """Whether the job is done, failed or cancelled."""
        return self.state in _ENDED

    def reply(self) -> JobReply:
        """Return the job for JSON."""
        seconds = (self.ended or time.time()) - self.started
        return answers.extended(
            JobReply,
            self,
            **vars(self.step()),
            id=self.job_id,
            started=round(self.started, 3),
            seconds=round(seconds, 3),
            curve=list(self.curve),
        )

    def step(self) -> JobStep:
        """Return the current step for JSON."""
        whole = self.progress.share
        left = None if self.is_over else self.progress.left(time.time() - self.started)
        whole = None if whole is None else round(whole, 4)
        return answers.extended(JobStep, self, share=round(self.share, 4), whole=whole, left=left)

    def tell(self, what: str, share: float, error: float | None) -> None:
        """Record the current step, the share of it that is done, and the error of a scene."""
        self.what, self.share, self.error = what, min(max(share, 0.0), 1.0), error
        self.progress.tell(what, self.share)
        if error is not None and what.startswith("sampling"):
            self.curve.append((round(self.share, 4), error))
            del self.curve[:-MOST_POINTS]
        self.version += 1

    def show(self, ref: str) -> None:
        """Record the ref of a first motion."""
        self.preview = ref
        self.version += 1

    def wait_for(self, other: str) -> None:
        """Record the title of the job that this one waits for, and wait a moment."""
        if self.what != (what := f"waits for: {other}"):
            self.what = what
            self.version += 1
        time.sleep(_PAUSE)

    def begin(self) -> bool:
        """Record that the work begins; False if the job is over, as one that was cancelled is."""
        with self._lock:
            if not self.is_over:
                self.state, self.what = "running", ""
                self.version += 1
            return not self.is_over

    def end(self, state: State, message: str | None = None, kind: str | None = None) -> None:
        """Record the final state; a later call changes nothing."""
        with self._lock:
            if not self.is_over:
                self.state, self.message, self.error_kind = state, message, kind
                self.ended = time.time()
                self.version += 1


class Worker:
    """A process that does long work, one command at a time."""

    def __init__(self, database: Path, read_only: bool, folder: Path) -> None:
        module, file = "motiondb.page.worker", str(database.absolute())
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", module, file, "read-only" if read_only else "writing"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            encoding="utf-8",
            cwd=folder,
        )
        self.turn = threading.Lock()

    @property
    def is_alive(self) -> bool:
        """Whether the process runs."""
        return self._process.poll() is None

    def run(
        self, job: Job, parameters: Mapping[str, Any], shown: Callable[[str], str] = str
    ) -> None:
        """Run a job: send the command, and record its events until it has ended."""
        stdin, stdout = self._process.stdin, self._process.stdout
        assert stdin is not None
        assert stdout is not None
        if not job.begin():
            return
        with suppress(OSError, ValueError):
            stdin.write(json.dumps({"kind": job.kind, "parameters": dict(parameters)}) + "\n")
            stdin.flush()
            _follow(job, stdout, shown)
        if not job.is_over:
            code = self._process.wait()
            job.end(
                "failed",
                f"{job.title}: expected the work to end, found that its process ended with code"
                f" {code}. What was saved before stays, nothing is half saved. Try again; there may"
                " be too little memory.",
                "WorkerError",
            )

    def stop(self) -> None:
        """End the process."""
        self._process.terminate()
        try:
            self._process.wait(_PATIENCE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        for stream in (self._process.stdin, self._process.stdout):
            if stream is not None:
                with suppress(OSError):
                    stream.close()


def _follow(job: Job, events: IO[str], shown: Callable[[str], str]) -> None:
    """Record the events of a worker until the job has ended."""
    for line in events:
        event = json.loads(line)
        if "failed" in event:
            job.end("failed", shown(event["failed"]), event["kind"])
        elif "done" in event:
            result = _RESULTS.get(job.kind, dict)  # short jobs have a plain one
            job.result, job.share = result(**event["done"]), 1.0
            job.end("done")
        elif "preview" in event:
            job.show(event["preview"])
        else:
            job.tell(event["what"], event["share"], event["error"])
        if job.is_over:
            return


class Jobs:
    """The jobs of a server."""

    def __init__(self, database: Path, read_only: bool, folder: Path) -> None:
        self._database, self._read_only, self._folder = database, read_only, folder
        self._jobs: OrderedDict[str, Job] = OrderedDict()
        self._workers: dict[str, Worker] = {}
        self._scene_worker: Worker | None = None
        self._lock = threading.Lock()
        self._closed = False

    def start(self, kind: str, title: str, parameters: Mapping[str, Any]) -> Job:
        """Start a job in a thread that follows its process, and return it."""
        job = Job(kind, title)
        with self._lock:
            self._jobs[job.job_id] = job
            self._forget()
        threading.Thread(target=self._follow, args=(job, dict(parameters)), daemon=True).start()
        return job

    def _follow(self, job: Job, parameters: Mapping[str, Any]) -> None:
        """Run a job after those of its kind that were started before it."""
        is_scene = job.kind in SCENE_KINDS
        while not (job.is_over or self._closed):
            left = [each for each in reversed(self.all()) if not each.is_over]
            first = next((each for each in left if (each.kind in SCENE_KINDS) == is_scene), job)
            if first is job:
                (self._run_scene if is_scene else self._run_alone)(job, parameters)
                return
            job.wait_for(first.title)

    def ask_scene_worker(self, kind: str, title: str, parameters: Mapping[str, Any]) -> Any:  # noqa: ANN401
        """Run a short job in the worker of scenes, or alone if that is busy; its result."""
        job, worker = Job(kind, title), self._scene_worker
        is_busy = worker is not None and worker.turn.locked()
        (self._run_alone if is_busy else self._run_scene)(job, parameters)
        if job.state != "done":
            status = 503 if job.error_kind == "HeldError" else 400
            raise PageError(job.message or "cancelled", job.error_kind or "WorkerError", status)
        return job.result

    def get(self, job_id: str) -> Job:
        """Return a job."""
        with self._lock:
            if job_id not in self._jobs:
                raise unknown("job", job_id)
            return self._jobs[job_id]

    def all(self) -> list[Job]:
        """Return the jobs, newest first."""
        with self._lock:
            return list(reversed(self._jobs.values()))

    def cancel(self, job_id: str) -> Job:
        """Cancel a job; a job that has ended does not change."""
        job = self.get(job_id)
        job.end("cancelled", "cancelled: what was saved before stays, nothing is half saved")
        with self._lock:
            worker = self._workers.pop(job_id, None)
            if worker is not None and worker is self._scene_worker:
                self._scene_worker = None
        if worker is not None:
            worker.stop()
        return job

    def drop_waiting(self, kind: str) -> None:
        """Cancel the waiting jobs of a kind; the running one continues.

        Ending the process would lose the clips and the compiled code that make the next job fast.
        """
        for job in self.all():
            if job.kind == kind and job.state == "waiting":
                job.end("cancelled", "a newer one took its place")

    def close(self) -> None:
        """End all processes."""
        self._closed = True
        for job in self.all():
            if not job.is_over:
                self.cancel(job.job_id)
        with self._lock:
            worker, self._scene_worker = self._scene_worker, None
        if worker is not None:
            worker.stop()

    def _run_alone(self, job: Job, parameters: Mapping[str, Any]) -> None:
        worker = Worker(self._database, self._read_only, self._folder)
        try:
            if not self._closed:
                self._run_by(worker, job, parameters)
        finally:
            worker.stop()

    def _run_by(self, worker: Worker, job: Job, parameters: Mapping[str, Any]) -> None:
        """Run a job by a worker, which is ended if the job is cancelled meanwhile."""
        with self._lock:
            self._workers[job.job_id] = worker
        try:
            if not job.is_over:
                worker.run(job, parameters, self._shown)
        finally:
            with self._lock:
                self._workers.pop(job.job_id, None)

    def _run_scene(self, job: Job, parameters: Mapping[str, Any]) -> None:
        while not job.is_over and not self._closed:
            with self._lock:
                if self._scene_worker is None or not self._scene_worker.is_alive:
                    self._scene_worker = Worker(self._database, self._read_only, self._folder)
                worker = self._scene_worker
            with worker.turn:
                if not worker.is_alive:  # cancelled while this job waited
                    continue
                self._run_by(worker, job, parameters)
            return

    def _shown(self, message: str) -> str:
        """Return a message without the server's private folder."""
        private = re.escape(str(self._folder.parent))
        return re.sub(rf"{private}/(?:[^/\s:]+/)*", "", message)

    def _forget(self) -> None:
        """Forget the oldest jobs that are over, if there are too many."""
        over = [name for name, job in self._jobs.items() if job.is_over]
        for name in over[: max(len(self._jobs) - MOST_JOBS, 0)]:
            del self._jobs[name]
