"""A site in the CMU database's layout on the loopback interface, with faults on demand."""

from __future__ import annotations

import re
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

ASF = """\
# AST/ASF file made by hand
:version 1.10
:name VICON
:units
  length 0.45
:root
   order TX TY TZ RX RY RZ
:bonedata
  begin
     id 1
     name lfemur
     dof rx ry rz
  end
:hierarchy
  begin
    root lfemur
  end
"""


def amc(n_frames: int) -> str:
    """An AMC file of two bones."""
    frames = (f"{n}\nroot {n}.5 17 0 0 0 0\nlfemur {n} 0.25 0\n" for n in range(1, n_frames + 1))
    return "#!OML:ASF made by hand\n:FULLY-SPECIFIED\n:DEGREES\n" + "".join(frames)


def page(subject: int, trials: list[tuple[int, str, int]]) -> str:
    """A search page with the site's own old markup, layout table and all."""
    number = f"{subject:02d}"
    rows = ""
    for trial, words, fps in trials:
        stem = f"http://mocap.cs.cmu.edu:80/subjects/{number}/{number}_{trial:02d}"
        links = "".join(
            f'<TD><A HREF="{stem}.{end}">{end}</A></TD>' for end in ("tvd", "c3d", "amc", "mpg")
        )
        rows += (
            f"<TR BGCOLOR=#FF0000><TD></TD><TD>{trial}</TD><TD>{words}</TD>{links}<TD></TD>"
            f'<TD>{fps}</TD><TD><A HREF="badtrial.php?subjectnumber={subject}&motion={trial}">'
            "Feedback</A></TD></TR>\n<TR><TD COLSPAN=3><BR></TD></TR>\n"
        )
    return (
        "<HTML><BODY><TABLE><TR><TD>Search <A HREF=search.php>all 14</A>\n<TABLE BORDER=0>"
        f"<TR><TD COLSPAN=3><CENTER>Subject #{subject} (by hand) <A HREF=/search.php?subjectnumber="
        f'{subject}&motion=%%%>file index</A> <A HREF="http://mocap.cs.cmu.edu:80/subjects/{number}/'
        f'{number}.asf">asf</A>\n<TR BGCOLOR=#909090><TD>Image</TD><TD>Trial #</TD>'
        f"<TD>Motion Description</TD></TR>\n{rows}</TABLE></TABLE></BODY></HTML>"
    )


@dataclass
class Site:
    """What the server serves and how it misbehaves; ``log`` holds (path, Range or None)."""

    files: dict[str, bytes] = field(default_factory=dict)
    has_range: bool = True
    cuts: dict[str, list[int]] = field(default_factory=dict)
    lengths: dict[str, int] = field(default_factory=dict)
    statuses: dict[str, list[int]] = field(default_factory=dict)
    silent: set[str] = field(default_factory=set)
    slow: set[str] = field(default_factory=set)  # Paths whose bytes come one by one
    without_length: set[str] = field(default_factory=set)
    log: list[tuple[str, str | None]] = field(default_factory=list)
    url: str = ""

    def asked(self, path: str) -> list[str | None]:
        """The Range headers of all requests for a path."""
        return [asked for name, asked in self.log if name == path]


def _handler(site: Site) -> type[BaseHTTPRequestHandler]:
    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            asked = self.headers.get("Range")
            site.log.append((self.path, asked))
            status = site.statuses.get(self.path, [])
            if status:
                self.send_error(status.pop(0))
            elif self.path in site.slow:
                self.wfile.write(b"HTTP/1.1 200 OK\r\nContent-Length: 9999\r\n\r\n")
                with suppress(OSError):  # until the other side has gone
                    for _ in range(200):
                        self.wfile.write(b"x")
                        time.sleep(0.02)
            elif self.path not in site.files:
                self.send_error(404)
            else:
                self._answer(site.files[self.path], asked)

        def _answer(self, data: bytes, asked: str | None) -> None:
            start = int(re.match(r"bytes=(\d+)-", asked)[1]) if asked and site.has_range else 0
            if start and start >= len(data):
                self.send_response(416)
                self.send_header("Content-Range", f"bytes */{len(data)}")
                self.send_header("Content-Length", "0")
                self.end_headers()
                return
            self.send_response(206 if start else 200)
            if start:
                self.send_header("Content-Range", f"bytes {start}-{len(data) - 1}/{len(data)}")
            body = data[start:]
            if self.path not in site.without_length:
                length = site.lengths.get(self.path, len(body))
                self.send_header("Content-Length", str(length))
                body = body[:length]
            self.end_headers()
            if self.path in site.silent:
                if not start:
                    self.wfile.write(body[:100])
                time.sleep(0.3)
                return
            cuts = site.cuts.get(self.path, [])
            self.wfile.write(body[: cuts.pop(0)] if cuts else body)

        def log_message(self, *_: object) -> None:
            pass

    return Handler


@contextmanager
def serve(site: Site) -> Iterator[Site]:
    """Serve a site on a free port until the block ends."""
    server = ThreadingHTTPServer(("127.0.0.1", 0), _handler(site))
    server.daemon_threads = True
    site.url = f"http://127.0.0.1:{server.server_port}"
    thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01})
    thread.start()
    try:
        yield site
    finally:
        server.shutdown()
        thread.join()
        server.server_close()
