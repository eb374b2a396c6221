//! The Pareto front of cost and error, and what to take for a wanted error.
//!
//! An error below the resolution of the means (two standard errors of their difference) is no error that anyone has seen: it
//! counts as the resolution. The deviation behind it is pooled over the full network's accepted steps with velocity Verlet,
//! because a deviation of ten runs is itself uncertain by a quarter.
//!
//! A setting is on the front of a measure if no other one costs no more and errs no more, with one of the two less. It is on
//! the front of all measures if no other one is at least as good in all of them and in cost, and better in one. Steps that the
//! kernel refuses, a toe (it changes the yarn law), and the reference do not compete.

use super::impact::{ABSORBED, COUNT, Ensemble, MEASURES, Network, RESIDUAL, Setting};
use super::{Cell, Table};

/// The fronts: by node-steps and by seconds among all settings, and the same among those on the full network.
pub const NAMES: [&str; 4] = ["steps", "seconds", "steps_full_network", "seconds_full_network"];

/// Membership of a front.
#[derive(Clone, Copy, Default)]
pub struct Front {
    /// Of each measure.
    pub each: [bool; COUNT],
    /// Of all measures together.
    pub all: bool,
}

/// A setting with its errors.
pub struct Row {
    /// Its runs.
    pub ensemble: Ensemble,
    /// Error of the mean, relative to the reference; of the energy residual its size over KE0.
    pub error: [f64; COUNT],
    /// Below this an error means nothing.
    pub resolution: [f64; COUNT],
    /// On which fronts it is, see [`NAMES`].
    pub fronts: [Front; 4],
    /// What the errors are counted from.
    pub reference: bool,
}

impl Row {
    /// The error that counts.
    fn counted(&self, index: usize) -> f64 {
        self.error[index].max(self.resolution[index])
    }

    /// Whether it competes.
    fn competes(&self) -> bool {
        let setting = &self.ensemble.setting;
        !self.reference && setting.accepted() && setting.toe == 0.0 && self.ensemble.runs > 0
    }

    fn cost(&self, by_seconds: bool) -> f64 {
        if by_seconds { self.ensemble.seconds } else { self.ensemble.node_steps }
    }

    /// Initials of the measures on whose front it is; `*` if on the front of all.
    pub fn marks(&self, front: usize) -> String {
        if self.reference {
            return "reference".to_string();
        }
        let initials = ["A", "V", "P", "X", "F", "E"];
        let Front { each, all } = self.fronts[front];
        let own: String = (0..COUNT).filter(|&index| each[index]).map(|index| initials[index]).collect();
        if all { format!("{own} *").trim().to_string() } else { own }
    }
}

/// All settings of a case.
pub struct Judged {
    /// In the order given, the reference first.
    pub rows: Vec<Row>,
    /// Chaos floor: standard deviation of one run over the reference (of the energy residual: itself).
    pub floor: [f64; COUNT],
    /// Resolution of means of as many runs as the reference has.
    pub resolution: [f64; COUNT],
}

