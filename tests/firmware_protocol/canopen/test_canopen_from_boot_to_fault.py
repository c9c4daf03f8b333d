"""A master and a drive on frames alone: booted, set up, enabled, driven, halted, faulted, reset."""

from firmware_protocol.canopen import (
    CONSUMER_HEARTBEAT,
    CONTROLWORD,
    ERROR_CODE,
    EVERY_SYNC,
    MODE,
    MODE_SHOWN,
    ON_EVENT,
    POSITION,
    PRODUCER_HEARTBEAT_MS,
    STANDARD,
    STATUSWORD,
    TARGET_POSITION,
    Access,
    Controlword,
    DataType,
    Dictionary,
    Direction,
    Disabled,
    Downloaded,
    DriveDevice,
    DriveState,
    Emergency,
    Happening,
    Heartbeat,
    HeartbeatWatch,
    Mapping,
    Nmt,
    NmtCommand,
    NmtNode,
    NodeState,
    ObjectEntry,
    ObjectStore,
    OperationMode,
    PdoSetup,
    Place,
    QuickStopOption,
    Reached,
    ReadAsked,
    SdoClient,
    SdoServer,
    SetPointHost,
    Statusword,
    Stood,
    Sync,
    Taken,
    Uploaded,
    WriteAsked,
    way,
)
from firmware_protocol.frames import Frame

NODE, MASTER = 5, 127
ORDER = Mapping.of_objects(STANDARD, CONTROLWORD, TARGET_POSITION)
STATE = Mapping.of_objects(STANDARD, STATUSWORD, POSITION)
SETUPS = (
    PdoSetup(Direction.RECEIVED, 1, NODE, ORDER, EVERY_SYNC),
    PdoSetup(Direction.TRANSMITTED, 1, NODE, STATE, ON_EVENT),
)
PDO_OBJECTS = [
    ObjectEntry(write.place, f"PDO {write.place}", write.type, Access.RW)
    for write in {write.place: write for setup in SETUPS for write in setup.writes}.values()
]


class Drive:
    """A drive whose motor is where it is told to be as soon as it is let (`move`)."""

    def __init__(self) -> None:
        self.nmt, self.sdo = NmtNode(NODE), SdoServer(NODE)
        self.store = ObjectStore(Dictionary([*STANDARD, *PDO_OBJECTS], STANDARD.records), NODE)
        self.machine = DriveDevice(QuickStopOption.QUICK_RAMP_AND_STAY)
        self.order = None

    def hear(self, frame) -> list[Frame]:
        self.nmt.receive_frame(frame)
        if frame.can_id == SETUPS[0].frame_id and self.nmt.takes("pdo"):
            self.order = ORDER.unpack(frame.data)
        if frame == Sync().frame and self.nmt.takes("pdo"):
            return [self.beat()]
        said = [self.sdo.receive_frame(frame)] if self.nmt.takes("sdo") else []
        for asked in iter(self.sdo.next_event, None):
            assert isinstance(asked, ReadAsked | WriteAsked)
            said.append(self.store.answer(self.sdo, asked))
            self.store.set(MODE_SHOWN, self.store.value(MODE))
        return [frame for frame in said if frame is not None]

    def beat(self) -> Frame:
        if self.order is not None:
            word, target = self.order
            self.machine.control(Controlword(word), target)
        state = (self.machine.statusword().value, self.store.value(POSITION))
        return Frame(SETUPS[1].frame_id, STATE.pack(state))

    def move(self) -> None:
        points = self.machine.points
        if points.halted:
            points.stood()
        elif points.active is not None:
            self.store.set(POSITION, points.active.target)
            points.arrived()


