"""Random verbs with random arguments, most of them such that the database can do them."""

from __future__ import annotations

import hashlib
import shutil
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from robustness_tasks.plain_model import CHANGES
from robustness_tasks.plain_world import Kept, Words, World

SAID = ("walk", "bow low", "jump, then kick", "kick", "wave", "a slow walk", "punch")
GRAMMARS, SCENES, OUT = ("moves", "steps"), ("play", "game"), "out"
NOBODY = "nobody"
"""A name that no capture has."""
SHORTEST = 0.5
"""Seconds of the shortest capture of the material."""


@dataclass(frozen=True)
class Material:
    """What steps are made of: tiny captures with their lengths, and players of a made scene."""

    folder: Path
    seconds: Mapping[str, float]  # name of the file, without ending
    players: tuple[str, ...] = ()  # empty: no scene was made
    other: Mapping[str, Kept] = field(default_factory=dict)  # captures of the database to merge

    def digest(self, name: str) -> str:
        """SHA-256 of a file's bytes."""
        return hashlib.sha256((self.folder / f"{name}.bvh").read_bytes()).hexdigest()


@dataclass(frozen=True)
class Chooser:
    """Chooses arguments for a world; files that a step reads are written into the place."""

    world: World
    rng: np.random.Generator
    place: Path
    material: Material
    number: int  # of the step

    def one(self, values: Iterable[Any]) -> Any:
        """One of the values."""
        values = list(values)
        return values[self.rng.integers(len(values))]

    def some(self, values: Iterable[Any], most: int) -> list[Any]:
        """One to ``most`` of the values, each at most once."""
        values = list(values)
        n = int(self.rng.integers(1, min(most, len(values)) + 1))
        return [values[k] for k in self.rng.permutation(len(values))[:n]]

    def capture(self) -> str:
        """The name of a capture, seldom one that nothing has."""
        names = sorted(self.world.captures)
        return self.one(names) if names and self.rng.random() < 0.96 else NOBODY

    def caption(self) -> Words:
        """Words about a capture or a part of it, seldom outside of it."""
        start, end = self.one(((None, None), (None, None), (0.1, None), (0.1, 0.4), (None, 0.3),
                               (50.0, 51.0)))  # fmt: skip
        return (self.one(SAID), start, end)

    def sheet(self, names: list[str]) -> tuple[str, dict[str, tuple[tuple[Words, ...], Any]]]:
        """A sheet of words, performers and licences, and what it says."""
        rows, said = ["file\twords\tstart\tend\tperformer\tlicence\tnote"], {}
        for name in names:
            captions = tuple(self.caption() for _ in range(self.rng.integers(0, 3)))
            captions = tuple(dict.fromkeys(c for c in captions if c[1] != 50.0))
            tags = {"performer": self.one(("ana", "boris"))}
            tags |= {"licence": "CC0-1.0"} if self.rng.random() < 0.5 else {}
            tags |= {"note": self.one(("a", "b"))} if self.rng.random() < 0.3 else {}
            for words, start, end in captions or (("", None, None),):
                cells = (
                    words,
                    start,
                    end,
                    *(tags.get(k) for k in ("performer", "licence", "note")),
                )
                rows.append("\t".join([name, *("" if c is None else str(c) for c in cells)]))
            said[name] = (captions, tags)
        return self.written("words.tsv", "\n".join(rows) + "\n"), said

    def events(self, names: list[str]) -> tuple[str, dict[str, tuple[tuple[int, str], ...]]]:
        """A sheet of events, and what it says."""
        rows, said = ["file\tframe\tevent"], {}
        for name in names:
            found = {(int(self.rng.integers(0, 12)), self.one(("foot_strike", "contact")))
                     for _ in range(2)}  # fmt: skip
            rows += [f"{name}\t{frame}\t{event}" for frame, event in sorted(found)]
            said[name] = tuple(sorted(found))
        return self.written("events.tsv", "\n".join(rows) + "\n"), said

    def written(self, name: str, text: str) -> str:
        """The path, below the place, of a text that is written there."""
        path = self.place / "given" / str(self.number) / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        return path.relative_to(self.place).as_posix()


def _add(of: Chooser) -> dict[str, Any]:
    folder = of.place / "given" / str(of.number) / "captures"
    folder.mkdir(parents=True)
    files = []
    for name in of.some(of.material.seconds, 3):
        new = of.one((name, name, f"more/{name}", "taken"))
        if not (folder / f"{new}.bvh").exists():
            (folder / new).parent.mkdir(exist_ok=True)
            shutil.copy(of.material.folder / f"{name}.bvh", folder / f"{new}.bvh")
            files.append((new, of.material.digest(name), of.material.seconds[name]))
    names = [name for name, _, _ in files]
    has_sheet, has_events = of.rng.random(2) < 0.4
    words, sheet = of.sheet(names) if has_sheet else (None, {})
    path, events = of.events(names) if has_events else (None, {})
    where = folder.relative_to(of.place).as_posix()
    return {"folder": where, "files": files, "words": words, "sheet": sheet,
            "events sheet": path, "events": events}  # fmt: skip


