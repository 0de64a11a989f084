"""Which part of a library to train on: chosen, told why, and written with a manifest.

Seconds are left out in this order, each with its reason: generated motion, copies and mirror images
of captures that stay, what cannot be measured, a false rate, faults and things that were not
captured (:mod:`motiondb.quality`), parts too short for an interval. The rest is covered by the
choice (:mod:`motiondb.curate.covering`), each split on its own.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from motiondb import answers, store
from motiondb.body.features import FEATURE_FPS, FEATURE_STEP, recognition_features
from motiondb.curate import covering, pieces
from motiondb.database.catalogue import assessing, exporting, packs
from motiondb.database.catalogue.parts import check_new_folder
from motiondb.database.values import seeded
from motiondb.errors import NotLearnedError, QueryError
from motiondb.files.safe_files import whole_folder
from motiondb.language.vocabulary import words_of
from motiondb.learn.learned import performers_of
from motiondb.records import Caption, CaptureInfo, FloatArray, IntArray, Quality

if TYPE_CHECKING:
    from motiondb.database.session import Session

Progress = Callable[[str, float, float], None]
BALANCES = ("words", "symbols")
_SLOW, _FAST = 0.8, 1.25  # Speeds between which the rate of a performer is not told to be false


@dataclass(frozen=True)
class CurateSettings:
    """What is chosen of a library, and how it is written."""

    share: float | None = None
    """Share of the seconds of the filter, such as 0.03; one of `share` and `hours`."""
    hours: float | None = None
    """Hours to choose."""
    quality: float = 0.8
    """Smallest number of a second that may be chosen (:attr:`Quality.seconds`)."""
    with_needs: bool = False
    """Whether motion may be chosen that needs something that was not captured."""
    shortest: float = 2.0
    """Seconds of an interval, at least."""
    longest: float = 10.0
    """Seconds of an interval, at most; at least twice `shortest`."""
    balance: str = ""
    """"words" or "symbols": each gets the same weight in what is covered; "": each second."""
    split: str = ""
    """"performer": a choice to train on, and one of other performers to test with; "": one."""
    test_share: float = 0.2
    """Share of the seconds that are set aside for the test, about."""
    seed: int = 0
    """Decides who is set aside."""
    ending: str = "npz"
    """Format of the files, as the ending of what ``export`` writes."""
    changes: exporting.MotionChanges = field(default_factory=exporting.MotionChanges)
    """How the motions are changed before they are written."""

    def check(self) -> None:
        """Refuse settings that mean nothing (QueryError)."""
        asked = [each for each in (self.share, self.hours) if each is not None]
        if len(asked) != 1 or not asked[0] > 0.0 or not (self.share or 0.5) <= 1.0:
            raise QueryError(
                f"share, hours: expected one of them, a share above 0 and at most 1 or hours above "
                f"0, found {self.share} and {self.hours}. Give --share 3% or --hours 2."
            )
        if not 1.0 <= self.shortest <= self.longest / 2.0 <= 300.0:
            raise QueryError(
                "shortest, longest: expected 1 s or more, and at least twice that up to 600 s, "
                f"found {self.shortest:g} and {self.longest:g}."
            )
        for what, value in (("quality", self.quality), ("test share", self.test_share)):
            if not 0.0 <= value <= 1.0:
                raise QueryError(f"{what}: expected 0 to 1, found {value:g}.")
        choices = {"balance": (self.balance, BALANCES), "split": (self.split, ("performer",))}
        for what, (said, known) in choices.items():
            if said and said not in known:
                expected = " or ".join(known)
                raise QueryError(f"{what}: expected {expected}, found {said!r}.")


def curate(
    session: Session,
    infos: Sequence[CaptureInfo],
    asked: CurateSettings,
    folder: Path | None,
    progress: Progress | None,
) -> answers.CurateAnswer:
    """Choose, and write into a new folder if one is given."""
    asked.check()
    tell = progress or (lambda _what, _done, _total: None)
    if folder is not None:
        check_new_folder(folder)
        exporting.check_changes(asked.changes, Path(f"motion.{asked.ending}"))
    gathered = gather(session, infos, asked, tell)
    tell("choosing", 0, 1)
    answer = gathered.answer()
    tell("choosing", 1, 1)
    return answer if folder is None else _write(session, answer, asked, folder, tell)


def gather(
    session: Session, infos: Sequence[CaptureInfo], asked: CurateSettings, tell: Progress
) -> Gathered:
    """Load all that a choice needs; to choose then needs no database."""
    reasons, lacks = _left_out(session, infos, asked, tell)
    with session.reading():
        return Gathered(session, infos, asked, reasons, lacks)


def only_once(session: Session, infos: Iterable[CaptureInfo]) -> dict[str, str]:
    """Captures that repeat another one of the same list, with a reason."""
    names = {info.name for info in infos}
    said = {"same": "copy", "mirror": "mirror image", "cut": "part"}
    return {
        r.capture: f"copy: {said[r.kind]} of {r.other}"
        for r in sorted(store.load_relations(session.store), key=lambda r: r.kind != "mirror")
        if r.capture in names and r.other in names
    }


def _left_out(
    session: Session, infos: Sequence[CaptureInfo], asked: CurateSettings, tell: Progress
) -> tuple[dict[int, list[str]], dict[str, Quality]]:
    """Why each frame of features of a capture is left out ("": it is not); what captures lack."""
    whole = only_once(session, infos)
    whole |= {info.name: "generated" for info in infos if info.kind == "generated"}
    rest = [info for info in infos if info.name not in whole]
    known, _, problems = assessing.known_quality(session, rest, progress=tell)
    failed = {problem.partition(": ")[0]: problem for problem in problems}
    found = {info.name: known[info.capture_id] for info in rest if info.capture_id in known}
    whose = {info.name: assessing.performer_of(info) for info in rest}
    false = {
        each.performer: f"rate: {each.sentence}"
        for each in assessing.rates(found, whose)
        if each.speed is not None and not _SLOW <= each.speed <= _FAST
    }
    out = {}
    for info in infos:
        frames = -(-info.motion_frames // FEATURE_STEP)
        why = whole.get(info.name) or false.get(whose[info.name], "")
        if why or info.name not in found:
            why = why or f"not measured: {failed.get(info.name, '')}"
            out[info.capture_id] = [why] * frames
        else:
            lacks = found[info.name]
            out[info.capture_id] = pieces.left_out(lacks, frames, asked.quality, asked.with_needs)
    return out, found


class Gathered:
    """What a choice is made of, and told by; loaded at once."""

    def __init__(
        self,
        session: Session,
        infos: Sequence[CaptureInfo],
        asked: CurateSettings,
        reasons: dict[int, list[str]],
        lacks: dict[str, Quality],
    ) -> None:
        self.asked, self.reasons, self.lacks = asked, dict[int, list[str]](), lacks
        everyone = {info.capture_id: info for info in store.load_captures(session.store)}
        self.performers = performers_of(everyone)
        self.captions = store.load_captions(session.store)
        self.learned = session.without_rows if store.is_learned(session.store) else None
        if self.learned is None and asked.balance == "symbols":
            raise NotLearnedError(
                "balance: expected a database that has learned symbols, found none. Run motiondb "
                "learn first."
            )
        self.intervals: list[pieces.Interval] = []
        self._poses = [pieces.NO_POSES]
        for number, motion in store.readable_motions(session.store, reasons):
            self.reasons[number] = reasons[number]
            self._cut(number, recognition_features(motion))
        self.infos = {info.capture_id: info for info in infos if info.capture_id in self.reasons}
        self.unread = [info.name for info in infos if info.capture_id not in self.reasons]
        self.windows = pieces.windows_of(self.intervals)

    def _cut(self, number: int, features: pieces.Float32Array) -> None:
        why, borders = self.reasons[number], pieces.rests(features)
        if self.learned is not None and number in self.learned.rows:
            starts = self.learned.segments.starts[self.learned.rows[number]]
            borders = sorted({*borders, *(starts // FEATURE_STEP).tolist()})
        kept = np.array([not reason for reason in why], dtype=bool)
        asked = self.asked
        found, short = pieces.cut(number, borders, kept, asked.shortest, asked.longest)
        self.intervals += found
        self._poses.append(pieces.poses(features, pieces.windows_of(found).first))
        for frame in np.flatnonzero(short).tolist():
            why[frame] = f"short: less than {asked.shortest:g} s between what is left out"

    @cached_property
    def vectors(self) -> tuple[pieces.Float32Array, pieces.Float32Array]:
        """Vectors of all windows, and of their mirror images."""
        return pieces.vectors(np.concatenate(self._poses))

    def words(self, each: pieces.Interval) -> tuple[str, ...]:
        """Words of the captions of an interval, or of its whole capture."""
        start, end = each.start / FEATURE_FPS, each.end / FEATURE_FPS

        def holds(said: Caption) -> bool:
            return (said.start or 0.0) < end and (said.end is None or said.end > start)

        texts = [said.words for said in self.captions.get(each.capture, ()) if holds(said)]
        return tuple(dict.fromkeys(word for text in texts for word in words_of(text)))

    def symbols(self, each: pieces.Interval) -> tuple[int, ...]:
        """Symbols of an interval, in order."""
        if self.learned is None or each.capture not in self.learned.rows:
            return ()
        table, rows = self.learned.segments, self.learned.rows[each.capture]
        inside = (table.starts[rows] < each.end * FEATURE_STEP) & (
            table.ends[rows] > each.start * FEATURE_STEP
        )
        return tuple(dict.fromkeys(int(s) for s in table.symbols[rows][inside]))

    def _weights(self, which: IntArray) -> FloatArray:
        """Weights of windows in what is covered."""
        seconds = self.windows.seconds[which]
        if not self.asked.balance:
            return seconds
        named = self.words if self.asked.balance == "words" else self.symbols
        owner, first = self.windows.owner[which], self.windows.first[which]
        classes = []
        for n, a in zip(owner.tolist(), first.tolist()):
            second = pieces.Interval(self.intervals[n].capture, a, a + pieces.WINDOW)
            classes.append(tuple(str(name) for name in named(second)))
        return seconds * covering.balanced(classes)

    def answer(self) -> answers.CurateAnswer:
        """Choose in every split, and tell."""
        notes = [f"{name}: its motion cannot be read, it is left out" for name in self.unread]
        if not self.intervals:
            raise QueryError(
                "curate: expected captures with something to choose, found none. "
                f"{self._totals()} Take other captures, a lower --quality, or a smaller --shortest."
            )
        chosen: list[answers.ChosenInterval] = []
        splits, dropped = [], []
        total = sum(info.duration for info in self.infos.values())
        share = self.asked.share or min(1.0, 3600.0 * (self.asked.hours or 0.0) / total)
        for name, numbers in self._splits().items():
            found, told, rest = self._choose(name, numbers, share, len(chosen))
            chosen += found
            splits.append(told)
            dropped += rest
        dropped += [
            self._dropped(number, a, b, reason)
            for number, why in self.reasons.items()
            for a, b, reason in pieces.runs_of(why)
            if reason
        ]
        dropped.sort(key=lambda each: (each.capture, each.start))
        sums = defaultdict[str, float](float)
        for each in dropped:
            kind = each.reason.partition(":")[0]
            sums[kind] = sums[kind] + each.end - each.start
        reasons = {kind: round(s, 2) for kind, s in sorted(sums.items(), key=lambda p: -p[1])}
        return answers.CurateAnswer(
            seconds=round(total, 2),
            splits=tuple(splits),
            reasons=reasons,
            intervals=tuple(chosen),
            dropped=tuple(dropped),
            notes=tuple(notes),
        )

    def _totals(self) -> str:
        every = [reason.partition(":")[0] for why in self.reasons.values() for reason in why]
        counts = {kind: every.count(kind) / FEATURE_FPS for kind in sorted(set(every) - {""})}
        said = ", ".join(f"{seconds:.1f} s {kind}" for kind, seconds in counts.items())
        return f"Left out: {said or 'nothing'}."

    def _splits(self) -> dict[str, list[int]]:
        """Numbers of the intervals of every split."""
        if not self.asked.split:
            return {"all": list(range(len(self.intervals)))}
        whose = [self.performers[each.capture] for each in self.intervals]
        seconds = defaultdict[str, float](float)
        for name, each in zip(whose, self.intervals):
            seconds[name] += each.seconds
        if len(seconds) < 2:
            raise QueryError(
                f"split: expected captures of two performers or more, found {len(seconds)}. Tag "
                "them (motiondb tags set performer=NAME ...), or leave --split out."
            )
        aside = covering.split(seconds, self.asked.test_share, seeded(self.asked.seed))
        out: dict[str, list[int]] = {"train": [], "test": []}
        for n, name in enumerate(whose):
            out["test" if name in aside else "train"].append(n)
        return out

    def _choose(
        self, name: str, numbers: list[int], share: float, before: int
    ) -> tuple[list[answers.ChosenInterval], answers.SplitChoice, list[answers.DroppedInterval]]:
        """Choose among the intervals of a split; tell of those that are chosen, and of others."""
        which = np.flatnonzero(np.isin(self.windows.owner, numbers))
        owner = np.searchsorted(numbers, self.windows.owner[which])
        costs = np.array([self.intervals[n].seconds for n in numbers])
        vectors, images = (each[which] for each in self.vectors)
        seconds = self.windows.seconds[which]
        mine = {self.performers[self.intervals[n].capture] for n in numbers}
        library = sum(i.duration for c, i in self.infos.items() if self.performers[c] in mine)
        whose = [self.performers[self.intervals[n].capture] for n in numbers]
        groups = covering.who_covers([whose[n] for n in owner.tolist()])
        weights, budget = self._weights(which), share * library
        found = covering.choose(vectors, owner, costs, weights, budget, groups, images)
        apart = covering.between(vectors, owner, found.intervals)
        stands = found.stands * seconds.mean()
        place = {int(n): k for k, n in enumerate(found.intervals)}
        told = [
            self._tell(
                self.intervals[numbers[n]], before + k, name, stands[owner == n], apart, k, before
            )
            for k, n in enumerate(found.intervals.tolist())
        ]
        told = _with_reasons(told)
        sums = np.bincount(owner, found.distances * seconds, len(numbers)) / costs
        rest = []
        for n, number in enumerate(numbers):
            if n not in place:
                of = np.bincount(found.nearest[owner == n]).argmax()
                each = self.intervals[number]
                reason = f"covered: by interval {before + place[int(of)] + 1}, {sums[n]:.3f} away"
                rest.append(self._dropped(each.capture, each.start, each.end, reason))
        facts = answers.SplitChoice(
            name,
            tuple(sorted(mine)),
            round(float(costs.sum()), 2),
            round(float(costs[found.intervals].sum()), 2),
            len(told),
            round(found.mean, 4),
            round(found.bound, 4),
        )
        return told, facts, rest

    def _tell(
        self,
        each: pieces.Interval,
        number: int,
        split: str,
        weights: FloatArray,
        apart: FloatArray,
        row: int,
        before: int,
    ) -> answers.ChosenInterval:
        """What is told of a chosen interval, without its reason; `apart`: of all chosen ones."""
        info = self.infos[each.capture]
        like = int(apart[row].argmin()) if len(apart) > 1 else None
        low, high = int(each.start / FEATURE_FPS), int(np.ceil(each.end / FEATURE_FPS))
        return answers.ChosenInterval(
            number + 1,
            info.name,
            round(each.start / FEATURE_FPS, 3),
            round(min(each.end / FEATURE_FPS, info.duration), 3),
            split,
            round(float(weights.sum()), 2),
            tuple(weights.round(2).tolist()),
            "",
            None if like is None else before + like + 1,
            None if like is None else round(float(apart[row, like]), 4),
            self.words(each),
            self.symbols(each),
            round(float(self.lacks[info.name].seconds[low:high].min()), 3),
            info.tags.get("performer", ""),
            info.tags.get("licence", "unknown"),
            info.path,
            info.sha256,
            "",
        )

    def _dropped(self, capture: int, start: int, end: int, reason: str) -> answers.DroppedInterval:
        info = self.infos[capture]
        last = min(end / FEATURE_FPS, info.duration)
        return answers.DroppedInterval(
            info.name, round(start / FEATURE_FPS, 3), round(last, 3), reason
        )


def _with_reasons(told: list[answers.ChosenInterval]) -> list[answers.ChosenInterval]:
    """Say what each interval has that no other one of its split has."""
    words = Counter(word for each in told for word in each.words)
    symbols = Counter(symbol for each in told for symbol in each.symbols)
    out, of = [], {each.interval: each for each in told}
    for each in told:
        said = [f"represents {each.weight:.0f} s of the library"]
        alone = [word for word in each.words if words[word] == 1]
        said += [f"the only one with {', '.join(alone)}"] if alone else []
        own = [str(symbol) for symbol in each.symbols if symbols[symbol] == 1]
        said += [f"the only one with symbol {', '.join(own)}"] if own else []
        if each.nearest is not None and each.distance is not None:
            other = of[each.nearest]
            meant = f" ({', '.join(other.words[:4])})" if other.words else ""
            said.append(f"{each.distance:.2f} from interval {each.nearest}{meant}, the nearest")
        out.append(replace(each, reason="; ".join(said)))
    return out


def _write(
    session: Session,
    answer: answers.CurateAnswer,
    asked: CurateSettings,
    folder: Path,
    tell: Progress,
) -> answers.CurateAnswer:
    """Write intervals and manifest into a draft that becomes the folder when it is complete."""
    with whole_folder(folder, check_new_folder) as draft:
        intervals = packs.write_motions(
            session, answer.intervals, draft, asked.ending, asked.changes, tell
        )
        answer = replace(answer, intervals=intervals, folder=folder)
        told = {"settings": asdict(asked), **answers.to_json(answer)}
        told.pop("folder", None)
        packs.write_manifest(intervals, told, draft)
    return answer
