"""Are the grammars whole? Every number resolves, and rules and parses give back the strings.

That last rule is the one a grammar lives by: deriving every sentence by its stored rule numbers
gives the very terminals of its segments, so the takes can be told from the grammar alone.
"""

from __future__ import annotations

from motiondb.errors import MotionDBError
from motiondb.grammar.cfg.context_free import check_grammar, derive_by
from motiondb.store.checking.offenders import FINISHED_RUN, broken_rules, foreign_rows
from motiondb.store.connection.handle import Store
from motiondb.store.grammars.grammars import (
    TABLES,
    LearnedGrammar,
    load_grammar,
    load_grammar_names,
)

_RULES = (
    # rule, query for the offenders (one text column)
    (
        "expected segments that tile its takes",
        """SELECT DISTINCT g.name FROM grammar g JOIN grammar_source c USING (grammar_id)
           LEFT JOIN (SELECT grammar_id, take, min(start_frame) AS low, max(end_frame) AS high,
           bool_and(end_frame > start_frame AND start_frame = previous) AS tiled FROM
           (SELECT *, lag(end_frame, 1, start_frame) OVER (PARTITION BY grammar_id, take
           ORDER BY ordinal) AS previous FROM terminal_segment) GROUP BY ALL) s
           USING (grammar_id, take) WHERE NOT coalesce(tiled, false) OR low <> 0
           OR high <> n_frames ORDER BY ALL""",
    ),
    (
        "expected one medoid for every terminal",
        """SELECT DISTINCT g.name FROM grammar g JOIN terminal t USING (grammar_id)
           LEFT JOIN (SELECT grammar_id, terminal, count(*) AS n FROM terminal_segment
           WHERE is_medoid GROUP BY ALL) s ON s.grammar_id = t.grammar_id
           AND s.terminal = t.ordinal WHERE coalesce(n, 0) <> 1 ORDER BY ALL""",
    ),
    (
        "expected the probabilities of a symbol's rules to sum to 1",
        """SELECT DISTINCT name FROM (SELECT grammar_id, left_symbol FROM grammar_rule
           GROUP BY ALL HAVING abs(sum(probability) - 1) > 1e-6) JOIN grammar USING (grammar_id)
           ORDER BY ALL""",
    ),
    (
        "expected sentences that tile the segments",
        """SELECT name FROM grammar LEFT JOIN (SELECT grammar_id, min(first_segment) AS low,
           max(end_segment) AS high, bool_and(end_segment > first_segment
           AND first_segment = previous) AS tiled FROM (SELECT *, lag(end_segment, 1,
           first_segment) OVER (PARTITION BY grammar_id ORDER BY ordinal) AS previous
           FROM sentence) GROUP BY ALL) s USING (grammar_id) LEFT JOIN (SELECT grammar_id,
           count(*) AS n FROM terminal_segment GROUP BY ALL) t USING (grammar_id)
           WHERE NOT coalesce(tiled, false) OR low <> 0 OR high <> n ORDER BY ALL""",
    ),
)


def broken_grammars(store: Store) -> list[str]:
    """Every fault in grammars and derivations, one sentence each."""
    faults = broken_rules(store, _RULES, "grammar ")
    faults += [fault for table in TABLES for fault in _unresolved(store, table)]
    if faults:
        return faults
    for name in load_grammar_names(store):
        learned = load_grammar(store, name)
        faults += _wrong_parses(learned) + _wrong_derivations(store, learned)
    return faults


def _unresolved(store: Store, table: str) -> list[str]:
    """Rows of no grammar, of another or an unfinished run, or of a capture that is gone."""
    checks = {"a grammar": "grammar_id NOT IN (SELECT grammar_id FROM grammar)"} | FINISHED_RUN
    if table == "derivation":
        checks["a generated capture"] = (
            "capture_id NOT IN (SELECT capture_id FROM capture WHERE kind = 'generated')"
        )
    else:
        checks["the run of its grammar"] = (
            f"run_id <> (SELECT run_id FROM grammar g WHERE g.grammar_id = {table}.grammar_id)"
        )
    return foreign_rows(store, table, checks)


def _wrong_parses(learned: LearnedGrammar) -> list[str]:
    try:
        check_grammar(learned.grammar)
    except MotionDBError as error:
        return [f"grammar {learned.name}: {error}"]
    wrong = [
        number
        for number, (string, rules) in enumerate(zip(learned.strings, learned.parses))
        if _derived(learned, rules) != string
    ]
    wrong += [
        number
        for number, (first, end) in enumerate(learned.sentences)
        if len(set(learned.terminals.takes[first:end].tolist())) != 1
    ]
    return [
        f"grammar {learned.name}: expected sentence {number} to be derived by its rules within one "
        "take, found otherwise."
        for number in sorted(set(wrong))
    ]


def _wrong_derivations(store: Store, learned: LearnedGrammar) -> list[str]:
    rows = store.connection.execute(
        "SELECT name, rules, clips FROM derivation JOIN capture USING (capture_id) "
        "WHERE grammar_id = ? ORDER BY name",
        [learned.grammar_id],
    ).fetchall()
    n, faults = len(learned.terminals.takes), []
    for name, rules, clips in rows:
        known = all(0 <= clip < n for clip in clips)
        played = tuple(learned.string(c, c + 1)[0] for c in clips) if known else ()
        if not known or _derived(learned, tuple(rules)) != played:
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
