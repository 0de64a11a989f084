"""Output of ``search --explain``: one line for each word."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from motiondb import ExplainedWord, WordAnswer


def print_explanations(answer: WordAnswer) -> None:
    """Print the log-odds of every match, then one line for each word."""
    for source in answer.sources:
        typer.echo(source.sentence())
    for match, why in zip(answer.matches, answer.explanations):
        typer.echo(
            f"{match.rank} {match.capture}  log-odds {why.log_odds:+.3f}, score {match.score:.3f}"
        )
        for word in why.words:
            typer.echo(f"    {_word_line(word)}")
        if why.together:
            typer.echo(f"    all of them together: {why.together:+.3f}")
        for excluded in why.excluded:
            typer.echo(
                f"    not {' '.join(word.word for word in excluded.words)}: "
                f"{excluded.amount:+.3f}, as its log-odds are {excluded.log_odds:+.3f}"
            )
            for word in excluded.words:
                typer.echo(f"        {_word_line(word)}")


def _word_line(word: ExplainedWord) -> str:
    """The contribution of one word, and its parts."""
    rest = word.other_shares
    others = f", others {rest:+.3f}" if abs(rest) >= 0.0005 else ""
    shares = ", ".join(
        f"symbol {s.symbol} {s.amount:+.3f} ({s.start:.1f}-{s.end:.1f} s)" for s in word.strongest
    )
    written = f", written {word.written:+.3f}" if word.written else ""
    if word.as_caption:
        written += f", as part of the caption {word.as_caption:+.3f}"
    usual = f"{word.word}: {word.contribution:+.3f} = usual {word.prior:+.3f}"
    return f"{usual}{written}, {shares}{others}"
