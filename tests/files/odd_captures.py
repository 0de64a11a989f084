"""Odd captures and sheets made from a seed: what damaged, hostile and merely strange files hold.

``case(seed)`` gives the same bytes on every machine. Each case starts from a small whole file of
one kind and damages it: bytes and tokens are exchanged, cut, repeated; numbers become those that
break programs; structures are nested, widened and declared larger than they are. Further kinds are
built to be hostile as a whole, such as compressed zeros and deep nesting.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np
from odd_c3d import damaged_c3d
from odd_damage import NUMBERS, damage
from odd_npz import mutated_npz, odd_npz, strange_npz

Companions = dict[str, bytes]
"""Name -> content of further files that belong to a case, such as the ASF of an AMC."""

BONES = (
    # joint of the canonical body, parent, offset in centimetres, name in an ASF
    ("Hips", "", (0, 0, 0), "root"),
    ("LeftUpLeg", "Hips", (9, 0, 0), "lfemur"),
    ("LeftLeg", "LeftUpLeg", (0, -43, 0), "ltibia"),
    ("LeftFoot", "LeftLeg", (0, -42, 0), "lfoot"),
    ("RightUpLeg", "Hips", (-9, 0, 0), "rfemur"),
    ("RightLeg", "RightUpLeg", (0, -43, 0), "rtibia"),
    ("RightFoot", "RightLeg", (0, -42, 0), "rfoot"),
    ("Spine2", "Hips", (0, 26, 0), "thorax"),
    ("Neck", "Spine2", (0, 24, 0), "lowerneck"),
    ("LeftArm", "Spine2", (17, 18, 0), "lhumerus"),
    ("LeftForeArm", "LeftArm", (28, 0, 0), "lradius"),
    ("RightArm", "Spine2", (-17, 18, 0), "rhumerus"),
    ("RightForeArm", "RightArm", (-28, 0, 0), "rradius"),
)


def _bvh_joint(name: str) -> str:
    """Write a joint of the BVH with all below it."""
    offset = next(bone[2] for bone in BONES if bone[0] == name)
    below = "".join(_bvh_joint(bone[0]) for bone in BONES if bone[1] == name)
    below = below or "End Site\n{\nOFFSET 0 -9 5\n}\n"
    places = "6 Xposition Yposition Zposition" if name == "Hips" else "3"
    return (
        f"{'ROOT' if name == 'Hips' else 'JOINT'} {name}\n{{\nOFFSET {offset[0]} {offset[1]} 0\n"
        f"CHANNELS {places} Zrotation Xrotation Yrotation\n{below}}}\n"
    )


_BVH_FRAMES = "".join(f"{n} 90 0 " + " ".join(["0 10 5"] * len(BONES)) + "\n" for n in range(8))
BVH = f"HIERARCHY\n{_bvh_joint('Hips')}MOTION\nFrames: 8\nFrame Time: 0.0333333\n{_BVH_FRAMES}"


def _asf_bone(number: int) -> str:
    """Write a bone of the ASF: from its joint to the first joint below, in CMU's unit."""
    name = BONES[number][0]
    ends = [bone[2] for bone in BONES if bone[1] == name] or [(0, -9, 0)]
    x, y, _ = ends[0]
    return (
        f"  begin\n    id {number}\n    name {BONES[number][3]}\n    direction {x} {y} 0\n"
        f"    length {0.18 * (x * x + y * y) ** 0.5:.3f}\n    axis 0 0 20 XYZ\n    dof rx rz\n"
        "    limits (-160.0 20.0)\n  end\n"
    )


