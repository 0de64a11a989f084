"""A sequence as a strip of terminals and as the path of its root on the ground.

Source: J. P. Park, K. H. Lee and J. Lee, "Finding Syntactic Structures from Human Motion Data",
Computer Graphics Forum 30 (2011), figure 4.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motiondb.database.grammars.grammar_sequences import GrammarSequence, Material
from motiondb.grammar.cfg.context_free import Tree
from motiondb.records import MOTION_FPS, FloatArray

PATH_STEP = 3  # Frames from one point of a path to the next: ten points a second


@dataclass(frozen=True)
class StripTerminal:
    """A terminal of a sequence, and its segment."""

    terminal: str
    nonterminal: str  # The nonterminal that generates it
    start: float  # Seconds of the sequence
    end: float  # Seconds of the sequence
    capture: str  # Name of the capture whose segment plays it
    source_start: float  # Start of the segment in the capture, seconds
    source_end: float  # End of the segment, seconds


@dataclass(frozen=True)
class TreeNode:
    """A node of a derivation, in preorder."""

    symbol: str
    parent: int  # Number of its parent, -1 for the root
    start: int  # Its first position in the string
    end: int  # The position after its last one
    is_terminal: bool  # Whether it is a terminal


def strip(material: Material, sequence: GrammarSequence) -> tuple[StripTerminal, ...]:
    """Return the terminals of a sequence in order."""
    terminals, sources = material.learned.terminals, material.learned.sources
    nodes = tree_nodes(sequence.tree)
    above = [nodes[node.parent].symbol for node in nodes if node.is_terminal]
    rows = zip(sequence.string, above, sequence.made.spans, sequence.choice.clips, strict=True)
    return tuple(
        StripTerminal(
            name,
            nonterminal,
            start / MOTION_FPS,
            end / MOTION_FPS,
            sources[int(terminals.takes[clip])].name,
            float(terminals.starts[clip]) / MOTION_FPS,
            float(terminals.ends[clip]) / MOTION_FPS,
        )
        for name, nonterminal, (start, end), clip in rows
    )


def root_path(sequence: GrammarSequence) -> FloatArray:
    """Return the path of the root on the ground: array (points, 2), x and z in metres.

    Points follow each other in :data:`PATH_STEP` frames.
    """
    return np.asarray(sequence.motion.root_positions[::PATH_STEP, [0, 2]], dtype=float)


def tree_nodes(tree: Tree) -> tuple[TreeNode, ...]:
    """Return the nodes of a derivation in preorder, each with the positions that it covers.

    >>> from motiondb.grammar.cfg.context_free import derive_by, read_grammar
    >>> toy = read_grammar("S -> a B c" + chr(10) + "B -> b | empty")
    >>> [(n.symbol, n.parent, n.start, n.end) for n in tree_nodes(derive_by(toy, (0, 1)))]
    [('S', -1, 0, 3), ('a', 0, 0, 1), ('B', 0, 1, 2), ('b', 2, 1, 2), ('c', 0, 2, 3)]
    """
    nodes: list[tuple[Tree, int]] = []
    starts: list[int] = []
    position = 0
    waiting = [(tree, -1)]
    while waiting:  # a loop, because derivations can be too deep for recursion
        node, parent = waiting.pop()
        number = len(nodes)
        nodes.append((node, parent))
        starts.append(position)
        position += node.is_leaf
        waiting.extend((child, number) for child in reversed(node.children))
    ends = [start + node.is_leaf for start, (node, _) in zip(starts, nodes)]
    for number in range(len(nodes) - 1, 0, -1):  # children come after their parents
        parent = nodes[number][1]
        ends[parent] = max(ends[parent], ends[number])
    return tuple(
        TreeNode(node.symbol, parent, start, end, node.is_leaf)
        for (node, parent), start, end in zip(nodes, starts, ends)
    )
