"""Strips of Kevlar 49 fabric, pulled in the network that shots use, against the published Weibull scales of four strips.

Method: held nodes have no velocity, so a strip is pulled through states of rest. All nodes move along the pull by 0.02 % of its
length, at rest and with the largest stretches that their segments have had; then the network moves for 256 steps, and is put to
rest again, until nothing breaks, its kinetic energy is below 1e-4 of the strain energy and both clamps feel the same load within
1 %. The strength is the largest load of the clamps over the section of the yarns. Shape and scale of the samples follow from mean
and deviation of the logarithms.
Input: data/fabrics/kevlar_49_yarn.toml. Count and linear density could not be cited: 17 yarns an inch of 1420 denier are a
choice.
Limits: clamps hold every yarn alike; a bar that breaks sets off waves that no test machine is slower than, so rests say nothing
of the rate.
"""

import math
import tomllib

import numpy
import scipy.optimize
from fabric_kernel import Scene, Simulation, drawing
from fabric_kernel.drawing import Series

from . import page, strength
from .comparison import about
from .statistics import Estimate
from .study import FULL, TOP

INCH = 0.0254
COUNT = 17 / INCH
SAMPLES = 30
# Crimp along the pull and across it, as measured.
CRIMP = {"warp": (0.0065, 0.0025), "fill": (0.0025, 0.0065)}
INCREMENT, BLOCK, BLOCKS = 2e-4, 256, 40
# Largest kinetic energy over strain energy, and difference of the clamps' loads, of a state of rest.
MOVING, UNLIKE = 1e-4, 0.01
# A strip is torn when its load has fallen to this part of the largest.
TORN = 0.9
# Green strain at which one yarn is cut, as strips break.
STRAIN = 0.013


def strip(width, length, direction="warp", pitch=None, **more):
    """The scene: rows of yarns along x, held at both ends. pitch: between crossings along the pull, m."""
    along, across = CRIMP[direction]
    yarn = {"name": "kevlar_49_yarn", "linear_density": {"value": 1420, "unit": "denier"}}
    textile = yarn | {"warp": {"count": COUNT, "crimp": along}, "weft": {"count": 1 / pitch if pitch else COUNT, "crimp": across}}
    scene = Scene("sheet_3in_sphere", fabric={"thickness": 0.0} | textile)
    nodes = {"sheet.nodes_x": round(length / scene["sheet.spacing"]) + 1, "sheet.nodes_y": round(width * COUNT)}
    return scene.replace(
        nodes | {"attachment.kind": "two_sides", "projectile.position": [0, 0, -1], "projectile.velocity": [0, 0, 0]} | more
    )


class Pull:
    """A strip between its clamps."""

    def __init__(self, scene):
        self.scene, self.simulation = scene, Simulation(scene, warns=False)
        self.nodes = self.simulation.positions()
        self.stretches = numpy.ones_like(self.simulation.damage())
        self.strain = 0.0
        self.critical = self._critical()

    def _critical(self):
        """The critical stretch of each segment: alpha = exp(-rate (U - U_c)) tells it where the stretch U damages but does not
        break."""
        rate, found = self.scene["yarn.damage_intercept"], numpy.full_like(self.stretches, math.nan)
        for stretch in 1 + numpy.arange(0.001, 0.12, 0.0015):
            alpha = self._alpha(numpy.full_like(found, stretch))
            damaged = (alpha > 0) & (alpha < 1)
            found[damaged] = stretch + numpy.log(alpha[damaged]) / rate
        assert not numpy.isnan(found).any()
        return found

    def _alpha(self, stretches):
        self.simulation.reset()
        self.simulation.set_largest_stretch(stretches)
        return self.simulation.damage()

    def _largest(self):
        """The largest stretch that each segment has had; 1 of whole ones, 2 of broken ones."""
        alpha, rate = self.simulation.damage(), self.scene["yarn.damage_intercept"]
        damaged = numpy.log(numpy.where(alpha > 0, alpha, 1)) / rate
        return numpy.where(alpha == 0, 2.0, numpy.where(alpha < 1, self.critical - damaged, 1.0))

    def to(self, strain, block=BLOCK, moving=MOVING):
        """Stretches the strip to this strain and lets it come to rest. Returns the mean load of the clamps, N, and whether it
        rests."""
        self.nodes[..., 0] *= (1 + strain) / (1 + self.strain)
        self.strain = strain
        for _ in range(BLOCKS):
            self._alpha(self.stretches)
            self.simulation.set_motion(self.nodes, numpy.zeros_like(self.nodes))
            self.simulation.step(block)
            ends = numpy.array([end[0] for end in self.simulation.support()["attachments"][:2]]) / self.simulation.time
            energy, stretches = self.simulation.energy(), self._largest()
            new = (stretches != self.stretches).any()
            self.nodes, self.stretches = self.simulation.positions(), stretches
            load = 0.5 * (ends[0] - ends[1])
            rests = not new and energy["fabric_kinetic"] < moving * energy["strain"] and abs(ends.sum()) < UNLIKE * load
            if rests:
                break
        return load, rests

    def strength(self):
        """Largest load over the section of the yarns, Pa, and how many states of the way there were not at rest."""
        along = (self.scene["sheet.nodes_x"] - 1) * self.scene["sheet.nodes_y"]
        # Up to the first break nothing happens.
        strain = self.critical[:along].min() * (1 + self.scene["sheet.crimp"][0]) - 1 - 1e-5
        most, restless = 0.0, 0
        while True:
            load, rests = self.to(strain)
            restless += not rests and load > TORN * most
            most = max(most, load)
            if load < TORN * most:
                return most / (self.scene["sheet.yarn_area"] * self.scene["sheet.nodes_y"]), restless
            strain += INCREMENT


