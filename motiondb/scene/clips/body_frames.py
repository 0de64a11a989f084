"""A capture as scenes look at it: where the body is on the ground, and its pose seen from there.

Per frame: the place (x, z, heading) of the pelvis on the ground, the joints in the frame of that
place (x left, y up, z ahead; the root's height stays in), and their velocities, turned into the
same frame but not freed of the body's own travel, so that running and standing in the same pose
are far apart.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from motiondb.generate.contact import find_contacts
from motiondb.pose import body, features, pose_vectors, retarget, rotation
from motiondb.records import MOTION_FPS, FloatArray, Motion
from motiondb.scene.clips.ground import compose, relative

WRISTS = (body.INDEX["l_wrist"], body.INDEX["r_wrist"])


@dataclass(frozen=True, eq=False)
class BodyFrames:
    """A motion, frame by frame, as seen from its own places on the ground.

    Attributes
    ----------
    places : array (frames, 3), x, z in metres and heading in radians, unwrapped, world.
    joints : array (frames, 21, 3), metres, in the frame of the place.
    velocities : array (frames, 21, 3), metres a second in the world, along the place's axes.
    contacts : array (frames, 2), whether the left and the right foot is on the ground.
    """

    places: FloatArray
    joints: FloatArray
    velocities: FloatArray
    contacts: NDArray[np.bool_]

    @property
    def n_frames(self) -> int:
        """Number of frames."""
        return len(self.places)

    @cached_property
    def speeds(self) -> FloatArray:
        """Mean speed of all joints, array (frames,), metres a second."""
        return np.asarray(np.linalg.norm(self.velocities, axis=2).mean(axis=1))

    def path(self, start: int, end: int) -> FloatArray:
        """Places of the frames ``start`` to ``end``, both included, as seen from the first.

        array (end - start + 1, 3). Where the capture ends before ``end``, its last step is
        repeated, so that the last row is where the next clip begins.
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
        """The mirror image, left and right exchanged."""
        flip = np.array([-1.0, 1.0, 1.0])
        return BodyFrames(
            self.places * np.array([-1.0, 1.0, -1.0]),
            self.joints[:, body.MIRROR] * flip,
            self.velocities[:, body.MIRROR] * flip,
            self.contacts[:, ::-1],
        )


def body_frames(motion: Motion) -> BodyFrames:
    """See :class:`BodyFrames`."""
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
