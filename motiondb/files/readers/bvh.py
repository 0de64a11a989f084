"""Reader of BVH (Biovision hierarchy).

What is kept: names, hierarchy, offsets, end sites, channel order, every frame. What is normalised:
Euler angles become quaternions, lengths become metres (``Clip.unit`` remembers the file's unit),
a frame time becomes the usual rate that is written so (:func:`motiondb.body.rates.find_rate`).
What a file has beside a body is left out with a note: scale channels of 1, a second root that is no
person, one more number in each frame.

Convention: channels are applied in the order in which they are listed, the first outermost, so that
"Zrotation Xrotation Yrotation" means R = Rz Rx Ry. Position channels of a joint take the place of
its OFFSET (Meredith and Maddock, "Motion Capture File Formats Explained", 2001, leave this open;
Blender, MotionBuilder and the Bandai-Namco files read so); an axis without a channel keeps the
OFFSET's value, and so does a joint whose positions are 0 in all frames. World axes are those of the
file.

Grammar of the HIERARCHY: ``ROOT|JOINT name { OFFSET x y z  CHANNELS n ...  (JOINT ... | End Site {
OFFSET })* }``. Keywords are read in any case and layout; a name is the rest of its line and may
hold spaces. Every structural fault is reported.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from itertools import pairwise
from types import MappingProxyType

import numpy as np

from motiondb.body import rotation
from motiondb.body.joint_names import REQUIRED, is_person
from motiondb.body.rates import find_rate
from motiondb.body.world import find_unit
from motiondb.errors import CaptureError
from motiondb.files.limits import AS_USUAL, MAX_FPS, MIN_FPS, ReadOptions, check_clip_size
from motiondb.files.text import (
    Faults,
    clean_bytes,
    decode,
    line_number,
    number,
    quoted,
    read_number_block,
    shorten,
    whole_number,
)
from motiondb.files.units import scaled
from motiondb.records import Clip, FloatArray, Skeleton

CHANNELS = MappingProxyType(
    {
        f"{a}{kind}".lower(): f"{a}{kind}"
        for kind in ("position", "rotation", "scale")
        for a in "XYZ"
    }
)  # Lower-case spelling -> usual spelling; BVH has no scales, but some programs write them
_KEYWORDS = frozenset({"hierarchy", "root", "joint", "end", "offset", "channels", "{", "}"})

MAX_HEADER = 10_000_000
"""Bytes of the HIERARCHY part that are read. A joint takes about 150 bytes, so that this is room
for more joints than any limit allows."""
_SCALE_WITHIN = 1e-3  # Difference of a scale channel from 1 that is rounding
_COUNT_LINE = re.compile(rb"[\s]*(frames|frame[ \t]*time)[ \t]*:?[ \t]*([^\s]*)[^\n]*\n?", re.I)

_ROTATED = re.compile(rb"\boffset(?:[ \t]+[-+.\w]+){6}", re.I)

Tokens = list[tuple[int, str]]  # (line number, word) in the order of the text


@dataclass
class _Node:
    """A joint or an end site while the text is being read."""

    name: str
    parent: int
    line: int
    is_end: bool = False
    offset: tuple[float, float, float] | None = None
    channels: tuple[str, ...] = ()
    is_rotated: bool = False  # OFFSET has a rotation, too


@dataclass
class _State:
    """The state after the tokens read so far."""

    # Joints and end sites in the order of the text
    nodes: list[_Node] = field(default_factory=list)
    stack: list[int] = field(default_factory=list)  # Nodes whose braces are open, innermost last
    announced: int | None = None  # A node whose opening brace has not come yet
    faults: Faults = field(default_factory=list)  # Structural faults with their lines

    def fault(self, line: int | None, sentence: str) -> None:
        """Add a fault."""
        self.faults.append((line, sentence))


def read_header(text: str) -> tuple[Skeleton | None, Faults]:
    """Read the skeleton of a HIERARCHY text."""
    state = _State()
    tokens = [
        (line, token)
        for line, content in enumerate(text.split("\n"), start=1)
        for token in content.replace("{", " { ").replace("}", " } ").split()
    ]
    place = 0
    while place < len(tokens):
        place = _read_token(state, tokens, place)
    last = tokens[-1][0] if tokens else 1
    if state.stack:
        opened, n = state.nodes[state.stack[-1]], len(state.stack) - 1
        around = f" and {n} more around it" if n else ""
        what = f"{quoted(opened.name)} of line {opened.line}{around}"
        state.fault(last, f"expected '}}' for {what}, found the end.")
    return _skeleton(state), state.faults


def _read_token(state: _State, tokens: Tokens, place: int) -> int:
    """Read one keyword with its values; return the next place."""
    line, token = tokens[place]
    keyword = token.lower()
    if keyword == "hierarchy":
        return place + 1
    if keyword in ("root", "joint", "end"):
        return _read_node(state, tokens, place)
    if keyword == "offset":
        return _read_offset(state, tokens, place)
    if keyword == "channels":
        return _read_channels(state, tokens, place)
    if keyword in ("{", "}"):
        _read_brace(state, line, keyword)
        return place + 1
    state.fault(line, f"expected a keyword such as JOINT or OFFSET, found {token[:30]!r}.")
    while place < len(tokens) and tokens[place][0] == line:
        place += 1
    return place


def _read_brace(state: _State, line: int, brace: str) -> None:
    """Open the announced node, or close the innermost open one."""
    if brace == "}" and state.stack:
        state.stack.pop()
    elif brace == "}":
        state.fault(line, "expected as many '{' as '}', found one '}' too many.")
    elif state.announced is None:
        state.fault(line, "expected ROOT, JOINT or End Site before '{', found none.")
    else:
        state.stack.append(state.announced)
        state.announced = None


def _read_node(state: _State, tokens: Tokens, place: int) -> int:
    """Read ROOT, JOINT or End with the name that follows; return the next place."""
    line, token = tokens[place]
    words, place = [], place + 1
    while place < len(tokens) and tokens[place][0] == line and tokens[place][1] != "{":
        words.append(tokens[place][1])
        place += 1
    is_end, name = token.lower() == "end", " ".join(words)
    if not name:
        state.fault(line, f"expected a name after {token}, found none.")
    parent = state.stack[-1] if state.stack else -1
    if parent >= 0 and state.nodes[parent].is_end:
        state.fault(line, f"expected no joint inside an End Site, found {quoted(name)}.")
    state.nodes.append(_Node(name, parent, line, is_end))
    if state.announced is not None:
        state.fault(line, "expected '{' before the next joint, found none.")
    state.announced = len(state.nodes) - 1
    return place


def _read_offset(state: _State, tokens: Tokens, place: int) -> int:
    """Read OFFSET with its three numbers; return the next place.

    Three more are the rest pose's rotation, as SOMA has it: the channels hold it, too.
    """
    line = tokens[place][0]
    texts = [token for _, token in tokens[place + 1 : place + 4]]
    values = [number(text) for text in texts]
    x, y, z = (*values, None, None, None)[:3]
    if x is None or y is None or z is None:
        on_line = " ".join(text for at, text in tokens[place + 1 : place + 4] if at == line)
        shown = quoted(on_line or "none")
        state.fault(line, f"expected 3 numbers after OFFSET, found {shown}.")
        return _next_keyword(tokens, place + 1)
    if not state.stack:
        state.fault(line, "expected OFFSET inside a joint, found it outside.")
    else:
        state.nodes[state.stack[-1]].offset = (x, y, z)
    more = [text for at, text in tokens[place + 4 : place + 8] if at == line]
    if len(more) == 3 and None not in map(number, more):
        if state.stack:
            state.nodes[state.stack[-1]].is_rotated = True
        return place + 7
    return place + 4


def _read_channels(state: _State, tokens: Tokens, place: int) -> int:
    """Read CHANNELS with their number and names; return the next place."""
    line = tokens[place][0]
    end = _next_keyword(tokens, place + 1)
    words = [token for _, token in tokens[place + 1 : end]]
    given = whole_number(words[0]) if words else None
    count = -1 if given is None else given
    known = [CHANNELS[word.lower()] for word in words[1:] if word.lower() in CHANNELS]
    unknown = [word for word in words[1:] if word.lower() not in CHANNELS]
    if unknown:
        state.fault(
            line, f"expected channels such as Xposition or Zrotation, found {quoted(unknown[0])}."
        )
    elif count != len(known):
        present = f"{len(known)} names" if count >= 0 else f"[{', '.join(map(quoted, words[:1]))}]"
        wanted = f"{count} channel names" if count >= 0 else "a number of channels"
        state.fault(line, f"expected {wanted}, found {present}.")
    if not state.stack or state.nodes[state.stack[-1]].is_end:
        state.fault(line, "expected CHANNELS inside a joint, found it outside.")
    else:
        node = state.nodes[state.stack[-1]]
        node.channels = tuple(known)
    return end


def _next_keyword(tokens: Tokens, place: int) -> int:
    """Return the place of the next keyword, or the end."""
    while place < len(tokens) and tokens[place][1].lower() not in _KEYWORDS:
        place += 1
    return place


def _skeleton(state: _State) -> Skeleton | None:
    """Return the joints in file order; add the faults that only the whole text shows."""
    joints = [number for number, node in enumerate(state.nodes) if not node.is_end]
    new_number = {old: new for new, old in enumerate(joints)}
    for node in state.nodes:
        if node.offset is None:
            state.fault(
                node.line, f"expected an OFFSET for {quoted(node.name)}, found none; write one."
            )
        n_turns = sum(channel.endswith("rotation") for channel in node.channels)
        if node.is_rotated and not node.is_end and n_turns < 3:
            state.fault(
                node.line,
                f"expected 3 rotation channels for {quoted(node.name)}, whose OFFSET has a "
                f"rotation, found {n_turns}. Export it again.",
            )
    if not joints:
        state.fault(1, "expected a ROOT joint, found none. Is this a BVH file?")
        return None
    if state.faults:
        return None
    nodes = [state.nodes[old] for old in joints]
    return Skeleton(
        names=tuple(node.name for node in nodes),
        parents=np.array([new_number.get(node.parent, -1) for node in nodes]),
        offsets=np.array([node.offset for node in nodes], dtype=float),
        end_sites=tuple(
            (new_number[node.parent], node.offset)
            for node in state.nodes
            if node.is_end and node.offset is not None
        ),
        channels=tuple(node.channels for node in nodes),
    )


_COMMA_TIME = re.compile(rb"(?i)Frame Time:\s*\d+,\d")


def _with_points(data: bytes, notes: list[str]) -> bytes:
    """Return a file with points for decimal commas, which some locales write, and note it."""
    if not _COMMA_TIME.search(data):
        return data
    notes.append("Decimal commas are read as points.")
    return re.sub(rb"(?<=\d),(?=\d)", b".", data)


def read_bvh(data: bytes, path: object, options: ReadOptions = AS_USUAL) -> Clip:
    """Read the clip in the bytes of a BVH file."""
    n_bytes = len(data)
    data = clean_bytes(data, path)
    notes: list[str] = []
    data = _with_points(data, notes)
    motion = re.search(rb"(?im)^[ \t]*MOTION[ \t\r]*$", data)
    header = data[: motion.start()] if motion else data
    if len(header) > MAX_HEADER:
        raise CaptureError(
            path,
            f"expected a HIERARCHY of at most {MAX_HEADER} bytes before a line MOTION, found "
            f"{len(header)} bytes. Is this a BVH file?",
        )
    skeleton, faults = read_header(decode(header))
    if motion is None:
        faults.append((None, "expected a line MOTION, found none. The file may be cut short."))
        raise CaptureError(path, shorten(faults))
    if _ROTATED.search(header):
        notes.append("OFFSETs with six numbers: the last three, a rotation, are in the channels.")
    counts = _read_counts(data, motion.end(), options.fps, faults, notes)
    n_frames, file_fps, block_start = counts
    if skeleton is None:
        raise CaptureError(path, shorten(faults))
    width = sum(map(len, skeleton.channels))
    if width == 0:
        faults.append((None, "expected channels in the HIERARCHY, found none: nothing moves."))
        raise CaptureError(path, shorten(faults))
    bounds = _person(skeleton, path, notes)
    block, expected = data[block_start:], _expected_values(skeleton)
    first_line = line_number(data, block_start)
    skip = options.skip_bad_frames
    table, frame_faults = read_number_block(block, first_line, width, expected, skip)
    if frame_faults and not len(table):
        more, more_faults = read_number_block(block, first_line, width + 1, expected, False)
        side = _spare_column(more) if not more_faults else ""
        if side:
            table, frame_faults = more[:, 1:] if side == "first" else more[:, :-1], []
            notes.append(f"Every frame has one number more; the {side} ones are left out.")
    n_present = len(table) + len(frame_faults)
    if options.skip_bad_frames and frame_faults and len(table):
        first = frame_faults[0][0]
        notes.append(f"Left out {len(frame_faults)} bad frames; the first is on line {first}.")
    else:
        faults += shorten(frame_faults)
    is_cut = not data.endswith(b"\n")
    faults += _check_frame_count(n_frames, n_present, skip, is_cut, notes)
    if faults:
        raise CaptureError(path, faults)
    check_clip_size(len(table), len(skeleton.names), n_bytes, path, options.limits)
    skeleton, table = _body_alone(skeleton, bounds, table, path, notes)
    clip = _to_clip(skeleton, table, file_fps, notes)
    return _in_metres(replace(clip, notes=tuple(notes)), options.unit)


def _spare_column(table: FloatArray) -> str:
    """Say which column holds no channel: the "first" if it counts frames, the "last" if it stays.

    "" if both may be spare: a first one that stays, or grows in even steps, may be a time.

    >>> _spare_column(np.array([[1.0, 5.0], [2.0, 6.0]])), _spare_column(np.array([[7.0, 5.0]]))
    ('first', '')
    >>> _spare_column(np.array([[0.1, 5.0], [0.2, 5.0], [0.3, 5.0]]))
    ''
    """
    if len(table) < 2:
        return ""
    first, is_still = np.diff(table[:, 0]), bool(np.ptp(table[:, -1]) == 0.0)
    if (first == 1.0).all() and table[0, 0] in (0.0, 1.0):
        return "first"
    is_even = np.ptp(first) <= 0.02 * np.abs(first).max()  # but for the digits of a time
    return "last" if is_still and not is_even else ""


def _person(skeleton: Skeleton, path: object, notes: list[str]) -> tuple[int, int]:
    """Return the first joint of the person's root and the first behind; note other roots."""
    bounds = [*np.flatnonzero(skeleton.parents < 0).tolist(), len(skeleton.names)]
    trees = list(pairwise(bounds))
    if len(trees) == 1:
        return trees[0]
    chosen = [tree for tree in trees if is_person(_tree(skeleton, *tree))]
    if not chosen:  # the joints have other names: the largest tree, beside props
        largest = max(trees, key=lambda tree: tree[1] - tree[0])
        others = (end - first for first, end in trees if (first, end) != largest)
        chosen = [largest] if max(others) < len(REQUIRED) else []
    if len(chosen) != 1:
        names = " and ".join(quoted(skeleton.names[first]) for first, _ in (chosen or trees)[:3])
        raise CaptureError(
            path,
            f"expected one ROOT that is a person, found {len(chosen or trees)}: {names}. "
            "Export one performer a file.",
        )
    names = ", ".join(
        quoted(skeleton.names[first]) for first, end in trees if first != chosen[0][0]
    )
    notes.append(f"Left out what hangs from other roots, which is no person: {names}.")
    return chosen[0]


