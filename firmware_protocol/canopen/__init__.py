"""CANopen (CiA 301) and its profile for drives (CiA 402): the master's end and a drive's end."""

from firmware_protocol.canopen.cob import (
    NODE_MAX,
    Service,
    cob_id,
    service_of,
)
from firmware_protocol.canopen.drive_device import (
    DriveDevice,
    SetPoint,
    SetPoints,
)
from firmware_protocol.canopen.drives import (
    TRANSITIONS,
    Command,
    ControlBit,
    Controlword,
    DriveState,
    Happening,
    OperationMode,
    QuickStopOption,
    StatusBit,
    Statusword,
    Transition,
    mode_of,
    supported_modes,
    supported_word,
    transition,
    way,
)
from firmware_protocol.canopen.eds import (
    read_eds,
)
from firmware_protocol.canopen.emcy import (
    ERROR_WORDS,
    Emergency,
    ErrorRegister,
    error_words,
)
from firmware_protocol.canopen.nmt import (
    ALL_NODES,
    SPEAKS,
    Heartbeat,
    HeartbeatWatch,
    Nmt,
    NmtCommand,
    NmtNode,
    NodeState,
    Sync,
)
from firmware_protocol.canopen.objects import (
    CONSUMER_HEARTBEAT,
    CONTROLWORD,
    DEVICE_TYPE,
    ERROR_CODE,
    ERROR_REGISTER,
    FAULT_REACTION_OPTION,
    FOLLOWING_ERROR,
    FOLLOWING_ERROR_TIMEOUT_MS,
    FOLLOWING_ERROR_WINDOW,
    HEARTBEAT_REACTION,
    MODE,
    MODE_SHOWN,
    POSITION,
    PRODUCER_HEARTBEAT_MS,
    PROFILE_ACCELERATION,
    PROFILE_DECELERATION,
    PROFILE_SPEED,
    QUICK_STOP_DECELERATION,
    QUICK_STOP_OPTION,
    STANDARD,
    STATUSWORD,
    SUPPORTED_MODES,
    TARGET_POSITION,
    Access,
    DataType,
    Dictionary,
    ObjectEntry,
    Place,
    Value,
)
from firmware_protocol.canopen.pdo import (
    EVERY_SYNC,
    NO_REMOTE,
    NOT_VALID,
    ON_EVENT,
    PDO_MAX,
    Direction,
    Mapped,
    Mapping,
    PdoSetup,
    Write,
)
from firmware_protocol.canopen.sdo import (
    EVENTS_MAX,
    Abort,
    AbortCode,
    abort_words,
)
from firmware_protocol.canopen.sdo_client import (
    Aborted,
    Downloaded,
    GarbledResponse,
    SdoClient,
    SdoEvent,
    StrayResponse,
    Uploaded,
)
from firmware_protocol.canopen.sdo_server import (
    Ask,
    GivenUp,
    IgnoredRequest,
    ObjectStore,
    ReadAsked,
    SdoServer,
    SdoServerEvent,
    WriteAsked,
)
from firmware_protocol.canopen.set_point_host import (
    Disabled,
    FollowingError,
    Phase,
    Reached,
    SetPointEvent,
    SetPointHost,
    Stood,
    Taken,
)
from firmware_protocol.waiting import (
    Overrun,
)

# a name a line would double the file
# fmt: off
__all__ = [
    "ALL_NODES", "CONSUMER_HEARTBEAT", "CONTROLWORD", "DEVICE_TYPE", "ERROR_CODE",
    "ERROR_REGISTER", "ERROR_WORDS", "EVENTS_MAX", "EVERY_SYNC", "FAULT_REACTION_OPTION",
    "FOLLOWING_ERROR", "FOLLOWING_ERROR_TIMEOUT_MS", "FOLLOWING_ERROR_WINDOW",
    "HEARTBEAT_REACTION", "MODE", "MODE_SHOWN", "NODE_MAX", "NOT_VALID", "NO_REMOTE", "ON_EVENT",
    "PDO_MAX", "POSITION", "PRODUCER_HEARTBEAT_MS", "PROFILE_ACCELERATION", "PROFILE_DECELERATION",
    "PROFILE_SPEED", "QUICK_STOP_DECELERATION", "QUICK_STOP_OPTION", "SPEAKS", "STANDARD",
    "STATUSWORD", "SUPPORTED_MODES", "TARGET_POSITION", "TRANSITIONS", "Abort", "AbortCode",
    "Aborted", "Access", "Ask", "Command", "ControlBit", "Controlword", "DataType", "Dictionary",
    "Direction", "Disabled", "Downloaded", "DriveDevice", "DriveState", "Emergency",
    "ErrorRegister", "FollowingError", "GarbledResponse", "GivenUp", "Happening", "Heartbeat",
    "HeartbeatWatch", "IgnoredRequest", "Mapped", "Mapping", "Nmt", "NmtCommand", "NmtNode",
    "NodeState", "ObjectEntry", "ObjectStore", "OperationMode", "Overrun", "PdoSetup", "Phase",
    "Place", "QuickStopOption", "Reached", "ReadAsked", "SdoClient", "SdoEvent", "SdoServer",
    "SdoServerEvent", "Service", "SetPoint", "SetPointEvent", "SetPointHost", "SetPoints",
    "StatusBit", "Statusword", "Stood", "StrayResponse", "Sync", "Taken", "Transition", "Uploaded",
    "Value", "Write", "WriteAsked", "abort_words", "cob_id", "error_words", "mode_of", "read_eds",
    "service_of", "supported_modes", "supported_word", "transition", "way",
]
# fmt: on
