"""A chain of random steps, with kills; ``benchmarks/robustness.py model`` runs many."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

from motiondb import Grammars, MotionDB, Scenes
from robustness_tasks import model, model_processes, model_verbs
from robustness_tasks.plain_model import DONE, UNKNOWN, Step, futures
from robustness_tasks.plain_world import ANY, Kept, World, difference

pytest.importorskip("resource")
OFTEN = {"": 0.9, "kill": 0.04, "late kill": 0.01, "full disk": 0.03, "clock": 0.02}
BESIDE = re.compile("draw|animate|check_")  # pictures, and refusals before the work
MADE = {"make", "update", "write"}  # scenes take a minute; ``kills`` does these
PURE = {
    "is_folder", "plan", "read_diagram",
    "read_folder", "read_grammar", "suggest", "validate",
}  # fmt: skip
VARIANTS = {
    "caption_history", "chain", "complete", "edits", "evaluate", "faulty_files", "find_actions",
    "generate_variants", "same_files", "tables", "tag_rows",
    "log_note", "parse", "searchable", "start_knowledge", "strip", "taken_in_filter",
    "taken_in_pattern", "taken_words", "why_unchecked", "word_sources",
}  # fmt: skip
"""Questions that the steps do not ask; their tests are in ``tests/database``."""


def test_every_verb_is_a_step_or_named_as_none() -> None:
    source = Path(model_verbs.__file__).read_text(encoding="utf-8")
    for topic in (MotionDB, Grammars, Scenes):
        names = {name for name in dir(topic) if not name.startswith("_")}
        left = {name for name in names if not re.search(rf"\b{name}\b", source)}
        assert {name for name in left if not BESIDE.match(name)} <= MADE | PURE | VARIANTS


def test_a_chain_of_steps_makes_no_difference(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(model_processes, "STRACE", None)  # limits of files do the same everywhere
    monkeypatch.setattr(model, "HARMS", OFTEN)
    material = model.tiny(tmp_path)
    model.warm_up(material)
    outcomes = list(model.chain(1, material, steps=60))
    assert [outcome for outcome in outcomes if outcome.faults] == []
    assert len(outcomes) == 60
    assert {"kill", "late kill"} & {outcome.harm for outcome in outcomes}


def test_an_interrupted_step_may_have_happened_or_not() -> None:
    world = World({"walk": Kept("captured", "d", {}, (("walk", None, None),))})
    given = {"name": "walk", "words": "run", "start": None, "end": None, "keep": True}
    worlds = list(futures(world, [Step("set words", given, UNKNOWN)], undisturbed=True))
    assert [len(later.captures["walk"].captions) for later in worlds] == [1, 2]
    export = Step("write generated", {"files": ["a", "b"]}, UNKNOWN)
    learned = World(vocabulary=("walk",))
    files = [set(later.files) for later in futures(learned, [export], undisturbed=True)]
    assert {frozenset(of_one) for of_one in files} == {
        frozenset(()), frozenset("a"), frozenset("b"), frozenset("ab"),
    }  # fmt: skip
    assert difference({"a": [1, ANY]}, {"a": (1, 5)}) == ""
    assert difference({"a": 1}, {"a": 1, "b": 2}) == "/b: unexpected"


def test_a_change_that_is_counted_back_may_be_counted_before_another_undo() -> None:
    world = World({"walk": Kept("captured", "d", {}, (), number=1)})
    for words in ("one", "two", "three"):
        before = world.copy()
        world.captures["walk"] = replace(world.captures["walk"], captions=((words, None, None),))
        world.remember("set words", before)
    latest = Step("undo", {"back": 0}, DONE)
    both = [latest, Step("undo", {"back": 2}, DONE)]
    worlds = list(futures(world, both, undisturbed=True))
    captions = [later.captures["walk"].captions[0][0] for later in worlds]
    assert captions == ["one"]  # "two" taken back after "three"; counted after it, none is allowed
