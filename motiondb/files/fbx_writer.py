"""Writer of FBX, through Blender where it is installed: the program, or the package bpy.

The format is not public, and Blender's exporter is the one that is free and well kept. Blender runs
in a process of its own. The pose without rotations becomes the pose of the bones; every bone points
along its Y axis, as Blender's do. The unit is the centimetre, y is up, and the first frame is at
0 s. Blender cuts names at 63 bytes and numbers equal ones; this is noted.
"""

from __future__ import annotations

import importlib.util
import json
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from motiondb.errors import CaptureError
from motiondb.files.bvh_writer import write_atomically, write_bvh
from motiondb.files.safe_files import open_file
from motiondb.files.text import quoted
from motiondb.records import Clip

UNIT = 0.01  # Metres: what Blender writes
_NAME_BYTES = 63  # Of a bone's name in Blender
_SECONDS = 600.0  # More than an hour of motion takes
_SCRIPT = Path(__file__).with_name("blender_fbx.py")


def find_program(name: str) -> str | None:
    """Return where a program lies on the PATH.

    Unlike ``shutil.which`` it is never one of the working folder, where that looks first on
    Windows: a folder of captures from elsewhere may hold a program, too.
    """
    ends = os.environ.get("PATHEXT", "").split(os.pathsep) if sys.platform == "win32" else [""]
    folders = map(Path, os.environ.get("PATH", os.defpath).split(os.pathsep))
    found = (each / f"{name}{end}" for each in folders if each.is_absolute() for end in ends)
    return next((str(path) for path in found if path.is_file() and os.access(path, os.X_OK)), None)


def find_blender() -> list[str]:
    """Return the command that runs a script in Blender; empty if it is not installed."""
    program = find_program("blender")
    if program is not None:
        how = ["--background", "--factory-startup", "--python-exit-code", "1", "--python"]
        return [program, *how, str(_SCRIPT)]
    if importlib.util.find_spec("bpy") is not None:
        return [sys.executable, "-P", str(_SCRIPT)]
    return []


def check_blender(path: object) -> None:
    """Refuse to write FBX where Blender is not installed (CaptureError)."""
    if not find_blender():
        raise CaptureError(
            path,
            "expected Blender, which writes FBX, found neither a program `blender` on the PATH nor "
            "the package bpy. Install Blender (https://www.blender.org), or write .glb or .bvh.",
        )


def write_fbx(clip: Clip, path: Path | str) -> tuple[str, ...]:
    """Write a clip with y up as FBX, whole or not at all (CaptureError); note changed names."""
    path = Path(path)
    check_blender(path)
    names = clip.skeleton.names
    said = {
        "joints": names,
        "armature": "Armature",
        "take": path.stem,
        "frames": clip.n_frames,
        "leaves": bool(clip.skeleton.end_sites),
    }
    with tempfile.TemporaryDirectory() as folder:
        bvh, fbx = Path(folder, "a.bvh"), Path(folder, "a.fbx")
        plain = replace(clip.skeleton, names=tuple(f"j{n}" for n in range(len(names))))
        write_bvh(replace(clip, skeleton=plain, unit=1.0), bvh)
        command, listed = [*find_blender(), "--", str(bvh), str(fbx)], json.dumps(said).encode()
        try:
            done = subprocess.run(
                command, input=listed, capture_output=True, timeout=_SECONDS, check=False
            )
        except (OSError, subprocess.TimeoutExpired) as error:
            raise CaptureError(path, f"expected Blender to write FBX, found: {error}.") from None
        if not fbx.is_file():
            reason = _reason((done.stderr + done.stdout).decode("utf-8", "replace"))
            raise CaptureError(path, f"expected Blender to write FBX, found: {reason}.")
        with open_file(fbx) as file:
            write_atomically(path, file.read())
    return _name_notes(names)


def _reason(output: str) -> str:
    r"""Return the line of Blender's output that says why it failed.

    >>> _reason("RuntimeError: Error: Python: Traceback (most recent call last):\n  File a\n"
    ...     "ValueError: no such bone\n\nLocation: x.py:3\n")
    'ValueError: no such bone'
    """
    lines = [line.strip() for line in output.splitlines() if "Traceback" not in line]
    said = [line for line in lines if re.match(r"(Error|[\w.]*(Error|Exception)):", line)]
    return (said or [line for line in lines if line] or ["no file and no reason"])[-1][:200]


def _name_notes(names: Sequence[str]) -> tuple[str, ...]:
    """Note the names that Blender changes.

    >>> _name_notes(["hips", "arm", "arm"])[0][-27:]
    " equal ones numbered: 'arm'"
    """
    cut = [name.encode()[:_NAME_BYTES].decode(errors="ignore") for name in names]
    changed = [n for at, (n, c) in enumerate(zip(names, cut)) if n != c or c in cut[:at]]
    if not changed:
        return ()
    shown = ", ".join(quoted(name) for name in dict.fromkeys(changed[:5]))
    return (
        f"Blender gave other names to {len(changed)} joints, since names are cut at "
        f"{_NAME_BYTES} bytes and equal ones numbered: {shown}",
    )
