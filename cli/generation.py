"""Command generate: motions from sentences."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from motiondb.cli import options, printing

if TYPE_CHECKING:
    from motiondb import Generated, JudgedAction
    from motiondb.answers.making import WrittenMotion

FPS = 30.0  # Frames per second of generated motion


def register(app: typer.Typer) -> None:
    """Add the command to the app."""
    app.command()(generate)
    app.command()(join)


def generate(
    shared: options.Shared,
    words: Annotated[str, typer.Argument(help='A sentence, such as "a person walks then kicks".')],
    output: options.Output,
    seed: options.Seed = 0,
    method: Annotated[str, typer.Option("--method", help="stitched or trajectory.")] = "stitched",
    exact: options.Exact = False,
    anyway: Annotated[
        bool,
        typer.Option("--anyway", help="Generate the nearest motion if no capture shows an action."),
    ] = False,
    variants: Annotated[
        int, typer.Option("--variants", help="Most different motions: FILE-1, FILE-2, ...", min=1)
    ] = 1,
    save: Annotated[
        str | None, typer.Option("--save", help="Also save it as a capture of this name.")
    ] = None,
    png: options.Png = None,
    html: options.Html = None,
    unit: options.OutUnit = None,
    fps: options.OutFps = None,
    loop: options.Loop = False,
    in_place: options.InPlace = False,
    mirror: options.Mirror = False,
    onto: options.Onto = None,
    joint_map: options.RigMap = None,
) -> None:
    """Generate a motion from a sentence, and say which of its actions the motion shows.

    A file beside it names its sources. The exit code is 1 if an action is not shown, or cannot be
    confirmed.
    """
    changes = options.motion_changes(unit, fps, loop, in_place, mirror, onto, joint_map)
    with (
        shared.database(writing=save is not None) as base,
        printing.progress(shared) as tell,
    ):
        tell("generating", 0.0, 1.0)
        names = _numbered(variants, output, save, png)
        for path, name, picture in names:
            options.output_name(path)
            options.output_name(picture)
            if name is not None:
                base.check_name_free(name)
        motions = base.generate_variants(words, variants, seed, method, exact, anyway, changes)
        facts = []
        for number, (made, (path, name, picture)) in enumerate(zip(motions, names), 1):
            facts.append(replace(made.write(path, changes.of_file), capture=name))
            if picture is not None:
                made.draw(picture)
            if html is not None:
                from motiondb import StandalonePage

                page = html if variants == 1 else options.numbered(html, number)
                printing.write_html(page, StandalonePage.of_generated(base, made, name or ""))
            if name is not None:  # last, so that nothing is saved if a file cannot be written
                base.save_generated(name, words, made, made.seed)
    printing.note_taken(motions[0].taken, motions[0].suggested, motions[0].unknown)
    printing.note_sources(motions[0].sources)
    _print_generated(shared, motions, facts, variants)
    if not all(made.shows_all for made in motions):
        raise typer.Exit(1)


def join(
    shared: options.Shared,
    parts: Annotated[
        list[str],
        typer.Argument(metavar="CAPTURE:FROM-TO...", help="Parts in order, times in seconds."),
    ],
    output: options.Output,
    png: options.Png = None,
    unit: options.OutUnit = None,
    fps: options.OutFps = None,
    loop: options.Loop = False,
    in_place: options.InPlace = False,
    mirror: options.Mirror = False,
    onto: options.Onto = None,
    joint_map: options.RigMap = None,
) -> None:
    """Join parts of captures, such as `walk:0-2 kick:1-3`, with the blending of generate.

    A file beside it names its sources. Each seam is reported.
    """
    changes = options.motion_changes(unit, fps, loop, in_place, mirror, onto, joint_map)
    with shared.database() as base:
        options.output_name(output)
        joined = base.join(parts, changes)
        facts = joined.write(output, changes.of_file)
        if png is not None:
            joined.draw(png)
    if not printing.as_json(shared, facts):
        printing.say(f"{facts.seconds:.2f} s of motion written to {facts.output}")
        for part in facts.parts:
            printing.say(f"  {part.capture} {part.start:.2f}-{part.end:.2f} s")
        for seam in facts.seams:
            rough = "; far apart, look at it" if seam.is_rough else ""
            printing.say(
                f"  seam at {seam.seconds:.2f} s: {100 * seam.gap:.1f} cm and "
                f"{seam.speed_gap:.2f} m/s apart, blended over {seam.blended:.2f} s{rough}"
            )
        for line in facts.changes:
            printing.say(f"  {line}")
        printing.print_sources(facts.sources)
        printing.say(f"every frame's origin: {facts.provenance}")


def _numbered(
    number: int, output: Path, save: str | None, png: Path | None
) -> list[tuple[Path, str | None, Path | None]]:
    """Files and names of the variants: as given for one, with -1, -2, ... for several."""
    if number == 1:
        return [(output, save, png)]
    return [
        (
            options.numbered(output, n),
            None if save is None else f"{save}-{n}",
            None if png is None else options.numbered(png, n),
        )
        for n in range(1, number + 1)
    ]


def _print_generated(
    shared: options.Shared,
    motions: Sequence[Generated],
    facts: Sequence[WrittenMotion],
    asked: int,
) -> None:
    """Print the motions as text, or as JSON: one object, or ``variants`` if more were asked for."""
    from motiondb.answers.making import Variants

    first = motions[0]
    several = Variants(all(made.shows_all for made in motions), asked, list(facts))
    if printing.as_json(shared, facts[0] if asked == 1 else several):
        return
    not_used = {left: None for made in motions for left in made.not_used}
    for why_not in dict.fromkeys(made.why_not for made in motions if made.why_not):
        printing.say(why_not)
    printing.print_question(first.question.understood, first.unknown, list(not_used), "generation")
    for made, one in zip(motions, facts):
        _print_one(made, one)
    if len(motions) < asked:
        printing.say(_say_fewer(len(motions), asked, motions[-1].took_all_places))


def _say_fewer(number: int, asked: int, took_all_places: bool) -> str:
    """That there are fewer different motions than asked for, and why.

    >>> _say_fewer(1, 3, True)
    '1 of 3 written: no other place shows this about as clearly'
    >>> _say_fewer(2, 3, False)
    '2 of 3 written: no other was found'
    """
    why = "no other place shows this about as clearly" if took_all_places else "no other was found"
    return f"{number} of {asked} written: {why}"


def _print_one(made: Generated, facts: WrittenMotion) -> None:
    printing.say(
        f"{facts.seconds:.2f} s of motion written to {facts.output} "
        f"({made.method}, seed {made.seed})"
    )
    for line in (*made.decided, *facts.changes):
        printing.say(f"  {line}")
    for shown in made.shown:
        printing.say(f"  {_say_shown(shown)}")
        for line in shown.done:
            printing.say(f"      {line}")
    printing.say(_say_smoothness(facts))
    printing.print_sources(facts.sources)
    printing.say(f"every frame's origin: {facts.provenance}")


def _say_smoothness(facts: WrittenMotion) -> str:
    """Slip, float and jumps of a motion, each beside those of its sources where it has any."""
    of = facts.smoothness

    def both(value: float | None, source: float | None, unit: str, digits: int = 1) -> str:
        text = "not measured (no foot stands)" if value is None else f"{value:.{digits}f} {unit}"
        return text if source is None else f"{text}, in the sources {source:.{digits}f}"

    def cm(value: float | None, source: float | None, unit: str) -> str:
        own, theirs = (None if v is None else 100.0 * v for v in (value, source))
        return both(own, theirs, unit)

    jump = both(of.speed_jump, of.speed_jump_of_sources, "m/s", 2)
    return (
        f"feet slip {cm(of.foot_slip, of.foot_slip_of_sources, 'cm/s')}; "
        f"toes {cm(of.toe_slip, of.toe_slip_of_sources, 'cm/s')}; "
        f"feet float {cm(of.floating, of.floating_of_sources, 'cm')}; "
        f"the speed jumps by at most {jump}"
    )


def _say_shown(one: JudgedAction) -> str:
    """One action: its interval, whether it is shown, and the words that its motion resembles."""
    place = f"{one.start / FPS:.2f}-{one.end / FPS:.2f} s  " if one.end > one.start else ""
    said = {True: "shown", False: "not shown", None: "not sure"}[one.shown]
    sure = "" if one.probability is None else f" ({one.probability:.2f})"
    why = f": {one.reason}" if one.reason else ""
    looks = ", ".join(f"{word} {p:.2f}" for word, p in one.described)
    return f"{place}{' '.join(one.words)}: {said}{sure}{why}" + (
        f"; looks like {looks}" if looks else ""
    )
