"""Commands add, show, export and fetch: captures in and out."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

import motiondb
from motiondb.cli import options, printing

app = options.Commands()
fetching = app.group("fetch", "Download captures from public databases.")


@app.command()
def add(
    shared: options.Shared,
    folders: Annotated[
        list[Path],
        options.argument(
            "Folders with captures, or capture files.", "FOLDER...", parser=options.a_path
        ),
    ],
    words: Annotated[Path | None, "A sheet of captions and tags (TSV or CSV)."] = None,
    events: Annotated[Path | None, "A sheet of events (TSV or CSV)."] = None,
    unit: Annotated[str | None, "Length unit: m, cm, mm, inch or a number."] = None,
    fps: Annotated[
        float | None,
        options.option(
            "Frames per second, in place of the rates in the files.", min=1.0, max=10_000.0
        ),
    ] = None,
    up: options.Up = "",
    mirror_world: Annotated[bool, "The axes of the files are left-handed."] = False,
    swap_sides: Annotated[bool, "The names of left and right are exchanged."] = False,
    joint_map: Annotated[
        Path | None, "A file of lines `role = joint` for unknown joint names."
    ] = None,
    skip_bad_frames: Annotated[bool, "Leave out frames that cannot be read."] = False,
    keep_implausible: Annotated[bool, "Also add motion too fast for people."] = False,
    skeleton: Annotated[
        Path | None,
        "A model (MJCF, URDF or .osim), an ASF, or a text file of joint names, for captures "
        "whose sheet names none.",
    ] = None,
    outside_skeletons: Annotated[bool, "Let sheets name ASF files outside FOLDER."] = False,
    time_limit: Annotated[
        float,
        options.option(
            "Seconds allowed for a file of up to 10 MB; larger files get proportionally more.",
            min=0.1,
            max=1e6,
        ),
    ] = 60.0,
    memory_limit: Annotated[
        float,
        options.option(
            "Largest size in memory of the clip of a file, in gigabytes.", min=0.01, max=1e4
        ),
    ] = 0.4,
    jobs: Annotated[int, options.option("Processes that read files.", min=1, max=1024)] = 2,
    prefix: options.Prefix = "",
    replacing: Annotated[
        bool,
        options.option(
            "Replace captures of the same names; words, tags and events that no sheet gives "
            "are kept. Reads known files again where options say how.",
            "--replace",
        ),
    ] = False,
    no_originals: Annotated[
        bool, "Keep the motions without the files, which then cannot be exported as they were."
    ] = False,
    check_bytes: Annotated[
        bool, "Compare the bytes of known files, too, not only their size and time."
    ] = False,
    cluster: options.Cluster = None,
) -> None:
    """Add captures, with captions and events of sheets.

    Unreadable files are skipped and listed (exit code 1). Files that are as they were when they
    were added are not read again, and are no faults if they were faulty then.
    """
    for folder in folders:
        motiondb.check_captures(folder)
    settings = motiondb.AddSettings(
        unit=motiondb.unit_from_name(unit) if unit else None,
        fps=fps,
        up=motiondb.check_up(up, "--up"),
        mirror_world=mirror_world,
        swap_sides=swap_sides,
        skip_bad_frames=skip_bad_frames,
        joint_map=motiondb.read_joint_map(joint_map) if joint_map else {},
        jobs=jobs,
        limits=motiondb.ReadLimits(seconds=time_limit, memory=int(memory_limit * 1e9)),
        keep_implausible=keep_implausible,
        skeleton=skeleton,
        outside_skeletons=outside_skeletons,
        prefix=prefix,
        replace=replacing,
        originals=not no_originals,
        check_bytes=check_bytes,
    )
    with (
        printing.cluster(cluster) as workers,
        shared.database(writing=True, create=True) as base,
        printing.progress(shared) as tell,
    ):
        report = base.add(folders, words, settings, tell, events, workers)
        facts, drift = base.info(), base.symbols.drift()
        wordless = not (facts.captures_with_words or base.symbols.start_facts())
    if not printing.as_json(shared, report, captures=facts.captures, drift=drift):
        printing.say(
            f"{printing.number(len(report.added), 'capture')} added ({report.seconds:.0f} s of "
            f"motion), {len(report.known)} already there, "
            f"{printing.number(len(report.problems), 'problem')}; "
            f"{printing.number(facts.captures, 'capture')} in {shared.db}."
        )
        if report.counted:
            printing.say(f"  {report.counted} of them can be searched now")
        if report.replaced:
            printing.say(f"  {len(report.replaced)} of them replaced captures of the same names")
        if report.events:
            printing.say(f"  {printing.number(report.events, 'event')} added with them")
        _note_performers(report.without_performer)
        for relation in report.relations:
            printing.say(f"  {printing.say_relation(relation)}")
        for name, known in report.known:
            if name != known:
                printing.say(f"  {name} is the same file as {known}")
        heads = [problem.splitlines()[0] for problem in report.known_faulty]
        printing.say(*(f"  known to be faulty, and as before: {head}" for head in heads))
        printing.print_notes(report.notes)
        printing.note_drift(drift)
        if wordless and report.added:
            _offer_start()
    printing.refuse(report.problems)


def _offer_start() -> None:
    """Print advice for captures without captions."""
    for start in motiondb.shipped_starts():
        printing.say(
            f"  no captions were added: motiondb learn --start {start['name']} provides "
            f"{start['words']} words, learned from {start['captions']} described captures of "
            f"others; then search, describe and generate work"
        )


def _note_performers(count: int) -> None:
    """Print how captures without a given performer are grouped."""
    if count:
        printing.say(
            f"  no performer is given for {count} of them. Captures of one folder count as one "
            f"performer; in a single folder, captures whose names differ only in the last number "
            f"do. Give performers in the column `performer` of a sheet (motiondb words import "
            f"SHEET)"
        )


@app.command()
def show(
    shared: options.Shared,
    name: options.CaptureName,
    png: options.Png = None,
    gif: Annotated[
        Path | None, options.animation("Write an animation to this file (.gif).")
    ] = None,
    start: options.From = None,
    end: options.To = None,
    html: options.Html = None,
) -> None:
    """Show one capture: its properties, symbols, activities and words.

    --png draws a strip of figures with timelines. --gif animates the capture, or the part from
    --from to --to.
    """
    with shared.database() as base:
        facts = base.captures.show(name)
        if png:
            base.captures.draw(name, png)
        if gif:
            base.captures.animate(name, gif, start, end)
        if html:
            printing.write_html(html, motiondb.StandalonePage.of_capture(base, name))
    if printing.as_json(shared, replace(facts, png=png, gif=gif)):
        return
    shown: dict[str, Any] = {}
    for key, value in vars(facts).items():
        shown |= value if key == "tags" else {key: value}
    for key, value in shown.items():
        for line in _lines(key, value):
            printing.say(line)
    for file in filter(None, (png, gif)):
        printing.say(f"picture:      {file}")


def _lines(key: str, value: Any) -> list[str]:  # noqa: ANN401  a fact may be of any type
    """Lines of text for one fact of a capture."""
    head = f"{key.replace('leg_length', 'leg length') + ':':13}"
    if key == "segments" and value:
        spans = (f"{s.symbol}[{s.start:.1f}-{s.end:.1f}]" for s in value)
        return [f"segments:     {' '.join(spans)}"]
    if key == "activities":
        return [
            f"{'activity:':13} {a.activity}  {a.start:.1f}-{a.end:.1f} s  "
            f"{' '.join(a.words)}".rstrip()
            for a in value
        ]
    if isinstance(value, list):
        return [f"{head} {item if isinstance(item, str) else _flat(item)}" for item in value]
    if value in ("", None, {}):
        return []
    return [f"{head} {_flat(value) if isinstance(value, dict) else value}"]


def _flat(value: dict[str, object]) -> str:
    return ", ".join(f"{k} {v}" for k, v in value.items() if v is not None)


@app.command()
def export(
    shared: options.Shared,
    changes: options.Changes,
    name: options.CaptureName,
    output: Annotated[
        Path,
        options.output(
            "File: .bvh, .glb, .gltf, .fbx or .usd; arrays: .npz, .csv or .parquet; or as it "
            "was added.",
            options.any_name,
        ),
    ],
    start: options.From = None,
    end: options.To = None,
    canonical: Annotated[bool, "Write the canonical body at 30 frames a second."] = False,
    form: Annotated[
        str, options.option("humanml3d: a folder; CAPTURE may be a filter.", "--as")
    ] = "",
) -> None:
    """Write a capture to a file; in its original format, the file is the added one.

    With an option that changes the motion, or a part of it, a new file is written.
    """
    asked = changes.read()
    if form:
        _export_set(shared, name, output, form, (start, end, canonical or None, asked))
        return
    with shared.database() as base:
        exported = base.export(name, output, start, end, canonical, asked)
    if printing.as_json(shared, exported):
        return
    what = "the added file" if exported.is_added_file else f"in {exported.unit}"
    printing.say(
        f"{exported.capture} written to {exported.output}: "
        f"{printing.number(exported.frames, 'frame')} at {exported.fps:g} a second, {what}"
    )
    if exported.skeleton is not None:
        printing.say(f"  its skeleton: {exported.skeleton}")
    if exported.unit == "cmu" and not exported.is_added_file:
        size = 100.0 * motiondb.unit_from_name("cmu")
        printing.say(
            f"Lengths are in the capture's own unit (1 unit = {size:.2f} cm). Use --unit cm for "
            "centimetres."
        )
    for line in exported.changes:
        printing.say(f"  {line}")


def _export_set(
    shared: options.Shared, where: str, folder: Path, form: str, others: tuple[object, ...]
) -> None:
    """Write captures as a data set."""
    if form.lower() != "humanml3d":
        raise motiondb.QueryError(f"--as: expected humanml3d, found {form!r}.")
    if others != (None, None, None, motiondb.MotionChanges()):
        raise motiondb.QueryError(
            "--as: expected a capture or a filter alone, found an option that changes the motion. "
            "Leave it out."
        )
    with shared.database() as base:
        written = base.captures.to_humanml3d(where, folder)
    if printing.as_json(shared, written):
        return
    printing.say(
        f"{printing.number(written.captures, 'capture')} written to {written.folder}: "
        f"{printing.number(written.frames, 'frame')} at 20 a second, "
        f"{printing.number(written.captions, 'caption')}"
    )
    if written.without_captions:
        printing.say(f"  {written.without_captions} have no captions, and are not in all.txt")
    for line in written.left_out:
        printing.say(f"  {line}")


@app.command()
def joints(
    shared: options.Shared,
    name: Annotated[
        str,
        options.argument("A file (.bvh, .fbx, .glb, .gltf), or a capture's name.", "FILE|CAPTURE"),
    ],
    output: Annotated[
        Path | None, options.output("Write a joint map (.map).", options.output_name)
    ] = None,
) -> None:
    """Show which joints of a file have which roles; propose them for unknown names.

    The joint map that -o writes is for add and export --onto (--joint-map).
    """
    if Path(name).is_file():
        found = motiondb.propose_joints(name, output)
    else:
        with shared.database() as base:
            found = motiondb.propose_joints(base.clip(name), output, name)
    if printing.as_json(shared, found):
        return
    how = "known names" if found.is_known else "names of no convention: these roles are a proposal"
    printing.say(f"{name}: {printing.number(found.joints, 'joint')}, {how}")
    for role, joint in found.roles.items():
        printing.say(f"  {role} = {joint}")
    if found.missing:
        printing.say(f"  not found, but needed: {', '.join(found.missing)}")
    if output is not None:
        printing.say(f"joint map: {output}")


@fetching.command("cmu")
def fetch_cmu(
    shared: options.Shared,
    subjects: Annotated[str, "Numbers of subjects, such as 14,16."],
    folder: Annotated[Path, options.option("The folder for the files.", "--dir")] = Path("cmu"),
    yes: Annotated[bool, "Accept the terms without being asked."] = False,
    only_fetch: Annotated[bool, "Do not add the files to the database."] = False,
    base_url: Annotated[str | None, "Address of another site with the same files."] = None,
    deadline: Annotated[
        float, options.option("Seconds for the whole download.", min=1.0, max=1e6)
    ] = 21_600.0,
) -> None:
    """Download captures and captions of the CMU Graphics Lab database, and add them."""
    printing.warn(*motiondb.CMU_TERMS.split("\n"))
    no_answer = "terms: expected yes or no, found no answer. Accept them with --yes."
    if not yes and not printing.confirmed("Do you accept these terms?", no_answer):
        raise typer.Exit(2)
    wanted = [s.strip() for s in subjects.split(",") if s.strip()]
    with printing.progress(shared) as tell:
        settings = motiondb.FetchSettings(
            base_url or motiondb.CMU_URL, limits=motiondb.FetchLimits(seconds=deadline)
        )
        report = motiondb.fetch_cmu(
            wanted,
            folder,
            settings,
            accept_terms=True,
            on_progress=lambda p: tell("fetching", p.number, p.n_files),
        )
    if not printing.as_json(shared, report):
        printing.say(
            f"{len(report.fetched)} files fetched into {folder}, "
            f"{len(report.skipped)} there already"
        )
    printing.print_problems([f"{file}: {reason}" for file, reason in report.refused])
    if not only_fetch and report.sheet.exists():
        add(shared, [folder], report.sheet)
    if report.refused:
        raise typer.Exit(1)
