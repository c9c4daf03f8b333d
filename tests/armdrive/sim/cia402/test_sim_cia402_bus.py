"""Simulated CiA 402 drives talk as CiA 301 says: NMT, heartbeats, PDOs, SDO, EMCY."""

from configparser import RawConfigParser

import pytest
from bus_sim import IDS
from cia402_sim import (
    CSP,
    ENABLE,
    MASTER,
    ORDER,
    PP,
    TURN,
    Bench,
    setups,
)

from armdrive.errors import BadRequest
from armdrive.sim.cia402.objects import dictionary, eds_text
from firmware_protocol import canopen
from firmware_protocol.frames import Frame

BOOT_S = 0.5
RPDO, TPDO = canopen.Place(0x1400, 1), canopen.Place(0x1800, 1)


@pytest.fixture
def bench():
    return Bench()


def emergencies(frames, node=1):
    return [canopen.Emergency.read(frame).code for frame in frames if frame.can_id == 0x80 + node]


def beats(frames, node=1):
    return [canopen.Heartbeat.read(frame).state for frame in frames if frame.can_id == 0x700 + node]


def moving_in_cycles(bench, cycles=20):
    """Drive along from SYNC to SYNC, with a heartbeat before each."""
    for _ in range(cycles):
        bench.beat()
        bench.order(1, ENABLE, CSP, bench.board.nodes[0].motor.counts + 50)
        bench.sync()


class TestObjects:
    def test_the_eds_is_in_order_and_has_all_that_is_standard(self):
        file = RawConfigParser()
        file.read_string(eds_text())
        lists = ("MandatoryObjects", "OptionalObjects", "ManufacturerObjects")
        listed = [
            int(file[name][str(number)], 0)
            for name in lists
            for number in range(1, int(file[name]["SupportedObjects"]) + 1)
        ]
        assert sorted(listed) == sorted(dictionary().indices)
        for index in listed:
            objects = [each for each in dictionary() if each.place.index == index]
            assert int(file[f"{index:04X}"].get("SubNumber", "1")) == len(objects)
        for entry in canopen.STANDARD:
            found = dictionary().find(entry.place)
            assert (found.type, found.access) == (entry.type, entry.access)

    def test_a_drive_says_what_it_is(self, bench):
        assert bench.read(3, canopen.DEVICE_TYPE) & 0xFFFF == 402
        assert bench.read(3, canopen.DEVICE_NAME) == "Simulated CiA 402 servo drive"  # in segments
        assert bench.read(3, canopen.SERIAL_NUMBER) == 3
        assert bench.read(3, canopen.SUPPORTED_MODES) == 0b1010_0001
        assert bench.read(3, canopen.Place(0x2345)) == canopen.AbortCode.NO_OBJECT
        assert bench.write(3, canopen.POSITION, 5) == canopen.AbortCode.READ_ONLY
        assert bench.read(9, canopen.DEVICE_TYPE) is None

    @pytest.mark.parametrize(
        ("settings", "place", "told"),
        [
            ({"profile": 401}, canopen.DEVICE_TYPE, 0x0004_0191),
            ({"missing": "60C2"}, canopen.Place(0x60C2, 1), canopen.AbortCode.NO_OBJECT),
            ({"missing": "6061+6007"}, canopen.HEARTBEAT_REACTION, canopen.AbortCode.NO_OBJECT),
            ({"homing": False}, canopen.SUPPORTED_MODES, 0b1000_0001),
            ({"following_window": 77}, canopen.Place(0x6065), 77),
        ],
    )
    def test_a_drive_may_be_another_or_lack_something(self, settings, place, told):
        bench = Bench(**settings)
        assert bench.read(1, place) == told
        assert (
            canopen.Statusword(bench.read(1, canopen.STATUSWORD)).state
            is canopen.DriveState.DISABLED
        )

    @pytest.mark.parametrize(
        ("place", "value"),
        [
            (canopen.MODE, 3),
            (canopen.QUICK_STOP_OPTION, 9),
            (canopen.HEARTBEAT_REACTION, 4),
            (canopen.CONSUMER_HEARTBEAT, 0xC8_0064),
            (canopen.Place(0x6085), 0),
            (canopen.Place(0x1800, 2), 250),
        ],
    )
    def test_nonsense_is_refused(self, bench, place, value):
        before = bench.read(1, place)
        assert bench.write(1, place, value) == canopen.AbortCode.VALUE
        assert bench.read(1, place) == before


