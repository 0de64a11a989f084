"""How a process does every verb of :mod:`robustness_tasks.plain_model`, and looks at the result."""

from __future__ import annotations

import hashlib
import json
import pickle
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

import motiondb
from motiondb import AddSettings, Caption, GrammarSettings, LearnSettings, MotionDB, store
from motiondb.grammar.cfg.context_free import Grammar, Rule, format_grammar
from motiondb.records import Run
from robustness_tasks.plain_world import Arguments

DB = "motions.duckdb"
SCENE = "scene.pickle"
OTHER = "other.duckdb"
"""The database that is merged, beside the material."""
MATCHES = "matches"
"""The folder for matches, where files are written."""


class Hand:
    """The database as one process holds it: open, lent, or closed.

    Parameters
    ----------
    place : Path
        The folder with the database.
    material : Path
        The folder with the scene that was made.
    """

    def __init__(self, place: Path, material: Path) -> None:
        self.place, self.material = place, material
        self.path = place / DB
        self._db: MotionDB | None = None
        self._scene: Any = None

    @property
    def db(self) -> MotionDB:
        """The open database; opened, or made, where it is not."""
        if self._db is None:
            self._db = motiondb.open(self.path, wait=60.0)
        return self._db

    @property
    def scene(self) -> Any:
        """The scene that was made when the run was prepared."""
        self._scene = self._scene or pickle.loads((self.material / SCENE).read_bytes())
        return self._scene

    def close(self) -> None:
        """Close the database."""
        if self._db is not None:
            self._db.close()
        self._db = None

    def lend(self) -> None:
        """Close the file, but keep what was loaded."""
        if self._db is not None:
            self._db.release()

    def do(self, verb: str, given: Arguments) -> dict[str, Any]:
        """Do a verb; plain facts that the model can compare."""
        facts = VERBS[verb](self, given)
        return facts if isinstance(facts, dict) else {}

    def look(self, *, thorough: bool) -> dict[str, Any]:
        """What is in the database, and everything that is wrong with it."""
        db = self.db
        with db.session.reading():
            captions, events = db.words.all_captions(), db.captures.all_events()
            infos = db.captures()
            names = {info.capture_id: info.name for info in infos}
            captures = {
                i.name: [
                    i.kind,
                    i.sha256,
                    dict(i.tags),
                    tuple((c.words, c.start, c.end) for c in captions.get(i.capture_id, ())),
                    tuple((e.frame, e.name) for e in events.get(i.capture_id, ())),
                ]
                for i in infos
            }
            scenes = {
                name: [names.get(player.capture_id) for player in db.scenes.load(name).players]
                for name in db.scenes.names()
            }
            runs = store.load_runs(db.store)
            facts = {
                "captures": captures,
                "synonyms": store.load_synonyms(db.store),
                "vocabulary": db.words.vocabulary() if db.is_learned() else None,
                "grammars": {
                    name: [_digest(db, name), sorted(db.grammars.saved(name))]
                    for name in db.grammars.names()
                },
                "scenes": scenes,
                "trash": sorted(name for _, name in store.load_trash(db.store)),
                "history": [[kind, [e.name for e in edits]] for kind, edits in _history(db, runs)],
            }
            wrong = (
                [f"unlearned: {name}" for name in db.captures.unlearned()]
                if db.is_learned()
                else []
            )
            wrong += [f"a run without an end: {run}" for run in runs if not run.finished]
            revision = db.revision()
        if thorough:
            wrong += db.check()
            wrong += counted_otherwise(db) if db.is_learned() else []
        return {"facts": facts, "wrong": wrong, "revision": revision}

    def begun(self) -> dict[str, Any]:
        """Numbers of the captures, and what runs changed, in a database that is taken over."""
        runs = [(kind, [tuple(vars(e).values())[1:6] for e in edits])
                for kind, edits in _history(self.db, store.load_runs(self.db.store))]  # fmt: skip
        return {"numbers": {i.name: i.capture_id for i in self.db.captures()}, "runs": runs}


