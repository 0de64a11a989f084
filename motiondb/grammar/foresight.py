"""How well a grammar foresees takes that it was not learned from, and how free it is.

A *window* is five terminals in a row of a held-out take. It is compared with all different orders
of the same five, its *shuffles*, so neither frequent terminals nor long sentences help: only order
counts. Of a model,

* *foresight* is the share of windows that are more probable than 95 % of their shuffles;
* *right of two* is the share of pairs of a window and a shuffle in which the window is more
  probable, a tie counted as half, the mean over windows (chance: 0.5);
* *accepted* is the share of windows that the grammar itself, without smoothing, derives somewhere
  in passages of its sentences; *freedom* is the same share of the shuffles, the mean over windows.

A list of its sentences accepts few windows; a grammar of everything accepts all shuffles. Neither
foresees. Windows of five equal terminals have no shuffles and are left out.

A window that the grammar does not derive has a probability too (:class:`Model`). With c the
terminals before t in the window, and s the longest ending of c that passages contain,

    P(t | c) = w P_grammar(t | s) + (1 - w) P_pairs(t | last of c)

P_grammar is of a window that begins anywhere in a passage of sentences (:func:`endings_grammar`),
and P_pairs is smoothed by the method C of Witten and Bell, towards single terminals and these
towards equal chances. The weight w is the one of the most probable windows of takes that are held
out within the training part.

Sources: T. C. Bell, J. G. Cleary and I. H. Witten, "Text Compression" (1990), for method C; F.
Jelinek and R. L. Mercer, "Interpolated estimation of Markov source parameters from sparse data"
(1980), for held-out weights.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise, permutations
from math import log
from types import MappingProxyType

import numpy as np

from motiondb.grammar.cfg.compiled import CompiledGrammar
from motiondb.grammar.cfg.context_free import Grammar, Rule
from motiondb.grammar.cfg.parse import compiled_form, read_sentence
from motiondb.records import FloatArray

String = tuple[str, ...]
Take = Sequence[String]
"""A take as its sentences in order."""
Learn = Callable[[list[String]], Grammar]

WIDTH = 5  # Terminals of a window
ABOVE = 0.95  # Share of its shuffles than which a foreseen window is more probable
FEWEST_ORDERED, SHUFFLES = 8, 199  # Terminals of a string whose order is judged; its shuffles
FEWEST_WINDOWS = 20  # Below this nothing is said: one window would be worth more than .05
MOST_FOLDS = 5  # Largest number of parts of the takes
WEIGHTS = (0.0, 0.1, 0.25, 0.5, 0.75, 0.9)
"""Weights of the grammar that are tried. Chosen by hand."""
YES, NO = 2, 0.05  # What an answered pair counts: observations, or a factor of its chance
DEFAULT_WEIGHT = 0.5  # Weight where nothing can be held out
LIST, EVERYTHING = 0.05, 0.9
"""A grammar that accepts at most the first share of windows is a list; one that accepts at least
the second share of shuffles allows everything. Chosen by hand."""
MOST_SHUFFLED = 12_000  # Terminals of all shuffles of a string: longer ones have fewer than 199
_MOST_KEPT = 50_000  # Factors whose next terminals are kept
_CONTINUES = 0.99  # Chance that another sentence follows in a passage; any value near 1


def endings_grammar(grammar: Grammar) -> Grammar:
    """Return the grammar of passages that begin anywhere within a sentence.

    A prefix of its strings is a factor of passages. Every position of a random sentence is equally
    probable as the first one: an ending of X -> Y Z begins in Y with the share of Y in the mean
    length of X.

    >>> from motiondb.grammar.cfg.context_free import read_grammar
    >>> from motiondb.grammar.cfg.parse import suggest
    >>> found = endings_grammar(read_grammar("S -> a b A" + chr(10) + "A -> c [0.5] | empty [0.5]"))
    >>> [(t, round(p, 2)) for t, p in suggest(found, [])]
    [('a', 0.4), ('b', 0.4), ('c', 0.2)]
    """
    lengths = _mean_lengths(grammar)
    taken = {*grammar.nonterminals, *grammar.terminals}

    def new(name: str) -> str:
        while name in taken:
            name += "'"
        return name

    ending = {left: new(f"{left}~") for left in grammar.nonterminals}
    more, whole = new(f"{grammar.start}+"), new(f"{grammar.start}~+")
    rules = [
        Rule(
            ending[rule.left],
            (ending.get(symbol, symbol), *rule.right[place + 1 :]),
            rule.probability * lengths.get(symbol, 1.0) / lengths[rule.left],
        )
        for rule in grammar.rules
        for place, symbol in enumerate(rule.right)
        if lengths.get(symbol, 1.0) > 0.0
    ]
    passages = [
        Rule(whole, (ending[grammar.start], more), 1.0),
        Rule(more, (grammar.start, more), _CONTINUES),
        Rule(more, (), 1.0 - _CONTINUES),
    ]
    return Grammar(whole, (*grammar.rules, *rules, *passages), grammar.terminals)


def _mean_lengths(grammar: Grammar, rounds: int = 200) -> dict[str, float]:
    """The mean length of the strings of each nonterminal of at most so many levels."""
    lengths = dict.fromkeys(grammar.nonterminals, 0.0)
    for _ in range(rounds):
        new = dict.fromkeys(lengths, 0.0)
        for rule in grammar.rules:
            size = sum(lengths.get(symbol, 1.0) for symbol in rule.right)
            new[rule.left] += rule.probability * min(size, 1e6)
        if new == lengths:
            break
        lengths = new
    return lengths


class Pairs:
    """Probabilities of a terminal after another, smoothed by method C of Witten and Bell.

    >>> pairs = Pairs([("a", "b", "a", "b", "a", "c")], ("a", "b", "c"))
    >>> round(pairs.chance("b", "a"), 4), round(sum(pairs.chance(t, "a") for t in "abc"), 4)
    (0.5333, 1.0)
    """

    def __init__(
        self,
        strings: Sequence[Sequence[str]],
        terminals: Sequence[str],
        answers: Mapping[tuple[str, str], bool] = MappingProxyType({}),
    ) -> None:
        self.singles = Counter(symbol for string in strings for symbol in string)
        self.pairs = Counter(pair for string in strings for pair in pairwise(string))
        self.no: dict[str, set[str]] = {}
        for (first, then), can in answers.items():
            if can:
                self.pairs[first, then] += YES
            else:
                self.no.setdefault(first, set()).add(then)
        self.before, self.kinds = Counter[str](), Counter[str]()
        for (first, _), number in self.pairs.items():
            self.before[first] += number
            self.kinds[first] += 1
        self.total, self.known = self.singles.total(), len(self.singles)
        self.n_terminals = max(len(terminals), 1)

    def chance(self, symbol: str, before: str | None = None) -> float:
        """Return P(symbol | before); None is the beginning of a window, where any may stand."""
        alone = (self.singles[symbol] + self.known / self.n_terminals) / (self.total + self.known)
        if before is None:
            return alone
        smoothed = self._smoothed(symbol, before)
        ruled_out = self.no.get(before)
        if not ruled_out:
            return smoothed
        lost = (1.0 - NO) * sum(self._smoothed(one, before) for one in ruled_out)
        return smoothed * (NO if symbol in ruled_out else 1.0) / (1.0 - lost)

    def _smoothed(self, symbol: str, before: str) -> float:
        alone = self.chance(symbol)
        seen, kinds = self.before[before], self.kinds[before]
        if not seen:
            return alone
        return (self.pairs[before, symbol] + kinds * alone) / (seen + kinds)


@dataclass(frozen=True, eq=False)
class Model:
    """A grammar with smoothed probabilities: any string of its terminals has one."""

    compiled: CompiledGrammar  # Of :func:`endings_grammar`
    pairs: Pairs
    weight: float  # w, the weight of the grammar
    _nexts: dict[String, dict[str, float] | None] = field(default_factory=dict)

    def accepts(self, window: String) -> bool:
        """Whether passages of the grammar's sentences contain a string."""
        return all(
            (nexts := self._after(window[:n])) is not None and nexts.get(window[n], 0.0) > 0.0
            for n in range(len(window))
        )

    def log_probability(self, window: Sequence[str]) -> float:
        """Return the natural logarithm of the smoothed probability; -inf only where w is 1."""
        total = sum(log(p) if p > 0.0 else -np.inf for p in self.chances(window))
        return float(total)

    def chances(self, window: Sequence[str]) -> Iterator[float]:
        """Yield the smoothed probability of each terminal after those before it."""
        for n, symbol in enumerate(window):
            before = tuple(window[max(0, n - WIDTH + 1) : n])
            by_rules = self._by_rules(before, symbol) if self.weight > 0.0 else 0.0
            by_pairs = self.pairs.chance(symbol, window[n - 1] if n else None)
            yield self.weight * by_rules + (1.0 - self.weight) * by_pairs

    def _by_rules(self, before: String, symbol: str) -> float:
        """The chance of a terminal after the longest ending of ``before`` that passages contain."""
        nexts = self._after(before)
        while nexts is None:
            before = before[1:]
            nexts = self._after(before)
        return nexts.get(symbol, 0.0)

    def _after(self, before: String) -> dict[str, float] | None:
        """The chances of the terminals after a factor; None after a string that is none."""
        if before not in self._nexts:
            if len(self._nexts) >= _MOST_KEPT:
                self._nexts.clear()
            self._nexts[before] = self._read(before)
        return self._nexts[before]

    def _read(self, before: String) -> dict[str, float] | None:
        if before and self._after(before[1:]) is None:
            return None
        viable = read_sentence(self.compiled, before)
        total = float(viable.weights.sum())
        if viable.position < len(before) or total <= 0.0:
            return None
        names = self.compiled.names[self.compiled.terminals]
        return dict(zip(names, (viable.weights / total).tolist(), strict=True))


