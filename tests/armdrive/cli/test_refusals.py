"""What is typed wrongly: one sentence names the mistake, and the exit code says its kind."""

import shlex

from amounts import every_row

from kinematics.textbook.systems import MODEL_NAMES

BUS = "can:socketcan:can0"
HALF = "write sim:DIALECT, one of teachmover, robko01"
NOT_ON_A_BUS = f"{BUS} is a CAN bus, but a controller that speaks teachmover"

REFUSED = [
    # an unset variable of a shell names no arm, and not the default one
    ("status --arm ''", 2, "the name is empty"),
    ("status --port '' --dialect robko01", 2, "the name is empty"),
    ("doctor ''", 2, "the name is empty"),
    ("config show ''", 2, "the name is empty"),
    # half the name of a simulated arm
    ("watch --port sim: --dialect robko01", 2, HALF),
    ("status --arm sim:", 2, HALF),
    ("config set-default sim:", 2, HALF),
    # words that contradict each other, and arms that have not what is asked of them
    ("status --sim teachmover --port /dev/ttyX", 2, "name one arm"),
    ("status --dialect grbl", 2, "name the port"),  # it would be another arm's
    ("resume --dialect grbl", 2, "name the port"),  # and not every arm
    ("verify --accept --keep", 2, "not allowed with"),
    ("move", 2, "name a goal"),
    ("move --x 250 --shoulder 40", 2, "not two of them"),
    ("move --line --shoulder 40", 2, "--line needs a pose"),
    ("move --via 270,0,120", 2, "name a goal"),
    ("move --y 60 --line --via 270,0,120", 2, "no --line"),
    ("move --y 60 --via 270,0", 2, "write it like"),
    ("move --shoulder 40 --frame tool", 2, "--frame needs a pose"),
    # nothing is opened for what the arm does not have
    ("move --port /dev/nothing --dialect grbl --joint tail=3", 2, "no joint 'tail', but base,"),
    ("move --port /dev/nothing --dialect grbl --z 3 --frame jig", 2, "no frame is called 'jig'"),
    ("move --port /dev/nothing --dialect grbl --x 3 --yaw 5", 2, "cannot take a yaw"),
    ("home --port /dev/nothing --dialect grbl --switches", 2, "no switches"),
    ("home --port /dev/nothing --dialect grbl --declare tail=3", 2, "NAME=DEGREES"),
    ("home --port /dev/nothing --dialect grbl --declare base=3", 2, "every joint needs an angle"),
    ("move --sim cia402 --base 5", 3, "`armdrive home --sim cia402`"),
    ("home --declare base=x", 2, "x"),
    ("home --declare base=0 shoulder=200 elbow=0 wrist_pitch=0 wrist_roll=0", 3, "shoulder"),
    ("points save pick --fresh", 3, "[E203]"),
    ("pendant show --sim mks --json", 3, "keeps no program"),
    ("teach tour.arm", 1, "no program of yours is driving"),
    ("demo --sim grbl", 2, "there is no option --sim"),
    # a desk, and a model with no arm
    ("jog", 2, "needs a terminal"),
    ("jog --model scra.toml", 2, "scra.toml"),
    ("jog --model minimover", 2, "did you mean 'minimover5'", *MODEL_NAMES),
    ("jog --model puma --sim teachmover", 2, "--model has no arm"),
    ("jog --model puma --setup", 2, "a model has no set-up"),
    ("jog --model puma", 2, "armdrive explain"),  # works without a terminal
    # mathematics
    ("fk 0 0 0 0 0 --model teachmoover", 2, "did you mean 'teachmover'"),
    ("fk 1 2", 2, "are required (base, shoulder, elbow, wrist pitch, wrist roll), not 2"),
    ("plot nope", 2, "'nope' is one argument too many"),
    ("fk --model puma 1 2", 2, "6 joint values are required"),
    ("fk --model pumo 1", 2, "did you mean 'puma'"),
    ("ik --x 1 --y 2 --z 3", 2, "--pitch is needed"),
    ("ik --model x.toml --x 1 --y 2 --z 3", 2, "cannot be read"),
    ("ik --x 250 --y 0 --z 100 --pitch -60 --yaw 5", 2, "six joints"),
    ("plot --model puma --pitch 0", 2, "other arms are drawn whole"),
    ("plot --output reach.jpg", 2, "should end in .png or .svg"),
    ("explain pumo", 2, "did you mean 'puma'"),
    ("explain two-link-1 30", 2, "2 joint values are required (theta1, theta2), not 1"),
    ("explain two-link-1 30 far", 2, "'far' is not a number"),
    ("explain minimover5 --goal 1 2", 2, "pitch_deg, roll_deg, not 2 numbers"),
    ("explain minimover5 --goal 900 0 120 -90 0", 3, "pitch -90°", "only to 544.66 mm from it"),
    ("explain nowhere.toml", 2, "nowhere.toml cannot be read"),
    ("explain puma --symbolic --goal 1", 2, "--goal goes with a worked example, not"),
    ("explain --goal 1", 2, "--goal needs a system or a model file"),
    ("explain puma --urdf --goal 1", 2, "not with --urdf"),
    ("explain efficiency --goal 1", 2, "not with efficiency"),
    ("explain --latex", 2, "--latex needs a system"),
    ("explain --list puma", 2, "puma goes with"),
    ("explain accuracy teachmover 1", 2, "5 joint values"),
    ("explain accuracy alpha2", 3, "motor steps of the Microbot Alpha II are not known"),
    ("explain --axes puma 10", 2, "a joint's value goes with a worked example or efficiency or"),
    ("explain --axes", 2, "--axes needs a system or a model file"),
    ("explain --axes efficiency", 2, "--axes needs a system or a model file, not efficiency"),
    ("explain --axes puma --symbolic", 2, "not allowed with argument --axes"),
    ("explain puma --convention craig", 2, "--convention goes with --axes, not"),
    ("explain --axes puma --convention paul", 2, "invalid choice: 'paul'"),
    # programs, and setting up
    ("run none.arm", 2, "cannot be read"),
    ("run none.txt", 2, "is no"),
    ("doctor", 2, "armdrive ports"),
    ("doctor /dev/ttyX --arm bench", 2, "name one port"),
    ("doctor --arm bench --dialect teachmover", 2, "name each only once"),
    ("doctor /dev/ttyX --fix", 2, "--fix needs"),
    ("doctor /dev/ttyX --ids 1-6", 2, "are about a CAN bus"),
    ("doctor --arm sim:teachmover", 2, "is simulated"),
    ("doctor /dev/ttyX --can socketcan:can0", 2, "name each only once"),
    (f"doctor --yes --can {BUS} --dialect teachmover", 4, NOT_ON_A_BUS),
    (f"status --port {BUS} --dialect teachmover", 4, NOT_ON_A_BUS),
    ("can monitor", 2, "name one bus"),
    ("can monitor /dev/ttyUSB0", 2, "no CAN bus"),
    ("can monitor can:nothing:0", 4, "python-can has no interface"),
    ("can monitor can:virtual:x --id x", 2, "an id is a number"),
    ("can setup bench", 3, "run this in a terminal, or give --sim"),
    ("can setup bench --yes", 3, "plug real drives in"),
    (f"can setup bench --sim --yes --port {BUS}", 2, "--sim needs no --port"),
    ("can setup ../x --sim --yes", 2, "cannot name a file"),
    ("config new bench --yes", 2, "'Which template does it begin from?' has no default",
     "--template"),
    ("config new bench --yes --template own", 2, "the answer 'links.file' into the file of --ans"),
]  # fmt: skip


@every_row("row", REFUSED, ids=lambda row: row[0])
def test_a_wrong_line_is_refused_in_one_sentence(call, row):
    typed, code, *said = row
    sentence = call.refused(*shlex.split(typed), code=code)
    assert [words for words in said if words not in sentence] == []
