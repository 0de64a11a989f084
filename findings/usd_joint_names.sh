#!/usr/bin/env bash
# Guess: joint names of a UsdSkel skeleton are tokens, so every name is allowed;
# or a name that is not allowed makes Topology.Validate answer no.
# Instead: the parent of a joint is found by reading the token as a path. A colon,
# a space, a dot or a digit first in a name is no path: the joint silently becomes
# another root (parent -1), and Validate still answers yes.
# A user meets a skeleton that falls into pieces: local transforms are then taken
# from the origin. Names need Tf.MakeValidIdentifier first, which makes "_" of
# every strange character, so that "Arm.L" and "Arm_L" become equal.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --quiet --disable-pip-version-check usd-core==26.11
cat >names.py <<'END'
from pxr import Tf, Usd, UsdSkel, Vt

print("usd-core", ".".join(map(str, Usd.GetVersion()[1:])))
for name, parent in (("Spine", 0), ("rig:Spine", -1), ("Mid Spine", -1), ("Spine.001", -1), ("1st", -1)):
    topology = UsdSkel.Topology(Vt.TokenArray(["Hips", "Hips/" + name]))
    seen = topology.GetParentIndices()[1]
    valid, _ = topology.Validate()
    print(f"Hips/{name}: parent {seen}, valid: {valid}")
    assert (seen, valid) == (parent, True), (seen, valid)
equal = [Tf.MakeValidIdentifier(name) for name in ("Arm.L", "Arm L", "Arm_L")]
print("made valid:", equal)
assert equal == ["Arm_L"] * 3, equal
END
venv/bin/python names.py 2>/dev/null
