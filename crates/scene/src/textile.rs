//! Textiles as TOML: the named ones of the folder `data/fabrics`, and the table `[fabric]` of a scene file.
//!
//! ```toml
//! fabric = "kevlar_km2_s706"      # a file of the folder `data/fabrics`; or
//!
//! [fabric]
//! name = "kevlar_km2_s706"        # without it all numbers are your own
//! count = "32 /in"                # own numbers replace those of the file; units: `units.rs`
//! weft.crimp = 0.01
//! ```
//!
//! The table `[back_fabric]` has the same keys for the last plies of a stack. Keys are the fields of
//! [`fabric_kernel::Textile`]; `linear_density`, `count` and `crimp` are those of both directions, below
//! `warp` and `weft` those of one. A number written `{ value, unit }` may have its
//! `source` and `mark`; those of the folder must.

use crate::{BadKey, Result, bad, short, units};
use fabric_kernel::textile::centinewton_per_dtex;
use fabric_kernel::{Scene, Textile};
use std::collections::BTreeMap;
use toml::{Table, Value};

/// The named textiles: their files.
const FILES: [(&str, &str); 4] = [
    ("kevlar_km2_s706", include_str!("../fabrics/kevlar_km2_s706.toml")),
    ("kevlar_49_yarn", include_str!("../fabrics/kevlar_49_yarn.toml")),
    ("zylon_as_500_35", include_str!("../fabrics/zylon_as_500_35.toml")),
    ("powell_zohdi_2009", include_str!("../fabrics/powell_zohdi_2009.toml")),
];

type Place = fn(&mut Textile) -> &mut f64;

/// The numbers by their keys, with their SI units. The density goes first: a unit of strength per linear
/// density needs it.
const NUMBERS: [(&str, Place, &str); 15] = [
    ("fibre_density", |t| &mut t.fibre_density, "kg/m3"),
    ("modulus", |t| &mut t.modulus, "Pa"),
    ("modulus_sd", |t| &mut t.modulus_sd, "Pa"),
    ("failure_strain", |t| &mut t.failure_strain, "1"),
    ("strength", |t| &mut t.strength, "Pa"),
    ("weaving_loss", |t| &mut t.weaving_loss, "1"),
    ("damage_rate", |t| &mut t.damage_rate, "1"),
    ("weibull_shape", |t| &mut t.weibull_shape, "1"),
    ("gauge_length", |t| &mut t.gauge_length, "m"),
    ("warp.linear_density", |t| &mut t.warp.linear_density, "kg/m"),
    ("warp.count", |t| &mut t.warp.count, "1/m"),
    ("warp.crimp", |t| &mut t.warp.crimp, "1"),
    ("weft.linear_density", |t| &mut t.weft.linear_density, "kg/m"),
    ("weft.count", |t| &mut t.weft.count, "1/m"),
    ("weft.crimp", |t| &mut t.weft.crimp, "1"),
];

/// What the network does not read but for the thickness, but what is said of one ply does: SI units and
/// ranges. A number that is not given is unknown; a thickness of 0 is that of a surface.
const WEAVE: [(&str, &str, [f64; 2]); 4] = [
    (THICKNESS, "m", [1e-6, 1e-2]),
    ("width", "m", [1e-6, 1e-2]),
    ("friction", "1", [0.0, 2.0]),
    (AREAL_DENSITY, "kg/m2", [1e-3, 100.0]),
];

/// Key of the thickness of a ply.
pub(crate) const THICKNESS: &str = "thickness";

/// Key that [`Textile::areal_density`] is compared with.
const AREAL_DENSITY: &str = "areal_density";

/// Largest part by which the areal density of a data sheet may differ from that of count, crimp and linear
/// density: it is often given with finish, or rounded.
const AREAL_DIFFERENCE: f64 = 0.1;

/// The tables of the sheet, and of the last plies of a stack.
const FRONT: &str = "fabric";
const BACK: &str = "back_fabric";

