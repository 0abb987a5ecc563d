"""Every number that the loop decides by. docs/close-loop-thresholds.md says what each stands for; a test holds both."""

from __future__ import annotations

# ---- what counts as noise ----------------------------------------------------------------------------------

#: Chance, in all three tests together, of calling pure noise a residual.
ALPHA = 0.015
#: Structure smaller than this many standard deviations of the noise (rms) is found, but not worth a term: the total is
#: then at most 1.1 times the noise.
SMALL = 0.45
#: Terms that take this share of what is not noise, and leave a total of less than 1.2 times the noise (this rms beside
#: it, in its standard deviations), are what the model lacked: the rest is their law's own inaccuracy.
EXPLAINED, ENOUGH = 0.95, 0.66
#: Readings of a test below which it is neither judged by itself nor laid beside a replicate.
FEWEST_TOGETHER = 8
#: Readings of a file, or of a probe, below which noise cannot be told from a residual.
FEWEST_READ = 12

# ---- how large the noise is --------------------------------------------------------------------------------

#: Noise of readings too few to tell, as a share of the largest: of a testing machine of the coarsest class, twice.
ASSUMED = 0.02
#: Noise a fabric's test has at least, as a share of its peak: half a class of a testing machine (ISO 7500-1, class 1).
MACHINE = 0.005
#: Chance of telling levels of noise apart that are alike.
BY_CHANCE = 1e-4

# ---- how much specimens scatter ----------------------------------------------------------------------------

#: A scatter seen in one pair may be greater by this many times itself (by fewer with more pairs), as Student's
#: distribution has it for so few degrees of freedom. Only what readings cannot explain to two of their standard
#: deviations counts, of replicates and of two predictions of a test.
FEW, BEYOND = 1.5, 4.0
#: Scatters are tried up to this many times that: a single specimen that carries a term is the farthest out of all.
MOST_SCATTER = 2.0
#: Where none were tested alike, specimens of one cloth scatter by this at most.
ONE_CLOTH = 0.05
#: Half of that is usual, which is known as well as so many specimens would tell it.
AS_SEEN = 2.0
#: Replicates turn at places that differ by less than this share of the strain: specimens slip and stretch a little.
SAME_WAY = 0.2
#: Lower by this, chi-squared says that replicates differ by an offset or by slack rather than in stiffness, and that a
#: next measurement tells rivals, refitted, from each other: five standard deviations.
CLEARLY = 25.0

# ---- when a term is named ----------------------------------------------------------------------------------

#: A term must lower BIC by this much; minus twice the logarithm of the likelihood as well, though specimens may
#: scatter as they like. So must a constant of the noise more.
MARGIN = 8.0
#: Share of the structured variance that a term must take.
SHARE = 0.05
#: Shares of the structured held-out error and of the tests: two of three.
TAKEN, HELPED = 0.2, 0.65
#: A test is counted only where the others determine its prediction to this many standard deviations of the noise (rms).
DETERMINED = 1.0
#: A test is noise up to this (rms).
TEST_NOISE = 1.5
#: Share of what a term explains that has to be in tests the others predict, for these to be asked.
SEEN = 0.5

# ---- how sure a name is (found on drawn fabrics whose own formula was taken out of the catalogue) ----------------

#: Share of the misfit that a right name's law may leave, and how many values of it count: neighbours miss alike.
LAW, VALUES = 0.15, 8.0
#: What something else leaves of it, where no name does better.
ELSEWHERE = 0.4
#: Another name is told beside the likeliest where that is no more than so many times as likely.
ODDS = 3.0

# ---- who could stand in its place --------------------------------------------------------------------------

#: Constants a rival may always have.
FEWEST_CONSTANTS = 2
#: An entry whose imprint has less than this (squared cosine) in common with a found effect's is no rival: to pass it
#: would have to have nearly all. A little of a large effect has not all in common with it either: that is the measure.
ALIKE = 0.2
#: Where the model's own constants are this unlikely to be so far from what is known of them, a rival passes that
#: explains as much as is enough: the found law is then not sure to be the whole truth.
STRAINED = 1e-3
#: Where much is known of the own constants a rival is none that needs them this unlikely far off, the found law not.
IMPOSSIBLE = 1e-6

#: Documents upstream are blamed that have this probability together.
BLAMED = 0.9

# ---- what is known of the model's own constants ------------------------------------------------------------

#: Relative standard deviation of the constants of a mold, a foam or a sheet, where none is stated.
PRIOR = 0.10
#: A model whose mean square misfit is so many times the noise's is wrong: its misfit counts as noise against a prior.
WRONG = 4.0
