"""Arrays by name in .npz, .npy and .pkl files, without running code from the file.

npz and npy: sizes and types are checked before any array is unpacked, because a few kilobytes of
compressed zeros can unpack to gigabytes. Arrays of objects are refused.

pkl: Python's own unpickler may call anything. This one makes dictionaries, lists, tuples, numbers,
texts and NumPy arrays of numbers and texts, and refuses everything else by its name. NumPy's own
way of restoring an array is not used either, since it believes the state that the file gives.
Files of joblib are pickles, whole or compressed, in which the bytes of an array stand behind what
tells its type; an npy of a dictionary has a pickle behind its header.

Source: joblib, ``numpy_pickle.py`` (BSD), for where the bytes stand.
"""

from __future__ import annotations

import io
import math
import pickle
import re
import struct
import warnings
import zipfile
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from motiondb.errors import CaptureError
from motiondb.files.text import quoted
from motiondb.records import BoolArray

RATES = (
    *("mocap_framerate", "mocap_frame_rate", "fps", "framerate", "frame_rate", "frequency"),
    *("mocap_fps", "motion_fps", "sample_rate", "sampling_rate"),
)
"""Names of the frame rate."""
_UNPACKED, _RATIO = 256_000_000, 20
"""Bytes to which the arrays of a file may unpack, or this multiple of the file's size if that is
more. An hour of poses at 60 frames a second takes 270 MB, and compressed motion has at least a
third of its size; compressed zeros have a thousandth."""
_NESTED = 2  # Dictionaries within one another that are looked into
_NO_NPZ = "expected an npz file of plain arrays, found something else. Save it again."

Arrays = dict[str, NDArray[np.generic]]


def load_npz(
    data: bytes, path: object, wanted: Sequence[str] | None = None
) -> tuple[Arrays, tuple[str, ...]]:
    """Return arrays of an npz file by name, and the names of all; `wanted`: None for all."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as file:
            named = {info.filename.removesuffix(".npy"): info for info in file.infolist()}
            members = {n: i for n, i in named.items() if wanted is None or n in wanted}
            _check_unpacked(sum(info.file_size for info in members.values()), len(data), path)
            found = {}
            for name, info in members.items():
                with file.open(info) as member:
                    shape, dtype = _header(member)
                if wanted is None and dtype.hasobject:
                    continue  # such as an object of a simulator beside the motion
                _check_header(shape, dtype, info.file_size)
                with file.open(info) as member:
                    found[name] = _values(member)
            return found, tuple(named)
    except CaptureError:
        raise
    except Exception as error:  # zipfile and NumPy raise some sixteen kinds for other files
        raise CaptureError(path, _NO_NPZ) from error


def npz_names(data: bytes, path: object) -> tuple[str, ...]:
    """Return the names of the arrays of an npz file."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as file:
            return tuple(name.removesuffix(".npy") for name in file.namelist())
    except Exception as error:
        raise CaptureError(path, _NO_NPZ) from error


def load_npy(data: bytes, path: object) -> Arrays:
    """Return the array of an npy file as "positions", or those of the dictionary in one."""
    try:
        file = io.BytesIO(data)
        shape, dtype = _header(file)
        if dtype.hasobject:
            return load_pickle(data[file.tell() :], path)
        _check_header(shape, dtype, len(data))
        return {"positions": _values(io.BytesIO(data))}
    except CaptureError:
        raise
    except Exception as error:
        raise CaptureError(
            path, "expected an npy file of numbers, found something else. Save it again."
        ) from error


def texts_of(array: NDArray[np.generic]) -> tuple[str, ...]:
    """Return the texts of an array, which some programs save as bytes."""
    return tuple(
        text.decode("utf-8", "replace") if isinstance(text, bytes) else str(text) for text in array
    )


def as_numbers(array: NDArray[np.generic]) -> NDArray[np.generic]:
    """Return an array of texts that are numbers, as some programs save a rate, as numbers.

    >>> as_numbers(np.array(["30"])), as_numbers(np.array(b"29.97")), as_numbers(np.array("x"))
    (array([30.]), array(29.97), array('x', dtype='<U1'))
    """
    try:
        return array.astype(float) if array.dtype.kind in "US" else array
    except ValueError:
        return array


