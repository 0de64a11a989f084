"""What the test of the extension does in Blender's Python: installs it, asks, imports.

``python in_blender.py ZIP ADDRESS RIG FOLDER`` writes what it found to FOLDER/found.json, and the
heads of the bones in the world, per frame, to FOLDER/*.npz.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

import numpy as np

if __name__ == "__main__":
    import bpy
    from mathutils import Matrix

    ZIP, ADDRESS, RIG, FOLDER = sys.argv[-4:]
PACKAGE = "bl_ext.user_default.motiondb"
found: dict = {}


def settle() -> None:
    """Wait for the thread, as Blender's timers do."""
    from bl_ext.user_default.motiondb import work

    state = bpy.context.window_manager.motiondb
    until = time.monotonic() + 100.0
    while state.busy and time.monotonic() < until:
        work.look()
        time.sleep(0.02)


def heads(armature: bpy.types.Object, name: str, frames: range) -> None:
    """Keep the places of the bones in the world, with y up."""
    places = []
    for frame in frames:
        bpy.context.scene.frame_set(frame)
        at = [armature.matrix_world @ bone.head for bone in armature.pose.bones]
        places.append([(x, z, -y) for x, y, z in at])
    names = [bone.name for bone in armature.pose.bones]
    np.savez(Path(FOLDER, f"{name}.npz"), places=np.array(places), names=names)


def state() -> bpy.types.PropertyGroup:
    return bpy.context.window_manager.motiondb


def press(button: object, **given: object) -> str:
    """Press a button, wait, and return the error."""
    try:
        button(**given)
    except RuntimeError as error:
        return str(error)
    settle()
    return state().error


def main() -> None:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.extensions.package_install_files(
        filepath=ZIP, repo="user_default", enable_on_install=True
    )
    found["enabled"] = PACKAGE in bpy.context.preferences.addons
    chosen = bpy.context.preferences.addons[PACKAGE].preferences
    scene, buttons = bpy.context.scene, bpy.ops.motiondb

    chosen.address = "http://127.0.0.1:9"
    state().question = "kick"
    found["no_server"] = press(buttons.search)
    chosen.address = ADDRESS.partition("/?")[0]
    found["no_token"] = press(buttons.search)
    chosen.address = ADDRESS  # with the token
    found["no_answer"] = press(buttons.load, number=3)

    state().limit = 3
    found["error"] = press(buttons.search)
    found["said"] = state().said
    found["answers"] = [[a.ref, a.start, a.end, a.title, a.detail] for a in state().answers]
    from bl_ext.user_default.motiondb import answers

    picture = answers.pictures["0"]
    pixels = np.array(picture.image_pixels_float).reshape(*picture.image_size, 4)
    found["drawn"] = int((pixels[..., 3] > 0).sum())
    np.save(Path(FOLDER, "picture.npy"), pixels)

    # of its own, at the frame rate of the scene, then at that of the capture
    scene.render.fps, scene.render.fps_base = 24, 1.0
    scene.frame_set(11)
    found["own"] = press(buttons.load, number=0)
    own = bpy.context.object
    action = own.animation_data.action
    found["own_range"] = list(action.frame_range)
    heads(own, "own", range(11, round(action.frame_range[1]) + 1))
    state().rate = "CAPTURE"
    scene.frame_set(1)
    press(buttons.load, number=0)
    found["capture_fps"] = scene.render.fps / scene.render.fps_base
    second = bpy.context.object
    heads(second, "capture", range(1, round(second.animation_data.action.frame_range[1]) + 1))

    # more like its action
    found["like"] = press(buttons.like)
    found["like_answers"] = [[a.ref, a.start, a.end] for a in state().answers]

    # onto a rig that Blender read from FBX
    bpy.ops.preferences.addon_enable(module="io_scene_fbx")
    bpy.ops.import_scene.fbx(filepath=RIG)
    rig = next(thing for thing in bpy.context.selected_objects if thing.type == "ARMATURE")
    rig.animation_data_clear()
    # as files of Mixamo come: bones in centimetres with y up, in an object that is turned and small
    inner = Matrix.Rotation(np.pi / 2, 4, "X") @ Matrix.Scale(0.01, 4)
    rig.matrix_world = rig.matrix_world @ inner
    rig.data.transform(inner.inverted())
    bpy.context.view_layer.update()
    bpy.context.view_layer.objects.active = rig
    scene.frame_set(1)
    found["onto"] = press(buttons.load, number=0, onto=True)
    found["onto_said"] = state().said
    found["onto_keys"] = rig.animation_data is not None
    if rig.animation_data is not None:
        last = round(rig.animation_data.action.frame_range[1])
        heads(rig, "onto", range(1, last + 1))
    for number, bone in enumerate(rig.data.bones):
        bone.name = f"b_{bone.name.split(':')[-1]}_{number}"
    found["unknown"] = press(buttons.load, number=0, onto=True)
    found["texts"] = [text.as_string() for text in bpy.data.texts]
    found["mapped"] = press(buttons.load, number=0, onto=True)

    state().question = "a person walks then kicks"
    found["generate"] = press(buttons.generate)
    found["made"] = [[a.title, a.detail, a.licence] for a in state().answers]
    found["load_made"] = press(buttons.load, number=0)
    found["provenance"] = bpy.context.object.animation_data.action.get("motiondb_provenance", "")
    bpy.ops.preferences.addon_disable(module=PACKAGE)


if __name__ == "__main__":
    try:
        main()
    finally:
        Path(FOLDER, "found.json").write_text(json.dumps(found))
