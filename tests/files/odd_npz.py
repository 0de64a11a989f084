"""Odd npz files: of random arrays, with false headers, and a good capture with small changes.

A flipped byte in an npz is found by the checksum of its zip. :func:`mutated_npz` therefore changes
arrays, members and headers before they are packed, so that the reader itself is tried; some of its
files are captures that must be read.
"""

from __future__ import annotations

import io
import struct
import zipfile
from collections.abc import Callable

import numpy as np
from odd_damage import damage

Companions = dict[str, bytes]
Arrays = dict[str, np.ndarray]


def good_arrays(n_frames: int = 12) -> Arrays:
    """A body of SMPL that stands, turns slowly and bends an elbow; z is up, 60 frames a second."""
    time = np.arange(n_frames) / 60.0
    poses = np.zeros((n_frames, 156))
    poses[:, 0] = np.pi / 2
    poses[:, 54 + 1] = 0.3 + time
    poses[:, 3 * 4] = 0.2 * np.sin(time)
    trans = np.stack([0.5 * time, np.zeros(n_frames), np.full(n_frames, 1.1)], axis=1)
    return {
        "poses": poses,
        "trans": trans,
        "mocap_framerate": np.array(60.0),
        "gender": np.array("female"),
        "betas": np.zeros(16),
    }


