"""The commands as tools for programs: their arguments as JSON schemas, calls, and allowed files.

A tool is a command: its arguments, their help and their limits are the command's, and its answer
is that of ``--json``. One more command is one more line of :data:`TOOLS`.

Files are those below some folders. Names are taken from the first of them, links are resolved,
``..`` is refused, and so is a text that names a file elsewhere where a command takes the name of a
capture or of a file. Without ``writes``, tools that change something are left out, and so is every
argument that names an output.
"""

from __future__ import annotations

import io
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from contextvars import copy_context
from dataclasses import dataclass, field
from inspect import unwrap
from pathlib import Path
from typing import Any

import typer.main

import motiondb
from motiondb.cli import options

TOOLS = {
    "add": True,
    "list": False,
    "show": False,
    "search": False,
    "like": False,
    "along": False,
    "rhythm": False,
    "describe": False,
    "compare": False,
    "judge": False,
    "generate": True,
    "join": True,
    "export": True,
    "words": False,
    "words set": True,
    "words history": False,
    "tags": False,
    "tags set": True,
    "selections": False,
    "selections show": False,
    "selections add": True,
    "selections take": True,
    "selections remove": True,
    "selections export": True,
    "rename": True,
    "remove": True,
    "undo": True,
    "learn": True,
    "quality": True,
    "coverage": False,
    "curate": True,
    "diff": False,
    "check": False,
    "info": False,
    "grammar list": False,
    "grammar show": False,
    "grammar parse": False,
    "grammar suggest": False,
    "grammar generate": True,
    "scene list": False,
    "scene validate": False,
    "scene grammar check": False,
}
"""Command -> whether it changes the database or writes files."""
_OF_SERVER = {
    "db",
    "json",
    "wait",
    "force",
    "cluster",
    "as_csv",
    "jobs",
    "outside_skeletons",
}
"""Parameters that no program gives: of the server, or answers to people; none asks for --force."""
_OUTPUTS = {"save", "output", "out"}  # Parameters that write and have no check of a file's name
_KINDS = {"int": "integer", "float": "number", "bool": "boolean"}
"""How the names of Click's types begin, such as "int range" -> type of JSON."""
MOST_LETTERS = 50_000  # Of an answer; longer ones would fill what a language model can read


class ToolError(Exception):
    """A sentence that tells a program why its call was not done."""


@dataclass(frozen=True)
class Called:
    """What a tool answered."""

    answer: Any  # As --json prints it
    notes: tuple[str, ...]  # What the command says beside it


