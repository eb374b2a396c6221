//! The claims of the paper and what the ensembles say of each. Every verdict is computed by the rule of statistics.rs: the 95 %
//! interval of ours lies inside the range that the claim allows ("agrees"), outside ("does not"), or across its edge
//! ("cannot be told"). Ranges are fixed here, beside the claim.

use super::html::Page;
use super::jobs::{FirstFailure, Reading, Record, Runs};
use super::map::{self, Cell};
use super::micro::Micro;
use super::plan::{self, ATTACHMENTS, Effort, HISTORY_ENERGIES, Yarn, attachment_name};
use super::statistics::{Estimate, Verdict};
use crate::report;
use fabric::AttachmentKind::{self, FourCorners, FourSides, TwoSides};

/// "Close", "similar": at most this factor apart. The paper's other factors are 2 and 3.
const CLOSE: f64 = 1.5;
/// "About three times".
const THREEFOLD: [f64; 2] = [2.0, 4.0];
/// "Slightly over-predicts".
const SLIGHTLY: [f64; 2] = [1.0, 1.2];
/// "Two to four times".
const TWO_TO_FOUR: [f64; 2] = [2.0, 4.0];
/// Mean numbers that round to "four" and to "one or two".
const FOUR: [f64; 2] = [3.5, 4.5];
const ONE_OR_TWO: [f64; 2] = [0.5, 2.5];
/// "In most runs".
const MOST: [f64; 2] = [0.5, 1.0];
/// Impact energies that count as low and as high, J.
const LOW: [f64; 4] = [2.5, 5.0, 7.5, 10.0];
const HIGH: [f64; 3] = [80.0, 160.0, 320.0];
/// Impact energies about the ballistic limit of sheets held at their corners, J.
const ABOUT_LIMIT: [f64; 5] = [5.0, 7.5, 10.0, 15.0, 20.0];
/// Time between two events that follow one another rather than happen together, s: the coarse pause between samples.
const APART: f64 = 10e-6;

/// One quantity that a claim speaks of.
struct Check {
    /// What it is; empty if the claim says so.
    name: String,
    ours: Estimate,
    range: [f64; 2],
    digits: usize,
}

impl Check {
    fn verdict(&self) -> Verdict {
        Verdict::of(&self.ours, self.range)
    }

    fn text(&self) -> String {
        let ours = self.ours.text(self.digits);
        if self.name.is_empty() { ours } else { format!("{}: {ours}", self.name) }
    }
}

/// A claim with its answer.
pub struct Claim {
    part: &'static str,
    claim: String,
    /// What it allows, in words.
    allows: String,
    checks: Vec<Check>,
    verdict: Verdict,
    /// What else there is to say.
    note: String,
}

impl Claim {
    /// A claim that must hold at every check.
    fn all(part: &'static str, claim: &str, allows: &str, checks: Vec<Check>, note: &str) -> Claim {
        let verdict = Verdict::all(&checks.iter().map(Check::verdict).collect::<Vec<_>>());
        Claim { part, claim: claim.into(), allows: allows.into(), checks, verdict, note: note.into() }
    }

    /// A claim that must hold somewhere.
    fn any(part: &'static str, claim: &str, allows: &str, checks: Vec<Check>, note: &str) -> Claim {
        let verdict = Verdict::any(&checks.iter().map(Check::verdict).collect::<Vec<_>>());
        Claim { part, claim: claim.into(), allows: allows.into(), checks, verdict, note: note.into() }
    }

