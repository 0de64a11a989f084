"""Files that a browser sends."""

from __future__ import annotations

import errno
import io
from pathlib import Path, PurePosixPath

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from page_serving import Serve
from starlette.testclient import TestClient

from motiondb.page.errors import PageError
from motiondb.page.settings import UploadLimits
from motiondb.page.uploads import Uploads, clean_name


@given(st.text(max_size=80))
def test_a_cleaned_name_stays_below_its_folder(name: str) -> None:
    cleaned = clean_name(name)
    parts = PurePosixPath(cleaned).parts
    assert not cleaned.startswith("/")
    assert not {"..", "."} & set(parts)
    assert not set(cleaned) & set('\\:*?"<>|\0\n')
    folder = Path("/upload")
    assert folder.joinpath(*parts).is_relative_to(folder)


@pytest.mark.parametrize(
    ("name", "cleaned"),
    [
        ("16/16_01.amc", "16/16_01.amc"),
        ("..\\..\\walk.bvh", "walk.bvh"),
        ("/etc/passwd.bvh", "etc/passwd.bvh"),
        ("....//....//x.bvh", "x.bvh"),
        ("läuft.bvh", "läuft.bvh"),
        (".hidden.bvh", "hidden.bvh"),
        ("..", ""),
        ("x" * 200 + ".bvh", "x" * 96 + ".bvh"),
    ],
)
def test_names_are_cleaned(name: str, cleaned: str) -> None:
    assert clean_name(name) == cleaned


def test_kinds_are_told_by_endings_and_others_refused(client: TestClient) -> None:
    names = ["a.bvh", "A.ASF", "words.tsv", "run.exe", "a.bvh", "noending"]
    answer = client.post("/api/uploads", files=[("files", (name, b"x")) for name in names])
    facts = answer.json()
    assert [(f["name"], f["kind"]) for f in facts["files"]] == [
        ("a.bvh", "capture"), ("A.ASF", "skeleton"), ("words.tsv", "sheet"),
    ]  # fmt: skip
    assert [refused["name"] for refused in facts["refused"]] == ["run.exe", "a.bvh", "noending"]
    assert facts["files"][0]["ref"] == f"upload:{facts['upload']}/a.bvh"


@pytest.mark.parametrize("names", [("a.bvh", "A.bvh/b.bvh"), ("a.bvh/b.bvh", "A.bvh")])
def test_a_name_is_that_of_a_file_or_of_a_folder(client: TestClient, names: list[str]) -> None:
    facts = client.post("/api/uploads", files=[("files", (n, b"x")) for n in names]).json()
    assert [file["name"] for file in facts["files"]] == [names[0]]
    assert facts["refused"] == [
        {"name": names[1], "message": "expected a file or a folder of one name, found both."}
    ]


def test_a_name_that_the_system_refuses_is_refused(client: TestClient) -> None:
    files = [("files", (name, b"x")) for name in ("漢" * 99 + ".bvh", "a.bvh")]
    answer = client.post("/api/uploads", files=files)
    assert answer.json()["refused"][0]["message"] == (
        "expected a name that can be stored, found: File name too long."
    )


def test_a_full_disk_is_told_and_keeps_nothing(
    tmp_path: Path, serve: Serve, monkeypatch: pytest.MonkeyPatch
) -> None:
    client = serve(tmp_path / "new.duckdb")

    def write(_path: Path, _mode: str) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "open", write)
    answer = client.post("/api/uploads", files=[("files", ("a.bvh", b"x"))])
    assert answer.status_code == 507
    assert "No space left on device" in answer.json()["error"]["message"]
    assert [*tmp_path.glob("private-*/uploads/*")] == []


def test_an_upload_without_captures_is_refused(client: TestClient) -> None:
    answer = client.post("/api/uploads", files=[("files", ("run.exe", b"MZ"))])
    assert answer.status_code == 415
    assert answer.json()["error"]["message"] == (
        "upload: expected captures or sheets of words, found none."
        " run.exe: expected a capture or a sheet, found another ending."
    )


