"""Switching the motors of CiA 402 drives on and off, and leaving their faults. Nothing moves."""

from __future__ import annotations

from collections.abc import Generator

from armdrive.dialects.cia402 import contact as setup
from armdrive.dialects.cia402.contact import Cia402Contact, refused_of
from armdrive.dialects.cia402.cycle import Script
from armdrive.dialects.cia402.drive import Cia402Drive
from armdrive.dialects.cia402.master import Heard
from armdrive.dialects.cia402.power import Hindrance
from armdrive.dialects.cia402.receive import FAULTS
from armdrive.dialects.cia402.sdo_queue import ObjectRead
from armdrive.tasks import Done, RequestRejected
from firmware_protocol.canopen import CONSUMER_HEARTBEAT, ERROR_CODE, DriveState, error_words

FAREWELLS = 2
"""Nobody waits for an answer: it is said so often."""


class Cia402Current(Cia402Contact):
    """Drives that hold, or not, and mind this program's heartbeat while they do."""

    # -- current ------------------------------------------------------------------------------

    def switch_on(self) -> Script:
        """Have every drive hold its motor where it is, and mind this program's heartbeat."""
        self.on = False
        if missing := (yield from self.look()):
            return self.absence(missing, self.now_s)
        for drive in self.drives:
            if drive.state in FAULTS:
                yield from self.explain(drive)
                return RequestRejected(
                    f"{self.fault_words(drive)}; `reset()` clears that", moved=False
                )
        if (hindrance := (yield from self._watch(on=True))) is not None:
            return hindrance
        if left := (yield from self.bring(self.drives, DriveState.ENABLED)):
            yield from self.explain(left[0])
            return RequestRejected(self._stays_words(left[0]), moved=False)
        if missing := (yield from self.look()):
            return self.absence(missing, self.now_s)
        for drive in self.drives:
            if abs(drive.seen - drive.place) > self.settings.rest_window:
                drive.rest()
            drive.booted = drive.reported = False
            drive.error = ""
        self.on = True
        return Done()

    def switch_off(self) -> Script:
        """Have every drive let its motor go."""
        self.on = False
        hindrance = yield from self._watch(on=False)
        left = yield from self.bring(self.drives, DriveState.DISABLED)
        off = [drive for drive in left if drive.state not in FAULTS]
        if any(drive.missed > 1 for drive in off):
            return self.absence(off, self.now_s)
        if off:
            return RequestRejected(f"{off[0]} does not switch its motor off")
        self.beats.end()
        return hindrance or Done()

    def farewell(self) -> bytes:
        """Have drives that stand mind the heartbeat no more: they hold, and none of them alarms."""
        if self.busy or not self.beats.on:
            return b""
        self.beats.end()
        write, said = setup.watch(self.settings, on=False), b""
        for drive in self.drives * FAREWELLS:
            self.bus.abandon(drive.node)
            said += self.bus.download(drive.node, write.place, write.data)
        return said

    def _watch(self, *, on: bool) -> Hindrance:
        """Have the drives mind this program's heartbeat, or no more; see that they do."""
        began_s, write = self.now_s, setup.watch(self.settings, on=on)
        self.last_said = "SDO 1016"
        lanes = yield from self.everywhere(write, ObjectRead(CONSUMER_HEARTBEAT))
        if on:
            self.beats.begin(self.now_s)
        if (missing := self.missing(lanes, began_s)) is not None:
            return missing
        if (refused := refused_of(lanes)) is not None:
            return refused
        for lane in lanes.values():
            if lane.values.get(CONSUMER_HEARTBEAT) != write.value:
                return RequestRejected(
                    f"{lane.drive} does not mind this program's heartbeat, whatever is written to "
                    f"object {CONSUMER_HEARTBEAT}: it would not stop when this program dies",
                    moved=False,
                )
        return None

    def _stays_words(self, drive: Cia402Drive) -> str:
        if drive.state in FAULTS:
            return f"{self.fault_words(drive)}; `reset()` clears that"
        state = "in no state" if drive.word is None else f"at {drive.word}"
        return (
            f"{drive} does not switch its motor on, it stays {state}: check the motors' supply "
            "and the drive's own enable input"
        )

    # -- faults -------------------------------------------------------------------------------

    def clear(self) -> Script:
        """Reset faults and leave quick stops: drives hold, or not, as they did. Moves nothing."""
        if missing := (yield from self.look()):
            return self.absence(missing, self.now_s)
        for drive in self.drives:
            self.report(drive)  # what nobody knows yet, as that a motor has no current any more
        faulty = [drive for drive in self.drives if drive.state in FAULTS]
        if left := (yield from self.reset_faults(faulty)):
            yield from self.explain(left[0])
            words = f"{self.fault_words(left[0])}, and does not leave it"
            return RequestRejected(f"{words}: mend that, then call `reset()`", moved=False)
        if (hindrance := (yield from self.resume(self.drives))) is not None:
            return hindrance
        if missing := (yield from self.look()):
            return self.absence(missing, self.now_s)
        for drive in self.drives:
            if not drive.near(self.settings.rest_window):
                drive.rest()
            drive.booted = drive.reported = False
            drive.error = ""
        self.on = self.beats.on and all(each.state is DriveState.ENABLED for each in self.drives)
        return Done()

    def explain(self, drive: Cia402Drive) -> Generator[float, Heard | None, None]:
        """Ask a drive what is wrong with it, where it has not said so."""
        if drive.error:
            return
        lanes = yield from self.transfer({drive.node: (ObjectRead(ERROR_CODE),)}, tries=2)
        code = lanes[drive.node].values.get(ERROR_CODE, 0)
        if code:
            drive.error = f"{error_words(code)} (error {code:04X})"
