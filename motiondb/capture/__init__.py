"""The edge to files: captures of all formats become clips, clips become BVH and glTF.

>>> from motiondb.capture import CAPTURE_ENDINGS
>>> CAPTURE_ENDINGS
('.bvh', '.amc', '.txt', '.json', '.npz', '.c3d')
"""

from motiondb.capture.bvh_writer import write_bvh
from motiondb.capture.formats import (
    CAPTURE_ENDINGS,
    capture_format,
    find_captures,
    read_capture,
    read_capture_bytes,
    skeleton_path,
)
from motiondb.capture.gltf import write_gltf
from motiondb.capture.gltf_scene import Character, write_gltf_scene
from motiondb.capture.units import UNITS, unit_from_name

__all__ = [
    "CAPTURE_ENDINGS",
    "UNITS",
    "Character",
    "capture_format",
    "find_captures",
    "read_capture",
    "read_capture_bytes",
    "skeleton_path",
    "unit_from_name",
    "write_bvh",
    "write_gltf",
    "write_gltf_scene",
]
