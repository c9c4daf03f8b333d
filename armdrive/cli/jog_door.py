"""Who may come to a desk that is shown in a browser: this computer, this user, one at a time. Pure.

A page of anybody's that is open in the same browser can reach this computer's own ports too, and a
WebSocket asks no leave of its server. So the origin counts, and a key that only the terminal has
shown; both also where another user of the same computer tries.
"""

from __future__ import annotations

import secrets
from dataclasses import dataclass, field

HOST = "127.0.0.1"
"""The only address that is listened on."""

KEY_BYTES = 24
PAGE, SOCKET = "/", "/ws"

POLICY = (
    "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; "
    "script-src 'self' 'unsafe-inline' 'unsafe-eval'; connect-src 'self' ws://{host}; "
    "frame-ancestors 'none'"
)
"""What the page may load, nothing of anybody else's; and no other page may show it inside."""


@dataclass(frozen=True, slots=True)
class Visit:
    """What a browser says when it asks for something."""

    path: str
    host: str
    origin: str = ""
    given: str = ""
    """The key in the address."""
    kept: str = ""
    """The key in the cookie."""


@dataclass(frozen=True, slots=True)
class Door:
    """One desk's address and key."""

    port: int
    key: str = field(default_factory=lambda: secrets.token_urlsafe(KEY_BYTES))

    @property
    def host(self) -> str:
        """What a browser has to call this computer."""
        return f"{HOST}:{self.port}"

    @property
    def address(self) -> str:
        """What is opened in the browser."""
        return f"http://{self.host}{PAGE}?key={self.key}"

    @property
    def cookie(self) -> str:
        """The cookie's name: one browser may have the desks of several ports."""
        return f"armdrive-{self.port}"

    @property
    def headers(self) -> dict[str, str]:
        """What every answer says beside its content."""
        policy = POLICY.format(host=self.host)
        return {"Content-Security-Policy": policy, "Referrer-Policy": "no-referrer"}

    def refusal(self, visit: Visit) -> str:
        """Return why a browser is not let in; nothing where it is."""
        if visit.host != self.host:
            return f"this desk is at http://{self.host}, and is called nothing else"
        if visit.origin not in ("", f"http://{self.host}"):
            return "another page asked for this: a desk is opened by its own address alone"
        if visit.path == SOCKET and not visit.origin:
            return "a desk is opened by a browser"
        shown = visit.kept or visit.given if visit.path != PAGE else visit.given or visit.kept
        # a cookie may have any bytes, of which some decode to what no encoding has
        if not secrets.compare_digest(shown.encode(errors="replace"), self.key.encode()):
            return "open the whole address that `armdrive jog --web` has printed, with its key"
        return ""
