"""The nodes and takes of an FBX file, as the library ufbx reads them.

ufbx trusts its caller to keep every object alive that it handed out: a node whose list was freed
ends the process. :class:`Scene` keeps them. It is used only in the child process of
:mod:`motiondb.files.readers.fbx`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from motiondb.errors import CaptureError
from motiondb.files.text import plain, quoted
from motiondb.records import FloatArray

_EVEN = 0.02  # Largest deviation of the distances of keys that are evenly spaced, as a share
_MOST_CURVES = 60  # Curves whose keys are looked at: those of the first few joints


@dataclass(frozen=True)
class Node:
    """A node of the file."""

    number: int
    name: str
    parent: int  # -1 for the root of the scene
    is_bone: bool
    is_null: bool  # A locator or a group without an object


@dataclass(frozen=True)
class Keys:
    """When a take has keys."""

    rate: float  # Keys a second of the longest curve if they are even, else 0
    span: tuple[float, float] | None  # First and last key, seconds; None where motion goes on


class Scene:
    """An open file; it keeps every object of ufbx that others are reached from."""

    def __init__(self, data: bytes, path: object) -> None:
        self.path = path
        self._scene = _load(data, path)
        self._kept = [self._scene.nodes, self._scene.anim_stacks, self._scene.skin_clusters]
        self._nodes = list(self._kept[0])
        self._stacks = list(self._kept[1])
        self._anims = [stack.anim for stack in self._stacks]
        skinned = self._skinned()
        self.nodes = tuple(self._describe(node, skinned) for node in self._nodes)
        self.takes = tuple(
            (stack.name, float(stack.time_begin), float(stack.time_end)) for stack in self._stacks
        )
        settings = self._scene.settings
        self._kept.append(settings)
        self.unit = float(settings.unit_meters)
        self.fps = float(settings.frames_per_second)

    def _skinned(self) -> set[int]:
        """Return the numbers of the nodes that move a skin, whatever their kind."""
        found = set()
        for cluster in self._kept[2]:
            node = cluster.bone_node
            self._kept += [cluster, node]
            if node is not None:
                found.add(int(node.typed_id))
        return found

    def _describe(self, node: Any, skinned: set[int]) -> Node:  # noqa: ANN401  of a C library
        parent = node.parent
        bone, mesh, light, camera = node.bone, node.mesh, node.light, node.camera
        self._kept += [parent, bone, mesh, light, camera]
        number = int(node.typed_id)
        return Node(
            number,
            plain(node.name),
            -1 if parent is None else int(parent.typed_id),
            bone is not None or number in skinned,
            mesh is None and light is None and camera is None and parent is not None,
        )

    def keys(self, take: int) -> Keys:
        """Return when a take has keys."""
        curves = self._curves(take)
        longest: FloatArray = np.zeros(0)
        spans: list[tuple[float, float]] = []
        is_held = True
        for number, curve in enumerate(curves):
            keys, before, after = curve.keyframes, curve.pre_extrapolation, curve.post_extrapolation
            self._kept += [keys, before, after]
            if len(keys) < 2:
                continue
            spans.append((float(curve.min_time), float(curve.max_time)))
            is_held &= before.mode.value == 0 == after.mode.value
            if number < _MOST_CURVES and len(keys) > max(2, len(longest)):
                longest = np.array([key.time for key in keys])
        if not spans:
            return Keys(0.0, None)
        steps = np.diff(longest)
        step = float(np.median(steps)) if len(steps) else 0.0
        even = len(steps) > 1 and steps.min() > 0.0 and np.ptp(steps) <= 2.0 * _EVEN * step
        first, last = min(a for a, _ in spans), max(b for _, b in spans)
        return Keys(1.0 / step if even else 0.0, (first, last) if is_held else None)

    def _curves(self, take: int) -> list[Any]:
        """Return the curves of a take."""
        found = []
        layers = self._stacks[take].layers
        self._kept.append(layers)
        for layer in layers:
            values = layer.anim_values
            self._kept += [layer, values]
            for value in values:
                curves = list(value.curves)
                self._kept += [value, *curves]
                found += [curve for curve in curves if curve is not None]
        return found

    def transforms(
        self, take: int, number: int, times: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Places, rotations, scales (frames, 3 or 4) of a node; take -1: the pose in the file."""
        import ufbx

        node = self._nodes[number]
        rows = []
        for time in times.tolist():
            transform = (
                node.local_transform
                if take < 0
                else ufbx.evaluate_transform(self._anims[take], node, time)
            )
            (place, (x, y, z, w), scale) = transform
            rows.append((*place, w, x, y, z, *scale))
        table = np.array(rows)
        return table[:, :3], table[:, 3:7], table[:, 7:]


def _load(data: bytes, path: object) -> Any:  # noqa: ANN401  an object of a C library
    """Open the bytes of a file; what ufbx says of it becomes a CaptureError."""
    import ufbx

    try:
        scene = ufbx.load_memory(
            data,
            ignore_geometry=True,
            skip_skin_vertices=True,
            ignore_embedded=True,
            load_external_files=False,
            target_axes=ufbx.axes_right_handed_y_up,
            space_conversion=ufbx.SpaceConversion.TRANSFORM_ROOT,
            inherit_mode_handling=ufbx.InheritModeHandling.HELPER_NODES,
        )
    except (ufbx.TruncatedFileError, ufbx.EmptyFileError):
        raise CaptureError(
            path, "expected a whole FBX file, found one that is cut short. Export it again."
        ) from None
    except ufbx.UnrecognizedFileFormatError:
        raise CaptureError(
            path, "expected an FBX file, found other content. Check what the file is."
        ) from None
    except ufbx.OutOfMemoryError:
        raise MemoryError from None
    except ufbx.UfbxError as error:
        reason = quoted(str(error) or type(error).__name__, 80)
        raise CaptureError(
            path, f"expected an FBX file that can be read, found {reason}. Export it again."
        ) from None
    metadata = scene.metadata
    if metadata.file_format != ufbx.FileFormat.FBX:
        raise CaptureError(path, "expected an FBX file, found another format. Rename it.")
    return scene
