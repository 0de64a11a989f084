"""A slow, obvious BVH reader: one frame, one joint, one 4 x 4 matrix at a time; no checks."""

from __future__ import annotations

import math

import numpy as np


def _turn(axis: str, degrees: float) -> np.ndarray:
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    m = np.eye(4)
    i, j = {"X": (1, 2), "Y": (2, 0), "Z": (0, 1)}[axis]
    m[i, i], m[i, j], m[j, i], m[j, j] = c, -s, s, c
    return m


def world_positions(text: str) -> np.ndarray:
    """World positions (frames, joints, 3) in file units, joints in file order."""
    words = text.split()
    joints: list[dict] = []
    stack: list[dict] = []
    current: dict = {}
    place = 0
    while words[place] != "MOTION":
        word = words[place]
        if word in ("ROOT", "JOINT", "End"):
            current = {"parent": stack[-1] if stack else None, "channels": []}
            if word != "End":
                joints.append(current)
        elif word == "{":
            stack.append(current)
        elif word == "}":
            stack.pop()
        elif word == "OFFSET":
            current["offset"] = [float(w) for w in words[place + 1 : place + 4]]
        elif word == "CHANNELS":
            n = int(words[place + 1])
            current["channels"] = words[place + 2 : place + 2 + n]
        place += 1
    n_frames = int(words[place + 2])
    values = iter(float(w) for w in words[place + 6 :])
    positions = np.zeros((n_frames, len(joints), 3))
    for frame in range(n_frames):
        for number, joint in enumerate(joints):
            place_of_joint = list(joint["offset"])
            turn = np.eye(4)
            for channel in joint["channels"]:
                value = next(values)
                if channel.endswith("position"):
                    place_of_joint["XYZ".index(channel[0])] = value
                else:
                    turn = turn @ _turn(channel[0], value)
            local = np.eye(4)
            local[:3, 3] = place_of_joint
            local = local @ turn
            parent = joint["parent"]
            joint["world"] = local if parent is None else parent["world"] @ local
            positions[frame, number] = joint["world"][:3, 3]
    return positions
