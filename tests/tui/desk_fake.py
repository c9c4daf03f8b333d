"""An arm that moves nothing and writes down what the desk asked of it; and a clock to set."""

import queue
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

from armdrive.dialog import PostureRequest
from armdrive.errors import Refused, StateFileError, Stopped
from armdrive.motion.gripper import Grasped
from armdrive.moves import GripperMove
from armdrive.status import Current, State, Status, Trust
from armdrive.trace.entries import EntryKind, EntryRing, TraceEntry
from armdrive.trace.log import LogReader
from kinematics import Joints, Motors, preset

MODEL = preset("teachmover")


class Clock:
    """Time that stands still until it is told to pass."""

    def __init__(self):
        self.now_s = 100.0

    def __call__(self):
        return self.now_s


class FakeArm:
    """Has what the desk asks of an arm."""

    def __init__(self, **more):
        joints = Joints.of(20.0, 60.0, -80.0, -60.0, 15.0)
        self.status = Status(
            arm="sim",
            title="TeachMover",
            link="in this process",
            dialect="teachmover",
            simulated=True,
            state=State.STANDBY,
            trust=Trust.REFERENCED,
            trust_reason="referenced in the reference posture",
            current=Current.HELD,
            joints=joints,
            pose=MODEL.arm.fk(joints),
            gripper_mm=38.0,
            gripping=False,
            acknowledged=Motors((393, -1179, 231, 277, 405, 786)),
            stop_time_s=0.21,
            stop_distance_mm=14.0,
            last_sent="@STEP 240,0,0,0,0,0,12",
            last_answer="1",
        )
        self.model = MODEL
        self.calls = []
        self.gripper = SimpleNamespace(force_n=0.0)
        self.set(**more)

    def set(self, **more):
        """Change the status; a notice is a new one even if its words are not."""
        notices = self.status.notices + ("notice" in more)
        self.status = replace(self.status, notices=notices, **more)

    def asked(self, name):
        return [call for call in self.calls if call[0] == name]

    @property
    def reference(self):
        """The fake is its own parts."""
        return self

    jogging = reference

    def request(self):
        pose = MODEL.reference.pose
        return PostureRequest(self, pose, MODEL.arm.ik(pose), 0.0)

    stops = 0
    homes_by_switches = False
    program = None
    frames = ("base", "tool", "board")
    reconnects = False

    def pose_in(self, frame):
        """Return the pose in a frame that is the base's, 100 mm along x."""
        return replace(self.status.pose, x_mm=self.status.pose.x_mm - 100.0)

    def enable(self):
        self.calls.append(("enable",))
        self.set(state=State.STANDBY)

    def disable(self):
        self.calls.append(("disable",))
        self.set(state=State.DISABLED, current=Current.OFF)

    def start(self, move, *, stops=None):
        """Move the fingers, which find a block of 30 mm."""
        if stops is not None and stops != self.stops:
            raise Stopped("a stop was requested before the motion started")
        if isinstance(move, GripperMove):
            self.calls.append(("open", move.opening_mm, move.speed))
        else:
            self.calls.append(("grasp",))
            self.gripper.force_n = move.force_n
        return SimpleNamespace(wait=lambda: Grasped(30.0, 8.9))

    def hold(self, jog, *, speed, for_s):
        self.calls.append(("hold", jog, speed, for_s))

    def nudge(self, jog, *, speed):
        self.calls.append(("nudge", jog, speed))

    def release(self):
        self.calls.append(("release",))

    def request_stop(self):
        self.calls.append(("stop",))
        self.stops += 1

    def estop(self):
        self.calls.append(("estop",))
        self.set(state=State.ERROR_STOP, error="emergency stop")

    def reset(self):
        self.calls.append(("reset",))
        self.set(state=State.STANDBY, error="")

    def reconnect(self):
        self.calls.append(("reconnect",))
        self.come_back()

    def come_back(self, **more):
        """Have the link back, as an arm does that stood when it was lost."""
        error = (
            "the connection was lost and is back, now COM7: look at the arm, then call `reset()`"
        )
        reason = "the link was lost and restored, and the registers match"
        back = {
            "state": State.ERROR_STOP,
            "error": error,
            "error_code": "E409",
            "trust": Trust.RESTORED,
            "trust_reason": reason,
        }
        self.set(**(back | more))

    def home(self, *, stops):
        if stops != self.stops:
            raise Stopped("a stop was requested before the motion started")
        self.calls.append(("home",))

    def confirm(self):
        self.calls.append(("reference",))

    def confirm_restored(self):
        self.calls.append(("restored",))

    def close(self):
        self.calls.append(("close",))


