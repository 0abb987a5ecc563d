"""Files in and out: CSV, STL, VTU, JSON, TOML, units, atomic writing. No physics."""
