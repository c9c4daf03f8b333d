"""What a simulated device has that is several drives on a CAN bus, for its wire and its faults."""

from __future__ import annotations

from typing import Protocol, runtime_checkable


@runtime_checkable
class DrivesOnBus(Protocol):
    """A device that says and hears packed frames; its drives are counted from 0, as the motors."""

    def bits_s(self) -> int:
        """Return the speed of its bus."""

    def mute_drive(self, drive: int, mute: bool) -> None:
        """Have a drive say nothing, while it hears and obeys; or speak again."""

    def plug_drive(self, drive: int, on: bool) -> None:
        """Plug a drive's CAN cable in, or pull it: it neither hears nor says anything then."""

    def power_drive(self, drive: int, on: bool) -> None:
        """Take a drive's supply away, and what it holds comes down; or give it back."""

    def reset_drive(self, drive: int) -> None:
        """Have a drive's firmware begin anew, in motion or not."""

    def set_drive_id(self, drive: int, node: int) -> int:
        """Give a drive an id, another one's perhaps; return the old. Raises `BadRequest`."""

    def set_drive_mode(self, drive: int, mode: int) -> int:
        """Give a drive a mode, as at its own keys; return the old. Raises `BadRequest`."""

    def withhold_done(self, drive: int, withheld: bool) -> None:
        """Have a drive not say that a motion is done, or say it again."""


@runtime_checkable
class SaysEmergencies(Protocol):
    """Drives that say error codes by themselves, counted from 0."""

    def ail_drive(self, drive: int, code: int) -> None:
        """Have something be wrong with a drive: it fails, until it is mended and reset."""

    def mend_drive(self, drive: int, code: int) -> None:
        """Have what was wrong with a drive be right again; its fault is to be reset yet."""

    def warn_drive(self, drive: int, code: int) -> None:
        """Have a drive say an error code, and go on."""