def _remove(of: Chooser) -> dict[str, Any]:
    names = of.some(of.world.captures, 2) if of.world.captures else []
    more = [NOBODY] if of.rng.random() < 0.1 or not names else []
    return {"names": list(dict.fromkeys([*names, *more]))}


def _set_words(of: Chooser) -> dict[str, Any]:
    words, start, end = of.caption()
    return {"name": of.capture(), "words": words, "start": start, "end": end,
            "keep": bool(of.rng.random() < 0.4)}  # fmt: skip


def _set_captions(of: Chooser) -> dict[str, Any]:
    captions = tuple(of.caption() for _ in range(of.rng.integers(0, 3)))
    return {"name": of.capture(), "captions": captions}


def _import_words(of: Chooser) -> dict[str, Any]:
    words, sheet = of.sheet(sorted({of.capture() for _ in range(2)}))
    return {"words": words, "sheet": sheet}


def _import_events(of: Chooser) -> dict[str, Any]:
    path, events = of.events(sorted({of.capture() for _ in range(2)}))
    return {"events sheet": path, "events": events}


def _set_synonyms(of: Chooser) -> dict[str, Any]:
    table = {word: of.one(("walk", "kick")) for word in of.some(("stroll", "leap", "hit"), 3)}
    lines = "".join(f"{word} = {other}\n" for word, other in table.items())
    return {"file": of.written("synonyms.txt", lines), "table": table}


def _export(of: Chooser) -> dict[str, Any]:
    name = of.capture()
    ending = of.one((".bvh", ".bvh", ".glb"))
    return {"name": name, "files": [f"{name.replace('/', '_')}{ending}"]}


def _rename(of: Chooser) -> dict[str, Any]:
    old = of.capture()
    if "/" in old and of.rng.random() < 0.3:
        return {"old": f"{old.partition('/')[0]}/", "new": of.one(("", "more/", "moved/"))}
    new = of.one((f"moved/{old}", "taken", *of.some(of.world.captures or ["taken"], 1)))
    return {"old": old, "new": "taken" if NOBODY in new else new}  # that nothing is called so


def _set_tags(of: Chooser) -> dict[str, Any]:
    names = of.some(of.world.captures, 3) if of.world.captures else [NOBODY]
    tags = {"performer": of.one(("ana", "dora", "")), "note": of.one(("a", "b", ""))}
    return {"names": names, "tags": {key: tags[key] for key in of.some(tags, 2)}}


def _add_words(of: Chooser) -> dict[str, Any]:
    names = of.some(of.world.captures, 3) if of.world.captures else []
    more = [NOBODY] if of.rng.random() < 0.1 or not names else []
    return {"names": [*names, *more], "words": of.one(SAID)}


def _grammar(of: Chooser) -> str:
    return str(of.one(sorted(of.world.grammars) or GRAMMARS))


