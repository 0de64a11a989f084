#!/usr/bin/env bash
# Guess: a reader of C3D gives a name for each of 300 points.
# What happens: the package c3d gives 300 points and 255 names, and ezc3d gives 255 names under
# LABELS and the other 45 under LABELS2. The format has room for 255 texts in a parameter.
# Who meets it: sets with skin, face or several performers; what is paired by zip() loses points.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.11 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check ezc3d==1.7.2 c3d==0.6.0 numpy==2.4.6 2>/dev/null
venv/bin/python -W ignore - <<'PY'
import c3d
import ezc3d
import numpy as np

file = ezc3d.c3d()
file["parameters"]["POINT"]["RATE"]["value"] = [100.0]
file["parameters"]["POINT"]["LABELS"]["value"] = [f"M{number:03}" for number in range(300)]
file["data"]["points"] = np.ones((4, 300, 2))
file.write("take.c3d")
point = ezc3d.c3d("take.c3d")["parameters"]["POINT"]
first = [len(point[name]["value"]) for name in ("LABELS", "LABELS2")]
with open("take.c3d", "rb") as stream:
    reader = c3d.Reader(stream)
    names, points = len(reader.point_labels), len(next(iter(reader.read_frames()))[1])
print("ezc3d 1.7.2 names", first, "| c3d 0.6.0 names", names, "points", points)
assert (first, names, points) == ([255, 45], 255, 300), "the behaviour has changed"
PY
