"""How much memory this process uses: by its live objects, and by the system's own count.

The objects are counted one by one on request. (Python's tracemalloc would make everything else
several times slower.) Memory that C code has lost shows only in the system's count.
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
    """The bytes of all live objects, by the names of their types."""

    sizes: Mapping[str, int]

    @property
    def total_kb(self) -> float:
        """The kB of all objects."""
        return sum(self.sizes.values()) / KB

    def since(self, before: Census, most: int = 4) -> str:
        """Return the types that have grown most, in words."""
        grown = Counter(self.sizes)
        grown.subtract(before.sizes)
        rows = [(name, size / KB) for name, size in grown.most_common(most) if size > KB]
        return ", ".join(f"{name} {size_kb:+.0f} kB" for name, size_kb in rows) or "no type"


def census() -> Census:
    """Count the bytes of every object that a container leads to, each once.

    This misses only objects that C code holds without telling the collector.
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
            # the collector does not list numbers and texts: only their owners lead to them
            if id(each) not in seen:
                seen.add(id(each))
                found.append(each)
        del reached
    return Census(MappingProxyType(sizes))


def process_kb() -> float:
    """Return the most memory that the process ever had, in kB; 0 if the system does not tell."""
    try:
        resource = importlib.import_module("resource")
    except ImportError:  # Windows
        return 0.0
    most = float(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
    return most / KB if sys.platform == "darwin" else most
