"""What every verb changes in what must be in a database.

A change of the database is a function of a :class:`World` and the verb's arguments. It changes the
world, or raises :class:`RefusedError` where the database must refuse. What a model so small cannot
foresee, such as the rules of a learned grammar, is :data:`ANY` after the change: the next look into
the database says what it is, and from then on it must stay so.

A verb that was interrupted may have happened or not, and two that ran at once in either order:
:func:`futures` gives all worlds that may then be.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import permutations, product
from types import MappingProxyType

from robustness_tasks import plain_grammars
from robustness_tasks.plain_world import (
    ANY,
    SYNONYMS,
    Arguments,
    Change,
    Kept,
    RefusedError,
    Removed,
    World,
)

DONE, REFUSED, UNKNOWN = "done", "refused", "unknown"


@dataclass(frozen=True)
class Step:
    """A verb with its arguments, and how it ended: done, refused or (interrupted) unknown."""

    verb: str
    arguments: Arguments
    ended: str
    by: str = ""  # who did it
    message: str = ""  # why it was refused


def futures(world: World, steps: Sequence[Step], undisturbed: bool) -> Iterator[World]:
    """All worlds that may be after steps that ran at once.

    `undisturbed`: whether a refusal that the model does not foresee is a fault.
    """
    steps = [part for step in steps for part in _by_file(step)]
    for meant in product(*(_meanings(world, step, len(steps) > 1) for step in steps)):
        for order in permutations(meant):
            ends = ((False, True) if step.ended == UNKNOWN else (None,) for step in order)
            for happened in product(*ends):
                later = world.copy()
                if all(_allows(later, s, h, undisturbed) for s, h in zip(order, happened)):
                    yield later


def _meanings(world: World, step: Step, at_once: bool) -> list[Step]:
    """What a step may mean: changes may be counted back before the other step, or after it."""
    back = step.arguments["back"] if step.verb == "undo" and at_once else 0
    if not back or len(world.history) < back:
        return [step]
    change = world.history[-back].serial
    return [step, replace(step, arguments={**step.arguments, "change": change})]


def _by_file(step: Step) -> list[Step]:
    """An interrupted step that writes several files as one step for each, since each is whole."""
    if step.ended != UNKNOWN or "files" not in step.arguments or step.verb == "add":
        return [step]
    return [
        replace(step, arguments={**step.arguments, "files": [file]})
        for file in step.arguments["files"]
    ]


def _allows(world: World, step: Step, happened: bool | None, undisturbed: bool) -> bool:
    """Whether a step may have ended as it did; changes the world if it happened."""
    change, before = CHANGES[step.verb], world.copy()
    is_optional = step.verb in MAY_REFUSE or not undisturbed
    if step.verb in ("ask", "export matches"):
        is_optional = not undisturbed or not _is_said(world, step.arguments["words"])
    is_optional |= (
        step.verb in ("rescue", "compact") and world == World()
    )  # there may be no file yet
    try:
        change(world, step.arguments, step.by)
        world.remember(step.verb, before)
        if step.by == "server" and step.verb in OF_PAGE and world.latest > before.latest:
            world.edits.append(world.latest)
        is_refused = False
    except RefusedError:
        vars(world).update(vars(before))
        is_refused = True
    if step.ended == DONE or happened:
        return not is_refused
    vars(world).update(vars(before))
    is_edit = step.verb == "undo" and step.by == "server" and bool(world.edits)
    if is_edit and step.ended == REFUSED and is_refused:
        world.edits.pop()  # an edit that cannot be undone is forgotten
    return step.ended != REFUSED or is_refused or is_optional


def _is_said(world: World, word: str) -> bool:
    """Whether a word was learned, and a caption of a capture still has it."""
    captured = [kept for kept in world.captures.values() if kept.kind == "captured"]
    said = [words for kept in captured if not isinstance(kept.captions, str)
            for words, _, _ in kept.captions]  # fmt: skip
    return word in (world.vocabulary or ()) and any(word in words for words in said)


def _ask(world: World, given: Arguments, _by: str) -> None:
    if world.vocabulary is None:
        raise RefusedError
    world.only(given["name"])


def _export_matches(world: World, _given: Arguments, _by: str) -> None:
    if world.vocabulary is None:
        raise RefusedError


def _add(world: World, given: Arguments, _by: str) -> None:
    """Captures whose content is new; files of a name that is taken are reported and left out."""
    digests = {kept.digest for kept in world.captures.values()}
    for name, digest, seconds in sorted(given["files"]):
        if digest not in digests and name not in world.captures:
            digests.add(digest)
            row = given["sheet"].get(name, ((), {}))
            captions = tuple(c for c in row[0] if c[1] is None or c[1] < seconds)
            world.captures[name] = Kept(
                "captured", digest, dict(row[1]), captions, given["events"].get(name, ())
            )


def _remove(world: World, given: Arguments, _by: str) -> None:
    for name in [world.full(name) for name in given["names"]]:
        _remove_one(world, name)


def _remove_one(world: World, name: str) -> None:
    """A capture goes, with the derivation of a sequence; players of scenes lose their motion."""
    kept, grammar = world.captures.pop(name), world.sequences.pop(name, None)
    derived = (grammar, world.versions.get(("grammar", grammar), 0)) if grammar else None
    plays = tuple(
        (scene, world.versions.get(("scene", scene), 0), number)
        for scene, players in world.scenes.items()
        for number, player in enumerate(players)
        if player == name
    )
    world.trash[kept.number] = Removed(name, kept, derived, plays)
    for players in world.scenes.values():
        players[:] = [None if player == name else player for player in players]


def _set_words(world: World, given: Arguments, by: str) -> None:
    kept = world.only(given["name"])
    new = (given["words"], given["start"], given["end"])
    _set_captions(
        world,
        {"name": given["name"], "captions": (*(kept.captions if given["keep"] else ()), new)},
        by,
    )


def _set_captions(world: World, given: Arguments, _by: str) -> None:
    kept = world.only(given["name"])
    for words, start, end in given["captions"]:
        if not words.strip() or (start or 0.0) >= (0.3 if end is None else end) or (end or 0) > 9.0:
            raise RefusedError
    kept.captions = tuple(given["captions"])


def _add_words(world: World, given: Arguments, _by: str) -> None:
    """A caption more where it is not there yet."""
    for name in [world.full(name) for name in given["names"]]:
        kept = world.captures[name]
        new = (given["words"], None, None)
        if isinstance(kept.captions, tuple) and new not in kept.captions:
            kept.captions = (*kept.captions, new)


def _undo(world: World, given: Arguments, by: str) -> None:
    """The latest change that stands, the one so many changes back, or the server's latest edit."""
    undone = set[int]()
    for change in reversed(world.history):
        if change.undoes and change.serial not in undone:
            undone.add(change.undoes)
    if by == "server":
        wanted = {world.edits.pop()} if world.edits else set()
    elif "change" in given:
        wanted = {given["change"]}
    elif given["back"]:
        wanted = {change.serial for change in world.history[-given["back"] :][:1]}
        wanted = wanted if len(world.history) >= given["back"] else set()
    else:
        standing = [c for c in world.history if not c.undoes and c.serial not in undone]
        wanted = {c.serial for c in [c for c in standing if c.verb in UNDOABLE][-1:]}
    found = [c for c in world.history if c.serial in wanted]
    if not found or found[0].verb not in UNDOABLE or found[0].serial in undone:
        raise RefusedError
    change = found[0]
    for later in world.history:
        counts = later.serial not in undone and later.undoes <= change.serial
        if later.serial > change.serial and counts and {*later.before} & {*change.before}:
            raise RefusedError
    _take_back(world, change)
    world.undoes = change.serial


