"""Python scripts: on the arm of the command or their own, checked on simulated ones."""

import sys

import pytest
from cli_calls import TRACEBACK, write_bench
from running_bench import Keys

from armdrive.cli import main
from armdrive.errors import BadRequest
from armdrive.programs.scripts import read_script


@pytest.fixture
def write(write):
    return lambda text, name="t.py": write(text, name)


TOUR = """\
    from armdrive import Arm, Pose
    with Arm.connect() as arm:
        arm.move_to(Pose.of(x_mm=250, y_mm=0, z_mm=120, pitch_deg=-90))
        arm.move_l(Pose.of(x_mm=250, y_mm=80, z_mm=120, pitch_deg=-90))
        arm.park()
"""


def test_a_script_without_a_target_gets_the_arm_of_the_command(homed, write):
    ran = homed("run", write(TOUR), code=0).out
    assert "sim:teachmover (Microbot TeachMover), SIMULATED" in ran
    assert "line 4: arm.move_l(Pose.of(" in ran
    assert "done: 3 calls in " in ran
    assert "; sim:teachmover: tip x 127" in ran
    assert homed("status", "--json", code=0).json["pose"]["z_mm"] == pytest.approx(30, abs=0.5)
    homed("home", "--sim", "grbl", code=0)
    assert "sim:grbl" in homed("run", write(TOUR), "--sim", "grbl", code=0).out


def test_for_programs_there_are_json_lines_and_the_scripts_words_go_elsewhere(homed, write):
    called = homed("run", write(f'{TOUR}        print("hello")\n'), "--json", code=0)
    lines = called.json_lines
    assert [each["event"] for each in lines] == ["begin", "act", "act", "act", "end"]
    assert [each["line"] for each in lines[1:4]] == [3, 4, 5]
    assert [each["act"] for each in lines[1:4]] == ["move_to", "move_l", "park"]
    assert called.err == "hello\n"


def test_arguments_are_the_scripts_own_and_so_is_its_exit_code(homed, write):
    path = write("import sys\nprint(sys.argv[1:], __name__)\nraise SystemExit(int(sys.argv[1]))\n")
    before = (sys.argv, list(sys.path))
    ran = homed("run", path, "7", "two", code=7).out
    assert "['7', 'two'] __main__" in ran
    assert (sys.argv, sys.path) == before
    assert "enough" in homed("run", write("raise SystemExit('enough')\n"), code=1).err


def test_an_error_of_an_arm_is_one_sentence_with_its_line(homed, write):
    path = write(TOUR.replace("y_mm=80", "y_mm=800"))
    failed = homed("run", path, code=3)
    assert f"{path}: line 4, column 5\n        arm.move_l" in failed.err
    assert "\n        ^\n" in failed.err  # under the call itself
    assert failed.err.splitlines()[-1].startswith("armdrive: [E")
    lines = homed("run", path, "--json", code=3).json_lines
    assert (lines[-1]["event"], lines[-1]["line"], lines[-1]["resume"]) == ("failed", 4, None)


def test_another_error_shows_the_traceback_of_the_script(homed, write, capsys):
    path = write(TOUR.replace("arm.park()", "raise KeyError('mine')"))
    for words in ([path], [path, "--check"]):
        capsys.readouterr()
        assert main(["run", *words]) == 1
        shown = capsys.readouterr().err
        assert shown.count(TRACEBACK) == 1
        assert "KeyError: 'mine'" in shown
        assert "runpy" not in shown
    capsys.readouterr()
    assert homed("status", "--json", code=0).json["state"] == "standby"


@pytest.mark.parametrize("words", [(), ("--check",)])
def test_an_error_in_a_thread_of_a_script_is_the_scripts(homed, write, words, capsys):
    path = write(
        """\
        import threading
        from armdrive import Arm
        with Arm.connect() as arm:
            for work in (lambda: arm.move_j(base_deg=400), lambda: {}["mine"]):
                thread = threading.Thread(target=work)
                thread.start()
                thread.join()
            arm.park()
        """
    )
    capsys.readouterr()
    assert main(["run", path, *words]) == 0
    shown = capsys.readouterr().err
    refused = f"armdrive: {path}: line 4, column 26: [E205] the base would turn to 400.0"
    assert refused in shown
    assert shown.count(TRACEBACK) == 1
    assert "KeyError: 'mine'" in shown
    assert "armdrive itself failed" not in shown


