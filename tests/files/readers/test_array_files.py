"""Pickles make plain arrays and nothing else."""

import pickle
import pickletools
import struct
import zlib
from collections import OrderedDict
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motiondb.errors import CaptureError
from motiondb.files.readers.array_files import inflated, load_npy, load_pickle


@pytest.mark.parametrize("protocol", range(2, 6))
def test_arrays_numbers_and_texts_are_read_as_they_were_saved(protocol: int) -> None:
    given: dict[str, Any] = {
        "a": np.arange(6.0).reshape(2, 3),
        "b": np.asfortranarray(np.arange(6, dtype=np.int16).reshape(2, 3)),
        "c": np.arange(3, dtype=">f4"),
        "d": np.array(["x", "yz"]),
        "e": np.float32(2.5),
        "f": [1, 2.5],
        "g": ("u", "v"),
        "h": 30,
    }
    found = load_pickle(pickle.dumps(OrderedDict(given), protocol), "f")
    for name, value in given.items():
        np.testing.assert_array_equal(found[name], np.asarray(value))


def test_anything_else_is_refused_by_its_name_and_not_made(tmp_path: Path) -> None:
    class Opens:
        def __reduce__(self) -> tuple[Any, ...]:
            return (open, (str(tmp_path / "made"), "w"))

    for value, name in (
        (Fraction(1, 2), "fractions.Fraction"),
        (Opens(), "io.open"),
        (Path("a"), "pathlib.PosixPath"),
        (np.array([Fraction(1)]), "fractions.Fraction"),
        (len, "builtins.len"),
    ):
        with pytest.raises(CaptureError) as error:
            load_pickle(pickle.dumps({"a": value}), "f")
        assert f"found '{name}" in str(error.value).replace('found "', "found '")
    assert not (tmp_path / "made").exists()


def test_dictionaries_of_numpy_joblib_and_python_2_are_read(tmp_path: Path) -> None:
    joblib = pytest.importorskip("joblib")
    values, names = np.arange(6.0).reshape(2, 3), ["a", "b"]
    given = {"v": values, "f": np.asfortranarray(values), "names": names, "one": np.float32(2.5)}
    np.save(tmp_path / "a.npy", {**given, "rows": list(values)}, allow_pickle=True)  # type: ignore[arg-type]
    found = [load_npy((tmp_path / "a.npy").read_bytes(), "f")]
    np.testing.assert_array_equal(found[0]["rows"], values)
    for compress in (0, 3, ("gzip", 3)):
        joblib.dump({"walk": given}, tmp_path / "a.pkl", compress=compress)
        found.append(load_pickle(inflated((tmp_path / "a.pkl").read_bytes(), "f"), "f"))
    found.append(load_pickle(pickle.dumps({k.encode(): v for k, v in given.items()}, 2), "f"))
    for each in found:
        for name, value in given.items():
            np.testing.assert_array_equal(each[name], np.asarray(value))


PYTHON_2 = (  # {"v": 2 x 2 floats, "names": ["a"]} of protocol 2, in texts of bytes
    b"\x80\x02}(U\x01vcnumpy.core.multiarray\n_reconstruct\ncnumpy\nndarray\nK\x00\x85U\x01b\x87R"
    b"(K\x01K\x02K\x02\x86cnumpy\ndtype\nU\x02f8K\x00K\x01\x87R(K\x03U\x01<NNNJ\xff\xff\xff\xff"
    b"J\xff\xff\xff\xffK\x00tb\x89U\x20%btbU\x05names]U\x01aau."
)
WITHOUT_PROTOCOL = (  # As Python 2 saves by default
    b"(dp0\nS'v'\np1\ncnumpy.core.multiarray\n_reconstruct\np2\n(cnumpy\nndarray\np3\n(I0\ntp4\nS'b'"
    b"\np5\ntp6\nRp7\n(I1\n(I2\nI2\ntp8\ncnumpy\ndtype\np9\n(S'f8'\np10\nI0\nI1\ntp11\nRp12\n(I3\n"
    b"S'<'\np13\nNNNI-1\nI-1\nI0\ntp14\nbI00\nS%b\np15\ntp16\nbsS'names'\np17\n(lp18\nS'a'\np19\nas."
)


