//! Textiles as TOML: the named ones of the folder `fabrics`, and the table `[fabric]` of a scene file.
//!
//! ```toml
//! [fabric]
//! name = "kevlar_km2_s706"                     # a file of the folder `fabrics`; without it all numbers are your own
//! count = { value = 32, unit = "1/in" }        # own numbers replace those of the file
//! weft.crimp = 0.01                            # a plain number is in SI units
//! ```
//!
//! The table `[back_fabric]` has the same keys for the last plies of a stack. Keys are the fields of [`fabric::Textile`]; `linear_density`, `count` and `crimp` are those of both directions, below `warp` and
//! `weft` those of one. Beside `value` and `unit` a number may have its `source` and `mark`; those of the folder must.

use crate::{Result, short, table_of, text_of};
use fabric::textile::{centinewton_per_dtex, denier, dtex, per_inch};
use fabric::{Scene, Textile, Threads};
use std::path::Path;
use toml::{Table, Value};

/// The named textiles: their files.
const FILES: [(&str, &str); 4] = [
    ("kevlar_km2_s706", include_str!("../../fabrics/kevlar_km2_s706.toml")),
    ("kevlar_49_yarn", include_str!("../../fabrics/kevlar_49_yarn.toml")),
    ("zylon_as_500_35", include_str!("../../fabrics/zylon_as_500_35.toml")),
    ("powell_zohdi_2009", include_str!("../../fabrics/powell_zohdi_2009.toml")),
];

type Unit = (&'static str, fn(f64) -> f64);
type Place = fn(&mut Textile) -> &mut f64;
type OfThreads = fn(&mut Threads) -> &mut f64;

const ONE: Unit = ("1", |x| x);
const PERCENT: Unit = ("%", |x| x / 100.0);
const STRESS: [Unit; 3] = [("Pa", |x| x), ("MPa", |x| x * 1e6), ("GPa", |x| x * 1e9)];
const LENGTH: [Unit; 2] = [("m", |x| x), ("mm", |x| x * 1e-3)];

/// Numbers of a direction.
const OF_THREADS: [(&str, OfThreads, &[Unit]); 3] = [
    ("linear_density", |t| &mut t.linear_density, &[("kg/m", |x| x), ("denier", denier), ("dtex", dtex)]),
    ("count", |t| &mut t.count, &[("1/m", |x| x), ("1/in", per_inch), ("1/cm", |x| x * 100.0)]),
    ("crimp", |t| &mut t.crimp, &[ONE, PERCENT]),
];

/// Numbers of both.
const OF_BOTH: [(&str, Place, &[Unit]); 9] = [
    ("fibre_density", |t| &mut t.fibre_density, &[("kg/m3", |x| x), ("g/cm3", |x| x * 1e3)]),
    ("modulus", |t| &mut t.modulus, &STRESS),
    ("modulus_sd", |t| &mut t.modulus_sd, &STRESS),
    ("failure_strain", |t| &mut t.failure_strain, &[ONE, PERCENT]),
    ("strength", |t| &mut t.strength, &STRESS),
    ("weaving_loss", |t| &mut t.weaving_loss, &[ONE, PERCENT]),
    ("damage_rate", |t| &mut t.damage_rate, &[ONE]),
    ("weibull_shape", |t| &mut t.weibull_shape, &[ONE]),
    ("gauge_length", |t| &mut t.gauge_length, &LENGTH),
];

/// The table of the last plies of a stack, and its keys that the kernel may refuse.
const BACK: &str = "back_fabric";
const KEYS_OF_BACK: [&str; 15] = [
    "back_fabric.warp.linear_density",
    "back_fabric.warp.count",
    "back_fabric.warp.crimp",
    "back_fabric.weft.linear_density",
    "back_fabric.weft.count",
    "back_fabric.weft.crimp",
    "back_fabric.fibre_density",
    "back_fabric.modulus",
    "back_fabric.modulus_sd",
    "back_fabric.failure_strain",
    "back_fabric.strength",
    "back_fabric.weaving_loss",
    "back_fabric.damage_rate",
    "back_fabric.weibull_shape",
    "back_fabric.gauge_length",
];

/// Makes the sheet of a scene that of its table `[fabric]`.
pub fn apply(scene: &mut Scene, table: &Value) -> Result<()> {
    scene.set_textile(&textile("fabric", table)?)?;
    Ok(())
}

/// Makes the fabric of the last plies of a scene that of its table `[back_fabric]`.
pub fn apply_back(scene: &mut Scene, table: &Value) -> Result<()> {
    scene.set_back_textile(&textile(BACK, table)?).map_err(of_back)?;
    Ok(())
}

/// Names of the textiles of a scene file's tables `[fabric]` and `[back_fabric]`; none where it has no such table or name.
pub fn names(file: &Path) -> Result<[Option<String>; 2]> {
    let file = table_of(&text_of(file)?)?;
    Ok(["fabric", BACK].map(|table| Some(file.get(table)?.get("name")?.as_str()?.to_string())))
}

/// The kernel's refusal of a textile with the names of the keys of `[back_fabric]`.
fn of_back(error: fabric::Error) -> fabric::Error {
    let key = |field: &'static str| {
        let ends = |key: &&&str| key.strip_prefix(BACK) == field.strip_prefix("textile").filter(|end| !end.is_empty());
        KEYS_OF_BACK.iter().find(ends).copied().unwrap_or(field)
    };
    fabric::Error { field: key(error.field), with: key(error.with), ..error }
}

