"""The verbs on folders and records of scenes; none of them needs an open database."""

from __future__ import annotations

from pathlib import Path

from motiondb import store
from motiondb.answers.scenes import SceneAnswer
from motiondb.database.scenes import scene_folder, scene_reports
from motiondb.files.safe_files import is_folder


class SceneFolderVerbs:
    """Read, report and draw the scene of a folder."""

    @staticmethod
    def is_folder(place: str | Path) -> bool:
        """Whether a name is that of a folder, and not of a kept scene."""
        return is_folder(place)

    @staticmethod
    def check_folder(folder: str | Path) -> None:
        """Refuse a folder that cannot hold a scene.

        Raises
        ------
        MotionDBError
            It cannot be written, or holds something else.
        """
        scene_folder.check_scene_folder(Path(folder))

    @staticmethod
    def read_folder(folder: str | Path) -> store.StoredScene:
        """Return the scene of a folder.

        Raises
        ------
        SceneError
            The folder holds no scene, or its record has a fault.
        """
        return scene_folder.read_scene_folder(Path(folder))

    @staticmethod
    def draw_folder(folder: str | Path, path: str | Path) -> Path:
        """Draw the paths of the characters of a folder's scene over its diagram, as PNG.

        Raises
        ------
        MotionDBError
            The folder holds no scene, or the picture cannot be written.
        """
        return scene_folder.draw_folder(Path(folder), Path(path))

    @staticmethod
    def facts(scene: store.StoredScene) -> SceneAnswer:
        """Return everything that is known of a scene, for JSON."""
        return scene_reports.report_facts(scene)

    @staticmethod
    def report(scene: store.StoredScene) -> str:
        """Return how well a scene keeps each rule, collisions and sources, as text."""
        return scene_reports.report_text(scene)

    @staticmethod
    def remarks(scene: store.StoredScene) -> list[str]:
        """Return one line for a sampling that was cut short, and for every impossible motion."""
        return [
            *scene_reports.cut_short_lines(scene),
            *scene_reports.impossible_lines(scene.report),
        ]
