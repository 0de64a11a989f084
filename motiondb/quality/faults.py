"""What is not as a body moves: jumps, swaps, frozen frames, noise, slides, and the like.

Jumps are told from accelerations, so their threshold in metres grows with the square of the time
between frames: a step of 12 cm that the steps around it do not explain is 430 m/s2 at 60 frames a
second, more than any joint of a person reaches; at 30 a second a punch reaches it. Where a jump
also changes the length of a bone, it is told at any rate.
"""

from __future__ import annotations

import numpy as np

from motiondb.body import body
from motiondb.body.features import runs
from motiondb.quality.measured import (
    I,
    Measured,
    P,
    joined,
    long_runs,
    residual,
    smoothed,
    times,
    unexplained,
)
from motiondb.records import FAULT, NEEDS, BoolArray, Finding, FloatArray

ROOT_STEP, ROOT_ACCELERATION = 0.06, 100.0
PUSH = 30.0  # m/s2, level or down: legs and gravity can do less
TURN = 15.0  # Degrees
JOINT_STEP, JOINT_ACCELERATION = 0.08, 400.0
BONE, RIGID = (0.06, 3.0), (0.03, 10.0)  # Metres, and times as far as a bone is off usually
AT_ONCE = 0.6  # Of what a rigid bone is off, that comes or goes in 0.05 s: a neck curls slowly
KNEE = 0.1  # Of a leg by which a knee is bent: markers let straight ones look bent by 0.065
BACK = 0.14
END, END_TIMES, _ENDS = 0.10, 6.0, 4  # Metres, times of what is beside, frames
SPIKE, SPIKE_FPS = 0.05, 25.0  # at fewer frames a second an arm is off in one by itself
SWAP, SWAP_SHARE = 0.20, 0.4
FROZEN, FROZEN_SECONDS = 2e-6, 0.1
HELD_SECONDS, HELD_WAY = 0.2, 0.03
_HELD = ("l_wrist", "r_wrist", "l_elbow", "r_elbow", "l_knee", "r_knee", "head")
NOISE, JOINT_NOISE = 0.0045, 0.010
POSE_SECONDS = 0.15
SINKS = ((0.055, 0.15), (0.045, 0.25), (0.04, 0.5))
SLIDES, TREADMILL, BELT = 0.13, 0.25, 0.6
SLIDE_SECONDS, SLIDE_ALIKE, SWINGS = 1.2, 0.3, 1.0  # m/s of a foot that swings low
SLIDE_MANY = (1.8, 0.8, 0.5)  # Seconds of many stances, share of them that drifts alike, how near
FLOATS = 0.055
RISES = 0.06
_WHOLE = 9  # Joints that jump at once in a seam of all the body
_BONES = tuple(
    (parent, joint)
    for joint, parent in enumerate(body.PARENTS)
    if parent >= 0 and joint != I["spine"] and not {parent, joint} & {I["l_collar"], I["r_collar"]}
)
"""From joint to joint; collars, and the spine over the pelvis, may be estimated."""
_WORDS = {"l": "left", "r": "right"}


def faults(m: Measured) -> list[Finding]:
    """Everything that is not as a body moves, by its beginning."""
    swaps = _swaps(m)
    jumps = [each for each in _jumps(m) if not any(_explains(swap, each) for swap in swaps)]
    found = jumps + swaps + _names(m) + _frozen(m) + _noise(m) + _rest_pose(m, jumps)
    found += _sinks(m) + _slides(m) + _gaps(m) + _through(m) + _off_floor(m)
    return sorted(found, key=lambda each: each.start)


def said(
    kind: str,
    sentence: str,
    span: tuple[float, float],
    measured: tuple[float, str, float],
    part: str = "body",
    place: FloatArray | None = None,
    family: str = FAULT,
) -> Finding:
    """A finding from when to when (s), with its measure, unit and threshold."""
    measure, unit, threshold = measured
    at = None if place is None else (float(place[0]), float(place[1]), float(place[2]))
    words = f"{sentence}, {times(*span)}"
    return Finding(kind, family, *span, float(measure), unit, threshold, part, words, at)


