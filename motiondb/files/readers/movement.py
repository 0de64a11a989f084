"""Reader of the netCDF files of the package movement: positions of keypoints in 3D.

Source: movement (https://movement.neuroinformatics.dev): a data set of ``ds_type`` "poses" with the
dimensions time, space, keypoints and individuals; from 0.17 on they are called keypoint and
individual, and one individual may have none. What is kept: the rate and the places of the joints,
whose rotations are solved as a C3D's are. What is lost: confidence, and keypoints that are
no joints. A neck that is no keypoint is over the shoulders. The file has no length unit: it
follows from the length of the legs. The library xarray opens the file, in a process with limits.
"""

from __future__ import annotations

import importlib.metadata
import importlib.util
from typing import Any

import numpy as np

from motiondb.body.rates import find_rate
from motiondb.errors import CaptureError, MotionDBError
from motiondb.files.limits import AS_USUAL, ReadOptions, check_rate
from motiondb.files.readers.child_process import end_child_with_parent, read_in_child
from motiondb.files.readers.point_motion import clip_of_points
from motiondb.records import Clip

NO_XARRAY = (
    "expected the packages xarray and h5netcdf for data sets of movement, found none. Install "
    "them: pip install 'motiondb[movement]'."
)
_DIMS = ("time", "keypoint", "individual", "space")
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

    with xarray.open_dataset(source) as opened:
        found = _renamed(opened)
        fault = _fault(found)
        if fault:
            np.savez(target, fault=np.array(fault))
            return
        position = found["position"].transpose(*_DIMS).sel(space=["x", "y", "z"])
        np.savez(
            target,
            points=position.values[:, :, 0].astype(np.float64),
            keypoints=np.array(list(map(str, found["keypoint"].values))),
            times=found["time"].values.astype(np.float64),
            fps=np.float64(found.attrs.get("fps") or 0.0),
            in_seconds=found.attrs.get("time_unit") == "seconds",
        )


def _renamed(found: Any) -> Any:  # noqa: ANN401  a Dataset
    """Return a data set with the names of 0.17 and later, and a dimension for one individual."""
    names = {old: old[:-1] for old in ("keypoints", "individuals") if old in found.coords}
    found = found.rename(names)
    alone = "position" in found and "individual" not in found["position"].dims
    if alone and "individual" in found.coords:
        return found.expand_dims("individual")
    return found.expand_dims(individual=["id_0"]) if alone else found


def _fault(found: Any) -> str:  # noqa: ANN401  a Dataset
    """Say why a data set cannot be read; "" if it can."""
    dims = tuple(map(str, found["position"].dims)) if "position" in found else ()
    if set(dims) != set(_DIMS):
        what = f"position over {', '.join(sorted(dims))}" if dims else "other data"
        return (
            "expected poses of movement, with position over time, space, keypoint and individual, "
            f"found {what}. Save a data set of poses."
        )
    space = list(map(str, found["space"].values))
    if not {"x", "y", "z"} <= set(space):
        return (
            f"expected positions in 3D, found {' and '.join(space)} alone. One view does not tell "
            "the pose: triangulate several."
        )
    people = list(map(str, found["individual"].values))
    if len(people) != 1:
        return (
            f"expected one individual, found {len(people)}: {', '.join(people)[:200]}. Save one a "
            "file: ds.sel(individual=[NAME])."
        )
    return ""


def _is_old() -> bool:
    """Whether the movement that is installed has the names of before 0.17."""
    try:
        return tuple(map(int, importlib.metadata.version("movement").split(".")[:2])) < (0, 17)
    except (importlib.metadata.PackageNotFoundError, ValueError):
        return False


def to_dataset(clip: Clip, individual: str, source: str = "") -> Any:  # noqa: ANN401
    """Return a clip as a data set (xarray.Dataset) in the form of movement, y or z up as it is."""
    try:
        import xarray
    except ImportError:
        raise MotionDBError(f"to_movement: {NO_XARRAY}") from None
    points = clip.world_positions().transpose(0, 2, 1)[..., None]
    keypoint, person = ("keypoints", "individuals") if _is_old() else ("keypoint", "individual")
    dims = ("time", "space", keypoint, person)
    return xarray.Dataset(
        {
            "position": (dims, points),
            "confidence": (
                ("time", keypoint, person),
                np.full((clip.n_frames, len(clip.joint_names), 1), np.nan),
            ),
        },
        coords={
            "time": np.arange(clip.n_frames) / clip.fps,
            "space": ["x", "y", "z"],
            keypoint: list(clip.joint_names),
            person: [individual],
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
