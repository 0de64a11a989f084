"""Seams of generated motion: jumps of the root speed, sliding toes, floating, against captures.

Measured on the motion alone, at 30 frames a second on the standard body, by what generation does
not use:

*jump*      largest change of the pelvis's speed over the ground from one frame to the next, m/s,
*toe slip*  mean ground speed of both toes, weighted by their height as in Zhang, Starke, Komura and
            Saito, "Mode-adaptive neural networks for quadruped motion control", TOG 37 (2018),
            v max(2 - 2^(h / H), 0) with H = 2.5 cm, over all frames, cm/s,
*float*     mean height of the lower foot over the ground, cm; *depth*: greatest depth below it, cm,
*lift*      greatest change of height between two rests of a seated pelvis with no standing between
            them, m.

The same is measured on windows of captures as long as those around the seams.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import motiondb
from motiondb.body import body, retarget
from motiondb.database.generating import Generated
from motiondb.records import MOTION_FPS, FloatArray, Motion
from quality_protocol.confidence import mean_of
from quality_protocol.learned_database import learned_database
from quality_protocol.report import Measure, Picture, TaskReport, draw
from quality_tasks.generation_page import page_figure
from quality_tasks.generation_sentences import generate_or_none

PAIRS = (
    "walk then run", "run then walk", "walk then jog", "jog then stop", "run then stop",
    "walk then stop", "walk then jump", "run then jump", "jump then run", "jump then walk",
    "walk then turn left", "walk then turn right", "turn left then walk", "run then turn right",
    "turn around then walk", "walk then sit down", "sit down then stand up", "stand up then walk",
    "sit down then drink", "drink then stand up", "walk then kick", "kick then punch",
    "punch then kick", "box then kick", "kick then walk", "walk then punch", "dance then walk",
    "walk then dance", "dance then jump", "run then duck", "duck then run", "walk then wave",
    "wave then walk", "wash windows then walk", "walk then wash windows", "mop then walk",
    "dribble then walk", "walk then dribble", "dribble then run", "walk backward then walk forward",
    "walk sideways then walk", "hop then walk", "walk then hop", "climb then jump",
    "climb a ladder then walk", "laugh then walk", "walk then laugh", "stretch then jog",
    "jumping jacks then run", "squat then jump", "twist then walk", "walk slowly then run fast",
    "walk then pick up something",
)  # fmt: skip
TRIPLES = (
    "walk, run, jump", "walk then sit down then stand up", "sit down, stand up, walk",
    "run then stop then walk", "walk, turn around, walk", "run, jump, run", "walk, kick, punch",
    "jog, walk, stop", "walk, wave, walk", "dance, walk, sit down", "jump, turn left, run",
    "stand up, walk, run",
)  # fmt: skip
SENTENCES = (*PAIRS, *TRIPLES)
"""Sentences of two and three actions that the captures of CMU show."""
LONG = ("walk for ten seconds", "run for eight seconds", "dribble for ten seconds")
AROUND = 15  # Frames before and after a boundary of two actions: windows of 1 s
LOW = 0.025  # H, metres
SEATED, STANDING = 0.65, 0.8  # Heights of the pelvis, metres
RESTING = 0.15  # Speed of the pelvis at rest, m/s
MOST_JUMP = 0.3  # Target, m/s a frame
SEAT = 0.1  # Metres
_TOES = [body.INDEX[f"{side}_toe"] for side in "lr"]
_ANKLES = [body.INDEX[f"{side}_ankle"] for side in "lr"]
_STANDING_TOE = float(body.LEG_LENGTH + body.ANKLE_HEIGHT + body.OFFSETS[body.INDEX["l_toe"]][1])
_STANDING_TOE -= float(body.LEG_LENGTH)


@dataclass(frozen=True)
class Smooth:
    """Measures of the module's docstring of one motion or window."""

    jump: float
    slip: float
    floating: float
    depth: float


@dataclass(frozen=True, eq=False)
class Seen:
    """One sentence's motion with its measures, as a whole and in the windows around its seams."""

    sentence: str
    made: Generated
    whole: Smooth
    windows: tuple[Smooth, ...]
    lift: float


