"""The verbs of selections: captures, and parts of them, that are kept under a name.

They are tags of their captures (:mod:`motiondb.store.catalogue.selections`), so that ``undo`` takes
changes of them back, and ``selection = 'fight day 2'`` is a filter.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from motiondb import answers, store
from motiondb.database.session import Topic
from motiondb.database.values import Where, listed
from motiondb.errors import QueryError, suggestion
from motiondb.records import CaptureInfo, Match
from motiondb.store import SELECTION, Span
from motiondb.tabled import Listed, Tupled

if TYPE_CHECKING:
    from motiondb.database.catalogue.exporting import MotionChanges

Part: TypeAlias = str | Match | tuple[str, float | None, float | None]
"""A capture's name, ``CAPTURE:FROM-TO``, a name with start and end (s), or an answer's match."""
LONGEST_NAME = 100  # Characters of the name of a selection


class Selections(Topic):
    """The selections of a database, available as ``db.selections``.

    ``db.selections()`` lists them. ``parts`` are names of captures, ``CAPTURE:FROM-TO`` in seconds,
    names with start and end, or matches: ``db.selections.add("x", db.search("kick").matches)``.
    """

    def __call__(self) -> list[answers.SelectionRow]:
        """The selections, by name, with what they hold."""
        held = dict[str, list[tuple[CaptureInfo, frozenset[Span]]]]()
        with self.session.reading():
            for info in store.load_captures(self.store):
                for name, spans in _selections_of(info).items():
                    held.setdefault(name, []).append((info, spans))
        return Listed(
            answers.SelectionRow(
                name,
                len(of),
                sum(len(spans) for _, spans in of),
                round(sum(_seconds(info, span) for info, spans in of for span in spans), 2),
            )
            for name, of in sorted(held.items())
        )

    def show(self, name: str) -> tuple[answers.SelectedPart, ...]:
        """What a selection holds, by capture and time; QueryError if there is none of that name."""
        with self.session.reading():
            infos = store.load_captures(self.store)
            name = self._check_known(name, infos)
            of = [(i, span) for i in infos for span in _selections_of(i).get(name, ())]
            of.sort(key=lambda each: (each[0].name, each[1] or (-1.0, -1.0)))
            return Tupled(
                answers.SelectedPart(
                    number,
                    info.name,
                    span[0] if span else 0.0,
                    span[1] if span else info.duration,
                    span is None,
                    info.kind,
                    info.tags.get("performer", ""),
                    info.tags.get("licence", "unknown"),
                    info.path,
                    info.sha256,
                    tuple(
                        f"{source.name} (licence {source.licence or 'unknown'})"
                        for source in store.load_provenance(self.store, info.capture_id).sources
                    )
                    if info.kind == "generated"
                    else (),
                    "",
                )
                for number, (info, span) in enumerate(of, start=1)
            )

    def add(self, name: str, parts: Iterable[Part] = (), where: Where = "") -> list[str]:
        """Put parts, and the captures of a filter, into a selection, which is made if need be.

        Returns the captures with something new.
        """
        name = _checked(name)
        return self._change(name, parts, where, lambda spans, new, _whole: spans | new)

    def take(self, name: str, parts: Iterable[Part] = (), where: Where = "") -> list[str]:
        """Take parts out of a selection; of a capture without times, all that it holds of it.

        Returns the captures that have changed. The last part that is taken takes the selection.
        """
        with self.session.reading():
            name = self._check_known(name, store.load_captures(self.store))
        return self._change(
            name, parts, where, lambda spans, old, whole: frozenset() if whole else spans - old
        )

    def remove(self, name: str) -> list[str]:
        """Forget a selection, and return the captures that it held; these stay."""
        return self.take(name, where=[part.capture for part in self.show(name)])

    def export(
        self,
        name: str,
        folder: str | Path,
        ending: str = "bvh",
        changes: MotionChanges | None = None,
    ) -> answers.PackWritten:
        """Write a selection into a new or empty folder: a file for each part, and a manifest.

        ``manifest.csv`` and ``.json`` have capture, interval, performer, licence, source file with
        its digest, and of generated motion what it was made of. The folder is there whole or not at
        all. ``ending``: a format that ``export`` writes.
        """
        from motiondb.database.catalogue import exporting, packs, parts
        from motiondb.files.safe_files import whole_folder

        target, asked = Path(folder), changes or exporting.MotionChanges()
        ending = ending.removeprefix(".")
        parts.check_new_folder(target)
        exporting.check_changes(asked, Path(f"motion.{ending}"))
        with self.session.reading(), whole_folder(target, parts.check_new_folder) as draft:
            rows = packs.write_motions(
                self.session, self.show(name), draft, ending, asked, lambda *_: None
            )
            packs.write_manifest(rows, {"selection": name, "intervals": rows}, draft)
        licences = sorted({row.licence for row in rows})
        return answers.PackWritten(name, target, len(rows), tuple(licences))

    def _change(
        self,
        name: str,
        parts: Iterable[Part],
        where: Where,
        change: Callable[[frozenset[Span], frozenset[Span], bool], frozenset[Span]],
    ) -> list[str]:
        """Change the parts of captures that a selection holds.

        `change`: Of those that it holds of a capture, those that are given, and whether the capture
        is given without times.
        """
        from motiondb.database.captures import chosen

        given = [_part(each) for each in listed("parts", parts)]
        with store.transaction(self.store):
            infos = store.load_named(self.store, [capture for capture, _, _ in given])
            asked = [(info, start, end) for info, (_, start, end) in zip(infos, given)]
            asked += [(info, None, None) for info in chosen(self.session, (), where)]
            spans, whole = dict[int, set[Span]](), set[int]()
            for info, start, end in asked:
                spans.setdefault(info.capture_id, set()).add(_span(info, start, end))
                whole |= {info.capture_id} if start is None and end is None else set()
            changed = []
            for number, info in {info.capture_id: info for info, _, _ in asked}.items():
                held = _selections_of(info)
                given_spans = frozenset(spans[number])
                held[name] = change(held.get(name, frozenset()), given_spans, number in whole)
                tags = {**info.tags, SELECTION: store.write_selections(held)}
                changed.append((info, {key: value for key, value in tags.items() if value}))
            return store.change_tags(self.store, {SELECTION: name}, changed)

    def _check_known(self, name: str, infos: Sequence[CaptureInfo]) -> str:
        """The name of a selection that there is; QueryError if there is none."""
        name, known = name.strip(), {each for info in infos for each in _selections_of(info)}
        if name not in known:
            raise QueryError(
                f"{name!r}: expected the name of a selection, found none of it in "
                f"{self.store.path}.{suggestion(name, known)} motiondb selections lists them."
            )
        return name


def _selections_of(info: CaptureInfo) -> dict[str, frozenset[Span]]:
    return store.read_selections(info.tags.get(SELECTION, ""))


def _seconds(info: CaptureInfo, span: Span) -> float:
    return info.duration if span is None else span[1] - span[0]


def _checked(name: str) -> str:
    """The name of a selection; QueryError if it cannot be one."""
    plain = name.strip()
    if (
        not plain
        or len(plain) > LONGEST_NAME
        or not plain.isprintable()
        or {*plain} & {*store.MARKS}
    ):
        raise QueryError(
            f"{name[:60]!r}: expected a name of a selection, 1 to {LONGEST_NAME} visible "
            f"characters without {' '.join(store.MARKS)}, found another text."
        )
    return plain


def _part(part: Part) -> tuple[str, float | None, float | None]:
    from motiondb.database.generated_files import read_part

    if isinstance(part, str):
        return read_part(part)
    return (part.capture, part.start, part.end) if isinstance(part, Match) else part


def _span(info: CaptureInfo, start: float | None, end: float | None) -> Span:
    """A part of a capture, seconds; None where it is all of it."""
    from motiondb.database.catalogue.parts import outside

    if start is None and end is None:
        return None
    until = round(info.duration, 3)
    low = round(start or 0.0, 3) + 0.0  # no -0.0
    high = until if end is None else round(end, 3)
    if not 0.0 <= low < min(high, until) or high > until + 0.5:
        raise QueryError(f"{info.name}: {outside(info.duration, start, end)}")
    return None if low == 0.0 and high >= until else (low, min(high, until))