def frames_left_out(
    good: BoolArray, path: object, skip_bad: bool, expected: str, found: str
) -> tuple[str, ...]:
    """Refuse bad frames, or say in a note that they are left out; `good` (frames,)."""
    if good.all():
        return ()
    count, first = int((~good).sum()), int(np.argmin(good))
    if not skip_bad or not good.any():
        raise CaptureError(
            path,
            f"expected {expected}, found {found} in {count} frames, the first is {first}. "
            "Export it again, or pass --skip-bad-frames to leave them out.",
        )
    return (f"Left out {count} bad frames; the first is {first}.",)


def npy_shape(start: bytes) -> tuple[int, ...] | None:
    """Return the shape that the start of an npy file tells; () for other files, None for objects.

    Objects may be a dictionary of arrays.
    """
    try:
        shape, dtype = _header(io.BytesIO(start))
    except Exception:
        return ()
    return None if dtype.hasobject else shape if dtype.kind in "iuf" else ()


def inflated(data: bytes, path: object = "") -> bytes:
    """Return a file that zlib or gzip compressed as it was, or its beginning if it is cut.

    Without `path`, of the beginning of a file, less is unpacked: zeros have a thousandth.

    >>> inflated(zlib.compress(b"abc")), inflated(b"abc")
    (b'abc', b'abc')
    """
    if data[:2] not in (b"\x78\x01", b"\x78\x5e", b"\x78\x9c", b"\x78\xda", b"\x1f\x8b"):
        return data
    most = max(_UNPACKED if path else 0, _RATIO * len(data))
    reader = zlib.decompressobj(wbits=47)
    try:
        whole = reader.decompress(data, most + 1)
    except zlib.error:
        return data
    if path:
        _check_unpacked(len(whole), len(data), path)
    return whole


def _check_unpacked(unpacked: int, packed: int, path: object) -> None:
    most = max(_UNPACKED, _RATIO * packed)
    if unpacked > most:
        raise CaptureError(
            path,
            f"expected arrays of at most {most / 1e6:.4g} MB, found {unpacked / 1e6:.4g} MB packed "
            f"into {packed / 1e6:.4g} MB. Save the motion again, without other data.",
        )


def _header(member: Any) -> tuple[tuple[int, ...], np.dtype[Any]]:  # noqa: ANN401  a file
    """Read the shape and the type of an array."""
    version = npy.read_magic(member)
    read_header = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
    with warnings.catch_warnings():  # odd headers make Python's parser warn beside its errors
        warnings.simplefilter("ignore", SyntaxWarning)
        shape, _, dtype = read_header(member)
    return shape, dtype


def _check_header(shape: tuple[int, ...], dtype: np.dtype[Any], size: int) -> None:
    """Refuse a header that promises more than there is, or objects (ValueError)."""
    if dtype.hasobject or any(length < 0 for length in shape):
        raise ValueError("objects, or a negative length")
    if math.prod(shape) * dtype.itemsize > size or math.prod(shape) > size:
        raise ValueError("less data than the header says")


def _values(member: Any) -> NDArray[np.generic]:  # noqa: ANN401  a file
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SyntaxWarning)
        return np.asarray(npy.read_array(member, allow_pickle=False))


# Pickles


class _Type:
    """The type of an array while it is read: a code such as "f8", and its byte order."""

    __slots__ = ("code", "order")

    def __init__(self, code: object) -> None:
        self.code = code.decode() if isinstance(code, bytes) else str(code)
        self.order = "="
        if not re.fullmatch(r"[<>=|]?([biufc?]\d{0,2}|[SU]\d{1,4}|O8?)", self.code):
            raise pickle.UnpicklingError(f"an array of type {self.code[:40]!r}")

    def restore(self, state: Any) -> None:  # noqa: ANN401  from a file
        self.order = str(state[1]) if str(state[1]) in "<>=|" else "="

    def dtype(self) -> np.dtype[Any]:
        return np.dtype((self.order if self.order in "<>" else "") + self.code.lstrip("<>=|"))


class _Array:
    """An array while it is read; one of objects is a list, or the only one of them."""

    __slots__ = ("value",)

    def __init__(self) -> None:
        self.value: Any = np.zeros(0)

    def restore(self, state: Any) -> None:  # noqa: ANN401  from a file
        _, shape, dtype, is_fortran, content = state
        if isinstance(content, list):
            self.value = content[0] if shape == () and len(content) == 1 else content
        else:
            self.value = _from_bytes(content, dtype, shape, "F" if is_fortran else "C")