def measure_smooth(positions: FloatArray) -> Smooth:
    """Jump, toe slip, float and depth of positions (frames, 21, 3), metres."""
    steps = np.diff(positions[:, 0][:, [0, 2]], axis=0) * MOTION_FPS
    jumps = np.abs(np.diff(np.linalg.norm(steps, axis=1)))
    heights = np.maximum(positions[:-1, _TOES, 1] - _STANDING_TOE, 0.0)
    speeds = np.linalg.norm(np.diff(positions[:, _TOES][..., [0, 2]], axis=0), axis=2) * MOTION_FPS
    weights = np.maximum(2.0 - 2.0 ** (heights / LOW), 0.0)
    slip = float(np.mean(speeds * weights)) if len(weights) else 0.0
    feet = foot_heights(positions)
    return Smooth(
        float(jumps.max(initial=0.0)),
        100.0 * slip,
        100.0 * float(np.maximum(feet.min(axis=1), 0.0).mean()),
        100.0 * float(np.maximum(-feet, 0.0).max()),
    )


def foot_heights(positions: FloatArray) -> FloatArray:
    """Heights of the lower of ankle and toe over its place in standing: array (frames, 2), m."""
    ankles = positions[:, _ANKLES, 1] - body.ANKLE_HEIGHT
    return np.minimum(ankles, positions[:, _TOES, 1] - _STANDING_TOE)


def seat_lift(pelvis: FloatArray) -> float:
    """Greatest change of height between rests of a seated pelvis (frames, 3) that never stood."""
    if len(pelvis) < 2:
        return 0.0
    speed = np.linalg.norm(np.gradient(pelvis, axis=0), axis=1) * MOTION_FPS
    lift, last = 0.0, np.nan
    for height, moving in zip(pelvis[:, 1], speed > RESTING):
        if height > STANDING:
            last = np.nan
        elif height < SEATED and not moving:
            lowest = height if np.isnan(last) else last
            lift = max(lift, abs(float(height - lowest)))
            last = lowest
    return lift


def run(data: Path, seed: int) -> TaskReport:
    """All sentences on a database that has learned CMU, and its captures."""
    return measure(learned_database(data, seed), seed)


def measure(database: Path, seed: int) -> TaskReport:
    """The same on a database that has learned."""
    with motiondb.open(database, read_only=True) as db:
        real = [_positions(db.motion(info.name)) for info in db.captures()]
        made = {s: generate_or_none(db, s, seed) for s in (*SENTENCES, *LONG)}
    seen = [see(s, g) for s in SENTENCES if (g := made[s]) is not None]
    long = [see(s, g) for s in LONG if (g := made[s]) is not None]
    return report(seen, long, real, seed)


def report(
    seen: Sequence[Seen], long: Sequence[Seen], real: Sequence[FloatArray], seed: int
) -> TaskReport:
    """The table of all windows and motions beside captures; `real`: their positions."""
    n_real = [p[a : a + 2 * AROUND] for p in real for a in range(0, len(p), AROUND)]
    windows = [measure_smooth(p) for p in n_real if len(p) == 2 * AROUND]
    seams = [window for one in seen for window in one.windows]
    limits = _quantiles(windows, 0.95)
    wholes = [measure_smooth(p) for p in real]
    rows = [
        ("seams, the second around each", *_row(seams, limits, seed)),
        ("captures, every second", *_row(windows, limits, seed)),
        ("generated motions", *_row([o.whole for o in seen], _quantiles(wholes, 0.95), seed)),
        ("captures", *_row(wholes, _quantiles(wholes, 0.95), seed)),
    ]
    return TaskReport(
        "Generation: seams",
        f"{len(seen)} sentences of two and three actions with {len(seams)} seams, and "
        f"{len(real)} captures of the same database, on the standard body at 30 frames a second. "
        "*Jump*: largest change of the pelvis's speed over the ground from one frame to the next, "
        "m/s. *Toe slip*: mean ground speed of the toes, weighted by their height as Zhang et al. "
        "(2018) do, cm/s. *Float*: mean height of the lower foot over the ground, *depth*: "
        "greatest depth of a foot below it, cm. Medians / 95th percentiles; *within*: "
        "share of jumps up to .3 m/s, and of slips up to the captures' 95th percentile. Generation "
        "uses none of these measures.",
        ("what", "jump", "within .3", "toe slip", "within", "float", "depth"),
        tuple(rows),
        (_say_seats(seen), _say_jumps(seen), _say_verdicts(seen), _say_cycles(long)),
        (_draw_worst(seen),),
    )


