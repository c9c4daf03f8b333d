"""The engine, its clocks, and the state of one arm: position, trust, record, stop bounds."""
