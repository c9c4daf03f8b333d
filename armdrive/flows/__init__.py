"""Work that the engine carries out step by step: motion, jogging, gripping, referencing.

A flow never sleeps and touches no wire: it yields what it waits for. See engine.py.
"""
