#!/usr/bin/env bash
# Guess: 300 names of points are 300 names in every C3D reader, and a point that
# the cameras lost is NaN.
# Instead: more than 255 names go on in POINT:LABELS2. c3d has only the first 255
# (with 300 points), ezc3d has the rest in another parameter. A lost point is NaN
# in ezc3d, and the place 0 0 0 in c3d, told from a real one only by the fourth
# number, the residual of -1.
# A user who reads markers of two people or a face pairs names and points that
# are of different number, and sees a lost marker jump to the origin.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --quiet --disable-pip-version-check ezc3d==1.7.2 c3d==0.6.0 numpy==2.4.6
cat >points.py <<'END'
from importlib.metadata import version

import c3d
import ezc3d
import numpy as np


def write(names, lost, path):
    take = ezc3d.c3d()
    take["parameters"]["POINT"]["RATE"]["value"] = [100.0]
    take["parameters"]["POINT"]["LABELS"]["value"] = names
    points = np.full((4, len(names), 5), 7.0)
    if lost:
        points[:3, 0, 2] = np.nan
    take["data"]["points"] = points
    take.write(path)


write([f"M{i:03d}" for i in range(300)], False, "many.c3d")
write(["LASI", "RASI"], True, "lost.c3d")
take = ezc3d.c3d("many.c3d")
labels = take["parameters"]["POINT"]
seen = (take["data"]["points"].shape[1], len(labels["LABELS"]["value"]), len(labels["LABELS2"]["value"]))
print("ezc3d", version("ezc3d"), "points, LABELS, LABELS2:", seen)
assert seen == (300, 255, 45), seen
with open("many.c3d", "rb") as file:
    reader = c3d.Reader(file)
    seen = (len(next(iter(reader.read_frames()))[1]), len(reader.point_labels))
print("c3d", version("c3d"), "points, names:", seen)
assert seen == (300, 255), seen
seen = ezc3d.c3d("lost.c3d")["data"]["points"][:3, 0, 2]
print("ezc3d: the lost point", seen)
assert np.isnan(seen).all(), seen
with open("lost.c3d", "rb") as file:
    seen = list(c3d.Reader(file).read_frames())[2][1][0][:4]
print("c3d: the lost point and its residual", seen)
assert seen.tolist() == [0, 0, 0, -1], seen
END
venv/bin/python -W ignore points.py
