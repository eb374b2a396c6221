//! The damage law at its edges.

use super::{Answer, Case};
use fabric::Scene;
use fabric::yarn::{Segment, twice_strain_at};

/// alpha at U_c, far beyond it, and the energy of one jump to failure.
pub fn rows() -> Vec<Case> {
    let law = Scene::sheet_3in_sphere().damage_law();
    let segment = Segment { modulus: 140.21e9, damage_rate: 230.6 };
    let alpha = move |stretch: f64| law.alpha(segment.damage_rate, twice_strain_at(stretch));
    let row = |name: &str, expected: &str, check: Box<dyn Fn() -> Answer + Sync + Send>| Case {
        theme: "Damage law",
        name: name.to_string(),
        expected: expected.to_string(),
        long: false,
        check: Box::new(move || Ok(check())),
    };
    vec![
        row(
            "U exactly U_c",
            "alpha = 1",
            Box::new(move || Answer::plain(format!("alpha = {}", alpha(1.03)), alpha(1.03) == 1.0)),
        ),
        row(
            "lambda (U - U_c) > 700, U up to 1e150",
            "alpha = 0",
            Box::new(move || {
                let values = [5.0, 1e3, 1e100, 1e150].map(alpha);
                Answer::plain(format!("alpha = {values:?}"), values == [0.0; 4])
            }),
        ),
        row(
            "dissipation of one jump to failure",
            "86.6265224 MJ/m^3 (1e-8)",
            Box::new(move || {
                let mega = 1e-6 * law.dissipated(&segment, 0.0);
                Answer::plain(format!("{mega:.7} MJ/m^3"), (mega / 86.6265224 - 1.0).abs() < 1e-8)
            }),
        ),
    ]
}
