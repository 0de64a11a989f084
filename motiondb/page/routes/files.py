"""Routes of motion: uploads, downloads, binary for the player, thumbnails for tables."""

from __future__ import annotations

import io
import re
import tempfile
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from fastapi import APIRouter, Query, Request
from fastapi.concurrency import run_in_threadpool
from pydantic import Field
from starlette.datastructures import UploadFile
from starlette.exceptions import HTTPException
from starlette.formparsers import MultiPartException
from starlette.responses import Response

from motiondb.answers.plain import extended
from motiondb.body.features import FEATURE_STEP
from motiondb.database import MotionDB
from motiondb.database.catalogue.exporting import MotionChanges, write_motion
from motiondb.database.catalogue.parts import cut_motion
from motiondb.errors import MotionDBError
from motiondb.files.limits import MAX_FPS, MIN_FPS
from motiondb.files.own_files import PROVENANCE, provenance_path
from motiondb.files.rigs import JointProposal, propose_joints
from motiondb.page import state
from motiondb.page.errors import ERRORS, PageError
from motiondb.page.motion import (
    MEDIA_TYPE,
    POINTS,
    Track,
    best_moment,
    body_track,
    facing_forward,
    pack,
    points_of,
)
from motiondb.page.routes.parameters import LONGEST_TEXT, Body, End, Part, RefText, Start, Text
from motiondb.page.state import Page
from motiondb.page.uploads import UploadReply
from motiondb.records import MOTION_FPS, Caption, CaptureInfo
from motiondb.store import load_motion as load_stored

_PLAIN = re.compile(r"[^A-Za-z0-9._-]+")
_TYPES = {".zip": "application/zip", ".glb": "model/gltf-binary"}
LICENCES = "LICENCES.txt"  # In a zip: the licence of each capture, as BVH has no place for it
MOST_ITEMS = 500  # Largest number of captures of one download
Format = Literal["bvh", "glb", "fbx", "usd", "npz", "csv", "parquet", "source"]
_SCENE_FORMATS = ("bvh", "glb", "source")
_BYTES = {"type": "string", "format": "binary"}
_FORM = {
    "type": "object",
    "required": ["files"],
    "properties": {"files": {"type": "array", "minItems": 1, "items": _BYTES}},
}
_UPLOAD = {"requestBody": {"required": True, "content": {"multipart/form-data": {"schema": _FORM}}}}
"""OpenAPI description of an upload."""


def described(about: str, *kinds: str) -> dict[int | str, dict[str, Any]]:
    """Return the OpenAPI description of an answer of bytes, of any of some kinds."""
    return {200: {"description": about, "content": {k: {"schema": _BYTES} for k in kinds}}}


_FILE = described(
    "A file to be saved: a motion, or a zip of several.",
    *("application/octet-stream", "application/zip", "model/gltf-binary"),
)


class DownloadBody(Body):
    """What to download, in which format, at which rate, and onto which uploaded rig.

    `alone`: Without the origin of generated motions in files beside them.
    """

    items: Annotated[list[Part], Field(min_length=1, max_length=MOST_ITEMS)]
    format: Format = "bvh"
    canonical: bool = False
    alone: bool = False
    fps: Annotated[float, Field(ge=MIN_FPS, le=MAX_FPS, allow_inf_nan=False)] | None = None
    onto: Text | None = None


def router(page: Page) -> APIRouter:
    """Return the routes of files."""
    routes = APIRouter(tags=["files"], responses=ERRORS)

    @routes.post("/api/uploads", openapi_extra=_UPLOAD)
    async def upload(request: Request) -> UploadReply:
        """Receive captures and sheets of words, without adding them to the database."""
        limits = page.settings.limits
        try:
            form = await request.form(max_files=limits.files, max_fields=10)
        except (HTTPException, MultiPartException) as error:
            said = getattr(error, "detail", None) or str(error)
            raise PageError(f"upload: expected files as a form has them, found: {said}") from None
        try:
            items = [item for _, item in form.multi_items() if isinstance(item, UploadFile)]
            files = [(item.filename or "", item.file) for item in items]
            return await run_in_threadpool(page.uploads.receive, files)
        finally:
            await form.close()

    @routes.get("/api/download", response_class=Response, responses=_FILE)
    def download_one(
        ref: RefText,
        start: Start = None,
        end: End = None,
        format: Format = "bvh",
        canonical: bool = False,
    ) -> Response:
        """One motion as a file; a scene as a zip."""
        items = [Part(ref=ref, start=start, end=end)]
        return download(page, DownloadBody(items=items, format=format, canonical=canonical))

    @routes.post("/api/download", response_class=Response, responses=_FILE)
    def download_many(body: DownloadBody) -> Response:
        """Motions as files; several as a zip archive, with the provenance of generated motions."""
        return download(page, body)

    @routes.get("/api/joints")
    def joints(ref: RefText) -> JointProposal:
        """Which joints of an uploaded skeleton have which roles; proposed for unknown names."""
        return propose_joints(_uploaded(page, ref), name=state.read_ref(ref).name)

    return routes