/// Makes the sheet of a scene that of its table `[fabric]`.
pub fn apply(scene: &mut Scene, table: &Value) -> Result<()> {
    scene.set_textile(&whole(FRONT, table)?).or_else(|error| refused(FRONT, error))?;
    if weave_of(FRONT, &given(FRONT, table)?)?.contains(&(THICKNESS, 0.0)) {
        scene.sheet.thickness = 0.0;
    }
    Ok(())
}

/// Makes the fabric of the last plies of a scene that of its table `[back_fabric]`.
pub fn apply_back(scene: &mut Scene, table: &Value) -> Result<()> {
    scene.set_back_textile(&whole(BACK, table)?).or_else(|error| refused(BACK, error))
}

/// The kernel's refusal of a textile with the names of the table's keys.
fn refused<T>(table: &str, error: fabric_kernel::Error) -> Result<T> {
    let range = USUAL.iter().find(|(name, ..)| error.field.ends_with(name)).map_or("0 to below 1", |(.., words)| words);
    let help = match error.code {
        fabric_kernel::Code::OutOfRange => format!("; there are {range}"),
        fabric_kernel::Code::DoesNotGoWith => "; give one of the two".to_string(),
        _ => String::new(),
    };
    let text = error.to_string().replace("textile.", &format!("{table}."));
    bad(&error.field.replace("textile", table), format!("{text}{help}"))
}

/// The textiles of a scene file, `fabric` and `back_fabric`, as it has them; and of `projectile` the material
/// or the density.
pub fn of(file: &Table) -> Table {
    let keys = [FRONT, BACK];
    let mut all: Table = keys.iter().filter_map(|key| Some((key.to_string(), file.get(*key)?.clone()))).collect();
    let body = crate::given(file)
        .into_iter()
        .filter_map(|(key, value)| Some((key.strip_prefix("projectile.")?.to_string(), value)));
    let body: Table = body.filter(|(key, _)| ["material", "density", "vertices"].contains(&&**key)).collect();
    // A polyhedron keeps its mass and moments.
    if !body.is_empty() && !body.contains_key("vertices") {
        all.insert("projectile".to_string(), body.into());
    }
    all
}

/// Their names; none where there is no textile, or it has no name.
pub fn names(textiles: &Table) -> [Option<String>; 2] {
    [FRONT, BACK].map(|key| {
        let textile = textiles.get(key)?;
        Some(textile.as_str().or_else(|| textile.get("name")?.as_str())?.to_string())
    })
}

/// The textiles as a scene file has them, after the file of each that has a name, as a comment: its sources.
pub fn write(textiles: &Table) -> String {
    let mut text = String::from(if names(textiles) == [None, None] && !textiles.contains_key(FRONT) {
        ""
    } else {
        "\n# The numbers below override those of the fabric.\n"
    });
    for (key, name) in [FRONT, BACK].into_iter().zip(names(textiles)) {
        let Some(textile) = textiles.get(key) else { continue };
        let file = FILES.iter().find(|(known, _)| name.as_deref() == Some(*known)).map_or("", |(_, file)| file);
        text.extend(file.lines().map(|line| format!("{}\n", format!("# {line}").trim_end())));
        let table = if textile.is_str() {
            Table::from_iter([("name".to_string(), textile.clone())]).into()
        } else {
            textile.clone()
        };
        text.push_str(&Table::from_iter([(key.to_string(), table)]).to_string());
    }
    text
}

/// Thickness of the ply and width of a yarn in it, m, and friction between yarns, of the fabric of the sheet,
/// by their keys; none that is unknown, but for the thickness what is assumed. And the larger spacing of its
/// yarns, m.
pub fn weave(textiles: &Table) -> Result<Vec<(&'static str, f64)>> {
    let Some(values) = textiles.get(FRONT) else { return Ok(Vec::new()) };
    let mut found = weave_of(FRONT, &given(FRONT, values)?)?;
    found.retain(|known| *known != (THICKNESS, 0.0));
    let cloth = textile(FRONT, values)?;
    let count = cloth.warp.count.min(cloth.weft.count);
    if count > 0.0 {
        found.push(("spacing", 1.0 / count));
    }
    if !found.iter().any(|(key, _)| *key == THICKNESS) {
        found.push(("assumed_thickness", cloth.assumed_thickness()));
    }
    Ok(found)
}