    /// The sentence behind the verdict, made from the checks.
    fn why(&self) -> String {
        let with = |verdict: Verdict| -> Vec<&str> {
            self.checks.iter().filter(|check| check.verdict() == verdict).map(|check| check.name.as_str()).collect()
        };
        let mut parts = Vec::new();
        let count = self.checks.len();
        for (verdict, word) in
            [(Verdict::Agrees, "inside"), (Verdict::DoesNot, "outside"), (Verdict::CannotBeTold, "across the edge")]
        {
            let names = with(verdict);
            if names.len() == count && count > 1 {
                parts.push(format!("all {count} {word}"));
            } else if count == 1 && names.len() == 1 {
                parts.push(word.to_string());
            } else if !names.is_empty() && verdict == Verdict::Agrees {
                parts.push(format!("{} of {count} {word}", names.len()));
            } else if !names.is_empty() {
                parts.push(format!("{word}: {}", names.join(", ")));
            }
        }
        if self.checks.is_empty() {
            parts.push("no points".to_string());
        }
        if !self.note.is_empty() {
            parts.push(self.note.clone());
        }
        parts.join("; ")
    }
}

fn within(centre: f64, tolerance: f64) -> [f64; 2] {
    [centre - tolerance, centre + tolerance]
}

/// Claims about the micro scale (P1, P2, and Fig. 3 of P3).
pub fn of_micro(micro: &Micro) -> Vec<Claim> {
    let one = |part, claim: &str, ours: Estimate, centre: f64, tolerance: f64, digits| {
        let check = Check { name: String::new(), ours, range: within(centre, tolerance), digits };
        Claim::all(part, claim, &format!("{centre} ± {tolerance}"), vec![check], "")
    };
    let sudden = vec![
        Check { name: "aligned".into(), ours: Estimate::exact(micro.aligned_left), range: [0.0, 0.0], digits: 3 },
        Check { name: "misaligned".into(), ours: micro.misaligned_left, range: [0.5, 1.0], digits: 3 },
    ];
    let scale = |estimate: Estimate, factor: f64| Estimate {
        value: estimate.value / factor,
        low: estimate.low / factor,
        high: estimate.high / factor,
    };
    let more = vec![Check {
        name: "work to rupture, misaligned/aligned".into(),
        ours: scale(micro.work, micro.aligned_work),
        range: [1.0, f64::INFINITY],
        digits: 3,
    }];
    vec![
        one("P1", "Mean modulus of a yarn, GPa", micro.modulus, 140.21, 0.06, 3),
        one("P1", "Standard deviation of the modulus, GPa", micro.modulus_sd, 2.04, 0.05, 3),
        one("P2", "Slope of λ over E, 1/GPa", micro.slope, 7.91, 0.25, 3),
        one("P2", "λ at E = 0", micro.intercept, -878.46, 35.0, 1),
        one("P2", "Standard deviation of λ about the line", micro.residual, 8.35, 0.5, 3),
        one("P2", "Mean λ", micro.rate, 230.6, 1.0, 2),
        Claim::all(
            "P3",
            "An aligned yarn breaks suddenly, misaligned ones do not (Fig. 3)",
            "stress kept just beyond U_c: aligned 0, misaligned more than half",
            sudden,
            "",
        ),
        Claim::all(
            "P3",
            "A misaligned yarn absorbs more (Fig. 3)",
            "ratio above 1",
            more,
            "the law with the paper's fitted λ absorbs 86.6 MJ/m³, between the two",
        ),
    ]
}

/// Reads numbers of the 3 in sheet off the runs.
struct Reader<'a> {
    runs: &'a Runs,
    effort: Effort,
}

