#!/usr/bin/env bash
# Guess: fitting a hidden Markov model to valid data gives rows of transition
# probabilities that add up to one, or raises.
# Instead: where a state is reached only at the last frame, hmmlearn returns
# a model whose row of that state is all zeros. It logs a line that a program
# does not see, and the model's own check refuses it when it is used: score raises.
# A user meets it when a take ends in a pose that it shows nowhere else (the hand
# at the switch, the clap).
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --quiet --disable-pip-version-check hmmlearn==0.3.3 numpy==2.4.6 scipy==1.17.1
cat >row.py <<'END'
from importlib.metadata import version

import numpy as np
from hmmlearn import hmm

rng = np.random.default_rng(0)
poses = np.vstack([rng.normal(0, 0.1, (20, 2)), [[9, 9]]])
model = hmm.GaussianHMM(2, random_state=0, n_iter=20).fit(poses)
sums = sorted(round(float(x), 6) for x in model.transmat_.sum(axis=1))
print("hmmlearn", version("hmmlearn"), "sums of the rows:", sums)
assert sums == [0, 1], sums
try:
    model.score(poses)
except ValueError:
    print("score of the same poses: raises ValueError")
else:
    raise SystemExit("changed: score works")
END
venv/bin/python row.py 2>/dev/null
