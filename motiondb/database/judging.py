"""``judge``: whether a motion of any origin shows a sentence."""

from __future__ import annotations

import json
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from motiondb import answers, store
from motiondb.database import generating
from motiondb.database.catalogue.assessing import points_of
from motiondb.database.catalogue.exporting import added_joint_map, load_clip
from motiondb.database.loading import nearby_table
from motiondb.database.searching import check_any
from motiondb.database.session import Session
from motiondb.database.values import check_text, seeded
from motiondb.errors import MotionDBError, QueryError
from motiondb.files.formats import read_capture, split_take
from motiondb.files.own_files import provenance_path
from motiondb.files.safe_files import is_file, read_bounded
from motiondb.generate.second_opinion import judge_sentence
from motiondb.language.question.readings import hinted, with_hints
from motiondb.quality.assess import assess
from motiondb.records import Clip, Motion
from motiondb.search.by_example import search_motion
from motiondb.search.takings import Taking, hints_of, sentence_of, unknown_words, write_otherwise

if TYPE_CHECKING:
    from motiondb.database.values import Example

SAME = 0.95
"""Resemblance from which on a capture is taken for the motion itself. A capture of the sample data
that was resampled from 30 to 24 frames a second has .98, and other takes of its action .90."""
SHORTEST = 0.5  # Seconds: in less, every motion looks like many actions
N_NEAREST = 10  # Captures that are looked at for copies of the motion


def judge(
    session: Session, example: Example, motion: Motion, sentence: str, exact: bool
) -> answers.Judgement:
    """Judge a motion, which was loaded from ``example``, by a sentence."""
    check_text("sentence", sentence)
    if motion.duration < SHORTEST:
        name = example if isinstance(example, str | Path) else "motion"
        raise QueryError(
            f"{name}: expected at least {SHORTEST} s of motion to judge, found "
            f"{motion.duration:.2f} s. Give a longer one."
        )
    with session.reading():
        check_any(session.learned)
        asked, same = sentence_of(session.learned, sentence), dict[str, Taking]()
        if exact:
            learned = session.learned
            takings = unknown_words(asked, nearby_table(), is_replaced=False)
        else:
            asked, same = write_otherwise(asked)
            learned, takings, _ = generating.replace_unknown(asked, False, False)
        names = _own_names(session, example)
        near = search_motion(
            session.searchable, session.frames, motion, list(learned.captures), N_NEAREST
        ).matches
        copies = [match.capture for match in near if match.score >= SAME]
        left_out = sorted({*names, *copies} & {info.name for info in learned.captures.values()})
        numbers = {info.name: number for number, info in learned.captures.items()}
        takes = generating.takes_of(session)
        found = judge_sentence(
            learned, takes, motion, asked.text, [numbers[n] for n in left_out], seeded(0)
        )
        quality = _quality(session, example)

    def is_told(taking: Taking) -> bool:
        return taking.is_taken or taking.word in question.unknown

    hints = hints_of({word: taking for word, taking in takings.items() if not taking.is_taken})
    question = with_hints(replace(found.question, text=sentence), hints)
    actions = tuple(generating.with_notation(one, takings) for one in found.actions)
    shown = found.shown if found.shown is not True or all(a.shown for a in actions) else None
    real = {info.name for info in learned.captures.values() if info.kind != "generated"} - names
    return answers.extended(
        answers.Judgement,
        found,
        sentence=sentence,
        seconds=round(motion.duration, 3),
        shown=shown,
        actions=tuple(map(generating.action_verdict, actions)),
        reason=generating.say_why_not(actions, found.against),
        question=answers.understood_question(question, hinted(found.not_used, hints)),
        sentences=(
            *motion.notes,
            *(
                taking.sentence()
                for taking in (*same.values(), *takings.values())
                if is_told(taking)
            ),
        ),
        left_out=tuple(left_out),
        nearest=next((match for match in near if match.capture in real), None),
        quality=quality,
    )


def _own_names(session: Session, example: Example) -> set[str]:
    """Names of the captures that a motion is, is made of, or is a copy of, as far as is known."""
    if isinstance(example, Clip | Motion):
        return set()
    if is_file(example):
        return _sources_beside(provenance_path(Path(example)))
    info = store.load_capture(session.store, str(example))
    copies = store.load_relations(session.store, info.name)
    names = {info.name, *(r.capture for r in copies), *(r.other for r in copies)}
    if info.kind == "generated":
        made = store.load_provenance(session.store, info.capture_id)
        names |= {source.name for source in made.sources}
    return names


def _sources_beside(path: Path) -> set[str]:
    """The captures of which a file of motiondb says that its motion was made."""
    with suppress(OSError, ValueError, MotionDBError, RecursionError):
        told = json.loads(read_bounded(path))
        sources = told.get("sources", ()) if isinstance(told, Mapping) else ()
        return {
            str(one["capture"]) for one in sources if isinstance(one, Mapping) and "capture" in one
        }
    return set()


def _quality(session: Session, example: Example) -> answers.CaptureQuality | None:
    """What the motion lacks, as `quality` tells it; None on the canonical body, which has no size.

    The joint map of a capture that was added with one is used, too.
    """
    if isinstance(example, Motion):
        return None
    name, joints = "" if isinstance(example, Clip) else str(example), dict[str, str]()
    if isinstance(example, Clip):
        clip = example
    elif is_file(split_take(name)[0]):
        clip = read_capture(name)
    else:
        clip = load_clip(session, name)
        joints = added_joint_map(session, store.load_capture(session.store, name))
    clip, points, has_toes = points_of(clip, joints)
    return answers.capture_quality(name, assess(points, clip.fps, has_toes))
