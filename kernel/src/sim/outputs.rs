//! The table of what a simulation tells of a run: one row for each number or vector of its read-outs.
//!
//! From these rows come the outputs of the FMUs with both model descriptions, what the Python package returns
//! and its types, the columns of history.csv, and the table of outputs of the documents. A new output needs
//! its field at the end of its structure, which C has too, and its row here.
//!
//! The rows that the FMUs have stand in the order of the model descriptions.

use crate::body::projectile::Motion;
use crate::ground::error::Failure;
use crate::ground::math;
use crate::scene::fields::{
    ANGULAR_VELOCITY, ANY_SIGN, DURATION, FORCE, POSITION, QUATERNION, Quantity, RATIO, Str, VELOCITY, quantity,
};
use crate::sim::simulation::{Contact, Counters, Fabric, Sim, Support};
use crate::step::energy::{Energy, Ply};
use core::slice::from_ref;

/// Impulse.
pub const IMPULSE: Quantity = quantity("Impulse", "N.s", "", ANY_SIGN, 1.0, "Force over time");
/// Angular impulse.
pub const ANGULAR_IMPULSE: Quantity = quantity("AngularImpulse", "N.m.s", "", ANY_SIGN, 1e-3, "Torque over time");
/// Energy.
pub const ENERGY: Quantity = quantity("Energy", "J", "", ANY_SIGN, 10.0, "Energy or work");
/// A whole number.
pub const COUNT: Quantity = quantity("Count", "1", "", 0.0, 1.0, "Number of things");

