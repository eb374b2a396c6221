//! The quarter model against the whole sheet, point by point until the first segment fails. Beyond, the whole sheet leaves
//! symmetry by rounding: its ensembles stand beside the quarter's in `impact.rs`.
//!
//! Contact amplifies rounding too, long before the first failure: nodes that leave and meet the projectile at slightly other
//! steps. So a second whole sheet stands beside the quarter, whose impact velocity differs by 1e-12: what the two whole sheets
//! differ by, no comparison can do better.

use super::impact::{self, CASES, Network, Setting};
use super::{Cell, Effort, Table};
use crate::memory::Buffers;
use crate::{Result, say};
use fabric::Sim;
use fabric::internals::parts::STEP_DEFAULT_FRACTION;
use std::path::Path;

/// Steps at which the sheets are compared, as long as nothing has failed.
const LOOKS: [u64; 7] = [400, 1000, 2000, 3000, 4000, 5500, 7000];
/// Allowed difference of a position at the first look, when contact has not yet amplified rounding, in node spacings.
const TOLERANCE: f64 = 1e-9;

/// False if the quarter is another sheet than the whole.
pub fn run(effort: Effort, out: &Path) -> Result<bool> {
    let cases: Vec<_> = CASES.iter().filter(|case| !case.stochastic).collect();
    let cases = if effort == Effort::Smoke { &cases[..1] } else { &cases };
    let mut table = Table::new(&[
        "case",
        "step",
        "time us",
        "position: quarter, whole (h)",
        "position: whole, V0 by 1e-12 (h)",
        "velocity: quarter, whole (m/s)",
        "velocity: whole, V0 by 1e-12 (m/s)",
    ]);
    let mut sound = true;
    for case in cases {
        let whole = Setting::verlet(STEP_DEFAULT_FRACTION);
        let quarter = Setting { network: Network::Quarter, ..whole };
        let scenes =
            [(whole, 0), (quarter, 0), (whole, 1)].map(|(setting, k)| impact::scene(case, &setting, k, effort));
        let [mut first, mut second, mut third] =
            [Buffers::of(&scenes[0])?, Buffers::of(&scenes[1])?, Buffers::of(&scenes[2])?];
        let mut sims = [first.sim(&scenes[0])?, second.sim(&scenes[1])?, third.sim(&scenes[2])?];
        for look in LOOKS {
            for sim in &mut sims {
                sim.advance(look - sim.step_count())?;
            }
            if sims.iter().any(|sim| sim.counters().failed_segments > 0) {
                break;
            }
            let [sheet, part, other] = &sims;
            let apart = difference(sheet, part)?;
            let velocity = |sim: &Sim<'_>| -> Result<f64> {
                Ok((sim.projectile()?.velocity[2] - sheet.projectile()?.velocity[2]).abs())
            };
            sound &= look > LOOKS[0] || apart < TOLERANCE;
            table.add(vec![
                Cell::text(case.name),
                Cell::Number(look as f64),
                Cell::Number(1e6 * sheet.time()),
                Cell::Number(apart),
                Cell::Number(difference(sheet, other)?),
                Cell::Number(velocity(part)?),
                Cell::Number(velocity(other)?),
            ]);
        }
    }
    table.write(&out.join("quarter.csv"))?;
    if !sound {
        say::line(format_args!(
            "at step {} the quarter is off by more than {TOLERANCE:e} h: NOT as it must be",
            LOOKS[0]
        ));
    }
    Ok(sound)
}

/// Largest difference of a coordinate over the nodes that both model, in node spacings.
fn difference(whole: &Sim<'_>, part: &Sim<'_>) -> Result<f64> {
    let positions = |sim: &Sim<'_>| -> Result<Vec<f64>> {
        let mut x = vec![0.0; 3 * sim.layout().nodes()];
        sim.copy_positions(&mut x)?;
        Ok(x)
    };
    let (x, y) = (positions(whole)?, positions(part)?);
    let (columns, all) = (part.layout().nodes_x, whole.layout().nodes_x);
    let apart = |k: usize| {
        let at = 3 * (k / columns * all + k % columns);
        (0..3).map(|c| (x[at + c] - y[3 * k + c]).abs()).fold(0.0, f64::max)
    };
    Ok((0..part.layout().nodes()).map(apart).fold(0.0, f64::max) / whole.scene().sheet.spacing)
}
