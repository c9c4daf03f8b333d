"""Small widgets that repaint only what has changed."""
