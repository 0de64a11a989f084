#!/usr/bin/env bash
# Guess: what a hidden Markov model gives as its covariances can be set on another
# one of the same kind, as its means and transitions can.
# Instead: with covariance_type="diag", hmmlearn returns full matrices (states,
# dimensions, dimensions) and accepts variances (states, dimensions) alone; setting
# what was got raises.
# A user meets it when models of movements are kept in a file by their parts and
# put together again.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --quiet --disable-pip-version-check hmmlearn==0.3.3 numpy==2.4.6 scipy==1.17.1
cat >parts.py <<'END'
from importlib.metadata import version

import numpy as np
from hmmlearn import hmm

poses = np.random.default_rng(0).normal(size=(60, 3))
fitted = hmm.GaussianHMM(2, covariance_type="diag", random_state=0).fit(poses)
shapes = fitted.means_.shape, fitted.covars_.shape
print("hmmlearn", version("hmmlearn"), "shapes of means and covariances:", shapes)
assert shapes == ((2, 3), (2, 3, 3)), shapes
again = hmm.GaussianHMM(2, covariance_type="diag")
again.n_features = 3
again.startprob_, again.transmat_, again.means_ = fitted.startprob_, fitted.transmat_, fitted.means_
try:
    again.covars_ = fitted.covars_
except ValueError as error:
    print("set what was got:", error)
else:
    raise SystemExit("changed: what was got can be set")
again.covars_ = np.array([np.diag(each) for each in fitted.covars_])
same = abs(again.score(poses) - fitted.score(poses)) < 1e-9
print("set the diagonals: the same likelihood", same)
assert same
END
venv/bin/python parts.py
