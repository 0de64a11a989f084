#!/usr/bin/env bash
# Guess: ezc3d reads back as many frames as it has written.
# What happens: of 70,000 frames 65,535 are read, without a word: the header's word for the last
# frame has 16 bits. The file is as long as 70,000 frames are.
# Who meets it: eleven minutes at 100 frames a second are enough.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.11 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check ezc3d==1.7.2 numpy==2.4.6 2>/dev/null
venv/bin/python - <<'PY'
import os

import ezc3d
import numpy as np

sizes = {}
for n_frames in (60_000, 70_000):
    file = ezc3d.c3d()
    file["parameters"]["POINT"]["RATE"]["value"] = [100.0]
    file["parameters"]["POINT"]["LABELS"]["value"] = ["A"]
    file["data"]["points"] = np.ones((4, 1, n_frames))
    file.write("take.c3d")
    again = ezc3d.c3d("take.c3d")["data"]["points"].shape[2]
    sizes[n_frames] = (again, os.path.getsize("take.c3d") // 16)
print("ezc3d 1.7.2: frames written -> (frames read, frames that the bytes hold):", sizes)
assert sizes[60_000][0] == 60_000
assert sizes[70_000][0] == 65_535, "the behaviour has changed"
assert sizes[70_000][1] >= 70_000
PY
