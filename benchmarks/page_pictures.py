"""The pictures of the page in docs/page: screenshots of its views, films of a search and the board.

Everything is seen in headless Chromium. The film is put together from screenshots, so that it does
not depend on how fast the machine is. Without ``--db`` the sample data is added and learned.

    python benchmarks/page_pictures.py board
    python benchmarks/page_pictures.py search
    python benchmarks/page_pictures.py views --db motions.duckdb
    python benchmarks/page_pictures.py real --db cmu.duckdb  # learned from CMU captures
"""

from __future__ import annotations

import argparse
import io
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from page_in_browser import WAIT, opened_browser
from PIL import Image

import motiondb

ROOT = Path(__file__).resolve().parents[1]
FILM = (760, 494)
"""Width and height of the film, pixels. Chosen by hand: words can be read, the file is small."""
COLOURS = 96
"""Colours of the film: more are not seen. Chosen by hand."""
ROUNDS = 30
"""Rounds in which the scene is sampled, instead of 70, to save time. Chosen by hand."""
MOST_SAMPLED = 14
"""Frames of the film that show the falling error. Chosen by hand."""
QUESTION = "a person walks, then turns left"
"""What the film of a search asks: several captures of the sample data show it."""
PLAYED = 26
"""Frames of the film in which the answers play. Chosen by hand."""
PLACE = """([x, z]) => {
    const court = document.querySelector('.board-court svg');
    const point = new DOMPoint(x, z).matrixTransform(court.getScreenCTM());
    return [point.x, point.y];
}"""
"""The place of the window that shows a place of the court."""


