"""CANopen (CiA 301) and its drive profile (CiA 402), for the master and for drives.

Which file decides what:

    services            ids, heartbeats, emergencies and their codes
    objects             object dictionaries
    sdo, sdo_server     objects read and written one by one; abort codes
    pdo                 objects sent in one frame
    drives              states, commands and modes of a drive
    host                a master's end
"""

from firmware_protocol.canopen.drives import INCREMENTS_A_SECOND as INCREMENTS_A_SECOND
from firmware_protocol.canopen.drives import POSITION_INCREMENTS as POSITION_INCREMENTS
from firmware_protocol.canopen.drives import RPM as RPM
from firmware_protocol.canopen.drives import TRANSITIONS as TRANSITIONS
from firmware_protocol.canopen.drives import Command as Command
from firmware_protocol.canopen.drives import ControlBit as ControlBit
from firmware_protocol.canopen.drives import Controlword as Controlword
from firmware_protocol.canopen.drives import DriveDevice as DriveDevice
from firmware_protocol.canopen.drives import DriveState as DriveState
from firmware_protocol.canopen.drives import Happening as Happening
from firmware_protocol.canopen.drives import OperationMode as OperationMode
from firmware_protocol.canopen.drives import QuickStopOption as QuickStopOption
from firmware_protocol.canopen.drives import SetPointHost as SetPointHost
from firmware_protocol.canopen.drives import SetPointPhase as SetPointPhase
from firmware_protocol.canopen.drives import SetPoints as SetPoints
from firmware_protocol.canopen.drives import StatusBit as StatusBit
from firmware_protocol.canopen.drives import Statusword as Statusword
from firmware_protocol.canopen.drives import Transition as Transition
from firmware_protocol.canopen.drives import mode_of as mode_of
from firmware_protocol.canopen.drives import speed_unit_hz as speed_unit_hz
from firmware_protocol.canopen.drives import supported_modes as supported_modes
from firmware_protocol.canopen.drives import supported_word as supported_word
from firmware_protocol.canopen.drives import transition as transition
from firmware_protocol.canopen.host import COMMAND_PDO as COMMAND_PDO
from firmware_protocol.canopen.host import REPORT_PDO as REPORT_PDO
from firmware_protocol.canopen.host import DriveReport as DriveReport
from firmware_protocol.canopen.host import Host as Host
from firmware_protocol.canopen.host import HostEvent as HostEvent
from firmware_protocol.canopen.host import SdoAnswered as SdoAnswered
from firmware_protocol.canopen.host import drive_pdos as drive_pdos
from firmware_protocol.canopen.objects import CONSUMER_HEARTBEAT as CONSUMER_HEARTBEAT
from firmware_protocol.canopen.objects import CONTROLWORD as CONTROLWORD
from firmware_protocol.canopen.objects import DEVICE_NAME as DEVICE_NAME
from firmware_protocol.canopen.objects import DEVICE_TYPE as DEVICE_TYPE
from firmware_protocol.canopen.objects import DIGITAL_INPUTS as DIGITAL_INPUTS
from firmware_protocol.canopen.objects import ENCODER_INCREMENTS as ENCODER_INCREMENTS
from firmware_protocol.canopen.objects import ENCODER_TURNS as ENCODER_TURNS
from firmware_protocol.canopen.objects import ERROR_BEHAVIOUR as ERROR_BEHAVIOUR
from firmware_protocol.canopen.objects import ERROR_CODE as ERROR_CODE
from firmware_protocol.canopen.objects import ERROR_COUNT as ERROR_COUNT
from firmware_protocol.canopen.objects import ERROR_REGISTER as ERROR_REGISTER
from firmware_protocol.canopen.objects import FAULT_REACTION_OPTION as FAULT_REACTION_OPTION
from firmware_protocol.canopen.objects import FOLLOWING_ERROR as FOLLOWING_ERROR
from firmware_protocol.canopen.objects import (
    FOLLOWING_ERROR_TIMEOUT_MS as FOLLOWING_ERROR_TIMEOUT_MS,
)
from firmware_protocol.canopen.objects import FOLLOWING_ERROR_WINDOW as FOLLOWING_ERROR_WINDOW
from firmware_protocol.canopen.objects import HEARTBEAT_REACTION as HEARTBEAT_REACTION
from firmware_protocol.canopen.objects import HOME_OFFSET as HOME_OFFSET
from firmware_protocol.canopen.objects import HOMING_ACCELERATION as HOMING_ACCELERATION
from firmware_protocol.canopen.objects import HOMING_CREEP as HOMING_CREEP
from firmware_protocol.canopen.objects import HOMING_METHOD as HOMING_METHOD
from firmware_protocol.canopen.objects import HOMING_SPEED as HOMING_SPEED
from firmware_protocol.canopen.objects import LAST_ERROR as LAST_ERROR
from firmware_protocol.canopen.objects import LEAST_POSITION as LEAST_POSITION
from firmware_protocol.canopen.objects import MODE as MODE
from firmware_protocol.canopen.objects import MODE_SHOWN as MODE_SHOWN
from firmware_protocol.canopen.objects import MOST_MOTOR_SPEED as MOST_MOTOR_SPEED
from firmware_protocol.canopen.objects import MOST_POSITION as MOST_POSITION
from firmware_protocol.canopen.objects import PERIOD as PERIOD
from firmware_protocol.canopen.objects import PERIOD_POWER as PERIOD_POWER
from firmware_protocol.canopen.objects import POSITION as POSITION
from firmware_protocol.canopen.objects import POSITION_DEMAND as POSITION_DEMAND
from firmware_protocol.canopen.objects import POSITION_UNIT as POSITION_UNIT
from firmware_protocol.canopen.objects import POSITION_WINDOW as POSITION_WINDOW
from firmware_protocol.canopen.objects import PRODUCER_HEARTBEAT_MS as PRODUCER_HEARTBEAT_MS
from firmware_protocol.canopen.objects import PRODUCT as PRODUCT
from firmware_protocol.canopen.objects import PROFILE_ACCELERATION as PROFILE_ACCELERATION
from firmware_protocol.canopen.objects import PROFILE_DECELERATION as PROFILE_DECELERATION
from firmware_protocol.canopen.objects import PROFILE_SPEED as PROFILE_SPEED
from firmware_protocol.canopen.objects import QUICK_STOP_DECELERATION as QUICK_STOP_DECELERATION
from firmware_protocol.canopen.objects import QUICK_STOP_OPTION as QUICK_STOP_OPTION
from firmware_protocol.canopen.objects import REVISION as REVISION
from firmware_protocol.canopen.objects import SERIAL_NUMBER as SERIAL_NUMBER
from firmware_protocol.canopen.objects import SPEED_UNIT as SPEED_UNIT
from firmware_protocol.canopen.objects import STANDARD as STANDARD
from firmware_protocol.canopen.objects import STATUSWORD as STATUSWORD
from firmware_protocol.canopen.objects import SUPPORTED_MODES as SUPPORTED_MODES
from firmware_protocol.canopen.objects import SYNC_ID as SYNC_ID
from firmware_protocol.canopen.objects import TARGET_POSITION as TARGET_POSITION
from firmware_protocol.canopen.objects import VELOCITY as VELOCITY
from firmware_protocol.canopen.objects import VENDOR as VENDOR
from firmware_protocol.canopen.objects import Access as Access
from firmware_protocol.canopen.objects import DataType as DataType
from firmware_protocol.canopen.objects import Dictionary as Dictionary
from firmware_protocol.canopen.objects import ObjectEntry as ObjectEntry
from firmware_protocol.canopen.objects import Place as Place
from firmware_protocol.canopen.objects import Value as Value
from firmware_protocol.canopen.objects import read_eds as read_eds
from firmware_protocol.canopen.pdo import EVERY_SYNC as EVERY_SYNC
from firmware_protocol.canopen.pdo import NOT_VALID as NOT_VALID
from firmware_protocol.canopen.pdo import PDO_SERVICES as PDO_SERVICES
from firmware_protocol.canopen.pdo import Direction as Direction
from firmware_protocol.canopen.pdo import Mapped as Mapped
from firmware_protocol.canopen.pdo import Mapping as Mapping
from firmware_protocol.canopen.pdo import Write as Write
from firmware_protocol.canopen.pdo import first_pdo as first_pdo
from firmware_protocol.canopen.pdo import switched_off as switched_off
from firmware_protocol.canopen.sdo import Abort as Abort
from firmware_protocol.canopen.sdo import AbortCode as AbortCode
from firmware_protocol.canopen.sdo import Aborted as Aborted
from firmware_protocol.canopen.sdo import Downloaded as Downloaded
from firmware_protocol.canopen.sdo import SdoClient as SdoClient
from firmware_protocol.canopen.sdo import SdoEvent as SdoEvent
from firmware_protocol.canopen.sdo import StrayResponse as StrayResponse
from firmware_protocol.canopen.sdo import Uploaded as Uploaded
from firmware_protocol.canopen.sdo import abort_words as abort_words
from firmware_protocol.canopen.sdo_server import ObjectStore as ObjectStore
from firmware_protocol.canopen.sdo_server import SdoServer as SdoServer
from firmware_protocol.canopen.services import ALL_NODES as ALL_NODES
from firmware_protocol.canopen.services import ERROR_WORDS as ERROR_WORDS
from firmware_protocol.canopen.services import HEARTBEAT_MISSING as HEARTBEAT_MISSING
from firmware_protocol.canopen.services import NODE_MAX as NODE_MAX
from firmware_protocol.canopen.services import Emergency as Emergency
from firmware_protocol.canopen.services import ErrorRegister as ErrorRegister
from firmware_protocol.canopen.services import Heartbeat as Heartbeat
from firmware_protocol.canopen.services import HeartbeatWatch as HeartbeatWatch
from firmware_protocol.canopen.services import Nmt as Nmt
from firmware_protocol.canopen.services import NmtCommand as NmtCommand
from firmware_protocol.canopen.services import NmtNode as NmtNode
from firmware_protocol.canopen.services import NodeState as NodeState
from firmware_protocol.canopen.services import Service as Service
from firmware_protocol.canopen.services import Sync as Sync
from firmware_protocol.canopen.services import cob_id as cob_id
from firmware_protocol.canopen.services import error_words as error_words
from firmware_protocol.canopen.services import service_of as service_of
from firmware_protocol.events import UnreadableFrame as UnreadableFrame
