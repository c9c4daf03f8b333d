"""A master and a drive on frames alone: booted, set up, enabled, driven, halted, faulted, reset."""

from firmware_protocol import canopen
from firmware_protocol.frames import Frame

NODE, MASTER = 5, 127
ORDER = canopen.Mapping.of_objects(canopen.STANDARD, canopen.CONTROLWORD, canopen.TARGET_POSITION)
STATE = canopen.Mapping.of_objects(canopen.STANDARD, canopen.STATUSWORD, canopen.POSITION)
SETUPS = (
    canopen.PdoSetup(canopen.Direction.RECEIVED, 1, NODE, ORDER, canopen.EVERY_SYNC),
    canopen.PdoSetup(canopen.Direction.TRANSMITTED, 1, NODE, STATE, 255),
)
PDO_OBJECTS = [
    canopen.ObjectEntry(write.place, f"PDO {write.place}", write.type, canopen.Access.RW)
    for write in {write.place: write for setup in SETUPS for write in setup.writes}.values()
]


class Drive:
    """A drive whose motor is where it is told to be as soon as it is let (`move`)."""

    def __init__(self) -> None:
        self.nmt, self.sdo = canopen.NmtNode(NODE), canopen.SdoServer(NODE)
        self.store = canopen.ObjectStore(
            canopen.Dictionary([*canopen.STANDARD, *PDO_OBJECTS], canopen.STANDARD.records), NODE
        )
        self.machine = canopen.DriveDevice(canopen.QuickStopOption.QUICK_RAMP_AND_STAY)
        self.order = None

    def receive(self, frame) -> list[Frame]:
        self.nmt.receive_frame(frame)
        if frame.can_id == SETUPS[0].frame_id and self.nmt.takes("pdo"):
            self.order = ORDER.unpack(frame.data)
        if frame == canopen.Sync().frame and self.nmt.takes("pdo"):
            return [self.beat()]
        said = [self.sdo.receive_frame(frame)] if self.nmt.takes("sdo") else []
        for asked in iter(self.sdo.next_event, None):
            assert isinstance(asked, canopen.ReadAsked | canopen.WriteAsked)
            said.append(self.store.answer(self.sdo, asked))
            self.store.set(canopen.MODE_SHOWN, self.store.value(canopen.MODE))
        return [frame for frame in said if frame is not None]

    def beat(self) -> Frame:
        if self.order is not None:
            word, target = self.order
            self.machine.control(canopen.Controlword(word), target)
        state = (self.machine.statusword().value, self.store.value(canopen.POSITION))
        return Frame(SETUPS[1].frame_id, STATE.pack(state))

    def move(self) -> None:
        points = self.machine.points
        if points.halted:
            points.stood()
        elif points.active is not None:
            self.store.set(canopen.POSITION, points.active.target)
            points.arrived()


class Master:
    """What a driver of such an arm will do, without its clock."""

    def __init__(self, drive) -> None:
        self.drive, self.sdo, self.point = drive, canopen.SdoClient(NODE), canopen.SetPointHost()
        self.word, self.target, self.position = canopen.Controlword(0), 0, 0

    def ask(self, request):
        while request is not None:
            (answer,) = self.drive.receive(request)
            request = self.sdo.receive_frame(answer)
        return self.sdo.next_event()

    def write(self, place, data) -> None:
        assert self.ask(self.sdo.download(place, data)) == canopen.Downloaded(place)

    def cycle(self, word=None) -> canopen.Statusword:
        self.word = self.word if word is None else word
        data = ORDER.pack((self.word.value, self.target))
        assert self.drive.receive(Frame(SETUPS[0].frame_id, data)) == []
        (frame,) = self.drive.receive(canopen.Sync().frame)
        value, self.position = STATE.unpack(frame.data)
        return canopen.Statusword(value)

    def go(self, goal, **asked) -> None:
        for row in canopen.way(self.cycle().state, goal, **asked):
            assert self.cycle(canopen.Controlword.of(row.cause)).state is row.end

    def drive_to(self, target) -> canopen.Phase:
        self.target, self.point = target, canopen.SetPointHost()
        return self.follow(4)

    def follow(self, cycles) -> canopen.Phase:
        for _ in range(cycles):
            self.point.receive(self.cycle(self.point.controlword))
        return self.point.phase


