"""The benchmark: goals beside what `cargo xtask bench` has measured, tables, the plot of time over size."""

import json
from types import SimpleNamespace

from fabric_kernel.drawing import Series

from . import page, short
from .page import significant

NS, US, MS = "ns per node-step", "us", "ms"
TIGHT = "contact_capacity 7250"


def answer(study):
    measured = json.loads((study.source / "bench.json").read_text())
    rows, figures = [SimpleNamespace(**row) for row in measured["rows"]], measured["figures"]
    found = [goal for goal in goals(rows, figures, measured["widest"]) if goal[1] is not None or study.docs]
    heading = ["figure", "goal", "measured", ""]
    goal_rows = [
        [what, limit(goal), significant(value) if value is not None else "-", verdict(goal)]
        for goal in found
        for what, value, *_ in [goal]
    ]
    print(page.printed(heading, goal_rows))
    draw(rows, measured["widest"], study.folder / "performance.svg")
    if not study.docs:
        return
    study.picture("performance.svg", "performance.svg")
    load = lambda value: "unknown" if value is None else f"{value:.2f}"
    text = (
        f"Measured on: {measured['machine']}, in {measured['rounds']} rounds; clock: {measured['clock']} for the kernel, "
        f"process CPU time for the peers. Load of the machine at the start {load(measured['load_at_start'])}, at the end "
        f"{load(measured['load_at_end'])}. Times are the least of the rounds, with the median in brackets; what is measured is "
        "said in [performance.md](../performance.md).\n"
    )
    sections = [
        ("Goals", page.markdown(heading, goal_rows)),
        ("Bare sweep", times(rows, "sweep")),
        ("Whole run", times(rows, "run")),
        ("Bare sweep, Kevlar KM2, viscous", times(rows, "KM2 sweep")),
        ("Whole run, Kevlar KM2, viscous", times(rows, "KM2 run")),
        ("Whole run in single steps", times(rows, "run, single steps")),
        ("Damage everywhere", times(rows, "dense")),
        ("Five plies that touch", times(rows, "plies")),
        ("Peers", peers(rows)),
        ("Rows at rest", rest(rows)),
    ]
    groups = [
        ("ledger", "Ledger"),
        ("memory", "Memory"),
        ("fmu", "FMU"),
        ("states", "FMU state, 350 x 350 nodes"),
        ("ports", "What the machine could do"),
        ("instructions", "Instructions per node-step, 105 x 105"),
    ]
    for group, title in groups:
        own = [[figure["name"], significant(figure["value"]), figure["unit"]] for figure in figures if figure["group"] == group]
        sections.append((title, page.markdown(["figure", "value", "unit"], own) if own else "Not measured in this run.\n"))
    none = "No group of measurements is missing; instruction sets that this machine lacks are.\n"
    sections.append(("Not measured", "".join(f"- {missing}\n" for missing in measured["missing"]) or none))
    text += "".join(f"\n## {title}\n\n{body}" for title, body in sections)
    short.write(
        study.docs, "performance", "What was measured", "cargo xtask bench` and `python -m evidence bench --docs docs", text
    )


def goals(rows, figures, widest):
    """(what, value or None, "at least" or "at most", limit, unit)."""
    found = []
    add = lambda what, value, side, bound, unit: found.append((what, value, side, bound, unit))
    most = lambda what, value, bound, unit=NS: add(what, value, "at most", bound, unit)
    time = lambda case, size, instructions, threads=1: next(
        (
            row.ns_per_node_step
            for row in rows
            if (row.case, row.size, row.instruction_set, row.threads) == (case, size, instructions, threads)
        ),
        None,
    )
    value = lambda name: next((figure["value"] for figure in figures if figure["name"] == name), None)
    part = lambda above, below, scale=1: None if above is None or below is None else scale * above / below
    for instructions, bound in (("avx512", 2.0), ("avx2", 3.3), ("scalar", 10.0)):
        most(f"350 x 350 whole run, {instructions}", time("run", 350, instructions), bound)
    for instructions, bound in (("avx512", 1.6), ("avx2", 2.5)):
        most(f"350 x 350 bare sweep, {instructions}", time("sweep", 350, instructions), bound)
    ports = part(value(f"add-port bound, {widest}"), time("sweep", 350, widest), 100)
    add(f"350 x 350 bare sweep, {widest}, part of the add-port bound", ports, "at least", 60.0, "%")
    for size, bound in ((105, 2.0), (1000, 3.6)):
        most(f"{size} x {size} bare sweep, avx512", time("sweep", size, "avx512"), bound)
    most("damage-dense state, 105 x 105, avx512", time("dense", 105, "avx512"), 4.0)
    for instructions, bound in (("avx512", 1.6), ("avx2", 1.4)):
        gain = part(time("run, single steps", 1000, instructions), time("run", 1000, instructions))
        add(f"1000 x 1000 whole run, steps in blocks against single ones, {instructions}", gain, "at least", bound, "x")
    for size in (105, 350, 1000):
        for instructions in ("avx512", "avx2"):
            more = part(time("KM2 sweep", size, instructions), time("sweep", size, instructions))
            most(
                f"time of Kevlar KM2, viscous, over that of the paper's sheet, bare sweep, {size} x {size}, {instructions}",
                more,
                1.6,
                "x",
            )
    for case, bound in (("viscous", 1.5), ("rate", 1.5), ("fabric", 1.1), ("graded", 1.1)):
        more = part(value(f"{case} 105, avx2"), value("sweep 105, avx2"))
        most(f"instructions of {case} over those of the bare sweep, avx2", more, bound, "x")
    for size, bound in ((350, 1.8), (1000, 1.9)):
        gain = part(time("run", size, widest), time("run", size, widest, 2))
        add(f"2 threads, {size} x {size} whole run, {widest}", gain, "at least", bound, "x")
    for instructions in ("avx512", "avx2"):
        more = part(time("run", 2000, instructions), time("run", 1000, instructions))
        most(f"2000 x 2000 whole run over 1000 x 1000, {instructions}", more, 1.1, "x")
    for instructions in ("avx2", "sse2", "scalar"):
        more = part(value(f"plies 105, {instructions}"), value(f"run 105, {instructions}"))
        most(f"instructions of five plies over those of one sheet, soon after the hit, {instructions}", more, 1.3, "x")
    for instructions in ("avx512", "avx2", "sse2", "scalar"):
        more = part(time("plies", 105, instructions), time("run", 105, instructions))
        most(f"time of five plies over that of one sheet, contact wide, {instructions}", more, 1.3, "x")
    for peer, bound in (("LAMMPS", 22.0), ("NVIDIA Warp", 16.0), ("plain C", 15.0)):
        slower = next((row.times_slower for row in rows if (row.case, row.size) == (f"peers: {peer}", 350)), None)
        add(f"{peer}, 350 x 350 whole run, over the kernel's {widest}", slower, "at least", bound, "x")
    for kind, bound in (("stochastic", 124.0), ("uniform", 92.0)):
        name = f"memory, 350 x 350, {kind}, {TIGHT}"
        most(name, value(name), bound, "bytes per node")
    for version, bound in (("FMI 2.0", 2.0), ("FMI 3.0", 3.0)):
        for mode in ("free", "prescribed"):
            for what, limit_us in (("doStep beyond stepping", bound), ("get of a force", 1.0)):
                name = f"{version}, {mode}: {what}"
                most(name, value(name), limit_us, US)
    for what, bound in (("get", 3.0), ("set", 3.0), ("serialise", 12.0), ("deserialise", 12.0)):
        name = f"state, 350 x 350: {what}"
        most(name, value(name), bound, MS)
    return found