def test_the_oldest_uploads_are_dropped_when_there_is_too_much(tmp_path: Path) -> None:
    uploads = Uploads(tmp_path, UploadLimits(kept_bytes=10))
    first, second = (uploads.receive([("a.bvh", io.BytesIO(b"x" * 8))]).upload for _ in "ab")
    assert [path.name for path in tmp_path.iterdir()] == [second]
    assert uploads.path(second, "a.bvh").read_bytes() == b"x" * 8
    with pytest.raises(PageError, match="Upload the files again"):
        uploads.path(first)
    with pytest.raises(PageError, match="uploaded file"):
        uploads.path(second, "../a.bvh")


def test_an_uploaded_file_is_an_example_like_a_stored_one(
    client: TestClient, samples_folder: Path
) -> None:
    data = (samples_folder / "ana" / "walk_1.bvh").read_bytes()
    sent = client.post("/api/uploads", files=[("files", ("x/mine.bvh", data))]).json()
    ref = sent["files"][0]["ref"]
    actual = client.get("/api/like", params={"ref": ref, "limit": 1}).json()
    assert actual["matches"][0]["capture"] == "ana/walk_1"
    body = {"items": [{"ref": ref}], "format": "bvh"}
    assert client.post("/api/download", json=body).content.startswith(b"HIERARCHY")


def test_a_download_is_put_onto_an_uploaded_rig_at_a_rate(
    client: TestClient, samples_folder: Path
) -> None:
    data = (samples_folder / "ana" / "walk_1.bvh").read_bytes()
    other = data.replace(b"LeftUpLeg", b"b_l_thigh")
    files = [("files", ("rig.bvh", data)), ("files", ("other.bvh", other))]
    sent = client.post("/api/uploads", files=files).json()
    rig, unknown = (file["ref"] for file in sent["files"])
    body = {"items": [{"ref": "capture:ana/bow_1", "end": 1.0}], "format": "npz", "onto": rig}
    answer = client.post("/api/download", json=body | {"fps": 24.0})
    with np.load(io.BytesIO(answer.content)) as held:
        assert (float(held["fps"]), len(held["time"])) == (24.0, 24)
        assert held["joints"][0] == "Hips"
    assert client.get("/api/joints", params={"ref": rig}).json()["is_known"]
    proposed = client.get("/api/joints", params={"ref": unknown}).json()
    assert not proposed["is_known"]
    assert proposed["roles"]["l_hip"] == "b_l_thigh"
    changed = client.post("/api/download", json=body | {"format": "source"})
    assert changed.status_code == 400
    assert "found source, which is the file as it was added" in changed.json()["error"]["message"]
    stored = client.get("/api/joints", params={"ref": "capture:ana/bow_1"})
    assert "expected an uploaded file, found something else." in stored.json()["error"]["message"]


def test_the_fault_of_an_uploaded_file_does_not_tell_where_it_lies(client: TestClient) -> None:
    sent = client.post("/api/uploads", files=[("files", ("bad.bvh", b"HIERARCHY\nrubbish"))])
    ref = sent.json()["files"][0]["ref"]
    answer = client.get("/api/describe", params={"ref": ref})
    message = answer.json()["error"]["message"]
    assert answer.status_code == 400
    assert message.startswith("bad.bvh:2: expected a keyword such as JOINT or OFFSET")
    assert "/uploads/" not in message


def test_files_that_are_all_too_large_are_told_as_too_large(tmp_path: Path) -> None:
    uploads = Uploads(tmp_path, UploadLimits(file_bytes=10))
    with pytest.raises(PageError) as error:
        uploads.receive([("walk.bvh", io.BytesIO(b"x" * 11))])
    assert error.value.status == 413
    bvh = b"HIERARCHY"
    kept = uploads.receive([("odd.txt", io.BytesIO(bvh)), ("a.bvh", io.BytesIO(bvh))])
    assert [file.name for file in kept.files] == ["a.bvh"]
    assert kept.refused[0].message == (
        "expected DeepMimic's JSON in a file with the ending .txt, found BVH. Let its name end in "
        ".bvh."
    )
