"""Every number that the loop decides by. docs/close-loop-thresholds.md says what each stands for; a test holds both."""

from __future__ import annotations

from scipy.special import chdtri

# ---- what counts as noise ----------------------------------------------------------------------------------

#: Chance, in all three tests together, of calling pure noise a residual.
ALPHA = 0.015
#: Structure smaller than this many standard deviations of the noise (rms) is found, but not worth a term: the total is
#: then at most 1.1 times the noise.
SMALL = 0.45
#: What is told of a number are so many of its standard deviations: of the scatter of replicates, of a constant of a
#: term, of what a test misses by or a model leaves (rms).
TOLD = 2.0
#: Chance below which something is taken for no chance: that levels of noise are alike, that constants are so far from
#: what is known of them, that replicates differ in stiffness alone, that a next measurement leaves rivals alike.
UNLIKELY = 1e-5
#: Readings of which something can be said: their deviation is known to a quarter. A smooth misfit counts as so many.
FEWEST = 8

# ---- what is known beforehand ------------------------------------------------------------------------------

#: Noise a fabric's test has at least, as a share of its peak: half a class of a testing machine (ISO 7500-1, class 1);
#: four times that where readings are too few to tell.
MACHINE = 0.005
#: Where none were tested alike, specimens of one cloth scatter by this at most; half of it is usual.
ONE_CLOTH = 0.05
#: Relative standard deviation of the constants of a mold, a foam or a sheet, where none is stated.
PRIOR = 0.10

# ---- when a term is named ----------------------------------------------------------------------------------

#: A term must lower BIC by this much; minus twice the logarithm of the likelihood as well, though specimens may
#: scatter as they like. So must a constant of the noise more.
MARGIN = 8.0
#: A share that does not matter: of the structured variance a term must take more, of tests left out too, and all but
#: this is enough.
SHARE = 0.05
#: A share that is most: two of three, of the tests left out and of what a term explains. What is left of it is
#: what something else leaves.
MOST = 0.65

# ---- how sure a name is, and who could stand in its place -----------------------------------------------------

#: To one: another name is told beside the likeliest where that is no more likely, and takes its place where it is the
#: likelier by more; documents upstream are blamed, and what specimens that scatter may hide is told, where they are so.
ODDS = 3.0


def clearly() -> float:
    """Return the fall of chi-squared, of one constant more, that is no chance.

    >>> round(clearly(), 1)
    19.5
    """
    return float(chdtri(1.0, UNLIKELY))