def _body_alone(
    skeleton: Skeleton, bounds: tuple[int, int], table: FloatArray, path: object, notes: list[str]
) -> tuple[Skeleton, FloatArray]:
    """Leave out other roots with their channels, and scales of 1; add notes."""
    first, end = bounds
    body = _tree(skeleton, first, end)
    joints = np.repeat(np.arange(len(skeleton.names)), [len(c) for c in skeleton.channels])
    is_scale = np.array([c.endswith("scale") for names in skeleton.channels for c in names])
    inside = (joints >= first) & (joints < end)
    if not is_scale.any():
        return body, table[:, inside]
    scales = table[:, inside & is_scale]
    if np.abs(scales - 1.0).max(initial=0.0) > _SCALE_WITHIN:
        worst = scales.ravel()[np.abs(scales - 1.0).argmax()]
        raise CaptureError(
            path,
            f"expected scale channels of 1, found {worst:g}. BVH has no scales: export the motion "
            "without them.",
        )
    notes.append("Left out the scale channels: all are 1.")
    kept = tuple(tuple(c for c in names if not c.endswith("scale")) for names in body.channels)
    return replace(body, channels=kept), table[:, inside & ~is_scale]


def _tree(skeleton: Skeleton, first: int, end: int) -> Skeleton:
    """Return the joints from a root to the next one as a skeleton."""
    return Skeleton(
        skeleton.names[first:end],
        np.maximum(skeleton.parents[first:end] - first, -1),
        skeleton.offsets[first:end],
        tuple((j - first, place) for j, place in skeleton.end_sites if first <= j < end),
        skeleton.channels[first:end],
    )


