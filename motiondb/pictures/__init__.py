"""Pictures of motions, symbols and answers: PNG, and animations as GIF."""

from motiondb.pictures.animation import draw_animation, draw_animations
from motiondb.pictures.charts import Grid, comparison_figure, coverage_figure, gait_figure
from motiondb.pictures.ghosts import ghosts_figure
from motiondb.pictures.hits import hits_figure
from motiondb.pictures.scenes import draw_scene_animation, scene_paths_figure
from motiondb.pictures.space import space_figure
from motiondb.pictures.strip import Timeline, strip_figure
from motiondb.pictures.style import save_png
from motiondb.pictures.tactics import tactics_figure
from motiondb.pictures.trees import (
    StringBar,
    TerminalCard,
    TreePicture,
    strings_figure,
    trees_figure,
)

__all__ = [
    "Grid",
    "StringBar",
    "TerminalCard",
    "Timeline",
    "TreePicture",
    "comparison_figure",
    "coverage_figure",
    "draw_animation",
    "draw_animations",
    "draw_scene_animation",
    "gait_figure",
    "ghosts_figure",
    "hits_figure",
    "save_png",
    "scene_paths_figure",
    "space_figure",
    "strings_figure",
    "strip_figure",
    "tactics_figure",
    "trees_figure",
]
