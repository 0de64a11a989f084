"""Reader of FBX, through the library ufbx.

What is kept: the joints that are bones, their names with namespaces, every frame of a take, the
frame rate of the scene, or of its keys where these are denser. What is normalised: the world is
right-handed with y up, lengths are metres. The place of every joint is measured in the world at
every frame, so that pre-rotations, pivots, scales, and nodes between bones (nulls, groups, the
"Armature" of Blender) need no treatment of their own; where a joint does not stay at one place in
its parent's frame, the clip has ``joint_positions``. Leaf bones that only mark an end
("Head_end", "LeftToeEnd", "Bip01 HeadNub") become end sites. What is lost: meshes, scales of bones,
cameras, constraints that were not plotted.

A file may hold several takes, of one or several skeletons (:mod:`.fbx_takes`). It is read in a
child process with limits of time and memory: a damaged file may end the process that reads it.

Source: https://ufbx.github.io; what the nodes of FBX mean: Autodesk, FBX SDK documentation.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from motiondb.errors import CaptureError
from motiondb.files.limits import AS_USUAL, ReadOptions
from motiondb.files.readers.child_process import end_child_with_parent, read_in_child
from motiondb.files.safe_files import open_file
from motiondb.records import Clip, Skeleton

_CPU_SECONDS = 30.0
"""Processor time of the child for a file of 10 MB, in proportion for larger ones: a take of 20,000
frames with 80 joints needs about 10 s."""
ALL, POSE = "*", "#pose"  # For the child: read every take, or the pose in the file


def read_fbx(data: bytes, path: object, options: ReadOptions = AS_USUAL) -> Clip:
    """Read the take that the options name, or the only one, in the bytes of an FBX file."""
    (clip,) = _read(data, path, options).values()
    return clip


def read_takes(data: bytes, path: object, options: ReadOptions = AS_USUAL) -> dict[str, Clip]:
    """Read every take in the bytes of an FBX file, by its label."""
    return _read(data, path, replace(options, take=ALL))


def read_pose(data: bytes, path: object) -> Clip:
    """Read the pose in which the joints of an FBX file stand: a clip of one frame."""
    (clip,) = _read(data, path, replace(AS_USUAL, take=POSE)).values()
    return clip


def _read(data: bytes, path: object, options: ReadOptions) -> dict[str, Clip]:
    """Read takes in a child process."""
    given = [str(options.fps or 0.0), str(options.unit or 0.0), options.take]
    limits = options.limits
    given += [str(min(limits.memory, sys.maxsize)), str(min(limits.joints, sys.maxsize))]
    read = read_in_child("motiondb.files.readers.fbx", data, limits, _CPU_SECONDS, given, path)
    if "faults" in read:
        raise CaptureError(path, [(None, str(fault)) for fault in read["faults"]])
    return {str(label): _clip(read, n) for n, label in enumerate(read["labels"])}


def _clip(read: Mapping[str, Any], number: int) -> Clip:
    """Return a take from the arrays that the child wrote."""
    names, joints, offsets, ends, local, root, moved, numbers, notes = (
        read[f"{key}_{number}"] for key in _KEYS
    )
    skeleton = Skeleton(
        tuple(map(str, names)),
        joints[: len(names)],
        offsets,
        tuple(
            (int(j), (float(x), float(y), float(z)))
            for j, (x, y, z) in zip(joints[len(names) :], ends)
        ),
    )
    fps, unit = numbers.tolist()
    return Clip(
        skeleton,
        fps,
        local,
        root,
        moved if moved.size else None,
        "fbx",
        unit,
        "y",  # ufbx has turned the world by the axes that the file states
        tuple(map(str, notes)),
    )


_KEYS = ("names", "joints", "offsets", "ends", "local", "root", "moved", "numbers", "notes")


def convert(source: str, target: str, given: list[str]) -> None:
    """Read takes with ufbx and write them as npz: the work of the child process."""
    from motiondb.files.limits import ReadLimits
    from motiondb.files.readers.fbx_takes import FbxFile

    fps, unit, take, memory, joints = given
    limits = replace(ReadLimits(), memory=int(memory), joints=int(joints))
    options = ReadOptions(float(fps) or None, float(unit) or None, limits=limits)
    arrays: dict[str, Any] = {}
    try:
        with open_file(source) as file:
            scene = FbxFile(file.read(), "", options, take == POSE)
        labels = scene.labels if take in (ALL, POSE) else (scene.chosen(take),)
        arrays["labels"] = np.array(labels, dtype=str)
        for number, label in enumerate(labels):
            clip = scene.clip(label)
            skeleton = clip.skeleton
            values = (
                np.array(skeleton.names, dtype=str),
                np.array([*skeleton.parents, *(joint for joint, _ in skeleton.end_sites)]),
                skeleton.offsets,
                np.array([end for _, end in skeleton.end_sites]).reshape(-1, 3),
                clip.local_rotations,
                clip.root_positions,
                np.zeros(0) if clip.joint_positions is None else clip.joint_positions,
                np.array([clip.fps, clip.unit]),
                np.array(clip.notes, dtype=str),
            )
            arrays |= {f"{key}_{number}": value for key, value in zip(_KEYS, values)}
    except CaptureError as error:
        arrays = {"faults": np.array([fault for _, fault in error.faults], dtype=str)}
    np.savez(target, **arrays)


if __name__ == "__main__":
    convert(*end_child_with_parent())