def _take_back(world: World, change: Change) -> None:
    """Bring the captures that a run changed back into the state before."""
    names = {kept.number: name for name, kept in world.captures.items()}
    for number, before in change.before.items():
        if before is None:
            _remove_one(world, names[number])
    back = {}
    for number, before in change.before.items():
        if number == SYNONYMS and before is not None:
            world.synonyms = dict(before[1].tags)  # type: ignore[arg-type]  # no ANY in synonyms
        elif before is not None and number not in change.removed:
            kept = world.captures.pop(names[number])
            old = before[1]
            back[before[0]] = replace(kept, tags=old.tags, captions=old.captions, events=old.events)
            _rename_uses(world, {names[number]: before[0]})
    for number in change.removed:
        if number not in world.trash:
            raise RefusedError
    for name in back:
        if name in world.captures:
            raise RefusedError
    world.captures |= back
    for number in sorted(change.removed):
        _restore(world, number)


def _restore(world: World, number: int) -> None:
    """Take a capture out of the trash, with its derivation and its part in a scene."""
    removed = world.trash.pop(number)
    digests = {kept.digest for kept in world.captures.values()}
    if removed.name in world.captures or removed.kept.digest in digests:
        raise RefusedError
    world.captures[removed.name] = removed.kept
    if removed.derived:
        grammar, version = removed.derived
        if grammar in world.grammars and version == world.versions.get(("grammar", grammar), 0):
            world.sequences[removed.name] = grammar
    for scene, version, player in removed.players:
        if scene in world.scenes and version == world.versions.get(("scene", scene), 0):
            world.scenes[scene][player] = removed.name


