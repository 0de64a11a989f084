"""Commands grammar learn, list, show, compare and remove."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from motiondb.cli import options, printing

if TYPE_CHECKING:
    from motiondb import GrammarAnswer, GrammarSize


def register(app: typer.Typer) -> None:
    """Add the commands to the app."""
    from motiondb.cli import grammar_edits, parsing, sequences

    group = options.Commands(
        help="Grammars of movement: learn from long takes, parse, suggest, generate, edit.",
        no_args_is_help=True,
    )
    group.command("learn")(learn)
    group.command("list")(list_grammars)
    group.command("show")(show)
    parsing.register(group)
    sequences.register(group)
    grammar_edits.register(group)
    group.command("compare")(compare)
    group.command("remove")(remove)
    app.add_typer(group, name="grammar")


def learn(
    shared: options.Shared,
    captures: Annotated[
        list[str],
        typer.Argument(metavar="CAPTURE...", help="Names of captures, preferably long takes."),
    ],
    terminals: Annotated[
        int | None,
        typer.Option(
            "--terminals",
            min=1,
            help="How many kinds of action (default: by duration, 4 to 20).",
        ),
    ] = None,
    name: Annotated[
        str | None,
        typer.Option("--name", help="Name of the grammar.  [default: the first capture's]"),
    ] = None,
    from_symbols: Annotated[
        bool, typer.Option("--from-symbols", help="Use the learned motion symbols as terminals.")
    ] = False,
    sentences: Annotated[
        str,
        typer.Option(
            "--sentences",
            help="How sentences are found. auto: by search; captures: one per capture; captions: "
            "at the start of captions.",
        ),
    ] = "auto",
    shortest: Annotated[
        int, typer.Option("--shortest", min=1, help="Smallest number of terminals of a sentence.")
    ] = 3,
    longest: Annotated[
        int, typer.Option("--longest", min=1, help="Largest number of terminals of a sentence.")
    ] = 20,
    seed: options.Seed = 0,
) -> None:
    """Learn a grammar from captures: segments, terminals, sentences, rules."""
    from motiondb import GrammarSettings, QueryError
    from motiondb.answers.grammars import GrammarLearnedAnswer
    from motiondb.answers.plain import extended

    if from_symbols and terminals is not None:
        raise QueryError(
            "--terminals: expected no number beside --from-symbols, where every motion symbol is"
            f" a terminal, found {terminals}. Leave one of them out."
        )
    settings = GrammarSettings(
        n_terminals=terminals,
        from_symbols=from_symbols,
        sentences=sentences,
        seed=seed,
        shortest=shortest,
        longest=longest,
    )
    with shared.database(writing=True) as base, printing.progress(shared) as tell:
        learned, lost = base.grammars.learn(captures, name, settings, tell)
        facts = base.grammars.show(learned.name)
        size = base.grammars.size(learned.name)
    if printing.as_json(shared, extended(GrammarLearnedAnswer, facts, no_longer_editable=lost)):
        return
    printing.say(summary(size))
    _say_list(facts)
    _say_lost(lost)


def summary(size: GrammarSize) -> str:
    """Describe a grammar in one line."""
    return (
        f"{size.name}: {_counted(size.captures, 'capture')} ({size.seconds:.0f} s), "
        f"{_counted(size.segments, 'segment')} of {_counted(size.terminals, 'terminal')}, "
        f"{_counted(size.sentences, 'sentence')}, {_counted(size.nonterminals, 'nonterminal')}, "
        f"{_counted(size.rules, 'rule')}, {sum(size.bits.values()):.1f} bits."
    )


def _counted(n: int, what: str) -> str:
    return f"{n} {what}{'s' * (n != 1)}"


def _say_list(facts: GrammarAnswer) -> None:
    """Print a note if the grammar only lists its sentences, with advice."""
    if not facts.derives_new:
        printing.warn(
            f"note: {facts.grammar} only lists its sentences and derives nothing new. More"
            " captures of the same activity, another number of kinds of action (--terminals) or"
            " shorter sentences (--longest) may give it rules.",
        )


def _say_lost(lost: list[str]) -> None:
    if lost:
        printing.warn(
            f"note: {', '.join(lost)} can no longer be edited: the grammar that derived "
            f"{'it' if len(lost) == 1 else 'them'} was removed",
        )


def list_grammars(shared: options.Shared) -> None:
    """List the grammars."""
    from motiondb import grammar_row

    with shared.database() as base:
        sizes = base.grammars.sizes()
    if printing.as_json(shared, [grammar_row(size) for size in sizes]):
        return
    if not sizes:
        printing.say("no grammars yet: motiondb grammar learn CAPTURE...")
    for size in sizes:
        printing.say(summary(size))


def show(
    shared: options.Shared,
    name: options.GrammarName,
    png: Annotated[
        Path | None,
        typer.Option(
            "--png",
            callback=options.picture_name,
            help="Draw the trees of the sentences into this file (.png).",
        ),
        options.WRITTEN,
    ] = None,
    strings: Annotated[
        Path | None,
        typer.Option(
            "--strings",
            callback=options.picture_name,
            help="Draw terminals, and captures as strings, into this file (.png).",
        ),
        options.WRITTEN,
    ] = None,
) -> None:
    """Show a grammar: rules, terminals with their words, and description length in bits."""
    with shared.database() as base:
        facts = base.grammars.show(name)
        size = base.grammars.size(name)
        if png:
            base.grammars.draw_trees(name, png)
        if strings:
            base.grammars.draw_strings(name, strings)
    if printing.as_json(shared, facts):
        return
    printing.say(summary(size))
    printing.say(*facts.text_with_loops.split("\n"))
    rows = [
        [
            t.terminal,
            str(t.count),
            f"{t.seconds:.2f}",
            "  ".join(printing.say_word(w.word, w.probability) for w in t.words),
            "  ".join(f"{s.symbol}: {s.share:.0%}" for s in t.symbols),
            f"{t.medoid.capture} {t.medoid.start:.2f}-{t.medoid.end:.2f} s",
        ]
        for t in facts.terminals
    ]
    columns = ["terminal", "count", "seconds", "words", "motion symbols", "medoid"]
    used = [k for k, _ in enumerate(columns) if any(row[k] for row in rows)]
    printing.print_table("", [columns[k] for k in used], [[row[k] for k in used] for row in rows])
    bits = {part: value for part, value in facts.bits.items() if part != "sum"}
    said = " + ".join(f"{part} {value:.1f}" for part, value in bits.items())
    printing.say(f"description: {said} = {facts.bits['sum']:.1f} bits")
    for capture in facts.captures:
        if not capture.there:
            printing.warn(
                f"note: {capture.capture} is no longer in the database: its segments cannot be "
                "played",
            )
    for picture in (png, strings):
        if picture:
            printing.say(f"picture: {picture}")


def compare(shared: options.Shared, name: options.GrammarName, seed: options.Seed = 0) -> None:
    """Compare a grammar with the finite state machine of its sentences."""
    with shared.database() as base:
        rows = base.grammars.compare(name, seed)
    if printing.as_json(shared, rows):
        return
    table = [
        [
            row.kind,
            str(row.nonterminals),
            str(row.rules),
            f"{row.bits:.1f}",
            "more than 10,000" if row.strings is None else str(row.strings),
            "" if row.held_out is None else f"{row.held_out:.0%}",
            f"{row.new:.0%}",
            f"{row.outside:.0%}",
            f"{row.mean_length:.1f}",
        ]
        for row in rows
    ]
    columns = [
        "grammar",
        "nonterminals",
        "rules",
        "bits",
        "strings",
        "held out",
        "new",
        "outside",
        "mean length",
    ]
    printing.print_table("", columns, table)
    printing.say("held out: share of sentences that a grammar learned from the others derives")
    printing.say(
        "new: share of strings that are not sentences; outside: share that the learned "
        "grammar does not derive"
    )


def remove(shared: options.Shared, name: options.GrammarName) -> None:
    """Remove a grammar; sequences that it generated stay as captures, but cannot be edited."""
    from motiondb.answers.catalogue import Removed

    with shared.database(writing=True) as base:
        lost = base.grammars.remove(name)
    if printing.as_json(shared, Removed(name, no_longer_editable=lost)):
        return
    printing.say(f"{name} removed")
    _say_lost(lost)
