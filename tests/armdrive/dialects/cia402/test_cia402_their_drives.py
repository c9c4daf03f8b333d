"""The driver on drives of the package `canopen`, an independent CANopen: its nodes, SDO and PDOs.

In simulated time and in this process. What is ours of those drives is their state machine, and a
position that is the target at once.
"""

import io
from types import SimpleNamespace

import pytest

canopen = pytest.importorskip("canopen")

from canopen.objectdictionary.eds import import_eds  # noqa: E402
from cia402_rig import steps  # noqa: E402
from driver_bench import DriverBench  # noqa: E402

from armdrive.connect.target import simulated_config  # noqa: E402
from armdrive.dialects.cia402.controller import Cia402Controller  # noqa: E402
from armdrive.registry import DIALECTS  # noqa: E402
from armdrive.sim.cia402.objects import eds_text  # noqa: E402
from armdrive.tasks import (  # noqa: E402
    Done,
    DropCurrent,
    Halted,
    MoveAlong,
    MoveBy,
    ReadPosition,
    SwitchOn,
)
from firmware_protocol.frames import Frame, Unpacker, pack  # noqa: E402

WIRE_S = 0.0003
OFF, READY, ON, ENABLED, QUICK_STOP = 0x0250, 0x0231, 0x0233, 0x0237, 0x0217
NEXT = {
    (OFF, 0x06): READY,
    (READY, 0x07): ON,
    (READY, 0x0F): ENABLED,
    (ON, 0x0F): ENABLED,
    (ENABLED, 0x02): QUICK_STOP,
    (QUICK_STOP, 0x0F): ENABLED,
}


class QuietNetwork(canopen.Network):
    """Their network without a bus: what they send is kept for us, and nothing is periodic."""

    def __init__(self) -> None:
        super().__init__()
        self.said: list[Frame] = []

    def send_message(self, can_id, data, remote=False) -> None:
        self.said.append(Frame(can_id, bytes(data)))

    def send_periodic(self, *_words, **_named):
        return SimpleNamespace(stop=lambda: None, update=lambda _data: None)


class TheirDrive:
    """A node of theirs that is a drive."""

    def __init__(self, network: QuietNetwork, number: int) -> None:
        self.node = network.add_node(
            canopen.LocalNode(number, import_eds(io.StringIO(eds_text()), number))
        )
        self.word, self.position, self.mode = OFF, 100 * number, 0
        self.running = False
        self.words: list[int] = []
        self.new = False
        self.node.add_read_callback(self._read)

    def _read(self, *, index, **_named):
        return {0x6041: self.word, 0x6061: self.mode, 0x6064: self.position}.get(index)

    def after(self, frame: Frame) -> None:
        """Do what a frame means that their node has taken."""
        operational = self.node.nmt.state == "OPERATIONAL"
        if operational and not self.running:
            self.node.rpdo.read()
            self.node.tpdo.read()
            for each in self.node.rpdo.values():
                each.subscribe()
        self.running = operational
        if operational and frame.can_id == 0x200 + self.node.id:
            self.new = True
        if operational and frame.can_id == 0x80:
            self._sync()

    def _sync(self) -> None:
        if self.new:
            self._obey(self.node.rpdo[1])
        told = self.node.tpdo[1]
        told[0x6041].raw, told[0x6061].raw = self.word, self.mode
        told[0x6064].raw = self.position
        told.transmit()

    def _obey(self, order) -> None:
        self.new = False
        word = order[0x6040].raw
        self.words.append(word)
        self.mode = order[0x6060].raw
        self.word = OFF if word == 0 else NEXT.get((self.word, word & 0x8F), self.word)
        if self.word == ENABLED and self.mode == 8:
            self.position = order[0x607A].raw


class Bus(DriverBench):
    """Their drives, and our controller, on simulated time."""

    def __init__(self) -> None:
        self.network = QuietNetwork()
        self.drives = [TheirDrive(self.network, number) for number in range(1, 7)]
        for drive in self.drives:
            drive.node.nmt.state = "PRE-OPERATIONAL"
        self.network.said.clear()
        self.due: list[tuple[float, Frame]] = []
        self._unpacker = Unpacker()
        abilities = DIALECTS["cia402"].abilities
        super().__init__(Cia402Controller(abilities, simulated_config("cia402")))

    def _step(self, end_s: float) -> None:
        self._pass_to(self._due_s(end_s, *(at_s for at_s, _ in self.due)))
        ready = [frame for at_s, frame in self.due if at_s <= self.now_s]
        self.due = [entry for entry in self.due if entry[0] > self.now_s]
        for frame in ready:
            self.controller.receive(pack(frame), self.now_s)
        self._send()

    def _send(self) -> None:
        for frame in self._unpacker.feed(self.controller.advance(self.now_s)):
            self.network.notify(frame.can_id, bytearray(frame.data), self.now_s)
            for drive in self.drives:
                drive.after(frame)
        self.due += [(self.now_s + WIRE_S, frame) for frame in self.network.said]
        self.network.said.clear()


def test_their_drives_are_set_up_switched_on_and_driven_by_sync():
    bus = Bus()
    assert bus.do(ReadPosition()).positions == (100, 200, 300, 400, 500, 600)
    assert bus.do(SwitchOn()) == Done()
    assert {drive.word for drive in bus.drives} == {ENABLED}
    assert bus.drives[0].node.sdo[0x1016][1].raw == 127 << 16 | 200
    assert bus.drives[0].node.sdo[0x6007].raw == 3
    way = (MoveBy(steps(3000, -1500), 20_000.0), MoveBy(steps(-1000), 20_000.0))
    assert bus.do(MoveAlong(iter(way), 0.3)) == Done()
    assert [drive.position for drive in bus.drives[:2]] == [2100, -1300]
    assert not bus.alerts()


def test_their_drives_are_stopped_by_a_quick_stop_held_and_let_go_when_asked():
    bus = Bus()
    bus.do(SwitchOn())
    bus.at_s[bus.now_s + 0.3] = lambda: bus.controller.stop(hard=False)
    way = MoveAlong(iter([MoveBy(steps(20_000), 20_000.0)]), 2.0)
    assert bus.do(way) == Halted()
    assert 0x02 in bus.drives[0].words
    assert {drive.word for drive in bus.drives} == {ENABLED}
    assert bus.drives[0].position < 20_000 * 0.35
    assert bus.do(DropCurrent()) == Done()
    assert {drive.word for drive in bus.drives} == {OFF}
