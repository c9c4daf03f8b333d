"""The arm file: one schema that reads, checks, suggests, writes and documents it."""
