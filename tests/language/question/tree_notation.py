"""Trees of questions in one line, as the table of phrasings has them.

walk left ~slow      an action with its manner        then(a, b)     in order
?                    anything                         while(a, b)    at once
times(a, 2..3)       repeated; 2.. no upper limit     both(a, b)     order not said
seconds(a, 10..10)   lasting                          or(a, b)       alternatives
angle(a, 90..90)     in degrees; also way (m), speed (m/s) and steps
not(a; b, c)         a without b and c; not(; b) without anything asked
"""

from __future__ import annotations

from motiondb.language.question.tree import (
    Action,
    AnyOf,
    Anything,
    AtOnce,
    Both,
    InOrder,
    Lasting,
    Measured,
    Node,
    Repeated,
    Without,
)

_JOINTS = {InOrder: "then", AtOnce: "while", Both: "both", AnyOf: "or"}


def notation(node: Node) -> str:
    """A tree in the notation of the module."""
    if isinstance(node, Action):
        return " ".join([*node.words, *(f"~{manner}" for manner in node.manner)])
    if isinstance(node, Anything):
        return "?"
    if isinstance(node, Without):
        asked = "" if isinstance(node.part, Anything) else notation(node.part)
        return f"not({asked}; {', '.join(map(notation, node.excluded))})"
    if isinstance(node, (Repeated, Lasting)):
        name = "times" if isinstance(node, Repeated) else "seconds"
        most = "" if node.most is None else f"{node.most:g}"
        return f"{name}({notation(node.part)}, {node.least:g}..{most})"
    if isinstance(node, Measured):
        measure = node.measure
        most = "" if measure.most is None else f"{measure.most:g}"
        return f"{measure.what}({notation(node.part)}, {measure.least:g}..{most})"
    return f"{_JOINTS[type(node)]}({', '.join(map(notation, node.parts))})"
