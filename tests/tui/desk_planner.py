"""A fake arm that plans as a real one does, and moves at once when it is told to go."""

from inspect import signature

from desk_fake import FakeArm
from waiting import until_seen

from armdrive.arm import Arm
from armdrive.connect.target import simulated_config
from armdrive.errors import Stopped
from armdrive.motion.frames import pose_in_frame
from armdrive.motion.plan import SpeedLimits
from armdrive.motion.preview import preview_move
from armdrive.motion.resolve import Ground, prepare
from armdrive.moves import GraspMove, GripperMove
from armdrive.registry import dialect
from armdrive.runtime.position import ArmCoordinates
from armdrive.status import State
from armdrive.storage.point_file import points_of
from armdrive.storage.points import Point
from kinematics import Motors

CONFIG = simulated_config("teachmover")
CONTROLLER = dialect("teachmover").controller(CONFIG)


class Going:
    """A motion that ends when it is waited for."""

    def __init__(self, arm, joints):
        self.arm, self.joints, self.cancelled = arm, joints, False

    def cancel(self):
        self.cancelled = True

    def wait(self):
        self.arm.during(self)
        if self.cancelled:
            raise Stopped("the motion was stopped before its goal")
        self.arm.stand_at(self.joints)


class PlannerArm(FakeArm):
    """Previews are the real ones; `during` is called while a motion would be under way."""

    config = CONFIG
    frames = ("base", "tool")
    stops = 0

    def __init__(self, **more):
        super().__init__(**more)
        self.during = lambda _: None
        self.asked_for = []
        self.previews = 0
        self.hindrance = None
        self.points = points_of(CONFIG.name, CONFIG.model.arm, self.here)

    def here(self):
        return Point(self.status.joints, self.status.gripper_mm)

    def stand_at(self, joints):
        steps, _ = Motors(round(angle * 1000) for angle in (*joints, 0.0)), None
        pose = CONFIG.model.arm.fk(joints)
        self.set(joints=joints, pose=pose, acknowledged=steps, state=State.STANDBY)

    def pose_in(self, frame):
        return pose_in_frame(CONFIG, self.status.pose, frame)

    def preview(self, move):
        self.previews += 1
        return preview_move(self._ground(), CONTROLLER, move, self.hindrance)

    def start(self, move, *, stops=None):
        if isinstance(move, GripperMove | GraspMove):
            return super().start(move, stops=stops)
        self.asked_for.append(move)
        if stops is not None and stops != self.stops:
            raise Stopped("a stop was requested before the motion started")
        return Going(self, prepare(move, self._ground()).plan.end.joints)

    def sleep(self, time_s):
        self.calls.append(("sleep", time_s))

    def pause(self):
        self.calls.append(("pause",))
        self.set(paused=True)

    def resume(self):
        self.calls.append(("resume",))
        self.set(paused=False)

    def _ground(self):
        here = ArmCoordinates(self.status.joints, 0.0)
        return Ground(CONFIG, _speeds(), here, lambda name: self.points[name].joints)


POLLS = 4
"""As many times an app looks before what it found first has led to all that follows."""


async def at_rest(pilot):
    """Have an app look, work out in threads and paint all that it wants to show."""
    app = pilot.app
    for _ in range(POLLS):
        if hasattr(app, "poll"):
            app.poll()
        await pilot.pause()
        await app.workers.wait_for_complete()
        await laid_out(pilot)


async def laid_out(pilot):
    """Wait until nothing waits for the timer by which the framework lays out and paints.

    A screen behind a dialog was at rest when the dialog came, and may keep its marks for good.
    """

    def is_laid_out():
        screen = pilot.app.screen
        return not (screen._layout_required or screen._dirty_widgets)

    await until_seen(is_laid_out, pilot.pause, "the screen was never laid out")


def _speeds():
    return SpeedLimits(
        CONFIG.model.joint_speeds_rad_s,
        CONFIG.model.gripper_speed_mm_s,
        CONTROLLER.usable_rate_hz(1e9),
        CONFIG.model.transmission,
    )


CALL, FAKED = (signature(kind.preview).parameters for kind in (Arm, PlannerArm))
assert {each for each in CALL if each != "joints_deg"} <= FAKED.keys()
