"""Options shared by several commands, and opening the database."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from copy import copy
from dataclasses import dataclass, fields, is_dataclass
from functools import cache, wraps
from inspect import Parameter, signature
from pathlib import Path
from typing import Annotated, Any, TypeVar, get_args, get_type_hints

import typer
import typer.core
from typer.main import get_command_name, get_current_context
from typer.models import OptionInfo

import motiondb
from motiondb.cli import printing

Function = TypeVar("Function", bound=Callable[..., Any])
Command = typer.core.TyperCommand | typer.core.TyperGroup


def option(about: str, *names: str, **settings: Any) -> Any:
    """An option; without names it has that of its parameter. A text alone stands for one, too."""
    return typer.Option(..., *names, help=about, **settings)


def argument(about: str, metavar: str | None = None, **settings: Any) -> Any:
    """An argument of a command."""
    return typer.Argument(..., help=about, metavar=metavar, **settings)


Where = Annotated[str, "Only captures that match, such as 'performer in (14, 16) and not fps<60'."]
Exact = Annotated[
    bool, "Leave out words that are in no caption, instead of replacing them by known words."
]
Limit = Annotated[int, option("Largest number of answers.", min=1)]
CaptureName = Annotated[str, argument("A capture's name.", "CAPTURE")]
GrammarName = Annotated[str, argument("Name of a grammar.", "NAME")]
DiagramFile = Annotated[str, argument("A tactics file, or one like give-and-go.", "DIAGRAM")]
SaveAs = Annotated[str | None, option("Also save it as a capture of this name.", "--save")]
Prefix = Annotated[str, "Put this before every new name, such as studio2/."]
Up = Annotated[
    str,
    option(
        "The axis that points up: x, y, z, -x, -y or -z; else what the file says or shows.",
        metavar="AXIS",
    ),
]
MOST_SECONDS = 1e7  # Largest time that is accepted, seconds: some months, longer than any take


From = Annotated[float | None, option("Start, in seconds.", "--from", min=0.0, max=MOST_SECONDS)]
To = Annotated[float | None, option("End, in seconds.", "--to", min=0.0, max=MOST_SECONDS)]


def numbered(path: Path, number: int) -> Path:
    """Return the path of one of several files: NAME-NUMBER with the same ending; of 0, NAME."""
    return path.with_name(f"{path.stem}-{number}{path.suffix}") if number else path


def check_ending(path: Path | None, endings: Sequence[str], advice: str = "") -> None:
    """Check how the name of an output ends, before anything is computed."""
    if path is not None and path.suffix.lower() not in endings:
        *most, last = endings
        expected = f"{', '.join(most)} or {last}" if most else last
        raise motiondb.QueryError(
            f"{path}: expected a name that ends in {expected}, "
            f"found {path.suffix or 'no ending'!r}.{advice}"
        )


def picture_name(path: Path | None) -> Path | None:
    """Check the name of a picture."""
    check_ending(path, (".png",), " Pictures are written as PNG.")
    return output_name(path)


def animation_name(path: Path | None) -> Path | None:
    """Check the name of an animation."""
    check_ending(path, (".gif",), " Animations are written as GIF.")
    return output_name(path)


def motion_name(path: Path | None) -> Path | None:
    """Check how the name of a generated motion ends; what it is, is checked by the command."""
    check_ending(path, (".bvh", ".fbx", ".glb", ".gltf", ".usd", ".usda", ".usdc"))
    if path is not None:
        motiondb.check_motion_file(path)
    return path


def output_name(path: Path | None) -> Path | None:
    """Check that the name of an output may be written, before anything is computed."""
    if path is not None:
        motiondb.check_overwriting(path)
    return path


def picture(about: str) -> Any:
    """An option that names a picture to write (.png)."""
    return option(about, callback=picture_name)


def animation(about: str) -> Any:
    """An option that names an animation to write (.gif)."""
    return option(about, callback=animation_name)


def output(about: str, check: Callable[[Path | None], Path | None]) -> Any:
    """The option -o that names a file to write."""
    return option(about, "-o", "--output", callback=check)


Png = Annotated[Path | None, picture("Draw a picture into this file (.png).")]


def html_name(path: Path | None) -> Path | None:
    """Check ending of the file name, and that the page was built, before anything is computed."""
    if path is None:
        return None
    check_ending(path, (".html", ".htm"))
    motiondb.StandalonePage.check()
    return output_name(path)


Html = Annotated[
    Path | None,
    option("Write a page with the answer and a player into this file (.html).", callback=html_name),
]


def any_name(path: Path | None) -> Path | None:
    """Leave the name of an output to its command, which checks it."""
    return path


NAME_CHECKS = (output_name, picture_name, animation_name, motion_name, html_name, any_name)
"""The callbacks of files that are written; a command with one of them has --force."""


def a_path(text: str) -> Path:
    """The path that was typed; an empty one (a variable that is not set) is not this folder."""
    if not text:
        raise typer.BadParameter("expected the name of a folder or a file, found an empty name.")
    return Path(text)


ExportFolder = Annotated[
    Path | None,
    option(
        "Write every answer into this folder as BVH, with its origin and licence beside it.",
        "--export",
        parser=a_path,
        metavar="FOLDER",
        callback=any_name,
    ),
]
Output = Annotated[Path, output("File: .bvh, .glb, .gltf, .fbx or .usd.", motion_name)]


@dataclass(frozen=True)
class Changes:
    """Options that change a motion before it is written."""

    unit: Annotated[
        str | None,
        "Length unit of the file: m, cm, mm, inch, a number of metres, or as-added "
        "for the capture's own.  [default: cm for BVH of captures in other formats]",
    ] = None
    fps: Annotated[float | None, option("Frames per second.", min=1.0, max=2000.0)] = None
    loop: Annotated[bool, "Trim to one seamless cycle."] = False
    in_place: Annotated[bool, "Remove travel, keep the motion on the spot."] = False
    mirror: Annotated[bool, "Mirror left and right."] = False
    onto: Annotated[
        Path | None,
        "A rig (.bvh, .fbx, .glb), a robot (MJCF, URDF), or lafan1, soma, mixamo, smpl: put the "
        "motion on its joints.",
    ] = None
    joint_map: Annotated[
        Path | None, "A file of lines `role = joint` for a rig of unknown names."
    ] = None

    speed: Annotated[
        float, option("Tempo of the file: 1.2 is a fifth faster.", min=0.1, max=10.0)
    ] = 1.0
    reduce_keys: Annotated[
        float | None,
        option(
            "Leave out keys within so many degrees, or centimetres (glTF alone: the other "
            "formats hold every frame).",
            min=0.001,
            max=45.0,
        ),
    ] = None

    def read(self) -> motiondb.MotionChanges:
        """The changes, with the joint map read from its file."""
        as_added = self.unit == "as-added"
        metres = None if self.unit is None or as_added else motiondb.unit_from_name(self.unit)
        names = {} if self.joint_map is None else motiondb.read_joint_map(self.joint_map)
        read: dict[str, Any] = {"unit": metres, "joint_map": names, "own_unit": as_added}
        return motiondb.MotionChanges(**vars(self) | read)


def protect(forced: bool) -> None:
    """Protect files of others in this context, unless --force; an eager option is first."""
    motiondb.protect_others(not forced)


Force = Annotated[
    bool,
    option(
        "Also overwrite files that motiondb is not known to have written.",
        "--force",
        is_eager=True,
        callback=protect,
    ),
]
Seed = Annotated[
    int, option("Random seed; the same seed gives the same result.", min=0, max=2**63 - 1)
]
# Seconds that a command waits for the database by default: most commands that hold it alone take
# less time, and after a longer wait the user should see which process holds it
DEFAULT_WAIT = 5.0
LONGEST_WAIT = 86_400.0  # Largest number of seconds to wait: a day. A larger one is a mistake
Cluster = Annotated[
    str | None,
    option(
        "Compute on the workers of a dask scheduler, tcp://HOST:8786, or on processes of this "
        "machine (local); the answers are the same.",
        metavar="ADDRESS",
        envvar="MOTIONDB_CLUSTER",
    ),
]
Json = Annotated[bool, "Print the answer as JSON."]
Wait = Annotated[
    float,
    option(
        "Seconds to wait for a database that another process holds.",
        envvar="MOTIONDB_WAIT",
        min=0.0,
        max=LONGEST_WAIT,
    ),
]


def database_name(path: Path | None) -> Path | None:
    """Check that the name of the database is not that of a folder."""
    with suppress(OSError):  # a name that the system cannot have is refused when it is opened
        if path is not None and path.is_dir():
            raise motiondb.QueryError(
                f"{path}: expected a database of motiondb, found a folder. Name a file with --db."
            )
    return path


@dataclass(frozen=True)
class Shared:
    """The options of every command on a database; :class:`Commands` adds them to its function."""

    db: Annotated[Path, option("The database file.", envvar="MOTIONDB", callback=database_name)] = (
        Path("motions.duckdb")
    )
    json: Json = False
    wait: Wait = DEFAULT_WAIT

    @contextmanager
    def database(
        self, *, writing: bool = False, create: bool = False
    ) -> Iterator[motiondb.MotionDB]:
        """Open the database and close it at the end.

        `writing`: Whether the command changes the database; then no other process can open it.
        """
        with _opened(self.db, self.wait, writing=writing, create=create) as db:
            yield db


@dataclass(frozen=True)
class SharedOfClips:
    """The same for commands that need no database, but list the clips of one that is given."""

    db: Annotated[
        Path | None,
        option("Also list the clips of this database for every action.", callback=database_name),
    ] = None
    json: Json = False
    wait: Wait = DEFAULT_WAIT

    @contextmanager
    def database(self) -> Iterator[motiondb.MotionDB | None]:
        """Open the database if one is given, and close it at the end."""
        if self.db is None:
            yield None
            return
        with _opened(self.db, self.wait) as db:
            yield db


@contextmanager
def _opened(
    path: Path, wait: float, *, writing: bool = False, create: bool = False
) -> Iterator[motiondb.MotionDB]:
    with _database(path, wait, writing, create) as db:
        printing.note(db.store.log_note)
        try:
            yield db
            printing.note(db.session.damage_note)
        finally:
            for sentence in db.store.notes:
                printing.note(sentence)
    printing.note(db.store.log_note)


_KEPT: ContextVar[dict[tuple[Path, bool], motiondb.MotionDB] | None] = ContextVar(
    "_KEPT", default=None
)


@contextmanager
def keeping_open() -> Iterator[Callable[[], None]]:
    """Keep what commands load in memory for the next ones; their files are closed in between.

    Yields a function that forgets all of it.
    """
    kept: dict[tuple[Path, bool], motiondb.MotionDB] = {}

    def forget() -> None:
        while kept:
            kept.popitem()[1].close()

    before = _KEPT.set(kept)
    try:
        yield forget
    finally:
        _KEPT.reset(before)
        forget()


@contextmanager
def _database(path: Path, wait: float, writing: bool, create: bool) -> Iterator[motiondb.MotionDB]:
    kept = _KEPT.get()
    if kept is None:
        with motiondb.MotionDB(path, read_only=not writing, create=create, wait=wait) as db:
            yield db
        return
    if (path, writing) not in kept:
        opened = motiondb.MotionDB(path, read_only=not writing, create=create, wait=wait)
        kept[path, writing] = opened
    try:
        yield kept[path, writing]
    finally:
        if (path, writing) in kept:
            kept[path, writing].release()


@cache
def examples() -> list[str]:
    """The lines of ``examples.txt``, with which the help of every command ends."""
    return Path(__file__).with_name("examples.txt").read_text(encoding="utf-8").splitlines()


class Group(typer.core.TyperGroup):
    """The group of all commands, whose help ends with examples."""

    def __init__(self, *args: Any, **settings: Any) -> None:
        super().__init__(*args, **settings)
        _add_examples(self, "motiondb")


def _add_examples(command: Command, name: str) -> None:
    """Let the help of a command, and of all below it, end with its examples."""
    for part, below in getattr(command, "commands", {}).items():
        _add_examples(below, f"{name} {part}")
    own = [line for line in examples() if _is_of(line, name, command)]
    if own:
        command.epilog = "\b\nExamples:\n" + "\n".join(f"  {line}" for line in own)


def _is_of(line: str, name: str, command: Command) -> bool:
    """Whether a line is an example of a command, and of none below it."""
    rest = line.removeprefix(name)
    if rest == line or (rest and not rest.startswith(" ")):
        return False
    below = getattr(command, "commands", {})
    return not below or not rest or (rest.split()[0] not in below and name != "motiondb")


class Commands(typer.Typer):
    """A Typer app whose commands have the shared options if they take them as one parameter."""

    def command(self, *args: Any, **options: Any) -> Callable[[Function], Function]:
        """Register a function as a command."""
        return _with_options(super().command(*args, **options))

    def callback(self, *args: Any, **options: Any) -> Callable[[Function], Function]:
        """Register the function that a group runs where none of its commands is named."""
        return _with_options(super().callback(*args, **options))

    def group(self, name: str, about: str, *, alone: bool = False) -> Commands:
        """Add a group of commands; ``alone``: its name alone is a command, too, not its help."""
        group = Commands(
            name=name, help=about, invoke_without_command=alone, no_args_is_help=not alone
        )
        self.add_typer(group)
        return group

    def include(self, other: typer.Typer) -> None:
        """Add the commands and groups of another app."""
        self.registered_commands += other.registered_commands
        self.registered_groups += other.registered_groups

    def only(self, name: str) -> typer.Typer:
        """The app with the command or group of a name alone, or all of it where there is none.

        Typer builds the options of every command of an app, a tenth of a second for all.
        """
        own = copy(self)
        own.registered_groups = [
            each
            for each in self.registered_groups
            if each.typer_instance and each.typer_instance.info.name == name
        ]
        own.registered_commands = [
            each
            for each in self.registered_commands
            if name == (each.name or get_command_name(getattr(each.callback, "__name__", "")))
        ]
        return own if own.registered_groups or own.registered_commands else self


def finite(value: float | None) -> float | None:
    """Refuse NaN and infinity, which the ranges of options let pass."""
    if value is not None and not math.isfinite(value):
        raise typer.BadParameter(f"expected a finite number, found {value}.")
    return value


def _described(parameter: Parameter) -> Parameter:
    """A parameter as Typer takes it: a text is the help of an option of its name.

    An option for a number refuses NaN and infinity.
    """
    if not hasattr(parameter.annotation, "__metadata__"):
        return parameter
    kind, (mark,) = parameter.annotation.__origin__, parameter.annotation.__metadata__
    described = option(mark) if isinstance(mark, str) else copy(mark)
    if isinstance(described, OptionInfo):
        described.param_decls = described.param_decls or (f"--{parameter.name.replace('_', '-')}",)
        if float in (kind, *get_args(kind)):
            described.callback = finite
    described.default = ... if parameter.default is Parameter.empty else parameter.default
    return parameter.replace(annotation=kind, default=described)


def _with_options(
    register: Callable[[Callable[..., Any]], object],
) -> Callable[[Function], Function]:
    """Register a function with an option for each field of its parameters that are dataclasses."""

    def decorate(function: Function) -> Function:
        known = dict(signature(function, eval_str=True).parameters)
        kinds: dict[str, Any] = {n: p.annotation for n, p in known.items()}
        kinds = {name: kind for name, kind in kinds.items() if is_dataclass(kind)}
        for name in sorted(kinds, key="shared".__eq__):  # those of every command come last
            del known[name]
            hints = get_type_hints(kinds[name], include_extras=True)
            for field in fields(kinds[name]):
                known[field.name] = _option(field.name, field.default, hints[field.name])
        marks = [m for p in known.values() for m in getattr(p.annotation, "__metadata__", ())]
        if kinds and any(getattr(mark, "callback", None) in NAME_CHECKS for mark in marks):
            known["force"] = _option("force", False, Force)
        known = {name: _described(parameter) for name, parameter in known.items()}

        @wraps(function)
        def command(*args: Any, **values: Any) -> Any:
            values.pop("force", None)  # its callback has heard it
            if get_current_context().invoked_subcommand is not None:  # the group of a command
                return None
            for name, kind in kinds.items():
                own = {field.name: values.pop(field.name) for field in fields(kind)}
                values[name] = kind(**own)
            return function(*args, **values)

        described: Any = command
        described.__signature__ = signature(function).replace(parameters=list(known.values()))
        described.__annotations__ = {name: each.annotation for name, each in known.items()}
        register(described)
        return function

    return decorate


def _option(name: str, default: object, annotation: object) -> Parameter:
    return Parameter(name, Parameter.KEYWORD_ONLY, default=default, annotation=annotation)
