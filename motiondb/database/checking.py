"""Check a database: its store, and that the parses of its grammars give back their strings.

Deriving every sentence by its stored rule numbers must give exactly the terminals of its segments,
so that the takes follow from the grammar alone.
"""

from __future__ import annotations

from motiondb import store
from motiondb.database.learned_grammar import LearnedGrammar, load_learned_grammar
from motiondb.errors import MotionDBError
from motiondb.grammar.cfg.context_free import check_grammar, derive_by


def check(opened: store.Store) -> list[str]:
    """Every fault of an open database, one sentence each; none if it is sound."""
    faults = store.check_store(opened, sources=True)
    if faults:  # grammars cannot be loaded from broken tables
        return faults
    for name in store.load_grammar_names(opened):
        learned = load_learned_grammar(opened, name)
        faults += _wrong_parses(learned) + _wrong_derivations(opened, learned)
    return faults


def _wrong_parses(learned: LearnedGrammar) -> list[str]:
    try:
        check_grammar(learned.grammar)
    except MotionDBError as error:
        return [f"grammar {learned.name}: {error}"]
    takes = learned.terminals.takes
    return [
        f"grammar {learned.name}: expected sentence {number} to be derived by its rules within one "
        "take, found otherwise."
        for number, (string, rules) in enumerate(zip(learned.strings, learned.parses))
        if _derived(learned, rules) != string
        or len(set(takes[slice(*learned.sentences[number])].tolist())) != 1
    ]


def _wrong_derivations(opened: store.Store, learned: LearnedGrammar) -> list[str]:
    n, faults = len(learned.terminals.takes), []
    for name, derivation in store.load_derivations(opened, learned.grammar_id).items():
        known = all(0 <= clip < n for clip in derivation.clips)
        played = tuple(learned.string(c, c + 1)[0] for c in derivation.clips) if known else ()
        if not known or _derived(learned, derivation.rules) != played:
            faults.append(
                f"{name}: expected clips of the terminals that grammar {learned.name} derived, "
                "found others."
            )
    return faults


def _derived(learned: LearnedGrammar, rules: tuple[int, ...]) -> tuple[str, ...] | None:
    try:
        return derive_by(learned.grammar, rules).leaves()
    except MotionDBError:
        return None
