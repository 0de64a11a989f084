"""Captures as files have them, and motions on the canonical body."""

from __future__ import annotations

from dataclasses import dataclass

from motiondb.records.arrays import MOTION_FPS, Float32Array, FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Skeleton:
    """Joints of one capture file, as the file has them."""

    names: tuple[str, ...]  # Joint names, in file order; parents come before children
    parents: IntArray  # (joints,): index of the parent, -1 for the root
    # (joints, 3): metres, from the parent in the parent's frame at zero rotation
    offsets: FloatArray
    # Joint, and x, y, z in metres in that joint's frame, of every end site
    end_sites: tuple[tuple[int, tuple[float, float, float]], ...] = ()
    # Per joint the names of its channels in file order, in BVH spelling ("Xposition", "Zrotation",
    # ...); empty if a joint has none
    channels: tuple[tuple[str, ...], ...] = ()


@dataclass(frozen=True, eq=False)
class Clip:
    """One capture, on its own skeleton and at its own frame rate.

    Attributes
    ----------
    skeleton : Skeleton
        Joints of the file.
    fps : float
        Frames per second.
    local_rotations : array (frames, joints, 4)
        Unit quaternions w, x, y, z, relative to the parent.
    root_positions : array (frames, 3)
        Metres, world frame, y up.
    joint_positions : array (frames, joints, 3) or None
        Where a file moves joints below the root: the translation of each joint in its parent's
        frame, metres, in place of ``offsets`` (the root's row repeats ``root_positions``).
    format : str
        "bvh", "amc", "deepmimic", "amass" or "c3d".
    unit : float
        Metres per length unit of the file.
    notes : tuple of str
        Sentences about unusual contents of the file and how the reader handled them.
    """

    skeleton: Skeleton
    fps: float
    local_rotations: FloatArray
    root_positions: FloatArray
    joint_positions: FloatArray | None = None
    format: str = "bvh"
    unit: float = 1.0
    notes: tuple[str, ...] = ()

    @property
    def n_frames(self) -> int:
        """Number of frames."""
        return len(self.root_positions)

    @property
    def duration(self) -> float:
        """Length in seconds, every frame lasting 1 / fps."""
        return self.n_frames / self.fps


@dataclass(frozen=True, eq=False)
class Motion:
    """A motion on the canonical body (``motiondb.body.body``) at 30 frames a second.

    World frame: right-handed, y up, the ground at y = 0.

    Attributes
    ----------
    local_rotations : array (frames, 21, 4), float32
        Unit quaternions w, x, y, z, relative to the parent joint.
    root_positions : array (frames, 3), float32
        World positions of the pelvis, metres on the standard body: the performer's positions
        scaled by standard leg length / performer's leg length.
    leg_length : float
        The performer's leg length, hip to ankle, metres.
    notes : tuple of str
        Sentences about repairs when the capture was read.
    """

    local_rotations: Float32Array
    root_positions: Float32Array
    leg_length: float = 0.8
    notes: tuple[str, ...] = ()

    @property
    def n_frames(self) -> int:
        """Number of frames."""
        return len(self.root_positions)

    @property
    def duration(self) -> float:
        """Length in seconds; every frame lasts 1 / 30 s."""
        return self.n_frames / MOTION_FPS

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the 21 joints, in the order of all arrays; parents come before children."""
        from motiondb.body.body import JOINTS

        return tuple(JOINTS)

    def joint_positions(self) -> FloatArray:
        """World positions of all joints: array (frames, 21, 3), metres on the standard body.

        Right-handed, y up. Multiply by ``leg_length / motiondb.body.body.LEG_LENGTH`` for the
        performer's size.
        """
        from motiondb.body.retarget import motion_positions

        return motion_positions(self)[0]
