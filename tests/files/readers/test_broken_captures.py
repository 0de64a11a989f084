"""Broken DeepMimic and AMASS files, each beside the exact message."""

from __future__ import annotations

import io
import json

import numpy as np
import pytest

from motiondb.errors import CaptureError
from motiondb.files.folder import FORMATS
from motiondb.files.formats import read_capture_bytes, read_takes_bytes

RATE = "Give the right frame rate with --fps."
FRAME = [0.03, 0, 0.9, 0] + [1, 0, 0, 0] * 4 + [0] + [1, 0, 0, 0] * 2 + [0] + [1, 0, 0, 0]
FRAME += [0] + [1, 0, 0, 0] * 2 + [0]
AGAIN = "Export it again, or pass --skip-bad-frames to leave it out."

BROKEN_DEEPMIMIC = {
    "cut short": (
        json.dumps({"Frames": [FRAME]})[:60],
        "f.txt:1: expected JSON, found a fault: Expecting value. The file may be cut short.",
    ),
    "other JSON": (
        '{"name": 1}',
        'f.txt: expected a list "Frames", found none. Is this a DeepMimic motion file?',
    ),
    "no frames": (
        '{"Frames": []}',
        "f.txt: expected at least 1 frame, found 0. Export the motion again.",
    ),
    "a short frame and no frame": (
        json.dumps({"Frames": [FRAME, FRAME[:40], 7]}),
        f"f.txt: frame 1: expected 44 numbers (4, root 4, 12 joints 36), found 40. {AGAIN}\n"
        f"f.txt: frame 2: expected 44 numbers (4, root 4, 12 joints 36), found no list. {AGAIN}",
    ),
    "another body": (
        json.dumps({"Frames": [FRAME[:19], FRAME[:19]]}),
        "f.txt: expected 44 numbers a frame, as DeepMimic's humanoid has, found 19 in all: the "
        "motion of another body. Export it in another format.",
    ),
    "NaN": (
        json.dumps({"Frames": [[float("nan"), *FRAME[1:]]]}),
        f"f.txt: frame 0: expected finite numbers, found 'nan' as value 1. {AGAIN}",
    ),
    "text": (
        json.dumps({"Frames": [["fast", *FRAME[1:]]]}),
        f"f.txt: frame 0: expected finite numbers, found 'fast' as value 1. {AGAIN}",
    ),
    "no rotation": (
        json.dumps({"Frames": [[*FRAME[:4], 0, 0, 0, 0, *FRAME[8:]]]}),
        f"f.txt: frame 0: expected a quaternion for root, found zeros. {AGAIN}",
    ),
    "other text": (
        "Take 2 was good.",
        'f.txt: expected JSON of DeepMimic with a list "Frames", found other text. Leave the file '
        "out, or export its motion in another format, such as BVH.",
    ),
    "an absurd duration": (
        json.dumps({"Frames": [[30.0, *FRAME[1:]]]}),
        f"f.txt: expected frames of 0.0005 to 1 s, found 30 s. {RATE}",
    ),
}


@pytest.mark.parametrize("name", BROKEN_DEEPMIMIC)
def test_broken_deepmimic(name: str) -> None:
    text, message = BROKEN_DEEPMIMIC[name]
    with pytest.raises(CaptureError) as caught:
        read_capture_bytes(text.encode(), "deepmimic", path="f.txt")
    assert str(caught.value) == message


def _npz(**arrays: object) -> bytes:
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)
    return buffer.getvalue()


POSES, TRANS = np.zeros((4, 66)), np.zeros((4, 3))
_HOLED = POSES.copy()
_HOLED[2:, 7] = np.nan

KNOWN = (
    "a.npz: expected arrays of SMPL (poses, trans), of a robot (qpos; or root_pos, root_rot and "
    "dof_pos), or places of joints (positions), found {}. Save them under these names."
)
BROKEN_AMASS = {
    "joints of a robot alone": (
        _npz(dof_pos=POSES, fps=30),
        KNOWN.format("'dof_pos', 'fps'"),
    ),
    "no npz": (
        b"PK\3\4 something",
        "a.npz: expected an npz file of plain arrays, found something else. Save it again.",
    ),
    "cut short": (
        _npz(poses=POSES, trans=TRANS, fps=30)[:900],
        "a.npz: expected an npz file of plain arrays, found something else. Save it again.",
    ),
    "pickled objects": (
        _npz(poses=np.array([{}], dtype=object), trans=TRANS),
        "a.npz: expected an npz file of plain arrays, found something else. Save it again.",
    ),
    "no poses": (
        _npz(trans=TRANS, fps=30),
        KNOWN.format("'fps', 'trans'"),
    ),
    "another npz": (
        _npz(weights=TRANS),
        KNOWN.format("'weights'"),
    ),
    "no frame rate": (
        _npz(poses=POSES, trans=TRANS),
        "a.npz: expected a frame rate (mocap_framerate or fps), found none. Give it with --fps.",
    ),
    "an absurd frame rate": (
        _npz(poses=POSES, trans=TRANS, mocap_framerate=1e6),
        f"a.npz: expected mocap_framerate from 1 to 2000, found 1e+06. {RATE}",
    ),
    "too few joints": (
        _npz(poses=POSES[:, :60], trans=TRANS, fps=30),
        "a.npz: expected poses with 3, 4, 6 or 9 numbers for each of 22, 23, 24, 52, 53, 55 "
        "joints, found shape (4, 60). Export the poses of the SMPL body as axis-angle.",
    ),
    "unequal lengths": (
        _npz(poses=POSES, trans=TRANS[:3], fps=30),
        "a.npz: expected trans of shape (4, 3) as poses has 4 frames, found (3, 3). "
        "Export the file again.",
    ),
    "no frames": (
        _npz(poses=POSES[:0], trans=TRANS[:0], fps=30),
        "a.npz: expected at least 1 frame, found 0. Export the motion again.",
    ),
    "text": (
        _npz(poses=np.array([["a"] * 66] * 4), trans=TRANS, fps=30),
        "a.npz: expected numbers in 'poses', found other values.",
    ),
    "NaN": (
        _npz(poses=_HOLED, trans=TRANS, fps=30),
        "a.npz: expected finite numbers, found NaN or infinity in 2 frames, the first is 2. "
        "Export it again, or pass --skip-bad-frames to leave them out.",
    ),
}


@pytest.mark.parametrize("name", BROKEN_AMASS)
def test_broken_amass(name: str) -> None:
    data, message = BROKEN_AMASS[name]
    with pytest.raises(CaptureError) as caught:
        read_capture_bytes(data, "amass", path="a.npz")
    assert str(caught.value) == message


@pytest.mark.parametrize("kind", sorted({*FORMATS.values()}))
def test_an_empty_file_is_called_empty(kind: str) -> None:
    with pytest.raises(CaptureError, match=r"f: expected a capture, found an empty file\. Export"):
        read_takes_bytes(b"", kind, path="f")
