"""E6: what the kinematics refuse. None of these has sent anything to an arm."""

from __future__ import annotations

from armdrive.catalogue.entry import NO_ARM, NOTHING_SENT, Entry

MATHEMATICS = (
    Entry(
        "E601", "KinematicsError", "the mathematics refuse",
        "What the sentence says.",
        NOTHING_SENT,
        "Correct what the sentence names.",
    ),
    Entry(
        "E602", "BadNumber", "not a finite number",
        "Text, nothing, NaN or an infinity stands where a length or an angle belongs.",
        NOTHING_SENT,
        "Give a number.",
    ),
    Entry(
        "E603", "JointLimit", "a joint beyond its limit",
        "An angle is outside the range that the arm file gives its joint.",
        NOTHING_SENT,
        "Choose an angle inside; the sentence says by how much it is too far.",
    ),
    Entry(
        "E604", "Unreachable", "out of reach",
        "No posture within the joint limits brings the tip to that pose.",
        NOTHING_SENT,
        "Take the nearest pose, which the sentence names, or another pitch.",
    ),
    Entry(
        "E605", "PathBroken", "a line, an arc or a route that cannot be followed",
        "On its way it leaves the reach, or the arm would have to change its posture.",
        NOTHING_SENT,
        "Use a joint motion, or a way that keeps clear of the point that the sentence names.",
    ),
    Entry(
        "E606", "SingularTransmission", "motors that do not tell the joints apart",
        "Steps per turn or couplings of the arm file make two motors say the same.",
        NO_ARM,
        "Correct the motor that the sentence names in the arm file.",
    ),
    Entry(
        "E607", "UnknownPreset", "no such preset arm",
        "No preset has that key.",
        NO_ARM,
        "Take the nearest, which the sentence names.",
    ),
    Entry(
        "E608", "UnknownSystem", "no such system of the textbook",
        "No worked system has that name.",
        NO_ARM,
        "Take one of those that the sentence lists.",
    ),
    Entry(
        "E609", "OutOfReach", "a textbook goal out of reach",
        "No posture of the named system meets the goal.",
        NO_ARM,
        "Take the goal that the sentence names instead.",
    ),
    Entry(
        "E610", "ZeroVector", "a vector without direction",
        "The zero vector was given where a direction is needed.",
        NO_ARM,
        "Give a vector with some length.",
    ),
    Entry(
        "E611", "FlatBasis", "three axes in one plane",
        "The three vectors span no space.",
        NO_ARM,
        "Give three independent vectors.",
    ),
    Entry(
        "E612", "NotARotation", "a matrix that is no rotation",
        "Its columns are not of length 1, not normal to each other, or left-handed.",
        NO_ARM,
        "Correct the matrix, or take the nearest rotation where only rounding spoiled it.",
    ),
    Entry(
        "E613", "NoNearestRotation", "no rotation is the nearest",
        "The matrix is a mirror image, or flat in two directions or more.",
        NO_ARM,
        "Correct the matrix.",
    ),
    Entry(
        "E614", "NotAUnitQuaternion", "a quaternion that is no rotation",
        "Its length is not 1.",
        NO_ARM,
        "Scale it to length 1.",
    ),
    Entry(
        "E615", "UnknownFrame", "no such frame",
        "No frame of the graph has that name.",
        NO_ARM,
        "Take one of those that the sentence lists.",
    ),
    Entry(
        "E616", "FramesNotConnected", "frames that nothing joins",
        "No chain of known transforms leads from one frame to the other.",
        NO_ARM,
        "Add a relation between the two groups.",
    ),
    Entry(
        "E617", "FramesDisagree", "frames that contradict one another",
        "Two ways between the same frames give different transforms.",
        NO_ARM,
        "Correct one of them, or widen the tolerances where they were measured.",
    ),
    Entry(
        "E618", "NoArc", "no arc leads through these points",
        "Two of the three points are the same one, or all of them lie in a line.",
        NOTHING_SENT,
        "Use a straight line, or choose a via point well beside the line from start to goal.",
    ),
)  # fmt: skip
