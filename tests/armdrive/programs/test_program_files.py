"""Program files as editors leave them: marks, line ends, tabs, no end of the last line."""

import pytest

from armdrive.programs.program import read_program_file

LEFT = {
    "a byte order mark": b'\xef\xbb\xbftype "a"\nready\n',
    "line ends of Windows": b'type "a"\r\nready\r\n',
    "tabs, and no end of the last line": b'\ttype\t"a"\n\t ready',
}


@pytest.mark.parametrize("how", LEFT)
def test_a_file_of_any_editor_is_read(tmp_path, how):
    path = tmp_path / "t.arm"
    path.write_bytes(LEFT[how])
    program = read_program_file(path)
    assert [line.split() for line in program.text.splitlines()] == [["type", '"a"'], ["ready"]]
    assert program.machine().next().mark.line == 1