fn weave_of(table: &str, all: &BTreeMap<String, (String, Value)>) -> Result<Vec<(&'static str, f64)>> {
    let mut found = Vec::new();
    for (key, si, [least, most]) in WEAVE {
        let Some((_, value)) = all.get(key) else { continue };
        let whole = format!("{table}.{key}");
        let number = number(&whole, value, si, 0.0, [least, most])?;
        let is_surface = key == THICKNESS && number == 0.0;
        if !(least..=most).contains(&number) && !is_surface {
            let unit = if si == "1" { "" } else { " m" };
            let text = format!("must be {least} to {most}{unit}; leave it out if it is unknown");
            return bad(&whole, format!("{whole} = {}: {text}", short(&value.to_string())));
        }
        found.push((key, number));
    }
    Ok(found)
}

/// The numbers of a table with this name, and of the file that it names, as [`numbers`] has them.
fn given(table: &str, values: &Value) -> Result<BTreeMap<String, (String, Value)>> {
    let mut own = match values {
        Value::Table(own) => own.clone(),
        // `fabric = "kevlar_km2_s706"`
        Value::String(_) => Table::from_iter([("name".to_string(), values.clone())]),
        _ => return bad(table, format!("`{table}` is a table, [{table}], or the name of a fabric: {}", known())),
    };
    let mut all = match own.remove("name") {
        Some(name) => numbers(table, named(table, &name)?)?,
        None => BTreeMap::new(),
    };
    let own = numbers(table, own)?;
    // Strength or failure strain, whichever is given, replaces the other.
    for (key, other) in [("strength", "failure_strain"), ("failure_strain", "strength")] {
        if own.contains_key(key) {
            all.remove(other);
        }
    }
    all.extend(own);
    Ok(all)
}

/// The textile of a table with this name.
fn textile(table: &str, values: &Value) -> Result<Textile> {
    let all = given(table, values)?;
    let weave = weave_of(table, &all)?;
    let mut textile = Textile::default();
    for (key, place, si) in NUMBERS {
        if let Some((given, value)) = all.get(key) {
            let whole = format!("{table}.{given}");
            let usual = USUAL.iter().find(|(name, ..)| whole.ends_with(name));
            let range = usual.map_or([0.0, f64::MAX], |(_, range, _)| *range);
            let number = number(&whole, value, si, textile.fibre_density, range)?;
            usual.map_or(Ok(()), |usual| refuse_wrong_unit(&whole, number, value, si, usual))?;
            *place(&mut textile) = number;
        }
    }
    textile.thickness = weave.iter().find(|(key, _)| *key == THICKNESS).map_or(0.0, |(_, thickness)| *thickness);
    let (sum, stated) = (textile.areal_density(), weave.iter().find(|(key, _)| *key == AREAL_DENSITY));
    if let Some((key, stated)) = stated.filter(|(_, stated)| sum > 0.0 && (sum / stated - 1.0).abs() > AREAL_DIFFERENCE)
    {
        let text = format!(
            "{table}.{key} = {stated} kg/m2: count, linear_density and crimp give {sum:.4} kg/m2; one of these numbers is wrong, or has another unit"
        );
        return bad(&format!("{table}.{key}"), text);
    }
    if !all.contains_key(THICKNESS) {
        refuse_heavy_yarns(table, &all, &textile)?;
    }
    Ok(textile)
}