def _quantiles(of: Sequence[Smooth], share: float) -> FloatArray:
    return np.asarray(np.quantile([list(vars(one).values()) for one in of], share, axis=0))


def _row(of: Sequence[Smooth], limits: FloatArray, seed: int) -> tuple[str | Measure, ...]:
    middle, most = _quantiles(of, 0.5), _quantiles(of, 0.95)
    jump, slip, floating, depth = (f"{a:.2f} / {b:.2f}" for a, b in zip(middle, most))
    calm = mean_of([float(one.jump <= MOST_JUMP) for one in of], seed)
    planted = mean_of([float(one.slip <= limits[1]) for one in of], seed)
    return jump, calm, slip, planted, floating, depth


def _say_jumps(seen: Sequence[Seen]) -> str:
    """The seams that jump by more than the target."""
    told = [
        f"{one.sentence} ({max(w.jump for w in one.windows):.2f})"
        for one in seen
        if max(w.jump for w in one.windows) > MOST_JUMP
    ]
    return f"Sentences with a jump above {MOST_JUMP} m/s at a seam: {'; '.join(told) or 'none'}."


def _say_seats(seen: Sequence[Seen]) -> str:
    lifted = [f"{one.sentence} ({one.lift:.2f} m)" for one in seen if one.lift > SEAT]
    return (
        f"Seated figures that are lifted or lowered by more than {SEAT} m: "
        + ("; ".join(lifted) or "none")
        + "."
    )


def _say_verdicts(seen: Sequence[Seen]) -> str:
    verdicts = Counter(action.shown for one in seen for action in one.made.shown)
    return (
        f"motiondb's judge says that {verdicts[True]} actions are shown, that {verdicts[False]} "
        f"are not, and that {verdicts[None]} cannot be confirmed; of "
        f"{sum(one.made.shows_all for one in seen)} sentences all actions are shown."
    )


def _say_cycles(long: Sequence[Seen]) -> str:
    """How often the frames of a long motion are played."""
    told = []
    for one in long:
        origin = one.made.provenance
        frames = np.column_stack([origin.source_numbers, np.rint(origin.source_frames)])
        _, counts = np.unique(frames, axis=0, return_counts=True)
        told.append(
            f"*{one.sentence}*: {one.made.motion.n_frames / MOTION_FPS:.1f} s from "
            f"{len(origin.sources)} captures, a frame played at most {counts.max()} times"
        )
    return "; ".join(told) + "."


def _draw_worst(seen: Sequence[Seen]) -> Picture:
    """The ten motions whose seams jump or slip most, relative to the targets."""

    def badness(one: Seen) -> float:
        return max(max(w.jump / MOST_JUMP, w.slip / 5.0) for w in one.windows)

    worst = sorted(seen, key=badness, reverse=True)[:10]
    figure = page_figure([(one.sentence, one.made.motion) for one in worst], 1)
    return draw(figure, "quality-seams-worst.png", "The ten worst seams of generated motion")


def see(sentence: str, made: Generated) -> Seen:
    """The measures of a sentence's motion."""
    positions = _positions(made.motion)
    inner = [start for start, _ in made.spans[1:]]
    windows = [positions[max(b - AROUND, 0) : b + AROUND] for b in inner]
    return Seen(
        sentence,
        made,
        measure_smooth(positions),
        tuple(map(measure_smooth, windows)),
        seat_lift(positions[:, 0]),
    )


def _positions(motion: Motion) -> FloatArray:
    return retarget.motion_positions(motion)[0].astype(np.float64)
