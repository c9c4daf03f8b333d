"""Track the questions and orders sent to one drive, and the replies it still owes. Seconds.

    Ledger   the open questions and orders: when to ask again, who is mute
    Absence  whether the drive had no power for a moment

A reply does not name the question it answers, and one may be late or lost. A drive that leaves
replies out for long may have had no power.
"""

from __future__ import annotations

import math

from armdrive.dialects.bus.questions import EPSILON_S, MUTE_POLLS, Questions

# While other drives reply, a silent drive is asked again this often, or as slowly as it replies.
# Frequent retries tell a few lost frames from a drive without power. Frames sent closer together
# count as one question.
RETRY_PERIOD_S = 0.01
# Once a drive replies again, replies that are later than this will not come, as long as the other
# drives reply in time.
REPLY_GRACE_S = 0.12
# Unanswered questions that are closer together than this count as one.
POLL_SPACING_S = 0.1


class Absence:
    """Whether one drive was without power for a moment, by the replies that it owes. Seconds.

    A drive that loses its supply for a tenth of a second counts from zero again and obeys the next
    order from there. If it stood near zero, its count reveals nothing. But it never answers what it
    was sent meanwhile, whereas a drive on a busy computer or a slow adapter answers everything,
    late. So a drive that leaves out replies is suspected, and was away if most of them never come:

        present -- left out replies --> suspected -- answered all of them --> present
                                        suspected -- time is over, owes more than half --> away
        away -- its count shows that it kept its power --> present

    On a link that has become slow, a drive always owes its latest replies. But it has answered what
    it left out at first, and a drive that was away never does, whatever it is asked later.
    """

    def __init__(self) -> None:
        self.since_s = math.inf
        """Since when the drive was away; infinity if nothing suggests that."""
        self.suspected_s = math.inf
        """Since when it may have been away; infinity if it has answered everything since."""
        self._ends_s = -math.inf
        """When the time for the replies is over."""
        self._owed = self._owed_before = 0
        """How many replies it owes now, and did before the first frame that is still open."""
        self._excused = 0
        """How many it owed before it was suspected: they are of earlier losses."""
        self._left_out = self._lost = 0
        """How many it had left out when it was suspected, and of these has lost at most."""

    @property
    def suspected(self) -> bool:
        """Whether the drive may have been away and may still send the replies it owes."""
        return math.isfinite(self.suspected_s)

    def opened(self) -> None:
        """Record that the drive has left out none of the frames that follow."""
        self._owed_before = self._owed

    def owe(self) -> None:
        """Record a frame that has exactly one reply, however late."""
        self._owed += 1

    def settle(self) -> None:
        """Record such a reply."""
        self._owed -= 1

    def suspect(self, since_s: float, until_s: float) -> None:
        """Suspect that the drive was away, unless all owed replies come by `until_s`.

        They get more time if the bus fails again meanwhile.
        """
        if not self.suspected:
            self.suspected_s, self._excused = since_s, self._owed_before
            self._ends_s = until_s
        self._left_out = self._lost = self._owed - self._excused
        self._ends_s = max(self._ends_s, until_s)

    def weigh(self) -> None:
        """Drop the suspicion if the drive has answered everything: it had power throughout."""
        self._lost = min(self._lost, self._owed - self._excused)
        if self.suspected and self._lost <= 0:
            self.suspected_s = math.inf

    def conclude(self, now_s: float) -> None:
        """Conclude that the drive was away if most of the owed replies are overdue."""
        if self.suspected and now_s >= self._ends_s:
            if self._lost > self._left_out // 2:
                self.since_s = min(self.since_s, self.suspected_s)
            self.suspected_s = math.inf

    def acquit(self) -> None:
        """Drop the conclusion that the drive was away: its count shows that it kept its power."""
        self.since_s = math.inf

    def forget(self) -> None:
        """Drop suspicion and conclusion."""
        self.since_s = self.suspected_s = math.inf


class Ledger(Questions):
    """The open questions to one drive, and the frames that it leaves unanswered."""

    def __init__(self) -> None:
        super().__init__()
        self.answers_orders = False
        """Whether the drive confirms orders. Its settings may switch that off."""
        self.unanswered_polls = 0
        """How often its position was asked for since its last reply."""
        self.replied_s = -math.inf
        """When the last reply came."""
        self.sent_s = -math.inf
        """When the last frame that needs a reply was sent."""
        self.open_s = math.inf
        """When the first frame without a reply was sent; infinity if none is open."""
        self.absence = Absence()
        self._polled_s = -math.inf
        self._missed = 0
        self._retried_s = -math.inf
        # whether no drive has replied since the latest frame: then the bus may have lost it
        self._unproven = False

    # -- events -------------------------------------------------------------------------------

    def asked(self, now_s: float) -> None:
        """Record a question about its position."""
        super().asked(now_s)
        if not self.unanswered_polls or now_s >= self._polled_s + POLL_SPACING_S - EPSILON_S:
            self.unanswered_polls, self._polled_s = self.unanswered_polls + 1, now_s

    def sent(self, now_s: float, others_s: float, *, owes: bool) -> None:
        """Record a frame that needs a reply.

        `others_s` is when another drive replied last. A frame that `owes` has exactly one reply,
        however late.
        """
        self.sent_s = now_s
        if math.isinf(self.open_s):
            self.open_s = self._retried_s = now_s
            self.absence.opened()
        elif now_s >= self._retried_s + self._retry_period_s - EPSILON_S:
            # The frame before this one is missed only if another drive has replied since: else the
            # bus itself may be silent.
            if self._unproven and others_s > self._retried_s:
                self._missed += 1  # the reply that came since then proves that the bus carried it
            self._unproven = others_s <= self.open_s
            self._missed += not self._unproven
            self._retried_s = now_s
        if owes:
            self.absence.owe()

    def replied(self, now_s: float, *, settles: bool, asked: bool = True) -> None:
        """Record a frame from the drive; one that `settles` is one of the replies it owes.

        A frame that was not `asked` for, such as the end of a motion, proves that the drive has
        power, but not that it receives anything: what was sent to it stays unanswered.
        """
        if settles:
            self.absence.settle()
        if self.silent:
            self.suspect(now_s + REPLY_GRACE_S)
        self.absence.weigh()
        if asked:
            self._missed, self._unproven, self.open_s = 0, False, math.inf
            self.replied_s, self.unanswered_polls = now_s, 0

    def suspect(self, until_s: float) -> None:
        """Suspect that the drive was away since the first frame that is still open."""
        self.absence.suspect(self.open_s, until_s)

    def forget(self) -> None:
        """Drop all suspicions and wait for no reply."""
        super().forget()
        self.absence.forget()
        self.open_s = math.inf
        self._missed, self._unproven = 0, False
        self.unanswered_polls = 0

    # -- conclusions --------------------------------------------------------------------------

    def retry_s(self, others_s: float) -> float:
        """Return when to ask again, given another drive's last reply; infinity for never."""
        return self._retried_s + self._retry_period_s if others_s > self.open_s else math.inf

    @property
    def silent(self) -> bool:
        """Whether the drive leaves everything unanswered while another one replies."""
        return self._missed >= MUTE_POLLS

    @property
    def _retry_period_s(self) -> float:
        return max(RETRY_PERIOD_S, self.longest_wait_s)
