"""The spring grid, its energy and its equilibrium on a surface."""