def test_texts_of_python_2_are_the_bytes_of_arrays() -> None:
    values = np.array([[-3.0, 0.1], [2.5, np.pi]])
    octets = values.tobytes()
    for data in (PYTHON_2 % octets, WITHOUT_PROTOCOL % repr(octets)[1:].encode()):
        found = load_pickle(data, "f")
        np.testing.assert_array_equal(found["v"], values)
        assert found["names"].tolist() == ["a"]


def test_small_files_make_no_large_arrays() -> None:
    row = np.zeros(5_000)

    class Zeros:
        def __reduce__(self) -> object:
            return bytearray, (10**12,)

    for value, said in (
        ([row] * 20_000, "expected lists that fit into memory"),
        (["a" * 9_000, *"b" * 20_000], "expected lists that fit into memory"),
        ([Zeros()], "a bytearray of no bytes"),
    ):
        with pytest.raises(CaptureError, match=said):
            load_pickle(pickle.dumps({"x": value}), "f")


def test_what_joblib_promises_and_the_file_has_not_is_refused(tmp_path: Path) -> None:
    joblib = pytest.importorskip("joblib")
    joblib.dump({"v": np.zeros((100, 100))}, tmp_path / "a.pkl")
    data = (tmp_path / "a.pkl").read_bytes()
    for broken in (data[:-400], data.replace(b"K\x64K\x64", b"K\xffK\xff")):
        with pytest.raises(CaptureError, match="expected a pickle of plain arrays"):
            load_pickle(broken, "f")
    with pytest.raises(CaptureError, match="packed"):
        inflated(zlib.compress(bytes(300_000_000), 1), "f")


def test_states_that_a_file_invents_reach_no_object() -> None:
    dtype = pickle.dumps(np.dtype("f8"), 2)
    assert b"\x86" in dtype or b"(" in dtype
    changed = b"\x80\x02cnumpy\ndtype\n}X\x01\x00\x00\x00aK\x01sb."
    for data in (changed, b"\x80\x02}}X\x01\x00\x00\x00aK\x01sb."):
        with pytest.raises(CaptureError, match="an object with a state"):
            load_pickle(data, "f")


def test_repeated_lists_do_not_grow_without_end() -> None:
    lists: list[Any] = [1.0] * 10
    for _ in range(30):
        lists = [lists] * 10
    with pytest.raises(CaptureError, match="found repeated ones"):
        load_pickle(pickle.dumps({"a": lists}), "f")


def test_cut_and_lying_files_are_refused() -> None:
    whole = pickle.dumps({"a": np.arange(100.0)}, 5)
    for length in range(len(whole)):
        with pytest.raises(CaptureError):
            load_pickle(whole[:length], "f")
    promised = b"\x80\x05" + pickle.BYTEARRAY8 + struct.pack("<Q", 2**40) + b"."
    with pytest.raises(CaptureError, match="cut short"):
        load_pickle(promised, "f")
    ops = {op.name for op, _, _ in pickletools.genops(whole)}
    assert "BYTEARRAY8" in ops  # which the loader bounds by the size of the file


def test_arrays_of_objects_and_short_arrays_are_refused() -> None:
    import io

    file = io.BytesIO()
    np.save(file, np.array([{}, 1]), allow_pickle=True)
    with pytest.raises(CaptureError, match="expected a dictionary of arrays, found a list"):
        load_npy(file.getvalue(), "f")
    file = io.BytesIO()
    np.save(file, np.zeros((10, 22, 3)))
    with pytest.raises(CaptureError, match="expected an npy file of numbers"):
        load_npy(file.getvalue()[:-8], "f")
