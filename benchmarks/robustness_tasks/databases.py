"""The databases that are attacked, learned once from the sample data."""

from __future__ import annotations

import importlib
import os
import pkgutil
import shutil
import subprocess
import sys
from pathlib import Path

import motiondb as motiondb_package

SAMPLES = Path(__file__).resolve().parents[2] / "sample_data"
SMALL = (
    "ana/bow_1", "ana/walk_1", "ana/jump_1", "boris/kick_1", "boris/long_2", "chidi/long_3",
)  # fmt: skip
"""Captures of the small database: enough to learn symbols, words and a grammar from."""
GRAMMAR = "moves"
"""Name of the grammar that is learned from the long takes."""


def import_everything() -> None:
    """Import all of motiondb, so that processes that part from this one need not."""
    from motiondb.language.lemmas import lemma

    for module in pkgutil.walk_packages(motiondb_package.__path__, "motiondb."):
        importlib.import_module(module.name)
    lemma("walks")  # loads the table of lemmas


def motiondb(*words: object) -> str:
    """Run a command to its end; what it prints."""
    program = [sys.executable, "-c", "from motiondb.cli.main import main; main()"]
    ended = subprocess.run(
        [*program, *map(str, words)], capture_output=True, text=True, check=False
    )
    if ended.returncode:
        raise RuntimeError(f"motiondb {' '.join(map(str, words))}: {ended.stderr}")
    return ended.stdout


def copy_captures(names: tuple[str, ...], folder: Path) -> Path:
    """Copy captures of the sample data into a folder, with their words in ``captions.tsv``."""
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(SAMPLES / "captures" / f"{name}.bvh", folder / f"{name}.bvh")
    files = {f"{name}.bvh" for name in names}
    head, *rows = (SAMPLES / "captions.tsv").read_text(encoding="utf-8").splitlines()
    kept = [row for row in rows if row.partition("\t")[0] in files]
    (folder / "captions.tsv").write_text("\n".join([head, *kept]) + "\n", encoding="utf-8")
    return folder


def small_database(folder: Path) -> Path:
    """Six captures with symbols, words, a grammar and a sequence that was kept; made if missing."""
    path = folder / "small.duckdb"
    if not path.exists():
        new = folder / f"new-{os.getpid()}"
        captures = copy_captures(SMALL, new / "captures")
        made = new / "small.duckdb"
        at = ("--db", made)
        motiondb("add", captures, "--words", captures / "captions.tsv", *at)
        motiondb("learn", *at)
        takes = [name for name in SMALL if "long" in name]
        motiondb("grammar", "learn", *takes, "--terminals", 5, "--name", GRAMMAR, *at)
        motiondb("grammar", "generate", GRAMMAR, "-o", new / "kept.bvh", "--save", "kept", *at)
        motiondb("grammar", "rename", GRAMMAR, "a", "first", *at)  # an edit that can be undone
        motiondb("search", "walk", *at)  # fills the cache
        shutil.copytree(f"{made}.cache", f"{path}.cache", dirs_exist_ok=True)
        made.replace(path)
        shutil.rmtree(new)
    return path
