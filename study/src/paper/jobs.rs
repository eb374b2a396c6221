//! The runs: each is done once and kept as a line of runs.jsonl, keyed by what it computes.

use super::plan::{LARGE_QUICK_STEPS, Point, Sheet, Yarn};
use crate::effort::Effort;
use crate::machine::Clock;
use crate::memory::Buffers;
use crate::progress::Progress;
use crate::{Result, event, picture, say};
use fabric::Hash;
use fabric::fields::FIELDS;
use fabric::{AttachmentKind, Outcome, OutcomeSet, Scene, Sim, Symmetry};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// Raise it when the same scene gives other numbers than before, or more of them: kept runs of older versions are then done
/// again.
pub const RESULTS_VERSION: u32 = 3;

/// Time between two samples of a history, s, while the impact is young and later.
const FINE: f64 = 2e-6;
const COARSE: f64 = 10e-6;
/// End of the fine samples, s.
const FINE_UNTIL: f64 = 200e-6;
/// Lines of the undeformed grid from an attachment within which a failure counts as "at the attachment".
const ATTACHMENT_ZONE: f64 = 5.0;
/// Distance from the centre, in radii of the projectile, within which a failure counts as "at the centre".
const CENTRE_ZONE: f64 = 2.0;
/// Time from the first failure until the places of failure are counted, s.
const SPREAD: f64 = 10e-6;
/// Failed segments that lie closer than so many spacings belong to one place of failure.
const PLACE: f64 = 5.0;

/// One run to be done.
pub struct Job {
    /// What is simulated.
    pub scene: Scene,
    /// Most steps; a run that these end is a timeout.
    pub step_limit: u64,
    /// In words, for the progress line and the file.
    pub name: String,
    /// Times at which the whole sheet is kept for pictures, s.
    pub pictures: &'static [f64],
}

/// One sample of a history.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// Time, s.
    pub t: f64,
    /// Energy lost by the projectile = absorbed, J.
    pub lost: f64,
    /// Kinetic energy of the fabric, J.
    pub kinetic: f64,
    /// Strain energy, J.
    pub strain: f64,
    /// Energy dissipated by rupture, J.
    pub dissipated: f64,
    /// Energy lost in impacts of nodes, J.
    pub loss: f64,
}

/// How failure begins. Segments of a mirrored sheet count with their images.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FirstFailure {
    /// Time, s.
    pub time: f64,
    /// Segments that failed first, within one step of one another.
    pub segments: u64,
    /// Separate places of failure 10 µs later, or at the end if that comes before.
    pub places: u64,
}

/// What one run gave: a line of runs.jsonl.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Hash of the scene, the stop rule and the versions.
    pub key: String,
    /// In words.
    pub name: String,
    /// Outcomes that ended the run, or TIMEOUT.
    pub ended_by: String,
    /// Whether the projectile was arrested.
    pub arrested: bool,
    /// Whether the step limit ended the run.
    pub timeout: bool,
    /// Steps taken.
    pub steps: u64,
    /// End of the run, s.
    pub time: f64,
    /// Kinetic energy at impact, J.
    pub energy: f64,
    /// Energy absorbed at the end, J.
    pub absorbed: f64,
    /// Time, s, and energy absorbed, J, when the last contact lost its supports; none if it never did.
    pub detached: Option<(f64, f64)>,
    /// Velocity along the line of flight at the end, m/s.
    pub residual_velocity: f64,
    /// Largest sampled kinetic energy of the fabric, J.
    pub peak_kinetic: f64,
    /// Largest sampled strain energy, J.
    pub peak_strain: f64,
    /// Failed segments at the end.
    pub failed: u64,
    /// Failed segments near an attachment, and near the centre (whole sheets only).
    pub failed_at: (u64, u64),
    /// Corners with a failed segment nearby at the end (corners of whole sheets only).
    pub failed_corners: u64,
    /// How failure began; none if nothing failed.
    pub first_failure: Option<FirstFailure>,
    /// When each corner lost its connection to the sheet, s; none if it held (corners of whole sheets only).
    pub torn: [Option<f64>; 4],
    /// What the energy balance does not close by, over the energy at impact.
    pub audit: f64,
    /// Processor time, s: the only entry that differs from run to run.
    pub cpu: f64,
    /// Samples in time.
    pub history: Vec<Sample>,
}

