"""Every announced bound of a stop, held against the worst that the simulated device can do."""
