"""The folder of a scene: motions, the whole scene, pictures, the report and the record.

``NAME.bvh`` for every character, in one world, so that all of them together are the scene, with
``NAME.bvh.provenance.json`` beside it; ``scene.glb`` with all characters and the ball;
``paths.png``, ``above.gif`` and ``scene.gif``; ``report.txt`` and ``report.json``; ``scene.json``,
from which ``scene update`` begins; the texts of the diagram and the grammar. The folder is written
under another name and then renamed, so that it is complete or absent.
"""

from __future__ import annotations

import json
import tempfile
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from motiondb import answers, pictures, store
from motiondb.answers import plain
from motiondb.body import body, retarget
from motiondb.database.generated_files import edits_in, leaves_out, runs_between, sources_of
from motiondb.database.scenes.scene_making import MadeScene, SceneProgress
from motiondb.database.scenes.scene_records import from_json, to_json, waiting
from motiondb.database.scenes.scene_texts import GRAMMAR, TACTICS, stored_text
from motiondb.errors import MotionDBError, SceneError
from motiondb.files.bvh_writer import write_bvh
from motiondb.files.formats import read_capture
from motiondb.files.gltf_writer import Character, write_gltf_scene
from motiondb.files.json_text import to_record
from motiondb.files.safe_files import check_output, read_bounded_text, unwritable, write_bytes
from motiondb.pictures.scenes import performer_colours
from motiondb.records import MOTION_FPS, Clip, IntArray, Motion
from motiondb.scene.language.activity import Thing
from motiondb.scene.language.tactics import Diagram
from motiondb.scene.report import report_records

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# The report of a scene as text and as facts for JSON.


_Span = tuple[int, int]  # The first evaluated frame of a rule, and the one after the last


def report_facts(scene: store.StoredScene) -> answers.SceneAnswer:
    """Return everything that is known of a scene, for JSON.

    Every rule has the frames [``start``, ``end``) in which it was evaluated and their number
    ``frames``.

    Values are metres for positions and lines, metres beyond the bounds for distances, degrees for
    directions and frames for synchronisations. The threshold of a position, a line or a direction
    is the weight of the rule, the deviation that costs 1; that of a synchronisation is two frames;
    a distance must be kept. All values are measured on the finished motions
    (:mod:`motiondb.scene.report.scene_report`), in the frames in which a rule is evaluated: one,
    or, for throughout, those of its own actions and no others.
    """
    rest = {key: value for key, value in scene.report.items() if key != "rule_frames"}
    return answers.extended(
        answers.SceneAnswer,
        to_record(answers.SceneDetails, rest, "report"),
        scene=scene.name,
        characters=len(scene.players),
        clips=sum(len(player.clips) for player in scene.players),
        frames=scene.n_frames,
        seconds=round(scene.n_frames / MOTION_FPS, 3),
        error=scene.error,
        rules=len(scene.rules),
        broken=sum(not rule.kept for rule in scene.rules),
        settings=dict(scene.settings),
        ball=bool(len(scene.ball)),
        actions={
            player.name: tuple(clip.terminal for clip in player.clips) for player in scene.players
        },
        by_rule=tuple(
            answers.extended(
                answers.MeasuredRule,
                rule,
                rule=rule.kind,
                before=round(rule.before, 4),
                after=round(rule.after, 4),
                threshold=round(rule.threshold, 4),
                start=start,
                end=end,
                frames=end - start,
            )
            for rule, (start, end) in _spans(scene)
        ),
    )


def _spans(record: store.StoredScene) -> list[tuple[store.SceneRule, _Span]]:
    """Return the rules, each with its first evaluated frame and the one after the last."""
    frames = record.report["rule_frames"]
    return [(rule, (start, end)) for rule, (start, end) in zip(record.rules, frames, strict=True)]