class Master:
    """What a driver of such an arm will do, without its clock."""

    def __init__(self, drive) -> None:
        self.drive, self.sdo, self.points = drive, SdoClient(NODE), SetPointHost()
        self.word, self.target, self.position = Controlword(0), 0, 0

    def ask(self, request):
        while request is not None:
            (answer,) = self.drive.hear(request)
            request = self.sdo.receive_frame(answer)
        return self.sdo.next_event()

    def write(self, place, data) -> None:
        assert self.ask(self.sdo.download(place, data)) == Downloaded(place)

    def cycle(self, word=None) -> Statusword:
        self.word = self.word if word is None else word
        data = ORDER.pack((self.word.value, self.target))
        assert self.drive.hear(Frame(SETUPS[0].frame_id, data)) == []
        (frame,) = self.drive.hear(Sync().frame)
        value, self.position = STATE.unpack(frame.data)
        return Statusword(value)

    def go(self, goal, **asked) -> None:
        for row in way(self.cycle().state, goal, **asked):
            assert self.cycle(Controlword.of(row.cause)).state is row.end

    def drive_to(self, target) -> list[object]:
        self.target = target
        self.points.begin()
        return self.follow(4)

    def follow(self, cycles) -> list[object]:
        return [
            event
            for _ in range(cycles)
            for event in self.points.hear(self.cycle(self.points.controlword))
        ]


def test_a_drive_is_brought_from_its_boot_to_a_target_and_out_of_a_fault():
    drive = Drive()
    master = Master(drive)
    assert Heartbeat.read(drive.nmt.booted()) == Heartbeat(NODE, NodeState.BOOTING)
    drive.machine.happen(Happening.INITIALISED)

    # whose silence stops it comes first
    master.write(CONSUMER_HEARTBEAT, DataType.U32.pack(HeartbeatWatch(MASTER, 250).value))
    master.write(PRODUCER_HEARTBEAT_MS, DataType.U16.pack(100))
    for write in (write for setup in SETUPS for write in setup.writes):
        master.write(write.place, write.data)
    assert drive.store.value(Place(0x1400, 1)) == 0x205
    master.write(MODE, DataType.I8.pack(OperationMode.PROFILE_POSITION))
    assert master.ask(master.sdo.upload(MODE_SHOWN)) == Uploaded(MODE_SHOWN, b"\1")

    assert drive.hear(Sync().frame) == []  # pre-operational: no PDO
    assert drive.hear(Nmt(NmtCommand.START, NODE).frame) == []
    master.go(DriveState.ENABLED)
    assert drive.machine.points.active is None  # nothing has moved

    assert master.drive_to(-5000) == [Taken()]
    drive.move()
    assert master.follow(1) == [Reached()]
    assert master.position == -5000

    assert master.drive_to(800) == [Taken()]
    master.points.halt()
    assert master.follow(2) == []
    drive.move()
    assert master.follow(1) == [Stood()]
    assert master.position == -5000
    assert master.drive_to(900) == [Taken()]

    drive.machine.happen(Happening.FAULT)
    drive.store.set(ERROR_CODE, 0x8611)
    emergency = Emergency.read(Emergency(NODE, drive.store.value(ERROR_CODE), 0x21).frame)
    assert emergency.words == "following error"
    assert master.follow(1) == [Disabled(DriveState.FAULT_REACTION)]
    drive.machine.happen(Happening.REACTED)
    assert way(master.cycle().state, DriveState.ENABLED) is None  # only a reset leads out
    drive.machine.mend()
    master.go(DriveState.ENABLED, reset=True)
    assert drive.machine.points.active is None  # and moves nothing
    assert master.drive_to(100) == [Taken()]
    drive.move()
    assert (master.follow(2), master.position) == ([Reached()], 100)


def test_a_board_that_was_reset_hears_no_target_until_it_is_set_up_again():
    drive = Drive()
    master = Master(drive)
    drive.nmt.booted()
    drive.machine.happen(Happening.INITIALISED)
    drive.hear(Nmt(NmtCommand.START).frame)
    master.go(DriveState.ENABLED)
    drive.hear(Nmt(NmtCommand.RESET_NODE, NODE).frame)
    assert drive.nmt.heartbeat.booted
    data = ORDER.pack((0x3F, 100))
    assert drive.hear(Frame(SETUPS[0].frame_id, data)) == drive.hear(Sync().frame) == []
    assert drive.hear(SdoClient(NODE).upload(POSITION)) == []