CHOICES: Mapping[str, Callable[[Chooser], dict[str, Any]]] = MappingProxyType(
    {
        "add": _add,
        "remove": _remove,
        "set words": _set_words,
        "set captions": _set_captions,
        "add words": _add_words,
        "undo": lambda of: {"back": int(of.one((0, 0, 0, 1, 2, 3)))},
        "import words": _import_words,
        "import events": _import_events,
        "set synonyms": _set_synonyms,
        "learn": lambda of: {"symbols": int(of.rng.integers(1, 3)), "seed": of.number},
        "save generated": lambda of: {"name": of.one(("made", "made/again", of.capture())),
                                      "words": "walk", "seed": int(of.rng.integers(3))},
        "learn grammar": lambda of: {"name": of.one(GRAMMARS),
                                     "captures": of.some(of.world.captures or [NOBODY], 4)},
        "remove grammar": lambda of: {"name": _grammar(of)},
        "edit rules": lambda of: {"name": _grammar(of), "how": of.one(("more", "flat"))},
        "rename terminal": lambda of: {"name": _grammar(of), "which": int(of.rng.integers(9)),
                                       "to": f"step{of.number}"},
        "undo edit": lambda of: {"name": _grammar(of)},
        "save sequence": lambda of: {"grammar": _grammar(of), "seed": int(of.rng.integers(3)),
                                     "name": of.one(("sung", "sung/again", of.capture()))},
        "keep scene": lambda of: {"name": of.one(SCENES), "players": of.material.players},
        "remove scene": lambda of: {"name": of.one(sorted(of.world.scenes) or SCENES)},
        "export": _export,
        "write generated": lambda of: {"words": "walk", "seed": int(of.rng.integers(3)),
                                       "files": ["made.bvh", "made.bvh.provenance.json"]},
        "export knowledge": lambda _of: {"files": ["known.knowledge"]},
        "export matches": lambda of: {"words": of.one(("walk", "kick", "bow"))},
        "show": lambda of: {"name": of.capture()},
        "list": lambda of: {"performer": of.one(("ana", "boris"))},
        "ask": lambda of: {"words": of.one(("walk", "kick")), "name": of.capture()},
        "ask grammar": lambda of: {"name": _grammar(of)},
        "ask scene": lambda of: {"name": of.one(sorted(of.world.scenes) or SCENES)},
        "rename": _rename,
        "set tags": _set_tags,
        "merge": lambda of: {"prefix": of.one(("", "", "new/")), "other": of.material.other},
        "join": lambda of: {"name": of.capture(), "files": ["join.bvh",
                                                            "join.bvh.provenance.json"]},
        "export words": lambda _of: {"files": ["words.tsv"]},
        "backup": lambda of: {"files": [f"backup{of.number}.duckdb"]},
        "compact": lambda _of: {},
        "rescue": lambda of: {"file": f"rescued{of.number}.duckdb"},
    }
)  # fmt: skip
"""Verb -> its arguments."""
WEIGHTS: Mapping[str, float] = MappingProxyType(
    {
        "add": 8, "remove": 3, "set words": 22, "set captions": 14, "undo": 8, "import words": 8,
        "import events": 8, "set synonyms": 4, "learn": 0.1, "save generated": 1,
        "learn grammar": 0.1, "remove grammar": 0.15, "save sequence": 1.5, "keep scene": 0.6,
        "remove scene": 0.4, "export": 8, "write generated": 0.5, "export knowledge": 0.3,
        "rename": 4, "set tags": 4, "merge": 0.8, "join": 2, "export words": 2, "backup": 0.3,
        "add words": 4, "edit rules": 2, "rename terminal": 1.5, "undo edit": 2,
        "export matches": 1,
        "show": 0.2, "list": 12, "ask": 1, "ask grammar": 0.5, "ask scene": 0.3, "compact": 0.8,
        "rescue": 0.1,
    }
)  # fmt: skip
"""Verb -> how often it is chosen where it can be done."""
BY_SERVER: Mapping[str, float] = MappingProxyType(
    {
        "add": 0.5, "remove": 3, "set words": 20, "set captions": 14, "undo": 12, "learn": 0.05,
        "add words": 6, "set tags": 6, "rename": 6, "rename terminal": 1, "undo edit": 1,
        "save generated": 1, "remove grammar": 0.2, "save sequence": 1, "list": 12,
        "ask": 1, "show": 1,
    }
)  # fmt: skip
"""The same for the server."""
LEARNED = ("save generated", "write generated", "export knowledge", "export matches", "ask")
"""Verbs that need a database that has learned; they are tried without, but seldom."""

OF_GRAMMARS = ("remove grammar", "edit rules", "rename terminal", "undo edit", "save sequence",
               "ask grammar")  # fmt: skip
"""Verbs that need a grammar; they are tried without, but seldom."""


def choose(of: Chooser, by: str) -> tuple[str, dict[str, Any]]:
    """A verb for a process or the server, and its arguments."""
    weights = dict(BY_SERVER if by == "server" else WEIGHTS)
    for verb in LEARNED:
        if of.world.vocabulary is None and verb in weights:
            weights[verb] *= 0.1
    if of.world.vocabulary is None:
        weights["learn"] *= 0.2  # what follows takes ten times as long
    if not of.world.grammars:
        for verb in OF_GRAMMARS:
            weights[verb] = 0.1 * weights.get(verb, 0.0)
    if not of.material.players:
        weights |= {"keep scene": 0.0, "remove scene": 0.0}
    if len(of.world.captures) > 8:
        weights["remove"] *= 4
    verbs = [verb for verb in CHANGES if weights.get(verb)]
    shares = np.array([weights[verb] for verb in verbs])
    verb = str(of.rng.choice(verbs, p=shares / shares.sum()))
    given = CHOICES[verb](of)
    if by == "server" and verb == "remove":
        given["names"] = given["names"][:1]
    if by == "server" and verb == "rename":
        given["new"] = given["new"] or "moved/"  # the page asks for a name
    if by == "server" and verb == "add":
        given |= {"events": {}, "events sheet": None}  # the page takes no sheet of events
    return verb, given