/// Refuses yarns of which the ply that is assumed would be thicker than they are apart, with the units that
/// make sense of linear density and count. A cloth that is so tight needs its own thickness.
fn refuse_heavy_yarns(table: &str, all: &BTreeMap<String, (String, Value)>, textile: &Textile) -> Result<()> {
    let (thickness, count) = (textile.assumed_thickness(), textile.warp.count.min(textile.weft.count));
    if !(thickness.is_finite() && thickness * count > 1.0) {
        return Ok(());
    }
    let mut hints = Vec::new();
    let mut said = Vec::new();
    // Thickness over spacing grows with the linear density, and with the square of the count.
    let powers: [fn(f64) -> f64; 2] = [|ratio| ratio, |ratio| ratio * ratio];
    let (mass, per_metre) = (textile.warp.linear_density, textile.warp.count);
    for (key, now, si, power) in [("linear_density", mass, "kg/m", powers[0]), ("count", per_metre, "1/m", powers[1])] {
        let Some((given, value)) = all.get(&format!("warp.{key}")) else { continue };
        let written = units::plain(value).or(units::with_unit(value).map(|(number, _)| number)).unwrap_or(now);
        let usual = USUAL.iter().find(|(name, ..)| *name == key).map_or([0.0, f64::MAX], |(_, range, _)| *range);
        let fits = |x: f64| (usual[0]..=usual[1]).contains(&x) && thickness * count * power(x / now) <= 1.0;
        let others = units::likely(written, si, &fits);
        hints.extend((!others.is_empty()).then(|| format!("{given} = {}", others.join(" or "))));
        said.push(format!("{table}.{given} = {}", short(&value.to_string())));
    }
    let hint = if hints.is_empty() { String::new() } else { format!("write {}; ", hints.join(", or ")) };
    let text = format!(
        "{}: a ply would be {:.2} mm thick with yarns {:.2} mm apart, as in no fabric; {hint}if they are right, give {table}.thickness",
        said.join(", "),
        1e3 * thickness,
        1e3 / count
    );
    bad(&format!("{table}.linear_density"), text)
}

/// Textile with all that a sheet needs.
fn whole(table: &str, values: &Value) -> Result<Textile> {
    let mut textile = textile(table, values)?;
    let given: Vec<_> =
        NUMBERS.iter().filter(|(_, place, _)| *place(&mut textile) != 0.0).map(|(key, ..)| *key).collect();
    refuse_missing(table, |key| given.contains(&key))?;
    Ok(textile)
}

/// Names the numbers without which there is no textile, those of both directions once.
fn refuse_missing(table: &str, has: impl Fn(&str) -> bool) -> Result<()> {
    let mut missing = Vec::new();
    for key in ["linear_density", "count"] {
        let lacking: Vec<_> =
            ["warp", "weft"].iter().map(|side| format!("{side}.{key}")).filter(|key| !has(key)).collect();
        missing.extend(if lacking.len() == 2 { vec![key.to_string()] } else { lacking });
    }
    missing.extend(["fibre_density", "modulus"].iter().filter(|key| !has(key)).map(|key| key.to_string()));
    if !has("failure_strain") && !has("strength") {
        missing.push("failure_strain (or strength)".to_string());
    }
    let Some(first) = missing.first() else { return Ok(()) };
    let text = format!(
        "{table}.{}: missing or 0 in [{table}]; data/fabrics/README.md has an example with all",
        missing.join(", ")
    );
    bad(&format!("{table}.{first}"), text)
}

/// The parameters of the sheet that a textile determines, and its keys that do.
const DETERMINED: [(&str, &str); 6] = [
    ("sheet.spacing", "fabric.count"),
    ("sheet.spacing_y", "fabric.warp.count"),
    ("sheet.node_mass", "fabric.linear_density, fabric.count and fabric.crimp"),
    ("sheet.yarn_area", "fabric.linear_density and fabric.fibre_density"),
    ("sheet.yarn_area_y", "fabric.linear_density and fabric.fibre_density"),
    ("sheet.crimp", "fabric.crimp"),
];