def test_a_drive_is_brought_from_its_boot_to_a_target_and_out_of_a_fault():
    drive = Drive()
    master = Master(drive)
    assert canopen.Heartbeat.read(drive.nmt.booted()) == canopen.Heartbeat(
        NODE, canopen.NodeState.BOOTING
    )
    drive.machine.happen(canopen.Happening.INITIALISED)

    # whose silence stops it comes first
    master.write(
        canopen.CONSUMER_HEARTBEAT,
        canopen.DataType.U32.pack(canopen.HeartbeatWatch(MASTER, 250).value),
    )
    master.write(canopen.PRODUCER_HEARTBEAT_MS, canopen.DataType.U16.pack(100))
    for write in (write for setup in SETUPS for write in setup.writes):
        master.write(write.place, write.data)
    assert drive.store.value(canopen.Place(0x1400, 1)) == 0x205
    master.write(canopen.MODE, canopen.DataType.I8.pack(canopen.OperationMode.PROFILE_POSITION))
    assert master.ask(master.sdo.upload(canopen.MODE_SHOWN)) == canopen.Uploaded(
        canopen.MODE_SHOWN, b"\1"
    )

    assert drive.receive(canopen.Sync().frame) == []  # pre-operational: no PDO
    assert drive.receive(canopen.Nmt(canopen.NmtCommand.START, NODE).frame) == []
    master.go(canopen.DriveState.ENABLED)
    assert drive.machine.points.active is None  # nothing has moved

    assert master.drive_to(-5000) is canopen.Phase.UNDER_WAY
    drive.move()
    assert (master.follow(1), master.position) == (canopen.Phase.FREE, -5000)
    assert master.drive_to(900) is canopen.Phase.UNDER_WAY

    drive.machine.happen(canopen.Happening.FAULT)
    drive.store.set(canopen.ERROR_CODE, 0x8611)
    emergency = canopen.Emergency.read(
        canopen.Emergency(NODE, drive.store.value(canopen.ERROR_CODE), 0x21).frame
    )
    assert emergency.words == "following error"
    assert master.follow(1) is canopen.Phase.FREE
    assert master.cycle().state is canopen.DriveState.FAULT_REACTION
    drive.machine.happen(canopen.Happening.REACTED)
    assert (
        canopen.way(master.cycle().state, canopen.DriveState.ENABLED) is None
    )  # only a reset leads out
    drive.machine.mend()
    master.go(canopen.DriveState.ENABLED, reset=True)
    assert drive.machine.points.active is None  # and moves nothing
    assert master.drive_to(100) is canopen.Phase.UNDER_WAY
    drive.move()
    assert (master.follow(2), master.position) == (canopen.Phase.FREE, 100)


def test_a_board_that_was_reset_hears_no_target_until_it_is_set_up_again():
    drive = Drive()
    master = Master(drive)
    drive.nmt.booted()
    drive.machine.happen(canopen.Happening.INITIALISED)
    drive.receive(canopen.Nmt(canopen.NmtCommand.START).frame)
    master.go(canopen.DriveState.ENABLED)
    drive.receive(canopen.Nmt(canopen.NmtCommand.RESET_NODE, NODE).frame)
    assert drive.nmt.heartbeat.booted
    data = ORDER.pack((0x3F, 100))
    assert (
        drive.receive(Frame(SETUPS[0].frame_id, data)) == drive.receive(canopen.Sync().frame) == []
    )
    assert drive.receive(canopen.SdoClient(NODE).upload(canopen.POSITION)) == []