def _jumps(m: Measured) -> list[Finding]:
    """Jumps of the root (seams), and of single joints."""
    e = m.steps.copy()
    dt2 = 1.0 / m.fps**2
    root, joint = max(ROOT_STEP, ROOT_ACCELERATION * dt2), max(JOINT_STEP, JOINT_ACCELERATION * dt2)
    out = []
    lost = _near(m.missing)
    e[lost] = 0.0
    steps = (e[:, 0] > root) | ((e > root).sum(axis=1) >= _WHOLE)
    turns, pushes = np.where(lost, 0.0, _turns(m)), np.where(lost, 0.0, _pushes(m))
    seam = steps | (turns > TURN)
    whole = e.copy()
    e[_near(seam)] = 0.0
    edge = np.where(lost[:, None], 0.0, _at_ends(m))
    bad = (e > joint) | _there_and_back(m) | (edge > 0.0)
    e = np.maximum(e, edge)
    spike = np.where((m.spikes > SPIKE) & (m.fps >= SPIKE_FPS), m.spikes, 0.0)
    bad |= spike > 0.0
    e = np.maximum(e, spike)
    off, long = _bones(m)
    for number, ends in enumerate(_BONES):
        for a, b in runs(long[:, number]):
            edges = [t for t in (a, b) if 0 < t < m.n]
            joint_ = max(ends[::-1], key=lambda end: m.steps[edges, end].sum())
            bad[a:b, joint_] = True
            e[a:b, joint_] = np.maximum(e[a:b, joint_], off[a:b, number])
    bad[_near(seam)] = False
    pushes[_near(seam | bad.any(axis=1))] = 0.0  # a limb that jumps moves the centre of mass, too
    for a, b in joined(runs(seam | (pushes > PUSH)), 0.2 * m.fps):
        if turns[a:b].max() > TURN and whole[a:b, 0].max() < root:
            size = float(turns[a:b].max())
            words, measured = f"the whole body turns by {size:.0f} degrees", (size, "degrees", TURN)
        elif seam[a:b].any():
            size = float(max(whole[a:b, 0].max(), np.median(whole[a:b].max(axis=0))))
            words, measured = f"the whole body jumps by {100 * size:.0f} cm", (size, "m", root)
        else:
            size = float(pushes[a:b].max())
            words, measured = f"the whole body is thrown by {size:.0f} m/s2", (size, "m/s2", PUSH)
        out.append(said("seam", words, _span(m, a, b), measured, "body", m.points[a, 0]))
    bad[:, [I["l_collar"], I["r_collar"]]] = False
    for number in np.flatnonzero(bad.any(axis=0)).tolist():
        for a, b in joined(runs(bad[:, number]), 0.25 * m.fps):
            size = float(e[a:b, number].max())
            name = body.JOINTS[number]
            words = f"the {_joint(name)} jumps by {100 * size:.0f} cm"
            place = m.points[a, number]
            least = min(joint, SPIKE) if spike[a:b, number].any() else joint
            least = min(least, END) if edge[a:b, number].any() else least
            least = min(least, RIGID[0] * m.k) if size < least else least
            out.append(said("jumps", words, _span(m, a, b), (size, "m", least), name, place))
    return out


def _turns(m: Measured) -> FloatArray:
    """By how much hips and shoulders turn in a frame alone, from above (frames,), degrees."""
    out = []
    for joint in ("hip", "shoulder"):
        across = m.at(f"l_{joint}") - m.at(f"r_{joint}")
        flat = across[:, 2] + 1j * across[:, 0]
        is_level = np.abs(flat) > 0.6 * np.linalg.norm(across, axis=1)
        turn = unexplained(np.angle(flat[1:] * flat[:-1].conj()))
        out.append(np.where(is_level, np.degrees(np.angle(np.exp(1j * turn))), 0.0))
    return np.where(out[0] * out[1] > 0.0, np.minimum(*np.abs(out)), 0.0)