impl Reader<'_> {
    fn values(&self, kind: AttachmentKind, yarn: Yarn, energy: f64, value: impl Fn(&Record) -> f64) -> Vec<f64> {
        self.runs.values(&plan::small(self.effort, kind, yarn, energy), value)
    }

    /// Those of these energies that are computed.
    fn energies(&self, wanted: &[f64]) -> Vec<f64> {
        self.effort.energies().iter().copied().filter(|energy| wanted.contains(energy)).collect()
    }

    /// Whether more than half of the runs are not arrested.
    fn goes_through(&self, kind: AttachmentKind, yarn: Yarn, energy: f64) -> bool {
        let arrested = self.values(kind, yarn, energy, |record| f64::from(u8::from(record.arrested)));
        report::mean(&arrested) < 0.5
    }

    /// Energies at which no run of these ensembles is arrested: there nothing is capped.
    fn uncapped(&self, ensembles: &[(AttachmentKind, Yarn)]) -> Vec<f64> {
        let free = |energy: f64| {
            ensembles.iter().all(|&(kind, yarn)| {
                let records = self.runs.of(&plan::small(self.effort, kind, yarn, energy));
                !records.is_empty() && records.iter().all(|record| !record.arrested)
            })
        };
        self.effort.energies().iter().copied().filter(|&energy| free(energy)).collect()
    }

    /// Ratio of one quantity between two yarns.
    fn yarns(
        &self,
        kind: AttachmentKind,
        [above, below]: [Yarn; 2],
        energy: f64,
        value: fn(&Record) -> f64,
        range: [f64; 2],
    ) -> Check {
        let ours = Estimate::ratio(&self.values(kind, above, energy, value), &self.values(kind, below, energy, value));
        Check { name: format!("{}, {energy} J", attachment_name(kind)), ours, range, digits: 2 }
    }

    /// Mean of a number of the runs of one yarn; those for which it is not defined are left out.
    fn mean_of(
        &self,
        kind: AttachmentKind,
        yarn: Yarn,
        energy: f64,
        value: fn(&Record) -> f64,
        range: [f64; 2],
    ) -> Check {
        let values: Vec<f64> =
            self.values(kind, yarn, energy, value).into_iter().filter(|value| value.is_finite()).collect();
        Check { name: format!("{}, {energy} J", yarn.name()), ours: Estimate::mean(&values), range, digits: 2 }
    }

    /// Ratio of one quantity between two attachments, stochastic yarn.
    fn ratio(
        &self,
        above: AttachmentKind,
        below: AttachmentKind,
        energy: f64,
        value: fn(&Record) -> f64,
        range: [f64; 2],
    ) -> Check {
        let ours = Estimate::ratio(
            &self.values(above, Yarn::Stochastic, energy, value),
            &self.values(below, Yarn::Stochastic, energy, value),
        );
        let name = format!("{}/{} at {energy} J", attachment_name(above), attachment_name(below));
        Check { name, ours, range, digits: 2 }
    }

    /// Mean of a number of the stochastic runs of one attachment.
    fn mean(&self, kind: AttachmentKind, energy: f64, name: &str, value: fn(&Record) -> f64, range: [f64; 2]) -> Check {
        Check { name: format!("{name}, {energy} J"), ..self.mean_of(kind, Yarn::Stochastic, energy, value, range) }
    }
}

const MORE: [f64; 2] = [1.0, f64::INFINITY];
const LESS: [f64; 2] = [0.0, 1.0];
const SIMILAR: [f64; 2] = [1.0 / CLOSE, CLOSE];
const PAIRS: [(AttachmentKind, AttachmentKind); 3] =
    [(FourCorners, TwoSides), (FourCorners, FourSides), (TwoSides, FourSides)];

