"""Finds and opens the port of a real arm, explains a failed connection, and reconnects the arm."""

from __future__ import annotations

import contextlib
import math
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from types import MappingProxyType

from armdrive.config.arm import ArmConfig
from armdrive.config.sections import Connection
from armdrive.connect.target import FORCE_SIM
from armdrive.dialects.recognition import (
    Recogniser,
    comes_back,
    excerpt,
    says_something_readable,
)
from armdrive.errors import ArmError, DeviceFault, LinkLost, NoAnswer, PortUnavailable
from armdrive.errors.printable import command_line, reason_of
from armdrive.motion.connecting import recover
from armdrive.motion.context import MotionContext, without_reset
from armdrive.registry import DIALECTS, dialect
from armdrive.registry.arm_files import port_problem
from armdrive.runtime.engine import Engine
from armdrive.tasks import TaskBody
from armdrive.trace.entries import EntryKind, TraceEntry
from armdrive.transports import opening, ports
from armdrive.transports.address import PREFIX, CanAddress, is_can, scheme
from armdrive.transports.link import AbsentLink, Link


class PortOpening:
    """Opens the port of one arm, found by its adapter's USB serial number, otherwise by name.

    An adapter with a serial number is later found by that number. When it is plugged in again, it
    may have a different name, and another adapter may have its old name.
    """

    def __init__(self, config: ArmConfig) -> None:
        self._connection = config.connection
        self._port = config.connection.port
        self._serial_number = config.connection.usb_serial
        self._ids = dialect(config.connection.dialect).driver().frame_ids(config.device)
        require_port(config)

    def find(self) -> str:
        """Return the port's present name. Raises `NoSuchPort` if no port has the serial number."""
        self._port = ports.device_of(self._serial_number, self._port)
        return self._port

    def open(self) -> Link:
        """Open the port under its present name; sends nothing. Raises `PortUnavailable`."""
        port = self.find()
        known = self._serial_number
        serial_number = known or ("" if scheme(port) else ports.serial_number_of(port))
        link = opening.open_link(
            self._filtered(port),
            self._connection.baud,
            raise_dtr=self._connection.raise_dtr,
            keep_dtr_on_close=self._connection.keep_dtr_on_close,
        )
        self._serial_number = serial_number
        return link

    def _filtered(self, port: str) -> str:
        """Add the drives' ids to the address of a CAN bus, so that no other frames are read."""
        if not (self._ids and is_can(port)):
            return port
        address = CanAddress.parse(port)
        return port if address.ids else str(replace(address, ids=frozenset(self._ids)))


def require_port(config: ArmConfig) -> None:
    """Raise `PortUnavailable` if an arm names no port, or one that cannot be its own."""
    if not config.connection.names_port:
        raise PortUnavailable(
            f'the arm file of {config.name} names no port: write port (such as "/dev/ttyUSB0") '
            f"or usb_serial under [connection]; `armdrive ports` lists the ports, and with "
            f"{FORCE_SIM}=1 in the environment the arm is simulated"
        )
    if problem := port_problem(config.connection):
        raise PortUnavailable(problem)


def lock_names(config: ArmConfig) -> tuple[str, ...]:
    """Return the names under which a program may hold a real arm: its own, and that of its port."""
    try:
        return config.name, PortOpening(config).find()
    except PortUnavailable:  # a program may hold the arm whose adapter has been pulled out
        return (config.name,)


# Explaining a failed connection: which device answered instead of the expected one.

MOST_BYTES = 4096  # received bytes that are examined
MOST_WRITES = 64  # writes that are compared with them, to find an echo
MOST_IDS = 6  # frame ids listed


@cache
def recogniser() -> Recogniser:
    """Return the recogniser of all devices that are not on a bus."""
    rows = ((row, row.tools().recognition) for row in DIALECTS.values())
    known = {row.name: each.of(row.name, row.baud) for row, each in rows if each}
    return Recogniser(MappingProxyType(known))


@contextlib.contextmanager
def explaining(
    recorded: Callable[[], Iterable[TraceEntry]], connection: Connection
) -> Iterator[None]:
    """Add what was received, and how to find out more, to the error of a failed connection.

    `recorded` returns the entries of the connection's recorder. On a bus that is lost at once, no
    node acknowledges frames: `armdrive doctor` finds out which nodes are there.
    """
    try:
        yield
    except DeviceFault as fault:
        entries = tuple(recorded())
        sent, received = (
            [each.what for each in entries if each.kind is kind and isinstance(each.what, bytes)]
            for kind in (EntryKind.SENT, EntryKind.RECEIVED)
        )
        heard = b"".join(received)[:MOST_BYTES]
        raise explained(fault, heard, connection, sent[:MOST_WRITES]) from None
    except LinkLost as lost:
        if not is_can(connection.port):
            raise
        raise LinkLost(f"{str(lost).rstrip('.')}. {_doctor(connection.port)}") from None


