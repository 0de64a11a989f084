"""Requests as people type them, and what they ask for."""

from __future__ import annotations

import pytest

from motiondb.language.question.parse import parse
from motiondb.language.question.readings import say
from motiondb.language.requests import without_request
from motiondb.language.vocabulary import split_actions


@pytest.mark.parametrize(
    ("text", "actions"),
    [
        ("Show me clips where someone is drinking while standing", "drink stand"),
        ("I need somebody who jumps over something", "jump over"),
        ("can you find people walking and then sitting down?", "walk | sit down"),
        ("find me a clip of a man doing a cartwheel", "cartwheel"),
        ("give me all the clips that show a kick", "kick"),
        ("I'd like to see a person wave", "wave"),
        ("we are looking for motion clips in which two people dance", "dance"),
        ("is there anyone jumping?", "jump"),
        ("Which recordings have a handstand", "handstand"),
        ("where does she sit down", "sit down"),
        ("Could we please see a slow walk", "slow walk"),
        ("something that looks like swimming", "swim"),
        ("goes for a walk", "walk"),
        ("he went for a quick run", "quick run"),
        ("takes a step forward", "step forward"),
        ("has taken a seat", "sit down"),
        ("gives a high kick", "high kick"),
        ("decides to run away, and is about to fall", "run away | fall"),
        ("goes from lying on the floor to standing", "lie floor | stand up"),
        ("begins seated and ends up kneeling", "sit | kneel"),
        ("walks from the door to the window", "walk door window"),
        ("raises both arms and lowers them", "raise both arm | put both arm down"),
        ("the lower arm swings", "lower arm swing"),
        ("turns counter-clockwise", "turn left"),
        ("walks clockwise", "walk circular right"),
        ("turns 90 degrees clockwise", "turn right"),
        ("turns his body in a clockwise direction", "turn body right"),
        ("turns, walks clockwise", "turn | walk circular right"),
        ("the clockwise hand", "clockwise hand"),
        ("takes tiny steps", "tiny step"),
        ("takes three long strides", "long stride"),
        ("takes two boxes away", "take thebox away"),
        ("goes from a squat into a jump", "squat | jump"),
        ("goes from a bed to a chair", "go bed chair"),
        ("is on his knees, then on one knee", "kneel | kneel"),
        ("walks on his knees", "walk knee"),
        ("paces up and down", "pace | turn around | pace"),
        ("runs up and down the stairs", "run up | down stair"),
        ("turns around and walks back", "turn around | walk"),
        ("turns around and then slowly walks back", "turn around | slowly walk"),
        ("makes a half turn and walks back", "half turn | walk"),
        ("turns left and walks backward", "turn left | walk backward"),
        ("turns left and walks back", "turn left | walk back"),
        ("turns the head and walks back", "turn head | walk back"),
        ("drops to his knees", "kneel down"),
        ("first he walks, second he jumps, third he kicks", "walk | jump | kick"),
        ("he runs, jumps and keeps running", "run | jump | run"),
        ("walks, stops and continues to walk", "walk | stop | walk"),
        ("gets up from lying on the back", "lie down | stand up"),
        ("punch left then right", "punch left hand | punch right hand"),
        ("punch to the left", "punch left"),
        ("goes down on the left knee", "kneel down left knee"),
        ("raises the arms and drops them", "raise arm | put arm down"),
        ("raises an arm and then slowly lowers it", "raise arm | slowly put arm down"),
        ("raises both arms up and down", "raise both arm"),
        # not frames: these are the motion
        ("someone looks for a key", "look key"),
        ("pull ups", "pullup"),
        ("gets up from the floor", "stand up floor"),
        ("plays a guitar", "play guitar"),
        ("picks up a box and takes it", "pick up thebox | take"),
        ("takes a box to her", "take thebox"),
        ("walking scene", "walk scene"),
    ],
)
def test_what_a_request_asks_for(text: str, actions: str) -> None:
    expected = [action.split() for action in actions.split(" | ")]
    assert split_actions(without_request(text)) == expected


def test_a_text_that_is_too_long_for_a_question_is_left_alone() -> None:
    text = "show me a " * 100_000
    assert without_request(text) == text


