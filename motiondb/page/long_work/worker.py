"""The process that runs long jobs for the page.

It is started as ``python -m motiondb.page.long_work.worker DATABASE MODE``.

It reads commands from standard input, one JSON object a line: ``{"kind", "parameters"}``. It writes
events to standard output: ``{"what", "share", "error"}`` while it works, then ``{"done": result}``
or ``{"failed": message, "kind": name of the error}``. It ends when standard input is closed, so
that it does not outlive the server.
"""

from __future__ import annotations

import json
import os
import sys
import threading
import time
from pathlib import Path
from queue import Queue
from typing import Any, TextIO

from motiondb.errors import MotionDBError
from motiondb.page.answers import to_json

WAIT = 60.0
"""Seconds to wait for a process that holds the database. Chosen by hand: a job may wait, because
no user watches it."""
EVERY = 0.05
"""Seconds between two events of one step. Chosen by hand: faster changes cannot be seen."""


class Events:
    """Writes events, at most one every ``EVERY`` seconds for the same step."""

    def __init__(self, out: TextIO) -> None:
        self._out = out
        self._what, self._told = "", 0.0

    def progress(self, what: str, share: float, error: float | None = None) -> None:
        """Report the progress of a step."""
        now = time.monotonic()
        if what == self._what and now - self._told < EVERY and share < 1.0:
            return
        self._what, self._told = what, now
        self.write({"what": what, "share": share, "error": error})

    def preview(self, ref: str) -> None:
        """Report the ref of a first motion."""
        self.write({"preview": ref})

    def write(self, event: dict[str, Any]) -> None:
        """Write an event."""
        self._out.write(json.dumps(to_json(event)) + "\n")
        self._out.flush()


def _read(commands: Queue[dict[str, Any]]) -> None:
    """Queue the commands of standard input; end the process when the input ends."""
    for line in sys.stdin:
        commands.put(json.loads(line))
    os._exit(0)


def main() -> None:
    """Run commands until standard input ends."""
    database, mode = Path(sys.argv[1]), sys.argv[2]
    out = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # output of libraries must not mix with the events
    commands: Queue[dict[str, Any]] = Queue()
    threading.Thread(target=_read, args=(commands,), daemon=True).start()
    from motiondb.page.long_work.work import Workshop

    events = Events(out)
    workshop = Workshop(database, mode == "read-only", WAIT)
    while True:
        command = commands.get()
        try:
            events.write({"done": workshop.do(command["kind"], command["parameters"], events)})
        except MotionDBError as error:
            events.write({"failed": str(error), "kind": type(error).__name__})
        except MemoryError:
            events.write({"failed": "expected enough memory, found too little.", "kind": "Memory"})
        except Exception as error:  # a bug; the server must be informed
            events.write({"failed": f"{type(error).__name__}: {error}", "kind": "ProgramError"})


if __name__ == "__main__":
    main()
