"""Commands search, like, along, rhythm, describe and compare."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import motiondb
from motiondb.cli import options, printing

app = options.Commands()

AsCsv = Annotated[
    Path | None,
    options.option(
        "Write the answers as a table, CSV if .csv, else TSV; - prints CSV.",
        "--csv",
        allow_dash=True,
        callback=options.output_name,
    ),
]
Example = Annotated[str, options.argument("A file, or the name of a stored capture.")]


@app.command()
def search(
    shared: options.Shared,
    words: Annotated[str, options.argument('Actions to search for, such as "walk, turn left".')],
    where: options.Where = "",
    limit: options.Limit = 10,
    by_symbols: Annotated[
        bool, "Match by motion symbols instead of words (the 2015 paper)."
    ] = False,
    explain: Annotated[bool, "Show the contribution of every symbol to every word."] = False,
    exact: options.Exact = False,
    png: options.Png = None,
    html: options.Html = None,
    export: options.ExportFolder = None,
    as_csv: AsCsv = None,
) -> None:
    """Search for intervals that show actions, given by words, in their order.

    The question may hold "then", "while", "or", "not", "without", "twice", "for ten seconds",
    "slowly", parentheses, and "?" for any action. Its interpretation is printed above the answers,
    with the parts that the search does not use.

    Every answer has two probabilities, estimated with performers held out: the probability that the
    capture shows the actions, and the probability that the interval does. They are "-" until
    captions of the database, 50 or more, have checked them. If the only evidence for an action is
    a caption of the whole capture, its place is unknown. If no answer is good enough, a line says
    so before the nearest ones.
    """
    if explain and by_symbols:
        raise motiondb.QueryError(
            "search: expected --explain or --by-symbols, found both. An answer by symbols comes "
            "from an alignment of sequences, so there is nothing more to explain."
        )
    with shared.database() as base:
        answer = base.search(words, where, limit, by_symbols, exact=exact)
        printing.note_filter(base, where, exact)
        printing.note_unlearned(base)
        if png and explain and answer.reasons:
            base.captures.draw_reasons(answer, png, words)
        elif png and answer.matches:
            base.captures.draw_matches(answer, png, words)
        if html:
            printing.write_html(html, motiondb.StandalonePage.of_search(base, answer))
        if export:
            _write_matches(base, answer, export, words)
    _note_words(answer, silent=explain and not shared.json)
    if as_csv:
        _write_csv(answer.matches, as_csv)
        return
    if printing.as_json(shared, motiondb.search_answer(answer, explain)):
        return
    if answer.not_understood:
        printing.say(answer.not_understood)
    printing.print_question(answer.understood, answer.unknown, answer.not_used, "search")
    _print_answer(
        answer,
        reasons=True,
        unscored=bool(answer.missing or any(each.nearest for each in answer.taken.values())),
    )
    if explain:
        _print_explanations(answer)


def _write_csv(matches: Sequence[motiondb.Match], path: Path) -> None:
    """Write the answers as a table, or print them (-)."""
    columns = ["rank", "capture", "start", "end", "score", "probability"]
    columns += ["interval_probability", "words", "reason"]
    every = [[getattr(match, column) for column in columns] for match in matches]
    rows = [
        [" ".join(v) if isinstance(v, tuple) else "" if v is None else str(v) for v in row]
        for row in every
    ]
    printing.write_rows(columns, rows, path, "answer")


def _write_matches(
    base: motiondb.MotionDB,
    answer: motiondb.WordAnswer | motiondb.ExampleAnswer,
    folder: Path,
    question: str,
) -> None:
    """Write the matches into a folder, and say so on standard error."""
    files = base.captures.export_matches(answer, folder, question)
    licences = ", ".join(sorted({file.licence for file in files})) or "none"
    printing.warn(
        f"export: {printing.number(len(files), 'motion')} in {folder}, each with its origin beside "
        f"it; licences: {licences}"
    )


def _note_words(answer: motiondb.WordAnswer, silent: bool) -> None:
    """Print on standard error from which captions the words of an answer were learned.

    ``silent``: without the captions, which the explanation names.
    """
    printing.note_words(answer)
    for written in answer.written:
        printing.warn(written.sentence())
    if not silent:
        printing.note_sources(answer.sources)
    printing.note(answer.unchecked)


@app.command()
def like(
    shared: options.Shared,
    example: Example,
    start: options.From = None,
    end: options.To = None,
    where: options.Where = "",
    limit: options.Limit = 10,
    meaning: Annotated[
        bool | None,
        options.option(
            "Whether learned words are compared too, which also finds other styles of an "
            "action.  [default: if there are words]",
            "--meaning/--by-motion-alone",
            show_default=False,
        ),
    ] = None,
    exact: options.Exact = False,
    png: options.Png = None,
    html: options.Html = None,
    export: options.ExportFolder = None,
    up: options.Up = "",
    as_csv: AsCsv = None,
) -> None:
    """Search for intervals that move like an example.

    If captures of two or more performers have captions, every answer has a probability that it
    shows the same action, and a line says if none is good enough.
    """
    with shared.database() as base:
        read = printing.read_example(base, example, up)
        answer = base.like(read, start, end, where, limit, meaning, exact)
        printing.note_filter(base, where, exact)
        printing.note_unlearned(base)
        if png and answer.matches:
            motion = base.motion(read, start, end)
            base.captures.draw_matches(answer, png, f"like {example}", motion)
        if html:
            printing.write_html(
                html,
                motiondb.StandalonePage.of_like(
                    base, answer, example, start, end, None if isinstance(read, str) else read
                ),
            )
        if export:
            _write_matches(base, answer, export, f"like {example}")
    printing.note(answer.unchecked)
    if as_csv:
        _write_csv(answer.matches, as_csv)
        return
    if printing.as_json(shared, motiondb.like_answer(answer)):
        return
    _print_answer(answer, reasons=any(m.reason for m in answer))


@dataclass(frozen=True)
class PartsAsked:
    """Options of the commands that search for parts of captures."""

    where: options.Where = ""
    limit: options.Limit = 10
    exact: options.Exact = False
    png: options.Png = None
    export: options.ExportFolder = None
    as_csv: AsCsv = None


@app.command()
def along(
    shared: options.Shared,
    path: Annotated[
        str,
        options.argument(
            'Points in metres, to the right and up as seen from above, such as "0,0 0,3 2,3".'
        ),
    ],
    asked: PartsAsked,
    words: Annotated[str, 'What is done along it, such as "walk".'] = "",
) -> None:
    """Search for intervals that travel along a path on the floor.

    The path may lie anywhere and in any direction, and answers be up to .7 or 1.4 times as long. A
    mirror image is another path. A line says if none goes along it.
    """
    with shared.database() as base:
        answer = base.captures.along(path, words, asked.where, asked.limit, asked.exact)
        _write_parts(base, answer, asked, f"along {path}")
    _print_parts(shared, answer, asked)


@app.command()
def rhythm(
    shared: options.Shared,
    taps: Annotated[
        str, options.argument('Times of three or more taps in seconds, such as "0 .5 1 1.5".')
    ],
    asked: PartsAsked,
    words: Annotated[str, 'What is done in it, such as "walk".'] = "",
) -> None:
    """Search for intervals whose steps fall at the times of taps.

    The first tap may be at any moment, and steps .8 to 1.25 times as fast. Either foot may begin. A
    line says if nobody steps in it.
    """
    with shared.database() as base:
        answer = base.captures.rhythm(taps, words, asked.where, asked.limit, asked.exact)
        _write_parts(base, answer, asked, f"in the rhythm {taps}")
    _print_parts(shared, answer, asked)


def _write_parts(
    base: motiondb.MotionDB, answer: motiondb.ExampleAnswer, asked: PartsAsked, title: str
) -> None:
    """Write the files of an answer with parts of captures."""
    printing.note_filter(base, asked.where, asked.exact)
    printing.note_unlearned(base)
    if asked.png and answer.matches:
        base.captures.draw_matches(answer, asked.png, title)
    if asked.export:
        _write_matches(base, answer, asked.export, title)


def _print_parts(shared: options.Shared, answer: motiondb.ExampleAnswer, asked: PartsAsked) -> None:
    """Print an answer with parts of captures, or its table."""
    if asked.as_csv:
        _write_csv(answer.matches, asked.as_csv)
        return
    if not printing.as_json(shared, motiondb.like_answer(answer)):
        if answer.read_as:
            printing.say(f"read as: {answer.read_as}")
        _print_answer(answer, reasons=True)


def _print_answer(
    answer: motiondb.WordAnswer | motiondb.ExampleAnswer, reasons: bool, unscored: bool = False
) -> None:
    """Print the matches, and whether any is good enough."""
    matches = answer.matches
    for remark in answer.remarks if isinstance(answer, motiondb.WordAnswer) else ():
        printing.say(remark)
    if answer.nothing:
        printing.say(answer.nothing + ("; the nearest:" if matches else ""))
    if matches:
        _print_matches(matches, reasons, unscored)


def _print_matches(matches: Sequence[motiondb.Match], reasons: bool, unscored: bool) -> None:
    """Print a table; probabilities that were not measured are printed as "-", and explained.

    `unscored`: without scores, which are for less than what was asked.
    """
    has_interval = any(m.parts for m in matches)  # neither an example nor symbols have one
    rows = [
        [m.rank, m.capture, f"{m.start:.2f}", f"{m.end:.2f}"]
        + [f"{m.score:.3f}"] * (not unscored)
        + [_two_digits(m.probability)]
        + [_two_digits(m.interval_probability)] * has_interval
        + [" ".join(m.words)]
        + ([m.reason] if reasons else [])
        for m in matches
    ]
    columns = ["rank", "capture", "start", "end"] + ["score"] * (not unscored) + ["probability"]
    columns += ["interval"] * has_interval + ["words"] + ["found"] * reasons
    printing.print_table(columns, rows)
    if any(printing.NOT_MEASURED in row for row in rows):
        printing.say(
            f"({printing.NOT_MEASURED}: no reliable probability for this kind of question)"
        )


def _two_digits(probability: float | None) -> str:
    return printing.NOT_MEASURED if probability is None else f"{probability:.2f}"


@app.command()
def describe(
    shared: options.Shared,
    example: Annotated[
        str | None, options.argument("A file, or the name of a stored capture.")
    ] = None,
    start: options.From = None,
    end: options.To = None,
    where: options.Where = "",
    output: Annotated[
        Path | None,
        options.output(
            "Write a sheet: file, start, end, words, probabilities (CSV if .csv, else TSV).",
            options.output_name,
        ),
    ] = None,
    up: options.Up = "",
    gait: Annotated[bool, "Measure how somebody walks or runs, in place of words."] = False,
    png: options.Png = None,
    as_csv: AsCsv = None,
) -> None:
    """Describe a motion, or all captures that match --where, by words, or by its gait (--gait).

    The words have times, and probabilities that captions have checked. A gait has strikes of the
    feet, cycles, cadence, lengths, speed and angles of the legs.
    """
    if gait:
        from motiondb.cli.curation import describe_gait

        describe_gait(shared, example, where, start, end, up, output, png, as_csv)
        return
    if png or as_csv:
        raise motiondb.QueryError(
            "describe: expected --gait with --png and --csv, found none. Words are written by -o."
        )
    if (example is None) == (not where.strip()):
        raise motiondb.QueryError(
            "describe: expected a capture or --where, found "
            f"{'neither' if example is None else 'both'}."
        )
    if where.strip() and (start is not None or end is not None):
        raise motiondb.QueryError(
            "describe: expected --from and --to with one capture, found --where."
        )
    with shared.database() as base:
        if example is None:
            answers = {info.name: base.describe(info.name) for info in base.captures(where)}
        else:
            read = printing.read_example(base, example, up)
            answers = {example: base.describe(read, start, end)}
        told = [d for answer in answers.values() for d in answer]
        sources = base.words.sources(dict.fromkeys(w for d in told for w, _ in d.words[:3]))
        unchecked = base.words.why_unchecked(word for d in told for word, p in d.words if p is None)
    printing.note_sources(sources)
    printing.note(unchecked)
    spans = [
        ([name, f"{d.start:.2f}", f"{d.end:.2f}"], d.words)
        for name, answer in answers.items()
        for d in answer
    ]
    if output:
        cells = [
            [*span, " ".join(w for w, _ in words), " ".join(_two_digits(p) for _, p in words)]
            for span, words in spans
        ]
        motiondb.write_table(output, ["file", "start", "end", "words", "probabilities"], cells)
        printing.warn(f"{printing.number(len(answers), 'capture')} described in {output}")
    timed = {name: motiondb.words_over_time(answer) for name, answer in answers.items()}
    if printing.as_json(shared, timed if example is None else timed[example]) or output:
        return
    rows = [[*span, "  ".join(printing.say_word(w, p) for w, p in words)] for span, words in spans]
    first = 1 if example is not None else 0
    columns = ["capture", "start", "end", "words"]
    printing.print_table(columns[first:], [row[first:] for row in rows])


@app.command()
def compare(
    shared: options.Shared,
    first: Example,
    second: Annotated[str, options.argument("The other.")],
    png: options.Png = None,
) -> None:
    """Align two motions in time, and say how far they are apart.

    Poses are compared on the standard body, relative to the pelvis and the heading. --png draws the
    distances of all poses with the alignment.
    """
    with shared.database() as base:
        told = base.compare(first, second, png)
    if printing.as_json(shared, told):
        return
    mirrored = f"; with the mirror image of the first {told.mirrored_distance:.3f} m"
    printing.say(f"mean distance of joints: {told.distance:.3f} m{mirrored}")
    printing.say(f"lengths: {told.first_seconds:.2f} s and {told.second_seconds:.2f} s")
    farthest = ", ".join(f"{each.joint} {each.distance:.3f} m" for each in told.joints[:5])
    printing.say(f"farthest apart: {farthest}")
    marks = [told.alignment[n * (len(told.alignment) - 1) // 8] for n in range(9)]
    printing.say(
        f"time in {first} -> time in {second} (s): "
        + ", ".join(f"{a:.2f} -> {b:.2f}" for a, b in marks)
    )
    printing.say_pictures(png)


def _print_explanations(answer: motiondb.WordAnswer) -> None:
    """Print the log-odds of every match, then one line for each word."""
    for source in answer.sources:
        printing.say(source.sentence())
    for match, why in zip(answer.matches, answer.explanations):
        printing.say(
            f"{match.rank} {match.capture}  log-odds {why.log_odds:+.3f}, score {match.score:.3f}"
        )
        for word in why.words:
            printing.say(f"    {_word_line(word)}")
        if why.suggests:
            printing.say(f"    captions nearest to its motion: {'; '.join(why.suggests)}")
        if why.together:
            printing.say(f"    all of them together: {why.together:+.3f}")
        for excluded in why.excluded:
            printing.say(
                f"    not {' '.join(word.word for word in excluded.words)}: "
                f"{excluded.amount:+.3f}, as its log-odds are {excluded.log_odds:+.3f}"
            )
            for word in excluded.words:
                printing.say(f"        {_word_line(word)}")


def _word_line(word: motiondb.ExplainedWord) -> str:
    """The contribution of one word, and its parts."""
    rest = word.others
    others = f", others {rest:+.3f}" if abs(rest) >= 0.0005 else ""
    shares = ", ".join(
        f"symbol {s.symbol} {s.share:+.3f} ({s.from_:.1f}-{s.to:.1f} s)" for s in word.strongest
    )
    written = f", written {word.written:+.3f}" if word.written else ""
    if word.likeness:
        written += f", likeness {word.likeness:+.3f}"
    usual = f"{word.word}: {word.contribution:+.3f} = usual {word.prior:+.3f}"
    return f"{usual}{written}, {shares}{others}"
