"""Pictures of arms in terminal characters and as PNG or SVG files."""
