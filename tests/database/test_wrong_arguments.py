"""Arguments of wrong types and odd values: every public verb refuses them by name."""

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
from motiondb import Grammars, MotionDB, MotionDBError, QueryError, Scenes, Tables
from motiondb.database.arguments import Kind, checked, kinds_of

ODD: tuple[object, ...] = (
    None, 5, -1, 10**40, 10**5000, 1.5, float("nan"), float("inf"), True, b"x", object(), [], {},
    [5], {"a": 5}, {5: "a"}, "", "a\0b", "\ud800", "x" * 100_000, "?*[", ["\ud800"], ["a\0b"], [""],
    Path(), Path("a\0b"), (1, 2), print, motiondb.LearnSettings(seed="x"),  # type: ignore[arg-type]
)  # fmt: skip
USUAL: dict[str, object] = {
    "str": "ana/walk_1",
    "Path": Path("none.bvh"),
    "int": 1,
    "float": 0.5,
    "bool": False,
    "Callable": print,
}
"""What the other arguments of a call are, by the first of the kinds that they may have."""
NOT_CALLED = ("close", "protect_others", "release", "serve", "undo", "to_json")
"""Verbs that end what the next ones need, and one that takes anything."""
SLOW = re.compile("learn|evaluate|backup|draw|generate|make|update|export_know|animate|compact|res")

Verb = tuple[str, Callable[..., object], dict[str, Kind | None], dict[str, inspect.Parameter]]


def public_verbs() -> Iterator[Verb]:
    """Owner and name, function, kinds and parameters of every public verb and function."""
    owners: tuple[Any, ...] = (MotionDB, Grammars, Scenes, Tables, motiondb)
    for owner in owners:
        for name in motiondb.__all__ if owner is motiondb else dir(owner):
            found = inspect.getattr_static(owner, name, None) or getattr(owner, name)
            verb = getattr(found, "__func__", found)  # of a method of the class
            if inspect.isfunction(verb) and not name.startswith("_") and name not in NOT_CALLED:
                given = dict(inspect.signature(verb).parameters)
                kinds = kinds_of(inspect.unwrap(verb))
                yield f"{owner.__name__}.{name}", verb, kinds, given


VERBS = list(public_verbs())


def fits(kind: Kind | None, value: object) -> bool:
    """Whether a value is of a kind."""
    try:
        return kind is None or (kind.fit(value), True)[1]
    except Exception:  # the mismatch is private
        return False


def calls(verb: Verb, is_fitting: bool) -> Iterator[dict[str, object]]:
    """The arguments of calls with one odd value."""
    _, _, kinds, given = verb
    own = {name: each for name, each in given.items() if name not in ("self", "cls")}
    usual = {
        name: next((v for v in USUAL.values() if fits(kinds[name], v)), ["ana/walk_1"])
        for name, each in own.items()
        if each.default is each.empty
    }
    for name in own:
        for value in ODD:
            if fits(kinds[name], value) == is_fitting:
                yield {**usual, name: value}


def test_every_public_verb_is_walked_over() -> None:
    assert len(VERBS) > 140
    assert all(
        kind
        for _, _, kinds, _ in VERBS
        for name, kind in kinds.items()
        if name not in ("self", "cls")
    )


@pytest.mark.parametrize("verb", VERBS, ids=[verb[0] for verb in VERBS])
def test_a_value_of_a_wrong_type_is_refused_by_name_before_the_verb_begins(verb: Verb) -> None:
    bound = [None] * (next(iter(verb[3]), "") in ("self", "cls"))  # nothing to work with
    for arguments in calls(verb, is_fitting=False):
        first = next(k for k, v in arguments.items() if not fits(verb[2][k], v))
        with pytest.raises(QueryError, match=rf"^{first}[.\w]*: expected .*, found ") as refused:
            verb[1](*bound, **arguments)
        str(refused.value).encode()
        assert len(str(refused.value)) < 400


def test_odd_values_are_answered_or_refused_and_then_nothing_is_written(
    learned_copy: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    rng = random.Random(7)
    with motiondb.open(learned_copy) as db:
        owners = {"MotionDB": db, "Grammars": db.grammars, "Scenes": db.scenes, "Tables": db.tables}
        for verb in VERBS:
            owner, _, name = verb[0].partition(".")
            odd = [] if SLOW.search(name) else list(calls(verb, is_fitting=True))
            for arguments in rng.sample(odd, min(len(odd), 3)):
                before, refused = db.revision(), ""
                try:
                    getattr(owners.get(owner, motiondb), name)(**arguments)
                except MotionDBError as error:
                    refused = str(error)
                assert max(map(len, refused.split()), default=0) < 1000
                assert not refused or db.revision() == before
        assert db.check() == []


def test_numbers_of_numpy_and_iterators_are_what_python_has() -> None:
    @checked
    def verb(n: int, x: float, b: bool, names: Iterator[str], path: Path | None = None) -> object:
        return n, x, b, names, path

    verb.__wrapped__.__annotations__.update(names="Iterable[str]")  # type: ignore[attr-defined]
    given = verb(np.int64(3), np.float32(0.5), np.bool_(True), (each for each in "ab"))  # type: ignore[arg-type]
    assert given == (3, 0.5, True, ("a", "b"), None)
    assert [type(value) for value in given] == [int, float, bool, tuple, type(None)]  # type: ignore[attr-defined]


def test_a_missing_or_surplus_argument_is_a_type_error(learned_file: Path) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        for call in (lambda: db.search(), lambda: db.show("a", 5), lambda: db.show(nme="a")):  # type: ignore[call-arg]
            with pytest.raises(TypeError, match="argument"):
                call()


def test_the_message_says_what_to_give(learned_file: Path) -> None:
    with (
        motiondb.open(learned_file, read_only=True) as db,
        pytest.raises(QueryError) as refused,
    ):
        db.remove("ana/walk_1")
    assert str(refused.value) == (
        "names: expected a sequence, each a text, found 'ana/walk_1' (str). Put it in a list."
    )


def test_no_cluster_is_started_for_an_address_that_is_no_text() -> None:
    for address in (None, 5, b"local"):  # dask starts a cluster of its own for None
        with pytest.raises(QueryError, match="address: expected a text, found"):
            motiondb.Cluster(address)  # type: ignore[arg-type]
