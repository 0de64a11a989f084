"""The methods that return facts: symbols and activities of captures, origins."""

from __future__ import annotations

from typing import TYPE_CHECKING

from motiondb import store
from motiondb.database.ask.making_verbs import MakingVerbs

if TYPE_CHECKING:
    from motiondb.answers.catalogue import ShownActivity, ShownSegment, SymbolSegment


class FactVerbs(MakingVerbs):
    """Verbs on facts; those that ask are inherited."""

    def segments(self, name: str) -> list[ShownSegment]:
        """Symbols of a capture with their times (seconds); empty if it is not learned.

        Raises
        ------
        QueryError
            When there is no such capture.
        """
        from motiondb.database.ask import showing

        with self.session.reading():
            known = self.session.kept("numbers by name", self._numbers_by_name)
            number = known.get(name)
            if number is None:
                number = store.load_capture(self.store, name).capture_id
            return showing.known_segments(self.searchable, number) if known else []

    def _numbers_by_name(self) -> dict[str, int]:
        """The captures of a database that has learned; empty for any other."""
        if not self.is_learned():
            return {}
        return {info.name: number for number, info in self.searchable.captures.items()}

    def symbol_segments(self, symbol: int) -> list[SymbolSegment]:
        """Segments of a symbol, those that it fits best first; times in seconds.

        Raises
        ------
        QueryError
            When there is no such symbol.
        """
        from motiondb.database.ask import showing

        return showing.symbol_segments(self.learned, symbol)

    def activities(self, name: str) -> list[ShownActivity]:
        """The successive activities of a capture; empty if there is only one.

        Raises
        ------
        QueryError
            When there is no such capture.
        """
        from motiondb.database.ask import showing

        with self.session.reading():
            info = store.load_capture(self.store, name)
            return showing.capture_activities(self, info.capture_id)

    def provenance(self, name: str) -> store.Provenance:
        """Origin of every frame of a generated capture; without sources for a captured one.

        Raises
        ------
        QueryError
            When there is no such capture.
        """
        with self.session.reading():
            info = store.load_capture(self.store, name)
            return store.load_provenance(self.store, info.capture_id)
