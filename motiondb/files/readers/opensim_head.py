"""The head of a motion of OpenSim (MOT, STO): its columns, and whether they are angles."""

from __future__ import annotations

import re
from collections.abc import Mapping

from motiondb.files.text import quoted

_OTHERS = (
    ("quaternion", "orientations of sensors; compute joint angles with OpenSense (IK)"),
    ("vec3", "vectors; export places of markers as TRC"),
    ("speeds", "speeds of coordinates; give their values (_q)"),
    ("velocities", "velocities; give values of coordinates (_q)"),
    ("accelerations", "accelerations; give values of coordinates (_q)"),
)  # What the header may say, and why the file is no motion
_FORCE = re.compile(
    r"force|moment|torque|grf|(^|_)cop|activation|excitation|fiber|tendon|emg|reserve|power|contact"
    r"|(^|[_.])[fmpv][xyz]\d?$|residual|work|control",
    re.IGNORECASE,
)
ANGLE = re.compile(
    r"flex|adduct|abduct|rotat|angle|tilt|_list|pelvis_t|_t[xyz]$|bend|exten|pro_?sup|hip_|knee"
    r"|ankle|elbow|shoulder|/value$|lumbar|subtalar|mtp|_dev|elv|elev|yaw|pitch|roll",
    re.IGNORECASE,
)


def is_angles(start: bytes) -> bool:
    """Say whether the start of a file may be that of coordinates."""
    header, names, _ = read_head(start.decode("latin-1").splitlines())
    return not other_kind(header, names) and any(map(ANGLE.search, names))


def read_head(lines: list[str]) -> tuple[dict[str, str], tuple[str, ...], int]:
    """Return the header, the names of the columns without time, and the first row's number."""
    header = {"": lines[0].strip()} if lines else {}
    for number, line in enumerate(lines):
        cells = cells_of(line)
        if cells and cells[0].lower() in ("time", "times", "#time"):
            return header, tuple(cells[1:]), number + 1
        key, _, value = (part.strip() for part in line.partition("="))
        if not value:
            key, _, value = line.strip().partition(" ")
        header.setdefault(key.lower(), value.strip().lower())
    return header, (), 0


def cells_of(line: str) -> list[str]:
    """Return the cells of a line, between tabs, else between spaces or commas."""
    line = line.strip(" \r\n") if "\t" in line else line.strip()
    cells = line.split("\t") if "\t" in line else re.split(r"\s*,\s*|\s+", line)
    cells = [cell.strip() for cell in cells]
    while cells and not cells[-1]:
        cells.pop()
    return cells[1:] if cells and not cells[0] else cells


def other_kind(header: Mapping[str, str], names: tuple[str, ...]) -> str:
    """Say what a file holds that are no coordinates; "" for what may be some."""
    said = f"{header.get('', '')} {header.get('datatype', '')}".lower()
    for word, what in _OTHERS:
        if word in re.split(r"[^a-z0-9]+", said):
            return what
    forces = [name for name in names if _FORCE.search(name)]
    values = [name for name in names if name.endswith("/value")]
    if 2 * len(forces) > len(names) and not values:
        found = some_names(forces)
        return f"forces, moments, muscles or controls ({found}); give joint angles (IK)"
    return ""


def some_names(names: tuple[str, ...] | list[str]) -> str:
    """Return the first names, and how many there are beside them."""
    more = f" and {len(names) - 4} more" if len(names) > 4 else ""
    return ", ".join(quoted(name, 60) for name in names[:4]) + more
