"""The first questions: the arm's name, the template it begins from, the wire that leads to it."""

from __future__ import annotations

from armdrive.dialog.conversation import Reader, WrongAnswer, choice, number, text, whole, yes_or_no
from armdrive.errors import BadRequest
from armdrive.registry import DIALECTS
from armdrive.setup.draft import Draft
from armdrive.setup.questions.arm import ArmRow, fixed, plain
from armdrive.setup.templates import available
from armdrive.storage.files import file_name
from armdrive.transports.address import is_can
from armdrive.transports.can_address import CanAddress


def _name(line: str) -> str:
    if not line or file_name(line) != line:
        raise WrongAnswer(
            f"{line!r} is no name for a file: use letters, digits, dots, dashes and underscores"
        )
    if line.endswith(".toml"):
        raise WrongAnswer(f"the name without its ending: {line.removesuffix('.toml')}")
    return line


def _port(draft: Draft) -> Reader:
    ports = draft.around.ports

    def read(line: str) -> str:
        if line in ("", "none"):
            return ""
        if line.isdecimal():
            return ports[int(number(1, len(ports))(line)) - 1] if ports else _no_port(line)
        written = any(mark in line for mark in ("/", "\\", "://")) or line.upper()[:3] == "COM"
        if not (written or is_can(line)):
            return _no_port(line)
        return line

    return read


def _no_port(line: str) -> str:
    raise WrongAnswer(
        f"{line!r} names no port: write it in full (/dev/ttyUSB0, COM3, socket://HOST:PORT), or "
        "none for now"
    )


def _bus(draft: Draft) -> Reader:
    buses = draft.around.buses

    def read(line: str) -> str:
        if line in ("", "none"):
            return ""
        if line.isdecimal() and buses:
            return buses[int(number(1, len(buses))(line)) - 1]
        try:
            return str(CanAddress.parse(line))
        except BadRequest:
            raise WrongAnswer(
                f"{line!r} names no CAN adapter, and these drives are on a CAN bus: write it as "
                "can:slcan:/dev/ttyACM0?bitrate=500000 or can:socketcan:can0, or none for now"
            ) from None

    return read


def _on_bus(draft: Draft) -> bool:
    return draft.dialect.can


def _on_line(draft: Draft) -> bool:
    return not draft.dialect.can


def _has_baud(draft: Draft) -> bool:
    """Tell whether it has a rate of its own: a bus's is told with its port."""
    return _on_line(draft) or "connection.baud" in draft.around.given


def _resets(draft: Draft) -> bool:
    return draft.dialect.abilities.resets_on_open and bool(draft.get("connection.port"))


ROWS = (
    ArmRow(
        "name", "What is the arm called?",
        "The arm file is named so, and every command takes this name: armdrive status --arm NAME.",
        fixed(_name),
    ),
    ArmRow(
        "template", "Which template does it begin from?",
        "A template brings a model, a dialect and defaults; every number can be changed below.",
        lambda _draft: choice(tuple(available())),
        choices=lambda _draft: tuple((key, row.title) for key, row in available().items()),
    ),
    ArmRow(
        "title", "A title for people?", "Shown wherever the arm is named.",
        fixed(text),
        lambda draft, _one: draft.preset.title if draft.preset else draft.name,
    ),
    ArmRow(
        "dialect", "Which dialect does its controller speak?",
        "The language of the controller's firmware. Nothing is sent to find out.",
        lambda _draft: choice(tuple(DIALECTS)),
        lambda draft, _one: draft.template.dialect,
        choices=lambda _draft: tuple((row.name, row.title) for row in DIALECTS.values()),
    ),
    ArmRow(
        "connection.port", "Which port leads to it? (none: only simulated for now)",
        "A serial port, or any pyserial URL such as socket://HOST:PORT. None is opened to look. "
        "Unplug the arm and ask `armdrive ports` again to see which one is its.",
        _port, plain("none"),
        choices=lambda draft: tuple((port, "") for port in draft.around.ports),
        when=_on_line,
    ),
    ArmRow(
        "connection.port", "Which CAN adapter leads to its drives? (none: only simulated for now)",
        "Written can:INTERFACE:CHANNEL, with the bus's bit rate behind it where the adapter is to "
        "be told: can:slcan:/dev/ttyACM0?bitrate=500000, or can:socketcan:can0 of the kernel. None "
        "is opened to look. `armdrive ports` lists them.",
        _bus, plain("none"),
        choices=lambda draft: tuple((port, "") for port in draft.around.buses),
        when=_on_bus,
    ),
    ArmRow(
        "connection.baud", "At how many baud?", "The dialect's own rate, unless you changed it.",
        fixed(whole(50, 4_000_000)),
        lambda draft, _one: str(draft.dialect.baud),
        when=_has_baud,
    ),
    ArmRow(
        "connection.keep_dtr", "Keep the board from resetting when its port is opened again?",
        "Such a board resets when DTR rises, which loses the position and drops the motors. Kept "
        "up between programs, it resets at the first opening alone.",
        fixed(yes_or_no), plain("yes"), when=_resets,
    ),
)  # fmt: skip
"""Asked first, in this order."""