class _Behind(_Array):
    """An array of joblib, whose bytes stand behind its type."""

    __slots__ = ()

    def read(self, state: Any, read: Callable[[int], bytes], most: int) -> None:  # noqa: ANN401
        if state.get("numpy_array_alignment_bytes") is not None:
            read(read(1)[0])
        dtype, shape = state["dtype"], tuple(int(n) for n in state["shape"])
        size = math.prod(shape) * dtype.dtype().itemsize
        if not 0 <= size <= most:
            raise EOFError
        self.value = _from_bytes(read(size) if size else b"", dtype, shape, state["order"])


def _from_bytes(content: Any, dtype: Any, shape: Any, order: Any = "C") -> NDArray[np.generic]:  # noqa: ANN401
    """Return the array whose bytes a file gives; those of Python 2 are a text."""
    if isinstance(content, str):
        content = content.encode("latin-1")
    if not isinstance(content, bytes | bytearray) or not isinstance(dtype, _Type):
        raise pickle.UnpicklingError("an array of objects")
    values = np.frombuffer(bytes(content), dtype.dtype())
    return values.reshape(tuple(int(n) for n in shape), order="F" if order == "F" else "C")


class _Maker:
    """Something that a pickle may call."""

    __slots__ = ("_make",)

    def __init__(self, make: Callable[..., Any]) -> None:
        self._make = make

    def __call__(self, *args: Any) -> Any:  # noqa: ANN401  from a file
        return self._make(*args)


def _scalar(dtype: Any, content: Any = b"") -> Any:  # noqa: ANN401  from a file
    return _from_bytes(content, dtype, (1,))[0]


def _bytes(content: Any) -> bytes:  # noqa: ANN401  from a file
    """Return bytes as bytes; of a number, Python would make as many zeros."""
    if not isinstance(content, bytes):
        raise pickle.UnpicklingError("a bytearray of no bytes")
    return content


_CORE = ("numpy._core", "numpy.core")
_MADE: dict[str, Callable[..., Any]] = {
    **{f"{core}.multiarray._reconstruct": lambda *_: _Array() for core in _CORE},
    **{f"{core}.multiarray.scalar": _scalar for core in _CORE},
    **{f"{core}.numeric._frombuffer": _from_bytes for core in _CORE},
    "numpy.ndarray": lambda *_: _Array(),
    "joblib.numpy_pickle.NumpyArrayWrapper": lambda *_: _Behind(),
    "numpy.dtype": lambda code, *_: _Type(code),
    "_codecs.encode": lambda text, *_: str(text).encode("latin-1"),
    "collections.OrderedDict": lambda pairs=(): dict(pairs),
    "builtins.bytearray": lambda content=b"", *_: _bytes(content),
}


_InPython: Any = pickle._Unpickler  # its memo is a dictionary


class _PlainUnpickler(_InPython):
    """Makes plain containers and arrays, and nothing else."""

    dispatch: ClassVar[Any] = dict(_InPython.dispatch)

    stack: list[Any]
    read: Callable[[int], bytes]
    append: Callable[[Any], None]

    def __init__(self, data: bytes) -> None:
        super().__init__(io.BytesIO(data), encoding="latin-1")  # texts of Python 2 are bytes
        self.n_bytes = len(data)

    def find_class(self, module: str, name: str) -> Any:  # noqa: ANN401
        made = _MADE.get(f"{module}.{name}")
        if made is None:
            raise pickle.UnpicklingError(f"{module}.{name}")
        return _Maker(made)

    def new(self) -> None:
        args, made = self.stack.pop(), self.stack.pop()
        if not isinstance(made, _Maker) or args != ():
            raise pickle.UnpicklingError("an object")
        self.append(made())

    def restore(self) -> None:
        state, made = self.stack.pop(), self.stack[-1]
        if isinstance(made, _Behind):
            made.read(state, self.read, self.n_bytes)
        elif isinstance(made, _Array | _Type):
            made.restore(state)
        else:
            raise pickle.UnpicklingError("an object with a state")

    def bytearray_of(self) -> None:
        (length,) = struct.unpack("<Q", self.read(8))
        if length > self.n_bytes:
            raise EOFError
        self.append(self.read(length))

    dispatch[pickle.BUILD[0]] = restore
    dispatch[pickle.BYTEARRAY8[0]] = bytearray_of
    dispatch[pickle.NEWOBJ[0]] = new
    for _code in (pickle.INST, pickle.OBJ, pickle.NEWOBJ_EX, pickle.EXT1):
        dispatch.pop(_code[0])
    for _code in (pickle.EXT2, pickle.EXT4, pickle.PERSID, pickle.BINPERSID, pickle.NEXT_BUFFER):
        dispatch.pop(_code[0])


