"""What the Armdroid tests draw from: every command and answer, and every way to cut a stream."""

from fuzzing import FuzzCase
from hypothesis import strategies as st

from firmware_protocol import armdroid
from firmware_protocol.armdroid.messages import encode_answer, encode_command

INT16 = st.integers(-32768, 32767)
SIX = st.tuples(*[INT16] * 6)
WORDS = st.text("0123456789abcxyz.-_=", min_size=1, max_size=16)
# commands that the device reads back as the very same message
PLAIN = st.one_of(
    st.builds(armdroid.DriveOne, st.integers(1, 6), INT16),
    st.builds(armdroid.DriveAll, SIX),
    st.builds(armdroid.SetSpeed, st.integers(1, armdroid.RPM_MAX)),
    st.builds(armdroid.Torque, st.booleans()),
    st.sampled_from(
        [
            armdroid.HomeToOffsets(),
            armdroid.ReportOffsets(),
            armdroid.ZeroOffsets(),
            armdroid.Version(),
            armdroid.ReportArguments(),
        ]
    ),
)
COMMANDS = PLAIN | st.sampled_from([armdroid.Clear(), armdroid.DropArguments()])
ANSWERS_OF = {
    armdroid.OffsetsReported: st.builds(armdroid.OffsetsReported, SIX),
    armdroid.SpeedReported: st.builds(armdroid.SpeedReported, INT16),
    armdroid.TorqueReported: st.builds(armdroid.TorqueReported, st.booleans()),
    armdroid.VersionReported: st.builds(armdroid.VersionReported, WORDS, st.none() | WORDS),
    armdroid.ArgumentsReported: st.builds(
        armdroid.ArgumentsReported, st.tuples(*[INT16] * 5), INT16
    ),
}
ANSWERS = st.one_of(*ANSWERS_OF.values())


def answer_to(command):
    """Return a strategy for what may answer a command."""
    return ANSWERS_OF[armdroid.ANSWER_TO[command.letter]]


def some_answer(device: armdroid.Device):
    """Return an answer of the form that the device owes."""
    return {
        armdroid.OffsetsReported: armdroid.OffsetsReported((1, -2, 3, -4, 5, -6)),
        armdroid.SpeedReported: armdroid.SpeedReported(100),
        armdroid.TorqueReported: armdroid.TorqueReported(on=True),
        armdroid.VersionReported: armdroid.VersionReported(),
        armdroid.ArgumentsReported: armdroid.ArgumentsReported(
            device.arguments, device.accumulator
        ),
    }[armdroid.ANSWER_TO[device.unanswered.letter]]


def events(machine: armdroid.Host | armdroid.Device) -> list[object]:
    """Fetch all events; a device's owner answers each command at once."""
    found = []
    while (event := machine.next_event()) is not None:
        found.append(event)
        if isinstance(machine, armdroid.Device) and machine.unanswered is not None:
            machine.send(some_answer(machine))
    return found


# -- The ends of the codec for the long fuzz run ---------------------------------------------------


def _host_saw_one(host: armdroid.Host) -> bool:
    found = any(
        isinstance(event, armdroid.Completed | armdroid.Stray | armdroid.Welcome)
        for event in events(host)
    )
    if host.outstanding is None:
        host.send(armdroid.ReportOffsets())
    return found


def _device_saw_one(device: armdroid.Device) -> bool:
    return bool(events(device))


LINES = (ANSWERS | st.just(armdroid.Welcome())).map(encode_answer)
HOST = FuzzCase("armdroid host", armdroid.Host, LINES, _host_saw_one, most_good=2)
DEVICE = FuzzCase(
    "armdroid device",
    armdroid.Device,
    PLAIN.map(encode_command),
    _device_saw_one,
    most_good=2,
)
