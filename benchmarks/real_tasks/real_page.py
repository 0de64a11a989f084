"""The findings on real captures as a page of Markdown."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from measured_run import machine, versions

from motiondb.generate.motion_making import METHODS
from motiondb.generate.shown_actions import JudgedAction
from motiondb.records import Match
from real_tasks.answers import (
    FIRST,
    ExampleResult,
    Judged,
    MadeResult,
    WordResult,
    median_smoothness,
)
from real_tasks.findings import Findings
from real_tasks.notes import Notes
from real_tasks.questions import SEED

PACKAGES = ("motiondb", "numpy", "scipy", "scikit-learn", "numba", "duckdb")
COMMAND = "python benchmarks/real_captures.py --data DIR"
TERMS = """The data used in this project was obtained from mocap.cs.cmu.edu. The database was
created with funding from NSF EIA-0196217. Words: the CMU index as compiled by B. Hahne (2008);
sentences for some captures from the KIT Motion-Language annotations. Known parts of long takes:
mocap6 (M. Hughes; Fox, Hughes, Sudderth, Jordan, 2014) and, for performer 86, after Zhou, De la
Torre and Hodgins (aligned cluster analysis). None of these data are part of this project. The page
shows what motiondb answers on them."""

ASKED = """Each question was asked three times: with the written words of each capture as evidence
beside its motion, as in normal use; with the written words hidden, so that only the motion counts,
by a map that was learned from these captions; and with a map that was learned without the words of
the capture's performer, as for a new performer. An answer is right if the capture's description has
all words of the question. An asterisk marks answers that a person judged from the
pictures; that verdict counts."""
MEASURES = """Slip is the mean ground speed of feet in contact (0 if no foot is ever in contact).
Jerk is the mean over joints and frames. Both are measured on the standard body at 30 frames per
second. *Shown* counts the actions that motiondb's judge says are shown (probability .6 or more);
the judge has no part in making the motion and never sees the captures used. The last two columns
count the sentences whose motion, when it is recognised again, gives exactly the symbols that it was
made from (those of the excerpts, or those decoded): as they are, and after repeats of a symbol are
merged."""


def write_report(findings: Findings, path: Path) -> Path:
    """Write the page; return its path."""
    blocks = [
        f"# Answers on real captures\n\nWritten by `{COMMAND}` on {machine()}; "
        f"{versions(*PACKAGES)}. {TERMS}",
        _note(findings.notes, "summary"),
        _sizes(findings),
        _words(findings),
        _parts(findings),
        _examples(findings),
        _made(findings),
    ]
    path.write_text("\n\n".join(block for block in blocks if block) + "\n", encoding="utf-8")
    return path


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table in Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def _note(notes: dict[str, Notes], key: str) -> str:
    """Prose of the notes, then a line for each verdict."""
    note = notes.get(key)
    if note is None:
        return ""
    lines = [f"- {name}, {verdict}: {why}" for name, (verdict, why) in note.verdicts.items()]
    return "\n\n".join(part for part in (note.prose, "\n".join(lines)) if part)


def _sizes(findings: Findings) -> str:
    n, stages = findings.counts, findings.stages
    rows = [
        ["captures", f"{n['captures']:.0f} of {n['performers']:.0f} performers"],
        ["motion", f"{n['seconds']:.0f} s"],
        ["segments", f"{n['segments']:.0f}"],
        ["motion symbols", f"{n['symbols']:.0f}, chosen by description length"],
        ["symbol space", f"{n['dimensions']:.0f} dimensions, {n['clusters']:.0f} clusters"],
        ["words", f"{n['words']:.0f}, {n['words twice']:.0f} of them in two captions or more"],
        ["database file", f"{n['bytes'] / 1e6:.0f} MB"],
        ["copies, mirror images and cuts", f"{len(findings.relations)}"],
    ]
    for name, stage in (("add", stages.add), ("learn", stages.learn)):
        if stage is not None:
            memory = f"{stage.peak_bytes / 2**30:.2f} GiB"
            rows.append(
                [f"`{name}`", f"{stage.seconds:.0f} s, at most {memory} (children included)"]
            )
    if stages.add is not None and stages.learn is not None:
        total = stages.add.seconds + stages.learn.seconds
        rows.append(["both", f"{total:.0f} s (target: 240 s, 3 GiB)"])
    else:
        rows.append(
            ["`add`, `learn`", "not measured in this run, because the database existed already"]
        )
    rows.append(["questions, generation, pictures of this page", f"{findings.seconds:.0f} s"])
    problems = "".join(f"\n- {problem}" for problem in findings.problems)
    return "\n\n".join(
        part
        for part in (
            "## Catalogue and learning",
            table(["what", "measured"], rows),
            f"Not added:\n{problems}" if problems else "",
            f"Not added, because the content is that of another capture: "
            f"{', '.join(findings.known)}."
            if findings.known
            else "",
            _note(findings.notes, "catalogue"),
            "![The symbol space](pictures/symbols.png)",
            "The symbols and words of one long take:",
            "![A long take](pictures/take-14-06.png)",
        )
        if part
    )


def _words(findings: Findings) -> str:
    shown = [
        [r.words, f"{r.there}", *(_score(j) for j in (r.written, r.alone, r.unseen))]
        for r in findings.words
    ]
    columns = [
        sum(sum(j.right == "yes" for j in getattr(r, name)) for r in findings.words)
        for name in ("written", "alone", "unseen")
    ]
    possible = sum(min(FIRST, r.there) for r in findings.words)
    shown.append(["**together**", "", *(f"**{c} of {possible}**" for c in columns)])
    precision = [
        [name, f"{p.words}", f"{p.precision:.3f}", f"{p.chance:.3f}"]
        for name, p in findings.precision.items()
    ]
    return "\n\n".join(
        part
        for part in (
            "## Twenty questions in words",
            ASKED,
            table(
                [
                    "question",
                    "captures",
                    "with written words",
                    "motion alone",
                    "unseen performers",
                ],
                shown,
            ),
            "Right answers among the first five. Mean average precision for single words that "
            "describe captures of two or more performers:",
            table(["captures ranked by", "words", "precision", "chance"], precision),
            _note(findings.notes, "words"),
            *(_word_section(r, findings.notes) for r in findings.words),
        )
        if part
    )


def _score(judged: Sequence[Judged]) -> str:
    return f"{sum(j.right == 'yes' for j in judged)}"


def _cell(judged: Sequence[Judged], place: int) -> str:
    if place >= len(judged):
        return ""
    j = judged[place]
    mark = "*" if j.looked else ""
    sure = "?" if j.match.probability is None else f"{j.match.probability:.2f}"
    return f"{j.match.capture} {_times(j.match)} ({sure}) {j.right}{mark}"


def _times(match: Match) -> str:
    """The interval of an answer; that of the capture where the place is not known."""
    where = "somewhere in " if match.place == "unknown" else ""
    return f"{where}{match.start:.1f}–{match.end:.1f} s"


def _answers(head: Sequence[str], columns: Sequence[Sequence[Judged]]) -> str:
    rows = [[str(k + 1), *(_cell(c, k) for c in columns)] for k in range(FIRST)]
    return table(["", *head], rows)


def _word_section(result: WordResult, notes: dict[str, Notes]) -> str:
    unknown = f"Not known: {', '.join(result.unknown)}." if result.unknown else ""
    parts = (
        f"### {result.words}",
        unknown,
        _answers(
            ["with written words", "motion alone", "unseen performers"],
            [result.written, result.alone, result.unseen],
        ),
        _note(notes, f"words: {result.words}"),
        f"![{result.words}](pictures/{result.picture})",
    )
    return "\n\n".join(part for part in parts if part)


def _parts(findings: Findings) -> str:
    rows = []
    for words, match, share, part in findings.parts:
        true = f"{part[0]:.1f}–{part[1]:.1f} s" if part else "elsewhere"
        rows.append([words, match.capture, _times(match), true, f"{share:.2f}"])
    if not rows:
        return ""
    mean = sum(row[2] for row in findings.parts) / len(findings.parts)
    return "\n\n".join(
        part
        for part in (
            "## Where in a long take",
            "Four long takes have parts known by hand. The words were searched in each take "
            "alone. The last column is the intersection over union of the answer and the nearest "
            f"true interval; its mean is {mean:.2f}.",
            table(["words", "capture", "found", "true", "overlap"], rows),
            _note(findings.notes, "parts"),
        )
        if part
    )


def _examples(findings: Findings) -> str:
    rows = [
        [
            r.example.name,
            f"{r.example.capture} {_example_times(r)}",
            f"{r.itself.capture} {_times(r.itself)}",
            _score(r.everybody),
            _score(r.others),
        ]
        for r in findings.examples
    ]
    return "\n\n".join(
        part
        for part in (
            "## Ten questions by example",
            "The example itself must be the first answer; it is not counted. An answer is right "
            "if its description has a word for what the example shows. In the four long takes, at "
            "least half of the interval must also lie in a part that shows it.",
            table(
                ["example", "interval", "rank 1", "right of 5, everybody", "other performers"], rows
            ),
            _note(findings.notes, "examples"),
            *(_example_section(r, findings.notes) for r in findings.examples),
        )
        if part
    )


def _example_times(result: ExampleResult) -> str:
    e = result.example
    return "whole" if e.end is None else f"{e.start:g}–{e.end:g} s"


def _example_section(result: ExampleResult, notes: dict[str, Notes]) -> str:
    name = result.example.name
    parts = (
        f"### like {name}",
        _answers(["everybody", "other performers"], [result.everybody, result.others]),
        _note(notes, f"like: {name}"),
        f"![like {name}](pictures/{result.picture})",
    )
    return "\n\n".join(part for part in parts if part)


def _made(findings: Findings) -> str:
    real = median_smoothness(findings.captured)
    rows = [["real captures", f"{real.slip:.1f}", f"{real.jerk:.0f}", "", "", ""]]
    for method in METHODS:
        median = median_smoothness([r.methods[method][0] for r in findings.made])
        again = [r.methods[method][1] for r in findings.made]
        exactly, merged = again.count("exactly"), len(again) - again.count("otherwise")
        counts = [f"{n} of {len(again)}" for n in (exactly, merged)]
        shown = [one.shown for r in findings.made for one in r.shown[method]]
        told = f"{shown.count(True)} of {len(shown)}"
        rows.append([method, f"{median.slip:.1f}", f"{median.jerk:.0f}", told, *counts])
    return "\n\n".join(
        part
        for part in (
            "## Five generated sentences",
            f"Seed {SEED}. {MEASURES}",
            table(
                ["median", "slip cm/s", "jerk m/s³", "shown", "recognised exactly", "merged"], rows
            ),
            _note(findings.notes, "made"),
            *(_made_section(r, findings.notes) for r in findings.made),
        )
        if part
    )


def _made_section(result: MadeResult, notes: dict[str, Notes]) -> str:
    made = result.made
    from_motion, again = result.methods[METHODS[0]]
    unknown = [f"- not known: {', '.join(made.unknown)}"] if made.unknown else []
    facts = [
        *unknown,
        *(_action_line(one) for one in made.shown),
        *(f"- not used: {left.text} ({left.reason})" for left in made.not_used),
        f"- the word map, which knows the captures used: {'; '.join(result.described)}",
        f"- symbols of the excerpts: {_numbers(made.symbols)}; recognised in the motion: "
        f"{_numbers(made.recognised)} ({again})",
        f"- {from_motion.seconds:.1f} s, slip {from_motion.slip:.1f} cm/s, "
        f"jerk {from_motion.jerk:.0f} m/s³",
    ]
    parts = (
        f"### {result.sentence}",
        "\n".join(facts),
        _note(notes, f"made: {result.sentence}"),
        f"![{result.sentence}](pictures/{result.picture})",
    )
    return "\n\n".join(part for part in parts if part)


def _action_line(one: JudgedAction) -> str:
    """What was done for an action, and what the judge says of it."""
    told = {True: "shown", False: "not shown", None: "not sure"}[one.shown]
    sure = "" if one.probability is None else f" ({one.probability:.2f})"
    why = f", {one.reason}" if one.reason else ""
    like = ", ".join(f"{word} {p:.2f}" for word, p in one.described)
    likest = f"; to the judge it looks like {like}" if like else ""
    source = f" from {', '.join(one.done)}" if one.done else ""
    return f"- {' '.join(one.words)}:{source}: **{told}**{sure}{why}{likest}"


def _numbers(symbols: Sequence[int]) -> str:
    return " ".join(map(str, symbols))
