"""How fast the page is for somebody who looks at it: measured in headless Chromium.

Every time is that of the browser, from the navigation or the input until the frame in which the
result is drawn. Without ``--db`` the sample data is added and learned.

    python benchmarks/page_speed.py --captures 10000 --keep many.duckdb
    python benchmarks/page_in_browser.py catalogue --db many.duckdb
    python benchmarks/page_speed.py --captures 3000 --learn --keep learned.duckdb
    python benchmarks/page_in_browser.py search --db learned.duckdb
    python benchmarks/page_in_browser.py board
    python benchmarks/page_in_browser.py player
"""

from __future__ import annotations

import argparse
import json
import shutil
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import motiondb
from motiondb.page import motion as binary

ROOT = Path(__file__).resolve().parents[1]
SAMPLES = ROOT / "sample_data"
SWITCHES = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
WAIT = 300_000
SEEN = """selector => new Promise(resolve => {
    const look = () => {
        if (document.querySelector(selector)) {
            requestAnimationFrame(() => requestAnimationFrame(() => resolve(performance.now())));
            return true;
        }
        return false;
    };
    if (!look()) {
        const observer = new MutationObserver(() => look() && observer.disconnect());
        observer.observe(document, { childList: true, subtree: true, attributes: true });
    }
})"""
"""Resolves to the milliseconds since the navigation when a selector is there and drawn."""
READING = 1500
"""Milliseconds in which somebody looks at answers before the next question. Chosen by hand."""
OPENED = """name => new Promise(resolve => {
    const began = performance.now();
    const look = () => {
        const open = document.querySelector('.details');
        if (open?.querySelector('h2').textContent !== name) return;
        if (!open.querySelector('.details-under .facts')) return;
        watch.disconnect();
        requestAnimationFrame(() =>
            requestAnimationFrame(() => resolve(performance.now() - began)));
    };
    const watch = new MutationObserver(look);
    watch.observe(document, { childList: true, subtree: true });
    [...document.querySelectorAll('.row-capture')]
        .find((row) => row.querySelector('.capture-name')?.textContent === name).click();
})"""
"""Opens a capture; resolves to the milliseconds until its facts are drawn."""
FRAMES = """seconds => new Promise(resolve => {
    const times = [];
    const step = now => {
        times.push(now);
        if (now - times[0] < 1000 * seconds) requestAnimationFrame(step);
        else resolve(times.slice(1).map((time, i) => time - times[i]));
    };
    requestAnimationFrame(step);
})"""
"""Resolves to the milliseconds between drawn frames."""
SHOWN = """() => {
    window.shown = [];
    addEventListener('pointerup', () => { window.released = performance.now(); }, true);
    new PerformanceObserver(list => {
        for (const { name } of list.getEntries()) {
            if (!name.includes('/api/motion?')) continue;
            requestAnimationFrame(() => requestAnimationFrame(() =>
                window.shown.push([name.includes('ref=first'), performance.now() - released])));
        }
    }).observe({ type: 'resource' });
}"""
"""Notes how long after the release of the pointer each motion is there and drawn."""


TOLD: list[dict[str, object]] = []
"""Every result of this process."""


def told(what: str, **numbers: object) -> None:
    """Print a result, and remember it."""
    TOLD.append({"what": what} | numbers)
    print(json.dumps(TOLD[-1]), flush=True)


def summary(times: list[float]) -> dict[str, float]:
    """Median and largest time, in milliseconds."""
    return {"median_ms": round(statistics.median(times)), "largest_ms": round(max(times))}


@contextmanager
def served(database: Path) -> Iterator[str]:
    """The address of a server."""
    code = "from motiondb.cli.main import main; main()"
    command = [sys.executable, "-c", code, "serve", "--no-open", "--port", "0"]
    with subprocess.Popen(
        [*command, "--db", str(database)], stdout=subprocess.PIPE, text=True
    ) as server:
        assert server.stdout is not None
        try:
            yield server.stdout.readline().removeprefix("The page is at ").split()[0]
        finally:
            server.terminate()


