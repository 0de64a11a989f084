"""Output of ``search --explain``: one line a word, all numbers in JSON, bars on a timeline."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

if TYPE_CHECKING:
    from motiondb.database import MotionDB
    from motiondb.learning.answers.word_answers import WordAnswer
    from motiondb.search.questions.reasons import WordReason

_FPS = 30.0


def reason_facts(words: Sequence[str], why: Sequence[WordReason]) -> dict[str, Any]:
    """Decomposition of one answer as JSON.

    ``math.fsum`` of all parts of ``words``, ``together`` and the amounts of ``excluded`` is
    ``log_odds``.

    Parameters
    ----------
    words : sequence of str
        The vocabulary.
    why : sequence of WordReason
        The reasons of the answer.
    """
    from motiondb.search.questions import reasons

    return {
        "log_odds": reasons.total(why),
        "together": reasons.together(why),
        "words": [_word_facts(words, w) for w in why if w.exclusion < 0],
        "excluded": [
            {
                "amount": lowering.amount,
                "log_odds": lowering.log_odds,
                "words": [_word_facts(words, w) for w in why if w.exclusion == lowering.exclusion],
            }
            for lowering in reasons.lowerings(why)
        ],
    }


def _word_facts(words: Sequence[str], w: WordReason) -> dict[str, Any]:
    return {
        "word": words[w.word],
        "log_odds": w.log_odds,
        "log_probability": w.log_probability,
        "contribution": w.contribution,
        "prior": w.prior,
        "written": w.written,
        "symbols": [
            {"symbol": s.symbol, "from": s.start / _FPS, "to": s.end / _FPS, "share": s.amount}
            for s in w.shares
        ],
    }


def print_reasons(answer: WordAnswer, words: Sequence[str]) -> None:
    """Print the log-odds of every answer, then a line a word.

    Parameters
    ----------
    answer : WordAnswer
        The answer of a search.
    words : sequence of str
        The vocabulary.
    """
    from motiondb.search.questions import reasons

    for match, why in zip(answer.matches, answer.reasons):
        typer.echo(
            f"{match.rank} {match.capture}  log-odds {reasons.total(why):+.3f}, "
            f"score {match.score:.3f}"
        )
        for w in why:
            if w.exclusion < 0:
                typer.echo(f"    {_word_line(w, words)}")
        if joint := reasons.together(why):
            typer.echo(f"    all of them together: {joint:+.3f}")
        for lowering in reasons.lowerings(why):
            own = [w for w in why if w.exclusion == lowering.exclusion]
            excluded = " ".join(words[w.word] for w in own)
            typer.echo(
                f"    not {excluded}: {lowering.amount:+.3f}, as its log-odds are "
                f"{lowering.log_odds:+.3f}"
            )
            for w in own:
                typer.echo(f"        {_word_line(w, words)}")


def _word_line(w: WordReason, words: Sequence[str]) -> str:
    """What one word adds, and of what that is made."""
    from motiondb.search.questions import reasons

    loudest = reasons.strongest(w)
    rest = w.contribution - w.prior - w.written - sum(s.amount for s in loudest)
    others = f", others {rest:+.3f}" if abs(rest) >= 0.0005 else ""
    shares = ", ".join(
        f"symbol {s.symbol} {s.amount:+.3f} ({s.start / _FPS:.1f}-{s.end / _FPS:.1f} s)"
        for s in loudest
    )
    written = f", written {w.written:+.3f}" if w.written else ""
    return (
        f"{words[w.word]}: {w.contribution:+.3f} = usual {w.prior:+.3f}{written}, {shares}{others}"
    )


def draw_reason(base: MotionDB, answer: WordAnswer, path: Path, title: str) -> None:
    """Draw the capture of the best answer with a timeline of contributions for each word.

    Parameters
    ----------
    base : MotionDB
        The database.
    answer : WordAnswer
        The answer of a search.
    path : Path
        The picture.
    title : str
        Title of the picture.
    """
    from motiondb import pictures

    if not answer.matches:
        return
    best, words = answer.matches[0], base.vocabulary()
    timelines = [
        pictures.Timeline(
            words[w.word],
            [
                (s.start / _FPS, s.end / _FPS, f"{s.amount:+.2f}", s.symbol)
                for s in w.shares
                if abs(s.amount) > 0.005
            ],
        )
        for w in answer.reasons[0]
    ]
    found = [(best.start, best.end, f"{best.start:.1f}-{best.end:.1f} s", 0)]
    timelines.append(pictures.Timeline("found", found))
    pictures.draw_strip(
        base.motion(best.capture), path, title=f"{title}: {best.capture}", timelines=timelines
    )