def _rename(world: World, given: Arguments, _by: str) -> None:
    """A capture, or all of a folder; a new name must be free."""
    old, new = given["old"], given["new"]
    if old.endswith("/"):
        names = {n: new + n.removeprefix(old) for n in world.captures if n.startswith(old)}
    else:
        names = {world.full(old): new}
    if not names or any(n in world.captures and n not in names for n in names.values()):
        raise RefusedError
    world.captures = {names.get(name, name): kept for name, kept in world.captures.items()}
    _rename_uses(world, names)


def _rename_uses(world: World, names: Mapping[str, str]) -> None:
    """Name captures anew where sequences and scenes refer to them."""
    world.sequences = {names.get(name, name): by for name, by in world.sequences.items()}
    for players in world.scenes.values():
        players[:] = [names.get(player, player) if player else None for player in players]


def _set_tags(world: World, given: Arguments, _by: str) -> None:
    for name in [world.full(name) for name in given["names"]]:
        kept = world.captures[name]
        if isinstance(kept.tags, dict):
            kept.tags = {k: v for k, v in {**kept.tags, **given["tags"]}.items() if v}


def _merge(world: World, given: Arguments, _by: str) -> None:
    """New content comes, by a free name; what is there gets the words, tags, events it lacks."""
    here = {kept.digest: kept for kept in world.captures.values()}
    for name, other in given["other"].items():
        if (kept := here.get(other.digest)) is not None:
            kept.captions = tuple(dict.fromkeys((*kept.captions, *other.captions)))
            kept.events = tuple(sorted({*kept.events, *other.events}))
            kept.tags = {**other.tags, **kept.tags}  # type: ignore[dict-item]
        elif given["prefix"] + name not in world.captures:
            world.captures[given["prefix"] + name] = replace(other, number=0)


def _compact(world: World, _given: Arguments, _by: str) -> None:
    world.trash.clear()


def _write_parts(world: World, given: Arguments, _by: str) -> None:
    world.only(given["name"])
    for file in given["files"]:
        world.files[file] = ANY


def _write(world: World, given: Arguments, _by: str) -> None:
    for file in given["files"]:
        world.files[file] = ANY


def _import_words(world: World, given: Arguments, _by: str) -> None:
    for name, (captions, tags) in given["sheet"].items():
        if name in world.captures:
            kept = world.captures[name]
            kept.captions = tuple(captions) or kept.captions
            if isinstance(kept.tags, dict):
                kept.tags = {**kept.tags, **tags}


def _import_events(world: World, given: Arguments, _by: str) -> None:
    for name, events in given["events"].items():
        if name in world.captures:
            world.captures[name].events = tuple(sorted(set(events)))


def _set_synonyms(world: World, given: Arguments, _by: str) -> None:
    world.synonyms = dict(given["table"])


def _learn(world: World, _given: Arguments, _by: str) -> None:
    if not any(kept.kind == "captured" for kept in world.captures.values()):
        raise RefusedError
    world.vocabulary = ANY