/// Claims about the attachments (P3, Figs 14 to 17).
pub fn of_attachments(runs: &Runs, effort: Effort) -> Vec<Claim> {
    let reader = Reader { runs, effort };
    let readings: [Reading; 2] =
        [("read when detached", Record::at_detached), ("read when arrested or gone", |record| record.absorbed)];
    let mut claims = Vec::new();
    let ratios = |pairs: &[(AttachmentKind, AttachmentKind)], energies: &[f64], value, range| -> Vec<Check> {
        let at = |&energy: &f64| pairs.iter().map(move |&(a, b)| (a, b, energy));
        let all = energies.iter().flat_map(at);
        all.map(|(above, below, energy)| reader.ratio(above, below, energy, value, range)).collect()
    };
    let low = reader.energies(&LOW);
    let high = reader.energies(&HIGH);
    for (reading, value) in readings {
        claims.push(Claim::all(
            "P3",
            &format!("All three attachments absorb about the same at low energy ({reading})"),
            &format!("ratios within a factor {CLOSE}, up to 10 J"),
            ratios(&PAIRS, &low, value, SIMILAR),
            "where all runs are arrested the ratio is 1 by itself",
        ));
    }
    let most = [(FourCorners, TwoSides), (FourCorners, FourSides)];
    for (reading, value) in readings {
        claims.push(Claim::all(
            "P3",
            &format!("Corners absorb most at the high end ({reading})"),
            "ratios above 1, from 80 J",
            ratios(&most, &high, value, MORE),
            "",
        ));
    }
    let least = [(TwoSides, FourCorners), (TwoSides, FourSides)];
    let perforated = reader.uncapped(&ATTACHMENTS.map(|kind| (kind, Yarn::Stochastic)));
    for (reading, value) in readings {
        claims.push(Claim::all(
            "P3",
            &format!("Two sides absorb least ({reading})"),
            "ratios below 1, at every energy at which nothing is arrested",
            ratios(&least, &perforated, value, LESS),
            "",
        ));
    }
    let other = |energies: &[f64]| {
        let checks = ratios(&most, energies, |record| record.peak_kinetic, THREEFOLD);
        checks.iter().map(Check::text).collect::<Vec<_>>().join(", ")
    };
    let [slow, fast] = HISTORY_ENERGIES;
    let rest: Vec<f64> = high.iter().copied().filter(|&energy| energy != fast).collect();
    claims.push(Claim::all(
        "P3",
        "Kinetic energy of the fabric at corners is about three times that of the others (Figs 15-17)",
        &format!("ratios of the largest values in {} to {}, at {fast} J", THREEFOLD[0], THREEFOLD[1]),
        ratios(&most, &[fast], |record| record.peak_kinetic, THREEFOLD),
        &if rest.is_empty() { String::new() } else { format!("elsewhere {}", other(&rest)) },
    ));
    claims.push(Claim::all(
        "P3",
        "Strain energy is similar for all attachments (Figs 15-17)",
        &format!("ratios of the largest values within a factor {CLOSE}, at {slow} and {fast} J"),
        ratios(&PAIRS, &HISTORY_ENERGIES, |record| record.peak_strain, SIMILAR),
        "",
    ));
    let shares: [(Reading, &str); 2] = [
        (("strain/kinetic", |record| record.peak_strain / record.peak_kinetic), "largest strain energy"),
        (
            ("strain and dissipated/kinetic", |record| record.largest_yarn_work() / record.peak_kinetic),
            "largest sum of strain energy and energy dissipated by rupture",
        ),
    ];
    for (kind, number) in [(FourSides, 17), (TwoSides, 16)] {
        let stretched = reader.uncapped(&[(kind, Yarn::Stochastic)]);
        for ((name, value), what) in shares {
            let checks = stretched.iter().map(|&energy| reader.mean(kind, energy, name, value, MORE)).collect();
            let held = if kind == FourSides { "Four sides" } else { "Two sides" };
            claims.push(Claim::all(
                "P3",
                &format!("{held}: most energy goes into strain (Fig. {number}; {what})"),
                &format!("{what} over largest kinetic energy of the fabric above 1, at every energy at which nothing is arrested"),
                checks,
                "",
            ));
        }
    }
    claims.extend(of_two_sides(&reader));
    claims.extend(of_places(&reader));
    claims
}

/// "Two sides give more kinetic energy than four": whose, the wording leaves open.
fn of_two_sides(reader: &Reader<'_>) -> Vec<Claim> {
    let energies = reader.uncapped(&[TwoSides, FourSides].map(|kind| (kind, Yarn::Stochastic)));
    let readings: [(&str, Reading); 3] = [
        ("the fabric's", ("largest kinetic energy of the fabric", |record| record.peak_kinetic)),
        (
            "the fabric's, as a part of what it absorbs",
            ("largest kinetic energy of the fabric over the energy absorbed at the end", |record| {
                record.peak_kinetic / record.absorbed
            }),
        ),
        ("what the projectile keeps", ("kinetic energy of the projectile at the end", Record::left)),
    ];
    let claim = |(whose, (what, value)): (&str, Reading)| {
        Claim::all(
            "P3",
            &format!("Two sides give more kinetic energy than four ({whose})"),
            &format!("{what}: ratio above 1, at every energy at which nothing is arrested"),
            energies.iter().map(|&energy| reader.ratio(TwoSides, FourSides, energy, value, MORE)).collect(),
            "",
        )
    };
    readings.into_iter().map(claim).collect()
}

