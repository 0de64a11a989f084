"""scene: motion grammars and tactics diagrams; scenes themselves are in scene_making."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from motiondb.cli.options import Commands, Json, database, print_json, print_table
from motiondb.cli.scenes import scene_making

if TYPE_CHECKING:
    from motiondb.database.scenes.scene_clips import ShownAction
    from motiondb.grammar.cfg.context_free import Tree
    from motiondb.scene.language.motion_grammar import MotionGrammar
    from motiondb.scene.services.services import GrammarReport

GrammarFile = Annotated[
    str, typer.Argument(metavar="GRAMMAR", help="A grammar file, or basketball or carrying.")
]
Actions = Annotated[str, typer.Argument(help="Actions in their order, separated by spaces.")]
StartSymbol = Annotated[
    str, typer.Option("--start", help="The start symbol, such as S_D.  [default: any that fits]")
]
ClipsDb = Annotated[
    Path | None, typer.Option("--db", help="Also list the clips of this database for every action.")
]


def register(app: typer.Typer) -> None:
    """Add the commands to the app.

    Parameters
    ----------
    app : typer.Typer
        The app.
    """
    group = Commands(help="Scenes from motion grammars and tactics diagrams.", no_args_is_help=True)
    grammars = Commands(help="Grammars of motion.", no_args_is_help=True)
    grammars.command("check")(check_grammar)
    group.add_typer(grammars, name="grammar")
    group.command("validate")(validate)
    group.command("suggest")(suggest)
    group.command("draw")(draw)
    scene_making.register(group)
    app.add_typer(group, name="scene")


def check_grammar(file: GrammarFile, db: ClipsDb = None, json: Json = False) -> None:
    """Check a grammar: form, LR(1) conflicts, useless symbols, and clips in a database."""
    from motiondb.database.scenes.scene_files import read_grammar
    from motiondb.scene.services import services

    grammar = read_grammar(file)
    report = services.check(grammar)
    clips = _clips(db, grammar)
    if json:
        print_json(_report_facts(grammar, report, clips))
        return
    typer.echo(
        f"{report.name}: {len(report.nonterminals)} nonterminals, {len(report.terminals)}"
        f" terminals, {len(grammar.grammar.rules)} rules, {len(grammar.annotations)} semantic rules"
    )
    for start in report.starts:
        whom = f" ({start.team})" if start.team else ""
        lalr = "LALR(1)" if not start.lalr_conflicts else "not LALR(1)"
        kind = f"LR(1), {start.n_states} states, {lalr}" if not start.conflicts else "not LR(1)"
        ll1 = "LL(1)" if not start.ll1_conflicts else "not LL(1)"
        typer.echo(f"{start.symbol}{whom}: {kind}, {ll1}")
        for conflict in start.conflicts:
            typer.echo(f"    {conflict.describe(grammar.grammar)}")
        if start.empty:
            typer.echo("    can derive no action at all; every player on court needs at least one")
    typer.echo(f"can be empty: {', '.join(report.nullable) or 'nothing'}")
    typer.echo(f"useless: {', '.join(report.useless) or 'nothing'}")
    _print_clips(clips, [terminal.name for terminal in grammar.terminals])


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
        "rules": [str(rule) for rule in rules.rules],
        "semantic_rules": len(grammar.annotations),
        "useless": report.useless,
        "nullable": report.nullable,
        "starts": [
            {
                "symbol": start.symbol,
                "team": start.team,
                "can_be_empty": start.empty,
                "lr1": not start.conflicts,
                "lr1_states": start.n_states,
                "lalr1": not start.lalr_conflicts,
                "ll1": not start.ll1_conflicts,
                "conflicts": [c.describe(rules) for c in start.conflicts],
                "ll1_conflicts": [c.describe(rules) for c in start.ll1_conflicts],
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
    from motiondb.database.scenes.scene_files import read_grammar
    from motiondb.scene.services import services

    grammar = read_grammar(file)
    found = services.validate(grammar, actions.split(), start)
    clips = _clips(db, grammar)
    named = [name for name in dict.fromkeys(actions.split()) if name in grammar.terminal]
    if json:
        facts = {
            "allowed": found.allowed,
            "start": found.start,
            "tree": _tree_facts(found.tree) if found.tree else None,
            "position": None if found.allowed else found.position,
            "expected": found.expected,
            "message": found.message,
        }
        print_json(facts | _clip_facts(clips, named))
    elif found.tree:
        _print_tree(found.tree)
        _print_clips(clips, named)
    if not found.allowed:
        if not json:
            typer.echo(f"{grammar.name}: {found.message}", err=True)
        raise typer.Exit(1)


def _tree_facts(tree: Tree) -> str | list[Any]:
    return tree.symbol if tree.is_leaf else [tree.symbol, [_tree_facts(c) for c in tree.children]]


def _print_tree(tree: Tree) -> None:
    """Print one symbol a line, indented by its depth."""
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
    db: ClipsDb = None,
    json: Json = False,
) -> None:
    """List the actions that may come next, with the probabilities of the grammar's rules."""
    from motiondb.database.scenes.scene_files import read_grammar
    from motiondb.scene.services import services

    grammar = read_grammar(file)
    found = services.suggest(grammar, actions.split(), start)
    clips = _clips(db, grammar)
    names = [name for name, _ in found.actions]
    if json:
        rows = [{"action": name, "probability": chance} for name, chance in found.actions]
        print_json({"next": rows, "end": found.end} | _clip_facts(clips, names))
        return
    rows_of_text = [[name, f"{chance:.3f}"] for name, chance in found.actions]
    if found.end:
        rows_of_text.append(["(the end)", f"{found.end:.3f}"])
    print_table("", ["next", "probability"], rows_of_text)
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
    from motiondb import pictures
    from motiondb.database.scenes.scene_files import grammar_of, read_tactics
    from motiondb.scene.language import expressions, possession
    from motiondb.scene.services import services

    diagram = read_tactics(file)
    grammar = grammar_of(diagram, file)
    trees = services.cast(diagram, grammar, file)
    strings = {name: tree.leaves() for name, tree in trees.items()}
    asked = expressions.expressions(diagram)
    clips = _clips(db, grammar)
    pictures.draw_tactics(diagram, out)
    names = list(dict.fromkeys(a for row in asked.values() for item in row for a in item.actions))
    holder = possession.first_holder(diagram)
    if json:
        players = [
            {
                "name": player.name,
                "team": player.team,
                "expression": "".join(str(item) for item in asked[player.name]),
                "shortest": strings[player.name],
                "opponent": diagram.opponent_of(player.name) or None,
            }
            for player in diagram.players
        ]
        facts = {"diagram": diagram.name, "grammar": grammar.name, "file": str(out)}
        print_json(facts | {"ball": holder, "players": players} | _clip_facts(clips, names))
        return
    ball = f"; the ball is with {holder} at first" if holder else ""
    typer.echo(f"{diagram.name} drawn to {out}{ball}")
    print_table(
        "",
        ["player", "team", "expression", "shortest string"],
        [
            [p.name, p.team, "".join(map(str, asked[p.name])), " ".join(strings[p.name])]
            for p in diagram.players
        ],
    )
    _print_clips(clips, names)


def _clips(path: Path | None, grammar: MotionGrammar) -> Mapping[str, Sequence[ShownAction]] | None:
    """Return the clips of a database for every terminal, or None if no database is given."""
    if path is None:
        return None
    with database(path) as base:
        return base.scenes.find_actions(grammar)


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
