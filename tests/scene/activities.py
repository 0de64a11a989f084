"""The shipped activities, for tests that read diagrams of them."""

from __future__ import annotations

from motiondb.database.scenes.scene_texts import read_grammar
from motiondb.scene.language import tactics_file
from motiondb.scene.language.tactics import Diagram

BASKETBALL = read_grammar("basketball")


def read_diagram(text: str, where: str = "diagram") -> Diagram:
    """Read a diagram of basketball."""
    return tactics_file.read_diagram(text, where, BASKETBALL.activity)
