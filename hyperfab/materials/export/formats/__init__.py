"""Card formats, one a file; each module lists its ``FORMAT``."""
