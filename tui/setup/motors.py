"""The stage that turns each motor a little, and asks what was seen."""

from __future__ import annotations

from functools import partial

from armdrive.errors import ArmError, BadRequest
from armdrive.render.scene import Moment
from armdrive.setup.arm_checks import before_trials
from armdrive.setup.directions import TRIAL_SPEED, DirectionCheck, SawMotion, check_of
from armdrive.setup.filing import file_of, propose
from armdrive.status import Trust
from kinematics.text import counted
from tui.app import Job
from tui.desk import Desk
from tui.keys.table import STOP, Needs
from tui.setup.stages import ANSWERS, SKIP, Go, SetupStage, StageText, correction


class MotorsStage(SetupStage):
    """Each motor alone: `t` turns it and brings it back, other keys say what was seen."""

    def __init__(self, desk: Desk, go: Go, before: SetupStage) -> None:
        super().__init__(desk, go, before)
        status = desk.link.status
        known = status.joints if status.trust is Trust.REFERENCED else None
        self.check: DirectionCheck = check_of(desk.arm.config, known)
        self.others: tuple[str, ...] = ()
        self._turning = Job()

    @property
    def idle(self) -> tuple[str, ...]:
        """Rows that do nothing: the answers before a motor has turned, going on after that."""
        if self.check.trial is None or self.others:
            return ("setup-turn", *ANSWERS, SKIP)
        waits = self.check.shown and not self.check.away and not self._turning.busy
        return ("setup-enter", SKIP) if waits else ("setup-enter", *ANSWERS, SKIP)

    def text(self) -> StageText:
        """Name the current motor, the expected motion, and the keys that answer."""
        check = self.check
        trial = check.trial
        if trial is None:
            return StageText("\n".join(self._end()))
        motor = f"Motor {trial.motor + 1}: {trial.name} ({len(check.looks)} checked)\n"
        if self.others and not self._turning.busy:
            asked = "Which motor's part moved instead?"
            return StageText(f"{motor}\n{asked}", self.others, self.marked)
        lines = [motor, self._turns(trial.steps), "", f"Expected: {trial.expected}", ""]
        return StageText("\n".join([*lines, *self._questions()]))

    def _turns(self, steps: int) -> str:
        """Say what the key that turns the motor does now."""
        turn = self.desk.keys.label("setup-turn")
        if self._turning.busy:
            return f"IT TURNS. {self.desk.keys.label(STOP)} stops it"
        if self.check.away:
            return f"{turn}: TURN IT BACK by {counted(steps, 'step')}"
        return f"{turn}: TURN IT by {counted(steps, 'step')}; once more brings it back"

    def _questions(self) -> list[str]:
        check, keys = self.check, self.desk.keys
        if check.away:
            return ["Bring it back, then say what you saw."]
        if not check.shown:
            return [before_trials("as drawn", self.desk.link.status.stop_time_s)]
        if check.asks_hand:
            clockwise = [keys.label(each) for each in ("setup-yes", "setup-reversed")]
            word = check.trial.expected.word("roll") if check.trial is not None else ""
            answers = (f"{clockwise[0]} yes", f"{clockwise[1]} the other way")
            unseen = f"{keys.label('setup-nothing')} not seen"
            asked = f"And the hand turned {word} as you look along it?"
            return [asked, ", ".join((*answers, unseen))]
        words = {row.id: row.tooltip for row in keys.rows if row.id in ANSWERS}
        return [f"{keys.label(each):>3}  {words[each]}" for each in ANSWERS]

    def _end(self) -> list[str]:
        signs = self.check.signs()
        words = (
            ("counts the other way", signs.motors),
            ("reversed as a whole", signs.joints),
            ("moved another motor's part", signs.order),
            ("went too far, or not far enough", signs.farther),
            ("unclear", signs.unclear),
        )
        found = [f"  {what}: {', '.join(names)}" for what, names in words if names]
        enter = self.desk.keys.label("setup-enter")
        return ["Every motor has been checked.", *(found or ["  all moved as shown"]), "",
                f"{enter}: see what the arm file should say"]  # fmt: skip

    def moment(self) -> Moment:
        """Draw the posture, and the motor's turn as a ghost."""
        opening_mm = self.desk.link.status.gripper_mm
        return Moment(self.check.posture, opening_mm, goal=self.check.after)

    def rows(self) -> int:
        """Return how many motors there are to choose from."""
        return len(self.others)

    # -- what was seen ------------------------------------------------------------------------

    def saw(self, what: str) -> None:
        """Take what was seen, by its name, or which way the hand turned where that is asked."""
        if self._turning.busy:
            raise BadRequest("it turns: wait until it stands")
        self.others = ()
        self.check.saw(SawMotion[what])

    def another(self) -> None:
        """Ask which motor's part moved instead."""
        ready = self.check.shown and not self.check.away and not self.check.asks_hand
        if self._turning.busy or not ready:
            raise BadRequest("turn it first and bring it back, then say what was seen")
        self.others, self.marked = self.check.others(), 0

    def enter(self) -> None:
        """Choose the other motor, or show what the file should say."""
        if self.others:
            chosen, self.others = self.others[self.marked], ()
            self.check.saw(SawMotion.ANOTHER, chosen)
        elif self.check.trial is None:
            self._propose()
        else:
            raise BadRequest("say what was seen of this motor first")

    def _propose(self) -> None:
        path = file_of(self.desk.arm.config)
        if path is None:
            raise BadRequest(
                "this arm has no file to write it into, or its file was changed meanwhile: leave, "
                "and connect to an arm file"
            )
        proposal = propose(path, self.check.transmission, self.check.signs())
        self.go(correction(self.before or self, proposal))

    # -- turning ------------------------------------------------------------------------------

    def turn(self) -> None:
        """Turn the motor there, or back, after one press and a pause: a held key is no press."""
        if self._turning.busy:
            self.desk.confirmation.refuse()  # it may still be held when the motor stands
            return
        self._next_steps()  # a refusal need not wait for the pause
        self.desk.confirmation.press(
            "turns it", partial(self._begin, self.desk.arm.stops), needed=1
        )

    def _next_steps(self) -> tuple[int, ...]:
        """Return what the next turn asks of each motor; refuse where none may turn."""
        self.desk.link.require(Needs.MOTORS)
        self.desk.link.require_standing()
        steps = self.check.steps(len(self.check.transmission.motors))
        if not any(steps):
            raise BadRequest("every motor has been checked")
        return steps

    def _begin(self, stops: int) -> None:
        steps = self._next_steps()  # the arm may be elsewhere by now
        self._turning = self.desk.calls.make(partial(self._turn, steps, stops))

    def _turn(self, steps: tuple[int, ...], stops: int) -> None:
        try:
            self.desk.arm.move_motors(*steps, speed=TRIAL_SPEED, stops=stops)
        except ArmError as error:
            raise BadRequest(f"{error}. A motor that was on its way: jog it back") from None
        self.check.turned()

    def forget(self) -> None:
        """Let nothing be half chosen."""
        self.others = ()
