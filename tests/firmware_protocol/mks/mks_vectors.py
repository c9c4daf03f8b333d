"""MKS frames byte by byte, ids first, as the manuals print them.

Examples of the manuals 1.0.6 and 1.0.9 (makerbase-motor/MKS-SERVO42D-57D), and by hand what they
have no example of. An F4 of nine bytes behind its id, which is printed too, is a misprint: no
frame of CAN has room for it.
"""

from firmware_protocol import mks
from firmware_protocol.frames import Frame

MANUAL_REQUESTS = [
    (mks.ReadEncoder(), "01 31 32"),
    (mks.EmergencyStop(), "01 F7 F8"),
    (mks.SetMode(mks.Mode.BUS_FOC), "01 82 05 88"),
    (mks.SetMode(mks.Mode.BUS_FOC), "00 82 05 87"),
    (mks.Home(), "01 91 92"),
    (mks.SetZero(), "01 92 93"),
    (mks.MoveAbsoluteAxis(0x4000, 600, 2), "01 F5 02 58 02 00 40 00 92"),
    (mks.MoveAbsoluteAxis(-0x4000, 600, 2), "01 F5 02 58 02 FF C0 00 11"),
    (mks.MoveRelativeAxis(0x4000, 600, 2), "01 F4 02 58 02 00 40 00 91"),
    (mks.MoveRelativeAxis(-0x4000, 600, 2), "01 F4 02 58 02 FF C0 00 10"),
    (mks.MoveRelativePulses(0xFA00, 320, 2), "01 FD 01 40 02 00 FA 00 3B"),
    (mks.MoveRelativePulses(-320_000, 100, 2), "02 FD 80 64 02 04 E2 00 CB"),
    (mks.MoveRelativePulses(3200, 300, 100), "50 FD 01 2C 64 00 0C 80 6A"),
    (mks.MoveAbsolutePulses(0x0C80, 600, 2), "01 FE 02 58 02 00 0C 80 E7"),
    (mks.RunAtSpeed(320, 2), "01 F6 01 40 02 3A"),
    (mks.RunAtSpeed(-320, 2), "01 F6 81 40 02 BA"),
    (mks.RunAtSpeed(640, 2), "01 F6 02 80 02 7B"),
    (mks.Stop(mks.Code.ABSOLUTE_AXIS, 4), "01 F5 00 00 04 00 00 00 FA"),
    (mks.ArmSynchronous(True), "00 4A 01 4B"),
    (mks.GoSynchronous(), "00 4B 4B"),
    (mks.ReportByItself(mks.Code.ENCODER, 1000), "01 01 31 03 E8 1E"),
    (mks.ReadSetting(mks.Code.CURRENT), "01 00 83 84"),
    (mks.Calibrate(), "01 80 00 81"),
]
# of these the check byte is the sum, done by hand
OTHER_REQUESTS = [
    (mks.ReadSpeed(), "01 32 33"),
    (mks.ReadPulses(), "01 33 34"),
    (mks.ReadInputs(), "01 34 35"),
    (mks.ReadRawEncoder(), "01 35 36"),
    (mks.ReadAngleError(), "01 39 3A"),
    (mks.ReadEnabled(), "01 3A 3B"),
    (mks.ReadHoming(), "01 3B 3C"),
    (mks.ClearStall(), "01 3D 3E"),
    (mks.ReadStall(), "01 3E 3F"),
    (mks.ReadVersion(), "01 40 41"),
    (mks.Restart(), "01 41 42"),
    (mks.ReadState(), "06 F1 F7"),
    (mks.Enable(True), "06 F3 01 FA"),
    (mks.Enable(False), "06 F3 00 F9"),
    (mks.GoToZero(), "01 91 01 93"),
    (mks.RunFor(-320, 2, 2560), "01 F6 81 40 02 00 01 00 BB"),
    (mks.Stop(mks.Code.SPEED_MODE, 2), "01 F6 00 00 02 F9"),
    (mks.Stop(mks.Code.RELATIVE_PULSES, 0), "01 FD 00 00 00 00 00 00 FE"),
    (mks.SetCurrent(3200), "01 83 0C 80 10"),
    (mks.SetCurrent(3200, keep=False), "01 83 0C 80 00 10"),
    (mks.SetHoldingCurrent(50), "01 9B 04 A0"),
    (mks.SetMicrosteps(16), "01 84 10 95"),
    (mks.SetMicrosteps(256), "01 84 00 85"),
    (mks.SetDirection(True), "01 86 01 88"),
    (mks.SetStallProtection(True), "01 88 01 8A"),
    (mks.SetPositionProtection(True, 20, 14000), "01 9D 01 00 14 36 B0 99"),
    (mks.SetHoming(False, True, 60, True, 1), "01 90 00 01 00 3C 01 01 D0"),
    (mks.SetArrival(True), "01 95 01 00 C8 5F"),
    (mks.SilenceWatchdog(500), "01 98 00 00 01 F4 8E"),
    (mks.SetBitrate(mks.Bitrate.K1000), "01 8A 03 8E"),
    (mks.SetId(0x123), "01 8B 01 23 B0"),
    (mks.SetGroup(0x50), "01 8D 00 50 DE"),
    (mks.SetReplies(mks.ReplyMode.IMMEDIATE), "01 8C 01 00 8E"),
    (mks.SetReplies(mks.ReplyMode.NONE), "01 8C 00 00 8D"),
]
ANSWER_BYTES = [
    (mks.EncoderRead(4), "01 31 00 00 00 00 00 04 36"),  # the manual's
    (mks.EncoderRead(0x3FF0 - 0x4000), "01 31 FF FF FF FF FF F0 1D"),  # its value a turn clockwise
    (mks.RawEncoderRead(0x7FF0), "01 35 00 00 00 00 7F F0 A5"),
    (mks.SpeedRead(-320), "01 32 FE C0 F1"),
    (mks.PulsesRead(-2), "01 33 FF FF FF FE 2F"),
    (mks.AngleErrorRead(142), "01 39 00 00 00 8E C8"),
    (mks.InputsRead(3), "01 34 03 38"),
    (mks.EnabledRead(True), "01 3A 01 3C"),
    (mks.HomingRead(mks.HomingState.DONE), "01 3B 01 3D"),
    (mks.HomingRead(mks.HomingState.DONE, mks.HomingState.FAILED), "01 3B 01 02 3F"),
    (mks.StallRead(False), "01 3E 00 3F"),
    (mks.StateRead(mks.MotorState.FULL_SPEED), "01 F1 04 F6"),
    (mks.VersionRead(True, 2, bytes((1, 0, 9))), "01 40 12 01 00 09 5D"),
    (mks.VersionRead(False, 4, b"\x01\x09"), "01 40 04 01 09 4F"),
    (mks.Status(mks.Code.ABSOLUTE_AXIS, mks.Outcome.STARTED), "01 F5 01 F7"),
    (mks.Status(mks.Code.ABSOLUTE_AXIS, mks.Outcome.DONE), "01 F5 02 F8"),
    (mks.Status(mks.Code.RELATIVE_PULSES, mks.Outcome.LIMIT_STOP), "01 FD 03 01"),
    (mks.Status(mks.Code.SPEED_MODE, mks.Outcome.STORED), "01 F6 05 FC"),
    (mks.Status(mks.Code.RELATIVE_AXIS, mks.Outcome.FAILED), "01 F4 00 F5"),
    (mks.Status(mks.Code.HOME, mks.Outcome.STARTED), "01 91 01 93"),
    (mks.Status(mks.Code.HOME, mks.Outcome.FAILED), "01 91 00 92"),
    (mks.Status(mks.Code.CALIBRATE, mks.Outcome.STARTED), "01 80 00 81"),
    (mks.Status(mks.Code.CALIBRATE, mks.Outcome.FAILED), "01 80 02 83"),
    (mks.Status(mks.Code.ENABLE, mks.Outcome.DONE), "01 F3 01 F5"),
    (mks.Status(mks.Code.MODE, mks.Outcome.FAILED), "01 82 00 83"),
    (
        mks.Status(mks.Code.REPORT, mks.Outcome.DONE, mks.Code.ENCODER),
        "01 01 31 01 34",
    ),  # the manual's
]

REQUEST_BYTES = MANUAL_REQUESTS + OTHER_REQUESTS


def frame_of(text: str) -> Frame:
    number, *data = bytes.fromhex(text)
    return Frame(number, bytes(data))
