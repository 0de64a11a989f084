"""Commands scene grammar check, scene validate, scene suggest and scene draw."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

import motiondb
from motiondb import answers
from motiondb.cli import options, printing, scene_making

app = options.Commands()
group = app.group("scene", "Scenes from motion grammars and tactics diagrams.")
grammars = group.group("grammar", "Grammars of motion.")

GrammarFile = Annotated[
    str, options.argument("A grammar file, or basketball or carrying.", "GRAMMAR")
]
Actions = Annotated[str, options.argument("Actions in their order, separated by spaces.")]
StartSymbol = Annotated[str, "The start symbol, such as S_D.  [default: any that fits]"]
Goals = Annotated[
    list[str] | None,
    options.option("An action to reach; may be repeated for several, in order.", "--goal"),
]


@grammars.command("check")
def check_grammar(
    shared: options.SharedOfClips, file: GrammarFile, exact: options.Exact = False
) -> None:
    """Check a grammar: form, LR(1) conflicts, useless symbols, and clips in a database."""
    grammar = motiondb.Scenes.read_grammar(file)
    report = motiondb.Scenes.check_grammar(grammar)
    clips = _clips(shared, grammar, exact)
    starts = [
        answers.StartSymbol(
            start.symbol,
            start.team,
            start.empty,
            not start.conflicts,
            start.n_states,
            [conflict.describe(grammar.grammar) for conflict in start.conflicts],
        )
        for start in report.starts
    ]
    checked = answers.extended(
        answers.CheckedGrammar,
        report,
        semantic_rules=report.n_semantic_rules,
        starts=starts,
        clips=_number(clips, report.terminals),
    )
    if printing.as_json(shared, checked):
        return
    printing.say(
        f"{report.name}: {len(report.nonterminals)} nonterminals, {len(report.terminals)}"
        f" terminals, {len(report.rules)} rules, {report.n_semantic_rules} semantic rules"
    )
    for start in starts:
        whom = f" ({start.team})" if start.team else ""
        kind = f"LR(1), {start.lr1_states} states" if start.lr1 else "not LR(1)"
        printing.say(f"{start.symbol}{whom}: {kind}")
        for conflict in start.conflicts:
            printing.say(f"    {conflict}")
        if start.can_be_empty:
            printing.say(
                "    can derive the empty string, but every player on court needs at least "
                "one action"
            )
    printing.say(f"can be empty: {', '.join(report.nullable) or 'nothing'}")
    printing.say(f"useless: {', '.join(report.useless) or 'nothing'}")
    _print_clips(clips, report.terminals)


@group.command()
def validate(
    shared: options.SharedOfClips, file: GrammarFile, actions: Actions, start: StartSymbol = ""
) -> None:
    """Show the tree of a string of actions, or the fault and what was expected (exit 1)."""
    grammar = motiondb.Scenes.read_grammar(file)
    validation = motiondb.Scenes.validate(grammar, actions, start)
    clips = _clips(shared, grammar)
    named = [name for name in dict.fromkeys(actions.split()) if name in grammar.terminal]
    answer = answers.extended(
        answers.ValidatedActions,
        validation,
        tree=_tree_facts(validation.tree) if validation.tree else None,
        trees=int(validation.n_trees) if math.isfinite(validation.n_trees) else None,
        position=None if validation.allowed else validation.position,
        clips=_number(clips, named),
    )
    if not printing.as_json(shared, answer) and validation.tree:
        _print_tree(validation.tree)
        if validation.n_trees > 1:
            number = "endlessly many" if answer.trees is None else answer.trees
            printing.say(f"ambiguous: the most probable of {number} trees")
        _print_clips(clips, named)
    if not validation.allowed:
        if not shared.json:
            printing.warn(f"{grammar.name}: {validation.message}")
        raise typer.Exit(1)


def _tree_facts(tree: motiondb.Tree) -> str | list[Any]:
    return tree.symbol if tree.is_leaf else [tree.symbol, [_tree_facts(c) for c in tree.children]]


def _print_tree(tree: motiondb.Tree) -> None:
    """Print one symbol per line, indented by its depth."""
    waiting = [(tree, 0)]
    while waiting:
        node, depth = waiting.pop()
        nothing = "  (nothing)" if not node.is_leaf and not node.children else ""
        printing.say(f"{'  ' * depth}{node.symbol}{nothing}")
        waiting.extend((child, depth + 1) for child in reversed(node.children))


@group.command()
def suggest(
    shared: options.SharedOfClips,
    file: GrammarFile,
    actions: Actions,
    start: StartSymbol = "",
    goals: Goals = None,
) -> None:
    """List the actions that may come next, with the probabilities of the grammar's rules.

    With --goal, show the shortest string that goes on from the actions and reaches the goals.
    """
    grammar = motiondb.Scenes.read_grammar(file)
    if goals:
        string = motiondb.Scenes.plan(grammar, actions, goals, start)
        clips, names = _clips(shared, grammar), list(dict.fromkeys(string))
        if not printing.as_json(shared, answers.ActionString(string, _number(clips, names))):
            printing.say(" ".join(string))
            _print_clips(clips, names)
        return
    suggestion = motiondb.Scenes.suggest(grammar, actions, start)
    clips, names = _clips(shared, grammar), [name for name, _ in suggestion.actions]
    following = [answers.NextAction(name, chance) for name, chance in suggestion.actions]
    if printing.as_json(
        shared, answers.NextActions(following, suggestion.end, _number(clips, names))
    ):
        return
    rows = [[one.action, f"{one.probability:.3f}"] for one in following]
    if suggestion.end:
        rows.append(["(the end)", f"{suggestion.end:.3f}"])
    printing.print_table(["next", "probability"], rows)
    _print_clips(clips, names)


@group.command()
def draw(
    shared: options.SharedOfClips,
    file: options.DiagramFile,
    out: Annotated[
        Path, options.option("Draw into this PNG.", "--out", "-o", callback=options.output_name)
    ],
) -> None:
    """Draw a tactics diagram, and list the actions that it requires of each player."""
    text = motiondb.Scenes.read_diagram(file)
    clips, diagram = _clips(shared, text.grammar), text.diagram
    motiondb.Scenes.draw_diagram(text, out)
    players = [
        answers.DiagramPlayer(
            player.name,
            player.team,
            text.expressions[player.name],
            text.shortest[player.name],
            diagram.opponent_of(player.name) or None,
        )
        for player in diagram.players
    ]
    holder, counts = text.first_holder, _number(clips, text.actions)
    drawn = answers.DrawnDiagram(diagram.name, text.grammar.name, str(out), holder, players, counts)
    if printing.as_json(shared, drawn):
        return
    ball = f"; {holder} has the ball at the start" if holder else ""
    printing.say(f"{diagram.name} drawn to {out}{ball}")
    printing.print_table(
        ["player", "team", "expression", "shortest string"],
        [[p.name, p.team, p.expression, " ".join(p.shortest)] for p in players],
    )
    _print_clips(clips, text.actions)


# The clips of each action; None: no database
Clips = Mapping[str, Sequence["motiondb.ShownAction"]] | None


def _clips(
    shared: options.SharedOfClips, grammar: motiondb.MotionGrammar, exact: bool = False
) -> Clips:
    """Return the clips of a database for every terminal, or None if no database is given."""
    with shared.database() as base:
        if base is None:
            return None
        taken = {} if exact else base.scenes.taken_words(grammar)
        printing.note_taken(taken.values(), grammar.name)
        return base.scenes.find_actions(grammar, exact)


def _number(clips: Clips, names: Sequence[str]) -> dict[str, int] | None:
    """Return the number of clips of some actions."""
    return None if clips is None else {name: len(clips[name]) for name in names}


def _print_clips(clips: Clips, names: Sequence[str]) -> None:
    if clips is None:
        return
    printing.say("clips: " + ", ".join(f"{name} {len(clips[name])}" for name in names))
    without = [name for name in names if not clips[name]]
    if without:
        printing.say(f"no clips for {', '.join(without)}: caption captures that show them")


group.include(scene_making.app)
