#!/usr/bin/env bash
# Guess: a C3D file of 70,000 frames that a library wrote is read with 70,000
# frames by this library and by another; or somebody refuses.
# Instead: ezc3d reads its own file as 65,535 frames, and c3d yields not a single
# frame while its frame_count says 65,535. All bytes are there; nobody warns.
# A user meets it with takes of more than 5.5 minutes at 200 frames a second:
# the end is missing, or an empty take goes on to the next step.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --quiet --disable-pip-version-check ezc3d==1.7.2 c3d==0.6.0 numpy==2.4.6
cat >long.py <<'END'
import os
from importlib.metadata import version

import c3d
import ezc3d
import numpy as np

take = ezc3d.c3d()
take["parameters"]["POINT"]["RATE"]["value"] = [200.0]
take["parameters"]["POINT"]["LABELS"]["value"] = ["LASI"]
points = np.ones((4, 1, 70_000))
points[0, 0] = np.arange(70_000)
take["data"]["points"] = points
take.write("long.c3d")
print("written: 70000 frames, bytes enough for them:", os.path.getsize("long.c3d") >= 70_000 * 16)
assert os.path.getsize("long.c3d") >= 70_000 * 16
seen = ezc3d.c3d("long.c3d")["data"]["points"].shape[2]
print("ezc3d", version("ezc3d"), "reads", seen)
assert seen == 65_535, seen
with open("long.c3d", "rb") as file:
    reader = c3d.Reader(file)
    counted, yielded = int(reader.frame_count), sum(1 for _ in reader.read_frames())
print("c3d", version("c3d"), "says", counted, "and yields", yielded)
assert (counted, yielded) == (65_535, 0), (counted, yielded)
END
venv/bin/python -W ignore long.py
