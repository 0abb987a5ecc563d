"""One command each: read, check, compute, judge, write."""
