"""What the model of a press lacks on readings between the molds."""
