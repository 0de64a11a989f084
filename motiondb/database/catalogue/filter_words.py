"""Replacement of filter words that are in no caption and no tag by words that are.

No capture fulfils a condition ``caption ~ word``, ``tag = word`` or ``tag ~ word`` with an unknown
word. If the word may be taken as words that captions, or the values of this tag, do hold
(:mod:`motiondb.search.takings`), the condition asks for these instead. Conditions with ``!=``
and ``!~``, and those within ``not``, are not changed: an unknown word excludes nothing.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from motiondb import store
from motiondb.database.loading import nearby_table
from motiondb.language.lemmas import lemma
from motiondb.language.vocabulary import forms_of
from motiondb.records import CaptureInfo
from motiondb.search.takings import TAKEN, Taking, take_word
from motiondb.store import CAPTION, COLUMNS, Condition, Filter, OneOf, matches, parse_where


def take_filter_words(
    opened: store.Store, where: str
) -> tuple[tuple[Filter, ...], dict[str, Taking]]:
    """A filter whose unknown words are replaced by known ones."""
    filters = parse_where(where)
    if not any(_is_word(each) for each in _positive(filters)):
        return filters, {}
    captions = {
        number: [caption.words for caption in rows]
        for number, rows in store.load_captions(opened).items()
    }
    infos = store.load_captures(opened)
    takings: dict[str, Taking] = {}
    taken = tuple(_take(each, infos, captions, takings) for each in filters)
    return taken, takings


def _positive(filters: Iterable[Filter]) -> list[Condition]:
    """Conditions that are not within a negation."""
    conditions: list[Condition] = []
    for each in filters:
        if isinstance(each, Condition):
            conditions.append(each)
        elif isinstance(each, OneOf):
            conditions += _positive(f for alternative in each.alternatives for f in alternative)
    return conditions


def _is_word(condition: Condition) -> bool:
    """Whether a condition asks captions or a tag for a single word."""
    operators = ("~",) if condition.name == CAPTION else ("=", "~")
    named = condition.name not in COLUMNS and condition.operator in operators
    return named and condition.value.isalpha()


def _take(
    each: Filter,
    infos: Sequence[CaptureInfo],
    captions: Mapping[int, Sequence[str]],
    takings: dict[str, Taking],
) -> Filter:
    """A filter with its words taken; notes the takings."""
    if isinstance(each, OneOf):
        return OneOf(
            tuple(
                tuple(_take(f, infos, captions, takings) for f in alternative)
                for alternative in each.alternatives
            )
        )
    if not isinstance(each, Condition) or not _is_word(each):
        return each
    if any(matches(info, (each,), captions.get(info.capture_id, ())) for info in infos):
        return each
    values = _values(each.name, infos, captions)
    taking = take_word(each.value, values, nearby_table())
    if taking.words:
        takings[each.value] = taking
    likely = [word for word, chance in taking.words if chance >= TAKEN]
    if not likely:
        return each
    return OneOf(
        tuple(
            (Condition(each.name, each.operator, value),)
            for word in likely
            for value in sorted(values[word])
        )
    )


def _values(
    name: str, infos: Sequence[CaptureInfo], captions: Mapping[int, Sequence[str]]
) -> dict[str, set[str]]:
    """Lemmas in captions or in the values of a tag, each with the text to compare with."""
    values: dict[str, set[str]] = {}
    if name == CAPTION:
        for texts in captions.values():
            for form in {form for text in texts for form in forms_of(text)}:
                values.setdefault(lemma(form), set()).add(form)
        return values
    for info in infos:
        value = info.tags.get(name, "")
        if value.isalpha():
            values.setdefault(lemma(value), set()).add(value)
    return values