def _read_counts(
    data: bytes, start: int, fps: float | None, faults: Faults, notes: list[str]
) -> tuple[int | None, float, int]:
    """Read the lines ``Frames:`` and ``Frame Time:``; add faults and notes."""
    lines: dict[bytes, tuple[int, str]] = {}
    while match := _COUNT_LINE.match(data, start):
        kind = b"frames" if match.group(1).lower() == b"frames" else b"time"
        line = line_number(data, match.start(1))
        if kind in lines:
            what = "Frames" if kind == b"frames" else "Frame Time"
            faults.append((line, f"expected one line '{what}', found a second."))
            break
        lines[kind] = (line, decode(match.group(2)))
        start = match.end()
    line = line_number(data, start)
    n_frames = None
    if b"frames" not in lines:
        faults.append((line, "expected a line 'Frames: N', found none."))
    else:
        at, text = lines[b"frames"]
        n_frames = whole_number(re.sub(r"\.0*$", "", text))
        if n_frames is None:
            faults.append((at, f"expected a number of frames, found {quoted(text)}."))
    if fps is None:
        fps = _read_frame_time(lines.get(b"time"), line, faults, notes)
    return n_frames, fps, start


def _read_frame_time(
    written: tuple[int, str] | None, line: int, faults: Faults, notes: list[str]
) -> float:
    """Return the frames per second of a frame time (line, text); 0 if there is a fault."""
    if written is None:
        faults.append((line, "expected a line 'Frame Time: seconds', found none. Give --fps."))
        return 0.0
    at, text = written
    seconds = number(text)
    if seconds is None or not 1 / MAX_FPS <= seconds <= 1 / MIN_FPS:
        shown = "no number" if seconds is None else f"{seconds:g}"
        faults.append(
            (
                at,
                f"expected a frame time from {1 / MAX_FPS:g} to {1 / MIN_FPS:g} s, found {shown}. "
                "Give the right frame rate with --fps.",
            )
        )
        return 0.0
    fps, found = find_rate(seconds, text)
    notes += found
    return fps


