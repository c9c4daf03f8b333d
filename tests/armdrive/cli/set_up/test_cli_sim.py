"""`armdrive sim --arm`: the simulated device of an arm file, for programs that open its port."""

import contextlib
import os

import pytest
from cli_calls import write_arm_file, write_bench
from command_host import HostedCommand

needs_pty = pytest.mark.skipif(os.name != "posix", reason="needs a pseudo-terminal")


@contextlib.contextmanager
def serving(*words):
    """Run `armdrive sim` in a process of its own; yield the lines that it says at first."""
    process = HostedCommand("sim", *words)
    try:
        yield process.stdout.readline
    finally:
        process.communicate("quit\n")


@needs_pty
def test_the_device_of_an_arm_file_is_served_and_found_at_its_port(call, tmp_path):
    port = tmp_path / "arm"
    words = ("--template", "printed-six", "--port", str(port), "--yes")
    call("config", "new", "six", *words, code=0)
    with serving("--arm", "six", "--pty", str(port)) as line:
        assert line().startswith("a simulated ")
        seen = call("status", "--arm", "six", "--json", code=0).json
    assert (seen["dialect"], seen["simulated"], seen["arm"]) == ("grbl", False, "six")
    assert seen["error"] == ""


@needs_pty
def test_a_port_that_the_arm_file_does_not_name_is_told_as_its_line(call, tmp_path):
    write_bench("/dev/ttyUSB7")
    with serving("--arm", "bench", "--pty", str(tmp_path / "arm")) as line:
        line()
        assert line().strip() == f'connect with port = "{tmp_path / "arm"}" in the arm file'


def test_the_wire_is_that_of_the_arm_file(call):
    write_arm_file("bus", 'model = "minimover5-mks"\n[connection]\ndialect = "mks"\n')
    assert "--slcan PATH is required" in call.refused("sim", "--arm", "bus", "--pty", "x", code=2)


@pytest.mark.parametrize("words", [("teachmover", "--arm", "bench"), ()])
def test_a_device_is_named_once(call, words):
    write_bench()
    said = call.refused("sim", *words, "--tcp", "127.0.0.1:0", code=2)
    assert "a dialect is required, or an arm file with --arm" in said
