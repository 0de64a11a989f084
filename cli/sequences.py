"""Commands grammar generate and edit: new sequences that a grammar derives."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

import motiondb
from motiondb import answers
from motiondb.cli import options, printing

app = options.Commands()


@app.command()
def generate(
    shared: options.Shared,
    name: options.GrammarName,
    output: options.Output,
    seed: options.Seed = 0,
    length: Annotated[
        int | None,
        options.option(
            "Number of terminals; the nearest possible number is used.", min=1, max=10_000
        ),
    ] = None,
    seconds: Annotated[
        float | None,
        options.option(
            "Let sentences follow one another until the motion is about this long.",
            min=0.1,
            max=600.0,
        ),
    ] = None,
    like: Annotated[
        str | None,
        'Pattern of terminals and words, such as "a ... ? b" (? is any one,'
        " ... any number), or a sentence in words.",
    ] = None,
    exact: options.Exact = False,
    save: options.SaveAs = None,
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
            base.captures.check_name_free(save)
        if like is not None and not exact:
            printing.note_taken(base.grammars.taken_in_pattern(name, like).values())
        how: dict[str, object]
        if seconds is not None:
            made, how = base.grammars.chain(name, seconds, seed), {"seconds": seconds}
        else:
            made = base.grammars.generate(name, seed, length, like, exact)
            how = {"length": length} if like is None else {"like": like}
        facts = _hand_out(base, made, seed, output, png, save, how)
        if html:
            printing.write_html(html, motiondb.StandalonePage.of_sequence(base, made, seed))
    if not printing.as_json(shared, facts):
        _say_made(facts)
        if length is not None and length != len(made.string):
            printing.warn(
                f"note: no sentence has {length} terminals; the nearest has {len(made.string)}",
            )


@app.command()
def edit(
    shared: options.Shared,
    name: options.GrammarName,
    sequence: Annotated[
        str, options.argument('A kept sequence\'s name, or terminals "a b c".', "SEQUENCE")
    ],
    at: Annotated[int, options.option("Position to edit, from 0.", min=0)],
    wider: Annotated[
        int, options.option("Enlarge the region by this many levels of the tree.", min=0)
    ] = 0,
    narrower: Annotated[
        int, options.option("Then reduce it by this many levels of the tree.", min=0)
    ] = 0,
    number: Annotated[int, options.option("Number of alternatives.", min=1, max=10_000)] = 4,
    choose: Annotated[
        int | None, options.option("The alternative to choose, from 1.", min=1)
    ] = None,
    output: Annotated[
        Path | None,
        options.output(
            "File for the chosen alternative; without --choose one for each.", options.motion_name
        ),
    ] = None,
    save: Annotated[str | None, "Also save the chosen one as a capture of this name."] = None,
    png: Annotated[Path | None, options.picture("Draw the trees of the alternatives.")] = None,
    seed: options.Seed = 0,
) -> None:
    """Offer alternatives for a region of a sequence; the rest does not change.

    The same seed gives the same alternatives: list them first, then --choose one.
    """
    if save is not None and choose is None:
        raise motiondb.QueryError(
            "edit: expected a choice to keep, found --save alone. Add --choose N."
        )
    if choose is not None and output is None and save is None:
        raise motiondb.QueryError(
            "edit: expected -o FILE or --save NAME with --choose, found neither."
        )
    if choose is not None:
        options.output_name(output)
    with shared.database(writing=save is not None) as base:
        if save is not None:
            base.captures.check_name_free(save)
        edited = base.grammars.edit(name, sequence, at, (wider, narrower), number, seed)
        if png:
            base.grammars.draw_edit(name, edited, png)
        if choose is None:
            offered = _offer(base, name, edited, seed, output)
            if not printing.as_json(shared, offered):
                _say_offer(offered)
            return
        how: dict[str, object] = {"edited": sequence, "at": at, "wider": wider}
        how |= {"narrower": narrower, "number": number, "choose": choose}
        made = base.grammars.play(name, edited, choose - 1)
        facts = _hand_out(base, made, seed, output, None, save, how)
    if not printing.as_json(shared, facts):
        _say_made(facts)


def _hand_out(
    base: motiondb.MotionDB,
    made: motiondb.GrammarSequence,
    seed: int,
    output: Path | None,
    png: Path | None,
    save: str | None,
    how: dict[str, object],
) -> answers.WrittenSequence:
    """Write, draw and save a sequence, each if a path or a name is given; return its facts."""
    facts = _written(base, made, seed, output)
    if png:
        base.grammars.draw_sequence(made, png)
    if save is not None:  # last, so that nothing is saved if a file cannot be written
        base.grammars.save(save, made, seed, how)
    return replace(facts, capture=save)


def _offer(
    base: motiondb.MotionDB, name: str, edited: motiondb.Edit, seed: int, output: Path | None
) -> answers.OfferedEdits:
    """Play the alternatives; write them as NAME-1, NAME-2, ... if an output is named.

    An alternative that cannot be played because captures were removed is listed with the reason. If
    none can be played, the first reason is raised.
    """
    rows: list[answers.Alternative | answers.Unplayable] = []
    faults = []
    for number, other in enumerate(edited.alternatives):
        known: Any = {"region": other.string, "log_probability": other.log_probability}
        try:
            made = base.grammars.play(name, edited, number)
        except motiondb.QueryError as fault:
            faults.append(fault)
            string = edited.tree(number).leaves()
            rows.append(answers.Unplayable(string=string, not_playable=str(fault), **known))
            continue
        file = output and options.numbered(output, number + 1)
        rows.append(
            answers.extended(answers.Alternative, _written(base, made, seed, file), **known)
        )
    if rows and len(faults) == len(rows):
        raise faults[0]
    string = edited.before.leaves()
    return answers.OfferedEdits(
        grammar=name, string=string, region=edited.region, alternatives=rows
    )


def _written(
    base: motiondb.MotionDB, made: motiondb.GrammarSequence, seed: int, output: Path | None
) -> answers.WrittenSequence:
    """Return the facts of the motion, which is written if a file is named."""
    if output:
        return base.grammars.write(made, output, seed)
    return answers.extended(answers.WrittenSequence, base.grammars.facts(made, seed))


def _say_offer(offered: answers.OfferedEdits) -> None:
    string, edited = offered.string, offered.region
    start, end = edited.start, edited.end
    marked = [*string[:start], "[", *string[start:end], "]", *string[end:]]
    printing.say(f"{' '.join(marked)}   {edited.symbol} derives {start} to {end - 1}")
    if not offered.alternatives:
        more = ": try a wider region (--wider)" if edited.path else ""
        printing.say(f"nothing else is possible there{more}")
        return
    rows = []
    for number, one in enumerate(offered.alternatives, start=1):
        made = ["", "", ""]
        if not isinstance(one, answers.Unplayable):
            made = [f"{one.seconds:.2f}", f"{one.join_cost:.2f}", one.output or ""]
        region = " ".join(one.region) or "nothing"
        rows.append([number, region, f"{one.log_probability:.2f}", *made])
    columns = ["rank", "region", "log probability", "seconds", "join cost", "file"]
    used = len(columns) if any(row[-1] for row in rows) else len(columns) - 1
    printing.print_table(columns[:used], [row[:used] for row in rows])
    for number, one in enumerate(offered.alternatives, start=1):
        if isinstance(one, answers.Unplayable):
            printing.warn(f"note: {number} cannot be played: {one.not_playable}")


def _say_made(facts: answers.WrittenSequence) -> None:
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
    printing.say(facts.says)
    printing.say(
        f"seams cost {facts.join_cost:.2f}; feet slip {100 * facts.foot_slip:.1f} cm/s, "
        f"in the sources {100 * facts.foot_slip_of_sources:.1f}"
    )
    printing.print_sources(facts.sources)
    if facts.provenance:
        printing.say(f"every frame's origin: {facts.provenance}")
