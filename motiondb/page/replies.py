"""Replies of the page: answers of the verbs with what a browser needs beside them.

The routes give them, and files without a server (:mod:`motiondb.page.standalone`) hold them.
"""

from __future__ import annotations

import base64
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from motiondb import answers
from motiondb.database import MotionDB
from motiondb.database.catalogue.browsing import BrowsedCapture
from motiondb.database.catalogue.parts import cut_motion
from motiondb.database.generated_files import Stretch, sources_of, stretches
from motiondb.database.generating import Generated
from motiondb.database.grammars import grammar_facts
from motiondb.database.grammars.grammar_sequences import GrammarSequence
from motiondb.database.scenes.scene_folder import report_facts
from motiondb.database.scenes.scene_records import action_captions, record_text
from motiondb.errors import MotionDBError
from motiondb.language.vocabulary import as_said
from motiondb.page.diagrams import DiagramShape, diagram_shape
from motiondb.page.motion import Track, pack, points_of, shapes_of
from motiondb.page.state import Block
from motiondb.records import MOTION_FPS, Caption, CaptureInfo, Finding, Match, Relation
from motiondb.search.by_example import ExampleAnswer
from motiondb.search.by_words import WordAnswer
from motiondb.store import StoredScene, load_motion

if TYPE_CHECKING:
    from motiondb.database.scenes.scenes import Scene


KEPT_POSTERS = 500  # Posters of earlier answers in memory, 1.5 kB each
MOST_POSTERS = 8  # Matches that get a poster: as many as are seen before one scrolls


@dataclass(frozen=True, kw_only=True)
class WordedSegment(answers.ShownSegment):
    """An interval with its motion symbol, and the word that is most often said of the symbol."""

    word: str | None = None
    word_probability: float | None = None


@dataclass(frozen=True)
class Timeline:
    """The symbols and captions of a take."""

    segments: tuple[WordedSegment, ...]
    words: tuple[Caption, ...]


@dataclass(frozen=True, kw_only=True)
class ShownMatch(answers.ExplainedMatch):
    """A match with its take."""

    ref: str
    duration: float
    performer: str | None
    licence: str | None
    kind: str
    timeline: Timeline
    poster: str | None  # Its pose at the found moment: a motion of one frame, in base64


@dataclass(frozen=True, kw_only=True)
class SearchReply(answers.SearchAnswer):
    """An answer to words."""

    matches: tuple[ShownMatch, ...]
    not_yet_learned: int
    took: float | None  # Seconds


@dataclass(frozen=True, kw_only=True)
class LikeReply(answers.LikeAnswer):
    """An answer to an example."""

    ref: str
    start: float | None
    end: float | None
    matches: tuple[ShownMatch, ...]
    not_yet_learned: int
    took: float | None


def worded_segments(db: MotionDB, capture: str) -> tuple[WordedSegment, ...]:
    """Return the segments of a capture, each with the word of its symbol."""
    segments = db.captures.segments(capture)
    if not segments:
        return ()
    load = partial(db.symbols.rows, 1)
    words = {
        row.symbol: row.words[0] for row in db.session.kept("words of symbols", load) if row.words
    }
    return tuple(
        answers.extended(
            WordedSegment,
            each,
            word=words[each.symbol].word if each.symbol in words else None,
            word_probability=words[each.symbol].probability if each.symbol in words else None,
        )
        for each in segments
    )


def search_reply(db: MotionDB, answer: WordAnswer, took: float | None = None) -> SearchReply:
    """Return the answer to words; every match has its reasons."""
    found = answers.search_answer(answer)
    return answers.extended(SearchReply, found, took=took, **_with_takes(db, found))


def like_reply(
    db: MotionDB,
    answer: ExampleAnswer,
    ref: str,
    start: float | None,
    end: float | None,
    took: float | None = None,
) -> LikeReply:
    """Return the answer to an example."""
    found = answers.like_answer(answer)
    more = {"ref": ref, "start": start, "end": end, "took": took}
    return answers.extended(LikeReply, found, **more, **_with_takes(db, found))


def _with_takes(db: MotionDB, answer: answers.LikeAnswer) -> dict[str, Any]:
    """Return the matches of an answer with their takes, and how many captures it leaves out."""
    matches = tuple(_with_take(db, match) for match in answer.matches)
    return {"matches": matches, "not_yet_learned": len(db.captures.unlearned())}


def _with_take(db: MotionDB, match: Match) -> ShownMatch:
    row = db.captures.browsed(match.capture)
    assert row is not None  # both come from one revision
    return answers.extended(
        ShownMatch,
        match,
        explain=getattr(match, "explain", None),
        ref=f"capture:{match.capture}",
        duration=round(row.info.duration, 3),
        performer=row.info.tags.get("performer"),
        licence=row.info.tags.get("licence"),
        kind=row.info.kind,
        timeline=Timeline(worded_segments(db, match.capture), row.captions),
        poster=_poster(db, match, row.info) if match.rank <= MOST_POSTERS else None,
    )


