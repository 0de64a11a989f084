"""Draw grammars: sentences as trees, captures as strings, generated sequences and their edits.

Every function takes the grammar with its takes (``material``) and the name of a PNG file
(``path``), and returns the file.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from motiondb import pictures
from motiondb.database.catalogue.parts import cut_motion
from motiondb.database.generated_files import source_spans
from motiondb.database.grammars.grammar_sequences import Edit, GrammarSequence, Material
from motiondb.database.grammars.grammar_words import Meaning
from motiondb.database.learned_grammar import LearnedGrammar
from motiondb.grammar.cfg import context_free
from motiondb.grammar.cfg.loops import with_loops, with_loops_around
from motiondb.records import MOTION_FPS

SHOWN_TREES = 12  # Most trees in a picture of the sentences


def colours(learned: LearnedGrammar) -> dict[str, int]:
    """Return the tint number of each terminal, which is the same in all pictures of a grammar."""
    return {name: k for k, name in enumerate(learned.terminals.names)}


def draw_sentences(material: Material, path: str | Path) -> Path:
    """Draw the trees of the sentences: each different tree once, the most frequent first."""
    learned = material.learned
    counts: dict[tuple[int, ...], list[int]] = {}
    for number, rules in enumerate(learned.parses, start=1):
        counts.setdefault(rules, []).append(number)
    order = sorted(counts.items(), key=lambda pair: (-len(pair[1]), pair[1][0]))
    trees = [
        pictures.TreePicture(
            _caption(numbers), with_loops(context_free.derive_by(learned.grammar, rules))
        )
        for rules, numbers in order[:SHOWN_TREES]
    ]
    n, kinds = len(learned.sentences), len(order)
    title = f"{learned.name}: {n} sentence{'s' * (n != 1)}, "
    title += f"{kinds} different tree{'s' * (kinds != 1)}"
    if len(order) > SHOWN_TREES:
        title += f", {SHOWN_TREES} of them here"
    return pictures.save_png(pictures.trees_figure(trees, title, colours(learned)), path)


def _caption(numbers: Sequence[int]) -> str:
    """Return the caption of a tree from the numbers of its sentences."""
    shown = ", ".join(map(str, numbers[:6])) + (", ..." if len(numbers) > 6 else "")
    return f"sentence{'s' if len(numbers) > 1 else ''} {shown}"


def draw_strings(material: Material, meanings: Sequence[Meaning], path: str | Path) -> Path:
    """Draw the terminals with figures and meanings, and the takes as strings.

    A terminal is left out above the strings if the capture of its medoid was removed.
    """
    learned, terminals = material.learned, material.learned.terminals
    cards, bars = [], []
    for k, (name, meaning) in enumerate(zip(terminals.names, meanings)):
        clip = int(terminals.medoids[k])
        motion = material.motions.get(int(terminals.takes[clip]))
        if motion is not None:
            seconds = terminals.starts[clip] / MOTION_FPS, terminals.ends[clip] / MOTION_FPS
            count = int((terminals.labels == k).sum())
            text = f"{meaning.text}  {count}x" if meaning.text else f"{count}x"
            cards.append(pictures.TerminalCard(name, text, k, cut_motion(motion, *seconds)))
    for take, source in enumerate(learned.sources):
        rows = np.flatnonzero(terminals.takes == take)
        spans = [
            (
                terminals.starts[r] / MOTION_FPS,
                terminals.ends[r] / MOTION_FPS,
                terminals.names[terminals.labels[r]],
                int(terminals.labels[r]),
            )
            for r in rows
        ]
        lines = [pictures.Timeline("terminals", spans)]
        numbered = enumerate(learned.sentences.tolist(), start=1)
        sentences = [
            (
                terminals.starts[a] / MOTION_FPS,
                terminals.ends[b - 1] / MOTION_FPS,
                str(number),
                11 if number % 2 else 6,
            )
            for number, (a, b) in numbered
            if rows[0] <= a <= rows[-1]
        ]
        lines.append(pictures.Timeline("sentences", sentences))
        bars.append(pictures.StringBar(source.name, source.n_frames / MOTION_FPS, lines))
    return pictures.save_png(pictures.strings_figure(cards, bars, learned.name), path)


def draw_sequence(material: Material, sequence: GrammarSequence, path: str | Path) -> Path:
    """Draw a strip of a generated motion over its terminals and sources."""
    names = colours(material.learned)
    spans = [
        (a / MOTION_FPS, b / MOTION_FPS, terminal, names[terminal])
        for terminal, (a, b) in zip(sequence.string, sequence.made.spans)
    ]
    lines = [
        pictures.Timeline("terminals", spans),
        pictures.Timeline("sources", source_spans(sequence)),
    ]
    title = f"{sequence.grammar}: {' '.join(sequence.string)}"
    return pictures.save_png(pictures.strip_figure(sequence.motion, title, lines), path)


def draw_parse(material: Material, trees: Sequence[context_free.Tree], path: str | Path) -> Path:
    """Draw the trees of a capture's sentences, at least one."""
    tree_pictures = [
        pictures.TreePicture(f"sentence {n}", with_loops(tree))
        for n, tree in enumerate(trees, start=1)
    ]
    learned = material.learned
    figure = pictures.trees_figure(tree_pictures, learned.name, colours(learned))
    return pictures.save_png(figure, path)


def draw_edit(material: Material, edited: Edit, path: str | Path) -> Path:
    """Draw the edited tree and those with the alternatives, with the region marked in each."""
    trees = [edited.before, *(edited.tree(n) for n in range(len(edited.alternatives)))]
    captions = ["as it is", *(str(n + 1) for n in range(len(edited.alternatives)))]
    tree_pictures = [
        pictures.TreePicture(caption, *with_loops_around(tree, edited.region.path))
        for caption, tree in zip(captions, trees)
    ]
    title = f"{material.learned.name}: what {edited.region.symbol} may derive"
    figure = pictures.trees_figure(tree_pictures, title, colours(material.learned))
    return pictures.save_png(figure, path)
