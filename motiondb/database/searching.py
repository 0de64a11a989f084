"""Questions of one session: what is searched, the words that replace unknown ones, pictures.

Two motions are compared here, too.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from motiondb import answers, store
from motiondb.database.catalogue.filter_words import take_filter_words
from motiondb.database.loading import nearby_table
from motiondb.database.session import Session
from motiondb.database.values import Where, check_least, check_text
from motiondb.errors import QueryError
from motiondb.language.question.readings import say
from motiondb.learn.learned import Learned
from motiondb.records import MOTION_FPS, Float32Array, Match, Motion
from motiondb.search.asked_words import WrittenWord, find_written
from motiondb.search.asking import ask
from motiondb.search.by_words import WordAnswer, as_near, search_words
from motiondb.search.reasons import ExplainedWord
from motiondb.symbols.hmm_jobs import one_blas_thread

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from motiondb.database.values import Example
    from motiondb.pictures import Timeline


SHOWN_MATCHES = 8  # Most matches in a picture: more would be too small on a screen
LEAST_SHARE = 0.005  # Nats from which on a contribution is drawn: smaller ones round to 0.00


def search(
    session: Session,
    words: str,
    where: Where,
    limit: int,
    by_symbols: bool,
    written: bool,
    exact: bool,
) -> WordAnswer:
    """The answer to a question in words, as ``MotionDB.search`` gives it."""
    check_text("words", words)
    check_least("limit", limit, 1)
    with session.reading():
        allowed = allowed_captures(session, where, exact)
        check_any(session.searchable)
        return answer_words(session, words, allowed, limit, exact, written, by_symbols)


def answer_words(
    session: Session,
    words: str,
    allowed: Sequence[int],
    limit: int,
    exact: bool,
    written: bool = True,
    by_symbols: bool = False,
) -> WordAnswer:
    """The answer to a question in words; with near words, if the asked ones match nothing.

    `allowed`: Numbers of the captures that are searched.
    """
    learned, pool = session.searchable, cache(lambda: session.features)

    def written_words() -> dict[str, WrittenWord]:
        return session.kept("written_words", lambda: find_written(learned))

    def features(capture: int) -> Float32Array:
        return pool().of_capture(capture)

    with one_blas_thread():  # for small matrices a second thread takes longer
        question = ask(learned, words, nearby_table(), written_words, exact, by_symbols)
        if by_symbols:
            from motiondb.search.by_symbols import search_decoded  # compiled code

            return search_decoded(question, allowed, limit)
        answer = search_words(question, allowed, limit, written, features)
        if answer.nothing and answer.matches and not exact:
            near = question.with_near_words(nearby_table())
            if near is not None:
                instead = search_words(near, allowed, limit, written, features)
                if not instead.nothing:
                    said = (say(each.sentence.parsed.tree) for each in (question, near))
                    return as_near(instead, *said)
        return answer


def check_any(learned: Learned) -> None:
    """Refuse a question about a database whose captures were all removed since it learned."""
    if not learned.rows:
        raise QueryError(
            f"{learned.source}: expected captures that can be searched, found none. Add some: "
            "motiondb add FOLDER. motiondb undo brings removed ones back."
        )


def allowed_captures(session: Session, where: Where, exact: bool) -> list[int]:
    """Numbers of the captures that a filter lets through; all that can be searched without one."""
    where = session.filter(where)
    if not where.strip():
        return list(session.searchable.captures)
    filters = where if exact else take_filter_words(session.store, where)[0]
    return [info.capture_id for info in store.load_captures(session.store, filters)]


def draw_matches(
    session: Session,
    matches: Sequence[Match],
    path: str | Path | None,
    title: str,
    example: Motion | None,
) -> Path | Figure:
    """Draw the first matches as rows of stick figures, with the example above them."""
    from motiondb import pictures

    with session.reading():
        hits = [(match, _motion(session, match.capture)) for match in matches[:SHOWN_MATCHES]]
    query = None if example is None else ("query", example)
    return pictures.save_png(pictures.hits_figure(hits, title, query), path)


def draw_reasons(
    session: Session, answer: WordAnswer, path: str | Path | None, title: str
) -> Path | Figure:
    """Draw the capture of the best match over a timeline of contributions for each word."""
    from motiondb import pictures

    if not answer.explanations:
        raise QueryError(
            f"{title}: expected an answer with reasons, found one without. Search for words, not by"
            " symbols, that some capture shows."
        )
    best, why = answer.matches[0], answer.explanations[0]
    words = [*why.words, *(word for one in why.excluded for word in one.words)]
    rows = [(best.start, best.end, f"{best.start:.1f}-{best.end:.1f} s", 0)]
    timelines = [*map(_timeline, words), pictures.Timeline("found", rows)]
    with session.reading():
        motion = _motion(session, best.capture)
    figure = pictures.strip_figure(motion, f"{title}: {best.capture}", timelines)
    return pictures.save_png(figure, path)


def _motion(session: Session, name: str) -> Motion:
    return store.load_motion(session.store, store.load_capture(session.store, name).capture_id)


def _timeline(word: ExplainedWord) -> Timeline:
    """The contributions of the motion to one word."""
    from motiondb import pictures

    return pictures.Timeline(
        word.word,
        [
            (share.from_, share.to, f"{share.share:+.2f}", share.symbol)
            for share in word.symbols
            if abs(share.share) > LEAST_SHARE
        ],
    )


def compare(
    session: Session, first: Example, second: Example, png: str | Path | None = None
) -> answers.Comparison:
    """Align two examples by dynamic time warping, and measure how far they are apart."""
    from motiondb import pictures
    from motiondb.body.body import JOINTS
    from motiondb.database.catalogue.parts import load_example
    from motiondb.search.alignment import MOST_POSES, align
    from motiondb.search.copies import copy_poses, mirror_poses

    names = [str(e) if isinstance(e, str | Path) else "motion" for e in (first, second)]
    motions = load_example(session, first), load_example(session, second)
    step = math.ceil(max(motion.n_frames for motion in motions) / MOST_POSES)
    poses, others = (copy_poses(motion)[::step] for motion in motions)
    found, mirrored = align(poses, others), align(mirror_poses(poses), others)
    times = found.path.T * (step / MOTION_FPS)
    if png is not None:
        spans = [(0.0, motion.n_frames / MOTION_FPS) for motion in motions]
        figure = pictures.comparison_figure(
            (names[0], names[1]), found.costs, (times[0], times[1]), (spans[0], spans[1])
        )
        pictures.save_png(figure, png)
    order = (-found.joint_distances).argsort()
    return answers.Comparison(
        names[0],
        names[1],
        round(float(found.distances.mean()), 4),
        round(float(mirrored.distances.mean()), 4),
        round(motions[0].duration, 3),
        round(motions[1].duration, 3),
        tuple(
            answers.JointDistance(JOINTS[n], round(float(found.joint_distances[n]), 4))
            for n in order
        ),
        tuple((round(float(a), 3), round(float(b), 3)) for a, b in zip(*times)),
        None if png is None else Path(png),
    )