def make_model(
    grammar: Grammar,
    takes: Sequence[Take],
    weight: float,
    answers: Mapping[tuple[str, str], bool] = MappingProxyType({}),
) -> Model:
    """Return the smoothed probabilities of a grammar and of the takes it was learned from."""
    compiled = compiled_form(endings_grammar(grammar))
    return Model(
        compiled, Pairs([passage(take) for take in takes], grammar.terminals, answers), weight
    )


def order_rank(model: Model, string: Sequence[str], rng: np.random.Generator) -> float | None:
    """Return the share of random shuffles of a string that are less probable; ties count half.

    None where fewer than :data:`FEWEST_ORDERED` terminals, or only one kind, have no order to
    judge. A string that a model knows nothing about has a rank like a random number from 0 to 1.
    """
    if len(string) < FEWEST_ORDERED or len(set(string)) < 2:
        return None
    own = model.log_probability(string)
    n_shuffles = min(SHUFFLES, max(MOST_SHUFFLED // len(string), 19))
    shuffles = [[string[n] for n in rng.permutation(len(string))] for _ in range(n_shuffles)]
    others = np.array([model.log_probability(one) for one in shuffles])
    less, more = np.mean(others < own - 1e-9), np.mean(others > own + 1e-9)
    return float(1.0 + less - more) / 2.0


def passage(take: Take) -> String:
    """Return a take as one string."""
    return tuple(symbol for sentence in take for symbol in sentence)


def windows_of(string: Sequence[str]) -> list[String]:
    """Return the windows of a string that have shuffles.

    >>> windows_of("aaaaab")
    [('a', 'a', 'a', 'a', 'b')]
    """
    windows = [tuple(string[n : n + WIDTH]) for n in range(len(string) - WIDTH + 1)]
    return [window for window in windows if len(set(window)) > 1]


def shuffles_of(window: String) -> list[String]:
    """Return all different orders of a window but its own.

    >>> ["".join(order) for order in shuffles_of(("a", "b", "b"))]
    ['bab', 'bba']
    """
    return sorted(set(permutations(window)) - {window})


@dataclass(frozen=True)
class Foresight:
    """How models judge held-out windows against their shuffles; see the module."""

    windows: int  # Number of held-out windows
    foreseen: float  # Share of windows above 95 % of their shuffles
    right_of_two: float
    accepted: float  # Share of windows that the grammar derives, unsmoothed
    freedom: float  # Share of shuffles that the grammar derives, unsmoothed
    weight: float  # Weight of the rules, the mean of the models
    extreme: str  # "list" or "everything" where the grammar is one of these, else ""

    @property
    def says(self) -> str:
        """The figures as a sentence."""
        return (
            f"of {self.windows} held-out windows of {WIDTH} terminals, {self.foreseen:.0%} are"
            f" foreseen (above 95% of their shuffles; chance 5%), {self.right_of_two:.2f} right of"
            f" two (chance 0.50); the rules accept {self.accepted:.0%} of the windows and"
            f" {self.freedom:.0%} of the shuffles"
        )


def ranks(model: Model, windows: Sequence[String]) -> FloatArray:
    """Judge windows: array (windows, 4).

    Columns: the share of shuffles that are less probable, the same with ties as half, whether the
    window is accepted, and the share of shuffles that are.
    """
    rows = np.zeros((len(windows), 4))
    for row, window in zip(rows, windows):
        orders = shuffles_of(window)
        own = model.log_probability(window)
        others = np.array([model.log_probability(order) for order in orders])
        less, more = np.mean(others < own - 1e-9), np.mean(others > own + 1e-9)
        accepted = np.mean([model.accepts(order) for order in orders])
        row[:] = less, (1.0 + less - more) / 2.0, model.accepts(window), accepted
    return rows


def as_foresight(rows: FloatArray, weight: float) -> Foresight:
    """Return the figures of judged windows, at least one."""
    _, right_of_two, accepted, freedom = rows.mean(axis=0).tolist()
    extreme = "everything" if freedom >= EVERYTHING else "list" if accepted <= LIST else ""
    foreseen = float(np.mean(rows[:, 0] > ABOVE))
    return Foresight(len(rows), foreseen, right_of_two, accepted, freedom, weight, extreme)


def foresee(
    learn: Learn,
    takes: Sequence[Take],
    rng: np.random.Generator,
    answers: Mapping[tuple[str, str], bool] = MappingProxyType({}),
) -> Foresight | None:
    """Judge a method of learning by takes that are held out in turn; None: too few takes.

    The takes are divided at random into at most five parts. Each is judged by the grammar of the
    others, whose weight is chosen on the next part, held out as well.
    """
    order = rng.permutation(len(takes))
    parts = [part.tolist() for part in np.array_split(order, min(MOST_FOLDS, max(len(takes), 1)))]
    if len(parts) < 2 or sum(len(windows_of(passage(take))) for take in takes) < FEWEST_WINDOWS:
        return None
    rows, weights = [], []
    for number, part in enumerate(parts):
        rest = [n for n in range(len(takes)) if n not in part]
        training = [takes[n] for n in rest]
        inner = parts[(number + 1) % len(parts)]
        weights.append(choose_weight(learn, training, [rest.index(n) for n in inner]))
        model = make_model(learn(_sentences(training)), training, weights[-1], answers)
        rows.append(ranks(model, [w for n in part for w in windows_of(passage(takes[n]))]))
    return as_foresight(np.concatenate(rows), float(np.mean(weights)))


def choose_weight(learn: Learn, takes: Sequence[Take], held: Sequence[int]) -> float:
    """Return the weight under which windows of the takes ``held`` are the most probable.

    The grammar is learned from the other takes. :data:`DEFAULT_WEIGHT` where there are none.
    """
    training = [take for n, take in enumerate(takes) if n not in held]
    windows = [w for n in held for w in windows_of(passage(takes[n]))]
    if not training or not windows:
        return DEFAULT_WEIGHT
    rules = make_model(learn(_sentences(training)), training, 1.0)
    by_rules, by_pairs = (
        np.array([list(model.chances(window)) for window in windows])
        for model in (rules, replace(rules, weight=0.0))
    )
    sums = [float(np.log(w * by_rules + (1.0 - w) * by_pairs).sum()) for w in WEIGHTS]
    return WEIGHTS[int(np.argmax(sums))]


def _sentences(takes: Sequence[Take]) -> list[String]:
    return [tuple(sentence) for take in takes for sentence in take]