def test_a_check_runs_the_script_on_simulated_arms_in_their_reference_posture(call, write):
    write_bench()
    path = write(
        """\
        from armdrive import Arm, Pose
        for name in (None, "bench", "sim:grbl"):
            with Arm.connect(name) as arm:
                print(arm.status.dialect, arm.simulated, arm.speed_override)
                if name is None:
                    arm.io.read()
                arm.move_to(Pose.of(x_mm=220, y_mm=0, z_mm=120, pitch_deg=-90))
        """
    )
    checked = call("run", path, "--check", "--arm", "bench", "--speed", "50%", code=0).out
    assert checked.count("teachmover True 0.5") == 2
    assert checked.count("grbl True 0.5") == 1  # an arm that the script names stays
    assert "SIMULATED, simulated arm at 9600 baud, in its reference posture" in checked
    assert "line 7: arm.move_to(Pose.of(" in checked
    assert "done: 4 calls in " in checked
    assert call("status", "--json", code=0).json["trust"] == "unknown"  # no arm has moved


def test_no_port_opens_in_a_check_whatever_the_script_does(call, write, monkeypatch):
    write_bench()
    path = write(
        """\
        import os, subprocess, sys, threading
        from armdrive import Arm
        from armdrive.connect.parts import connect_real
        from armdrive.connect.target import find
        seen = []
        def work():
            with Arm.connect("bench") as arm:
                seen.append(arm.simulated)
                arm.move_j(base_deg=20)
        thread = threading.Thread(target=work)
        thread.start()
        thread.join()
        with Arm.connect("/dev/ttyUSB0", dialect="teachmover") as arm:
            seen.append(arm.simulated)
        child = "from armdrive import Arm; print(Arm.connect('bench').simulated)"
        seen.append(subprocess.run([sys.executable, "-c", child], stdout=-1).stdout)
        print(seen)
        connect_real(find("bench").config)
        """
    )
    checked = call("run", path, "--check", "--arm", "bench", code=4)
    assert "[True, True, b'True\\n']" in checked.out
    assert "ARMDRIVE_FORCE_SIM is set" in checked.err


def test_options_that_scripts_do_not_support_are_refused(call, write):
    for line in ("--resume", "--loops 3", "--input 1=on", "--assume-width 20", "--plot"):
        option, *value = line.split()
        said = call.refused("run", write("pass\n"), option, *value, code=2)
        assert f"{option} is for program files" in said


def test_a_syntax_error_of_a_script_is_reported_with_its_line(call, write, tmp_path):
    assert "line 2" in call.refused("run", write("pass\nif\n"), code=2)
    assert "cannot be read" in call.refused("run", str(tmp_path / "none.py"), code=2)
    (tmp_path / "zero.py").write_bytes(b"\0")
    with pytest.raises(BadRequest):
        read_script(tmp_path / "zero.py")


def test_coroutines_are_run_checked_and_stepped_through_too(homed, write, monkeypatch):
    keys = Keys()
    monkeypatch.setattr("armdrive.cli.program.run.standard_input", lambda: keys)
    path = write(
        """\
        import asyncio
        from armdrive import AsyncArm
        async def main():
            async with AsyncArm.connect() as arm:
                await arm.move_j(base_deg=30)
                await arm.park()
        asyncio.run(main())
        """
    )
    assert "done: 2 calls" in homed("run", path, "--check", code=0).out
    ran = homed("run", path, "--step", code=0).out
    assert "line 6: await arm.park()\n" in ran
    assert "done: 2 calls" in ran
    assert keys.taken == 2


def test_arms_that_a_script_leaves_open_are_stopped_and_closed(homed, write):
    path = write(
        """\
        from armdrive import Arm
        arm = Arm.connect()
        arm.move_j(base_deg=80, speed=0.1, wait=False)
        arm.sleep(1)
        """
    )
    homed("run", path, code=0)
    view = homed("status", "--json", code=0).json
    assert view["trust"] == "restored"
    assert 0.5 < view["joints"]["base_deg"] < 79
