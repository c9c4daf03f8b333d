"""Programs: a small language over the calls of an arm, and what runs and rehearses them."""
