"""Commands scene grammar check, scene validate, scene suggest and scene draw."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from motiondb.cli import scene_making
from motiondb.cli.options import Commands, Exact, Json, database
from motiondb.cli.printing import note_phrases, print_json, print_table

if TYPE_CHECKING:
    from motiondb import GrammarReport, MotionGrammar, ShownAction, Tree

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
ClipsDb = Annotated[
    Path | None, typer.Option("--db", help="Also list the clips of this database for every action.")
]


def register(app: typer.Typer) -> None:
    """Add the commands to the app."""
    group = Commands(help="Scenes from motion grammars and tactics diagrams.", no_args_is_help=True)
    grammars = Commands(help="Grammars of motion.", no_args_is_help=True)
    grammars.command("check")(check_grammar)
    group.add_typer(grammars, name="grammar")
    group.command("validate")(validate)
    group.command("suggest")(suggest)
    group.command("draw")(draw)
    scene_making.register(group)
    app.add_typer(group, name="scene")


def check_grammar(
    file: GrammarFile, db: ClipsDb = None, exact: Exact = False, json: Json = False
) -> None:
    """Check a grammar: form, LR(1) conflicts, useless symbols, and clips in a database."""
    from motiondb import Scenes

    grammar = Scenes.read_grammar(file)
    report = Scenes.check_grammar(grammar)
    clips = _clips(db, grammar, exact)
    if json:
        print_json(_report_facts(grammar, report, clips))
        return
    typer.echo(
        f"{report.name}: {len(report.nonterminals)} nonterminals, {len(report.terminals)}"
        f" terminals, {len(report.rules)} rules, {report.n_semantic_rules} semantic rules"
    )
    for start in report.starts:
        whom = f" ({start.team})" if start.team else ""
        kind = "not LR(1)" if start.conflicts else f"LR(1), {start.n_states} states"
        typer.echo(f"{start.symbol}{whom}: {kind}")
        for conflict in start.conflicts:
            typer.echo(f"    {conflict.describe(grammar.grammar)}")
        if start.empty:
            typer.echo(
                "    can derive the empty string, but every player on court needs at least "
                "one action"
            )
    typer.echo(f"can be empty: {', '.join(report.nullable) or 'nothing'}")
    typer.echo(f"useless: {', '.join(report.useless) or 'nothing'}")
    _print_clips(clips, report.terminals)


def _report_facts(
    grammar: MotionGrammar,
    report: GrammarReport,
    clips: Mapping[str, Sequence[ShownAction]] | None,
) -> dict[str, Any]:
    rules = grammar.grammar
    facts: dict[str, Any] = {
        "name": report.name,
        "nonterminals": report.nonterminals,
        "terminals": report.terminals,
        "rules": report.rules,
        "semantic_rules": report.n_semantic_rules,
        "useless": report.useless,
        "nullable": report.nullable,
        "starts": [
            {
                "symbol": start.symbol,
                "team": start.team,
                "can_be_empty": start.empty,
                "lr1": not start.conflicts,
                "lr1_states": start.n_states,
                "conflicts": [c.describe(rules) for c in start.conflicts],
            }
            for start in report.starts
        ],
    }
    return facts | _clip_facts(clips, report.terminals)


def validate(
    file: GrammarFile,
    actions: Actions,
    start: StartSymbol = "",
    db: ClipsDb = None,
    json: Json = False,
) -> None:
    """Show the tree of a string of actions, or the fault and what was expected (exit 1)."""
    from motiondb import Scenes

    grammar = Scenes.read_grammar(file)
    validation = Scenes.validate(grammar, actions, start)
    clips = _clips(db, grammar)
    named = [name for name in dict.fromkeys(actions.split()) if name in grammar.terminal]
    if json:
        facts = {
            "allowed": validation.allowed,
            "start": validation.start,
            "tree": _tree_facts(validation.tree) if validation.tree else None,
            "trees": int(validation.n_trees) if math.isfinite(validation.n_trees) else None,
            "position": None if validation.allowed else validation.position,
            "expected": validation.expected,
            "message": validation.message,
        }
        print_json(facts | _clip_facts(clips, named))
    elif validation.tree:
        _print_tree(validation.tree)
        if validation.n_trees > 1:
            number = (
                int(validation.n_trees) if math.isfinite(validation.n_trees) else "endlessly many"
            )
            typer.echo(f"ambiguous: the most probable of {number} trees")
        _print_clips(clips, named)
    if not validation.allowed:
        if not json:
            typer.echo(f"{grammar.name}: {validation.message}", err=True)
        raise typer.Exit(1)


def _tree_facts(tree: Tree) -> str | list[Any]:
    return tree.symbol if tree.is_leaf else [tree.symbol, [_tree_facts(c) for c in tree.children]]


def _print_tree(tree: Tree) -> None:
    """Print one symbol per line, indented by its depth."""
    waiting = [(tree, 0)]
    while waiting:
        node, depth = waiting.pop()
        nothing = "  (nothing)" if not node.is_leaf and not node.children else ""
        typer.echo(f"{'  ' * depth}{node.symbol}{nothing}")
        waiting.extend((child, depth + 1) for child in reversed(node.children))


def suggest(
    file: GrammarFile,
    actions: Actions,
    start: StartSymbol = "",
    goals: Goals = None,
    db: ClipsDb = None,
    json: Json = False,
) -> None:
    """List the actions that may come next, with the probabilities of the grammar's rules.

    With --goal, show the shortest string that goes on from the actions and reaches the goals.
    """
    from motiondb import Scenes

    grammar = Scenes.read_grammar(file)
    if goals:
        _print_way(Scenes.plan(grammar, actions, goals, start), _clips(db, grammar), json)
        return
    suggestion = Scenes.suggest(grammar, actions, start)
    clips = _clips(db, grammar)
    names = [name for name, _ in suggestion.actions]
    if json:
        rows = [{"action": name, "probability": chance} for name, chance in suggestion.actions]
        print_json({"next": rows, "end": suggestion.end} | _clip_facts(clips, names))
        return
    rows_of_text = [[name, f"{chance:.3f}"] for name, chance in suggestion.actions]
    if suggestion.end:
        rows_of_text.append(["(the end)", f"{suggestion.end:.3f}"])
    print_table("", ["next", "probability"], rows_of_text)
    _print_clips(clips, names)


def _print_way(
    string: tuple[str, ...], clips: Mapping[str, Sequence[ShownAction]] | None, json: bool
) -> None:
    """Print the shortest string that reaches the goals."""
    names = list(dict.fromkeys(string))
    if json:
        print_json({"string": string} | _clip_facts(clips, names))
        return
    typer.echo(" ".join(string))
    _print_clips(clips, names)


def draw(
    file: Annotated[
        str, typer.Argument(metavar="DIAGRAM", help="A tactics file, or one like give-and-go.")
    ],
    out: Annotated[Path, typer.Option("--out", "-o", help="Draw into this PNG.")],
    db: ClipsDb = None,
    json: Json = False,
) -> None:
    """Draw a tactics diagram, and list the actions that it requires of each player."""
    from motiondb import Scenes

    text = Scenes.read_diagram(file)
    clips, diagram = _clips(db, text.grammar), text.diagram
    Scenes.draw_diagram(text, out)
    if json:
        players = [
            {
                "name": player.name,
                "team": player.team,
                "expression": text.expressions[player.name],
                "shortest": text.shortest[player.name],
                "opponent": diagram.opponent_of(player.name) or None,
            }
            for player in diagram.players
        ]
        facts = {"diagram": diagram.name, "grammar": text.grammar.name, "file": str(out)}
        more = {"ball": text.first_holder, "players": players}
        print_json(facts | more | _clip_facts(clips, text.actions))
        return
    ball = f"; {text.first_holder} has the ball at the start" if text.first_holder else ""
    typer.echo(f"{diagram.name} drawn to {out}{ball}")
    print_table(
        "",
        ["player", "team", "expression", "shortest string"],
        [
            [p.name, p.team, text.expressions[p.name], " ".join(text.shortest[p.name])]
            for p in diagram.players
        ],
    )
    _print_clips(clips, text.actions)


def _clips(
    path: Path | None, grammar: MotionGrammar, exact: bool = False
) -> Mapping[str, Sequence[ShownAction]] | None:
    """Return the clips of a database for every terminal, or None if no database is given."""
    if path is None:
        return None
    with database(path) as base:
        note_phrases(base.scenes, grammar, exact)
        return base.scenes.find_actions(grammar, exact)


def _clip_facts(
    clips: Mapping[str, Sequence[ShownAction]] | None, names: Sequence[str]
) -> dict[str, Any]:
    return {} if clips is None else {"clips": {name: len(clips[name]) for name in names}}


def _print_clips(clips: Mapping[str, Sequence[ShownAction]] | None, names: Sequence[str]) -> None:
    if clips is None:
        return
    typer.echo("clips: " + ", ".join(f"{name} {len(clips[name])}" for name in names))
    without = [name for name in names if not clips[name]]
    if without:
        typer.echo(f"no clips for {', '.join(without)}: caption captures that show them")
