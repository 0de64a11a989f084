"""What a library holds and lacks: tables of going, of changes, of symbols and of words.

Captures that repeat another one are counted once. A cell with less than a second, or with one
performer, stands on the shot list; one with nothing has the three moments beside it that are most
like it, so that a wrong "none" is seen.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from motiondb import answers, pictures, store
from motiondb.curate import going
from motiondb.database import searching
from motiondb.database.curating import only_once
from motiondb.errors import NotLearnedError, QueryError
from motiondb.files.safe_files import read_user_text
from motiondb.language.vocabulary import as_said
from motiondb.learn.learned import performers_of
from motiondb.records import MOTION_FPS, CaptureInfo, FloatArray

if TYPE_CHECKING:
    from motiondb.database.session import Session

Progress = Callable[[str, float, float], None]
_LEAST_SECONDS, _LEAST_PERFORMERS = 1.0, 2
_N_NEAREST = 3
_LIKELY = 0.5  # Probability from which an answer in words counts as there
_MOST_ANSWERS = 1000


@dataclass
class _Held:
    """What a cell holds."""

    amount: float = 0.0
    performers: set[str] | None = None

    def add(self, amount: float, performer: str) -> None:
        self.amount += amount
        self.performers = (self.performers or set()) | {performer}


Table: TypeAlias = dict[tuple[str, str], _Held]


def coverage(
    session: Session,
    infos: Sequence[CaptureInfo],
    words: Sequence[str] | Path,
    png: str | Path | None,
    progress: Progress | None,
) -> answers.CoverageAnswer:
    """What captures hold and lack, as :meth:`MotionDB.coverage` says."""
    if isinstance(words, Path):
        lines = read_user_text(words, "words").splitlines()
        words = list(dict.fromkeys(filter(None, map(str.strip, lines))))
    if words and not store.is_learned(session.store):
        raise NotLearnedError(
            "words: expected a database that has learned, found only captures. Run motiondb learn "
            "first, or leave --words out."
        )
    with session.reading():
        repeats = only_once(session, infos)
        counted = [i for i in infos if i.name not in repeats and i.kind == "captured"]
        if not counted:
            raise QueryError("coverage: expected captures, found none. Add some, or take others.")
        made = _Coverage(session, counted, progress or (lambda _what, _done, _total: None))
        cells = [*made.going(), *made.changes(), *made.words(words), *made.symbols()]
    if len({made.performers[number] for number in made.infos}) == 1:  # no cell can have two
        cells = [replace(c, shot="") if c.amount >= _LEAST_SECONDS else c for c in cells]
    seconds = sum(info.duration for info in counted)
    notes = [f"{len(repeats)} captures repeat others and are counted once"] if repeats else []
    notes += [f"{name}: its motion cannot be read" for name in made.unread]
    shots = tuple(cell.shot for cell in cells if cell.shot)
    answer = answers.CoverageAnswer(
        len(counted), round(seconds, 2), round(made.down, 2), tuple(cells), shots, tuple(notes)
    )
    if png is None:
        return answer
    grids: list[pictures.Grid] = [
        [(c.row, c.column, c.amount, c.unit, c.performers) for c in cells if c.table == table]
        for table in ("going", "changes")
    ]
    pictures.save_png(pictures.coverage_figure(*grids), png)
    return replace(answer, png=Path(png))


class _Coverage:
    """What is counted over all captures."""

    def __init__(self, session: Session, infos: Sequence[CaptureInfo], tell: Progress) -> None:
        self.session, self.infos = session, {info.capture_id: info for info in infos}
        everyone = {info.capture_id: info for info in store.load_captures(session.store)}
        self.performers = performers_of(everyone)
        self.down, self.unread = 0.0, list[str]()
        self._going: Table = defaultdict(_Held)
        self._changes: Table = defaultdict(_Held)
        self._shown: list[tuple[int, int, str]] = []  # Capture, frame, change
        self._seconds: list[FloatArray] = []
        self._where: list[tuple[int, int]] = []  # Capture and second of every moment
        motions = store.readable_motions(session.store, list(self.infos))
        read = set[int]()
        for done, (number, motion) in enumerate(motions):
            tell("looking", done, len(infos))
            read.add(number)
            self._count(number, going.going_of(motion))
        self.unread = [info.name for n, info in self.infos.items() if n not in read]

    def _count(self, number: int, found: going.Going) -> None:
        who = self.performers[number]
        kinds, turns = found.kinds, found.turns
        self.down += float((kinds < 0).sum()) / MOTION_FPS
        pairs = np.bincount((kinds * len(going.TURNS) + turns)[kinds >= 0])
        for cell in np.flatnonzero(pairs).tolist():
            kind, turn = divmod(cell, len(going.TURNS))
            key = going.KINDS[kind][0], going.TURNS[turn]
            self._going[key].add(float(pairs[cell]) / MOTION_FPS, who)
        for change in going.changes_of(found):
            key = going.CHANGES[change.kind], going.FEET[change.foot]
            self._changes[key].add(1.0, who)
            self._shown.append((number, change.frame, ", ".join(key)))
        seconds = going.moments(found)
        self._seconds.append(seconds)
        self._where += [(number, n) for n in range(len(seconds))]

    def going(self) -> list[answers.Cell]:
        """Kinds of going by turns."""
        out = []
        for kind, (row, *_) in enumerate(going.KINDS):
            for turn, column in enumerate(going.TURNS):
                said, held = going.phrase(kind, turn), self._going[row, column]
                near = () if held.amount else self._near(going.wanted(kind, turn))
                out.append(_cell("going", row, column, held, "s", said, near))
        return out

    def _near(self, wanted: FloatArray) -> tuple[answers.Moment, ...]:
        """The moments that are most like one, of different captures."""
        every = np.concatenate(self._seconds) if self._seconds else np.zeros((0, 4))
        apart = np.nan_to_num(np.linalg.norm(every - wanted, axis=1), nan=np.inf)
        out: dict[int, answers.Moment] = {}
        for n in np.argsort(apart, kind="stable").tolist():
            number, second = self._where[n]
            if np.isinf(apart[n]) or len(out) == _N_NEAREST:
                break
            if number not in out:
                speed, _, _, turn = every[n]
                side = "left" if turn > 0.0 else "right"
                turns = f"turns {side} by {abs(turn) * 90:.0f} degrees a second"
                said = f"{speed * 1.4:.1f} m/s, {turns}"
                out[number] = self._moment(number, second, second + 1.0, said)
        return tuple(out.values())

    def _moment(self, number: int, start: float, end: float, what: str) -> answers.Moment:
        info = self.infos[number]
        low, high = max(0.0, start), min(end, info.duration)
        return answers.Moment(info.name, round(low, 2), round(high, 2), what)

    def changes(self) -> list[answers.Cell]:
        """Starts, stops and changes of gait by the foot ahead."""
        out = []
        for row in going.CHANGES:
            for column in going.FEET:
                held = self._changes[row, column]
                near = () if held.amount else self._like_change(row, column)
                said = f"{row} with the {column} ahead"
                out.append(_cell("changes", row, column, held, "times", said, near))
        return out

    def _like_change(self, row: str, column: str) -> tuple[answers.Moment, ...]:
        """Changes that are most like one: with the other foot, then with words in common."""
        words = set(row.split())

        def unlike(shown: tuple[int, int, str]) -> tuple[bool, int, bool]:
            kind, _, foot = shown[2].partition(", ")
            return kind != row, -len(words & set(kind.split())), foot != column

        near = sorted(self._shown, key=unlike)[:_N_NEAREST]
        return tuple(
            self._moment(number, frame / MOTION_FPS - 1.0, frame / MOTION_FPS + 1.0, said)
            for number, frame, said in near
        )

    def symbols(self) -> list[answers.Cell]:
        """Symbols by the symbol before them; none where nothing is learned.

        A symbol that is there is a row for each context; one that no capture shows is one row.
        """
        if not store.is_learned(self.session.store):
            return []
        learned = self.session.without_rows
        table, held = learned.segments, defaultdict[tuple[int, str], _Held](_Held)
        for number, rows in learned.rows.items():
            if number not in self.infos:
                continue
            before = "begin"
            for row in range(rows.start, rows.stop):
                symbol = int(table.symbols[row])
                seconds = float(table.ends[row] - table.starts[row]) / MOTION_FPS
                held[symbol, f"after {before}"].add(seconds, self.performers[number])
                before = str(symbol)
        out, known = [], learned.association.words
        translation = learned.association.translation
        for symbol in range(learned.symbols.n_symbols):
            contexts = {c: each for (s, c), each in held.items() if s == symbol}
            who = set(chain.from_iterable(each.performers or () for each in contexts.values()))
            total = _Held(sum(each.amount for each in contexts.values()), who)
            near = self._like_symbol(symbol) if len(who) < _LEAST_PERFORMERS else ()
            name = f"symbol {symbol}"
            likely = np.argsort(-translation[symbol + 1], kind="stable")[:2]
            said = ", ".join(as_said(known[word]) for word in likely)
            whole = f"{name} ({said})" if said else name
            if contexts and near:  # its own segments are the nearest
                at, near = near[0], ()
                whole += f", as in {at.capture} {at.start:.1f} to {at.end:.1f} s"
            out.append(_cell("symbols", name, "all", total, "s", whole, near))
            out += [
                replace(_cell("symbols", name, c, each, "s", name, ()), shot="")
                for c, each in sorted(contexts.items())
            ]
        return out

    def _like_symbol(self, symbol: int) -> tuple[answers.Moment, ...]:
        """Segments of the symbols nearest to one."""
        learned = self.session.without_rows
        table, out = learned.segments, list[answers.Moment]()
        for other in np.argsort(learned.distances[symbol], kind="stable").tolist():
            for row in np.flatnonzero(table.symbols == other).tolist():
                if int(table.capture_ids[row]) in self.infos and len(out) < _N_NEAREST:
                    span = table.starts[row] / MOTION_FPS, table.ends[row] / MOTION_FPS
                    where = int(table.capture_ids[row])
                    out.append(self._moment(where, *span, f"symbol {other}"))
        return tuple(out)

    def words(self, questions: Sequence[str]) -> list[answers.Cell]:
        """Questions in words: the intervals that are found with a probability of one half."""
        names = {info.name: number for number, info in self.infos.items()}
        return [self._word(question, names) for question in questions]

    def _word(self, question: str, names: dict[str, int]) -> answers.Cell:
        where = self.session.filter(list(names))
        try:
            with self.session.reading():
                allowed = searching.allowed_captures(self.session, where, exact=False)
                found = searching.answer_words(
                    self.session, question, allowed, _MOST_ANSWERS, exact=False
                ).matches
        except QueryError as error:
            cell = _cell("words", question, "captions and motion", _Held(), "s", question, ())
            return replace(cell, shot=f"{cell.shot[:-1]}; {str(error).partition('.')[0]})")
        held = _Held()
        for match in found:
            if (match.probability or 0.0) >= _LIKELY:
                amount = match.end - match.start
                held.add(amount, self.performers[names[match.capture]])
        near = [] if held.amount else found[:_N_NEAREST]
        moments = tuple(
            answers.Moment(m.capture, round(m.start, 2), round(m.end, 2), _chance(m.probability))
            for m in near
        )
        return _cell("words", question, "captions and motion", held, "s", question, moments)


def _chance(probability: float | None) -> str:
    return "not known how likely" if probability is None else f"probability {probability:.2f}"


def _cell(
    table: str,
    row: str,
    column: str,
    held: _Held,
    unit: str,
    said: str,
    near: tuple[answers.Moment, ...],
) -> answers.Cell:
    """A cell, with what to record where it has too little."""
    performers = len(held.performers or ())
    short = held.amount < _LEAST_SECONDS or performers < _LEAST_PERFORMERS
    times = "once" if int(held.amount) == 1 else f"{int(held.amount)} times"
    amount = f"{held.amount:.1f} s" if unit == "s" else times
    who = "one performer" if performers == 1 else f"{performers} performers"
    shot = f"To record: {said} ({f'{amount}, {who}' if held.amount else 'none'})" if short else ""
    return answers.Cell(table, row, column, round(held.amount, 2), unit, performers, shot, near)
