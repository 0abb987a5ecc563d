"""The stretched sheet as finite elements, and the sphere it meets."""