/// The textile of a table with this name.
fn textile(table: &str, values: &Value) -> Result<Textile> {
    let Value::Table(own) = values else { return Err(format!("`{table}` is a table, [{table}]").into()) };
    let mut own = own.clone();
    let mut all = match own.remove("name") {
        Some(name) => named(table, &name)?,
        None => Table::new(),
    };
    // Of strength and failure strain the one that is given replaces the other, and a number of both directions those of each.
    for (key, other) in [("strength", "failure_strain"), ("failure_strain", "strength")] {
        if own.contains_key(key) {
            all.remove(other);
        }
    }
    for (key, value) in own {
        for side in ["warp", "weft"] {
            if let Some(Value::Table(side)) = all.get_mut(side) {
                side.remove(&key);
            }
        }
        match (all.get_mut(&key), value) {
            (Some(Value::Table(side)), Value::Table(more)) if ["warp", "weft"].contains(&key.as_str()) => {
                side.extend(more)
            }
            (_, value) => {
                all.insert(key, value);
            }
        }
    }
    let mut textile = Textile::default();
    // The density goes first: units of strength per linear density need it.
    if let Some(density) = all.get("fibre_density") {
        set(&mut textile, table, "fibre_density", density)?;
    }
    // Both directions before each.
    let (sides, others): (Vec<_>, Vec<_>) =
        all.into_iter().partition(|(key, _)| ["warp", "weft"].contains(&key.as_str()));
    for (key, value) in others {
        set(&mut textile, table, &key, &value)?;
    }
    for (side, values) in sides {
        let Value::Table(values) = values else { return Err(format!("{table}.{side}: must be a table").into()) };
        for (key, value) in values {
            let threads = if side == "warp" { &mut textile.warp } else { &mut textile.weft };
            let place = format!("{table}.{side}");
            set_threads(threads, &place, &key, &value).ok_or_else(|| unknown(table, &format!("{side}.{key}")))??;
        }
    }
    refuse_wrong_units(table, &textile)?;
    Ok(textile)
}

/// Gives a number of a textile its value.
fn set(textile: &mut Textile, table: &str, key: &str, value: &Value) -> Result<()> {
    let density = textile.fibre_density;
    if let Some((_, place, units)) = OF_BOTH.iter().find(|(name, ..)| *name == key) {
        *place(textile) = number(&format!("{table}.{key}"), value, units, density)?;
        return Ok(());
    }
    set_threads(&mut textile.warp, table, key, value).ok_or_else(|| unknown(table, key))??;
    set_threads(&mut textile.weft, table, key, value).unwrap_or(Ok(()))
}