@contextmanager
def launched() -> Iterator[Any]:
    """A headless Chromium."""
    from playwright.sync_api import sync_playwright

    program = shutil.which("chromium") or shutil.which("google-chrome")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=SWITCHES)
        yield browser
        browser.close()


def measure_views(address: str) -> list[dict[str, object]]:
    """Measure the first view, scrolling, opening and questions on a server; return the results."""
    with launched() as browser:
        for view in (catalogue, opening, search):
            view(browser, address)
    return TOLD


@contextmanager
def opened_browser(
    db: Path | None, prepare: Callable[[Path], None] | None = None
) -> Iterator[tuple[Any, str]]:
    """A browser and the address of a server of a copy of ``db``, or of the learned sample data.

    `prepare`: Called with the copy before it is served.
    """
    with tempfile.TemporaryDirectory() as place:
        database = Path(place) / "motions.duckdb"
        if db:
            shutil.copy(db, database)
        else:
            make_sample_database(database)
        if prepare:
            prepare(database)
        with served(database) as address, launched() as browser:
            yield browser, address


def make_sample_database(database: Path) -> None:
    """Add the sample data and learn from it."""
    with motiondb.open(database) as db:
        db.add(SAMPLES / "captures", SAMPLES / "captions.tsv")
        db.learn()


def catalogue(browser: Any, address: str) -> None:
    """The first view, and scrolling to the end."""
    times = []
    for _ in range(5):
        page = browser.new_context(viewport={"width": 1400, "height": 900}).new_page()
        page.goto(address, wait_until="commit")
        times.append(page.evaluate(SEEN, ".row-capture .capture-name"))
        if len(times) < 5:
            page.context.close()
    told("first view of the catalogue", **summary(times), first_ms=round(times[0]))
    page.wait_for_timeout(1000)
    page.mouse.move(900, 600)
    page.evaluate(f"window.gaps = ({FRAMES})(6)")
    for _ in range(60):
        page.mouse.wheel(0, 900)
        page.wait_for_timeout(80)
    gaps = page.evaluate("() => window.gaps")
    told(
        "frames while scrolling", frames=len(gaps), **summary(gaps),
        over_100_ms=sum(gap > 100 for gap in gaps),
    )  # fmt: skip


def opening(browser: Any, address: str) -> None:
    """From a click on a row until the facts of its capture are drawn; each another capture."""
    page = browser.new_context(viewport={"width": 1400, "height": 900}).new_page()
    page.goto(address)
    page.locator(".row-capture .capture-name").first.wait_for()
    page.wait_for_timeout(2 * READING)
    names = page.locator(".row-capture .capture-name").all_inner_texts()[:8]
    times = []
    for name in names:
        times.append(page.evaluate(OPENED, name))
        page.wait_for_timeout(READING)
    told("a capture is opened", first_ms=round(times[0]), **summary(times[1:]))


def search(browser: Any, address: str) -> None:
    """From the key that asks until the answers are drawn: at once after the last ones, and later.

    Also the processor time of the page itself, which a busy machine does not change much.
    """
    page = browser.new_context(viewport={"width": 1400, "height": 900}).new_page()
    page.goto(f"{address}#/search")
    box = page.get_by_role("searchbox").first
    tools = page.context.new_cdp_session(page)
    tools.send("Performance.enable", {"timeDomain": "threadTicks"})
    for pause in (0, READING):
        times: dict[str, list[float]] = {"kick": [], "walk, turn left": []}
        work: dict[str, list[float]] = {question: [] for question in times}
        for question in [*times] * 7:
            page.wait_for_timeout(pause)
            box.fill(question)
            page.evaluate("() => document.querySelectorAll('.answer').forEach(a => a.remove())")
            page.evaluate(f"() => {{ window.seen = ({SEEN})('.answer'); }}")
            before = _busy(tools)
            began = page.evaluate("() => performance.now()")
            box.press("Enter")
            times[question].append(page.evaluate("() => window.seen") - began)
            work[question].append(1000 * (_busy(tools) - before))
        for question, measured in times.items():
            told(
                f"search: {question}", pause_ms=pause, first_ms=round(measured[0]),
                **summary(measured[1:]),
                page_processor_ms=round(statistics.median(work[question][1:])),
            )  # fmt: skip