/// Reader of an output, by the structure that has it.
#[derive(Clone, Copy, Debug)]
#[allow(missing_docs)] // named as the structures
pub enum Get {
    Projectile(fn(&Motion) -> &[f64]),
    Contact(fn(&Contact) -> &[f64]),
    Support(fn(&Support) -> &[f64]),
    Energy(fn(&Energy) -> f64),
    Fabric(fn(&Fabric) -> f64),
    Ply(fn(&Ply) -> f64),
    Counters(fn(&Counters) -> f64),
    Whole(fn(&Sim<'_>) -> Result<f64, Failure>),
}

/// One row of the table.
#[derive(Clone, Copy, Debug)]
pub struct Output {
    /// Structure and field, as C and Python have them.
    pub name: &'static str,
    /// Name and value reference (of the first element) in the FMUs; a reference of 0: they do not have it.
    pub fmi: (&'static str, u32),
    /// Kind of number.
    pub quantity: &'static Quantity,
    /// Dimensions; empty for a scalar.
    pub shape: &'static [usize],
    /// Typical size, if it is not that of the quantity; 0 otherwise.
    pub nominal: f64,
    /// Reader.
    pub get: Get,
    /// Meaning.
    pub about: &'static str,
}

impl Output {
    /// Name of the structure that has it, and its name there.
    pub fn parts(&self) -> (&'static str, &'static str) {
        self.name.split_once('.').unwrap_or((self.name, ""))
    }

    /// Number of elements.
    pub fn size(&self) -> usize {
        self.shape.iter().product()
    }
}

/// Most elements of an output.
pub const MOST_ELEMENTS: usize = 12;

/// Readings of a simulation at one time: a pass over the sheet is made once, when a number that needs it is
/// first asked for.
#[derive(Clone, Copy, Debug, Default)]
pub struct Readings {
    energy: Option<Energy>,
    fabric: Option<Fabric>,
}

impl Readings {
    /// The energies.
    pub fn energy(&mut self, sim: &Sim<'_>) -> Result<Energy, Failure> {
        let energy = self.energy.map_or_else(|| sim.energy(), Ok)?;
        Ok(*self.energy.insert(energy))
    }

    fn fabric(&mut self, sim: &mut Sim<'_>) -> Result<Fabric, Failure> {
        let fabric = self.fabric.map_or_else(|| sim.fabric(), Ok)?;
        Ok(*self.fabric.insert(fabric))
    }

    /// The elements of an output, row by row, then zeros. Those of single plies are read from [`Sim::ply`]
    /// with [`Get::Ply`]: here 0.
    pub fn read(&mut self, sim: &mut Sim<'_>, output: &Output) -> Result<[f64; MOST_ELEMENTS], Failure> {
        let mut values = [0.0; MOST_ELEMENTS];
        let mut put = |from: &[f64]| values.iter_mut().zip(from).for_each(|(to, from)| *to = *from);
        match output.get {
            Get::Projectile(of) => put(of(&sim.projectile()?)),
            Get::Contact(of) => put(of(&sim.contact()?)),
            Get::Support(of) => put(of(&sim.support()?)),
            Get::Energy(of) => put(&[of(&self.energy(sim)?)]),
            Get::Fabric(of) => put(&[of(&self.fabric(sim)?)]),
            Get::Counters(of) => put(&[of(&sim.counters())]),
            Get::Whole(of) => put(&[of(sim)?]),
            Get::Ply(_) => {}
        }
        Ok(values)
    }
}

type Fmi = (Str, u32);

/// Not in the FMUs.
const NO_FMI: Fmi = ("", 0);

const fn row(name: Str, fmi: Fmi, of: &'static Quantity, shape: &'static [usize], get: Get, about: Str) -> Output {
    Output { name, fmi, quantity: of, shape, nominal: 0.0, get, about }
}

/// The way of nodes through something.
const fn way(name: Str, fmi: Fmi, get: Get, about: Str) -> Output {
    Output { nominal: 1e-6, ..row(name, fmi, &POSITION, &[], get, about) }
}

const fn energy(name: Str, fmi: Fmi, of: fn(&Energy) -> f64, about: Str) -> Output {
    row(name, fmi, &ENERGY, &[], Get::Energy(of), about)
}

const fn count(name: Str, fmi: Fmi, of: fn(&Counters) -> f64, about: Str) -> Output {
    row(name, fmi, &COUNT, &[], Get::Counters(of), about)
}

/// Every output.
#[rustfmt::skip] // A row is a line, or two.
pub const OUTPUTS: &[Output] = &[
    row("contact.force_peak", ("contact.force_peak", 313), &FORCE, &[], Get::Contact(|contact| from_ref(&contact.force_peak)),
        "Largest mean force over consecutive windows of force_window; until the first is full the mean force over the time elapsed"),
    row("contact.impulse", ("contact.impulse", 320), &IMPULSE, &[3], Get::Contact(|contact| &contact.impulse),
        "Impulse on the projectile since the start"),
    row("contact.angular_impulse", ("contact.angular_impulse", 330), &ANGULAR_IMPULSE, &[3], Get::Contact(|contact| &contact.angular_impulse),
        "Angular impulse on the projectile about its moving centre of mass since the start"),
    row("contact.work", ("contact.work", 333), &ENERGY, &[], Get::Contact(|contact| from_ref(&contact.work)),
        "Work of the projectile on the fabric since the start: the energy absorbed"),
    row("support.total", ("support.impulse", 340), &IMPULSE, &[3], Get::Support(|support| &support.total),
        "Impulse of the sheet on all its supports since the start"),
    row("support.attachments", ("support.attachment_impulse", 350), &IMPULSE, &[4, 3], Get::Support(|support| support.attachments.as_flattened()),
        "The same for each attachment: sides left (-x), right, bottom (-y), top; or corners (-x -y), (+x -y), (-x +y), (+x +y)"),
    row("support.force", ("support.attachment_force", 840), &FORCE, &[4], Get::Support(|support| &support.force),
        "Mean force on each attachment over the last window of force_window; 0 before, and without a hold or a strength"),
    row("support.let_go", ("support.let_go_time", 844), &DURATION, &[4], Get::Support(|support| &support.let_go),
        "Time at which each attachment let go; 0: it has not"),
    row("support.casing", ("support.casing_impulse", 362), &IMPULSE, &[3], Get::Support(|support| &support.casing),
        "The same for the case of a ring"),
    row("projectile.position", ("state.position", 370), &POSITION, &[3], Get::Projectile(|motion| &motion.position),
        "Centre of mass of the body the fabric saw"),
    row("projectile.velocity", ("state.velocity", 380), &VELOCITY, &[3], Get::Projectile(|motion| &motion.velocity),
        "Velocity of that body (half an internal step earlier)"),
    row("projectile.orientation", ("state.orientation", 390), &QUATERNION, &[4], Get::Projectile(|motion| &motion.orientation),
        "Orientation of that body, scalar first"),
    row("projectile.angular_velocity", ("state.angular_velocity", 400), &ANGULAR_VELOCITY, &[3], Get::Projectile(|motion| &motion.angular_velocity),
        "Angular velocity of that body, host's axes"),
    energy("energy.projectile_kinetic", NO_FMI, |energy| energy.projectile_kinetic, "Kinetic energy of the projectile; 0 if its mass is unknown"),
    energy("energy.fabric_kinetic", ("energy.kinetic", 410), |energy| energy.fabric_kinetic, "Kinetic energy of the fabric"),
    energy("energy.strain", ("energy.strain", 411), |energy| energy.strain, "Strain energy of the yarns"),
    energy("energy.dissipated", ("energy.dissipated", 412), |energy| energy.dissipated, "Energy dissipated by rupture"),
    // Not that of the energies, which are a pass over the sheet.
    row("contact.loss", ("energy.contact_loss", 413), &ENERGY, &[], Get::Contact(|contact| from_ref(&contact.loss)),
        "Kinetic energy lost when nodes are swept up by the projectile"),
    energy("energy.contact_loss", NO_FMI, |energy| energy.contact_loss, "The same as contact.loss"),
    energy("energy.viscous", ("energy.viscous", 416), |energy| energy.viscous, "Energy dissipated by viscosity and rate dependence of the yarn"),
    energy("energy.friction", ("energy.friction", 417), |energy| energy.friction, "Energy dissipated by friction between yarn and projectile"),
    energy("energy.ply_loss", ("energy.ply_loss", 418), |energy| energy.ply_loss, "Kinetic energy lost where separate plies meet"),
    energy("energy.contact_work", NO_FMI, |energy| energy.contact_work, "The same as contact.work"),
    energy("energy.support_work", ("energy.support_work", 419), |energy| energy.support_work,
        "Work of the projectile on held nodes: the part of contact.work that the fabric did not get"),
    energy("energy.casing_loss", ("energy.casing_loss", 425), |energy| energy.casing_loss, "Kinetic energy lost where nodes of a ring meet its case"),
    energy("energy.attachment", ("energy.attachment", 426), |energy| energy.attachment, "Energy dissipated in clamps in which held nodes have slid"),
    energy("energy.gained", ("energy.gained", 427), |energy| energy.gained,
        "Energy from nothing, in energy.residual"),
    energy("energy.external_work", NO_FMI, |energy| energy.external_work, "Work of the external load on the projectile"),
    energy("energy.residual", ("energy.residual", 414), |energy| energy.residual, "Residual of the energy balance"),
    row("fabric.max_deflection", ("fabric.max_deflection", 420), &POSITION, &[], Get::Fabric(|fabric| fabric.max_deflection),
        "Largest distance from the sheet's plane of a node that is still joined to a support (of any node of a free sheet)"),
    row("fabric.max_stretch", ("fabric.max_stretch", 421), &RATIO, &[], Get::Fabric(|fabric| fabric.max_stretch),
        "Largest stretch of a segment that has not failed"),
    count("counters.steps", NO_FMI, |counters| counters.steps as f64, "Steps taken"),
    count("counters.failed_segments", ("fabric.failed_segments", 422), |counters| counters.failed_segments as f64, "Number of failed segments"),
    way("counters.worst_penetration", ("fabric.worst_penetration", 423), Get::Counters(|counters| counters.worst_penetration),
        "Deepest penetration of a node into the projectile so far"),
    way("counters.ply_penetration", ("fabric.ply_penetration", 424), Get::Counters(|counters| counters.ply_penetration),
        "Deepest way of a node through the one that it faces in the next of separate plies so far"),
    row("ply.failed_segments", ("ply.failed_segments", 800), &COUNT, &[], Get::Ply(|ply| ply.failed_segments as f64),
        "Failed segments of single plies, from ply.first on; 0 for a ply that there is not"),
    row("ply.kinetic", ("ply.kinetic", 808), &ENERGY, &[], Get::Ply(|ply| ply.kinetic), "Kinetic energy of single plies, likewise"),
    row("ply.strain", ("ply.strain", 816), &ENERGY, &[], Get::Ply(|ply| ply.strain), "Strain energy of single plies, likewise"),
    row("ply.dissipated", ("ply.dissipated", 824), &ENERGY, &[], Get::Ply(|ply| ply.dissipated), "Energy dissipated by rupture in single plies, likewise"),
    row("momentum.residual", ("momentum.residual", 430), &IMPULSE, &[], Get::Whole(|sim| sim.momentum_residual().map(math::length)),
        "Size of the momentum residual of fabric, projectile and supports"),
    row("step.fraction", ("step.fraction", 431), &RATIO, &[], Get::Whole(|sim| Ok(sim.step_limits().dt / sim.step_limits().dt_crit)),
        "Time step in use over the stability limit of the sampled sheet"),
    row("step.seconds", ("step.seconds", 436), &DURATION, &[], Get::Whole(|sim| Ok(sim.step_limits().dt)), "Time step in use"),
    count("counters.contacts", NO_FMI, |counters| counters.contacts as f64, "Nodes with a contact impulse in the last step"),
    count("counters.unconverged", ("contact.unconverged", 432), |counters| counters.unconverged as f64, "Contact solves that were given up"),
    row("counters.contact_residual", ("contact.residual", 435), &VELOCITY, &[], Get::Counters(|counters| counters.contact_residual),
        "Greatest speed by which a contact has failed its law in a solve that was given up; 0 if all converged"),
    count("counters.most_sweeps", NO_FMI, |counters| counters.most_sweeps as f64, "Most Gauss-Seidel sweeps of one contact solve, passes of Newton's method included"),
    count("counters.most_candidates", NO_FMI, |counters| counters.most_candidates as f64, "Most candidate nodes of one step"),
    count("counters.candidate_capacity", NO_FMI, |counters| counters.candidate_capacity as f64, "Places for candidate nodes"),
    count("counters.iterations", NO_FMI, |counters| counters.iterations as f64, "Iterations of the theta rule; 0 with velocity Verlet"),
    count("counters.most_iterations", NO_FMI, |counters| counters.most_iterations as f64, "Most iterations of one step"),
    count("counters.beyond_fine", ("contact.beyond_fine", 434), |counters| counters.beyond_fine as f64,
        "Steps in which the projectile met the sheet beyond the fine part of a graded network, where nodes may be \
         too far apart to feel it: 0 in a run that is to be trusted"),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::sheet;
    use std::collections::BTreeMap;
    use std::format;
    use std::string::String;
    use std::vec::Vec;

    /// The table has of a structure what the structure itself shows: every field, its name and its number.
    #[test]
    fn every_field_of_a_read_out_has_its_row() {
        let mut scene = sheet(41, 41);
        scene.contact.friction = 0.2;
        (scene.stack.plies, scene.stack.gap, scene.projectile.angular_velocity) = (2, 1e-4, [30.0, 40.0, 50.0]);
        let mut sim = crate::tests::sim(&scene);
        sim.advance(2000).unwrap();
        let shown = BTreeMap::from([
            ("projectile", format!("{:?}", sim.projectile().unwrap())),
            ("contact", format!("{:?}", sim.contact().unwrap())),
            ("support", format!("{:?}", sim.support().unwrap())),
            ("energy", format!("{:?}", sim.energy().unwrap())),
            ("fabric", format!("{:?}", sim.fabric().unwrap())),
            ("counters", format!("{:?}", sim.counters())),
            ("ply", format!("{:?}", sim.ply(1).unwrap())),
        ]);
        let (mut found, mut readings, ply) = (BTreeMap::new(), Readings::default(), sim.ply(1).unwrap());
        for output in OUTPUTS.iter().filter(|output| !matches!(output.get, Get::Whole(_))) {
            let (structure, field) = output.parts();
            let mut values = readings.read(&mut sim, output).unwrap();
            if let Get::Ply(of) = output.get {
                values[0] = of(&ply);
            }
            let of_one =
                |value: &f64| if *output.quantity == COUNT { format!("{value}") } else { format!("{value:?}") };
            let numbers: Vec<String> = values[..output.size().max(1)].iter().map(of_one).collect();
            let text = format!("{field}: {}", numbers.join(", "));
            let plain = shown[structure].replace(['[', ']'], "").replace(" }", ",");
            assert!(plain.contains(&format!(" {text},")), "{}: {text} is not in {plain}", output.name);
            *found.entry(structure).or_insert(0) += 1;
        }
        for (structure, text) in shown {
            assert_eq!(found[structure], text.matches(": ").count(), "{text}");
        }
    }
}