def _poster(db: MotionDB, match: Match, info: CaptureInfo) -> str | None:
    """Return the pose that shows most of a match, kept for a revision; None without a body."""
    made = db.session.kept("posters", dict[tuple[str, float, float], str])
    key = (match.capture, match.start, match.end)
    if key not in made:
        try:
            whole = load_motion(db.store, info.capture_id)
        except MotionDBError:  # markers, or damaged: the player says it
            return None
        points = points_of(cut_motion(whole, match.start, match.end))
        pose = int(np.argmax(shapes_of(points)[1]))
        track = Track(info.name, f"capture:{info.name}", points[pose : pose + 1])
        made[key] = base64.b64encode(pack([track])).decode()
        for oldest in list(made)[:-KEPT_POSTERS]:
            made.pop(oldest, None)
    return made[key]


@dataclass(frozen=True, kw_only=True)
class CaptureRow:
    """A row of the catalogue: what the table shows."""

    ref: str
    name: str
    kind: str  # "captured" or "generated"
    duration: float
    tags: dict[str, str]
    notes: tuple[str, ...]
    words: tuple[Caption, ...]
    learned: bool
    copies: int


@dataclass(frozen=True, eq=False, kw_only=True)
class CaptureDetails(answers.ListedCapture):
    """Everything about one capture; the last three fields are about generated ones."""

    ref: str
    learned: bool
    copies: int
    relations: tuple[Relation, ...]
    events: tuple[answers.ShownEvent, ...]
    segments: tuple[WordedSegment, ...]
    activities: tuple[answers.ShownActivity, ...]
    lacks: tuple[Finding, ...]
    ghosts: tuple[answers.Ghost, ...]
    recognised: tuple[answers.WordsOverTime, ...]
    sources: tuple[answers.Source, ...] = ()
    stretches: tuple[Stretch, ...] = ()
    grammar: str | None = None
    string: tuple[str, ...] | None = None


def capture_row(row: BrowsedCapture) -> CaptureRow:
    """Return a row of the catalogue."""
    more = {"words": row.captions, "learned": row.learned, "copies": row.copies}
    return answers.extended(CaptureRow, row.info, ref=f"capture:{row.info.name}", **more)


def described_words(db: MotionDB, name: str) -> tuple[answers.WordsOverTime, ...]:
    """Return the likely words of a capture over time; kept until the database changes."""
    if not (db.is_learned() and db.learned.has_words):
        return ()
    return db.session.kept(("described", name), lambda: answers.words_over_time(db.describe(name)))


def capture_details(db: MotionDB, row: BrowsedCapture, described: bool = True) -> CaptureDetails:
    """Return everything about one capture; if asked for, also what must be found in its motion.

    That are its activities and its likely words, which take longest.
    """
    name = row.info.name
    made: dict[str, Any] = {}
    if row.info.kind == "generated":
        provenance, shown = db.captures.provenance(name), db.captures.show(name)
        made = {"sources": sources_of(provenance), "stretches": stretches(provenance)}
        if shown.string is not None:
            made |= {"grammar": shown.grammar, "string": tuple(shown.string.split())}
    return answers.extended(
        CaptureDetails,
        row.info,
        words=row.captions,
        ref=f"capture:{name}",
        learned=row.learned,
        copies=row.copies,
        relations=tuple(db.captures.relations(name)),
        events=tuple(map(answers.shown_event, db.captures.events(name))),
        segments=worded_segments(db, name),
        activities=tuple(db.captures.activities(name)) if described else (),
        lacks=db.captures.findings(name),
        ghosts=db.session.kept(("ghosts", name), lambda: db.captures.ghosts(name)),
        recognised=described_words(db, name) if described else (),
        **made,
    )


@dataclass(frozen=True)
class ShownBlock(Block):
    """A block as it was made, in the order of the shown actions; none for other methods."""

    places: int = 1  # Number of places that show it about as clearly


@dataclass(frozen=True, kw_only=True)
class MadeReply(answers.GeneratedAnswer):
    """A generated motion; `saved` is the capture that holds it."""

    id: str
    ref: str
    recognised_words: tuple[answers.WordsOverTime, ...]
    stretches: tuple[Stretch, ...]
    blocks: tuple[ShownBlock, ...]
    saved: str | None


@dataclass(frozen=True, kw_only=True)
class GenerateReply(answers.WordsOfQuestion):
    """Motions of one sentence."""

    variants: tuple[MadeReply, ...]


_BETWEEN = re.compile(r"\s*(?:[,;.]\s*(?:and\s+)?then\b|[,;.]|\b(?:and\s+)?then\b)\s*")


def _blocks_of(made: Generated, asked: Sequence[Block]) -> tuple[ShownBlock, ...]:
    """Return the actions that were made, each with the part of the sentence that asks for it."""
    if not asked:
        phrases = [part for part in _BETWEEN.split(made.words) if part]
        if len(phrases) != len(made.actions):  # "twice", "while": the words that were understood
            phrases = [" ".join(words) for words in made.actions]
        asked = [Block(phrase) for phrase in phrases]
    return tuple(
        answers.extended(ShownBlock, block, place=place if place >= 0 else None, places=number)
        for block, (place, number) in zip(asked, made.places)
    )


