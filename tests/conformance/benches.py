"""The table of transports: which bench stands for each."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from .bench import Bench
from .memory_bench import ThoroughMemoryBench
from .process_bench import PtyBench, TcpBench, UdpBench

BENCHES: Mapping[str, Callable[[str], Bench]] = MappingProxyType(
    {bench.transport: bench for bench in (ThoroughMemoryBench, PtyBench, TcpBench, UdpBench)}
)
