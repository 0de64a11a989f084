"""What the verbs of grammars change in what must be in a database.

An edit of a grammar keeps what was before it, so that edits are taken back one after the other:
then the grammar must be exactly the earlier one, and derive the sequences that it derived, found by
their content.
"""

from __future__ import annotations

from robustness_tasks.plain_world import ANY, Arguments, Kept, RefusedError, World


def learn(world: World, given: Arguments, _by: str) -> None:
    """A grammar replaces that of its name; what the earlier one derived can no longer be edited."""
    for name in given["captures"]:
        world.only(name)
    _begin(world, given["name"])
    world.grammars[given["name"]] = ANY


def remove(world: World, given: Arguments, _by: str) -> None:
    """A grammar goes with its edits."""
    _only(world, given["name"])
    del world.grammars[given["name"]]
    _begin(world, given["name"])


def _begin(world: World, name: str) -> None:
    """Nothing is left of a grammar of this name."""
    world.sequences = {c: by for c, by in world.sequences.items() if by != name}
    world.grammar_edits.pop(name, None)
    world.renew("grammar", name)


def _only(world: World, name: str) -> None:
    if name not in world.grammars:
        raise RefusedError


def save_sequence(world: World, given: Arguments, _by: str) -> None:
    """A new capture, which the grammar derives."""
    _only(world, given["grammar"])
    if given["name"] in world.captures:
        raise RefusedError
    world.captures[given["name"]] = Kept("generated", ANY, ANY, ANY)
    world.sequences[given["name"]] = given["grammar"]


def edit_rules(world: World, given: Arguments, by: str) -> None:
    """Other rules; more of them derive what they did, flat ones possibly less."""
    rename_terminal(world, given, by)
    if given["how"] == "flat" and world.derived_by(given["name"]):
        world.loose.add(given["name"])


def rename_terminal(world: World, given: Arguments, _by: str) -> None:
    """Another version of the grammar, which derives the same."""
    name = given["name"]
    _only(world, name)
    derived = frozenset(world.captures[capture].digest for capture in world.derived_by(name))
    world.grammar_edits.setdefault(name, []).append((world.grammars[name], derived))
    world.grammars[name] = ANY
    world.renew("grammar", name)


def undo_edit(world: World, given: Arguments, _by: str) -> None:
    """The grammar before the edit, and what it derived; it may derive what was saved since."""
    name = str(given["name"])
    _only(world, name)
    if not world.grammar_edits.get(name):
        raise RefusedError
    world.grammars[name], digests = world.grammar_edits[name].pop()
    since = world.derived_by(name)
    back = {
        capture
        for capture, kept in world.captures.items()
        if kept.digest in digests and world.sequences.get(capture, name) == name
    }
    if ANY in digests or not since <= back:
        world.loose.add(name)
    world.sequences |= dict.fromkeys(back, name)
    world.renew("grammar", name)