def explained(
    fault: DeviceFault, received: bytes, connection: Connection, sent: Sequence[bytes] = ()
) -> DeviceFault:
    """Return the fault with what was received, and how to find out more."""
    if not is_can(connection.port):
        instead = _instead(received, connection.dialect, sent)
    else:
        instead = _frames_heard(received, connection) if isinstance(fault, NoAnswer) else ""
    sentences = [str(fault).rstrip(".") + ".", instead, _doctor(connection.port)]
    return type(fault)(" ".join(each for each in sentences if each))


def bare(fault: BaseException, connection: Connection) -> str:
    """Return the error text of a failed connection without the reference to the doctor."""
    return str(fault).removesuffix(_doctor(connection.port)).rstrip(" .")


def _frames_heard(received: bytes, connection: Connection) -> str:
    """Return whose frames were received: nodes with other ids than those in the arm file show."""
    unpacker = dialect(connection.dialect).driver().frames
    frames = [] if unpacker is None else unpacker().feed(received)
    ids = list(dict.fromkeys(f"{frame.can_id:X}" for frame in frames))
    if not ids:
        return "Nothing was received."
    more = ", ..." if len(ids) > MOST_IDS else ""
    return f"Frames were received, but not the answer: ids {', '.join(ids[:MOST_IDS])}{more}."


def _instead(received: bytes, dialect: str, sent: Sequence[bytes]) -> str:
    if comes_back(sent, received):
        return (
            "Everything that is sent comes straight back: transmit and receive are connected, or "
            "the adapter or the board echoes. Switch the echo off, and check the wiring."
        )
    identity = recogniser().recognise(received)
    if identity is not None and identity.dialect != dialect:
        choice = f"set the dialect to {identity.dialect}" if identity.dialect else identity.remedy
        chosen = f"; {choice}" if choice else ""
        return f"The device does not speak {dialect}: it is {identity.firmware}{chosen}."
    if not received or identity is not None:
        return ""
    if says_something_readable(received):
        return f"The bytes received are not in the {dialect} dialect: {excerpt(received)}."
    return f"The bytes received are unreadable: {excerpt(received)}; is the baud rate right?"


def _doctor(port: str) -> str:
    if is_can(port):
        survey = command_line("doctor", "--can", port.removeprefix(PREFIX))
        return f"`{survey}` finds out which drives are there, and moves nothing."
    which = "" if port else ", for the port that `armdrive ports` shows,"
    doctor = command_line("doctor", port or "PORT")
    return f"`{doctor}`{which} finds out what is there, and moves nothing."


# Reconnecting a lost link. The engine reports the loss (`Reconnector.lost`), and calls the
# reconnector in the place of its controller from then on. The old link is closed, and an
# `AbsentLink` stands in for it. An attempt tries to open the port; if it fails, the next one
# follows after a longer pause. Once the port is open, the engine gets the new link and a new
# controller, which repeats no request of the old one (`_take`). A task then checks that the same
# arm answers (`recover`, motion/connecting.py), and leaves it in a state in which nothing moves.

# The pauses before each attempt; the last one repeats. Opening a port can reset a board.
PAUSES_S = (0.2, 0.3, 0.5, 1.0, 2.0, 5.0)
# How long an attempt waits for the old link to close: it may still send a stop, and it holds the
# port.
LET_GO_S = 3.0


@dataclass(frozen=True, slots=True, eq=False)
class NewLink:
    """How to reopen a lost link: `open_again` raises `PortUnavailable` while the port is missing.

    With `automatic`, attempts start by themselves. With `in_thread`, each attempt runs in its own
    thread, because a network can take seconds to refuse a connection.
    """

    open_again: Callable[[], Link]
    automatic: bool = False
    in_thread: bool = False


