"""scene make, update, report, list, remove: animated scenes from tactics diagrams."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from motiondb.cli.options import (
    DEFAULT_DB,
    Db,
    Json,
    Png,
    Seed,
    database,
    finite,
    print_json,
    print_table,
)

if TYPE_CHECKING:
    from motiondb.database.motion_db import MotionDB
    from motiondb.database.scenes.scene_verbs import Scene
    from motiondb.store import StoredScene

DiagramFile = Annotated[
    str, typer.Argument(metavar="DIAGRAM", help="A tactics file, or one like give-and-go.")
]
Folder = Annotated[Path, typer.Option("--out", "-o", help="The folder to write.")]
Rounds = Annotated[
    int,
    typer.Option(
        "--rounds",
        min=1,
        max=1_000_000,
        help="Rounds of sampling, at most; the seed then fixes the scene.",
    ),
]
Minutes = Annotated[
    float | None,
    typer.Option(
        "--minutes", min=0.0001, max=10_000.0, callback=finite,
        help="Cut sampling short after this time, and say so; else never.",
    ),
]  # fmt: skip
Chains = Annotated[
    int,
    typer.Option("--chains", help="Number of Markov chains, at different temperatures, 1 to 64."),
]
Name = Annotated[
    str,
    typer.Option("--name", help="Also keep it in the database, with its motions as NAME/PLAYER."),
]
Gaze = Annotated[bool, typer.Option("--gaze/--no-gaze", help="Whether heads follow the ball.")]
Drawn = Annotated[
    bool, typer.Option("--pictures/--no-pictures", help="Draw paths.png, above.gif and scene.gif.")
]
Place = Annotated[
    str, typer.Argument(metavar="SCENE", help="The folder of a scene, or the name of a kept scene.")
]


def register(group: typer.Typer) -> None:
    """Add the commands to the group.

    Parameters
    ----------
    group : typer.Typer
        The group ``scene``.
    """
    for command in (make, update, report):
        group.command(command.__name__)(command)
    group.command("list")(list_scenes)
    group.command("remove")(remove)


def make(
    file: DiagramFile,
    out: Folder,
    seed: Seed = 0,
    rounds: Rounds = 70,
    minutes: Minutes = None,
    chains: Chains = 4,
    name: Name = "",
    gaze: Gaze = True,
    drawn: Drawn = True,
    db: Db = DEFAULT_DB,
    json: Json = False,
) -> None:
    """Make an animated scene from a tactics diagram, with a report of every rule's error."""
    from motiondb.database.scenes.scene_files import read_tactics
    from motiondb.database.scenes.scene_verbs import SceneSettings, check_folder

    settings = SceneSettings(seed=seed, chains=chains, rounds=rounds, minutes=minutes, gaze=gaze)
    check_folder(out)
    began = time.monotonic()
    with database(db, writing=bool(name)) as base, scene_progress(not json) as tell:
        if name:
            base.scenes.check_name(name, read_tactics(file).player)
        scene = base.scenes.make(file, settings, tell, name)
        _finish(base, scene, out, bool(name), drawn, tell)
    _print(scene, out, time.monotonic() - began, json)
    _refuse_impossible(scene.record)


def update(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="The folder of a scene.")],
    file: DiagramFile,
    seed: Annotated[
        int | None,
        typer.Option("--seed", min=0, max=2**63 - 1, help="A seed other than the scene's."),
    ] = None,
    minutes: Minutes = None,
    name: Name = "",
    drawn: Drawn = True,
    db: Db = DEFAULT_DB,
    json: Json = False,
) -> None:
    """Make the scene of a folder again for a changed diagram, starting from the present scene."""
    from dataclasses import replace

    from motiondb.database.scenes.scene_files import read_tactics
    from motiondb.database.scenes.scene_verbs import SceneSettings, check_folder

    began = time.monotonic()
    with database(db, writing=bool(name)) as base, scene_progress(not json) as tell:
        earlier = base.scenes.find(folder)
        check_folder(folder)
        if name:
            base.scenes.check_name(name, read_tactics(file).player)
        settings = replace(SceneSettings(**earlier.settings), minutes=minutes)
        settings = settings if seed is None else replace(settings, seed=seed)
        earlier = replace(earlier, name=name) if name else earlier
        scene = base.scenes.update(earlier, file, settings, tell)
        _finish(base, scene, folder, bool(name), drawn, tell)
    _print(scene, folder, time.monotonic() - began, json)
    _refuse_impossible(scene.record)


def _finish(
    base: MotionDB,
    scene: Scene,
    folder: Path,
    kept: bool,
    drawn: bool,
    tell: Callable[[str, float, float], None],
) -> None:
    """Write the folder, and keep the scene if it has a name."""
    base.scenes.write(scene, folder, tell, drawn, kept)