def packed(members: dict[str, bytes], how: int = zipfile.ZIP_STORED) -> bytes:
    """Zip members under their names, without times."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", how) as file:
        for name, content in members.items():
            file.writestr(zipfile.ZipInfo(name), content, compress_type=how)
    return buffer.getvalue()


def as_member(array: np.ndarray) -> bytes:
    """The content of an npy file."""
    buffer = io.BytesIO()
    np.save(buffer, array)
    return buffer.getvalue()


def mutated_npz(rng: np.random.Generator) -> tuple[str, bytes, Companions]:
    """Change a good capture in one to three places, then pack it."""
    arrays = good_arrays()
    for _ in range(int(rng.integers(1, 4))):
        CHANGES[int(rng.integers(len(CHANGES)))](arrays, rng)
    members = {f"{name}.npy": as_member(array) for name, array in arrays.items()}
    if rng.random() < 0.3 and members:  # the header and the data of a member, checksum of the new
        name = sorted(members)[int(rng.integers(len(members)))]
        members[name] = damage(members[name], rng)
    how = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)[int(rng.integers(2))]
    data = packed(members, how)
    return ".npz", damage(data, rng) if rng.random() < 0.1 else data, {}


def _any(arrays: Arrays, rng: np.random.Generator) -> str:
    """Name of an array; the names that the reader needs are drawn more often."""
    needed = [name for name in ("poses", "trans", "mocap_framerate") if name in arrays]
    names = needed * 2 + sorted(arrays)
    return names[int(rng.integers(len(names)))] if names else ""


def _change_type(arrays: Arrays, rng: np.random.Generator) -> None:
    """Another type of numbers, another byte order, or the order of columns."""
    name = _any(arrays, rng)
    if not name or arrays[name].dtype.kind not in "iuf":
        return
    kinds = ("<f4", ">f8", ">f4", "<f2", "<i4", "<i8", "<u2", "<c16", "?")
    kind = kinds[int(rng.integers(len(kinds)))]
    with np.errstate(all="ignore"):
        changed = arrays[name].astype(kind)
    arrays[name] = np.asfortranarray(changed) if rng.random() < 0.3 else changed


def _change_number(arrays: Arrays, rng: np.random.Generator) -> None:
    """One number becomes another, perhaps none."""
    name = _any(arrays, rng)
    if not name or arrays[name].dtype.kind not in "iuf" or not arrays[name].size:
        return
    values = (np.nan, np.inf, -np.inf, 1e308, -1e200, 1e-320, 0.0, 1.0, 0.01, -0.3)
    with np.errstate(all="ignore"):
        arrays[name].reshape(-1)[int(rng.integers(arrays[name].size))] = (
            values[int(rng.integers(len(values)))]
            if arrays[name].dtype.kind == "f"
            else int(rng.integers(2))
        )


def _cut_frames(arrays: Arrays, rng: np.random.Generator) -> None:
    """Fewer frames, in all arrays or in one."""
    keep = int(rng.integers(0, 12))
    if rng.random() < 0.7:
        for name in {"poses", "trans"} & set(arrays):
            arrays[name] = arrays[name][:keep]
    elif name := _any(arrays, rng):
        arrays[name] = arrays[name][:keep] if arrays[name].ndim else arrays[name]


def _cut_columns(arrays: Arrays, rng: np.random.Generator) -> None:
    """Poses of fewer joints, mostly of the usual numbers."""
    if "poses" in arrays and arrays["poses"].ndim == 2:
        widths = (66, 72, 165, 63, 65, int(rng.integers(0, 157)))
        arrays["poses"] = arrays["poses"][:, : widths[int(rng.integers(len(widths)))]]


def _reshape(arrays: Arrays, rng: np.random.Generator) -> None:
    """Three numbers a joint on an axis of their own, one axis more, or one less."""
    name = _any(arrays, rng)
    if not name:
        return
    array = arrays[name]
    if array.ndim == 2 and array.shape[1] % 3 == 0 and rng.random() < 0.6:
        arrays[name] = array.reshape(len(array), array.shape[1] // 3, 3)
    else:
        arrays[name] = array[None] if rng.random() < 0.5 else array.reshape(-1)


def _rename(arrays: Arrays, rng: np.random.Generator) -> None:
    """Another usual name, an unknown one, or none."""
    names = {"mocap_framerate": ("fps", "mocap_frame_rate", "frame_rate")}
    name = _any(arrays, rng)
    if not name:
        return
    usual = names.get(name, (f"{name} ",))
    array = arrays.pop(name)
    if rng.random() < 0.8:
        arrays[usual[int(rng.integers(len(usual)))]] = array


def _split_poses(arrays: Arrays, _rng: np.random.Generator) -> None:
    """Root and body apart, as newer files have them."""
    if "poses" in arrays and arrays["poses"].ndim == 2:
        poses = arrays.pop("poses")
        arrays["root_orient"], arrays["pose_body"] = poses[:, :3], poses[:, 3:66]


def _change_rate(arrays: Arrays, rng: np.random.Generator) -> None:
    """Another frame rate, often a usable one."""
    if "mocap_framerate" in arrays:
        rates = (30, 120.0, 59.94, [100.0], [[60.0]], np.float32(250), 1.0, 2000, _rate(rng))
        value = rates[int(rng.integers(len(rates)))]
        array = np.array(value)
        arrays["mocap_framerate"] = array if array.dtype != object else np.array("none")


def _add_array(arrays: Arrays, rng: np.random.Generator) -> None:
    """An array that is not needed."""
    extra = (np.zeros((3, 3)), np.array("text"), rng.normal(size=40), np.zeros(0), np.array(True))
    name = ("dmpls", "labels", "extra/poses", "poses2")[int(rng.integers(4))]
    arrays[name] = extra[int(rng.integers(len(extra)))]


CHANGES: tuple[Callable[[Arrays, np.random.Generator], None], ...] = (
    _change_type, _change_number, _cut_frames, _cut_columns, _reshape, _rename, _split_poses,
    _change_rate, _add_array,
)  # fmt: skip


def odd_npz(rng: np.random.Generator) -> tuple[str, bytes, Companions]:
    """Build an npz with arrays of odd types and shapes, then perhaps damage its bytes."""
    n_frames = int(rng.integers(0, 6))
    kinds = ("f8", "f4", "f2", "i4", "u1", "?", "c16", "M8[s]", "m8[s]", "U3", "S5")
    arrays: dict[str, object] = {
        "poses": _array(rng, (n_frames, 66), kinds),
        "trans": _array(rng, (n_frames, 3), kinds),
        str(rng.choice(["fps", "mocap_framerate", "mocap_frame_rate"])): _rate(rng),
    }
    if rng.random() < 0.2:
        arrays["root_orient"] = _array(rng, (n_frames, 3), kinds)
        arrays["pose_body"] = _array(rng, (n_frames, 63), kinds)
        del arrays["poses"]
    if rng.random() < 0.1:
        arrays["poses"] = np.array([{}] * 3, dtype=object)
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)  # odd values on purpose
    data = buffer.getvalue()
    return ".npz", damage(data, rng) if rng.random() < 0.4 else data, {}


def strange_npz(rng: np.random.Generator) -> tuple[str, bytes, Companions]:
    """Build an npz that unpacks to much, or whose headers say what is not there."""
    headers = (
        "{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000, 66), }",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (-1, 66), }",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (" + "9" * 5000 + ",), }",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (" + "(" * 300 + ")" * 300 + "), }",
        "{'descr': '|O', 'fortran_order': False, 'shape': (1,), }",
        "{'descr': '|V0', 'fortran_order': False, 'shape': (1000000000,), }",
        "{'descr': '<U0', 'fortran_order': False, 'shape': (1000000000, 66), }",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 66), ",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (0, 66), }",
        "'" * 3,
        "(" * 200,
    )
    size = int(10 ** rng.uniform(3, 8.7)) if rng.random() < 0.05 else 1000
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as file:
        for name in ("poses", "trans", "fps"):
            text = headers[int(rng.integers(len(headers)))].encode() + b"\n"
            version = bytes([int(rng.integers(0, 5)), 0])
            length = struct.pack("<H" if version[0] == 1 else "<I", len(text) % 65536)
            content = b"\x93NUMPY" + version + length + text + bytes(size)
            info = zipfile.ZipInfo(f"{name}.npy")  # without a time, so that a case stays the same
            file.writestr(info, content, compress_type=zipfile.ZIP_DEFLATED)
    return ".npz", buffer.getvalue(), {}


def _array(rng: np.random.Generator, shape: tuple[int, ...], kinds: tuple[str, ...]) -> object:
    """Make an array of an odd type or shape; most are ordinary."""
    values = rng.normal(size=shape)
    if rng.random() < 0.3:
        values.reshape(-1)[:2] = rng.choice([np.nan, np.inf, 1e308, -1e200, 0.0])
    if rng.random() < 0.2:
        values = values.reshape(-1)[: int(rng.integers(1, 9))]
    if rng.random() < 0.2:
        values = values[None]
    kind = str(rng.choice(kinds)) if rng.random() < 0.4 else "f8"
    with np.errstate(all="ignore"):
        return np.abs(values).astype("i8").astype(kind) if kind[0] in "Mm" else values.astype(kind)


def _rate(rng: np.random.Generator) -> object:
    """Make a frame rate, often none."""
    rates: tuple[object, ...] = (
        30.0, 120, np.array([60]), np.array([]), np.array([30, 60]), np.nan, np.inf, -1.0, 1e300,
        "fast", np.array(None, dtype=object), np.datetime64("2020-01-01"), 1 + 2j, b"60", True,
    )  # fmt: skip
    return rates[int(rng.integers(len(rates)))]
