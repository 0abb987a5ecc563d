"""Closing the loop with measured data: noise, residual, score, selection, mimics, the next measurement.

The engine knows a problem only through ``predict(constants, terms) -> values`` at measured points, so one
engine serves all domains. It opens no file and prints nothing.
"""
