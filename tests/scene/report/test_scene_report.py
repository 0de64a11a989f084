"""Which frames a rule looks at: a guard who keeps on while the opponent leaves is not looked at."""

from __future__ import annotations

import numpy as np
import pytest

from motiondb.grammar.cfg.parse import parse
from motiondb.scene.energy.binding import bind
from motiondb.scene.language.grammar_file import read_motion_grammar
from motiondb.scene.language.tactics_file import read_diagram
from motiondb.scene.report.scene_report import _rule
from motiondb.scene.report.visible_motion import guard_distances
from motiondb.scene.timing.timeline import Timeline

GRAMMAR = read_motion_grammar(
    """
    grammar short
    start S for attack
    place rim
    S -> hold guard pass | catch
    hold := "hold"
    guard := "guard"
    pass := "pass" event release
    catch := "catch" event catch
    guard: distance(rim, 0.5 m .. 2 m), direction(rim)
    pass: distance(rim, 0.5 m .. 2 m), synchronisation(receiver, catch, 0 s)
    """,
    "short.grammar",
)
DIAGRAM = read_diagram(
    'diagram "short"\ngrammar short\ncourt half\nattack A1 at 0 1\nattack A2 at 3 4\n'
    "1 pass A1 to A2\n",
    "short.tactics",
)


@pytest.fixture(scope="module")
def rules():
    """A1 holds, guards in frames 40 to 126, waits, passes at 200; 1 m away, at 60 2.5 m."""
    trees = [parse(GRAMMAR.started(), string.split()) for string in ("hold guard pass", "catch")]
    table = bind(DIAGRAM, GRAMMAR, trees)
    places = np.zeros((2, 328, 3))
    places[0, :, 1] = 1.0
    places[0, 60, 1] = 2.5
    places[0, 127:180, 1] = 9.0  # behind the guard's own frames: no rule looks
    clips = [np.array([4, 40, 180, 328])], [np.array([20, 83, 200])], [np.array([40, 127, 328])]
    other = np.array([0, 328]), np.array([201]), np.array([328])
    begins, instants, ends = ((*clip, alone) for clip, alone in zip(clips, other, strict=True))
    timeline = Timeline(places, begins, instants, ends)
    actual = [_rule(table, number, timeline, timeline) for number in range(len(table.rows))]
    return {(rule.action, rule.kind): rule for rule in actual}


def test_throughout_looks_at_its_actions_own_frames(rules) -> None:
    guard = rules["guard", "distance"]
    assert (guard.start, guard.end) == (40, 127)  # 87 of 328
    assert guard.frame == 60
    assert guard.after == pytest.approx(0.5)  # and not the 7 m of frames 127 to 179
    assert not guard.kept
    facing = rules["guard", "direction"]
    assert (facing.start, facing.end) == (40, 127)
    assert facing.after == pytest.approx(180.0)


def test_an_instant_is_one_frame(rules) -> None:
    for kind in ("distance", "synchronisation"):
        assert (rules["pass", kind].start, rules["pass", kind].end) == (200, 201)
        assert rules["pass", kind].frame == 200
    assert rules["pass", "synchronisation"].after == pytest.approx(1.0)


def test_a_guards_distance_is_told_over_all_frames() -> None:
    grammar = read_motion_grammar(
        "grammar g\nstart S\nS -> guard | walk\nguard := 'guard'\nwalk := 'walk'\n".replace(
            "'", '"'
        )
        + "guard: distance(opponent, 0.5 m .. 2 m)\n",
        "g.grammar",
    )
    diagram = read_diagram(
        'diagram "g"\ngrammar g\ncourt half\nattack A1 at 0 1\ndefence D1 at 0 2 guards A1\n',
        "g.tactics",
    )
    trees = [parse(grammar.started(), [action]) for action in ("walk", "guard")]
    table = bind(diagram, grammar, trees)
    places = np.zeros((2, 100, 3))
    places[1, :40, 1] = 1.5  # guards in frames 0 to 39, and then stays where A1 leaves
    places[1, 40:, 1] = 3.0
    places[1, 70, 1] = 4.5
    begins, instants, ends = [np.array([0, 100])] * 2, [np.array([20])] * 2, [np.array([40])] * 2
    timeline = Timeline(places, tuple(begins), tuple(instants), tuple(ends))
    (guard,) = guard_distances(table, timeline)
    assert (guard.player, guard.target, guard.near, guard.far) == ("D1", "A1", 0.5, 2.0)
    assert (guard.n_frames, guard.outside) == (40, pytest.approx(0.6))
    assert (guard.farthest, guard.frame) == (4.5, 70)
