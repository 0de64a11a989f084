"""Reader of the netCDF files of the package movement: positions of keypoints in 3D.

Source: movement (https://movement.neuroinformatics.dev): a data set of ``ds_type`` "poses" with the
dimensions time, space, keypoints and individuals. What is kept: the rate and the places of the
joints, whose rotations are solved as a C3D's are. What is lost: confidence, and keypoints that are
no joints. A neck that is no keypoint lies between the shoulders. The file has no length unit: it
follows from the length of the legs. The library xarray opens the file, in a process with limits.
"""

from __future__ import annotations

import importlib.util
from typing import Any

import numpy as np

from motiondb.body.world import find_rate
from motiondb.errors import CaptureError, MotionDBError
from motiondb.files.limits import AS_USUAL, ReadOptions, check_rate
from motiondb.files.readers.child_process import end_child_with_parent, read_in_child
from motiondb.files.readers.point_motion import clip_of_points
from motiondb.records import Clip

NO_XARRAY = (
    "expected the packages xarray and h5netcdf for data sets of movement, found none. Install "
    "them: pip install 'motiondb[movement]'."
)
_DIMS = ("time", "keypoints", "individuals", "space")
_CPU_SECONDS = 30.0  # Of the child for 10 MB: an hour of 20 keypoints takes about 5 s


def read_movement(data: bytes, path: object, options: ReadOptions = AS_USUAL) -> Clip:
    """Read the clip in the bytes of a netCDF file; its axis up is y."""
    if importlib.util.find_spec("xarray") is None:
        raise CaptureError(path, NO_XARRAY)
    module = "motiondb.files.readers.movement"
    read = read_in_child(module, data, options.limits, _CPU_SECONDS, (), path)
    if "fault" in read:
        raise CaptureError(path, str(read["fault"]))
    rate, rate_notes = _rate(read, path, options.fps)
    names = list(map(str, read["keypoints"]))
    return clip_of_points(names, read["points"], rate, options, path, "movement", rate_notes)


def _rate(read: dict[str, Any], path: object, asked: float | None) -> tuple[float, tuple[str, ...]]:
    """Return the frames a second: those asked for, the file's, or those of its times."""
    if asked is not None:
        return asked, ()
    if read["fps"] > 0.0:
        return check_rate(float(read["fps"]), path), ()
    steps = np.diff(read["times"])
    if not len(steps) or not read["in_seconds"]:
        raise CaptureError(path, "expected the attribute fps, found none. Give it (--fps).")
    rate, notes = find_rate(float(np.median(steps)))
    return check_rate(rate, path), notes


def convert(source: str, target: str, _given: list[str]) -> None:
    """Write the arrays of a file for the parent process, or what is wrong with it."""
    import xarray

    with xarray.open_dataset(source) as found:
        fault = _fault(found)
        if fault:
            np.savez(target, fault=np.array(fault))
            return
        position = found["position"].transpose(*_DIMS).sel(space=["x", "y", "z"])
        np.savez(
            target,
            points=position.values[:, :, 0].astype(np.float64),
            keypoints=np.array(list(map(str, found["keypoints"].values))),
            times=found["time"].values.astype(np.float64),
            fps=np.float64(found.attrs.get("fps") or 0.0),
            in_seconds=found.attrs.get("time_unit") == "seconds",
        )


def _fault(found: Any) -> str:  # noqa: ANN401  a Dataset
    """Say why a data set cannot be read; "" if it can."""
    if "position" not in found or set(found["position"].dims) != set(_DIMS):
        return (
            "expected poses of movement, with position over time, space, keypoints and "
            "individuals, found other data. Save a data set of poses."
        )
    space = list(map(str, found["space"].values))
    if not {"x", "y", "z"} <= set(space):
        return (
            f"expected positions in 3D, found {' and '.join(space)} alone. One view does not tell "
            "the pose: triangulate several."
        )
    people = list(map(str, found["individuals"].values))
    if len(people) != 1:
        return (
            f"expected one individual, found {len(people)}: {', '.join(people)[:200]}. Save one a "
            "file: ds.sel(individuals=[NAME])."
        )
    return ""


def to_dataset(clip: Clip, individual: str, source: str = "") -> Any:  # noqa: ANN401
    """Return a clip as a data set (xarray.Dataset) in the form of movement, y or z up as it is."""
    try:
        import xarray
    except ImportError:
        raise MotionDBError(f"to_movement: {NO_XARRAY}") from None
    points = clip.world_positions().transpose(0, 2, 1)[..., None]
    dims = ("time", "space", "keypoints", "individuals")
    return xarray.Dataset(
        {
            "position": (dims, points),
            "confidence": (
                ("time", "keypoints", "individuals"),
                np.full((clip.n_frames, len(clip.joint_names), 1), np.nan),
            ),
        },
        coords={
            "time": np.arange(clip.n_frames) / clip.fps,
            "space": ["x", "y", "z"],
            "keypoints": list(clip.joint_names),
            "individuals": [individual],
        },
        attrs={
            "fps": clip.fps,
            "time_unit": "seconds",
            "source_software": "motiondb",
            "source_file": source,
            "ds_type": "poses",
        },
    )


if __name__ == "__main__":
    convert(*end_child_with_parent())
