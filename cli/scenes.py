"""Commands of scenes: check grammars, validate, suggest and draw; make, update, report, list."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

import motiondb
from motiondb import answers
from motiondb.cli import options, printing

app = options.Commands()
group = app.group("scene", "Scenes from motion grammars and tactics diagrams.")
grammars = group.group("grammar", "Grammars of motion.")

GrammarFile = Annotated[
    str, options.argument("A grammar file, or the name of a shipped one.", "GRAMMAR")
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
    """Check a grammar: form, ambiguity, useless symbols, and clips in a database."""
    grammar = motiondb.Scenes.read_grammar(file)
    report = motiondb.Scenes.check_grammar(grammar)
    clips = _clips(shared, grammar, exact)
    with shared.database() as base:  # the nearest words for terminals without clips
        nearest = None if base is None else base.scenes.nearest_words(grammar)
    starts = [
        answers.extended(
            answers.StartSymbol,
            start,
            can_be_empty=start.empty,
            strings=start.n_strings,
            ambiguous=" ".join(start.ambiguous),
            trees=int(start.n_trees) if math.isfinite(start.n_trees) else None,
        )
        for start in report.starts
    ]
    checked = answers.extended(
        answers.CheckedGrammar,
        report,
        semantic_rules=report.n_semantic_rules,
        starts=starts,
        verbs=tuple(grammar.activity.verbs),
        clips=_number(clips, report.terminals),
        nearest=nearest,
    )
    if printing.as_json(shared, checked):
        return
    printing.say(
        f"{report.name}: {len(report.nonterminals)} nonterminals, {len(report.terminals)}"
        f" terminals, {len(report.rules)} rules, {report.n_semantic_rules} semantic rules"
    )
    for start in starts:
        whom = f" ({start.team})" if start.team else ""
        kind = f"one tree for each of its {start.strings} most probable strings"
        if start.ambiguous:
            kind = f"ambiguous, '{start.ambiguous}' has {start.trees or 'endlessly many'} trees"
        printing.say(f"{start.symbol}{whom}: {kind}")
        if start.can_be_empty:
            printing.say("    can be the empty string, but every player needs at least one action")
    printing.say(f"can be empty: {', '.join(report.nullable) or 'nothing'}")
    printing.say(f"useless: {', '.join(report.useless) or 'nothing'}")
    printing.say(f"verbs of diagrams: {', '.join(checked.verbs)}")
    _print_clips(clips, report.terminals)
    for name, near in (checked.nearest or {}).items():
        printing.say(f"nearest to {name}: {', '.join(near) or 'no word of a caption'}")


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
            printing.say(
                f"ambiguous: the most probable of {answer.trees or 'endlessly many'} trees"
            )
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
        answers.extended(
            answers.DiagramPlayer,
            player,
            expression=text.expressions[player.name],
            shortest=text.shortest[player.name],
            opponent=diagram.opponent_of(player.name) or None,
        )
        for player in diagram.players
    ]
    holder, counts = text.first_holder, _number(clips, text.actions)
    drawn = answers.DrawnDiagram(diagram.name, text.grammar.name, str(out), holder, players, counts)
    if printing.as_json(shared, drawn):
        return
    thing = text.grammar.activity.thing
    ball = f"; {holder} has the {thing.name} at the start" if holder and thing else ""
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


Folder = Annotated[Path, options.option("The folder to write.", "--out", "-o")]
Rounds = Annotated[
    int,
    options.option(
        "Largest number of rounds of sampling; the seed then determines the scene.",
        min=1,
        max=1_000_000,
    ),
]
Minutes = Annotated[
    float | None,
    options.option(
        "Stop sampling after this time, and print a note. [default: no limit]",
        min=0.0001,
        max=10_000.0,
    ),
]
Chains = Annotated[int, "Number of Markov chains, of which the best is kept, 1 to 64."]
Name = Annotated[str, "Also keep it in the database, with its motions as NAME/PLAYER."]
Gaze = Annotated[bool, options.option("Whether heads follow the object.", "--gaze/--no-gaze")]
Drawn = Annotated[
    bool, options.option("Draw paths.png, above.gif and scene.gif.", "--pictures/--no-pictures")
]
Place = Annotated[
    str, options.argument("The folder of a scene, or the name of a kept scene.", "SCENE")
]


@group.command()
def make(
    shared: options.Shared,
    file: options.DiagramFile,
    out: Folder,
    seed: options.Seed = 0,
    rounds: Rounds = 70,
    minutes: Minutes = None,
    chains: Chains = 4,
    name: Name = "",
    gaze: Gaze = True,
    exact: options.Exact = False,
    drawn: Drawn = True,
    html: options.Html = None,
) -> None:
    """Make an animated scene from a tactics diagram, with a report of every rule's error."""
    settings = motiondb.SceneSettings(seed, chains, rounds, minutes, gaze=gaze, exact=exact)
    motiondb.Scenes.check_folder(out)
    began = time.monotonic()
    with (
        shared.database(writing=bool(name)) as base,
        printing.scene_progress(shared) as tell,
    ):
        text = base.scenes.read_diagram(file)
        if name:
            base.scenes.check_new(name, text, settings)
        taken = {} if exact else base.scenes.taken_words(text.grammar)
        printing.note_taken(taken.values(), text.grammar.name)
        scene = base.scenes.make(file, settings, tell, name)
        base.scenes.write(scene, out, tell, drawn, kept=bool(name))
        if html:
            printing.write_html(html, motiondb.StandalonePage.of_scene(scene, shared.db.name))
    _print(shared, scene, out, time.monotonic() - began)
    _refuse_impossible(scene.record)


