"""Commands generate, judge and join: motions from sentences, and what any motion shows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Annotated

import typer

import motiondb
from motiondb import answers
from motiondb.cli import options, printing

app = options.Commands()

FPS = 30.0  # Frames per second of generated motion
NOT_SURE = 3  # Exit code where a motion may show what is asked, or not


@app.command()
def generate(
    shared: options.Shared,
    changes: options.Changes,
    words: Annotated[str, options.argument('A sentence, such as "a person walks then kicks".')],
    output: options.Output,
    seed: options.Seed = 0,
    method: Annotated[str, "stitched or trajectory."] = "stitched",
    exact: options.Exact = False,
    anyway: Annotated[bool, "Generate the nearest motion if no capture shows an action."] = False,
    variants: Annotated[
        int, options.option("Most different motions: FILE-1, FILE-2, ...", min=1)
    ] = 1,
    save: options.SaveAs = None,
    png: options.Png = None,
    html: options.Html = None,
) -> None:
    """Generate a motion from a sentence, and say which of its actions the motion shows.

    A file beside it names its sources. The exit code is 1 if an action is not shown, or cannot be
    confirmed.
    """
    asked = changes.read()
    with (
        shared.database(writing=save is not None) as base,
        printing.progress(shared) as tell,
    ):
        tell("generating", 0.0, 1.0)
        numbers = range(1, variants + 1) if variants > 1 else [0]
        for n in numbers:
            options.output_name(options.numbered(output, n))
            options.output_name(png and options.numbered(png, n))
            if save is not None:
                base.captures.check_name_free(f"{save}-{n}" if n else save)
        motions = base.generate_variants(words, variants, seed, method, exact, anyway, asked)
        facts = []
        for n, made in zip(numbers, motions):
            name = f"{save}-{n}" if n and save is not None else save
            written = made.write(options.numbered(output, n), asked.of_file)
            facts.append(replace(written, capture=name))
            if png is not None:
                made.draw(options.numbered(png, n))
            if html is not None:
                page = motiondb.StandalonePage.of_generated(base, made, name or "")
                printing.write_html(options.numbered(html, n), page)
            if name is not None:  # last, so that nothing is saved if a file cannot be written
                base.captures.save_generated(name, words, made, made.seed)
    printing.note_words(motions[0])
    printing.note_sources(motions[0].sources)
    _print_generated(shared, motions, facts, variants)
    if not all(made.shows_all for made in motions):
        raise typer.Exit(1)


@app.command()
def judge(
    shared: options.Shared,
    example: Annotated[str, options.argument("A file, or the name of a stored capture.")],
    sentence: Annotated[str, options.argument('Such as "a person walks, then kicks twice".')],
    start: options.From = None,
    end: options.To = None,
    exact: options.Exact = False,
    up: options.Up = "",
) -> None:
    """Say whether a motion shows a sentence: its actions, their order and their number.

    The motion may come from anywhere, such as from a generator of others. Captures that it is a
    copy of, or was made from, are no evidence. The exit code is 0 if everything is shown, 1 if
    something is not shown, 3 if this is not sure.
    """
    with shared.database() as base:
        read = printing.read_example(base, example, up) if up else example
        told = base.judge(read, sentence, start, end, exact)
    if not printing.as_json(shared, told):
        _print_judgement(told)
    if told.shown is not True:
        raise typer.Exit(NOT_SURE if told.shown is None else 1)


def _print_judgement(told: answers.Judgement) -> None:
    """Print the verdict on a motion, on each action, and what the motion is most like."""
    chosen = f", by {told.chosen!r}" if told.chosen else ""
    why = f" - {told.reason}" if told.reason else ""
    printing.say(f"{SAID[told.shown]}{chosen}{why}")
    printing.print_question(told.question.understood, (), told.question.not_used, "judging")
    for one in told.actions:
        printing.say(f"  {_say_shown(one, 1.0)}", *(f"      {line}" for line in one.done))
    if told.nearest is not None:
        near = told.nearest
        printing.say(
            f"moves most like {near.capture} {near.start:.2f}-{near.end:.2f} s ({near.score:.2f})"
        )
    for finding in getattr(told.quality, "findings", ()):
        printing.say(f"quality: {finding.sentence}")
    for name in told.left_out:
        printing.note(f"{name} is the motion itself or a part of it, and no evidence")
    for sentence in told.sentences:
        printing.note(sentence)


@app.command()
def join(
    shared: options.Shared,
    changes: options.Changes,
    parts: Annotated[
        list[str], options.argument("Parts in order, times in seconds.", "CAPTURE:FROM-TO...")
    ],
    output: options.Output,
    png: options.Png = None,
) -> None:
    """Join parts of captures, such as `walk:0-2 kick:1-3`, with the blending of generate.

    A file beside it names its sources. Each seam is reported.
    """
    asked = changes.read()
    with shared.database() as base:
        options.output_name(output)
        joined = base.join(parts, asked)
        facts = joined.write(output, asked.of_file)
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


def _print_generated(
    shared: options.Shared,
    motions: Sequence[motiondb.Generated],
    facts: Sequence[answers.WrittenMotion],
    asked: int,
) -> None:
    """Print the motions as text, or as JSON: one object, or ``variants`` if more were asked for."""
    first = motions[0]
    several = answers.Variants(all(made.shows_all for made in motions), asked, list(facts))
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
    '1 of 3 written: no other excerpt shows this about as clearly'
    >>> _say_fewer(2, 3, False)
    '2 of 3 written: no other was found'
    """
    why = (
        "no other excerpt shows this about as clearly" if took_all_places else "no other was found"
    )
    return f"{number} of {asked} written: {why}"


def _print_one(made: motiondb.Generated, facts: answers.WrittenMotion) -> None:
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


def _say_smoothness(facts: answers.WrittenMotion) -> str:
    """Slip, float and jumps of a motion, each beside those of its sources where it has any."""
    of = facts.smoothness

    def both(value: float | None, source: float | None, unit: str, digits: int = 1) -> str:
        text = "not measured (no foot stands)" if value is None else f"{value:.{digits}f} {unit}"
        return text if source is None else f"{text} (originals {source:.{digits}f})"

    def cm(value: float | None, source: float | None, unit: str) -> str:
        own, theirs = (None if v is None else 100.0 * v for v in (value, source))
        return both(own, theirs, unit)

    jump = both(of.speed_jump, of.speed_jump_of_sources, "m/s", 2)
    return (
        f"foot sliding {cm(of.foot_slip, of.foot_slip_of_sources, 'cm/s')}, "
        f"toes {cm(of.toe_slip, of.toe_slip_of_sources, 'cm/s')}; "
        f"feet hover {cm(of.floating, of.floating_of_sources, 'cm')}; "
        f"largest jolt {jump}"
    )


SAID = {True: "shown", False: "not shown", None: "not sure"}


def _say_shown(one: motiondb.JudgedAction | answers.ActionVerdict, fps: float = FPS) -> str:
    """One action: its interval, whether it is shown, and the words that its motion resembles."""
    place = f"{one.start / fps:.2f}-{one.end / fps:.2f} s  " if one.end > one.start else ""
    sure = "" if one.probability is None else f" ({one.probability:.2f})"
    why = f": {one.reason}" if one.reason else ""
    near = (
        (each.word, each.probability) if isinstance(each, answers.WordProbability) else each
        for each in one.described
    )
    looks = ", ".join(f"{word} {p:.2f}" for word, p in near)
    return f"{place}{' '.join(one.words)}: {SAID[one.shown]}{sure}{why}" + (
        f"; looks like {looks}" if looks else ""
    )