def _print(scene: Scene, folder: Path, seconds: float, json: bool) -> None:
    from motiondb.database.scenes.scene_reports import (
        cut_short_lines,
        impossible_lines,
        report_facts,
    )

    facts = report_facts(scene.record)
    work = {what: round(took, 3) for what, took in scene.made.seconds.items()}
    if json:
        print_json(facts | {"folder": str(folder), "took": work | {"all": round(seconds, 3)}})
        return
    typer.echo(
        f"{scene.record.name}: {facts['characters']} characters, {facts['clips']} clips,"
        f" {facts['frames']} frames ({facts['seconds']:.1f} s), in {folder}"
    )
    took = ", ".join(f"{what} {time:.1f} s" for what, time in work.items())
    typer.echo(f"error {facts['error']:.2f} before polish; {took}")
    for line in cut_short_lines(scene.record):
        typer.echo(line)
    touching = len(facts["collisions"])
    typer.echo(
        f"rules kept: {facts['rules'] - facts['broken']} of {facts['rules']};"
        f" collisions: {touching or 'none'}"
    )
    for line in impossible_lines(scene.record.report):
        typer.echo(line)
    if facts["too_fast"]:
        typer.echo(f"  faster than people go: {', '.join(facts['too_fast'])}")
    for rule in scene.broken:
        typer.echo(
            f"  broken: {rule.kind} of {rule.player} at {rule.action} ({rule.clip + 1}),"
            f" (about {rule.about}), {rule.after:.2f} {rule.unit} where {rule.threshold:.2f} is"
            " allowed"
        )


def _refuse_impossible(record: StoredScene) -> None:
    """Exit with 1 if a scene has motion that people cannot do; its frames are in the output."""
    if record.report.get("impossible"):
        raise typer.Exit(1)


def report(place: Place, png: Png = None, db: Db = DEFAULT_DB, json: Json = False) -> None:
    """Report how well a scene keeps each rule, collisions, and the sources of its motion."""
    from motiondb.database.scenes.scene_folder import read_scene_folder
    from motiondb.database.scenes.scene_reports import report_facts, report_text
    from motiondb.file_names import is_folder

    if is_folder(place):
        record = read_scene_folder(Path(place))
        if png:
            from motiondb.database.scenes.scene_folder import draw_folder

            draw_folder(Path(place), png)
    else:
        with database(db) as base:
            record = base.scenes.load(place)
            if png:
                base.scenes.draw(place, png)
    if json:
        print_json(report_facts(record) | ({"picture": str(png)} if png else {}))
    else:
        typer.echo(report_text(record))
    _refuse_impossible(record)


def list_scenes(db: Db = DEFAULT_DB, json: Json = False) -> None:
    """List the scenes that are kept in the database."""
    from motiondb.database.scenes.scene_reports import report_facts

    with database(db) as base:
        facts = [report_facts(base.scenes.load(name)) for name in base.scenes.names()]
    if json:
        keys = ("scene", "characters", "clips", "frames", "seconds", "error", "rules", "broken")
        print_json([{key: fact[key] for key in keys} for fact in facts])
        return
    if not facts:
        typer.echo("no scenes; motiondb scene make DIAGRAM -o FOLDER --name NAME keeps one")
        return
    print_table(
        "",
        ["scene", "characters", "clips", "seconds", "error", "broken rules"],
        [
            [
                fact["scene"], str(fact["characters"]), str(fact["clips"]),
                f"{fact['seconds']:.1f}", f"{fact['error']:.2f}", str(fact["broken"]),
            ]
            for fact in facts
        ],
    )  # fmt: skip


def remove(
    name: Annotated[str, typer.Argument(metavar="NAME", help="The name of a kept scene.")],
    db: Db = DEFAULT_DB,
    json: Json = False,
) -> None:
    """Remove a kept scene and its players' motions from the database; folders stay."""
    with database(db, writing=True) as base:
        captures = base.scenes.remove(name)
    if json:
        print_json({"removed": name, "captures": captures})
    else:
        typer.echo(f"removed {name} with {', '.join(captures) or 'no captures'}")


@contextmanager
def scene_progress(enabled: bool) -> Iterator[Callable[[str, float, float], None]]:
    """Show progress on standard error: call with what is done, the fraction done, the error."""
    if not enabled:
        yield lambda _what, _share, _error: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (
        TextColumn("{task.description:18}"),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f} %"),
        TextColumn("{task.fields[error]:14}"),
    )
    with Progress(*columns, TimeElapsedColumn(), console=Console(stderr=True)) as bar:
        tasks: dict[str, Any] = {}

        def tell(what: str, share: float, error: float) -> None:
            for name, task in tasks.items():
                if name != what:
                    bar.update(task, completed=1.0)
                    bar.stop_task(task)
            shown = "" if math.isnan(error) else f"error {error:8.2f}"
            if what not in tasks:
                tasks[what] = bar.add_task(what, total=1.0, error=shown)
            bar.update(tasks[what], completed=min(share, 1.0), error=shown)

        yield tell
        for task in tasks.values():
            bar.update(task, completed=1.0)