def palette_of(frames: Sequence[Image.Image]) -> Image.Image:
    """A palette with the greys of a film and its strong colours, which few pixels have."""
    pixels = np.concatenate([np.asarray(frame).reshape(-1, 3)[::7] for frame in frames])
    strong = pixels[np.ptp(pixels, axis=1) > 60]
    colours: list[int] = []
    for some, count in ((pixels, COLOURS * 2 // 3), (strong, COLOURS // 3)):
        part = Image.fromarray(some[None]).quantize(count, dither=Image.Dither.NONE)
        colours += (part.getpalette() or [])[: 3 * count]
    palette = Image.new("P", (1, 1))
    palette.putpalette(colours)
    return palette


class Film:
    """Screenshots of a page, each with the milliseconds that it is shown.

    Parameters
    ----------
    page : playwright page
        The page.
    """

    def __init__(self, page: Any) -> None:
        self._page = page
        self.frames: list[tuple[Image.Image, int]] = []

    def take(self, milliseconds: int) -> None:
        """Add what is seen now."""
        shot = Image.open(io.BytesIO(self._page.screenshot())).convert("RGB")
        self.frames.append((shot.resize(FILM, Image.Resampling.LANCZOS), milliseconds))

    def thin(self, first: int, most: int) -> None:
        """Keep at most so many frames from a number on, evenly."""
        newer = self.frames[first:]
        step = max(len(newer) - 1, 1) / max(most - 1, 1)
        if step > 1.0:
            self.frames[first:] = [newer[round(k * step)] for k in range(most)]

    def write(self, path: Path) -> None:
        """Write the film as GIF."""
        palette = palette_of([frame for frame, _ in self.frames])
        pictures = [f.quantize(palette=palette, dither=Image.Dither.NONE) for f, _ in self.frames]
        pictures[0].save(
            path, save_all=True, append_images=pictures[1:], loop=0, optimize=True,
            duration=[shown for _, shown in self.frames],
        )  # fmt: skip


def save_picture(page: Any, path: Path) -> None:
    """Write what is seen as PNG, with few colours: half the size."""
    picture = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
    picture.quantize(256).save(path, optimize=True)


def drag(page: Any, start: tuple[float, float], end: tuple[float, float], film: Film) -> None:
    """Drag on the court, with four pictures of it."""
    (x, y), (to_x, to_y) = page.evaluate(PLACE, start), page.evaluate(PLACE, end)
    page.mouse.move(x, y)
    page.mouse.down()
    for k in range(1, 5):
        page.mouse.move(x + (to_x - x) * k / 4, y + (to_y - y) * k / 4)
        page.wait_for_timeout(200)
        film.take(170)
    page.mouse.up()


def with_fewer_rounds(route: Any) -> None:
    """Send a request for a scene on, with another number of rounds."""
    asked = json.loads(route.request.post_data)
    route.continue_(post_data=json.dumps(asked | {"rounds": ROUNDS}))


def play(page: Any, film: Film, pictures: int, share: float = 1.0) -> None:
    """Show a share of the scene."""
    slider = page.locator(".board-scene .player-slider")
    end = share * float(slider.get_attribute("max"))
    for k in range(pictures):
        slider.evaluate(
            "(slider, time) => { slider.value = time;"
            " slider.dispatchEvent(new Event('input', { bubbles: true })); }",
            end * k / pictures,
        )
        page.wait_for_timeout(200)
        film.take(160)


def board(browser: Any, address: str, out: Path, _: str) -> None:
    """The film: an action that cannot be played; the error falls; a player is dragged."""
    page = browser.new_context(
        viewport={"width": 1400, "height": 910}, reduced_motion="reduce"
    ).new_page()
    page.set_default_timeout(3 * WAIT)
    page.goto(f"{address}#/board?board=give-and-go")
    page.locator(".board-list li").first.wait_for()
    film = Film(page)
    film.take(900)
    page.locator("[data-tool=dribble]").click()
    drag(page, (3.2, 0.6), (5.0, 4.0), film)
    page.locator(".board-element.infeasible").wait_for()
    film.take(1900)
    page.get_by_role("button", name="Undo").click()
    page.locator(".board-element.infeasible").wait_for(state="detached")
    page.keyboard.press("Escape")
    page.route("**/api/scenes", with_fewer_rounds)
    page.get_by_role("button", name="Make the scene").click()
    first = len(film.frames)
    while not page.locator(".board-rules").count():
        page.wait_for_timeout(700)
        film.take(180)
    film.thin(first, MOST_SAMPLED)
    page.evaluate("() => scrollTo(0, 0)")
    play(page, film, 12)
    save_picture(page, out / "board.png")
    before = page.url
    drag(page, (0.4, 8.2), (-1.6, 9.0), film)
    page.wait_for_function(
        "before => location.hash.includes('scene=') && !location.hash.includes('job=')"
        " && location.href !== before", arg=before,
    )  # fmt: skip
    page.wait_for_timeout(1500)
    play(page, film, 10, 0.8)
    film.frames[-1] = (film.frames[-1][0], 1200)
    film.write(out / "board.gif")
    told = [f"{out / name}: {(out / name).stat().st_size} bytes" for name in ("board.gif",)]
    print(*told, f"{len(film.frames)} frames", flush=True)


def search(browser: Any, address: str, out: Path, _: str) -> None:
    """The film: a question is typed, and the likely answers play over their found intervals."""
    page = browser.new_context(
        viewport={"width": 1400, "height": 910}, reduced_motion="reduce"
    ).new_page()
    page.set_default_timeout(WAIT)
    page.goto(address)
    page.locator(".row-capture").first.wait_for()
    page.locator(".examples .chip").first.wait_for()
    page.wait_for_timeout(3000)  # the small figures
    film = Film(page)
    film.take(1200)
    page.locator("#question").focus()
    for k, letter in enumerate(QUESTION):
        page.keyboard.type(letter)
        if k % 3 == 2:
            film.take(180)
    page.keyboard.press("Enter")
    page.locator(".answer.likely .timeline-lit").first.wait_for()
    page.wait_for_timeout(6000)  # the motions of the answers
    film.take(1500)
    areas = page.locator(".answer.likely .timeline-area").all()
    places = [
        (area.bounding_box(), [lit.bounding_box() for lit in area.locator(".timeline-lit").all()])
        for area in areas
    ]
    seen = [(box, lit) for box, lit in places if box and box["y"] + box["height"] < 910]
    for k in range(PLAYED):
        for box, lit in seen:
            start, end = lit[0]["x"], lit[-1]["x"] + lit[-1]["width"]
            page.mouse.click(start + 1 + (end - start - 2) * k / (PLAYED - 1), box["y"] + 5)
        page.mouse.move(4, 400)
        page.wait_for_timeout(150)
        film.take(160)
    film.frames[-1] = (film.frames[-1][0], 1500)
    film.write(out / "search.gif")
    told = (out / "search.gif").stat().st_size
    print(f"{out / 'search.gif'}: {told} bytes, {len(film.frames)} frames", flush=True)


VIEWS = (
    ("catalogue", "catalogue?capture=ana/walk_1", ".details .block", (1280, 800), "light"),
    ("search", "search?q=walk, turn left, sit down", ".answer .block", (1280, 860), "light"),
    ("generate", "generate?q=a person walks then kicks&variants=2", ".variant",
     (1280, 720), "light"),
    ("symbols", "symbols?symbol=3", ".segment-list li", (1280, 780), "light"),
    ("not-here", "search?q=walk, kick&where=performer=ana", ".verdict.not-here",
     (1280, 800), "dark"),
    ("example", "search?like=capture:ana/long_1&start=6.500&end=9.300", ".answer .block",
     (1280, 860), "light"),
    ("compare", "compare?part=0.400-4.400 capture:ana/walk_1&part=0.400-4.900 capture:chidi/walk_1"
     "&at=poses", ".compare-curve", (1280, 720), "light"),
    ("grammar-rules", "grammar?name=play", ".grammar-rules .letter", (1280, 640), "light"),
    ("grammar", "grammar?name=play&seed=2&tree=1", ".strip-item", (1280, 900), "light"),
    ("grammar-narrow", "grammar?name=play&seed=2", ".strip-item", (390, 844), "dark"),
)  # fmt: skip
"""Views of the sample data with the grammar ``play``: name of the picture, address, an element to
wait for, size of the window, colours."""
GRAMMAR = ("chidi/long_play_1", "fatou/long_play_2")
"""The captures of the grammar ``play``, as in README."""
REAL_VIEWS = (
    ("generate-real", "generate?q=a person walks forward then kicks, then runs&seed=0", ".variant",
     (1280, 990), "dark"),
)  # fmt: skip
"""Views of a database of the CMU captures."""


def views(browser: Any, address: str, out: Path, only: str, chosen: Sequence[Any] = VIEWS) -> None:
    """Screenshots of views of a learned database; ``only`` one, or all for ""."""
    for name, place, seen, size, scheme in chosen:
        if only not in ("", name):
            continue
        page = browser.new_context(
            viewport={"width": size[0], "height": size[1]}, color_scheme=scheme,
            reduced_motion="reduce",
        ).new_page()  # fmt: skip
        page.set_default_timeout(WAIT)
        page.goto(f"{address}#/{place}")
        if "&seed=" in place and place.startswith("grammar"):
            page.get_by_role("button", name="Make a sequence").click()
            page.locator(seen).nth(2).click()  # its alternatives play in the corners
        page.locator(seen).first.wait_for()
        page.wait_for_timeout(4000)
        save_picture(page, out / f"{name}.png")
        print(f"{out / name}.png", flush=True)
        page.context.close()


def real_views(browser: Any, address: str, out: Path, only: str) -> None:
    """Screenshots of the views of real captures."""
    views(browser, address, out, only, REAL_VIEWS)


def learn_grammar(database: Path) -> None:
    """Learn the grammar ``play``, if its captures are there and it is not."""
    with motiondb.open(database) as db:
        known = {info.name for info in db.captures()}
        if known.issuperset(GRAMMAR) and "play" not in db.grammars.names():
            settings = motiondb.GrammarSettings(n_terminals=8, longest=8)
            db.grammars.learn(GRAMMAR, "play", settings)


def main() -> None:
    """Serve a database and make pictures."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("what", choices=("board", "search", "views", "real"))
    options.add_argument("--db", type=Path, help="an existing database; it is copied")
    options.add_argument("--only", default="", help="the name of one view")
    options.add_argument("--out", type=Path, default=ROOT / "docs" / "page")
    chosen = options.parse_args()
    with opened_browser(chosen.db, learn_grammar) as (browser, address):
        if chosen.what == "board":
            board(browser, address, chosen.out, chosen.only)
        elif chosen.what == "search":
            search(browser, address, chosen.out, chosen.only)
        elif chosen.what == "views":
            views(browser, address, chosen.out, chosen.only)
        else:
            real_views(browser, address, chosen.out, chosen.only)


if __name__ == "__main__":
    main()
