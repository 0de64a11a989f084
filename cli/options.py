"""Options shared by several commands, and opening the database."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from copy import copy
from dataclasses import dataclass, fields, is_dataclass
from functools import wraps
from inspect import Parameter, signature
from pathlib import Path
from typing import Annotated, Any, TypeVar, get_args, get_type_hints

import typer
import typer.core
from typer.main import get_command_name
from typer.models import OptionInfo

import motiondb
from motiondb.cli import printing

Function = TypeVar("Function", bound=Callable[..., Any])

Where = Annotated[
    str,
    typer.Option(
        "--where", help="Only captures that match, such as 'performer in (14, 16) and not fps<60'."
    ),
]
Exact = Annotated[
    bool,
    typer.Option(
        "--exact",
        help="Leave out words that are in no caption, instead of replacing them by known words.",
    ),
]
Limit = Annotated[int, typer.Option("--limit", min=1, help="Largest number of answers.")]
CaptureName = Annotated[str, typer.Argument(metavar="CAPTURE", help="A capture's name.")]
GrammarName = Annotated[str, typer.Argument(metavar="NAME", help="Name of a grammar.")]
DiagramFile = Annotated[
    str, typer.Argument(metavar="DIAGRAM", help="A tactics file, or one like give-and-go.")
]
SaveAs = Annotated[
    str | None, typer.Option("--save", help="Also save it as a capture of this name.")
]
Prefix = Annotated[
    str, typer.Option("--prefix", help="Put this before every new name, such as studio2/.")
]
Up = Annotated[
    str,
    typer.Option(
        "--up",
        metavar="AXIS",
        help="The axis that points up: x, y, z, -x, -y or -z; else what the file says or shows.",
    ),
]
MOST_SECONDS = 1e7  # Largest time that is accepted, seconds: some months, longer than any take


From = Annotated[
    float | None,
    typer.Option("--from", min=0.0, max=MOST_SECONDS, help="Start, in seconds."),
]
To = Annotated[
    float | None,
    typer.Option("--to", min=0.0, max=MOST_SECONDS, help="End, in seconds."),
]


WRITTEN = "written"  # Marks a parameter with a file that is written; its command has --force


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


def picture(about: str, name: str = "--png") -> OptionInfo:
    """The option for a picture that shows something else than most."""
    option: OptionInfo = typer.Option(name, callback=picture_name, help=about)
    return option


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


Png = Annotated[Path | None, picture("Draw a picture into this file (.png)."), WRITTEN]


def html_name(path: Path | None) -> Path | None:
    """Check ending of the file name, and that the page was built, before anything is computed."""
    if path is None:
        return None
    check_ending(path, (".html", ".htm"))
    motiondb.StandalonePage.check()
    return output_name(path)


Html = Annotated[
    Path | None,
    typer.Option(
        "--html",
        callback=html_name,
        help="Write a page with the answer and a player into this file (.html).",
    ),
    WRITTEN,
]


def a_path(text: str) -> Path:
    """The path that was typed; an empty one (a variable that is not set) is not this folder."""
    if not text:
        raise typer.BadParameter("expected the name of a folder or a file, found an empty name.")
    return Path(text)


ExportFolder = Annotated[
    Path | None,
    typer.Option(
        "--export",
        parser=a_path,
        metavar="FOLDER",
        help="Write every answer into this folder as BVH, with its origin and licence beside it.",
    ),
    WRITTEN,
]
Output = Annotated[
    Path,
    typer.Option(
        "-o", "--output", callback=motion_name, help="File: .bvh, .glb, .gltf, .fbx or .usd."
    ),
    WRITTEN,
]


@dataclass(frozen=True)
class Changes:
    """Options that change a motion before it is written."""

    unit: Annotated[
        str | None,
        typer.Option(
            "--unit",
            help="Length unit of the file: m, cm, mm, inch, a number of metres, or as-added "
            "for the capture's own.  [default: cm for BVH of captures in other formats]",
        ),
    ] = None
    fps: Annotated[
        float | None, typer.Option("--fps", min=1.0, max=2000.0, help="Frames per second.")
    ] = None
    loop: Annotated[bool, typer.Option("--loop", help="Trim to one seamless cycle.")] = False
    in_place: Annotated[
        bool, typer.Option("--in-place", help="Remove travel, keep the motion on the spot.")
    ] = False
    mirror: Annotated[bool, typer.Option("--mirror", help="Mirror left and right.")] = False
    onto: Annotated[
        Path | None,
        typer.Option(
            "--onto",
            help="A rig (.bvh, .fbx, .glb), a robot (MJCF, URDF), or lafan1, soma, mixamo, "
            "smpl: put the motion on its joints.",
        ),
    ] = None
    joint_map: Annotated[
        Path | None,
        typer.Option(
            "--joint-map", help="A file of lines `role = joint` for a rig of unknown names."
        ),
    ] = None

    speed: Annotated[
        float,
        typer.Option(
            "--speed", min=0.1, max=10.0, help="Tempo of the file: 1.2 is a fifth faster."
        ),
    ] = 1.0
    reduce_keys: Annotated[
        float | None,
        typer.Option(
            "--reduce-keys",
            min=0.001,
            max=45.0,
            help="Leave out keys within so many degrees, or centimetres (glTF alone: the other "
            "formats hold every frame).",
        ),
    ] = None

    def read(self) -> motiondb.MotionChanges:
        """The changes, with the joint map read from its file."""
        as_added = self.unit == "as-added"
        metres = None if self.unit is None or as_added else motiondb.unit_from_name(self.unit)
        names = {} if self.joint_map is None else motiondb.read_joint_map(self.joint_map)
        return motiondb.MotionChanges(
            metres,
            self.fps,
            self.loop,
            self.in_place,
            self.mirror,
            self.onto,
            names,
            own_unit=as_added,
            speed=self.speed,
            reduce_keys=self.reduce_keys,
        )


def protect(forced: bool) -> None:
    """Protect files of others in this context, unless --force; an eager option is first."""
    motiondb.protect_others(not forced)


Force = Annotated[
    bool,
    typer.Option(
        "--force",
        is_eager=True,
        callback=protect,
        help="Also overwrite files that motiondb is not known to have written.",
    ),
]
Seed = Annotated[
    int,
    typer.Option(
        "--seed", min=0, max=2**63 - 1, help="Random seed; the same seed gives the same result."
    ),
]
# Seconds that a command waits for the database by default: most commands that hold it alone take
# less time, and after a longer wait the user should see which process holds it
DEFAULT_WAIT = 5.0
LONGEST_WAIT = 86_400.0  # Largest number of seconds to wait: a day. A larger one is a mistake
Cluster = Annotated[
    str | None,
    typer.Option(
        "--cluster",
        metavar="ADDRESS",
        envvar="MOTIONDB_CLUSTER",
        help="Compute on the workers of a dask scheduler, tcp://HOST:8786, or on processes of this "
        "machine (local); the answers are the same.",
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print the answer as JSON.")]
Wait = Annotated[
    float,
    typer.Option(
        "--wait",
        envvar="MOTIONDB_WAIT",
        min=0.0,
        max=LONGEST_WAIT,
        help="Seconds to wait for a database that another process holds.",
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

    db: Annotated[
        Path,
        typer.Option("--db", envvar="MOTIONDB", callback=database_name, help="The database file."),
    ] = Path("motions.duckdb")
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
        typer.Option(
            "--db",
            callback=database_name,
            help="Also list the clips of this database for every action.",
        ),
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
    with motiondb.MotionDB(path, read_only=not writing, create=create, wait=wait) as db:
        printing.note(db.store.log_note)
        try:
            yield db
            printing.note(db.session.damage_note)
        finally:
            for sentence in db.store.notes:
                printing.note(sentence)
    printing.note(db.store.log_note)


class Group(typer.core.TyperGroup):
    """The group of all commands, whose help ends with examples."""

    def __init__(self, *args: Any, **settings: Any) -> None:
        super().__init__(*args, **settings)
        from motiondb.cli.examples import add_examples

        add_examples(self)


class Commands(typer.Typer):
    """A Typer app whose commands have the shared options if they take them as one parameter."""

    def command(self, *args: Any, **options: Any) -> Callable[[Function], Function]:
        """Register a function as a command."""
        return _with_options(super().command(*args, **options))

    def callback(self, *args: Any, **options: Any) -> Callable[[Function], Function]:
        """Register the function that a group runs before its commands, or alone."""
        return _with_options(super().callback(*args, **options))

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


def _check_number(annotation: Any) -> None:
    """Let an option for a number refuse NaN and infinity."""
    for option in getattr(annotation, "__metadata__", ()):
        kinds = (annotation.__origin__, *get_args(annotation.__origin__))
        if isinstance(option, OptionInfo) and float in kinds:
            option.callback = finite


def _with_options(
    register: Callable[[Callable[..., Any]], object],
) -> Callable[[Function], Function]:
    """Register a function with an option for each field of its parameters that are dataclasses."""

    def decorate(function: Function) -> Function:
        known = dict(signature(function, eval_str=True).parameters)
        writes = any(WRITTEN in getattr(p.annotation, "__metadata__", ()) for p in known.values())
        kinds: dict[str, Any] = {n: p.annotation for n, p in known.items()}
        kinds = {name: kind for name, kind in kinds.items() if is_dataclass(kind)}
        for name in sorted(kinds, key="shared".__eq__):  # those of every command come last
            del known[name]
            hints = get_type_hints(kinds[name], include_extras=True)
            for field in fields(kinds[name]):
                known[field.name] = _option(field.name, field.default, hints[field.name])
        if writes and kinds:
            known["force"] = _option("force", False, Force)
        for parameter in known.values():
            _check_number(parameter.annotation)

        @wraps(function)
        def command(*args: Any, **values: Any) -> Any:
            values.pop("force", None)  # its callback has heard it
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
