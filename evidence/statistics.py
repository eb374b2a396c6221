"""Means with 95 % intervals, ratios of means, and the rule that turns an interval into a verdict.

Method: Student's t for a mean; Welch's interval of the difference of two logarithms for a ratio of means, with the standard
errors carried to first order; Wilson's interval for a share of the runs, which has a width also where all runs are alike.
The ballistic limit is the mean of the distribution of single limits that the arrested parts describe (Spearman and Kaerber).
Limits: ensembles of 3 to 10 runs are taken as normal; intervals of several points are not corrected for their number.
Reference: B. L. Welch, Biometrika 34 (1947) 28; E. B. Wilson, J. Amer. Statist. Assoc. 22 (1927) 209; G. Kaerber, Arch. exp.
Path. Pharmak. 162 (1931) 480.
"""

import math
from typing import NamedTuple

import numpy
import scipy.optimize
import scipy.stats

AGREES, DOES_NOT, UNDECIDED = "agrees", "does not", "undecided"


def mean(values):
    return float(numpy.mean(values)) if len(values) else math.nan


def deviation(values):
    """Standard deviation of the sample; 0 for fewer than two values."""
    return float(numpy.std(values, ddof=1)) if len(values) > 1 else 0.0


def student(freedom):
    """97.5 % quantile of Student's t; below 1 degree of freedom that of 1."""
    return float(scipy.stats.t.ppf(0.975, max(freedom, 1.0))) if not math.isnan(freedom) else student(1.0)


def standard_error(values, resolution=0.0):
    """Infinite for fewer than two values. resolution: steps in which the values are known, in parts of them."""
    if len(values) < 2:
        return math.inf
    # Values that differ by rounding alone have no spread.
    spread = deviation(values)
    spread = 0.0 if spread <= 1e-14 * abs(mean(values)) else spread / math.sqrt(len(values))
    return math.hypot(spread, resolution * mean(values) / math.sqrt(12))


class Estimate(NamedTuple):
    """A value with its 95 % interval."""

    value: float
    low: float
    high: float

    @staticmethod
    def exact(value):
        return Estimate(value, value, value)

    @staticmethod
    def of_error(value, error, freedom):
        """From a standard error and the degrees of freedom of that error."""
        half = student(freedom) * error
        return Estimate(value, value - half, value + half)

    @staticmethod
    def mean(values, resolution=0.0):
        """The mean of a sample. Fewer than two values: an interval without ends. resolution: as of standard_error."""
        return Estimate.of_error(mean(values), standard_error(values, resolution), len(values) - 1)

    @staticmethod
    def large_sample_deviation(value, count):
        """The standard deviation of a large normal sample: its error is sd/sqrt(2 (n - 1))."""
        return Estimate.of_error(value, value / math.sqrt(2 * (count - 1)), count - 1)

    @staticmethod
    def ratio(above, below):
        """Ratio of the means of two independent positive samples."""
        if not mean(below):
            return Estimate.exact(math.nan)
        value, parts = mean(above) / mean(below), []
        for values in (above, below):
            error = standard_error(values)
            # A sample of zeros has no spread either.
            parts.append(((error / mean(values)) ** 2 if error else 0.0, len(values) - 1))
        total = sum(part for part, _ in parts)
        if total == 0.0 or math.isnan(value):
            return Estimate.exact(value)
        if math.isinf(total):
            return Estimate(value, 0.0, math.inf)
        # Welch and Satterthwaite.
        freedom = total**2 / sum(part**2 / free for part, free in parts if part)
        factor = math.exp(student(freedom) * math.sqrt(total))
        return Estimate(value, value / factor, value * factor)

    @staticmethod
    def share(hits, count):
        """The share of a sample for which something holds. An empty sample: not defined."""
        if not count:
            return Estimate.exact(math.nan)
        interval = scipy.stats.binomtest(hits, count).proportion_ci(method="wilson")
        return Estimate(hits / count, interval.low, interval.high)

    @staticmethod
    def quotient(above, below):
        """Quotient of two positive values whose intervals are independent, to first order in the logarithms."""
        halves = [0.5 * (part.high - part.low) / part.value for part in (above, below)]
        factor, value = math.exp(math.hypot(*halves)), above.value / below.value
        return Estimate(value, value / factor, value * factor)

    @staticmethod
    def difference(above, below):
        """Difference of two values whose intervals are independent."""
        half, value = 0.5 * math.hypot(above.high - above.low, below.high - below.low), above.value - below.value
        return Estimate(value, value - half, value + half)

    def text(self, digits):
        """value [low, high] with so many digits after the point."""
        if not math.isfinite(self.value):
            return "not defined"
        if not (math.isfinite(self.low) and math.isfinite(self.high)):
            return f"{self.value:.{digits}f} (single run)"
        return f"{self.value:.{digits}f} [{self.low:.{digits}f}, {self.high:.{digits}f}]"

    def verdict(self, allowed):
        """The rule: compares the interval with the range that a claim allows."""
        low, high = allowed
        if math.isnan(self.value):
            return UNDECIDED
        if low <= self.low and self.high <= high:
            return AGREES
        return DOES_NOT if self.high < low or high < self.low else UNDECIDED


def verdict_of_all(verdicts):
    """A claim about every one of several points: one counterexample refutes it."""
    if DOES_NOT in verdicts:
        return DOES_NOT
    return AGREES if verdicts and UNDECIDED not in verdicts else UNDECIDED


def verdict_of_any(verdicts):
    """A claim that some point exists at which it holds."""
    if AGREES in verdicts:
        return AGREES
    return DOES_NOT if verdicts and UNDECIDED not in verdicts else UNDECIDED


def arrest_limit(counts):
    """The ballistic limit, J, from (energy, arrested, runs) at increasing energies: None unless all runs are arrested at the
    first of them and none at the last. Parts that rise with energy are pooled. The error has the counts' and that of not knowing
    where between two energies a limit lies (the spacing over sqrt(12))."""
    if not counts or counts[0][1] != counts[0][2] or counts[-1][1] != 0 or counts[0][2] == 0:
        return None
    _, arrested, runs = map(numpy.array, zip(*counts))
    parts = scipy.optimize.isotonic_regression(arrested / runs, weights=runs, increasing=False).x.tolist()
    limit = variance = 0.0
    for k in range(len(counts) - 1):
        start, end = counts[k][0], counts[k + 1][0]
        share = parts[k] - parts[k + 1]
        limit += share * 0.5 * (start + end)
        variance += (share * (end - start)) ** 2 / 12
        if k > 0:
            weight = 0.5 * (end - counts[k - 1][0])
            variance += weight**2 * parts[k] * (1 - parts[k]) / max(counts[k][2] - 1, 1)
    return Estimate.of_error(limit, math.sqrt(variance), math.inf)