class TestNmt:
    def test_a_drive_says_that_it_has_booted_some_time_after_its_power_came(self, bench):
        bench.enable(*IDS, mode=PP)
        bench.device.power_off()
        assert bench.run(1.0) == []
        bench.device.power_on()
        assert bench.run(BOOT_S - 0.01) == []
        assert bench.read(1, canopen.STATUSWORD) is None
        assert beats(bench.run(0.1)) == [canopen.NodeState.BOOTING]
        assert bench.state(1).state is canopen.DriveState.DISABLED

    @pytest.mark.parametrize("fault", ["drive-reset", "drive-dead"])
    def test_a_restarted_drive_releases_its_motor(self, bench, fault):
        bench.enable(*IDS, mode=PP)
        before = bench.world.motors
        bench.twin.faults.add(fault, "2")
        bench.run(0.1)
        bench.twin.faults.end()
        heard = bench.run(1.0)
        assert beats(heard, 2) == [canopen.NodeState.BOOTING]
        assert beats(heard, 1) == []
        assert bench.world.motors[1] != before[1]
        assert bench.count(2) == 0
        assert [node.motor.holding for node in bench.board.nodes].count(True) == 5

    def test_a_position_may_outlast_the_power(self):
        bench = Bench(keeps_position=True)
        bench.enable(*IDS, mode=PP)
        bench.device.board.count_from([500] * 6)
        bench.device.power_off()
        bench.device.power_on()
        bench.run(1.0)
        sagged = bench.world.motors
        assert bench.count(1) == 500
        assert sagged[1] - bench.count(2) == bench.board.nodes[1].motor.zero

    def test_a_master_resets_a_node(self, bench):
        bench.set_up(1)
        bench.enable(1)
        heard = bench.tell(canopen.Nmt(canopen.NmtCommand.RESET_NODE, 1).frame, 1.0)
        assert beats(heard) == [canopen.NodeState.BOOTING]
        assert bench.state(1).state is canopen.DriveState.DISABLED
        assert bench.sync() == {}  # pre-operational
        assert bench.read(1, canopen.Place(0x60C2, 1)) == 1

    def test_a_reset_of_the_communication_leaves_the_motor_alone(self, bench):
        bench.write(1, canopen.HEARTBEAT_REACTION, 0)
        bench.set_up(1)
        bench.enable(1)
        heard = bench.tell(canopen.Nmt(canopen.NmtCommand.RESET_COMMUNICATION, 1).frame, 0.1)
        assert beats(heard) == [canopen.NodeState.BOOTING]
        assert bench.state(1).state is canopen.DriveState.ENABLED
        assert bench.read(1, canopen.Place(0x60C2, 1)) == 10
        assert bench.read(1, canopen.Place(0x1800, 2)) == 255

    def test_a_stopped_node_is_deaf_and_reacts(self, bench):
        bench.write(1, canopen.HEARTBEAT_REACTION, 3)
        bench.write(1, canopen.QUICK_STOP_OPTION, canopen.QuickStopOption.QUICK_RAMP_AND_STAY)
        bench.enable(1, mode=PP)
        bench.send(canopen.Nmt(canopen.NmtCommand.STOP, 1).frame)
        assert bench.read(1, canopen.STATUSWORD) is None
        bench.send(canopen.Nmt(canopen.NmtCommand.PRE_OPERATIONAL, 1).frame)
        assert bench.state(1).state is canopen.DriveState.QUICK_STOP

    def test_heartbeats_tell_the_state(self, bench):
        bench.write(1, canopen.PRODUCER_HEARTBEAT_MS, 100)
        assert beats(bench.run(1.0)) == [canopen.NodeState.PRE_OPERATIONAL] * 10
        bench.send(canopen.Nmt(canopen.NmtCommand.START, 1).frame)
        assert set(beats(bench.run(0.5))) == {canopen.NodeState.OPERATIONAL}
        bench.write(1, canopen.PRODUCER_HEARTBEAT_MS, 0)
        assert beats(bench.run(0.5)) == []

    def test_drives_of_one_period_beat_together_however_they_were_set_up(self, bench):
        for node in IDS:
            bench.write(node, canopen.PRODUCER_HEARTBEAT_MS, 100)
            bench.run(0.013)
        began_s = bench.now_s
        bench.run(1.0)
        beats_s = [time_s for time_s, each in bench.heard if time_s > began_s]
        assert len(beats_s) == 10 * len(IDS)
        for first in range(0, len(beats_s), len(IDS)):
            together = beats_s[first : first + len(IDS)]
            assert together[-1] - together[0] < 0.001


