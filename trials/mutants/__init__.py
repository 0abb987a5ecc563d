"""Small defects planted in the program, one at a time: does a test notice? ``python -m trials.mutants``."""
