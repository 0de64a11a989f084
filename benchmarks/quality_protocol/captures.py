"""The captures of the quality benchmark: read once, kept in a cache, and split by performer.

``load_cmu`` and ``load_bandai`` read what the product's readers and features make of the files. The
cache lies in the user's cache folder and is named after the files and the code that reads them.
"""

from __future__ import annotations

import csv
import hashlib
import os
import pickle
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from joblib import Parallel, delayed

import motiondb
from motiondb.body.features import recognition_features
from motiondb.body.retarget import to_motion
from motiondb.files.formats import read_capture
from motiondb.records import Float32Array, IntArray, Motion
from motiondb.search import copies

N_FOLDS = 5
"""Parts of the performers; each part is unseen once."""


@dataclass(frozen=True, eq=False)
class Capture:
    """name such as "16/16_01"; performer ("bandai" for all of Bandai-Namco); captions as written;
    style (Bandai-Namco); the canonical motion and its features (frames at 15 a second, 130)."""

    name: str
    performer: str
    captions: tuple[str, ...]
    style: str
    motion: Motion
    features: Float32Array


def load_cmu(data: Path) -> list[Capture]:
    """All CMU captures of the sheet, in its order."""
    return load_sheet(data / "cmu", data / "cmu-captions.tsv")


def load_bandai(data: Path) -> list[Capture]:
    """All Bandai-Namco captures of the sheet, in its order."""
    return load_sheet(data / "bandai", data / "bandai-captions.tsv")


def without_copies(captures: Sequence[Capture]) -> list[Capture]:
    """The captures less those that repeat an earlier one, or its mirror image, as a whole."""
    library = copies.build_library([copies.copy_poses(c.motion) for c in captures])
    relations = copies.find_copies(library, range(len(captures)))
    twice = {max(c.query, c.take) for c in relations if c.kind in ("same", "mirror")}
    return [c for n, c in enumerate(captures) if n not in twice]


def performer_folds(performers: Sequence[str], n_folds: int = N_FOLDS) -> IntArray:
    """The fold of every capture; a performer stays whole, the largest are dealt out first.

    >>> performer_folds(["a", "a", "b", "c"], 2).tolist()
    [0, 0, 1, 1]
    """
    names, counts = np.unique(list(performers), return_counts=True)
    fold_of: dict[str, int] = {}
    sizes = np.zeros(n_folds, dtype=int)
    for p in np.lexsort([names, -counts]):
        smallest = int(np.argmin(sizes))
        fold_of[str(names[p])] = smallest
        sizes[smallest] += counts[p]
    return np.array([fold_of[p] for p in performers])


def load_sheet(folder: Path, sheet: Path) -> list[Capture]:
    rows: dict[str, list[dict[str, str]]] = {}
    with sheet.open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file, delimiter="\t"):
            rows.setdefault(row["file"], []).append(row)
    cache = _cache_file(folder, sheet)
    if cache.exists():
        with cache.open("rb") as file:
            return [Capture(*fields) for fields in pickle.load(file)]
    read = Parallel(2)(delayed(_read)(folder / name, said) for name, said in rows.items())
    cache.parent.mkdir(parents=True, exist_ok=True)
    with cache.open("wb") as file:
        pickle.dump([tuple(vars(c).values()) for c in read], file)
    return list(read)


def _read(path: Path, rows: Sequence[dict[str, str]]) -> Capture:
    fps = rows[0].get("fps")
    motion = to_motion(read_capture(path, fps=float(fps) if fps else None))
    return Capture(
        name="/".join(path.with_suffix("").parts[-2:]),
        performer=rows[0].get("performer", "bandai"),
        captions=tuple(row["words"] for row in rows if row["words"]),
        style=rows[0].get("style", ""),
        motion=motion,
        features=recognition_features(motion),
    )


def _cache_file(folder: Path, sheet: Path) -> Path:
    """Named after the sheet, the files' sizes, and the code that reads them."""
    digest = hashlib.sha256(sheet.read_bytes())
    for path in sorted(folder.rglob("*.*")):
        digest.update(f"{path.name} {path.stat().st_size}".encode())
    package = Path(motiondb.__file__).parent
    for pattern in ("files/**/*.py", "body/*.py"):
        paths = sorted(package.glob(pattern))
        assert paths, f"{pattern} matches no file of the package"
        for path in paths:
            digest.update(path.read_bytes())
    home = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))
    return home / "motiondb" / f"quality-{folder.name}-{digest.hexdigest()[:16]}.pickle"
