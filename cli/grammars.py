"""Commands of grammars: learn, list, show, compare, remove; rules, rename, undo: edits by hand."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import motiondb
from motiondb import answers
from motiondb.cli import options, parsing, printing, sequences

app = options.Commands()
group = options.Commands(
    name="grammar",
    help="Grammars of movement: learn from long takes, parse, suggest, generate, edit.",
    no_args_is_help=True,
)
app.add_typer(group)


@group.command()
def learn(
    shared: options.Shared,
    captures: Annotated[
        list[str], options.argument("Names of captures, preferably long takes.", "CAPTURE...")
    ],
    terminals: Annotated[
        int | None,
        options.option("How many kinds of action (default: by duration, 4 to 20).", min=1),
    ] = None,
    name: Annotated[str | None, "Name of the grammar.  [default: the first capture's]"] = None,
    from_symbols: Annotated[bool, "Use the learned motion symbols as terminals."] = False,
    sentences: Annotated[
        str,
        "How sentences are found. auto: by search; captures: one per capture; captions: "
        "at the start of captions.",
    ] = "auto",
    shortest: Annotated[
        int, options.option("Smallest number of terminals of a sentence.", min=1)
    ] = 3,
    longest: Annotated[
        int, options.option("Largest number of terminals of a sentence.", min=1)
    ] = 20,
    seed: options.Seed = 0,
) -> None:
    """Learn a grammar from captures: segments, terminals, sentences, rules."""
    settings = motiondb.GrammarSettings(
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
    if printing.as_json(
        shared, answers.extended(answers.GrammarLearnedAnswer, facts, no_longer_editable=lost)
    ):
        return
    printing.say(summary(size))
    _say_list(facts)
    _say_lost(lost, "the grammar that derived {} was removed")


def summary(size: motiondb.GrammarSize) -> str:
    """Describe a grammar in one line."""
    number = printing.number
    return (
        f"{size.name}: {number(size.captures, 'capture')} ({size.seconds:.0f} s), "
        f"{number(size.segments, 'segment')} of {number(size.terminals, 'terminal')}, "
        f"{number(size.sentences, 'sentence')}, {number(size.nonterminals, 'nonterminal')}, "
        f"{number(size.rules, 'rule')}, {sum(size.bits.values()):.1f} bits."
    )


def _say_list(facts: motiondb.GrammarAnswer) -> None:
    """Print a note if the grammar only lists its sentences, with advice."""
    if not facts.derives_new:
        printing.warn(
            f"note: {facts.grammar} only lists its sentences and derives nothing new. More"
            " captures of the same activity, another number of kinds of action (--terminals) or"
            " shorter sentences (--longest) may give it rules.",
        )


def _say_lost(lost: list[str], why: str) -> None:
    """Print which sequences can no longer be edited; {} in the reason stands for them."""
    reason = why.format("it" if len(lost) == 1 else "them")
    printing.note(f"{', '.join(lost)} can no longer be edited: {reason}" if lost else "")


@group.command("list")
def list_grammars(shared: options.Shared) -> None:
    """List the grammars."""
    with shared.database() as base:
        sizes = base.grammars.sizes()
    if printing.as_json(shared, [motiondb.grammar_row(size) for size in sizes]):
        return
    if not sizes:
        printing.say("no grammars yet: motiondb grammar learn CAPTURE...")
    for size in sizes:
        printing.say(summary(size))


@group.command()
def show(
    shared: options.Shared,
    name: options.GrammarName,
    png: Annotated[
        Path | None,
        options.option(
            "Draw the trees of the sentences into this file (.png).", callback=options.picture_name
        ),
    ] = None,
    strings: Annotated[
        Path | None,
        options.option(
            "Draw terminals, and captures as strings, into this file (.png).",
            callback=options.picture_name,
        ),
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
            t.count,
            f"{t.seconds:.2f}",
            "  ".join(printing.say_word(w.word, w.probability) for w in t.words),
            "  ".join(f"{s.symbol}: {s.share:.0%}" for s in t.symbols),
            f"{t.medoid.capture} {t.medoid.start:.2f}-{t.medoid.end:.2f} s",
        ]
        for t in facts.terminals
    ]
    columns = ["terminal", "count", "seconds", "words", "motion symbols", "medoid"]
    used = [k for k, _ in enumerate(columns) if any(row[k] for row in rows)]
    printing.print_table([columns[k] for k in used], [[row[k] for k in used] for row in rows])
    bits = {part: value for part, value in facts.bits.items() if part != "sum"}
    said = " + ".join(f"{part} {value:.1f}" for part, value in bits.items())
    printing.say(f"description: {said} = {facts.bits['sum']:.1f} bits")
    for capture in facts.captures:
        if not capture.there:
            printing.warn(
                f"note: {capture.capture} is no longer in the database: its segments cannot be "
                "played",
            )
    printing.say_pictures(png, strings)


@group.command()
def compare(shared: options.Shared, name: options.GrammarName, seed: options.Seed = 0) -> None:
    """Compare a grammar with the finite state machine of its sentences."""
    with shared.database() as base:
        rows = base.grammars.compare(name, seed)
    if printing.as_json(shared, rows):
        return
    table = [
        [
            row.kind,
            row.nonterminals,
            row.rules,
            f"{row.bits:.1f}",
            "more than 10,000" if row.strings is None else row.strings,
            "" if row.held_out is None else f"{row.held_out:.0%}",
            f"{row.new:.0%}",
            f"{row.outside:.0%}",
            f"{row.mean_length:.1f}",
        ]
        for row in rows
    ]
    columns = ["grammar", "nonterminals", "rules", "bits", "strings", "held out", "new", "outside"]
    printing.print_table([*columns, "mean length"], table)
    printing.say("held out: share of sentences that a grammar learned from the others derives")
    printing.say(
        "new: share of strings that are not sentences; outside: share that the learned "
        "grammar does not derive"
    )


@group.command()
def remove(shared: options.Shared, name: options.GrammarName) -> None:
    """Remove a grammar; sequences that it generated stay as captures, but cannot be edited."""
    with shared.database(writing=True) as base:
        lost = base.grammars.remove(name)
    if printing.as_json(shared, answers.Removed(name, no_longer_editable=lost)):
        return
    printing.say(f"{name} removed")
    _say_lost(lost, "the grammar that derived {} was removed")


STANDARD_INPUT = "-"


@group.command()
def rules(
    shared: options.Shared,
    name: options.GrammarName,
    file: Annotated[
        str | None,
        options.argument("Text file with all rules, edited; - reads the standard input."),
    ] = None,
) -> None:
    """Print the rules of a grammar as text; with a file, replace them by those of the file.

    The rules must derive every sentence of the captures. motiondb grammar undo takes an edit back.
    """
    if file is None:
        with shared.database() as base:
            text = base.grammars.show(name).text
        if not printing.as_json(shared, answers.GrammarRules(name, text)):
            printing.say(*text.split("\n"))
        return
    written = _text(file)
    with shared.database(writing=True) as base:
        before = base.grammars.edits(name)
        lost = base.grammars.edit_rules(name, written)
        edited = base.grammars.edits(name) != before
    if printing.as_json(shared, answers.GrammarEdited(name, lost)):
        return
    printing.say(f"{name} has the rules of {file}" if edited else f"{name} has these rules already")
    _say_lost(lost, "the new rules do not derive {}")


@group.command()
def rename(
    shared: options.Shared,
    name: options.GrammarName,
    terminal: Annotated[str, options.argument("Present name of a terminal.")],
    to: Annotated[str, options.argument("New name, such as step_left.", "NEW")],
) -> None:
    """Give a terminal of a grammar another name, also in its rules and saved sequences."""
    with shared.database(writing=True) as base:
        lost = base.grammars.rename_terminal(name, terminal, to)
    if not printing.as_json(shared, answers.GrammarEdited(name, lost)):
        printing.say(f"{terminal} of {name} is now {to}")


@group.command()
def undo(shared: options.Shared, name: options.GrammarName) -> None:
    """Take the last edit of a grammar back; repeated, it goes further back."""
    with shared.database(writing=True) as base:
        done = base.grammars.undo_edit(name)
    if not printing.as_json(shared, answers.GrammarEdited(name, [], done)):
        printing.say(f"undone: {done} of {name}")


def _text(file: str) -> str:
    """Read a text file, or the standard input."""
    if file == STANDARD_INPUT:
        return sys.stdin.read()
    return motiondb.read_user_text(Path(file), "a file of rules")


for part in (parsing, sequences):
    group.include(part.app)
