"""Commands scene make, update, report, list and remove: animated scenes from diagrams."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

import motiondb
from motiondb import answers
from motiondb.cli import options, printing

app = options.Commands()


Folder = Annotated[Path, options.option("The folder to write.", "--out", "-o")]
Rounds = Annotated[
    int,
    options.option(
        "Largest number of rounds of sampling; the seed then determines the scene.",
        min=1,
        max=1_000_000,
    ),
]
Minutes = Annotated[
    float | None,
    options.option(
        "Stop sampling after this time, and print a note. [default: no limit]",
        min=0.0001,
        max=10_000.0,
    ),
]
Chains = Annotated[int, "Number of Markov chains, of which the best is kept, 1 to 64."]
Name = Annotated[str, "Also keep it in the database, with its motions as NAME/PLAYER."]
Gaze = Annotated[bool, options.option("Whether heads follow the ball.", "--gaze/--no-gaze")]
Drawn = Annotated[
    bool, options.option("Draw paths.png, above.gif and scene.gif.", "--pictures/--no-pictures")
]
Place = Annotated[
    str, options.argument("The folder of a scene, or the name of a kept scene.", "SCENE")
]


@app.command()
def make(
    shared: options.Shared,
    file: options.DiagramFile,
    out: Folder,
    seed: options.Seed = 0,
    rounds: Rounds = 70,
    minutes: Minutes = None,
    chains: Chains = 4,
    name: Name = "",
    gaze: Gaze = True,
    exact: options.Exact = False,
    drawn: Drawn = True,
    html: options.Html = None,
) -> None:
    """Make an animated scene from a tactics diagram, with a report of every rule's error."""
    settings = motiondb.SceneSettings(seed, chains, rounds, minutes, gaze=gaze, exact=exact)
    motiondb.Scenes.check_folder(out)
    began = time.monotonic()
    with (
        shared.database(writing=bool(name)) as base,
        printing.scene_progress(shared) as tell,
    ):
        text = base.scenes.read_diagram(file)
        if name:
            base.scenes.check_new(name, text, settings)
        taken = {} if exact else base.scenes.taken_words(text.grammar)
        printing.note_taken(taken.values(), text.grammar.name)
        scene = base.scenes.make(file, settings, tell, name)
        base.scenes.write(scene, out, tell, drawn, kept=bool(name))
        if html:
            printing.write_html(html, motiondb.StandalonePage.of_scene(scene, shared.db.name))
    _print(shared, scene, out, time.monotonic() - began)
    _refuse_impossible(scene.record)


@app.command()
def update(
    shared: options.Shared,
    folder: Annotated[Path, options.argument("The folder of a scene.", "DIR")],
    file: options.DiagramFile,
    seed: Annotated[
        int | None, options.option("A seed other than the scene's.", min=0, max=2**63 - 1)
    ] = None,
    minutes: Minutes = None,
    name: Name = "",
    drawn: Drawn = True,
) -> None:
    """Make the scene of a folder again for a changed diagram, starting from its present state."""
    began = time.monotonic()
    with (
        shared.database(writing=bool(name)) as base,
        printing.scene_progress(shared) as tell,
    ):
        earlier = base.scenes.find(folder)
        base.scenes.check_folder(folder)
        if name:
            base.scenes.check_name(name, base.scenes.read_diagram(file).diagram.player)
        settings = replace(motiondb.SceneSettings(**earlier.settings), minutes=minutes)
        settings = settings if seed is None else replace(settings, seed=seed)
        earlier = replace(earlier, name=name) if name else earlier
        scene = base.scenes.update(earlier, file, settings, tell)
        base.scenes.write(scene, folder, tell, drawn, kept=bool(name))
    _print(shared, scene, folder, time.monotonic() - began)
    _refuse_impossible(scene.record)


def _print(shared: options.Shared, scene: motiondb.Scene, folder: Path, seconds: float) -> None:
    facts = motiondb.Scenes.facts(scene.record)
    work = {what: round(took, 3) for what, took in scene.made.seconds.items()}
    took = work | {"all": round(seconds, 3)}
    if printing.as_json(
        shared, answers.extended(answers.WrittenScene, facts, folder=folder, took=took)
    ):
        return
    printing.say(
        f"{scene.record.name}: {facts.characters} characters, {facts.clips} clips,"
        f" {facts.frames} frames ({facts.seconds:.1f} s), in {folder}"
    )
    parts = ", ".join(f"{what} {time:.1f} s" for what, time in work.items())
    printing.say(f"error {facts.error:.2f} before polish; {parts}")
    touching = len(facts.collisions)
    printing.say(
        f"rules kept: {facts.rules - facts.broken} of {facts.rules};"
        f" collisions: {touching or 'none'}"
    )
    for line in motiondb.Scenes.remarks(scene.record):
        printing.say(line)
    if facts.too_fast:
        printing.say(f"  faster than people can move: {', '.join(facts.too_fast)}")
    for rule in scene.broken:
        printing.say(
            f"  broken: {rule.kind} of {rule.player} at {rule.action} ({rule.clip + 1}),"
            f" (about {rule.about}), {rule.after:.2f} {rule.unit} where {rule.threshold:.2f} is"
            " allowed"
        )


def _refuse_impossible(record: motiondb.StoredScene) -> None:
    """Exit with 1 if a scene has motion that people cannot do; its frames are in the output."""
    if record.report.get("impossible"):
        raise typer.Exit(1)


@app.command()
def report(shared: options.Shared, place: Place, png: options.Png = None) -> None:
    """Report how well a scene keeps each rule, collisions, and the sources of its motion."""
    if motiondb.Scenes.is_folder(place):
        record = motiondb.Scenes.read_folder(place)
        if png:
            motiondb.Scenes.draw_folder(place, png)
    else:
        with shared.database() as base:
            record = base.scenes.load(place)
            if png:
                base.scenes.draw(place, png)
    if not printing.as_json(
        shared, answers.extended(answers.DrawnScene, motiondb.Scenes.facts(record), picture=png)
    ):
        printing.say(*motiondb.Scenes.report(record).split("\n"))
    _refuse_impossible(record)


@app.command("list")
def list_scenes(shared: options.Shared) -> None:
    """List the scenes that are kept in the database."""
    with shared.database() as base:
        facts = [base.scenes.facts(base.scenes.load(name)) for name in base.scenes.names()]
    if printing.as_json(shared, map(motiondb.scene_row, facts)):
        return
    if not facts:
        printing.say("no scenes; motiondb scene make DIAGRAM -o FOLDER --name NAME keeps one")
        return
    printing.print_table(
        ["scene", "characters", "clips", "seconds", "error", "broken rules"],
        [
            [f.scene, f.characters, f.clips, f"{f.seconds:.1f}", f"{f.error:.2f}", f.broken]
            for f in facts
        ],
    )


@app.command()
def remove(
    shared: options.Shared,
    name: Annotated[str, options.argument("The name of a kept scene.", "NAME")],
) -> None:
    """Remove a kept scene and its players' motions from the database; folders stay."""
    with shared.database(writing=True) as base:
        captures = base.scenes.remove(name)
    if not printing.as_json(shared, answers.Removed(name, captures)):
        printing.say(f"removed {name} with {', '.join(captures) or 'no captures'}")
