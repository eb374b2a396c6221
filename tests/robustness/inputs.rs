//! The cases of bad input, each with its exact code and field (`fabric_tests::inputs`), through the Rust
//! interface. The C host and the FMI tests go through the same cases as tests/inputs lists them.

use fabric_kernel::fields::FIELDS;
use fabric_kernel::internals::fingerprint::fingerprint;
use fabric_kernel::{CacheLine, Failure, Layout, Scene, Sim};
use fabric_tests::inputs::{self, Expected};
use fabric_tests::{image_of, stepped};

/// Larger sheets are checked, but not made.
const NODES: u32 = 100;
/// What memory holds before.
const SEVENS: CacheLine = CacheLine([7.5; 8]);

/// What the kernel says. A refusal must come from the constructor with its memory untouched, and from
/// [`Scene::check`] and [`Scene::step_limits`] alike if they look at what is wrong.
fn said(scene: &Scene, memory: &mut [CacheLine]) -> Expected {
    let early = Layout::of(scene).err();
    let early = early.map(|error| Expected::Refused(error.code, error.field));
    if scene.sheet.nodes_x.max(scene.sheet.nodes_y) > NODES {
        return early.unwrap_or(Expected::Accepted);
    }
    let checked = scene.check_start();
    match Sim::new(scene, memory) {
        Ok(mut sim) => {
            assert!(early.is_none() && checked.is_ok());
            // Whatever comes of it is told, and nothing panics.
            let advanced = sim.advance(3);
            assert_eq!(advanced.err(), sim.failure());
            memory.fill(SEVENS);
            Expected::Accepted
        }
        Err(error) => {
            assert!(memory.iter().all(|&line| line == SEVENS), "memory was written");
            assert!(error.text().starts_with(error.field));
            assert!(checked.is_err_and(|checked| (checked.code, checked.field) == (error.code, error.field)));
            let refused = Expected::Refused(error.code, error.field);
            assert!(early.is_none_or(|early| early == refused));
            refused
        }
    }
}

#[test]
fn every_case_is_answered_exactly() {
    let mut memory = vec![SEVENS; 5500];
    let (mut cases, mut wrong) = (0, Vec::new());
    for case in inputs::cases() {
        let mut scene = inputs::scene(case.base);
        if !inputs::assign(&mut scene, case.name, case.value) {
            continue;
        }
        cases += 1;
        let said = said(&scene, &mut memory);
        if said != case.expected {
            wrong.push(format!("{} {} = {:e}: {said:?}, not {:?}", case.base, case.name, case.value, case.expected));
        }
    }
    println!("figure 8: {cases} cases in Rust, {} exact", cases - wrong.len());
    assert!(wrong.is_empty(), "{} of {cases}:\n{}", wrong.len(), wrong.join("\n"));
    assert!(cases >= 500);
}

#[test]
fn the_committed_list_is_that_of_the_table() {
    let committed = include_str!("../inputs/cases");
    assert!(committed == inputs::listed(), "run `cargo run -p fabric-tests --bin inputs` and read what changes");
}

/// An image must not load into a scene in which a number that it depends on is another; the start of the body
/// is none of these.
#[test]
fn every_number_that_counts_and_no_other_changes_the_fingerprint() {
    // The correlation of drawn strength is read for a back fabric alone, too.
    let mut drawn_back = inputs::scene("hybrid");
    drawn_back.back.weibull_shape = 10.0;
    let scenes = inputs::bases().map(|base| (base, inputs::scene(base))).chain([("drawn back", drawn_back)]);
    let mut tried = [0; 2];
    for (base, plain) in scenes {
        for field in FIELDS {
            let read = (field.read)(&plain);
            let counts = field.in_fingerprint;
            for element in 0..field.size() {
                let mut scene = plain;
                let word = field.word(&mut scene, element);
                let other =
                    if field.is_real() { (0.3 + 2.0 * f64::from_bits(word)).to_bits() } else { 1 - word.min(1) };
                field.set_word(&mut scene, element, other).unwrap();
                let changes = fingerprint(&scene, 1e-8) != fingerprint(&plain, 1e-8);
                let tells = counts && element < read;
                // Edges and faces that a shape has not are no part of it.
                let of_shape = ["size", "faces", "moments", "sector"].iter().any(|name| field.name.contains(name));
                if tells || !counts || of_shape {
                    assert_eq!(changes, tells, "{base}: {} [{element}]", field.name);
                    tried[usize::from(changes)] += 1;
                }
            }
        }
    }
    println!("fingerprint: {} numbers count, {} do not", tried[1], tried[0]);
}

/// What is left out of the fingerprint changes nothing: a scene with another such number takes the same steps
/// from the same image, bit by bit.
#[test]
fn a_number_beyond_the_fingerprint_changes_no_bit_of_a_step() {
    let mut tried = 0;
    for base in inputs::bases() {
        let plain = inputs::scene(base);
        if plain.sheet.nodes_x.max(plain.sheet.nodes_y) > NODES {
            continue;
        }
        let mut sim = stepped(&plain, 2);
        let image = image_of(&sim);
        sim.advance(3).unwrap();
        for field in FIELDS {
            for element in 0..field.size() {
                let mut scene = plain;
                let word = field.word(&mut scene, element);
                let other = if field.is_real() { (0.5 * f64::from_bits(word)).to_bits() } else { 1 - word.min(1) };
                if other == word || field.set_word(&mut scene, element, other).is_err() {
                    continue;
                }
                let Ok(layout) = Layout::of(&scene) else { continue };
                let mut memory = vec![SEVENS; layout.lines()];
                let Ok(mut other) = Sim::new(&scene, &mut memory) else { continue };
                // The image says by its fingerprint whether it is one of this scene.
                if other.load(&image).is_ok() {
                    let steps = other.advance(3);
                    // Fewer candidates than the body meets: said, and no step is taken.
                    if field.name == "contact_capacity" && steps == Err(Failure::ContactCapacity) {
                        continue;
                    }
                    steps.unwrap();
                    assert_eq!(other.digest(), sim.digest(), "{base}: {} [{element}]", field.name);
                    tried += 1;
                }
            }
        }
    }
    println!("fingerprint: {tried} other numbers change no bit");
    assert!(tried >= 100);
}
