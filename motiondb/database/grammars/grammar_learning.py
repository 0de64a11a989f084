"""Learn a grammar from captures: find terminals, sentences and rules, and save them together.

The terminals are found in the motion, or are the motion symbols of the database. The sentences are
found by least description length, or each capture is one sentence, or a sentence begins where a
timed caption begins. Either the whole grammar is saved or nothing is.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from itertools import pairwise

import numpy as np

from motiondb import store
from motiondb.database.grammars import grammar_asking
from motiondb.database.grammars.grammar_editing import FORESIGHT
from motiondb.database.loading import LearnedGrammar, load_learned_grammar
from motiondb.database.values import is_compiled, seeded
from motiondb.errors import QueryError
from motiondb.grammar import foresight
from motiondb.grammar.cfg import context_free, parse
from motiondb.grammar.induction.induction import induce_quickly, induce_with_bits
from motiondb.grammar.induction.law_checks import keeps_laws
from motiondb.grammar.sentences import partition
from motiondb.grammar.sentences.doubtful import find_doubtful
from motiondb.grammar.terminals.pose_runs import find_pose_runs
from motiondb.grammar.terminals.terminals import (
    Terminals,
    TerminalSettings,
    find_terminals,
    strings_of,
    terminals_from_symbols,
)
from motiondb.records import MOTION_FPS, Caption, CaptureInfo, IntArray, Motion

Progress = Callable[[str, float, float], None]
"""Called with the name of the step, the amount done and the total amount."""

SENTENCES = ("auto", "captures", "captions")
FEWEST_TERMINALS, MOST_TERMINALS = 4, 20
"""Bounds of the default number of terminals. The upper one is near the number with the fewest bits
of motion, strings and rules in most real takes (``docs/measured/grammar.md``)."""

SECONDS_A_TERMINAL = 5.0
"""Default duration for each terminal, in seconds. With 20 terminals in a minute of motion most of
them occur once, and nothing recurs that rules could describe. Held-out sentences of real takes are
foreseen as often as with a number chosen by bits, or more often (``docs/measured/grammar.md``)."""

MAX_NAME = 80  # Most characters of a grammar's name, so that it fits into file names and tables


@dataclass(frozen=True)
class GrammarSettings:
    """Settings that decide what is learned."""

    n_terminals: int | None = None
    """Number of whole actions that are terminals. None takes runs of poses of about half a second,
    whose number and length foresee best; actions, their number by duration, where the captures are
    too few to say which."""
    from_symbols: bool = False
    """Whether the motion symbols of the database are the terminals."""
    sentences: str = "auto"
    """"auto" (found by description length), "captures" (each capture is a sentence) or "captions"
    (a sentence begins where a timed caption begins)."""
    seed: int = 0
    """Seed of all random steps."""
    search: TerminalSettings = field(default_factory=TerminalSettings)
    """Settings of the search for terminals."""
    shortest: int = partition.SHORTEST
    """Fewest terminals of a sentence that is found."""
    longest: int = partition.LONGEST
    """Most terminals of a sentence that is found."""
    without_errors: bool = False
    """Whether sentences that look like errors are left out (``find_doubtful``)."""
    evaluations: int = partition.EVALUATIONS
    """Number of partitions into sentences that are tried; fewer for long strings."""


def learn_grammar(
    database: store.Store,
    captures: Sequence[str],
    name: str | None,
    settings: GrammarSettings,
    progress: Progress | None = None,
) -> tuple[LearnedGrammar, list[str]]:
    """Learn a grammar from captures and save it, as ``Grammars.learn`` does."""
    said = progress or (lambda _what, _done, _total: None)
    first = "" if is_compiled(keeps_laws) else ", compiling once"

    def tell(what: str, done: float, total: float) -> None:
        said(f"{what}{first}", done, total)

    infos = _sources(database, captures)
    name = infos[0].name.rpartition("/")[2] if name is None else name
    _check(name, settings)
    rng = seeded(settings.seed)
    motions = [store.load_motion(database, info.capture_id) for info in infos]
    store.check_writable(database)
    known = grammar_asking.load_answers(database, name)
    try:
        with store.released(database):
            learned = _search(database, infos, motions, name, settings, rng, tell)
            learned, kept_to = grammar_asking.with_answers(learned, known)
            tell("foresee held-out takes", 0.0, 1.0)
            judged = foresight.foresee(
                induce_quickly, learned.takes, seeded(settings.seed), kept_to
            )
    except parse.ParseError:  # an internal fault: a learned grammar parses its sentences
        raise
    except context_free.GrammarError as error:  # the captures or the number of terminals do not fit
        raise QueryError(str(error)) from None
    parameters = {"name": name, "captures": [info.name for info in infos], **asdict(settings)}
    parameters[FORESIGHT] = judged and asdict(judged)
    with store.running(database, "grammar", parameters, settings.seed) as run_id:
        lost = store.save_grammar(database, learned.stored, run_id)
    tell("parses", 1.0, 1.0)
    return load_learned_grammar(database, name), lost


def default_terminals(n_frames: int) -> int:
    """Return the default number of terminals for a total duration.

    >>> default_terminals(300), default_terminals(1_800), default_terminals(9_000)
    (4, 12, 20)
    """
    wished = round(n_frames / MOTION_FPS / SECONDS_A_TERMINAL)
    return min(max(wished, FEWEST_TERMINALS), MOST_TERMINALS)


def _sources(database: store.Store, captures: Sequence[str]) -> list[CaptureInfo]:
    """Load the records of the captures; raise QueryError if one cannot be learned from."""
    infos = store.load_named(database, captures)
    if not infos:
        raise QueryError("captures: expected at least one to learn from, found none. Name some.")
    for number, info in enumerate(infos):
        if not info.has_body:
            raise QueryError(f"{info.name}: {store.MARKERS_ONLY}")
        if info.kind != "captured":
            raise QueryError(
                f"{info.name}: expected a capture that was captured, found a generated one."
                " A grammar is learned from captured motion only: leave it out."
            )
        if any(info.capture_id == other.capture_id for other in infos[:number]):
            raise QueryError(
                f"{info.name}: expected every capture once, found it twice. Name it once."
            )
    return infos


def _check(name: str, settings: GrammarSettings) -> None:
    """Raise QueryError if the name or a setting is not valid."""
    if not name.strip() or len(name) > MAX_NAME or not name.isprintable():
        raise QueryError(
            f"{name!r}: expected a name of 1 to {MAX_NAME} letters, found another. Choose one."
        )
    store.check_new_name(name, "grammar")
    if settings.from_symbols and settings.n_terminals is not None:
        raise QueryError(
            "terminals: expected no number beside --from-symbols, where every motion symbol is a"
            f" terminal, found {settings.n_terminals}. Leave one of them out."
        )
    if settings.sentences not in SENTENCES:
        raise QueryError(
            f"sentences: expected one of {', '.join(SENTENCES)}, found {settings.sentences!r}."
        )
    if not 1 <= settings.shortest <= settings.longest:
        raise QueryError(
            "sentence lengths: expected 1 <= shortest <= longest, found"
            f" {settings.shortest} and {settings.longest}. Give both in terminals."
        )


def _search(
    database: store.Store,
    infos: Sequence[CaptureInfo],
    motions: Sequence[Motion],
    name: str,
    settings: GrammarSettings,
    rng: np.random.Generator,
    tell: Progress,
) -> LearnedGrammar:
    """Find terminals and then sentences."""
    captions = store.load_captions(database) if settings.sentences == "captions" else {}
    captions_of_takes = [captions.get(info.capture_id, ()) for info in infos]
    if settings.sentences == "captions" and not any(
        c.start for timed in captions_of_takes for c in timed
    ):
        raise QueryError(
            "sentences: expected captures with timed words, found none. Add some (motiondb words "
            "set --from --to), or search for the sentences (--sentences auto)."
        )

    def advance(done: int, total: int, what: str) -> None:
        tell(what, done, total)

    if settings.from_symbols:
        table = store.load_segments(database, scores=False)
        terminals = terminals_from_symbols(motions, [info.capture_id for info in infos], table)
        symbols = np.array([int(name.removeprefix("s")) for name in terminals.names])
    else:
        terminals = _found(motions, settings, rng, advance)
        symbols = np.full(len(terminals.names), -1)
    found = _sentences(terminals, captions_of_takes, settings, rng, tell)
    tell("parses", 0.0, 1.0)
    grammar, bits = found.grammar, found.bits
    intervals, sentences = _intervals(found.sentences), list(found.sentences)
    parses = _parses(grammar, sentences)
    if settings.without_errors and (odd := find_doubtful(grammar, sentences, parses)):
        kept = sorted(set(range(len(sentences))) - {one.sentence for one in odd})
        intervals, sentences = intervals[kept], [sentences[n] for n in kept]
        made = induce_with_bits(sentences)
        grammar, bits = made.grammar, made.bits
        parses = _parses(grammar, sentences)
    return LearnedGrammar(
        name,
        tuple(store.GrammarSource(i.name, i.sha256, i.motion_frames) for i in infos),
        terminals,
        symbols,
        context_free.Grammar(grammar.start, grammar.rules, terminals.names),
        intervals,
        parses,
        {"sentences": bits.sentences, "rules": bits.grammar},
    )


def _parses(
    grammar: context_free.Grammar, sentences: Sequence[Sequence[str]]
) -> tuple[tuple[int, ...], ...]:
    """The rules of the tree of each sentence."""
    return tuple(context_free.choices_of(parse.parse(grammar, each)) for each in sentences)


def _found(
    motions: Sequence[Motion],
    settings: GrammarSettings,
    rng: np.random.Generator,
    advance: Callable[[int, int, str], None],
) -> Terminals:
    """Find pose runs; whole actions where their number is given, or the takes are too few."""
    number = settings.n_terminals
    if number is None:
        runs = find_pose_runs(
            motions, rng, lambda done, total: advance(done, total, "choose pose runs")
        )
        if runs is not None:
            return runs
        number = default_terminals(sum(motion.n_frames for motion in motions))
    return find_terminals(motions, number, rng, settings=settings.search, progress=advance)


def _sentences(
    terminals: Terminals,
    captions: Sequence[Sequence[Caption]],
    settings: GrammarSettings,
    rng: np.random.Generator,
    tell: Progress,
) -> partition.Sentences:
    """Find the sentences of the takes; ``captions`` are those of each take."""
    strings = strings_of(terminals)
    if settings.sentences == "auto":
        return partition.find_sentences(
            strings,
            rng,
            lengths=(settings.shortest, settings.longest),
            evaluations=settings.evaluations,
            progress=lambda done, total: tell("find sentences", done, total),
        )
    if settings.sentences == "captures":
        return partition.sentences_between(strings, [[] for _ in strings])
    cuts = [
        caption_cuts(timed, terminals.starts[terminals.takes == take])
        for take, timed in enumerate(captions)
    ]
    return partition.sentences_between(strings, cuts)


def caption_cuts(captions: Sequence[Caption], starts: IntArray) -> list[int]:
    """Return the segments at which sentences begin: those nearest to the starts of timed captions.

    `starts` (segments,) are frames; captions without a start are ignored.

    >>> timed = [Caption("walk", 0.0, 1.0), Caption("jump", 1.0, 2.0), Caption("all")]
    >>> caption_cuts(timed, np.array([0, 14, 33, 50]))
    [2]
    """
    times = {c.start * MOTION_FPS for c in captions if c.start is not None}
    return sorted({int(np.argmin(np.abs(starts - time))) for time in times} - {0})


def _intervals(sentences: Sequence[Sequence[str]]) -> IntArray:
    """Return the interval [start, end) of segments of each sentence: array (sentences, 2)."""
    edges = np.cumsum([0, *map(len, sentences)])
    return np.array(list(pairwise(edges)), dtype=np.int64).reshape(-1, 2)
