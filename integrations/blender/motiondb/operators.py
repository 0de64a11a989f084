"""What the buttons do: ask, generate, import."""

import bpy
from bpy.props import BoolProperty, IntProperty

from . import answers, skeletons, work
from .client import Motion, Server, ServerError

_MOST_FRAMES = 36_000  # Of an action that is sent as an example


def server() -> Server:
    """Return the server of the preferences (ServerError)."""
    chosen = bpy.context.preferences.addons[__package__].preferences
    found = Server.at(chosen.address, chosen.token)
    if not found.is_local and not getattr(bpy.app, "online_access", True):
        raise ServerError(
            f"server: expected leave to reach {found.address}, found that Blender is offline. "
            "Allow it (Preferences > System > Network > Allow Online Access)."
        )
    return found


def armature_of(context: bpy.types.Context) -> bpy.types.Object:
    """Return the active armature, or the only one of the scene (ArmatureError)."""
    if context.object is not None and context.object.type == "ARMATURE":
        return context.object
    found = [thing for thing in context.scene.objects if thing.type == "ARMATURE"]
    if len(found) != 1:
        raise skeletons.ArmatureError(
            f"armature: expected an active one, found {len(found)} in the scene. Select one."
        )
    return found[0]


class _Asking(bpy.types.Operator):
    """Base of the buttons: errors are shown in the panel and in the status bar."""

    bl_options = {"REGISTER"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        try:
            self.run(context)
        except (ServerError, skeletons.ArmatureError) as error:
            context.window_manager.motiondb.error = str(error)
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


class MOTIONDB_OT_search(_Asking):
    """Find intervals that show what the question asks for"""

    bl_idname = "motiondb.search"
    bl_label = "Search"

    def run(self, context: bpy.types.Context) -> None:
        state = context.window_manager.motiondb
        asked, at = state.question.strip(), server()
        if not asked:
            raise ServerError("question: expected words such as walk, turn left, found none.")
        query = {"q": asked, "where": state.where, "limit": state.limit}

        def job() -> tuple:
            reply = at.get("/api/search", **query)
            said = [f"understood: {reply['question']['understood']}", *reply["sentences"]]
            return "\n".join(said), *_matches(at, reply)

        work.start(f"Searching {asked}", job, lambda found: answers.show(state, *found))


class MOTIONDB_OT_like(_Asking):
    """Find intervals that move like the action of the selected armature"""

    bl_idname = "motiondb.like"
    bl_label = "More Like the Selected Action"

    def run(self, context: bpy.types.Context) -> None:
        state, at = context.window_manager.motiondb, server()
        armature = armature_of(context)
        action = armature.animation_data and armature.animation_data.action
        if not action:
            raise skeletons.ArmatureError(
                f"{armature.name}: expected an action, found none. Select an animated armature."
            )
        scene = context.scene
        first, last = (round(frame) for frame in action.frame_range)
        if scene.use_preview_range:
            first = max(first, scene.frame_preview_start)
            last = min(last, scene.frame_preview_end)
        if not 2 <= last - first + 1 <= _MOST_FRAMES:
            raise skeletons.ArmatureError(
                f"{action.name}: expected 2 to {_MOST_FRAMES} frames, found {last - first + 1}. "
                "Set the preview range to a part of it."
            )
        frames = range(first, last + 1)
        text, _ = skeletons.to_bvh(armature, joint_map(armature), frames)
        query, name = {"where": state.where, "limit": state.limit}, armature.name

        def job() -> tuple | dict:
            ref = at.upload("action.bvh", text.encode())
            if unknown := _unknown_joints(at, ref):
                return unknown
            reply = at.get("/api/like", ref=ref, **query)
            said = {True: "", False: "; nothing is near enough, these are the nearest"}
            much = said.get(reply["matches_anything"], "")
            return f"like {action_name}{much}", *_matches(at, reply)

        action_name = action.name

        def then(found: tuple | dict) -> None:
            if isinstance(found, dict):
                raise propose(bpy.data.objects[name], found)
            answers.show(state, *found)

        work.start(f"Searching like {action.name}", job, then)


class MOTIONDB_OT_generate(_Asking):
    """Make motion that shows the actions of the sentence, in their order"""

    bl_idname = "motiondb.generate"
    bl_label = "Generate"

    def run(self, context: bpy.types.Context) -> None:
        state, at = context.window_manager.motiondb, server()
        body = {"words": state.question.strip(), "seed": state.seed, "variants": 3}
        if not body["words"]:
            raise ServerError(
                "sentence: expected one such as a person walks then kicks, found none."
            )

        def job() -> tuple:
            reply = at.post("/api/generate", body)
            made = [
                {
                    "ref": one["ref"],
                    "title": f"generated, seed {one['seed']}, {one['seconds']:.1f} s",
                    "detail": one["why_not"] or "shows all actions",
                    "licence": "; ".join(sorted({s["licence"] for s in one["sources"]})),
                }
                for one in reply["variants"]
            ]
            said = [f"understood: {reply['question']['understood']}", *reply["sentences"]]
            drawn = at.figures([{"ref": one["ref"]} for one in made])
            return "\n".join(said), made, drawn

        work.start(f"Generating {body['words']}", job, lambda made: answers.show(state, *made))


class MOTIONDB_OT_load(_Asking):
    """Import this motion, from the current frame on"""

    bl_idname = "motiondb.load"
    bl_label = "Import"

    number: IntProperty(default=0)
    onto: BoolProperty(default=False)

    @classmethod
    def description(cls, _context: bpy.types.Context, properties: object) -> str:
        """Say what one of the two buttons does."""
        if properties.onto:
            return "Put this motion onto the selected armature, as a new action"
        return "Import this motion with an armature of its own"

    def run(self, context: bpy.types.Context) -> None:
        state, at = context.window_manager.motiondb, server()
        if not 0 <= self.number < len(state.answers):
            raise ServerError("answer: expected one of the list, found another. Search again.")
        answer = state.answers[self.number]
        wanted = {"ref": answer.ref}
        if answer.start >= 0.0:
            wanted |= {"start": round(answer.start, 4), "end": round(answer.end, 4)}
        facts = {"ref": answer.ref, "title": answer.title, "licence": answer.licence}
        fps = skeletons.fps_of(context.scene) if state.rate == "SCENE" else None
        rig, bones, name = "", [], ""
        if self.onto:
            armature = armature_of(context)
            rig, bones = skeletons.to_bvh(armature, joint_map(armature))
            name = armature.name

        def job() -> Motion | dict:
            onto = at.upload("rig.bvh", rig.encode()) if rig else None
            if onto and (unknown := _unknown_joints(at, onto)):
                return unknown
            return at.motion(**wanted, fps=fps, onto=onto)

        def then(found: Motion | dict) -> None:
            armature = bpy.data.objects.get(name)
            if name and armature is None:
                raise skeletons.ArmatureError(f"{name}: expected it, found it deleted.")
            if isinstance(found, dict):
                raise propose(armature, found)
            state.said = put(found, facts, armature, bones)
            if not bpy.app.background:  # the button's own step ended before the motion came
                bpy.ops.ed.undo_push(message=f"Import {facts['title']}")

        work.start(f"Importing {answer.title}", job, then)


def put(motion: Motion, facts: dict, armature: bpy.types.Object | None, bones: list[str]) -> str:
    """Put a motion onto an armature, or on one of its own; return what was done."""
    scene = bpy.context.scene
    if bpy.context.window_manager.motiondb.rate == "CAPTURE":
        skeletons.set_fps(scene, motion.fps)
    title = facts["title"].split("  ")[0]
    if armature is None:
        armature = skeletons.build(motion, title)
        bones = list(armature["motiondb_joints"])
    if len(bones) != len(motion.joints):
        raise skeletons.ArmatureError(
            f"{armature.name}: expected {len(motion.joints)} bones, found {len(bones)}: they "
            "changed meanwhile. Import again."
        )
    first = scene.frame_current
    action = skeletons.move(armature, bones, motion, title, first)
    action["motiondb_ref"], action["motiondb_licence"] = facts["ref"], facts["licence"]
    if motion.provenance:
        action["motiondb_provenance"] = motion.provenance
    last = first + len(motion.positions) - 1
    scene.frame_end = max(scene.frame_end, last)
    return f"imported {title} on {armature.name}: frames {first}-{last}"


def joint_map(armature: bpy.types.Object) -> dict[str, str]:
    """Return the joint map that the user keeps for an armature in a text; empty without one."""
    text = bpy.data.texts.get(map_name(armature))
    pairs = {}
    for line in text.as_string().splitlines() if text else ():
        role, equals, bone = line.split("#")[0].partition("=")
        if equals:
            pairs[role.strip()] = bone.strip()
    wrong = [role for role in pairs if role not in skeletons.ROLES]
    gone = [bone for bone in pairs.values() if bone not in armature.data.bones]
    if wrong or gone:
        raise skeletons.ArmatureError(
            f"{map_name(armature)}: expected `role = bone` with known roles and existing bones, "
            f"found {', '.join([*wrong, *gone])}. Correct the text, or delete it."
        )
    return pairs


def map_name(armature: bpy.types.Object) -> str:
    """Return the name of the text that holds the joint map of an armature."""
    return f"motiondb joints of {armature.name}"


def propose(armature: bpy.types.Object, found: dict) -> skeletons.ArmatureError:
    """Write the proposed roles of bones into a text; return the error that asks to check them."""
    if joint_map(armature):  # the user's own lines stay
        missing = ", ".join(found["missing"]) or "some"
        return skeletons.ArmatureError(
            f"{map_name(armature)}: expected a bone for every role that is needed, found none for: "
            f"{missing}. Add lines `role = bone` to this text."
        )
    bones = {"_".join(bone.name.split()): bone.name for bone in skeletons.chain(armature)}
    lines = ["# Check these lines (role = bone), then import again. Roles without a bone:"]
    roles = found["roles"]
    lines += [f"# {role}" for role in skeletons.ROLES if role not in roles]
    lines += [f"{role} = {bones[roles[role]]}" for role in skeletons.ROLES if role in roles]
    lines += ["# Bones:", *(f"#   {bone}" for bone in bones.values())]
    text = bpy.data.texts.get(map_name(armature)) or bpy.data.texts.new(map_name(armature))
    text.from_string("\n".join(lines) + "\n")
    missing = f" Needed and not found: {', '.join(found['missing'])}." if found["missing"] else ""
    return skeletons.ArmatureError(
        f"{armature.name}: expected names of bones that are known, found others.{missing} A "
        f"proposal is in the text {text.name!r}: check it in the text editor, and try again."
    )


def _unknown_joints(at: Server, ref: str) -> dict | None:
    """Return what the server proposes for a skeleton whose names it does not know."""
    found = at.get("/api/joints", ref=ref)
    return None if found["is_known"] else found


def _matches(at: Server, reply: dict) -> tuple[list[dict], tuple]:
    """Return the matches of an answer as the panel shows them, and their figures."""
    found = []
    for match in reply["matches"]:
        sure = match.get("interval_probability")
        if sure is None:
            sure = match.get("probability")
        words = " ".join(match.get("words") or ())
        found.append(
            {
                "ref": match["ref"],
                "title": f"{match['capture']}  {match['start']:.2f}-{match['end']:.2f} s",
                "detail": f"{words}  score {match['score']:.2f}"
                + ("" if sure is None else f"  probability {sure:.2f}"),
                "start": match["start"],
                "end": match["end"],
                "licence": match["licence"] or "",
            }
        )
    parts = [{"ref": one["ref"], "start": one["start"], "end": one["end"]} for one in found]
    return found, at.figures(parts)


CLASSES = (MOTIONDB_OT_search, MOTIONDB_OT_like, MOTIONDB_OT_generate, MOTIONDB_OT_load)
