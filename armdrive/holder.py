"""What other programs ask of the one that holds an arm, over its local socket.

What may be asked stands in neighbours.py. Messages are JSON objects; nothing is ever unpickled.
"""

from __future__ import annotations

import contextlib
import json
from typing import TYPE_CHECKING, Any

from armdrive import places
from armdrive.errors import ArmError
from armdrive.holder_notice import AGAIN, PATIENCE_S, called, holder_words, knock, notice_of
from armdrive.private import is_ours

if TYPE_CHECKING:
    from collections.abc import Generator, Iterator
    from multiprocessing.connection import Connection

CALLS = 5
"""Calls before a request is given up that others crowd out."""


def ask_holder(name: str, request: str, **words: object) -> dict[str, Any]:
    """Ask the holder of an arm (neighbours.py says what). Raises `ArmError` where none is."""
    for _ in range(CALLS):
        with _called(name) as connection:
            connection.send_bytes(json.dumps({"request": request, **words}).encode())
            answer = _heard(name, connection)
        if not answer.get(AGAIN):
            break
    return answer


def watch_holder(name: str, every_s: float) -> Iterator[dict[str, Any]]:
    """Yield the status of a held arm whenever it has changed, until its holder gives it back.

    Raises `ArmError` where none holds it, or the holder falls silent.
    """
    return _changes(name, "watch", every_s)


def follow_holder(name: str, every_s: float) -> Iterator[dict[str, Any]]:
    """Yield the status as `watch_holder` does, and whenever a program has come further as well."""
    return _changes(name, "follow", every_s)


def overhear_holder(name: str, every_s: float) -> Iterator[dict[str, Any]]:
    """Yield what passes on a held arm's wire (overhearing.py), and `{}` where nothing does.

    Ends, and raises, as `watch_holder` does.
    """
    return _streamed(name, "wire", every_s)


def _changes(name: str, request: str, every_s: float) -> Iterator[dict[str, Any]]:
    """Yield what is not nothing; whoever closes this has hung up."""
    with contextlib.closing(_streamed(name, request, every_s)) as said:
        yield from filter(None, said)


def _streamed(name: str, request: str, every_s: float) -> Generator[dict[str, Any], None, None]:
    with _called(name) as connection:
        try:
            connection.send_bytes(json.dumps({"request": request, "every_s": every_s}).encode())
            while True:
                yield _heard(name, connection, max(every_s, 0.0))
        except _HUNG_UP:
            return


_HUNG_UP = (EOFError, ConnectionResetError, BrokenPipeError)
"""How the end of a call is met: the last two by a caller whose words were not read any more."""


@contextlib.contextmanager
def _called(name: str) -> Iterator[Connection[Any, Any]]:
    """Call the holder of an arm, and hang up at the end; every trouble becomes a sentence."""
    notice = notice_of(name)
    if notice is None:
        raise ArmError(f"no program holds {name}: nothing moves it from this computer")
    try:
        with called(str(notice["address"])) as connection:
            if not is_ours(connection.fileno()):
                raise ArmError(f"another user's program answers for {name}: it was asked nothing")
            yield connection
    except (ConnectionRefusedError, FileNotFoundError):
        raise ArmError(
            f"{holder_words(name)} held {name} and was ended without a chance to give it back: "
            "nothing moves it from this computer any more"
        ) from None
    except (OSError, EOFError, ValueError) as error:
        raise ArmError(f"{holder_words(name)} cannot be asked: {error}") from None


def _heard(name: str, connection: Connection[Any, Any], longer_s: float = 0.0) -> dict[str, Any]:
    if not connection.poll(PATIENCE_S + longer_s):
        raise ArmError(f"{holder_words(name)} does not answer; stop the arm at its own switch")
    answer = json.loads(connection.recv_bytes(65536))
    return answer if isinstance(answer, dict) else {}


def held_arms() -> list[str]:
    """Return the names under which programs hold arms now."""
    found: dict[str, str] = {}
    for path in sorted(places.states().glob("*.holder")):
        name = path.name.removesuffix(".holder")
        notice = notice_of(name) or {}
        address = str(notice.get("address"))
        with contextlib.suppress(OSError, EOFError):  # left behind by a program that was killed
            knock(address)
            found[address] = str(
                notice.get("arm", name)
            )  # an arm goes by its own name and by its port's
    return list(found.values())
