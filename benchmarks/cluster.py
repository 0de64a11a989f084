"""Past one machine: what workers gain, what is sent, and what 300 hours would take on 16 of them.

    python benchmarks/cluster.py CAPTURES [--sheet SHEET] [--workers 1 2]

adds and learns the captures on this machine alone and with numbers of workers, each a process of
one thread, and prints a table: seconds by the clock, seconds that tasks computed, the share of
time in which workers did nothing, bytes of results. Then a model is checked and applied:

    T(w) = alone + computed / w

`alone` are the seconds in which no task computes: the work of the asking process, and the handing
out; `computed` are those of tasks. It is
fitted to the run with one worker, and checked by that with the most. On a machine with fewer free
processors than workers it shows overheads, not gains.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import motiondb


@dataclass
class Run:
    """What one command took."""

    what: str
    workers: int
    seconds: float  # By the clock
    own: float = 0.0  # Processor seconds of the asking process
    computed: float = 0.0  # Seconds in which workers computed, summed
    sent: float = 0.0  # Bytes of results
    tasks: int = 0

    @property
    def idle(self) -> float:
        """Share of the workers' time in which they did nothing."""
        return 1.0 - self.computed / (self.workers * self.seconds) if self.workers else 0.0


def measured(what: str, work: Callable[[], object], workers: motiondb.Cluster | None) -> Run:
    """Time a command, with the tasks that it handed out."""
    begun, own = time.perf_counter(), time.process_time()
    if workers is None:
        work()
        return Run(what, 0, time.perf_counter() - begun, time.process_time() - own)
    from distributed import get_task_stream

    with get_task_stream(workers._client) as stream:
        work()
    run = Run(what, workers.n_workers, time.perf_counter() - begun, time.process_time() - own)
    for task in stream.data:
        spans = [s for s in task["startstops"] if s["action"] == "compute"]
        run.computed += sum(s["stop"] - s["start"] for s in spans)
        run.sent += task["nbytes"]
        run.tasks += 1
    return run


def runs_with(n_workers: int, folder: Path, captures: Path, sheet: Path | None) -> list[Run]:
    """Add and learn with so many workers; 0: without a cluster."""
    path = folder / f"{n_workers}.duckdb"
    if n_workers == 0:
        return _add_and_learn(path, captures, sheet, None)
    from distributed import LocalCluster

    with (
        LocalCluster(n_workers=n_workers, threads_per_worker=1, dashboard_address=None) as started,
        motiondb.Cluster(started.scheduler_address) as workers,
    ):
        return _add_and_learn(path, captures, sheet, workers)


def _add_and_learn(
    path: Path, captures: Path, sheet: Path | None, workers: motiondb.Cluster | None
) -> list[Run]:
    settings = motiondb.AddSettings(skip_bad_frames=True)
    with motiondb.open(path) as db:
        add = measured("add", lambda: db.add(captures, sheet, settings, workers=workers), workers)
        learn = measured("learn", lambda: db.learn(workers=workers), workers)
    return [add, learn]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("captures", type=Path)
    parser.add_argument("--sheet", type=Path)
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 2])
    asked = parser.parse_args()
    columns = ["command", "workers", "clock, s", "asking process, s", "tasks", "computed, s"]
    columns += ["idle", "results, MB"]
    print(f"| {' | '.join(columns)} |\n|{' --- |' * len(columns)}")
    found: list[Run] = []
    with tempfile.TemporaryDirectory() as folder:
        for n_workers in [0, *asked.workers]:
            for run in runs_with(n_workers, Path(folder), asked.captures, asked.sheet):
                found.append(run)
                times = f"{run.seconds:.0f} | {run.own:.0f} | {run.tasks} | {run.computed:.0f}"
                sent = f"{run.idle:.0%} | {run.sent / 1e6:.0f}"
                print(f"| `{run.what}` | {run.workers or 'none'} | {times} | {sent} |", flush=True)
        with motiondb.open(Path(folder) / "0.duckdb", read_only=True) as db:
            hours = sum(info.duration for info in db.captures()) / 3600
    print(f"\n{hours:.2f} hours of motion.")
    for what in ("add", "learn"):
        one, *_, most = [run for run in found if run.what == what and run.workers]
        alone = max(one.seconds - one.computed, 0.0)  # with the handing out of tasks
        says = alone + most.computed / most.workers
        print(
            f"`{what}`: the model says {says:.0f} s for {most.workers} workers, measured "
            f"{most.seconds:.0f} s. For 300 hours on 16 workers, by the hours: "
            f"{300 / hours * (alone + one.computed / 16) / 3600:.1f} h."
        )


if __name__ == "__main__":
    main()