impl Point {
    /// Run k of this ensemble.
    pub fn job(&self, effort: Effort, k: u64, pictures: &'static [f64]) -> Job {
        let step_limit = match (self.sheet, self.yarn) {
            // These end when detached at the latest, within about 1 ms.
            (Sheet::Small, Yarn::Symmetric) => 50_000,
            (Sheet::Small, _) => 100_000,
            (Sheet::Large, _) => 120_000,
        };
        let step_limit = match (effort, self.sheet) {
            (Effort::Smoke, _) => 5_000,
            // One run at the corners would take a third of all the time: that the sheet is torn off is seen before.
            (Effort::Quick, Sheet::Large) => LARGE_QUICK_STEPS,
            _ => step_limit,
        };
        Job { scene: self.scene(effort, k), step_limit, name: format!("{}, run {}", self.name(), k + 1), pictures }
    }
}

impl Job {
    /// Hash of everything that decides the result: every parameter that is not the preset's, and how long is run. A parameter that
    /// the kernel gains is the preset's in all of these runs, so that kept ones stay good.
    pub fn key(&self) -> String {
        let mut text = vec![
            format!("results {RESULTS_VERSION}, package {}", env!("CARGO_PKG_VERSION")),
            format!("until arrested or exited, mirrored: or detached, at most {} steps", self.step_limit),
        ];
        let (mut scene, mut preset) = (self.scene, Scene::sheet_3in_sphere());
        for field in FIELDS {
            for element in 0..field.size() {
                let (word, usual) = (field.word(&mut scene, element), field.word(&mut preset, element));
                if word != usual {
                    text.push(format!("{}[{element}] {word:x}", field.name));
                }
            }
        }
        let mut hash = Hash::default();
        text.join("\n").bytes().for_each(|byte| hash.word(byte as u64));
        format!("{:016x}", hash.value())
    }

    /// Nodes times the steps that such a run takes, roughly: what it costs against the others.
    fn cost(&self) -> u64 {
        let nodes = self.scene.sheet.nodes_x as u64 * self.scene.sheet.nodes_y as u64;
        let share = if self.scene.symmetry == Symmetry::default() { 1 } else { 4 };
        (nodes / 1000 / share).max(1)
    }

    /// Does the run; keeps whole sheets in `out` where asked.
    fn run(&self, out: &Path) -> Result<Record> {
        let clock = Clock::start();
        let mut buffers = Buffers::of(&self.scene)?;
        let mut sim = buffers.sim(&self.scene)?;
        let mut mask = event::mask_of(&[Outcome::Arrested, Outcome::Exited]);
        if self.scene.symmetry != Symmetry::default() {
            // Torn off evenly at all corners, the sheet wraps the sphere and flies with it: the run is over.
            mask |= Outcome::Detached;
        }
        let dt = sim.step_limits().dt;
        let every = |pause: f64| ((pause / dt).round() as u64).max(1);
        let mut history = vec![sample(&sim)?];
        let mut torn = [None; 4];
        // A quarter model's corners all tear alike, and its failures lie where the quarter's do.
        let whole = self.scene.symmetry == Symmetry::default();
        let mut connection = Connection::new(&sim);
        let mut onset = Onset::default();
        let mut pictures = self.pictures.iter().peekable();
        while sim.step_count() < self.step_limit && !sim.outcomes().mask.has(mask) {
            let pause = if sim.time() < FINE_UNTIL { FINE } else { COARSE };
            let steps = every(pause).min(self.step_limit - sim.step_count());
            onset.advance_until(&mut sim, mask, steps)?;
            history.push(sample(&sim)?);
            if whole && self.scene.attachment.kind == AttachmentKind::FourCorners {
                connection.find_torn(&sim, &mut torn)?;
            }
            if let Some(&&time) = pictures.peek()
                && sim.time() >= time
            {
                picture::keep(&out.join(picture_file(&self.key(), time)), &sim)?;
                pictures.next();
            }
        }
        for &time in pictures {
            picture::keep(&out.join(picture_file(&self.key(), time)), &sim)?;
        }
        let first_failure = onset.close(&sim)?;
        let (failed_at, failed_corners) = if whole { failed_at(&sim)? } else { ((0, 0), 0) };
        let ended = event::Summary::of(&sim, mask)?;
        let peak = |value: fn(&Sample) -> f64| history.iter().map(value).fold(0.0, f64::max);
        Ok(Record {
            key: self.key(),
            name: self.name.clone(),
            arrested: ended.latched(Outcome::Arrested).is_some(),
            timeout: !sim.outcomes().mask.has(mask),
            steps: ended.steps,
            time: ended.time,
            energy: ended.initial_kinetic_energy,
            absorbed: ended.absorbed,
            detached: ended.latched(Outcome::Detached).map(|latched| (latched.time, latched.absorbed)),
            residual_velocity: ended.residual_velocity[2],
            peak_kinetic: peak(|sample| sample.kinetic),
            peak_strain: peak(|sample| sample.strain),
            failed: ended.failed_segments,
            failed_at,
            failed_corners,
            first_failure,
            torn,
            audit: ended.energy_residual_relative,
            ended_by: ended.ended_by,
            cpu: (clock.seconds() * 1e3).round() / 1e3,
            history,
        })
    }