@group.command()
def update(
    shared: options.Shared,
    folder: Annotated[Path, options.argument("The folder of a scene.", "DIR")],
    file: options.DiagramFile,
    seed: Annotated[
        int | None, options.option("A seed other than the scene's.", min=0, max=2**63 - 1)
    ] = None,
    minutes: Minutes = None,
    name: Name = "",
    drawn: Drawn = True,
) -> None:
    """Make the scene of a folder again for a changed diagram, starting from its present state."""
    began = time.monotonic()
    with (
        shared.database(writing=bool(name)) as base,
        printing.scene_progress(shared) as tell,
    ):
        earlier = base.scenes.find(folder)
        base.scenes.check_folder(folder)
        if name:
            base.scenes.check_name(name, base.scenes.read_diagram(file).diagram.player)
        settings = replace(motiondb.SceneSettings(**earlier.settings), minutes=minutes)
        settings = settings if seed is None else replace(settings, seed=seed)
        earlier = replace(earlier, name=name) if name else earlier
        scene = base.scenes.update(earlier, file, settings, tell)
        base.scenes.write(scene, folder, tell, drawn, kept=bool(name))
    _print(shared, scene, folder, time.monotonic() - began)
    _refuse_impossible(scene.record)


def _print(shared: options.Shared, scene: motiondb.Scene, folder: Path, seconds: float) -> None:
    facts = motiondb.Scenes.facts(scene.record)
    work = {what: round(took, 3) for what, took in scene.made.seconds.items()}
    took = work | {"all": round(seconds, 3)}
    if printing.as_json(shared, facts, folder=folder, took=took):
        return
    printing.say(
        f"{scene.record.name}: {facts.characters} characters, {facts.clips} clips,"
        f" {facts.frames} frames ({facts.seconds:.1f} s), in {folder}"
    )
    parts = ", ".join(f"{what} {time:.1f} s" for what, time in work.items())
    printing.say(f"error {facts.error:.2f} before polish; {parts}")
    touching = len(facts.collisions)
    for line in motiondb.Scenes.seen(scene.record):
        printing.say(line)
    printing.say(
        f"rules kept: {facts.rules - facts.broken} of {facts.rules};"
        f" collisions: {touching or 'none'}"
    )
    for line in motiondb.Scenes.remarks(scene.record):
        printing.say(line)
    if facts.too_fast:
        printing.say(f"  faster than people can move: {', '.join(facts.too_fast)}")
    for rule in scene.broken:
        place = f" at {rule.action} ({rule.clip + 1})" * bool(rule.action)
        printing.say(
            f"  broken: {rule.kind} of {rule.player}{place}, about {rule.about}:"
            f" {rule.after:.2f} {rule.unit} where {rule.threshold:.2f} is allowed"
        )


def _refuse_impossible(record: motiondb.StoredScene) -> None:
    """Exit with 1 if a scene has motion that people cannot do; its frames are in the output."""
    if record.report.get("impossible"):
        raise typer.Exit(1)


@group.command()
def report(shared: options.Shared, place: Place, png: options.Png = None) -> None:
    """Report how well a scene keeps each rule, collisions, and the sources of its motion."""
    if motiondb.Scenes.is_folder(place):
        record = motiondb.Scenes.read_folder(place)
        if png:
            motiondb.Scenes.draw_folder(place, png)
    else:
        with shared.database() as base:
            record = base.scenes.load(place)
            if png:
                base.scenes.draw(place, png)
    drawn = {"picture": png} if png else {}
    if not printing.as_json(shared, motiondb.Scenes.facts(record), **drawn):
        printing.say(*motiondb.Scenes.report(record).split("\n"))
    _refuse_impossible(record)


@group.command("list")
def list_scenes(shared: options.Shared) -> None:
    """List the scenes that are kept in the database."""
    with shared.database() as base:
        facts = [base.scenes.facts(base.scenes.load(name)) for name in base.scenes.names()]
    if printing.as_json(shared, map(motiondb.scene_row, facts)):
        return
    if not facts:
        printing.say("no scenes; motiondb scene make DIAGRAM -o FOLDER --name NAME keeps one")
        return
    printing.print_table(
        ["scene", "characters", "clips", "seconds", "error", "broken rules"],
        [
            [f.scene, f.characters, f.clips, f"{f.seconds:.1f}", f"{f.error:.2f}", f.broken]
            for f in facts
        ],
    )


@group.command()
def remove(
    shared: options.Shared,
    name: Annotated[str, options.argument("The name of a kept scene.", "NAME")],
) -> None:
    """Remove a kept scene and its players' motions from the database; folders stay."""
    with shared.database(writing=True) as base:
        captures = base.scenes.remove(name)
    if not printing.as_json(shared, answers.Removed(name, captures)):
        printing.say(f"removed {name} with {', '.join(captures) or 'no captures'}")
