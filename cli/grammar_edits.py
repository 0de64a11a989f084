"""Commands grammar rules, rename and undo: a grammar changed by hand, and back again."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from motiondb.cli import options, printing

STANDARD_INPUT = "-"


def register(group: typer.Typer) -> None:
    """Add the commands to the group."""
    group.command("rules")(rules)
    group.command("rename")(rename)
    group.command("undo")(undo)


def rules(
    shared: options.Shared,
    name: options.GrammarName,
    file: Annotated[
        str | None,
        typer.Argument(help="Text file with all rules, edited; - reads the standard input."),
    ] = None,
) -> None:
    """Print the rules of a grammar as text; with a file, replace them by those of the file.

    The rules must derive every sentence of the captures. motiondb grammar undo takes an edit back.
    """
    from motiondb.answers.grammars import GrammarEdited, GrammarRules

    if file is None:
        with shared.database() as base:
            text = base.grammars.show(name).text
        if not printing.as_json(shared, GrammarRules(name, text)):
            printing.say(*text.split("\n"))
        return
    written = _text(file)
    with shared.database(writing=True) as base:
        before = base.grammars.edits(name)
        lost = base.grammars.edit_rules(name, written)
        edited = base.grammars.edits(name) != before
    if printing.as_json(shared, GrammarEdited(name, lost)):
        return
    printing.say(f"{name} has the rules of {file}" if edited else f"{name} has these rules already")
    say_lost(lost)


def rename(
    shared: options.Shared,
    name: options.GrammarName,
    terminal: Annotated[str, typer.Argument(help="Present name of a terminal.")],
    to: Annotated[str, typer.Argument(metavar="NEW", help="New name, such as step_left.")],
) -> None:
    """Give a terminal of a grammar another name, also in its rules and saved sequences."""
    from motiondb.answers.grammars import GrammarEdited

    with shared.database(writing=True) as base:
        lost = base.grammars.rename_terminal(name, terminal, to)
    if not printing.as_json(shared, GrammarEdited(name, lost)):
        printing.say(f"{terminal} of {name} is now {to}")


def undo(shared: options.Shared, name: options.GrammarName) -> None:
    """Take the last edit of a grammar back; repeated, it goes further back."""
    from motiondb.answers.grammars import GrammarEdited

    with shared.database(writing=True) as base:
        done = base.grammars.undo_edit(name)
    if not printing.as_json(shared, GrammarEdited(name, [], done)):
        printing.say(f"undone: {done} of {name}")


def say_lost(lost: list[str]) -> None:
    """Print which sequences can no longer be edited."""
    if lost:
        printing.warn(
            f"note: {', '.join(lost)} can no longer be edited: the new rules do not derive "
            f"{'it' if len(lost) == 1 else 'them'}",
        )


def _text(file: str) -> str:
    """Read a text file, or the standard input."""
    from motiondb import read_user_text

    if file == STANDARD_INPUT:
        return sys.stdin.read()
    return read_user_text(Path(file), "a file of rules")
