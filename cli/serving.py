"""Commands serve and mcp: the page in the browser, and the commands as tools for programs.

The tools follow the Model Context Protocol, over standard streams. One message of JSON-RPC 2.0 a
line. A thread reads them and answers at once what takes no time. Calls are queued, and run one
after the other on the main thread, where a cancelled one is interrupted. Standard output holds
messages alone: what else prints goes to standard error.

Source: the Model Context Protocol, revisions 2024-11-05 to 2025-11-25 (modelcontextprotocol.io).
"""

from __future__ import annotations

import _thread
import json
import os
import queue
import signal
import sys
import tempfile
import threading
import traceback
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any, BinaryIO

import motiondb
from motiondb.cli import options, printing
from motiondb.cli.tools import MOST_LETTERS, ToolError, Tools, shortened, working_in

app = options.Commands()


@app.command()
def serve(
    shared: options.Shared,
    host: Annotated[
        str, "Address to listen at; other computers need the token that is printed."
    ] = "127.0.0.1",
    port: Annotated[
        int, options.option("Port to listen at; 0 for a free one.", min=0, max=65_535)
    ] = 8765,
    read_only: Annotated[bool, "The page cannot change anything."] = False,
    folders: Annotated[
        list[Path] | None,
        options.option(
            "A folder from which the page may add captures; may be repeated.", "--folder"
        ),
    ] = None,
    boards: Annotated[
        Path | None, "Folder of your tactics diagrams.  [default: boards, by the database]"
    ] = None,
    names: Annotated[
        list[str] | None,
        options.option(
            "A further name by which browsers reach this computer; may be repeated.", "--name"
        ),
    ] = None,
    token: Annotated[
        bool, "Require the token that is printed also from this computer, where others use it."
    ] = False,
    open_browser: Annotated[
        bool, options.option("Whether to open the page in the browser.", "--open/--no-open")
    ] = True,
) -> None:
    """Serve the page: the database in the browser, until Ctrl-C.

    The database is held only while a request is answered, so commands work beside it.
    """
    settings = motiondb.PageSettings(
        shared.db,
        host,
        port,
        read_only,
        folders=tuple(folders or ()),
        boards=boards,
        wait=shared.wait,
        allowed_hosts=tuple(names or ()),
        always_token=token,
    )

    def told(address: str) -> None:
        if not printing.as_json(shared, {"address": address}):
            printing.say(f"The page is at {address}  (Ctrl-C ends it)")

    try:
        motiondb.serve(settings, told, lambda text: printing.warn(f"note: {text}"), open_browser)
    except SystemExit as ended:  # by a signal; a question may still be computed, for minutes
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(int(ended.code or 0))


VERSIONS = ("2025-11-25", "2025-06-18", "2024-11-05")
"""Revisions of the protocol, the newest first. That of 2025-03-26 is left out: it has batches."""
STRUCTURED = "2025-06-18"  # The first revision whose answers have structured content
LONGEST_LINE = 4_000_000  # Bytes of a message
PARSE, INVALID, NO_METHOD, PARAMETERS = -32700, -32600, -32601, -32602  # Errors of JSON-RPC
Message = dict[str, Any]


@app.command()
def mcp(
    shared: options.Shared,
    folders: Annotated[
        list[Path] | None,
        options.option(
            "A folder whose files may be read, and written with --write; may be repeated. Names "
            "of files are taken from the first.",
            "--folder",
        ),
    ] = None,
    write: Annotated[bool, "Also change the database, and write files below the folders."] = False,
) -> None:
    """Serve the commands as tools of the Model Context Protocol, until standard input ends.

    Programs such as assistants start this command and talk to it over standard input and output.
    They read the database, and with --write change it. Files are read and written below the
    folders that are named, and nowhere else.
    """
    for folder in folders or ():
        if not folder.is_dir():
            raise motiondb.QueryError(f"{folder}: expected a folder. Name one that there is.")
    within = tuple(Path(os.path.realpath(folder)) for folder in folders or ())
    tools = Tools(shared.db.absolute(), within, write, shared.wait)
    reading, writing = _own_streams()
    with (
        tempfile.TemporaryDirectory() as empty,
        working_in(within[0] if within else Path(empty)),
        options.keeping_open() as forget,
    ):
        Server(tools, writing, forget).run(reading)