@dataclass(frozen=True)
class Tools:
    """The tools of one database."""

    db: Path
    folders: tuple[Path, ...] = ()
    writes: bool = False
    wait: float = options.DEFAULT_WAIT
    _commands: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        from motiondb.cli.main import make_app

        app: Any = typer.main.get_command(make_app())
        for path, changes in TOOLS.items():
            command = app
            for word in path.split():
                command = command.commands[word]
            if self.writes or not changes:
                self._commands[path.replace(" ", "_")] = command

    def listed(self) -> list[dict[str, Any]]:
        """All tools, as the protocol lists them."""
        return [
            {
                "name": name,
                "description": command.help.replace("\b\n", ""),
                "inputSchema": self._schema(command),
                "annotations": {
                    "readOnlyHint": not self._changes(name),
                    "destructiveHint": name in ("remove", "words_set", "tags_set", "learn"),
                    "openWorldHint": False,
                },
            }
            for name, command in self._commands.items()
        ]

    def call(self, name: str, arguments: Mapping[str, Any]) -> Called:
        """Run a command with the arguments of a program (ToolError: it cannot be done so)."""
        if name not in self._commands:
            raise KeyError(name)
        line = self._line(name, arguments)
        out, err = io.StringIO(), io.StringIO()
        with redirect_stdout(out), redirect_stderr(err):
            try:
                code = copy_context().run(
                    self._commands[name].main, line, f"motiondb {name}", standalone_mode=False
                )
            except motiondb.MotionDBError as error:
                raise ToolError(str(error)) from None
            except Exception as error:
                if not hasattr(error, "format_message"):  # Typer's, of wrong arguments
                    raise
                raise ToolError(f"{name}: {error.format_message()}") from None
        notes = tuple(filter(None, err.getvalue().splitlines()))
        try:
            return Called(json.loads(out.getvalue()), notes)
        except ValueError:
            said = "\n".join((*out.getvalue().splitlines(), *notes))
            raise ToolError(said or f"{name}: ended with {code}") from None

    def _changes(self, name: str) -> bool:
        """Whether a tool may change the database or write a file."""
        return TOOLS[name.replace("_", " ")] or any(
            map(_is_output, self._parameters(self._commands[name]))
        )

    def _parameters(self, command: Any) -> Iterator[Any]:  # noqa: ANN401  Typer's own Click
        for each in command.params:
            if each.name not in _OF_SERVER and (self.writes or not _is_output(each)):
                yield each

    def _schema(self, command: Any) -> dict[str, Any]:  # noqa: ANN401
        known = list(self._parameters(command))
        return {
            "type": "object",
            "properties": {each.name: _schema_of(each) for each in known},
            "required": [each.name for each in known if each.required],
            "additionalProperties": False,
        }

    def _line(self, name: str, arguments: Mapping[str, Any]) -> list[str]:
        """The words of a command line."""
        known = {each.name: each for each in self._parameters(self._commands[name])}
        if unknown := sorted(arguments.keys() - known.keys()):
            raise ToolError(
                f"{name}: expected arguments out of {', '.join(known)}, found "
                f"{', '.join(map(repr, unknown))}."
            )
        line = [f"--db={self.db}", f"--wait={self.wait}", "--json"]
        positional = []
        for key, each in known.items():
            value = arguments.get(key)
            if value is None:
                continue
            values = value if _is_many(each) and isinstance(value, list) else [value]
            texts = [self._text(name, each, one) for one in values]
            if each.param_type_name == "argument":
                positional += texts
            elif isinstance(value, bool) and _kind(each) == "boolean":
                line += (each.opts if value else each.secondary_opts)[:1]
            else:
                line += [f"{max(each.opts, key=len)}={text}" for text in texts]
        return [*line, "--", *positional]

    def _text(self, name: str, parameter: Any, value: Any) -> str:  # noqa: ANN401
        """One argument as a command line has it."""
        kind = _kind(parameter)
        types: dict[str, Any] = {"integer": int, "number": (int, float), "boolean": bool}
        is_kind = isinstance(value, types.get(kind, str))
        if not is_kind or (isinstance(value, bool) and kind != "boolean"):
            raise ToolError(f"{name}: {parameter.name}: expected a {kind}, found {value!r:.80}.")
        text = str(value)
        if kind == "string":
            self._check_file(name, parameter, text)
        return text

    def _check_file(self, name: str, parameter: Any, text: str) -> None:  # noqa: ANN401
        """Refuse a file that does not lie below the folders (ToolError)."""
        is_path = _is_path(parameter)
        for each in dict.fromkeys((text, text.rpartition("#")[0])):  # a take of an FBX: FILE#TAKE
            if each and (is_path or os.path.lexists(each)) and (out := self._outside(Path(each))):
                within = ", ".join(map(str, self.folders)) or "none: start it with --folder"
                link = "" if str(out) == text else f", with {str(out)!r:.200}"
                raise ToolError(
                    f"{name}: {parameter.name}: expected a file below the folders that are "
                    f"allowed ({within}), found {text!r:.200}{link}."
                )

    def _outside(self, path: Path) -> Path | None:
        """The path, or a link that commands may follow with it, that leads out of the folders."""
        if ".." in path.parts:
            return path
        for each in (path, *_links(path)):
            try:
                real = Path(os.path.realpath(each))
            except (OSError, ValueError):  # a name that no system accepts
                return each
            if not any(real.is_relative_to(folder) for folder in self.folders):
                return each
        return None