def load_pickle(data: bytes, path: object) -> Arrays:
    """Return the arrays, numbers and lists of texts in the dictionary of a pickle."""
    try:
        found = _PlainUnpickler(data).load()
        if isinstance(found, _Array):
            found = found.value
    except pickle.UnpicklingError as error:
        raise CaptureError(
            path,
            "expected a pickle of plain arrays, numbers and texts, found "
            f"{quoted(str(error), 120)}, which is not made. Save the arrays as npz.",
        ) from None
    except MemoryError:
        raise
    except Exception as error:  # an unpickler raises some ten kinds for other files
        is_cut = isinstance(error, EOFError | IndexError | struct.error)
        what = "one that is cut short" if is_cut else "other content"
        raise CaptureError(
            path, f"expected a pickle of plain arrays, found {what}. Save the arrays as npz."
        ) from None
    if isinstance(found, list) and len(found) == 1:
        found = found[0]
    if isinstance(found, dict) and len(found) == 1 and isinstance(next(iter(found.values())), dict):
        found = next(iter(found.values()))
    if not isinstance(found, dict):
        raise CaptureError(
            path, f"expected a dictionary of arrays, found a {type(found).__name__}. Save one."
        )
    found = found.get("smpl_params_global", found)  # of GVHMR, beside those in the camera
    if found and all(isinstance(value, dict) for value in found.values()):
        raise CaptureError(
            path, f"expected one motion, found {len(found)}. Save each in a file of its own."
        )
    budget = _Budget(len(data), max(_UNPACKED, _RATIO * len(data)))
    names = {k: k.decode("latin-1") if isinstance(k, bytes) else str(k) for k in found}  # Python 2
    values = {names[k][:100]: v for k, v in found.items() if v is not None}
    for _ in range(_NESTED):  # an array within a dictionary is called as both
        values = {
            f"{name}.{inner}" if inner else name: each
            for name, value in values.items()
            for inner, each in (value.items() if isinstance(value, dict) else [("", value)])
        }
    made = {str(name)[:100]: _plain(value, budget, path) for name, value in values.items()}
    return {name: value for name, value in made.items() if value is not None}


@dataclass
class _Budget:
    """What the lists of a pickle may still have: a file may name one list or array many times."""

    parts: int
    n_bytes: int  # Of the arrays that are made of lists; a long text makes all in its list long


def _plain(value: object, budget: _Budget, path: object) -> NDArray[np.generic] | None:
    """Return a value as an array; None for what is none, such as a dictionary."""
    if isinstance(value, _Array):
        value = value.value
    if isinstance(value, np.ndarray | np.generic):
        return np.asarray(value)
    if isinstance(value, bool | int | float | str):
        return np.asarray(value) if not isinstance(value, int) or abs(value) < 2**63 else None
    if not isinstance(value, list | tuple):
        return None
    budget.parts -= len(value)
    if budget.parts < 0:
        raise CaptureError(
            path, "expected lists that the file holds once, found repeated ones. Save arrays."
        )
    parts = [_plain(part, budget, path) for part in value]
    shapes = {part.shape for part in parts if part is not None}
    kinds = {part.dtype.kind in "US" for part in parts if part is not None}
    if any(part is None for part in parts) or len(shapes) > 1 or len(kinds) > 1 or not parts:
        return None
    known = [part for part in parts if part is not None]
    budget.n_bytes -= len(known) * max(part.nbytes for part in known)
    if budget.n_bytes < 0:
        raise CaptureError(
            path, "expected lists that fit into memory, found larger ones. Save arrays."
        )
    return np.stack(known)
