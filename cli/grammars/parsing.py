"""Commands grammar parse and suggest."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from motiondb.cli.options import (
    DEFAULT_DB,
    Db,
    GrammarName,
    Json,
    Png,
    database,
    print_json,
    print_table,
)

if TYPE_CHECKING:
    from motiondb.database.grammars.grammar_parsing import ParsedMotion

SHOWN = 10
"""Unlike segments that are printed; JSON holds all."""


def register(group: typer.Typer) -> None:
    """Add the commands to the group.

    Parameters
    ----------
    group : typer.Typer
        The group ``grammar``.
    """
    group.command("parse")(parse)
    group.command("suggest")(suggest)


def parse(
    name: GrammarName,
    example: Annotated[
        str, typer.Argument(metavar="CAPTURE", help="A stored capture's name, or a file.")
    ],
    png: Png = None,
    db: Db = DEFAULT_DB,
    json: Json = False,
) -> None:
    """Parse a capture: trees of its sentences, or the fault and what was expected (exit 1).

    Segments that are unlike all motion from which the grammar was learned are listed with their
    distance from the nearest terminal; if most of the capture is unlike, the exit code is 1 too.
    """
    with database(db) as base:
        found = base.grammars.parse(name, example)
        if png and found.trees:
            base.grammars.draw_parse(name, found, png)
    if json:
        print_json(_facts(found))
    else:
        _say_parsed(found, example)
        _say_unlike(found, name, example)
        if png:
            typer.echo(f"picture: {png}" if found.trees else f"no sentence to draw: no {png}")
    if found.fault or found.is_unlike:
        raise typer.Exit(1)


def _facts(found: ParsedMotion) -> dict[str, Any]:
    from motiondb.database.grammars.grammar_facts import format_tree

    fault = found.fault
    return {
        "string": list(found.string),
        "spans": [list(span) for span in zip(found.starts, found.ends)],
        "learned_from": found.stored,
        "distances": list(found.distances),
        "usual_distance": found.reach,
        "unlike": list(found.unlike),
        "share_unlike": found.share_unlike,
        "is_unlike": found.is_unlike,
        "sentences": [
            {"string": list(tree.leaves()), "tree": format_tree(tree)} for tree in found.trees
        ],
        "fault": None
        if fault is None
        else {
            "position": fault.position, "found": fault.found,
            "expected": list(fault.expected), "may_end": fault.may_end, "says": str(fault),
        },
    }  # fmt: skip


def _say_parsed(found: ParsedMotion, example: str) -> None:
    """Print the string, then its trees, or the fault and its time."""
    from motiondb.database.grammars.grammar_facts import format_tree

    how = "as learned" if found.stored else "read anew"
    typer.echo(f"{' '.join(found.string)} ({how})")
    for number, tree in enumerate(found.trees, start=1):
        typer.echo(f"{number}  {format_tree(tree)}")
    if found.fault:
        typer.echo(f"{found.fault}")
        if found.fault.position < len(found.starts):
            start, end = found.starts[found.fault.position], found.ends[found.fault.position]
            typer.echo(f"that is {start:.2f}-{end:.2f} s of {example}")


def _say_unlike(found: ParsedMotion, name: str, example: str) -> None:
    """Print the segments unlike anything learned, the farthest first, or that this is unknown."""
    if not found.stored and found.reach is None:
        typer.echo(
            f"note: the terminals of {name} have too few members to say what is unlike them",
            err=True,
        )
    if not found.unlike:
        return
    share = f"{found.share_unlike:.0%}"
    if found.is_unlike:
        typer.echo(
            f"{example} is unlike what {name} was learned from for {share} of its time: there its"
            " terminals are only the least unlike, and mean nothing. Learn a grammar from captures"
            " like it."
        )
    else:
        typer.echo(f"unlike anything {name} was learned from, {share} of the time:")
    farthest = sorted(found.unlike, key=lambda n: -found.distances[n])
    print_table(
        "",
        ["position", "terminal", "start", "end", "metres from it"],
        [
            [str(n), found.string[n], f"{found.starts[n]:.2f}", f"{found.ends[n]:.2f}",
             f"{found.distances[n]:.2f}"]
            for n in farthest[:SHOWN]
        ],
    )  # fmt: skip
    if len(farthest) > SHOWN:
        typer.echo(f"and {len(farthest) - SHOWN} more (--json tells all)")
    typer.echo(
        f"usual: within {found.reach:.2f} m, as members of terminals where they were learned"
    )


def suggest(
    name: GrammarName,
    beginning: Annotated[
        str, typer.Argument(metavar="STRING", help='Terminals so far, such as "a b c"; or "".')
    ] = "",
    db: Db = DEFAULT_DB,
    json: Json = False,
) -> None:
    """List the terminals that the grammar allows next, with their probabilities."""
    with database(db) as base:
        found = base.grammars.suggest(name, beginning)
        names = base.grammars.load(name).terminals.names
        words = dict(zip(names, (m.text for m in base.grammars.meanings(name))))
    if json:
        print_json([{"terminal": t, "end": t is None, "probability": p} for t, p in found])
        return
    rows = [
        ["the end" if t is None else t, f"{p:.3f}", words.get(t, "") if t else ""] for t, p in found
    ]
    columns = ["next", "probability", "words"][: 3 if any(row[2] for row in rows) else 2]
    print_table("", columns, [row[: len(columns)] for row in rows])