def returned(job):
    """The load of the middle yarn, cut in its middle, over that of a whole one, at each bar from the cut to the end; and the most
    that a yarn beside it bears."""
    width, length, sides = job
    # Far above the waves that the cut sets off.
    more = {"attachment.kind": sides, "yarn.strength_draw": "none", "yarn.critical_stretch": 1.05, "sheet.crimp": [0, 0]}
    pull = Pull(strip(width, length, **more))
    rows, bars = pull.scene["sheet.nodes_y"], pull.scene["sheet.nodes_x"] - 1
    row, cut = rows // 2, (bars - 1) // 2
    pull.stretches[row * bars + cut] = 2.0
    pull.to(math.sqrt(1 + 2 * STRAIN) - 1, 1024, 1e-7)
    assert (pull.stretches > 1).sum() == 1, "another yarn broke"
    stretch = pull.simulation.stretch()[: rows * bars].reshape(rows, bars)
    load = stretch * (stretch**2 - 1) / (2 * STRAIN * math.sqrt(1 + 2 * STRAIN))
    return load[row, cut + 1 :].tolist(), float(load[row + 1].max())


def rigid(crossings):
    """Load of the cut yarn if all others are rigid: w'' = w^3, w' = -strain at the cut, for displacements w over the crossings,
    in spacings."""
    return 1 - 1 / (1 + (math.sqrt(2) * STRAIN) ** 0.5 * crossings / math.sqrt(2)) ** 2


def shared(width, length, seed, samples=2000):
    """Strengths, MPa, if all yarns shared their load equally at each crossing: the least of the bundles between two crossings."""
    yarn = tomllib.loads((TOP / "data/fabrics/kevlar_49_yarn.toml").read_text())["fabric"]
    shape, rows, bars = yarn["weibull_shape"]["value"], round(width * COUNT), round(length * COUNT)
    scale = yarn["strength"]["value"] * (1e-3 * yarn["gauge_length"]["value"] * COUNT) ** (1 / shape)
    strengths = numpy.sort(scale * numpy.random.default_rng(seed).weibull(shape, (samples, bars, rows)))
    return (strengths * (1 - numpy.arange(rows) / rows)).max(axis=2).min(axis=1)


def weibull(samples):
    """Scale with its interval, and shape."""
    shape, scale, error = strength.weibull(numpy.log(samples))
    return Estimate.of_error(scale, error, len(samples) - 1), shape


def pulled(job):
    """Strength, MPa, and states of the way that were not at rest."""
    width, length, direction, pitch, gauge, seed = job
    found, restless = Pull(
        strip(width, length, direction, pitch, seed=seed, **({"yarn.weibull_gauge_length": gauge} if gauge else {}))
    ).strength()
    return 1e-6 * float(found), int(restless)


def ensemble(study, cases, samples):
    """Strengths, MPa, of so many draws of each case, and states that were not at rest."""
    found = study.each(pulled, [(*case, seed) for k, case in enumerate(cases) for seed in range(1000 * k, 1000 * k + samples)])
    return [[one for one, _ in found[k * samples : (k + 1) * samples]] for k in range(len(cases))], sum(
        restless for _, restless in found
    )


def longer(gauge, shape, modulus, found, wanted):
    """The gauge length at which strips of the strength `found` have the strength `wanted`: their strains at break go with its
    1/m-th power."""
    strain = lambda stress: scipy.optimize.brentq(lambda e: modulus * (1 + e) * ((1 + e) ** 2 - 1) / 2 - stress, 0, 0.2)
    return gauge * (strain(wanted) / strain(found)) ** shape


