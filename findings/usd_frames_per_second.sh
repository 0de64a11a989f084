#!/usr/bin/env bash
# Guess: framesPerSecond of a USD stage only says how to play it; how long it
# lasts is said by timeCodesPerSecond, 24 where it is not written.
# Instead: where only framesPerSecond is written, it is also the answer to
# GetTimeCodesPerSecond, though HasAuthoredMetadata says that this is not written.
# The other way round it does not hold: with timeCodesPerSecond 60 alone, frames
# per second are 24.
# A user who sets the rate of viewing to 30 shortens a capture of 24 time codes a
# second by a fifth. Write both.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --quiet --disable-pip-version-check usd-core==26.11
cat >rates.py <<'END'
from pxr import Usd

print("usd-core", ".".join(map(str, Usd.GetVersion()[1:])))


def rates(frames=None, codes=None):
    stage = Usd.Stage.CreateInMemory()
    if frames:
        stage.SetFramesPerSecond(frames)
    if codes:
        stage.SetTimeCodesPerSecond(codes)
    return stage.GetFramesPerSecond(), stage.GetTimeCodesPerSecond(), stage.HasAuthoredMetadata("timeCodesPerSecond")


for given, expected in (({}, (24, 24, False)), ({"frames": 30}, (30, 30, False)), ({"codes": 60}, (24, 60, True))):
    seen = rates(**given)
    print("written", given, "-> frames, time codes per second, authored:", seen)
    assert seen == expected, seen
END
venv/bin/python rates.py
