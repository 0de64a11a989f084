"""Animation of a motion as a GIF.

Frames are drawn with Pillow at twice the size and then reduced, because matplotlib would take
minutes for hundreds of frames. The camera moves with the figure; a metre grid on the ground shows
how it travels.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from motiondb.errors import MotionDBError
from motiondb.pictures import style
from motiondb.pictures.stick import (
    BONES,
    ELEVATION,
    HEAD_RADIUS,
    View,
    bone_colour,
    head_centre,
    view_motion,
)
from motiondb.records import MOTION_FPS, FloatArray, Motion

if TYPE_CHECKING:
    from PIL.Image import Image
    from PIL.ImageDraw import ImageDraw

_FINE = 2  # frames are drawn at so many times their size and then reduced
_FRAME_SECONDS = 0.05
"""GIF counts in hundredths of a second; browsers play at most 50 frames a second."""
_MAX_SECONDS = 60.0  # a longer GIF is many megabytes. Chosen by hand.
_GRID_REACH = 6  # metres of the grid on every side of the figure


def draw_animation(motion: Motion, path: str | Path, *, height: int = 320) -> Path:
    """Write a motion as an animated GIF in real time, 20 frames a second; return its path.

    `height`: Height in pixels. The width is equal, or larger for a motion with the body lying down.
    """
    path = style.check_gif(path)
    images = animation_images(motion, height)
    return style.save_gif(images, path, _FRAME_SECONDS)


def animation_images(motion: Motion, height: int = 320) -> list[Image]:
    """Frames of an animation, 20 a second, with one palette."""
    from PIL import Image as PilImage

    view = view_motion(motion)
    duration = view.n_frames / MOTION_FPS
    if duration > _MAX_SECONDS:
        raise MotionDBError(
            f"animation: expected at most {_MAX_SECONDS:.0f} s, found {duration:.1f} s. "
            "Choose an interval with --from and --to."
        )
    if height < 64:
        raise MotionDBError(
            f"animation: expected at least 64 pixels, found {height}. Ask for more."
        )
    times = np.arange(0.0, duration, _FRAME_SECONDS)
    frames = np.minimum((times * MOTION_FPS + 0.5).astype(int), view.n_frames - 1)
    metres = max(view.top, 1.6) + 0.35
    width = round(height * max(1.0, 1.1 * view.width / metres))
    pictures = [_draw_frame(view, int(frame), (width, height), metres) for frame in frames]
    palette = pictures[0].quantize(64, method=PilImage.Quantize.MEDIANCUT)
    return [picture.quantize(palette=palette, dither=PilImage.Dither.NONE) for picture in pictures]


def _draw_frame(view: View, frame: int, size: tuple[int, int], metres: float) -> Image:
    from PIL import Image as PilImage
    from PIL import ImageDraw as PilDraw

    width, height = size[0] * _FINE, size[1] * _FINE
    scale = height / metres
    origin = np.array([width / 2.0, height - 0.25 * scale])

    def to_pixels(points: FloatArray) -> FloatArray:
        return origin + points * np.array([scale, -scale])

    image = PilImage.new("RGB", (width, height), "white")
    draw = PilDraw.Draw(image)
    for line in _grid(view.track[frame]):
        pixels = to_pixels(line)
        draw.line([tuple(pixels[0]), tuple(pixels[1])], fill=style.GRID, width=_FINE)
    x, y = origin
    reach, rise = 0.31 * scale, 0.31 * np.sin(ELEVATION) * scale
    draw.ellipse((x - reach, y - rise, x + reach, y + rise), fill=style.GRID)
    points = view.points[frame]
    head = to_pixels(head_centre(points))
    _draw_body(draw, to_pixels(points), view.depths[frame], head, scale)
    return image.resize(size, PilImage.Resampling.LANCZOS)


def _draw_body(
    draw: ImageDraw, points: FloatArray, depths: FloatArray, head: FloatArray, scale: float
) -> None:
    """The figure, far limbs first; points and head in pixels, ``scale`` in pixels per metre."""
    thick = max(1, round(0.045 * scale))
    for parent, child in sorted(BONES, key=lambda bone: float(depths[bone[0]] + depths[bone[1]])):
        colour = bone_colour(child)
        draw.line([tuple(points[parent]), tuple(points[child])], fill=colour, width=thick)
        for x, y in (points[parent], points[child]):
            r = thick / 2.0
            draw.ellipse((x - r, y - r, x + r, y + r), fill=colour)
    (x, y), r = head, HEAD_RADIUS * scale
    draw.ellipse(
        (x - r, y - r, x + r, y + r), fill="white", outline=style.TRUNK, width=round(0.8 * thick)
    )


def _grid(spot: FloatArray) -> list[FloatArray]:
    """Lines of the metre grid on the ground near a place (right, towards the camera), projected."""
    offset = spot - np.round(spot)
    marks = np.arange(-_GRID_REACH, _GRID_REACH + 1)
    lines = []
    for mark in marks:
        lines.append(np.array([[mark, -_GRID_REACH], [mark, _GRID_REACH]], dtype=float))
        lines.append(np.array([[-_GRID_REACH, mark], [_GRID_REACH, mark]], dtype=float))
    return [(line - offset) * np.array([1.0, -np.sin(ELEVATION)]) for line in lines]