/// The refusal of another number for a parameter that a textile determines; none for all other parameters.
pub fn determined(name: &str) -> Option<BadKey> {
    let (_, by) = DETERMINED.iter().find(|(known, _)| *known == name)?;
    let text = format!("{name} and [fabric]: it follows from {by}, so change that, or leave one of the two out");
    Some(BadKey { key: name.to_string(), text })
}

/// The numbers of a table by their whole keys, each with the key that it was given by: one of both directions
/// is that of each which has none of its own.
fn numbers(table: &str, given: Table) -> Result<BTreeMap<String, (String, Value)>> {
    let mut all = BTreeMap::new();
    let (sides, both): (Table, Table) = given.into_iter().partition(|(key, _)| key == "warp" || key == "weft");
    for (key, value) in both {
        let wholes = ["", "warp.", "weft."].map(|side| format!("{side}{key}"));
        let known: Vec<_> = wholes.into_iter().filter(|whole| keys().any(|name| name == whole)).collect();
        if known.is_empty() {
            return unknown(table, &key);
        }
        all.extend(known.into_iter().map(|whole| (whole, (key.clone(), value.clone()))));
    }
    for (side, values) in sides {
        let Value::Table(values) = values else {
            return bad(
                &format!("{table}.{side}"),
                format!("{table}.{side}: must be a table, [{table}.{side}], with linear_density, count, crimp"),
            );
        };
        for (key, value) in values {
            let whole = format!("{side}.{key}");
            if !NUMBERS.iter().any(|(name, ..)| *name == whole) {
                return unknown(table, &whole);
            }
            all.insert(whole.clone(), (whole, value));
        }
    }
    Ok(all)
}

/// The keys of all numbers.
fn keys() -> impl Iterator<Item = &'static str> {
    NUMBERS.iter().map(|(name, ..)| *name).chain(WEAVE.map(|(name, ..)| name))
}

/// What people call numbers of a textile otherwise.
const OTHERWISE: [(&str, &str); 5] = [
    ("density", "`fibre_density`"),
    ("fiber_density", "`fibre_density`"),
    ("youngs_modulus", "`modulus`"),
    ("tenacity", "`strength`"),
    ("plies", crate::PLIES),
];

