"""Broken BVH files, each beside the exact message."""

from __future__ import annotations

import pytest

from motiondb.errors import CaptureError
from motiondb.files.formats import read_capture_bytes
from motiondb.files.limits import ReadOptions

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
COMMA = "Export the file with decimal points: it has decimal commas."
MEND = "Correct the line, or pass --skip-bad-frames to leave it out."
FEW = (
    "The file may be cut short: export it again, or pass --skip-bad-frames to read the frames that "
    "are there."
)
NINE = "expected 9 values (6 for the root, 3 for each of 1 joints)"
RATE = "Give the right frame rate with --fps."

BROKEN_BVH = {
    "empty file": ("", "w.bvh: expected a capture, found an empty file. Export it again."),
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
        "w.bvh:7: expected '}' for 'Leg' of line 6 and 1 more around it, found the end.\n"
        "w.bvh:6: expected an OFFSET for 'Leg', found none; write one.\n"
        "w.bvh: expected a line MOTION, found none. The file may be cut short.",
    ),
    "cut in a frame": (
        BVH[:-12],
        f"w.bvh:21: {NINE}, found 4. {SKIP}",
    ),
    "cut between frames": (
        BVH.replace("0 92 0 0 30 0 0 0 40\n", "").replace("Frames: 3", "Frames: 4"),
        f"w.bvh: expected 4 frames as the header says, found 2. {FEW}",
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
    "decimal commas": (
        BVH.replace("0 91 0 10", "0 91,5 0 10").replace("0 92", "0 92,25"),
        f"w.bvh:20: expected numbers, found '91,5' as value 2. {COMMA}\n"
        f"w.bvh:21: expected numbers, found '92,25' as value 2. {COMMA}",
    ),
    "a frame time of 0": (
        BVH.replace("0.0333333", "0"),
        f"w.bvh:18: expected a frame time from 0.0005 to 1 s, found 0. {RATE}",
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
        .replace("Yposition", "Yshear")
        .replace("0.0333333", "0"),
        "w.bvh:5: expected channels such as Xposition or Zrotation, found 'Yshear'.\n"
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
        read_capture_bytes(
            text.encode(), "bvh", path="w.bvh", options=ReadOptions(skip_bad_frames=True)
        )
    assert str(caught.value) == f"w.bvh:19: {NINE}, found 3. {SKIP}"