class TestSilence:
    """Of the master, whose heartbeat a drive minds."""

    def ready(self, reaction, **settings):
        bench = Bench(**settings)
        bench.set_up(1)
        bench.write(1, canopen.QUICK_STOP_OPTION, canopen.QuickStopOption.QUICK_RAMP_AND_STAY)
        bench.write(1, canopen.HEARTBEAT_REACTION, reaction)
        bench.watch(1, 200)
        bench.enable(1)
        return bench

    @pytest.mark.parametrize(
        ("reaction", "ends"),
        [
            (0, canopen.DriveState.ENABLED),
            (1, canopen.DriveState.FAULT),
            (2, canopen.DriveState.DISABLED),
            (3, canopen.DriveState.QUICK_STOP),
        ],
    )
    def test_a_drive_reacts_as_it_was_told(self, reaction, ends):
        bench = self.ready(reaction)
        moving_in_cycles(bench)
        heard = bench.run(0.5)
        assert emergencies(heard) == [0x8130]
        assert bench.state(1).state is ends
        assert bench.read(1, canopen.ERROR_CODE) == 0x8130
        assert bench.board.nodes[0].states.watch_stops == 1

    @pytest.mark.parametrize("quirk", ["hold", "extrapolate"])
    def test_even_one_that_runs_on_ends_after_so_much_silence(self, quirk):
        bench = self.ready(3, hold_after_loss=quirk)
        moving_in_cycles(bench)
        bench.run(0.15)
        begun = bench.count(1)
        bench.run(0.1)
        there = bench.count(1)
        assert (there > begun) is (quirk == "extrapolate")
        bench.run(1.0)
        assert bench.count(1) == there

    def test_no_silence_is_minded_before_the_first_heartbeat_or_without_a_watch(self):
        bench = self.ready(3)
        bench.run(2.0)
        assert bench.state(1).state is canopen.DriveState.ENABLED
        bench.beat()
        bench.write(1, canopen.CONSUMER_HEARTBEAT, 0)
        assert emergencies(bench.run(2.0)) == []

    def test_it_is_over_when_the_master_is_heard_again(self):
        bench = self.ready(3)
        bench.beat()
        bench.run(0.5)
        assert bench.state(1).has(canopen.StatusBit.WARNING)
        bench.beat()
        assert emergencies(bench.run()) == [0]
        assert bench.read(1, canopen.ERROR_REGISTER) == 0
        bench.write(1, canopen.CONTROLWORD, ENABLE)
        assert bench.state(1).state is canopen.DriveState.ENABLED

    @pytest.mark.parametrize("plugged", [True, False])
    def test_another_node_is_not_the_master_and_without_its_cable_a_drive_misses_it(self, plugged):
        bench = self.ready(3)
        bench.beat()
        bench.run(0.1)
        bench.board.node(0).port.plugged = plugged
        sender = MASTER - plugged
        for _ in range(10):
            bench.tell(canopen.Heartbeat(sender, canopen.NodeState.OPERATIONAL).frame, 0.05)
        assert bench.board.nodes[0].states.state is canopen.DriveState.QUICK_STOP


class TestPdos:
    def test_as_shipped_they_go_by_themselves(self, bench):
        heard = bench.tell(canopen.Nmt(canopen.NmtCommand.START, 1).frame)
        assert {frame.can_id for frame in heard} == {0x181, 0x281, 0x381}
        assert bench.run(0.5) == []
        heard = bench.tell(Frame(0x201, b"\x06\x00"))
        assert [frame.can_id for frame in heard] == [0x181, 0x281, 0x381]
        assert bench.state(1).state is canopen.DriveState.READY

    def test_none_goes_before_the_node_is_started(self, bench):
        for setup in setups(1):
            for write in setup.writes:
                bench.write(1, write.place, write.value)
        assert bench.sync() == {}
        bench.order(1, 6, CSP, 0)
        bench.sync()
        assert bench.state(1).state is canopen.DriveState.DISABLED

    def test_all_drives_begin_at_one_sync(self, bench):
        bench.set_up(*IDS)
        bench.enable(*IDS)
        for node in IDS:
            bench.order(node, ENABLE, CSP, 100)
        bench.send(canopen.Sync().frame)
        bench.run(0.015)
        assert len({node.motor.point.end_s for node in bench.board.nodes}) == 1
        assert bench.device.registers == (100,) * 6

    def test_one_that_is_too_short_is_told_and_left_out(self, bench):
        bench.set_up(1)
        heard = bench.tell(Frame(0x201, ORDER.pack((6, PP, 0))[:5]))
        assert emergencies(heard) == [0x8210]
        bench.sync()
        assert bench.state(1).state is canopen.DriveState.DISABLED

    def test_they_are_changed_only_while_they_are_off_and_the_node_is_not_started(self, bench):
        count = canopen.Place(0x1600, 0)
        assert bench.write(1, count, 0) == canopen.AbortCode.DEVICE_STATE
        bench.write(1, RPDO, 1 << 31 | 0x201)
        assert bench.write(1, count, 0) is None
        assert bench.write(1, canopen.Place(0x1600, 1), 0x60600008) is None
        bench.send(canopen.Nmt(canopen.NmtCommand.START, 1).frame)
        assert bench.write(1, count, 1) == canopen.AbortCode.DEVICE_STATE

    def test_a_drive_that_lacks_what_it_would_map_maps_it_not(self):
        bench = Bench(missing="6061")
        heard = bench.tell(canopen.Nmt(canopen.NmtCommand.START, 1).frame)
        assert {frame.can_id for frame in heard} == {0x181, 0x381}