def report_text(scene: store.StoredScene) -> str:
    """Return how well a scene keeps each rule, collisions and sources, as text."""
    facts = report_facts(scene)
    lines = [
        f"{scene.name}: {facts.characters} characters, {facts.clips} clips,"
        f" {scene.n_frames} frames ({facts.seconds:.1f} s)",
        f"error -log P(Z) {scene.error:.2f} as sampled; seed {scene.settings.get('seed')}",
        *cut_short_lines(facts),
        "",
    ]
    lines += [f"{name:6} {' '.join(actions)}" for name, actions in facts.actions.items()]
    lines += ["", *seen_lines(facts)]
    lines += [f"rules kept: {facts.rules - facts.broken} of {facts.rules}", ""]
    lines += _table(
        ["player", "action", "rule", "about", "before", "after", "threshold", "frame", ""],
        [_rule_row(rule, span, scene.n_frames) for rule, span in _spans(scene)],
    )
    lines += ["", f"collisions:{'' if facts.collisions else ' none'}"]
    lines += [
        f"  {' and '.join(c.players)}, frames {c.start} to {c.end}, {c.depth:.2f} m deep"
        for c in facts.collisions
    ]
    lines += impossible_lines(facts)
    lines += [*_guard_lines(facts), *_feet_lines(facts), "", "made from:"]
    lines += [f"  {s.capture}, licence {s.licence}, {s.frames} frames" for s in facts.sources]
    return "\n".join(lines)


def cut_short_lines(facts: answers.SceneAnswer) -> list[str]:
    """Return a line if a limit of time ended the sampling, else no line."""
    if not facts.cut_short:
        return []
    minutes, at = float(facts.settings.get("minutes") or 0.0), facts.cut_at
    ended = f"; it ended after {at['rounds']} of {at['of']} rounds of try {at['try']}" if at else ""
    return [
        f"sampling was cut short by --minutes {minutes:g}: the seed alone does not determine this "
        f"scene, and more minutes may improve it{ended}"
    ]


def _rule_row(rule: store.SceneRule, span: _Span, n_frames: int) -> list[str]:
    start, end = span
    frames, fault = str(rule.frame), "" if rule.kept else "BROKEN"
    if end - start > 1:
        frames = f"{start}-{end - 1}, {end - start} of {n_frames}"
        fault += f", most at {rule.frame}" * (not rule.kept)
    shown = [
        f"{value:.2f} {rule.unit}".rstrip() for value in (rule.before, rule.after, rule.threshold)
    ]
    action = f"{rule.action} ({rule.clip + 1})"
    return [rule.player, action, rule.kind, rule.about, *shown, frames, fault]


_IMPOSSIBLE = {
    "airborne": "both feet in the air for {value:.0f} frames, at most {limit:.0f} are possible",
    "speed": "travels at {value:.1f} m/s, at most {limit:.1f} m/s is possible",
    "step": "feet {value:.2f} m apart, at most {limit:.2f} m is possible",
    "foot jump": "a planted foot jumps by {value:.2f} m, at most {limit:.2f} m is possible",
    "limbs": "limbs pass through each other",
}


def impossible_lines(facts: answers.SceneAnswer) -> list[str]:
    """Return the impossible motion of a scene, one line each."""
    if not facts.impossible:
        return ["impossible motion: none"]
    return ["impossible motion:"] + [
        f"  {' and '.join(m.players)}{' ' * bool(m.action)}{m.action}, {_frames(m)}: "
        + _IMPOSSIBLE[m.kind].format(value=m.value, limit=m.limit)
        for m in facts.impossible
    ]


def _frames(motion: report_records.ImpossibleMotion) -> str:
    start, last = motion.start, motion.end - 1
    if start == last:
        return f"frame {start}"
    return f"frames {start} to {last}, most at {motion.frame}"


_SEEN = {
    "guard": "{0} guards {1}, and is out of the grammar's bounds in {share:.0f} % of the frames",
    "stands": "{0} stands for {value:.1f} of {all:.1f} s",
    "held pose": "{0} holds a pose without moving for {value:.1f} s",
    "misses": "what {0} sends misses the {1} by {value:.2f} m",
    "object": "the object passes through {0}",
    "reach": "{0} reaches for the object, which is {value:.1f} m away",
    "order": "{1} does step {value:.0f} before {0} does an earlier one",
    "place": "{0} passes through the {1}",
    "leap": "{0} goes from {1} to {2} at once, with no clip that leads there",
    "limbs": "limbs of {0} and {1} touch, {value:.2f} m between their bones",
}


def seen_lines(facts: answers.SceneAnswer) -> list[str]:
    """Return what a viewer sees at once although no rule is about it, one line each."""
    told = [
        _SEEN[one.kind].format(
            *one.players, value=one.value, share=100.0 * one.value, all=facts.seconds
        )
        + f", frames {one.start} to {one.end - 1}" * (one.kind != "guard")
        for one in facts.seen
    ]
    return ["seen at once, whatever the rules:", *(f"  {line}" for line in told)] if told else []


