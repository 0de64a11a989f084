"""Read one odd case as a user would: by the reader of its kind, or by a command's verb.

What reads a case may only raise the project's errors. Verbs that write change a copy of the
database, which is thrown away after the case, so that every case can be repeated by its seed.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import MappingProxyType

import numpy as np
import odd_captures

from motiondb import MotionDB
from motiondb.database.catalogue.file_reading import AddSettings, read_joint_map
from motiondb.files.formats import capture_format, read_capture_bytes
from motiondb.files.limits import ReadLimits, ReadOptions, SkeletonFile, guarded
from robustness_tasks.odd_texts import text_case

SHARE_CAPTURES, SHARE_C3D, SHARE_WRITING = 0.5, 0.01, 0.03
"""Shares of the cases that are captures and sheets, C3D files, and cases that write to a copy of
the database; the rest are texts."""
_ROLES = {"pelvis": "Hips", "l_hip": "LeftUpLeg", "l_knee": "LeftLeg", "chest": "Spine2"}


@dataclass(frozen=True)
class Place:
    """Where a case is read: an empty folder, and a database that has learned."""

    folder: Path
    database: Path


@dataclass(frozen=True)
class Case:
    """A case: its kind, and what reads it."""

    kind: str
    read: Callable[[Place], object]


def make_case(seed: int) -> Case:
    """The case of a seed."""
    draw = np.random.default_rng([seed, 5]).random()
    if draw < SHARE_CAPTURES:
        suffix, data, companions = odd_captures.case(seed)
        kind = {".tsv": "sheet of words", ".csv": "sheet of events"}.get(
            suffix, f"capture {suffix}"
        )
        return Case(kind, lambda place: _read_capture(suffix, data, companions, seed, place))
    draw -= SHARE_CAPTURES
    if draw < SHARE_C3D:
        _, data, _ = odd_captures.odd_c3d(np.random.default_rng(seed))
        return Case("capture .c3d", lambda place: _read_capture(".c3d", data, {}, seed, place))
    draw -= SHARE_C3D
    if draw < SHARE_WRITING:
        return _writing_case(seed)
    kind, data = text_case(seed)
    return Case(kind, lambda place: READS[kind](data, place))


def _read_capture(
    suffix: str, data: bytes, companions: Mapping[str, bytes], seed: int, place: Place
) -> object:
    """Read a capture as ``add`` does, up to the motion on the canonical body; or a sheet."""
    from motiondb.body import retarget
    from motiondb.files.sheets import read_event_sheet, read_sheet

    if suffix in (".tsv", ".csv"):
        path = place.folder / f"sheet{suffix}"
        path.write_bytes(data)
        return read_sheet(path) if suffix == ".tsv" else read_event_sheet(path)
    asf = SkeletonFile(companions["skeleton.asf"]) if companions else None
    options = ReadOptions(skip_bad_frames=seed % 3 == 0, limits=ReadLimits(10.0))
    kind = capture_format(f"odd{suffix}")
    clip = read_capture_bytes(data, kind, path=f"odd{suffix}", skeleton=asf, options=options)
    with guarded("odd"):
        motion = retarget.to_motion(
            clip, _ROLES if seed % 5 == 0 else None, keep_implausible=seed % 4 == 0
        )
    if not (np.isfinite(motion.root_positions).all() and np.isfinite(motion.local_rotations).all()):
        raise AssertionError("a motion with numbers that are not finite")
    return motion


def _writing_case(seed: int) -> Case:
    """A sheet, a table of synonyms or a folder of captures, written to a copy of the database."""
    rng = np.random.default_rng([seed, 6])
    which = int(rng.integers(4))
    if which == 0:
        _, data, _ = odd_captures.odd_sheet(rng)
        data = data.replace(b"a/b.bvh", b"ana/bow_1").replace(b"c.bvh", b"ana/walk_1")
        return Case("words import", lambda place: _import(data, place, "import_words", ".tsv"))
    if which == 1:
        _, data, _ = odd_captures.odd_events(rng)
        data = data.replace(b"a/b.bvh", b"ana/bow_1").replace(b"c.bvh", b"ana/walk_1")
        return Case("events import", lambda place: _import(data, place, "import_events", ".csv"))
    if which == 2:
        data = text_case(seed, "synonyms")[1]
        return Case("words synonyms", lambda place: _import(data, place, "set_synonyms", ".txt"))
    odd = odd_captures.case(seed)  # before it is measured: some are packed from a gigabyte
    return Case("add", lambda place: _add(odd, place))


def _import(data: bytes, place: Place, verb: str, ending: str) -> object:
    """Give a file to a verb of the database, then ask whether the database is whole."""
    path = place.folder / f"given{ending}"
    path.write_bytes(data)
    with writable(place) as db:
        report = getattr(db, verb)(path)
        db.search("walk")
    return report


def _add(odd: tuple[str, bytes, odd_captures.Companions], place: Place) -> object:
    """Add a folder of an odd capture, an odd sheet and a whole capture."""
    folder = place.folder / "added"
    folder.mkdir(exist_ok=True)
    suffix, data, companions = odd
    (folder / f"odd{suffix}").write_bytes(data)
    for name, content in companions.items():
        (folder / name).write_bytes(content)
    (folder / "whole.bvh").write_text(odd_captures.BVH)
    with writable(place) as db:
        report = db.add(folder, settings=AddSettings(jobs=1, limits=ReadLimits(10.0)))
        if "whole" not in {info.name for info in db.captures()}:
            raise AssertionError("an odd file kept a whole one from being added")
    return report


@contextmanager
def writable(place: Place) -> Iterator[MotionDB]:
    """A copy of the database that may be changed."""
    copy = place.folder / "copy.duckdb"
    shutil.copy(place.database, copy)
    with MotionDB(copy) as db:
        yield db


def _read_cfg(data: bytes, _place: Place) -> object:
    """Read a context-free grammar, write it, and ask what it accepts."""
    from motiondb.grammar.cfg import context_free, parse

    grammar = context_free.read_grammar(_text(data))
    context_free.check_grammar(grammar)
    context_free.read_grammar(context_free.format_grammar(grammar))
    parse.accepts(grammar, grammar.terminals[:3])
    return parse.suggest(grammar, grammar.terminals[:1])


def _read_motion_grammar(data: bytes, place: Place) -> object:
    """Read a motion grammar from a file, check it, and ask what may come."""
    from motiondb.database.scenes.scene_texts import read_grammar
    from motiondb.scene.services import services

    grammar = read_grammar(_file(data, place, "odd.grammar"))
    services.check(grammar)
    actions = [terminal.name for terminal in grammar.terminals[:2]]
    services.validate(grammar, actions)
    services.suggest(grammar, [])
    return services.plan(grammar)


def _read_tactics(data: bytes, place: Place) -> object:
    """Read a diagram from a file, and cast its players."""
    from motiondb import Scenes

    return Scenes.read_diagram(_file(data, place, "odd.tactics")).shortest


def _read_actions(data: bytes, _place: Place) -> object:
    """Validate a string of actions, and ask what may follow it."""
    from motiondb.database.scenes.scene_texts import read_grammar
    from motiondb.scene.services import services

    grammar, actions = read_grammar("basketball"), _text(data).split()
    services.validate(grammar, actions)
    return services.suggest(grammar, actions)


def _ask_name(data: bytes, db: MotionDB) -> object:
    """Name a capture that is looked up, and one that is to be made."""
    from motiondb import store

    name = _text(data)
    store.check_new_name(name, "capture")
    db.captures.check_name_free(name)
    return db.captures.show(name)


def _asking(ask: Callable[[bytes, MotionDB], object]) -> Callable[[bytes, Place], object]:
    """A question to the database, which is only read."""

    return lambda data, place: ask(data, _opened(place.database))


@cache
def _opened(path: Path) -> MotionDB:
    """The database that is only asked, opened once in each process."""
    return MotionDB(path, read_only=True, wait=60.0)


def _read_page(data: bytes, _place: Place) -> object:
    from motiondb.fetch.cmu import check_amc, check_asf, read_trials

    check_amc(data)
    check_asf(data)
    return read_trials(data.decode("latin-1"), 16)


def _read_synonyms(data: bytes, _place: Place) -> object:
    from motiondb.language.vocabulary import parse_synonyms

    return parse_synonyms(_text(data))


def _read_unit(data: bytes, _place: Place) -> object:
    from motiondb.files.units import unit_from_name

    return unit_from_name(_text(data))


def _read_subjects(data: bytes, _place: Place) -> object:
    from motiondb.fetch.cmu import check_subjects

    return check_subjects(_text(data).split())


def _text(data: bytes) -> str:
    """Bytes as the text of an argument: bytes that are not UTF-8 become lone surrogates."""
    return data.decode("utf-8", "surrogateescape")


def _file(data: bytes, place: Place, name: str) -> Path:
    path = place.folder / name
    path.write_bytes(data)
    return path


READS: Mapping[str, Callable[[bytes, Place], object]] = MappingProxyType(
    {
        "synonyms": _read_synonyms,
        "joint map": lambda data, place: read_joint_map(_file(data, place, "joints.txt")),
        "filter": _asking(lambda data, db: db.captures(_text(data))),
        "question": _asking(lambda data, db: db.search(_text(data))),
        "grammar": _read_cfg,
        "motion grammar": _read_motion_grammar,
        "tactics": _read_tactics,
        "actions": _read_actions,
        "terminals": _asking(lambda data, db: db.grammars.suggest("moves", _text(data))),
        "name": _asking(_ask_name),
        "unit": _read_unit,
        "subjects": _read_subjects,
        "page": _read_page,
    }
)
"""Kind of text -> what reads it."""
