"""The HIERARCHY part of a BVH file: from text to a skeleton, with every structural fault.

Grammar: ``ROOT|JOINT name { OFFSET x y z  CHANNELS n ...  (JOINT ... | End Site { OFFSET })* }``.
Keywords are read in any case and layout; a name is the rest of its line and may hold spaces.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from motiondb.files.text import Faults, number, quoted, whole_number
from motiondb.records import Skeleton

CHANNELS = MappingProxyType(
    {f"{a}{kind}".lower(): f"{a}{kind}" for kind in ("position", "rotation") for a in "XYZ"}
)  # Lower-case spelling -> BVH spelling of the six channels
_KEYWORDS = frozenset({"hierarchy", "root", "joint", "end", "offset", "channels", "{", "}"})

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


@dataclass
class _State:
    """The state after the tokens read so far."""

    # Joints and end sites in the order of the text
    nodes: list[_Node] = field(default_factory=list)
    stack: list[int] = field(default_factory=list)  # Nodes whose braces are open, innermost last
    announced: int | None = None  # A node whose opening brace has not come yet
    has_root: bool = False  # Whether a joint without parent was read
    faults: Faults = field(default_factory=list)  # Structural faults with their lines


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
    for node in state.stack[::-1]:
        opened = state.nodes[node]
        state.faults.append(
            (
                last,
                f"expected '}}' for {quoted(opened.name)} of line {opened.line}, found the end.",
            )
        )
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
    state.faults.append(
        (line, f"expected a keyword such as JOINT or OFFSET, found {token[:30]!r}.")
    )
    while place < len(tokens) and tokens[place][0] == line:
        place += 1
    return place


def _read_brace(state: _State, line: int, brace: str) -> None:
    """Open the announced node, or close the innermost open one."""
    if brace == "}" and state.stack:
        state.stack.pop()
    elif brace == "}":
        state.faults.append((line, "expected as many '{' as '}', found one '}' too many."))
    elif state.announced is None:
        state.faults.append((line, "expected ROOT, JOINT or End Site before '{', found none."))
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
        state.faults.append((line, f"expected a name after {token}, found none."))
    parent = state.stack[-1] if state.stack else -1
    if parent < 0 and state.has_root:
        first = state.nodes[0]
        state.faults.append(
            (
                line,
                f"expected one ROOT, found a second, {quoted(name)}, after {quoted(first.name)} "
                f"of line {first.line}. Export one performer a file.",
            )
        )
    if parent >= 0 and state.nodes[parent].is_end:
        state.faults.append((line, f"expected no joint inside an End Site, found {quoted(name)}."))
    state.has_root |= parent < 0 and not is_end
    state.nodes.append(_Node(name, parent, line, is_end))
    if state.announced is not None:
        state.faults.append((line, "expected '{' before the next joint, found none."))
    state.announced = len(state.nodes) - 1
    return place


def _read_offset(state: _State, tokens: Tokens, place: int) -> int:
    """Read OFFSET with its three numbers; return the next place."""
    line = tokens[place][0]
    texts = [token for _, token in tokens[place + 1 : place + 4]]
    values = [number(text) for text in texts]
    x, y, z = (*values, None, None, None)[:3]
    if x is None or y is None or z is None:
        on_line = " ".join(text for at, text in tokens[place + 1 : place + 4] if at == line)
        shown = quoted(on_line or "none")
        state.faults.append((line, f"expected 3 numbers after OFFSET, found {shown}."))
        return _next_keyword(tokens, place + 1)
    if not state.stack:
        state.faults.append((line, "expected OFFSET inside a joint, found it outside."))
    else:
        state.nodes[state.stack[-1]].offset = (x, y, z)
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
        state.faults.append(
            (line, f"expected channels such as Xposition or Zrotation, found {quoted(unknown[0])}.")
        )
    elif count != len(known):
        present = f"{len(known)} names" if count >= 0 else f"[{', '.join(map(quoted, words[:1]))}]"
        wanted = f"{count} channel names" if count >= 0 else "a number of channels"
        state.faults.append((line, f"expected {wanted}, found {present}."))
    if not state.stack or state.nodes[state.stack[-1]].is_end:
        state.faults.append((line, "expected CHANNELS inside a joint, found it outside."))
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
            state.faults.append(
                (node.line, f"expected an OFFSET for {quoted(node.name)}, found none; write one.")
            )
    if not joints:
        state.faults.append((1, "expected a ROOT joint, found none. Is this a BVH file?"))
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