def _expected_values(skeleton: Skeleton) -> str:
    """Describe a frame for messages: "63 values (6 for the root, 3 for each of 19 joints)"."""
    counts = [len(names) for names in skeleton.channels]
    rest = counts[1:]
    text = f"{sum(counts)} values ({counts[0]} for the root"
    if rest and min(rest) == max(rest):
        text += f", {rest[0]} for each of {len(rest)} joints"
    elif rest:
        text += f", {sum(rest)} for {len(rest)} joints"
    return text + ")"


def _check_frame_count(
    n_frames: int | None, n_present: int, skip_bad: bool, is_cut: bool, notes: list[str]
) -> Faults:
    """Compare the header's number of frames with the file's; a note where nothing is lost.

    More frames than the header says are all there; one less, at the end of a line, is a header
    that counts from 0 or from 1.
    """
    if n_present == 0:
        return [(None, "expected at least 1 frame, found 0. Export the motion again.")]
    if n_frames is None or n_frames == n_present:
        return []
    if skip_bad or n_present > n_frames or (n_present == n_frames - 1 and not is_cut):
        notes.append(f"The header says {n_frames} frames; the file holds {n_present}.")
        return []
    return [
        (
            None,
            f"expected {n_frames} frames as the header says, found {n_present}. The file may be "
            "cut short: export it again, or pass --skip-bad-frames to read the frames that are "
            "there.",
        )
    ]


