"""The link table of a printed six-axis arm: what the common printed arms with NEMA motors have.

A starting template. The numbers are those that public programs give for the AR3 and AR4 (modified
link table: 169.77, 64.2, 305, 222.63, 36.25 mm); every printed arm has its own, and the
interview asks for each.
"""

from __future__ import annotations

from armdrive.interview.link_tables import Joint, Length, LinkTable

PRINTED_SIX = LinkTable(
    convention="craig",
    source="template: the link table that public programs give for the AR3 and AR4; not yours",
    lengths=(
        Length("shoulder_height", 169.77, "from the table up to the shoulder's axis"),
        Length("shoulder_offset", 64.2, "from the base axis forward to the shoulder's axis"),
        Length("upper_arm", 305.0, "from the shoulder's axis to the elbow's axis"),
        Length("forearm", 222.63, "from the elbow's axis to the axis of the wrist's pitch"),
        Length("flange", 36.25, "from the axis of the wrist's pitch to the flange"),
        Length("tool", 70.0, "from the flange to the tips of the fingers"),
    ),
    joints=(
        Joint("base", (-170.0, 170.0), 20.0, "10:1", d="shoulder_height"),
        Joint(
            "shoulder", (-42.0, 90.0), 15.0, "50:1", a="shoulder_offset", alpha_deg=-90.0,
            offset_deg=-90.0, sees=-1,
        ),
        Joint("elbow", (-89.0, 52.0), 15.0, "50:1", a="upper_arm", sees=-1),
        Joint("forearm_roll", (-165.0, 165.0), 30.0, "16:1", d="forearm", alpha_deg=-90.0),
        Joint("wrist_pitch", (-105.0, 105.0), 30.0, "10:1", alpha_deg=90.0),
        Joint("wrist_roll", (-155.0, 155.0), 40.0, "20:1", d="flange", alpha_deg=-90.0),
    ),
    tool="tool",
)  # fmt: skip
