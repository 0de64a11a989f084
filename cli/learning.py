"""Commands learn and symbols."""

from __future__ import annotations

import shlex
from typing import Annotated

import motiondb
from motiondb import answers
from motiondb.cli import options, printing
from motiondb.cli.keeping import print_start

app = options.Commands()


@app.command()
def learn(
    shared: options.Shared,
    n_symbols: Annotated[
        int | None,
        options.option("Number of symbols.  [default: chosen from the data]", "--symbols", min=1),
    ] = None,
    start: Annotated[
        str | None,
        "Knowledge to start from: a file of `knowledge export`, cmu (shipped), or none.  "
        "[default: the start used before; cmu where few of the captures are described]",
    ] = None,
    seed: options.Seed = 0,
    where: options.Where = "",
    cluster: options.Cluster = None,
) -> None:
    """Learn motion symbols, their space and their words from the captures of the database.

    With --start, symbols and words of other captures are used, so that a database without captions
    can be searched by words. The weight of own captions grows with their number.
    """
    with (
        printing.cluster(cluster) as workers,
        shared.database(writing=True) as base,
        printing.progress(shared) as tell,
    ):
        settings = motiondb.LearnSettings(n_symbols=n_symbols, seed=seed)
        drift = base.symbols.drift()
        learning = base.learn(
            settings, lambda what, share: tell(what, share, 1.0), start, where, workers
        )
        first = base.symbols.start_facts()
    size = motiondb.learned_summary(learning)
    if printing.as_json(shared, size, drift=drift, start=first):
        return
    number = printing.number
    printing.say(
        f"{number(size.captures, 'capture')}, {number(size.segments, 'segment')}, "
        f"{number(size.symbols, 'symbol')} in {number(size.clusters, 'cluster')} "
        f"({number(size.dimensions, 'dimension')}), {number(size.words, 'word')}."
    )
    if first:
        print_start(first)
    elif start not in (None, "none"):
        printing.say(
            f"The start {start} is not used: its symbols do not fit these captures, and their "
            f"captions are enough to learn from. Words that only the start has are unknown."
        )
    if drift and not first and not (drift.captures_added or drift.captures_removed or drift.words):
        printing.say("No capture was added or removed since the last learning, and no word is new.")
    if not size.words:
        printing.say(
            "No words yet: `like` works, `search` needs words (motiondb words set, or motiondb "
            "learn --start cmu)."
        )


@app.command()
def demo(shared: options.Shared) -> None:
    """Add the 101 sample captures with their words, and learn from them: a database to try.

    They are synthetic, made by a program, and CC0-1.0. The database may hold no other captures.
    """
    with (
        shared.database(writing=True, create=True) as base,
        printing.progress(shared) as tell,
    ):
        base.captures.add_sample(tell)
        learning = base.learn(progress=lambda what, share: tell(what, share, 1.0))
    size = motiondb.learned_summary(learning)
    if printing.as_json(shared, size):
        return
    db = "" if shared.db == options.Shared.db else f" --db {shlex.quote(str(shared.db))}"
    printing.say(
        f"{printing.number(size.captures, 'capture')} and {printing.number(size.words, 'word')} in"
        f" {shared.db}. Now: motiondb search kick{db}, or motiondb serve{db}"
    )


@app.command()
def evaluate(
    shared: options.Shared, where: options.Where = "", cluster: options.Cluster = None
) -> None:
    """Measure the answers about captures that the database has not learned from.

    Learn from the others first (learn --where). Their captions only judge: words, captions and
    examples are asked for among these captures, and intervals of timed captions in their captures.
    """
    with (
        printing.cluster(cluster) as workers,
        shared.database() as base,
        printing.progress(shared) as tell,
    ):
        report = base.evaluate(where, lambda what, share: tell(what, share, 1.0), workers)
    if printing.as_json(shared, report):
        return
    rows = []
    for score in report.scores:
        shown = ["-" if v is None else f"{v:.3f}" for v in (score.value, score.chance)]
        rows.append([score.task, score.measure, score.questions, *shown])
    printing.say(
        f"learned from {printing.number(report.learned_from, 'capture')}, judged by "
        f"{printing.number(report.judged, 'other')} with captions"
    )
    printing.print_table(["task", "measure", "questions", "value", "chance"], rows)


@app.command()
def symbols(shared: options.Shared, png: options.Png = None) -> None:
    """List the motion symbols with their clusters and words; --png draws their space."""
    with shared.database() as base:
        rows = base.symbols.rows()
        if png:
            base.symbols.draw(png)

    def cells(row: answers.SymbolRow) -> list[object]:
        said = " ".join(f"{each.word} {each.probability:.2f}" for each in row.words)
        return [row.symbol, row.cluster, row.count, row.captures, f"{row.seconds:.2f}", said]

    columns = ["symbol", "cluster", "count", "captures", "seconds", "words"]
    printing.print_rows(shared, rows, columns, cells)
    printing.say_pictures(None if shared.json else png)
