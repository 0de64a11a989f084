"""Requests to ``motiondb serve``. Nothing here knows Blender, so threads may call all of it."""

from __future__ import annotations

import io
import ipaddress
import json
import urllib.error
import urllib.parse
import urllib.request
import uuid
import zipfile
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
SECONDS = 120.0  # For an answer; the first question of a large database loads it


class ServerError(Exception):
    """The server cannot be reached, or refuses; the message says what to do."""


@dataclass(frozen=True)
class Motion:
    """A motion as the server sends it: metres, y up.

    ``offsets`` (joints, 3) are from the parent in its frame, ``positions`` (frames, joints, 3) in
    the world, ``local_rotations`` (frames, joints, 4) quaternions w, x, y, z.
    """

    fps: float
    joints: list[str]
    parents: list[int]
    offsets: Array
    positions: Array
    local_rotations: Array
    provenance: str = ""  # Of a generated motion, JSON


class _NoRedirect(urllib.request.HTTPRedirectHandler):
    """Follows no redirection, which would hand the token to another server."""

    def redirect_request(self, *_args: Any) -> None:
        """Return no request, so that the redirection is an error."""


@dataclass(frozen=True)
class Server:
    """Where the server is; ``token`` is empty where it needs none."""

    address: str
    token: str = ""

    @classmethod
    def at(cls, address: str, token: str = "") -> Server:
        """Return the server at an address, which may hold the token as ``serve`` prints it."""
        text = address.strip() if "//" in address else f"http://{address.strip()}"
        try:
            parts = urllib.parse.urlsplit(text)
            is_address = parts.scheme in ("http", "https") and bool(parts.hostname)
        except ValueError:  # brackets that are not closed
            is_address = False
        if not is_address:
            raise ServerError(
                f"address: expected one such as http://127.0.0.1:8765, found {address!r}. Correct "
                "it in the preferences of the extension."
            )
        given = urllib.parse.parse_qs(parts.query).get("token", [""])[0]
        return cls(f"{parts.scheme}://{parts.netloc}", token.strip() or given)

    @property
    def is_local(self) -> bool:
        """Whether it is on this computer."""
        name = urllib.parse.urlsplit(self.address).hostname or ""
        try:
            return ipaddress.ip_address(name).is_loopback
        except ValueError:
            return name == "localhost"

    def get(self, path: str, **query: Any) -> Any:
        """Return the JSON of an answer."""
        given = {name: value for name, value in query.items() if value is not None}
        return json.loads(self._ask(f"{path}?{urllib.parse.urlencode(given)}"))

    def post(self, path: str, body: Any) -> Any:
        """Return the JSON of an answer to a body."""
        return json.loads(self._ask(path, json.dumps(body).encode(), "application/json"))

    def upload(self, name: str, data: bytes) -> str:
        """Send a file, and return its ref."""
        border = uuid.uuid4().hex
        head = (
            f'--{border}\r\nContent-Disposition: form-data; name="files"; filename="{name}"\r\n'
            "Content-Type: application/octet-stream\r\n\r\n"
        )
        body = head.encode() + data + f"\r\n--{border}--\r\n".encode()
        form = f"multipart/form-data; boundary={border}"
        said = json.loads(self._ask("/api/uploads", body, form))
        return str(said["files"][0]["ref"])

    def motion(
        self,
        ref: str,
        start: float | None = None,
        end: float | None = None,
        fps: float | None = None,
        onto: str | None = None,
    ) -> Motion:
        """Return the motion of an interval, seconds; ``onto`` is the ref of an uploaded rig."""
        body = {
            "items": [{"ref": ref, "start": start, "end": end}],
            "format": "npz",
            "fps": fps,
            "onto": onto,
        }
        data = self._ask("/api/download", json.dumps(body).encode(), "application/json")
        provenance = ""
        with zipfile.ZipFile(io.BytesIO(data)) as files:  # an .npz is one itself
            names = files.namelist()
            inner = [name for name in names if name.endswith(".npz")]
            if inner:
                data = files.read(inner[0])
                beside = [name for name in names if name.endswith(".json")]
                provenance = files.read(beside[0]).decode() if beside else ""
        with np.load(io.BytesIO(data)) as held:
            return Motion(
                fps=float(held["fps"]),
                joints=[str(name) for name in held["joints"]],
                parents=[int(parent) for parent in held["parents"]],
                offsets=held["offsets"],
                positions=held["positions"],
                local_rotations=held["local_rotations"],
                provenance=provenance,
            )

    def figures(self, parts: list[dict[str, Any]]) -> tuple[list[Array], list[int]]:
        """Return the points of each part at 4 frames a second, and the parents of the points."""
        if not parts:
            return [], []
        data = self._ask(
            "/api/motions", json.dumps({"items": parts, "fps": 4.0}).encode(), "application/json"
        )
        length = int.from_bytes(data[4:8], "little")
        header = json.loads(data[8 : 8 + length])
        payload, n_points = data[8 + length :], len(header["points"])
        figures = []
        for track in header["tracks"]:
            count = track["frames"] * n_points * 3
            values = np.frombuffer(payload, "<i2", count, track["offset"])
            points = values.reshape(track["frames"], n_points, 3)
            figures.append(points * np.array(track["scale"]) + np.array(track["origin"]))
        return figures, header["parents"]

    def _ask(self, path: str, body: bytes | None = None, kind: str = "") -> bytes:
        """Return the bytes of an answer."""
        headers = {"Accept": "*/*"}
        if kind:
            headers["Content-Type"] = kind
        if self.token:
            headers["Authorization"] = f"Bearer {self.token}"
        request = urllib.request.Request(self.address + path, body, headers)
        # no proxy stands between Blender and this computer
        chosen: list[Any] = [urllib.request.ProxyHandler({})] if self.is_local else []
        chosen.append(_NoRedirect())
        try:
            with urllib.request.build_opener(*chosen).open(request, timeout=SECONDS) as answer:
                return bytes(answer.read())
        except urllib.error.HTTPError as error:
            raise ServerError(self._refusal(error)) from None
        except TimeoutError:
            raise ServerError(
                f"server: expected an answer within {SECONDS:.0f} s, found none. Try again; the "
                "first question of a large database takes longest."
            ) from None
        except (urllib.error.URLError, OSError) as error:
            reason = getattr(error, "reason", None) or error
            raise ServerError(
                f"server: expected motiondb at {self.address}, found no answer ({reason}). Start "
                "it in a terminal: motiondb serve --db FILE. The address is in the preferences of "
                "the extension."
            ) from None

    def _refusal(self, error: urllib.error.HTTPError) -> str:
        """Return what the server says, or that it is no motiondb."""
        try:
            said = str(json.loads(error.read())["error"]["message"])
        except (ValueError, KeyError, TypeError, OSError):
            return (
                f"server: expected motiondb at {self.address}, found another program (status "
                f"{error.code}). Correct the address in the preferences of the extension."
            )
        if error.code == 401:
            said += " Paste it into the preferences of the extension."
        return said
