"""Pictures of motions, symbols and answers: PNG, and animations as GIF."""

from motiondb.pictures.animation import draw_animation
from motiondb.pictures.hits import draw_hits
from motiondb.pictures.scenes import draw_scene_animation, draw_scene_paths
from motiondb.pictures.space import draw_symbol_space
from motiondb.pictures.strings import StringBar, TerminalCard, draw_strings
from motiondb.pictures.strip import Timeline, draw_strip
from motiondb.pictures.tactics import draw_tactics
from motiondb.pictures.trees import TreePicture, draw_trees

__all__ = [
    "StringBar",
    "TerminalCard",
    "Timeline",
    "TreePicture",
    "draw_animation",
    "draw_hits",
    "draw_scene_animation",
    "draw_scene_paths",
    "draw_strings",
    "draw_strip",
    "draw_symbol_space",
    "draw_tactics",
    "draw_trees",
]