def _to_clip(skeleton: Skeleton, table: FloatArray, fps: float, notes: list[str]) -> Clip:
    """Turn the channel table (frames, channels) into a clip that is still in the file's unit."""
    n_frames, n_joints = len(table), len(skeleton.names)
    positions = np.broadcast_to(skeleton.offsets, (n_frames, n_joints, 3)).copy()
    orders: dict[str, list[tuple[int, list[int]]]] = {}
    column, moved = 0, False
    for joint, channels in enumerate(skeleton.channels):
        turns = []
        for name in channels:
            if name.endswith("position"):
                positions[:, joint, "XYZ".index(name[0])] = table[:, column]
                moved |= joint > 0
            else:
                turns.append(column)
            column += 1
        order = "".join(name[0] for name in channels if name.endswith("rotation"))
        orders.setdefault(order, []).append((joint, turns))
    notes += _keep_lengths(skeleton, positions)
    rotations = np.empty((n_frames, n_joints, 4))
    for order, group in orders.items():
        joints = [joint for joint, _ in group]
        angles = table[:, np.array([turns for _, turns in group], dtype=int)]
        rotations[:, joints] = rotation.from_euler(angles, order)
    return Clip(
        skeleton=skeleton,
        fps=fps,
        local_rotations=rotations,
        root_positions=positions[:, 0].copy(),
        joint_positions=positions if moved else None,
        format="bvh",
    )