def answer(study):
    measured, full = strength.measured("fabric"), study.effort == FULL
    # In short form the strips are smaller.
    scale, samples = (1e-3, SAMPLES) if full else (3e-4, 3)
    strips = [(scale * row["size_mm"][0], scale * row["size_mm"][1], row["direction"]) for row in measured]
    scene = strip(*strips[0])
    gauge, shape, modulus = (scene[f"yarn.{name}"] for name in ("weibull_gauge_length", "weibull_shape", "modulus_mean"))
    pitches = (0.75e-3, 6e-3) if full else ()
    cases = [(*case, None, None) for case in strips] + [(*strips[0], pitch, None) for pitch in pitches]
    alone, restless = ensemble(study, cases, samples)
    first, _ = weibull(alone[0])
    fitted, low, high = (
        longer(gauge, shape, modulus, 1e6 * value, 1e6 * measured[0]["scale_mpa"])
        for value in (first.value, first.high, first.low)
    )
    longest, more = ensemble(study, [(*case, None, float(f"{fitted:.3g}")) for case in strips], samples)
    heading = (
        "strip; measured MPa; its shape; model, yarn at 50 mm: MPa [95 %]; off %; verdict; shape; "
        "with the fitted length: MPa [95 %]; off %; verdict; if all yarns shared at each crossing: MPa"
    ).split("; ")
    lines = []
    for k, (row, case) in enumerate(zip(measured, strips)):
        name, allowed = f"{1e3 * case[0]:.0f} mm x {1e3 * case[1]:.0f} mm, {case[2]}", about(row["scale_mpa"], 0.1)
        (plain, m), (after, _) = weibull(alone[k]), weibull(longest[k])
        # The error of the fit is in what it predicts.
        spread = math.hypot((after.high - after.value) / after.value, (first.high - first.value) / first.value) if k else 0.0
        after = Estimate(after.value, after.value * (1 - spread), after.value * (1 + spread))
        off = lambda estimate: f"{100 * (estimate.value / row['scale_mpa'] - 1):+.1f}"
        verdict = after.verdict(allowed) if k else "fitted"
        alike = [plain.text(0), off(plain), plain.verdict(allowed), f"{m:.0f}", after.text(0), off(after), verdict]
        lines.append([name, row["scale_mpa"], row["shape"], *alike, f"{weibull(shared(*case[:2], k))[0].value:.0f}"])
    columns = {"yarn at 50 mm": alone, f"yarn at {fitted:.3g} m": longest}
    study.write(
        "strips",
        [
            {"strip": line[0], "draw": k} | {name: found[n][k] for name, found in columns.items()}
            for n, line in enumerate(lines)
            for k in range(samples)
        ],
    )
    text = (
        f"Allowed are ± 10 %. Each model value is of {samples} samples. {restless + more} states of rest were not reached.\n\n"
        + page.markdown(heading, lines)
    )
    text += (
        f"\nThe gauge length for which yarn of the measured strength gives the first strip its strength: {fitted:.2g} m "
        f"[{low:.2g}, {high:.2g}]; the yarn was measured at {1e3 * gauge:.0f} mm.\n"
    )
    rows = [[f"{1e3 * pitch:g} mm", weibull(samples)[0].text(0)] for pitch, samples in zip(pitches, alone[len(strips) :])]
    text += "\nThe first strip with other distances between crossings along the pull:\n\n" + page.markdown(
        ["distance", "MPa [95 %]"], rows
    )
    sheets = [(f"strip of {1e3 * width:.0f} mm, edges free", width, "two_sides") for width in (0.025, 0.05)] + [
        ("the same, edges held", 0.05, "four_sides")
    ]
    at, rows, series = (1, 2, 5, 10, 20, 40, 60), [], []
    length = 0.2 if full else 0.1
    for (name, _, _), (load, beside) in zip(
        sheets, study.each(returned, [(width, length, sides) for _, width, sides in sheets], "a cut yarn")
    ):
        rows.append([name, *(f"{load[k - 1]:.2f}" if k <= len(load) else "" for k in at), f"{beside:.2f}"])
        series.append(Series(name, list(enumerate(load, 1)), "line"))
    rows.append(["all other yarns rigid, closed form", *(f"{rigid(k - 0.5):.2f}" for k in at), "1"])
    series.append(Series("all other yarns rigid, closed form", [(k, rigid(k - 0.5)) for k in range(1, 67)], "dashed"))
    drawing.draw(
        study.folder / "strips.svg",
        "Load of a cut yarn at a strain of 1.3 %",
        "distance from the cut (bars)",
        "load / load of a whole yarn",
        series,
        "from zero",
    )
    text += (
        "\nLoad of a yarn that is cut, over that of a whole yarn, so many bars from the cut, at a strain of 1.3 %; no other "
        "breaks:\n\n"
    )
    text += page.markdown(["", *map(str, at), "most beside the cut"], rows)
    study.table("strips", "Strips of Kevlar 49 fabric in the network", text)
    study.picture("strips.svg", "strips.svg")
