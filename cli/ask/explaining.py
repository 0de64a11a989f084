"""Output of ``search --explain``: one line a word, and all numbers in JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import typer

if TYPE_CHECKING:
    from motiondb import ExplainedWord, Explanation, WordAnswer


def explanation_facts(why: Explanation) -> dict[str, Any]:
    """Decomposition of one answer as JSON.

    ``math.fsum`` of all parts of ``words``, ``together`` and the amounts of ``excluded`` is
    ``log_odds``.

    Parameters
    ----------
    why : Explanation
        The explanation of the answer.
    """
    return {
        "log_odds": why.log_odds,
        "together": why.together,
        "words": [_word_facts(word) for word in why.words],
        "excluded": [
            {
                "amount": excluded.amount,
                "log_odds": excluded.log_odds,
                "words": [_word_facts(word) for word in excluded.words],
            }
            for excluded in why.excluded
        ],
    }


def _word_facts(word: ExplainedWord) -> dict[str, Any]:
    return {
        "word": word.word,
        "log_odds": word.log_odds,
        "log_probability": word.log_probability,
        "contribution": word.contribution,
        "prior": word.prior,
        "written": word.written,
        "symbols": [
            {"symbol": s.symbol, "from": s.start, "to": s.end, "share": s.amount}
            for s in word.shares
        ],
    }


def print_explanations(answer: WordAnswer) -> None:
    """Print the log-odds of every match, then a line a word.

    Parameters
    ----------
    answer : WordAnswer
        The answer of a search.
    """
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
    """What one word adds, and of what that is made."""
    rest = word.other_shares
    others = f", others {rest:+.3f}" if abs(rest) >= 0.0005 else ""
    shares = ", ".join(
        f"symbol {s.symbol} {s.amount:+.3f} ({s.start:.1f}-{s.end:.1f} s)" for s in word.strongest
    )
    written = f", written {word.written:+.3f}" if word.written else ""
    usual = f"{word.word}: {word.contribution:+.3f} = usual {word.prior:+.3f}"
    return f"{usual}{written}, {shares}{others}"
