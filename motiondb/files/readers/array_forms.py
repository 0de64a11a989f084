"""Arrays of generators and simulators in forms of their own, put under the names that others use.

MDM: ``motion`` (samples, joints, 3, frames) with ``lengths``. Motion-X: 322 numbers a frame, of
which turns and places of SMPL-X's body are read. MimicKit: ``frames`` of root, rotation vector and
joints. poselib (IsaacGymEnvs, ASE, PHC, ProtoMotions): a SkeletonMotion, local turns of links.

Source: https://github.com/GuyTevet/motion-diffusion-model; https://github.com/IDEA-Research/Motion-X;
https://github.com/xbpeng/MimicKit; https://github.com/isaac-sim/IsaacGymEnvs (poselib).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from motiondb.body import hinges, kinematics, rotation
from motiondb.errors import CaptureError
from motiondb.files.limits import ReadOptions, check_clip_size, check_rate
from motiondb.files.readers.array_files import Arrays, texts_of
from motiondb.files.readers.first_bytes import MOTION_X_WIDTH
from motiondb.records import Clip, FloatArray

_TREE = "skeleton_tree."
_PARTS = ("rotation.arr", "root_translation.arr", f"{_TREE}parent_indices.arr")
_OFFSETS, _LINKS = f"{_TREE}local_translation.arr", f"{_TREE}node_names"
_MOTION_X_FPS = 30.0


def plain_form(arrays: Arrays, path: object) -> Arrays:
    """Return the arrays of one motion under the names of SMPL, a robot or positions.

    Where the form says which axis is up, that is added as "up".
    """
    people = sorted({name.partition(".")[0] for name in arrays if name.endswith(".pose_body")})
    if len(people) > 1:
        raise CaptureError(
            path,
            f"expected one body, found {len(people)}: {', '.join(people)[:100]}. Save each in a "
            "file of its own.",
        )
    values = arrays.get("positions")
    if values is not None and values.ndim == 3 and len(values) == 1:
        values = values[0]
    if values is not None and values.ndim == 2 and values.shape[1] == MOTION_X_WIDTH:
        parts: Arrays = {"root_orient": values[:, :3], "pose_body": values[:, 3:66]}
        return {
            **parts,
            "trans": values[:, 309:312],
            "fps": np.array(_MOTION_X_FPS),
            "up": np.array("y"),
        }
    frames = arrays.get("frames")
    if "loop_mode" in arrays and frames is not None and frames.ndim == 2 and frames.shape[1] > 6:
        numbers = frames.astype(np.float64)
        turns = rotation.exp(numbers[:, 3:6])
        plain: Arrays = {
            "root_pos": numbers[:, :3],
            "root_quat_wxyz": turns,
            "dof_pos": numbers[:, 6:],
        }
        return plain | {"fps": arrays["fps"]} if "fps" in arrays else plain
    if "lengths" in arrays and "motion" in arrays and arrays["motion"].ndim == 4:
        return {"positions": _only_sample(arrays, path)}
    return arrays


def _only_sample(arrays: Arrays, path: object) -> FloatArray:
    """Return the places (frames, joints, 3) of MDM's only sample."""
    samples, lengths = arrays["motion"], np.ravel(arrays["lengths"])
    if len(samples) != 1 or samples.shape[2] != 3:
        found = f"{len(samples)} samples" if len(samples) != 1 else "other numbers"
        raise CaptureError(
            path,
            f"expected places of one motion, found {found} of shape {samples.shape[1:]} (joints, "
            "3, frames). Save each: np.save(NAME, motion[n, ..., :lengths[n]].transpose(2, 0, 1)).",
        )
    return samples[0, ..., : int(lengths[0])].transpose(2, 0, 1).astype(np.float64)


def is_skeleton_motion(arrays: Arrays) -> bool:
    """Whether arrays are a SkeletonMotion of poselib."""
    return {*_PARTS, _OFFSETS, _LINKS} <= {*arrays}


def read_skeleton_motion(arrays: Arrays, path: object, options: ReadOptions, n_bytes: int) -> Clip:
    """Read a SkeletonMotion: turns x y z w of links by their parents; z up (CaptureError)."""
    given, root, parents = (arrays[name] for name in _PARTS)
    offsets, links = arrays[_OFFSETS].astype(np.float64), texts_of(np.ravel(arrays[_LINKS]))
    shape, above = (len(root), len(links)), parents.astype(np.int64).ravel()
    fits = given.shape == (*shape, 4) and root.shape == (shape[0], 3) and shape[0] > 0
    fits &= offsets.shape == (shape[1], 3) and above.shape == (shape[1],)
    if not fits or (above >= np.arange(shape[1])).any() or (above[1:] < 0).any():
        raise CaptureError(
            path,
            "expected turns of as many links as the skeleton has, found others. Save it again.",
        )
    check_clip_size(*shape, n_bytes, path, options.limits)
    if options.fps is None and "fps" not in arrays:
        raise CaptureError(path, "expected a frame rate (fps), found none. Give it with --fps.")
    fps = options.fps or check_rate(float(np.ravel(arrays["fps"])[0]), path)
    turns = rotation.normalize(given.astype(np.float64)[..., [3, 0, 1, 2]])
    if "is_local" in arrays and bool(arrays["is_local"]):
        places, turns = kinematics.forward(above, offsets, turns, root.astype(np.float64))
    else:
        local = turns.copy()
        local[:, 1:] = rotation.relative(turns[:, above[1:]], turns[:, 1:])
        places, turns = kinematics.forward(above, offsets, local, root.astype(np.float64))
    if not (np.isfinite(places).all() and np.isfinite(turns).all()):
        raise CaptureError(path, "expected finite numbers, found others. Save it again.")
    clip = hinges.of_frames(links, above, places, turns, fps, up=options.up or "z")
    return replace(clip, joint_positions=None)