    /// Whether all pictures of this run are there.
    pub fn has_pictures(&self, out: &Path) -> bool {
        self.pictures.iter().all(|&time| out.join(picture_file(&self.key(), time)).exists())
    }
}

fn sample(sim: &Sim<'_>) -> Result<Sample> {
    let energy = sim.energy()?;
    // Six digits are more than a plot shows.
    let short = |value: f64| (value * 1e6).round() / 1e6;
    Ok(Sample {
        t: (sim.time() * 1e10).round() / 1e10,
        lost: short(energy.contact_work),
        kinetic: short(energy.fabric_kinetic),
        strain: short(energy.strain),
        dissipated: short(energy.dissipated),
        loss: short(energy.contact_loss),
    })
}

/// Ends of segment number e: its two nodes.
fn ends(number: usize, nx: usize, ny: usize) -> (usize, usize) {
    let across = (nx - 1) * ny;
    if number < across {
        let node = number / (nx - 1) * nx + number % (nx - 1);
        (node, node + 1)
    } else {
        let node = number - across;
        (node, node + nx)
    }
}

/// Middles of the failed segments in the undeformed sheet, in spacings from its centre; of a mirrored sheet those of the
/// part that is modelled.
fn failed_places(sim: &Sim<'_>) -> Result<Vec<[f64; 2]>> {
    let (scene, layout) = (sim.scene(), sim.layout());
    let mut damage = vec![0.0; layout.segments()];
    sim.copy_damage(&mut damage)?;
    let failed = damage.iter().enumerate().filter(|(_, alpha)| **alpha <= 0.0);
    Ok(failed.map(|(number, _)| middle(number, scene, [layout.nodes_x, layout.nodes_y])).collect())
}

/// Middle of segment number e in the undeformed sheet, in spacings from its centre. `nodes`: those modelled along x and y;
/// a mirrored line has one segment more, from its last node to an image.
fn middle(number: usize, scene: &Scene, [nx, ny]: [usize; 2]) -> [f64; 2] {
    let in_row = if scene.symmetry.mirror_x { nx } else { nx - 1 };
    let place = |i: usize, j: usize| {
        [
            fabric::internals::places::rest_offset(i, scene.sheet.nodes_x),
            fabric::internals::places::rest_offset(j, scene.sheet.nodes_y),
        ]
    };
    if number < in_row * ny {
        let [x, y] = place(number % in_row, number / in_row);
        [x + 0.5, y]
    } else {
        let number = number - in_row * ny;
        let [x, y] = place(number % nx, number / nx);
        [x, y + 0.5]
    }
}

