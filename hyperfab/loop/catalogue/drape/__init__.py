"""What the model of a draped sheet lacks on markers."""
