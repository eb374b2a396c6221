"""Convergence in the network of bodies with edges: fragment simulator, cube, flat-ended cylinder, beside a sphere, on cloth with
its thickness and on a surface without.

Method: ballistic limit of hits that differ by their place in a cell, found by bisection, and the energy absorbed at one velocity
above it; Kevlar KM2 S706, 75 mm wide, four sides held, bonded plies of the assumed thickness, bars for 2, 1, 1/2 and 1/4 yarns,
the last two graded. All bodies weigh 1.1 g.
Limits: few hits; a quarter of a yarn for two bodies on ten plies, with thickness only.
"""

from fabric_kernel import Scene, drawing

from . import page
from .comparison import mean_of
from .hits import BISECTION, GRADED, impact, limit, sheet, shot
from .oneply import THICKNESS
from .statistics import deviation, mean
from .study import FULL

WIDTH, LONGEST = 0.075, 1e-3
# Hits by yarns a bar; plies with the velocity from which a limit is sought, and that of the energy, m/s.
HITS, PACKS = {2.0: 4, 1.0: 4, 0.5: 4, 0.25: 2}, ((10, 300.0, 500.0), (28, 500.0, 900.0))
BODIES = {
    "fragment simulator": {"shape": "fsp", "calibre": ".22"},
    "cube": {"shape": "box", "size": [5.195e-3] * 3, "mass": 1.1e-3},
    "flat cylinder": {"shape": "cylinder", "radius": 2.73e-3, "length": 5.98e-3, "mass": 1.1e-3},
    "sphere": {"shape": "sphere", "radius": 3.222e-3, "mass": 1.1e-3},
}
FINEST = ("fragment simulator", "sphere")
"""Bodies that meet the finest network, on ten plies: on 28 a shot takes a quarter of a minute."""
# One ply: width of the sheet, m, and velocity from which its limit is sought, m/s; the sphere and the thickness of oneply.py.
WIDTHS, BALL = ((0.051, 66.0), (0.102, 133.0)), {"shape": "sphere", "radius": 2.778e-3, "mass": 6.9e-4}


def scene_of(plies, body, thick, bar, width=WIDTH):
    assumed = Scene("sheet_3in_sphere", fabric={"name": "kevlar_km2_s706"})["sheet.thickness"]
    scene = sheet({"name": "kevlar_km2_s706", "thickness": assumed if thick else 0.0}, width, bar)
    return scene.replace({"sheet.plies": plies, "projectile": BODIES[body]})


def fine(scene, guess, bar):
    """The scene, with a graded network where bars are shorter than a yarn's spacing."""
    return shot(scene, guess, 0).graded(GRADED) if bar < 1.0 else scene


def measured(job):
    scene, guess, fast, hit = job
    return limit(scene, guess, hit, LONGEST), impact(shot(scene, fast, hit), LONGEST)["absorbed"]


def one_ply(study):
    """A table: limits of one ply with its thickness and without."""
    thicknesses, hits = (2e3 * THICKNESS, 0.0), 4 if study.effort == FULL else 2
    cases = [(width, guess, t) for width, guess in WIDTHS[: 2 if study.effort == FULL else 1] for t in thicknesses]
    scenes = [
        sheet({"name": "kevlar_km2_s706", "thickness": 1e-3 * t}, width, 1.0).replace(projectile=BALL) for width, _, t in cases
    ]
    jobs = [(scene, guess, 2 * guess, hit) for scene, (_, guess, _) in zip(scenes, cases) for hit in range(hits)]
    found, rows = iter(study.each(measured, jobs, "one ply")), []
    for width, _, t in cases:
        limits = [next(found)[0] for _ in range(hits)]
        row = {"width mm": 1e3 * width, "thickness mm": t, "hits": hits, "limit m/s": mean(limits)}
        rows.append(row | {"limit m/s: deviation": deviation(limits)})
    study.write("one_ply", rows)
    lines = [[f"{row['width mm']:.0f}", f"{row['thickness mm']:g}", mean_of(row, "limit m/s", BISECTION).text(1)] for row in rows]
    return page.markdown(["width, mm", "thickness, mm", "limit, m/s"], lines, 0)


def answer(study):
    full = study.effort == FULL
    bars, packs, width = (list(HITS), PACKS, WIDTH) if full else ([2.0, 1.0], PACKS[:1], 0.03)
    networks = [(bar, *pack, body, thick) for bar in bars for pack in packs for body in BODIES for thick in (True, False)]
    few = PACKS[0][0]
    networks = [one for one in networks if one[0] > min(HITS) or (one[1] == few and one[-2] in FINEST and one[-1])]
    jobs = [
        (fine(scene_of(plies, body, thick, bar, width), guess, bar), guess, fast, hit)
        for bar, plies, guess, fast, body, thick in networks
        for hit in range(HITS[bar] if full else 2)
    ]
    found, rows = iter(study.each(measured, jobs, "mesh")), []
    for bar, plies, _, fast, body, thick in networks:
        limits, absorbed = zip(*(next(found) for _ in range(HITS[bar] if full else 2)))
        row = {"plies": plies, "projectile": body, "thickness": "assumed" if thick else "none", "yarns a bar": bar}
        row |= {"hits": len(limits), "limit m/s": mean(limits), "limit m/s: deviation": deviation(limits)}
        rows.append(row | {"energy at m/s": fast, "absorbed J": mean(absorbed), "absorbed J: deviation": deviation(absorbed)})
    study.write("mesh", rows)
    table = []
    figure, panels = drawing.new(7.4, 4.2, len(packs), sharey=False, squeeze=False)
    for axis, (plies, *_) in zip(panels[0], packs):
        for number, body in enumerate(BODIES):
            for thick in ("assumed", "none"):
                own = [row for row in rows if (row["plies"], row["projectile"], row["thickness"]) == (plies, body, thick)]
                ours = [mean_of(row, "limit m/s", BISECTION) for row in own]
                style = "marked" if thick == "assumed" else "dashed"
                label = body if thick == "assumed" else f"{body}, no thickness"
                style = {"color": drawing.COLOURS[number], "label": label, **drawing.STYLES[style]}
                axis.plot(bars[: len(own)], [one.value for one in ours], **style)
                energy = [f"{row['absorbed J']:.1f}" for row in own]
                lacking = ["–"] * (len(bars) - len(own))
                table.append([plies, body, thick, *(one.text(0) for one in ours), *lacking, *energy, *lacking])
        axis.set(xscale="log", xlabel="yarns a bar", ylabel="ballistic limit (m/s)", ylim=(0, None), title=f"{plies} plies")
        axis.set_xticks(bars, [f"{bar:g}" for bar in bars], minor=False)
        axis.minorticks_off()
    drawing.below(figure, *panels[0])
    drawing.save(figure, study.folder / "mesh.svg")
    study.picture("mesh.svg", "mesh.svg")
    heading = ["plies", "projectile", "thickness", *(f"limit, {bar:g} yarns a bar" for bar in bars)]
    heading += [f"J, {bar:g} yarns a bar" for bar in bars]
    single = "\n## One ply and a sphere of 0.69 g\n\n" + one_ply(study)
    text = "Limits in m/s with 95 % intervals; J: energy absorbed at "
    text += " and ".join(f"{fast:g} m/s by {plies} plies" for plies, _, fast in packs) + ".\n\n"
    study.table("mesh", "Convergence in the network of bodies with edges", text + page.markdown(heading, table, 3) + single)
