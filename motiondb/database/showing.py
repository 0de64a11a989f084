"""Facts of a capture, its segments and activities, its picture, and its gait.

The gait is that of a capture or a file, at its own rate and in the metres of its performer.
"""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from motiondb import answers, pictures, store
from motiondb.body import gait, retarget
from motiondb.body.features import FEATURE_STEP, recognition_features
from motiondb.database.catalogue.parts import cut_clip
from motiondb.database.loading import load_learned_grammar
from motiondb.database.session import Session
from motiondb.errors import QueryError
from motiondb.grammar.cfg.context_free import derive_by
from motiondb.records import MOTION_FPS, Clip, Motion, SegmentTable
from motiondb.search.described import describe
from motiondb.symbols.activities import ActivitySettings, find_activities

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from motiondb.database.values import Example

LIKELY = 0.2  # Probability from which on a word is named


def describe_capture(session: Session, name: str) -> answers.CaptureFacts:
    """Facts of one capture, for print or JSON; times in seconds."""
    info = store.load_capture(session.store, name)
    number = info.capture_id
    captions = store.load_captions(session.store, [number])
    events = store.load_events(session.store, [number])
    made: dict[str, Any] = {}
    if info.kind == "generated":
        made["sources"] = _sources(session, number)
        derivation = store.load_derivation(session.store, number)
        if derivation is not None:
            learned = load_learned_grammar(session.store, derivation.grammar)
            string = derive_by(learned.grammar, derivation.rules).leaves()
            made |= {"grammar": derivation.grammar, "string": " ".join(string)}
    return answers.extended(
        answers.CaptureFacts,
        info,
        capture=info.name,
        seconds=round(info.duration, 3),
        frames=info.n_frames,
        leg_length=f"{info.leg_length:.3f} m" if info.has_body else "",
        tags={k: v for k, v in info.tags.items() if k not in ("capture", "segments")},
        words=[_timed(c.words, c.start, c.end) for c in captions.get(number, ())],
        events=dict(sorted(Counter(e.name for e in events.get(number, ())).items())),
        copies=[
            f"{r.capture} {r.kind} {r.other} {r.start:.2f}-{r.end:.2f} s"
            for r in store.load_relations(session.store, info.name)
        ]
        + [
            f"{path} is the same file"
            for path, name in store.load_same_files(session.store)
            if name == info.name
        ],
        notes=list(info.notes),
        segments=capture_segments(session, number) if store.is_learned(session.store) else [],
        activities=capture_activities(session, number),
        lacks=_lacks(session, number),
        **made,
    )


def _lacks(session: Session, capture_id: int) -> list[str] | None:
    """What a capture lacks, in sentences; None where it was not measured."""
    quality = store.load_quality(session.store, [capture_id]).get(capture_id)
    if quality is None:
        return None
    said = [finding.sentence for finding in quality.findings]
    return [f"quality {quality.seconds.mean():.2f}", *said, *quality.untold]


def capture_segments(session: Session, capture_id: int) -> list[answers.ShownSegment]:
    """Symbols of a capture with their times (seconds) and log-likelihoods (nats per frame)."""
    table = store.load_segments(session.store, scores=False)
    rows = np.flatnonzero(table.capture_ids == capture_id)
    return [shown_segment(table, int(row)) for row in rows]


def shown_segment(table: SegmentTable, row: int) -> answers.ShownSegment:
    """A row of the table of segments: times in seconds, log-likelihood in nats per frame."""
    return answers.ShownSegment(
        int(table.symbols[row]),
        round(float(table.starts[row]) / MOTION_FPS, 3),
        round(float(table.ends[row]) / MOTION_FPS, 3),
        round(float(table.log_likelihoods[row]), 3),
        bool(table.log_likelihoods[row] > table.backgrounds[row]),
    )


def searched_segments(session: Session, name: str) -> list[answers.ShownSegment]:
    """Symbols of a capture, also of a generated one, from what is in memory."""
    opened = session.store
    if not store.is_learned(opened):
        store.load_capture(opened, name)  # refuses a name that no capture has
        return []
    learned = session.searchable
    numbers = session.kept(
        "numbers by name", lambda: {i.name: number for number, i in learned.captures.items()}
    )
    capture_id = numbers[name] if name in numbers else store.load_capture(opened, name).capture_id
    if capture_id not in learned.rows:
        return []
    rows, table = learned.rows[capture_id], learned.segments
    return [shown_segment(table, row) for row in range(rows.start, rows.stop)]


def capture_activities(session: Session, capture_id: int) -> list[answers.ShownActivity]:
    """The successive activities of a capture; equal numbers are the same activity.

    Found in the capture alone, without labels (:mod:`motiondb.symbols.activities`); where
    words were learned, each comes with those that its motion most likely shows. Empty if the
    capture does one thing throughout.
    """
    return session.kept(("activities", capture_id), lambda: _activities(session, capture_id))


def _activities(session: Session, capture_id: int) -> list[answers.ShownActivity]:
    if not store.has_body(session.store, capture_id):
        return []
    motion = store.load_motion(session.store, capture_id)
    if motion.n_frames < 2 * ActivitySettings().shortest * FEATURE_STEP:
        return []  # too short for two, without looking at its features
    runs = find_activities(recognition_features(motion), np.random.default_rng(0))
    if len(runs) < 2:
        return []
    rows = []
    for start, end, activity in runs:
        low, high = start * FEATURE_STEP, min(end * FEATURE_STEP, motion.n_frames)
        words = tuple(_likely_words(session, capture_id, low, high))
        span = round(low / MOTION_FPS, 3), round(high / MOTION_FPS, 3)
        rows.append(answers.ShownActivity(int(activity), *span, words))
    return rows


