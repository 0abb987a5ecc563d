"""Newton, linear solvers, adaptive steps. No physics."""
