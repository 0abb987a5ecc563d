"""A triangle surface: nearest point, ray, soundness."""
