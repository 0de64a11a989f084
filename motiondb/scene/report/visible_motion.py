"""Visible faults of a scene that no rule covers: feet, steps, speed, limbs, guards.

The allowed range of an action is measured on the captures of the database that show it
(:func:`natural_ranges`): how long both feet are in the air, how far apart they are, how fast the
body travels. Editing changes all of this a little, so the limits are somewhat wider. Motion beyond
them is impossible: people do not walk with both feet in the air.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from motiondb.body import retarget
from motiondb.body.features import runs
from motiondb.generate.contact import find_contacts, foot_heights
from motiondb.records import FloatArray, Motion
from motiondb.scene.clips.clips import ClipLibrary
from motiondb.scene.energy import rule_table as kinds
from motiondb.scene.energy.rule_table import RuleTable
from motiondb.scene.polish.placed import Placed
from motiondb.scene.polish.seam_steps import LIFTED
from motiondb.scene.report.gait import (
    SPEED_FRAMES,
    GaitRange,
    airborne,
    foot_jump,
    gait_range,
    on_the_ground,
    step_lengths,
    travel_speeds,
)
from motiondb.scene.report.near_limbs import limb_distances
from motiondb.scene.report.report_records import (
    GuardReport,
    ImpossibleMotion,
    JumpReport,
    LimbReport,
)
from motiondb.scene.timing.time_editing import SLOWEST
from motiondb.scene.timing.timeline import Timeline, moment_frames
from motiondb.scene.timing.waiting import ON_GUARD

WAITING = "waiting"  # Name of the time between the actions of a player
STANDING = GaitRange(airborne=0, step=0.8, speed=0.8)
"""The allowed range of standing, which includes small steps."""
AIR_SLACK = 3
"""Frames in the air beyond those of the captures (as long as time may stretch them). Less than 4
frames are not visible, and blends lift feet for as long."""
SPEED_FACTOR, SPEED_SLACK = 1.5, 0.25
"""An action may be this many times as fast as in its captures, plus so many m/s. A clip may be
stretched by 1.3, and time by 1.25; both together look wrong."""
STEP_FACTOR, STEP_SLACK = 1.3, 0.1
"""An action's steps may be this many times as long as in its captures, plus so many m: the stretch
of a clip."""
JUMP_LIMIT = 0.15
"""Displacement of a planted foot within 0.3 s, m, that is clearly visible. Chosen by
hand; smaller ones are reported but not refused."""
NEAR_LIMBS = 0.05
"""Distance between the axes of bones, m, below which limbs count as near: half a limb's width."""
CROSSING = 0.01  # Distance between the axes of bones, m, below which limbs pass through each other
_BLEND = 5  # Frames around a seam in which either neighbour's limits hold: half a blend


def natural_ranges(
    library: ClipLibrary, motions: Mapping[str, Motion], actions: set[str]
) -> dict[str, GaitRange]:
    """Return the gait of each of some actions in all captures that the library has of it."""
    ranges = {WAITING: STANDING}
    joints: dict[str, FloatArray] = {}
    for action in sorted(actions):
        intervals: dict[str, set[tuple[int, int]]] = {}
        for entry in library.of(action):
            source = library.source[entry]
            intervals.setdefault(source.capture, set()).add((source.start, source.end))
        gait = GaitRange()
        for capture, shown in intervals.items():
            if capture not in joints:
                joints[capture] = retarget.motion_positions(motions[capture])[0]
            gait = gait.including(gait_range(joints[capture], sorted(shown)))
        ranges[action] = gait
    return ranges


def shown_actions(placed: Placed, actions: Sequence[str]) -> list[str]:
    """Return the action of a player at every frame, or :data:`WAITING`."""
    waits = ["waits" in edit.split(", ") for edit in placed.edits]
    clips = np.asarray(placed.clips).tolist()
    return [WAITING if wait else actions[clip] for wait, clip in zip(waits, clips, strict=True)]