/// Failed segments near an attachment and near the centre, by the place of their middles in the undeformed sheet; and the
/// number of corners with a failed segment nearby.
fn failed_at(sim: &Sim<'_>) -> Result<((u64, u64), u64)> {
    let scene = sim.scene();
    let h = scene.sheet.spacing;
    let half = scene.half_size();
    let zone = ATTACHMENT_ZONE * h;
    let near_attachment = |x: f64, y: f64| {
        let (x, y) = (x.abs(), y.abs());
        match scene.attachment.kind {
            AttachmentKind::TwoSides => half[0] - x <= zone,
            AttachmentKind::FourSides => half[0] - x <= zone || half[1] - y <= zone,
            AttachmentKind::FourCorners => {
                let centre = half.map(|half| half - scene.attachment.disc_inset);
                (x - centre[0]).hypot(y - centre[1]) <= scene.attachment.disc_radius + zone
            }
            AttachmentKind::Free => false,
        }
    };
    let (mut attachments, mut centre, mut corners) = (0, 0, [0; 4]);
    for place in failed_places(sim)? {
        let [x, y] = place.map(|offset| h * offset);
        if x.hypot(y) <= CENTRE_ZONE * scene.projectile.radius {
            centre += 1;
        } else if near_attachment(x, y) {
            attachments += 1;
            corners[usize::from(x > 0.0) + 2 * usize::from(y > 0.0)] = 1;
        }
    }
    let corners = if scene.attachment.kind == AttachmentKind::FourCorners { corners.iter().sum() } else { 0 };
    Ok(((attachments, centre), corners))
}

/// These places with their mirror images, each once.
fn with_images(places: &[[f64; 2]], symmetry: Symmetry) -> Vec<[f64; 2]> {
    let mut all: Vec<[f64; 2]> = places.to_vec();
    for (axis, mirrored) in [symmetry.mirror_x, symmetry.mirror_y].into_iter().enumerate() {
        let image = |place: &[f64; 2]| {
            let mut image = *place;
            image[axis] = 0.0 - image[axis];
            image
        };
        if mirrored {
            all.extend(all.iter().map(image).collect::<Vec<_>>());
        }
    }
    all.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    all.dedup();
    all
}

/// Number of groups whose members are joined by distances of at most [`PLACE`].
fn count_groups(places: &[[f64; 2]]) -> u64 {
    let mut labels = vec![0; places.len()];
    let mut groups = fabric::internals::outcome::Components::new(&mut labels);
    for (k, a) in places.iter().enumerate() {
        for (l, b) in places.iter().enumerate().take(k) {
            if (a[0] - b[0]).hypot(a[1] - b[1]) <= PLACE {
                groups.join(k, l);
            }
        }
    }
    (0..places.len()).filter(|&k| groups.find(k) == k).count() as u64
}

/// Watches how failure begins.
#[derive(Default)]
struct Onset {
    /// Time and number of segments of the first failure.
    first: Option<(f64, u64)>,
    /// Places of failure some time later.
    places: Option<u64>,
}

impl Onset {
    /// Advances the simulation by at most so many steps, one by one until all is known of the onset.
    fn advance_until(&mut self, sim: &mut Sim<'_>, mask: OutcomeSet, steps: u64) -> Result<()> {
        let failed = |failure: fabric::Failure| failure.to_string();
        let end = sim.step_count() + steps;
        while self.places.is_none() && sim.step_count() < end && !sim.outcomes().mask.has(mask) {
            sim.advance_until(mask, 1).map_err(failed)?;
            self.look(sim)?;
        }
        sim.advance_until(mask, end - sim.step_count()).map_err(failed)?;
        Ok(())
    }

    fn look(&mut self, sim: &Sim<'_>) -> Result<()> {
        match self.first {
            None if sim.counters().failed_segments > 0 => {
                let places = with_images(&failed_places(sim)?, sim.scene().symmetry);
                self.first = Some((sim.time(), places.len() as u64));
            }
            Some((time, _)) if sim.time() >= time + SPREAD => {
                self.places = Some(count_groups(&with_images(&failed_places(sim)?, sim.scene().symmetry)));
            }
            _ => {}
        }
        Ok(())
    }

    /// What was seen until the end of the run.
    fn close(self, sim: &Sim<'_>) -> Result<Option<FirstFailure>> {
        let Some((time, segments)) = self.first else { return Ok(None) };
        let places = match self.places {
            Some(places) => places,
            None => count_groups(&with_images(&failed_places(sim)?, sim.scene().symmetry)),
        };
        Ok(Some(FirstFailure { time, segments, places }))
    }
}

/// Finds out which corners still hold the sheet.
struct Connection {
    damage: Vec<f64>,
    labels: Vec<u32>,
    /// A fixed node of each corner.
    corners: [usize; 4],
}

