"""Printing why an answer was found: one line a word, all numbers in JSON, bars on the timeline."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

if TYPE_CHECKING:
    from motiondb.database import MotionDB
    from motiondb.learning.answers.word_answers import WordAnswer
    from motiondb.search.reasons import WordReason

_FPS = 30.0


def reason_facts(words: Sequence[str], why: Sequence[WordReason]) -> dict[str, Any]:
    """The whole reason of one answer; ``math.fsum`` of all parts is ``log_odds``."""
    from motiondb.search import reasons

    return {
        "log_odds": reasons.total(why),
        "together": reasons.together(why),
        "words": [
            {
                "word": words[w.word],
                "log_odds": w.log_odds,
                "log_probability": w.log_probability,
                "contribution": w.contribution,
                "prior": w.prior,
                "written": w.written,
                "symbols": [
                    {
                        "symbol": s.symbol,
                        "from": s.start / _FPS,
                        "to": s.end / _FPS,
                        "share": s.amount,
                    }
                    for s in w.shares
                ],
            }
            for w in why
        ],
    }


def print_reasons(answer: WordAnswer, words: Sequence[str]) -> None:
    """For every answer its log-odds, then a line a word."""
    from motiondb.search import reasons

    for match, why in zip(answer.matches, answer.reasons):
        typer.echo(
            f"{match.rank} {match.capture}  log-odds {reasons.total(why):+.3f}, "
            f"score {match.score:.3f}"
        )
        for w in why:
            loudest = reasons.strongest(w)
            rest = w.contribution - w.prior - w.written - sum(s.amount for s in loudest)
            others = f", others {rest:+.3f}" if abs(rest) >= 0.0005 else ""
            shares = ", ".join(
                f"symbol {s.symbol} {s.amount:+.3f} ({s.start / _FPS:.1f}-{s.end / _FPS:.1f} s)"
                for s in loudest
            )
            written = f", written {w.written:+.3f}" if w.written else ""
            typer.echo(
                f"    {words[w.word]}: {w.contribution:+.3f} = usual {w.prior:+.3f}{written}, "
                f"{shares}{others}"
            )
        if joint := reasons.together(why):
            typer.echo(f"    all of them together: {joint:+.3f}")


def draw_reason(base: MotionDB, answer: WordAnswer, path: Path, title: str) -> None:
    """The best answer's take with a timeline a word: what each segment says for or against it."""
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
