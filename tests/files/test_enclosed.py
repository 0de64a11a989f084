"""Files of a folder that others may fill."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from motiondb.errors import CaptureError
from motiondb.files.safe_files import open_inside


def test_a_file_is_opened_through_links_that_stay_in_the_folder(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "take").write_text("text")
    (tmp_path / "b").symlink_to("a")
    with os.fdopen(open_inside(tmp_path / "b" / "take", tmp_path, os.O_RDONLY)) as file:
        assert file.read() == "text"


@pytest.mark.parametrize("name", ["take", "folder/take"])
def test_a_link_that_is_put_in_the_way_meanwhile_is_refused(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    outside, folder = tmp_path / "outside", tmp_path / "inside"
    outside.mkdir()
    folder.mkdir()
    (outside / "take").write_text("text")
    (folder / "take").symlink_to(outside / "take")
    (folder / "folder").symlink_to(outside)
    with pytest.raises(CaptureError, match="a link that leads out of it"):
        open_inside(folder / name, folder, os.O_RDONLY)
    # as if the links were made after this
    monkeypatch.setattr(os.path, "realpath", lambda path, strict=False: str(path))
    with pytest.raises(CaptureError, match="a link that leads out of it"):
        open_inside(folder / name, folder, os.O_RDONLY)