def _uploaded(page: Page, text: str) -> Path:
    """Return the path of an uploaded file."""
    ref = state.read_ref(text)
    upload_id, _, file = ref.name.partition("/")
    if ref.kind != "upload" or not file:
        raise PageError(f"{ref}: expected an uploaded file, found something else. Upload it.")
    return page.uploads.path(upload_id, file)


def download(page: Page, asked: DownloadBody) -> Response:
    """Return the file for some parts: one motion as it is, anything else as a zip."""
    rig = None if asked.onto is None else _uploaded(page, asked.onto)
    changes = MotionChanges(fps=asked.fps, onto=rig)
    if changes.are_any and asked.format == "source":
        raise PageError(
            "format: expected another one for a changed motion, found source, which is the file as "
            "it was added. Choose one of the others."
        )
    with tempfile.TemporaryDirectory(dir=page.folder) as place:
        folder = Path(place)
        targets = [
            (part, state.read_ref(part.ref), folder / f"{n:04d}")
            for n, part in enumerate(asked.items)
        ]
        for _, ref, target in targets:
            target.mkdir()
            if ref.kind in ("scene", "kept") and (
                changes.are_any or asked.format not in _SCENE_FORMATS
            ):
                raise PageError(
                    f"{ref}: expected one motion, found a scene with several. Name a capture."
                )
            if ref.kind == "scene" and asked.format != "source":  # by a process that may need it
                made = page.scene_folder(ref.name)
                output = str(target / "scene")
                said = {"scene": ref.name, "folder": str(made), "output": output}
                page.jobs.ask_scene_worker("scene-files", "write the scene", said)
        with page.reading() as db:
            for part, _, target in targets:
                if not any(target.iterdir()):
                    _write(page, db, part, target, asked, changes)
            licences = _licences(db, asked.items)
        files = sorted(path for path in folder.rglob("*") if path.is_file())
        if asked.alone:
            files = [path for path in files if not path.name.endswith(PROVENANCE)]
        if len(files) == 1:
            name, data = files[0].name, files[0].read_bytes()
        else:
            if licences:
                files.append(folder / LICENCES)
                files[-1].write_text(licences, encoding="utf-8")
            first, more = _stem(page, targets[0][1], targets[0][0]), len(targets) - 1
            name, data = f"{first}-and-{more}-more.zip" if more else f"{first}.zip", zipped(files)
    return Response(
        data,
        media_type=_TYPES.get(Path(name).suffix, "application/octet-stream"),
        headers={"Content-Disposition": f'attachment; filename="{name}"'},  # plain ASCII
    )


def _licences(db: MotionDB, items: Sequence[Part]) -> str:
    """Return a line for each stored capture of a download: its name and its licence."""
    refs = [state.read_ref(part.ref) for part in items]
    names = dict.fromkeys(ref.name for ref in refs if ref.kind == "capture")
    rows = [row for name in names if (row := db.captures.browsed(name)) is not None]
    return "".join(
        f"{row.info.name}: licence {row.info.tags.get('licence', 'not known')}\n" for row in rows
    )


def zipped(files: Sequence[Path]) -> bytes:
    """Return a zip archive of files; files of the same name are numbered.

    A file beside another (its origin) keeps to the name that the other one got.
    """
    stream, given = io.BytesIO(), dict[Path, str]()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in sorted(files, key=lambda path: path.name.endswith(PROVENANCE)):
            of = path.with_name(path.name.removesuffix(PROVENANCE))
            name, used, count = path.name, set(given.values()), 1
            if of != path and of in given:
                name = provenance_path(Path(given[of])).name
            while name in used:
                count += 1
                name = f"{path.stem}-{count}{path.suffix}"
            given[path] = name
            archive.write(path, name)
    return stream.getvalue()


def _write(
    page: Page,
    db: MotionDB,
    part: Part,
    folder: Path,
    asked: DownloadBody,
    changes: MotionChanges,
) -> None:
    """Write one part into a folder."""
    ref, ending = state.read_ref(part.ref), asked.format
    if ending == "source":
        _write_source(db, ref, part, folder)
        return
    path = folder / f"{_stem(page, ref, part)}.{ending}"
    whole = part.start is None and part.end is None
    if ref.kind == "capture":
        state.find_row(db, ref.name)
        db.export(ref.name, path, part.start, part.end, asked.canonical, changes)
    elif ref.kind == "made" and whole:
        page.made.get(ref.name).generated.write(path, changes)
    elif ref.kind == "sequence" and whole and not changes.are_any and ending in _SCENE_FORMATS:
        kept = page.sequences.get(ref.name)
        db.grammars.write(kept.sequence, path, kept.seed)
    elif ref.kind == "kept":
        record = state.find_kept(db, ref.name)
        for player in db.scenes.motions(record):  # raises if a capture of the scene was removed
            name = f"{ref.name}/{player}"
            db.export(name, folder / f"{plain_name(player)}.{ending}", canonical=True)
    else:
        write_motion(state.load_motion(page, db, ref, part.start, part.end), path, changes)


