"""A user's table of synonyms: lines ``word = canonical word``.

A tab may replace ``=``; blank lines and text after ``#`` are ignored. A canonical word may itself
have an entry: chains are followed to their end.
"""

from __future__ import annotations

import re

from motiondb.errors import SheetError
from motiondb.language.lemmas import lemma


def parse_synonyms(text: str, source: str = "synonyms") -> dict[str, str]:
    r"""Read a table of synonyms.

    >>> parse_synonyms("jog = run\nstroll\twalk  # slowly")
    {'jog': 'run', 'stroll': 'walk'}
    """
    table: dict[str, str] = {}
    lines: dict[str, int] = {}
    faults: list[str] = []
    for number, raw in enumerate(text.lstrip("\ufeff").splitlines(), start=1):
        line = raw.split("#", 1)[0].strip()
        if not line:
            continue
        pair = _pair(line)
        if pair is None:
            faults.append(
                f"{source}:{number}: expected 'word = canonical word', found {line!r}. "
                "Write one word on each side of '=' or of a tab."
            )
        elif table.get(pair[0], pair[1]) != pair[1]:
            faults.append(
                f"{source}:{number}: expected one canonical word for {pair[0]!r}, found "
                f"{pair[1]!r} beside {table[pair[0]]!r} of line {lines[pair[0]]}. Leave one out."
            )
        elif pair[0] != pair[1]:
            table[pair[0]], lines[pair[0]] = pair[1], number
    ends = _ends(table)
    faults += [
        f"{source}:{lines[word]}: expected synonyms that end in a word, found a circle through "
        f"{word!r}. Leave one of its lines out."
        for word in table
        if ends[word] is None
    ]
    if faults:
        raise SheetError("\n".join(faults))
    return {word: ends[word] or word for word in table}


def _pair(line: str) -> tuple[str, str] | None:
    sides = [side.strip() for side in re.split(r"=|\t+", line)]
    if len(sides) != 2 or not all(re.fullmatch(r"[^\W\d_]+", side) for side in sides):
        return None
    return lemma(sides[0]), lemma(sides[1])


def _ends(table: dict[str, str]) -> dict[str, str | None]:
    """End of the chain that starts at each word, None if it leads into a cycle."""
    ends: dict[str, str | None] = {}
    for start in table:
        chain: dict[str, None] = {}
        word = start
        while word in table and word not in ends and word not in chain:
            chain[word] = None
            word = table[word]
        end = None if word in chain else ends.get(word, word)
        ends.update(dict.fromkeys(chain, end))
    return ends