def _pushes(m: Measured) -> FloatArray:
    """By how much the centre of mass is pushed along the ground or down (frames,), m/s2."""
    x, y, z = smoothed(m.com, m.fps, 0.1, (2,))[0].T
    return np.maximum(np.hypot(x, z), -y)


def _there_and_back(m: Measured) -> BoolArray:
    """Joints that step away and, within 0.2 s, as far back (frames, joints)."""
    e, v = m.steps, m.step_vectors
    out = np.zeros(e.shape, dtype=np.bool_)
    for gap in range(1, max(2, round(0.2 * m.fps))):
        size = np.minimum(e[:-gap], e[gap:])
        if size.max(initial=0.0) < BACK:
            continue
        dots = np.einsum("fjc,fjc->fj", v[:-gap], v[gap:])
        back = (size > BACK) & (dots < -0.8 * e[:-gap] * e[gap:])
        back &= size > 0.7 * np.maximum(e[:-gap], e[gap:])
        out[:-gap] |= back
    return out


def _at_ends(m: Measured) -> FloatArray:
    """Steps in the first or last frames as nothing does beside them (frames, joints), m; else 0."""
    out = np.zeros(m.steps.shape)
    fourth = np.linalg.norm(np.diff(m.points, 4, axis=0), axis=-1)  # of a step, up to thrice it
    for changes, flags, steps in (
        (fourth, out, m.steps[1:]),
        (fourth[::-1], out[::-1], m.steps[:0:-1]),
    ):
        if len(changes) >= 3 * _ENDS:
            first, beside = changes[:_ENDS].max(axis=0), changes[_ENDS : 3 * _ENDS].max(axis=0)
            size = steps[:_ENDS].max(axis=0)
            flags[0] = np.where((first > END_TIMES * beside) & (size > END), size, 0.0)
    return out


def _near(mask: BoolArray) -> BoolArray:
    """Frames at most 3 from those of a mask."""
    return np.convolve(mask, np.ones(7), "same") > 0


def _bones(m: Measured) -> tuple[FloatArray, BoolArray]:
    """How far bones are from their usual length, m, and where that is a jump (frames, bones)."""
    a, b = (m.points[:, [bone[end] for bone in _BONES]] for end in (0, 1))
    length = np.linalg.norm(b - a, axis=-1)
    off = np.abs(length - np.median(length, axis=0))
    usual = np.percentile(off, 75, axis=0)  # a bone that is never of one length says nothing
    far, near = (
        (off > y * m.k + times_ * usual) & ~m.missing[:, None] for y, times_ in (BONE, RIGID)
    )
    beside = max(1, round(0.025 * m.fps))
    for number in range(len(_BONES)):
        for start, end in runs(near[:, number]):
            edges = [off[max(t - beside, 0) : t + beside, number] for t in (start, end)]
            if max(np.ptp(each) for each in edges) > AT_ONCE * off[start:end, number].max():
                far[start:end, number] = True
    return off, np.asarray(far)


def _joint(name: str) -> str:
    return f"{_WORDS[name[0]]} {name[2:]}" if name[1] == "_" else name


def _span(m: Measured, a: int, b: int) -> tuple[float, float]:
    return a / m.fps, b / m.fps


_SIDES = {"feet": ("ankle", "toe"), "hands": ("wrist",)}
_SIDES |= {f"{joint}s": (joint,) for joint in ("knee", "hip", "shoulder", "elbow")}
_SWAPPED: list[tuple[str, list[str], list[str]]] = [
    *((f"left and right {part}", [f"l_{j}" for j in of], [f"r_{j}" for j in of])
      for part, of in _SIDES.items()),
    *((f"{_WORDS[s]} {a} and {b}", [f"{s}_{a}"], [f"{s}_{b}"]) for s in "lr"
      for a, b in (("knee", "ankle"), ("ankle", "toe"), ("elbow", "wrist"))),
]  # fmt: skip


