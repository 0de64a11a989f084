"""Answers as tables: what a notebook or a Python prompt shows of them."""

from __future__ import annotations

import html
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any, TypeVar, cast

T = TypeVar("T")
_SHOWN_ROWS, _SHOWN_LETTERS = 9, 40  # Of an answer's table, and of a cell, as notebooks show it


class Tabled:
    """An answer whose ``repr`` is a table of at most 12 lines; notebooks show it as HTML."""

    def _rows(self) -> tuple[str, Sequence[Mapping[str, object]]]:
        """A title, and rows by column; of a record its fields."""
        said = [(f.name, getattr(self, f.name)) for f in fields(cast(Any, self))]
        rows = [{"field": name, "value": value} for name, value in said if value not in ((), "")]
        return type(self).__name__, rows

    def _table(self) -> tuple[str, list[list[str]], str]:
        """The title, the lines of the table with its head, and how much is left out."""
        title, rows = self._rows()
        more = len(rows) - _SHOWN_ROWS
        lines = [list(map(_cell, row.values())) for row in rows[:_SHOWN_ROWS]]
        return (
            _cell(title, 160),
            [list(rows[0]), *lines] if rows else [],
            (f"... {more} more" if more > 0 else ""),
        )

    def __repr__(self) -> str:
        title, lines, more = self._table()
        widths = [max(map(len, column)) for column in zip(*lines)]
        padded = ("  ".join(map(str.ljust, line, widths)).rstrip() for line in lines)
        return "\n".join(filter(None, (title, *padded, more)))

    def _repr_html_(self) -> str:
        """Return the same table for a notebook."""
        title, lines, more = self._table()
        cells = ("".join(f"<td>{html.escape(cell)}</td>" for cell in line) for line in lines)
        rows = "".join(f"<tr>{line}</tr>" for line in cells)
        return f"<p>{html.escape(title)}</p><table>{rows}</table><p>{more}</p>"


class _Records(Tabled):
    """Records, of which a table shows some fields: ``columns``, or all."""

    columns: Sequence[str] = ()

    def _rows(self) -> tuple[str, Sequence[Mapping[str, object]]]:
        records: list[Any] = list(cast(Any, self))
        names = self.columns or [f.name for record in records[:1] for f in fields(record)]
        rows = [{name: getattr(record, name) for name in names} for record in records]
        return f"{len(rows)} row{'s' * (len(rows) != 1)}", rows


class Listed(_Records, list[T]):
    """A list of records that is shown as a table."""

    def __init__(self, records: Iterable[T], *columns: str) -> None:
        super().__init__(records)
        self.columns = columns


class Tupled(_Records, tuple[T, ...]):
    """A tuple of records that is shown as a table."""


def _cell(value: Any, longest: int = _SHOWN_LETTERS) -> str:  # noqa: ANN401
    """A value in a line, cut; what a terminal would obey is escaped."""
    if value is None:
        return "-"
    if isinstance(value, float):
        return f"{value:.2f}"
    if isinstance(value, Mapping):
        value = [f"{key}={item}" for key, item in value.items()]
    elif is_dataclass(value) and hasattr(type(value).__repr__, "__wrapped__"):  # no repr of its own
        value = [getattr(value, f.name) for f in fields(value)]
    if isinstance(value, list | tuple):
        is_nested = any(is_dataclass(item) or isinstance(item, list | tuple) for item in value)
        value = (", " if is_nested else " ").join(map(_cell, value[:_SHOWN_ROWS]))
    text = " ".join(str(value)[: 4 * longest].split())
    text = text if text.isprintable() else text.encode("unicode_escape").decode()
    return text if len(text) <= longest else f"{text[: longest - 1]}…"
