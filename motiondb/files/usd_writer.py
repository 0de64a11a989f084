"""Writer of USD: a UsdSkel skeleton with its animation, through the package usd-core.

The stage has y up and its own unit and rate. The joints of the skeleton are bound and at rest in
the pose without rotations. Names that USD does not allow are changed; the attribute ``jointNames``
has the true ones. The ending says the form: ``.usda`` is text, ``.usdc`` and ``.usd`` are binary.
Source: https://openusd.org, "UsdSkel: USD Skeleton Schema and API".
"""

from __future__ import annotations

import importlib.util
import re
import tempfile
from pathlib import Path

import numpy as np

from motiondb.body import rotation
from motiondb.errors import CaptureError
from motiondb.files.bvh_writer import check_clip, local_places, write_atomically
from motiondb.files.safe_files import open_file
from motiondb.records import Clip, Skeleton

ENDINGS = (".usd", ".usda", ".usdc")


def check_usd(path: object) -> None:
    """Refuse to write USD where its package is not installed (CaptureError)."""
    if importlib.util.find_spec("pxr") is None:
        raise CaptureError(
            path,
            "expected the package usd-core to write USD, found none. pip install motiondb[usd]",
        )


def write_usd(clip: Clip, path: Path | str) -> None:
    """Write a clip as USD; the file is written whole or not at all (CaptureError)."""
    path = Path(path)
    check_usd(path)
    check_clip(clip, path)
    with tempfile.TemporaryDirectory() as folder:
        draft = Path(folder, f"draft{path.suffix.lower()}")
        _write(clip, draft)
        with open_file(draft) as file:
            write_atomically(path, file.read())


def _write(clip: Clip, path: Path) -> None:
    """Write the stage of a clip."""
    from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, Vt

    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, clip.unit)
    stage.SetTimeCodesPerSecond(clip.fps)
    stage.SetFramesPerSecond(clip.fps)
    stage.SetStartTimeCode(0)
    stage.SetEndTimeCode(clip.n_frames - 1)
    root = UsdSkel.Root.Define(stage, "/Person")
    stage.SetDefaultPrim(root.GetPrim())
    skeleton = UsdSkel.Skeleton.Define(stage, "/Person/Skeleton")
    motion = UsdSkel.Animation.Define(stage, "/Person/Skeleton/Motion")
    joints = Vt.TokenArray(_paths(clip.skeleton))
    skeleton.CreateJointsAttr(joints)
    skeleton.CreateJointNamesAttr(Vt.TokenArray(list(clip.skeleton.names)))
    translations = local_places(clip) / clip.unit
    rest = translations[0]
    world = rest.copy()
    for joint, parent in enumerate(clip.skeleton.parents):
        world[joint] += world[parent] if parent >= 0 else 0.0
    moves = [[Gf.Matrix4d(1.0).SetTranslate(Gf.Vec3d(*map(float, row))) for row in rows]
             for rows in (rest, world)]  # fmt: skip
    skeleton.CreateRestTransformsAttr(Vt.Matrix4dArray(moves[0]))
    skeleton.CreateBindTransformsAttr(Vt.Matrix4dArray(moves[1]))
    binding = UsdSkel.BindingAPI.Apply(skeleton.GetPrim())
    binding.CreateAnimationSourceRel().SetTargets([Sdf.Path("/Person/Skeleton/Motion")])
    motion.CreateJointsAttr(joints)
    motion.CreateScalesAttr(Vt.Vec3hArray([Gf.Vec3h(1, 1, 1)] * len(joints)))
    turns = rotation.unroll(rotation.normalize(clip.local_rotations))
    places, to_turns = motion.CreateTranslationsAttr(), motion.CreateRotationsAttr()
    for frame in range(clip.n_frames):
        quats = [Gf.Quatf(*map(float, q)) for q in turns[frame]]
        to_turns.Set(Vt.QuatfArray(quats), frame)
        places.Set(Vt.Vec3fArray.FromNumpy(translations[frame].astype(np.float32)), frame)
    stage.GetRootLayer().Save()


def _paths(skeleton: Skeleton) -> list[str]:
    """Return the paths of joints in names that USD allows, each once below its parent.

    >>> _paths(Skeleton(("m:Hips", "L arm", "L-arm"), np.array([-1, 0, 0]), np.zeros((3, 3))))
    ['m_Hips', 'm_Hips/L_arm', 'm_Hips/L_arm_2']
    """
    paths: list[str] = []
    for name, parent in zip(skeleton.names, skeleton.parents.tolist()):
        plain = re.sub(r"[^A-Za-z0-9_]", "_", name)
        plain = plain if plain[:1].isalpha() or plain[:1] == "_" else f"_{plain}"
        above = f"{paths[parent]}/" if parent >= 0 else ""
        path, number = above + plain, 2
        while path in paths:
            path, number = f"{above}{plain}_{number}", number + 1
        paths.append(path)
    return paths