/// Where and in which order the sheets fail.
fn of_places(reader: &Reader<'_>) -> Vec<Claim> {
    let corners = HISTORY_ENERGIES
        .map(|e| reader.mean(FourCorners, e, "share at the washers", Record::share_at_attachments, [0.5, 1.0]));
    let mut claims = vec![Claim::all(
        "P3",
        "Sheets held at corners fail at the attachments",
        "more than half of the failed segments within 5 yarns of a washer",
        corners.into(),
        "",
    )];
    let number = |record: &Record| record.torn.iter().flatten().count() as f64;
    let torn = HISTORY_ENERGIES.map(|e| reader.mean(FourCorners, e, "corners torn", number, [0.0, 4.0]).text());
    let gaps: [Reading; 2] =
        [("first and last", |record| gap(record, usize::MAX)), ("first and second", |record| gap(record, 1))];
    let sayings = ["Corners do not fail all at once", "Corners fail one by one"];
    for ((which, value), claim) in gaps.into_iter().zip(sayings) {
        let apart = [1e6 * APART, f64::INFINITY];
        claims.push(Claim::all(
            "P3",
            claim,
            &format!("{which} corner that tears off more than {:.0} µs apart", 1e6 * APART),
            HISTORY_ENERGIES.map(|e| reader.mean(FourCorners, e, "µs apart", value, apart)).into(),
            &torn.join(", "),
        ));
    }
    for kind in [FourSides, TwoSides] {
        let shares = HISTORY_ENERGIES.map(|e| {
            let [centre, attachment]: [fn(&Record) -> f64; 2] = [Record::share_at_centre, Record::share_at_attachments];
            let text = |value| reader.mean(kind, e, "", value, [0.0, 1.0]).ours.text(2);
            format!("at {e} J {} at the centre and {} at the attachments", text(centre), text(attachment))
        });
        let more = |record: &Record| record.share_at_centre() - record.share_at_attachments();
        let note = match kind {
            TwoSides => "; the tear runs through the middle from one free edge to the other",
            _ => "",
        };
        claims.push(Claim::all(
            "P3",
            &format!("Clamped sheets fail at the centre, {}", attachment_name(kind)),
            "a larger share of the failed segments within 2 radii of the projectile from the centre than within 5 yarns of the clamps",
            HISTORY_ENERGIES.map(|e| reader.mean(kind, e, "difference of the shares", more, [0.0, 1.0])).into(),
            &(shares.join(", ") + note),
        ));
    }
    claims
}

/// Time between the first corner that tears off and a later one (the last, if there are not so many), µs; NaN for fewer than two.
fn gap(record: &Record, later: usize) -> f64 {
    let mut times: Vec<f64> = record.torn.iter().flatten().copied().collect();
    times.sort_by(f64::total_cmp);
    if times.len() < 2 { f64::NAN } else { 1e6 * (times[later.min(times.len() - 1)] - times[0]) }
}

/// Claims about uniform against stochastic yarn (P3, Figs 18 to 20).
pub fn of_uniform(runs: &Runs, effort: Effort) -> Vec<Claim> {
    let reader = Reader { runs, effort };
    let mut claims = Vec::new();
    for kind in [FourSides, TwoSides] {
        let energies = reader.uncapped(&[(kind, Yarn::Stochastic), (kind, Yarn::Uniform)]);
        let check = |&energy: &f64| Check {
            digits: 3,
            ..reader.yarns(kind, [Yarn::Uniform, Yarn::Stochastic], energy, Record::at_detached, SLIGHTLY)
        };
        claims.push(Claim::all(
            "P3",
            &format!("Uniform yarn over-predicts slightly, {}", attachment_name(kind)),
            &format!("ratio in {} to {}, at every energy at which nothing is arrested", SLIGHTLY[0], SLIGHTLY[1]),
            energies.iter().map(check).collect(),
            "",
        ));
    }
    let [slow, fast] = HISTORY_ENERGIES;
    for (what, value) in STRAINS {
        let checks = ATTACHMENTS.iter().flat_map(|&kind| {
            let yarns = [Yarn::Uniform, Yarn::Stochastic];
            HISTORY_ENERGIES.map(|energy| reader.yarns(kind, yarns, energy, value, TWO_TO_FOUR))
        });
        claims.push(Claim::all(
            "P3",
            &format!("Strain energy is two to four times larger in uniform sheets than in stochastic ones ({what})"),
            &format!("ratio in {} to {}, at {slow} and {fast} J", TWO_TO_FOUR[0], TWO_TO_FOUR[1]),
            checks.collect(),
            "",
        ));
    }
    claims.extend(of_corners(&reader));
    claims.extend(of_points(&reader));
    claims
}

