"""The folder of a scene: motions, the whole scene, pictures, the report and the record.

``NAME.bvh`` for every character, in one world, so that all of them together are the scene, with
``NAME.provenance.json`` beside it; ``scene.glb`` with all characters and the ball; ``paths.png``,
``above.gif`` and ``scene.gif``; ``report.txt`` and ``report.json``; ``scene.json``, from which
``scene update`` begins; the texts of the diagram and the grammar. The folder is written under
another name and then renamed, so that it is complete or absent.
"""

from __future__ import annotations

import glob
import json
import os
import shutil
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motiondb import files as capture
from motiondb import pictures, store
from motiondb.answers import plain
from motiondb.body import body, retarget
from motiondb.database.catalogue.parts import write_bytes
from motiondb.database.scenes.scene_files import GRAMMAR, TACTICS
from motiondb.database.scenes.scene_making import MadeScene, SceneProgress
from motiondb.database.scenes.scene_records import from_json, to_json
from motiondb.database.scenes.scene_reports import report_facts, report_text
from motiondb.errors import MotionDBError, SceneError
from motiondb.files.gltf_writer import Character
from motiondb.pictures.scenes.scene_paths import performer_colours
from motiondb.records import Clip, IntArray, Motion
from motiondb.scene.language.tactics import Diagram
from motiondb.scene.language.tactics_file import read_diagram

RECORD = "scene.json"  # Name of the file with the record of a scene
_LEFT_OUT = 2.0  # Frames of a capture between two frames of a scene, above which some were left out


def fill_scene_folder(
    made: MadeScene,
    record: store.StoredScene,
    provenance: Mapping[str, store.Provenance],
    folder: Path,
    progress: SceneProgress,
    drawn: bool = True,
) -> None:
    """Write everything of a scene into an empty folder, such as :func:`whole_folder` gives."""
    motions = {player.player: player.motion for player in made.polished.players}
    for player in made.polished.players:
        name = player.player
        capture.write_bvh(in_world(player.motion), folder / f"{name}.bvh")
        facts = {
            "scene": record.name,
            "player": name,
            "seed": made.settings.seed,
            "actions": list(made.state.players[_number(made, name)].tree.leaves()),
            "sources": source_facts(provenance[name]),
            "frames": action_runs(player.clips, made, name, provenance[name]),
        }
        _write(folder / f"{name}.provenance.json", json.dumps(facts, indent=1))
    _write_gltf(folder / "scene.glb", made.text.diagram, motions, record)
    _write(folder / RECORD, to_json(record))
    _write(folder / f"diagram{TACTICS}", record.diagram)
    _write(folder / f"{made.text.diagram.grammar}{GRAMMAR}", record.grammar)
    _write(folder / "report.json", json.dumps(plain.to_json(report_facts(record)), indent=1))
    _write(folder / "report.txt", report_text(record) + "\n")
    if drawn:
        _draw(folder, made.text.diagram, motions, record, progress)


def in_world(motion: Motion) -> Clip:
    """Return a motion as a clip in the scene's metres: every player has the same body."""
    return retarget.to_clip(replace(motion, leg_length=body.LEG_LENGTH))


def _number(made: MadeScene, name: str) -> int:
    return [player.name for player in made.text.diagram.players].index(name)


def _write(path: Path, text: str) -> None:
    write_bytes(path, text.encode())


def _write_gltf(
    path: Path, diagram: Diagram, motions: Mapping[str, Motion], record: store.StoredScene
) -> None:
    colours = performer_colours(diagram)
    people = [
        Character(name, in_world(motion), _linear(colours[name]))
        for name, motion in motions.items()
    ]
    capture.write_gltf_scene(people, path, record.ball)


def _linear(colour: str) -> tuple[float, float, float]:
    """Return red, green and blue in linear light, as glTF needs them, of "#rrggbb"."""
    red, green, blue = (round((int(colour[k : k + 2], 16) / 255.0) ** 2.2, 4) for k in (1, 3, 5))
    return red, green, blue


def _draw(
    part: Path,
    diagram: Diagram,
    motions: Mapping[str, Motion],
    record: store.StoredScene,
    progress: SceneProgress,
) -> None:
    ball = record.ball if len(record.ball) else None
    progress("drawing", 0.0, record.error)
    pictures.draw_scene_paths(diagram, motions, part / "paths.png", ball)
    progress("drawing", 0.2, record.error)
    pictures.draw_scene_animation(diagram, motions, part / "above.gif", ball, above=True)
    progress("drawing", 0.6, record.error)
    pictures.draw_scene_animation(diagram, motions, part / "scene.gif", ball)
    progress("drawing", 1.0, record.error)


def source_facts(provenance: store.Provenance) -> list[dict[str, Any]]:
    """Return the captures that frames come from, with licence, digest and number of frames."""
    return [
        {
            "capture": source.name,
            "licence": source.licence or "unknown",
            "sha256": source.sha256,
            "frames": int((provenance.source_numbers == number).sum()),
        }
        for number, source in enumerate(provenance.sources)
    ]


