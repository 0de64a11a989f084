"""Routes of motion: binary for the player, and thumbnails for tables."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from fastapi import APIRouter, Query
from pydantic import Field
from starlette.responses import Response

from motiondb.body.features import FEATURE_STEP
from motiondb.database import MotionDB
from motiondb.page.errors import ERRORS
from motiondb.page.motion import (
    MEDIA_TYPE,
    POINTS,
    Track,
    body_track,
    facing_forward,
    figure_of,
    pack,
)
from motiondb.page.refs import Ref, load_motion, load_scene, made_scene, read_ref
from motiondb.page.routes.parameters import LONGEST_TEXT, Body, End, Part, RefText, Start
from motiondb.page.state import Page
from motiondb.records import MOTION_FPS

MOST_THUMBS = 200  # Largest number of thumbnails of one request
THUMB_FRAMES, THUMB_SECONDS = 24, 4.0  # Frames of a thumbnail, and the seconds that they span
MOST_MOTIONS = 64  # Largest number of motions of one request
_CONTAINER: dict[int | str, dict[str, Any]] = {
    200: {
        "description": "Motion as binary; docs/guide/page.md describes the format.",
        "content": {MEDIA_TYPE: {"schema": {"type": "string", "format": "binary"}}},
    }
}  # OpenAPI description of binary motion
Rate = Annotated[float, Query(ge=1.0, le=MOTION_FPS, description="Frames per second.")]


class MotionsBody(Body):
    """Several motions."""

    items: Annotated[list[Part], Field(min_length=1, max_length=MOST_MOTIONS)]
    fps: Annotated[float, Field(ge=1.0, le=MOTION_FPS)] = MOTION_FPS


def router(page: Page) -> APIRouter:
    """Return the routes of motion."""
    routes = APIRouter(tags=["motion"], responses=ERRORS)

    @routes.get("/api/motion", response_class=Response, responses=_CONTAINER)
    def motion(
        ref: RefText, start: Start = None, end: End = None, fps: Rate = MOTION_FPS
    ) -> Response:
        """A motion, or a scene with several tracks, as compact binary."""
        if start is None and end is None and fps == MOTION_FPS:
            made = made_scene(page, read_ref(ref))
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
        """Thumbnails of stored captures, facing forward; unknown captures have no frames."""
        with page.reading() as db:
            return _binary([_thumb(db, each) for each in name])

    return routes


def tracks_of(page: Page, db: MotionDB, part: Part, fps: float) -> list[Track]:
    """Return the tracks of a part; those of a scene include the ball."""
    ref = read_ref(part.ref)
    if ref.kind in ("scene", "first", "kept"):
        return load_scene(page, db, ref, part.start, part.end, fps)
    loaded = load_motion(page, db, ref, part.start, part.end)
    first = round((part.start or 0.0) * MOTION_FPS / FEATURE_STEP) * FEATURE_STEP / MOTION_FPS
    return [body_track(ref.name, part.ref, figure_of(loaded), first, fps)]


def _thumb(db: MotionDB, name: str) -> Track:
    ref = str(Ref("capture", name))
    row = db.captures.browsed(name)
    if row is None:
        return Track(name, ref, np.zeros((0, len(POINTS), 3)))
    seconds = min(row.info.duration, THUMB_SECONDS)
    frames = row.info.motion_frames
    end = THUMB_SECONDS if frames > THUMB_SECONDS * MOTION_FPS else None
    shown = figure_of(db.motion(name, None, end))
    rate = min(MOTION_FPS, THUMB_FRAMES / max(seconds, 1e-3))
    track = body_track(name, ref, shown, 0.0, rate)
    return Track(name, ref, facing_forward(track.points[:THUMB_FRAMES]), fps=track.fps)


def _binary(tracks: list[Track]) -> Response:
    return Response(pack(tracks), media_type=MEDIA_TYPE)