/// Says what the table may have.
fn unknown(table: &str, key: &str) -> String {
    let of_threads: Vec<_> = OF_THREADS.iter().map(|(name, ..)| *name).collect();
    let of_both: Vec<_> = OF_BOTH.iter().map(|(name, ..)| *name).collect();
    let (threads, both, key) = (of_threads.join(", "), of_both.join(", "), short(key));
    format!(
        "unknown key `{table}.{key}`; there are name, {both}, and, for both directions or below warp and weft, {threads}"
    )
}

/// What textiles are made of, in SI units: a number outside has the wrong unit.
fn refuse_wrong_units(table: &str, textile: &Textile) -> Result<()> {
    let titer = |threads: &Threads| threads.linear_density;
    for (key, value, [least, most], unit) in [
        ("fibre_density", textile.fibre_density, [500.0, 10_000.0], "kg/m3"),
        ("modulus", textile.modulus, [1e8, 1e13], "Pa"),
        ("warp.linear_density", titer(&textile.warp), [1e-7, 1e-1], "kg/m"),
        ("weft.linear_density", titer(&textile.weft), [1e-7, 1e-1], "kg/m"),
        ("warp.count", textile.warp.count, [10.0, 1e5], "1/m"),
        ("weft.count", textile.weft.count, [10.0, 1e5], "1/m"),
    ] {
        if value > 0.0 && !(least..=most).contains(&value) {
            let text = format!(
                "{table}.{key} = {value:e} {unit}: no textile has that; a plain number is in SI units, else write {{ value, unit }}"
            );
            return Err(text.into());
        }
    }
    Ok(())
}

/// Gives a number of one direction its value, if it is one; `place` is the table's name.
fn set_threads(threads: &mut Threads, place: &str, key: &str, value: &Value) -> Option<Result<()>> {
    let (_, number_of, units) = OF_THREADS.iter().find(|(name, ..)| *name == key)?;
    Some(number(&format!("{place}.{key}"), value, units, 0.0).map(|number| *number_of(threads) = number))
}

/// A number in SI units: as it is, or `{ value, unit }`. `key`: its whole name.
fn number(key: &str, value: &Value, units: &[Unit], density: f64) -> Result<f64> {
    let real = |value: &Value| value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64));
    if let Some(number) = real(value) {
        return Ok(number);
    }
    let tenacity = units.len() == STRESS.len() && units[0].0 == STRESS[0].0;
    let mut known: Vec<_> = units.iter().map(|(name, _)| *name).collect();
    known.extend(tenacity.then_some("cN/dtex"));
    let wanted = || {
        let value = value.to_string();
        format!("{key} = {}: must be a number, or {{ value, unit }} with one of {}", short(&value), known.join(", "))
    };
    let given = value.get("value").and_then(real).ok_or_else(wanted)?;
    let unit = value.get("unit").and_then(Value::as_str).ok_or_else(wanted)?;
    if tenacity && unit == "cN/dtex" {
        return Ok(centinewton_per_dtex(given, density));
    }
    let (_, in_si) = units.iter().find(|(name, _)| *name == unit).ok_or_else(wanted)?;
    Ok(in_si(given))
}

/// The table of a named textile.
fn named(table: &str, name: &Value) -> Result<Table> {
    let names = FILES.map(|(name, _)| format!("\"{name}\"")).join(", ");
    let unknown = || format!("{table}.name = {}: must be one of {names}", short(&name.to_string()));
    let (_, text) = FILES.iter().find(|(known, _)| name.as_str() == Some(known)).ok_or_else(unknown)?;
    let file: Table = text.parse()?;
    Ok(file.get("fabric").and_then(Value::as_table).cloned().unwrap_or_default())
}

/// A named textile.
pub struct Named {
    /// Its name in scene files.
    pub name: &'static str,
    /// What it is.
    pub title: String,
    /// Its file, with the source of each number.
    pub file: &'static str,
    /// Its numbers.
    pub textile: Textile,
}