impl Connection {
    fn new(sim: &Sim<'_>) -> Connection {
        let layout = sim.layout();
        let mut corners = [0; 4];
        let kind = sim.scene().attachment.kind;
        for j in 0..sim.scene().sheet.nodes_y as usize {
            for (run, columns) in fabric::internals::weave::fixed_runs(sim.scene(), j).iter().enumerate() {
                if columns[1] > columns[0] && kind == AttachmentKind::FourCorners {
                    let corner = fabric::internals::weave::attachment_of(kind, layout.y.nodes, layout.upper, j, run);
                    corners[corner] = j * layout.nodes_x + columns[0] as usize;
                }
            }
        }
        Connection { damage: vec![0.0; layout.segments()], labels: vec![0; layout.nodes()], corners }
    }

    /// Notes the time for each corner that is no longer joined to the largest whole piece of the sheet.
    fn find_torn(&mut self, sim: &Sim<'_>, torn: &mut [Option<f64>; 4]) -> Result<()> {
        let (nx, ny) = (sim.layout().nodes_x, sim.layout().nodes_y);
        sim.copy_damage(&mut self.damage)?;
        let mut components = fabric::internals::outcome::Components::new(&mut self.labels);
        for (number, _) in self.damage.iter().enumerate().filter(|(_, alpha)| **alpha > 0.0) {
            let (a, b) = ends(number, nx, ny);
            components.join(a, b);
        }
        let mut sizes = vec![0_u32; nx * ny];
        for node in 0..nx * ny {
            sizes[components.find(node)] += 1;
        }
        let largest = (0..nx * ny).max_by_key(|&node| sizes[node]).unwrap_or(0);
        for (slot, &node) in torn.iter_mut().zip(&self.corners) {
            if slot.is_none() && components.find(node) != largest {
                *slot = Some(sim.time());
            }
        }
        Ok(())
    }
}

/// All runs that are known, by key.
pub struct Runs {
    records: HashMap<String, Record>,
    effort: Effort,
    /// How many were taken from the file and how many were done now.
    pub kept: usize,
    /// Runs done now.
    pub done: usize,
    /// Runs wanted that are neither kept nor done.
    pub missing: usize,
}

/// The file of kept runs.
pub fn path_of_runs(out: &Path) -> PathBuf {
    out.join("runs.jsonl")
}

/// The file of a run's sheet at a time, from the folder of the results.
pub fn picture_file(key: &str, time: f64) -> String {
    format!("sheets/{key}_{:.0}us.bin", 1e6 * time)
}

/// Reads the kept runs. A last line that was cut off is dropped; a line of another version is ignored by its key.
fn read(path: &Path) -> Result<HashMap<String, Record>> {
    let text = match std::fs::read_to_string(path) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(HashMap::new()),
        Err(error) => return Err(format!("{}: {error}", path.display()).into()),
    };
    let records = text.lines().filter_map(|line| serde_json::from_str::<Record>(line).ok());
    Ok(records.map(|record| (record.key.clone(), record)).collect())
}

/// Opens the file for more lines; one that was cut off is ended first, so that it spoils no other.
fn open(path: &Path) -> Result<File> {
    let cut = std::fs::read(path).is_ok_and(|bytes| bytes.last().is_some_and(|&byte| byte != b'\n'));
    let mut file = OpenOptions::new().create(true).append(true).open(path)?;
    if cut {
        file.write_all(b"\n")?;
    }
    Ok(file)
}