class StubbornArm(FakeArm):
    """Refuses everything that may be refused, with a sentence."""

    def reset(self):
        raise Refused("the arm is still moving: wait")

    def confirm(self):
        raise Refused("no reference now: the arm moves")

    def nudge(self, jog, *, speed):
        raise Refused("no such axis here")


class UnplaceableArm(FakeArm):
    """Nobody knows its reference posture."""

    def request(self):
        raise Refused("no reference posture is known")


def unknown_position():
    """Fields of a status before anything is known of the position."""
    return {
        "trust": Trust.UNKNOWN,
        "trust_reason": "no position of this arm has been saved",
        "joints": None,
        "pose": None,
        "gripper_mm": None,
        "acknowledged": None,
    }


END = object()
"""Put into a holder's reports, it ends them."""


class FakeHolder:
    """A program that drives an arm: it reports what a test puts, and writes down what is asked."""

    def __init__(self, *views):
        self.said = queue.Queue()
        self.asked = []
        self.answer = {"done": "it"}
        for view in views:
            self.said.put(view)

    def views(self):
        while (view := self.said.get()) is not END:
            if isinstance(view, Exception):
                raise view
            yield view

    def ask(self, request, **words):
        self.asked.append((request, words))
        if isinstance(self.answer, Exception):
            raise self.answer
        return self.answer


class LoggedArm(FakeArm):
    """`pass_by` puts entries into its log; `saved` is where a recording goes."""

    def __init__(self, dialect="teachmover", **more):
        super().__init__(**more)
        self.ring = EntryRing()
        self.dialect = dialect
        self.now_s = 0.0
        self.saved = Path("/somewhere/recordings/sim-001-asked-for.jsonl")
        self.looks = []

    @property
    def recorder(self):
        """The fake is its own parts."""
        return self

    def log(self):
        return LogReader(self._since, self.dialect, 0.0)

    def _since(self, number, most, back):
        first, entries = self.ring.since(number, most, back)
        self.looks.append(len(entries))
        return first, entries

    def pass_by(self, kind, what):
        self.now_s += 0.125
        self.ring.add(TraceEntry(self.now_s, kind, what))

    def move(self, steps="37,0,-4,0,0,0"):
        """Have what belongs to one small motion pass by."""
        self.pass_by(EntryKind.REQUEST, "MoveBy(37 0 -4 0 0 0; 219.5 steps/s)")
        self.pass_by(EntryKind.SENT, f"@STEP 214,{steps}\r".encode())
        self.pass_by(EntryKind.RECEIVED, b"1\r")
        self.pass_by(EntryKind.REPLY, "done")

    def save(self):
        if self.saved is None:
            raise StateFileError("the recording cannot be written: the disk is full")
        return self.saved


def busy_arm(dialect="teachmover"):
    """An arm with a call, a motion, and a fault behind it."""
    arm = LoggedArm(dialect)
    arm.pass_by(EntryKind.CALL, "move_j shoulder 40 deg, elbow -60 deg, speed 0.5")
    arm.pass_by(EntryKind.STATE, "moving")
    for number in range(6):
        arm.move(f"{37 + number},0,-4,0,0,0")
    arm.pass_by(EntryKind.TIMEOUT, "no answer to `@STEP 214,37,0,-4,0,0,0` within 1.5 s")
    arm.pass_by(EntryKind.STATE, "error-stop")
    arm.pass_by(EntryKind.TRUST, "suspect: a motion was sent and never answered")
    arm.pass_by(EntryKind.ERROR, "[E502] no answer to `@STEP 214,37,0,-4,0,0,0` within 1.5 s")
    arm.pass_by(EntryKind.RAISED, "NoAnswer: no answer to `@STEP 214,37,0,-4,0,0,0` within 1.5 s")
    return arm