_ASF_NAMES = {bone[0]: bone[3] for bone in BONES}
ASF = """:version 1.10
:units
  mass 1.0
  length 0.45
  angle deg
:root
  order TX TY TZ RX RY RZ
  axis XYZ
  position 0 0 0
  orientation 0 0 0
:bonedata
"""
ASF += "".join(_asf_bone(number) for number in range(1, len(BONES))) + ":hierarchy\n  begin\n"
ASF += "".join(f"    {_ASF_NAMES[bone[1]]} {bone[3]}\n" for bone in BONES[1:]) + "  end\n"
AMC = ":FULLY-SPECIFIED\n:DEGREES\n" + "".join(
    f"{n}\nroot 1 17 2 0 {n} 0\n" + "".join(f"{bone[3]} 2 3\n" for bone in BONES[1:])
    for n in range(1, 9)
)
FRAME = [0.03, 0.0, 0.9, 0.0] + [1.0, 0, 0, 0] * 4 + [0.1] + [1.0, 0, 0, 0] * 2 + [0.2]
FRAME += [1.0, 0, 0, 0] + [0.1] + [1.0, 0, 0, 0] * 2 + [0.2]
DEEPMIMIC = json.dumps({"Loop": "wrap", "Frames": [FRAME] * 8})
SHEET = 'file\twords\tstart\tend\tfps\tperformer\na/b.bvh\tsome "words"\t0.5\t1.5\t120\tAnn\n'
SHEET += "c.bvh\twalks, then runs\t\t\t\tBen\n"
EVENTS = "file,event,frame,time,joint,other\na/b.bvh,catch,12,,r_wrist,ball\nc.bvh,step,,1.5,,\n"


def case(seed: int) -> tuple[str, bytes, Companions]:
    """Make an odd file.

    Parameters
    ----------
    seed : int
        Number of the case, from 0.

    Returns
    -------
    suffix : str
        Ending of a capture; ".tsv" for a sheet of words, ".csv" for a sheet of events.
    data : bytes
        Content of the file.
    companions : dict of str to bytes
        Files that belong to it, by name.
    """
    rng = np.random.default_rng(seed)
    makers = tuple(MAKERS.values())
    return makers[int(rng.integers(len(makers)))](rng)


def odd_bvh(rng: np.random.Generator) -> tuple[str, bytes, Companions]:
    """Damage a whole BVH."""
    return ".bvh", damage(BVH.encode(), rng), {}


def strange_bvh(rng: np.random.Generator) -> tuple[str, bytes, Companions]:
    """Build a BVH whose structure is extreme: deep, wide, without channels, with many headers."""
    how = int(rng.integers(6))
    count = int(10 ** rng.uniform(0, 4))
    if how == 0:  # nested joints
        head = "".join(f"JOINT j{n}\n{{\nOFFSET 0 1 0\nCHANNELS 0\n" for n in range(count))
        tail, values = "}\n" * count, "1 2 3"
    elif how == 1:  # children without channels
        head = "JOINT j\n{\nOFFSET 0 1 0\nCHANNELS 0\n}\n" * count
        tail, values = "", "1 2 3"
    else:
        head = tail = ""
        values = "1 2 3" if how == 2 else "1e200 1e200 1e200"
    n_frames = int(10 ** rng.uniform(0, 4))
    text = "HIERARCHY\nROOT Hips\n{\nOFFSET 0 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n"
    text += f"{head}{tail}}}\nMOTION\n"
    if how == 4:
        text += "Frames: 1\n" * count
    declared = 10**9 if how == 5 else n_frames
    text += f"Frames: {declared}\nFrame Time: {rng.choice(['1', '0.01', '0.0005', '1e-9'])}\n"
    return ".bvh", (text + f"{values}\n" * n_frames).encode(), {}


def odd_amc(rng: np.random.Generator) -> tuple[str, bytes, Companions]:
    """Damage an AMC, its ASF, or both; some have no ASF."""
    which = int(rng.integers(4))
    amc = damage(AMC.encode(), rng) if which in (0, 2) else AMC.encode()
    asf = damage(ASF.encode(), rng) if which in (1, 2) else ASF.encode()
    return ".amc", amc, {} if which == 3 and rng.random() < 0.2 else {"skeleton.asf": asf}


def strange_asf(rng: np.random.Generator) -> tuple[str, bytes, Companions]:
    """Build an ASF with many bones, circles, wrong axes or huge sizes."""
    count = int(10 ** rng.uniform(0, 3.5))
    size = str(rng.choice(["1", "1e300", "1e-300", "0", "-1"]))
    axis = str(rng.choice(["XYZ", "QQQ", "XXX", "zyx", "X", ""]))
    bones = "".join(
        f"begin\nname b{n}\ndirection 0 {size} 0\nlength {size}\naxis 1 2 3 {axis}\ndof rx\nend\n"
        for n in range(count)
    )
    links = "".join(f"b{n} b{n + 1}\n" for n in range(count - 1))
    circle = "b0 b0\n" if rng.random() < 0.2 else ""
    asf = f":root\naxis {axis}\norder TX TY TZ RX RY RZ\n:bonedata\n{bones}:hierarchy\nbegin\n"
    asf += f"root b0\n{links}{circle}end\n"
    frame = "root 0 0 0 0 0 0\n" + "".join(f"b{n} {n % 90}\n" for n in range(count))
    amc = ":DEGREES\n" + "".join(f"{n}\n{frame}" for n in range(1, 1 + int(rng.integers(1, 5))))
    return ".amc", amc.encode(), {"skeleton.asf": asf.encode()}