impl Runs {
    /// Does what is missing among `jobs`, on all cores, and keeps it in `out`; nothing with `only_kept`.
    pub fn complete(out: &Path, effort: Effort, jobs: Vec<Job>, only_kept: bool) -> Result<Runs> {
        let path = path_of_runs(out);
        std::fs::create_dir_all(out.join("sheets"))?;
        let known = read(&path)?;
        // A job may be wanted by several figures; the first that asks for pictures has come first.
        let mut seen = std::collections::HashSet::new();
        let jobs: Vec<Job> = jobs.into_iter().filter(|job| seen.insert(job.key())).collect();
        let wanted = jobs.len();
        let (there, mut missing): (Vec<Job>, Vec<Job>) =
            jobs.into_iter().partition(|job| known.contains_key(&job.key()) && job.has_pictures(out));
        let left_out = if only_kept { std::mem::take(&mut missing).len() } else { 0 };
        // The longest first, so that no core idles at the end; otherwise in the order of the plan.
        missing.sort_by_key(|job| std::cmp::Reverse(job.cost()));
        say::aside(format_args!(
            "{wanted} runs: {} taken from {}, {} to do",
            there.len(),
            path.display(),
            missing.len()
        ));
        let file = Mutex::new(open(&path)?);
        let progress = Progress::new("paper", missing.iter().map(Job::cost).sum());
        let count = std::sync::atomic::AtomicUsize::new(0);
        let done: Vec<std::result::Result<Record, String>> = missing
            .iter()
            .par_bridge()
            .map(|job| {
                let record = job.run(out).map_err(|error| format!("{}: {error}", job.name))?;
                let line = serde_json::to_string(&record).map_err(|error| error.to_string())? + "\n";
                let mut file = file.lock().map_err(|error| error.to_string())?;
                file.write_all(line.as_bytes()).and_then(|()| file.flush()).map_err(|error| error.to_string())?;
                drop(file);
                let n = 1 + count.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
                progress.add(job.cost(), || format!("{n} of {} runs; {}", missing.len(), job.name));
                Ok(record)
            })
            .collect();
        progress.finish();
        let mut records = HashMap::new();
        let mut known = known;
        for job in &there {
            if let Some(record) = known.remove(&job.key()) {
                records.insert(record.key.clone(), record);
            }
        }
        let mut failures = Vec::new();
        for result in done {
            match result {
                Ok(record) => {
                    records.insert(record.key.clone(), record);
                }
                Err(message) => failures.push(message),
            }
        }
        if !failures.is_empty() {
            return Err(format!("{} runs failed: {}", failures.len(), failures.join("; ")).into());
        }
        Ok(Runs { records, effort, kept: there.len(), done: missing.len(), missing: left_out })
    }

