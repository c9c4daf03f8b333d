"""The Robko 01's SUPER protocol: messages, frames and host.

The ESP32 retrofit (robko01/robko01_retrofit_fw) also reads lines that look like a TeachMover's
(`@STEP`, `@READ`, ...). That is another dialect, which is not supported here: it answers OK at
once, takes absolute positions and does not wait for the motion.
"""

from firmware_protocol.events import Stray as Stray
from firmware_protocol.events import Unreadable as Unreadable
from firmware_protocol.robko01.frames import FLUSH as FLUSH
from firmware_protocol.robko01.frames import FRAME_MAX as FRAME_MAX
from firmware_protocol.robko01.frames import PAYLOAD_MAX as PAYLOAD_MAX
from firmware_protocol.robko01.host import Answered as Answered
from firmware_protocol.robko01.host import Event as Event
from firmware_protocol.robko01.host import Host as Host
from firmware_protocol.robko01.messages import AXES as AXES
from firmware_protocol.robko01.messages import AXIS_NAMES as AXIS_NAMES
from firmware_protocol.robko01.messages import Acknowledged as Acknowledged
from firmware_protocol.robko01.messages import Answer as Answer
from firmware_protocol.robko01.messages import Axes as Axes
from firmware_protocol.robko01.messages import Busy as Busy
from firmware_protocol.robko01.messages import Clear as Clear
from firmware_protocol.robko01.messages import Disable as Disable
from firmware_protocol.robko01.messages import Enable as Enable
from firmware_protocol.robko01.messages import Inputs as Inputs
from firmware_protocol.robko01.messages import InputsRead as InputsRead
from firmware_protocol.robko01.messages import IsMoving as IsMoving
from firmware_protocol.robko01.messages import MoveAbsolute as MoveAbsolute
from firmware_protocol.robko01.messages import MoveRelative as MoveRelative
from firmware_protocol.robko01.messages import MoveSpeed as MoveSpeed
from firmware_protocol.robko01.messages import Moving as Moving
from firmware_protocol.robko01.messages import Op as Op
from firmware_protocol.robko01.messages import Outputs as Outputs
from firmware_protocol.robko01.messages import OutputsSet as OutputsSet
from firmware_protocol.robko01.messages import Ping as Ping
from firmware_protocol.robko01.messages import Pong as Pong
from firmware_protocol.robko01.messages import Position as Position
from firmware_protocol.robko01.messages import Positions as Positions
from firmware_protocol.robko01.messages import Request as Request
from firmware_protocol.robko01.messages import Status as Status
from firmware_protocol.robko01.messages import Stop as Stop
