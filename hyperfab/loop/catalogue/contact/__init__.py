"""What the model of a punched sheet lacks on its force over depth."""