    /// The keys of a point's runs, in the order of their numbers; those not asked for are missing.
    pub fn keys(&self, point: &Point) -> Vec<String> {
        let keys = (0..point.runs).map(|k| point.job(self.effort, k, &[]).key());
        keys.filter(|key| self.records.contains_key(key)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::plan::{Yarn, small};
    use super::*;

    fn jobs() -> Vec<Job> {
        let point = small(Effort::Smoke, AttachmentKind::FourCorners, Yarn::Stochastic, 160.0);
        (0..2).map(|k| point.job(Effort::Smoke, k, &[])).collect()
    }

    #[test]
    fn kept_runs_are_not_done_again() {
        let out = std::env::temp_dir().join(format!("fabric-study-paper-{}", std::process::id()));
        std::fs::create_dir_all(&out).unwrap();
        let none = Runs::complete(&out, Effort::Smoke, jobs(), true).unwrap();
        assert_eq!((none.kept, none.done, none.missing), (0, 0, 2));
        let first = Runs::complete(&out, Effort::Smoke, jobs(), false).unwrap();
        assert_eq!((first.kept, first.done, first.missing), (0, 2, 0));
        // Half a line more, as a power cut leaves it.
        let mut file = OpenOptions::new().append(true).open(path_of_runs(&out)).unwrap();
        file.write_all(b"{\"key\":\"0123\",\"na").unwrap();
        let again = Runs::complete(&out, Effort::Smoke, jobs(), true).unwrap();
        assert_eq!((again.kept, again.done), (2, 0));
        assert_eq!(first.records, again.records);
        // The cut line is ended, so the next one stands by itself.
        let mut more = jobs();
        let point = small(Effort::Smoke, AttachmentKind::TwoSides, Yarn::Uniform, 160.0);
        more.push(point.job(Effort::Smoke, 0, &[]));
        let third = Runs::complete(&out, Effort::Smoke, more, false).unwrap();
        assert_eq!((third.kept, third.done), (2, 1));
        assert_eq!(read(&path_of_runs(&out)).unwrap().len(), 3);
        std::fs::remove_dir_all(&out).unwrap();
    }

    /// If this fails, the kernel gives other numbers than before: raise RESULTS_VERSION, then pin the new number here.
    #[test]
    fn results_version_goes_with_the_numbers() {
        let record = jobs()[0].run(&std::env::temp_dir()).unwrap();
        assert_eq!((RESULTS_VERSION, record.absorbed), (3, 4.279345472050326));
    }

    #[test]
    fn places_of_failure() {
        let quarter = Symmetry { mirror_x: true, mirror_y: true };
        // Off both planes four places, on one of them two, on both one.
        let images = with_images(&[[-20.5, -10.0], [-0.5, 0.0], [0.0, -0.5], [0.0, 0.0]], quarter);
        assert_eq!(images.len(), 4 + 2 + 2 + 1);
        // Segments across a plane are modelled beside their image.
        assert_eq!(with_images(&[[-0.5, 0.0], [0.5, 0.0]], quarter), [[-0.5, 0.0], [0.5, 0.0]]);
        // Four alone, and those about the centre together.
        assert_eq!(count_groups(&images), 5);
        assert_eq!(with_images(&[[-20.5, -10.0]], Symmetry::default()).len(), 1);
        // A chain of near ones is one place.
        assert_eq!(count_groups(&[[0.0, 0.0], [8.0, 0.0], [4.0, 0.0], [14.0, 0.0]]), 2);
        assert_eq!(count_groups(&[]), 0);
    }

    #[test]
    fn onset_of_failure_is_seen_in_whole_and_mirrored_sheets() {
        let first = |yarn: Yarn| {
            let point = small(Effort::Smoke, AttachmentKind::FourSides, yarn, 160.0);
            point.job(Effort::Smoke, 0, &[]).run(&std::env::temp_dir()).unwrap().first_failure.unwrap()
        };
        let (whole, mirrored) = (first(Yarn::Uniform), first(Yarn::Symmetric));
        // Before the first failure a whole uniform sheet is symmetric but for rounding.
        assert!((whole.time / mirrored.time - 1.0).abs() < 0.02, "{whole:?} {mirrored:?}");
        assert!(whole.segments >= 1 && mirrored.segments >= 2 && mirrored.segments % 2 == 0, "{whole:?} {mirrored:?}");
        assert!(whole.places >= 1 && mirrored.places >= 1);
    }

    #[test]
    fn keys_tell_runs_apart() {
        let jobs = jobs();
        assert_eq!(jobs[0].key(), jobs[0].key());
        assert_ne!(jobs[0].key(), jobs[1].key());
        let mut longer = Job { scene: jobs[0].scene, name: String::new(), pictures: &[], step_limit: 9 };
        assert_ne!(jobs[0].key(), longer.key());
        longer.step_limit = jobs[0].step_limit;
        assert_eq!(jobs[0].key(), longer.key(), "the name does not matter");
    }

    #[test]
    fn segments_lie_where_they_should() {
        let mut scene = Scene::sheet_3in_sphere();
        (scene.sheet.nodes_x, scene.sheet.nodes_y) = (5, 5);
        let at = |number: usize, scene: &Scene, nodes: usize| middle(number, scene, [nodes, nodes]);
        assert_eq!([0, 3, 4, 19].map(|e| at(e, &scene, 5)), [[-1.5, -2.0], [1.5, -2.0], [-1.5, -1.0], [1.5, 2.0]]);
        assert_eq!([20, 24, 25, 39].map(|e| at(e, &scene, 5)), [[-2.0, -1.5], [2.0, -1.5], [-2.0, -0.5], [2.0, 1.5]]);
        // A quarter has 3 nodes and 3 segments a line, the last across the plane.
        scene.symmetry = Symmetry { mirror_x: true, mirror_y: true };
        assert_eq!([0, 2, 3, 8].map(|e| at(e, &scene, 3)), [[-1.5, -2.0], [0.5, -2.0], [-1.5, -1.0], [0.5, 0.0]]);
        assert_eq!([9, 11, 17].map(|e| at(e, &scene, 3)), [[-2.0, -1.5], [0.0, -1.5], [0.0, 0.5]]);
    }

    #[test]
    fn segments_end_where_they_should() {
        assert_eq!([0, 2, 3, 9, 16].map(|number| ends(number, 4, 3)), [(0, 1), (2, 3), (4, 5), (0, 4), (7, 11)]);
    }
}