/// The named textiles.
pub fn all() -> Result<Vec<Named>> {
    let read = |(name, text): (&'static str, &'static str)| {
        let file: Table = text.parse()?;
        let title = file.get("title").and_then(Value::as_str).unwrap_or_default().to_string();
        Ok(Named { name, title, file: text, textile: textile("fabric", &file["fabric"])? })
    };
    FILES.into_iter().map(read).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Result<Textile> {
        let file: Table = text.parse()?;
        textile("fabric", &file["fabric"])
    }

    fn close(value: f64, expected: f64) {
        assert!((value / expected - 1.0).abs() < 1e-12, "{value:e} is not {expected:e}");
    }

    #[test]
    fn units_of_data_sheets() {
        let textile = of("[fabric]\nlinear_density = { value = 600, unit = \"denier\" }\ncount = { value = 12, unit = \"1/cm\" }\n\
                          modulus = { value = 1150, unit = \"cN/dtex\" }\nfibre_density = { value = 1.54, unit = \"g/cm3\" }\n\
                          failure_strain = { value = 3.5, unit = \"%\" }\ngauge_length = { value = 50, unit = \"mm\" }\n\
                          weft = { count = 1000, crimp = { value = 1.5, unit = \"%\" } }")
        .unwrap();
        close(textile.warp.linear_density, 600e-3 / 9000.0);
        assert_eq!((textile.warp.count, textile.weft.count), (1200.0, 1000.0));
        assert_eq!((textile.warp.crimp, textile.weft.crimp), (0.0, 0.015));
        close(textile.modulus, 177.1e9);
        assert_eq!((textile.failure_strain, textile.gauge_length), (0.035, 0.05));
    }

    #[test]
    fn a_forgotten_unit_and_an_unknown_key_are_refused_with_what_helps() {
        let mut scene = Scene::sheet_3in_sphere();
        for (number, part) in [
            ("fibre_density = 1.44", "fibre_density = 1.44e0 kg/m3: no textile"),
            ("modulus = 84.6", "modulus = 8.46e1 Pa"),
            ("linear_density = 600", "linear_density = 6e2 kg/m"),
            ("weft.count = 1e6", "weft.count = 1e6 1/m"),
            ("crimp_warp = 0.01", "there are name, fibre_density"),
            ("warp.crimps = 0.01", "below warp and weft, linear_density, count, crimp"),
        ] {
            let file: Table = format!("[fabric]\nname = \"kevlar_km2_s706\"\n{number}").parse().unwrap();
            let error = apply(&mut scene, &file["fabric"]).unwrap_err().to_string();
            assert!(error.contains(part), "{error}");
            assert_eq!(scene, Scene::sheet_3in_sphere());
        }
    }

    #[test]
    fn own_numbers_replace_those_of_a_named_textile() {
        let named = of("[fabric]\nname = \"kevlar_49_yarn\"").unwrap();
        let own = of("[fabric]\nname = \"kevlar_49_yarn\"\nfailure_strain = 0.02\ncount = 700\nlinear_density = 1e-4\nweft.crimp = 0.1").unwrap();
        assert_eq!((own.failure_strain, own.strength), (0.02, 0.0));
        assert_eq!(
            (own.warp.count, own.weft.count, own.warp.crimp, own.weft.crimp),
            (700.0, 700.0, named.warp.crimp, 0.1)
        );
        assert_eq!(own.modulus, named.modulus);
        let both = of("[fabric]\nname = \"kevlar_49_yarn\"\ncrimp = 0.0").unwrap();
        assert_eq!((both.warp.crimp, both.weft.crimp), (0.0, 0.0));
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (text, named) in [
            ("fabric = 1", "[fabric]"),
            ("[fabric]\nname = \"cotton\"", "\"kevlar_km2_s706\""),
            ("[fabric]\ndenier = 600", "fabric.denier"),
            ("[fabric]\nwarp.ends = 600", "fabric.warp.ends"),
            ("[fabric]\nmodulus = { value = 1, unit = \"kg\" }", "cN/dtex"),
            ("[fabric]\ncount = { value = 1 }", "1/in"),
        ] {
            let message = of(text).unwrap_err().to_string();
            assert!(message.contains(named), "{message}");
        }
    }

    /// Of the table's own keys, and of those that the kernel refuses.
    #[test]
    fn what_is_wrong_of_the_back_fabric_is_named_by_its_key() {
        for (line, named) in [
            ("modulus = 84.6", "back_fabric.modulus = 8.46e1 Pa"),
            ("modulus_mean = 8e10", "`back_fabric.modulus_mean`"),
            ("modulus = { value = 1, unit = \"kg\" }", "back_fabric.modulus = {"),
            ("count = \"many\"", "back_fabric.count = \"many\""),
            ("warp.count = \"many\"", "back_fabric.warp.count = \"many\""),
            ("warp.ends = 600", "`back_fabric.warp.ends`"),
            ("warp = 600", "back_fabric.warp: must be a table"),
            ("weaving_loss = 1.5", "back_fabric.weaving_loss: "),
            ("weft.crimp = -1.0", "back_fabric.weft.crimp: "),
            ("strength = 3e9\nfailure_strain = 0.03", "back_fabric.strength: "),
        ] {
            let text = format!("preset = \"sheet_3in_sphere\"\n[back_fabric]\nname = \"kevlar_km2_s706\"\n{line}\n");
            let message = crate::parse(&text).unwrap_err().to_string();
            assert!(message.contains(named) && !message.contains("textile."), "{message}");
        }
        let cotton = crate::parse("preset = \"sheet_3in_sphere\"\n[back_fabric]\nname = \"cotton\"\n").unwrap_err();
        assert!(cotton.to_string().starts_with("back_fabric.name = \"cotton\""), "{cotton}");
    }

    /// The marks of how a number is known: read in the source, in a transcription of it, derived.
    const MARKS: [&str; 3] = ["S", "2", "D"];

    #[track_caller]
    fn has_its_source(name: &str, table: &Value) {
        let text = |key: &str| table.get(key).and_then(Value::as_str).unwrap_or_default();
        assert!(MARKS.contains(&text("mark")), "{name}: mark {:?}", text("mark"));
        assert!(text("source").len() > 5, "{name} has no source");
    }

    #[test]
    fn every_number_of_a_named_textile_has_its_source() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fabrics");
        let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        assert_eq!(entries.filter(|path| path.extension().is_some_and(|kind| kind == "toml")).count(), FILES.len());
        for (name, text) in FILES {
            let file: Table = text.parse().unwrap();
            for (key, value) in file["fabric"].as_table().unwrap() {
                match value.as_table().filter(|_| ["warp", "weft"].contains(&key.as_str())) {
                    Some(side) => {
                        side.iter().for_each(|(inner, value)| has_its_source(&format!("{name}: {key}.{inner}"), value))
                    }
                    None => has_its_source(&format!("{name}: {key}"), value),
                }
            }
            textile("fabric", &file["fabric"]).unwrap().critical_stretch().unwrap();
        }
    }

    /// Published areal densities are met: that of the fabric, and that of the paper's sheet, whose nodes weigh 6.52e-8 kg.
    #[test]
    fn named_textiles_weigh_what_they_weigh() {
        let density = |name: &str| of(&format!("[fabric]\nname = \"{name}\"")).unwrap().areal_density();
        assert!((density("kevlar_km2_s706") / 0.180 - 1.0).abs() < 0.01);
        let spacing = 0.0254 / 35.0;
        assert!((density("powell_zohdi_2009") * spacing * spacing / 6.52e-8 - 1.0).abs() < 1e-4);
    }

    #[test]
    fn the_example_of_the_page_is_a_scene() {
        let page = include_str!("../../fabrics/README.md");
        let example = page.split_once("```toml\n").unwrap().1.split_once("```").unwrap().0;
        let scene = crate::parse(example).unwrap();
        assert_eq!((scene.sheet.crimp, scene.viscosity()), ([0.01, 0.003], fabric::TEXTILE_VISCOSITY));
        for key in OF_THREADS.iter().map(|(name, ..)| name).chain(OF_BOTH.iter().map(|(name, ..)| name)) {
            assert!(page.contains(&format!("`{key}`")), "{key} is not on the page");
        }
    }

    #[test]
    fn every_measurement_has_its_source() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../validation");
        let mut count = 0;
        for entry in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            if entry.extension().is_some_and(|kind| kind == "toml") {
                let file: Table = std::fs::read_to_string(&entry).unwrap().parse().unwrap();
                has_its_source(&entry.display().to_string(), &Value::Table(file));
                count += 1;
            }
        }
        assert_eq!(count, 4);
    }
}