def _history(db: MotionDB, runs: Sequence[Run]) -> list[tuple[str, list[Any]]]:
    """The kind of every run that changed captures, with its edits by name; oldest first."""
    kinds = {run.run_id: run.kind for run in runs}
    edits: dict[int, list[Any]] = {}
    for edit in store.load_edits(db.store):
        edits.setdefault(edit.run_id, []).append(edit)
    return [(kinds[run], sorted(of, key=lambda e: e.name)) for run, of in sorted(edits.items())]


def _digest(db: MotionDB, name: str) -> str:
    """A digest of a grammar's rules, terminals and sentences."""
    learned = db.grammars.load(name)
    facts = (learned.grammar.rules, learned.strings, learned.parses, learned.terminals.takes)
    return hashlib.sha256(repr(facts).encode()).hexdigest()


def counted_otherwise(db: MotionDB) -> list[str]:
    """Counts of the learned model that are not those of the captures and words that are there."""
    from motiondb.database.loading import segments_of
    from motiondb.learn.learned_model import from_stored
    from motiondb.meaning import counting

    with db.session.reading():
        model = from_stored(store.load_learning(db.store))
        there = set(model.segments.capture_ids.tolist())
        captions = {c: rows for c, rows in db.words.all_captions().items() if c in there}
        synonyms = store.load_synonyms(db.store)
        table = segments_of(db.store, model, there)
    counted = model.counted
    again = counting.count(table, captions, synonyms, counted.reference)
    told = _unlike(again, counted.counts, "counts")
    return [f"counted otherwise than from the beginning: {told}"] if told else []


def _unlike(one: object, other: object, where: str) -> str:
    """The first place where two nested records differ by more than rounding, or ""."""
    if is_dataclass(one) and not isinstance(one, type):
        told = (_unlike(getattr(one, f.name), getattr(other, f.name), f"{where}.{f.name}")
                for f in fields(one))  # fmt: skip
        return next(filter(None, told), "")
    if isinstance(one, np.ndarray) and isinstance(other, np.ndarray):
        same = np.shape(one) == np.shape(other) and np.allclose(one, other, atol=1e-6)
        return "" if same else where
    if isinstance(one, dict) and isinstance(other, dict):
        if set(one) != set(other):
            return where
        told = (_unlike(one[key], other[key], f"{where}[{key!r}]") for key in one)
        return next(filter(None, told), "")
    return "" if one == other or isinstance(one, float) else where


def _add(hand: Hand, given: Arguments) -> Any:
    sheets = (given["words"], given["events sheet"])
    words, events = (None if path is None else hand.place / path for path in sheets)
    settings = AddSettings(jobs=1)
    report = hand.db.add(hand.place / given["folder"], words, settings, events=events)
    return {"added": sorted(report.added)}


def _learn(hand: Hand, given: Arguments) -> None:
    hand.db.learn(LearnSettings(n_symbols=given["symbols"], seed=given["seed"]))


def _made(hand: Hand, given: Arguments) -> Any:
    return hand.db.generate(given["words"], given["seed"], anyway=True)


def _save_generated(hand: Hand, given: Arguments) -> None:
    made = _made(hand, given)
    hand.db.captures.save_generated(given["name"], given["words"], made, given["seed"])


def _out(hand: Hand, given: Arguments) -> Path:
    """Where a file is written."""
    return hand.place / "out" / str(given["files"][0])


def _learn_grammar(hand: Hand, given: Arguments) -> None:
    settings = GrammarSettings(n_terminals=2, sentences="captures", evaluations=2)
    hand.db.grammars.learn(given["captures"], given["name"], settings)


def _save_sequence(hand: Hand, given: Arguments) -> None:
    sequence = hand.db.grammars.generate(given["grammar"], given["seed"])
    hand.db.grammars.save(given["name"], sequence, given["seed"])


def _edit_rules(hand: Hand, given: Arguments) -> Any:
    """Add an alternative, or let the start derive the sentences at once and this alternative."""
    grammars, name = hand.db.grammars, given["name"]
    with store.transaction(hand.db.store):
        learned, saved = grammars.load(name), grammars.saved(name)
        text = edited_rules(learned.grammar, learned.strings, given["how"])
        lost = grammars.edit_rules(name, text)
        wrong = {*saved} - {*lost} ^ {*grammars.saved(name)}
    return {"wrong": [f"not lost as told: {capture}" for capture in sorted(wrong)]}


