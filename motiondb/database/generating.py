"""``generate``: a motion from a sentence, with the origin of every frame."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from motiondb import answers, store
from motiondb.database import generated_files
from motiondb.database.catalogue.exporting import MotionChanges, change_sequence
from motiondb.database.loading import nearby_table
from motiondb.database.searching import check_any
from motiondb.database.session import Session
from motiondb.errors import QueryError
from motiondb.generate import motion_making
from motiondb.generate.excerpt_motion import Choices, PlaceWish
from motiondb.generate.material import Takes
from motiondb.generate.sentence_plan import plan_sentence, speed_of
from motiondb.generate.shown_actions import JudgedAction
from motiondb.generate.smoothness import Smoothness
from motiondb.language.question.readings import KnownQuestion, hinted, with_hints
from motiondb.language.question.tree import AnyOf, Node, NotUsed, Without, parts_of
from motiondb.language.translation import decoding
from motiondb.language.vocabulary import as_said, say_not_understood
from motiondb.learn.learned import Learned
from motiondb.records import MOTION_FPS, Motion
from motiondb.search.asking import with_found
from motiondb.search.chances import WordSource, word_sources
from motiondb.search.takings import (
    Sentence,
    Taking,
    hints_of,
    nearest_suggested,
    not_understood,
    sentence_of,
    unknown_words,
    with_likeliest,
    write_otherwise,
)
from motiondb.tabled import Tabled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LEAST_PICKED = 15  # Fewest frames (0.5 s) of an excerpt that is picked: seams need as much
MOST_VARIANTS = 100  # Motions of one sentence that are made at once
MOST_TRIES = 2
"""Motions that are made for each one asked for: of several actions or alternatives, some may be
made from the same places again."""


@dataclass(frozen=True)
class ActionPlace:
    """Where an action of a sentence is taken from.

    Attributes
    ----------
    place : int or None
        Number of one of the places that show the action about as clearly (``Generated.places``),
        from 0; None for any.
    capture : str or None
        Name of the capture of an excerpt that was picked by hand; then `place` does not count, and
        no caption needs to say the action.
    start, end : float
        The excerpt, in seconds of the capture.
    """

    place: int | None = None
    capture: str | None = None
    start: float = 0.0
    end: float = 0.0


@dataclass(frozen=True, eq=False, repr=False)
class Generated(Tabled):
    """A motion that was made from a sentence, and how."""

    motion: Motion
    """On the canonical body, at 30 frames a second."""
    symbols: tuple[int, ...]
    """Symbols of the excerpts, or those that were decoded."""
    positions: tuple[int, ...]
    """Per symbol the number of its action."""
    actions: tuple[tuple[str, ...], ...]
    """Known words of every action."""
    decodings: tuple[decoding.Decoding, ...]
    """Per action; none for stitched motion."""
    recognised: tuple[int, ...]
    """Symbols recognised in the motion."""
    provenance: store.Provenance
    """Origin and licence of every frame."""
    question: KnownQuestion
    """The parsed sentence."""
    smoothness: Smoothness
    """How smooth the motion is, beside the captures that its frames come from."""
    shown: tuple[JudgedAction, ...] = ()
    """For each requested action, whether the motion shows it, according to a judge that is
    independent of the generation."""
    decided: tuple[str, ...] = ()
    """What the sentence leaves open, and how it was decided."""
    spans: tuple[tuple[int, int], ...] = ()
    """First frame and last frame + 1 of every action that was made."""
    not_used: tuple[NotUsed, ...] = ()
    """What of the sentence the motion takes no account of."""
    words: str = ""
    """The sentence."""
    seed: int = 0
    """The seed."""
    method: str = "stitched"
    """One of ``METHODS``."""
    taken: Mapping[str, Taking] = field(default_factory=dict)
    """Word that is in no caption -> the known words that replace it; the most probable was used."""
    suggested: Mapping[str, Taking] = field(default_factory=dict)
    """Word that is in no caption and was not replaced -> suggested known words."""
    sources: tuple[WordSource, ...] = ()
    """The captions from which the words were learned, if the database learned with a start."""
    took_all_places: bool = False
    """Whether no further variant follows because the places that show the sentence about as clearly
    were all tried."""
    missing: tuple[str, ...] = ()
    """Words that name an action of the sentence and are not understood."""
    changed: tuple[str, ...] = ()
    """How the motion was changed after it was made; everything else is about the changed motion."""
    places: tuple[tuple[int, int], ...] = ()
    """For each action of stitched motion the number of its place, from 0, and the number of places
    that show it about as clearly; -1 for an excerpt that is none of them, or that was picked."""

    def _rows(self) -> tuple[str, list[dict[str, object]]]:
        rows: list[dict[str, object]] = [
            {
                "action": one.words,
                "start": one.start / MOTION_FPS,
                "end": one.end / MOTION_FPS,
                "shown": {True: "shown", False: "not shown", None: "not sure"}[one.shown],
                "reason": one.reason,
            }
            for one in self.shown
        ]
        return f"{self.words!r}, {self.motion.duration:.2f} s, seed {self.seed}", rows

    @property
    def unknown(self) -> Mapping[str, tuple[str, ...]]:
        """Words of the sentence that are not known -> nearest known words."""
        return self.question.unknown

    @property
    def shows_all(self) -> bool:
        """Whether every requested action is shown, according to the judge."""
        return all(one.shown is True for one in self.shown)

    @property
    def why_not(self) -> str:
        """What is not understood, not shown, or not sure to be shown; "" if everything is shown."""
        made = [one for one in self.shown if one.end or not self.missing]
        return say_why_not(made, say_not_understood(self.missing))

    def facts(self) -> answers.GeneratedAnswer:
        """The request, its decoding and the sources, for JSON; times in seconds."""
        return answers.extended(
            answers.GeneratedAnswer,
            self,
            seconds=round(self.motion.n_frames / MOTION_FPS, 3),
            shown=self.shows_all,
            shown_actions=tuple(map(action_verdict, self.shown)),
            decodings=tuple(answers.extended(answers.DecodedAction, d) for d in self.decodings),
            sources=generated_files.sources_of(self.provenance),
            words_from=self.sources,
            question=answers.understood_question(self.question, self.not_used),
        )

    def write(
        self, path: str | Path, changes: MotionChanges | None = None
    ) -> answers.WrittenMotion:
        """Write the motion, and beside it ``FILE.provenance.json`` with the origin of its frames.

        Parameters
        ----------
        path : str or Path
            The ending says the format: .bvh, .glb, .gltf, .fbx, .usd, .usda or .usdc.
        changes : MotionChanges, optional
            How the file differs: its unit, frame rate and rig. What makes another motion (loop, in
            place, mirror) is not judged here; ask :meth:`MotionDB.generate_variants` for it.
        """
        facts = self.facts()
        written = generated_files.write_with_provenance(
            self, facts, Path(path), changes, self.changed
        )
        return answers.extended(answers.WrittenMotion, facts, **written)

    def draw(self, path: str | Path | None = None) -> Path | Figure:
        """Draw a strip of stick figures over the sources of the frames, as PNG."""
        return generated_files.draw_generated(self, self.words, path)


def say_why_not(shown: Sequence[JudgedAction], first: str = "") -> str:
    """What is not shown or not sure, behind another sentence."""
    said = [first]
    for verdict, value in (("not shown", False), ("not sure", None)):
        of = [one for one in shown if one.shown is value]
        listed = ", ".join(f"{' '.join(one.words)} ({one.reason})" for one in of)
        said.append(f"{verdict}: {listed}" if of else "")
    return "; ".join(filter(None, said))


def takes_of(session: Session) -> Takes:
    """The motions of all captures, as generation looks at them."""

    def held(capture: int, posture: str) -> list[tuple[int, int]]:
        seen = session.frames.of(session.learned, capture)
        return [] if seen.is_away else seen.events(posture)

    return Takes(session.pool, lambda number: store.load_motion(session.store, number), held)


def generate(
    session: Session,
    words: str,
    seeds: range,
    method: str = "stitched",
    exact: bool = False,
    anyway: bool = False,
    changes: MotionChanges | None = None,
    places: Sequence[ActionPlace] = (),
) -> list[Generated]:
    """Generate up to as many motions from a sentence as there are seeds.

    They are judged after they were mirrored, looped or put in place. Stitched motions of the same
    actions from the same places as an earlier one are left out, so that there may be fewer.
    """
    seed, number = seeds.start, len(seeds)
    if not 1 <= number <= MOST_VARIANTS:
        raise QueryError(f"variants: expected 1 to {MOST_VARIANTS}, found {number}.")
    if number > 1 and method == "trajectory":
        raise QueryError(
            f"variants: expected 1 for trajectory, which is one motion, found {number}. "
            "Use the method stitched."
        )
    made: list[motion_making.MadeMotion] = []
    motions: list[Generated] = []
    with session.reading():
        takes = takes_of(session)
        check_any(session.learned)
        sentence, same = sentence_of(session.learned, words), dict[str, Taking]()
        sentence = with_found(sentence, nearby_table(), ())
        if exact:
            learned = session.learned
            takings = unknown_words(sentence, nearby_table(), is_replaced=False)
            instead: dict[str, str] = {}
        else:
            sentence, same = write_otherwise(sentence)
            learned, takings, instead = replace_unknown(
                sentence, anyway, any(place.capture for place in places)
            )
        wishes = tuple(_wish(session, place) for place in places)
        missing = not_understood(sentence, [w for w, t in takings.items() if t.is_taken])
        for variant in range(seed, seed + MOST_TRIES * number):
            rng = np.random.default_rng(variant)
            motion = motion_making.make_motion(
                learned,
                takes,
                sentence.text,
                rng,
                method,
                anyway,
                instead,
                Choices(variant, wishes),
            )
            if not any(_is_from_same(motion, earlier) for earlier in made):
                made.append(motion)
                origin, first, said = motion.made, 0, tuple[str, ...]()
                if changes is not None and changes.of_motion.are_any:
                    done = change_sequence(motion.made, changes)
                    origin, first, said = done.made, done.first, done.said
                judged = motion_making.judge(learned, takes, motion, origin, first)
                provenance = store.to_provenance(
                    session.store, origin.captures, origin.frames, edits=origin.edits
                )
                more = {"words": words, "seed": variant, "method": method, "missing": missing}
                more |= {"provenance": provenance, "changed": said}
                heard = _taken_words(sentence, variant, motion, takings)
                motions.append(_to_generated(learned, motion, judged, takings, heard, same, more))
            if len(motions) == number:
                break
            if _took_all_places(motion, variant + 1 - seed):
                motions[-1] = replace(motions[-1], took_all_places=True)
                break
    return motions


def _wish(session: Session, place: ActionPlace) -> PlaceWish:
    """Return a wish by the number of the capture and in frames."""
    if place.capture is None:
        return PlaceWish(place.place)
    info = store.load_capture(session.store, place.capture)
    times = (place.start, place.end)
    first, last = (round(t * MOTION_FPS) if math.isfinite(t) else -1 for t in times)
    if not 0 <= first < last <= info.motion_frames or last - first < LEAST_PICKED:
        raise QueryError(
            f"{info.name}: expected an excerpt of at least {LEAST_PICKED / MOTION_FPS:g} s within"
            f" 0 to {info.motion_frames / MOTION_FPS:.2f} s, found {place.start:g} to"
            f" {place.end:g} s. Choose one inside the capture."
        )
    return PlaceWish(None, (info.capture_id, first, last))


def _took_all_places(motion: motion_making.MadeMotion, n_tries: int) -> bool:
    """Whether further seeds prefer the places of earlier ones, after some successive seeds.

    Never where alternatives are drawn, since the next seed may draw another one.
    """
    if not motion.places or _has_alternatives(motion.question.tree):
        return False
    return n_tries >= math.lcm(*(n_places for _, n_places in motion.places))


def _has_alternatives(node: Node) -> bool:
    """Whether alternatives are drawn; those of what must not be shown are not."""
    parts = (node.part,) if isinstance(node, Without) else parts_of(node)
    return isinstance(node, AnyOf) or any(_has_alternatives(part) for part in parts)


def _is_from_same(one: motion_making.MadeMotion, other: motion_making.MadeMotion) -> bool:
    """Whether stitched motions show the same actions from the same places."""
    if not one.places or (one.actions, one.decided) != (other.actions, other.decided):
        return False
    return all(
        a == b and (a >= 0 or _shares_most(one, other, n))
        for n, ((a, _), (b, _)) in enumerate(zip(one.places, other.places))
    )


def _shares_most(
    one: motion_making.MadeMotion, other: motion_making.MadeMotion, action: int
) -> bool:
    """Whether two motions share more than half of the frames of an action, of the shorter one."""
    used = []
    for made in (one.made, other.made):
        end = sum(made.lengths[: action + 1])
        inside = slice(end - made.lengths[action], end)
        frames = np.round(made.frames[inside]).astype(int)
        used.append(set(zip(made.captures[inside].tolist(), frames.tolist())))
    return 2 * len(used[0] & used[1]) > min(map(len, used))


def replace_unknown(
    sentence: Sentence, anyway: bool, is_picked: bool
) -> tuple[Learned, dict[str, Taking], dict[str, str]]:
    """Unknown words as known ones; words of speed stay, since the tempo can be changed.

    `is_picked`: Whether excerpts were picked, which may show what no word is known for.

    Also, for each word that is made as the nearest known one although it may not be taken so, that
    known word.
    """
    learned = sentence.learned
    try:
        takings = unknown_words(sentence, nearby_table())
    except QueryError:
        instead = nearest_suggested(sentence, nearby_table()) if anyway else {}
        if not instead and not is_picked:
            raise
        return replace(learned, synonyms={**learned.synonyms, **instead}), {}, instead
    speeds = {word for word in takings if speed_of(word)}
    kept = {word: taking for word, taking in takings.items() if word not in speeds}
    return with_likeliest(learned, kept), kept, {}


def _to_generated(
    learned: Learned,
    motion: motion_making.MadeMotion,
    judged: motion_making.JudgedMotion,
    takings: Mapping[str, Taking],
    heard: Sequence[Mapping[str, Taking]],
    same: Mapping[str, Taking],
    more: Mapping[str, Any],
) -> Generated:
    suggested = {word: taking for word, taking in takings.items() if not taking.is_taken}
    hints = hints_of(suggested)
    of_each = [*heard, *[takings] * (len(judged.shown) - len(heard))]
    return answers.extended(
        Generated,
        motion,
        motion=judged.made.motion,
        symbols=tuple(int(s) for s in motion.symbols),
        recognised=tuple(int(s) for s in judged.recognised),
        question=with_hints(replace(motion.question, text=more["words"]), hints),
        shown=tuple(map(with_notation, judged.shown, of_each)),
        taken={**same, **{word: taking for word, taking in takings.items() if taking.is_taken}},
        suggested=suggested,
        spans=judged.spans,
        not_used=hinted(motion.not_used, hints),
        sources=word_sources(learned, (word for action in motion.actions for word in action)),
        smoothness=judged.smoothness,
        **more,
    )


def _taken_words(
    sentence: Sentence, seed: int, motion: motion_making.MadeMotion, takings: Mapping[str, Taking]
) -> list[Mapping[str, Taking]]:
    """The taken words of each action that was made: of "moonwalk, then walk", only the first's.

    They are found by planning the sentence as it was written, with the same draws. Where that plan
    is another one, because of words that were left out, every taken word counts for every action.
    """
    known = {word: t.words[0][0] for word, t in takings.items() if t.is_taken}
    every = [takings] * len(motion.asked)
    if not known:
        return every
    plan = plan_sentence(sentence.parsed.tree, np.random.default_rng(seed))[0]
    written = [action.words for action in plan]
    if len(written) != len(every) or not all(
        {*one.words} <= {known.get(word, word) for word in words}
        for one, words in zip(motion.asked, written)
    ):
        return every
    return [{word: takings[word] for word in words if word in takings} for words in written]


def with_notation(one: JudgedAction, takings: Mapping[str, Taking]) -> JudgedAction:
    """A judged action whose taken words say so; at most it is not sure to show what was asked."""
    taken = {t.words[0][0]: t for t in takings.values() if t.is_taken}
    told = [taken[word] for word in one.words if word in taken]
    one = replace(one, words=tuple(map(as_said, one.words)))
    if not told:
        return one
    words = tuple(
        replace(taken[word], words=taken[word].words[:1]).notation if word in taken else word
        for word in one.words
    )
    if one.shown is not True:
        return replace(one, words=words)
    why = "; ".join(taking.sentence() for taking in told)
    return replace(one, words=words, shown=None, probability=None, reason=why)


def action_verdict(one: JudgedAction) -> answers.ActionVerdict:
    """One action for JSON; times in seconds."""
    return answers.extended(
        answers.ActionVerdict,
        one,
        start=round(one.start / MOTION_FPS, 3),
        end=round(one.end / MOTION_FPS, 3),
        described=tuple(answers.WordProbability(word, p) for word, p in one.described),
    )