def limit(goal):
    _, _, side, bound, unit = goal
    return f"{side} {significant(bound)} {unit}"


def verdict(goal):
    _, value, side, bound, _ = goal
    if value is None:
        return "not measured"
    return "met" if (value >= bound if side == "at least" else value <= bound) else "**missed**"


def times(rows, case):
    """One line a size, one column a way to step."""
    own = [row for row in rows if row.case == case]
    ways = list(dict.fromkeys((row.instruction_set, row.threads) for row in own))
    heading = ["nodes", *(f"{name}, {threads} threads" if threads > 1 else name for name, threads in ways), "digest"]
    lines = []
    for size in dict.fromkeys(row.size for row in own):
        of = {(row.instruction_set, row.threads): row for row in own if row.size == size}
        shown = lambda row: (
            "not on this machine" if row is None or row.median is None else f"{row.ns_per_node_step:.2f} ({row.median:.2f})"
        )
        digest = next((row.digest for row in of.values() if row.digest), "")
        lines.append([f"{size} x {size}", *(shown(of.get(way)) for way in ways), f"`{digest}`"])
    return page.markdown(heading, lines)


def peers(rows):
    heading = ["nodes", "program", "ns per node-step (median)", "times slower", "deflection at the start, mm", "how it differs"]
    lines = []
    for row in rows:
        if row.case.startswith("peers: "):
            name = row.case.removeprefix("peers: ")
            time, median = ("-" if value is None else significant(value) for value in (row.ns_per_node_step, row.median))
            deflection = "-" if row.deflection is None else f"{1e3 * row.deflection:.4f}"
            ratio = "1" if row.times_slower is None else significant(row.times_slower)
            lines.append(
                [
                    f"{row.size} x {row.size}",
                    name if row.times_slower else f"{name}, {row.instruction_set}",
                    f"{time} ({median})",
                    ratio,
                    deflection,
                    row.differs or "",
                ]
            )
    return page.markdown(heading, lines, 2)


def rest(rows):
    lines = [
        [
            f"{row.size} x {row.size}",
            row.case,
            "-" if row.ns_per_node_step is None else significant(row.ns_per_node_step),
            f"`{row.digest or '-'}`",
        ]
        for row in rows
        if row.case.startswith("first ")
    ]
    return page.markdown(["nodes", "", NS, "digest"], lines, 2)


def draw(rows, widest, path):
    """Time over size: the bare sweep of every instruction set, and every peer."""
    series = []

    def add(name, style, case, instructions):
        points = [
            (row.size, row.ns_per_node_step)
            for row in rows
            if (row.case, row.instruction_set, row.threads) == (case, instructions, 1) and row.ns_per_node_step
        ]
        if points:
            series.append(Series(name, points, style))

    for instructions in dict.fromkeys(row.instruction_set for row in rows if row.case == "sweep"):
        add(f"bare sweep, {instructions}", "marked", "sweep", instructions)
    add(f"whole run, {widest}", "dashed", "run", widest)
    for case in dict.fromkeys(row.case for row in rows if row.case.startswith("peers: ")):
        add(case.removeprefix("peers: ") + ", whole run", "marked", case, "compiled")
    page.errors(path, "Time per node and step, one core", "nodes along a side", "time per node-step (ns)", series)
