"""Commands of grammars: learn, list, show, compare, remove, edit by hand, parse, suggest."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

import motiondb
from motiondb import answers
from motiondb.cli import options, printing, sequences

app = options.Commands()
group = app.group(
    "grammar", "Grammars of movement: learn from long takes, parse, suggest, generate, edit."
)


@group.command()
def learn(
    shared: options.Shared,
    captures: Annotated[
        list[str], options.argument("Names of captures, preferably long takes.", "CAPTURE...")
    ],
    terminals: Annotated[
        int | None,
        options.option(
            "How many kinds of whole actions (default: runs of poses of about half a second,"
            " whose number foresees held-out parts best).",
            min=1,
        ),
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
    without_errors: Annotated[
        bool, "Leave out sentences that look like errors (grammar show names them)."
    ] = False,
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
        without_errors=without_errors,
    )
    with shared.database(writing=True) as base, printing.progress(shared) as tell:
        learned, lost = base.grammars.learn(captures, name, settings, tell)
        facts = base.grammars.show(learned.name)
        size = base.grammars.size(learned.name)
    if printing.as_json(shared, facts, no_longer_editable=lost):
        return
    printing.say(summary(size))
    printing.say(f"foresight: {facts.foresight_says}")
    _say_errors(facts)
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


def _say_errors(facts: motiondb.GrammarAnswer) -> None:
    """Print the sentences that look like errors, and those that were left out."""
    for one in facts.doubtful:
        printing.warn(f"note: {one.says}")
    if facts.doubtful:
        printing.say("motiondb grammar learn --without-errors leaves these out")
    for at in facts.left_out:
        printing.say(f"left out as an error: {at.capture} {at.start:.2f}-{at.end:.2f} s")


def _say_list(facts: motiondb.GrammarAnswer) -> None:
    """Print a note if the grammar only lists its sentences, with advice."""
    if not facts.derives_new:
        printing.warn(
            f"note: {facts.grammar} only lists its sentences and derives nothing new. More"
            " captures of the same activity, another number of kinds of action (--terminals) or"
            " shorter sentences (--longest) may give it rules.",
        )
    elif facts.foresight and facts.foresight.extreme == "list":
        printing.warn(
            f"note: the rules of {facts.grammar} list what they saw: they accept next to nothing of"
            " held-out takes. More captures of the same activity may give it rules."
        )
    if facts.foresight and facts.foresight.extreme == "everything":
        printing.warn(
            f"note: {facts.grammar} allows nearly every order of its terminals, so its rules say"
            " next to nothing. More kinds of action (--terminals) may give it an order."
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
        Path | None, options.picture("Draw the trees of the sentences into this file (.png).")
    ] = None,
    strings: Annotated[
        Path | None,
        options.picture("Draw terminals, and captures as strings, into this file (.png)."),
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
    _say_errors(facts)
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
            *_judged(row.foresight),
        ]
        for row in rows
    ]
    columns = ["grammar", "nonterminals", "rules", "bits", "strings", "held out", "new", "outside"]
    judged = ["foreseen", "right of two", "accepts", "freedom"]
    printing.print_table([*columns, "mean length", *judged], table)
    printing.say("held out: share of sentences that a grammar learned from the others derives")
    printing.say(
        "new: share of strings that are not sentences; outside: share that the learned "
        "grammar does not derive"
    )
    if rows[0].foresight is None:
        printing.say("foreseen: cannot say, too few takes")
    else:
        printing.say(
            f"of {rows[0].foresight.windows} windows of five terminals in held-out takes; foreseen:"
            " share above 95% of their shuffles, smoothed (chance 5%); right of two: chance 0.50;"
            " accepts, freedom: share of windows, and of shuffles, that the rules derive"
        )


def _judged(seen: answers.Foresight | None) -> list[str]:
    """The figures of foresight and freedom; empty cells where nothing can be said."""
    if seen is None:
        return [""] * 4
    shares = f"{seen.foreseen:.0%} {seen.right_of_two:.2f} {seen.accepted:.0%} {seen.freedom:.0%}"
    return shares.split()


@group.command()
def remove(shared: options.Shared, name: options.GrammarName) -> None:
    """Remove a grammar; sequences that it generated stay as captures, but cannot be edited."""
    with shared.database(writing=True) as base:
        lost = base.grammars.remove(name)
    if printing.as_json(shared, answers.Removed(name, no_longer_editable=lost)):
        return
    printing.say(f"{name} removed")
    _say_lost(lost, "the grammar that derived {} was removed")


@group.command()
def ask(
    shared: options.Shared,
    name: options.GrammarName,
    answer: Annotated[
        list[str] | None,
        options.option('An answer such as "a b no" (yes, no, unknown); may be repeated.'),
    ] = None,
    author: Annotated[str, "Who answers; needed with answers."] = "",
    number: Annotated[int, options.option("Most questions.", min=1, max=1000)] = 10,
    png: options.Png = None,
    gif: Annotated[
        Path | None, options.animation("Animate the questions into this file (.gif).")
    ] = None,
) -> None:
    """Ask which terminals can follow each other; the next learning of NAME keeps to the answers.

    Without --answer, the questions are listed; with --author, a terminal is asked each of them. An
    empty line ends the answers.
    """
    given = [one.split() for one in answer or []]
    is_terminal = sys.stdin.isatty() and sys.stdout.isatty()
    prompted = not given and not shared.json and bool(author) and is_terminal
    with shared.database(writing=bool(given) or prompted) as base:
        n_ruled = 0  # Answers that rules can keep to
        for words in given:
            if len(words) != 3:
                raise motiondb.QueryError(
                    f"--answer: expected 'FIRST THEN yes', found {' '.join(words)!r}. Write two"
                    " terminals and yes, no or unknown."
                )
            first, then, said = words
            n_ruled += _keep_answer(base, name, first, then, said, author)
        asked = base.grammars.questions(name, number)
        files = [file for file in (png, gif) if file and asked]
        for file in files:
            base.grammars.draw_questions(name, asked, file)
        picture = str(files[0]) if files else None
        if printing.as_json(shared, answers.GrammarAsked(name, asked, len(given), picture)):
            return
        kept = len(given)
        for place, one in enumerate(asked, start=1):
            first, then = (
                f"{terminal}{words and f', {words}'} ({s.capture} {s.start:.2f}-{s.end:.2f} s)"
                for terminal, words, s in (
                    (one.first, one.first_words, one.first_shown),
                    (one.then, one.then_words, one.then_shown),
                )
            )
            printing.say(f"{place}  can {then} come straight after {first}?")
            if prompted:
                if not (said := _prompted()):
                    break
                n_ruled += _keep_answer(base, name, one.first, one.then, said, author)
                kept += 1
    if kept:
        said = printing.number(kept, "answer")
        which = "them" if n_ruled == kept else f"{n_ruled} of them"
        printing.say(
            f"{said} kept: the next motiondb grammar learn ... --name {name} keeps to {which}"
        )
    if not asked:
        printing.say(f"no question is left about {name}")
    printing.say_pictures(*files)


def _prompted() -> str:
    """Return an answer, or "" for none."""
    said = "?"
    while said not in ("yes", "no", "unknown", ""):
        said = str(typer.prompt("yes, no, unknown", default="", show_default=False)).strip()
    return said


def _keep_answer(
    base: motiondb.MotionDB, name: str, first: str, then: str, said: str, author: str
) -> bool:
    """Keep an answer, tell where rules cannot keep to it, and return whether they can."""
    can = base.grammars.answer(name, first, then, said, author)
    if not can:
        printing.note(f"the captures show {then} straight after {first}, so rules keep it")
    return can


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


SHOWN = 10  # Largest number of unlike segments that are printed; JSON lists all


@group.command()
def parse(
    shared: options.Shared,
    name: options.GrammarName,
    example: Annotated[str, options.argument("A stored capture's name, or a file.", "CAPTURE")],
    png: options.Png = None,
) -> None:
    """Parse a capture: trees of its sentences, or the fault and what was expected (exit 1).

    Segments that are unlike all motion from which the grammar was learned are listed with their
    distance from the nearest terminal; if most of the capture is unlike, the exit code is 1 too.
    """
    with shared.database() as base:
        parsed_motion = base.grammars.parse(name, example)
        if png and parsed_motion.trees:
            base.grammars.draw_parse(name, parsed_motion, png)
    if not printing.as_json(shared, parsed_motion.facts()):
        _say_parsed(parsed_motion, example)
        _say_unlike(parsed_motion, name, example)
        if parsed_motion.of_another_activity:
            printing.say(
                f"{example} is probably of another activity than {name}:"
                f" {parsed_motion.of_another_activity}"
            )
        if png:
            printing.say(
                f"picture: {png}" if parsed_motion.trees else f"no sentence to draw, no {png}"
            )
    if parsed_motion.fault or parsed_motion.is_unlike:
        raise typer.Exit(1)


def _say_parsed(parsed: motiondb.ParsedMotion, example: str) -> None:
    """Print the string, then its trees, or the fault and its time."""
    how = "as learned" if parsed.stored else "read anew"
    printing.say(f"{' '.join(parsed.string)} ({how})")
    for number, tree in enumerate(parsed.trees, start=1):
        printing.say(f"{number}  {tree}")
    if parsed.fault:
        printing.say(f"{parsed.fault}")
        if parsed.log_probability is not None:
            each = parsed.log_probability / max(len(parsed.string), 1)
            rank = (
                ""
                if parsed.order_rank is None
                else (f"; the order is more probable than {parsed.order_rank:.0%} of its shuffles")
            )
            printing.say(f"smoothed log-probability {each:.2f} a terminal{rank}")
        if parsed.fault.position < len(parsed.starts):
            start, end = parsed.starts[parsed.fault.position], parsed.ends[parsed.fault.position]
            printing.say(f"that is {start:.2f}-{end:.2f} s of {example}")


def _say_unlike(parsed: motiondb.ParsedMotion, name: str, example: str) -> None:
    """Print the segments unlike anything learned, the farthest first, or that this is unknown."""
    if not parsed.stored and parsed.reach is None:
        printing.warn(
            f"note: the terminals of {name} have too few members to decide which segments are "
            f"unlike them",
        )
    if not parsed.unlike:
        return
    share = f"{parsed.share_unlike:.0%}"
    if parsed.is_unlike:
        printing.say(
            f"{example} is unlike what {name} was learned from for {share} of its time; the "
            f"terminals there are only the nearest ones and have no meaning. Learn a grammar from "
            f"captures like it."
        )
    else:
        printing.say(f"unlike anything {name} was learned from, {share} of the time:")
    farthest = sorted(parsed.unlike, key=lambda n: -parsed.distances[n])
    printing.print_table(
        ["position", "terminal", "start", "end", "metres from it"],
        [
            [n, parsed.string[n]]
            + [f"{of[n]:.2f}" for of in (parsed.starts, parsed.ends, parsed.distances)]
            for n in farthest[:SHOWN]
        ],
    )
    if len(farthest) > SHOWN:
        printing.say(f"and {len(farthest) - SHOWN} more (--json lists all)")
    printing.say(
        f"usual: within {parsed.reach:.2f} m, as for members of terminals in the learned captures"
    )


@group.command()
def suggest(
    shared: options.Shared,
    name: options.GrammarName,
    beginning: Annotated[
        str, options.argument('Terminals so far, such as "a b c"; or "".', "STRING")
    ] = "",
    goal: Annotated[str, "Show the most probable way to this terminal instead."] = "",
    like: Annotated[
        str | None,
        'Complete this pattern: terminals and words, such as "a ... ? b" (? is any one,'
        " ... any number), or a sentence in words.",
    ] = None,
    number: Annotated[int, options.option("Sentences with --like.", min=1, max=1000)] = 5,
    exact: options.Exact = False,
) -> None:
    """List the terminals that the grammar allows next, or sentences that complete a pattern."""
    with shared.database() as base:
        if like is not None:
            if beginning or goal:
                raise motiondb.QueryError(
                    f"--like: expected no STRING and no --goal with it, found"
                    f" {f'{beginning} {goal}'.strip()!r}. Write them into the pattern."
                )
            taken = {} if exact else base.grammars.taken_in_pattern(name, like)
            printing.note_taken(taken.values())
            found = base.grammars.complete(name, like, number, exact)
            sentences = [answers.extended(answers.CompletedSentence, s) for s in found.sentences]
            said = answers.extended(answers.CompletionsAnswer, found, sentences=sentences)
            if not printing.as_json(shared, said):
                _say_completed(said, name)
            return
        if goal:
            _say_way(shared, base.grammars.plan(name, beginning, goal), goal)
            return
        nexts = base.grammars.suggest(name, beginning)
        names = base.grammars.load(name).terminals.names
        words = dict(zip(names, (m.text for m in base.grammars.meanings(name))))
    if printing.as_json(shared, [answers.NextTerminal(t, t is None, p) for t, p in nexts]):
        return
    rows = [
        ["the end" if t is None else t, f"{p:.3f}", words.get(t, "") if t else ""] for t, p in nexts
    ]
    columns = ["next", "probability", "words"][: 3 if any(row[2] for row in rows) else 2]
    printing.print_table(columns, [row[: len(columns)] for row in rows])


def _say_way(shared: options.Shared, way: motiondb.Plan, goal: str) -> None:
    """Print the most probable continuation that reaches a terminal."""
    said = answers.extended(answers.WayAnswer, way, tree=str(way.tree))
    if printing.as_json(shared, said):
        return
    printing.say(f"to {goal}: {' '.join(way.to_goal)}")
    printing.say(f"then:  {' '.join(way.then) or 'the end'}")
    printing.say(f"tree:  {way.tree}")


def _say_completed(completed: answers.CompletionsAnswer, name: str) -> None:
    """Print the most probable sentences that match a pattern."""
    rows = [[" ".join(one.string), f"{one.probability:.3f}"] for one in completed.sentences]
    printing.print_table(["sentence", "probability"], rows)
    printing.say(f"{completed.probability:.2%} of the sentences of {name} match")


group.include(sequences.app)
