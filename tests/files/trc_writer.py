"""A small writer of TRC, and a person as centres of joints."""

from __future__ import annotations

from collections.abc import Mapping

from motiondb.files.limits import AS_USUAL, ReadOptions
from motiondb.files.readers.c3d import read_c3d_takes
from motiondb.files.readers.markers import only_performer
from motiondb.files.readers.trc import read_trc_takes
from motiondb.records import Clip

_SIDED = {
    "Hip": (9, 92, 0), "Knee": (9, 50, 1), "Ankle": (9, 9, 0), "BigToe": (9, 2, 14),
    "Heel": (9, 2, -5), "Shoulder": (18, 145, 0), "Elbow": (45, 145, 0), "Wrist": (70, 145, 0),
}  # fmt: skip
CENTRES = (
    {f"L{name}": place for name, place in _SIDED.items()}
    | {f"R{name}": (-x, y, z) for name, (x, y, z) in _SIDED.items()}
    | {"Neck": (0, 148, 0), "Head": (0, 172, 2)}
)
"""Centres as OpenPose and Pose2Sim name them, centimetres, y up."""


def trc(places: Mapping[str, tuple[float, ...]], unit: str = "cm", scale: float = 1.0) -> bytes:
    """Write points that move ahead by 1 cm a frame, with a blank cell in the second frame."""
    heads = "".join(f"{name}\t\t\t" for name in places)
    axes = "".join(f"X{n}\tY{n}\tZ{n}\t" for n in range(1, len(places) + 1))
    lines = [
        "PathFileType\t4\t(X/Y/Z)\ta.trc",
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits",
        f"60.00\t60.00\t20\t{len(places)}\t{unit}",
        f"Frame#\tTime\t{heads}",
        f"\t\t{axes}",
        "",
    ]
    for frame in range(20):
        numbers = [
            f"{scale * (v + frame * (k == 2)):.6f}"
            for p in places.values()
            for k, v in enumerate(p)
        ]
        if frame == 1:
            numbers[:3] = ["", "", ""]
        lines.append("\t".join([str(frame + 1), f"{frame / 60:.3f}", *numbers]))
    return "\n".join(lines).encode()


def read_trc(data: bytes, path: object, options: ReadOptions = AS_USUAL) -> Clip:
    """Read the only performer of a TRC."""
    return only_performer(read_trc_takes(data, path, options), path, options)


def read_c3d(data: bytes, path: object, options: ReadOptions = AS_USUAL) -> Clip:
    """Read the only performer of a C3D."""
    return only_performer(read_c3d_takes(data, path, options), path, options)
