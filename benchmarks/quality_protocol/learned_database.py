"""A database that has learned all CMU captures, made once per run of the benchmark."""

from __future__ import annotations

import atexit
import shutil
import tempfile
from functools import cache
from pathlib import Path

import motiondb
from motiondb.database.catalogue.file_reading import AddSettings
from motiondb.learn.recognition import LearnSettings


@cache
def learned_database(data: Path, seed: int) -> Path:
    """Add and learn; the file is deleted when the process ends."""
    folder = Path(tempfile.mkdtemp(prefix="motiondb-quality-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    path = folder / "cmu.duckdb"
    with motiondb.open(path) as db:
        db.add(data / "cmu", data / "cmu-captions.tsv", AddSettings(skip_bad_frames=True))
        db.learn(LearnSettings(seed=seed))
    return path
