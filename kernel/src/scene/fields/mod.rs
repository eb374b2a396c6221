//! The table of a scene's parameters: one row for each number of [`Scene`](crate::Scene).
//!
//! From these rows come the checks of each number by itself, the fingerprint of a scene, the keys of scene
//! files, the structure `fk_scene` of the C header, the FMU's parameters with both model descriptions, the
//! keys of kept results, and the parameter table of the documents. A new parameter needs its field in
//! `parts.rs`, its row in `table.rs`, and the code that reads it; a choice its enum in `choices.rs` first.

pub(crate) mod choices;
mod lookup;
mod quantities;
mod row;
mod table;

pub use choices::{CHOICES, Choice};
pub use lookup::{SLOTS, check, field, slot_of};
pub(crate) use quantities::Str;
pub use quantities::{
    ANGLE, ANGULAR_VELOCITY, ANY_SIGN, AREA, DAMAGE_SLOPE, DURATION, FORCE, INERTIA, LENGTH, MASS, MODULUS, POSITION,
    QUATERNION, Quantity, RATIO, STRAIN_RATE, VELOCITY, quantity,
};
pub use row::{Field, Place, Range};
pub use table::{FIELDS, GROUPS};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scene;
    use std::collections::BTreeMap;
    use std::format;
    use std::string::{String, ToString};
    use std::vec::Vec;

    /// Every number of a scene by its path, as the scene's own debug output has them.
    fn numbers(scene: &Scene) -> BTreeMap<String, String> {
        let (mut path, mut found, mut deep) = (Vec::new(), BTreeMap::new(), 0);
        for line in format!("{scene:#?}").lines().skip(1) {
            let line = line.trim();
            let (name, value) = line.split_once(": ").unwrap_or(("", line));
            if deep > 0 || value == "[" {
                // Within an array all belongs to its name.
                if deep == 0 {
                    path.push(name.to_string());
                }
                deep += usize::from(value == "[");
                deep -= usize::from(value.starts_with(']'));
                found.entry(path.join(".")).or_insert_with(String::new).push_str(value);
                if deep == 0 {
                    path.pop();
                }
            } else if value.ends_with('{') {
                path.push(name.to_string());
            } else if line.starts_with('}') {
                path.pop();
            } else {
                path.push(name.to_string());
                found.insert(path.join("."), value.to_string());
                path.pop();
            }
        }
        found
    }

    #[test]
    fn every_number_of_a_scene_has_a_row_of_its_name() {
        let names: Vec<_> = numbers(&Scene::sheet_3in_sphere()).into_keys().collect();
        for name in &names {
            assert!(field(name).is_some(), "{name} has no row in the table");
        }
        for field in FIELDS {
            assert!(names.iter().any(|name| name == field.name), "{} is no field of a scene", field.name);
        }
        assert_eq!(names.len(), FIELDS.len());
    }

    #[test]
    fn a_count_that_no_number_holds_is_refused() {
        for field in FIELDS.iter().filter(|field| matches!(field.place, Place::Count(_))) {
            assert!(field.set_word(&mut Scene::sheet_3in_sphere(), 0, u64::MAX).is_err(), "{}", field.name);
        }
    }

    #[test]
    fn a_row_reads_and_sets_the_number_that_it_names_and_no_other() {
        for field in FIELDS {
            for element in [0, field.size() - 1] {
                let mut scene = Scene::sheet_3in_sphere();
                let before = numbers(&scene);
                let old = field.word(&mut scene, element);
                let new = if field.is_real() { 1234.5_f64.to_bits() } else { 1 - old.min(1) };
                field.set_word(&mut scene, element, new).unwrap();
                assert_eq!(field.word(&mut scene, element), new, "{}", field.name);
                let after = numbers(&scene);
                let changed: Vec<_> = after.iter().filter(|(name, value)| before[*name] != **value).collect();
                assert!(changed.len() == 1 && changed[0].0 == field.name, "{}: {changed:?}", field.name);
                if field.is_real() {
                    assert_eq!(changed[0].1.matches("1234.5").count(), 1, "{}", field.name);
                }
            }
        }
    }

    #[test]
    fn names_references_and_groups_do_not_overlap() {
        let (mut names, mut references) = (BTreeMap::new(), BTreeMap::new());
        for (k, row) in FIELDS.iter().enumerate() {
            assert!(names.insert(row.name, k).is_none(), "{}", row.name);
            for element in 0..row.size() as u32 {
                assert!(references.insert(row.fmi + element, k).is_none(), "{}: {}", row.name, row.fmi + element);
            }
            assert_eq!(row.is_real(), row.quantity.is_some(), "{}", row.name);
            assert!(!matches!(row.place, Place::Choice(choice, ..) if !CHOICES.contains(&choice)), "{}", row.name);
            // Rows of a group stand together: C has one structure for them.
            if let Some((group, _)) = row.name.rsplit_once('.') {
                assert!(GROUPS.iter().any(|(name, _)| *name == group), "{group} is not among the groups");
                let of_it = |field: &&Field| field.name.starts_with(&format!("{group}."));
                let first = FIELDS.iter().position(|field| of_it(&field)).unwrap();
                assert!(FIELDS[first..=k].iter().all(|field| of_it(&field)), "{} stands apart", row.name);
            }
        }
    }

    #[test]
    fn defaults_lie_in_their_ranges() {
        for make in [Scene::sheet_3in_sphere, Scene::sheet_10in_cylinder, Scene::turbine_disc_sector, Scene::ring_40in]
        {
            let mut scene = make();
            check(&scene).unwrap();
            for field in FIELDS {
                let [least, greatest] = field.limits();
                let value = field.value_of(field.word(&mut scene, 0));
                assert!(least <= value && value <= greatest, "{}", field.name);
            }
        }
    }
}
