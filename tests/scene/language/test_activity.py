"""Activities that no program knows: what a grammar says of verbs, roles, objects and places."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from made_activities import CUP, DANCE, PAIR, TABLE, refusal, texts

from motiondb.body import body
from motiondb.body.retarget import motion_positions
from motiondb.errors import SceneError
from motiondb.grammar.cfg.parse import parse
from motiondb.records import Motion
from motiondb.scene.clips.clip_cutting import found_instant
from motiondb.scene.energy.binding import (
    AT_END,
    AT_START,
    POSITION,
    SYNCHRONISATION,
    UNMET,
    bind,
)
from motiondb.scene.energy.scene_arrays import PlayerState, SceneState
from motiondb.scene.language.activity import Answers, Thing
from motiondb.scene.language.expressions import exact_actions, expressions
from motiondb.scene.language.grammar_file import read_motion_grammar
from motiondb.scene.language.possession import first_holder, has_ball
from motiondb.scene.language.tactics import aligned, answered
from motiondb.scene.language.tactics_file import format_diagram, parse_diagram, read_diagram
from motiondb.scene.services.casting import cast
from motiondb.scene.thing.thing_acts import Aim, Possession, ThingActs, thing_acts
from motiondb.scene.thing.thing_flight import fly, palms
from motiondb.scene.timing.timeline import sampled_timeline


def acted(wandering: Callable, text: str) -> ThingActs:
    """What is done with the cup if everybody plays their shortest string."""
    diagram = read_diagram(text, "x", CUP.activity)
    trees = cast(diagram, CUP, "x")
    table, library = bind(diagram, CUP, trees), wandering(CUP.terminal)
    players = [
        PlayerState(trees[player.name], entries, (player.at.x, player.at.z, 0.0), 0)
        for player, actions in zip(diagram.players, table.actions, strict=True)
        for entries in [np.array([library.of(action)[0] for action in actions])]
    ]
    state = SceneState(tuple(players))
    acts = thing_acts(state, library, table, sampled_timeline(state, library))
    assert acts is not None
    return acts


def test_what_the_grammar_forces_although_nobody_asks_for_it_is_refused() -> None:
    text = 'start S\nS -> walk wave\nwalk := "walk"\nwave := "wave" when asked\n'
    told = refusal(read_motion_grammar(text, "g"), "player A at 0 0\n1 walk A")
    assert told == (
        "x:1: 'A': expected a string of the grammar g with what is drawn, found none without wave,"
        " which is done only when asked: 'walk wave'. Draw it, take 'when asked' from it, or add a"
        " rule that does without."
    )


def test_any_action_and_every_declared_class_is_a_verb() -> None:
    assert texts(DANCE, PAIR + "1 step Lea to 1 2\n2 bow Lea with Finn\n2 turn Lea") == {
        "Lea": "(step)*(bow)(turn)",
        "Finn": "(bow)",  # the grammar's rule asks for it
    }
    assert texts(DANCE, PAIR + "1 travel Lea to 1 2")["Lea"] == "(step|turn)*"
    told = refusal(DANCE, PAIR + "1 waltz Lea")
    assert told.startswith("x:3:3: expected what is done (travel, step, turn, bow, does),")


def test_roles_are_those_of_the_grammar() -> None:
    diagram = read_diagram(PAIR + "1 bow Lea", "x", DANCE.activity)
    assert DANCE.start_of("leader") == "S_L"
    assert (diagram.partner_of("Lea"), diagram.partner_of("Finn")) == ("Finn", "Lea")
    assert "one of diagram, grammar, court, ground, place, step, leader, follower, player" in (
        refusal(DANCE, "attack A1 at 0 0")
    )


def test_a_rule_about_nobody_is_refused_before_sampling() -> None:
    told = refusal(DANCE, "follower Finn at 1 0\n1 step Finn")
    assert told == (
        "x:2: 'step Finn': expected a leader of Finn, whom the rule distance of step is about,"
        " found none. Add a player who is the leader, or take the element out."
    )
    assert "a partner of Lea, whom the rule direction of bow is about" in (
        refusal(DANCE, "leader Lea at 1 0\n1 step Lea")  # a bow may be derived
    )


def test_the_ground_and_its_marks_are_the_grammars() -> None:
    diagram = read_diagram(PAIR, "x", DANCE.activity)
    assert diagram.court.corners == (-2.0, 8.0, -1.0, 7.0)
    (mark,) = diagram.court.marks
    np.testing.assert_allclose([mark[0], mark[-1]], [(1, 0, 0), (-1, 0, 0)], atol=1e-12)
    assert "a point on the ground (x -2 to 8 m" in refusal(DANCE, "leader Lea at -3 0")
    assert parse_diagram("ground 4 x 4\n" + PAIR, "x", DANCE.activity).court.marks == ()
    assert "expected the ground of the grammar (hall)" in refusal(DANCE, "court half\n" + PAIR)


def test_who_has_the_object_follows_from_what_actions_do_with_it() -> None:
    text = TABLE + "1 take Ana\n2 go Ana to 1 1\n3 give_it Ana to Bo\n4 toss Bo at goal"
    diagram = read_diagram(text, "x", CUP.activity)
    assert first_holder(diagram) == ""
    assert has_ball(diagram, "Ana") == (False, True, True)
    assert has_ball(diagram, "Bo") == (False, True)
    assert texts(CUP, text) == {"Ana": "(take)(bear)*(give_it)", "Bo": "(take)(toss)"}
    assert "expected Ana without the cup, found Ana with it" in (
        refusal(CUP, TABLE + "1 take Ana\n2 walk Ana to 1 1")
    )
    assert "'drink Ana': expected Ana to have the cup, found Ana without the cup." in (
        refusal(CUP, TABLE + "1 drink Ana")
    )
    assert read_diagram(format_diagram(diagram), "x", CUP.activity).elements[3].target == "goal"


@pytest.mark.parametrize(
    ("done", "told"),
    [
        ("1 take Ana\n2 does Ana bear* then drink", ""),
        ("1 does Ana walk* then take then put_it", ""),  # the object is taken on the way
        ("1 does Ana walk then drink", "expected Ana to have the cup"),
        ("1 take Ana\n2 does Ana take", "expected a receiver without the cup"),
        ("1 take Ana\n2 does Ana walk*", "expected Ana without the cup, found Ana with it"),
    ],
)
def test_a_string_of_actions_is_done_with_the_object_or_without(done: str, told: str) -> None:
    if told:
        assert told in refusal(CUP, TABLE + done)
    else:
        cast(read_diagram(TABLE + done, "x", CUP.activity), CUP, "x")


def test_what_is_struck_lies_and_is_in_nobodys_hands(wandering) -> None:
    assert "expected the cup to lie, found Ana with it. Let it be put down before, or" in (
        refusal(CUP, TABLE + "1 take Ana\n2 flick Bo at goal")
    )
    told = refusal(CUP, TABLE + "1 toss Ana at goal")
    assert "Let Ana take it, or be given it, before. What is struck where it lies" in told
    acts = acted(wandering, TABLE + "1 walk Ana\n1 walk Bo\n2 flick Ana at goal\n")
    (struck,) = acts.possessions
    assert (struck.is_struck, struck.left) == (True, "send")
    upright = np.zeros((struck.until + 30, 21, 4), np.float32)
    upright[..., 0] = 1.0
    stand = Motion(upright, np.zeros((len(upright), 3), np.float32))
    ball, moved = fly(acts, [stand, stand])
    lying = ball.positions[: struck.until + 1]
    np.testing.assert_allclose(lying, np.broadcast_to([2.0, 0.74, 0.0], lying.shape))
    assert set(ball.holder) == {-1}
    assert moved == [stand, stand]
    assert [(sent.frame, sent.target) for sent in ball.sent] == [(struck.until, "goal")]
    stand.root_positions[struck.until - 5] = 2.0, 0.0, 0.0  # a limb is nearest to the cup then
    assert [sent.frame for sent in fly(acts, [stand, stand])[0].sent] == [struck.until - 5]


def test_what_is_sent_flies_to_who_takes_it_within_a_moment() -> None:
    sent = Possession(0, 10, 10, left="send", aim=Aim("goal", (0.0, 1.0, 9.0), 3.0, True))
    upright = np.zeros((90, 21, 4), np.float32)
    upright[..., 0] = 1.0
    stands = [Motion(upright, np.full((90, 3), z, np.float32)) for z in (0.0, 6.0)]
    lies = Aim("spot", (0.0, 0.1, 0.5))
    for since, misses in ((30, 0), (80, 1)):
        acts = ThingActs((sent, Possession(1, since, 89)), Thing("ball"), lies)
        ball, _ = fly(acts, stands)
        assert len(ball.sent) == misses
        assert ball.holder[since] == 1
    aimless = Possession(0, 70, 75, left="send")
    acts = ThingActs((sent, aimless, Possession(1, 85, 89)), Thing("ball"), lies)
    assert [one.frame for one in fly(acts, stands)[0].sent] == [10]  # what was sent at nothing
    lies = Aim("spot", (0.4, 0.1, 0.0))
    walker = Motion(upright, np.zeros((90, 3), np.float32))
    walker.root_positions[:, 0] = np.linspace(-1.4, 4.0, 90)  # nearest to the ball after frame 10
    for since in (12, 14, 30):  # taken again before the foot would be nearest
        acts = ThingActs((sent, Possession(1, since, 89)), Thing("ball"), lies)
        ball, _ = fly(acts, [walker, stands[1]])
        assert np.isfinite(ball.positions).all()
        assert ball.holder[since] == 1
    put = Possession(1, 0, 12, left="put", aim=lies)
    late = replace(sent, since=15, until=15)
    ball, _ = fly(ThingActs((put, late), Thing("ball")), [walker, stands[1]])
    assert all(one.frame > 12 for one in ball.sent)
    caught, _ = fly(ThingActs((sent, Possession(1, 30, 89)), Thing("ball"), lies), stands)
    ahead = np.diff(caught.positions[10:31, 2])
    np.testing.assert_allclose(ahead, ahead[0])


def test_what_flies_to_somebody_is_struck_by_them_and_rolls_from_foot_to_foot() -> None:
    aims = [Aim("ABO"[n], width=0.25, player=n) for n in (0, 1)]
    serve = Possession(0, 10, 10, left="send", aim=aims[1])
    back = Possession(1, 40, 40, left="send", aim=aims[0])
    upright = np.zeros((90, 21, 4), np.float32)
    upright[..., 0] = 1.0
    stands = [Motion(upright, np.full((90, 3), z, np.float32)) for z in (0.0, 6.0)]
    acts = ThingActs((serve, back, Possession(0, 70, 89)), Thing("ball"), Aim("s", (0.0, 0.1, 0.5)))
    ball, _ = fly(acts, stands)
    assert set(ball.holder[:70]) == {-1}
    assert ball.sent == ()  # all that was sent was struck or caught
    assert [(who, frame) for who, frame, _ in ball.met] == [(0, 10), (1, 40)]
    limbs = motion_positions(stands[1])[0][40]
    assert np.linalg.norm(limbs - ball.positions[40], axis=1).min() < 1e-6
    np.testing.assert_allclose(np.diff(ball.positions[10:41, 2], 2), 0.0, atol=1e-6)
    kicks = [replace(stand, root_positions=stand.root_positions.copy()) for stand in stands]
    for stand in kicks:
        stand.root_positions[:, 1] = 0.9
    acts = ThingActs((serve, back), Thing("ball"), Aim("s", (0.0, 0.1, 0.1)))
    heights = fly(acts, kicks)[0].positions[10:41, 1]
    assert max(heights) < 0.2  # it does not leave the ground


def test_what_two_take_is_between_them_until_one_puts_it_down(wandering) -> None:
    acts = acted(
        wandering,
        TABLE + "1 take Ana\n1 take Bo\n2 drink Ana\n2 drink Bo\n3 put_it Ana\n3 put_it Bo\n",
    )
    (both,) = acts.possessions
    ((helper, since, until),) = both.helpers
    assert {both.player, helper} == {0, 1}
    assert both.since <= since < until <= both.until
    n_frames = both.until + 30
    upright = np.zeros((n_frames, 21, 4), np.float32)
    upright[..., 0] = 1.0
    stands = [
        Motion(upright, np.tile(np.float32([x, 0.9, 0.0]), (n_frames, 1))) for x in (-0.6, 0.6)
    ]
    lies = Aim("table", (0.0, 0.74, 0.0))
    ball, moved = fly(replace(acts, lies=lies, thing=Thing("sofa", 0.6)), stands)
    middle = (since + until) // 2
    assert abs(ball.positions[middle, 0]) < 0.02
    for motion in moved:  # both have their hands on it
        apart = palms(motion_positions(motion)[0])[middle] - ball.positions[middle]
        assert np.linalg.norm(apart, axis=1).max() < 0.4
    far = [stands[0], replace(stands[1], root_positions=stands[1].root_positions + 9.0)]
    met = fly(replace(acts, lies=lies, thing=Thing("sofa", 0.6)), far)[0].met
    assert {who: apart > 5.0 for who, _, apart in met} == {0: False, 1: True}


def test_a_time_that_is_asked_for_does_not_change_the_receiver(wandering) -> None:
    text = "player Cid at -2 0\n1 take Ana\n2 give_it Ana to Bo\n3 walk Cid\n4 drink Bo\n"
    for timed in ("", "step 3 comes 1 s after 2"):
        acts = acted(wandering, TABLE + text + timed)
        assert [("Ana", "Bo", "Cid")[one.player] for one in acts.possessions] == ["Ana", "Bo"]


TAG = read_motion_grammar(
    """
    start S
    verb chase = run then touch on partner
    verb walk = run to X Z
    S -> run | touch | run S | touch S
    run := "run"
    touch := "touch" event contact when asked
    touch: distance(receiver, <= 1 m)
    """,
    "tag",
)


def test_what_needs_somebody_who_is_named_is_done_when_asked() -> None:
    unasked = replace(TAG, terminals=tuple(replace(one, asked=False) for one in TAG.terminals))
    assert refusal(unasked, "player A at 0 0\nplayer B at 1 0\n1 touch A with B").endswith(
        "whom the rule distance of touch is about, found none. Write 'when asked' behind the words"
        " of touch, or take the rule out of the grammar."
    )


@pytest.mark.parametrize(
    ("drawn", "asked", "starts"),
    [
        ("1 chase A on B\n2 walk A to 5 0", "(run)*(touch)(run)*", [0, 0]),
        ("1 walk B to 1 0\n2 chase A on B", "(touch)", [0, 0]),  # B is there by then
        ("1 walk A to 4 0\n2 touch A with B", "(run)*(touch)", [0, 0]),  # comes nearer first
        ("1 walk A to 8 0\n2 touch A with B", "(run)*(touch)", [0, 0, 1]),
    ],
)
def test_who_acts_with_somebody_far_away_goes_there(
    drawn: str, asked: str, starts: list[int]
) -> None:
    diagram = read_diagram(f"player A at 0 0\nplayer B at 9 0\n{drawn}\n", "x", TAG.activity)
    assert "".join(map(str, expressions(diagram)["A"])) == asked
    trees = cast(diagram, TAG, "x")
    rows = bind(diagram, TAG, trees).rows
    places = rows[(rows["kind"] == POSITION) & (rows["player"] == 0)]
    assert places["first"][places["moment"] == AT_START].tolist() == starts
    to_somebody = places[places["target"] >= 0]
    assert to_somebody["moment"].tolist() == [AT_END] * asked.startswith("(run)*(touch)(run)")


def test_a_string_of_actions_is_spelt_out_exactly() -> None:
    diagram = read_diagram(PAIR + "1 does Lea bow then step* then turn | bow", "x", DANCE.activity)
    (asked, _) = expressions(diagram).values()
    assert "".join(map(str, asked)) == "(bow)(step)*(turn|bow)"
    assert cast(diagram, DANCE)["Lea"].leaves() == ("bow", "step", "turn")
    assert set(exact_actions(diagram, DANCE, "Lea")) == {"step", "turn", "bow"}
    assert exact_actions(diagram, DANCE, "Finn") == ()
    assert "1 does Lea bow then step* then turn | bow" in format_diagram(diagram)


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("verb glide = slide", "expected an action declared with ':=', found 'slide'."),
        ("verb glide step", "expected '=', found 'step'. Write 'verb move = walk | run to X Z'"),
        ("role partner", "expected another name, found 'partner'. 'partner' has its own meaning"),
        ("object cup\nobject box", "expected one object, found 'box'. The grammar has 'cup'"),
        ("a: keep(cup)", "expected the object, found 'cup'. Declare cup in a line of its own."),
        ("place goal size 900 m", "expected 0.01 to 20 m, found '900'. Correct the size."),
        ("ground 1 x 4", "expected 2 to 100 metres, found '1'."),
        ("rest sleep", "expected an action declared with ':=', found 'sleep'."),
        ("a answers b", "expected an action declared with ':=', found 'b'."),
        ("b := 'x' event deepest(head)", "expected one of lowest, highest, nearest before '('"),
        (
            "b := 'x'\na answers b\nb answers a",
            "x.grammar:4:1: expected answers that come to an end, found that b is answered by a",
        ),
        ("b := 'x'\na: direction(c)", "expected a place or a role, found 'c'."),
        ("role c\nrest c", "expected an action declared with ':=', found 'c'. c is a role: name"),
        ("b := 'x' event lowest(nose)", "expected a joint (pelvis, l_hip,"),
    ],
)
def test_slips_in_a_grammar_are_told_with_line_and_column(line: str, told: str) -> None:
    text = f'start S\nS -> a\na := "a"\n{line}\n'.replace("'x'", '"x"')
    with pytest.raises(SceneError) as caught:
        read_motion_grammar(text, "x.grammar")
    assert told in str(caught.value)
    assert str(caught.value).startswith("x.grammar:")


def test_instants_are_found_in_the_motion() -> None:
    joints = np.zeros((5, 21, 3))
    joints[:, body.INDEX["head"], 1] = 1.6, 1.5, 1.0, 1.2, 1.6
    joints[:, body.INDEX["r_wrist"], 1] = 1.0, 1.0, 1.5, 1.6, 1.0
    joints[:, body.INDEX["r_wrist"], 2] = 0.2, 0.3, 0.5, 0.7, 0.2
    assert found_instant("lowest(head)", joints) == 2
    assert found_instant("highest(r_wrist)", joints) == 3
    assert found_instant("nearest(r_wrist, partner.head)", joints) == 3
    assert found_instant("nearest(r_wrist, head)", joints) == 1


FIGHT = read_motion_grammar(
    """
    start S
    S -> punch | kick | parry | duck | punch S | kick S | parry S | duck S
    punch := "punch" event contact
    kick := "kick" event contact
    parry := "parry" event contact
    duck := "duck" event lowest(head)
    parry, duck answers punch | kick after 0.1 s
    """,
    "fight",
)


def answers_of(red: str, blue: str, drawn: str = "") -> list[tuple[int, str, list[int]]]:
    """Of every act and every unasked answer: its kind, whose rule, and the actions meant."""
    text = f"red R at 0 0\nblue B at 1 0\n{drawn}"
    diagram = read_diagram(text, "x", FIGHT.activity)
    trees = [parse(FIGHT.started(), actions.split()) for actions in (red, blue)]
    table = bind(diagram, FIGHT, trees)
    rows = [row for row in table.rows if row["kind"] in (SYNCHRONISATION, UNMET)]
    return [
        (
            int(row["kind"]),
            f"{table.players[row['player']]}{row['first']}",
            table.partners[row["partner_first"] : row["partner_last"]].tolist(),
        )
        for row in rows
    ]


def test_answers_are_one_to_one_and_in_order() -> None:
    assert answers_of("punch kick", "parry duck") == [
        (SYNCHRONISATION, "R0", [0]),
        (SYNCHRONISATION, "R1", [1]),
    ]
    two = answers_of("punch", "duck duck")  # for one punch: the second answers nothing
    assert two == [(SYNCHRONISATION, "R0", [0]), (UNMET, "B1", [])]
    assert (UNMET, "R1", []) in answers_of("punch kick", "parry")


def test_a_drawn_answer_is_that_of_its_step() -> None:
    drawn = "1 punch R on B\n2 kick R on B\n2 duck B\n"
    assert answers_of("punch kick", "parry duck", drawn)[:2] == [
        (SYNCHRONISATION, "R0", [0]),
        (SYNCHRONISATION, "R1", [1]),
    ]


def test_an_answer_that_is_not_drawn_is_asked_for_at_the_step_of_its_act() -> None:
    drawn = "red R at 0 0\nblue B at 1 0\n1 punch R on B\n2 kick R on B\n2 duck B\n3 kick B on R\n"
    asked = expressions(read_diagram(drawn, "x", FIGHT.activity))
    assert ["".join(map(str, asked[name])) for name in "RB"] == [
        "(punch)(kick)(parry|duck)",
        "(parry|duck)(duck)(kick)",
    ]


def test_an_answer_of_somebody_else_is_drawn_in_the_step_of_its_act() -> None:
    players = "red R at 0 0\nblue B at 1 0 guards R\ngreen G at 9 9\n"
    drawn = read_diagram(f"{players}1 punch R\n1 duck G\n2 kick R\n", "x", FIGHT.activity)
    asked = expressions(drawn)  # B guards R, but G ducks the punch
    assert ["".join(map(str, asked[name])) for name in "RBG"] == [
        "(punch)(kick)",
        "(parry|duck)",
        "(duck)",
    ]
    trees = [parse(FIGHT.started(), one.split()) for one in ("punch kick", "parry", "duck")]
    table = bind(drawn, FIGHT, trees)
    rows = table.rows[table.rows["kind"] == SYNCHRONISATION]
    assert [(int(row["first"]), int(row["partner"])) for row in rows] == [(1, 1), (0, 2)]


@pytest.mark.parametrize(
    ("lines", "asked"),
    [
        ("1 punch R on B\n1 duck G", ["(punch)", "", "(duck)"]),  # aimed at B, whom G protects
        ("1 punch R on B\n1 duck G on R", ["(punch)", "", "(duck)"]),
        ("1 punch R on B\n1 duck G\n1 parry B", ["(punch)", "(parry)", "(duck)"]),
        ("1 punch R on G\n1 duck G\n1 kick B on R", ["(punch)(parry|duck)", "(kick)", "(duck)"]),
    ],
)
def test_who_is_named_answers_unless_only_others_are_drawn_to(lines: str, asked: list) -> None:
    players = "red R at 0 0\nblue B at 1 0\ngreen G at 9 9\n"
    drawn = expressions(read_diagram(players + lines, "x", FIGHT.activity))
    assert ["".join(map(str, drawn[name])) for name in "RBG"] == asked


def test_in_a_rally_of_four_each_hits_on_to_whom_they_like() -> None:
    rally = Answers(("hit", "take"), ("serve", "hit"), 0.9)
    serve, hits = [(0, 1, 1)], [[], [(0, 2, 2)], [(0, 3, 3)], [(0, 4, 0)]]
    acts, replies = [serve, *hits[1:]], [[(1, 5, 3)], *hits[1:]]
    assert set(answered(rally, acts, replies)) == {
        ((0, 0), (1, 0)),
        ((1, 0), (2, 0)),
        ((2, 0), (3, 0)),
        ((3, 0), (0, 1)),
    }
    ((act, _),) = answered(rally, [[]] * 4, [[], [(0, 2, 2)], [], []])  # nothing came to them
    assert act == (2, -1)


def test_pairs_are_as_many_as_possible() -> None:
    assert aligned([(0, 1), (1, 2)], [(5, 1)]) == [(0, 5), (1, -1)]
    assert aligned([], [(3, -1)]) == [(-1, 3)]
    assert [pair for pair in aligned([(0, -1)] * 3, [(7, -1)] * 3) if -1 not in pair] == [
        (0, 7)
    ] * 3
