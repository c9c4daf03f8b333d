"""A named system or a link table, studied posture by posture with no arm connected."""