def _write_source(db: MotionDB, ref: state.Ref, part: Part, folder: Path) -> None:
    if ref.kind != "capture" or part.start is not None or part.end is not None:
        raise PageError(
            f"{ref}: expected a whole stored capture for its source file, found something else."
            " Choose BVH or glTF."
        )
    row = state.find_row(db, ref.name)
    ending = Path(row.info.path).suffix.lower() or f".{row.info.format}"
    db.export(ref.name, folder / f"{plain_name(ref.name)}.{plain_name(ending)}")


def _stem(page: Page, ref: state.Ref, part: Part) -> str:
    """Return a name that says what is in a file: the sentence, the grammar, the capture."""
    stem = plain_name(ref.name)
    if ref.kind == "made":
        stem = spoken(page.made.get(ref.name).generated.words)
    elif ref.kind == "sequence":
        stem = spoken(page.sequences.get(ref.name).sequence.grammar)
    elif ref.kind in ("scene", "first"):
        stem = "scene"
    if part.start is None and part.end is None:
        return stem
    return f"{stem}_{part.start or 0.0:.2f}-{'end' if part.end is None else f'{part.end:.2f}'}"


def spoken(words: str) -> str:
    """Return words as the name of a file.

    >>> spoken("Walk, then jump!"), spoken("läuft")
    ('walk-then-jump', 'l-uft')
    """
    said = re.sub(r"[^a-z0-9]+", "-", words.lower()).strip("-")
    return said[:60].rstrip("-") or "motion"


def plain_name(name: str) -> str:
    """Return a name with only characters that every file system and HTTP header allows.

    >>> plain_name('ana/läuft "schnell"')
    'ana_l_uft_schnell_'
    """
    return _PLAIN.sub("_", name).lstrip(".")[:150] or "motion"


MOST_THUMBS = 200  # Largest number of thumbnails of one request
THUMB_SECONDS, THUMB_RATE = 2.0, 15.0  # Length of a thumbnail, and its frames per second
SEARCHED = 60.0  # Seconds of a capture in which its moment is looked for
MOST_TILES = 60  # Largest number of captures of the wall
MOST_MOTIONS = 64  # Largest number of motions of one request
_CONTAINER = described("Motion as binary; docs/guide/page.md describes the format.", MEDIA_TYPE)
Rate = Annotated[float, Query(ge=1.0, le=MOTION_FPS, description="Frames per second.")]


class MotionsBody(Body):
    """Several motions."""

    items: Annotated[list[Part], Field(min_length=1, max_length=MOST_MOTIONS)]
    fps: Annotated[float, Field(ge=1.0, le=MOTION_FPS)] = MOTION_FPS


def motion_router(page: Page) -> APIRouter:
    """Return the routes of motion."""
    routes = APIRouter(tags=["motion"], responses=ERRORS)

    @routes.get("/api/motion", response_class=Response, responses=_CONTAINER)
    def motion(
        ref: RefText, start: Start = None, end: End = None, fps: Rate = MOTION_FPS
    ) -> Response:
        """A motion, or a scene with several tracks, as compact binary."""
        if start is None and end is None and fps == MOTION_FPS:
            made = state.made_scene(page, state.read_ref(ref))
            if made is not None:  # as the job wrote it, without opening the database
                return Response(made, media_type=MEDIA_TYPE)
        with page.reading() as db:
            data = tracks_of(page, db, Part(ref=ref, start=start, end=end), fps)
        return _binary(data)

    @routes.post("/api/motions", response_class=Response, responses=_CONTAINER)
    def motions(body: MotionsBody) -> Response:
        """Several motions in one container, in the order asked for."""
        tracks: list[Track] = []
        with page.reading() as db:
            for part in body.items:
                tracks += tracks_of(page, db, part, body.fps)
        return _binary(tracks)

    @routes.get("/api/thumbs", response_class=Response, responses=_CONTAINER)
    def thumbs(
        name: Annotated[
            list[Annotated[str, Query(max_length=LONGEST_TEXT)]],
            Query(min_length=1, max_length=MOST_THUMBS),
        ],
    ) -> Response:
        """Thumbnails of stored captures: the seconds in which most happens, facing forward.

        Unknown captures have no frames.
        """
        with page.reading() as db:
            return _binary([_thumb(page, db, each) for each in name])

    @routes.get("/api/wall")
    def wall(count: Annotated[int, Query(ge=1, le=MOST_TILES)] = 24) -> WallReply:
        """Captures that move, from everywhere in the catalogue, each with its moment."""
        with page.reading() as db:
            return WallReply(wall_of(page, db, count))

    return routes