/// Compares every ensemble with the first.
pub fn judge(ensembles: Vec<Ensemble>) -> Judged {
    let reference: Vec<f64> = ensembles.first().map_or(vec![f64::NAN; COUNT], |first| first.mean.to_vec());
    let first_runs = ensembles.first().map_or(0, |first| first.runs) as f64;
    let pooled = |index: usize| {
        let plain = |of: &&Ensemble| {
            let setting = of.setting;
            setting.accepted() && setting == Setting::verlet(setting.step)
        };
        let squares: Vec<f64> = ensembles.iter().filter(plain).map(|of| of.deviation[index].powi(2)).collect();
        let scale = if index == RESIDUAL { 100.0 } else { reference[index].abs() };
        crate::report::mean(&squares).sqrt() / scale
    };
    let floor: [f64; COUNT] = std::array::from_fn(pooled);
    let resolution = |index: usize, runs: f64| match index {
        // The true value is known, and the spread differs from step to step: each row has its own.
        RESIDUAL => 0.0,
        _ => 2.0 * floor[index] * (1.0 / runs + 1.0 / first_runs).sqrt(),
    };
    let mut rows: Vec<Row> = ensembles
        .into_iter()
        .enumerate()
        .map(|(number, ensemble)| Row {
            error: std::array::from_fn(|index| match index {
                RESIDUAL => 0.01 * ensemble.mean[index].abs(),
                _ => (ensemble.mean[index] / reference[index] - 1.0).abs(),
            }),
            resolution: std::array::from_fn(|index| match index {
                RESIDUAL => 0.02 * ensemble.deviation[index] / (ensemble.runs as f64).sqrt(),
                _ => resolution(index, ensemble.runs as f64),
            }),
            fronts: [Front::default(); 4],
            reference: number == 0,
            ensemble,
        })
        .collect();
    for number in 0..rows.len() {
        rows[number].fronts = [(false, false), (true, false), (false, true), (true, true)]
            .map(|(by_seconds, full_only)| front(&rows, number, by_seconds, full_only));
    }
    Judged { rows, floor, resolution: std::array::from_fn(|index| resolution(index, first_runs)) }
}

/// On what part of a front a row is.
fn front(rows: &[Row], number: usize, by_seconds: bool, full_only: bool) -> Front {
    let row = &rows[number];
    let among = |of: &Row| of.competes() && (!full_only || of.ensemble.setting.network == Network::Full);
    let beaten = |measures: &[usize]| {
        let mut others = rows.iter().enumerate().filter(|(other, of)| *other != number && among(of));
        others.any(|(_, other)| beats(other, row, measures, by_seconds))
    };
    if !among(row) {
        return Front::default();
    }
    let all: [usize; COUNT] = std::array::from_fn(|index| index);
    Front { each: std::array::from_fn(|index| !beaten(&[index])), all: !beaten(&all) }
}

/// At least as good in cost and these measures, and better in one.
fn beats(other: &Row, row: &Row, measures: &[usize], by_seconds: bool) -> bool {
    let cost = (other.cost(by_seconds), row.cost(by_seconds));
    let errors = || measures.iter().map(|&index| (other.counted(index), row.counted(index)));
    let no_worse = cost.0 <= cost.1 && errors().all(|(a, b)| a <= b);
    no_worse && (cost.0 < cost.1 || errors().any(|(a, b)| a < b))
}

/// Says whether the default is on the fronts.
pub fn verdict(judged: &Judged) -> String {
    let Some(default) = judged.rows.iter().find(|row| row.ensemble.setting.is_default()) else {
        return "the default was not run".to_string();
    };
    let said = |among: &str, Front { each, all }: Front| {
        let on: Vec<&str> = (0..COUNT).filter(|&index| each[index]).map(|index| MEASURES[index].name).collect();
        let on = if on.is_empty() { "none".to_string() } else { on.join(", ") };
        format!(
            "{among}: {} the front of all measures together, and on that of {on}",
            if all { "on" } else { "NOT on" }
        )
    };
    format!(
        "The default (Verlet, 0.4 dt_crit) is, {}; {}; {}; {}.",
        said("among the settings on the full network, by node-steps", default.fronts[2]),
        said("by seconds", default.fronts[3]),
        said("among all settings, by node-steps", default.fronts[0]),
        said("by seconds", default.fronts[1])
    )
}

/// Wanted errors of the ensemble mean of the absorbed energy.
const WANTED: [f64; 7] = [0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001];