def edited_rules(grammar: Grammar, sentences: Sequence[Sequence[str]], how: str) -> str:
    """The text of other rules, "flat" or "more", with an alternative that is not there yet."""
    known = {rule.right for rule in grammar.rules if rule.left == grammar.start}
    used = next(symbol for rule in grammar.rules for symbol in rule.right
                if not grammar.is_nonterminal(symbol))  # fmt: skip
    new = next((used,) * n for n in range(1, len(known) + 2) if (used,) * n not in known)
    if how == "flat":
        known, others = {tuple(sentence) for sentence in sentences}, []
    else:
        others = [rule for rule in grammar.rules if rule.left != grammar.start]
    rights = [*sorted(known), new]
    own = [Rule(grammar.start, right, 1.0 / len(rights)) for right in rights]
    return format_grammar(Grammar(grammar.start, (*own, *others)))


def _rename_terminal(hand: Hand, given: Arguments) -> None:
    grammars, name = hand.db.grammars, given["name"]
    with store.transaction(hand.db.store):
        names = grammars.load(name).terminals.names
        grammars.rename_terminal(name, names[given["which"] % len(names)], given["to"])


def _export_matches(hand: Hand, given: Arguments) -> Any:
    answer = hand.db.search(given["words"], limit=2)
    files = hand.db.captures.export_matches(answer, hand.place / "out" / MATCHES, given["words"])
    wrong = [file.output.name for file in files if not _is_as_told(file.output, file.provenance)]
    return {"wrong": [f"not as told: {name}" for name in wrong]}


def _is_as_told(path: Path, beside: Path) -> bool:
    """Whether the file beside says the content of a file."""
    told = json.loads(beside.read_text())["sha256"]
    return bool(told == hashlib.sha256(path.read_bytes()).hexdigest())


def _keep_scene(hand: Hand, given: Arguments) -> None:
    record = replace(hand.scene.record, name=given["name"])
    hand.db.scenes.keep(replace(hand.scene, record=record))


def _captions(given: Arguments) -> list[Caption]:
    return [Caption(*words) for words in given["captions"]]


def _list(hand: Hand, given: Arguments) -> Any:
    where = f"performer={given['performer']}"
    names = {info.name for info in hand.db.captures()}
    has = any("performer" in info.tags for info in hand.db.captures())
    found = sorted(info.name for info in hand.db.captures(where, exact=True)) if has else []
    rows = hand.db.captures.browse(sort="-name", limit=1000).rows
    return {"names": sorted(names), "found": found, "browsed": [row.info.name for row in rows]}


def _show(hand: Hand, given: Arguments) -> Any:
    db, name = hand.db, given["name"]
    db.captures.show(name)
    asks = (
        db.captures.segments,
        db.captures.activities,
        db.captures.relations,
        db.captures.provenance,
        db.clip,
        db.motion,
        db.captures.features,
    )
    for ask in asks:
        ask(name)
    db.captures.duplicates()
    said = tuple((c.words, c.start, c.end) for c in db.words.captions(name))
    events = {event.name for event in db.captures.events(name)} - {
        row.event for row in db.captures.event_rows()
    }
    counts = {f.missing + sum(n for _, n in f.values) for f in db.captures.facets()}
    row = db.captures.browsed(name)
    return {"said": said, "counts": [*counts], "events": [*events], "found": row and row.info.name}


def _ask(hand: Hand, given: Arguments) -> Any:
    db = hand.db
    answer = db.search(given["words"])
    alike = db.like(given["name"])
    rows = (db.words.rows(), db.symbols.rows(), db.symbols.segments(0), db.symbols.start_facts())
    told = (answer.matches, alike.matches, db.describe(given["name"]), db.symbols.drift(), rows)
    return {"answer": repr(told)}


def _ask_grammar(hand: Hand, given: Arguments) -> Any:
    grammars, name = hand.db.grammars, given["name"]
    facts = (grammars.suggest(name), grammars.show(name), grammars.size(name), grammars.sizes())
    edits = []
    for saved in grammars.saved(name):
        edited = grammars.edit(name, saved, 0)
        played = [grammars.play(name, edited, k) for k in range(len(edited.alternatives))][:1]
        edits.append([each.choice for each in (grammars.open(saved), *played)])
    return {"answer": repr((facts, edits, grammars.meanings(name)))}


