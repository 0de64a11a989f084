"""motiondb in Blender: ask a motiondb database, import what it answers, generate motion.

A panel in the sidebar of the 3D view (N) talks to ``motiondb serve``.
"""

import bpy

from . import answers, operators, panel, work

_CLASSES = (*operators.CLASSES, *panel.CLASSES)


def register() -> None:
    """Add the panel and its buttons."""
    answers.register()
    for each in _CLASSES:
        bpy.utils.register_class(each)


def unregister() -> None:
    """Take them away."""
    work.forget()
    for each in reversed(_CLASSES):
        bpy.utils.unregister_class(each)
    answers.unregister()
