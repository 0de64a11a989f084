"""Terminals of takes: known truth, determinism, limits, errors; symbols as terminals."""

import csv
from dataclasses import replace
from pathlib import Path

import naive_terminals as naive
import numpy as np
import pytest

from motiondb.body.retarget import to_motion
from motiondb.files.formats import read_capture
from motiondb.grammar.cfg.context_free import GrammarError
from motiondb.grammar.terminals import terminals as module
from motiondb.grammar.terminals.terminals import (
    Terminals,
    TerminalSettings,
    find_terminals,
    strings_of,
    terminals_from_symbols,
)
from motiondb.records import Motion, SegmentTable

QUICK = TerminalSettings(n_starts=4, n_trials=400)
ORDERS = ("abcabdacb", "dacbacabd")


@pytest.fixture(scope="module")
def takes() -> list[Motion]:
    return [naive.actions_motion(order, seed)[0] for seed, order in enumerate(ORDERS)]


@pytest.fixture(scope="module")
def learned(takes: list[Motion]) -> Terminals:
    return find_terminals(takes, 4, np.random.default_rng(0), settings=QUICK)


def same(one: Terminals, other: Terminals) -> bool:
    return all(
        np.array_equal(getattr(one, name), getattr(other, name))
        for name in ("names", "takes", "starts", "ends", "labels", "medoids", "objective")
    )


def test_the_actions_of_a_fight_are_found(samples_folder: Path) -> None:
    """Sample data with known truth: two cuts in three or more are right within five frames."""
    name = "boris/long_fight_1.bvh"
    motion = to_motion(read_capture(samples_folder / name))
    terminals = find_terminals([motion], 6, np.random.default_rng(0))
    with (samples_folder.parent / "segments.tsv").open(encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file, delimiter="\t") if row["file"] == name]
    true = np.array([int(row["start_frame"]) for row in rows[1:]])
    near = np.abs(true[:, None] - terminals.starts[1:]) <= 5
    assert near.any(axis=1).mean() > 2 / 3
    assert near.any(axis=0).mean() > 2 / 3
    names: dict[str, set[str]] = {row["label"]: set() for row in rows}
    for row in rows:
        middle = (int(row["start_frame"]) + int(row["end_frame"])) // 2
        at = int(np.searchsorted(terminals.ends, middle, side="right"))
        names[row["label"]].add(terminals.names[terminals.labels[at]])
    assert not names["kick"] & names["punch"]


def test_segments_tile_their_takes_and_every_terminal_is_used(
    learned: Terminals, takes: list[Motion]
) -> None:
    for take, motion in enumerate(takes):
        of_take = learned.takes == take
        assert learned.starts[of_take][0] == 0
        assert learned.ends[of_take][-1] == motion.n_frames
        assert (learned.ends[of_take][:-1] == learned.starts[of_take][1:]).all()
    assert (learned.labels[learned.medoids] == np.arange(4)).all()
    assert (learned.ends - learned.starts).min() >= QUICK.shortest
    assert learned.names == ("a", "b", "c", "d")
    assert learned.labels[0] == 0


def test_the_same_seed_gives_the_same_terminals(
    learned: Terminals, takes: list[Motion], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert same(learned, find_terminals(takes, 4, np.random.default_rng(0), settings=QUICK))
    from motiondb.grammar.terminals import distances, exchange

    pool = exchange.ThreadPoolExecutor
    for one in (exchange, distances, module):
        monkeypatch.setattr(one, "ThreadPoolExecutor", lambda _n: pool(1))
    assert same(learned, find_terminals(takes, 4, np.random.default_rng(0), settings=QUICK))


def test_the_number_of_segments_can_be_limited(takes: list[Motion]) -> None:
    settings = replace(QUICK, most_segments=12, n_trials=100)
    few = find_terminals(takes, 3, np.random.default_rng(0), settings=settings)
    assert 3 <= len(few.starts) <= 12


def test_a_take_shorter_than_a_segment_is_one_segment() -> None:
    short = [naive.swinging_motion(5), naive.swinging_motion(90, 1)]
    terminals = find_terminals(short, 2, np.random.default_rng(0), settings=QUICK)
    assert (terminals.starts[0], terminals.ends[0], terminals.takes[0]) == (0, 5, 0)
    assert terminals.takes[1] == 1


@pytest.mark.parametrize(
    ("n_terminals", "settings", "text"),
    [
        (0, QUICK, "expected at least 1, found 0. Ask for more terminals."),
        (9, QUICK, "long enough for 9 terminals, found 4 segments of 8 frames or more"),
        (3, replace(QUICK, most_segments=2), "expected room for 3 segments or more, found at most"),
        (1, replace(QUICK, longest=9, grid=4, most_segments=1), "expected at least 2 segments"),
        (2, replace(QUICK, weight=1.0), "expected a weight of R from 0 to below 1, found 1.0"),
        (2, replace(QUICK, shortest=1), "expected 2 <= shortest <= longest frames"),
    ],
)
def test_what_cannot_be_done_is_said(
    n_terminals: int, settings: TerminalSettings, text: str
) -> None:
    with pytest.raises(GrammarError, match=text.replace(".", r"\.")):
        find_terminals(
            [naive.swinging_motion(40)], n_terminals, np.random.default_rng(0), settings=settings
        )


def table(rows: list[tuple[int, int, int, int]]) -> SegmentTable:
    columns = np.array(rows).T
    none = np.zeros(len(rows))
    return SegmentTable(*columns, none, none, np.zeros((len(rows), 9), dtype=np.float32))


def test_a_databases_symbols_become_terminals(takes: list[Motion]) -> None:
    n_frames = [take.n_frames for take in takes]
    rows = [(7, 0, 40, 5), (7, 40, n_frames[0], 2), (8, 0, 9, 1), (9, 0, 30, 5), (9, 30, 61, 8)]
    rows.append((9, 61, n_frames[1], 5))
    actual = terminals_from_symbols(takes, [7, 9], table(rows))
    assert actual.names == ("s2", "s5", "s8")
    assert strings_of(actual) == (("s5", "s2"), ("s5", "s8", "s5"))
    assert actual.takes.tolist() == [0, 0, 1, 1, 1]
    assert actual.medoids[0] == 1
    assert actual.labels[actual.medoids].tolist() == [0, 1, 2]
    assert actual.objective > 0.0
    with pytest.raises(GrammarError, match="take 1: expected segments that tile its"):
        terminals_from_symbols(takes, [8, 9], table(rows))