class Reconnector:
    """Reconnects one arm. The engine calls it, under its lock, while the link is lost."""

    def __init__(self, context: MotionContext, rewiring: NewLink) -> None:
        self.tries = 0
        """The number of attempts that have ended, successfully or not."""
        self.trouble: ArmError | None = None
        """Why the last attempt failed."""
        self._context = context
        self._rewiring = rewiring
        self._closing: threading.Thread | None = None
        """Closes the old link, which holds the port until then."""
        self._trying = False
        self._lock = threading.Lock()  # of the two that follow, which an attempt's thread shares
        self._outcome: Link | ArmError | None = None
        """What the attempt under way has led to; None until it ends."""
        self._closed = False
        self._due_s = math.inf
        self._lost_s = 0.0
        self._lost_link = ""
        self._failures = 0

    @property
    def automatic(self) -> bool:
        """Whether attempts start by themselves."""
        return self._rewiring.automatic

    @property
    def _engine(self) -> Engine:
        return self._context.engine

    def lost(self, now_s: float) -> None:
        """Close the broken link, which frees its port; schedule an attempt if automatic.

        Called for a link that was lost, and for a new one on which the arm did not answer.
        """
        self._lost_s = now_s
        old = self._engine.link
        self._lost_link = self._lost_link or old.description
        self._engine.link = AbsentLink(old.description)
        self._closing = self._run(old.close, "armdrive-closing")  # a socket can take a moment
        if self._rewiring.automatic:
            self._due_s = now_s + self._pause_s()

    def ask(self, now_s: float) -> int:
        """Try at once; return the number of attempts that had ended before."""
        self._due_s = now_s
        return self.tries

    def close(self) -> None:
        """Make no more attempts."""
        self._due_s = math.inf
        with self._lock:
            self._closed, outcome = True, self._outcome
        _close(outcome)

    def __call__(self, now_s: float) -> float:
        """Do all that is due; return when to call again."""
        if not self._trying:
            if now_s < self._due_s:
                return self._due_s
            self._due_s, self._trying = math.inf, True
            self._run(self._try, "armdrive-opening")
        with self._lock:
            outcome, self._outcome = self._outcome, None
        if outcome is None:
            return math.inf
        self._trying = False
        if isinstance(outcome, ArmError):
            self._failed(outcome, now_s)
        else:
            self._take(outcome)
        return self._due_s

    def _run(self, work: Callable[[], None], name: str) -> threading.Thread | None:
        """Do some work, in a thread of its own if the link may take its time."""
        if not self._rewiring.in_thread:
            work()
            return None
        thread = threading.Thread(target=work, name=name, daemon=True)
        thread.start()
        return thread

    def _try(self) -> None:
        """Open the link, once the old one has let go of the port; close it if it comes too late."""
        outcome: Link | ArmError
        if self._closing is not None:
            self._closing.join(LET_GO_S)
        try:
            outcome = self._rewiring.open_again()
        except ArmError as error:
            outcome = error
        except OSError as error:
            outcome = LinkLost(f"the link cannot be opened ({reason_of(error)})")
        with self._lock:
            self._outcome, unwanted = outcome, self._closed
        if unwanted:
            _close(outcome)
        self._engine.link.wake()

    def _take(self, link: Link) -> None:
        """Continue on a new link, with a controller that remembers nothing of the old one."""
        core, absent = self._context.core, self._engine.link
        # a controller remembers what it has sent; the device may have restarted meanwhile
        core.controller = dialect(core.config.connection.dialect).controller(core.config)
        self._engine.take(link, core.controller)
        absent.close()
        core.notify(f"found {link.description}: checking whether the arm answers")
        # a motion that was sent before the loss may still be running: wait for its end first
        runs_s = max(self._lost_s + core.stops.sent_s(core.controller) - self._engine.now_s, 0.0)
        self._engine.start(self._resume(), within_s=runs_s + self._engine.call_limit_s)

    def _resume(self) -> TaskBody[None]:
        """Check that the same arm answers on the new link, and restore its state."""
        try:
            yield from recover(self._context, self._lost_s, self._lost_link)
        except ArmError as error:
            self._failed(error, self._context.now_s)
            raise LinkLost(
                f"the port is open again, but the arm is not ready: {without_reset(error)}. "
                "Nothing moves; reconnect again"
            ) from None
        self.tries += 1
        self._lost_link = ""
        self._failures, self.trouble = 0, None
        self._engine.prove()

    def _failed(self, error: ArmError, now_s: float) -> None:
        self.tries += 1
        self._failures += 1
        self.trouble = error
        self._context.core.notify(f"could not reconnect: {without_reset(error)}", error)
        if self._rewiring.automatic:
            self._due_s = now_s + self._pause_s()

    def _pause_s(self) -> float:
        return PAUSES_S[min(self._failures, len(PAUSES_S) - 1)]


def _close(outcome: Link | ArmError | None) -> None:
    """Close what an attempt has opened, if it has opened anything."""
    if outcome is not None and not isinstance(outcome, ArmError):
        outcome.close()