/// What "strain energy" may be.
const STRAINS: [Reading; 2] = [
    ("its largest value", |record| record.peak_strain),
    ("strain and dissipated, when detached", Record::yarn_work_at_detached),
];

/// At how many corners sheets fail near the limit.
fn of_corners(reader: &Reader<'_>) -> Vec<Claim> {
    let readings: [(&str, Reading); 2] = [
        (
            "torn off",
            ("mean number of corners that tear off, of the sheets of which one does", |record| {
                defined(record.torn.iter().flatten().count())
            }),
        ),
        (
            "segments fail nearby",
            (
                "mean number of corners with a failed segment within 5 yarns of the washer, of the sheets that fail there",
                |record| defined(record.failed_corners as usize),
            ),
        ),
    ];
    let mut claims = Vec::new();
    for (yarn, saying, range) in [
        (Yarn::Uniform, "Near the limit uniform sheets fail at all four corners", FOUR),
        (Yarn::Stochastic, "Near the limit stochastic sheets fail at one or two corners", ONE_OR_TWO),
    ] {
        let limit =
            reader.energies(&ABOUT_LIMIT).into_iter().find(|&energy| reader.goes_through(FourCorners, yarn, energy));
        for (how, (what, value)) in readings {
            let text = |energy: f64| {
                let mean = reader.mean_of(FourCorners, yarn, energy, value, range).ours.text(1);
                let records = reader.runs.of(&plan::small(reader.effort, FourCorners, yarn, energy));
                let arrested = records.iter().filter(|record| record.arrested).count();
                format!("at {energy} J {mean}, {arrested} of {} arrested", records.len())
            };
            let note =
                if yarn == Yarn::Uniform { "; a mirror-symmetric sheet fails at all four or at none" } else { "" };
            let texts: Vec<String> = reader.energies(&ABOUT_LIMIT).into_iter().map(text).collect();
            claims.push(Claim::all(
                "P3",
                &format!("{saying} ({how})"),
                &format!(
                    "{what}: {} to {}, at the first impact energy at which more than half of the runs are not arrested",
                    range[0], range[1]
                ),
                limit.iter().map(|&energy| reader.mean_of(FourCorners, yarn, energy, value, range)).collect(),
                &(texts.join("; ") + note),
            ));
        }
    }
    claims
}

/// A number that says nothing where it is zero.
fn defined(number: usize) -> f64 {
    if number == 0 { f64::NAN } else { number as f64 }
}

