"""Printing of the interpretation of a question, and of its unused parts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from motiondb import KnownQuestion, NotUsed


def print_question(question: KnownQuestion, not_used: Sequence[NotUsed], what: str) -> None:
    """The interpretation of a question, and a line for every part that ``what`` does not use.

    Unknown words are printed separately, on standard error (``options.note_unknown``).
    """
    typer.echo(f"understood: {question.understood}")
    for left in not_used:
        if left.text not in question.unknown:
            typer.echo(f"{left.text!r} is not used in {what}: {left.reason}")
