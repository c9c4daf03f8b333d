"""Write a word on a sheet of paper with a pen, in letters of straight strokes.

Runs unattended on the simulated arm, and on an arm of yours by its name:

    armdrive run lettering.py HELLO --arm NAME --check        on a simulated arm first
    armdrive run lettering.py HELLO --arm NAME

Hold a pen in the fingers, point down, and say in the arm file how far it stands out of them
(`[tool]`, `along_mm`). Then every pose is that of its point: take the reference with the pen's
point on the mark (`armdrive home`), on the sheet of paper if it is a thick one.

    the paper       x from 220 to 270, y from 90 to -90, mm from the arm's base; it is read by
                    somebody who stands behind the arm
"""

import sys

from armdrive import Arm, LinePart, Pose, Trust

WORD = "ARM"
FOOT_MM = 230.0  # x of the letters' feet
LEFT_MM = 80.0  # y of the first letter's left edge
SQUARE_MM = 5.0  # letters are drawn on squares: 4 wide, 6 high, and 2 between two letters
PAPER_MM = 0.0  # its height above the reference mark
UP_MM = 10.0  # the pen is lifted so far between strokes
SPEED = 0.5

LETTERS = {  # strokes, each from corner to corner: squares from the left, squares from the foot
    "A": ("00 26 40", "13 33"),
    "B": ("00 06 36 45 44 33 03", "33 42 41 30 00"),
    "C": ("45 36 16 05 01 10 30 41",),
    "D": ("00 06 26 44 42 20 00",),
    "E": ("40 00 06 46", "03 33"),
    "F": ("00 06 46", "03 33"),
    "G": ("45 36 16 05 01 10 30 41 43 23",),
    "H": ("00 06", "03 43", "40 46"),
    "I": ("20 26",),
    "J": ("01 10 30 41 46",),
    "K": ("00 06", "46 03 40"),
    "L": ("06 00 40",),
    "M": ("00 06 23 46 40",),
    "N": ("00 06 40 46",),
    "O": ("01 05 16 36 45 41 30 10 01",),
    "P": ("00 06 36 45 44 33 03",),
    "Q": ("01 05 16 36 45 41 30 10 01", "22 40"),
    "R": ("00 06 36 45 44 33 03", "23 40"),
    "S": ("01 10 30 41 42 33 13 04 05 16 36 45",),
    "T": ("06 46", "26 20"),
    "U": ("06 01 10 30 41 46",),
    "V": ("06 20 46",),
    "W": ("06 10 23 30 46",),
    "X": ("00 46", "06 40"),
    "Y": ("06 23 46", "23 20"),
    "Z": ("06 46 00 40",),
    " ": (),
}


def strokes_of(word: str) -> list[list[Pose]]:
    """Return the strokes of a word, each the poses of its corners on the paper."""
    strokes = []
    for place, letter in enumerate(word):
        for stroke in LETTERS[letter]:
            corners = [(6 * place + int(at[0]), int(at[1])) for at in stroke.split()]
            strokes.append([on_paper(right, up) for right, up in corners])
    return strokes


def on_paper(right: int, up: int, above_mm: float = 0.0) -> Pose:
    """Return the pose with the pen's point on a corner of the squares, or straight above it."""
    return Pose.of(
        x_mm=FOOT_MM + up * SQUARE_MM,
        y_mm=LEFT_MM - right * SQUARE_MM,
        z_mm=PAPER_MM + above_mm,
        pitch_deg=-90,
    )


def lifted(pose: Pose) -> Pose:
    """Return the pose with the pen's point above the paper."""
    return Pose(pose.x_mm, pose.y_mm, PAPER_MM + UP_MM, pose.pitch_rad, pose.roll_rad)


word = (" ".join(sys.argv[1:]) or WORD).upper()
if not set(word) <= set(LETTERS):
    sys.exit(f"there are letters from A to Z alone, so that this cannot be written: {word}")

with Arm.connect() as arm:
    if arm.status.trust is Trust.UNKNOWN:
        arm.home()  # the simulated arm has a simulated operator
    arm.park()  # off the mark, and clear of the paper
    arm.move_to(on_paper(0, 0, above_mm=UP_MM))
    for stroke in strokes_of(word):
        first, last = stroke[0], stroke[-1]
        way = [lifted(first), *stroke, lifted(last)]
        arm.move_path([LinePart(pose) for pose in way], speed=SPEED)
    arm.park()
    print(f"wrote {word}, {6 * SQUARE_MM:g} mm high")
