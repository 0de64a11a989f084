"""What must be in a database, as plain dictionaries, and where two such worlds differ."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

ANY = "?"
"""Stands for something that the model does not foresee."""
Arguments = Mapping[str, Any]
Words = tuple[str, float | None, float | None]
"""A caption: words, start and end in seconds."""

NOT_NOTED = frozenset({"save sequence", "keep scene"})
"""Verbs that change captures and of which no undoing is foreseen."""
KINDS = MappingProxyType(
    {
        "set words": "words", "set captions": "words", "add words": "words",
        "import words": "words",
        "set synonyms": "words", "set tags": "tags", "import events": "events",
        "save generated": "generate", "remove scene": "scene remove",
    }
)  # fmt: skip
"""Verb -> kind of its run, where that has another name."""


class RefusedError(Exception):
    """The database must refuse the verb."""


@dataclass
class Kept:
    """A capture that must be there."""

    kind: str
    digest: str
    tags: dict[str, str] | str
    captions: tuple[Words, ...] | str = ()
    events: tuple[tuple[int, str], ...] = ()
    number: int = 0  # the same by whatever name; 0: not given yet


@dataclass(frozen=True)
class Change:
    """What a run changed in captures: number -> name and capture before, None if it was added.

    The synonyms are noted as the tags of the number SYNONYMS.
    """

    serial: int
    verb: str
    names: tuple[str, ...]  # of the captures: before the change, or of new ones
    before: Mapping[int, tuple[str, Kept] | None]
    removed: frozenset[int]
    undoes: int = 0  # serial of the run that it takes back


@dataclass(frozen=True)
class Removed:
    """A capture in the trash, with what may be restored beside it."""

    name: str
    kept: Kept
    derived: tuple[str, int] | None  # grammar and its version
    players: tuple[tuple[str, int, int], ...]  # scene, its version, player


SYNONYMS = -1


@dataclass
class World:
    """Everything that must be in the database, its history, and the edits of the server."""

    captures: dict[str, Kept] = field(default_factory=dict)
    synonyms: dict[str, str] = field(default_factory=dict)
    vocabulary: tuple[str, ...] | str | None = None  # None: it has not learned
    grammars: dict[str, str] = field(default_factory=dict)  # name -> digest
    # Grammar -> what was before each edit: its digest, and those of the sequences that it derived
    grammar_edits: dict[str, list[tuple[str, frozenset[str]]]] = field(default_factory=dict)
    loose: set[str] = field(default_factory=set)  # grammars of which the sequences are not foreseen
    sequences: dict[str, str] = field(default_factory=dict)  # capture -> grammar that derived it
    scenes: dict[str, list[str | None]] = field(default_factory=dict)  # name -> captures of players
    edits: list[int] = field(default_factory=list)  # serials of the server's changes of words
    history: list[Change] = field(default_factory=list)
    trash: dict[int, Removed] = field(default_factory=dict)
    versions: dict[tuple[str, str], int] = field(default_factory=dict)  # of grammars and scenes
    latest: int = 0  # serial of the latest run that changed captures
    numbers: int = 0  # given to captures so far
    players: set[int] = field(default_factory=set)  # numbers of captures that scenes brought
    undoes: int = 0  # serial of what the step under way takes back
    files: dict[str, str] = field(default_factory=dict)  # file that was written -> digest

    def copy(self) -> World:
        """A world that can be changed; records of what was are shared."""
        return replace(
            self,
            captures={name: replace(kept) for name, kept in self.captures.items()},
            synonyms=dict(self.synonyms),
            grammars=dict(self.grammars),
            grammar_edits={name: list(edits) for name, edits in self.grammar_edits.items()},
            loose=set(self.loose),
            sequences=dict(self.sequences),
            scenes={name: list(players) for name, players in self.scenes.items()},
            edits=list(self.edits),
            history=list(self.history),
            trash=dict(self.trash),
            versions=dict(self.versions),
            players=set(self.players),
            files=dict(self.files),
        )

    def derived_by(self, grammar: str) -> set[str]:
        """The captures that a grammar derived, and that can be edited."""
        return {capture for capture, by in self.sequences.items() if by == grammar}

    def renew(self, kind: str, name: str) -> None:
        """A grammar or scene is another one from now on, though it may have the name."""
        self.versions[kind, name] = self.versions.get((kind, name), 0) + 1

    def facts(self) -> dict[str, Any]:
        """What a look into the database must give."""
        grammars = {
            name: [digest, ANY if name in self.loose else sorted(self.derived_by(name))]
            for name, digest in self.grammars.items()
        }
        captures = {name: list(vars(kept).values())[:5] for name, kept in self.captures.items()}
        return {
            "captures": captures,
            "synonyms": self.synonyms,
            "vocabulary": self.vocabulary,
            "grammars": grammars,
            "scenes": self.scenes,
            "files": self.files,
            "trash": sorted(removed.name for removed in self.trash.values()),
            "history": [[KINDS.get(c.verb, c.verb), list(c.names)] for c in self.history],
        }

    def learn_from(self, seen: Mapping[str, Any]) -> None:
        """Take over what the model did not foresee."""
        for name, kept in self.captures.items():
            kept.digest, kept.tags, kept.captions = seen["captures"][name][1:4]
        self.vocabulary = seen["vocabulary"]
        self.grammars = {name: facts[0] for name, facts in seen["grammars"].items()}
        for name in self.loose & set(self.grammars):
            others = {c: by for c, by in self.sequences.items() if by != name}
            self.sequences = others | dict.fromkeys(seen["grammars"][name][1], name)
        self.loose = set()
        self.files = dict(seen["files"])

    def remember(self, verb: str, before: World) -> None:
        """Number new captures, and note what a verb changed in captures, for an undoing."""
        for kept in self.captures.values():
            if not kept.number:
                self.numbers += 1
                kept.number = self.numbers
                self.players |= {kept.number} if verb == "keep scene" else set()
        now = {kept.number: (name, kept) for name, kept in self.captures.items()}
        then = {kept.number: (name, kept) for name, kept in before.captures.items()}
        changed: dict[int, tuple[str, Kept] | None] = {
            number: then.get(number)
            for number in {*now, *then}
            if now.get(number) != then.get(number)
        }
        if self.synonyms != before.synonyms:
            changed[SYNONYMS] = ("synonyms", Kept("", "", dict(before.synonyms)))
        if not changed or verb in NOT_NOTED:
            return
        self.latest += 1
        removed = frozenset(then.keys() - now.keys())
        names = (old[0] if old else now[number][0] for number, old in changed.items())
        change = Change(self.latest, verb, tuple(sorted(names)), changed, removed, self.undoes)
        self.history.append(change)
        self.undoes = 0

    def full(self, name: str) -> str:
        """The whole name of a capture; its end behind a ``/`` says enough if no other ends so."""
        if name in self.captures:
            return name
        found = [known for known in self.captures if known.endswith(f"/{name}")]
        if len(found) != 1:
            raise RefusedError
        return found[0]

    def only(self, name: str) -> Kept:
        """The capture of a name."""
        return self.captures[self.full(name)]


def difference(expected: object, seen: object, where: str = "") -> str:
    """Where two nested values differ, "" if nowhere; ``ANY`` agrees with everything."""
    if isinstance(expected, str) and expected == ANY:
        return ""
    if isinstance(expected, dict) and isinstance(seen, dict):
        for key in sorted({*expected, *seen}):
            if key not in expected or key not in seen:
                return f"{where}/{key}: {'unexpected' if key in seen else 'missing'}"
            if told := difference(expected[key], seen[key], f"{where}/{key}"):
                return told
        return ""
    if isinstance(expected, (list, tuple)) and isinstance(seen, (list, tuple)):
        if len(expected) != len(seen):
            return f"{where}: expected {expected!r}, found {seen!r}"
        pairs = enumerate(zip(expected, seen))
        return next(filter(None, (difference(a, b, f"{where}/{n}") for n, (a, b) in pairs)), "")
    return "" if expected == seen else f"{where}: expected {expected!r}, found {seen!r}"
