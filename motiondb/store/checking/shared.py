"""Copy the data of no single capture to a new store: synonyms, copies, grammars and scenes."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial

from motiondb.errors import MotionDBError
from motiondb.store.catalogue.annotations import load_synonyms, save_synonyms
from motiondb.store.catalogue.relations import load_relations, save_relations
from motiondb.store.connection.handle import Store
from motiondb.store.connection.transactions import transaction
from motiondb.store.grammars.derivations import load_derivation, save_derivation
from motiondb.store.grammars.grammars import load_grammar, load_grammar_names, save_grammar
from motiondb.store.grammars.scenes import load_scene, load_scene_names, save_scene


def copy_shared(damaged: Store, new: Store, run_id: int) -> list[str]:
    """Copy the readable data; yield a sentence for everything else."""
    numbers, lost = _new_numbers(damaged, new), []
    lost += _try("synonyms", lambda: save_synonyms(new, load_synonyms(damaged)))
    lost += _try("the list of copies", lambda: _copy_relations(damaged, new))
    lost += _each(
        damaged,
        "grammar",
        load_grammar_names,
        lambda name: save_grammar(new, load_grammar(damaged, name), run_id),
    )
    lost += _try("derivations", lambda: _copy_derivations(damaged, new, numbers, run_id))
    lost += _each(
        damaged,
        "scene",
        load_scene_names,
        lambda name: _copy_scene(damaged, new, name, numbers, run_id),
    )
    return lost


def _try(what: str, copy: Callable[[], object]) -> list[str]:
    """Nothing if a copy succeeds, else a sentence."""
    try:
        copy()
    except (MotionDBError, ValueError, TypeError, KeyError, IndexError):
        return [f"{what}: could not be read."]
    return []


def _each(
    damaged: Store,
    kind: str,
    load_names: Callable[[Store], Iterable[str]],
    copy: Callable[[str], object],
) -> list[str]:
    """Copy everything of a kind, one by one."""
    try:
        names = list(load_names(damaged))
    except MotionDBError:
        return [f"every {kind}: the table {kind} could not be read."]
    return [sentence for name in names for sentence in _try(f"{kind} {name}", partial(copy, name))]


def _new_numbers(damaged: Store, new: Store) -> dict[int, int]:
    """Number of a capture in the damaged store -> in the new one, by digest."""
    query = "SELECT sha256, capture_id FROM capture"
    after = dict(new.connection.execute(query).fetchall())
    try:
        before = damaged.connection.execute(query).fetchall()
    except MotionDBError:
        return {}
    return {number: after[sha256] for sha256, number in before if sha256 in after}


def _copy_relations(damaged: Store, new: Store) -> None:
    names = {name for (name,) in new.connection.execute("SELECT name FROM capture").fetchall()}
    kept = [r for r in load_relations(damaged) if r.capture in names and r.other in names]
    save_relations(new, kept)


def _copy_derivations(damaged: Store, new: Store, numbers: dict[int, int], run_id: int) -> None:
    grammars = dict(new.connection.execute("SELECT name, grammar_id FROM grammar").fetchall())
    with transaction(new):
        for before, after in numbers.items():
            derivation = load_derivation(damaged, before)
            if derivation is not None and derivation.grammar in grammars:
                save_derivation(new, after, grammars[derivation.grammar], derivation, run_id)


def _copy_scene(
    damaged: Store, new: Store, name: str, numbers: dict[int, int], run_id: int
) -> None:
    scene = load_scene(damaged, name)
    players = tuple(
        replace(player, capture_id=numbers.get(player.capture_id, -1)) for player in scene.players
    )
    save_scene(new, replace(scene, players=players), run_id)


def was_learned(damaged: Store) -> bool:
    """Whether a damaged database had learned; True where that cannot be read."""
    try:
        row = damaged.connection.execute("SELECT count(*) FROM learning").fetchone()
    except MotionDBError:
        return True
    return bool(row and row[0])
