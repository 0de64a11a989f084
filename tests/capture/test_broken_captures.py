"""A collection of broken captures, each beside the exact message."""

from __future__ import annotations

import io
import json

import numpy as np
import pytest

from motiondb.capture import read_capture_bytes
from motiondb.errors import CaptureError

BVH = """HIERARCHY
ROOT Hips
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT Leg
  {
    OFFSET 0 -45 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    End Site
    {
      OFFSET 0 -40 0
    }
  }
}
MOTION
Frames: 3
Frame Time: 0.0333333
0 90 0 0 0 0 0 0 0
0 91 0 10 0 0 20 0 0
0 92 0 0 30 0 0 0 40
"""
SKIP = (
    "The file may be cut short: export it again, or pass --skip-bad-frames to leave this frame out."
)
MEND = "Mend the line, or pass --skip-bad-frames to leave it out."
FEW = (
    "The file may be cut short: export it again, or pass --skip-bad-frames to read the frames that "
    "are there."
)
NINE = "expected 9 values (6 for the root, 3 for each of 1 joints)"
RATE = "Give the right frame rate with --fps."

BROKEN_BVH = {
    "empty file": ("", "w.bvh: expected a capture, found an empty file. Export it again."),
    "white space": (" \n\n ", "w.bvh: expected a capture, found an empty file. Export it again."),
    "binary data": (
        "\0\1\2",
        "w.bvh: expected text, found binary data. Check the file's ending, or export it as text.",
    ),
    "another text": (
        "Dear all,\n",
        "w.bvh:1: expected a keyword such as JOINT or OFFSET, found 'Dear'.\n"
        "w.bvh:1: expected a ROOT joint, found none. Is this a BVH file?\n"
        "w.bvh: expected a line MOTION, found none. The file may be cut short.",
    ),
    "cut in the hierarchy": (
        BVH[: BVH.index("OFFSET 0 -45")],
        "w.bvh:7: expected '}' for 'Leg' of line 6, found the end.\n"
        "w.bvh:7: expected '}' for 'Hips' of line 2, found the end.\n"
        "w.bvh:6: expected an OFFSET for 'Leg', found none; write one.\n"
        "w.bvh: expected a line MOTION, found none. The file may be cut short.",
    ),
    "cut before the motion": (
        BVH.split("MOTION")[0],
        "w.bvh: expected a line MOTION, found none. The file may be cut short.",
    ),
    "cut in a frame": (
        BVH[:-12],
        f"w.bvh:21: {NINE}, found 4. {SKIP}",
    ),
    "cut between frames": (
        BVH.replace("0 92 0 0 30 0 0 0 40\n", ""),
        f"w.bvh: expected 3 frames as the header says, found 2. {FEW}",
    ),
    "cut in an early frame": (
        BVH.split(" 10 0 0 20")[0],
        f"w.bvh:20: {NINE}, found 3. {SKIP}\n"
        f"w.bvh: expected 3 frames as the header says, found 2. {FEW}",
    ),
    "a short and a long frame": (
        BVH.replace("20 0 0\n", "20 0\n").replace("0 40\n", "0 40 5\n"),
        f"w.bvh:20: {NINE}, found 8. {SKIP}\nw.bvh:21: {NINE}, found 10. {SKIP}",
    ),
    "no frames": (
        BVH.split("0 90 0")[0].replace("Frames: 3", "Frames: 0"),
        "w.bvh: expected at least 1 frame, found 0. Export the motion again.",
    ),
    "NaN": (
        BVH.replace("91", "nan"),
        f"w.bvh:20: expected numbers, found 'nan' as value 2. {MEND}",
    ),
    "infinity": (
        BVH.replace("91", "1e999"),
        f"w.bvh:20: expected numbers, found '1e999' as value 2. {MEND}",
    ),
    "decimal commas": (
        BVH.replace("0 91 0 10", "0 91,5 0 10").replace("0 92", "0 92,25"),
        f"w.bvh:20: expected numbers, found '91,5' as value 2. {MEND}\n"
        f"w.bvh:21: expected numbers, found '92,25' as value 2. {MEND}",
    ),
    "a frame time of 0": (
        BVH.replace("0.0333333", "0"),
        f"w.bvh:18: expected a frame time from 0.0005 to 1 s, found 0. {RATE}",
    ),
    "a rate in place of a time": (
        BVH.replace("0.0333333", "30"),
        f"w.bvh:18: expected a frame time from 0.0005 to 1 s, found 30. {RATE}",
    ),
    "a negative frame time": (
        BVH.replace("0.0333333", "-0.03"),
        f"w.bvh:18: expected a frame time from 0.0005 to 1 s, found -0.03. {RATE}",
    ),
    "an absurd frame time": (
        BVH.replace("0.0333333", "1e-9"),
        f"w.bvh:18: expected a frame time from 0.0005 to 1 s, found 1e-09. {RATE}",
    ),
    "a frame time that is none": (
        BVH.replace("0.0333333", "fast"),
        f"w.bvh:18: expected a frame time from 0.0005 to 1 s, found no number. {RATE}",
    ),
    "no frame time": (
        BVH.replace("Frame Time: 0.0333333\n", ""),
        "w.bvh:18: expected a line 'Frame Time: seconds', found none. Give --fps.",
    ),
    "no number of frames": (
        BVH.replace("Frames: 3\n", ""),
        "w.bvh:18: expected a line 'Frames: N', found none.",
    ),
    "a number of frames that is none": (
        BVH.replace("Frames: 3", "Frames: many"),
        "w.bvh:17: expected a number of frames, found 'many'.",
    ),
    "two performers": (
        BVH.replace(
            "MOTION",
            "ROOT Ben\n{\nOFFSET 0 0 0\nCHANNELS 3 Xrotation Yrotation Zrotation\n}\nMOTION",
        ),
        "w.bvh:16: expected one ROOT, found a second, 'Ben', after 'Hips' of line 2. "
        "Export one performer a file.",
    ),
    "an open brace": (
        BVH.replace("  }\n}\nMOTION", "}\nMOTION"),
        "w.bvh:14: expected '}' for 'Hips' of line 2, found the end.",
    ),
    "a brace too many": (
        BVH.replace("}\nMOTION", "}\n}\nMOTION"),
        "w.bvh:16: expected as many '{' as '}', found one '}' too many.",
    ),
    "a short OFFSET": (
        BVH.replace("OFFSET 0 -45 0", "OFFSET 0 -45"),
        "w.bvh:8: expected 3 numbers after OFFSET, found '0 -45'.\n"
        "w.bvh:6: expected an OFFSET for 'Leg', found none; write one.",
    ),
    "no channels at all": (
        "HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 0\n}\nMOTION\nFrames: 1\nFrame Time: 0.1\n",
        "w.bvh: expected channels in the HIERARCHY, found none: nothing moves.",
    ),
    "several faults at once": (
        BVH.replace("CHANNELS 3", "CHANNELS 4")
        .replace("Yposition", "Yscale")
        .replace("0.0333333", "0"),
        "w.bvh:5: expected channels such as Xposition or Zrotation, found 'Yscale'.\n"
        "w.bvh:9: expected 4 channel names, found 3 names.\n"
        f"w.bvh:18: expected a frame time from 0.0005 to 1 s, found 0. {RATE}",
    ),
    "joints without names": (
        BVH.replace("JOINT Leg", "JOINT"),
        "w.bvh:6: expected a name after JOINT, found none.",
    ),
    "a joint without braces": (
        BVH.replace("JOINT Leg\n  {\n", "JOINT Leg\n"),
        "w.bvh:9: expected '{' before the next joint, found none.\n"
        "w.bvh:14: expected as many '{' as '}', found one '}' too many.\n"
        "w.bvh:6: expected an OFFSET for 'Leg', found none; write one.",
    ),
}