def _save_generated(world: World, given: Arguments, _by: str) -> None:
    if world.vocabulary is None or given["name"] in world.captures:
        raise RefusedError
    captions = ((given["words"], None, None),)
    world.captures[given["name"]] = Kept("generated", ANY, ANY, captions)


def _keep_scene(world: World, given: Arguments, _by: str) -> None:
    """A scene replaces that of its name, with the captures of its players.

    There is one scene to keep, and no content is kept twice: not while other captures have it.
    """
    name = given["name"]
    own = set(world.scenes.get(name, ()))
    if any(k.number in world.players and n not in own for n, k in world.captures.items()):
        raise RefusedError
    if name in world.scenes:
        before = world.copy()
        _remove_scene(world, given, "")
        world.remember("remove scene", before)
    captures = [f"{name}/{player}" for player in given["players"]]
    if set(captures) & set(world.captures):
        raise RefusedError
    for capture in captures:
        world.captures[capture] = Kept("generated", ANY, ANY, ANY)
    world.scenes[name] = list(captures)


def _remove_scene(world: World, given: Arguments, _by: str) -> None:
    if given["name"] not in world.scenes:
        raise RefusedError
    for capture in filter(None, world.scenes.pop(given["name"])):
        _remove_one(world, capture)
    world.renew("scene", given["name"])


def _export(world: World, given: Arguments, _by: str) -> None:
    kept = world.only(given["name"])
    for file in given["files"]:
        world.files[file] = kept.digest if file.endswith(".bvh") else ANY


def _write_learned(world: World, given: Arguments, _by: str) -> None:
    if world.vocabulary is None:
        raise RefusedError
    for file in given["files"]:
        world.files[file] = ANY


def _ask_one(world: World, given: Arguments, _by: str) -> None:
    world.only(given["name"])


def _ask_scene(world: World, given: Arguments, _by: str) -> None:
    if given["name"] not in world.scenes:
        raise RefusedError


def _nothing(_world: World, _given: Arguments, _by: str) -> None:
    pass


CHANGES: Mapping[str, Callable[[World, Arguments, str], None]] = MappingProxyType(
    {
        "add": _add,
        "remove": _remove,
        "set words": _set_words,
        "add words": _add_words,
        "set captions": _set_captions,
        "undo": _undo,
        "import words": _import_words,
        "import events": _import_events,
        "set synonyms": _set_synonyms,
        "learn": _learn,
        "save generated": _save_generated,
        "learn grammar": plain_grammars.learn,
        "remove grammar": plain_grammars.remove,
        "edit rules": plain_grammars.edit_rules,
        "rename terminal": plain_grammars.rename_terminal,
        "undo edit": plain_grammars.undo_edit,
        "save sequence": plain_grammars.save_sequence,
        "keep scene": _keep_scene,
        "remove scene": _remove_scene,
        "export": _export,
        "write generated": _write_learned,
        "export knowledge": _write_learned,
        "export matches": _export_matches,
        "show": _ask_one,
        "list": _nothing,
        "ask": _ask,
        "ask grammar": _nothing,
        "ask scene": _ask_scene,
        "rename": _rename,
        "set tags": _set_tags,
        "merge": _merge,
        "join": _write_parts,
        "export words": _write,
        "backup": _write,
        "compact": _compact,
        "rescue": _nothing,
    }
)
"""Verb -> what it changes in the world."""
UNDOABLE = frozenset(
    {"add", "remove", "rename", "set words", "set captions", "add words", "import words",
     "set tags",
     "import events", "merge", "save generated", "set synonyms", "undo", "words"}
)  # fmt: skip
"""Verbs that can be undone."""
OF_PAGE = frozenset({"set words", "set captions", "add words", "set tags", "rename", "remove"})
"""Verbs that the server takes back."""
MAY_REFUSE = frozenset(
    {"learn", "save generated", "learn grammar", "save sequence", "write generated", "ask",
     "export knowledge", "ask grammar"}
)  # fmt: skip
"""Verbs that may also be refused for reasons that the model does not know: too little to learn."""
