"""Access control: host, origin, token and size are checked before any route is called.

A page of another site that is open in the same browser can send requests to this computer. It
cannot hide its own name: the browser puts the name of the requested server into ``Host``, and the
address of the requesting page into ``Origin``. Both are compared with those of this server. The
headers of every answer allow only this page to use it.
"""

from __future__ import annotations

import hmac
import ipaddress
import socket
from collections.abc import Awaitable, Callable, MutableMapping
from typing import Any
from urllib.parse import urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import Request
from starlette.responses import Response

from motiondb.page.errors import PageError, answer_of
from motiondb.page.settings import LOOPBACK, PageSettings

Scope = MutableMapping[str, Any]
Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
Application = Callable[[Scope, Receive, Send], Awaitable[None]]

COOKIE = "motiondb_token"
UPLOADS = "/api/uploads"
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:;"
    " connect-src 'self'; font-src 'self'; base-uri 'none'; form-action 'none';"
    " frame-ancestors 'none'"
)
HEADERS = {
    "Content-Security-Policy": POLICY,
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": "camera=(), microphone=(), geolocation=()",
}
_SAFE = ("GET", "HEAD", "OPTIONS")
_OWN = ("same-origin", "none")


class Guard:
    """Checks every request, and adds headers to every answer."""

    def __init__(self, application: Application, settings: PageSettings) -> None:
        self._application, self._settings = application, settings

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or refuse it."""
        if scope["type"] != "http":
            await self._application(scope, receive, send)
            return
        headers = Headers(scope=scope)

        async def guarded(message: Message) -> None:
            if message["type"] == "http.response.start":
                added = MutableHeaders(raw=message["headers"])
                for name, value in HEADERS.items():
                    added[name] = value
                added.setdefault("Cache-Control", "no-store")
            await send(message)

        try:
            check_host(headers.get("host", ""), self._settings)
            check_origin(scope, headers)
            request = Request(scope)
            if _is_first_visit(request, self._settings):
                is_own = headers.get("sec-fetch-site", "none") in _OWN
                await _keep_token(self._settings.token, is_own)(scope, receive, guarded)
                return
            check_token(request, self._settings)
            check_content(scope, headers)
            limits = self._settings.limits
            most = limits.request_bytes if scope["path"] == UPLOADS else limits.body_bytes
            if int(headers.get("content-length") or 0) > most:
                raise _too_large(most)
        except PageError as error:
            await answer_of(error)(scope, receive, guarded)
            return
        await self._measured(scope, receive, guarded, most)

    async def _measured(self, scope: Scope, receive: Receive, send: Send, most: int) -> None:
        """Pass the request on; refuse it if its body turns out to be larger than the limit."""
        received, is_too_large = 0, False

        async def counted() -> Message:
            nonlocal received, is_too_large
            message = await receive()
            received += len(message.get("body", b""))
            if received > most:
                is_too_large = True
                raise _too_large(most)
            return message

        async def replaced(message: Message) -> None:
            if not is_too_large:
                await send(message)
            elif message["type"] == "http.response.start":
                await answer_of(_too_large(most))(scope, receive, send)

        await self._application(scope, counted, replaced)


def _too_large(most: int) -> PageError:
    return PageError(
        f"request: expected at most {most / 1e6:.3g} MB, found more. Send less at a time.",
        "TooLargeError",
    )


def check_host(host: str, settings: PageSettings) -> None:
    """Refuse a request whose ``Host`` is not a name of this server."""
    name = _host_name(host)
    if settings.is_local:
        known = name in LOOPBACK
    else:
        names = {*LOOPBACK, settings.host.lower(), socket.gethostname().lower()}
        known = name in names or _is_address(name)
    if not known and name not in {each.lower() for each in settings.allowed_hosts}:
        raise PageError(
            f"host: expected one of the names of this server, found {name[:100]!r}. Use the address"
            " that motiondb serve printed.",
            "HostError",
        )


def _host_name(host: str) -> str:
    """Return the name in a ``Host`` header, without its port.

    >>> _host_name("localhost:8765"), _host_name("[::1]:8765"), _host_name("")
    ('localhost', '::1', '')
    """
    try:
        return (urlsplit(f"//{host}").hostname or "").lower()
    except ValueError:
        return ""


def _is_address(name: str) -> bool:
    """Return whether a name is an IP address, which no other site can use as its name."""
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


def check_origin(scope: Scope, headers: Headers) -> None:
    """Refuse a request from a page of another site."""
    origin, host = headers.get("origin"), headers.get("host", "")
    site = headers.get("sec-fetch-site", "none")
    foreign = origin is not None and urlsplit_or_none(origin) != host.lower()
    is_visit = scope["path"] == "/" and scope["method"] == "GET" and origin is None
    if foreign or (site not in _OWN and not is_visit):
        shown = (origin or site)[:100]
        raise PageError(
            f"origin: expected this page, found {shown!r}. Other sites may not use the server.",
            "OriginError",
        )


def urlsplit_or_none(origin: str) -> str | None:
    """Return host and port of an ``http`` or ``https`` origin; None for any other."""
    try:
        parts = urlsplit(origin)
    except ValueError:
        return None
    return parts.netloc.lower() if parts.scheme in ("http", "https") else None


def check_token(request: Request, settings: PageSettings) -> None:
    """Refuse a request without the token, if the page requires one."""
    given = request.headers.get("authorization", "").removeprefix("Bearer ")
    if settings.token and not any(
        _is_token(each, settings) for each in (given, request.cookies.get(COOKIE, ""))
    ):
        raise PageError(
            "token: expected the token that motiondb serve printed, found none or another one. Open"
            " the whole address that it printed.",
            "TokenError",
        )


def _is_token(given: str, settings: PageSettings) -> bool:
    """Whether a text is the token, compared in a time that does not tell how much of it is."""
    return hmac.compare_digest(given.encode("utf-8", "replace"), settings.token.encode())


def _is_first_visit(request: Request, settings: PageSettings) -> bool:
    """Whether a request is ``/?token=T`` with the token."""
    if not settings.token or request.scope["path"] != "/" or request.method != "GET":
        return False
    return _is_token(request.query_params.get("token", ""), settings)


def _keep_token(token: str, is_own: bool) -> Response:
    """Return the answer that stores the token in a cookie and leads to the page without it.

    `is_own`: Whether the user gave the address. Where a file led to it, the cookie would not go
    along with a redirection; it goes with what this answer asks for.
    """
    how = (303, {"Location": "/"}) if is_own else (200, {"Refresh": "0; url=/"})
    answer = Response(status_code=how[0], headers=how[1])
    answer.set_cookie(COOKIE, token, httponly=True, samesite="strict", path="/")
    return answer


def check_content(scope: Scope, headers: Headers) -> None:
    """Refuse a change whose body is not JSON; other sites can send forms without permission."""
    if scope["method"] in _SAFE or scope["path"] == UPLOADS:
        return
    kind = headers.get("content-type", "").partition(";")[0].strip().lower()
    has_body = headers.get("content-length", "0") != "0" or "transfer-encoding" in headers
    if has_body and kind != "application/json":
        raise PageError(
            f"content: expected application/json, found {kind[:60] or 'no type'!r}.",
            "KindError",
        )
