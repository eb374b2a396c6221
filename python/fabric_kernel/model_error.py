"""`python -m fabric_kernel.model_error` prints every comparison that `fabric_kernel.model_error` is made of."""

from .compared import compared, factor, left_out
from .page import printed


def main() -> None:
    """Prints each series with and without each case."""
    for kind in ("limit", "strength"):
        series = compared(kind)
        rows = [("series", "case", "measured", "computed", "computed/measured", "factor of the others", "within")]
        for (name, case, worst, others, within), one in zip(left_out(series), (case for each in series for case in each.cases)):
            computed = ", ".join(f"{value:g}" for value in one.computed)
            rows.append((name, case, f"{one.measured:g}", computed, f"{worst:.2f}", f"{others:.2f}", "yes" if within else "no"))
        units, sources = ({one.about[key] for one in series} for key in ("unit", "source"))
        print(
            f"{kind}, {'; '.join(units)}: a new one lies within a factor of {factor([one.errors() for one in series]):.2f} in "
            f"95 %"
        )
        print(printed(rows[0], rows[1:]), *sources, "", sep="\n")


if __name__ == "__main__":
    main()
