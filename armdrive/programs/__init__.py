"""Programs: a small language over the calls of an arm, and what runs, rehearses and resumes them."""
