"""Broken AMC and ASF files, each beside the exact message."""

from __future__ import annotations

import pytest

from motiondb.errors import CaptureError
from motiondb.files.formats import read_capture_bytes
from motiondb.files.limits import SkeletonFile

SKIP = (
    "The file may be cut short: export it again, or pass --skip-bad-frames to leave this frame out."
)
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
        "Correct the line, or pass --skip-bad-frames to leave the frame out.",
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
            text.encode(), "amc", path="a.amc", skeleton=SkeletonFile(ASF.encode(), "a.asf")
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
    "a bone without an end": (
        ASF.replace("    dof rx ry rz\n  end\n", "    dof rx ry rz\n"),
        "a.asf:4: expected 'end' for bone 'hip', found none.\n"
        "a.asf:19: expected a bone of :bonedata, found 'hip'.\n"
        "a.asf:20: expected a bone of :bonedata, found 'hip'.",
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
            AMC.encode(), "amc", path="a.amc", skeleton=SkeletonFile(text.encode(), "a.asf")
        )
    assert str(caught.value) == message


def test_amc_without_its_asf() -> None:
    with pytest.raises(CaptureError) as caught:
        read_capture_bytes(AMC.encode(), "amc", path="a.amc")
    assert str(caught.value) == (
        "a.amc: expected the ASF file of its body, found none. Put it beside the AMC."
    )