class TestFaults:
    def test_a_drive_with_another_id_begins_to_talk_anew(self, bench):
        bench.write(2, canopen.HEARTBEAT_REACTION, 0)
        bench.set_up(1, 2)
        bench.enable(1, 2)
        bench.twin.faults.add("drive-id", "2", "9")
        heard = bench.run(0.1)
        assert beats(heard, 9) == [canopen.NodeState.BOOTING]
        assert bench.read(2, canopen.STATUSWORD) is None
        assert bench.state(9).state is canopen.DriveState.ENABLED
        bench.twin.faults.end()
        assert beats(bench.run(0.1), 2) == [canopen.NodeState.BOOTING]
        with pytest.raises(BadRequest, match="1 to 127"):
            bench.board.node(0).set_id(128, bench.board.now_s)

    def test_somebody_changes_a_mode_until_the_next_order(self, bench):
        bench.set_up(1)
        bench.enable(1)
        moving_in_cycles(bench, 3)
        bench.twin.faults.add("drive-mode", "1", "2")
        there = bench.count(1)
        bench.run(0.1)
        assert bench.sync()[1][1] == 2
        assert bench.count(1) == pytest.approx(there, abs=60)
        moving_in_cycles(bench, 2)
        assert bench.sync()[1][1] == CSP
        with pytest.raises(BadRequest, match="modes are"):
            bench.board.node(0).set_mode(5, bench.board.now_s)

    def test_a_drive_fails_for_as_long_as_it_is_told(self, bench):
        bench.enable(1, 2, mode=PP)
        bench.twin.faults.add("drive-fault", "1", "4310")
        assert emergencies(bench.run()) == [0x4310]
        assert bench.read(1, canopen.ERROR_REGISTER) == 0x09
        assert bench.state(1).state is canopen.DriveState.FAULT
        assert [node.motor.holding for node in bench.board.nodes[:2]] == [False, True]
        bench.twin.faults.end()
        bench.write(1, canopen.CONTROLWORD, 0x80)
        assert bench.state(1).state is canopen.DriveState.DISABLED

    def test_one_that_is_still_ill_fails_again_when_its_power_comes(self, bench):
        bench.twin.faults.add("drive-fault", "1", "4310")
        bench.device.power_off()
        bench.device.power_on()
        heard = bench.run(1.0)
        assert beats(heard) == [canopen.NodeState.BOOTING]
        assert emergencies(heard) == [0x4310]
        assert bench.state(1).state is canopen.DriveState.FAULT
        assert bench.state(2).state is canopen.DriveState.DISABLED

    def test_changes_to_a_drive_without_power_show_when_it_is_powered(self, bench):
        bench.board.switch_drive(0, False)
        bench.board.node(0).set_id(9, bench.board.now_s)
        bench.board.node(0).set_mode(2, bench.board.now_s)
        assert bench.run(1.0) == []
        bench.board.switch_drive(0, True)
        assert beats(bench.run(1.0), 9) == [canopen.NodeState.BOOTING]
        assert bench.state(9).state is canopen.DriveState.DISABLED
        assert bench.read(9, canopen.MODE_SHOWN) == 0

    def test_a_drive_that_says_an_emcy_goes_on(self, bench):
        bench.enable(1, mode=PP)
        bench.twin.faults.add("drive-emcy", "1", "7305")
        assert emergencies(bench.run()) == [0x7305]
        assert bench.state(1).state is canopen.DriveState.ENABLED
        with pytest.raises(BadRequest, match="four hex digits"):
            bench.twin.faults.add("drive-emcy", "1", "0000")

    def test_a_stopped_host_leaves_nothing_waiting(self, bench):
        bench.set_up(*IDS)
        bench.enable(*IDS)
        bench.run(1.0)
        assert not bench.device.busy
        assert bench.link.next_s() == float("inf")
        assert bench.read(1, canopen.TARGET_POSITION) == 0
        assert bench.read(1, canopen.Place(0x608F, 1)) == TURN
