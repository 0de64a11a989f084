"""Questions of one session: what is searched, the words that replace unknown ones, pictures.

Two motions are compared here, too.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from motiondb import answers, pictures, store
from motiondb.body.features import FEATURE_FPS, FEATURE_STEP
from motiondb.database.catalogue.filter_words import take_filter_words
from motiondb.database.loading import load_steps, nearby_table
from motiondb.database.session import Session
from motiondb.database.values import Where, check_least, check_text
from motiondb.errors import QueryError
from motiondb.language.question.readings import say
from motiondb.learn.learned import Learned
from motiondb.records import MOTION_FPS, Float32Array, Match
from motiondb.search.asked_words import WrittenWord, find_written
from motiondb.search.asking import ask
from motiondb.search.by_words import WordAnswer, as_near, search_words
from motiondb.search.chances import LIKELY
from motiondb.symbols.hmm_jobs import one_blas_thread

if TYPE_CHECKING:
    from motiondb.database.values import Example
    from motiondb.search.by_example import ExampleAnswer
    from motiondb.search.nearest_parts import Shown

MOST_SHOWN, UNSURE = 1000, 30
"""Answers to words that are looked at beside a path; and those of which none has a probability."""
AROUND = 45  # Feature frames (3 s) around the interval of an answer in which path or rhythm may lie


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
    learned = session.searchable

    def written_words() -> dict[str, WrittenWord]:
        return session.kept("written_words", lambda: find_written(learned))

    frames = session.frames
    with one_blas_thread():  # for small matrices a second thread takes longer
        question = ask(learned, words, nearby_table(), written_words, exact, by_symbols)
        if by_symbols:
            from motiondb.search.by_symbols import search_decoded  # compiled code

            in_words = ask(learned, words, nearby_table(), written_words, exact)
            shown = search_words(in_words, allowed, len(allowed), written, frames)
            found = {match.capture: match for match in shown.matches}
            return search_decoded(question, allowed, limit, found)
        answer = search_words(question, allowed, limit, written, frames)
        if answer.nothing and answer.matches and not exact:
            near = question.with_near_words(nearby_table())
            if near is not None:
                instead = search_words(near, allowed, limit, written, frames)
                if not instead.nothing:
                    said = (say(each.sentence.parsed.tree) for each in (question, near))
                    return as_near(instead, *said)
        return answer


def answer_path(
    session: Session,
    path: str | Sequence[Sequence[float]],
    words: str,
    allowed: Sequence[int],
    limit: int,
    exact: bool,
) -> ExampleAnswer:
    """The intervals that travel along a path; with words, where captures show these."""
    from motiondb.search.by_path import MOST_ALONG, Ways, parts_along, points_of, read_path
    from motiondb.search.nearest_parts import answer_parts

    check_least("limit", limit, 1)
    line = read_path(points_of(path) if isinstance(path, str) else path)
    learned, pool = session.searchable, session.pool
    shown, read_as = _where_shown(session, words, allowed, exact)
    if shown is None:
        every = sorted(learned.rows)
        ways = session.kept("ways", lambda: Ways.of({c: pool.of_capture(c) for c in every}))
        return answer_parts(learned, parts_along(ways, line, allowed), MOST_ALONG, limit)
    rows, firsts = dict[int, Float32Array](), dict[int, int]()
    for capture, where in shown.items():
        start, end = (round(each / FEATURE_STEP) for each in (where.start, where.end))
        firsts[capture] = max(start - AROUND, 0)
        rows[capture] = pool.of_capture(capture)[firsts[capture] : end + AROUND]
    parts = parts_along(Ways.of(rows, firsts), line, list(rows))
    return replace(answer_parts(learned, parts, MOST_ALONG, limit, shown), read_as=read_as)


def answer_rhythm(
    session: Session,
    taps: str | Sequence[float],
    words: str,
    allowed: Sequence[int],
    limit: int,
    exact: bool,
) -> ExampleAnswer:
    """The intervals whose steps fall at taps; with words, where captures show these."""
    from motiondb.search.by_rhythm import MOST_OFF, parts_in, read_rhythm
    from motiondb.search.nearest_parts import answer_parts

    check_least("limit", limit, 1)
    rhythm, learned = read_rhythm(taps), session.searchable
    shown, read_as = _where_shown(session, words, allowed, exact)
    steps = session.kept("steps", lambda: load_steps(session.store))
    if shown is not None:
        around = AROUND / FEATURE_FPS
        spans = {c: (w.start / MOTION_FPS, w.end / MOTION_FPS) for c, w in shown.items()}
        steps = {
            c: steps[c][(steps[c] >= start - around) & (steps[c] <= end + around)]
            for c, (start, end) in spans.items()
        }
    allowed = [c for c in allowed if c in learned.rows] if shown is None else list(shown)
    answer = answer_parts(learned, parts_in(steps, rhythm, allowed), MOST_OFF, limit, shown)
    return replace(answer, read_as=read_as)


def _where_shown(
    session: Session, words: str, allowed: Sequence[int], exact: bool
) -> tuple[dict[int, Shown] | None, str]:
    """Where captures show words, by their numbers, and how these are read; None without words."""
    from motiondb.search.nearest_parts import Shown

    check_text("words", words)
    if not words.strip():
        return None, ""
    number = {info.name: capture for capture, info in session.searchable.captures.items()}
    answer = answer_words(session, words, allowed, MOST_SHOWN, exact)
    where = dict[int, Shown]()
    for match in _likely(answer.matches):
        sure = "" if match.probability is None else f" {match.probability:.2f}"
        start, end = (round(MOTION_FPS * each) for each in (match.start, match.end))
        where[number[match.capture]] = Shown(f"{say(answer.question.tree)}{sure}", start, end)
    left = (f"{each.text!r} is not used: {each.reason}" for each in answer.not_used)
    told = filter(None, (answer.not_understood, answer.understood, *answer.remarks, *left))
    return where, "; ".join(told)


def _likely(matches: Sequence[Match]) -> Sequence[Match]:
    """The likely answers to words; the first ones, where none has a probability."""
    if all(match.probability is None for match in matches):
        return [match for match in matches if not match.contradicted][:UNSURE]
    return [match for match in matches if (match.probability or 0.0) >= LIKELY]


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


def compare(
    session: Session, first: Example, second: Example, png: str | Path | None = None
) -> answers.Comparison:
    """Align two examples by dynamic time warping, and measure how far they are apart."""
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