/// Says what the table may have.
fn unknown<T>(table: &str, key: &str) -> Result<T> {
    let known = |of: fn(&'static str) -> Option<&'static str>| keys().filter_map(of).collect::<Vec<_>>().join(", ");
    let both = known(|name| (!name.contains('.')).then_some(name));
    let (of_threads, key) = (known(|name| name.strip_prefix("warp.")), short(key));
    let others = OTHERWISE.map(|(other, own)| (other, own.to_string())).into_iter();
    let others = others.chain(keys().map(|name| (crate::last_of(name), format!("`{}`", crate::last_of(name)))));
    let near = others.map(|(other, own)| (strsim::normalized_levenshtein(crate::last_of(&key), other), own));
    let near = near.max_by(|one, other| one.0.total_cmp(&other.0)).filter(|(likeness, _)| *likeness > 0.7);
    let meant = near.map_or(String::new(), |(_, own)| format!("; is it {own}?"));
    let text = format!(
        "unknown key `{table}.{key}`{meant}; there are name, {both}, and, for both directions or below warp and weft, {of_threads}"
    );
    bad(&format!("{table}.{key}"), text)
}

/// A number, its range in SI units and in words.
type Usual = (&'static str, [f64; 2], &'static str);
/// What textiles have: a number outside has the wrong unit. Below 100 of `damage_rate` a yarn would go on
/// beyond its failure strain for more than 5 % of strain.
const USUAL: [Usual; 8] = [
    ("fibre_density", [500.0, 10_000.0], "0.5 to 10 g/cm3"),
    ("modulus", [1e8, 1e12], "0.1 to 1000 GPa"),
    ("strength", [1e7, 2e10], "0.01 to 20 GPa"),
    ("failure_strain", [0.002, 0.3], "0.2 to 30 %"),
    ("damage_rate", [100.0, f64::MAX], "100 and more, and 2300 fails within 0.2 % of strain"),
    ("linear_density", [1e-7, 1e-1], "1 to 1,000,000 dtex"),
    ("count", [100.0, 1e5], "1 to 1000 1/cm"),
    ("crimp", [0.0, 0.5], "0 to 50 %"),
];

/// Refuses what no textile has, with the units that make sense of the number as it is written.
fn refuse_wrong_unit(key: &str, number: f64, value: &Value, si: &str, usual: &Usual) -> Result<()> {
    let (_, [least, most], words) = *usual;
    if number.is_nan() || number <= 0.0 || (least..=most).contains(&number) {
        return Ok(());
    }
    let written = units::plain(value).or(units::with_unit(value).map(|(number, _)| number)).unwrap_or(number);
    let others = units::likely(written, si, &|x| (least..=most).contains(&x));
    let hint = if others.is_empty() { String::new() } else { format!(": write {}", others.join(" or ")) };
    let unit = if units::plain(value).is_some() && si != "1" { format!(" {si}") } else { String::new() };
    bad(key, format!("{key} = {}{unit}: no textile has that; there are {words}{hint}", short(&value.to_string())))
}

/// Units of tenacity and of modulus over density, in cN/dtex.
const TENACITIES: [(&str, f64); 4] =
    [("cN/dtex", 1.0), ("cN/tex", 0.1), ("N/tex", 10.0), ("g/den", units::GRAMS_PER_DENIER)];

/// A number in SI units, or with a unit; of stress also one of tenacity, which needs the fibre's density.
/// `key`: its whole name.
fn number(key: &str, given: &Value, si: &str, density: f64, [least, most]: [f64; 2]) -> Result<f64> {
    let names = TENACITIES.map(|(name, _)| name).join(", ");
    let tenacity = if si == "Pa" { format!(", {names}") } else { String::new() };
    if let Some(number) = units::number(given, si) {
        return Ok(number);
    }
    if let Some((number, unit)) = units::with_unit(given).filter(|_| si == "Pa")
        && let Some((_, in_cn_dtex)) = TENACITIES.iter().find(|(name, _)| *name == unit)
    {
        return Ok(centinewton_per_dtex(number * in_cn_dtex, density));
    }
    units::refused(key, given, si, &tenacity, &|x| (least..=most).contains(&x))
}

/// The names of the textiles, in words.
fn known() -> String {
    FILES.map(|(name, _)| format!("\"{name}\"")).join(", ")
}

/// The table of a named textile.
fn named(table: &str, name: &Value) -> Result<Table> {
    let Some((_, text)) = FILES.iter().find(|(known, _)| name.as_str() == Some(known)) else {
        let text = format!("{table}.name = {}: must be one of {}", short(&name.to_string()), known());
        return bad(&format!("{table}.name"), text);
    };
    let file: Table = text.parse()?;
    Ok(file.get("fabric").and_then(Value::as_table).cloned().unwrap_or_default())
}

/// A named textile.
pub struct Named {
    /// Name in scene files.
    pub name: &'static str,
    /// What it is.
    pub title: String,
    /// File, with the source of each number.
    pub file: &'static str,
    /// Numbers in SI units.
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
    use std::path::Path;

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
        let other = |text| of(&format!("[fabric]\nfibre_density = 1540\nmodulus = \"{text}\"")).unwrap().modulus;
        close(other("115 N/tex"), 177.1e9);
        close(other("11500 cN/tex"), 177.1e9);
        close(other("1300 g/den"), 1300.0 * 9.80665e-3 / (1e-3 / 9000.0) * 1540.0);
        assert_eq!((textile.failure_strain, textile.gauge_length), (0.035, 0.05));
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

    /// 1100 tex over 1.44 g/cm3 are 0.764 mm^2, two of them at 7 per cm over 0.48 are 2.23 mm; yarns 1.43 mm
    /// apart.
    #[test]
    fn yarns_too_heavy_for_their_count_need_a_thickness() {
        let cloth = |dtex: u32, more: &str| {
            let text =
                format!("[fabric]\nlinear_density = \"{dtex} dtex\"\ncount = \"7 /cm\"\nfibre_density = 1440\n{more}");
            of(&text).map(|_| ()).map_err(|error| error.to_string())
        };
        assert!(cloth(11_000, "").unwrap_err().contains("a ply would be 2.23 mm thick with yarns 1.43 mm apart"));
        assert_eq!([cloth(11_000, "thickness = \"2 mm\""), cloth(7000, ""), cloth(1100, "")], [Ok(()), Ok(()), Ok(())]);
    }

    #[test]
    fn thickness_width_and_friction_are_known_or_not() {
        let known = |text: &str| weave(&text.parse().unwrap());
        let yarns = ("spacing", 0.0254 / 34.0);
        let text = "[fabric]\nname = \"kevlar_km2_s706\"\nthickness = \"0.2 mm\"\nfriction = { value = 20, unit = \"%\", source = \"pulled\" }";
        assert_eq!(known(text).unwrap(), [("thickness", 2e-4), ("friction", 0.2), yarns]);
        let unknown = known("fabric = \"kevlar_km2_s706\"").unwrap();
        assert_eq!((unknown[0], unknown[1].0, known("").unwrap()), (yarns, "assumed_thickness", vec![]));
        let unknown = of("fabric = \"kevlar_km2_s706\"").unwrap();
        assert_eq!(of(text).unwrap(), Textile { thickness: 2e-4, ..unknown });
        let sheet =
            |text: &str| crate::parse(&format!("preset = \"sheet_3in_sphere\"\n{text}")).unwrap().sheet.thickness;
        assert_eq!([sheet(text), sheet("fabric = \"kevlar_km2_s706\"")], [2e-4, unknown.assumed_thickness()]);
        assert_eq!(sheet("fabric = { name = \"kevlar_km2_s706\", thickness = 0 }"), 0.0);
        for (wrong, told) in [
            ("friction = -0.1", "fabric.friction = -0.1: must be 0 to 2; leave it out if it is unknown"),
            ("thickness = \"20 mm\"", "fabric.thickness = \"20 mm\": must be 0.000001 to 0.01 m"),
            ("width = nan", "fabric.width = nan: must be"),
            ("warp.width = 1e-4", "unknown key `fabric.warp.width`"),
        ] {
            let error = of(&format!("[fabric]\nname = \"kevlar_km2_s706\"\n{wrong}")).unwrap_err().to_string();
            assert!(error.contains(told), "{error}");
        }
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
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/fabrics");
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

    /// Published areal densities are met: that of the fabric, and that of the paper's sheet, whose nodes
    /// weigh 6.52e-8 kg.
    #[test]
    fn named_textiles_weigh_what_they_weigh() {
        let density = |name: &str| of(&format!("[fabric]\nname = \"{name}\"")).unwrap().areal_density();
        assert!((density("kevlar_km2_s706") / 0.180 - 1.0).abs() < 0.01);
        let spacing = 0.0254 / 35.0;
        assert!((density("powell_zohdi_2009") * spacing * spacing / 6.52e-8 - 1.0).abs() < 1e-4);
    }

    #[test]
    fn the_example_of_the_page_is_a_scene() {
        let page = include_str!("../fabrics/README.md");
        let example = page.split_once("```toml\n").unwrap().1.split_once("```").unwrap().0;
        let scene = crate::parse(example).unwrap();
        assert_eq!((scene.sheet.crimp, scene.viscosity()), ([0.01, 0.003], fabric_kernel::TEXTILE_VISCOSITY));
        for key in keys().map(|name| name.trim_start_matches("warp.").trim_start_matches("weft.")) {
            assert!(page.contains(&format!("`{key}`")), "{key} is not on the page");
        }
    }

    #[test]
    fn every_measurement_has_its_source() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/measured");
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