def _own_streams() -> tuple[BinaryIO, BinaryIO]:
    """Standard input and output, which nothing else reads or writes from now on."""
    reading, writing = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    nothing, end = os.pipe()
    os.close(end)
    os.dup2(nothing, 0)
    os.dup2(2, 1)
    return reading, writing


class _CancelledError(BaseException):
    """The call that is running was cancelled."""


class Server:
    """One connection: reads requests, runs calls, writes answers.

    `forget`: closes the databases that are kept open, after a call was interrupted.
    """

    def __init__(self, tools: Tools, writing: BinaryIO, forget: Callable[[], None]) -> None:
        self.tools, self.writing, self.forget = tools, writing, forget
        self.version = VERSIONS[0]
        self.calls: queue.Queue[Message | None] = queue.Queue()
        self.lock = threading.Lock()
        self.cancelled, self.running = set[Any](), object()
        self.is_interrupting = self.is_ended = False

    def run(self, reading: BinaryIO) -> None:
        """Answer until the input ends, and then what was asked before."""
        before = signal.getsignal(signal.SIGINT)

        def interrupt(number: int, frame: Any) -> None:  # noqa: ANN401
            if not self.is_interrupting and callable(before):  # Ctrl-C
                self.is_ended = True
                before(number, frame)
            self.is_interrupting = False
            if self.running in self.cancelled:
                raise _CancelledError

        signal.signal(signal.SIGINT, interrupt)
        threading.Thread(target=self._read, args=(reading,), daemon=True).start()
        while True:
            with suppress(_CancelledError):
                request = self.calls.get()
                if request is None:
                    break
                self._run_call(request)
        signal.signal(signal.SIGINT, before)

    def _read(self, reading: BinaryIO) -> None:
        while line := reading.readline(LONGEST_LINE):
            if len(line) >= LONGEST_LINE:
                while line and not line.endswith(b"\n"):
                    line = reading.readline(LONGEST_LINE)
                self._refuse(None, INVALID, f"expected a message of at most {LONGEST_LINE:,} bytes")
            elif line.strip():
                try:
                    self._take(json.loads(line))
                except (ValueError, RecursionError) as error:
                    self._refuse(None, PARSE, f"expected a line of JSON, found: {error}")
        self.calls.put(None)

    def _take(self, message: Any) -> None:  # noqa: ANN401  whatever the line holds
        """Answer a message at once, or queue its call."""
        method = message.get("method") if isinstance(message, dict) else None
        number = message.get("id") if isinstance(message, dict) else None
        if (
            isinstance(message, dict)
            and method is None
            and ("result" in message or "error" in message)
        ):
            return  # an answer; nothing was asked
        is_request = isinstance(message, dict) and "id" in message
        if not isinstance(method, str) or (is_request and not _is_number(number)):
            self._refuse(
                None, INVALID, "expected a request of JSON-RPC 2.0 with a method and an id"
            )
            return
        given = message.get("params", {})
        given = given if isinstance(given, dict) else {}
        if not is_request:
            if method == "notifications/cancelled" and _is_number(given.get("requestId")):
                self._cancel(given["requestId"])
        elif method == "initialize":
            self._send(number, self._initialized(given))
        elif method == "ping":
            self._send(number, {})
        elif method == "tools/list":
            self._send(number, {"tools": self.tools.listed()})
        elif method == "tools/call":
            self.calls.put(message)
        else:
            self._refuse(number, NO_METHOD, f"expected a known method, found {method!r:.80}")

    def _initialized(self, given: Message) -> Message:
        """Agree on a revision: the newest that is not newer than the one that was asked for."""
        asked = str(given.get("protocolVersion", ""))
        self.version = next((v for v in VERSIONS if v <= asked), VERSIONS[-1])
        return {
            "protocolVersion": self.version,
            "capabilities": {"tools": {}},
            "serverInfo": {"name": "motiondb", "version": motiondb.__version__},
            "instructions": "A database of motion capture. Times are seconds, lengths metres. "
            "Search for actions in words, such as 'walk, then turn left'.",
        }

    def _cancel(self, number: Any) -> None:  # noqa: ANN401
        with self.lock:
            self.cancelled.add(number)
            if self.running == number:
                self.is_interrupting = True
                _thread.interrupt_main()

    def _run_call(self, request: Message) -> None:
        number = request["id"]
        with self.lock:
            is_wanted = number not in self.cancelled
            if is_wanted:
                self.running = number
        try:
            answered = self._called(request) if is_wanted else None
        except _CancelledError:
            self.forget()
            return
        finally:
            self.running = object()
        if answered is not None and number not in self.cancelled:
            self._send(number, **answered)
        self.cancelled.discard(number)

    def _called(self, request: Message) -> Message:
        """The result of a call, or the error of the protocol."""
        given = request.get("params")
        name = given.get("name") if isinstance(given, dict) else None
        arguments = given.get("arguments") or {} if isinstance(given, dict) else {}
        if not isinstance(name, str) or not isinstance(arguments, dict):
            return _error(PARAMETERS, "tools/call: expected a name and arguments")
        try:
            called = self.tools.call(name, arguments)
        except KeyError:
            return _error(PARAMETERS, f"expected a tool that is listed, found {name!r:.80}")
        except ToolError as error:
            return {"result": _texts([str(error)[:MOST_LETTERS]], is_error=True)}
        except Exception as error:
            if self.is_ended:  # Click makes an error of Ctrl-C
                raise KeyboardInterrupt from None
            self.forget()
            traceback.print_exc()
            said = f"{name}: an error of motiondb, {type(error).__name__}: {error}"
            return {"result": _texts([said[:MOST_LETTERS]], is_error=True)}
        answer, cut = shortened(called.answer)
        text = json.dumps(answer, ensure_ascii=False)
        if len(text) > MOST_LETTERS:
            return {"result": _texts([f"{name}: the answer is too long. Ask for less."], True)}
        if cut:
            cut = [f"the answer was too long: {'; '.join(cut)}. Ask for less, or with a limit."]
        notes = [*cut, *called.notes]
        result = _texts([text, *(["\n".join(notes)[:MOST_LETTERS]] if notes else [])])
        if self.version >= STRUCTURED:
            result["structuredContent"] = answer if isinstance(answer, dict) else {"answer": answer}
        return {"result": result}

    def _refuse(self, number: Any, code: int, message: str) -> None:  # noqa: ANN401
        self._send(number, **_error(code, message))

    def _send(self, number: Any, result: Any = None, error: Any = None) -> None:  # noqa: ANN401
        part = {"result": result} if error is None else {"error": error}
        line = json.dumps({"jsonrpc": "2.0", "id": number} | part) + "\n"
        with self.lock, suppress(BrokenPipeError):  # who has gone needs no answer
            self.writing.write(line.encode())
            self.writing.flush()


def _is_number(value: Any) -> bool:  # noqa: ANN401
    """Whether a value can be the id of a request."""
    return isinstance(value, str | int) and not isinstance(value, bool)


def _error(code: int, message: str) -> Message:
    return {"error": {"code": code, "message": message}}


def _texts(texts: list[str], is_error: bool = False) -> Message:
    content = [{"type": "text", "text": printing.visible_lines(text)} for text in texts]
    return {"content": content, "isError": is_error}
