"""What the panel shows: a question, the state of the work, and the answers with their pictures."""

import bpy
import bpy.utils.previews
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    StringProperty,
)

from . import figures
from .client import Array

pictures = None  # The pictures of the answers, by number


class Answer(bpy.types.PropertyGroup):
    """An interval that can be imported."""

    ref: StringProperty()
    title: StringProperty()
    detail: StringProperty()
    start: FloatProperty(default=-1.0)  # Seconds; below 0: the whole motion
    end: FloatProperty(default=-1.0)
    licence: StringProperty()


class State(bpy.types.PropertyGroup):
    """The question, and what the server answered."""

    question: StringProperty(
        name="Question", description="Such as: walk, turn left. For Generate: a sentence"
    )
    where: StringProperty(
        name="Filter", description="Only captures that this selects, such as: performer=ana"
    )
    limit: IntProperty(name="Answers", default=6, min=1, max=50)
    seed: IntProperty(name="Seed", default=0, min=0, description="Another one: another motion")
    rate: EnumProperty(
        name="Frame rate",
        items=[
            ("SCENE", "Scene", "Keep the frame rate of the scene; the motion is resampled"),
            ("CAPTURE", "Capture", "Set the frame rate of the scene to that of the capture"),
        ],
    )
    busy: StringProperty()  # What is under way
    error: StringProperty()
    said: StringProperty()  # How the question was understood, or what was done
    answers: CollectionProperty(type=Answer)
    asks_anything: BoolProperty(default=False)


def show(
    state: State, said: str, answers: list[dict], drawn: tuple[list[Array], list[int]]
) -> None:
    """Replace the answers."""
    state.said, state.asks_anything = said, True
    state.answers.clear()
    pictures.clear()
    for number, facts in enumerate(answers):
        answer = state.answers.add()
        for name, value in facts.items():
            setattr(answer, name, value)
        if number < len(drawn[0]):
            picture = pictures.new(str(number))
            picture.image_size = (figures.SIZE, figures.SIZE)
            pixels = figures.draw(drawn[0][number], drawn[1])
            picture.image_pixels_float = pixels.ravel().tolist()


def register() -> None:
    """Add the state to Blender's window manager, which files do not keep."""
    global pictures
    pictures = bpy.utils.previews.new()
    bpy.utils.register_class(Answer)
    bpy.utils.register_class(State)
    bpy.types.WindowManager.motiondb = bpy.props.PointerProperty(type=State)


def unregister() -> None:
    """Take it away."""
    del bpy.types.WindowManager.motiondb
    bpy.utils.unregister_class(State)
    bpy.utils.unregister_class(Answer)
    bpy.utils.previews.remove(pictures)
