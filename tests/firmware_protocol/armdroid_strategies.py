"""What the Armdroid tests draw from: every command and answer, and every way to cut a stream."""

from hypothesis import strategies as st

from firmware_protocol.armdroid import (
    ANSWER_TO,
    RPM_MAX,
    ArgumentsReported,
    Clear,
    Device,
    DriveAll,
    DriveOne,
    DropArguments,
    HomeToOffsets,
    Host,
    InterfaceKind,
    InterfaceReported,
    OffsetsReported,
    ReportArguments,
    ReportOffsets,
    SetSpeed,
    SpeedReported,
    Torque,
    TorqueReported,
    Version,
    VersionReported,
    ZeroOffsets,
)

INT16 = st.integers(-32768, 32767)
SIX = st.tuples(*[INT16] * 6)
WORDS = st.text("0123456789abcxyz.-_=", min_size=1, max_size=16)
# commands that the device reads back as the very same message
PLAIN = st.one_of(
    st.builds(DriveOne, st.integers(1, 6), INT16),
    st.builds(DriveAll, SIX),
    st.builds(SetSpeed, st.integers(1, RPM_MAX)),
    st.builds(Torque, st.booleans()),
    st.sampled_from(
        [
            HomeToOffsets(),
            ReportOffsets(),
            ZeroOffsets(),
            Version(),
            InterfaceKind(),
            ReportArguments(),
        ]
    ),
)
COMMANDS = PLAIN | st.sampled_from([Clear(), DropArguments()])
ANSWERS_OF = {
    OffsetsReported: st.builds(OffsetsReported, SIX),
    SpeedReported: st.builds(SpeedReported, INT16),
    TorqueReported: st.builds(TorqueReported, st.booleans()),
    VersionReported: st.builds(VersionReported, WORDS, st.none() | WORDS),
    InterfaceReported: st.builds(InterfaceReported, WORDS),
    ArgumentsReported: st.builds(ArgumentsReported, st.tuples(*[INT16] * 5), INT16),
}
ANSWERS = st.one_of(*ANSWERS_OF.values())


def answer_to(command):
    """Return a strategy for what may answer a command."""
    return ANSWERS_OF[ANSWER_TO[command.letter]]


def some_answer(device: Device):
    """Return an answer of the form that the device owes."""
    return {
        OffsetsReported: OffsetsReported((1, -2, 3, -4, 5, -6)),
        SpeedReported: SpeedReported(100),
        TorqueReported: TorqueReported(on=True),
        VersionReported: VersionReported(),
        InterfaceReported: InterfaceReported(),
        ArgumentsReported: ArgumentsReported(device.arguments, device.accumulator),
    }[ANSWER_TO[device.unanswered.letter]]


def events(machine: Host | Device) -> list[object]:
    """Fetch all events; a device's owner answers each command at once."""
    found = []
    while (event := machine.next_event()) is not None:
        found.append(event)
        if isinstance(machine, Device) and machine.unanswered is not None:
            machine.send(some_answer(machine))
    return found
