"""Arguments of wrong types and odd values: likely mistakes have a sentence; none writes."""

from __future__ import annotations

import inspect
import random
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import motiondb
from motiondb import Grammars, MotionDB, QueryError, Scenes, Tables

ODD: tuple[object, ...] = (
    None, 5, -1, 10**40, 10**5000, 1.5, float("nan"), float("inf"), True, b"x", object(), [], {},
    [5], {"a": 5}, {5: "a"}, "", "a\0b", "\ud800", "x" * 100_000, "?*[", ["\ud800"], ["a\0b"], [""],
    Path(), Path("a\0b"), (1, 2), print, motiondb.LearnSettings(seed="x"),  # type: ignore[arg-type]
)  # fmt: skip
USUAL = {"str": "ana/walk_1", "int": 1, "float": 0.5, "bool": False, "Callable": print}
"""What the other arguments of a call are, by the beginning of their annotation."""
NOT_CALLED = ("close", "protect_others", "release", "serve", "undo", "to_json")
"""Verbs that end what the next ones need, and one that takes anything."""
SLOW = re.compile("learn|evaluate|backup|draw|generate|make|update|export_know|animate|compact|res")


def public_verbs() -> Iterator[tuple[str, dict[str, inspect.Parameter]]]:
    """Owner and name, and the parameters, of every public verb and function."""
    owners: tuple[Any, ...] = (MotionDB, Grammars, Scenes, Tables, motiondb)
    for owner in owners:
        for name in motiondb.__all__ if owner is motiondb else dir(owner):
            found = inspect.getattr_static(owner, name, None) or getattr(owner, name)
            verb = getattr(found, "__func__", found)  # of a method of the class
            if inspect.isfunction(verb) and not name.startswith("_") and name not in NOT_CALLED:
                given = dict(inspect.signature(verb).parameters)
                own = {name: each for name, each in given.items() if name not in ("self", "cls")}
                yield f"{owner.__name__}.{name}", own


def test_an_odd_value_is_answered_or_refused_and_then_nothing_is_written(
    learned_copy: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    rng = random.Random(7)
    tried = 0
    with motiondb.open(learned_copy) as db:
        owners = {"MotionDB": db, "Grammars": db.grammars, "Scenes": db.scenes, "Tables": db.tables}
        for verb, given in public_verbs():
            owner, _, name = verb.partition(".")
            usual = {
                name: next((v for k, v in USUAL.items() if k in str(each.annotation)), ["walk_1"])
                for name, each in given.items()
                if each.default is each.empty
            }
            odd = [] if SLOW.search(name) else [(arg, value) for arg in given for value in ODD]
            for argument, value in rng.sample(odd, min(len(odd), 4)):
                before, refused = db.revision(), ""
                try:
                    getattr(owners.get(owner, motiondb), name)(**{**usual, argument: value})
                except Exception as error:
                    refused = str(error) or "refused"
                assert max(map(len, refused.split()), default=0) < 1000, verb
                assert not refused or db.revision() == before, verb
                tried += 1
        assert db.check() == []
    assert tried > 400


LIKELY: dict[str, Callable[[MotionDB], object]] = {
    "names: expected several texts, found 'ana/walk_1'. Put it in a list.": lambda db: db.remove(
        "ana/walk_1"
    ),
    "captures: expected several texts, found 'ana'. Put it in a list.": lambda db: db.rename(
        "a*", "b*", "ana"
    ),
    "parts: expected several texts, found 'ana/walk_1:0-1'. Put it in a list.": lambda db: db.join(
        "ana/walk_1:0-1"
    ),
    "words: expected a text, found ['walk'].": lambda db: db.search(["walk"]),  # type: ignore[arg-type]
    "words: expected a text, found 5.": lambda db: db.generate(5),  # type: ignore[arg-type]
    "limit: expected a whole number from 1 on, found 0.": lambda db: db.like("ana/walk_1", limit=0),
    "seed: expected a whole number from 0 on, found -1.": lambda db: db.generate("walk", seed=-1),
}


def test_a_likely_mistake_has_a_sentence(learned_copy: Path) -> None:
    with motiondb.open(learned_copy) as db:
        for sentence, mistake in LIKELY.items():
            with pytest.raises(QueryError) as refused:
                mistake(db)
            assert str(refused.value) == sentence


def test_numbers_of_numpy_are_numbers(learned_file: Path) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        limit, seed = np.int64(2), np.int64(3)
        assert len(db.search("walk", limit=limit).matches) == 2  # type: ignore[arg-type]
        assert db.generate("walk", seed=seed).seed == 3  # type: ignore[arg-type]
        start = np.float32(0.5)
        assert db.motion("ana/walk_1", start).n_frames == db.motion("ana/walk_1", 0.5).n_frames  # type: ignore[arg-type]


def test_no_cluster_is_started_for_an_address_that_is_no_text() -> None:
    for address in (None, 5, b"local"):  # dask starts a cluster of its own for None
        with pytest.raises(QueryError, match="address: expected a text, found"):
            motiondb.Cluster(address)  # type: ignore[arg-type]