def action_runs(
    clips: IntArray, made: MadeScene, name: str, provenance: store.Provenance
) -> list[dict[str, Any]]:
    """Return runs of frames of one action: their capture, its frames, and what was done to them.

    Waiting is a separate run, and a new run begins after frames that were left out.
    """
    actions = made.state.players[_number(made, name)].tree.leaves()
    numbers = np.asarray(clips)
    waits = waiting(provenance.edits)
    changed = (np.diff(numbers) != 0) | (np.diff(provenance.source_numbers) != 0)
    changed |= (waits[1:] != waits[:-1]) | (np.abs(np.diff(provenance.source_frames)) > _LEFT_OUT)
    bounds = [0, *(np.flatnonzero(changed) + 1).tolist(), len(numbers)]
    return [
        {
            "start": start,
            "end": end,
            "action": actions[int(numbers[start])],
            "capture": provenance.sources[int(provenance.source_numbers[start])].name,
            "source_start": round(float(provenance.source_frames[start]), 2),
            "source_end": round(float(provenance.source_frames[end - 1]), 2),
            "edits": sorted(
                {
                    "blend" if part.startswith("blend") else part
                    for edit in provenance.edits[start:end]
                    for part in edit.split(", ")
                    if part
                }
            ),
        }
        for start, end in pairwise(bounds)
        if end > start
    ]


def waiting(edits: Sequence[str]) -> NDArray[np.bool_]:
    """Return the frames in which a player waits, by their edits: array (frames,)."""
    return np.array(["waits" in edit.split(", ") for edit in edits], dtype=bool)


def check_scene_folder(folder: Path) -> None:
    """Refuse a folder that cannot hold a scene, before anything is computed."""
    if not folder.absolute().parent.is_dir():
        raise MotionDBError(
            f"{folder}: expected the folder {folder.parent}, found none. Make the folder first."
        )
    try:
        Path(tempfile.mkdtemp(prefix=f".{folder.name}.", dir=folder.absolute().parent)).rmdir()
    except OSError as error:
        raise _unwritable(folder, error) from None
    if not folder.exists():
        return
    if not folder.is_dir():
        raise MotionDBError(f"{folder}: expected a folder, found a file. Name another.")
    if any(folder.iterdir()) and not (folder / RECORD).is_file():
        raise MotionDBError(
            f"{folder}: expected a new folder, or one that holds a scene, found other files."
            " Name another."
        )


def _unwritable(folder: Path, error: OSError) -> MotionDBError:
    return MotionDBError(
        f"{folder}: expected a folder that can be written, found: {error.strerror or error}."
        " Check its permissions and the room on its disk."
    )


def read_scene_folder(folder: Path) -> store.StoredScene:
    """Read the record in a scene's folder."""
    path = folder / RECORD
    try:
        record = from_json(path.read_text(encoding="utf-8"), str(path))
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "other bytes than text"
        raise SceneError(
            f"{path}: expected the record of a scene, found: {reason}."
            " Make the scene with motiondb scene make, or name the folder of one."
        ) from None
    try:
        report_text(record)
    except (ValueError, KeyError, TypeError, AttributeError, IndexError) as error:
        raise SceneError(
            f"{path}: expected a record that can be reported, found"
            f" {type(error).__name__}: {error}. It was changed by hand: make the scene again."
        ) from None
    return record


def read_motions(folder: Path, names: list[str]) -> dict[str, Motion]:
    """Read the motions of a scene's characters from their BVH files."""
    return {
        name: retarget.to_motion(capture.read_capture(folder / f"{name}.bvh")) for name in names
    }


def draw_folder(folder: Path, png: Path) -> Path:
    """Draw the paths of the characters of a scene's folder over its diagram."""
    record = read_scene_folder(folder)
    diagram = read_diagram(record.diagram, str(folder))
    motions = read_motions(folder, [player.name for player in record.players])
    return pictures.draw_scene_paths(diagram, motions, png, record.ball)


def _mend(folder: Path) -> None:
    """Repair the state that killed processes left while they wrote this folder.

    An earlier scene that had been moved away is restored; partial folders are removed.
    """
    for left in folder.parent.glob(f".{glob.escape(folder.name)}.*.*"):
        owner, _, kind = left.name.removeprefix(f".{folder.name}.").rpartition(".")
        if kind not in ("part", "old") or not owner.isdigit() or _runs(int(owner)):
            continue
        if kind == "old" and not folder.exists():
            left.rename(folder)
        else:
            shutil.rmtree(left, ignore_errors=True)


def _runs(process: int) -> bool:
    """Return whether a process is alive, or True if that cannot be known."""
    if os.name != "posix":
        return True
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True


@contextmanager
def whole_folder(folder: Path) -> Iterator[Path]:
    """Give a folder to write into; rename it to ``folder`` on success, remove it otherwise."""
    _mend(folder.absolute())
    check_scene_folder(folder)
    folder = folder.absolute()
    part = folder.with_name(f".{folder.name}.{os.getpid()}.part")
    old = folder.with_name(f".{folder.name}.{os.getpid()}.old")
    try:
        shutil.rmtree(part, ignore_errors=True)
        part.mkdir()
        yield part
        if folder.exists():
            folder.rename(old)
        try:
            part.rename(folder)
        except OSError:
            if old.exists():
                old.rename(folder)
            raise
    except OSError as error:
        raise _unwritable(folder, error) from None
    finally:
        shutil.rmtree(part, ignore_errors=True)
        shutil.rmtree(old, ignore_errors=True)