def odd_deepmimic(rng: np.random.Generator) -> tuple[str, bytes, Companions]:
    """Damage a whole DeepMimic file."""
    return str(rng.choice([".txt", ".json"])), damage(DEEPMIMIC.encode(), rng), {}


def strange_json(rng: np.random.Generator) -> tuple[str, bytes, Companions]:
    """Build JSON with deep nesting, huge numbers or values of other types."""
    depth = int(10 ** rng.uniform(0, 5))
    value = str(rng.choice(NUMBERS))
    texts = (
        '{"Frames": ' + "[" * depth + "]" * depth + "}",
        '{"Frames": ' + '{"a":' * depth + "1" + "}" * depth + "}",
        '{"Frames": [[' + ", ".join([value] * 44) + "]]}",
        json.dumps({"Frames": [[*FRAME[:40], "x", None, [], {}]] * 3}),
        json.dumps({"Frames": [[1e200 if v else 0.0 for v in FRAME]] * 3}),
        json.dumps({"Frames": [[float(rng.choice([1e-320, 0.5, 1e300])), *FRAME[1:]]] * 3}),
        '{"Frames": [' + ", ".join(["[]"] * depth) + "]}",
        '{"Frames": "' + "x" * depth + '"}',
    )
    return ".json", texts[int(rng.integers(len(texts)))].encode(), {}


def odd_c3d(rng: np.random.Generator) -> tuple[str, bytes, Companions]:
    """Damage a whole C3D file, or build a strange one."""
    return strange_c3d(rng) if rng.random() < 0.2 else (".c3d", damaged_c3d(rng), {})


def strange_c3d(rng: np.random.Generator) -> tuple[str, bytes, Companions]:
    """Build a header of a C3D file with random counts, then random or empty blocks."""
    words = rng.integers(0, 1000, 256)
    words[0] = 0x5002 if rng.random() < 0.8 else words[0]
    words[8] = int(rng.integers(0, 6))
    body = rng.integers(0, 256, 512 * int(rng.integers(0, 6))).astype(np.uint8).tobytes()
    return ".c3d", words.astype("<u2").tobytes() + body, {}


def odd_sheet(rng: np.random.Generator) -> tuple[str, bytes, Companions]:
    """Damage a sheet of words."""
    return ".tsv", damage(SHEET.encode(), rng), {}


def odd_events(rng: np.random.Generator) -> tuple[str, bytes, Companions]:
    """Damage a sheet of events."""
    return ".csv", damage(EVENTS.encode(), rng), {}


def noise(rng: np.random.Generator) -> tuple[str, bytes, Companions]:
    """Make random bytes, some of them text, with any ending."""
    ending = str(rng.choice([".bvh", ".amc", ".json", ".npz", ".c3d", ".tsv", ".csv"]))
    n_bytes = int(10 ** rng.uniform(0, 4))
    low, high = (32, 127) if rng.random() < 0.5 else (0, 256)
    data = rng.integers(low, high, n_bytes).astype(np.uint8).tobytes()
    return ending, data, {"skeleton.asf": data} if ending == ".amc" else {}


MAKERS: Mapping[str, Callable[[np.random.Generator], tuple[str, bytes, Companions]]]
MAKERS = MappingProxyType(
    {
        "bvh": odd_bvh,
        "bvh structure": strange_bvh,
        "amc": odd_amc,
        "asf structure": strange_asf,
        "deepmimic": odd_deepmimic,
        "json structure": strange_json,
        "npz": odd_npz,
        "npz mutated": mutated_npz,
        "npz structure": strange_npz,
        "sheet": odd_sheet,
        "events": odd_events,
        "noise": noise,
    }
)
"""Kind of case -> its maker. C3D is apart (:func:`odd_c3d`)."""
