"""Input and output of files: captures of all formats become clips, clips become BVH and glTF.

>>> from motiondb.files import CAPTURE_ENDINGS
>>> CAPTURE_ENDINGS
('.bvh', '.amc', '.txt', '.json', '.npz', '.c3d', '.fbx')
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from motiondb.files.bvh_writer import to_bvh, write_bvh
    from motiondb.files.folder import (
        CAPTURE_ENDINGS,
        find_captures,
        name_fault,
        named_skeleton,
        not_read,
        printable,
        skeleton_path,
    )
    from motiondb.files.formats import (
        capture_format,
        read_capture,
        read_capture_bytes,
        read_file,
        read_takes_bytes,
        split_take,
    )
    from motiondb.files.gltf_writer import Character, write_gltf, write_gltf_scene
    from motiondb.files.limits import NO_LIMITS, ReadLimits, ReadOptions, cap_memory, guarded
    from motiondb.files.readers.amc import AsfFile
    from motiondb.files.units import UNITS, unit_from_name

__all__ = [
    "CAPTURE_ENDINGS",
    "NO_LIMITS",
    "UNITS",
    "AsfFile",
    "Character",
    "ReadLimits",
    "ReadOptions",
    "cap_memory",
    "capture_format",
    "find_captures",
    "guarded",
    "name_fault",
    "named_skeleton",
    "not_read",
    "printable",
    "read_capture",
    "read_capture_bytes",
    "read_file",
    "read_takes_bytes",
    "skeleton_path",
    "split_take",
    "to_bvh",
    "unit_from_name",
    "write_bvh",
    "write_gltf",
    "write_gltf_scene",
]

_PLACES = {
    "motiondb.files.bvh_writer": "to_bvh write_bvh",
    "motiondb.files.folder": "CAPTURE_ENDINGS find_captures name_fault named_skeleton not_read "
    "printable skeleton_path",
    "motiondb.files.formats": "capture_format read_capture read_capture_bytes read_file "
    "read_takes_bytes split_take",
    "motiondb.files.gltf_writer": "Character write_gltf write_gltf_scene",
    "motiondb.files.limits": "NO_LIMITS ReadLimits ReadOptions cap_memory guarded",
    "motiondb.files.readers.amc": "AsfFile",
    "motiondb.files.units": "UNITS unit_from_name",
}  # The names of each module, separated by spaces
_MODULES = {name: module for module, names in _PLACES.items() for name in names.split()}


def __getattr__(name: str) -> object:
    """Import a name when it is first used: the store needs file names alone, and no readers."""
    if name in _MODULES:
        return getattr(import_module(_MODULES[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
