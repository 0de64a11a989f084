"""Commands scene make, update, report, list and remove: animated scenes from diagrams."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from motiondb.cli.options import DEFAULT_DB, Db, Exact, Html, Json, Png, Seed, database, finite
from motiondb.cli.printing import (
    note_phrases,
    print_json,
    print_table,
    scene_progress,
    write_html,
)

if TYPE_CHECKING:
    from motiondb import Scene, StoredScene

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
        help="Largest number of rounds of sampling; the seed then determines the scene.",
    ),
]
Minutes = Annotated[
    float | None,
    typer.Option(
        "--minutes",
        min=0.0001,
        max=10_000.0,
        callback=finite,
        help="Stop sampling after this time, and print a note. [default: no limit]",
    ),
]
Chains = Annotated[
    int,
    typer.Option("--chains", help="Number of Markov chains, of which the best is kept, 1 to 64."),
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
    """Add the commands to the group."""
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
    exact: Exact = False,
    drawn: Drawn = True,
    html: Html = None,
    db: Db = DEFAULT_DB,
    json: Json = False,
) -> None:
    """Make an animated scene from a tactics diagram, with a report of every rule's error."""
    from motiondb import Scenes, SceneSettings

    settings = SceneSettings(seed, chains, rounds, minutes, gaze=gaze, exact=exact)
    Scenes.check_folder(out)
    began = time.monotonic()
    with database(db, writing=bool(name)) as base, scene_progress(not json) as tell:
        if name:
            base.scenes.check_name(name, base.scenes.read_diagram(file).diagram.player)
        note_phrases(base.scenes, base.scenes.read_diagram(file).grammar, exact)
        scene = base.scenes.make(file, settings, tell, name)
        base.scenes.write(scene, out, tell, drawn, kept=bool(name))
        if html:
            from motiondb import StandalonePage

            write_html(html, StandalonePage.of_scene(scene, db.name))
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
    """Make the scene of a folder again for a changed diagram, starting from its present state."""
    from motiondb import SceneSettings

    began = time.monotonic()
    with database(db, writing=bool(name)) as base, scene_progress(not json) as tell:
        earlier = base.scenes.find(folder)
        base.scenes.check_folder(folder)
        if name:
            base.scenes.check_name(name, base.scenes.read_diagram(file).diagram.player)
        settings = replace(SceneSettings(**earlier.settings), minutes=minutes)
        settings = settings if seed is None else replace(settings, seed=seed)
        earlier = replace(earlier, name=name) if name else earlier
        scene = base.scenes.update(earlier, file, settings, tell)
        base.scenes.write(scene, folder, tell, drawn, kept=bool(name))
    _print(scene, folder, time.monotonic() - began, json)
    _refuse_impossible(scene.record)


def _print(scene: Scene, folder: Path, seconds: float, json: bool) -> None:
    from motiondb import Scenes

    facts = Scenes.facts(scene.record)
    work = {what: round(took, 3) for what, took in scene.made.seconds.items()}
    if json:
        print_json(vars(facts) | {"folder": folder, "took": work | {"all": round(seconds, 3)}})
        return
    typer.echo(
        f"{scene.record.name}: {facts.characters} characters, {facts.clips} clips,"
        f" {facts.frames} frames ({facts.seconds:.1f} s), in {folder}"
    )
    took = ", ".join(f"{what} {time:.1f} s" for what, time in work.items())
    typer.echo(f"error {facts.error:.2f} before polish; {took}")
    touching = len(facts.collisions)
    typer.echo(
        f"rules kept: {facts.rules - facts.broken} of {facts.rules};"
        f" collisions: {touching or 'none'}"
    )
    for line in Scenes.remarks(scene.record):
        typer.echo(line)
    if facts.too_fast:
        typer.echo(f"  faster than people can move: {', '.join(facts.too_fast)}")
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
    from motiondb import Scenes

    if Scenes.is_folder(place):
        record = Scenes.read_folder(place)
        if png:
            Scenes.draw_folder(place, png)
    else:
        with database(db) as base:
            record = base.scenes.load(place)
            if png:
                base.scenes.draw(place, png)
    if json:
        print_json(vars(Scenes.facts(record)) | ({"picture": png} if png else {}))
    else:
        typer.echo(Scenes.report(record))
    _refuse_impossible(record)


def list_scenes(db: Db = DEFAULT_DB, json: Json = False) -> None:
    """List the scenes that are kept in the database."""
    with database(db) as base:
        facts = [base.scenes.facts(base.scenes.load(name)) for name in base.scenes.names()]
    if json:
        from motiondb import scene_row

        print_json([scene_row(fact) for fact in facts])
        return
    if not facts:
        typer.echo("no scenes; motiondb scene make DIAGRAM -o FOLDER --name NAME keeps one")
        return
    print_table(
        "",
        ["scene", "characters", "clips", "seconds", "error", "broken rules"],
        [
            [
                fact.scene,
                str(fact.characters),
                str(fact.clips),
                f"{fact.seconds:.1f}",
                f"{fact.error:.2f}",
                str(fact.broken),
            ]
            for fact in facts
        ],
    )


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
