"""The table of transports: which bench stands for each."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from armdrive.registry import DIALECTS

from .bench import Bench
from .memory_bench import ThoroughMemoryBench
from .process_bench import PtyBench, TcpBench, UdpBench

BENCHES: Mapping[str, type[Bench]] = MappingProxyType(
    {bench.transport: bench for bench in (ThoroughMemoryBench, PtyBench, TcpBench, UdpBench)}
)


def stands_on(dialect: str, transport: str) -> bool:
    """Tell whether the controller of a dialect can be reached over a transport."""
    return BENCHES[transport].on_bus or not DIALECTS[dialect].can