def tracks_of(page: Page, db: MotionDB, part: Part, fps: float) -> list[Track]:
    """Return the tracks of a part; those of a scene include the ball."""
    ref = state.read_ref(part.ref)
    if ref.kind in ("scene", "first", "kept"):
        return state.load_scene(page, db, ref, part.start, part.end, fps)
    loaded = state.load_motion(page, db, ref, part.start, part.end)
    first = round((part.start or 0.0) * MOTION_FPS / FEATURE_STEP) * FEATURE_STEP / MOTION_FPS
    return [body_track(ref.name, part.ref, loaded, first, fps)]


@dataclass(frozen=True, kw_only=True)
class WallTile:
    """A capture of the wall: what people wrote about its moment, and when it is."""

    capture: str
    words: str
    start: float
    end: float
    duration: float


@dataclass(frozen=True)
class WallReply:
    """Captures that move, from everywhere in the catalogue, in its order."""

    tiles: list[WallTile]


def wall_of(page: Page, db: MotionDB, count: int) -> list[WallTile]:
    """Return up to `count` captures: of twice as many, evenly spread, those that differ most."""
    rows = db.captures.browse(limit=10**6).rows
    share = max(len(rows) / (2 * count), 1.0)
    spread = [rows[int(n * share)] for n in range(min(2 * count, len(rows)))]
    looked = [(row, _moment(page, db, row.info)) for row in spread]
    moments = [(row, moment) for row, moment in looked if moment is not None]
    kept = _unlike([moment for _, moment in moments], count)
    return [
        extended(
            WallTile,
            moment,
            capture=row.info.name,
            words=_said(row.captions, moment.pose),
            duration=round(row.info.duration, 3),
        )
        for row, moment in (moments[n] for n in kept)
    ]


def _unlike(moments: Sequence[state.Moment], count: int) -> list[int]:
    """Return which moments to show: those that move first, unlike the others above all in pose.

    Beginning with the fastest, the next is the one of the largest speed times distance to the
    nearest that was chosen.
    """
    shapes = np.array([moment.shape for moment in moments])
    scores = speeds = np.array([moment.speed for moment in moments])
    near = np.full(len(moments), np.inf)
    chosen: list[int] = []
    for _ in range(min(count, len(moments))):
        chosen.append(int(np.argmax(np.where(np.isin(np.arange(len(scores)), chosen), -1, scores))))
        near = np.minimum(near, np.linalg.norm(shapes - shapes[chosen[-1]], axis=1))
        scores = near * speeds
    return sorted(chosen)


def _said(captions: Sequence[Caption], time: float) -> str:
    """Return a caption of a time, else one of the whole capture, else ""."""
    timed = [c for c in captions if c.start is not None and c.start <= time < (c.end or np.inf)]
    whole = [caption for caption in captions if caption.start is None]
    return next((caption.words for caption in (*timed, *whole)), "")


def _moment(page: Page, db: MotionDB, info: CaptureInfo) -> state.Moment | None:
    """Return the moment of a capture, which is looked for in its first minute, and kept.

    None without a body.
    """
    key = (info.capture_id, info.sha256)
    if key not in page.moments:
        try:
            motion = load_stored(db.store, info.capture_id)
        except MotionDBError:  # markers only, or damaged
            if not info.has_body:
                page.moments[key] = None
            return None
        looked = cut_motion(motion, None, SEARCHED)
        best = best_moment(points_of(looked), round(THUMB_SECONDS * MOTION_FPS))
        start, stop, at = (round(n / MOTION_FPS, 3) for n in (best.first, best.stop, best.pose))
        page.moments[key] = state.Moment(start, stop, at, best.speed, best.shape)
    return page.moments[key]


def _thumb(page: Page, db: MotionDB, name: str) -> Track:
    ref = str(state.Ref("capture", name))
    row = db.captures.browsed(name)
    at = None if row is None else _moment(page, db, row.info)
    if row is None or at is None:
        return Track(name, ref, np.zeros((0, len(POINTS), 3)))
    motion = load_stored(db.store, row.info.capture_id)
    shown = cut_motion(motion, at.start, at.end)
    track = body_track(name, ref, shown, at.start, THUMB_RATE)
    return replace(track, points=facing_forward(track.points), contacts=None, moment=at.pose)


def _binary(tracks: list[Track]) -> Response:
    return Response(pack(tracks), media_type=MEDIA_TYPE)
