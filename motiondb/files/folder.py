"""Which files of a folder are captures, which are not, and which skeleton belongs to an AMC.

Files that a user may expect to be captures are not skipped silently: :func:`not_read` names links
to folders and files of other motion-capture programs, and :func:`name_fault` finds names that no
capture can have.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType

from motiondb.errors import CaptureError
from motiondb.files.safe_files import is_file, leads_out, open_file
from motiondb.files.text import quoted

_MODELS = (".xml", ".mjcf", ".urdf")
FORMATS = MappingProxyType(
    {
        ".bvh": "bvh",
        ".amc": "amc",
        ".txt": "deepmimic",
        ".json": "deepmimic",
        ".npz": "amass",
        ".c3d": "c3d",
        ".fbx": "fbx",
        ".trc": "trc",
        ".nc": "movement",
        ".npy": "positions",
        ".csv": "robot",
        ".tsv": "markers",
        ".mvnx": "markers",
        ".pkl": "robot",
        ".mot": "opensim",
        ".sto": "opensim",
    }
)  # Ending, lower case -> format
WITH_TAKES = frozenset({"fbx", "c3d", "trc", "markers"})
"""Formats of which one file may hold several captures, takes or performers."""
TAKE_ENDINGS = frozenset({".csv"} | {end for end, form in FORMATS.items() if form in WITH_TAKES})
"""Endings of such files, lower case."""
CAPTURE_ENDINGS: tuple[str, ...] = tuple(FORMATS)
"""Endings of captures, lower case; ".txt" and ".json" count where they hold DeepMimic's JSON,
".csv", ".tsv", ".npy", ".pkl", ".mot" and ".sto" where they hold motion."""
WITH_SKELETON: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {".amc": (".asf",), ".csv": _MODELS, ".pkl": (*_MODELS, ".txt")}
    | {
        ".npz": (*_MODELS, ".txt"),
        ".npy": (*_MODELS, ".txt"),
        ".mot": (".osim",),
        ".sto": (".osim",),
    }
)
"""Ending of a capture -> endings of the skeleton file that may belong to it: an ASF, the model of a
robot or of OpenSim, names of joints."""
NAME_FILES = ("joint_names.txt", "joints.txt")
"""Text files of joint names for all arrays of their folder; ``NAME.joints.txt`` is for one."""
OTHER_FORMATS = MappingProxyType(
    {
        ".trb": "marker tracks of Motion Analysis",
        ".htr": "Motion Analysis HTR",
        ".gtr": "Motion Analysis GTR",
        ".mot": "OpenSim table of forces or other values than joint angles",
        ".sto": "OpenSim table of forces, muscles or other values than joint angles",
        ".v": "Vicon V-file",
        ".vsk": "Vicon skeleton",
        ".vst": "Vicon skeleton template",
        ".vss": "Vicon Shogun skeleton",
        ".vsr": "Vicon retarget setup",
        ".x1d": "Vicon raw data",
        ".x2d": "Vicon raw data",
        ".mcp": "Vicon Shogun capture",
        ".tak": "OptiTrack take",
        ".qtm": "Qualisys capture",
        ".mvn": "Xsens capture",
        ".bip": "3ds Max Biped",
        ".csm": "Character Studio markers",
        ".pkl": "Python pickle without a motion that is known",
        ".npy": "NumPy array without places of joints or a motion that is known",
        ".glb": "glTF",
        ".gltf": "glTF",
        ".dae": "Collada",
        ".usd": "USD",
        ".usda": "USD",
        ".usdc": "USD",
        ".blend": "Blender scene",
        ".vmd": "MikuMikuDance motion",
        ".vrma": "VRM animation",
        ".anim": "Unity or Maya animation",
        ".abc": "Alembic",
        ".skeleton": "NTU skeletons",
        ".zoo": "biomechzoo",
        ".h5": "HDF5",
        ".hdf5": "HDF5",
        ".mat": "MATLAB",
        ".pt": "PyTorch",
        ".pth": "PyTorch",
        ".parquet": "table of numbers, as of LeRobot",
        ".xlsx": "workbook",
        ".zip": "packed folder",
    }
)  # Ending of a format that motiondb does not read -> its name
_MENDS = MappingProxyType(
    {".zip": "unpack it", ".xlsx": "save its sheet of places as CSV"}
    | dict.fromkeys((".h5", ".hdf5", ".mat", ".pt", ".pth", ".parquet"), "save its arrays as npz")
)  # Ending -> what to do, other than to export as BVH
GENERIC_SKELETONS = frozenset(
    {"skeleton", "skel", "body", "actor", "performer", "subject", "character", "rig", "model"}
    | {"base", "default", "template", "mocap", "human"}
)
"""Names of an ASF that say nothing about whose it is."""
_INCLUDED = re.compile(rb"<include\s[^>]*?file\s*=\s*[\"']([^\"'<>]*)[\"']")
_CONTROL = re.compile(r"[\x00-\x1f\x7f-\x9f\u2028\u2029\u202a-\u202e\u2066-\u2069]")
"""Characters that end lines, command terminals or turn the direction of writing around: a list of
captures that holds them would show what is not there."""
_HEAD = 65536  # Bytes of a table or an array in which is looked whether it holds motion
_LOOK = 4096
"""Bytes at both ends of a text file in which the key "Frames" is searched for: DeepMimic writes it
within the first or, where other keys follow, the last few hundred bytes."""


def find_captures(folder: Path | str, within: Path | None = None) -> list[Path]:
    """Captures below a folder, sorted, none hidden; links that lead out of `within` count too.

    But not those named as sheets (".tsv"), of which few hold markers.
    """

    def counts(path: Path) -> bool:
        if within is not None and leads_out(path, within):
            return path.suffix.lower() != ".tsv"
        return holds_capture(path)

    every = _visible(Path(folder))
    return sorted(p for p in every if p.suffix.lower() in FORMATS and p.is_file() and counts(p))


def holds_capture(path: Path) -> bool:
    """Whether a file with the ending of a capture may hold one; those of tables often do not."""
    ending = path.suffix.lower()
    if ending in (".csv", ".tsv", ".npy", ".pkl", ".mot", ".sto"):
        return _is_motion(path, ending)
    return ending not in (".txt", ".json") or _is_deepmimic(path)


def no_captures(folder: Path) -> tuple[str, ...]:
    """Describe the contents of a folder in which no capture was found."""
    tables = [
        path
        for path in sorted(_visible(folder))
        if path.suffix.lower() in FORMATS
        and path.suffix.lower() not in OTHER_FORMATS
        and path.is_file()
    ]
    if not tables:
        return not_read(folder)
    names = ", ".join(printable(path.relative_to(folder)) for path in tables[:5])
    more = f" and {len(tables) - 5} more" if len(tables) > 5 else ""
    told = f"{printable(folder)}: {names}{more}: no motion by which a capture is known; add a file "
    return (told + "by its name to see the reason", *not_read(folder))


def not_read(folder: Path | str) -> tuple[str, ...]:
    """Describe the contents of a folder that are not read although they may hold captures."""
    others: dict[str, list[Path]] = {}
    root, sentences = Path(folder), list[str]()
    for path in (*[root][: root.is_dir()], *sorted(_visible(root))):
        if path.is_symlink() and path.is_dir() and path != root:
            sentences.append(
                f"{printable(path)}: a link to a folder is not followed; add that folder by itself"
            )
        elif path.is_dir():
            if not os.access(path, os.R_OK | os.X_OK):
                sentences.append(f"{printable(path)}: a folder that may not be read")
        elif path.suffix.lower() in FORMATS and not path.is_file():
            what = "a link that leads to no file" if path.is_symlink() else "a pipe or device"
            sentences.append(f"{printable(path)}: {what} is not read")
        elif (
            path.suffix.lower() in OTHER_FORMATS
            and path.is_file()
            and not (path.suffix.lower() in FORMATS and holds_capture(path))
        ):
            others.setdefault(path.suffix.lower(), []).append(path)
    for ending, paths in others.items():
        more = f" and {len(paths) - 1} more" if len(paths) > 1 else ""
        mend = (
            "" if FORMATS.get(ending) == "opensim" else f"; {_MENDS.get(ending, 'export as BVH')}"
        )
        what = OTHER_FORMATS[ending]
        sentences.append(f"{printable(paths[0])}{more}: {ending} ({what}) is not read{mend}")
    return tuple(sentences)


def printable(path: Path | str) -> str:
    r"""Return a path as text that can be printed and stored.

    Bytes that are no text, and control characters, become ``\\x..``.

    >>> printable("walk.bvh")
    'walk.bvh'
    """
    text = os.fsencode(path).decode("utf-8", errors="backslashreplace")
    return _CONTROL.sub(lambda character: character[0].encode("unicode_escape").decode(), text)


def name_fault(path: Path | str) -> str:
    r"""Say what keeps the name of a file from being that of a capture.

    >>> name_fault("walk.bvh"), name_fault("line\nbreak.bvh")
    ('', 'without control characters, found one')
    """
    try:
        str(path).encode("utf-8")
    except UnicodeEncodeError:
        return "in UTF-8, found other bytes"
    return "without control characters, found one" if _CONTROL.search(str(path)) else ""


def skeleton_path(path: Path | str, skeleton: Path | str | None = None) -> Path | None:
    """Return the skeleton file that belongs to a capture; None for captures that need none.

    For the motion of a robot: ``skeleton`` if given; of the models (MJCF, URDF) of the same folder
    the one with the longest name that the capture's name begins with; the only one. For positions:
    ``walk.joints.txt`` for ``walk.npy``, or ``joint_names.txt``.

    For an AMC, in this order: ``skeleton`` if given; of the ASF files of the same folder, in any
    case of letters, the one with the longest name that the AMC's name is or begins with (``16.asf``
    for ``16_01.amc``); the only one of the folder, if its name is the folder's or says nothing
    about whose skeleton it is (``skeleton.asf``). An ASF with another
    performer's name is not used.
    """
    path = Path(path)
    if path.suffix.lower() not in WITH_SKELETON:
        return None
    if skeleton is not None:
        return Path(skeleton)
    if path.suffix.lower() != ".amc":
        return _model_beside(path)
    beside = [p for p in _skeletons(path.parent) if p.suffix.lower() == ".asf"]
    named = [asf for asf in beside if _begins_with(path.stem, asf.stem)]
    if named:
        return max(named, key=lambda asf: (len(asf.stem), path.stem.startswith(asf.stem)))
    if len(beside) == 1 and _is_generic(beside[0]):
        return beside[0]
    wanted = f"{path.stem.split('_')[0]}.asf"
    present = ", ".join(p.name for p in beside[:5]) if beside else "no ASF file"
    raise CaptureError(
        path,
        f"expected its skeleton {wanted} in the same folder, found {present}. "
        "Put the ASF beside the AMC, or name it in the sheet's column 'skeleton'.",
    )


def named_skeleton(path: Path, name: str, folder: Path, allow_outside: bool = False) -> Path:
    """Return the skeleton that a sheet names, below the added folder or beside the capture."""
    root = folder if folder.is_dir() else folder.parent
    outside = False
    if "\0" not in name:
        for base in (root, path.parent):
            for ending in ("", *WITH_SKELETON.get(path.suffix.lower(), (".asf",))):
                candidate = base / (name + ending)
                if not is_file(candidate):
                    continue
                if allow_outside or candidate.resolve().is_relative_to(root.resolve()):
                    return candidate
                outside = True
    if outside:
        raise CaptureError(
            path,
            f"expected a skeleton inside the added folder, found {quoted(name, 200)} outside. "
            "Copy it into the folder, or pass --outside-skeletons.",
        )
    raise CaptureError(
        path,
        f"expected the skeleton {quoted(name, 200)} of the sheet below {root} or beside the "
        "capture, found none. Correct the column 'skeleton'.",
    )


def _model_beside(path: Path) -> Path | None:
    """Return the model, or the names of joints, beside an array; None where it is not clear.

    OpenCap has models in a folder beside that of the motions.
    """
    folders = [path.parent]
    if path.suffix.lower() in (".mot", ".sto"):
        folders += [path.parent.parent / name for name in ("Model", "Models")]
    beside = [found for folder in folders for found in _skeletons(folder)]
    endings = WITH_SKELETON[path.suffix.lower()]
    models = [p for p in beside if p.suffix.lower() in endings and p.suffix.lower() != ".txt"]
    included = {model: set(_INCLUDED.findall(_start(model))) for model in models}
    names = {model.name.encode() for model in models}
    models = [model for model in models if not included[model] & names]  # no scene around another
    named = [model for model in models if _begins_with(path.stem, model.stem)]
    if named or len({model.stem for model in models}) == 1:
        return max(named or models, key=lambda p: (len(p.stem), p.suffix.lower() != ".urdf"))
    texts = {p.name.lower(): p for p in beside if ".txt" in endings}
    wanted = (f"{path.stem.lower()}.joints.txt", *NAME_FILES)
    return next((texts[name] for name in wanted if name in texts), None)


def _skeletons(folder: Path) -> tuple[Path, ...]:
    """Return the skeletons, models and lists of names in a folder, sorted."""
    try:
        changed, n_entries = folder.stat().st_mtime_ns, sum(1 for _ in folder.iterdir())
        return _beside(folder, folder.resolve(), changed, n_entries)
    except OSError:
        return ()


@lru_cache(maxsize=64)
def _beside(folder: Path, _where: Path, _changed: int, _n_entries: int) -> tuple[Path, ...]:
    """As :func:`_skeletons`, of a folder that was changed at a time."""
    from motiondb.files.readers.first_bytes import is_model

    found = []
    for path in sorted(_children(folder)):
        name = path.name.lower()
        is_robot = path.suffix.lower() in (*_MODELS, ".osim") and is_model(_start(path))
        if is_robot or name in NAME_FILES or name.endswith((".asf", ".joints.txt")):
            found.append(path)
    return tuple(found)


def _start(path: Path) -> bytes:
    """Return the first bytes of a file; none if it may not be read."""
    try:
        with open_file(path) as file:
            return file.read(_HEAD)
    except OSError:
        return b""


def _is_motion(path: Path, ending: str) -> bool:
    """Say whether a table or an array may hold motion, or may not be read, which is told later."""
    from motiondb.files.readers import array_files, first_bytes

    start = _start(path)
    if not start:
        return path.is_file() and not os.access(path, os.R_OK)
    if ending == ".npy":
        shape = array_files.npy_shape(start)
        is_named = shape is None and first_bytes.is_motion_pickle(start)
        return is_named or first_bytes.is_points_shape(shape or ())
    if ending in (".mot", ".sto"):
        return first_bytes.is_angles(start)
    if ending in (".csv", ".tsv"):
        is_robot = ending == ".csv" and first_bytes.is_robot_csv(start)
        return is_robot or first_bytes.is_marker_table(start)
    return first_bytes.is_motion_pickle(array_files.inflated(start))


def _begins_with(stem: str, name: str) -> bool:
    """Say whether a capture's name is a skeleton's name, or begins with it as a whole word.

    >>> _begins_with("16_01", "16"), _begins_with("161_01", "16"), _begins_with("Ann-walk", "ann")
    (True, False, True)
    """
    stem, name = stem.lower(), name.lower()
    return bool(name) and stem.startswith(name) and not stem[len(name) : len(name) + 1].isalnum()


def _is_generic(asf: Path) -> bool:
    """Say whether the only ASF of a folder may belong to every capture in it."""
    stem = asf.stem.lower()
    words = set(re.split(r"[^a-z]+", stem)) - {""}
    return stem == asf.parent.name.lower() or bool(words & GENERIC_SKELETONS)


def _visible(root: Path) -> Iterator[Path]:
    """Yield all paths below a folder but hidden ones, and those of which only names are shown."""
    for path in root.rglob("*"):
        is_hidden = any(part.startswith(".") for part in path.relative_to(root).parts)
        if not is_hidden and os.path.lexists(path):
            yield path


def _children(folder: Path) -> list[Path]:
    """Return the contents of a folder; empty if it cannot be read."""
    try:
        return list(folder.iterdir())
    except OSError:
        return []


def _is_deepmimic(path: Path) -> bool:
    """Say whether a file is JSON and names its Frames, or may not be read, which is told later."""
    try:
        with open_file(path) as file:
            start = file.read(_LOOK)
            file.seek(max(0, path.stat().st_size - _LOOK))
            end = file.read(_LOOK)
    except OSError:
        return True
    start = start.removeprefix(b"\xef\xbb\xbf").lstrip()
    return start.startswith(b"{") and (b'"Frames"' in start or b'"Frames"' in end)
