"""Where the pictures stand: __init__.py imports a module when one is used."""

from .animation import draw_animation as draw_animation
from .animation import draw_animations as draw_animations
from .charts import Grid as Grid
from .charts import comparison_figure as comparison_figure
from .charts import coverage_figure as coverage_figure
from .charts import gait_figure as gait_figure
from .ghosts import ghosts_figure as ghosts_figure
from .hits import hits_figure as hits_figure
from .scenes import draw_scene_animation as draw_scene_animation
from .scenes import scene_paths_figure as scene_paths_figure
from .space import space_figure as space_figure
from .strip import Timeline as Timeline
from .strip import strip_figure as strip_figure
from .style import save_png as save_png
from .tactics import tactics_figure as tactics_figure
from .trees import StringBar as StringBar
from .trees import TerminalCard as TerminalCard
from .trees import TreePicture as TreePicture
from .trees import strings_figure as strings_figure
from .trees import trees_figure as trees_figure