def _ask_scene(hand: Hand, given: Arguments) -> Any:
    scenes = hand.db.scenes
    scene = scenes.find(given["name"])
    told = (scenes.facts(scene), scenes.report(scene), scenes.remarks(scene))
    return {"answer": repr(told)}


def _undo(hand: Hand, given: Arguments) -> None:
    """Take back the latest change, or the one so many changes of captures back."""
    if not given["back"]:
        hand.db.undo()
        return
    runs = sorted({edit.run_id for edit in store.load_edits(hand.db.store)})
    hand.db.undo(runs[-given["back"]] if len(runs) >= given["back"] else 0)


def _join(hand: Hand, given: Arguments) -> None:
    name = given["name"]
    hand.db.join([f"{name}:0-0.3", name]).write(_out(hand, given))


def _backup(hand: Hand, given: Arguments) -> Any:
    new = _out(hand, given)
    hand.db.backup(new)
    with motiondb.open(new, read_only=True) as db:
        said = {i.name: [i.sha256, len(db.words.captions(i.name))] for i in db.captures()}
        return {"rescued": said, "wrong": db.check()}


def _compact(hand: Hand, _given: Arguments) -> None:
    hand.close()
    motiondb.compact(hand.path, wait=60.0)


def _rescue(hand: Hand, given: Arguments) -> Any:
    hand.close()
    new = hand.place / given["file"]
    motiondb.rescue(hand.path, new, wait=60.0)
    with motiondb.open(new) as db:
        said = {i.name: [i.sha256, len(db.words.captions(i.name))] for i in db.captures()}
        wrong = db.check()
    for path in hand.place.glob(f"{given['file']}*"):
        path.unlink()
    return {"rescued": said, "wrong": wrong}


VERBS: Mapping[str, Callable[[Hand, Arguments], Any]] = MappingProxyType(
    {
        "add": _add,
        "remove": lambda hand, given: {"removed": hand.db.captures.remove(given["names"])},
        "set words": lambda hand, given: hand.db.words.set(
            *(given[key] for key in ("name", "words", "start", "end", "keep"))
        ),
        "add words": lambda hand, given: hand.db.words.add(given["words"], given["names"]),
        "set captions": lambda hand, given: hand.db.words.set_captions(
            given["name"], _captions(given)
        ),
        "import words": lambda hand, given: hand.db.words.import_sheet(hand.place / given["words"]),
        "import events": lambda hand, given: hand.db.captures.import_events(
            hand.place / given["events sheet"]
        ),
        "undo": _undo,
        "rename": lambda hand, given: hand.db.captures.rename(given["old"], given["new"]),
        "set tags": lambda hand, given: hand.db.captures.set_tags(given["tags"], given["names"]),
        "merge": lambda hand, given: hand.db.merge(hand.material / OTHER, given["prefix"], wait=60),
        "join": _join,
        "export words": lambda hand, given: hand.db.words.export(_out(hand, given)),
        "backup": _backup,
        "set synonyms": lambda hand, given: hand.db.words.set_synonyms(hand.place / given["file"]),
        "learn": _learn,
        "save generated": _save_generated,
        "learn grammar": _learn_grammar,
        "edit rules": _edit_rules,
        "rename terminal": _rename_terminal,
        "undo edit": lambda hand, given: hand.db.grammars.undo_edit(given["name"]),
        "remove grammar": lambda hand, given: hand.db.grammars.remove(given["name"]),
        "save sequence": _save_sequence,
        "keep scene": _keep_scene,
        "remove scene": lambda hand, given: hand.db.scenes.remove(given["name"]),
        "export": lambda hand, given: hand.db.export(given["name"], _out(hand, given)),
        "write generated": lambda hand, given: _made(hand, given).write(_out(hand, given)),
        "export knowledge": lambda hand, given: hand.db.symbols.export_knowledge(_out(hand, given)),
        "export matches": _export_matches,
        "show": _show,
        "list": _list,
        "ask": _ask,
        "ask grammar": _ask_grammar,
        "ask scene": _ask_scene,
        "compact": _compact,
        "rescue": _rescue,
    }
)
"""Verb -> what does it; the model looks at what is given back as a dictionary."""
