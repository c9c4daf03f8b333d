"""The Mini-mover geometry: closed form, nearest pose, singularities, many poses at once."""
