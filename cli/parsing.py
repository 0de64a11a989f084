"""Commands grammar parse and suggest."""

from __future__ import annotations

from typing import Annotated

import typer

import motiondb
from motiondb import answers
from motiondb.cli import options, printing

app = options.Commands()


SHOWN = 10  # Largest number of unlike segments that are printed; JSON lists all


@app.command()
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


@app.command()
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
