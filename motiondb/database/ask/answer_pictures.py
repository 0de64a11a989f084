"""Pictures of the answers to a question, and of the reasons of the best one."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from motiondb import pictures
from motiondb.errors import QueryError
from motiondb.records import Match, Motion
from motiondb.search.explained_answer import ExplainedWord
from motiondb.search.word_answers import WordAnswer

if TYPE_CHECKING:
    from motiondb.database.ask.question_verbs import QuestionVerbs

SHOWN_MATCHES = 8  # Most matches in a picture: more would be too small on a screen
LEAST_SHARE = 0.005  # Nats from which on a contribution is drawn: smaller ones round to 0.00


def draw_matches(
    base: QuestionVerbs,
    matches: Sequence[Match],
    path: str | Path,
    title: str = "",
    example: Motion | None = None,
) -> Path:
    """Draw the first matches as rows of stick figures, with the example above them."""
    hits = [(match, base.motion(match.capture)) for match in matches[:SHOWN_MATCHES]]
    query = None if example is None else ("query", example)
    return pictures.draw_hits(hits, Path(path), title=title, query=query)


def draw_reasons(base: QuestionVerbs, answer: WordAnswer, path: str | Path, title: str) -> Path:
    """Draw the capture of the best match over a timeline of contributions for each word."""
    if not answer.explanations:
        raise QueryError(
            f"{title}: expected an answer with reasons, found one without. Search for words, not by"
            " symbols, that some capture shows."
        )
    best, why = answer.matches[0], answer.explanations[0]
    words = [*why.words, *(word for one in why.excluded for word in one.words)]
    rows = [(best.start, best.end, f"{best.start:.1f}-{best.end:.1f} s", 0)]
    timelines = [*map(_timeline, words), pictures.Timeline("found", rows)]
    return pictures.draw_strip(
        base.motion(best.capture), path, title=f"{title}: {best.capture}", timelines=timelines
    )


def _timeline(word: ExplainedWord) -> pictures.Timeline:
    """The contributions of the motion to one word."""
    return pictures.Timeline(
        word.word,
        [
            (share.from_, share.to, f"{share.share:+.2f}", share.symbol)
            for share in word.symbols
            if abs(share.share) > LEAST_SHARE
        ],
    )