@pytest.mark.parametrize("name", BROKEN_BVH)
def test_broken_bvh(name: str) -> None:
    text, message = BROKEN_BVH[name]
    with pytest.raises(CaptureError) as caught:
        read_capture_bytes(text.encode(), "bvh", path="w.bvh")
    assert str(caught.value) == message


def test_many_bad_frames_are_counted() -> None:
    text = BVH.replace("Frames: 3", "Frames: 53") + "1 2 3\n" * 50
    with pytest.raises(CaptureError) as caught:
        read_capture_bytes(text.encode(), "bvh", path="w.bvh")
    lines = str(caught.value).splitlines()
    assert len(lines) == 21
    assert lines[-1] == "w.bvh: ... and 30 more faults like these."


def test_nothing_left_after_leaving_bad_frames_out() -> None:
    text = BVH.split("0 90 0")[0].replace("Frames: 3", "Frames: 1") + "1 2 3\n"
    with pytest.raises(CaptureError) as caught:
        read_capture_bytes(text.encode(), "bvh", path="w.bvh", skip_bad_frames=True)
    assert str(caught.value) == f"w.bvh:19: {NINE}, found 3. {SKIP}"


ASF = """:units
  length 0.45
:bonedata
  begin
    name hip
    direction 0 -1 0
    length 7
    axis 0 0 20 XYZ
    dof rx ry rz
  end
  begin
    name shin
    direction 0 -1 0
    length 7
    axis 0 0 20 XYZ
    dof rx
  end
:hierarchy
  begin
    root hip
    hip shin
  end
"""
AMC = ":DEGREES\n" + "".join(f"{n}\nroot 1 17 2 0 0 0\nhip 1 2 3\nshin 4\n" for n in (1, 2, 3))
SAME_BODY = "a.amc: Give the ASF of the same body, or export the file again if it is cut short."

