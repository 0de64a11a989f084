"""Edit a grammar by hand: its rules, the name of a terminal; and take the last edit back.

An edit is saved as a whole new version of the grammar. Its run holds what was before it, so edits
can be taken back one after the other, also by a later process. The version that comes back has a
run of its own, too: a derivation of an older run belongs to another version, which is how the trash
knows. Saved sequences stay editable where the new rules derive their strings; those that were lost
come back when the edit is taken back.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, cast

from motiondb import store
from motiondb.database.loading import LearnedGrammar, load_learned_grammar
from motiondb.errors import QueryError, suggestion
from motiondb.grammar.cfg import context_free
from motiondb.grammar.cfg.context_free import EMPTY, Grammar, GrammarError, Rule
from motiondb.grammar.cfg.parse import ParseError, parse
from motiondb.grammar.rules.description_length import description_length
from motiondb.records import Run

EDIT = "edit"  # The key of a run's parameters that holds an edit
UNDONE = "undone"  # That of a run which took an edit back
FORESIGHT = "foresight"  # That of the figures on held-out takes, which edited rules lose
_TERMINAL = re.compile(r"[A-Za-z_][A-Za-z0-9_'.-]{0,59}")
_Derivations = Mapping[str, store.Derivation]


def edit_rules(database: store.Store, name: str, text: str) -> list[str]:
    """Replace the rules of a grammar; return the sequences that can no longer be edited."""
    with store.transaction(database):
        learned = load_learned_grammar(database, name)
        grammar = _read_rules(learned, text)
        old = learned.grammar
        if grammar.start == old.start and set(grammar.rules) == set(old.rules):
            return []
        edited = _parsed(replace(learned, grammar=grammar))
        return _save(database, learned, edited, "rules", {})


def rename_terminal(database: store.Store, name: str, terminal: str, to: str) -> list[str]:
    """Give a terminal of a grammar another name, also in its rules."""
    with store.transaction(database):
        learned = load_learned_grammar(database, name)
        known = learned.terminals.names
        if terminal not in known:
            near = suggestion(terminal, known) or f" There are: {', '.join(known)}."
            raise QueryError(f"terminal: expected one of {name}, found {terminal!r}.{near}")
        if to == terminal:
            return []
        taken = {*known, *learned.grammar.nonterminals, EMPTY}
        if not _TERMINAL.fullmatch(to) or to in taken:
            found = "one that is taken" if to in taken else repr(to[:100])
            raise QueryError(
                f"terminal: expected a new name of at most 60 of the letters a-z and A-Z, digits,"
                f" _, ', . and -, that begins with a letter or _, found {found}. Choose another"
                " name."
            )
        names = tuple(to if one == terminal else one for one in known)
        rules = tuple(
            replace(rule, right=tuple(to if one == terminal else one for one in rule.right))
            for rule in learned.grammar.rules
        )
        edited = replace(
            learned,
            terminals=replace(learned.terminals, names=names),
            grammar=Grammar(learned.grammar.start, rules, names),
        )
        return _save(database, learned, edited, f"name of {terminal}", {terminal: to})


def undo_edit(database: store.Store, name: str) -> str:
    """Take the last edit of a grammar back; return what it was."""
    with store.transaction(database):
        learned = load_learned_grammar(database, name)
        edit = _edit_of(store.load_run(database, learned.run_id))
        if edit is None:
            raise QueryError(
                f"{name}: expected a grammar that was edited, found none: nothing to undo."
            )
        before = edit["before"]
        names = tuple(before["terminals"])
        earlier = replace(
            learned,
            terminals=replace(learned.terminals, names=names),
            grammar=Grammar(
                before["start"], tuple(Rule(a, tuple(b), p) for a, b, p in before["rules"]), names
            ),
            parses=tuple(map(tuple, before["parses"])),
            bits=before["bits"],
        )
        renamed = dict(zip(learned.terminals.names, names, strict=True))
        since = _derivations(database, learned)
        carried, _ = _carried(learned, earlier, since, renamed)
        kept = {
            sha256: store.Derivation(name, tuple(rules), tuple(clips))
            for sha256, (rules, clips) in before["derivations"].items()
        }
        of_before = store.load_run(database, before["run"])
        undone = {UNDONE: {"what": edit["what"], "run": learned.run_id}}
        parameters = of_before.parameters | undone
        with store.running(database, "grammar undo", parameters, of_before.seed) as number:
            _replace(database, earlier, number, carried | kept)
        return str(edit["what"])


def edits_of(runs: Mapping[int, Run], run_id: int) -> tuple[str, ...]:
    """What the edits changed that can be taken back, the last first."""
    found: list[str] = []
    while run_id in runs and (edit := _edit_of(runs[run_id])) is not None:
        found.append(str(edit["what"]))
        earlier = int(edit["before"]["run"])
        if earlier >= run_id:
            break
        run_id = earlier
    return tuple(found)


def _edit_of(run: Run) -> dict[str, Any] | None:
    """The edit that a run made, with what was before it."""
    return cast("dict[str, Any] | None", run.parameters.get(EDIT))


def _derivations(database: store.Store, learned: LearnedGrammar) -> dict[str, store.Derivation]:
    """Load the derivations of a grammar by the digests of their captures, which stay."""
    digests = {info.name: info.sha256 for info in store.load_captures(database)}
    known = store.load_derivations(database, learned.grammar_id)
    return {digests[name]: derivation for name, derivation in known.items()}


def _read_rules(learned: LearnedGrammar, text: str) -> Grammar:
    """Read edited rules; a nonterminal whose line is unchanged keeps its exact probabilities."""
    names = learned.terminals.names
    try:
        read = context_free.read_grammar(text)
        context_free.check_grammar(read)
    except GrammarError as error:
        raise QueryError(str(error)) from None
    wrong = sorted(set(read.nonterminals) & set(names))
    if wrong:
        raise QueryError(
            f"rules: expected nonterminals on the left, found the terminal {wrong[0]!r}."
            " A terminal stands for segments of captures, and has no rules."
        )
    unknown = sorted(set(read.terminals) - set(names))
    if unknown:
        near = suggestion(unknown[0], (*names, *read.nonterminals))
        near = near or f" Terminals are: {', '.join(names)}."
        raise QueryError(
            f"rules: expected terminals of the captures or nonterminals with rules, found"
            f" {unknown[0][:60]!r}.{near}"
        )
    old = learned.grammar
    exact: list[Rule] = []
    for left in read.nonterminals:
        rules = [read.rules[n] for n in read.rules_of[left]]
        before = [old.rules[n] for n in old.rules_of.get(left, ())]
        same = [(r.right, f"{r.probability:.3g}") for r in rules] == [
            (r.right, f"{r.probability:.3g}") for r in before
        ]
        exact += before if same else rules
    return Grammar(read.start, tuple(exact), names)


def _parsed(edited: LearnedGrammar) -> LearnedGrammar:
    """Parse all sentences with edited rules, and count their bits; every one must be derived."""
    grammar, choices = edited.grammar, []
    for sentence in edited.strings:
        try:
            choices.append(context_free.choices_of(parse(grammar, sentence)))
        except ParseError as error:
            raise QueryError(
                f"rules: expected rules that derive every sentence of the captures, found none for"
                f" '{' '.join(sentence)}': {error}"
            ) from None
    bits = description_length(Grammar(grammar.start, grammar.rules), edited.strings)
    counted = {"sentences": bits.sentences, "rules": bits.grammar}
    return replace(edited, parses=tuple(choices), bits=counted)


def _carried(
    learned: LearnedGrammar, edited: LearnedGrammar, known: _Derivations, renamed: Mapping[str, str]
) -> tuple[dict[str, store.Derivation], list[str]]:
    """Return the derivations by other rules, and the captures that these do not derive."""
    kept: dict[str, store.Derivation] = {}
    lost: list[str] = []
    for capture, derivation in known.items():
        try:
            leaves = context_free.derive_by(learned.grammar, derivation.rules).leaves()
            tree = parse(edited.grammar, [renamed.get(leaf, leaf) for leaf in leaves])
        except GrammarError:  # such as ParseError
            lost.append(capture)
        else:
            kept[capture] = replace(derivation, rules=context_free.choices_of(tree))
    return kept, lost


def _save(
    database: store.Store,
    learned: LearnedGrammar,
    edited: LearnedGrammar,
    what: str,
    renamed: Mapping[str, str],
) -> list[str]:
    """Save an edited grammar with what was before it."""
    known = _derivations(database, learned)
    kept, lost = _carried(learned, edited, known, renamed)
    run = store.load_run(database, learned.run_id)
    before: dict[str, Any] = {
        "run": learned.run_id,
        "terminals": learned.terminals.names,
        "start": learned.grammar.start,
        "rules": [(r.left, r.right, r.probability) for r in learned.grammar.rules],
        "parses": [[int(n) for n in parse] for parse in learned.parses],
        "bits": dict(learned.bits),
        "derivations": {
            capture: ([int(n) for n in one.rules], [int(n) for n in one.clips])
            for capture, one in known.items()
        },
    }
    lapsed = {EDIT, UNDONE, *([FORESIGHT] if what == "rules" else [])}
    of_learning = {key: value for key, value in run.parameters.items() if key not in lapsed}
    parameters = of_learning | {EDIT: {"what": what, "before": before}}
    with store.running(database, "grammar edit", parameters, run.seed) as number:
        _replace(database, edited, number, kept)
    return [info.name for info in store.load_captures(database) if info.sha256 in lost]


def _replace(
    database: store.Store, grammar: LearnedGrammar, run_id: int, derivations: _Derivations
) -> None:
    """Save a version of a grammar in the place of the present one, with its derivations."""
    store.save_grammar(database, grammar.stored, run_id)
    number = store.load_grammar(database, grammar.name).grammar_id
    for info in store.load_captures(database):
        derivation = derivations.get(info.sha256)
        if derivation is None or info.kind != "generated":
            continue
        if store.load_derivation(database, info.capture_id) is None:
            store.save_derivation(database, info.capture_id, number, derivation, run_id)