def _links(path: Path) -> Iterator[Path]:
    """The links below a folder; beside a file those of its name, and skeletons."""
    is_folder = path.is_dir()
    for folder, below, files in os.walk(path if is_folder else path.parent):
        for each in (Path(folder, name) for name in (*below, *files)):
            is_beside = each.name.startswith(path.stem) or each.suffix.lower() == ".asf"
            if (is_folder or is_beside) and each.is_symlink():
                yield each
        if not is_folder:
            return


def _kind(parameter: Any) -> str:  # noqa: ANN401
    name = parameter.type.name
    return next((kind for start, kind in _KINDS.items() if name.startswith(start)), "string")


def _has_name_check(parameter: Any) -> bool:  # noqa: ANN401
    """Whether a command checks the name of a file that it writes; Typer wraps the checks."""
    return parameter.callback and unwrap(parameter.callback) in options.NAME_CHECKS


def _is_output(parameter: Any) -> bool:  # noqa: ANN401
    return _has_name_check(parameter) or parameter.name in _OUTPUTS


def _is_path(parameter: Any) -> bool:  # noqa: ANN401
    """Whether a parameter takes nothing but the name of a file or folder."""
    return _has_name_check(parameter) or parameter.type.name in (
        "path",
        "file",
        "directory",
        "a_path",
    )


def _is_many(parameter: Any) -> bool:  # noqa: ANN401
    return parameter.nargs == -1 or getattr(parameter, "multiple", False)


def _schema_of(parameter: Any) -> dict[str, Any]:  # noqa: ANN401
    """The JSON schema of an argument: its type, limits, default and help."""
    schema: dict[str, Any] = {"type": _kind(parameter)}
    limits = {"minimum": "min", "maximum": "max"}
    for key, own in limits.items():
        if (limit := getattr(parameter.type, own, None)) is not None:
            schema[key] = limit
    if _is_many(parameter):
        schema = {"type": "array", "items": schema}
    elif isinstance(parameter.default, str | int | float) and parameter.default != "":
        schema["default"] = parameter.default
    return schema | {"description": parameter.help or ""}


def shortened(answer: Any, most: int = MOST_LETTERS) -> tuple[Any, list[str]]:  # noqa: ANN401
    """An answer whose longest lists are cut until it has so many letters, and what was cut.

    >>> shortened({"matches": list(range(100)), "n": 1}, 60)
    ({'matches': [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11], 'n': 1}, ['matches: the first 12 of 100'])
    """
    cut: dict[str, tuple[int, int]] = {}
    answer = json.loads(json.dumps(answer))
    while len(json.dumps(answer)) > most:
        lists = [each for each in _lists("", answer) if len(each[1]) > 1]
        if not lists:
            break
        path, longest = max(lists, key=lambda each: len(json.dumps(each[1])))
        cut[path] = len(longest) // 2, cut.get(path, (0, len(longest)))[1]
        del longest[len(longest) // 2 :]
    return answer, [f"{path or 'answer'}: the first {n} of {of}" for path, (n, of) in cut.items()]


def _lists(path: str, value: Any) -> Iterator[tuple[str, list[Any]]]:  # noqa: ANN401
    """All lists of an answer, with the keys that lead to them."""
    if isinstance(value, list):
        yield path, value
    items: Sequence[tuple[Any, Any]] = []
    if isinstance(value, list | dict):
        items = list(value.items() if isinstance(value, dict) else enumerate(value))
    for key, each in items:
        yield from _lists(f"{path}.{key}" if path else str(key), each)


@contextmanager
def working_in(folder: Path) -> Iterator[None]:
    """Work in a folder, so that names of files are taken from there."""
    before = Path.cwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)
