"""Drive Mini-mover-style robot arms."""