BROKEN_AMC = {
    "no frames": (
        ":FULLY-SPECIFIED\n:DEGREES\n",
        "a.amc: expected at least 1 frame, found 0. Is this an AMC file?",
    ),
    "bones of another body": (
        AMC.replace("shin 4", "tail 4"),
        f"a.amc:5: expected a bone of a.asf, found 'tail'.\n"
        f"a.amc:2: expected values for shin as a.asf says, found none.\n{SAME_BODY}",
    ),
    "a name that is near": (
        AMC.replace("shin 4", "shinn 4"),
        "a.amc:5: expected a bone of a.asf, found 'shinn'. Did you mean shin?\n"
        f"a.amc:2: expected values for shin as a.asf says, found none.\n{SAME_BODY}",
    ),
    "other degrees of freedom": (
        AMC.replace("shin 4", "shin 4 5 6"),
        f"a.amc:5: expected 1 value for shin (rx) as a.asf says, found 3.\n{SAME_BODY}",
    ),
    "a bone twice": (
        AMC.replace("shin 4\n", "shin 4\nshin 4\n"),
        f"a.amc:6: expected 'shin' once a frame, found it twice.\n{SAME_BODY}",
    ),
    "a short line": (
        AMC.replace("2\nroot 1 17 2 0 0 0\nhip 1 2 3", "2\nroot 1 17 2 0 0 0\nhip 1 2"),
        f"a.amc:8: expected 3 values for hip, found 2. {SKIP}",
    ),
    "NaN": (
        AMC.replace("2\nroot 1 17", "2\nroot 1 nan"),
        "a.amc:7: expected numbers for root, found 'nan'. "
        "Mend the line, or pass --skip-bad-frames to leave the frame out.",
    ),
    "a bone that is lost": (
        AMC.replace("shin 4\n2\n", "2\n").replace("shin 4\n3\n", "3\n"),
        f"a.amc:2: expected values for shin as a.asf says, found none.\n{SAME_BODY}",
    ),
    "a bone that is lost later": (
        AMC.replace("shin 4\n3\n", "3\n"),
        f"a.amc:6: expected 3 bones in this frame, found 2 (shin is missing). {SKIP}",
    ),
    "a bone that comes later": (
        AMC.replace("shin 4\n3\n", "shin 4\ntail 1\n3\n"),
        f"a.amc:10: expected a bone of the first frame, found 'tail'. {SKIP}",
    ),
}


