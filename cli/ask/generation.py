"""Printing of generated motions: their actions, settings and sources."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from motiondb.cli.ask.understanding import print_question
from motiondb.cli.printing import print_json

if TYPE_CHECKING:
    from motiondb import Generated, JudgedAction

FPS = 30.0  # Frames per second of generated motion


def numbered(
    number: int, output: Path, save: str | None, png: Path | None
) -> list[tuple[Path, str | None, Path | None]]:
    """Files and names of the variants: as given for one, with -1, -2, ... for several."""
    if number == 1:
        return [(output, save, png)]
    return [
        (
            numbered_path(output, n),
            None if save is None else f"{save}-{n}",
            None if png is None else numbered_path(png, n),
        )
        for n in range(1, number + 1)
    ]


def print_generated(
    motions: Sequence[Generated], facts: Sequence[dict[str, Any]], json: bool, asked: int
) -> None:
    """Print the motions as text, or as JSON: one object, or ``variants`` if more were asked for."""
    first = motions[0]
    if json:
        for one, made in zip(facts, motions):
            one["question"] = made.question.facts(made.not_used)
        shown = all(made.shows_all for made in motions)
        several = {"shown": shown, "asked": asked, "variants": list(facts)}
        print_json(facts[0] if asked == 1 else several)
        return
    not_used = {left: None for made in motions for left in made.not_used}
    print_question(first.question, list(not_used), "generation")
    for made, one in zip(motions, facts):
        _print_one(made, one)
    if len(motions) < asked:
        typer.echo(say_fewer(len(motions), asked, motions[-1].took_all_places))


def say_fewer(number: int, asked: int, took_all_places: bool) -> str:
    """That there are fewer different motions than asked for, and why.

    >>> say_fewer(1, 3, True)
    '1 of 3 written: no other place shows this about as clearly'
    >>> say_fewer(2, 3, False)
    '2 of 3 written: no other was found'
    """
    why = "no other place shows this about as clearly" if took_all_places else "no other was found"
    return f"{number} of {asked} written: {why}"


def _print_one(made: Generated, facts: dict[str, Any]) -> None:
    typer.echo(
        f"{facts['seconds']:.2f} s of motion written to {facts['output']} "
        f"({made.method}, seed {made.seed})"
    )
    for line in made.decided:
        typer.echo(f"  {line}")
    for shown in made.shown:
        typer.echo(f"  {say_shown(shown)}")
        for line in shown.done:
            typer.echo(f"      {line}")
    for source in facts["sources"]:
        typer.echo(
            f"from {source['capture']}, {source['frames']} frames, licence {source['licence']}"
        )
    typer.echo(f"every frame's origin: {facts['provenance']}")


def say_shown(one: JudgedAction) -> str:
    """One action: its interval, whether it is shown, and the words that its motion resembles."""
    place = f"{one.start / FPS:.2f}-{one.end / FPS:.2f} s  " if one.end > one.start else ""
    said = {True: "shown", False: "not shown", None: "not confirmed"}[one.shown]
    sure = "" if one.probability is None else f" ({one.probability:.2f})"
    why = f": {one.reason}" if one.reason else ""
    looks = ", ".join(f"{word} {p:.2f}" for word, p in one.described)
    return f"{place}{' '.join(one.words)}: {said}{sure}{why}" + (
        f"; looks like {looks}" if looks else ""
    )


def numbered_path(path: Path, n: int) -> Path:
    """Path of the nth variant: NAME-n with the same ending."""
    return path.with_name(f"{path.stem}-{n}{path.suffix}")
