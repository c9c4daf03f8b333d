"""An independent master, of the package `canopen`, reads, enables and drives simulated drives."""

import io
import threading
import time
import uuid
from types import SimpleNamespace

import pytest

canopen = pytest.importorskip("canopen")

import can  # noqa: E402
from canopen.objectdictionary.eds import import_eds  # noqa: E402
from canopen.profiles.p402 import BaseNode402, State402  # noqa: E402
from cia402_sim import MASTER, arm_config  # noqa: E402
from waiting import LONG_S, until  # noqa: E402

from armdrive.registry import simulate  # noqa: E402
from armdrive.sim.bus.line import BusLine  # noqa: E402
from armdrive.sim.cia402.objects import eds_text  # noqa: E402
from firmware_protocol.frames import Frame, Unpacker, pack  # noqa: E402

WAKES_S = 0.002
"""So often the drives live on while nobody says anything."""
TARGET = 700


class Living:
    """The drives in a thread, at one end of a bus within this process."""

    def __init__(self) -> None:
        self.device = simulate(arm_config()).device
        self._line = BusLine(self.device)
        self._channel = str(uuid.uuid4())
        self._ours = can.Bus(self._channel, interface="virtual")
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._live, daemon=True)
        self.network = canopen.Network()
        self.network.NOTIFIER_CYCLE = 0.02
        self.network.connect(channel=self._channel, interface="virtual")
        self._thread.start()

    def end(self) -> None:
        self.network.disconnect()
        self._ended.set()
        self._thread.join(LONG_S)
        self._ours.shutdown()

    def _live(self) -> None:
        began_s, unpacker = time.monotonic(), Unpacker()
        while not self._ended.is_set():
            message = self._ours.recv(WAKES_S)
            now_s = time.monotonic() - began_s
            if message is not None:
                self._line.send(pack(Frame(message.arbitration_id, bytes(message.data))), now_s)
            for frame in unpacker.feed(self._line.receive(now_s)):
                self._ours.send(
                    can.Message(arbitration_id=frame.can_id, data=frame.data, is_extended_id=False)
                )


@pytest.fixture
def living():
    running = Living()
    yield running
    running.end()


@pytest.fixture
def bench(living):
    node = BaseNode402(1, import_eds(io.StringIO(eds_text()), 1))
    living.network.add_node(node)
    node.sdo.RESPONSE_TIMEOUT = LONG_S
    node.TIMEOUT_SWITCH_STATE_SINGLE = node.TIMEOUT_SWITCH_STATE_FINAL = LONG_S
    node.TIMEOUT_CHECK_TPDO = LONG_S
    return SimpleNamespace(
        node=node, network=living.network, device=living.device, board=living.device.board
    )


def test_they_read_the_objects_and_bring_the_drive_to_where_it_obeys(bench):
    sdo = bench.node.sdo
    assert sdo[0x1000].raw & 0xFFFF == 402
    assert sdo[0x1008].raw == "Simulated CiA 402 servo drive"
    sdo[0x6060].raw = 1
    for word in (0x06, 0x07, 0x0F):
        sdo[0x6040].raw = word
    assert State402.SW_MASK["OPERATION ENABLED"][1] == sdo[0x6041].raw & 0x6F
    sdo[0x607A].raw = TARGET
    before = bench.device.world.motors
    sdo[0x6040].raw = 0x3F
    until(lambda: sdo[0x6041].raw & 0x0400 and sdo[0x6064].raw == TARGET)
    assert bench.device.world.motors[0] - before[0] == TARGET
    sdo[0x6040].raw = 0
    assert not bench.board.nodes[0].motor.holding


def test_they_map_pdos_and_stream_targets_by_sync(bench):
    node = bench.node
    node.nmt.state = "PRE-OPERATIONAL"
    node.pdo.read()
    for pdo, names in ((node.rpdo[1], (0x6040, 0x6060, 0x607A)), (node.tpdo[1], (0x6041, 0x6064))):
        pdo.clear()
        for index in names:
            pdo.add_variable(index)
        pdo.trans_type, pdo.enabled = 1, True
        pdo.save()
    node.sdo[0x60C2][1].raw = 10
    node.sdo[0x6060].raw = 8
    node.nmt.state = "OPERATIONAL"
    for word in (0x06, 0x07, 0x0F):
        node.sdo[0x6040].raw = word
    order, state = node.rpdo[1], node.tpdo[1]
    order[0x6040].raw, order[0x6060].raw = 0x0F, 8
    for target in range(20, 201, 20):
        order[0x607A].raw = target
        order.transmit()
        bench.network.sync.transmit()
        assert state.wait_for_reception(LONG_S) is not None
    bench.network.sync.transmit()
    until(lambda: node.sdo[0x6064].raw == 200)
    assert state[0x6041].raw & 0x6F == 0x27
    assert bench.device.registers[0] == 200


def test_they_hear_heartbeats_and_an_emergency_when_theirs_is_missing(bench):
    node = bench.node
    node.sdo[0x1017].raw = 20
    assert node.nmt.wait_for_heartbeat(LONG_S) == "PRE-OPERATIONAL"
    node.sdo[0x605A].raw = 6
    node.sdo[0x6007].raw = 3
    for word in (0x06, 0x07, 0x0F):
        node.sdo[0x6040].raw = word
    node.sdo[0x1016][1].raw = MASTER << 16 | 50
    bench.network.send_message(0x700 + MASTER, b"\x05")
    error = node.emcy.wait(0x8130, LONG_S)
    assert error is not None
    assert error.register & 0x10
    assert node.sdo[0x6041].raw & 0x6F == 0x07  # quick stop active: it holds
    assert bench.board.nodes[0].motor.holding
    node.nmt.send_command(0x81)
    node.nmt.wait_for_bootup(LONG_S)
    assert not bench.board.nodes[0].motor.holding