def _busy(tools: Any) -> float:
    """Seconds of processor time that the main thread of a page has used."""
    metrics = tools.send("Performance.getMetrics")["metrics"]
    return next(float(m["value"]) for m in metrics if m["name"] == "TaskDuration")


def board(browser: Any, address: str) -> None:
    """From the release of a dragged player until the first frame of the changed scene.

    The scene to change is sampled in 10 rounds instead of 70, to save time.
    """
    page = browser.new_context(viewport={"width": 1400, "height": 900}).new_page()
    page.set_default_timeout(WAIT)
    page.goto(f"{address}#/board?board=give-and-go")
    page.locator(".board-player").first.wait_for()
    page.route("**/api/scenes", lambda route: route.continue_(
        post_data=json.dumps(json.loads(route.request.post_data) | {"rounds": 10})))  # fmt: skip
    page.get_by_role("button", name="Make the scene").click()
    page.locator(".board-rules").wait_for(state="attached")
    page.evaluate(SHOWN)
    first, whole = [], []
    for n in range(6):
        box = page.locator("[data-player=A1] circle").first.bounding_box()
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x + (9 if n % 2 else -9), y + 3, steps=4)
        page.evaluate("() => { window.shown.length = 0; }")
        page.mouse.up()
        page.wait_for_function("() => window.shown.some(([first]) => !first)")
        shown = page.evaluate("() => window.shown")
        first.append(min(time for _, time in shown))
        whole.append(max(time for _, time in shown))
    told("a player is dragged: first new frame", **summary(first))
    told("a player is dragged: the whole scene with its report", **summary(whole))


def player(browser: Any, address: str) -> None:
    """Frames a second with ten characters in one view."""
    names = [f"{who}/walk_1" for who in ("ana", "boris", "chidi", "fatou")]
    with tempfile.TemporaryDirectory() as place, motiondb.open(Path(place) / "x.duckdb") as db:
        motions = [db.motion(SAMPLES / "captures" / f"{name}.bvh") for name in names]
    tracks = []
    for number in range(10):
        motion = motions[number % len(motions)]
        track = binary.body_track(f"P{number}", f"capture:{number}", motion)
        track.points[..., 0] += number - 4.5
        tracks.append(track)
    data = binary.pack(tracks)
    for size in ((1400, 900), (700, 500)):
        page = browser.new_context(viewport={"width": size[0], "height": size[1]}).new_page()
        page.route("**/api/motion?*", lambda route: route.fulfill(
            body=data, content_type=binary.MEDIA_TYPE))  # fmt: skip
        page.goto(f"{address}#/catalogue?capture=ana/walk_1")
        page.locator(".details .timeline-cursor").wait_for()
        page.locator(".player-canvas").focus()
        page.keyboard.press(" ")
        page.wait_for_timeout(1000)
        gaps = page.evaluate(FRAMES, 5)
        canvas = page.locator(".player-canvas").bounding_box()
        told(
            "ten characters", canvas=f"{canvas['width']:.0f} x {canvas['height']:.0f}",
            frames_a_second=round(1000 / statistics.mean(gaps), 1), **summary(gaps),
        )  # fmt: skip
        page.context.close()


def main() -> None:
    """Serve a database and measure one thing."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("what", choices=("catalogue", "opening", "search", "board", "player"))
    options.add_argument("--db", type=Path, help="an existing database; it is copied")
    chosen = options.parse_args()
    with opened_browser(chosen.db) as (browser, address):
        globals()[chosen.what](browser, address)


if __name__ == "__main__":
    main()