/// "For this error in the ensemble mean take this: it costs that." The error of a mean of n runs is taken as
/// sqrt(error^2 + floor^2/n), with an error that cannot be told from 0 counted as one standard error of the difference.
pub fn choice(judged: &Judged) -> Table {
    let mut table = Table::new(&[
        "wanted error of absorbed energy",
        "take",
        "dt/dt_crit",
        "runs",
        "node-steps in all",
        "CPU s in all",
        "expected error",
        "energy residual % of KE0",
    ]);
    for wanted in WANTED {
        let mut best: Option<(f64, usize, &Row, f64)> = None;
        for row in judged.rows.iter().filter(|row| row.competes()) {
            let own = row.error[ABSORBED].max(0.5 * row.resolution[ABSORBED]);
            let spread = judged.floor[ABSORBED];
            if own.is_nan() || own >= wanted {
                continue;
            }
            let runs = (spread * spread / (wanted * wanted - own * own)).ceil().max(1.0);
            let cost = runs * row.ensemble.node_steps;
            if best.is_none_or(|(least, ..)| cost < least) {
                best = Some((cost, runs as usize, row, (own * own + spread * spread / runs).sqrt()));
            }
        }
        let percent = |value: f64| format!("{} %", crate::report::shortest(100.0 * value));
        table.add(match best {
            Some((cost, runs, row, error)) => vec![
                Cell::Number(wanted, percent(wanted)),
                Cell::text(row.ensemble.setting.family()),
                Cell::plain(row.ensemble.setting.step, 2),
                Cell::plain(runs as f64, 0),
                Cell::power(cost, 1),
                Cell::plain(runs as f64 * row.ensemble.seconds, 2),
                Cell::Number(error, format!("{:.2} %", 100.0 * error)),
                Cell::plain(row.ensemble.mean[RESIDUAL], 4),
            ],
            None => {
                let mut cells = vec![Cell::text(""); 8];
                cells[0] = Cell::Number(wanted, percent(wanted));
                cells[1] = Cell::text("below what these ensembles can show");
                cells
            }
        });
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ensemble(step: f64, cost: f64, absorbed: f64, residual: f64) -> Ensemble {
        let mut mean = [1.0; COUNT];
        (mean[ABSORBED], mean[RESIDUAL]) = (absorbed, residual);
        let mut deviation = [0.0; COUNT];
        deviation[ABSORBED] = 0.01;
        let (setting, trouble) = (Setting::verlet(step), Vec::new());
        Ensemble { setting, runs: 8, mean, deviation, node_steps: cost, seconds: cost, trouble }
    }

    #[test]
    fn the_front_counts_no_error_below_the_resolution() {
        // Reference 1 ± 0.01: means of eight runs resolve 0.01.
        let judged = judge(vec![
            ensemble(0.05, 8.0, 1.0, 0.0),
            ensemble(0.1, 4.0, 1.001, 0.01),
            ensemble(0.2, 2.0, 1.004, 0.1),
            ensemble(0.4, 1.0, 1.02, 1.0),
            ensemble(0.3, 1.5, 1.03, 0.5),
            ensemble(0.7, 0.5, 1.0, 0.0),
        ]);
        assert!((judged.resolution[ABSORBED] - 0.01).abs() < 1e-12);
        let on: Vec<bool> = judged.rows.iter().map(|row| row.fronts[0].each[ABSORBED]).collect();
        assert_eq!(on, [false, false, true, true, false, false]);
        let all: Vec<bool> = judged.rows.iter().map(|row| row.fronts[0].all).collect();
        assert_eq!(all, [false, true, true, true, true, false], "the energy residual tells them apart");
        assert!(judged.rows.iter().all(|row| row.fronts.iter().all(|front| front.each == row.fronts[0].each)));
    }

    #[test]
    fn the_choice_is_the_cheapest_that_meets_the_wish() {
        let judged =
            judge(vec![ensemble(0.05, 8.0, 1.0, 0.0), ensemble(0.2, 2.0, 1.004, 0.1), ensemble(0.4, 1.0, 1.015, 1.0)]);
        let table = choice(&judged);
        // 0.05: one run at 0.4; 0.01: (0.01^2 - 0.005^2) leaves room for the spread of two runs at 0.2.
        assert_eq!((table.rows[1][2].shown(), table.rows[1][3].shown()), ("0.40", "1"));
        assert_eq!((table.rows[3][2].shown(), table.rows[3][3].shown()), ("0.20", "2"));
        assert!(table.rows[6][1].shown().starts_with("below"));
    }
}