def _swaps(m: Measured) -> list[Finding]:
    """Frames from which on two parts have changed places."""
    out = []
    calm = (np.median(m.steps[1:], axis=1) < 0.04) & ~_near(m.missing)[1:]
    for part, ones, others in _SWAPPED:
        a, b = (m.points[:, [I[name] for name in names]] for names in (ones, others))
        moves = [np.linalg.norm(np.diff(x, axis=0), axis=-1).mean(axis=1) for x in (a, b)]
        kept = moves[0] + moves[1]
        crossed = np.linalg.norm(a[1:] - b[:-1], axis=-1).mean(axis=1)
        crossed = crossed + np.linalg.norm(b[1:] - a[:-1], axis=-1).mean(axis=1)
        bad = calm & (kept > SWAP * m.k) & (crossed < SWAP_SHARE * kept)
        bad &= np.minimum(*moves) > 0.6 * np.maximum(*moves)
        at = np.flatnonzero(bad) + 1
        for start, end in zip(at[::2], [*at[1::2], m.n]):
            words = f"{part} change places"
            size = float(kept[start - 1])
            place = m.points[start, I[ones[0]]]
            measured = (size, "m", SWAP * m.k)
            span = _span(m, int(start), int(end))
            out.append(said("swapped", words, span, measured, part, place))
    return out


def _explains(swap: Finding, jump: Finding) -> bool:
    """Whether a joint jumps because it, or one beside it, has changed places."""
    inside = swap.start - 0.1 < jump.start < swap.end + 0.1
    ends = min(abs(jump.start - swap.start), abs(jump.start - swap.end)) < 0.1
    return jump.kind == "jumps" and inside and (ends or swap.end - swap.start < 1.0)


def _names(m: Measured) -> list[Finding]:
    """That the names of left and right are exchanged, of all, arms or legs; or knees bent wrongly.

    Toes and knees point backwards then, or shoulders lie across from the hips.
    """
    left = m.at("l_hip") - m.at("r_hip")
    ahead = np.cross(left, m.at("neck") - m.points[:, 0])
    votes, whole = [], (0.0, m.n / m.fps)
    if m.has_toes:
        toes = sum(m.at(f"{s}_toe") - m.at(f"{s}_ankle") for s in "lr")
        votes.append(np.asarray((ahead * toes).sum(axis=-1) > 0))
    bends = []
    for s in "lr":
        bend = m.at(f"{s}_knee") - (m.at(f"{s}_hip") + m.at(f"{s}_ankle")) / 2.0
        clear = np.linalg.norm(bend, axis=1) > 0.06 * m.leg
        if clear.mean() > 0.1:
            votes.append(np.asarray((ahead * bend).sum(axis=-1)[clear] > 0))
            back = 1.0 - float(votes[-1].mean())
            bent = np.percentile(np.linalg.norm(bend, axis=1), 90) > KNEE * m.leg
            if back > 0.6 and clear.mean() > 0.3 and bent:
                words, measured = (
                    f"the {_WORDS[s]} knee bends backwards",
                    (back, "of the time", 0.6),
                )
                bends.append(said("bends", words, whole, measured, f"{s}_knee"))
    across = m.at("l_shoulder") - m.at("r_shoulder")
    crossed = float(((left * across).sum(axis=1) < 0.0).mean())
    share = 1.0 - float(np.mean([vote.mean() for vote in votes])) if votes else 0.0
    if votes and max(vote.mean() for vote in votes) <= 0.4:
        whose = " of the legs" if crossed > 0.6 else ""
        words = f"toes and knees point backwards: the names of left and right{whose} are exchanged"
    elif crossed > 0.6:
        share = crossed
        words = "shoulders lie across from the hips: the names of left and right arm are exchanged"
    else:
        return bends
    return [said("names", words, whole, (share, "of the frames", 0.6))]


