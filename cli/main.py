"""The Typer app; errors become messages and exit codes here."""

from __future__ import annotations

import errno
import gc
import math
import os
import signal
import sys
from contextvars import copy_context
from importlib import import_module
from typing import Annotated, NoReturn

import typer

import motiondb
from motiondb.cli import options, printing

COMMANDS = {
    "cataloguing": ("add", "show", "export", "joints", "fetch"),
    "selections": ("selections",),
    "archive": ("list", "sql", "remove", "undo", "rename", "merge", "backup", "tags"),
    "learning": ("learn", "demo", "evaluate", "symbols"),
    "curation": ("quality", "curate", "coverage", "diff"),
    "search": ("search", "like", "along", "rhythm", "describe", "compare"),
    "batch": ("batch",),
    "generation": ("generate", "judge", "join"),
    "words": ("words", "events"),
    "keeping": ("check", "rescue", "info", "compact", "knowledge"),
    "grammars": ("grammar",),
    "scenes": ("scene",),
    "serving": ("serve", "mcp"),
}
"""Module -> its commands and groups. A command's module alone is loaded: all take .1 s."""


def make_app(name: str = "") -> options.Commands:
    """The app with the command or group of a name alone, or with all where there is none."""
    app = options.Commands(
        name="motiondb",
        cls=options.Group,
        help="A motion-capture database that understands what is in it.",
        no_args_is_help=True,
        context_settings={"help_option_names": ["-h", "--help"]},
        rich_markup_mode=None,
        pretty_exceptions_enable=False,
    )
    app.callback()(_options)
    for module in [each for each, names in COMMANDS.items() if name in names] or COMMANDS:
        app.include(import_module(f"motiondb.cli.{module}").app)
    return app.only(name)


def _version(wanted: bool) -> None:
    if wanted:
        printing.say(f"motiondb {motiondb.__version__}")
        raise typer.Exit()


def _options(
    version: Annotated[
        bool, options.option("Print the version.", callback=_version, is_eager=True)
    ] = False,
) -> None:
    pass


INTERRUPTED = 130
_NO_OUTPUT = (errno.ENOSPC, errno.EBADF, errno.EIO, errno.EFBIG, errno.EDQUOT)
"""Errors of the system when standard output cannot be written; Typer handles a closed pipe."""


_SPINNING = "20"
"""Power of 2 of the processor cycles that idle threads of OpenBLAS wait busily, .4 ms; by default
they waste 60 ms of processor time at every start, and a third of what interleaved products take."""


def main() -> None:
    """Run the command line: 0 done, 1 wrong data, 2 wrong use, 130 interrupted."""
    os.environ.setdefault("OPENBLAS_THREAD_TIMEOUT", _SPINNING)  # read when numpy is imported
    gc.set_threshold(10_000)  # new objects; looking for cycles at every 700 took .03 s of imports
    before = sys.unraisablehook, signal.getsignal(signal.SIGINT)
    sys.unraisablehook = _end_lost_interrupt
    if before[1] is signal.default_int_handler:
        signal.signal(signal.SIGINT, _interrupt)
    printing.accept_any_text()
    try:
        sys.exit(copy_context().run(_run))  # whatever a command sets ends with it
    except KeyboardInterrupt:  # while ending or importing
        _end_interrupted()
    finally:
        sys.unraisablehook = before[0]
        signal.signal(signal.SIGINT, before[1])


_MEMORY = "Out of Memory", "failed to map segment", "can't start new thread", "allocate memory"
"""What libraries say where Python would raise a MemoryError."""


_LEAST_MEMORY = 1_000_000_000
"""Bytes of address space below which libraries were seen to end without a word (SIGSEGV)."""


def _run() -> int:
    if (limit := _memory_limit()) < _LEAST_MEMORY:
        printing.warn(
            f"error: memory: expected a limit of at least {_LEAST_MEMORY / 1e6:,.0f} MB, found "
            f"{limit / 1e6:,.0f} MB. Allow more (ulimit -v)."
        )
        return 1
    try:
        _run_command()
    except Exception as error:
        if _is_memory_short(error):
            printing.warn(
                "error: memory: expected enough for this command, found that it ran out. Nothing "
                "is half written. Close other programs, allow more (ulimit -v), or do it in "
                "smaller parts, such as fewer captures or --jobs 1."
            )
            return 1
        if isinstance(error, motiondb.MotionDBError):
            _tell(error)
            return 2 if isinstance(error, motiondb.QueryError | motiondb.NotLearnedError) else 1
        if (
            not isinstance(error, OSError)
            or error.filename is not None
            or error.errno not in _NO_OUTPUT
        ):
            raise
        reason = (error.strerror or "an error").lower()
        printing.warn(f"error: output: expected to write all of it, found: {reason}.")
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # Python flushes it when it ends
        return 1
    return 0


def _memory_limit() -> float:
    """Bytes of address space that this process may take, as ``ulimit -v`` limits it."""
    try:
        import resource
    except ImportError:  # Windows
        return math.inf
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    return math.inf if limit == resource.RLIM_INFINITY else limit


def _is_memory_short(error: BaseException | None) -> bool:
    """Whether an error, or one that it follows from, is that memory ran out."""
    if error is None:
        return False
    found = isinstance(error, MemoryError) or any(said in str(error) for said in _MEMORY)
    return found or _is_memory_short(error.__context__)


def _tell(error: Exception) -> None:
    """Print the message of an error, even if a file name in it is not valid text."""
    text = f"error: {error}".encode("utf-8", "backslashreplace").decode()
    printing.warn(*text.split("\n"))


def _run_command() -> None:
    """Run the command; errors after Ctrl-C are treated as interrupts.

    DuckDB turns an interrupt into one of its own errors, and Typer into the exit code 130.
    """
    try:
        make_app(sys.argv[1] if len(sys.argv) > 1 else "")()
    except BaseException as ended:
        if _interrupts and not (isinstance(ended, SystemExit) and not ended.code):
            _end_interrupted()
        raise


_interrupts: list[int] = []


def _interrupt(number: int, _frame: object) -> NoReturn:
    _interrupts.append(number)
    raise KeyboardInterrupt


def _end_lost_interrupt(lost: sys.UnraisableHookArgs) -> None:
    """End at once if Ctrl-C interrupts a callback of a C library, which cannot pass it on.

    The database is safe: a process may stop at any moment.
    """
    if not issubclass(lost.exc_type, KeyboardInterrupt):
        sys.__unraisablehook__(lost)
        return
    _end_interrupted()


def _end_interrupted() -> NoReturn:
    """Print a message and end at once, so that threads do not outlive their data."""
    if motiondb.changes_saved():
        printing.warn("interrupted: complete changes up to then are saved, and nothing else")
    else:
        printing.warn("interrupted: the database is unchanged")
    sys.stdout.flush()
    os._exit(INTERRUPTED)