/// At how many points uniform clamped sheets fail.
fn of_points(reader: &Reader<'_>) -> Vec<Claim> {
    type Count = fn(&FirstFailure) -> u64;
    let readings: [(&str, &str, Count); 2] = [
        ("segments that fail first", "segments that fail first, within one step of one another", |first| {
            first.segments
        }),
        ("places", "places that lie more than 5 yarns apart, 10 µs after the first failure", |first| first.places),
    ];
    let mut claims = Vec::new();
    for yarn in [Yarn::Uniform, Yarn::Symmetric] {
        for (how, what, count) in readings {
            let points =
                [TwoSides, FourSides].into_iter().flat_map(|kind| HISTORY_ENERGIES.map(|energy| (kind, energy)));
            let (mut checks, mut means) = (Vec::new(), Vec::new());
            for (kind, energy) in points {
                let records = reader.runs.of(&plan::small(reader.effort, kind, yarn, energy));
                let counts: Vec<u64> =
                    records.iter().filter_map(|record| record.first_failure.as_ref()).map(count).collect();
                let name = format!("{}, {energy} J", attachment_name(kind));
                let mean = Estimate::mean(&counts.iter().map(|&count| count as f64).collect::<Vec<_>>());
                means.push(format!("{name} {}", mean.text(1)));
                checks.push(Check { name, ours: two_or_four(&counts), range: MOST, digits: 2 });
            }
            let sheet = if yarn == Yarn::Uniform { "whole sheet" } else { "mirror-symmetric sheet" };
            claims.push(Claim::all(
                "P3",
                &format!("Uniform clamped sheets fail at two or four points ({how}, {sheet})"),
                &format!("two or four {what}: in more than half of the runs"),
                checks,
                &format!("mean number: {}", means.join(", ")),
            ));
        }
    }
    claims
}

/// The share of the runs whose number is two or four.
fn two_or_four(counts: &[u64]) -> Estimate {
    let hits = counts.iter().filter(|&&count| count == 2 || count == 4).count();
    Estimate::share(hits, counts.len())
}

/// The open question (P3, Fig. 18): over the plain reading, and over the whole map.
pub fn of_map(runs: &Runs, effort: Effort) -> Vec<Claim> {
    let cells = map::cells(runs, effort);
    let check = |cell: &Cell, name: String| Check { name, ours: cell.estimate(), range: map::TWOFOLD, digits: 2 };
    let [low, high] = map::TWOFOLD;
    let allows = format!("ratio in {low} to {high} at some energy near the limit");
    let of = |wanted: fn(&Cell) -> bool| -> Vec<Check> {
        cells.iter().filter(|cell| wanted(cell)).map(|cell| check(cell, format!("{} J", cell.impact_j))).collect()
    };
    let reader = Reader { runs, effort };
    let symmetric = [Yarn::Symmetric, Yarn::Stochastic];
    let strain = |(what, value): Reading| {
        Claim::all(
            "P3",
            &format!(
                "Strain energy is two to four times larger in uniform sheets than in stochastic ones ({what}; mirror-symmetric uniform sheet, near the limit)"
            ),
            &format!("ratio in {} to {}", TWO_TO_FOUR[0], TWO_TO_FOUR[1]),
            effort
                .map_energies()
                .iter()
                .map(|&energy| reader.yarns(FourCorners, symmetric, energy, value, TWO_TO_FOUR))
                .collect(),
            "",
        )
    };
    let mut every: Vec<Check> = cells.iter().map(|cell| check(cell, cell.name())).collect();
    let count = |verdict: Verdict| every.iter().filter(|check| check.verdict() == verdict).count();
    let note = format!(
        "of {} ratios {} lie inside, {} outside, {} across an edge",
        every.len(),
        count(Verdict::Agrees),
        count(Verdict::DoesNot),
        count(Verdict::CannotBeTold)
    );
    let verdict = Verdict::any(&every.iter().map(Check::verdict).collect::<Vec<_>>());
    // Only the greatest ratios are worth a line in the table.
    every.sort_by(|a, b| b.ours.value.total_cmp(&a.ours.value));
    every.truncate(3);
    let mut claims = vec![
        Claim::any(
            "P3",
            "Uniform yarn over-predicts about twofold near the limit, corners (absorbed energy; preset washers, whole sheet, one draw per segment, when detached)",
            &allows,
            of(Cell::plain),
            "",
        ),
        Claim::any(
            "P3",
            "The same, dissipated energy (\"work done by the yarn\") of the mirror-symmetric sheet, when detached",
            &allows,
            of(Cell::dissipated),
            "",
        ),
        Claim {
            part: "P3",
            claim: "The same under some reading of what the paper leaves open (the map; its three greatest ratios)"
                .into(),
            allows,
            checks: every,
            verdict,
            note,
        },
    ];
    claims.extend(STRAINS.map(strain));
    claims
}