def _frozen(m: Measured) -> list[Finding]:
    """Times in which nothing moves at all."""
    still = np.abs(np.diff(m.points, axis=0)).max(axis=(1, 2)) < FROZEN
    still &= ~(m.missing[1:] | m.missing[:-1])
    out = []
    for a, b in long_runs(still, FROZEN_SECONDS * m.fps):
        length = (b + 1 - a) / m.fps
        words = f"nothing moves for {length:.1f} s"
        out.append(said("frozen", words, _span(m, a, b + 1), (length, "s", FROZEN_SECONDS)))
    for name in _HELD:
        number, parent = I[name], body.PARENTS[I[name]]
        step, moves = (
            np.linalg.norm(np.diff(m.points[:, j], axis=0), axis=1) for j in (number, parent)
        )
        for a, b in long_runs((step < FROZEN) & ~still, HELD_SECONDS * m.fps):
            if moves[a:b].sum() > HELD_WAY * m.k:
                length = (b + 1 - a) / m.fps
                words = (
                    f"the {_joint(name)} stays where it is for {length:.1f} s while the rest moves"
                )
                measured = (length, "s", HELD_SECONDS)
                span = _span(m, a, b + 1)
                out.append(said("frozen", words, span, measured, name, m.points[a, number]))
    return out


