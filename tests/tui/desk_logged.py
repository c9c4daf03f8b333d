"""An arm that has a flight recorder's memory into which a test puts what has passed."""

from pathlib import Path

from desk_fake import FakeArm

from armdrive.errors import StateFileError
from armdrive.trace.entries import EntryKind, EntryRing, TraceEntry
from armdrive.trace.log import LogReader


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
