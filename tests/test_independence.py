"""No test depends on the speed of the computer: none reads the wall clock, sleeps or sets a timer.

What has to be waited for is waited for by `waiting.py`, until it is seen. This page finds whoever
does otherwise, by the syntax of every file under `tests/`.
"""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from amounts import every_row

TESTS = Path(__file__).parent

CLOCKS = frozenset(
    {
        "time.sleep", "time.time", "time.time_ns", "time.monotonic", "time.monotonic_ns",
        "time.perf_counter", "time.perf_counter_ns", "time.process_time", "time.thread_time",
        "datetime.now", "datetime.utcnow", "datetime.today", "date.today",
        "datetime.datetime.now", "datetime.datetime.utcnow", "datetime.date.today",
        "asyncio.sleep", "asyncio.timeout", "asyncio.wait_for",
        "threading.Timer", "signal.alarm", "signal.setitimer",
    }
)  # fmt: skip
"""Names by which real time comes into a test; called with 0 or None, they only give way."""

BENCH = "runs by itself on a device in real time, and is no test for every day"
DEVICE = "is the real-time loop of a simulated device; no assertion depends on it"
TIMEOUT = "a timeout is what is tested, and it may come at any moment"
WAITING_KEY = re.compile(r"wait:\d")
ALLOWED = {
    "waiting.py": "the one place that waits",
    "conformance/__main__.py": BENCH,
    "conformance/real_time_bench.py": BENCH,
    "conformance/running.py": "says how long a row took",
    "campaign/__main__.py": "says how long all missions took",
    "scenarios/program.py": "ends a mission that hangs, after processor time of its own",
    "mutants/command.py": "says how long all mutants took",
    "mutants/copies.py": "says how long a mutant took",
    "mutants/pytest_server.py": "ends a run that hangs",
    "firmware/avr_bench.py": BENCH,
    "firmware/grbl_setup.py": BENCH,
    "firmware/native.py": BENCH,
    "armdrive/transports/can_served.py": DEVICE,
    "armdrive/sim/cia402/test_sim_cia402_master.py": DEVICE,
    "armdrive/mortal_host.py": "dies at a random time for `benchmarks/kill_everywhere.py`",
    "armdrive/aio/test_async_arm.py": TIMEOUT,
}
"""Who may, and why."""


SIGNS = re.compile(
    rf"\b(?:{'|'.join(map(re.escape, sorted(CLOCKS)))})\b"
    r"|\bfrom time import|pilot\.pause\((?!\))|wait:\d"
)
"""A text without any of these takes to no real time: most files need no parsing."""


def real_time(text: str) -> Iterator[str]:
    """Yield each place at which a module takes to real time, in words."""
    if not SIGNS.search(text):
        return
    nodes = [*ast.walk(ast.parse(text))]
    nothing = set()  # the names in calls such as `asyncio.sleep(0)`, which only give way
    for node in nodes:
        if isinstance(node, ast.ImportFrom) and node.module == "time":
            yield f"line {node.lineno}: names of `time` are imported one by one"
        if not isinstance(node, ast.Call):
            continue
        first = node.args[0] if node.args else None
        if isinstance(first, ast.Constant) and not first.value:
            nothing.add(id(node.func))
        if _dotted(node.func).endswith("pilot.pause") and (node.args or node.keywords):
            yield f"line {node.lineno}: {ast.unparse(node)} sleeps"
        pressed = [each.value for each in node.args if isinstance(each, ast.Constant)]
        if any(isinstance(each, str) and WAITING_KEY.match(each) for each in pressed):
            yield f"line {node.lineno}: a key `wait:` sleeps"
    for node in nodes:
        if isinstance(node, ast.Attribute) and id(node) not in nothing:
            name = _dotted(node)
            if name in CLOCKS:
                yield f"line {node.lineno}: {name}"


def _dotted(node: ast.expr) -> str:
    """Return a name with its dots; of what stands before any other expression's dot, nothing."""
    if isinstance(node, ast.Attribute):
        return f"{_dotted(node.value)}.{node.attr}"
    return node.id if isinstance(node, ast.Name) else ""


FILES = {each.relative_to(TESTS).as_posix(): each for each in sorted(TESTS.rglob("*.py"))}


def test_no_test_takes_to_real_time():
    found = [
        f"tests/{name}, {words}"
        for name, path in FILES.items()
        if name not in ALLOWED
        for words in real_time(path.read_text(encoding="utf-8"))
    ]
    assert not found, "wait by `waiting.py`, or use simulated time:\n" + "\n".join(found)


@pytest.mark.parametrize("name", ALLOWED)
def test_nobody_is_allowed_what_he_does_not_need(name):
    assert any(real_time(FILES[name].read_text(encoding="utf-8")))


@every_row(
    "text",
    [
        "import time\ntime.sleep(1)",
        "from time import monotonic",
        "import time\nnow = time.monotonic",
        "async def test():\n    await asyncio.sleep(0.1)",
        "async def test():\n    await asyncio.wait_for(x(), 5.0)",
        "async def test(pilot):\n    await pilot.pause(0.1)",
        "async def test(session):\n    await session.pilot.press('wait:300', 'w')",
        "threading.Timer(0.1, call).start()",
        "from datetime import datetime\ndatetime.now()",
    ],
)
def test_real_time_is_found(text):
    assert [*real_time(text)]
