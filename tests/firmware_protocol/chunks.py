"""How bytes arrive: cut anywhere, whatever the dialect."""

from itertools import pairwise

from hypothesis import strategies as st


@st.composite
def chunked(draw: st.DrawFn, data: bytes) -> list[bytes]:
    """Cut bytes into portions: all at once, one by one, or anywhere."""
    how = draw(st.sampled_from(["whole", "bytes", "anywhere"]))
    if how == "whole":
        return [data]
    if how == "bytes":
        return [bytes([byte]) for byte in data]
    cuts = draw(st.lists(st.integers(0, len(data)), max_size=6))
    return [data[a:b] for a, b in pairwise(sorted({0, len(data), *cuts}))]
