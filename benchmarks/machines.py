"""Does the same seed give the same answers on another machine?

    python benchmarks/machines.py --out DIR [--only learn,search]

Runs the commands below twice, each time in a new folder: as this machine is, and with the features
of its processor hidden as far as they can be (:data:`OTHER`): no vector instructions newer than
SSE4, no fused multiplications, one thread for matrix products, another order of sets. Prints for
every command what differs: words, whole numbers and files, and the largest relative difference of
the other numbers. The second run compiles everything for the other processor, which takes some
minutes; ``--only`` names the beginnings of commands to run after those of :data:`MAKING`.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import shlex
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

OTHER = {
    "NUMBA_CPU_NAME": "generic",
    "NUMBA_CPU_FEATURES": "",
    "NPY_DISABLE_CPU_FEATURES": "X86_V3 X86_V4",
    "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-AVX,-FMA,-FMA4",
    "OPENBLAS_CORETYPE": "Nehalem",
    "OPENBLAS_NUM_THREADS": "1",
    "PYTHONHASHSEED": "1",
}
"""Environment of a process that computes as on an older processor."""

MAKING = (
    "add sample_data/captures --words sample_data/captions.tsv --events sample_data/events.tsv",
    "learn",
)
ASKING = (
    "info",
    "symbols",
    "show ana/long_1",
    'search "walk, turn left, sit down" --limit 6 --explain',
    'search "walk but not run" --limit 6 --explain',
    'search "jump or kick" --limit 6',
    "like fatou/long_6 --from 7 --to 9",
    "describe dora/long_4",
    'generate "a person walks then kicks" -o walk.bvh --seed 7',
    'generate "run, jump and wave" -o run.bvh --seed 7',
    'generate "sit down" -o sit.bvh --seed 3 --method trajectory',
    "grammar learn chidi/long_play_1 fatou/long_play_2 --terminals 8 --longest 8 --name play",
    "grammar show play",
    "grammar generate play -o new.bvh --seed 3 --save new/play",
    "grammar learn goran/long_fight_2 --name fight",
    "grammar show fight",
    "scene make pass-and-shoot -o scene --seed 1 --rounds 2 --no-pictures",
    "scene report scene",
)
CHANGING = ("seconds", "created", "started", "finished", "revision", "bytes", "size", "path")
"""Fields of answers that are not the same twice on one machine either."""


def main() -> None:
    """Run the commands on both machines, and print the differences."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--only", default="")
    asked = parser.parse_args()
    chosen = [c for c in ASKING if c.startswith(tuple(asked.only.split(",")))]
    commands = [*MAKING, *chosen]
    cache = {"NUMBA_CACHE_DIR": str((asked.out / "compiled").resolve())}
    here = answers(asked.out / "here", commands, {"PYTHONHASHSEED": "0"})
    there = answers(asked.out / "there", commands, OTHER | cache)
    for command, one, other in zip(commands, here, there, strict=True):
        found = list(differences(one, other))
        largest = max((x for x in found if isinstance(x, float)), default=0.0)
        named = [x for x in found if isinstance(x, str)]
        print(f"{largest:.0e}  {len(named):3d}  {command}", *named[:5], sep="\n    ", flush=True)


def answers(folder: Path, commands: list[str], environment: dict[str, str]) -> list[Any]:
    """What the commands print as JSON, and the digests of the motions that they write."""
    folder.mkdir(parents=True)
    (folder / "sample_data").symlink_to(Path(__file__).resolve().parents[1] / "sample_data")
    program = Path(sys.executable).with_name("motiondb")
    said = []
    for command in commands:
        ended = subprocess.run(
            [program, *shlex.split(command), "--json"],
            cwd=folder,
            env=os.environ | environment,
            capture_output=True,
            text=True,
            check=False,
        )
        files = {
            path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
            for path in sorted(folder.rglob("*.bvh"))
        }
        said.append({"code": ended.returncode, "files": files, "out": _json(ended.stdout)})
    return said


def _json(text: str) -> Any:
    try:
        return json.loads(text)
    except ValueError:
        return text


def differences(one: Any, other: Any, where: str = "") -> Iterator[str | float]:
    """Yield where two answers differ, and the relative difference of each pair of numbers."""
    if isinstance(one, dict) and isinstance(other, dict):
        for key in sorted({*one, *other} - {*CHANGING}):
            yield from differences(one.get(key), other.get(key), f"{where}.{key}")
    elif isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        for k, (a, b) in enumerate(zip(one, other, strict=True)):
            yield from differences(a, b, f"{where}[{k}]")
    elif isinstance(one, float) and isinstance(other, float):
        yield abs(one - other) / max(1.0, abs(one))
    elif one != other:
        yield f"{where}: {str(one)[:60]} or {str(other)[:60]}"


if __name__ == "__main__":
    main()
