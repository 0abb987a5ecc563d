"""The page of ``hf report``: sections made of tables, charts and turnable views, in one file that needs no network."""
