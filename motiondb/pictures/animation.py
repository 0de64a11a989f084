"""Animation of a motion as a GIF.

Frames are drawn with Pillow at twice the size and then reduced, because matplotlib would take
minutes for hundreds of frames. The camera moves with the figure; a metre grid on the ground shows
how it travels.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from motiondb.errors import MotionDBError
from motiondb.pictures import stick, style
from motiondb.records import MOTION_FPS, FloatArray, IntArray, Motion

if TYPE_CHECKING:
    from PIL.Image import Image
    from PIL.ImageDraw import ImageDraw

FINE = 2  # Frames are drawn at so many times their size and then reduced
_MAX_SECONDS = 60.0  # a longer GIF is many megabytes. Chosen by hand.
ACROSS = 5  # Most motions side by side
_GRID_REACH = 6  # metres of the grid on every side of the figure


def draw_animation(motion: Motion, path: str | Path, *, height: int = 320) -> Path:
    """Write a motion as an animated GIF in real time, 20 frames a second; return its path."""
    path = style.check_gif(path)
    images = animation_images(motion, height)
    return style.save_gif(images, path)


def draw_animations(
    motions: Sequence[Motion], titles: Sequence[str], path: str | Path, *, height: int = 160
) -> Path:
    """Write motions side by side as one animated GIF, each under its title; return the path.

    A motion that has ended stands still until the longest one has.
    """
    from PIL import Image as PilImage
    from PIL import ImageDraw as PilDraw

    path = style.check_gif(path)
    drawn = [animation_images(motion, height) for motion in motions]
    width = max(max(images[0].width for images in drawn), *(6 * len(t) + 12 for t in titles))
    columns = min(len(drawn), ACROSS)
    rows = -(-len(drawn) // columns)
    whole = []
    for frame in range(max(map(len, drawn))):
        page = PilImage.new("RGB", (columns * width, rows * (height + 16)), "white")
        for n, (images, title) in enumerate(zip(drawn, titles, strict=True)):
            left, top = n % columns * width, n // columns * (height + 16)
            image = images[min(frame, len(images) - 1)]
            page.paste(image, (left + (width - image.width) // 2, top + 16))
            PilDraw.Draw(page).text((left + 6, top + 2), title, fill=style.TRUNK)
        whole.append(page)
    return style.save_gif(in_one_palette(whole, whole[0], 64), path)


def animation_images(motion: Motion, height: int = 320) -> list[Image]:
    """Frames of an animation, 20 a second, with one palette."""
    view = stick.view_motion(motion)
    frames = shown_frames(view.n_frames, _MAX_SECONDS, "Choose an interval with --from and --to.")
    metres = max(view.top, 1.6) + 0.35
    width = round(height * max(1.0, 1.1 * view.width / metres))
    pictures = [_draw_frame(view, int(frame), (width, height), metres) for frame in frames]
    return in_one_palette(pictures, pictures[0], 64)


def shown_frames(n_frames: int, most_seconds: float, advice: str) -> IntArray:
    """Return the frames of an animation in real time; one that is too long is refused."""
    duration = n_frames / MOTION_FPS
    if duration > most_seconds:
        raise MotionDBError(
            f"animation: expected at most {most_seconds:.0f} s, found {duration:.1f} s. {advice}"
        )
    times = np.arange(0.0, duration, style.FRAME_SECONDS)
    return np.minimum((times * MOTION_FPS + 0.5).astype(int), n_frames - 1)


def in_one_palette(pictures: Sequence[Image], typical: Image, n_colours: int) -> list[Image]:
    """Return pictures with the colours of a typical one, so that a GIF needs one palette."""
    from PIL.Image import Dither, Quantize

    palette = typical.quantize(n_colours, method=Quantize.MEDIANCUT)
    return [picture.quantize(palette=palette, dither=Dither.NONE) for picture in pictures]


def paint_disc(draw: ImageDraw, at: FloatArray, radius: float, **look: Any) -> None:  # noqa: ANN401
    """Draw a circle around a point in pixels; `look`: what Pillow's ellipse takes."""
    x, y = at
    draw.ellipse((x - radius, y - radius, x + radius, y + radius), **look)


def paint_body(
    draw: ImageDraw,
    points: FloatArray,
    depths: FloatArray,
    radius: float,
    thick: int,
    colour_of: Callable[[int], str],
    outline: tuple[str, int],
) -> None:
    """Draw limbs, far ones first, and the head with its outline; all sizes in pixels."""
    for parent, child in sorted(
        stick.BONES, key=lambda bone: float(depths[bone[0]] + depths[bone[1]])
    ):
        colour = colour_of(child)
        draw.line([tuple(points[parent]), tuple(points[child])], fill=colour, width=thick)
        for end in (points[parent], points[child]):
            paint_disc(draw, end, thick / 2.0, fill=colour)
    colour, width = outline
    paint_disc(draw, stick.head_centre(points), radius, fill="white", outline=colour, width=width)


def _draw_frame(view: stick.View, frame: int, size: tuple[int, int], metres: float) -> Image:
    from PIL import Image as PilImage
    from PIL import ImageDraw as PilDraw

    width, height = size[0] * FINE, size[1] * FINE
    scale = height / metres
    origin = np.array([width / 2.0, height - 0.25 * scale])

    def to_pixels(points: FloatArray) -> FloatArray:
        return origin + points * np.array([scale, -scale])

    image = PilImage.new("RGB", (width, height), "white")
    draw = PilDraw.Draw(image)
    for line in _grid(view.track[frame]):
        pixels = to_pixels(line)
        draw.line([tuple(pixels[0]), tuple(pixels[1])], fill=style.GRID, width=FINE)
    x, y = origin
    reach, rise = 0.31 * scale, 0.31 * np.sin(stick.ELEVATION) * scale
    draw.ellipse((x - reach, y - rise, x + reach, y + rise), fill=style.GRID)
    thick = max(1, round(0.045 * scale))
    outline, points = (style.TRUNK, round(0.8 * thick)), to_pixels(view.points[frame])
    radius, depths = stick.HEAD_RADIUS * scale, view.depths[frame]
    paint_body(draw, points, depths, radius, thick, stick.bone_colour, outline)
    return image.resize(size, PilImage.Resampling.LANCZOS)


def _grid(spot: FloatArray) -> list[FloatArray]:
    """Lines of the metre grid on the ground near a place (right, towards the camera), projected."""
    offset = spot - np.round(spot)
    marks = np.arange(-_GRID_REACH, _GRID_REACH + 1)
    lines = []
    for mark in marks:
        lines.append(np.array([[mark, -_GRID_REACH], [mark, _GRID_REACH]], dtype=float))
        lines.append(np.array([[-_GRID_REACH, mark], [_GRID_REACH, mark]], dtype=float))
    return [(line - offset) * np.array([1.0, -np.sin(stick.ELEVATION)]) for line in lines]