@pytest.mark.parametrize("name", BROKEN_AMC)
def test_broken_amc(name: str) -> None:
    text, message = BROKEN_AMC[name]
    with pytest.raises(CaptureError) as caught:
        read_capture_bytes(
            text.encode(), "amc", path="a.amc", skeleton=ASF.encode(), skeleton_path="a.asf"
        )
    assert str(caught.value) == message


BROKEN_ASF = {
    "empty file": ("", "a.asf: expected a capture, found an empty file. Export it again."),
    "another text": (
        "Dear all,\n",
        "a.asf: expected bones in :bonedata, found none. Is this an ASF file?",
    ),
    "cut in a bone": (
        ASF[: ASF.index("    dof rx\n")],
        "a.asf:11: expected 'end' for bone 'shin', found none.\n"
        "a.asf: expected bones below root in :hierarchy, found none.",
    ),
    "cut before the hierarchy": (
        ASF[: ASF.index(":hierarchy")],
        "a.asf: expected bones below root in :hierarchy, found none.",
    ),
    "a bone without a parent": (
        ASF.replace("    hip shin\n", ""),
        "a.asf:11: expected a parent of 'shin' in :hierarchy, found none.",
    ),
    "an unknown bone": (
        ASF.replace("hip shin\n", "hip shin tail\n"),
        "a.asf:21: expected a bone of :bonedata, found 'tail'.",
    ),
    "two parents": (
        ASF.replace("root hip\n", "root hip shin\n"),
        "a.asf:21: expected one parent for 'shin', found a second.",
    ),
    "a circle": (
        ASF.replace("hip shin\n", "hip shin\n    shin root\n"),
        "a.asf:22: expected one parent for 'root', found a second.",
    ),
    "no numbers": (
        ASF.replace("direction 0 -1 0", "direction 0 down 0", 1).replace("length 7", "length", 1),
        "a.asf:6: expected 3 numbers after direction, found '0 down 0'.\n"
        "a.asf:7: expected a number after length, found 'none'.",
    ),
    "a sliding joint": (
        ASF.replace("dof rx\n", "dof rx tz\n"),
        "a.asf:16: expected rx, ry or rz as dof of 'shin', found 'tz'.",
    ),
    "a bone twice": (
        ASF.replace("name shin", "name hip").replace("hip shin", "hip"),
        "a.asf:11: expected one bone 'hip', found a second.",
    ),
}


@pytest.mark.parametrize("name", BROKEN_ASF)
def test_broken_asf(name: str) -> None:
    text, message = BROKEN_ASF[name]
    with pytest.raises(CaptureError) as caught:
        read_capture_bytes(
            AMC.encode(), "amc", path="a.amc", skeleton=text.encode(), skeleton_path="a.asf"
        )
    assert str(caught.value) == message


def test_amc_without_its_asf() -> None:
    with pytest.raises(CaptureError) as caught:
        read_capture_bytes(AMC.encode(), "amc", path="a.amc")
    assert str(caught.value) == (
        "a.amc: expected the ASF file of its body, found none. Put it beside the AMC."
    )


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

BROKEN_AMASS = {
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
        "a.npz: expected an array 'poses', found fps, trans. Is this a motion of AMASS?",
    ),
    "another npz": (
        _npz(weights=TRANS),
        "a.npz: expected an array 'poses', found none of the known. Is this a motion of AMASS?",
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
        "a.npz: expected poses of shape (frames, 66 or more), found (4, 60). "
        "Export the poses of the SMPL body as axis-angle.",
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
