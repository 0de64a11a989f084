"""Commands check, rescue, info, compact and knowledge: the database file, and what it learned."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path
from typing import Annotated

import typer

import motiondb
from motiondb import answers
from motiondb.cli import options, printing

app = options.Commands()
knowing = app.group("knowledge", "Export what was learned, without motion and captions.")


@app.command()
def check(
    shared: options.Shared,
    quick: Annotated[bool, "Do not read motions, scores and stored files."] = False,
) -> None:
    """Check the database for faults; exit 1 if there are any."""
    faults = motiondb.check_file(shared.db, wait=shared.wait, quick=quick)
    if shared.json:
        printing.as_json(shared, answers.Faults(faults))
    elif not faults:
        said = "no faults found; motions, scores and stored files were not read"
        printing.say(f"{shared.db}: {said}" if quick else f"{shared.db} is sound")
    printing.refuse(faults)


@app.command()
def rescue(
    shared: options.Shared,
    file: Annotated[
        Path | None, options.argument("The damaged database; by default --db.", "FILE")
    ] = None,
    output: Annotated[
        Path, options.option("The new database, a new file.", "-o", "--output")
    ] = Path("rescued.duckdb"),
) -> None:
    """Save every readable capture of a damaged database into a new file; exit 1 if any is lost."""
    report = motiondb.rescue(file or shared.db, output, wait=shared.wait)
    if not printing.as_json(shared, report):
        saved = printing.number(len(report.captures), "capture")
        printing.say(f"{saved} saved in {report.output}")
        if report.was_learned:
            printing.say(f"Learn again: motiondb learn --db {report.output}")
    for sentence in (*report.mended, *report.lost):
        printing.warn(f"  {sentence}")
    if report.lost:
        raise typer.Exit(1)


@app.command()
def info(shared: options.Shared) -> None:
    """Show what the database contains and the commands that changed it."""
    with shared.database() as base:
        facts, runs, drift = base.info(), base.runs(), base.symbols.drift()
    if printing.as_json(shared, facts, drift=drift, runs=runs):
        return
    for key, value in vars(facts).items():
        if value is None or key in ("start", "compact_pays"):
            continue
        if key == "current":
            printing.say(f"{'learned data out of date:':22} {'no' if value else 'yes'}")
        elif key.endswith("bytes"):
            what = {"bytes": "size", "unused_bytes": "reclaimable"}.get(key)
            what = what or key.removesuffix("_bytes")
            more = " (motiondb compact)" if key == "unused_bytes" else ""
            printing.say(f"{what + ':':22} {value / 1e6:.1f} MB{more}")
        else:
            shown = ", ".join(value) if isinstance(value, list) else value
            printing.say(f"{key.replace('_', ' ') + ':':22} {shown}")
    if facts.start:
        print_start(facts.start)
    for run in runs[-10:]:
        what = f"run {run['run_id']:<4} {run['kind']:10}"
        printing.say(f"{what} {run['started']} motiondb {run['version']}")
    if facts.compact_pays:
        final = f", and makes {facts.removed} removals final" if facts.removed else ""
        printing.say(
            f"motiondb compact makes it about {facts.unused_bytes / 1e6:.0f} MB smaller{final}."
        )
    if drift is None and facts.learned and not facts.current:
        printing.say("Captures have changed since it learned: run motiondb learn to update it.")
    printing.note_drift(drift)


@app.command()
def compact(
    shared: options.Shared,
    motions_to: Annotated[
        str | None,
        options.option(
            "Move motions, original files and scores of segments there: a folder, a URL of "
            "fsspec such as s3://bucket/motions, or here for the database file.",
            metavar="PLACE",
        ),
    ] = None,
) -> None:
    """Rewrite the database file without the space of removed rows; removals become final.

    With --motions-to, motions, original files and scores of segments lie in Parquet files in a
    folder or at a URL, and the file holds the rest. Captures that are added later, and the scores
    that every learn makes anew, lie in the file until they are moved by the same command.
    """
    with printing.progress(shared) if motions_to is not None else nullcontext() as tell:
        done = motiondb.compact(shared.db, shared.wait, motions_to, tell)
    for sentence in done.notes:
        printing.note(sentence)
    if printing.as_json(shared, done):
        return
    if motions_to is not None:
        printing.say(f"motions or scores of {printing.number(done.moved, 'capture')} moved")
    printing.say(f"{done.before / 1e6:.1f} MB before, {done.after / 1e6:.1f} MB after")
    if done.unused:
        files = printing.number(len(done.unused), "Parquet file")
        printing.say(f"{files} no longer needed. Delete what no copy of the database needs:")
        for path in done.unused:
            printing.say(f"  {path}")


@knowing.command("export")
def export_knowledge(
    shared: options.Shared,
    file: Annotated[Path, options.argument("The file to write.", callback=options.output_name)],
    name: Annotated[str, "Its name.  [default: name of the file]"] = "",
    credit: Annotated[str, "The acknowledgement that users are asked to give."] = "",
) -> None:
    """Write the learned model, without motion and captions (see learn --start)."""
    with shared.database() as base:
        facts = answers.knowledge_answer(base.symbols.export_knowledge(file, name, credit))
    n_bytes = file.stat().st_size
    if printing.as_json(shared, facts, file=file, bytes=n_bytes):
        return
    printing.say(f"{file}: {n_bytes / 1e6:.2f} MB, {say_origin(facts)}")
    printing.say(f"Start from it: motiondb learn --start {file}")


@knowing.command("show")
def show_knowledge(
    shared: options.Shared,
    what: Annotated[
        str | None,
        options.argument(
            "A file, or the shipped knowledge: cmu.  [default: the start of the database]"
        ),
    ] = None,
) -> None:
    """Show the content and origin of knowledge; a file is checked."""
    if what is None:
        with shared.database() as base:
            knowledge = base.symbols.start_knowledge()
    else:
        knowledge = motiondb.load_knowledge(what)
    facts = answers.knowledge_answer(knowledge)
    if printing.as_json(shared, facts, vocabulary=knowledge.words):
        return
    printing.say(say_origin(facts))
    printing.say(f"sha256: {facts.sha256}")
    if facts.credit:
        printing.say(f"credit: {facts.credit}")
    printing.say(f"words: {', '.join(knowledge.words)}")


def say_origin(facts: answers.KnowledgeAnswer) -> str:
    """One line on the origin of knowledge."""
    licences = ", ".join(f"{name} ({n})" for name, n in facts.licences.items())
    return (
        f"{facts.name}: {facts.symbols} symbols and {facts.words} words of "
        f"{facts.captures} captures, {facts.captions} of them described, "
        f"{facts.performers} performers; licences: {licences}; motiondb {facts.version}"
    )


def print_start(first: answers.StartAnswer) -> None:
    """Print the origin of the start of a database and its share."""
    printing.say(f"Started from {say_origin(first)}.")
    if first.own_captions:
        printing.say(
            f"{first.words_of_start_alone} words are of the start alone, "
            f"{first.words_of_both} of both, {first.words_of_own_captions_alone} of own "
            f"captions alone; a caption of the start counts {first.weight:.2g} of an own one."
        )
    else:
        printing.say("No own captions: all words are those of the start.")
    if first.unchecked:
        printing.say(f"Answers carry {first.unchecked}.")
    if not first.fits:
        printing.say(
            f"{first.strange_motion:.0%} of the motion is unlike anything that the symbols of "
            f"the start model: its words are less reliable here."
        )
    if first.credit:
        printing.say(f"Credit: {first.credit}")
