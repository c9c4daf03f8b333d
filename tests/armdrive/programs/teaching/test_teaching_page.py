"""The rows of a TeachMover's program on its page can be read."""

from pages import blocks, page

from armdrive.dialects.teachmover.pendant import parse_pendant


def test_the_rows_of_the_page_read():
    (shown,) = [text for text in blocks(page("teachmover")) if text.startswith("armdrive pendant")]
    program = parse_pendant(shown)
    assert [row.number for row in program.rows] == [1, 2, 3]
    assert program.origin is not None
