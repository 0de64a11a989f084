"""Reader of C3D: marker positions as clips of joints (:mod:`.markers`).

Up is the axis that ``POINT:Y_SCREEN`` names, else the one that the motion shows. Lost are analog
channels and forces. A file with several performers gives a clip for each. A file of segments alone
(the group ROTATION: a matrix of 16 numbers, column by column, and a reliability), as Theia writes
it, is read by the places of the segments.

The bytes of a C3D file: its parameters and the places of its points.

Layout: blocks of 512 bytes. A header of 16-bit words; parameters, each a record with the number of
bytes to the next; then, frame after frame, four values for every point (x, y, z, and a residual
that is negative where the point was not seen) and the analog samples, which are skipped. Numbers
are those of PC (Intel), DEC (VAX) or SGI (MIPS, big-endian) machines; values are 16-bit integers
times a scale, or floats.

Header and parameters say some things twice, and programs that crop, filter or convert a file often
change one of the two. So every combination of what they say is held against the number of bytes,
and the first one that fits is read. The number of frames may stand in four places, of which some
count to 65,535 only. Nothing that a file says is believed beyond its bytes.

Source: The C3D File Format, Motion Lab Systems, https://www.c3d.org/HTML/Documents/; C-Motion,
"ROTATION data type".
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from motiondb.errors import CaptureError
from motiondb.files.limits import AS_USUAL, ReadOptions, check_clip_size, check_rate
from motiondb.files.readers.marker_gaps import is_place
from motiondb.files.readers.markers import MarkerFile, read_markers
from motiondb.files.readers.point_motion import clip_of_points
from motiondb.records import LARGEST, MOTION_FPS, Clip, Event, FloatArray


def read_c3d_takes(data: bytes, path: object, options: ReadOptions = AS_USUAL) -> dict[str, Clip]:
    """Read the clip of each performer in the bytes of a C3D file; "" for the only one."""
    if (said := _segments_alone(data)) is not None:
        return {"": _of_segments(said, path, options)}
    return read_markers(c3d_markers(data, path, options), len(data), path, options)


def c3d_markers(data: bytes, path: object, options: ReadOptions = AS_USUAL) -> MarkerFile:
    """Read the markers in the bytes of a C3D file."""
    file = read_c3d_file(data, path, options.skip_bad_frames)
    track = cache(file.track)  # a file may hold hundreds of points that are no markers
    notes = file.notes + (file.rate_notes if options.fps is None else ())
    return MarkerFile(
        file.labels, file.n_frames, track, file.fps, file.unit, file.up, "z", "c3d", notes
    )


def c3d_events(data: bytes, path: object, fps: float, take: str = "") -> list[Event]:
    """Read the events in the bytes of a C3D file, at 30 a second, that lie within its frames.

    Strikes of the foot and heel are ``foot_strike``, toe off is ``foot_off``, with the ankle of the
    side that the context names. `fps`: the rate at which the frames are read. `take`: the performer
    whose events are read; those without a subject are everybody's.
    """
    if (said := _segments_alone(data)) is not None:
        events, n_frames = _events(said), max(said.frame_counts().values(), default=0)
    else:
        file = read_c3d_file(data, path, skip_bad=True)
        events, n_frames = file.events, file.n_frames
    found = []
    for event in events:
        frame = round(event.frame / fps * MOTION_FPS)
        if not 0 <= event.frame < n_frames or (take and event.subject not in ("", take)):
            continue
        side = {"left": "l_ankle", "right": "r_ankle"}.get(event.context.lower(), "")
        name = "_".join(event.label.lower().split())
        if short := re.fullmatch(r"([lr])_?(hs|to)", name):
            side = f"{short[1]}_ankle"
            name = {"hs": "foot_strike", "to": "foot_off"}[short[2]]
        if re.fullmatch(r"(foot|heel|initial)_?(strike|contact)", name):
            found.append(Event(frame, "foot_strike", side, "ground"))
        elif re.fullmatch(r"(foot|toe)_?off", name):
            found.append(Event(frame, "foot_off", side, "ground"))
        else:
            sided = f"{event.context.lower()}_{name}" if side else name
            found.append(Event(frame, sided))
    return found


_TURNED = 17  # Numbers of a segment in a frame
_ENDS = MappingProxyType(
    {"thigh": "hip", "shank": "knee", "foot": "ankle", "toes": "toe"}
    | {"uarm": "shoulder", "larm": "elbow", "hand": "wrist"}
)  # Segment -> joint at which it begins


def _segments_alone(data: bytes) -> _Said | None:
    """Return what a file says that has segments in place of points; None for others."""
    said = _read_parameters(data) if len(data) >= BLOCK and data[1] == 0x50 else None
    alone = said and said.count("ROTATION:USED") and not said.count("POINT:USED")
    return said if alone else None


def _of_segments(said: _Said, path: object, options: ReadOptions) -> Clip:
    """Read the places of segments, as Theia writes them, which are those of the joints."""
    labels, count = _all_texts(said, "ROTATION:LABELS"), said.count("ROTATION:USED")
    start = (said.count("ROTATION:DATA_START") - 1) * BLOCK
    rate = options.fps or check_rate(said.number("ROTATION:RATE") or said.rate, path)
    times = said.count("ROTATION:RATIO") or max(1, round(rate / said.rate)) if said.rate else 1
    n_frames = max(said.frame_counts().values(), default=0) * times
    size = 4 * _TURNED * count
    check_clip_size(n_frames, count, len(said.data), path, options.limits)
    if start < BLOCK or not n_frames or len(labels) != count:
        raise CaptureError(path, "expected places of segments, found none. Export them again.")
    if len(said.data) < start + size * n_frames:
        room = max(0, len(said.data) - start) // size
        raise CaptureError(
            path, f"expected {n_frames} frames of {count} segments, found {room}: the file is cut."
        )
    values = _floats(said.data[start : start + size * n_frames], said.machine)
    values = values.reshape(n_frames, count, _TURNED)
    places = np.where(values[..., 16:] < 0, np.nan, values[..., 12:15])
    names = [label.lower().removesuffix("_4x4") for label in labels]
    kept = [n for n, name in enumerate(names) if name == "head" or name[2:] in _ENDS]
    names = [name[:2] + _ENDS.get(name[2:], "") if name != "head" else name for name in names]
    options = replace(options, up=options.up or _up(said) or "z")
    note = ("Of segments, the places at which they begin are read, and not their turns.",)
    return clip_of_points(
        [names[n] for n in kept], places[:, kept], rate, options, path, "c3d", note
    )


BLOCK = 512
_INTEL, _DEC, _MIPS = 84, 85, 86  # Byte 4 of the parameters
_TEXT, _FLOAT = -1, 4  # Types of parameters; 1 and 2 are integers of so many bytes
_FULL = 65535  # The largest count of a word; programs write it for "more", or for "unknown"
_SAMPLE = 100_000  # Bytes that are looked at to see whether numbers are floats
_SMALL = 1e-6  # Floats below are bytes of something else: a marker is never a nanometre from 0


@dataclass(frozen=True)
class C3DEvent:
    """An instant that a file names."""

    frame: float  # From 0, the first frame of the file; it may lie outside the file
    label: str  # Such as "Foot Strike"
    context: str = ""  # Such as "Left"
    subject: str = ""


@dataclass(frozen=True)
class C3DFile:
    """What a file says about its points, and where their places lie in its bytes."""

    labels: tuple[str, ...]  # Name of each point, as written; "" for those without
    fps: float  # 0.0 where the file has no rate
    unit: str  # POINT:UNITS, "" for none
    up: str  # The axis that POINT:Y_SCREEN names, such as "z" or "-y"; "" for none
    n_frames: int
    notes: tuple[str, ...]
    rate_notes: tuple[str, ...]  # Where it tells several rates
    events: tuple[C3DEvent, ...]
    _frames: NDArray[np.uint8]  # (frames, bytes of a frame)
    _machine: int
    _scale: float  # File units per integer; 0.0 for floats

    def track(self, point: int) -> FloatArray:
        """Places (frames, 3) of a point in the file's axes and units, NaN where it was not seen.

        Not seen is a point with a negative residual, without numbers, or with one number three
        times, such as 0 or 9999.99, as many programs write it.
        """
        size = 8 if self._scale else 16
        part = np.ascontiguousarray(self._frames[:, size * point : size * (point + 1)])
        if self._scale:
            values = _words(part.tobytes(), self._machine, "i2").reshape(-1, 4).astype(float)
            places = values[:, :3] * self._scale
        else:
            values = _floats(part.tobytes(), self._machine).reshape(-1, 4)
            places = values[:, :3]
        with np.errstate(invalid="ignore"):
            is_seen = is_place(places) & ~(values[:, 3] < 0)
        return np.where(is_seen[:, None], places, np.nan)


def read_c3d_file(data: bytes, path: object, skip_bad: bool = False) -> C3DFile:
    """Read the parameters of a C3D file and find its frames; ``skip_bad``: also if it is cut."""
    if len(data) < BLOCK or data[1] != 0x50:
        raise CaptureError(path, "expected a C3D file, found something else. Export it again.")
    said = _read_parameters(data)
    layout, n_frames, notes = _layout(said, path, skip_bad)
    size = n_frames * layout.frame
    padded = data + bytes(max(0, layout.start + size - len(data)))  # analog samples may be cut
    frames = np.frombuffer(padded, np.uint8, size, layout.start).reshape(n_frames, layout.frame)
    labels = _all_texts(said, "POINT:LABELS")
    labels = (labels + [""] * layout.n_points)[: layout.n_points]
    scale, scale_notes = (0.0, ()) if layout.is_float else _scale(said)
    file = C3DFile(
        labels=tuple(labels),
        fps=said.rate,
        unit="".join(said.texts("POINT:UNITS")[:1]),
        up=_up(said),
        n_frames=n_frames,
        notes=notes + scale_notes,
        rate_notes=said.rate_notes,
        events=_events(said),
        _frames=frames,
        _machine=said.machine,
        _scale=scale,
    )
    return _without_phantoms(file, said, layout)


@dataclass(frozen=True)
class _Said:
    """What a file says: its header, and its parameters by "GROUP:NAME"."""

    data: bytes
    machine: int
    place: int  # Byte at which the parameters begin
    end: int  # Byte after their last block
    by_name: Mapping[str, tuple[int, tuple[int, ...], bytes]]  # Type, sizes, values

    @property
    def header(self) -> list[int]:
        """The first ten words of the header."""
        return [int(word) for word in _words(self.data[:20], self.machine, "u2")]

    @property
    def header_floats(self) -> tuple[float, float]:
        """The scale and the frame rate of the header."""
        scale, rate = _floats(self.data[12:16] + self.data[20:24], self.machine)
        return float(scale), float(rate)

    @property
    def rates(self) -> list[float]:
        """Frames per second as the parameters, the header and the trial tell them."""
        rates = (self.number("POINT:RATE"), self.header_floats[1], self.number("TRIAL:CAMERA_RATE"))
        return [rate for rate in rates if 0 < rate < LARGEST]

    @property
    def rate(self) -> float:
        """Frames per second, 0.0 if nothing tells them."""
        return next(iter(self.rates), 0.0)

    @property
    def rate_notes(self) -> tuple[str, ...]:
        """A note on rates that contradict each other."""
        if all(math.isclose(rate, self.rate, rel_tol=1e-3) for rate in self.rates):
            return ()
        found = ", ".join(f"{rate:g}" for rate in self.rates)
        return (f"The file has the rates {found}; {self.rate:g} is taken. Give the right one "
                "(--fps) if this is wrong.",)  # fmt: skip

    def texts(self, name: str) -> list[str]:
        """The texts of a parameter, without the spaces and zeros that fill them up."""
        kind, sizes, values = self.by_name.get(name, (_TEXT, (0,), b""))
        length = sizes[0] if sizes else 1
        if kind != _TEXT or length == 0:
            return []
        parts = [values[place : place + length] for place in range(0, len(values), length)]
        return [_text(part) for part in parts]

    def numbers(self, name: str) -> list[float]:
        """The numbers of a parameter; integers are taken to be without sign."""
        kind, _, values = self.by_name.get(name, (_TEXT, (), b""))
        if kind == _FLOAT:
            return [float(value) for value in _floats(values, self.machine)]
        if kind == _TEXT:
            return []
        return [float(value) for value in _words(values, self.machine, f"u{kind}")]

    def number(self, name: str) -> float:
        """The first number of a parameter, 0.0 for none."""
        return next(iter(self.numbers(name)), 0.0)

    def count(self, name: str) -> int:
        """A whole number, which may have its higher word behind the lower; 0 for none."""
        values = self.numbers(name)[:2]
        if not values or not all(0 <= value < LARGEST for value in values):
            return 0
        is_long = len(values) == 2 and self.by_name[name][0] == 2
        return round(values[0] + (65536 * values[1] if is_long else 0))

    def frame_counts(self) -> dict[str, int]:
        """The number of frames by the place that says it, without those that mean "unknown"."""
        words = self.header
        first = self.count("TRIAL:ACTUAL_START_FIELD") or 1
        last = self.count("TRIAL:ACTUAL_END_FIELD")
        counts = {
            "TRIAL:ACTUAL_END_FIELD": last - first + 1 if last else 0,
            "POINT:LONG_FRAMES": self.count("POINT:LONG_FRAMES"),
            "POINT:FRAMES": self.count("POINT:FRAMES"),
            "the header": words[4] - words[3] + 1 if 0 < words[4] < _FULL else 0,
        }
        return {name: count for name, count in counts.items() if count > 0 and count != _FULL}


@dataclass(frozen=True)
class _Layout:
    """Where the data begin, and what a frame consists of."""

    start: int
    is_float: bool
    n_points: int
    n_analog: int

    @property
    def frame(self) -> int:
        """Bytes of a frame."""
        return (4 * self.n_points + self.n_analog) * (4 if self.is_float else 2)


def _read_parameters(data: bytes) -> _Said:
    """Read the parameters where the header says, with the numbers that their machine has."""
    stated = (data[0] - 1) * BLOCK if data[0] else BLOCK
    for place in dict.fromkeys((stated, BLOCK)):
        machine = data[place + 3] if place + 4 <= len(data) else 0
        for tried in dict.fromkeys((machine, _INTEL, _MIPS)):
            if tried in (_INTEL, _DEC, _MIPS):
                said = _parameters_at(data, place, tried)
                if any(name.startswith("POINT:") for name in said.by_name):
                    return said
    return _Said(data, _INTEL, stated, stated, {})


def _parameters_at(data: bytes, place: int, machine: int) -> _Said:
    """Follow the records of the parameters from a byte on."""
    groups: dict[int, str] = {}
    found: list[tuple[int, str, tuple[int, tuple[int, ...], bytes]]] = []
    blocks = place + data[place + 2] * BLOCK if place + 4 <= len(data) else 0
    first_data = (int(_words(data[16:18], machine, "u2")[0]) - 1) * BLOCK
    end = min(len(data), max(blocks, first_data))
    at = place + 4
    while at + 4 <= end:
        length, group = _signed(data[at]), _signed(data[at + 1])
        after = at + 2 + abs(length)
        if length == 0 or after + 2 > end:
            break
        name = _text(data[at + 2 : after]).upper()
        offset = int(_words(data[after : after + 2], machine, "u2")[0])
        if group < 0:
            groups.setdefault(-group, name)
        elif (values := _values(data[after + 2 : min(end, after + max(offset, 2))])) is not None:
            found.append((group, name, values))
        elif offset == 0 and (values := _values(data[after + 2 : end])) is not None:
            found.append((group, name, values))  # the last record need not say where the next is
        if offset < 2:
            break
        at = after + offset
    by_name: dict[str, tuple[int, tuple[int, ...], bytes]] = {}
    for group, name, value in found:
        by_name.setdefault(f"{groups.get(group, '')}:{name}", value)
    return _Said(data, machine, place, max(blocks, place), MappingProxyType(by_name))


def _values(record: bytes) -> tuple[int, tuple[int, ...], bytes] | None:
    """Type, sizes and bytes of a parameter from its record; None if the record lacks them."""
    if len(record) < 2 or _signed(record[0]) not in (_TEXT, 1, 2, _FLOAT):
        return None
    sizes = tuple(record[2 : 2 + record[1]])
    n_bytes = abs(_signed(record[0]))
    for size in sizes:
        n_bytes *= size
    begin = 2 + record[1]
    if begin + n_bytes > len(record):
        return None
    return _signed(record[0]), sizes, record[begin : begin + n_bytes]


def _layouts(said: _Said) -> Iterator[_Layout]:
    """Yield every combination of what parameters and header say, the most believed first."""
    words = said.header
    starts = (words[8], said.count("POINT:DATA_START"), said.end // BLOCK + 1)
    scales = [said.number("POINT:SCALE"), said.header_floats[0]]
    if "POINT:SCALE" not in said.by_name:
        del scales[0]
    rate = said.number("ANALOG:RATE") / said.rate if said.rate else 0.0
    channels = said.count("ANALOG:USED")
    analog = (words[2], channels * words[9], channels * round(rate) if 0 < rate < _FULL else 0)
    points = (said.count("POINT:USED"), words[1])
    for n_points, start, n_analog, is_float in itertools.product(
        dict.fromkeys(points),
        dict.fromkeys(starts),
        dict.fromkeys(analog),
        dict.fromkeys(scale < 0 for scale in scales),
    ):
        if n_points and start > 1:
            yield _Layout((start - 1) * BLOCK, is_float, n_points, n_analog)


def _layout(said: _Said, path: object, skip_bad: bool) -> tuple[_Layout, int, tuple[str, ...]]:
    """Return the layout that fits the bytes, the number of frames, and notes."""
    layouts = list(_layouts(said))
    if not layouts:
        raise CaptureError(path, "expected points, found none. Export the markers, too.")
    if len(layouts) > 1:
        layouts = [layout for layout in layouts if _is_sane(said, layout)] or layouts
    counts = said.frame_counts()
    found = [_count(counts, _room(said, layout), layout.frame) for layout in layouts]
    for which in (0, 1):
        for layout, n_frames in zip(layouts, found):
            if n_frames[which]:
                return layout, n_frames[which], ()
    return layouts[0], *_cut_short(said, layouts[0], counts, path, skip_bad)


def _room(said: _Said, layout: _Layout) -> int:
    """Return the bytes for frames: up to the end of the file, or to where other data begin."""
    other = (said.count("ROTATION:DATA_START") - 1) * BLOCK
    end = min(len(said.data), other) if other > layout.start else len(said.data)
    return max(0, end - layout.start)


def _count(counts: Mapping[str, int], n_bytes: int, frame: int) -> tuple[int, int]:
    """Return the number of frames that fills the bytes up to a block, and one that they hold.

    0 for none. A count may have lost what is above 65,535. Without any, the bytes tell.

    >>> _count({"POINT:FRAMES": 3}, 1024, 200), _count({"POINT:FRAMES": 3}, 2048, 200)
    ((3, 3), (0, 3))
    >>> _count({"POINT:FRAMES": 4}, 65540 * 200, 200), _count({}, 1024, 200)
    ((65540, 4), (5, 5))
    """
    room = n_bytes // frame
    if not counts:
        return room, room
    wrapped = [count + (room - count) // 65536 * 65536 for count in counts.values()]
    stated, whole = (
        [n for n in numbers if 0 <= n_bytes - n * frame < BLOCK]
        for numbers in (counts.values(), wrapped)
    )
    holds = [n for n in counts.values() if n <= room]
    return max(stated or whole, default=0), next(iter(holds), 0)


def _is_sane(said: _Said, layout: _Layout) -> bool:
    """Say whether the first places of a layout can be floats; integers can be anything."""
    if not layout.is_float:
        return True
    n_frames = min(_room(said, layout), max(_SAMPLE, layout.frame)) // layout.frame
    size = n_frames * layout.frame
    sample = _floats(said.data[layout.start : layout.start + size], said.machine)
    places = sample.reshape(-1, layout.frame // 4)[:, : 4 * layout.n_points]
    with np.errstate(invalid="ignore"):
        sizes = np.abs(places)
        odd = (sizes > LARGEST) | ((sizes < _SMALL) & (sizes > 0))
    return bool(odd.mean() < 0.1) if odd.size else False


def _cut_short(
    said: _Said, layout: _Layout, counts: Mapping[str, int], path: object, skip_bad: bool
) -> tuple[int, tuple[str, ...]]:
    """Return the frames to read of a file with fewer than it says, and a note; or refuse it."""
    where = min(counts, key=lambda name: counts[name], default="the header")
    count, n_bytes = counts.get(where, 0), _room(said, layout)
    room = n_bytes // layout.frame
    points = layout.frame - (4 if layout.is_float else 2) * layout.n_analog
    if count and (count - 1) * layout.frame + points <= n_bytes:
        return count, ("The file ends within the analog samples of its last frame.",)
    if room and skip_bad:
        return room, (f"Left out {count - room} frames that the file is cut short of.",)
    if not count:
        raise CaptureError(path, "expected at least 1 frame, found 0. Export the motion again.")
    big = " (big-endian, SGI)" if said.machine == _MIPS else ""
    raise CaptureError(
        path,
        f"expected {count} frames as {where} says, found {len(said.data)} bytes, which hold {room} "
        f"of {layout.n_points} points{big}. The file is cut short: export it again, or pass "
        "--skip-bad-frames to read what is there.",
    )


def _scale(said: _Said) -> tuple[float, tuple[str, ...]]:
    """Return the file units per integer, and a note if header and parameters differ.

    Motion Analysis wrote files in which the header is right: a person of 1.6 m, not of 0.6 m.
    """
    both = [abs(said.header_floats[0]), abs(said.number("POINT:SCALE"))]
    likely = [scale for scale in both if 1.0 / LARGEST < scale < LARGEST and scale != 1.0] or [1.0]
    if likely[-1] / 1.01 < likely[0] < likely[-1] * 1.01:
        return likely[0], ()
    return likely[0], (
        f"The scale of the header ({likely[0]:.4g}) was taken; POINT:SCALE says {likely[1]:.4g}.",
    )


def _without_phantoms(file: C3DFile, said: _Said, layout: _Layout) -> C3DFile:
    """Leave out frames at the end in which no point was seen.

    Only those that not every place counts, as readers make that read up to the end of a file, or,
    where none does, those that may be the filling of the last block.
    """
    last = min(said.frame_counts().values(), default=file.n_frames - BLOCK // layout.frame - 1)
    beyond = replace(file, _frames=file._frames[max(last, 1) :])
    if not 0 < len(beyond._frames) < file.n_frames:
        return file
    seen = np.zeros(len(beyond._frames), bool)
    for point in range(layout.n_points):
        seen |= ~np.isnan(beyond.track(point)[:, 0])
    n_frames = file.n_frames - int(np.argmax(np.append(seen[::-1], True)))
    return replace(file, n_frames=n_frames, _frames=file._frames[:n_frames])


def _events(said: _Said) -> tuple[C3DEvent, ...]:
    """Return the instants that the group EVENT names, in the order of time.

    Their times are minutes and seconds from frame 1 of the trial, of which a file may hold a part:
    force plates of seven trials agree with this, not with frame 0.
    """
    times = np.array(said.numbers("EVENT:TIMES"))
    times = times[: len(times) // 2 * 2].reshape(-1, 2)
    n_events = min(len(times), said.count("EVENT:USED") if "EVENT:USED" in said.by_name else 65535)
    texts = {name: _all_texts(said, f"EVENT:{name}") for name in ("LABELS", "CONTEXTS", "SUBJECTS")}
    first = max(said.count("TRIAL:ACTUAL_START_FIELD") or said.header[3], 1)
    found = []
    for number, (minutes, seconds) in enumerate(times[:n_events].tolist()):
        frame = (60.0 * minutes + seconds) * said.rate - (first - 1)
        words = [of[number] if number < len(of) else "" for of in texts.values()]
        if abs(frame) < LARGEST and words[0]:
            found.append(C3DEvent(frame, *words))
    return tuple(sorted(found, key=lambda event: event.frame))


def _all_texts(said: _Said, name: str) -> list[str]:
    """Return the texts of a parameter, and of those with a number behind its name."""
    found = said.texts(name)
    for number in itertools.count(2):
        if f"{name}{number}" not in said.by_name:
            return found
        found += said.texts(f"{name}{number}")
    return found


def _up(said: _Said) -> str:
    """Return the axis that Y_SCREEN says is up; "" where none, or that of X_SCREEN, is named."""
    across, up = ("".join(said.texts(f"POINT:{axis}_SCREEN")[:1]).upper() for axis in "XY")
    if not re.fullmatch(r"[+-]?[XYZ]", up) or across[-1:] == up[-1]:
        return ""
    return up.lower().lstrip("+")


def _text(data: bytes) -> str:
    """Return the text of bytes up to a zero, without the spaces around it."""
    plain = data.split(b"\0")[0]
    try:
        return plain.decode().strip()
    except UnicodeDecodeError:
        return plain.decode("latin-1").strip()


def _signed(byte: int) -> int:
    return byte - 256 if byte > 127 else byte


def _words(data: bytes, machine: int, kind: str) -> NDArray[np.generic]:
    """Return the integers in bytes, of a kind such as "u2"."""
    whole = data[: len(data) // int(kind[1]) * int(kind[1])]
    return np.frombuffer(whole, (">" if machine == _MIPS else "<") + kind)


def _floats(data: bytes, machine: int) -> FloatArray:
    """Return the floats of four bytes that a machine writes.

    Those of DEC have their words exchanged, are 2 ** (exponent - 129) times 1 to 2, and zero if the
    exponent is.

    >>> _floats(bytes([0x80, 0x40, 0, 0]), _DEC), _floats(bytes([0x3F, 0x80, 0, 0]), _MIPS)
    (array([1.]), array([1.]))
    """
    if machine != _DEC:
        with np.errstate(invalid="ignore"):  # a signalling NaN
            return _words(data, machine, "f4").astype(float)
    words = _words(data[: len(data) // 4 * 4], machine, "u2").astype(np.int64)
    bits = words[::2] << 16 | words[1::2]
    exponents = bits >> 23 & 255
    sizes = np.ldexp(1.0 + (bits & 0x7FFFFF) / 2.0**23, exponents - 129)
    return np.where(exponents == 0, 0.0, np.where(bits >> 31, -sizes, sizes))
