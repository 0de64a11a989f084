"""Where the players of a scene are: their clips, the seams between them, and the grid."""

from __future__ import annotations

from motiondb.scene.energy.compilation import compiled
from motiondb.scene.energy.placement import ClipArrays, chain, clip_at, place_in_clip
from motiondb.scene.energy.scene_arrays import SceneArrays


@compiled
def place_of(
    scene: SceneArrays, library: ClipArrays, player: int, frame: int
) -> tuple[float, float, float]:
    """Return where a player is at a frame of the scene: x, z, theta."""
    begin = scene.begin[player]
    k = clip_at(begin, scene.n_clips[player], frame)
    clip = library.clips[scene.entry[player, k]]
    inside = min(max(frame - begin[k], 0), clip.n_frames - 1)
    return place_in_clip(scene.placed[player], library.path, clip.path_start + inside, k)


@compiled
def grid_since(scene: SceneArrays, player: int, k: int) -> int:
    """Return the first grid point that a change of clip ``k`` (-1: of all) can affect."""
    return 0 if k < 0 else -(-scene.begin[player, k] // scene.every[0])


@compiled
def place_string(scene: SceneArrays, library: ClipArrays, player: int, k: int) -> None:
    """Place everything after clip ``k`` (-1: everything) of a player; update seams and grid."""
    n, since, every = scene.n_clips[player], max(k, 0), scene.every[0]
    entry, begin, placed = scene.entry[player], scene.begin[player], scene.placed[player]
    chain(placed, begin, entry, library.clips, since, n)
    for m in range(max(since, 1), n if k < 0 else min(k + 2, n)):
        before, after = library.clips[entry[m - 1]].seam, library.clips[entry[m]].seam
        scene.seams[player, m] = library.seams[before, after]
    grid = scene.grid[player]
    g = grid_since(scene, player, k)
    while g * every < begin[0]:
        grid[g, 0], grid[g, 1], grid[g, 2] = placed[0, 0], placed[0, 1], placed[0, 2]
        g += 1
    for m in range(since, n):
        row = library.clips[entry[m]].path_start - begin[m]
        c, s, x, z, theta = placed[m, 3], placed[m, 4], placed[m, 0], placed[m, 1], placed[m, 2]
        while g * every < begin[m + 1]:
            at = row + g * every
            px, pz = library.path[at, 0], library.path[at, 1]
            grid[g, 0], grid[g, 1] = x + px * c + pz * s, z - px * s + pz * c
            grid[g, 2] = theta + library.path[at, 2]
            g += 1
    scene.filled[player] = g
    clip = library.clips[entry[n - 1]]
    last = clip.path_start + clip.n_frames - 1
    grid[g, 0], grid[g, 1], grid[g, 2] = place_in_clip(placed, library.path, last, n - 1)
