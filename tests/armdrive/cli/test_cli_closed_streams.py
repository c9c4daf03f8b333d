"""Commands that were begun without a standard stream: as from a bad service file, or by `<&-`."""

import subprocess
import sys

import pytest

if sys.platform == "win32":
    pytest.skip("no shell that closes streams", allow_module_level=True)


@pytest.mark.parametrize("closed", ["<&-", ">&-", "2>&-", "<&- >&- 2>&-"])
def test_a_closed_stream_is_no_traceback(call, tmp_path, closed):
    call("home", code=0)
    program = tmp_path / "t.arm"
    program.write_text('type "on"\nmove at(250, 0, 120, -90)\n', encoding="utf-8")
    words = f"'{sys.executable}' -m armdrive run '{program}' {closed}"
    ended = subprocess.run(words, shell=True, capture_output=True, text=True, check=False)
    assert (ended.returncode, "Traceback" in ended.stderr) == (0, False), ended
    assert call("status", "--json", code=0).json["pose"]["z_mm"] == pytest.approx(120, abs=0.5)
