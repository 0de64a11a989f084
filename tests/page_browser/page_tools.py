"""What browser tests do again and again."""

from __future__ import annotations

from pathlib import Path
from typing import Any

AXE = Path(__file__).parents[2] / "motiondb/page/web/node_modules/axe-core/axe.min.js"
"""The accessibility checker, if the packages of the page are installed."""
WAIT = 60_000
"""Milliseconds that a test waits for something to appear: a busy machine is slow, not wrong."""


def pixels(page: Any, selector: str) -> str:
    """The picture of the first canvas of a selector, as text that can be compared."""
    picture: str = page.locator(selector).first.evaluate("canvas => canvas.toDataURL()")
    return picture


def settled(page: Any, selector: str) -> str:
    """The picture of a canvas once it has not changed for ten drawn frames."""
    page.evaluate(
        """async selector => {
            const canvas = document.querySelector(selector);
            let before = '';
            for (let same = 0; same < 10; ) {
                await new Promise(requestAnimationFrame);
                const now = canvas.toDataURL();
                same = now === before ? same + 1 : 0;
                before = now;
            }
        }""",
        selector,
    )
    return pixels(page, selector)


def wait_for(page: Any, expression: str, argument: Any = None) -> None:
    """Wait until a JavaScript function, given an argument, returns something true."""
    page.wait_for_function(expression, arg=argument, timeout=WAIT)


def wait_for_figure(page: Any, selector: str = ".player-canvas") -> None:
    """Wait until a canvas shows more than the empty stage: at least 12 colours of a figure."""
    wait_for(
        page,
        """selector => {
            const canvas = document.querySelector(selector);
            if (!canvas || !canvas.width) return false;
            const image = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
            const colours = new Set();
            for (let i = 0; i < image.data.length; i += 4 * 7) {
                colours.add(image.data[i] + 256 * image.data[i + 1] + 65536 * image.data[i + 2]);
            }
            return colours.size > 150;
        }""",
        selector,
    )


def drag_on(page: Any, selector: str, start: float, end: float) -> None:
    """Drag with the mouse over an element, from one share of its width to another."""
    box = page.locator(selector).first.bounding_box()
    middle = box["y"] + box["height"] / 2
    page.mouse.move(box["x"] + start * box["width"], middle)
    page.mouse.down()
    page.mouse.move(box["x"] + (start + end) / 2 * box["width"], middle, steps=4)
    page.mouse.move(box["x"] + end * box["width"], middle, steps=4)
    page.mouse.up()


def drop_files(page: Any, selector: str, files: list[Path]) -> None:
    """Drop files onto an element, as from the desktop."""
    contents = [{"name": path.name, "text": path.read_text()} for path in files]
    transfer = page.evaluate_handle(
        """contents => {
            const transfer = new DataTransfer();
            for (const { name, text } of contents) transfer.items.add(new File([text], name));
            return transfer;
        }""",
        contents,
    )
    for event in ("dragenter", "dragover", "drop"):
        page.dispatch_event(selector, event, {"dataTransfer": transfer})


def serious(page: Any) -> list[str]:
    """What axe-core calls serious or critical, as text."""
    page.evaluate(AXE.read_text())
    actual = page.evaluate("() => axe.run(document)")
    return [
        f"{rule['id']}: {node['html'][:200]} {node['failureSummary']}"
        for rule in actual["violations"]
        if rule["impact"] in ("serious", "critical")
        for node in rule["nodes"]
    ]