def made_reply(
    db: MotionDB, made: Generated, made_id: str, saved: str = "", blocks: Sequence[Block] = ()
) -> MadeReply:
    """Return a generated motion; `blocks` are those that it was asked for with."""
    return answers.extended(
        MadeReply,
        made.facts(),
        id=made_id,
        ref=f"made:{made_id}",
        recognised_words=answers.words_over_time(db.describe(made.motion)),
        stretches=stretches(made.provenance),
        blocks=_blocks_of(made, blocks),
        saved=saved or None,
    )


def generate_reply(made: Generated, variants: Sequence[MadeReply]) -> GenerateReply:
    """Return motions of one sentence; the words are those of one of them."""
    return GenerateReply(
        question=answers.understood_question(made.question, made.not_used),
        taken=answers.known_words(made.taken),
        suggested=answers.known_words(made.suggested),
        unknown={as_said(word): near for word, near in made.unknown.items()},
        missing=made.missing,
        sentences=(
            *(taking.sentence() for taking in made.taken.values()),
            *(source.sentence() for source in made.sources),
        ),
        variants=tuple(variants),
    )


@dataclass(frozen=True)
class Positions:
    """Positions of a string, half-open."""

    start: int
    end: int


@dataclass(frozen=True, kw_only=True)
class WordedTerminal(grammar_facts.StripTerminal):
    """A terminal of a sequence, with its words and its position in the string."""

    words: tuple[str, ...]
    at: int


@dataclass(frozen=True)
class RootPath:
    """The path of the root joint on the ground: [x, z] in metres."""

    fps: float
    points: list[tuple[float, float]]


@dataclass(frozen=True, kw_only=True)
class SequenceReply(answers.SequenceAnswer):
    """A sequence; `parent` is the one of which it is an edit, `saved` the capture that holds it."""

    id: str
    ref: str
    parent: str | None = None
    edited: Positions | None = None
    saved: str | None = None
    strip: tuple[WordedTerminal, ...]
    path: RootPath
    nodes: tuple[grammar_facts.TreeNode, ...]
    stretches: tuple[Stretch, ...]


def sequence_reply(
    db: MotionDB,
    sequence: GrammarSequence,
    seed: int,
    sequence_id: str,
    **more: Any,  # noqa: ANN401
) -> SequenceReply:
    """Return a sequence; `more` holds its parent, the edited positions, and where it is saved."""
    meanings = db.grammars.meanings(sequence.grammar)
    names = db.grammars.load(sequence.grammar).terminals.names
    words = {name: tuple(w for w, _ in one.words) for name, one in zip(names, meanings)}
    path = grammar_facts.root_path(sequence).round(3).tolist()
    return answers.extended(
        SequenceReply,
        db.grammars.facts(sequence, seed),
        id=sequence_id,
        ref=f"sequence:{sequence_id}",
        strip=tuple(
            answers.extended(WordedTerminal, each, words=words.get(each.terminal, ()), at=at)
            for at, each in enumerate(db.grammars.strip(sequence))
        ),
        path=RootPath(MOTION_FPS / grammar_facts.PATH_STEP, [(x, z) for x, z in path]),
        nodes=grammar_facts.tree_nodes(sequence.tree),
        stretches=stretches(sequence.provenance),
        **more,
    )


@dataclass(frozen=True)
class SceneReply:
    """A scene: its diagram, its report, and the actions of the players with their times."""

    ref: str
    name: str
    text: str
    board: DiagramShape
    report: answers.SceneAnswer
    actions: dict[str, tuple[Caption, ...]]
    curve: list[tuple[float, float]] = field(default_factory=list)  # Share done, error
    took: dict[str, float] = field(default_factory=dict)  # Seconds of each part of the work


def made_scene_reply(ref: str, scene: Scene, curve: Sequence[tuple[float, float]]) -> SceneReply:
    """Return a scene that was made; `curve` is the share of the sampling and the scene's error."""
    placed = zip(scene.record.players, scene.made.polished.players, strict=True)
    actions = {
        who.name: action_captions(where, tuple(clip.terminal for clip in who.clips))
        for who, where in placed
    }
    took = {what: round(seconds, 3) for what, seconds in scene.made.seconds.items()}
    return replace(_scene_reply(ref, scene.record, actions), curve=list(curve), took=took)


def kept_scene_reply(db: MotionDB, record: StoredScene) -> SceneReply:
    """Return a kept scene; the times of actions are the captions of its captures."""
    actions: dict[str, Sequence[Caption]] = {}
    for player in record.players:
        row = db.captures.browsed(f"{record.name}/{player.name}")
        actions[player.name] = row.captions if row else ()
    return _scene_reply(f"kept:{record.name}", record, actions)


def _scene_reply(
    ref: str, record: StoredScene, actions: Mapping[str, Sequence[Caption]]
) -> SceneReply:
    return SceneReply(
        ref,
        record.name,
        record.diagram,
        diagram_shape(record_text(record).diagram),
        report_facts(record),
        {name: tuple(captions) for name, captions in actions.items()},
    )
