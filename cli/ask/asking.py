"""Commands search, like, describe and generate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from motiondb.cli.ask import explaining, generation, understanding
from motiondb.cli.html_files import Html, write_html
from motiondb.cli.options import (
    DEFAULT_DB,
    Db,
    Exact,
    From,
    Json,
    Limit,
    Png,
    Seed,
    To,
    Where,
    database,
)
from motiondb.cli.printing import (
    note_filter,
    note_sources,
    note_taken,
    note_unchecked,
    note_unlearned,
    print_json,
    print_table,
    progress,
    say_word,
)

if TYPE_CHECKING:
    from motiondb import ExampleAnswer, Match, WordAnswer

Example = Annotated[str, typer.Argument(help="A file, or the name of a stored capture.")]


def register(app: typer.Typer) -> None:
    """Add the commands to the app."""
    app.command()(search)
    app.command()(like)
    app.command()(describe)
    app.command()(generate)


def search(
    words: Annotated[str, typer.Argument(help='Actions to search for, such as "walk, turn left".')],
    where: Where = "",
    limit: Limit = 10,
    by_symbols: Annotated[
        bool,
        typer.Option(
            "--by-symbols", help="Decode the words to symbols and align these (as in paper A)."
        ),
    ] = False,
    explain: Annotated[
        bool, typer.Option("--explain", help="Show the contribution of every symbol to every word.")
    ] = False,
    exact: Exact = False,
    png: Png = None,
    html: Html = None,
    db: Db = DEFAULT_DB,
    json: Json = False,
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
        from motiondb import QueryError

        raise QueryError(
            "search: expected --explain or --by-symbols, found both. An answer by symbols comes "
            "from an alignment of sequences, so there is nothing more to explain."
        )
    with database(db) as base:
        answer = base.search(words, where, limit, by_symbols, exact=exact)
        note_filter(base, where, exact)
        note_unlearned(base)
        if png and explain and answer.reasons:
            base.draw_reasons(answer, png, words)
        elif png and answer.matches:
            base.draw_matches(answer, png, words)
        if html:
            from motiondb import StandalonePage

            write_html(html, StandalonePage.of_search(base, answer))
    _note_words(answer, silent=explain and not json)
    why = [e.facts() for e in answer.explanations] if explain else []
    more = {
        "question": answer.question.facts(answer.not_used),
        **_word_facts(answer),
    }
    if not json:
        understanding.print_question(answer.question, answer.not_used, "search")
    _print_answer(answer, json, reasons=True, why=why, more=more)
    if explain and not json:
        explaining.print_explanations(answer)


def _note_words(answer: WordAnswer, silent: bool) -> None:
    """Print on standard error from which captions the words of an answer were learned.

    ``silent``: without the captions, which the explanation names.
    """
    note_taken(answer.taken, answer.suggested, answer.unknown)
    for written in answer.written:
        typer.echo(written.sentence(), err=True)
    if not silent:
        note_sources(answer.sources)
    note_unchecked(answer.unchecked)


def _word_facts(answer: WordAnswer) -> dict[str, Any]:
    """The sources of the words of an answer, for JSON; empty ones are left out."""
    facts: dict[str, Any] = {
        "decoding": asdict(answer.decoding) if answer.decoding else None,
        "sources": [asdict(source) for source in answer.sources],
        "written": [
            {
                "word": w.word,
                "tags": list(w.tags),
                "captures": len(w.captures),
                "in_captions": w.in_captions,
            }
            for w in answer.written
        ],
        "taken": {word: taking.facts() for word, taking in answer.taken.items()},
    }
    return {name: value for name, value in facts.items() if value}


def like(
    example: Example,
    start: From = None,
    end: To = None,
    where: Where = "",
    limit: Limit = 10,
    meaning: Annotated[
        bool | None,
        typer.Option(
            "--meaning/--by-motion-alone",
            help="Whether learned words are compared too, which also finds other styles of an "
            "action.  [default: if there are words]",
            show_default=False,
        ),
    ] = None,
    exact: Exact = False,
    png: Png = None,
    html: Html = None,
    db: Db = DEFAULT_DB,
    json: Json = False,
) -> None:
    """Search for intervals that move like an example.

    If captures of two or more performers have captions, every answer has a probability that it
    shows the same action, and a line says if none is good enough.
    """
    with database(db) as base:
        answer = base.like(example, start, end, where, limit, meaning, exact)
        note_filter(base, where, exact)
        note_unlearned(base)
        if png and answer.matches:
            motion = base.motion(example, start, end)
            base.draw_matches(answer, png, f"like {example}", motion)
        if html:
            from motiondb import StandalonePage

            write_html(html, StandalonePage.of_like(base, answer, example, start, end))
    note_unchecked(answer.unchecked)
    _print_answer(answer, json, reasons=any(m.reason for m in answer))


def _print_answer(
    answer: WordAnswer | ExampleAnswer,
    json: bool,
    reasons: bool = False,
    why: Sequence[dict[str, Any]] = (),
    more: Mapping[str, Any] | None = None,
) -> None:
    """Print the matches, and whether any is good enough; in JSON one object."""
    matches, any_match = answer.matches, answer.matches_anything
    if json:
        rows: list[dict[str, Any]] = [
            {
                "rank": m.rank,
                "capture": m.capture,
                "start": m.start,
                "end": m.end,
                "score": m.score,
                "probability": m.probability,
                "words": list(m.words),
            }
            for m in matches
        ]
        for row, match in zip(rows, matches):
            row.update(_place_facts(match))
        for row, reason in zip(rows, why):
            row["explain"] = reason
        print_json(
            {
                "matches_anything": any_match,
                "strength": answer.strength,
                "threshold": answer.threshold,
                **({"unchecked": answer.unchecked} if answer.unchecked else {}),
                "matches": rows,
                **(more or {}),
            }
        )
        return
    if any_match is False:
        typer.echo("nothing in this database matches" + ("; the nearest:" if matches else ""))
    if matches:
        _print_matches(matches, reasons, bool(answer.unchecked))


def _place_facts(match: Match) -> dict[str, Any]:
    """The intervals of an answer to words with certainties, for JSON; empty for other answers."""
    if not match.parts:
        return {}
    return {
        "interval_probability": match.interval_probability,
        "place": match.place,
        "parts": [asdict(part) for part in match.parts],
    }


def _print_matches(matches: Sequence[Match], reasons: bool, unchecked: bool) -> None:
    """Print a table; probabilities that no own caption has checked are printed as "-".

    So is the probability of an interval that is shown but was never checked for these words.
    """
    sure = unchecked or any(m.probability is not None for m in matches)
    nothing = "-" if unchecked else ""
    chances = [nothing or _two_digits(m.probability) for m in matches]
    placed = any(m.interval_probability is not None or _is_place_unchecked(m) for m in matches)
    intervals = [
        "-" if _is_place_unchecked(m) else _two_digits(m.interval_probability) for m in matches
    ]
    columns = ["rank", "capture", "start", "end", "score"] + ["probability"] * sure
    columns += ["interval"] * placed
    print_table(
        "",
        [*columns, "words"] + (["found"] if reasons else []),
        [
            [str(m.rank), m.capture, f"{m.start:.2f}", f"{m.end:.2f}", f"{m.score:.3f}"]
            + [chance] * sure
            + [interval] * placed
            + [" ".join(m.words) or nothing]
            + ([m.reason] if reasons else [])
            for m, chance, interval in zip(matches, chances, intervals)
        ],
    )


def _is_place_unchecked(match: Match) -> bool:
    """Whether an answer has a probability, but none that its interval is right."""
    known = match.probability is not None and match.place == "known"
    return bool(match.parts) and known and match.interval_probability is None


def _two_digits(probability: float | None) -> str:
    return "" if probability is None else f"{probability:.2f}"


def describe(
    example: Example,
    start: From = None,
    end: To = None,
    db: Db = DEFAULT_DB,
    json: Json = False,
) -> None:
    """Describe a motion by words, with times and probabilities that captions have checked."""
    with database(db) as base:
        answer = base.describe(example, start, end)
        sources = base.word_sources(word for d in answer for word, _ in d.words[:3])
        unchecked = base.why_unchecked(word for d in answer for word, p in d.words if p is None)
    note_sources(sources)
    note_unchecked(unchecked)
    if json:
        print_json(
            [
                {
                    "start": d.start,
                    "end": d.end,
                    "words": [{"word": w, "probability": p} for w, p in d.words],
                }
                for d in answer
            ]
        )
        return
    rows = [
        [f"{d.start:.2f}", f"{d.end:.2f}", "  ".join(say_word(w, p) for w, p in d.words)]
        for d in answer
    ]
    print_table("", ["start", "end", "words"], rows)


def generate(
    words: Annotated[str, typer.Argument(help='A sentence, such as "a person walks then kicks".')],
    output: Annotated[Path, typer.Option("-o", "--output", help="File: .bvh, .glb or .gltf.")],
    seed: Seed = 0,
    method: Annotated[str, typer.Option("--method", help="stitched or trajectory.")] = "stitched",
    exact: Exact = False,
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
    png: Png = None,
    html: Html = None,
    db: Db = DEFAULT_DB,
    json: Json = False,
) -> None:
    """Generate a motion from a sentence, and say which of its actions the motion shows.

    A file beside it names its sources. The exit code is 1 if an action is not shown, or cannot be
    confirmed.
    """
    with database(db, writing=save is not None) as base, progress(not json) as tell:
        tell("generating", 0.0, 1.0)
        names = generation.numbered(variants, output, save, png)
        for _, name, _ in names:
            if name is not None:
                base.check_name_free(name)
        motions = base.generate_variants(words, variants, seed, method, exact, anyway)
        facts = []
        for number, (made, (path, name, picture)) in enumerate(zip(motions, names), 1):
            facts.append(made.write(path))
            if name is not None:
                base.save_generated(name, words, made, made.seed)
                facts[-1]["capture"] = name
            if picture is not None:
                made.draw(picture)
            if html is not None:
                from motiondb import StandalonePage

                page = html if variants == 1 else generation.numbered_path(html, number)
                write_html(page, StandalonePage.of_generated(base, made, name or ""))
    note_taken(motions[0].taken, motions[0].suggested, motions[0].unknown)
    note_sources(motions[0].sources)
    generation.print_generated(motions, facts, json, variants)
    if not all(made.shows_all for made in motions):
        raise typer.Exit(1)
