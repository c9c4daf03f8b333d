"""How much memory this process has in use: by its living objects, and by the system's own count.

The objects are counted one by one, when asked and at no other time. (Python's tracemalloc makes
everything else several times slower.) What they cannot show, such as memory that C
code has lost, shows in the process as the system sees it.
"""

from __future__ import annotations

import gc
import importlib
import sys
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

KB = 1024.0


@dataclass(frozen=True, slots=True)
class Census:
    """The bytes of all living objects, by the names of their types."""

    sizes: Mapping[str, int]

    @property
    def total_kb(self) -> float:
        """The bytes of all of them together."""
        return sum(self.sizes.values()) / KB

    def since(self, before: Census, most: int = 4) -> str:
        """Say which types have grown most."""
        grown = Counter(self.sizes)
        grown.subtract(before.sizes)
        rows = [(name, size / KB) for name, size in grown.most_common(most) if size > KB]
        return ", ".join(f"{name} {size_kb:+.0f} kB" for name, size_kb in rows) or "no type"


def census() -> Census:
    """Count every object that can be reached from a container, once, and what it occupies itself.

    That is all but what C code holds without telling the collector.
    """
    gc.collect()
    found: list[object] = gc.get_objects()
    seen = {id(found), *map(id, found)}
    sizes: dict[str, int] = {}
    while found:
        for each in found:
            name = type(each).__name__
            sizes[name] = sizes.get(name, 0) + sys.getsizeof(each, 0)
        reached, found = gc.get_referents(*found), []
        for each in reached:
            # numbers, texts and tuples of them are no container's: only their owners know them
            if id(each) not in seen:
                seen.add(id(each))
                found.append(each)
        del reached
    return Census(MappingProxyType(sizes))


def process_kb() -> float:
    """Return the most memory that the process has ever had from the system; 0 where none tells."""
    try:
        resource = importlib.import_module("resource")
    except ImportError:  # Windows
        return 0.0
    most = float(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
    return most / KB if sys.platform == "darwin" else most
