"""Opens a CAN bus by python-can, with its own configuration, and says in words why it cannot."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Any

from armdrive.errors import ArmError, PortUnavailable
from armdrive.transports.can_address import CanAddress
from armdrive.transports.can_refusals import (
    NOT_INSTALLED,
    can_refusal,
    is_down,
    unknown_interface,
)

if TYPE_CHECKING:
    import can

STANDARD_MASK = 0x7FF
EXTENDED_MASK = 0x1FFF_FFFF
_RATES = frozenset({"bitrate", "btr", "timing"})


def open_bus(address: CanAddress) -> tuple[can.BusABC, str]:
    """Open the bus of an address; return it and its name for people. Raises `PortUnavailable`.

    What the address leaves out comes from python-can's configuration, as its users know it.
    """
    try:
        import can
    except ImportError as error:
        raise PortUnavailable(f"{NOT_INSTALLED} ({error})") from None
    logger = logging.getLogger("can")
    if not logger.handlers:  # its warnings would be printed; armdrive's errors tell them
        logger.addHandler(logging.NullHandler())
    settings = _settings(address)
    interface = str(settings.pop("interface"))
    channel = settings.pop("channel", None)
    found = CanAddress(interface, "" if channel is None else str(channel), address.options)
    if down := is_down(found):
        raise down
    if interface == "slcan" and found.channel and not _RATES & settings.keys():
        raise PortUnavailable(
            f"{address} names no bit rate, and an slcan adapter has none of its own: write "
            f"{found}?bitrate=500000"
        )
    if interface == "socketcan" and address.ids:  # elsewhere error frames would be filtered too
        settings["can_filters"] = _filters(address.ids)
    try:
        if interface == "slcan":
            from armdrive.transports.can_slcan import Slcan

            bus: can.BusABC = Slcan(str(channel or ""), **settings)
        else:
            bus = can.Bus(channel=channel, interface=interface, ignore_config=True, **settings)
    except ArmError:
        raise
    except Exception as error:  # every backend has its own kinds
        raise can_refusal(found, error) from None
    return bus, _name(found, settings)


def _settings(address: CanAddress) -> dict[str, Any]:
    """Return what python-can makes of an address and its own configuration."""
    import can

    given: dict[str, Any] = dict(address.options)
    if address.interface:
        given["interface"] = address.interface
    if address.channel:
        given["channel"] = address.channel
    try:
        return dict(can.util.load_config(config=given))
    except NotImplementedError:
        raise unknown_interface(address, can.VALID_INTERFACES) from None
    except (ValueError, TypeError) as error:
        raise PortUnavailable(f"{address} cannot be used: {error}") from None


def _filters(ids: frozenset[int]) -> list[dict[str, int | bool]]:
    return [
        {
            "can_id": each,
            "can_mask": STANDARD_MASK if each <= STANDARD_MASK else EXTENDED_MASK,
            "extended": each > STANDARD_MASK,
        }
        for each in sorted(ids)
    ]


def _name(address: CanAddress, settings: dict[str, Any]) -> str:
    where = str(CanAddress(address.interface, address.channel))
    bitrate = settings.get("bitrate")
    return f"{where} at {bitrate / 1000:g} kbit/s" if isinstance(bitrate, int) else where
