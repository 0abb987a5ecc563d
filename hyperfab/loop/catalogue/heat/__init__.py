"""What the model of a heated mold lacks on thermocouple readings."""