def _noise(m: Measured) -> list[Finding]:
    """Seconds in which joints tremble more than a cubic through their neighbours explains.

    Motion leaves 16 times as much at twice the distance of frames, noise leaves as much.
    """
    if m.n < 16:
        return []
    near, wide = (np.linalg.norm(residual(m.points, step), axis=-1) for step in (1, 2))
    size = max(8, round(m.fps))
    values = np.zeros((m.n, 1 + near.shape[1]))  # of all joints, and of each
    for start in range(0, max(1, len(wide) - size // 2), size // 2):
        piece = slice(start, start + size)
        value, around = (
            np.array([np.median(r[piece]), *np.median(r[piece], axis=0)]) for r in (near, wide)
        )
        value[value < 0.4 * around] = 0.0
        values[piece] = np.maximum(values[piece], value)
    values[:, 1:][values[:, 0] > NOISE] = 0.0
    out = []
    for number, name in enumerate(("body", *body.JOINTS)):
        least = JOINT_NOISE * max(1.0, 50.0 / m.fps) if number else NOISE
        for a, b in runs(values[:, number] > least):
            most = float(values[a:b, number].max())
            who = f"the {_joint(name)} trembles" if number else "joints tremble"
            words = f"{who} by {1000 * most:.0f} mm from frame to frame"
            out.append(said("noise", words, _span(m, a, b), (most, "m", least), name))
    return out


def _rest_pose(m: Measured, jumps: list[Finding]) -> list[Finding]:
    """A T-pose or A-pose at the start, from before the take."""
    n = min(m.n, round(1.5 * m.fps))
    arms, level, legs = np.ones((3, n), dtype=np.bool_)
    for s in "lr":
        upper, fore = (
            m.at(f"{s}_{b}")[:n] - m.at(f"{s}_{a}")[:n]
            for a, b in (("shoulder", "elbow"), ("elbow", "wrist"))
        )
        down = [-u[:, 1] / np.maximum(np.linalg.norm(u, axis=1), 1e-6) for u in (upper, fore)]
        cosine = np.einsum("fc,fc->f", upper, fore) / np.maximum(
            np.linalg.norm(upper, axis=1) * np.linalg.norm(fore, axis=1), 1e-6
        )
        arms &= (cosine > 0.94) & (np.abs(down[0]) < 0.85)
        level &= (np.abs(down[0]) < 0.26) & (np.abs(down[1]) < 0.26)
        leg = m.at(f"{s}_ankle")[:n] - m.at(f"{s}_hip")[:n]
        legs &= -leg[:, 1] > 0.96 * np.linalg.norm(leg, axis=1)
    wide = np.linalg.norm(m.at("l_wrist")[:n] - m.at("r_wrist")[:n], axis=1) > 1.5 * m.leg
    still = m.speed[:n].max(axis=1) < 0.02
    pose = legs & ((level & wide) | (arms & still))
    first = runs(pose)[:1]
    least = POSE_SECONDS * m.fps
    if first and first[0][0] <= 0.1 * m.fps and first[0][1] >= least:
        end = first[0][1] / m.fps
        words = "stands in a rest pose from before the take"
        return [said("rest pose", words, (0.0, end), (end, "s", POSE_SECONDS))]
    seams = [j.start for j in jumps if j.kind == "seam" and 0.0 < j.start <= 1.5]
    if seams and pose[: max(1, round(0.5 * seams[0] * m.fps))].all():
        words = "begins with a rest pose from before the take"
        return [said("rest pose", words, (0.0, seams[0]), (seams[0], "s", 0.0))]
    return []


def _sinks(m: Measured) -> list[Finding]:
    """Feet below the floor."""
    deep = -m.h[:, [P[f"{s}_{name}"] for s in "lr" for name in ("toe", "ankle")]].min(axis=1)
    out = []
    spans = [s for y, seconds in SINKS for s in long_runs(deep > y * m.k, seconds * m.fps)]
    for a, b in joined(spans, 0.5 * m.fps):
        depth = float(np.percentile(deep[a:b], 80))
        words = f"sinks {100 * depth:.0f} cm into the floor"
        place = m.points[a:b, 0].mean(axis=0)
        out.append(
            said("sinks", words, _span(m, a, b), (depth, "m", SINKS[-1][0] * m.k), "feet", place)
        )
    return out


def stances(m: Measured, seconds: float = 1.0) -> tuple[FloatArray, FloatArray]:
    """Drift of every stance of a foot: middle (stances,), s, and velocity (stances, 2).

    A stance that lasts is taken in pieces of about so many seconds. Its drift is taken where the
    foot's velocity changes least: where it is slowest, a foot that slides is about to turn around.
    """
    times, drifts = [], []
    for s in "lr":
        feet = [P[f"{s}_{name}"] for name in ("toe", "ankle")]
        h, v = m.h[:, feet], m.v[:, feet][..., [0, 2]]
        change = np.linalg.norm(np.gradient(v, axis=0), axis=-1)
        change = np.where(h < 0.035 * m.k, change, np.inf)
        down = np.asarray((h < 0.035 * m.k).any(axis=1))
        for a, b in long_runs(down, 0.12 * m.fps):
            for piece in np.array_split(np.arange(a, b), max(1, round((b - a) / m.fps / seconds))):
                best = piece[np.argsort(change[piece].min(axis=1))[: max(1, len(piece) // 4)]]
                foot = change[best].argmin(axis=1)
                times.append(float(piece.mean()) / m.fps)
                drifts.append(np.median(v[best, foot], axis=0))
    return np.array(times), np.array(drifts).reshape(-1, 2)


def _slides(m: Measured) -> list[Finding]:
    """Feet that drift one way in all stances: a slide, or a treadmill if the body stays."""
    _, v = stances(m)
    if len(v) < 2:
        return []
    drift = np.median(v, axis=0)
    speed = float(np.linalg.norm(drift))
    agree = float((v @ drift > 0.5 * speed**2).mean())
    travel = m.points[-1, 0] - m.points[0, 0]
    pace = float(np.hypot(travel[0], travel[2])) / (m.n / m.fps)
    span = (0.0, m.n / m.fps)
    belt = np.linalg.norm(v, axis=1)  # it may turn with the body
    usual = float(np.median(belt))
    stays = np.hypot(*np.ptp(m.points[:, 0], axis=0)[[0, 2]]) < BELT * m.k
    straight = speed > TREADMILL and agree > 0.5 and pace < 0.5 * speed
    if straight or (stays and len(v) > 3 and (belt > TREADMILL).mean() > 0.8):
        words = f"walks on a treadmill at {usual:.1f} m/s"
        measured = (usual, "m/s", TREADMILL)
        return [
            said("treadmill", words, span, measured, "feet", m.points[:, 0].mean(axis=0), NEEDS)
        ]
    if speed > SLIDES and agree > 0.7 and len(v) > 2:
        words = f"feet on the floor slide at {speed:.2f} m/s"
        return [said("slides", words, span, (speed, "m/s", SLIDES), "feet")]
    return _slides_for_a_while(m)


def _slides_for_a_while(m: Measured) -> list[Finding]:
    """Times in which three stances that follow one another drift alike, or most of five or more."""
    at, v = stances(m, 0.4)
    order = np.argsort(at, kind="stable")
    order = order[np.linalg.norm(v[order], axis=1) < SWINGS]
    at, v = at[order], v[order]
    spans, speeds = [], []
    for first in range(len(at) - 2):
        many = int(np.searchsorted(at, at[first] + SLIDE_MANY[0]))
        three = first + 3 if at[first + 2] - at[first] <= SLIDE_SECONDS else first
        for end, middle, least, (share, near) in (
            (three, np.mean, 3, (1.0, SLIDE_ALIKE)),
            (many, np.median, 5, SLIDE_MANY[1:]),
        ):
            if end - first < least:
                continue
            drift = middle(v[first:end], axis=0)
            speed = float(np.linalg.norm(drift))
            alike = np.linalg.norm(v[first:end] - drift, axis=1) < near * speed
            if speed > SLIDES and alike.mean() >= share:
                spans.append((round(at[first] * m.fps), round(at[end - 1] * m.fps)))
                speeds.append(speed)
    out = []
    for a, b in joined(spans, 0.2 * m.fps):
        speed = max(s for s, (c, d) in zip(speeds, spans) if c < b and d > a)
        words = f"feet on the floor slide at {speed:.2f} m/s"
        out.append(said("slides", words, _span(m, a, b), (speed, "m/s", SLIDES), "feet"))
    return out


def _gaps(m: Measured) -> list[Finding]:
    """Frames in which a joint has no place."""
    out = []
    for a, b in runs(m.missing):
        length = (b - a) / m.fps
        words = f"some joints have no place for {length:.2f} s"
        out.append(said("gap", words, _span(m, a, b), (length, "s", 0.0)))
    return out


def _through(m: Measured) -> list[Finding]:
    """Wrists or ankles at the axis of the trunk, where no limb can be."""
    low, high = m.points[:, I["spine"]], m.points[:, I["chest"]]
    axis = high - low
    square = np.maximum((axis * axis).sum(axis=1), 1e-9)
    out = []
    for name in ("l_wrist", "r_wrist", "l_ankle", "r_ankle", "l_elbow", "r_elbow"):
        x = m.at(name) - low
        share = np.clip((x * axis).sum(axis=1) / square, 0.0, 1.0)
        distance = np.linalg.norm(x - share[:, None] * axis, axis=1)
        for a, b in long_runs(distance < 0.04 * m.k, 0.1 * m.fps):
            words = f"the {_joint(name)} is inside the trunk"
            measured = (float(distance[a:b].min()), "m", 0.04 * m.k)
            out.append(said("through", words, _span(m, a, b), measured, name, m.at(name)[a]))
    return out


def _off_floor(m: Measured) -> list[Finding]:
    """That feet rest at another height at the end than at the beginning, or off y = 0."""
    span = (0.0, m.n / m.fps)
    out = []
    if FLOATS < abs(m.floor) < 0.25:
        words = "over" if m.floor > 0 else "below"
        words = f"feet rest {100 * abs(m.floor):.0f} cm {words} the height 0 of the file"
        out.append(said("off the floor", words, span, (m.floor, "m", FLOATS), "feet"))
    soles = m.bottom[:, [P[f"{s}_{name}"] for s in "lr" for name in ("toe", "ankle")]]
    frames, at = np.nonzero(m.rests[:, [P[f"{s}_{n}"] for s in "lr" for n in ("toe", "ankle")]])
    y = soles[frames, at]
    kept = y < m.floor + 0.15 * m.k
    frames, y = frames[kept], y[kept]
    if len(frames) < 0.5 * m.fps or np.ptp(frames) < 0.5 * m.n:
        return out
    thirds = np.array_split(y, 3)
    rise = float(np.median(thirds[2]) - np.median(thirds[0]))
    if abs(rise) > RISES * m.k:
        words = f"the floor {'rises' if rise > 0 else 'falls'} by {100 * abs(rise):.0f} cm"
        out.append(said("floor tilts", words, span, (rise, "m", RISES * m.k), "feet"))
    return out
