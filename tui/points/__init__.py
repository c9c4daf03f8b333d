"""Named places and sequences over them."""