def _guard_lines(facts: answers.SceneAnswer) -> list[str]:
    guards = facts.guards
    return ["distance of guards over all frames (rules use those of guarding):"] * bool(guards) + [
        f"  {g.player} from {g.target}: outside {g.near:g} to "
        f"{np.inf if g.far is None else g.far:g} m in {100 * g.outside:.0f} % of "
        f"{facts.frames} frames (rules use {g.n_frames}), "
        f"farthest {g.farthest:.1f} m at frame {g.frame}"
        for g in guards
    ]


def _feet_lines(facts: answers.SceneAnswer) -> list[str]:
    lines = ["feet on the ground slide (in the captures), m/s:"]
    lines += [f"  {name:6} {slip:.3f} ({there:.3f})" for name, (slip, there) in facts.feet.items()]
    jumps, paces = facts.planted_feet, facts.paces
    lines += ["largest jump of a planted foot within 0.3 s (in the captures), m:"] * bool(jumps)
    lines += [
        f"  {j.player:6} {j.metres:.3f} ({j.source_metres:.3f})"
        + f", {j.foot} foot, frames {j.start} to {j.end}" * bool(j.foot)
        for j in jumps
    ]
    lines += ["fastest on the ground, as sampled and after polish, m/s:"] * bool(paces)
    lines += [f"  {p.player:6} {p.before:.1f} {p.after:.1f}" for p in paces]
    gap = facts.ball_gap
    return lines + ([] if gap is None else [f"ball to palm while held: {gap:.2f} m at most"])


def source_list(provenances: Sequence[store.Provenance]) -> tuple[answers.Source, ...]:
    """Return the captures that a scene's frames come from, each once, with licence and frames."""
    frames: Counter[tuple[str, str, str]] = Counter()
    for source in (source for one in provenances for source in sources_of(one)):
        frames[source.capture, source.licence, source.sha256] += source.frames
    return tuple(answers.Source(*key, count) for key, count in sorted(frames.items()) if count)


def _table(columns: list[str], rows: list[list[str]]) -> list[str]:
    """Return the lines of a table, with columns as wide as necessary."""
    widths = [max(len(cell) for cell in column) for column in zip(columns, *rows, strict=True)]
    return [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in [columns, *rows]
    ]


RECORD = "scene.json"  # Name of the file with the record of a scene


def fill_scene_folder(
    made: MadeScene,
    record: store.StoredScene,
    provenance: Mapping[str, store.Provenance],
    folder: Path,
    progress: SceneProgress,
    drawn: bool = True,
) -> None:
    """Write everything of a scene into an empty folder, such as :func:`whole_folder` gives."""
    motions = {player.player: player.motion for player in made.polished.players}
    for player in made.polished.players:
        name = player.player
        write_bvh(in_world(player.motion), folder / f"{name}.bvh")
        facts = {
            "scene": record.name,
            "player": name,
            "seed": made.settings.seed,
            "actions": list(made.state.players[_number(made, name)].tree.leaves()),
            "sources": [asdict(source) for source in sources_of(provenance[name])],
            "frames": action_runs(player.clips, made, name, provenance[name]),
        }
        _write(folder / f"{name}.bvh.provenance.json", json.dumps(facts, indent=1))
    _write_gltf(folder / "scene.glb", made.text.diagram, motions, record)
    _write(folder / RECORD, to_json(record))
    _write(folder / f"diagram{TACTICS}", record.diagram)
    _write(folder / f"{made.text.diagram.grammar}{GRAMMAR}", record.grammar)
    _write(folder / "report.json", json.dumps(plain.to_json(report_facts(record)), indent=1))
    _write(folder / "report.txt", report_text(record) + "\n")
    if drawn:
        _draw(folder, made.text.diagram, motions, record, progress)


def in_world(motion: Motion) -> Clip:
    """Return a motion as a clip in the scene's metres: every player has the same body."""
    return retarget.to_clip(replace(motion, leg_length=body.LEG_LENGTH))


def _number(made: MadeScene, name: str) -> int:
    return [player.name for player in made.text.diagram.players].index(name)


def _write(path: Path, text: str) -> None:
    write_bytes(path, text.encode())


