"""The sample data: 101 synthetic captures with words and events, shipped with motiondb."""

from __future__ import annotations

from pathlib import Path

import motiondb
from motiondb import store
from motiondb.answers import AddReport
from motiondb.database.catalogue import cataloguing, sheets
from motiondb.errors import MotionDBError


def sample_folder() -> Path:
    """The folder of the sample data: in the package, or beside it in a clone.

    Raises
    ------
    MotionDBError
        It is in neither.
    """
    package = Path(motiondb.__file__).parent
    places = [package / "sample_data", package.parent / "sample_data"]
    for folder in places:
        if (folder / "captions.tsv").is_file():
            return folder
    raise MotionDBError(
        f"{places[0]}: expected the sample data of motiondb, found none. Install motiondb again."
    )


def add_sample(opened: store.Store, progress: cataloguing.Progress | None) -> AddReport:
    """Add the sample data to a database that holds nothing else; what is there stays."""
    folder = sample_folder()
    captures = folder / "captures"
    own = {
        path.relative_to(captures).with_suffix("").as_posix() for path in captures.rglob("*.bvh")
    }
    others = [info.name for info in store.load_captures(opened) if info.name not in own]
    if others:
        raise MotionDBError(
            f"{opened.path}: expected a database without captures for the sample data, found"
            f" {len(others)} of others, such as {others[0]}. Name a new database."
        )
    given = sheets.Sheets.read(folder / "captions.tsv", folder / "events.tsv")
    settings = cataloguing.AddSettings()
    return cataloguing.add_captures(opened, [captures], given, settings, progress, None)
