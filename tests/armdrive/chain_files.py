"""Arms of model files for the tests: the one that the docs show, and a six-joint one."""

from faults import sim_arm
from pages import blocks, page

from armdrive.registry.arm_files import load_arm

_SIX_LINKS = ((0.0, 0.0, -90), (149.09, 431.8, 0), (0.0, 0.0, 90), (433.07, 0.0, -90), (0, 0, 90))
_RANGES = ((-160, 160), (-225, 45), (-45, 225), (-110, 170), (-100, 100), (-266, 266))
NAMES = ("waist", "shoulder", "elbow", "forearm", "bend", "flange")


def shown_files():
    """The link table and the arm file of the docs."""
    _, links, arm, *_ = blocks(page("arm-file"), "toml")
    return links, arm


def shown_links():
    """The model file with everything in it of the docs."""
    return blocks(page("arm-file"), "toml")[3]


def five_joints(folder):
    links, arm = shown_files()
    (folder / "minilinks.toml").write_text(links, encoding="utf-8")
    return written(folder, arm)


def six_links(base_height=660.0):
    rows = [*_SIX_LINKS, (56.25, 0.0, 0)]
    table = f'name = "puma"\ntitle = "Puma on six motors"\n[base]\nz_mm = {base_height}\n'
    for name, (d, a, alpha), (low, high) in zip(NAMES, rows, _RANGES, strict=True):
        table += f'[[links]]\njoint = "{name}"\nd_mm = {d}\na_mm = {a}\nalpha_deg = {alpha}\n'
        table += f"low_deg = {low}\nhigh_deg = {high}\n"
    return table


def six_arm():
    table = 'model = "six.toml"\n[speeds_deg_s]\n'
    table += "".join(f"{name} = 30\n" for name in NAMES)
    for name in NAMES:
        table += f'[[motors]]\nname = "{name}"\nsteps_per_turn = 14400\nsees = {{ {name} = 1 }}\n'
    return table


def six_joints(folder, extra=""):
    (folder / "six.toml").write_text(six_links(), encoding="utf-8")
    return written(folder, six_arm() + extra)


def written(folder, text):
    path = folder / "bench.toml"
    path.write_text(text, encoding="utf-8")
    return load_arm(path)


def connected(config, **options):
    return sim_arm(config, **options)
