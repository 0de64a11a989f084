"""Make the sample captures with their words and truth: ``python sample_data/make.py``.

Writes ``captures/<performer>/<name>.bvh``, ``captions.tsv``, ``segments.tsv``, ``events.tsv`` and
``grammars.json`` below ``--out``. The same seed gives the same bytes.
"""

from __future__ import annotations

import argparse
import json
import sys
import zlib
from collections.abc import Iterable
from pathlib import Path

import numpy as np

if __package__ in (None, ""):  # run as a program: make the package importable
    sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
    __package__ = "sample_data"

from motiondb.body import rotation
from motiondb.records import Clip

from .grammars import GRAMMARS, Derivation
from .phrases import long_captions, short_captions, timed_caption
from .repertoire import coarse
from .score import FPS, Take
from .takes import Capture, activities, captures, perform

LICENCE = "CC0-1.0"
_RESTS = ("idle", "hold", "sit", "ready", "hold_box")
HEADERS = {
    "captions": "file performer licence words start end action synthetic",
    "segments": "file start_s end_s start_frame end_frame label",
    "events": "file frame event joint other",
}
"""Columns of the sheets."""
Row = tuple[object, ...]


def main(arguments: list[str] | None = None) -> None:
    """Make every capture and sheet."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("sample_data"), help="folder to write to")
    parser.add_argument("--seed", type=int, default=1, help="of every random choice")
    options = parser.parse_args(arguments)
    print(make(options.out, options.seed))
    print(make(options.out / "activities", options.seed, collection=activities()))


def make(
    out: Path,
    seed: int,
    only: Iterable[str] | None = None,
    collection: list[Capture] | None = None,
) -> str:
    """Write the captures, all or those whose files are in ``only``, and their sheets below ``out``.

    collection : of captures, by default the first one, which has grammars.

    Returns a sentence that says how much was made.
    """
    sheets: dict[str, list[Row]] = {name: [] for name in HEADERS}
    takes: dict[str, list[dict[str, object]]] = {name: [] for name in GRAMMARS}
    wanted = None if only is None else set(only)
    everything = captures() if collection is None else collection
    chosen = [c for c in everything if wanted is None or c.file in wanted]
    n_frames = 0
    for capture in chosen:
        take, derivations = perform(capture, seed)
        path = out / "captures" / capture.file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(bvh_text(take.clip()), encoding="ascii", newline="\n")
        n_frames += take.n_frames
        sheets["segments"] += _segment_rows(capture, take)
        sheets["events"] += _event_rows(capture, take)
        sheets["captions"] += _caption_rows(capture, take, seed)
        if derivations:
            takes[capture.grammar].append(_truth(capture, derivations))
    for name, rows in sheets.items():
        lines = ["\t".join(HEADERS[name].split())]
        lines += ["\t".join(str(value) for value in row) for row in rows]
        (out / f"{name}.tsv").write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")
    if collection is not None:
        return f"{len(chosen)} captures, {n_frames} frames, {n_frames / FPS:.0f} s, in {out}"
    truth = {name: {"rules": rules, "takes": takes[name]} for name, rules in GRAMMARS.items()}
    text = json.dumps(truth, indent=1) + "\n"
    (out / "grammars.json").write_text(text, encoding="utf-8", newline="\n")
    return f"{len(chosen)} captures, {n_frames} frames, {n_frames / FPS:.0f} s, in {out}"


def bvh_text(clip: Clip) -> str:
    """A clip as the text of a BVH file in centimetres; angles to 0.01 degrees, places to 0.01 mm.

    Half of 0.01 degrees moves the end of a leg by less than 0.1 mm; rounding also keeps the bytes
    the same where the last bits of sines and cosines differ from one machine to another.
    """
    bones, lines = clip.skeleton, ["HIERARCHY"]
    ends = dict(bones.end_sites)

    def write(joint: int, depth: int) -> None:
        pad = "\t" * depth
        kind = "ROOT" if depth == 0 else "JOINT"
        lines.extend([f"{pad}{kind} {bones.names[joint]}", f"{pad}{{"])
        lines.append(f"{pad}\tOFFSET {_numbers(100.0 * bones.offsets[joint], 2)}")
        channels = bones.channels[joint]
        lines.append(f"{pad}\tCHANNELS {len(channels)} {' '.join(channels)}")
        for child in np.flatnonzero(bones.parents == joint):
            write(int(child), depth + 1)
        if joint in ends:
            place = _numbers(100.0 * np.array(ends[joint]), 2)
            lines.extend(
                [f"{pad}\tEnd Site", f"{pad}\t{{", f"{pad}\t\tOFFSET {place}", f"{pad}\t}}"]
            )
        lines.append(f"{pad}}}")

    write(0, 0)
    order = "".join(name[0] for name in bones.channels[0][3:])
    angles = rotation.to_euler(clip.local_rotations, order).reshape(clip.n_frames, -1)
    lines += ["MOTION", f"Frames: {clip.n_frames}", f"Frame Time: {1.0 / clip.fps:.8f}"]
    for place, row in zip(100.0 * clip.root_positions, angles):
        lines.append(f"{_numbers(place, 3)} {_numbers(row, 2)}")
    return "\n".join(lines) + "\n"


def _numbers(values: np.ndarray, decimals: int) -> str:
    """Numbers with at most so many decimals, as short as they can be written."""
    texts = (f"{value:.{decimals}f}".rstrip("0").rstrip(".") for value in values)
    return " ".join("0" if text == "-0" else text for text in texts)


def _frames(take: Take) -> list[tuple[str, int, int]]:
    return [(label, round(start * FPS), round(end * FPS)) for label, start, end in take.segments]


def _segment_rows(capture: Capture, take: Take) -> list[Row]:
    return [
        (capture.file, f"{start / FPS:.3f}", f"{end / FPS:.3f}", start, end, label)
        for label, start, end in _frames(take)
    ]


def _event_rows(capture: Capture, take: Take) -> list[Row]:
    last = take.n_frames - 1
    rows = [
        (capture.file, min(last, round(time * FPS)), event, joint, other)
        for time, event, joint, other in take.events
    ]
    return sorted(rows, key=lambda row: (row[1], row[2], row[3]))


def _caption_rows(capture: Capture, take: Take, seed: int) -> list[Row]:
    """What people wrote about a capture; of a long one also about each action in it."""
    random = np.random.RandomState(zlib.crc32(f"words/{seed}/{capture.file}".encode()))
    who = capture.performer
    acted = [(label, start, end) for label, start, end in _frames(take) if label not in _RESTS]
    labels = [label for label, _, _ in acted] or [take.segments[0][0]]
    if capture.is_long:
        written = long_captions(who, labels, random)
    elif capture.action == "dance":
        written = short_captions(who, ["dance", *labels], random)[:1]
        written += short_captions(who, ["dance"], random)
    else:
        once = [label for i, label in enumerate(labels) if i == 0 or label != labels[i - 1]]
        written = short_captions(who, once, random)
    head, tail = (capture.file, who, LICENCE), (capture.action, "yes")
    rows: list[Row] = [(*head, words, "", "", *tail) for words in written]
    if capture.is_long:
        for label, start, end in acted:
            words, times = timed_caption(who, label, random), (start / FPS, end / FPS)
            rows.append((*head, words, *(f"{t:.3f}" for t in times), coarse(label), "yes"))
    return rows


def _truth(capture: Capture, derivations: list[Derivation]) -> dict[str, object]:
    sentences = [{"words": d.words(), "tree": d.tree} for d in derivations]
    return {"file": capture.file, "sentences": sentences}


if __name__ == "__main__":
    main()
