"""Commands grammar generate and edit: new sequences that a grammar derives."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from motiondb.cli.options import (
    DEFAULT_DB,
    Db,
    Exact,
    GrammarName,
    Html,
    Json,
    Png,
    Seed,
    database,
    picture_name,
)
from motiondb.cli.printing import (
    note_pattern,
    print_json,
    print_table,
    progress,
    write_html,
)

if TYPE_CHECKING:
    from motiondb import Edit, GrammarSequence, MotionDB

Save = Annotated[str | None, typer.Option("--save", help="Also save it as a capture of this name.")]
TreesPng = Annotated[
    Path | None,
    typer.Option("--png", callback=picture_name, help="Draw the trees of the alternatives."),
]


def register(group: typer.Typer) -> None:
    """Add the commands to the group."""
    group.command("generate")(generate)
    group.command("edit")(edit)


def generate(
    name: GrammarName,
    output: Annotated[Path, typer.Option("-o", "--output", help="File: .bvh, .glb or .gltf.")],
    seed: Seed = 0,
    length: Annotated[
        int | None,
        typer.Option(
            "--length",
            min=1,
            max=10_000,
            help="Number of terminals; the nearest possible number is used.",
        ),
    ] = None,
    seconds: Annotated[
        float | None,
        typer.Option(
            "--seconds",
            min=0.1,
            max=600.0,
            help="Let sentences follow one another until the motion is about this long.",
        ),
    ] = None,
    like: Annotated[
        str | None,
        typer.Option(
            "--like",
            help='Pattern of terminals and words, such as "a ... ? b" (? is any one,'
            " ... any number), or a sentence in words.",
        ),
    ] = None,
    exact: Exact = False,
    save: Save = None,
    png: Png = None,
    html: Html = None,
    db: Db = DEFAULT_DB,
    json: Json = False,
) -> None:
    """Generate a new sequence that the grammar derives; a file beside it names its sources."""
    if seconds is not None and (length is not None or like is not None):
        raise typer.BadParameter("expected --seconds alone, found --length or --like beside it.")
    with database(db, writing=save is not None) as base, progress(not json) as tell:
        tell("generating", 0.0, 1.0)
        if save is not None:
            base.check_name_free(save)
        note_pattern(base.grammars, name, like, exact)
        how: dict[str, object]
        if seconds is not None:
            made, how = base.grammars.chain(name, seconds, seed), {"seconds": seconds}
        else:
            made = base.grammars.generate(name, seed, length, like, exact)
            how = {"length": length} if like is None else {"like": like}
        facts = _hand_out(base, made, seed, (output, png), save, how)
        if html:
            from motiondb import StandalonePage

            write_html(html, StandalonePage.of_sequence(base, made, seed))
    if json:
        print_json(facts)
    else:
        _say_made(facts, output)
        if length is not None and length != len(made.string):
            typer.echo(
                f"note: no sentence has {length} terminals; the nearest has {len(made.string)}",
                err=True,
            )


def edit(
    name: GrammarName,
    sequence: Annotated[
        str,
        typer.Argument(metavar="SEQUENCE", help='A kept sequence\'s name, or terminals "a b c".'),
    ],
    at: Annotated[int, typer.Option("--at", min=0, help="Position to edit, from 0.")],
    wider: Annotated[
        int,
        typer.Option("--wider", min=0, help="Enlarge the region by this many levels of the tree."),
    ] = 0,
    narrower: Annotated[
        int,
        typer.Option("--narrower", min=0, help="Then reduce it by this many levels of the tree."),
    ] = 0,
    number: Annotated[
        int, typer.Option("--number", min=1, max=10_000, help="Number of alternatives.")
    ] = 4,
    choose: Annotated[
        int | None,
        typer.Option("--choose", min=1, help="The alternative to choose, from 1."),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o", "--output", help="File for the chosen alternative; without --choose one for each."
        ),
    ] = None,
    save: Annotated[
        str | None,
        typer.Option("--save", help="Also save the chosen one as a capture of this name."),
    ] = None,
    png: TreesPng = None,
    seed: Seed = 0,
    db: Db = DEFAULT_DB,
    json: Json = False,
) -> None:
    """Offer alternatives for a region of a sequence; the rest does not change.

    The same seed gives the same alternatives: list them first, then --choose one.
    """
    from motiondb import QueryError

    if save is not None and choose is None:
        raise QueryError("edit: expected a choice to keep, found --save alone. Add --choose N.")
    if choose is not None and output is None and save is None:
        raise QueryError("edit: expected -o FILE or --save NAME with --choose, found neither.")
    with database(db, writing=save is not None) as base:
        if save is not None:
            base.check_name_free(save)
        edited = base.grammars.edit(name, sequence, at, (wider, narrower), number, seed)
        if png:
            base.grammars.draw_edit(name, edited, png)
        if choose is not None:
            made = base.grammars.play(name, edited, choose - 1)
            how = {
                "edited": sequence,
                "at": at,
                "wider": wider,
                "narrower": narrower,
                "number": number,
                "choose": choose,
            }
            facts = _hand_out(base, made, seed, (output, None), save, how)
        else:
            facts = _offer(base, name, edited, seed, output)
    if json:
        print_json(facts)
    elif choose is not None:
        _say_made(facts, output)
    else:
        _say_offer(facts)


def _hand_out(
    base: MotionDB,
    made: GrammarSequence,
    seed: int,
    paths: tuple[Path | None, Path | None],
    save: str | None,
    how: dict[str, object],
) -> dict[str, Any]:
    """Write, draw and save a sequence, each if a path or a name is given; return its facts."""
    output, png = paths
    facts = _written(base, made, seed, output)
    if png:
        base.grammars.draw_sequence(made, png)
    if save is not None:  # last, so that nothing is saved if a file cannot be written
        base.grammars.save(save, made, seed, how)
        facts["capture"] = save
    return facts


def _offer(
    base: MotionDB, name: str, edited: Edit, seed: int, output: Path | None
) -> dict[str, Any]:
    """Play the alternatives; write them as NAME-1, NAME-2, ... if an output is named.

    An alternative that cannot be played because captures were removed is listed with the reason. If
    none can be played, the first reason is raised.
    """
    from motiondb import QueryError

    rows: list[dict[str, Any]] = []
    faults = []
    for number, alternative in enumerate(edited.alternatives):
        known = {
            "region": list(alternative.string),
            "log_probability": alternative.log_probability,
        }
        try:
            made = base.grammars.play(name, edited, number)
        except QueryError as fault:
            faults.append(fault)
            string = list(edited.tree(number).leaves())
            rows.append({"string": string, "not_playable": str(fault)} | known)
            continue
        file = None
        if output:
            file = output.with_name(f"{output.stem}-{number + 1}{output.suffix}")
        rows.append(_written(base, made, seed, file) | known)
    if rows and len(faults) == len(rows):
        raise faults[0]
    return {
        "grammar": name,
        "string": list(edited.before.leaves()),
        "region": edited.region,
        "alternatives": rows,
    }


def _written(
    base: MotionDB, made: GrammarSequence, seed: int, output: Path | None
) -> dict[str, Any]:
    """Return the facts of the motion, which is written if a file is named."""
    if output:
        return base.grammars.write(made, output, seed)
    return dict(vars(base.grammars.facts(made, seed)))


def _say_offer(facts: dict[str, Any]) -> None:
    string, region = facts["string"], facts["region"]
    start, end = region.start, region.end
    marked = [*string[:start], "[", *string[start:end], "]", *string[end:]]
    typer.echo(f"{' '.join(marked)}   {region.symbol} derives {start} to {end - 1}")
    if not facts["alternatives"]:
        more = ": try a wider region (--wider)" if region.path else ""
        typer.echo(f"nothing else is possible there{more}")
        return
    rows = [
        [
            str(number),
            " ".join(row["region"]) or "nothing",
            f"{row['log_probability']:.2f}",
            *(
                [""] * 2
                if "not_playable" in row
                else [f"{row['seconds']:.2f}", f"{row['join_cost']:.2f}"]
            ),
            row.get("output", ""),
        ]
        for number, row in enumerate(facts["alternatives"], start=1)
    ]
    columns = ["rank", "region", "log probability", "seconds", "join cost", "file"]
    used = len(columns) if any(row[-1] for row in rows) else len(columns) - 1
    print_table("", columns[:used], [row[:used] for row in rows])
    for number, row in enumerate(facts["alternatives"], start=1):
        if "not_playable" in row:
            typer.echo(f"note: {number} cannot be played: {row['not_playable']}", err=True)


def _say_made(facts: dict[str, Any], output: Path | None) -> None:
    where = f" written to {output}" if output else ""
    kept = f", kept as {facts['capture']}" if "capture" in facts else ""
    typer.echo(f"{facts['seconds']:.2f} s of motion{where}{kept} (seed {facts['seed']})")
    typer.echo(f"string: {' '.join(facts['string'])}")
    typer.echo(f"tree:   {facts['tree']}")
    if facts["sentences"] > 1:
        edited = "; a chain cannot be edited" if "capture" in facts else ""
        typer.echo(
            f"{facts['sentences']} sentences follow one another, each drawn by itself{edited}"
        )
    typer.echo(
        f"seams cost {facts['join_cost']:.2f}; "
        f"feet slip {100 * facts['foot_slip']:.1f} cm/s, in the sources "
        f"{100 * facts['foot_slip_of_sources']:.1f}"
    )
    from motiondb import to_json

    for source in to_json(facts["sources"]):
        typer.echo(
            f"from {source['capture']}, {source['frames']} frames, licence {source['licence']}"
        )
    if output:
        typer.echo(f"every frame's origin: {facts['provenance']}")
