"""Which file is a capture, which reader reads it, which skeleton belongs to it.

Every reader turns bytes into a :class:`Clip`; paths serve for messages only, so that a capture can
be read again from the bytes that the store keeps.
"""

from __future__ import annotations

import re
from pathlib import Path

from motiondb.errors import CaptureError
from motiondb.records import Clip

_FORMATS = {
    ".bvh": "bvh",
    ".amc": "amc",
    ".txt": "deepmimic",
    ".json": "deepmimic",
    ".npz": "amass",
    ".c3d": "c3d",
}
CAPTURE_ENDINGS: tuple[str, ...] = tuple(_FORMATS)
"""Endings of captures, lower case; ".txt" and ".json" count where they hold DeepMimic's JSON."""
_LOOK = 4096


def capture_format(path: Path | str) -> str:
    """The format that a file's ending names.

    >>> capture_format("walk.BVH")
    'bvh'

    Raises
    ------
    CaptureError
        for any other ending.
    """
    ending = Path(path).suffix.lower()
    if ending not in _FORMATS:
        known = ", ".join(CAPTURE_ENDINGS)
        raise CaptureError(
            path, f"expected a capture ({known}), found ending {ending!r}. Rename or convert it."
        )
    return _FORMATS[ending]


def find_captures(folder: Path | str) -> list[Path]:
    """All captures below a folder, sorted; hidden files and folders are passed over."""
    root = Path(folder)
    found = [
        path
        for path in root.rglob("*")
        if path.suffix.lower() in _FORMATS
        and path.is_file()
        and not any(part.startswith(".") for part in path.relative_to(root).parts)
        and (path.suffix.lower() not in (".txt", ".json") or _is_deepmimic(path))
    ]
    return sorted(found)


def read_capture(
    path: Path | str,
    *,
    skeleton: Path | str | None = None,
    fps: float | None = None,
    unit: float | None = None,
    data: bytes | None = None,
    skip_bad_frames: bool = False,
) -> Clip:
    """The clip in a capture file.

    Parameters
    ----------
    path : the file; its ending names the format.
    skeleton : the ASF file of an AMC; None: the one that :func:`skeleton_path` finds.
    fps : frames per second, in place of what the file says.
    unit : metres per length unit; None: what the file says, or found from the size of the body.
    data : the file's bytes, if they are at hand.
    skip_bad_frames : leave bad frames out instead of refusing the file.

    Raises
    ------
    CaptureError
        when the file cannot be read; it lists every structural fault with its line.
    """
    path = Path(path)
    kind = capture_format(path)
    asf = skeleton_path(path, skeleton) if kind == "amc" else None
    return read_capture_bytes(
        _read_bytes(path) if data is None else data,
        kind,
        path=path,
        skeleton=None if asf is None else _read_bytes(asf),
        skeleton_path=asf or "",
        fps=fps,
        unit=unit,
        skip_bad_frames=skip_bad_frames,
    )


def read_capture_bytes(
    data: bytes,
    kind: str,
    *,
    path: Path | str = "capture",
    skeleton: bytes | None = None,
    skeleton_path: Path | str = "skeleton",
    fps: float | None = None,
    unit: float | None = None,
    skip_bad_frames: bool = False,
) -> Clip:
    """The clip in the bytes of a capture of format ``kind`` ("bvh", "amc", ...).

    ``path`` and ``skeleton_path`` serve for messages only; ``skeleton`` holds the bytes of the ASF.
    Further parameters and errors as in :func:`read_capture`.
    """
    if fps is not None and not 0 < fps < float("inf"):
        raise CaptureError(path, f"expected a frame rate above 0, found {fps:g}. Give another.")
    if kind == "bvh":
        from motiondb.capture.bvh import read_bvh

        return read_bvh(data, path, fps=fps, unit=unit, skip_bad_frames=skip_bad_frames)
    if kind == "amc":
        from motiondb.capture.amc import read_amc

        return read_amc(
            data, path, skeleton, skeleton_path, fps=fps, unit=unit, skip_bad_frames=skip_bad_frames
        )
    if kind == "deepmimic":
        from motiondb.capture.deepmimic import read_deepmimic

        return read_deepmimic(data, path, fps=fps, unit=unit, skip_bad_frames=skip_bad_frames)
    if kind == "amass":
        from motiondb.capture.amass import read_amass

        return read_amass(data, path, fps=fps, unit=unit, skip_bad_frames=skip_bad_frames)
    if kind == "c3d":
        from motiondb.capture.c3d import read_c3d

        return read_c3d(data, path, fps=fps, unit=unit, skip_bad_frames=skip_bad_frames)
    raise CaptureError(path, f"expected a known format, found {kind!r}.")


def skeleton_path(path: Path | str, skeleton: Path | str | None = None) -> Path | None:
    """The ASF file that belongs to an AMC file; None for captures that need none.

    That is ``skeleton`` if given, else the ASF of the same folder (in any case of letters) that is
    named like the part of the AMC's name before its last "_", like the AMC, or is the only one.

    Raises
    ------
    CaptureError
        when there is none, or when it is not clear which.
    """
    path = Path(path)
    if path.suffix.lower() != ".amc":
        return None
    if skeleton is not None:
        return Path(skeleton)
    beside = sorted(p for p in path.parent.iterdir() if p.suffix.lower() == ".asf")
    for stem in (path.stem, path.stem.rpartition("_")[0], re.split(r"_", path.stem)[0]):
        for candidate in beside:
            if stem and candidate.stem.lower() == stem.lower():
                return candidate
    if len(beside) == 1:
        return beside[0]
    wanted = f"{path.stem.split('_')[0]}.asf"
    found = ", ".join(p.name for p in beside[:5]) if beside else "no ASF file"
    raise CaptureError(
        path,
        f"expected its skeleton {wanted} in the same folder, found {found}. "
        "Put the ASF beside the AMC, or name it in the sheet's column 'skeleton'.",
    )


def _read_bytes(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        reason = (error.strerror or "an error").lower()
        raise CaptureError(path, f"expected a readable file, found: {reason}.") from error


def _is_deepmimic(path: Path) -> bool:
    """Whether a text file starts like JSON and names its Frames near the begin or the end."""
    try:
        with path.open("rb") as file:
            start = file.read(_LOOK)
            file.seek(max(0, path.stat().st_size - _LOOK))
            end = file.read(_LOOK)
    except OSError:
        return False
    start = start.removeprefix(b"\xef\xbb\xbf").lstrip()
    return start.startswith(b"{") and (b'"Frames"' in start or b'"Frames"' in end)
