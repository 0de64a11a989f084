"""Printing how a question was understood, and what of it is not used."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import typer

if TYPE_CHECKING:
    from motiondb.words.question.known import KnownQuestion
    from motiondb.words.question.tree import NotUsed


def question_facts(question: KnownQuestion, not_used: Sequence[NotUsed]) -> dict[str, Any]:
    """A question for JSON: its text, one line for how it is understood, its tree, what is left."""
    from motiondb.words.question.say import say
    from motiondb.words.question.tree import to_dict

    return {
        "text": question.text,
        "understood": say(question.tree),
        "tree": to_dict(question.tree),
        "not_used": [{"text": left.text, "reason": left.reason} for left in not_used],
    }


def print_question(question: KnownQuestion, not_used: Sequence[NotUsed], what: str) -> None:
    """How a question is understood, and a line for everything that ``what`` does not use.

    Unknown words are told apart, on standard error (``options.note_unknown``).
    """
    from motiondb.words.question.say import say

    typer.echo(f"understood: {say(question.tree)}")
    for left in not_used:
        if left.text not in question.unknown:
            typer.echo(f"{left.text!r} is not used in {what}: {left.reason}")