def impossible_gait(
    player: str, joints: FloatArray, labels: Sequence[str], ranges: Mapping[str, GaitRange]
) -> list[ImpossibleMotion]:
    """Return the frames in which a player's gait is impossible for their action.

    Shapes: `joints` (frames, 21, 3), m.
    """
    natural = [ranges[label] for label in labels]
    airborne_limits = _widest([n.airborne for n in natural], _BLEND)
    faults = []
    for start, end in runs(airborne(joints)):
        limit = math.ceil(SLOWEST * float(airborne_limits[start:end].max())) + AIR_SLACK
        if end - start > limit:
            middle = (start + end) // 2
            faults.append(
                ImpossibleMotion(
                    "airborne",
                    (player,),
                    labels[middle],
                    start,
                    end,
                    middle,
                    float(end - start),
                    float(limit),
                    "frames",
                )
            )
    speed_limits = _widest([n.speed for n in natural], _BLEND + SPEED_FRAMES // 2)
    step_limits = _widest([n.step for n in natural], _BLEND)
    for kind, unit, values, limits in (
        ("speed", "m/s", travel_speeds(joints), SPEED_FACTOR * speed_limits + SPEED_SLACK),
        ("step", "m", step_lengths(joints), STEP_FACTOR * step_limits + STEP_SLACK),
    ):
        for start, end in runs(values > limits):
            worst = start + int(np.argmax((values - limits)[start:end]))
            value, limit_there = float(values[worst]), float(limits[worst])
            faults.append(
                ImpossibleMotion(
                    kind, (player,), labels[worst], start, end, worst, value, limit_there, unit
                )
            )
    return faults


def _widest(values: Sequence[float], reach: int) -> FloatArray:
    """Return the largest value within ``reach`` frames on both sides of each."""
    from scipy.ndimage import maximum_filter1d

    return np.asarray(maximum_filter1d(np.asarray(values, dtype=float), 2 * reach + 1))


def planted_feet(
    placed: Placed, joints: FloatArray, motions: Mapping[str, Motion]
) -> NDArray[np.bool_]:
    """Return which feet are planted: array (frames, 2), left and right.

    A foot is planted if it is in contact in the scene, or in the capture that the frame shows and
    not lifted in the scene, or between two such times in a blend without being lifted. While a
    player waits, feet step on their own, and only contacts in the scene count.
    """
    planted, low = find_contacts(joints), foot_heights(joints) <= LIFTED
    known: dict[str, NDArray[np.bool_]] = {}
    words = [edit.split(", ") for edit in placed.edits]
    for frame, edits in enumerate(words):
        if "waits" in edits:
            continue
        capture = placed.captures[int(placed.source_numbers[frame])]
        if capture not in known:
            known[capture] = find_contacts(retarget.motion_positions(motions[capture])[0])
        there = int(np.clip(np.rint(placed.source_frames[frame]), 0, len(known[capture]) - 1))
        contacts = known[capture][there]
        planted[frame] |= low[frame] & (contacts[::-1] if "mirror" in edits else contacts)
    blended = [any(edit.startswith(("blend", "waits")) for edit in edits) for edits in words]
    return on_the_ground(joints, planted, np.array(blended, dtype=bool))


def foot_jumps(placed: Placed, joints: FloatArray, motions: Mapping[str, Motion]) -> JumpReport:
    """Return the largest displacement of a planted foot of a player, beside their captures'."""
    jump = foot_jump(joints, planted_feet(placed, joints, motions))
    source = 0.0
    for capture in placed.captures:
        there = retarget.motion_positions(motions[capture])[0]
        source = max(source, foot_jump(there, find_contacts(there)).metres)
    foot = ("left", "right", "")[jump.foot]
    return JumpReport(placed.player, foot, jump.metres, jump.start, jump.end, source)


def impossible_jump(jump: JumpReport, labels: Sequence[str]) -> list[ImpossibleMotion]:
    """Return a jump of a planted foot as impossible motion if it is beyond the limit.

    The limit is :data:`JUMP_LIMIT`, or that of the stretched steps of the captures, if larger.
    """
    limit = max(JUMP_LIMIT, STEP_FACTOR * jump.source_metres)
    if jump.metres <= limit:
        return []
    return [
        ImpossibleMotion(
            "foot jump",
            (jump.player,),
            labels[jump.end],
            jump.start,
            jump.end + 1,
            jump.end,
            jump.metres,
            limit,
            "m",
        )
    ]


def near_limbs(names: Sequence[str], joints: Sequence[FloatArray]) -> Iterator[LimbReport]:
    """Yield every pair of players whose limbs are less than 5 cm apart at some time."""
    for one, other in combinations(range(len(names)), 2):
        apart = limb_distances(joints[one], joints[other])
        frame = int(np.argmin(apart))
        near = int((apart < NEAR_LIMBS).sum())
        if near:
            yield LimbReport((names[one], names[other]), float(apart[frame]), frame, near)


def crossing_limbs(limbs: Sequence[LimbReport]) -> list[ImpossibleMotion]:
    """Return the pairs of players whose limbs pass through each other."""
    return [
        ImpossibleMotion(
            "limbs",
            pair.players,
            "",
            pair.frame,
            pair.frame + 1,
            pair.frame,
            pair.metres,
            CROSSING,
            "m",
        )
        for pair in limbs
        if pair.metres < CROSSING
    ]


def guard_distances(table: RuleTable, timeline: Timeline) -> list[GuardReport]:
    """Return how far guards are from the players whom they guard, over all frames of the scene."""
    reports: dict[tuple[int, int], GuardReport] = {}
    frames: dict[tuple[int, int], set[int]] = {}
    for row in table.rows:
        player, target = int(row["player"]), int(row["target"])
        guards = table.actions[player][row["first"]] == ON_GUARD
        if row["kind"] != kinds.DISTANCE or target < 0 or not guards:
            continue
        apart = np.linalg.norm(
            timeline.places[player, :, :2] - timeline.places[target, :, :2], axis=1
        )
        looked = frames.setdefault((player, target), set())
        looked.update(moment_frames(row, timeline).tolist())
        near, far = float(row["near"]), float(row["far"])
        frame = int(np.argmax(apart))
        reports[player, target] = GuardReport(
            table.players[player],
            table.players[target],
            near,
            far,
            len(looked),
            float(((apart < near) | (apart > far)).mean()),
            float(apart[frame]),
            frame,
        )
    return list(reports.values())
