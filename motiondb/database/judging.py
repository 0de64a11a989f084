"""``judge``: whether a motion of any origin shows a sentence."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import replace
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motiondb import answers, store
from motiondb.body.joint_names import joint_map
from motiondb.body.retarget import keypoints_of
from motiondb.database.catalogue.exporting import load_clip
from motiondb.database.generating import action_verdict, replace_unknown, say_why_not, with_notation
from motiondb.database.loading import nearby_table
from motiondb.database.searching import check_any
from motiondb.database.session import Session
from motiondb.database.values import check_text, seeded
from motiondb.errors import MotionDBError
from motiondb.files.formats import read_capture, split_take
from motiondb.files.own_files import provenance_path
from motiondb.files.safe_files import is_file, read_bounded
from motiondb.generate.material import Takes
from motiondb.generate.second_opinion import judge_sentence
from motiondb.language.question.readings import hinted, with_hints
from motiondb.records import Clip, Match, Motion
from motiondb.search.by_example import search_motion
from motiondb.search.takings import Sentence, Taking, hints_of, unknown_words, write_otherwise

if TYPE_CHECKING:
    from motiondb.database.values import Example

SAME = 0.95
"""Resemblance from which on a capture is taken for the motion itself. A capture of the sample data
that was resampled from 30 to 24 frames a second has .98, and other takes of its action .90."""
N_NEAREST = 10  # Captures that are looked at for copies of the motion


def judge(
    session: Session, example: Example, motion: Motion, sentence: str, exact: bool
) -> answers.Judgement:
    """Judge a motion, which was loaded from ``example``, by a sentence."""
    check_text("sentence", sentence)
    with session.reading():
        check_any(session.learned)
        asked, same = Sentence(session.learned, sentence), dict[str, Taking]()
        if exact:
            learned = session.learned
            takings = unknown_words(asked, nearby_table(), is_replaced=False)
        else:
            asked, same = write_otherwise(asked)
            learned, takings, _ = replace_unknown(asked, False, False)
        names = _own_names(session, example)
        near = search_motion(
            session.searchable, session.features, motion, list(learned.captures), N_NEAREST
        ).matches
        copies = [match.capture for match in near if match.score >= SAME]
        left_out = sorted({*names, *copies} & {info.name for info in learned.captures.values()})
        numbers = {info.name: number for number, info in learned.captures.items()}
        takes = Takes(session.features, lambda capture: store.load_motion(session.store, capture))
        found = judge_sentence(
            learned, takes, motion, asked.text, [numbers[n] for n in left_out], seeded(0)
        )
        quality = _quality(session, example)

    def is_told(taking: Taking) -> bool:
        return taking.is_taken or taking.word in question.unknown

    hints = hints_of({word: taking for word, taking in takings.items() if not taking.is_taken})
    question = with_hints(replace(found.question, text=sentence), hints)
    actions = tuple(with_notation(one, takings) for one in found.actions)
    shown = found.shown if found.shown is not True or all(a.shown for a in actions) else None
    real = {info.name for info in learned.captures.values() if info.kind != "generated"} - names
    return answers.Judgement(
        sentence=sentence,
        seconds=round(motion.duration, 3),
        shown=shown,
        actions=tuple(map(action_verdict, actions)),
        in_order=found.in_order,
        reason=say_why_not(actions, found.against),
        chosen=found.chosen,
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
        nearest=_first(near, real),
        quality=quality,
    )


def _first(near: Iterable[Match], names: set[str]) -> Match | None:
    return next((match for match in near if match.capture in names), None)


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


def _quality(session: Session, example: Example) -> Any | None:  # noqa: ANN401  of its room
    """What the motion lacks, as `quality` tells it; None where this version has no such room."""
    if find_spec("motiondb.quality") is None or isinstance(example, Motion):
        return None
    clip = example if isinstance(example, Clip) else None
    if clip is None:
        is_of_file = is_file(split_take(str(example))[0])
        clip = read_capture(str(example)) if is_of_file else load_clip(session, str(example))
    roles, most = joint_map(clip.skeleton), import_module("motiondb.quality.measured").MOST_FPS
    points, step = keypoints_of(clip, roles)[0], max(1, round(clip.fps / most))
    assess = import_module("motiondb.quality.assess").assess
    found = assess(points[::step], clip.fps / step, {"l_toe", "r_toe"} <= roles.keys())
    name = "" if isinstance(example, Clip) else str(example)
    return import_module("motiondb.answers.catalogue").capture_quality(name, found)
