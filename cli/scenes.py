"""Commands scene grammar check, scene validate, scene suggest and scene draw."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from motiondb.cli import options, printing, scene_making

if TYPE_CHECKING:
    from motiondb import MotionGrammar, ShownAction, Tree

GrammarFile = Annotated[
    str, typer.Argument(metavar="GRAMMAR", help="A grammar file, or basketball or carrying.")
]
Actions = Annotated[str, typer.Argument(help="Actions in their order, separated by spaces.")]
StartSymbol = Annotated[
    str, typer.Option("--start", help="The start symbol, such as S_D.  [default: any that fits]")
]
Goals = Annotated[
    list[str] | None,
    typer.Option("--goal", help="An action to reach; may be repeated for several, in order."),
]


def register(app: typer.Typer) -> None:
    """Add the commands to the app."""
    group = options.Commands(
        help="Scenes from motion grammars and tactics diagrams.", no_args_is_help=True
    )
    grammars = options.Commands(help="Grammars of motion.", no_args_is_help=True)
    grammars.command("check")(check_grammar)
    group.add_typer(grammars, name="grammar")
    group.command("validate")(validate)
    group.command("suggest")(suggest)
    group.command("draw")(draw)
    scene_making.register(group)
    app.add_typer(group, name="scene")


def check_grammar(
    shared: options.SharedOfClips, file: GrammarFile, exact: options.Exact = False
) -> None:
    """Check a grammar: form, LR(1) conflicts, useless symbols, and clips in a database."""
    from motiondb import Scenes
    from motiondb.answers.scenes import CheckedGrammar, StartSymbol

    grammar = Scenes.read_grammar(file)
    report = Scenes.check_grammar(grammar)
    clips = _clips(shared, grammar, exact)
    starts = [
        StartSymbol(
            start.symbol,
            start.team,
            start.empty,
            not start.conflicts,
            start.n_states,
            [conflict.describe(grammar.grammar) for conflict in start.conflicts],
        )
        for start in report.starts
    ]
    checked = CheckedGrammar(
        report.name,
        report.nonterminals,
        report.terminals,
        report.rules,
        report.n_semantic_rules,
        report.useless,
        report.nullable,
        starts,
        _number(clips, report.terminals),
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


def validate(
    shared: options.SharedOfClips, file: GrammarFile, actions: Actions, start: StartSymbol = ""
) -> None:
    """Show the tree of a string of actions, or the fault and what was expected (exit 1)."""
    from motiondb import Scenes
    from motiondb.answers.scenes import ValidatedActions

    grammar = Scenes.read_grammar(file)
    validation = Scenes.validate(grammar, actions, start)
    clips = _clips(shared, grammar)
    named = [name for name in dict.fromkeys(actions.split()) if name in grammar.terminal]
    answer = ValidatedActions(
        validation.allowed,
        validation.start,
        _tree_facts(validation.tree) if validation.tree else None,
        int(validation.n_trees) if math.isfinite(validation.n_trees) else None,
        None if validation.allowed else validation.position,
        validation.expected,
        validation.message,
        _number(clips, named),
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


def _tree_facts(tree: Tree) -> str | list[Any]:
    return tree.symbol if tree.is_leaf else [tree.symbol, [_tree_facts(c) for c in tree.children]]


def _print_tree(tree: Tree) -> None:
    """Print one symbol per line, indented by its depth."""
    waiting = [(tree, 0)]
    while waiting:
        node, depth = waiting.pop()
        nothing = "  (nothing)" if not node.is_leaf and not node.children else ""
        printing.say(f"{'  ' * depth}{node.symbol}{nothing}")
        waiting.extend((child, depth + 1) for child in reversed(node.children))


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
    from motiondb import Scenes
    from motiondb.answers.scenes import ActionString, NextAction, NextActions

    grammar = Scenes.read_grammar(file)
    if goals:
        string = Scenes.plan(grammar, actions, goals, start)
        clips, names = _clips(shared, grammar), list(dict.fromkeys(string))
        if not printing.as_json(shared, ActionString(string, _number(clips, names))):
            printing.say(" ".join(string))
            _print_clips(clips, names)
        return
    suggestion = Scenes.suggest(grammar, actions, start)
    clips, names = _clips(shared, grammar), [name for name, _ in suggestion.actions]
    following = [NextAction(name, chance) for name, chance in suggestion.actions]
    if printing.as_json(shared, NextActions(following, suggestion.end, _number(clips, names))):
        return
    rows = [[one.action, f"{one.probability:.3f}"] for one in following]
    if suggestion.end:
        rows.append(["(the end)", f"{suggestion.end:.3f}"])
    printing.print_table("", ["next", "probability"], rows)
    _print_clips(clips, names)


def draw(
    shared: options.SharedOfClips,
    file: Annotated[
        str, typer.Argument(metavar="DIAGRAM", help="A tactics file, or one like give-and-go.")
    ],
    out: Annotated[
        Path,
        typer.Option("--out", "-o", callback=options.output_name, help="Draw into this PNG."),
        options.WRITTEN,
    ],
) -> None:
    """Draw a tactics diagram, and list the actions that it requires of each player."""
    from motiondb import Scenes
    from motiondb.answers.scenes import DiagramPlayer, DrawnDiagram

    text = Scenes.read_diagram(file)
    clips, diagram = _clips(shared, text.grammar), text.diagram
    Scenes.draw_diagram(text, out)
    players = [
        DiagramPlayer(
            player.name,
            player.team,
            text.expressions[player.name],
            text.shortest[player.name],
            diagram.opponent_of(player.name) or None,
        )
        for player in diagram.players
    ]
    holder, counts = text.first_holder, _number(clips, text.actions)
    drawn = DrawnDiagram(diagram.name, text.grammar.name, str(out), holder, players, counts)
    if printing.as_json(shared, drawn):
        return
    ball = f"; {holder} has the ball at the start" if holder else ""
    printing.say(f"{diagram.name} drawn to {out}{ball}")
    printing.print_table(
        "",
        ["player", "team", "expression", "shortest string"],
        [[p.name, p.team, p.expression, " ".join(p.shortest)] for p in players],
    )
    _print_clips(clips, text.actions)


Clips = Mapping[str, Sequence["ShownAction"]] | None  # The clips of each action; None: no database


def _clips(shared: options.SharedOfClips, grammar: MotionGrammar, exact: bool = False) -> Clips:
    """Return the clips of a database for every terminal, or None if no database is given."""
    with shared.database() as base:
        if base is None:
            return None
        printing.note_phrases(base.scenes, grammar, exact)
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
