"""One document kind a file: what hf reads and writes, and its JSON Schema."""
