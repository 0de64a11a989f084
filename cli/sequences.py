"""Commands grammar generate and edit: new sequences that a grammar derives."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from motiondb.cli import options, printing

if TYPE_CHECKING:
    from motiondb import Edit, GrammarSequence, MotionDB
    from motiondb.answers.grammars import OfferedEdits, WrittenSequence

Save = Annotated[str | None, typer.Option("--save", help="Also save it as a capture of this name.")]
TreesPng = Annotated[
    Path | None,
    typer.Option(
        "--png", callback=options.picture_name, help="Draw the trees of the alternatives."
    ),
    options.WRITTEN,
]


def register(group: typer.Typer) -> None:
    """Add the commands to the group."""
    group.command("generate")(generate)
    group.command("edit")(edit)


def generate(
    shared: options.Shared,
    name: options.GrammarName,
    output: options.Output,
    seed: options.Seed = 0,
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
    exact: options.Exact = False,
    save: Save = None,
    png: options.Png = None,
    html: options.Html = None,
) -> None:
    """Generate a new sequence that the grammar derives; a file beside it names its sources."""
    if seconds is not None and (length is not None or like is not None):
        raise typer.BadParameter("expected --seconds alone, found --length or --like beside it.")
    with (
        shared.database(writing=save is not None) as base,
        printing.progress(shared) as tell,
    ):
        tell("generating", 0.0, 1.0)
        options.output_name(output)
        if save is not None:
            base.check_name_free(save)
        printing.note_pattern(base.grammars, name, like, exact)
        how: dict[str, object]
        if seconds is not None:
            made, how = base.grammars.chain(name, seconds, seed), {"seconds": seconds}
        else:
            made = base.grammars.generate(name, seed, length, like, exact)
            how = {"length": length} if like is None else {"like": like}
        facts = _hand_out(base, made, seed, (output, png), save, how)
        if html:
            from motiondb import StandalonePage

            printing.write_html(html, StandalonePage.of_sequence(base, made, seed))
    if not printing.as_json(shared, facts):
        _say_made(facts)
        if length is not None and length != len(made.string):
            printing.warn(
                f"note: no sentence has {length} terminals; the nearest has {len(made.string)}",
            )


def edit(
    shared: options.Shared,
    name: options.GrammarName,
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
            "-o",
            "--output",
            callback=options.motion_name,
            help="File for the chosen alternative; without --choose one for each.",
        ),
        options.WRITTEN,
    ] = None,
    save: Annotated[
        str | None,
        typer.Option("--save", help="Also save the chosen one as a capture of this name."),
    ] = None,
    png: TreesPng = None,
    seed: options.Seed = 0,
) -> None:
    """Offer alternatives for a region of a sequence; the rest does not change.

    The same seed gives the same alternatives: list them first, then --choose one.
    """
    from motiondb import QueryError

    if save is not None and choose is None:
        raise QueryError("edit: expected a choice to keep, found --save alone. Add --choose N.")
    if choose is not None and output is None and save is None:
        raise QueryError("edit: expected -o FILE or --save NAME with --choose, found neither.")
    if choose is not None:
        options.output_name(output)
    with shared.database(writing=save is not None) as base:
        if save is not None:
            base.check_name_free(save)
        edited = base.grammars.edit(name, sequence, at, (wider, narrower), number, seed)
        if png:
            base.grammars.draw_edit(name, edited, png)
        if choose is None:
            offered = _offer(base, name, edited, seed, output)
            if not printing.as_json(shared, offered):
                _say_offer(offered)
            return
        how = {
            "edited": sequence,
            "at": at,
            "wider": wider,
            "narrower": narrower,
            "number": number,
            "choose": choose,
        }
        made = base.grammars.play(name, edited, choose - 1)
        facts = _hand_out(base, made, seed, (output, None), save, how)
    if not printing.as_json(shared, facts):
        _say_made(facts)


def _hand_out(
    base: MotionDB,
    made: GrammarSequence,
    seed: int,
    paths: tuple[Path | None, Path | None],
    save: str | None,
    how: dict[str, object],
) -> WrittenSequence:
    """Write, draw and save a sequence, each if a path or a name is given; return its facts."""
    output, png = paths
    facts = _written(base, made, seed, output)
    if png:
        base.grammars.draw_sequence(made, png)
    if save is not None:  # last, so that nothing is saved if a file cannot be written
        base.grammars.save(save, made, seed, how)
    return replace(facts, capture=save)


def _offer(base: MotionDB, name: str, edited: Edit, seed: int, output: Path | None) -> OfferedEdits:
    """Play the alternatives; write them as NAME-1, NAME-2, ... if an output is named.

    An alternative that cannot be played because captures were removed is listed with the reason. If
    none can be played, the first reason is raised.
    """
    from motiondb import QueryError
    from motiondb.answers.grammars import Alternative, OfferedEdits, Unplayable
    from motiondb.answers.plain import extended

    rows: list[Alternative | Unplayable] = []
    faults = []
    for number, other in enumerate(edited.alternatives):
        known: Any = {"region": other.string, "log_probability": other.log_probability}
        try:
            made = base.grammars.play(name, edited, number)
        except QueryError as fault:
            faults.append(fault)
            string = edited.tree(number).leaves()
            rows.append(Unplayable(string=string, not_playable=str(fault), **known))
            continue
        file = output and options.numbered(output, number + 1)
        rows.append(extended(Alternative, _written(base, made, seed, file), **known))
    if rows and len(faults) == len(rows):
        raise faults[0]
    string = edited.before.leaves()
    return OfferedEdits(grammar=name, string=string, region=edited.region, alternatives=rows)


def _written(
    base: MotionDB, made: GrammarSequence, seed: int, output: Path | None
) -> WrittenSequence:
    """Return the facts of the motion, which is written if a file is named."""
    from motiondb.answers.grammars import WrittenSequence
    from motiondb.answers.plain import extended

    if output:
        return base.grammars.write(made, output, seed)
    return extended(WrittenSequence, base.grammars.facts(made, seed))


def _say_offer(offered: OfferedEdits) -> None:
    from motiondb.answers.grammars import Unplayable

    string, region = offered.string, offered.region
    start, end = region.start, region.end
    marked = [*string[:start], "[", *string[start:end], "]", *string[end:]]
    printing.say(f"{' '.join(marked)}   {region.symbol} derives {start} to {end - 1}")
    if not offered.alternatives:
        more = ": try a wider region (--wider)" if region.path else ""
        printing.say(f"nothing else is possible there{more}")
        return
    rows = []
    for number, one in enumerate(offered.alternatives, start=1):
        row = [str(number), " ".join(one.region) or "nothing", f"{one.log_probability:.2f}"]
        if isinstance(one, Unplayable):
            rows.append([*row, "", "", ""])
        else:
            rows.append([*row, f"{one.seconds:.2f}", f"{one.join_cost:.2f}", one.output or ""])
    columns = ["rank", "region", "log probability", "seconds", "join cost", "file"]
    used = len(columns) if any(row[-1] for row in rows) else len(columns) - 1
    printing.print_table("", columns[:used], [row[:used] for row in rows])
    for number, one in enumerate(offered.alternatives, start=1):
        if isinstance(one, Unplayable):
            printing.warn(f"note: {number} cannot be played: {one.not_playable}")


def _say_made(facts: WrittenSequence) -> None:
    where = f" written to {facts.output}" if facts.output else ""
    kept = f", kept as {facts.capture}" if facts.capture else ""
    printing.say(f"{facts.seconds:.2f} s of motion{where}{kept} (seed {facts.seed})")
    printing.say(f"string: {' '.join(facts.string)}")
    printing.say(f"tree:   {facts.tree}")
    if facts.sentences > 1:
        edited = "; a chain cannot be edited" if facts.capture else ""
        printing.say(
            f"{facts.sentences} sentences follow one another, each drawn by itself{edited}"
        )
    printing.say(
        f"seams cost {facts.join_cost:.2f}; feet slip {100 * facts.foot_slip:.1f} cm/s, "
        f"in the sources {100 * facts.foot_slip_of_sources:.1f}"
    )
    printing.print_sources(facts.sources)
    if facts.provenance:
        printing.say(f"every frame's origin: {facts.provenance}")
