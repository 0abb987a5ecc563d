"""Heat conduction in the mold: mesh, terms, boundary conditions, time integration."""