/// Heading of the table of claims.
const HEADING: [&str; 6] = ["", "claim", "read as", "ours [95 % interval]", "verdict", "why"];

fn rows(claims: &[Claim], line_break: &str) -> Vec<Vec<String>> {
    let row = |claim: &Claim| {
        vec![
            claim.part.to_string(),
            claim.claim.clone(),
            claim.allows.clone(),
            claim.checks.iter().map(Check::text).collect::<Vec<_>>().join(line_break),
            claim.verdict.name().to_string(),
            claim.why(),
        ]
    };
    claims.iter().map(row).collect()
}

/// The table "claim, ours, verdict, why".
pub fn table(page: &mut Page, claims: &[Claim]) {
    page.table(&HEADING, &[1, 2, 3, 4, 5], &rows(claims, "\n"));
}

/// The same in Markdown.
pub fn markdown(claims: &[Claim]) -> String {
    report::markdown(&HEADING, &rows(claims, "<br>"))
}

/// The same on the terminal, short.
pub fn print(claims: &[Claim]) {
    let mut table = report::table(&["claim", "ours [95 % interval]", "verdict"]);
    for claim in claims {
        let texts: Vec<String> = claim.checks.iter().map(Check::text).collect();
        let ours =
            if texts.len() > 2 { format!("{}; and {} more", texts[0], texts.len() - 1) } else { texts.join("; ") };
        table.add_row(vec![claim.claim.clone(), ours, claim.verdict.name().to_string()]);
    }
    println!("{table}");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_claim_is_refuted_by_one_counterexample_and_says_which() {
        let check = |name: &str, low: f64, high: f64| Check {
            name: name.into(),
            ours: Estimate { value: 0.5 * (low + high), low, high },
            range: MORE,
            digits: 1,
        };
        let claim = Claim::all("P3", "more", "above 1", vec![check("a", 1.1, 1.2), check("b", 0.8, 0.9)], "");
        assert_eq!(claim.verdict, Verdict::DoesNot);
        assert_eq!(claim.why(), "1 of 2 inside; outside: b");
        let claim = Claim::any("P3", "more", "above 1", vec![check("a", 1.1, 1.2), check("b", 0.8, 0.9)], "");
        assert_eq!(claim.verdict, Verdict::Agrees);
    }

    #[test]
    fn two_or_four_points_in_most_runs() {
        let verdict = |counts: &[u64]| Verdict::of(&two_or_four(counts), MOST);
        assert_eq!(two_or_four(&[2, 4, 3, 1]).value, 0.5);
        assert_eq!(verdict(&[2, 4, 2, 2, 4, 2, 2, 2, 4, 2]), Verdict::Agrees);
        assert_eq!(verdict(&[1, 1, 3, 1, 8, 1, 1, 5, 1, 1]), Verdict::DoesNot);
        assert_eq!(verdict(&[2, 1, 4, 3]), Verdict::CannotBeTold);
        assert_eq!(verdict(&[]), Verdict::CannotBeTold);
    }

    #[test]
    fn mean_numbers_of_corners_against_four_and_one_or_two() {
        let mean = |values: &[f64]| Estimate::mean(values);
        // Sheets that do not fail say nothing of how many corners fail.
        assert!(defined(0).is_nan() && defined(3) == 3.0);
        assert_eq!(Verdict::of(&mean(&[4.0; 10]), FOUR), Verdict::Agrees);
        assert_eq!(Verdict::of(&mean(&[2.0, 3.0, 2.0, 3.0, 3.0, 2.0]), FOUR), Verdict::DoesNot);
        assert_eq!(Verdict::of(&mean(&[2.0, 3.0, 2.0, 3.0, 3.0, 2.0]), ONE_OR_TWO), Verdict::CannotBeTold);
        assert_eq!(Verdict::of(&mean(&[1.0, 2.0, 2.0, 1.0]), ONE_OR_TWO), Verdict::Agrees);
    }
}
