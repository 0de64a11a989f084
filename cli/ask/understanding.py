"""Printing how a question was understood, and what of it is not used."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from motiondb import KnownQuestion, NotUsed


def print_question(question: KnownQuestion, not_used: Sequence[NotUsed], what: str) -> None:
    """How a question is understood, and a line for everything that ``what`` does not use.

    Unknown words are told apart, on standard error (``options.note_unknown``).
    """
    typer.echo(f"understood: {question.understood}")
    for left in not_used:
        if left.text not in question.unknown:
            typer.echo(f"{left.text!r} is not used in {what}: {left.reason}")
