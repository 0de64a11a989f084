"""The process that holds the file: its number, command, host, and start.

DuckDB names the number of one process that holds a lock on the file. The rest is requested from the
system: ``/proc`` on Linux, ``ps`` elsewhere. Locks of the file system are those of this host.
"""

from __future__ import annotations

import os
import re
import socket
import subprocess
import time
from pathlib import Path

_HOLDER = re.compile(r"held in (\S+) \(PID (\d+)\)")
_LONGEST_COMMAND = 120  # Letters of a command that are shown: one or two lines of a terminal


def is_lock(error: BaseException) -> bool:
    """Whether DuckDB could not open the file because another process holds it."""
    return "Could not set lock" in str(error)


def holder_sentence(path: Path, message: str, waited: float = 0.0) -> str:
    """Return the process that holds the file, from DuckDB's message."""
    held = _HOLDER.search(message)
    who = "another process"
    if held:
        who = f"process {held[2]} ({Path(held[1]).name}){describe_process(int(held[2]))}"
    after = f" after {waited:g} s" if waited else ""
    return (
        f"{path}: expected a free database, found it held by {who}{after}. "
        "Wait until it has ended, or wait longer with --wait SECONDS."
    )


def describe_process(pid: int) -> str:
    """The command of a process, its host and when it began; empty if that is not known."""
    command, began = _from_proc(pid) or _from_ps(pid) or ("", "")
    if not command:
        return ""
    if len(command) > _LONGEST_COMMAND:
        command = f"{command[:_LONGEST_COMMAND]}..."
    return f", command `{command}`, on {socket.gethostname()} since {began}"


def _from_proc(pid: int) -> tuple[str, str] | None:
    """Command and start of a process, from Linux."""
    try:
        words = Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")
        status = Path(f"/proc/{pid}/stat").read_text(errors="replace")
        boot = re.search(r"^btime (\d+)$", Path("/proc/stat").read_text(), re.MULTILINE)
        if boot is None:
            return None
        # field 22 of stat, counted from behind the command, which may hold spaces
        ticks = int(status.rpartition(")")[2].split()[19])
        seconds = int(boot[1]) + ticks / os.sysconf("SC_CLK_TCK")
    except (OSError, ValueError, IndexError):
        return None
    command = " ".join(word.decode(errors="replace") for word in words if word)
    began = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(seconds))
    return " ".join(command.split()), began


def _from_ps(pid: int) -> tuple[str, str] | None:
    """Command and start of a process, from ``ps``."""
    try:
        answer = subprocess.run(
            ["ps", "-o", "lstart=,command=", "-p", str(pid)],
            capture_output=True,
            text=True,
            timeout=2.0,
            check=True,
        ).stdout.split()
    except (OSError, subprocess.SubprocessError):
        return None
    return (" ".join(answer[5:]), " ".join(answer[:5])) if len(answer) > 5 else None