def _likely_words(session: Session, capture_id: int, low: int, high: int) -> list[str]:
    """The two likeliest words of an interval (frames), from its motion alone."""
    if not store.is_learned(session.store) or not session.learned.has_words:
        return []
    learned = session.learned
    if capture_id not in learned.rows:
        return []
    rows = learned.rows[capture_id]
    starts, ends = learned.segments.starts[rows], learned.segments.ends[rows]
    inside = np.maximum(np.minimum(ends, high) - np.maximum(starts, low), 0)
    if not inside.any():
        return []
    mean = inside @ learned.segment_probabilities[rows] / inside.sum()
    mean = np.where(learned.is_known() & learned.checked, mean, 0.0)
    order = np.argsort(-mean, kind="stable")[:2]
    return [learned.association.words[w] for w in order if mean[w] > LIKELY]


def draw_capture(session: Session, name: str, path: str | Path | None) -> Path | Figure:
    """A strip of stick figures with the timelines of symbols and words under it."""
    info = store.load_capture(session.store, name)
    motion = store.load_motion(session.store, info.capture_id)
    timelines = []
    captions = store.load_captions(session.store, [info.capture_id]).get(info.capture_id, ())
    if store.is_learned(session.store):
        spans = [
            (s.start, s.end, str(s.symbol), s.symbol)
            for s in capture_segments(session, info.capture_id)
        ]
        timelines.append(pictures.Timeline("symbols", spans))
    doing = capture_activities(session, info.capture_id)
    if doing:
        done = [
            (a.start, a.end, f"{a.activity} {' '.join(a.words)}".strip(), a.activity) for a in doing
        ]
        timelines.append(pictures.Timeline("activities", done))
    if captions:
        end = motion.n_frames / MOTION_FPS
        written = [(c.start or 0.0, c.end or end, c.words, c.words) for c in captions]
        timelines.append(pictures.Timeline("words", written))
    if store.is_learned(session.store) and session.learned.fitted_word_map is not None:
        said = []
        for d in describe(session.learned, motion):
            first = [(word, p) for word, p in d.words[:3] if (p or 0.0) > LIKELY]
            if all(p is None for _, p in d.words[:3]):  # no own caption has checked any
                first = [*d.words[:1]]
            said.append((d.start, d.end, " ".join(word for word, _ in first), d.words[0][0]))
        timelines.append(pictures.Timeline("recognised", [span for span in said if span[2]]))
    return pictures.save_png(pictures.strip_figure(motion, info.name, timelines), path)


def _timed(words: str, start: float | None, end: float | None) -> str:
    if start is None and end is None:
        return words
    return f"{start or 0:g}-{'end' if end is None else f'{end:g}'} s: {words}"


def _sources(session: Session, capture_id: int) -> list[str]:
    provenance = store.load_provenance(session.store, capture_id)
    numbers = provenance.source_numbers
    return [
        f"{s.name} (frames {int((numbers == n).sum())}, licence {s.licence or '?'})"
        for n, s in enumerate(provenance.sources)
    ]


_STANDS = "no gait: no foot swings to another place and strikes there, with the other in turn"


def gait_of(
    session: Session,
    example: Example,
    start: float | None = None,
    end: float | None = None,
    png: str | Path | None = None,
) -> answers.GaitReport:
    """Find foot strikes, and measure the cycles between them, as ``Captures.gait`` says."""
    name = str(example) if isinstance(example, str | Path) else "motion"
    clip, joint_map = _clip_of(session, example)
    clip = cut_clip(clip, start, end)
    points, belt = gait.over_ground(retarget.clip_keypoints(clip, joint_map), clip.fps)
    events = gait.foot_events(points, clip.fps)
    cycles = gait.gait_cycles(points, clip.fps, events)
    angles = gait.cycle_angles(points, clip.fps, cycles)
    prints = gait.foot_prints(points, clip.fps, events)
    notes = [] if events else [_STANDS]
    if belt:
        notes.append(f"on a treadmill at {belt:.2f} m/s: lengths are those over the belt")
    if events and not cycles:
        notes.append("no whole cycle: no foot strikes twice with one strike of the other between")
    steady = gait.steady(cycles)
    if len(steady) < len(cycles):
        uneven = len(cycles) - len(steady)
        notes.append(f"the measures leave out {uneven} of {len(cycles)} cycles that start or stop")
    if png is not None:
        if not events:
            raise QueryError(f"{name}: expected steps to draw, found {_STANDS}.")
        stances = {
            side: float(np.mean([c.stance for c in cycles if c.side == side]))
            for side in {c.side for c in cycles}
        }
        pictures.save_png(pictures.gait_figure(name, prints, angles, stances), png)
    return answers.GaitReport(
        name,
        round(clip.duration, 3),
        clip.fps,
        tuple(events),
        cycles,
        gait.measures(steady),
        angles,
        prints,
        round(belt, 3),
        tuple(notes),
        None if png is None else Path(png),
    )


def _clip_of(session: Session, example: Example) -> tuple[Clip, dict[str, str]]:
    """Return the clip of an example, and the joint map with which it was added."""
    from motiondb.database.catalogue.exporting import added_joint_map, load_clip
    from motiondb.files.formats import read_capture, split_take
    from motiondb.files.safe_files import is_file

    if isinstance(example, Clip):
        return example, {}
    if isinstance(example, Motion):
        return retarget.to_clip(example), {}
    if is_file(split_take(example)[0]):
        return read_capture(example), {}
    with session.reading():
        info = store.load_capture(session.store, str(example), or_file=True)
        if info.kind == "generated":
            return retarget.to_clip(store.load_motion(session.store, info.capture_id)), {}
        return load_clip(session, info.name), added_joint_map(session, info)
