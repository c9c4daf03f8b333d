"""Files with random edits: every parser returns a value, or raises an error of its own kind."""

import json

import pytest
from amounts import every_row
from hostile import unprintable
from hypothesis import example, given
from hypothesis import strategies as st

from armdrive.config.link_model import parse_model
from armdrive.dialects.teachmover.pendant import PendantProgram
from armdrive.errors import ArmError, ArmFileError
from armdrive.errors.printable import printable
from armdrive.programs.program import read_program
from armdrive.registry.arm_files import parse_arm
from armdrive.storage.points import parse_points
from armdrive.text.reading import parse_toml
from armdrive.trace.files import parse_recording
from armdrive.trace.replay import config_of
from kinematics.errors import KinematicsError

ARM = """\
model = "teachmover"
title = "bench"
[connection]
dialect = "grbl"
port = "/dev/ttyUSB0"
[motion]
ramp_s = 0.2
[limits_deg]
base = [-90, 90.5]
[gripper]
kind = "servo"
[frames.table]
x_mm = 10
"""
MODEL = """\
name = "two"
convention = "craig"
[base]
x_mm = 1.5
[[links]]
a_mm = 10
alpha_deg = 90
[[links]]
d_mm = 1e1
low_deg = -10
"""
POINTS = """\
[points.above]
joints_deg = { base = 0, shoulder = 0, elbow = 0, wrist_pitch = 0, wrist_roll = 0 }
taught = 2026-11-22T10:30:00
gripper_mm = 40
note = "over the block"
"""
PROGRAM = """\
define fetch(p)
  move p
  if input(1) then goto out
  out: ready
end
point place = joints(base 0, shoulder 0, elbow 0, wrist_pitch 0, wrist_roll 0)
repeat 3 as i
  x = (i * 2 + 1) / 3
  type "x", x
end
while not 2 = 1 or true
  delay 1
end
fetch(place)
"""
AXES = """\
convention = "craig"
[[axes]]
point_mm = [0, 0, 0]
direction = [0, 0, 1]
low_deg = -90
[[axes]]
joint = "slide"
kind = "prismatic"
point_mm = [100, 0, 1e-7]
direction = [0, 1e-8, 1]
high_mm = 50.0
[tip]
point_mm = [150, 20, 0]
approach = [0, 1, 0]
normal = [1, 0, 0]
"""
PENDANT = """\
armdrive pendant program 1
origin 0 0 0 0 0 0
"""
HEADER = {
    "armdrive_recording": 1, "version": "0", "why": "", "arm": "x", "title": "",
    "dialect": "grbl", "link": "", "calibration": "", "began": "", "began_s": 0.0,
    "arm_file": ARM, "model_file": "",
}  # fmt: skip
ENTRIES = [{"t": 0.0, "kind": "state", "text": "standby"}, {"t": 1.5, "kind": "sent", "bytes": "?"}]
RECORDING = "".join(f"{json.dumps(each)}\n" for each in (HEADER, *ENTRIES))
JOINTS = ("base", "shoulder", "elbow", "wrist_pitch", "wrist_roll")


def recording(text):
    return parse_recording(text.encode("utf-8", "surrogatepass"))


PARSERS = {
    "arm": (ARM, lambda text: parse_arm(parse_toml(text, ArmFileError), name="x")),
    "model": (MODEL, lambda text: parse_model(parse_toml(text, ArmFileError))),
    "axes": (AXES, lambda text: parse_model(parse_toml(text, ArmFileError))),
    "points": (POINTS, lambda text: parse_points(text, JOINTS)),
    "program": (PROGRAM, read_program),
    "pendant": (PENDANT, PendantProgram.parse),
    "recording": (RECORDING, recording),
    "arm of a recording": (RECORDING, lambda text: config_of(recording(text))),
}
PIECES = st.sampled_from([
    "[", "]", "{", "}", "(", ")", ".", ",", "=", '"', "'", '"""', "#", "\n", "\r", "\0", "\x1b",
    " ", "-", "+", "*", "/", "%", "e", "nan", "inf", "-inf", "1e308", "5e-324", "0x7f", "9" * 400,
    "true", "not ", "goto 1", "end\n", "repeat 2\n", "else\n", "[[links]]\n", "\u0663", "\uff11",
    "\u202e", "\u2028", "\x85", "\\u0000", "null", "{}", "[]", "1:", "x", "x = x", "joints(",
])  # fmt: skip
EDITS = st.lists(
    st.tuples(st.floats(0, 1), st.integers(0, 12), st.one_of(PIECES, st.text(max_size=4))),
    min_size=1,
    max_size=6,
)


def edited(text, edits):
    """Return a text with pieces of it replaced: where, how much of it, and by what."""
    for share, length, new in edits:
        at = int(share * len(text))
        text = text[:at] + new + text[at + length :]
    return text


@every_row("name", PARSERS)
def test_an_edited_file_was_readable_before(name):
    text, parse = PARSERS[name]
    parse(text)


@pytest.mark.parametrize("name", PARSERS)
@given(edits=EDITS)
@example(edits=[(0.0, 0, "[" * 50_000)])
@example(edits=[(0.5, 0, "9" * 6_000)])
@example(edits=[(0.3, 3, "-" * 50_000 + "1")])
@example(edits=[(0.3, 3, "(" * 50_000 + "1" + ")" * 50_000)])
def test_a_parser_returns_a_value_or_raises_an_error_of_ours(name, edits):
    text, parse = PARSERS[name]
    told = "read"
    try:
        parse(edited(text, edits))
    except ArmError as error:
        told = str(error)
    except KinematicsError as error:  # of the arm that is described; its reader names the file
        told = printable(str(error))
    assert told
    assert not unprintable(told)
