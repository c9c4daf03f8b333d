"""Sets an arm up: finds its port, asks about it, writes its file, tries its motors."""
