#!/usr/bin/env bash
# Guess: the distance by dynamic time warping of two sequences is one number,
# whichever library computes it.
# Instead: dtaidistance and tslearn take the root of a sum of squares, fastdtw the
# sum of the distances themselves, also where its radius makes it exact; here 2.6
# for .72. They do not even agree which of two sequences is nearer to a third.
# A user who takes a threshold, or an order of the most similar movements, from one
# library to another finds other movements.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --quiet --disable-pip-version-check dtaidistance==2.5.1 tslearn==0.10.0 fastdtw==0.3.4 numpy==2.4.6 scipy==1.17.1
cat >distances.py <<'END'
from importlib.metadata import version

import numpy as np
from dtaidistance import dtw
from fastdtw import fastdtw
from tslearn.metrics import dtw as tslearn_dtw


def every(one, other):
    found = dtw.distance(one, other), tslearn_dtw(one, other), fastdtw(one, other, radius=100)[0]
    return [round(float(value), 3) for value in found]


knee = np.sin(np.linspace(0, 6, 40))
later = np.sin(np.linspace(0, 6, 50) + 0.4)
names = [f"{name} {version(name)}" for name in ("dtaidistance", "tslearn", "fastdtw")]
seen = every(knee, later)
print(dict(zip(names, seen)))
assert seen == [0.716, 0.716, 2.605], seen
rest = np.zeros(20)
spike, sway = rest.copy(), rest + 0.1
spike[10] = 1.0
near = [np.argmin(pair) for pair in zip(every(rest, spike), every(rest, sway))]
print("nearer to rest, spike (0) or sway (1):", [int(n) for n in near])
assert [int(n) for n in near] == [1, 1, 0], near
END
venv/bin/python -W ignore distances.py