def _write_gltf(
    path: Path, diagram: Diagram, motions: Mapping[str, Motion], record: store.StoredScene
) -> None:
    colours = performer_colours(diagram)
    people = [
        Character(name, in_world(motion), _linear(colours[name]))
        for name, motion in motions.items()
    ]
    thing = diagram.activity.thing or Thing("ball")
    write_gltf_scene(people, path, record.ball, thing.size / 2.0)


def _linear(colour: str) -> tuple[float, float, float]:
    """Return red, green and blue in linear light, as glTF needs them, of "#rrggbb"."""
    red, green, blue = (round((int(colour[k : k + 2], 16) / 255.0) ** 2.2, 4) for k in (1, 3, 5))
    return red, green, blue


def _draw(
    part: Path,
    diagram: Diagram,
    motions: Mapping[str, Motion],
    record: store.StoredScene,
    progress: SceneProgress,
) -> None:
    ball = record.ball if len(record.ball) else None
    progress("drawing", 0.0, record.error)
    pictures.save_png(pictures.scene_paths_figure(diagram, motions, ball), part / "paths.png")
    progress("drawing", 0.2, record.error)
    pictures.draw_scene_animation(diagram, motions, part / "above.gif", ball, above=True)
    progress("drawing", 0.6, record.error)
    pictures.draw_scene_animation(diagram, motions, part / "scene.gif", ball)
    progress("drawing", 1.0, record.error)


def action_runs(
    clips: IntArray, made: MadeScene, name: str, provenance: store.Provenance
) -> list[dict[str, Any]]:
    """Return runs of frames of one action: their capture, its frames, and what was done to them.

    Waiting is a separate run, and a new run begins after frames that were left out.
    """
    actions = made.state.players[_number(made, name)].tree.leaves()
    numbers = np.asarray(clips)
    waits = waiting(provenance.edits)
    changed = (np.diff(numbers) != 0) | (waits[1:] != waits[:-1]) | leaves_out(provenance)
    return [
        {
            "start": start,
            "end": end,
            "action": actions[int(numbers[start])],
            "capture": provenance.sources[int(provenance.source_numbers[start])].name,
            "source_start": round(float(provenance.source_frames[start]), 2),
            "source_end": round(float(provenance.source_frames[end - 1]), 2),
            "edits": edits_in(provenance, start, end),
        }
        for start, end in runs_between(changed)
    ]


def check_scene_folder(folder: str | Path) -> None:
    """Refuse a folder that cannot be written, or holds something else than a scene."""
    folder = Path(folder)
    if not folder.absolute().parent.is_dir():
        raise MotionDBError(
            f"{folder}: expected the folder {folder.parent}, found none. Make the folder first."
        )
    try:
        check_output(folder, is_folder=True)
        Path(tempfile.mkdtemp(prefix=f".{folder.name}.", dir=folder.absolute().parent)).rmdir()
    except OSError as error:
        raise unwritable(folder, error) from None
    if not folder.exists():
        return
    if not folder.is_dir():
        raise MotionDBError(f"{folder}: expected a folder, found a file. Name another.")
    if any(folder.iterdir()) and not (folder / RECORD).is_file():
        raise MotionDBError(
            f"{folder}: expected a new folder, or one that holds a scene, found other files."
            " Name another."
        )


def read_scene_folder(folder: str | Path) -> store.StoredScene:
    """Return the scene of a folder."""
    path = Path(folder) / RECORD
    try:
        record = from_json(read_bounded_text(path), str(path))
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "other bytes than text"
        raise SceneError(
            f"{path}: expected the record of a scene, found: {reason}."
            " Make the scene with motiondb scene make, or name the folder of one."
        ) from None
    try:
        report_text(record)
    except (ValueError, KeyError, TypeError, AttributeError, IndexError) as error:
        raise SceneError(
            f"{path}: expected a record that can be reported, found"
            f" {type(error).__name__}: {error}. It was changed by hand: make the scene again."
        ) from None
    return record


def draw_folder(folder: str | Path, path: str | Path | None = None) -> Path | Figure:
    """Draw the paths of the characters of a folder's scene over its diagram, as PNG."""
    record = read_scene_folder(folder)
    diagram = stored_text(record.diagram, record.grammar, str(folder)).diagram
    files = {player.name: Path(folder) / f"{player.name}.bvh" for player in record.players}
    motions = {name: retarget.to_motion(read_capture(file)) for name, file in files.items()}
    return pictures.save_png(pictures.scene_paths_figure(diagram, motions, record.ball), path)
