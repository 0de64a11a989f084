"""The panel in the sidebar of the 3D view, and the preferences."""

import textwrap

import bpy
from bpy.props import StringProperty

from . import answers

_WIDTH = 46  # Characters of a line of the panel


class Preferences(bpy.types.AddonPreferences):
    """Where the server is."""

    bl_idname = __package__

    address: StringProperty(
        name="Address",
        default="http://127.0.0.1:8765",
        description="The address that motiondb serve prints, with its token if there is one",
    )
    token: StringProperty(name="Token", subtype="PASSWORD", description="If serve printed one")

    def draw(self, _context: bpy.types.Context) -> None:
        """Draw the preferences."""
        self.layout.prop(self, "address")
        self.layout.prop(self, "token")


class MOTIONDB_PT_panel(bpy.types.Panel):
    """The question, and the answers."""

    bl_label = "motiondb"
    bl_idname = "MOTIONDB_PT_panel"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "motiondb"

    def draw(self, context: bpy.types.Context) -> None:
        """Draw the panel."""
        state, layout = context.window_manager.motiondb, self.layout
        layout.prop(state, "question", text="", icon="VIEWZOOM")
        row = layout.row(align=True)
        row.operator("motiondb.search")
        row.operator("motiondb.generate")
        layout.operator("motiondb.like")
        more = layout.column(align=True)
        more.prop(state, "where")
        row = more.row(align=True)
        row.prop(state, "limit")
        row.prop(state, "seed")
        row = layout.row(align=True)
        row.label(text="Frame rate")
        row.prop(state, "rate", expand=True)
        if state.busy:
            layout.label(text=f"{state.busy} ...", icon="TIME")
        if state.error:
            _say(layout, state.error, "ERROR")
        elif state.said:
            _say(layout, state.said, "INFO")
        if state.asks_anything and not state.answers:
            layout.label(text="No answers.")
        for number, answer in enumerate(state.answers):
            _draw_answer(layout, number, answer)


def _draw_answer(layout: bpy.types.UILayout, number: int, answer: answers.Answer) -> None:
    """Draw one answer with its picture."""
    row = layout.box().row()
    picture = answers.pictures.get(str(number))
    if picture is not None:
        row.template_icon(icon_value=picture.icon_id, scale=5.0)
    column = row.column(align=True)
    column.label(text=answer.title)
    column.label(text=answer.detail)
    if answer.licence:
        column.label(text=answer.licence)
    buttons = column.row(align=True)
    for text, onto in (("Import", False), ("Onto Armature", True)):
        button = buttons.operator("motiondb.load", text=text)
        button.number, button.onto = number, onto


def _say(layout: bpy.types.UILayout, text: str, icon: str) -> None:
    """Draw a message over as many lines as it needs."""
    column = layout.column(align=True)
    for paragraph in text.split("\n"):
        for line in textwrap.wrap(paragraph, _WIDTH):
            column.label(text=line, icon=icon)
            icon = "BLANK1"


CLASSES = (Preferences, MOTIONDB_PT_panel)
