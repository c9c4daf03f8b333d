"""The MKS SERVO42D/57D on CAN, for the host of a bus of drives and for a drive.

Which file decides what:

    values     codes, units, options, and the check byte
    requests   a host's requests, and the firmware that each needs
    answers    a drive's answers; frames checked and read
    host       which reply belongs to which request
    device     a drive's end
"""

from firmware_protocol.events import UnreadableFrame as UnreadableFrame
from firmware_protocol.mks.answers import BOARDS as BOARDS
from firmware_protocol.mks.answers import AngleErrorRead as AngleErrorRead
from firmware_protocol.mks.answers import Answer as Answer
from firmware_protocol.mks.answers import EnabledRead as EnabledRead
from firmware_protocol.mks.answers import EncoderRead as EncoderRead
from firmware_protocol.mks.answers import HomingRead as HomingRead
from firmware_protocol.mks.answers import RawEncoderRead as RawEncoderRead
from firmware_protocol.mks.answers import Reading as Reading
from firmware_protocol.mks.answers import SettingRead as SettingRead
from firmware_protocol.mks.answers import StallRead as StallRead
from firmware_protocol.mks.answers import StateRead as StateRead
from firmware_protocol.mks.answers import Status as Status
from firmware_protocol.mks.answers import VersionRead as VersionRead
from firmware_protocol.mks.answers import as_setting as as_setting
from firmware_protocol.mks.answers import decode_answer as decode_answer
from firmware_protocol.mks.answers import decode_request as decode_request
from firmware_protocol.mks.answers import encode as encode
from firmware_protocol.mks.device import Asked as Asked
from firmware_protocol.mks.device import Device as Device
from firmware_protocol.mks.host import Answered as Answered
from firmware_protocol.mks.host import Event as Event
from firmware_protocol.mks.host import Foreign as Foreign
from firmware_protocol.mks.host import Host as Host
from firmware_protocol.mks.requests import COURSE_CODES as COURSE_CODES
from firmware_protocol.mks.requests import CURRENT_MAX_MA as CURRENT_MAX_MA
from firmware_protocol.mks.requests import MICROSTEPS_MAX as MICROSTEPS_MAX
from firmware_protocol.mks.requests import MOTION_CODES as MOTION_CODES
from firmware_protocol.mks.requests import OTHER_MOTIONS as OTHER_MOTIONS
from firmware_protocol.mks.requests import SETTING_CODES as SETTING_CODES
from firmware_protocol.mks.requests import Action as Action
from firmware_protocol.mks.requests import ArmSynchronous as ArmSynchronous
from firmware_protocol.mks.requests import Calibrate as Calibrate
from firmware_protocol.mks.requests import ClearStall as ClearStall
from firmware_protocol.mks.requests import EmergencyStop as EmergencyStop
from firmware_protocol.mks.requests import Enable as Enable
from firmware_protocol.mks.requests import Home as Home
from firmware_protocol.mks.requests import Motion as Motion
from firmware_protocol.mks.requests import MoveAbsoluteAxis as MoveAbsoluteAxis
from firmware_protocol.mks.requests import OtherMotion as OtherMotion
from firmware_protocol.mks.requests import Read as Read
from firmware_protocol.mks.requests import ReadAngleError as ReadAngleError
from firmware_protocol.mks.requests import ReadEnabled as ReadEnabled
from firmware_protocol.mks.requests import ReadEncoder as ReadEncoder
from firmware_protocol.mks.requests import ReadHoming as ReadHoming
from firmware_protocol.mks.requests import ReadRawEncoder as ReadRawEncoder
from firmware_protocol.mks.requests import ReadSetting as ReadSetting
from firmware_protocol.mks.requests import ReadStall as ReadStall
from firmware_protocol.mks.requests import ReadState as ReadState
from firmware_protocol.mks.requests import ReadVersion as ReadVersion
from firmware_protocol.mks.requests import Request as Request
from firmware_protocol.mks.requests import SetBitrate as SetBitrate
from firmware_protocol.mks.requests import SetCurrent as SetCurrent
from firmware_protocol.mks.requests import SetHoming as SetHoming
from firmware_protocol.mks.requests import SetId as SetId
from firmware_protocol.mks.requests import SetMicrosteps as SetMicrosteps
from firmware_protocol.mks.requests import SetMode as SetMode
from firmware_protocol.mks.requests import SetReplies as SetReplies
from firmware_protocol.mks.requests import SetStallProtection as SetStallProtection
from firmware_protocol.mks.requests import Setting as Setting
from firmware_protocol.mks.requests import SetZero as SetZero
from firmware_protocol.mks.requests import SilenceWatchdog as SilenceWatchdog
from firmware_protocol.mks.requests import Stop as Stop
from firmware_protocol.mks.requests import answer_code as answer_code
from firmware_protocol.mks.values import ANGLE_ERROR_PER_TURN as ANGLE_ERROR_PER_TURN
from firmware_protocol.mks.values import BROADCAST as BROADCAST
from firmware_protocol.mks.values import COUNTS_PER_TURN as COUNTS_PER_TURN
from firmware_protocol.mks.values import COUNTS_S_PER_RPM as COUNTS_S_PER_RPM
from firmware_protocol.mks.values import HARD_STOP_MAX_RPM as HARD_STOP_MAX_RPM
from firmware_protocol.mks.values import LATEST as LATEST
from firmware_protocol.mks.values import NODE_DEFAULT as NODE_DEFAULT
from firmware_protocol.mks.values import NODE_MAX as NODE_MAX
from firmware_protocol.mks.values import SPEED_MAX_RPM as SPEED_MAX_RPM
from firmware_protocol.mks.values import TARGET_MAX as TARGET_MAX
from firmware_protocol.mks.values import Ability as Ability
from firmware_protocol.mks.values import Bitrate as Bitrate
from firmware_protocol.mks.values import Code as Code
from firmware_protocol.mks.values import HomingState as HomingState
from firmware_protocol.mks.values import Mode as Mode
from firmware_protocol.mks.values import MotorState as MotorState
from firmware_protocol.mks.values import Outcome as Outcome
from firmware_protocol.mks.values import ReplyMode as ReplyMode
from firmware_protocol.mks.values import Version as Version
from firmware_protocol.mks.values import abilities_of as abilities_of
from firmware_protocol.mks.values import acc_of as acc_of
from firmware_protocol.mks.values import check_byte as check_byte
from firmware_protocol.mks.values import ramp_rpm_s as ramp_rpm_s
from firmware_protocol.mks.values import slope_of as slope_of
from firmware_protocol.mks.values import true_rpm as true_rpm
