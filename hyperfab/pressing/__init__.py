"""Two molds, the foam between them, the heat in them."""
