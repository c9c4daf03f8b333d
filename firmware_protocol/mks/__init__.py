"""The MKS SERVO42D/57D on CAN: the host's end of a bus of drives, and a drive's end."""

from firmware_protocol.mks.abilities import (
    LATEST,
    SINCE,
    Ability,
    Since,
    Version,
    abilities_of,
    needed_for,
)
from firmware_protocol.mks.actions import (
    MOTION_CODES,
    Action,
    ArmSynchronous,
    Calibrate,
    ClearStall,
    EmergencyStop,
    Enable,
    GoSynchronous,
    GoToZero,
    Home,
    Motion,
    Restart,
    SetZero,
    Stop,
)
from firmware_protocol.mks.bus_settings import (
    SetBitrate,
    SetGroup,
    SetId,
    SetReplies,
)
from firmware_protocol.mks.device import (
    Asked,
    Device,
    DeviceEvent,
    Ignored,
    Overlooked,
)
from firmware_protocol.mks.events import (
    Answered,
    Done,
    Event,
    Failed,
    Foreign,
    Garbled,
    LimitStop,
    Overrun,
    Reported,
    Started,
    StoredForStart,
    Stray,
    Superseded,
)
from firmware_protocol.mks.guard_settings import (
    SetArrival,
    SetHoming,
    SetPositionProtection,
    SetStallProtection,
    SilenceWatchdog,
)
from firmware_protocol.mks.host import (
    EVENTS_MAX,
    Host,
)
from firmware_protocol.mks.identity import (
    BOARDS,
    SettingRead,
    VersionRead,
)
from firmware_protocol.mks.motor_settings import (
    CURRENT_MAX_MA,
    MICROSTEPS_MAX,
    SetCurrent,
    SetDirection,
    SetHoldingCurrent,
    SetMicrosteps,
    SetMode,
)
from firmware_protocol.mks.moves import (
    ACC_MAX,
    RUN_MAX_MS,
    Move,
    MoveAbsoluteAxis,
    MoveAbsolutePulses,
    MoveRelativeAxis,
    MoveRelativePulses,
    RunAtSpeed,
    RunFor,
)
from firmware_protocol.mks.outcomes import (
    COURSE_CODES,
    Status,
)
from firmware_protocol.mks.readings import (
    AngleErrorRead,
    EnabledRead,
    EncoderRead,
    HomingRead,
    InputsRead,
    PulsesRead,
    RawEncoderRead,
    Reading,
    SpeedRead,
    StallRead,
    StateRead,
)
from firmware_protocol.mks.reads import (
    READ_CODES,
    Read,
    ReadAngleError,
    ReadEnabled,
    ReadEncoder,
    ReadHoming,
    ReadInputs,
    ReadPulses,
    ReadRawEncoder,
    ReadSetting,
    ReadSpeed,
    ReadStall,
    ReadState,
    ReadVersion,
    ReportByItself,
)
from firmware_protocol.mks.settings import (
    SETTING_CODES,
    Setting,
)
from firmware_protocol.mks.values import (
    ANGLE_ERROR_PER_TURN,
    BROADCAST,
    COUNTS_PER_TURN,
    HARD_STOP_MAX_RPM,
    NODE_DEFAULT,
    NODE_MAX,
    SPEED_MAX_RPM,
    TARGET_MAX,
    Bitrate,
    Code,
    HomingState,
    Mode,
    MotorState,
    Outcome,
    ReplyMode,
    acc_of,
    check_byte,
    ramp_rpm_s,
    true_rpm,
)
from firmware_protocol.mks.wire import (
    Answer,
    Request,
    as_setting,
    decode_answer,
    decode_request,
    encode,
)

# a name a line would double the file
# fmt: off
__all__ = [
    "ACC_MAX", "ANGLE_ERROR_PER_TURN", "BOARDS", "BROADCAST", "COUNTS_PER_TURN", "COURSE_CODES",
    "CURRENT_MAX_MA", "EVENTS_MAX", "HARD_STOP_MAX_RPM", "LATEST", "MICROSTEPS_MAX",
    "MOTION_CODES", "NODE_DEFAULT", "NODE_MAX", "READ_CODES", "RUN_MAX_MS", "SETTING_CODES",
    "SINCE", "SPEED_MAX_RPM", "TARGET_MAX", "Ability", "Action", "AngleErrorRead", "Answer",
    "Answered", "ArmSynchronous", "Asked", "Bitrate", "Calibrate", "ClearStall", "Code",
    "Device", "DeviceEvent", "Done", "EmergencyStop", "Enable", "EnabledRead", "EncoderRead",
    "Event", "Failed", "Foreign", "Garbled", "GoSynchronous", "GoToZero", "Home", "HomingRead",
    "HomingState", "Host", "Ignored", "InputsRead", "LimitStop", "Mode", "Motion", "MotorState",
    "Move", "MoveAbsoluteAxis", "MoveAbsolutePulses", "MoveRelativeAxis", "MoveRelativePulses",
    "Outcome", "Overlooked", "Overrun", "PulsesRead", "RawEncoderRead", "Read",
    "ReadAngleError", "ReadEnabled", "ReadEncoder", "ReadHoming", "ReadInputs", "ReadPulses",
    "ReadRawEncoder", "ReadSetting", "ReadSpeed", "ReadStall", "ReadState", "ReadVersion",
    "Reading", "ReplyMode", "ReportByItself", "Reported", "Request", "Restart", "RunAtSpeed",
    "RunFor", "SetArrival", "SetBitrate", "SetCurrent", "SetDirection", "SetGroup",
    "SetHoldingCurrent", "SetHoming", "SetId", "SetMicrosteps", "SetMode",
    "SetPositionProtection", "SetReplies", "SetStallProtection", "SetZero", "Setting",
    "SettingRead", "SilenceWatchdog", "Since", "SpeedRead", "StallRead", "Started", "StateRead",
    "Status", "Stop", "StoredForStart", "Stray", "Superseded", "Version", "VersionRead",
    "abilities_of", "acc_of", "as_setting", "check_byte", "decode_answer", "decode_request",
    "encode", "needed_for", "ramp_rpm_s", "true_rpm",
]
# fmt: on
