"""One planned motion asked for at a screen: seen first, confirmed twice, and stopped with all.

At each poll `PlannedMove.follow` compares what a preview depends on (`Seen`: goal, motor steps,
state, trust) with what it was computed from. If something differs, it computes another one in a
thread, one at a time, and takes a first press back. So two presses always confirm the motion that
is on the screen, and `_go` moves nothing if it has changed since.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

from armdrive.errors import BadRequest
from armdrive.motion.preview import (
    PostureOption,
    Preview,
    clearance_words,
    duration_words,
    margin_words,
)
from armdrive.moves import TOOL_FRAME, Motion
from armdrive.render.scene import Moment
from armdrive.status import IN_MOTION, State, Status
from tui.app import Job
from tui.desk import Desk
from tui.keys.keyboard import Keyboard, short_label
from tui.keys.table import PAUSE, STOP
from tui.move.form import GoalForm
from tui.safety import bound_text

# The effect of the second press of a key.
MOVES = "MOVES THE ARM"

# What the key of a refused motion says, whose panel has the reason.
REFUSED = "nothing moves: the motion is refused, for the reason shown"

NOTHING_ASKED = "type into a field, or step it with the arrows"
# Characters of the bar that shows progress.
BAR = 24


def way_text(form: GoalForm, keys: Keyboard) -> str:
    """Say how the goal is typed and reached, each with its key: mode, way, frame, speed, step."""
    row = keys.label
    if form.cartesian:
        change = " (a change)" if form.frame == TOOL_FRAME else ""
        first = f"{row('mode')}: POSE   {row('line')}: {form.settings.way}"
        first += f"   {row('frame')}: frame {form.frame}{change}"
    else:
        first = f"{row('mode')}: JOINTS   joint motion"
    speed, step = (short_label(keys.row(name)) for name in ("go-speed", "step"))
    return f"{first}\n{speed}: speed {form.settings.speed:.0%}   {step}: step {form.step:g}"


def preview_text(preview: Preview, *, told: bool) -> str:
    """Say what the motion would be, or why it is refused.

    `told` means that the safety panel says why the arm cannot move now.
    """
    return "\n".join(_preview_lines(preview, told=told))


def choices_text(preview: Preview, keys: Keyboard) -> str:
    """Say what is possible instead of a refused motion, and the postures at the goal."""
    lines = []
    if preview.nearest is not None:
        lines += [f"{keys.label('move-nearest')}: possible instead:"]
        lines += [f"  {preview.nearest.pose}"]
    lines += [_way_line(way, preview.problem) for way in preview.ways]
    if any(other_ways(preview)):
        lines += [f"  {keys.label('move-posture')}: another allowed one"]
    return "\n".join(lines)


def _preview_lines(preview: Preview, *, told: bool) -> Iterator[str]:
    for refusal in (None if told else preview.hindrance, preview.problem):
        if refusal is not None:
            yield f"REFUSED: {_reason(refusal)}"
    if preview.plan is None:
        return
    yield duration_words(preview)
    if preview.stop_time_s:
        yield f"a stop takes up to {bound_text(preview.stop_distance_mm, preview.stop_time_s)}"
    if preview.margin is not None:
        yield margin_words(preview.margin)
    table = [each for each in preview.clearances if each.guard == "table"]
    others = [each for each in preview.clearances if each.guard != "table"]
    yield from (clearance_words(preview, each) for each in (*table, *others[:1]))
    if preview.plan.note:
        yield preview.plan.note


def other_ways(preview: Preview | None) -> list[PostureOption]:
    """Return the allowed postures at the goal that the motion does not take."""
    return [way for way in (preview.ways if preview else ()) if way.allowed and not way.taken]


def _way_line(way: PostureOption, problem: Exception | None) -> str:
    sign = "*" if way.taken else "-"
    name = way.name or "nearest posture found"
    if way.against and problem is not None and _reason(problem).startswith(way.against):
        return f"{sign} {name}: refused as above"
    return f"{sign} {name}: {'taken' if way.taken else way.against.split(';')[0]}"


def _reason(refusal: Exception) -> str:
    """Return why a motion is refused: the goal, and what is possible, have their own lines."""
    reason = str(getattr(refusal, "reason", refusal))
    return reason.split("; nearest pose")[0].removesuffix("; nothing was moved")


def ready_text(preview: Preview | None, key: str) -> str:
    """Say by which key the motion is begun; nothing where it would be refused."""
    if preview is None or preview.refusal is not None:
        return ""
    return f"{key} twice moves the arm like this"


def going_text(keys: Keyboard, *, paused: bool) -> str:
    """Say which keys pause or resume a motion under way, and stop it."""
    pause, stop = keys.label(PAUSE), keys.label(STOP)
    return f"{f'PAUSED: {pause} resumes' if paused else f'UNDER WAY: {pause} pauses'}, {stop} stops"


def progress_bar(share: float) -> str:
    """Return a share of 1 as a bar and a number."""
    full = round(share * BAR)
    return f"[{'#' * full}{'-' * (BAR - full)}] {share:.0%}"


def arrived(status: Status) -> str:
    """Say where the arm is."""
    return "arrived" if status.pose is None else f"arrived: {status.pose}"


# Returns what is asked for now; None where nothing is.
Goal = Callable[[], Motion | None]

# The inputs of a preview, which is valid as long as none of them has changed.
Seen = tuple[Motion | None, Any, State, str]


class PlannedMove:
    """Moves the arm to the goal of a screen: as it was shown, and confirmed by two presses."""

    def __init__(self, desk: Desk, goal: Goal) -> None:
        self.preview: Preview | None = None
        """The preview of the goal, as soon as it is computed."""
        self.previewing = Job()
        """The work on a preview."""
        self.going = Job()
        """The motion of the arm to the goal."""
        self._desk = desk
        self._goal = goal
        self._seen: Seen | None = None

    def follow(self, status: Status) -> Preview | None:
        """Work out what has changed; return the preview of the present goal and place, if any."""
        self._foresee(status)
        return self.preview if self._fresh(status) else None

    def moment(self, status: Status, fresh: Preview | None) -> Moment:
        """Return the arm as it stands, with the ghost of where it goes or would go."""
        shown = self.preview if self.going.busy else fresh
        return Moment(
            status.joints,
            status.gripper_mm,
            goal=shown.end if shown else None,
            planned=shown.path if shown else (),
        )

    def text(self, status: Status, fresh: Preview | None) -> str:
        """Say how the motion is begun, confirmed or stopped."""
        keys = self._desk.keys
        if self.going.busy:
            return going_text(keys, paused=status.paused)
        return self._desk.confirmation.again or ready_text(fresh, keys.label("go"))

    # -- the preview --------------------------------------------------------------------------

    def _asked(self, status: Status) -> Seen:
        return self._goal(), status.acknowledged, status.state, status.trust.value

    def _fresh(self, status: Status) -> bool:
        return self._seen == self._asked(status) and not self.previewing.busy

    def _foresee(self, status: Status) -> None:
        """Compute a preview if something has changed, one at a time, and not in motion."""
        asked = self._asked(status)
        if self.previewing.busy or self.going.busy or asked == self._seen:
            return
        if status.state in IN_MOTION:
            return
        self._desk.confirmation.forget(MOVES)
        if asked[0] is None:
            self._seen, self.preview = asked, None
            return
        work = partial(self._desk.arm.preview, asked[0])
        self.previewing = self._desk.calls.work_out(work, partial(self._keep, asked))

    def _keep(self, asked: Seen, preview: Preview | None) -> None:
        self._seen, self.preview = asked, preview

    # -- going --------------------------------------------------------------------------------

    def press(self) -> None:
        """Take one press of the two that move the arm."""
        desk = self._desk
        if self.going.busy:
            raise BadRequest(f"the arm is on its way: {desk.keys.label(STOP)} stops it")
        if self.preview is None or not self._fresh(desk.link.status):
            desk.confirmation.refuse()
            raise BadRequest(
                "there is nothing to confirm yet: choose a goal, and look at the motion first"
            )
        if self.preview.refusal is not None:
            desk.confirmation.refuse()
            raise BadRequest(REFUSED)
        desk.confirmation.press(MOVES, self._go, row="go")

    def _go(self) -> None:
        """Move as it is shown, unless what is shown is no longer so."""
        preview, desk = self.preview, self._desk
        ask = self._seen[0] if self._seen is not None else None
        if preview is None or ask is None or not self._fresh(desk.link.status):
            raise BadRequest("the motion has changed: look at it, and confirm again")
        # the count is taken here: a stop while the thread starts lets the motion not begin
        self.going = desk.calls.make(partial(self._carry_out, ask, desk.arm.stops))

    def _carry_out(self, ask: Motion, stops: int) -> str:
        self._desk.arm.start(ask, stops=stops).wait()
        return arrived(self._desk.arm.status)