def _keep_lengths(skeleton: Skeleton, positions: FloatArray) -> list[str]:
    """Put joints whose positions are 0 in all frames at their OFFSETs; note them."""
    zero = (positions[:, 1:] == 0.0).all(axis=(0, 2)) & skeleton.offsets[1:].any(axis=1)
    joints = 1 + np.flatnonzero(zero)
    if len(joints) == 0:
        return []
    positions[:, joints] = skeleton.offsets[joints]
    names = ", ".join(quoted(skeleton.names[joint]) for joint in joints[:5])
    return [
        f"The positions of {len(joints)} joints ({names}{', ...' * (len(joints) > 5)}) are 0 in "
        "all frames: their OFFSETs are kept, since bones have lengths."
    ]


def _in_metres(clip: Clip, unit: float | None) -> Clip:
    """Scale a clip in file units to metres; estimate the unit if it is not given."""
    notes: tuple[str, ...] = ()
    if unit is None:
        unit, notes = find_unit(clip.skeleton, clip.joint_positions)
    return replace(
        clip,
        skeleton=scaled(clip.skeleton, unit),
        root_positions=clip.root_positions * unit,
        joint_positions=None if clip.joint_positions is None else clip.joint_positions * unit,
        unit=unit,
        notes=clip.notes + notes,
    )
