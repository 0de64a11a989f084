"""Files to download: captures, parts of them, generated motions, scenes; several as a zip."""

from __future__ import annotations

import io
import re
import tempfile
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from motiondb.body import retarget
from motiondb.database import MotionDB
from motiondb.database.catalogue.parts import write_clip
from motiondb.page.answers import PageError
from motiondb.page.delivery.refs import Ref, find_capture, load_motion, read_ref
from motiondb.page.delivery.scene_motions import load_scene
from motiondb.page.facts.scene_facts import find_kept
from motiondb.page.parameters import Part
from motiondb.page.session.state import Page
from motiondb.records import Motion

_PLAIN = re.compile(r"[^A-Za-z0-9._-]+")
_TYPES = {".zip": "application/zip", ".glb": "model/gltf-binary"}


@dataclass(frozen=True)
class Download:
    """A file for the browser."""

    name: str  # File name in plain ASCII
    data: bytes

    @property
    def media_type(self) -> str:
        """Its media type."""
        return _TYPES.get(Path(self.name).suffix, "application/octet-stream")


def download(page: Page, parts: Sequence[Part], ending: str, canonical: bool) -> Download:
    """Return the file for some parts: one motion as it is, anything else as a zip."""
    with tempfile.TemporaryDirectory(dir=page.folder) as place:
        folder = Path(place)
        with page.held.use() as db, db.session.reading():
            for number, part in enumerate(parts):
                subfolder = folder / f"{number:04d}"
                subfolder.mkdir()
                _write(page, db, (part, ending, canonical), subfolder)
        files = sorted(path for path in folder.rglob("*") if path.is_file())
        if len(files) == 1:
            return Download(files[0].name, files[0].read_bytes())
        return Download("motiondb.zip", _zip(files))


def _zip(files: Sequence[Path]) -> bytes:
    """Return a zip archive of files; files of the same name are numbered."""
    stream, used = io.BytesIO(), dict[str, int]()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in files:
            count = used[path.name] = used.get(path.name, 0) + 1
            name = path.name if count == 1 else f"{path.stem}-{count}{path.suffix}"
            archive.write(path, name)
    return stream.getvalue()


def _write(page: Page, db: MotionDB, wanted: tuple[Part, str, bool], folder: Path) -> None:
    """Write one part into a folder; ``wanted`` is the part, the file ending, and ``canonical``."""
    part, ending, canonical = wanted
    ref = read_ref(part.ref)
    stem = _stem(ref, part)
    if ending == "source":
        _write_source(db, ref, part, folder)
        return
    path = folder / f"{stem}.{ending}"
    if ref.kind == "capture":
        db.export(find_capture(db, ref.name), path, part.start, part.end, canonical)
    elif ref.kind == "made" and part.start is None and part.end is None:
        page.made.get(ref.name).generated.write(path)
    elif ref.kind == "sequence" and part.start is None and part.end is None:
        kept = page.sequences.get(ref.name)
        db.grammars.write(kept.sequence, path, kept.seed)
    elif ref.kind == "scene":
        _write_scene(page, ref, folder)
    elif ref.kind == "kept":
        record = find_kept(db, ref.name)
        load_scene(page, db, ref, None, None, 30.0)  # raises if a capture of the scene was removed
        for player in record.players:
            name = f"{ref.name}/{player.name}"
            db.export(name, folder / f"{_plain(player.name)}.{ending}", canonical=True)
    else:
        _write_motion(load_motion(page, db, ref, part.start, part.end), path)


def _write_source(db: MotionDB, ref: Ref, part: Part, folder: Path) -> None:
    if ref.kind != "capture" or part.start is not None or part.end is not None:
        raise PageError(
            f"{ref}: expected a whole stored capture for its source file, found something else."
            " Choose BVH or glTF."
        )
    row = db.browsed(find_capture(db, ref.name))
    assert row is not None
    ending = Path(row.info.path).suffix.lower() or f".{row.info.format}"
    db.export(ref.name, folder / f"{_plain(ref.name)}.{_plain(ending)}")


def _write_motion(motion: Motion, path: Path) -> None:
    write_clip(retarget.to_clip(motion), path)


def _write_scene(page: Page, ref: Ref, folder: Path) -> None:
    made = page.scene_folder(ref.name)
    parameters = {"scene": ref.name, "folder": str(made), "output": str(folder / "scene")}
    page.jobs.ask_scene_worker("scene-files", "write the scene", parameters)


def _stem(ref: Ref, part: Part) -> str:
    stem = _plain(ref.name)
    if part.start is None and part.end is None:
        return stem
    return f"{stem}_{part.start or 0.0:.2f}-{'end' if part.end is None else f'{part.end:.2f}'}"


def _plain(name: str) -> str:
    """Return a name with only characters that every file system and HTTP header allows.

    >>> _plain('ana/läuft "schnell"')
    'ana_l_uft_schnell_'
    """
    return _PLAIN.sub("_", name).lstrip(".")[:150] or "motion"