@pytest.mark.parametrize("text", ["find", "show me", "I want", "clips", "", "where is"])
def test_a_frame_alone_asks_for_nothing_else(text: str) -> None:
    words = [word for action in split_actions(without_request(text)) for word in action]
    assert set(words) <= {"find", "show", "clip", "want"}


@pytest.mark.parametrize(
    ("text", "asked"),
    [
        ("sit-to-stand", "sit, then stand up"),
        ("transition from walking to running", "walking, then running"),
        ("stand-to-sit transition", "stand, then sit down"),
        ("squatting trials at slow cadence", "squatting slowly"),
        ("four examples of a jump", "a jump"),
        ("start to run", "start to run"),
        ("walk to box", "walk to box"),
        ("side to side", "side to side"),
    ],
)
def test_changes_and_named_captures_are_read_as_they_are_meant(text: str, asked: str) -> None:
    assert without_request(text) == asked


@pytest.mark.parametrize(
    ("text", "understood"),
    [
        ("a figure eight walk", "in a figure eight walk"),
        ("standing long jump", "stand still, then jump forward"),
        ("start running from a standstill", "stand still, then run"),
        ("goes from standing to sitting", "stand, then sit down"),
        ("u-turn", "turn 180 degrees"),
        ("jump and land on one foot", "jump, then land one foot"),
        ("bends over to touch the toes", "bend over and touch toe"),
        ("walks up three steps", "walk up step"),
        ("walks three steps up", "walk up 3 steps"),
        ("sits cross-legged", "sit cross-legged"),
        ("hands up and then down", "raise hand up, then put hand down"),
        ("walks with arms spread wide", "walk while hold both arm out to the side"),
        ("hip hop", "hip hop"),
        ("pushed by someone", "push"),
        ("walks on hands and knees", "walk on all fours"),
        ("kick or punch but not both", "kick or punch"),
        ("before jumping he squats", "squat, then jump"),
        ("jump, pause, jump", "jump, then stand still, then jump"),
        ("several jumps", "jump at least 2 times"),
        ("walk in the beginning and run at the end", "walk, then run"),
        ("hop on left then hop on right", "hop left leg, then hop right leg"),
        ("starts with a walk and ends with a jump", "walk, then jump"),
        ("makes a u turn", "turn 180 degrees"),
        ("runs away from rest", "stand still, then run away"),
        ("jumps high from a standstill", "stand still, then jump high"),
        ("starts from rest and runs", "stand still, then run"),
        ("gets up from rest", "stand up rest"),
        ("he walks from rest area to rest area", "walk rest area rest area"),
        ("walks with hands on the wheel", "walk hand wheel"),
        ("walks with arms behind", "walk while hold arm behind back"),
        ("arms stretched out of the window", "arm stretch out window"),
        ("walks with arms out in front", "walk while hold both arm out in front"),
        ("stands in a T-pose", "stand while hold both arm out to the side"),
        ("extends the right arm forward", "hold right arm out in front"),
        ("raise the arms to the sides", "hold both arm out to the side"),
        ("swings the arms forward and back", "swing arm forward back"),
        ("arms at his sides", "arm side"),
        ("walks low and slow", "walk slowly while stay low"),
        ("walks in a low crouch", "walk while stay low"),
        ("crouch walk backwards", "walk backward while stay low"),
        ("walks low for 2 s", "walk while (stay low for 2 s)"),
        ("runs bent-kneed", "run bend knee"),
        ("hands up and down the stairs", "hand up and down stair"),
        ("jumps high five times", "jump high 5 times"),
        ("attempts to touch the floor", "touch floor"),
        ("walks to cover the distance", "walk cover distance"),
        ("hand on hip stepping left", "hand hip step left"),
        ("a hand on her hip hop", "hand hip hop"),
        ("in an eight minute dance", "dance for 480 s"),
        ("in an 8 shape", "in a figure eight"),
        ("arms cross-armed", "arm cross arm"),
        ("thumbs up", "thumbs up"),
        ("stands with arms akimbo", "stand while hold arm hip"),
        ("jumps from rest twice", "stand still, then (jump 2 times)"),
        ("a landing on one foot", "land one foot"),
        ("comes down on both feet", "land both foot"),
        ("comes down on one knee", "kneel down"),
        ("jumps with knees up", "jump while raise knee"),
        ("lifts both arms above the head", "raise both arm above the head"),
        ("walk, hands not on hips", "walk, not both hand hip"),
        ("puts his hands up", "raise hand"),
        ("put the hands on the hips", "put both hand hip"),
        ("throws jabs", "jab"),
        ("throws the ball", "throw ball"),
        ("sits down, waits for 3 s and stands up", "(sit down for 3 s), then stand up"),
        ("walks, waits, walks on", "walk, then stand still, then walk"),
        ("waits two seconds, then runs", "(stand still for 2 s), then run"),
        ("walk without arms out to the side", "walk, not hold both arm out to the side"),
        ("someone waits before jumping", "stand still, then jump"),
        ("put your hands up in the air", "raise hand above the head"),
        ("walk that does not end with a jump", "walk, not jump"),
        ("a walk ending with a jump", "walk, then jump"),
        ("starts walking, ends running", "start walk, then run"),
        ("after turning around he walks back", "turn around, then walk back"),
        ("after putting the box down she leaves", "put a box down, then leave"),
        (
            "left kick, then a right roundhouse kick",
            "kick left foot, then roundhouse kick right foot",
        ),
        ("a right hook", "hook right hand"),
        ("step to the left and kick", "step left and kick"),
        ("turn left, kick right", "turn left, then kick right"),
        ("jump off the left foot", "jump while take off from left foot"),
        ("takes off from one foot", "take off from one foot"),
        ("run up and jump", "run and jump"),
        ("give me all the jumps", "jump"),
        ("every kick", "kick"),
        ("on all fours", "on all fours"),
        ("need 3 walking clips", "walk"),
        ("the take with the most kicks", "kick most often"),
        ("who jumps the most", "jump most often"),
        ("the fewest turns", "turn least often"),
        ("the most boxes", "box"),
        ("walks with the arms held out in front", "walk while hold both arm out in front"),
    ],
)
def test_phrases_of_manner_are_read_as_what_is_measured(text: str, understood: str) -> None:
    assert say(parse(without_request(text)).tree) == understood


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("ends with a jump", "at the end"),
        ("clips that begin with a squat", "at the start"),
        ("kick or punch but not both", "but not both"),
        ("the take ends sitting", "at the end"),
        ("a clip starts standing", "at the start"),
        ("clips ending with a jump", "at the end"),
        ("does the take end with a jump?", "at the end"),
        ("ends with a jump or a kick", "at the end"),
        ("never ends with a jump", "at the end"),
        ("starts in a T-pose", "at the start"),
        ("jump in the beginning", "at the beginning"),
        ("wave at the beginning and the end", "at the beginning and the end"),
        ("wave in the last few seconds", "in the last few seconds"),
        ("wave during the first two seconds", "during the first two seconds"),
        ("wave, never in the first 2 s", "never in the first 2 s"),
        ("jump, but not at the end", "but not at the end"),
        ("runs faster and faster", "faster and faster"),
        ("walks, getting slower", "getting slower"),
        ("sits down, waits and stands up", "for a while"),
        ("kick at 3 s", "at 3 s"),
        ("jump around second 5", "around second 5"),
        ("run until 3 s", "until 3 s"),
        ("walk from 2 to 4 s", "from 2 to 4 s"),
        ("sits between 2 s and 6 s", "between 2 s and 6 s"),
        ("kicks 3 seconds in", "3 seconds in"),
        ("a kick halfway through", "halfway through"),
        ("the last two seconds of a jump", "the last two seconds of"),
        ("walk at 3-5 s", "at 3-5 s"),
        ("jump at 500 ms", "at 500 ms"),
        ("how many jumps are there?", "how many"),
        ("jump right after the turn", "immediately"),
        ("walks the whole time", "the whole time"),
        ("more jumps than kicks", "than kicks"),
        ("runs faster than walking", "than walking"),
    ],
)
def test_what_a_single_action_does_not_honour_is_told(text: str, told: str) -> None:
    assert [part.text for part in parse(without_request(text)).not_used] == [told]
