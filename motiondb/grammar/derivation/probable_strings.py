"""The strings of a language, most probable first.

A string can be no more probable than its beginnings, so a search that always lengthens the most
probable beginning meets the strings in the order of their probability, each summed over all its
trees. A finite language comes out whole.
"""

from __future__ import annotations

from collections.abc import Iterator
from heapq import heappop, heappush
from itertools import count
from math import inf, log

from motiondb.grammar.cfg.parse import AnyGrammar, compiled_form
from motiondb.grammar.cfg.prefix import suggest


def best_strings(
    grammar: AnyGrammar, n: int, *, steps: int | float = inf
) -> Iterator[tuple[tuple[str, ...], float]]:
    """The ``n`` most probable strings with their log-probabilities, given that derivations end.

    Equal ones in the order of the grammar's terminals. ``steps`` bounds the beginnings looked at;
    the search may then stop before the n-th string.

    >>> from motiondb.grammar.cfg.context_free import read_grammar
    >>> toy = read_grammar("S -> a S [0.6] | b [0.4]")
    >>> ["".join(string) for string, _ in best_strings(toy, 3)]
    ['b', 'ab', 'aab']
    """
    compiled = compiled_form(grammar)
    order = count()
    agenda: list[tuple[float, int, tuple[str, ...], bool]] = [(0.0, next(order), (), False)]
    found = looked = 0
    while agenda and found < n:
        cost, _, string, complete = heappop(agenda)
        if complete:
            found += 1
            yield string, -cost
            continue
        looked += 1
        if looked > steps:
            return
        for symbol, chance in suggest(compiled, string):
            longer = string if symbol is None else (*string, symbol)
            heappush(agenda, (cost - log(chance), next(order), longer, symbol is None))
