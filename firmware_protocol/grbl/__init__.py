"""The dialect of GRBL 1.1, grbl-Mega-5X, grblHAL and FluidNC, for both ends.

Which file decides what:

    commands, gcode   lines of a host, and which words exclude which
    answers           lines of a board
    codes             errors and alarms: what they mean, what to do, whether the position is kept
    host, device      the two ends, and how long a line each accepts
    keys              the numbers of settings
    dialect           numbers and letters: what is accepted, and how it is written
"""

from firmware_protocol.events import Stray as Stray
from firmware_protocol.events import Unreadable as Unreadable
from firmware_protocol.grbl.answers import Alarm as Alarm
from firmware_protocol.grbl.answers import Answer as Answer
from firmware_protocol.grbl.answers import AxesInfo as AxesInfo
from firmware_protocol.grbl.answers import Banner as Banner
from firmware_protocol.grbl.answers import Error as Error
from firmware_protocol.grbl.answers import Feedback as Feedback
from firmware_protocol.grbl.answers import Info as Info
from firmware_protocol.grbl.answers import Ok as Ok
from firmware_protocol.grbl.answers import Remark as Remark
from firmware_protocol.grbl.answers import Setting as Setting
from firmware_protocol.grbl.answers import State as State
from firmware_protocol.grbl.answers import StatusReport as StatusReport
from firmware_protocol.grbl.answers import Version as Version
from firmware_protocol.grbl.answers import WordedError as WordedError
from firmware_protocol.grbl.answers import encode_answer as encode_answer
from firmware_protocol.grbl.codes import ALARMS as ALARMS
from firmware_protocol.grbl.codes import ERRORS as ERRORS
from firmware_protocol.grbl.codes import AlarmCode as AlarmCode
from firmware_protocol.grbl.codes import ErrorCode as ErrorCode
from firmware_protocol.grbl.codes import alarm_code as alarm_code
from firmware_protocol.grbl.codes import error_code as error_code
from firmware_protocol.grbl.commands import Command as Command
from firmware_protocol.grbl.commands import Home as Home
from firmware_protocol.grbl.commands import Line as Line
from firmware_protocol.grbl.commands import Realtime as Realtime
from firmware_protocol.grbl.commands import SetSetting as SetSetting
from firmware_protocol.grbl.commands import SystemCommand as SystemCommand
from firmware_protocol.grbl.commands import pieces as pieces
from firmware_protocol.grbl.device import Content as Content
from firmware_protocol.grbl.device import Device as Device
from firmware_protocol.grbl.device import Empty as Empty
from firmware_protocol.grbl.device import LineReader as LineReader
from firmware_protocol.grbl.device import LineReceived as LineReceived
from firmware_protocol.grbl.device import Rejected as Rejected
from firmware_protocol.grbl.device import parse_line as parse_line
from firmware_protocol.grbl.dialect import AXIS_LETTERS as AXIS_LETTERS
from firmware_protocol.grbl.dialect import FLUIDNC as FLUIDNC
from firmware_protocol.grbl.dialect import GRBL as GRBL
from firmware_protocol.grbl.dialect import GRBLHAL as GRBLHAL
from firmware_protocol.grbl.dialect import Dialect as Dialect
from firmware_protocol.grbl.dialect import Variant as Variant
from firmware_protocol.grbl.dialect import write_number as write_number
from firmware_protocol.grbl.dialect import written as written
from firmware_protocol.grbl.gcode import Block as Block
from firmware_protocol.grbl.gcode import GcodeError as GcodeError
from firmware_protocol.grbl.gcode import Group as Group
from firmware_protocol.grbl.gcode import Modal as Modal
from firmware_protocol.grbl.gcode import parse_block as parse_block
from firmware_protocol.grbl.host import Acknowledged as Acknowledged
from firmware_protocol.grbl.host import AlarmRaised as AlarmRaised
from firmware_protocol.grbl.host import Event as Event
from firmware_protocol.grbl.host import Host as Host
from firmware_protocol.grbl.host import Refused as Refused
from firmware_protocol.grbl.host import Restarted as Restarted
