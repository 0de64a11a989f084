"""Changes of a clip on its own skeleton: another rate, in place, mirrored, with y up.

Nothing here looks at the names of joints but :func:`mirrored`, which needs left and right.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from motiondb.body import kinematics, rotation
from motiondb.body.joint_names import joint_map, mirror_joints
from motiondb.body.retarget import up_axis
from motiondb.body.world import to_y_up
from motiondb.errors import SkeletonError
from motiondb.records import Clip, FloatArray, IntArray, Skeleton

_SWAY_SECONDS = 0.35
"""Standard deviation of the weights by which the path over the ground is averaged: about a third of
a cycle of walking, so that the sway of a step is not travel."""
TURNED = 0.35  # Radians (20 degrees) from which on a cycle turns, as in ``generate.cycles``
_FLIP = np.array([-1.0, 1.0, 1.0])  # Mirror image in the plane x = 0
_FLIP_TURN = np.array([1.0, 1.0, -1.0, -1.0])
_LIKE = 0.05  # Length of the difference of two bones, as a share, below which they are alike


def resampled(clip: Clip, fps: float, is_cycle: bool = False) -> Clip:
    """A clip of the same duration at another rate; in a cycle the first frame follows the last."""
    if fps == clip.fps:
        return clip
    count = max(1, round(clip.n_frames / clip.fps * fps))
    if is_cycle:
        clip = _with_next(clip)
    times = np.minimum(np.arange(count) * (clip.fps / fps), clip.n_frames - 1)
    low = np.minimum(times.astype(np.int64), max(clip.n_frames - 2, 0))
    high = np.minimum(low + 1, clip.n_frames - 1)
    share = times - low

    def between(values: FloatArray) -> FloatArray:
        each = share.reshape(-1, *(1,) * (values.ndim - 1))
        return values[low] * (1.0 - each) + values[high] * each

    turns = rotation.normalize(clip.local_rotations)
    shares = np.repeat(share[:, None], turns.shape[1], axis=1)
    moved = clip.joint_positions
    return replace(
        clip,
        fps=float(fps),
        local_rotations=rotation.unroll(rotation.slerp(turns[low], turns[high], shares)),
        root_positions=between(clip.root_positions),
        joint_positions=None if moved is None else between(moved),
    )


def _with_next(clip: Clip) -> Clip:
    """Return a cycle with the first frame of the next one; its root goes on at its last speed."""
    again = [*range(clip.n_frames), 0]
    root, moved = clip.root_positions[again], clip.joint_positions
    over = root[-2] - root[-3] if len(root) > 2 else np.zeros(3)
    root[-1] = root[-2] + over * np.array([1.0, 0.0, 1.0])
    root[-1, 1] = root[0, 1]
    turns = clip.local_rotations[again]
    turns[-1, 0] = rotation.multiply(_turn_of(turns[:-1, 0]), turns[-1, 0])
    clip = replace(
        clip,
        local_rotations=turns,
        joint_positions=None if moved is None else moved[again],
    )
    return moved_root(clip, root)


def _turn_of(roots: FloatArray) -> FloatArray:
    """The turn about y of a cycle and its last step; none below ``TURNED``, which sways."""

    def about_y(since: FloatArray, until: FloatArray) -> float:
        turn = rotation.multiply(until, rotation.conjugate(since))
        angle = 2.0 * np.arctan2(turn[2], turn[0])
        return float((angle + np.pi) % (2.0 * np.pi) - np.pi)

    turn = about_y(roots[0], roots[-1])
    if abs(turn) < TURNED:
        return np.array([1.0, 0.0, 0.0, 0.0])
    angle = turn + (about_y(roots[-2], roots[-1]) if len(roots) > 1 else 0.0)
    return np.asarray(rotation.from_axis_angle(np.array([0.0, 1.0, 0.0]), angle))


def upright(clip: Clip, user_map: Mapping[str, str] | None = None) -> Clip:
    """Turn a clip whose world has another axis up to one with y up."""
    up = up_axis(clip, user_map)
    if up == "y":
        return clip
    turn = to_y_up(up)
    local = clip.local_rotations.copy()
    local[:, 0] = rotation.multiply(turn, local[:, 0])
    clip = replace(clip, local_rotations=local, up="y")
    return moved_root(clip, rotation.rotate(turn, clip.root_positions))


def moved_root(clip: Clip, root: FloatArray) -> Clip:
    """Return a clip whose root is at other places (frames, 3)."""
    moved = clip.joint_positions
    if moved is not None:
        moved = moved.copy()
        moved[:, 0] = root
    return replace(clip, root_positions=root, joint_positions=moved)


@dataclass(frozen=True, eq=False)
class Hips:
    """A clip from its hips down the hierarchy, and the clip that it was taken from."""

    clip: Clip  # Its root is the joint that carries the legs and the trunk
    whole: Clip
    joints: tuple[int, ...]  # Numbers of its joints in the whole

    def restored(self, changed: Clip) -> Clip:
        """Put a clip back into the whole; what is above and beside holds its first frame."""
        whole, count = self.whole, changed.n_frames
        if len(self.joints) == len(whole.skeleton.names):
            return changed
        local = np.repeat(whole.local_rotations[:1], count, axis=0)
        moved = whole.joint_positions
        offsets = whole.skeleton.offsets if moved is None else moved[0]
        places = np.repeat(offsets[None], count, axis=0)
        places[:, 0] = whole.root_positions[0]
        inside = list(self.joints)
        local[:, inside] = changed.local_rotations
        places[:, inside] = (
            changed.skeleton.offsets if changed.joint_positions is None else changed.joint_positions
        )
        above = int(whole.skeleton.parents[inside[0]])
        at, turned = kinematics.clip_positions(part(whole, 0, 1))
        back = np.broadcast_to(rotation.conjugate(turned[:, above]), (count, 4))
        places[:, inside[0]] = rotation.rotate(back, changed.root_positions - at[:, above])
        local[:, inside[0]] = rotation.multiply(back, changed.local_rotations[:, 0])
        return replace(
            whole,
            local_rotations=local,
            root_positions=places[:, 0].copy(),
            joint_positions=places,
        )


def from_hips(clip: Clip, user_map: Mapping[str, str] | None = None) -> Hips:
    """Take the joints above the hips away, such as a root on the ground."""
    parents = clip.skeleton.parents
    hips = hips_joint(clip.skeleton, user_map)
    if hips == 0:
        return Hips(clip, clip, tuple(range(len(parents))))
    inside = {hips}
    inside |= {j for j, _ in enumerate(parents) if kinematics.is_below(parents, j, hips)}
    joints = sorted(inside)
    number = {joint: place for place, joint in enumerate(joints)}
    at, turned = kinematics.clip_positions(clip)
    local = clip.local_rotations[:, joints].copy()
    local[:, 0] = turned[:, hips]
    skeleton, moved = clip.skeleton, clip.joint_positions
    offsets = skeleton.offsets[joints].copy()
    offsets[0] = 0.0
    below = replace(
        skeleton,
        names=tuple(skeleton.names[joint] for joint in joints),
        parents=np.array([number.get(int(parents[joint]), -1) for joint in joints]),
        offsets=offsets,
        end_sites=tuple((number[j], end) for j, end in skeleton.end_sites if j in number),
        channels=(),
    )
    places = None if moved is None else moved[:, joints].copy()
    new = replace(clip, skeleton=below, local_rotations=local, joint_positions=places)
    return Hips(moved_root(new, at[:, hips]), clip, tuple(joints))


def hips_joint(skeleton: Skeleton, user_map: Mapping[str, str] | None = None) -> int:
    """Return the joint that carries both legs and the neck, the nearest one to them."""
    roles = joint_map(skeleton, user_map)
    chains = []
    for role in ("l_hip", "r_hip", "neck"):
        joint = roles[role] if roles[role] >= 0 else skeleton.end_sites[-1 - roles[role]][0]
        chain = [joint]
        while skeleton.parents[chain[-1]] >= 0:
            chain.append(int(skeleton.parents[chain[-1]]))
        chains.append(chain)
    return next((j for j in chains[0] if all(j in chain for chain in chains[1:])), 0)


def part(clip: Clip, first: int, behind: int) -> Clip:
    """Return some frames of a clip."""
    chosen, moved = slice(first, behind), clip.joint_positions
    return replace(
        clip,
        local_rotations=clip.local_rotations[chosen],
        root_positions=clip.root_positions[chosen],
        joint_positions=None if moved is None else moved[chosen],
    )


def in_place(clip: Clip, hips: FloatArray, is_cycle: bool = False) -> tuple[Clip, float]:
    """Take the averaged travel of hips (frames, 3) out of a clip; also its length, metres."""
    from scipy.ndimage import gaussian_filter1d  # most exports do without

    path = hips[:, [0, 2]]
    if is_cycle:  # the first frame follows the last
        steps = len(path) / max(len(path) - 1, 1)
        line = np.arange(len(path))[:, None] / len(path) * (path[-1] - path[0]) * steps
        frames = _SWAY_SECONDS * clip.fps
        travel = line + gaussian_filter1d(path - line, frames, axis=0, mode="wrap")
    else:
        travel = _averaged(path, _SWAY_SECONDS * clip.fps)
    root = clip.root_positions.copy()
    root[:, [0, 2]] -= travel
    length = float(np.linalg.norm(np.diff(travel, axis=0), axis=1).sum())
    return moved_root(clip, root), length


def _averaged(path: FloatArray, frames: float) -> FloatArray:
    """Average a path (frames, 2); beyond its ends it goes on as if turned about them."""
    if len(path) < 2:
        return path.copy()
    from scipy.ndimage import gaussian_filter1d

    more = min(int(4 * frames) + 1, len(path) - 1)
    before = 2.0 * path[0] - path[more:0:-1]
    after = 2.0 * path[-1] - path[-2 : -2 - more : -1]
    whole = np.concatenate([before, path, after])
    return np.asarray(gaussian_filter1d(whole, frames, axis=0)[more : more + len(path)])


def mirrored(clip: Clip) -> Clip:
    """The mirror image in the plane x = 0, left and right exchanged; bones keep their lengths."""
    skeleton = clip.skeleton
    partners = mirror_joints(skeleton)
    _, world = kinematics.clip_positions(clip)
    turned = world[:, partners] * _FLIP_TURN
    rest = _rest_turns(clip, partners)
    turned = rotation.multiply(turned, np.broadcast_to(rest, turned.shape))
    local = turned.copy()
    for joint, parent in enumerate(skeleton.parents):
        if parent >= 0:
            local[:, joint] = rotation.relative(turned[:, parent], turned[:, joint])
    clip = replace(clip, local_rotations=rotation.unroll(local))
    moved = clip.joint_positions
    if moved is not None:
        other = moved[:, partners] * _FLIP
        for joint, parent in enumerate(skeleton.parents):
            if parent >= 0:
                back = np.broadcast_to(rotation.conjugate(rest[parent]), (len(other), 4))
                other[:, joint] = rotation.rotate(back, other[:, joint])
        clip = replace(clip, joint_positions=other)
    return moved_root(clip, clip.root_positions * _FLIP)


def _rest_turns(clip: Clip, partners: IntArray) -> FloatArray:
    """Turn of each joint's frame after which its bones mirror its partner's; mostly none."""
    skeleton = clip.skeleton
    turns = np.tile(rotation.IDENTITY, (len(skeleton.names), 1))
    for joint in range(len(partners)):
        ours, theirs = [], []
        for child, parent in enumerate(skeleton.parents):
            if parent == joint:
                ours.append(skeleton.offsets[child])
                theirs.append(skeleton.offsets[partners[child]] * _FLIP)
        if not ours:
            continue
        own, other = np.array(ours), np.array(theirs)
        size = max(float(np.abs(other).max()), 1e-9)
        if np.abs(own - other).max() > _LIKE * size:
            turns[joint] = _best_turn(own, other)
    return turns


def _best_turn(own: FloatArray, other: FloatArray) -> FloatArray:
    """Return the rotation that brings vectors nearest to others (Kabsch); one: the smallest."""
    if len(own) == 1:
        return rotation.between(own[0], other[0])
    left, _, right = np.linalg.svd(other.T @ own)
    sign = np.sign(np.linalg.det(left @ right)) or 1.0
    return rotation.from_matrix(left @ np.diag([1.0, 1.0, sign]) @ right)


def check_pairs(clip: Clip) -> None:
    """Refuse a skeleton whose left and right are not known (SkeletonError)."""
    partners = mirror_joints(clip.skeleton)
    if (partners == np.arange(len(partners))).all():
        names = ", ".join(clip.skeleton.names[:12])
        raise SkeletonError(
            f"skeleton: expected joints in pairs of left and right, found none among: {names}. "
            "Export with --canonical."
        )
