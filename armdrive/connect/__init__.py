"""Connects an arm, reconnects it, and answers other programs that ask about it."""
