"""A capture as scenes use it: the place of the body on the ground, and its pose relative to it.

Each frame has the place (x, z, heading) of the pelvis on the ground, the joints in the frame of
that place (x left, y up, z ahead; the height of the root is kept), and their velocities. Velocities
are rotated into the same frame but include the travel of the body, so that running and standing in
the same pose are far apart.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from motiondb.body import body, features, pose_vectors, retarget, rotation
from motiondb.generate.contact import find_contacts
from motiondb.records import MOTION_FPS, FloatArray, Motion
from motiondb.scene.clips.ground import compose, relative

WRISTS = (body.INDEX["l_wrist"], body.INDEX["r_wrist"])  # Indices of the wrists among the 21 joints


@dataclass(frozen=True, eq=False)
class BodyFrames:
    """A motion, frame by frame, seen from its own places on the ground."""

    places: FloatArray  # (frames, 3), m and rad: x, z and unwrapped heading in the world
    joints: FloatArray  # (frames, 21, 3), m: joints in the frame of the place
    # (frames, 21, 3), m/s: velocities relative to the world, along the axes of the place
    velocities: FloatArray
    # (frames, 2), bool: whether the left and the right foot is on the ground
    contacts: NDArray[np.bool_]

    @property
    def n_frames(self) -> int:
        """Number of frames."""
        return len(self.places)

    @cached_property
    def speeds(self) -> FloatArray:
        """Mean speed of all joints, array (frames,), m/s."""
        return np.asarray(np.linalg.norm(self.velocities, axis=2).mean(axis=1))

    def path(self, start: int, end: int) -> FloatArray:
        """Return the places of frames ``start`` to ``end``, both included, seen from the first.

        If the capture ends before ``end``, its last step is repeated, so that the last row is where
        the next clip begins.

        Shapes: result (end - start + 1, 3), m and rad.
        """
        inside = np.minimum(np.arange(start, end + 1), self.n_frames - 1)
        path = relative(self.places[inside], self.places[start])
        missing = end - (self.n_frames - 1)
        if missing > 0 and self.n_frames > start + 1:
            step = relative(self.places[-1], self.places[-2])
            for k in range(len(path) - missing, len(path)):
                path[k] = compose(path[k - 1], step)
        return path

    def mirrored(self) -> BodyFrames:
        """Return the mirror image, with left and right exchanged."""
        flip = np.array([-1.0, 1.0, 1.0])
        return BodyFrames(
            self.places * np.array([-1.0, 1.0, -1.0]),
            self.joints[:, body.MIRROR] * flip,
            self.velocities[:, body.MIRROR] * flip,
            self.contacts[:, ::-1],
        )


def body_frames(motion: Motion) -> BodyFrames:
    """Return a motion seen from its own places on the ground; see :class:`BodyFrames`."""
    positions, rotations = retarget.motion_positions(motion)
    headings = features.headings(rotations)
    places = np.column_stack([positions[:, 0, [0, 2]], headings])
    facing = pose_vectors.yaw(-headings)[:, None]
    ground = positions[:, :1] * np.array([1.0, 0.0, 1.0])
    return BodyFrames(
        places,
        rotation.rotate(facing, positions - ground),
        rotation.rotate(facing, features.velocity(positions, MOTION_FPS)),
        find_contacts(positions),
    )
