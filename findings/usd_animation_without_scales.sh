#!/usr/bin/env bash
# Guess: a UsdSkel animation may leave out what it does not animate: without
# scales, they are 1.
# Instead: an animation with rotations and translations, but without the attribute
# scales, is left out as a whole: every joint keeps its rest pose at every time.
# No exception, and the query of the animation is valid. With scales of 1, the
# same animation plays.
# A user whose capture has no scales (nearly all) writes a USD file that is valid
# and stands still.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --quiet --disable-pip-version-check usd-core==26.11
cat >scales.py <<'END'
from pxr import Gf, Usd, UsdSkel, Vt

print("usd-core", ".".join(map(str, Usd.GetVersion()[1:])))


def angles(with_scales):
    stage = Usd.Stage.CreateInMemory()
    root = UsdSkel.Root.Define(stage, "/Body")
    skeleton = UsdSkel.Skeleton.Define(stage, "/Body/Skeleton")
    rest = Vt.Matrix4dArray([Gf.Matrix4d(1)])
    skeleton.CreateJointsAttr(["Hips"])
    skeleton.CreateRestTransformsAttr(rest)
    skeleton.CreateBindTransformsAttr(rest)
    animation = UsdSkel.Animation.Define(stage, "/Body/Walk")
    animation.CreateJointsAttr(["Hips"])
    animation.CreateTranslationsAttr(Vt.Vec3fArray([Gf.Vec3f(0, 90, 0)]))
    rotations = animation.CreateRotationsAttr()
    rotations.Set(Vt.QuatfArray([Gf.Quatf(1, 0, 0, 0)]), 0)
    rotations.Set(Vt.QuatfArray([Gf.Quatf(0.70710678, 0, 0.70710678, 0)]), 10)
    if with_scales:
        animation.CreateScalesAttr(Vt.Vec3hArray([Gf.Vec3h(1)]))
    binding = UsdSkel.BindingAPI.Apply(skeleton.GetPrim())
    binding.CreateAnimationSourceRel().SetTargets([animation.GetPath()])
    cache = UsdSkel.Cache()
    cache.Populate(root, Usd.PrimDefaultPredicate)
    query = cache.GetSkelQuery(skeleton)
    assert query.GetAnimQuery(), "changed: the query of the animation is not valid"
    return [round(query.ComputeJointLocalTransforms(t)[0].ExtractRotation().GetAngle()) for t in (0, 5, 10)]


without, with_ = angles(False), angles(True)
print("degrees at times 0, 5, 10 without scales:", without)
print("degrees at times 0, 5, 10 with scales 1: ", with_)
assert without == [0, 0, 0] and with_ == [0, 45, 90], (without, with_)
END
venv/bin/python scales.py 2>/dev/null
